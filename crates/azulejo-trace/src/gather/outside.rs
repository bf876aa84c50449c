//! Direct light of environments at points, and what paths find beyond the scene.
//!
//! Directions of the hemisphere and directions in which the environment is bright are two
//! estimators of the same light, weighted by the balance heuristic (Veach and Guibas, *Optimally
//! combining sampling techniques for Monte Carlo rendering*, SIGGRAPH 1995).

use super::direct::Direct;
use super::{GatherPoint, Gatherer, REPLICATES};
use crate::follow::{Path, Via};
use crate::lights::{beyond, mis_weight};
use crate::sampling::{cosine_hemisphere, seeds, sobol, uniform};
use azulejo_scene::Rgb;
use azulejo_scene::math::Frame;
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, PI};
use std::ops::Range;

impl Direct<'_> {
    /// Adds the light of the environments, one estimate per replicate, from two shadow rays for
    /// each of `rays`.
    pub(super) fn add_environments(
        &mut self,
        points: &[GatherPoint],
        rays: Range<u32>,
        seed: u32,
        add: impl FnMut(usize, usize, Rgb),
    ) {
        if !self.lights.outside.has_environments() {
            return;
        }
        let (first, count) = (rays.start, rays.end - rays.start);
        let mut values = Vec::new();
        self.tests.clear();
        for (index, point) in points.iter().enumerate() {
            for r in 0..REPLICATES as u32 {
                let s = [0xe0, 0xe1].map(|k| seeds(&[seed, point.key, k, r / 2]));
                for k in 0..count {
                    let k = 2 * first + r % 2 * count + k;
                    let u = |d: usize| f64::from(sobol(k, d % 3, s[d / 3][d % 3]));
                    let by_sky = self.sky_direction([u(0), u(1), u(2)]);
                    let by_cosine = self.hemisphere_direction(point, [u(3), u(4)]);
                    for direction in [by_sky, by_cosine].into_iter().flatten() {
                        // Each of the two was sampled once, so the densities add up.
                        let value = self.through(point, direction) / f64::from(count);
                        self.plan_environment(point, direction, (index, r), value, &mut values);
                    }
                }
            }
        }
        self.add_visible(&values, add);
    }

    /// Adds one estimate of the light of the environments per point, from one shadow ray each.
    pub(super) fn add_environment_samples(
        &mut self,
        points: &[GatherPoint],
        seed: u32,
        mut add: impl FnMut(usize, Rgb),
    ) {
        if !self.lights.outside.has_environments() {
            return;
        }
        let mut values = Vec::new();
        self.tests.clear();
        for (index, point) in points.iter().enumerate() {
            let u = |d: u32| f64::from(uniform(&[seed, point.key, d]));
            let direction = if u(3) < 0.5 {
                self.sky_direction([u(4), u(5), u(6)])
            } else {
                self.hemisphere_direction(point, [u(4), u(5)])
            };
            if let Some(direction) = direction {
                let value = self.through(point, direction) * 2.0;
                self.plan_environment(point, direction, (index, 0), value, &mut values);
            }
        }
        self.add_visible(&values, |index, _, value| add(index, value));
    }

    fn sky_direction(&self, u: [f64; 3]) -> Option<DVec3> {
        Some(self.lights.outside.sample_environment(u)?.0)
    }

    fn hemisphere_direction(&self, point: &GatherPoint, u: [f64; 2]) -> Option<DVec3> {
        let local = cosine_hemisphere(u[0], u[1]);
        Some(Frame::from_normal(point.normal).to_world(local))
    }

    /// Irradiance that the light from a direction stands for, if both ways of sampling it were
    /// taken once.
    fn through(&self, point: &GatherPoint, direction: DVec3) -> Rgb {
        let cos = direction.dot(point.normal);
        if cos <= 0.0 {
            return Rgb::BLACK;
        }
        let outside = &self.lights.outside;
        let density = cos * FRAC_1_PI + outside.environment_pdf(direction);
        outside.environment(direction) * (cos / density)
    }

    fn plan_environment(
        &mut self,
        point: &GatherPoint,
        direction: DVec3,
        (index, replicate): (usize, u32),
        value: Rgb,
        values: &mut Vec<(usize, Rgb)>,
    ) {
        if value.max_channel() > 0.0 {
            let first = self.tests.planned();
            let from = self.surfaces.tracer.leaving(point.position, point.normal);
            let to = beyond(self.surfaces, point.position, direction);
            self.tests.push_segment(from, to);
            self.tests.keep(first, values.len() as u32, replicate, 1.0);
            values.push((index, value));
        }
    }

    /// Traces the planned rays and passes on what arrives of what they stand for.
    pub(super) fn add_visible(
        &mut self,
        values: &[(usize, Rgb)],
        mut add: impl FnMut(usize, usize, Rgb),
    ) {
        let (tracer, incident) = (self.surfaces.tracer, &mut self.incident);
        self.tests.trace(|test, share, ray| {
            if !share.is_black() {
                let (index, value) = values[test.tag as usize];
                let replicate = test.replicate as usize;
                incident.add(
                    index,
                    replicate..replicate + 1,
                    value * share,
                    (tracer, ray),
                );
                add(index, replicate, value * share);
            }
        });
    }
}

impl Gatherer<'_> {
    /// Whether light comes from the surroundings, or from suns that subtend an angle.
    pub fn has_surroundings(&self) -> bool {
        !self.ambient().is_black() || !self.lights().outside.is_empty()
    }

    /// Exitance πL of the surroundings that a path finds where it leaves the scene, W/m², beyond
    /// what [`direct`](Gatherer::direct) counts.
    ///
    /// Directions sampled from a glossy surface are weighted against [`NextEvent`](super::NextEvent).
    /// Mirrors and glass show no suns but those in flat mirrors, which the direct light counts: a
    /// path would hit the small disc too seldom.
    pub fn escaped_exitance(&self, path: &Path) -> Rgb {
        let ambient = self.ambient();
        let outside = &self.lights().outside;
        if outside.is_empty() || path.via == Via::Direct {
            return ambient * PI;
        }
        let ray = self.surfaces().tracer.world_ray(&path.leg.ray);
        let direction = ray.direction.normalize_or_zero();
        let radiance = if path.density > 0.0 {
            let weight = mis_weight(path.density.into(), outside.pdf(direction));
            outside.radiance(direction) * weight
        } else {
            outside.environment(direction)
        };
        (ambient + radiance) * PI
    }
}
