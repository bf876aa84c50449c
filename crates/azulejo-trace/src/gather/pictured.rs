//! Direct light of surfaces that emit pictures.
//!
//! Points of the pictures are chosen in two steps: a few in proportion to what they emit, and of these
//! one in proportion to what it would give the point if nothing stood between (resampled importance
//! sampling: Talbot, Cline and Egbert, *Importance resampling for global illumination*, EGSR 2005). So
//! a lamp next to the point is found as easily as a brighter one far away.

use super::direct::Direct;
use super::polygon::kernel;
use super::{GatherPoint, REPLICATES};
use crate::sampling::{hash, seeds, sobol, uniform};
use azulejo_scene::Rgb;
use glam::DVec3;
use std::ops::Range;

/// Points of pictures from which one is chosen.
const CANDIDATES: u32 = 8;

/// A point of a picture that was chosen.
struct PicturedSample {
    /// Where a shadow ray ends.
    target: DVec3,
    /// Irradiance that it stands for, W/m².
    irradiance: Rgb,
}

impl Direct<'_> {
    /// Adds the light of surfaces that emit pictures, one estimate per replicate, from a shadow ray for
    /// each of `rays`.
    pub(super) fn add_pictures(
        &mut self,
        points: &[GatherPoint],
        rays: Range<u32>,
        seed: u32,
        add: impl FnMut(usize, usize, Rgb),
    ) {
        if !self.lights.has_pictures() {
            return;
        }
        let (first, count) = (rays.start, rays.end - rays.start);
        let mut values = Vec::new();
        self.tests.clear();
        for (index, point) in points.iter().enumerate() {
            for r in 0..REPLICATES as u32 {
                let s = seeds(&[seed, point.key, 0xe3, r / 2]);
                for k in 0..count {
                    let k = 2 * first + r % 2 * count + k;
                    let u = [0, 1, 2].map(|d| f64::from(sobol(k, d, s[d])));
                    let key = hash(&[s[3], k]);
                    if let Some(sample) = self.pictured_sample(point, u, key) {
                        let value = sample.irradiance / f64::from(count);
                        self.plan_picture(point, (index, r), sample.target, value, &mut values);
                    }
                }
            }
        }
        self.add_visible(&values, add);
    }

    /// Adds one estimate of that light per point, from one shadow ray each.
    pub(super) fn add_picture_samples(
        &mut self,
        points: &[GatherPoint],
        seed: u32,
        mut add: impl FnMut(usize, Rgb),
    ) {
        if !self.lights.has_pictures() {
            return;
        }
        let mut values = Vec::new();
        self.tests.clear();
        for (index, point) in points.iter().enumerate() {
            let key = hash(&[seed, point.key, 0xe4]);
            let u = [0, 1, 2].map(|d| f64::from(uniform(&[key, d])));
            if let Some(sample) = self.pictured_sample(point, u, key) {
                let value = sample.irradiance;
                self.plan_picture(point, (index, 0), sample.target, value, &mut values);
            }
        }
        self.add_visible(&values, |index, _, value| add(index, value));
    }

    /// A sample for three numbers in 0..1, of which the first two are shifted for each candidate;
    /// `None` if no candidate lights the point.
    fn pictured_sample(
        &self,
        point: &GatherPoint,
        u: [f64; 3],
        key: u32,
    ) -> Option<PicturedSample> {
        let (mut sum, mut chosen) = (0.0, None);
        let mut chance = u[2];
        for k in 0..CANDIDATES {
            // Evenly spaced over the pictures, and at random across them.
            let along = (u[0] + f64::from(k)) / f64::from(CANDIDATES);
            let across = (u[1] + f64::from(uniform(&[key, k]))).fract();
            let (emission, mut y) = self.lights.pictured_point((along, across));
            let is_behind = y.normal.dot(point.position - y.position) < 0.0;
            if is_behind && emission.emits_back {
                y.normal = -y.normal;
            }
            let given = emission.radiance * (kernel(point, y.position, y.normal) * y.area);
            let weight = given.mean();
            if !(weight > 0.0 && weight.is_finite()) {
                continue;
            }
            // One of those so far in proportion to their weights, by one number for all.
            sum += weight;
            let share = weight / sum;
            if chance < share {
                chance /= share;
                chosen = Some((y, given / weight));
            } else {
                chance = (chance - share) / (1.0 - share);
            }
        }
        let (y, color) = chosen?;
        Some(PicturedSample {
            target: self.surfaces.tracer.leaving(y.position, y.normal),
            irradiance: color * (sum / f64::from(CANDIDATES)),
        })
    }

    fn plan_picture(
        &mut self,
        point: &GatherPoint,
        (index, replicate): (usize, u32),
        target: DVec3,
        value: Rgb,
        values: &mut Vec<(usize, Rgb)>,
    ) {
        let first = self.tests.planned();
        let from = self.surfaces.tracer.leaving(point.position, point.normal);
        self.tests.push_segment(from, target);
        self.tests.keep(first, values.len() as u32, replicate, 1.0);
        values.push((index, value));
    }
}
