//! Fresnel's and Snell's laws: the smooth boundary of a transparent body, and a thin pane.

use crate::math::reflect;
use glam::DVec3;

/// How a boundary or a pane splits one ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FresnelSplit {
    /// Fraction of the radiance that is reflected, 0..=1; 1 for total internal reflection.
    pub reflectance: f64,
    /// Reflected direction, unit.
    pub reflected: DVec3,
    /// Transmitted direction, unit; `None` for total internal reflection.
    pub refracted: Option<DVec3>,
}

/// Splits a ray at the boundary between two media.
///
/// `direction` is unit and points against the unit normal `n` (`direction · n <= 0`); `eta` > 0 is
/// the index of refraction of the far side over that of the near side. Snell's law and Fresnel's
/// equations for unpolarized light, exact. At grazing incidence everything is reflected.
pub fn split(direction: DVec3, n: DVec3, eta: f64) -> FresnelSplit {
    let cos_i = (-direction.dot(n)).clamp(0.0, 1.0);
    let reflected = reflect(direction, n);
    let cos2_t = 1.0 - (1.0 - cos_i * cos_i) / (eta * eta);
    if cos2_t <= 0.0 {
        return FresnelSplit {
            reflectance: 1.0,
            reflected,
            refracted: None,
        };
    }
    let cos_t = cos2_t.sqrt();
    let bent = direction / eta + (cos_i / eta - cos_t) * n;
    FresnelSplit {
        reflectance: reflectance(cos_i, cos_t, eta),
        reflected,
        refracted: Some(bent.normalize()),
    }
}

/// Splits a ray at a thin pane, which stands for both of its surfaces: transmitted light continues
/// straight.
///
/// Arguments as for [`split`]. For either polarization each surface reflects the fraction R; with
/// all interreflections between the two, 2R/(1 + R) is reflected and (1 − R)/(1 + R) transmitted.
/// Light from either side is split in the same way.
pub fn pane(direction: DVec3, n: DVec3, eta: f64) -> FresnelSplit {
    let one = split(direction, n, eta);
    if one.refracted.is_none() {
        return one;
    }
    let cos_i = (-direction.dot(n)).clamp(0.0, 1.0);
    let cos_t = (1.0 - (1.0 - cos_i * cos_i) / (eta * eta)).max(0.0).sqrt();
    let both = polarized(cos_i, cos_t, eta).map(|r| 2.0 * r / (1.0 + r));
    FresnelSplit {
        reflectance: 0.5 * (both[0] + both[1]),
        refracted: Some(direction),
        ..one
    }
}

/// Fresnel reflectance of unpolarized light: the mean over both polarizations.
fn reflectance(cos_i: f64, cos_t: f64, eta: f64) -> f64 {
    let [perpendicular, parallel] = polarized(cos_i, cos_t, eta);
    0.5 * (perpendicular + parallel)
}

/// Fresnel reflectance of light polarized perpendicular and parallel to the plane of incidence.
///
/// Hecht, *Optics*, 4th ed., eqs. (4.34) and (4.40), with the indices divided by the near one.
fn polarized(cos_i: f64, cos_t: f64, eta: f64) -> [f64; 2] {
    let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    [perpendicular * perpendicular, parallel * parallel]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_angle(degrees: f64, eta: f64) -> FresnelSplit {
        let (sin, cos) = degrees.to_radians().sin_cos();
        split(DVec3::new(sin, 0.0, -cos), DVec3::Z, eta)
    }

    #[test]
    fn known_reflectances() {
        let check = |degrees: f64, eta: f64, expected: f64| {
            let r = at_angle(degrees, eta).reflectance;
            assert!(
                (r - expected).abs() < 1e-9,
                "{degrees}° into {eta}: {r}, expected {expected}"
            );
        };
        check(0.0, 1.5, 0.04);
        check(0.0, 1.0 / 1.5, 0.04);
        check(30.0, 1.0, 0.0);
        check(90.0, 1.5, 1.0);
        // At Brewster's angle only the perpendicular polarization is reflected.
        let brewster = 1.5f64.atan();
        let rs = (2.0 * brewster).cos().powi(2);
        check(brewster.to_degrees(), 1.5, 0.5 * rs);
        // The critical angle, from inside glass, is 41.81°.
        check(42.0, 1.0 / 1.5, 1.0);
        assert!(at_angle(41.0, 1.0 / 1.5).reflectance < 0.5);
    }

    #[test]
    fn snell_holds_and_the_way_back_is_the_way_in() {
        for degrees in [0.0, 10.0, 45.0, 80.0, 89.9] {
            let s = at_angle(degrees, 1.5);
            let t = s
                .refracted
                .expect("from the thinner medium there is always a way in");
            assert!(
                (1.5 * t.x - f64::to_radians(degrees).sin()).abs() < 1e-12,
                "{degrees}"
            );
            assert!((t.length() - 1.0).abs() < 1e-12 && t.z < 0.0);
            let back = split(-t, -DVec3::Z, 1.0 / 1.5);
            assert!((back.reflectance - s.reflectance).abs() < 1e-9, "{degrees}");
        }
    }

    /// 2 ∫ R(cos) cos d cos, by the midpoint rule.
    fn diffuse_average(at: fn(DVec3, DVec3, f64) -> FresnelSplit, eta: f64) -> f64 {
        let n = 20_000;
        let term = |i: i32| {
            let c = (f64::from(i) + 0.5) / f64::from(n);
            let d = DVec3::new((1.0 - c * c).sqrt(), 0.0, -c);
            2.0 * c * at(d, DVec3::Z, eta).reflectance / f64::from(n)
        };
        (0..n).map(term).sum()
    }

    #[test]
    fn diffuse_averages_match_the_tabulated_ones() {
        assert!((diffuse_average(split, 1.5) - 0.091_777_959_3).abs() < 1e-6);
        assert!((diffuse_average(split, 1.0 / 1.5) - 0.596_345_759_7).abs() < 1e-6);
        assert!((1.0 - diffuse_average(pane, 1.5) - 0.850_938_300_9).abs() < 1e-6);
    }

    #[test]
    fn a_pane_is_two_boundaries() {
        // At normal incidence: 0.04 of each surface, 0.08/1.04 of both.
        let straight = pane(-DVec3::Z, DVec3::Z, 1.5);
        assert!((straight.reflectance - 0.08 / 1.04).abs() < 1e-12);
        assert_eq!(straight.refracted, Some(-DVec3::Z));
        // An index of 1 reflects nothing at any angle; an index below 1 may reflect everything.
        let slant = DVec3::new(0.96, 0.0, -0.28);
        assert!(pane(slant, DVec3::Z, 1.0).reflectance < 1e-15);
        assert_eq!(pane(slant, DVec3::Z, 1.0 / 1.5).refracted, None);
        assert!((pane(DVec3::X, DVec3::Z, 1.5).reflectance - 1.0).abs() < 1e-12);
    }
}
