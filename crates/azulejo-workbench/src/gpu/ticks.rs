//! Round values on a colour scale: for its legend and for isolines.

use super::ColorScale;

/// Decades above which a logarithmic scale is marked at powers of ten alone.
const FEW_DECADES: f64 = 3.5;

impl ColorScale {
    /// Distance between isolines in the stored unit, round in the displayed one; for a logarithmic
    /// scale 1 if they are powers of ten, and otherwise 0.3: 1, 2 and 5 of each. 0 for none.
    pub fn interval(&self) -> f64 {
        if self.bands == 0 {
            return 0.0;
        }
        if self.is_logarithmic {
            let decades = (self.high / self.low).log10();
            return if decades > FEW_DECADES { 1.0 } else { 0.3 };
        }
        let span = self.display * (self.high - self.low);
        round_step(span / f64::from(self.bands)) / self.display
    }

    /// Round values between the ends of the scale in the displayed unit, in ascending order: those
    /// of the isolines, or about four where there are none.
    pub fn ticks(&self) -> Vec<f64> {
        let scale = ColorScale {
            bands: if self.bands == 0 { 4 } else { self.bands },
            ..*self
        };
        let (low, high) = (self.display * self.low, self.display * self.high);
        let slack = 1e-6 * (high - low);
        let inside = |v: &f64| (low - slack..=high + slack).contains(v);
        if self.is_logarithmic {
            let decades = (low.log10().floor() as i32)..=(high.log10().ceil() as i32);
            let steps: &[f64] = if scale.interval() < 1.0 {
                &[1.0, 2.0, 5.0]
            } else {
                &[1.0]
            };
            let values = decades.flat_map(|power| steps.iter().map(move |s| s * 10f64.powi(power)));
            return values.filter(inside).collect();
        }
        let step = scale.interval() * self.display;
        if !(step > 0.0 && step.is_finite()) {
            return Vec::new();
        }
        let first = (low / step - 1e-6).ceil();
        let count = ((high / step + 1e-6).floor() - first).clamp(0.0, 1_000.0) as u32;
        (0..=count).map(|k| (first + f64::from(k)) * step).collect()
    }

    /// The scale with ends at round values that include the old ones.
    pub fn rounded(self) -> ColorScale {
        if self.is_logarithmic {
            return self;
        }
        let span = self.display * (self.high - self.low);
        let step = round_step(span / f64::from(self.bands.max(4))) / self.display;
        if !(step > 0.0 && step.is_finite()) {
            return self;
        }
        // A scale that begins near 0 begins at 0, with which everything is compared.
        let low = if self.low < 0.3 * self.high {
            0.0
        } else {
            (self.low / step).floor() * step
        };
        ColorScale {
            low,
            high: (self.high / step - 1e-9).ceil() * step,
            ..self
        }
    }
}

/// The smallest of 1, 2, 2.5 and 5 times a power of ten that is not less than `step`.
fn round_step(step: f64) -> f64 {
    if !(step > 0.0 && step.is_finite()) {
        return 0.0;
    }
    let power = 10f64.powf(step.log10().floor());
    let steps = [1.0, 2.0, 2.5, 5.0, 10.0];
    let factor = steps.iter().find(|s| *s * power >= step * (1.0 - 1e-9));
    factor.map_or(step, |s| s * power)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scale(low: f64, high: f64) -> ColorScale {
        ColorScale {
            low,
            high,
            bands: 8,
            ..ColorScale::default()
        }
    }

    #[test]
    fn ticks_are_round_in_the_unit_that_is_shown() {
        let rounded = scale(0.0, 2.07).rounded();
        assert_eq!((rounded.low, rounded.high), (0.0, 2.5));
        assert_eq!(rounded.ticks(), [0.0, 0.5, 1.0, 1.5, 2.0, 2.5]);
        let lux = ColorScale {
            display: 179.0,
            ..scale(0.0, 2.07)
        };
        let lux = lux.rounded();
        assert!(
            (lux.high * 179.0 - 400.0).abs() < 1e-9,
            "{}",
            lux.high * 179.0
        );
        assert_eq!(lux.ticks().len(), 9);
        assert_eq!(scale(90.0, 110.0).rounded().ticks().first(), Some(&90.0));
    }

    #[test]
    fn logarithmic_scales_are_marked_by_decades() {
        let log = |low, high| ColorScale {
            is_logarithmic: true,
            ..scale(low, high)
        };
        let near = |ticks: Vec<f64>, expected: &[f64]| {
            assert_eq!(ticks.len(), expected.len(), "{ticks:?}");
            for (a, b) in ticks.iter().zip(expected) {
                assert!((a / b - 1.0).abs() < 1e-9, "{ticks:?}");
            }
        };
        near(log(0.9, 12.0).ticks(), &[1.0, 2.0, 5.0, 10.0]);
        near(log(1e-3, 50.0).ticks(), &[1e-3, 1e-2, 0.1, 1.0, 10.0]);
    }

    #[test]
    fn a_scale_without_extent_has_few_ticks() {
        assert!(scale(1.0, 1.0).ticks().len() <= 1);
        assert_eq!(scale(0.0, 0.0).interval(), 0.0);
    }
}
