//! Display settings of the lobes, kept while the editor exists.

use super::theme;
use crate::ui::inputs;
use crate::words::Language;
use egui::{ComboBox, Slider, Ui};

/// Further angles of incidence, degrees.
const OTHERS: [f64; 4] = [0.0, 30.0, 60.0, 80.0];

/// The meaning of the radius.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LobeQuantity {
    /// f_r cos θ: bounded for models that conserve energy.
    WithCosine,
    /// f_r alone.
    Alone,
}

/// The scale of the radius.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RadialScale {
    Linear,
    Logarithmic,
}

/// The display settings.
#[derive(Clone, Debug)]
pub(super) struct LobeView {
    /// Angle of incidence, degrees.
    pub incidence: f64,
    /// Azimuth of the plane of incidence, degrees.
    pub azimuth: f64,
    /// Whether lobes for other angles are drawn too.
    pub has_others: bool,
    pub quantity: LobeQuantity,
    pub scale: RadialScale,
    /// Azimuth and elevation of the camera for the lobe in space, degrees.
    pub orbit: [f32; 2],
}

impl Default for LobeView {
    fn default() -> LobeView {
        LobeView {
            incidence: 45.0,
            azimuth: 0.0,
            has_others: true,
            quantity: LobeQuantity::WithCosine,
            scale: RadialScale::Linear,
            orbit: [-106.0, 24.0],
        }
    }
}

/// Decades that a logarithmic radius spans.
const DECADES: f64 = 4.0;

impl LobeView {
    /// The chosen angle, followed by the others.
    pub fn incidences(&self) -> Vec<f64> {
        let others = OTHERS
            .into_iter()
            .filter(|a| self.has_others && (a - self.incidence).abs() > 5.0);
        std::iter::once(self.incidence).chain(others).collect()
    }

    /// The plotted value for f_r at a cosine to the normal.
    pub fn value(&self, f: f64, cos: f64) -> f64 {
        match self.quantity {
            LobeQuantity::WithCosine => f * cos,
            LobeQuantity::Alone => f,
        }
    }

    /// Fraction of the radius for a value, where `top` is at 1.
    pub fn share(&self, value: f64, top: f64) -> f64 {
        let ratio = value / top;
        match self.scale {
            // NaN has no position.
            _ if ratio.is_nan() || ratio <= 0.0 => 0.0,
            RadialScale::Linear => ratio.min(1.0),
            RadialScale::Logarithmic => (1.0 + ratio.log10() / DECADES).clamp(0.0, 1.0),
        }
    }

    /// The value at a fraction of the radius: the inverse of `share`.
    pub fn value_at(&self, share: f64, top: f64) -> f64 {
        match self.scale {
            RadialScale::Linear => share * top,
            RadialScale::Logarithmic => top * 10f64.powf((share - 1.0) * DECADES),
        }
    }

    /// Values of the rings, from the outermost.
    pub fn rings(&self, top: f64) -> Vec<f64> {
        let decade = 10f64.powf(top.log10().floor());
        match self.scale {
            RadialScale::Logarithmic => (0..DECADES as i32)
                .map(|k| decade / 10f64.powi(k))
                .collect(),
            RadialScale::Linear => {
                let steps = [0.2, 0.5, 1.0, 2.0].map(|s| s * decade);
                let step = steps.into_iter().find(|s| top / s <= 5.0).unwrap_or(decade);
                (1..=5)
                    .rev()
                    .map(|k| f64::from(k) * step)
                    .filter(|v| *v <= top * 1.001)
                    .collect()
            }
        }
    }

    /// Draws the settings.
    pub fn ui(&mut self, ui: &mut Ui, language: Language) {
        let mut degrees = |name: &str, about: &str, value: &mut f64, most: f64| {
            theme::row(ui, name, about, |ui, name| {
                let slider = Slider::new(value, 0.0..=most).suffix("°").step_by(1.0);
                ui.add(slider).accessible_name(name);
            });
        };
        let about = language.tr("Angle between the light and the normal.");
        degrees(language.tr("Incidence"), about, &mut self.incidence, 89.0);
        let about = language.tr("Angle between the plane of incidence and the tangent.");
        degrees(language.tr("Azimuth"), about, &mut self.azimuth, 180.0);
        theme::row(
            ui,
            language.tr("Radius"),
            language.tr("Quantity plotted as the radius."),
            |ui, name| {
                let quantity = |q| match q {
                    LobeQuantity::WithCosine => "f·cos θ",
                    LobeQuantity::Alone => "f",
                };
                let combo = ComboBox::from_id_salt("quantity").width(70.0);
                let quantities = [LobeQuantity::WithCosine, LobeQuantity::Alone];
                inputs::choice(combo, ui, &mut self.quantity, quantities, |&q| quantity(q))
                    .accessible_name(name);
                let scale = |s| match s {
                    RadialScale::Linear => language.tr("Linear"),
                    RadialScale::Logarithmic => language.tr("Logarithmic"),
                };
                let combo = ComboBox::from_id_salt("scale").width(96.0);
                let scales = [RadialScale::Linear, RadialScale::Logarithmic];
                inputs::choice(combo, ui, &mut self.scale, scales, |&s| scale(s))
                    .accessible_name(language.tr("Scale"));
                ui.checkbox(&mut self.has_others, language.tr("More angles"));
            },
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radii_grow_as_they_say() {
        let check = |scale, value: f64, expected: f64| {
            let view = LobeView {
                scale,
                ..LobeView::default()
            };
            let share = view.share(value, 10.0);
            assert!((share - expected).abs() < 1e-12, "{share} {expected}");
        };
        check(RadialScale::Linear, 5.0, 0.5);
        check(RadialScale::Logarithmic, 0.1, 0.5);
        check(RadialScale::Logarithmic, 1e-9, 0.0);
        check(RadialScale::Linear, f64::NAN, 0.0);
    }

    #[test]
    fn rings_are_few_and_round() {
        for scale in [RadialScale::Linear, RadialScale::Logarithmic] {
            let view = LobeView {
                scale,
                ..LobeView::default()
            };
            for top in [0.013, 0.33, 1.0, 7.7, 4.2e5] {
                let rings = view.rings(top);
                assert!((2..=5).contains(&rings.len()), "{top}: {rings:?}");
                assert!(rings.iter().all(|r| *r <= top * 1.001));
            }
        }
    }
}
