//! The data of a fit: values of a reflection model for many pairs of directions.

use azulejo_scene::{Brdf, Rgb};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// Steps of Rusinkiewicz's angles θ_h, θ_d and φ_d.
///
/// As in MERL's files, but coarser: θ_h is denser near zero, where highlights are.
const STEPS: [usize; 3] = [40, 12, 10];

/// Steps of φ_h, for anisotropic models.
const TURNS: usize = 8;

/// The value for one pair of directions.
#[derive(Clone, Copy, Debug)]
pub struct FitSample {
    /// To the viewer.
    pub wo: DVec3,
    /// To the light.
    pub wi: DVec3,
    /// f_r, 1/sr.
    pub value: Rgb,
    /// Its weight: the solid angles that it represents, without common factors.
    pub measure: f64,
}

/// Samples of a model, without those at larger polar angles than `most_angle` (radians) and those
/// without data.
pub fn entries(target: &Brdf, most_angle: f64) -> Vec<FitSample> {
    let lowest = most_angle.cos();
    let value = |wo: DVec3, wi: DVec3| {
        let is_in = wo.z >= lowest && wi.z >= lowest;
        let value = if is_in {
            target.eval(wo, wi)
        } else {
            Rgb::BLACK
        };
        (!value.is_black()).then_some(value)
    };
    let turns = if is_isotropic(target) { 1 } else { TURNS };
    let mut samples = Vec::new();
    for turn in 0..turns {
        let phi_h = PI * turn as f64 / turns as f64;
        for (half, measure) in halves() {
            let (wo, wi) = pair(phi_h, half);
            if let Some(value) = value(wo, wi) {
                samples.push(FitSample {
                    wo,
                    wi,
                    value,
                    measure,
                });
            }
        }
    }
    samples
}

/// The angles at the centres of their bins, with the solid angles of the bins.
fn halves() -> impl Iterator<Item = ([f64; 3], f64)> {
    let [a, b, c] = STEPS;
    let bins = (0..a).flat_map(move |i| (0..b).flat_map(move |j| (0..c).map(move |k| [i, j, k])));
    bins.map(move |[i, j, k]| {
        let edge = |i: usize| (i as f64 / a as f64).powi(2) * FRAC_PI_2;
        let theta_h = ((i as f64 + 0.5) / a as f64).powi(2) * FRAC_PI_2;
        let theta_d = (j as f64 + 0.5) / b as f64 * FRAC_PI_2;
        let phi_d = (k as f64 + 0.5) / c as f64 * PI;
        let rings = edge(i).cos() - edge(i + 1).cos();
        (
            [theta_h, theta_d, phi_d],
            rings * theta_d.sin() * theta_d.cos(),
        )
    })
}

/// Directions to the viewer and the light, from half and difference angles (Rusinkiewicz 1998).
fn pair(phi_h: f64, [theta_h, theta_d, phi_d]: [f64; 3]) -> (DVec3, DVec3) {
    let difference = DVec3::new(
        theta_d.sin() * phi_d.cos(),
        theta_d.sin() * phi_d.sin(),
        theta_d.cos(),
    );
    let (sin, cos) = theta_h.sin_cos();
    let tilt = |v: DVec3| DVec3::new(cos * v.x + sin * v.z, v.y, cos * v.z - sin * v.x);
    let turn = |v: DVec3| {
        let (sin, cos) = phi_h.sin_cos();
        DVec3::new(cos * v.x - sin * v.y, sin * v.x + cos * v.y, v.z)
    };
    let other = DVec3::new(-difference.x, -difference.y, difference.z);
    let [wi, wo] = [difference, other].map(|v| turn(tilt(v)));
    (wo, wi)
}

/// Whether the model is isotropic, tested at some angles.
fn is_isotropic(target: &Brdf) -> bool {
    let angles = [
        [0.1, 0.3, 0.7],
        [0.3, 0.7, 1.9],
        [0.05, 1.0, 2.5],
        [0.5, 0.2, 1.2],
    ];
    angles.into_iter().all(|half| {
        let at = |phi_h: f64| {
            let (wo, wi) = pair(phi_h, half);
            target.eval(wo, wi).mean()
        };
        let first = at(0.0);
        [0.6, 1.3, 2.2]
            .into_iter()
            .all(|turn| (at(turn) - first).abs() <= 1e-3 * first.abs())
    })
}

impl FitSample {
    /// The value in the metric of the fit: ln(1 + f cos θi), per channel.
    ///
    /// The logarithm reduces the weight of highlights, the cosine that of grazing angles (Löw,
    /// Kronander, Ynnerman, Unger 2012, section 4).
    pub fn compressed(&self, value: Rgb) -> Rgb {
        value.map(|f| (f * self.wi.z).ln_1p())
    }
}

/// Deviations of a model from the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitErrors {
    /// Root mean square difference of ln(1 + f cos θi), which the fit minimizes.
    pub compressed: f64,
    /// Root mean square difference of f cos θi, weighted by solid angle, relative to that of the
    /// data (Ngan, Durand, Matusik 2005).
    pub relative: f64,
}

/// The errors of a model.
pub fn errors(entries: &[FitSample], model: &Brdf) -> FitErrors {
    let (mut log, mut off, mut all) = (0.0, 0.0, 0.0);
    for entry in entries {
        let value = model.eval(entry.wo, entry.wi);
        let square = |v: Rgb| v.map(|x| x * x).mean();
        log += square(entry.compressed(value) - entry.compressed(entry.value));
        off += entry.measure * square((value - entry.value) * entry.wi.z);
        all += entry.measure * square(entry.value * entry.wi.z);
    }
    FitErrors {
        compressed: (log / entries.len().max(1) as f64).sqrt(),
        relative: if all > 0.0 { (off / all).sqrt() } else { 0.0 },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn brdf(text: &str) -> Brdf {
        Brdf::new(text.parse().unwrap()).unwrap()
    }

    #[test]
    fn pairs_have_their_half_vector() {
        let (wo, wi) = pair(0.4, [0.3, 0.8, 1.1]);
        let h = (wo + wi).normalize();
        assert!((wo.length() - 1.0).abs() < 1e-12 && (wi.length() - 1.0).abs() < 1e-12);
        assert!((h.z.acos() - 0.3).abs() < 1e-12 && (h.y.atan2(h.x) - 0.4).abs() < 1e-12);
        assert!((wo.dot(h).acos() - 0.8).abs() < 1e-12);
    }

    #[test]
    fn far_angles_do_not_count() {
        let data = entries(&brdf("lewis kd = 0.2 ks = 0.5 n = 30"), 80f64.to_radians());
        assert!(
            (1000..STEPS.iter().product()).contains(&data.len()),
            "{}",
            data.len()
        );
        let lowest = data.iter().map(|e| e.wo.z.min(e.wi.z)).fold(1.0, f64::min);
        assert!(lowest >= 80f64.to_radians().cos(), "{lowest}");
    }

    #[test]
    fn a_model_is_not_off_from_itself() {
        let model = brdf("lewis kd = 0.2 ks = 0.5 n = 30");
        let error = errors(&entries(&model, 1.3), &model);
        assert_eq!(
            error,
            FitErrors {
                compressed: 0.0,
                relative: 0.0
            }
        );
        let off = errors(&entries(&model, 1.3), &brdf("diffuse kd = 0"));
        assert!((off.relative - 1.0).abs() < 1e-12, "{off:?}");
    }
}
