//! The irradiance of a sky on level ground.

use crate::quadrature::gauss_legendre;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// Nodes between two cuts of the zenith angle.
const ZENITH_NODES: usize = 40;

/// Nodes of half a turn of azimuth.
const AZIMUTH_NODES: usize = 24;

/// ∫ L cos Z dω over the upper hemisphere, of a luminance that is symmetric about the vertical
/// plane through the sun and smooth but at the sun and at the zenith angle `edge`.
///
/// `sun_zenith`: 0..=π. `luminance` of a unit direction, z up, in a frame turned so that the sun is
/// at (sin `sun_zenith`, 0, cos `sun_zenith`). Gauss's rule; at the sun, where the luminance has a
/// peak like a cone, the zenith angle is cut, and nodes crowd towards it in both angles.
pub(super) fn horizontal_irradiance(
    sun_zenith: f64,
    edge: Option<f64>,
    luminance: impl Fn(DVec3) -> f64,
) -> f64 {
    let sun = sun_zenith.clamp(0.0, FRAC_PI_2);
    let mut cuts = vec![0.0, sun, FRAC_PI_2];
    cuts.extend(edge);
    cuts.sort_by(f64::total_cmp);
    let zenith_rule = gauss_legendre(ZENITH_NODES);
    let azimuth_rule = gauss_legendre(AZIMUTH_NODES);
    let mut sum = 0.0;
    for cut in cuts.windows(2).filter(|c| c[1] > c[0]) {
        for &(x, weight) in &zenith_rule {
            let (z, dz) = crowded(cut[0], cut[1], 0.5 * (1.0 + x));
            let ring = half_ring(z, sun_zenith, &azimuth_rule, &luminance);
            sum += 0.5 * weight * dz * z.sin() * z.cos() * ring;
        }
    }
    2.0 * sum
}

/// The point of `from..to` at the share `t` of it, and its derivative. Points crowd towards both
/// ends: one is the sun's angle, and at the horizon the gradation exp(b / cos Z) is smooth, but has
/// no power series.
fn crowded(from: f64, to: f64, t: f64) -> (f64, f64) {
    let length = to - from;
    (
        from + length * t * t * (3.0 - 2.0 * t),
        6.0 * length * t * (1.0 - t),
    )
}

/// The integral of luminance over the azimuths 0..π from the sun's at the zenith angle `z`.
///
/// With the azimuth φ = 2 a sinh u, and sinh a the ratio that follows, the angle χ to the sun,
/// sin²(χ/2) = sin²((Z − Z_s)/2) + sin Z sin Z_s sin²(φ/2), is smooth in u however near the ring
/// passes the sun.
fn half_ring(
    z: f64,
    sun_zenith: f64,
    rule: &[(f64, f64)],
    luminance: impl Fn(DVec3) -> f64,
) -> f64 {
    let near = (0.5 * (z - sun_zenith)).sin().abs();
    let far = (z.sin() * sun_zenith.sin()).max(0.0).sqrt();
    // A ring around the zenith or far from the sun needs no crowding, one through the sun has a
    // limit.
    let a = (near / far.max(1e-6)).asinh().clamp(1e-9, 4.0);
    let end = (FRAC_PI_2 / a).asinh();
    let (sin_z, cos_z) = z.sin_cos();
    let mut sum = 0.0;
    for &(x, weight) in rule {
        let u = 0.5 * (1.0 + x) * end;
        let azimuth = (2.0 * a * u.sinh()).min(PI);
        let (sin, cos) = azimuth.sin_cos();
        let direction = DVec3::new(sin_z * cos, sin_z * sin, cos_z);
        sum += weight * u.cosh() * luminance(direction);
    }
    a * end * sum
}
