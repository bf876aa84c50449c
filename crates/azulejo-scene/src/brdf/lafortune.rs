//! Cosine lobes around arbitrary directions, for fits to measurements: `lafortune`.
//!
//! E. P. F. Lafortune, S.-C. Foo, K. E. Torrance, D. P. Greenberg, *Non-linear approximation of
//! reflectance functions*, SIGGRAPH 1997. One lobe; several are a combination. Published fits have
//! no separate reflectance, since the coefficients include it: leave ks at 1 for them.

use super::arguments::Arguments;
use super::lambert::Lambert;
use super::lewis::about;
use super::lobe::{Lobe, Reflect, Spread};
use super::models::{KD, KS, ModelInfo, PLAIN, ParameterInfo};
use super::{BrdfError, NARROW};
use crate::Rgb;
use glam::DVec3;
use std::f64::consts::TAU;

/// A coefficient per channel; |c| < 2 covers every published fit.
const fn coefficient(name: &'static str, about: &'static str) -> ParameterInfo {
    ParameterInfo::color(name, [-2.0, 2.0], about)
}

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "lafortune",
    aliases: &["generalized_cosine"],
    title: "Lafortune",
    paper: "E. P. F. Lafortune, S.-C. Foo, K. E. Torrance, D. P. Greenberg, Non-linear \
            approximation of reflectance functions, SIGGRAPH 1997",
    parameters: &[
        KD,
        KS,
        coefficient("cx", "along the tangent; −1 mirrors, 1 sends back").or(-1.0),
        coefficient("cy", "along the bitangent; as cx").or(-1.0),
        coefficient("cz", "along the normal").or(1.0),
        ParameterInfo::color("n", [0.0, 1e6], "exponent: the higher, the narrower"),
    ],
    examples: &[
        "lafortune kd = 0.2 ks = 0.5 cx = -1 cy = -1 cz = 0.95 n = 20",
        "lafortune cx = (-0.9, -0.8, -0.7) cy = (-0.9, -0.8, -0.7) cz = (0.9, 0.95, 1) n = (12, 16, 30)",
        "lafortune ks = 0.5 cx = 0.9 cy = 0.8 cz = 0.7 n = 5",
        "lafortune ks = 0.3 cx = 0 cy = 0 cz = 1 n = 0.5",
    ],
    is_energy_safe: false,
    make,
    ..PLAIN
};

/// Largest reflectance of a lobe that a fit to a real surface may have.
const PLAUSIBLE: f64 = 10.0;

fn make(arguments: &Arguments) -> Result<Vec<Lobe>, BrdfError> {
    let (cx, cy, cz) = (
        arguments.color("cx"),
        arguments.color("cy"),
        arguments.color("cz"),
    );
    let exponents = arguments.color("n").to_array();
    let scale = arguments.color("ks");
    let axes = [0, 1, 2].map(|c| DVec3::new(cx[c], cy[c], cz[c]));
    let lobe = Lafortune {
        scale,
        axes,
        exponents,
    };
    let most = lobe.most();
    if most > PLAUSIBLE {
        return Err(BrdfError::Energy {
            what: "the reflectance of `lafortune`, 2π ks max(cx, cy, cz)ⁿ/(n + 2),".to_owned(),
            sum: most,
        });
    }
    Ok(vec![
        Lobe::Lambert(Lambert {
            albedo: arguments.color("kd"),
        }),
        Lobe::Lafortune(lobe),
    ])
}

/// ks (cx x x′ + cy y y′ + cz z z′)ⁿ per channel.
#[derive(Clone, Debug)]
pub(super) struct Lafortune {
    scale: Rgb,
    /// cx, cy, cz of each channel.
    axes: [DVec3; 3],
    exponents: [f64; 3],
}

impl Lafortune {
    /// An upper bound of the lobe's reflectance.
    fn most(&self) -> f64 {
        let of = |c: usize| {
            let n = self.exponents[c];
            let power = self.axes[c].abs().max_element().powf(n).min(f64::MAX);
            self.scale[c] * power * TAU / (n + 2.0)
        };
        // Powers may be infinite, and infinity times a scale of 0 would be NaN.
        of(0).max(of(1)).max(of(2))
    }

    /// The direction of the lobe of a channel.
    fn axis(&self, channel: usize, wo: DVec3) -> DVec3 {
        (self.axes[channel] * wo).normalize_or(DVec3::Z)
    }
}

/// cosⁿ where the cosine is positive.
fn power(cos: f64, n: f64) -> f64 {
    if cos > 0.0 { cos.powf(n) } else { 0.0 }
}

impl Reflect for Lafortune {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let of = |c: usize| power(self.axes[c].dot(wo * wi), self.exponents[c]);
        self.scale * Rgb::new(of(0), of(1), of(2))
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let of = |c: usize| {
            let (cos, n) = (self.axis(c, wo).dot(wi), self.exponents[c]);
            (n + 1.0) / TAU * power(cos.min(1.0), n)
        };
        (of(0) + of(1) + of(2)) / 3.0
    }

    /// Each channel's lobe gets a third of the samples.
    fn sample(&self, wo: DVec3, [u1, u2, choice]: [f64; 3]) -> DVec3 {
        let channel = ((3.0 * choice) as usize).min(2);
        let cos = (1.0 - u1).powf(1.0 / (self.exponents[channel] + 1.0));
        about(self.axis(channel, wo), cos, u2)
    }

    fn spread(&self) -> Spread {
        let least = self.exponents.into_iter().fold(f64::INFINITY, f64::min);
        let angle = 0.5f64.powf(1.0 / (least + 1.0)).acos();
        let mirrors = |axis: &DVec3| axis.x < 0.0 && axis.y < 0.0;
        if self.axes.iter().all(mirrors) {
            Spread::Glossy(angle)
        } else {
            // However narrow, it is not a perfect mirror.
            Spread::Glossy(angle.max(NARROW.to_radians()))
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::brdf::{Brdf, Description};
    use glam::DVec3;

    fn brdf(text: &str) -> Brdf {
        Brdf::new(text.parse::<Description>().unwrap()).unwrap()
    }

    /// With −1, −1, 1 and a factor (n + 2)/(2π) the coefficients give Lewis' lobe.
    #[test]
    fn is_lewis_where_it_mirrors() {
        let n = 10.0;
        let c = (12.0 / std::f64::consts::TAU).powf(1.0 / n);
        let ours = brdf(&format!("lafortune cx = -{c} cy = -{c} cz = {c} n = {n}"));
        let lewis = brdf("lewis ks = 1 n = 10");
        let (wo, wi) = (
            DVec3::new(0.6, 0.0, 0.8),
            DVec3::new(-0.5, 0.3, 0.6).normalize(),
        );
        let (a, b) = (ours.eval(wo, wi).g, lewis.eval(wo, wi).g);
        assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
    }

    #[test]
    fn what_no_surface_reflects_is_refused() {
        let description: Description = "lafortune cx = -2 n = 1000".parse().unwrap();
        assert!(Brdf::new(description).is_err());
    }
}
