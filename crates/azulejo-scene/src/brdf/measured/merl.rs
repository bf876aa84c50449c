//! Tables over half and difference angles, as in the MERL database.

use super::super::lobe::{Reflect, Spread};
use super::super::microfacet::HalfVector;
use super::super::quadrature::cosine_hemisphere;
use super::square;
use super::warp::{Mix, Tables, Warp, mix};
use crate::Rgb;
use crate::content_bytes::{ContentBytes, ContentSink, content_of_fields};
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI};

/// An isotropic BRDF measured at half angles.
///
/// W. Matusik, H. Pfister, M. Brand, L. McMillan, *A data-driven reflectance model*, SIGGRAPH 2003;
/// the angles are Rusinkiewicz' (1998). Entries are values at the middles of their bins,
/// interpolated in between.
#[derive(Clone, PartialEq)]
pub struct Merl {
    /// Bins of θ_h, θ_d, φ_d.
    sizes: [usize; 3],
    values: Vec<[f32; 3]>,
    density: Warp,
}

/// Half and difference angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfAngles {
    /// Between half vector and normal, radians.
    pub theta_h: f64,
    /// Between half vector and light, radians.
    pub theta_d: f64,
    /// Azimuth of the light about the half vector, from the plane of the normal, radians in 0..=π.
    pub phi_d: f64,
}

// The density is derived from the values.
content_of_fields! { Merl { sizes, values; density } }

impl HalfAngles {
    /// The angles of two directions, in any order.
    pub fn new(wo: DVec3, wi: DVec3) -> HalfAngles {
        HalfAngles::of(&HalfVector::new(wo, wi), wi - wo)
    }

    fn of(half: &HalfVector, across: DVec3) -> HalfAngles {
        let h = half.v.normalize_or(DVec3::Z);
        let around = DVec2::new(h.x, h.y).normalize_or_zero();
        let bitangent = DVec3::new(-around.y, around.x, 0.0);
        let (y, x) = (across.dot(bitangent), across.dot(bitangent.cross(h)));
        HalfAngles {
            theta_h: half.theta_h(),
            theta_d: half.cos_d().acos(),
            // Light and viewer may be exchanged, which shifts this angle by π.
            phi_d: if y < 0.0 { (-y).atan2(-x) } else { y.atan2(x) },
        }
    }

    /// Two directions, viewer and light, with these angles, the half vector in the plane of normal
    /// and tangent.
    pub fn directions(&self) -> [DVec3; 2] {
        let (sin_h, cos_h) = self.theta_h.sin_cos();
        let (sin_d, cos_d) = self.theta_d.sin_cos();
        let (sin_phi, cos_phi) = self.phi_d.sin_cos();
        let half = DVec3::new(sin_h, 0.0, cos_h);
        let across = DVec3::new(cos_h, 0.0, -sin_h) * cos_phi + DVec3::Y * sin_phi;
        [half * cos_d - across * sin_d, half * cos_d + across * sin_d]
    }
}

/// The sizes of the tables of the database.
const DATABASE: [usize; 3] = [90, 90, 180];

/// Sizes of the densities: angles of the viewer, and nodes of the half vector's position.
const VIEWERS: usize = 16;
const WIDTH: usize = 64;
const HEIGHT: usize = 33;

/// Fraction of samples from a cosine distribution, for directions that the densities miss.
const EVEN: f64 = 0.15;

impl Merl {
    /// Bins of θ_h, θ_d and φ_d in the database.
    pub const SIZES: [usize; 3] = DATABASE;

    /// A table of `sizes` bins: θ_h with finer bins towards the normal, θ_d, and φ_d, which runs
    /// fastest. `None` unless each size is at least 2, the number of values fits, and all are
    /// finite and not negative.
    pub fn new(sizes: [usize; 3], values: Vec<[f32; 3]>) -> Option<Merl> {
        let [h, d, p] = sizes;
        let count = h.checked_mul(d)?.checked_mul(p)?;
        let fits = sizes.iter().all(|n| *n >= 2) && values.len() == count;
        let is_good = |v: &f32| v.is_finite() && *v >= 0.0;
        if !fits || !values.iter().flatten().all(is_good) {
            return None;
        }
        let mut merl = Merl {
            sizes,
            values,
            density: Warp::new(Tables::new(2, 2, vec![1.0; 4])?),
        };
        merl.density = Warp::new(merl.importance()?);
        Some(merl)
    }

    /// Tabulates a function of two directions, viewer and light, as if it had been measured. It is
    /// zero below the surface. `None` as [`new`](Merl::new).
    pub fn tabulated(sizes: [usize; 3], of: impl Fn(DVec3, DVec3) -> Rgb) -> Option<Merl> {
        let [h, d, p] = sizes;
        let count = h.checked_mul(d)?.checked_mul(p)?;
        let value = |k: usize| {
            let [wo, wi] = angles(sizes, [k / (d * p), k / p % d, k % p]).directions();
            let above = wo.z > 0.0 && wi.z > 0.0;
            let value = if above { of(wo, wi) } else { Rgb::BLACK };
            value.to_f32()
        };
        Merl::new(sizes, (0..count).map(value).collect())
    }

    /// Bins of θ_h, θ_d, φ_d.
    pub fn sizes(&self) -> [usize; 3] {
        self.sizes
    }

    /// The angles and the value of every entry, in the order of the table, 1/sr.
    pub fn entries(&self) -> impl Iterator<Item = (HalfAngles, Rgb)> + '_ {
        let [_, d, p] = self.sizes;
        self.values.iter().enumerate().map(move |(k, value)| {
            let angles = angles(self.sizes, [k / (d * p), k / p % d, k % p]);
            (angles, Rgb::from(value.map(f64::from)))
        })
    }

    /// The value at half angles, 1/sr.
    pub fn at(&self, at: &HalfAngles) -> Rgb {
        let [h, d, p] = self.sizes;
        let theta_h = edged(square::polar_coordinate(at.theta_h), h);
        let theta_d = edged(at.theta_d / FRAC_PI_2, d);
        let phi_d = around(at.phi_d / PI, p);
        let mut sum = Rgb::BLACK;
        for (i, a) in theta_h {
            for (j, b) in theta_d {
                for (k, c) in phi_d {
                    let value = self.values[(i * d + j) * p + k];
                    sum += Rgb::from(value.map(f64::from)) * (a * b * c);
                }
            }
        }
        sum
    }

    /// For each angle of the viewer, the reflected light by position of the half vector.
    fn importance(&self) -> Option<Tables> {
        let mut values = Vec::with_capacity(VIEWERS * WIDTH * HEIGHT);
        for viewer in 0..VIEWERS {
            let (sin, cos) = viewer_angle(viewer).min(1.55).sin_cos();
            let wo = DVec3::new(sin, 0.0, cos);
            for k in 0..WIDTH * HEIGHT {
                let node = |k: usize, n: usize| k as f64 / (n - 1) as f64;
                let place = [node(k % WIDTH, WIDTH), node(k / WIDTH, HEIGHT)];
                values.push(self.seen_by(place, wo) as f32);
            }
        }
        Tables::new(WIDTH, HEIGHT, values)
    }

    fn seen_by(&self, place: [f64; 2], wo: DVec3) -> f64 {
        let wi = square::mirrored_at(place, 0.0, wo);
        if wi.z <= 0.0 {
            return 0.0;
        }
        let seen = self.eval(wo, wi).mean() * wi.z * square::solid_angle(&HalfVector::new(wo, wi));
        seen.min(f64::from(f32::MAX))
    }

    fn mix(&self, wo: DVec3) -> Mix {
        mix([&[0.0], &VIEWER_ANGLES], [0.0, square::polar(wo)])
    }
}

/// Angle to the normal of the k-th viewing direction of the densities.
fn viewer_angle(viewer: usize) -> f64 {
    f64::from(VIEWER_ANGLES[viewer])
}

const VIEWER_ANGLES: [f32; VIEWERS] = {
    let mut angles = [0.0; VIEWERS];
    let mut k = 0;
    while k < VIEWERS {
        angles[k] = k as f32 * (std::f32::consts::FRAC_PI_2 / (VIEWERS - 1) as f32);
        k += 1;
    }
    angles
};

/// The angles at the middle of a bin.
fn angles(sizes: [usize; 3], bin: [usize; 3]) -> HalfAngles {
    let middle = |k: usize| (bin[k] as f64 + 0.5) / sizes[k] as f64;
    HalfAngles {
        theta_h: middle(0).powi(2) * FRAC_PI_2,
        theta_d: middle(1) * FRAC_PI_2,
        phi_d: middle(2) * PI,
    }
}

/// The two bins whose middles enclose `x` in 0..=1, with weights; clamped to the first and the
/// last.
fn edged(x: f64, count: usize) -> [(usize, f64); 2] {
    let at = (x * count as f64 - 0.5).clamp(0.0, (count - 1) as f64);
    let low = (at as usize).min(count - 2);
    let t = at - low as f64;
    [(low, 1.0 - t), (low + 1, t)]
}

/// The same for a periodic table, whose last bin is adjacent to the first.
fn around(x: f64, count: usize) -> [(usize, f64); 2] {
    let at = x * count as f64 - 0.5;
    let t = at - at.floor();
    // From −1 for half a bin before the first to count − 1.
    let low = (at.floor() + count as f64) as usize;
    [(low % count, 1.0 - t), ((low + 1) % count, t)]
}

impl Reflect for Merl {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        self.at(&HalfAngles::new(wo, wi))
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let half = HalfVector::new(wo, wi);
        let place = square::place(&half, square::azimuth(wo));
        let density = self.density.density(&self.mix(wo), place) / square::solid_angle(&half);
        EVEN * wi.z * FRAC_1_PI + (1.0 - EVEN) * density
    }

    fn sample(&self, wo: DVec3, [u1, u2, choice]: [f64; 3]) -> DVec3 {
        if choice < EVEN {
            return cosine_hemisphere(u1, u2);
        }
        let place = self.density.sample(&self.mix(wo), [u1, u2]);
        square::mirrored_at(place, square::azimuth(wo), wo)
    }

    fn spread(&self) -> Spread {
        super::spread(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_and_directions_agree() {
        let check = |theta_h: f64, theta_d: f64, phi_d: f64| {
            let angles = HalfAngles {
                theta_h,
                theta_d,
                phi_d,
            };
            let [wo, wi] = angles.directions();
            for angles in [HalfAngles::new(wo, wi), HalfAngles::new(wi, wo)] {
                assert!((angles.theta_h - theta_h).abs() < 1e-9, "{angles:?}");
                assert!((angles.theta_d - theta_d).abs() < 1e-9, "{angles:?}");
                assert!((angles.phi_d - phi_d).abs() < 1e-9, "{angles:?}");
            }
        };
        check(0.3, 0.4, 1.0);
        check(0.01, 1.2, 3.0);
        check(1.0, 0.2, 0.1);
    }

    /// Every entry is reproduced at the middle of its bin, and φ_d is periodic with π.
    #[test]
    fn entries_are_found_where_they_stand() {
        let values = (0..60).map(|k| [k as f32, 0.0, 1.0]).collect();
        let merl = Merl::new([3, 4, 5], values).unwrap();
        for (angles, value) in merl.entries() {
            assert!((merl.at(&angles).r - value.r).abs() < 1e-9);
        }
        let mut edge = angles(merl.sizes, [1, 2, 0]);
        edge.phi_d = 0.0;
        let before = merl.at(&edge);
        edge.phi_d = PI;
        let after = merl.at(&edge);
        assert!((before.r - after.r).abs() < 1e-9, "{before:?} {after:?}");
    }

    #[test]
    fn bad_tables_are_refused() {
        assert!(Merl::new([2, 2, 2], vec![[0.0; 3]; 7]).is_none());
        assert!(Merl::new([1, 2, 2], vec![[0.0; 3]; 4]).is_none());
        assert!(Merl::new([2, 2, 2], vec![[f32::NAN; 3]; 8]).is_none());
        assert!(Merl::new([2, 2, 2], vec![[-1.0; 3]; 8]).is_none());
        assert!(Merl::new([usize::MAX, 2, 2], Vec::new()).is_none());
    }
}
