//! Fresnel terms: the reflectance of a smooth boundary by angle.

use crate::Rgb;

/// The Fresnel term of a model. Angles are between the light and the normal of the (micro)facet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fresnel {
    /// A constant.
    Constant(Rgb),
    /// Schlick's approximation, from the reflectance at normal incidence; with the tint that
    /// OpenPBR's F82 gives it at cos θ = 1/7 (white for Schlick's own).
    Schlick {
        /// Reflectance at normal incidence.
        f0: Rgb,
        /// Factor on Schlick's value at cos θ = 1/7.
        tint: Rgb,
    },
    /// A metal: the complex index of refraction per channel, relative to the outside.
    Conductor {
        /// Real part.
        eta: Rgb,
        /// Imaginary part.
        k: Rgb,
    },
    /// A transparent body: its index of refraction relative to the outside.
    Dielectric {
        /// The index, > 0.
        eta: f64,
    },
}

impl Fresnel {
    /// Reflectance for the cosine of the angle of incidence, 0..=1.
    pub fn at(&self, cos: f64) -> Rgb {
        let c = cos.clamp(0.0, 1.0);
        match *self {
            Fresnel::Constant(f) => f,
            Fresnel::Schlick { f0, tint } => schlick(f0, tint, c),
            Fresnel::Conductor { eta, k } => {
                let of = |channel: usize| conductor(c, eta[channel], k[channel]);
                Rgb::new(of(0), of(1), of(2))
            }
            Fresnel::Dielectric { eta } => Rgb::grey(dielectric(c, eta)),
        }
    }

    /// Mean over the hemisphere, weighted by the cosine: 2 ∫ F μ dμ.
    pub fn mean(&self) -> Rgb {
        let n = 1024;
        let term = |cos: f64| self.at(cos) * (2.0 * cos / n as f64);
        super::quadrature::midpoints(n).map(term).sum()
    }
}

/// Schlick 1994, less OpenPBR's term for metals (Kutz, Hašan, Edmondson 2021).
fn schlick(f0: Rgb, tint: Rgb, c: f64) -> Rgb {
    let of = |c: f64| f0 + (Rgb::WHITE - f0) * (1.0 - c).powi(5);
    if tint == Rgb::WHITE {
        return of(c);
    }
    let dip = of(1.0 / 7.0) * (Rgb::WHITE - tint) / (1.0 / 7.0 * (6.0f64 / 7.0).powi(6));
    (of(c) - dip * (c * (1.0 - c).powi(6))).map(|f| f.clamp(0.0, 1.0))
}

/// A boundary to a metal of index η + ik, unpolarized light.
fn conductor(c: f64, eta: f64, k: f64) -> f64 {
    // At grazing incidence all light is reflected; the terms below may be 0/0 there.
    let c = c.max(1e-12);
    let (c2, s2) = (c * c, 1.0 - c * c);
    let t = eta * eta - k * k - s2;
    let w = t.hypot(2.0 * eta * k);
    let a = (0.5 * (w + t)).max(0.0).sqrt();
    let rs = (w + c2 - 2.0 * a * c) / (w + c2 + 2.0 * a * c);
    let (sum, difference) = (c2 * w + s2 * s2, 2.0 * a * c * s2);
    let rp = rs * (sum - difference) / (sum + difference);
    (0.5 * (rs + rp)).clamp(0.0, 1.0)
}

/// A boundary to a transparent body, unpolarized light; 1 where reflection is total.
fn dielectric(c: f64, eta: f64) -> f64 {
    let direction = glam::DVec3::new((1.0 - c * c).max(0.0).sqrt(), 0.0, -c);
    crate::fresnel::split(direction, glam::DVec3::Z, eta).reflectance
}
