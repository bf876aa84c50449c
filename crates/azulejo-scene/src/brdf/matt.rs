//! Lobes about as wide as the hemisphere: all of them are sampled as Lambert's.

use super::lobe::{Reflect, Spread};
use super::quadrature::cosine_hemisphere;
use crate::Rgb;
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// A lobe that a cosine is a good density for.
pub(super) trait Matt {
    /// f_r, 1/sr; finite.
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb;
}

impl<M: Matt> Reflect for M {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        Matt::eval(self, wo, wi)
    }

    fn pdf(&self, _wo: DVec3, wi: DVec3) -> f64 {
        wi.z * FRAC_1_PI
    }

    fn sample(&self, _wo: DVec3, [u1, u2, _]: [f64; 3]) -> DVec3 {
        cosine_hemisphere(u1, u2)
    }

    fn spread(&self) -> Spread {
        Spread::Matt
    }
}

/// What cos of the angle between two directions has beyond the product of their cosines to the
/// normal: sin θi sin θo cos Δφ.
pub(super) fn across(wo: DVec3, wi: DVec3) -> f64 {
    wo.x * wi.x + wo.y * wi.y
}
