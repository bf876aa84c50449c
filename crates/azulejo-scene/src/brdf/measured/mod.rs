//! Measured BRDFs: tables in place of formulas.

mod merl;
mod rgl;
mod square;
mod warp;

pub use merl::{HalfAngles, Merl};
pub use rgl::{Grid, Rgl, RglTensors};

use super::NARROW;
use super::lobe::{Reflect, Spread};
use super::lobes::weighted_median;
use super::quadrature::lattice;
use crate::Rgb;
use glam::DVec3;
use std::fmt;
use std::sync::Arc;

/// A measured BRDF, for directions above the surface only; light and viewer have the roles that
/// they had in the measurement.
#[derive(Clone, PartialEq)]
#[non_exhaustive]
pub enum Measured {
    /// In half angles, isotropic.
    Merl(Merl),
    /// On grids adapted to the material.
    Rgl(Box<Rgl>),
}

impl Measured {
    fn model(&self) -> &dyn Reflect {
        match self {
            Measured::Merl(merl) => merl,
            Measured::Rgl(rgl) => &**rgl,
        }
    }
}

impl fmt::Debug for Measured {
    /// Describes the table without its million numbers.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Measured::Merl(merl) => write!(f, "Merl {:?}", merl.sizes()),
            Measured::Rgl(rgl) if rgl.is_isotropic() => f.write_str("Rgl isotropic"),
            Measured::Rgl(_) => f.write_str("Rgl anisotropic"),
        }
    }
}

/// The lobe of a measured BRDF.
#[derive(Clone, Debug)]
pub(super) struct Table(pub Arc<Measured>);

impl Reflect for Table {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        self.0.model().eval(wo, wi)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.0.model().pdf(wo, wi)
    }

    fn sample(&self, wo: DVec3, u: [f64; 3]) -> DVec3 {
        self.0.model().sample(wo, u)
    }

    fn spread(&self) -> Spread {
        self.0.model().spread()
    }
}

/// Lobes at least this wide are matt, in degrees. A Lambertian surface reflects half of the light
/// within 45°.
const WIDE: f64 = 35.0;

/// The angle about the normal that contains half of the light reflected at normal incidence.
/// However narrow, measurements are not perfect mirrors: their peaks are as wide as the lamp of the
/// measurement.
fn spread(model: &dyn Reflect) -> Spread {
    let wo = DVec3::Z;
    let weighed = |u: [f64; 3]| {
        let wi = model.sample(wo, u);
        let pdf = model.pdf(wo, wi);
        let seen = wi.z > 0.0 && pdf > 0.0;
        // Negative cosines rise with the angle.
        seen.then(|| (-wi.z, model.eval(wo, wi).mean() * wi.z / pdf))
    };
    let median = weighted_median(lattice(1024).filter_map(weighed));
    let angle = median.map_or(90.0, |cos| (-cos).min(1.0).acos().to_degrees());
    if angle >= WIDE {
        Spread::Matt
    } else {
        Spread::Glossy(angle.max(NARROW).to_radians())
    }
}

#[cfg(test)]
mod tests;
