//! Highlights as MTL, 3DS, VRML and OpenFlight describe them.
//!
//! Their shading adds Ks cosⁿ to Kd cos θ, each times the arriving light, and neither bounds
//! nor normalizes the highlight. A reflection model with the same highlight along the normal is
//! f_r = Kd/π + Ks/π cosⁿ. `blinn` and `lewis` are its reciprocal forms, where Ks is replaced by ks,
//! the share that the lobe reflects of light along the normal, which cannot exceed 1 − Kd.

use super::model::{color, model_of, number};
use azulejo_scene::brdf::Description;
use azulejo_scene::{Material, Rgb};

/// The largest exponent of a model; sharper lobes are practically mirrors.
const SHARPEST: f64 = 1e6;

/// The brightest highlight; all but the sharpest lobes are scaled down long before.
const BRIGHTEST: f64 = 1e6;

/// A highlight as a format's shading defines it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Highlight {
    pub angle: Angle,
    /// The exponent.
    pub n: f64,
    /// Peak value of the highlight, Ks.
    pub ks: Rgb,
}

/// The angle whose cosine a highlight uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Angle {
    /// Between the normal and the half vector of light and viewer.
    Half,
    /// Between the viewer and the mirrored light direction.
    Mirrored,
}

/// A number in 0..=most; NaN becomes 0.
fn bounded(x: f64, most: f64) -> f64 {
    if x > 0.0 { x.min(most) } else { 0.0 }
}

impl Highlight {
    /// A highlight around the normal, as in MTL, VRML and OpenFlight. NaN becomes 0.
    pub fn half(n: f64, ks: Rgb) -> Highlight {
        Highlight {
            angle: Angle::Half,
            n: bounded(n, SHARPEST),
            ks: ks.map(|c| bounded(c, BRIGHTEST)),
        }
    }

    /// A highlight around the mirrored light direction, as in 3DS.
    pub fn mirrored(n: f64, ks: Rgb) -> Highlight {
        Highlight {
            angle: Angle::Mirrored,
            ..Highlight::half(n, ks)
        }
    }

    /// The share that the lobe reflects of light along the normal, for a highlight of 1.
    fn share(angle: Angle, n: f64) -> f64 {
        match angle {
            Angle::Half => 8.0 * ((-0.5 * n).exp2() + n) / ((n + 2.0) * (n + 4.0)),
            Angle::Mirrored => 2.0 / (n + 2.0),
        }
    }

    /// The share that the lobe reflects of light along the normal.
    pub fn reflectance(&self) -> Rgb {
        self.ks * Highlight::share(self.angle, self.n)
    }

    /// The model whose lobe reflects `ks`.
    pub fn description(&self, kd: Rgb, ks: Rgb) -> Description {
        let name = match self.angle {
            Angle::Half => "blinn",
            Angle::Mirrored => "lewis",
        };
        let parameters = [("n", self.n.into()), ("ks", ks.into()), ("kd", kd.into())];
        Description::model(name, parameters)
    }

    /// The highlight of a material that has exactly one of these models.
    pub fn of(material: &Material) -> Option<Highlight> {
        let model = model_of(material)?;
        let angle = match &*model.name {
            "blinn" => Angle::Half,
            "lewis" => Angle::Mirrored,
            _ => return None,
        };
        let n = number(model, "n")?;
        let ks = color(model, "ks").unwrap_or(Rgb::WHITE);
        Some(Highlight {
            angle,
            n,
            ks: ks / Highlight::share(angle, n),
        })
    }

    /// The nearest highlight around the normal: angles to the mirrored light are about twice those to
    /// the half vector.
    pub fn around_normal(self) -> Highlight {
        match self.angle {
            Angle::Half => self,
            Angle::Mirrored => Highlight {
                angle: Angle::Half,
                n: 4.0 * self.n,
                ks: self.ks,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::gloss::Gloss;
    use glam::DVec3;
    use std::f64::consts::FRAC_1_PI;

    fn shiny(highlight: Highlight) -> Material {
        let mut material = Material::diffuse("", Rgb::grey(0.2));
        Gloss::default()
            .highlight(&mut material, highlight)
            .unwrap();
        material
    }

    #[test]
    fn highlights_keep_their_height_and_numbers() {
        let ks = Rgb::new(0.5, 0.25, 0.0);
        for n in [0.0, 1.0, 20.0, 1000.0] {
            for made in [
                Highlight::half(n, ks * 0.5),
                Highlight::mirrored(n, ks * 0.5),
            ] {
                let material = shiny(made);
                let f = material.brdf.as_ref().unwrap().eval(DVec3::Z, DVec3::Z);
                let expected = (Rgb::grey(0.2) + ks * 0.5) * FRAC_1_PI;
                assert!((f - expected).map(f64::abs).max_channel() < 1e-12, "{n}");
                let highlight = Highlight::of(&material).unwrap();
                assert_eq!((highlight.angle, highlight.n), (made.angle, n));
                assert!((highlight.ks - made.ks).map(f64::abs).max_channel() < 1e-12);
            }
        }
    }

    #[test]
    fn excessive_reflectance_is_scaled_with_a_warning() {
        let mut material = Material::diffuse("", Rgb::grey(0.8));
        let made = Gloss::default().highlight(&mut material, Highlight::half(0.0, Rgb::WHITE));
        assert!(made.is_err_and(|m| m.contains("more light than it receives")));
        assert!((material.diffuse.r - 0.9 * 0.8 / 1.8).abs() < 0.01);
        assert!(material.brdf.unwrap().albedo(DVec3::Z).r < 0.9 + 1e-3);
    }

    #[test]
    fn nan_makes_no_highlight() {
        let made = Highlight::half(f64::NAN, Rgb::grey(f64::NAN));
        assert_eq!((made.n, made.ks), (0.0, Rgb::BLACK));
        assert_eq!(Highlight::half(f64::INFINITY, Rgb::WHITE).n, SHARPEST);
    }
}
