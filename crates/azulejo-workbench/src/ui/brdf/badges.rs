//! Badges for reciprocity and energy conservation, both measured numerically.

use super::reflection::MaterialReflection;
use super::theme::mark;
use crate::words::Language;
use azulejo::scene::Rgb;
use azulejo::scene::brdf::check::{self, ANGLES, AZIMUTH};
use azulejo::trace::{Cancelled, Progress};
use egui::{Color32, RichText, Ui};

/// Number of exchanged pairs of directions, in total and per block.
const PAIRS: u32 = 2_000;

/// Larger relative differences are not rounding errors.
const TOLERANCE: f64 = 1e-9;

/// Tolerance of the quadrature for an albedo of 1.
const BRIGHT: f64 = 1.0 + 1e-3;

/// The measured values.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ModelChecks {
    /// Largest relative difference after exchanging the directions of light and camera.
    pub exchanged: f64,
    /// Angles in degrees with the albedo of the channel that reflects most.
    pub albedos: Vec<(f64, f64)>,
}

impl ModelChecks {
    /// The largest albedo, and its angle in degrees.
    fn most(&self) -> (f64, f64) {
        let albedos = self.albedos.iter().map(|&(angle, albedo)| (albedo, angle));
        albedos.fold(
            (0.0, 0.0),
            |most, albedo| if albedo.0 > most.0 { albedo } else { most },
        )
    }
}

/// Measures a material.
pub(super) fn measure(
    optics: &MaterialReflection,
    progress: &Progress,
    show: &mut dyn FnMut(ModelChecks),
) -> Result<(), Cancelled> {
    let reflector = optics.reflector();
    let mut exchanged = 0f64;
    for part in reflector.parts() {
        progress.advance(1)?;
        exchanged = exchanged.max(check::reciprocity(part, PAIRS).largest);
    }
    let mut albedos = Vec::new();
    for angle in ANGLES {
        let wo = check::direction(angle, AZIMUTH);
        let mut sum = Rgb::BLACK;
        for part in reflector.parts() {
            progress.advance(1)?;
            sum += check::albedo(part, wo);
        }
        albedos.push((angle, sum.max_channel()));
    }
    show(ModelChecks { exchanged, albedos });
    Ok(())
}

/// Draws both badges.
pub(super) fn badges(ui: &mut Ui, language: Language, measures: &ModelChecks) {
    reciprocity(ui, language, measures);
    energy(ui, language, measures);
}

fn reciprocity(ui: &mut Ui, language: Language, measures: &ModelChecks) {
    let holds = measures.exchanged <= TOLERANCE;
    let words = if holds {
        language.tr("reciprocal")
    } else {
        language.tr("not reciprocal")
    };
    let about = language
        .tr("Over many pairs of directions, swapping light and camera changes f by at most");
    badge(ui, holds, words).on_hover_text(format!("{about} {:.2} %", 100.0 * measures.exchanged));
}

fn energy(ui: &mut Ui, language: Language, measures: &ModelChecks) {
    let (most, angle) = measures.most();
    let holds = most <= BRIGHT;
    let words = if holds {
        language.tr("energy conserved, albedo at most")
    } else {
        language.tr("energy not conserved, albedo up to")
    };
    let at = language.tr("at");
    let mut about = format!(
        "{words} {most:.2} {at} {angle}°\n{}",
        language.tr("Albedo by angle of incidence:")
    );
    for (angle, albedo) in &measures.albedos {
        about += &format!("\n{angle}°  {albedo:.4}");
    }
    badge(ui, holds, &format!("{words} {most:.2}")).on_hover_text(about);
}

/// A symbol and a text, so that the colour carries no information of its own.
fn badge(ui: &mut Ui, holds: bool, words: &str) -> egui::Response {
    let [r, g, b] = match (holds, ui.visuals().dark_mode) {
        (true, true) => [0, 70, 105],
        (true, false) => [205, 228, 243],
        (false, true) => [120, 60, 0],
        (false, false) => [250, 220, 190],
    };
    let ink = ui.visuals().strong_text_color();
    let frame = egui::Frame::new()
        .fill(Color32::from_rgb(r, g, b))
        .corner_radius(6)
        .inner_margin(egui::Margin::symmetric(6, 2));
    let shown = frame.show(ui, |ui| {
        ui.horizontal(|ui| {
            mark(ui, holds, ink);
            ui.label(RichText::new(words).color(ink))
        })
        .inner
    });
    shown.inner
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo::scene::{Brdf, Material};
    use std::sync::Arc;

    fn measured(text: &str) -> ModelChecks {
        let brdf = Arc::new(Brdf::new(text.parse().unwrap()).unwrap());
        let material = Material {
            brdf: Some(brdf),
            ..Material::default()
        };
        let mut measured = None;
        measure(
            &MaterialReflection::of(&material),
            &Progress::new(),
            &mut |m| measured = Some(m),
        )
        .unwrap();
        measured.unwrap()
    }

    #[test]
    fn the_library_keeps_energy() {
        for entry in &crate::library::LIBRARY {
            let name = entry.script_name();
            let material = entry.material("").unwrap();
            let optics = MaterialReflection::of(&material);
            let mut measured = None;
            measure(&optics, &Progress::new(), &mut |m| measured = Some(m)).unwrap();
            let measured = measured.unwrap();
            assert!(
                measured.most().0 <= BRIGHT,
                "{name}: {:?}",
                measured.albedos
            );
            let is_black = name == "black-rubber";
            assert!(is_black || measured.most().0 > 0.05, "{name} is visible");
        }
    }

    #[test]
    fn measures_tell_models_apart() {
        let lewis = measured("lewis kd = 0.3 ks = 0.6 n = 20");
        assert!(
            lewis.exchanged <= TOLERANCE && lewis.most().0 <= BRIGHT,
            "{lewis:?}"
        );
        assert!(measured("phong kd = 0.3 ks = 0.4 n = 10").exchanged > 0.1);
        assert!(
            measured("lafortune ks = 0.5 cx = 0.9 cy = 0.8 cz = 0.7 n = 5").exchanged <= TOLERANCE
        );
    }
}
