//! A sum of lobes, sampled in proportion to their albedos.

use super::lewis::mirrored;
use super::lobe::{Lobe, Reflect};
use super::quadrature::{lattice, midpoints};
use crate::Rgb;
use glam::DVec3;

/// Cosines at which the albedo of a lobe is tabulated, to choose among lobes.
const ANGLES: usize = 16;

/// Samples of the albedo at each of them.
const SAMPLES: usize = 256;

/// Samples of an albedo, unless a caller asks for another number.
pub(super) const FINE_SAMPLES: usize = 4096;

/// A direction sampled from a BRDF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrdfSample {
    /// Direction toward the light, unit, above the surface.
    pub wi: DVec3,
    /// f_r cos θi / pdf, the factor of the incident radiance.
    pub weight: Rgb,
    /// Density over solid angle, 1/sr.
    pub pdf: f64,
}

/// A weighted sum of lobes.
#[derive(Clone, Debug, Default)]
pub struct Lobes {
    parts: Vec<WeightedLobe>,
    mean_albedo: Rgb,
    mean_mirror: Rgb,
}

#[derive(Clone, Debug)]
struct WeightedLobe {
    lobe: Lobe,
    weight: f64,
    /// Mean over the channels of the albedo without the perfectly specular part, times the weight,
    /// at the middles of equal intervals of cos θ.
    likely: [f64; ANGLES],
}

impl Lobes {
    pub(super) fn new(lobes: Vec<(f64, Lobe)>) -> Lobes {
        let lobes = lobes.into_iter().filter(|(weight, _)| *weight > 0.0);
        let (mut parts, mut mean_albedo, mut mean_mirror) = (Vec::new(), Rgb::BLACK, Rgb::BLACK);
        for (weight, lobe) in lobes {
            let mut likely = [0.0; ANGLES];
            for (k, cos) in midpoints(ANGLES).enumerate() {
                let scattered = scattered(&lobe, from_cosine(cos), SAMPLES) * weight;
                likely[k] = scattered.mean();
                let share = 2.0 * cos / ANGLES as f64;
                mean_albedo += scattered * share;
                mean_mirror += lobe.mirror(cos) * (weight * share);
            }
            parts.push(WeightedLobe {
                lobe,
                weight,
                likely,
            });
        }
        Lobes {
            parts,
            mean_albedo,
            mean_mirror,
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.parts.is_empty()
    }

    /// The sum of the lobes, 1/sr, without perfect specular reflection.
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        if !(wo.z > 0.0 && wi.z > 0.0) {
            return Rgb::BLACK;
        }
        let of = |p: &WeightedLobe| p.lobe.eval(wo, wi) * p.weight;
        self.parts.iter().map(of).sum()
    }

    /// Reflectance of the perfectly specular part, for the cosine of the angle to the normal.
    pub fn mirror(&self, cos: f64) -> Rgb {
        let of = |p: &WeightedLobe| p.lobe.mirror(cos) * p.weight;
        self.parts.iter().map(of).sum()
    }

    /// Albedo for `wo`, perfect specular reflection included.
    pub fn albedo(&self, wo: DVec3) -> Rgb {
        self.albedo_by(wo, FINE_SAMPLES)
    }

    pub(super) fn albedo_by(&self, wo: DVec3, samples: usize) -> Rgb {
        let of =
            |p: &WeightedLobe| (scattered(&p.lobe, wo, samples) + p.lobe.mirror(wo.z)) * p.weight;
        self.parts.iter().map(of).sum()
    }

    /// Cosine-weighted mean of the albedo over directions: the reflectance for uniform light,
    /// without perfect specular reflection.
    pub fn mean_albedo(&self) -> Rgb {
        self.mean_albedo
    }

    /// The same of perfect specular reflection.
    pub fn mean_mirror(&self) -> Rgb {
        self.mean_mirror
    }

    /// Approximate albedo for `wo` without the specular part, averaged over the channels: the
    /// lobes' claim on samples.
    pub fn likely(&self, wo: DVec3) -> f64 {
        self.parts.iter().map(|p| p.likely(wo)).sum()
    }

    /// A direction, `None` if the sample is lost below the surface. `u[0]` chooses the lobe.
    pub fn direction(&self, wo: DVec3, u: [f64; 3]) -> Option<DVec3> {
        let sum = self.likely(wo);
        let mut rest = u[0] * sum;
        let (part, share) = self.parts.iter().find_map(|p| {
            let share = p.likely(wo);
            let here = rest < share;
            if !here {
                rest -= share;
            }
            here.then_some((p, share))
        })?;
        // The remainder of the number that chose the lobe is uniform again.
        let again = (rest / share).clamp(0.0, 1.0 - f64::EPSILON);
        let wi = part.lobe.sample(wo, [u[1], u[2], again]);
        (wi.z > 0.0).then_some(wi)
    }

    /// A direction for three numbers in 0..1, as [`Brdf::sample`](super::Brdf::sample) gives.
    pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BrdfSample> {
        if !(wo.z > 0.0) {
            return None;
        }
        let wi = self.direction(wo, u)?;
        let pdf = self.pdf(wo, wi);
        let weight = self.eval(wo, wi) * (wi.z / pdf);
        (pdf > 0.0 && weight.is_finite()).then_some(BrdfSample { wi, weight, pdf })
    }

    /// Density of [`sample`](Lobes::sample), 1/sr.
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let sum = self.likely(wo);
        if !(wo.z > 0.0 && wi.z > 0.0 && sum > 0.0) {
            return 0.0;
        }
        let of = |p: &WeightedLobe| p.likely(wo) * p.lobe.pdf(wo, wi);
        self.parts.iter().map(of).sum::<f64>() / sum
    }
}

impl WeightedLobe {
    fn likely(&self, wo: DVec3) -> f64 {
        let at = wo.z * ANGLES as f64 - 0.5;
        let low = (at.floor().max(0.0) as usize).min(ANGLES - 2);
        let t = (at - low as f64).clamp(0.0, 1.0);
        self.likely[low] * (1.0 - t) + self.likely[low + 1] * t
    }
}

/// A direction at that cosine to the normal, halfway between tangent and bitangent, for anisotropic
/// models.
fn from_cosine(cos: f64) -> DVec3 {
    let sin = (0.5 * (1.0 - cos * cos)).sqrt();
    DVec3::new(sin, sin, cos)
}

/// The angle about the specular direction that contains half of the reflected light for incidence
/// near the normal, in radians.
pub(super) fn median_angle(lobe: &impl Reflect) -> f64 {
    let wo = from_cosine(0.999);
    let mirrored = mirrored(wo);
    let weigh = |u: [f64; 3]| {
        let wi = lobe.sample(wo, u);
        let pdf = lobe.pdf(wo, wi);
        let is_lost = !(wi.z > 0.0 && pdf > 0.0);
        let weight = lobe.eval(wo, wi).mean() * wi.z / pdf;
        let angle = mirrored.cross(wi).length().atan2(mirrored.dot(wi));
        (!is_lost).then_some((angle, weight))
    };
    let median = weighted_median(lattice(SAMPLES).filter_map(weigh));
    median.unwrap_or(std::f64::consts::FRAC_PI_2)
}

/// The value below which half of the weights lie; `None` without weights.
pub(super) fn weighted_median(pairs: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let mut pairs: Vec<(f64, f64)> = pairs.collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * pairs.iter().map(|(_, weight)| weight).sum::<f64>();
    let mut sum = 0.0;
    let median = pairs.iter().find(|(_, weight)| {
        sum += weight;
        sum >= half
    });
    median.map(|(value, _)| *value)
}

/// Albedo of a lobe for `wo`, without its specular part, from the mean weight of its samples.
fn scattered(lobe: &Lobe, wo: DVec3, samples: usize) -> Rgb {
    let weight = |u: [f64; 3]| {
        let wi = lobe.sample(wo, u);
        let pdf = lobe.pdf(wo, wi);
        if wi.z > 0.0 && pdf > 0.0 {
            lobe.eval(wo, wi) * (wi.z / pdf)
        } else {
            Rgb::BLACK
        }
    };
    lattice(samples).map(weight).sum::<Rgb>() / samples as f64
}
