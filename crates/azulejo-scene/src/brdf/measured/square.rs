//! Directions of half vectors as positions in the unit square, finer towards the normal.

use super::super::microfacet::{HalfVector, mirrored_by};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// An angle to the normal in 0..1: √(2θ/π).
pub(super) fn polar_coordinate(theta: f64) -> f64 {
    (theta / FRAC_PI_2).sqrt()
}

/// An angle around the normal in 0..1, starting at −π.
pub(super) fn azimuth_coordinate(phi: f64) -> f64 {
    let turn = (phi + PI) / TAU;
    turn - turn.floor()
}

/// The angle of a direction around the normal; 0 for the normal.
pub(super) fn azimuth(w: DVec3) -> f64 {
    w.y.atan2(w.x)
}

/// The angle of a direction to the normal.
pub(super) fn polar(w: DVec3) -> f64 {
    w.x.hypot(w.y).atan2(w.z)
}

/// Position of the half vector of two directions, rotated back by `turn`.
pub(super) fn place(half: &HalfVector, turn: f64) -> [f64; 2] {
    [
        polar_coordinate(half.theta_h()),
        azimuth_coordinate(azimuth(half.v) - turn),
    ]
}

/// The direction to which the facet of a position reflects `wo`.
pub(super) fn mirrored_at([x, y]: [f64; 2], turn: f64, wo: DVec3) -> DVec3 {
    let (sin, cos) = (x * x * FRAC_PI_2).sin_cos();
    let (sin_phi, cos_phi) = (TAU * y - PI + turn).sin_cos();
    mirrored_by(wo, DVec3::new(sin * cos_phi, sin * sin_phi, cos))
}

/// Solid angle of reflected directions per area of the square, sr.
pub(super) fn solid_angle(half: &HalfVector) -> f64 {
    let theta = half.theta_h();
    // dω of the half vector is sin θ dθ dφ, and θ = x² π/2.
    let half_angle = 2.0 * PI * PI * polar_coordinate(theta) * theta.sin();
    (half_angle * 4.0 * half.cos_d()).max(1e-12)
}
