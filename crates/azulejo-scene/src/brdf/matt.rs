//! Lobes about as wide as the hemisphere: all are sampled by a cosine distribution.

use super::lobe::{Reflect, Spread};
use super::quadrature::cosine_hemisphere;
use crate::Rgb;
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// A lobe for which a cosine distribution is a good density.
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

/// sin θi sin θo cos Δφ: the cosine of the angle between two directions less the product of their
/// cosines to the normal.
pub(super) fn across(wo: DVec3, wi: DVec3) -> f64 {
    wo.x * wi.x + wo.y * wi.y
}
