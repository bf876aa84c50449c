//! Direct light at points: exact formulas where nothing stands between, shadow rays where
//! something may.
//!
//! The irradiance that a flat lamp would give if nothing stood between is Lambert's formula,
//! without noise; rays are spent only on the share of it that is visible. The estimate of that
//! share is weighted by the transport kernel cos θ cos θ′/r², whose mean the formula knows: a
//! control variate, so that a point that sees all or nothing of a lamp has no error at all.

use super::harmonics::IncidentSums;
use super::many_lights::{choose, cumulative};
use super::polygon::{LampShape, is_through, kernel, sample_lamp};
use super::shadow::ShadowTests;
use super::sources::DirectSources;
use super::terms::{Target, Term, TermTests};
use super::{DirectLight, GatherPoint, REPLICATES};
use crate::Surfaces;
use crate::lights::{Lights, beyond};
use crate::sampling::{hash, seeds, sobol, uniform};
use azulejo_scene::Rgb;
use azulejo_scene::math::reflect;
use glam::DVec3;
use std::ops::Range;

/// More terms than this at one point are sampled by importance instead of one by one.
pub(super) const MOST_TERMS: usize = 32;

/// Which shadow rays the points of a batch use.
#[derive(Clone, Debug)]
pub(super) enum ShadowRays {
    /// Each point those of these numbers, of a sequence of its own.
    Own(Range<u32>),
    /// Each point one, all of one sequence.
    Shared,
}

impl ShadowRays {
    /// Per point, replicate and source.
    fn of_point(&self) -> Range<u32> {
        match self {
            ShadowRays::Own(rays) => rays.clone(),
            ShadowRays::Shared => 0..1,
        }
    }
}

/// Computes the direct light of batches of points.
pub(super) struct Direct<'a> {
    pub(super) surfaces: &'a Surfaces<'a>,
    pub(super) lights: &'a Lights<'a>,
    pub(super) sources: &'a DirectSources,
    pub(super) tests: ShadowTests<'a>,
    /// Where the light of [`irradiance`](Direct::irradiance) comes from.
    pub(super) incident: IncidentSums,
}

impl<'a> Direct<'a> {
    pub(super) fn new(
        surfaces: &'a Surfaces<'a>,
        lights: &'a Lights<'a>,
        sources: &'a DirectSources,
    ) -> Direct<'a> {
        Direct {
            surfaces,
            lights,
            sources,
            tests: ShadowTests::new(surfaces.tracer),
            incident: IncidentSums::default(),
        }
    }

    /// Direct irradiance of each point, one estimate per replicate, from shadow rays number
    /// `rays` of every replicate and source.
    ///
    /// Always as many: to spend more where the first few disagree would favour what they saw.
    pub(super) fn irradiance(
        &mut self,
        points: &[GatherPoint],
        shadow_rays: ShadowRays,
        seed: u32,
    ) -> Vec<DirectLight> {
        let rays = shadow_rays.of_point();
        let mut sums = vec![DirectLight::default(); points.len()];
        let mut terms = Vec::new();
        let groups = self.sources.groups_alone(self.lights);
        // Collect the sources that may light each point; of very many, all but suns are sampled by importance.
        for (index, point) in points.iter().enumerate() {
            let start = terms.len();
            let count = rays.end - rays.start;
            let seed = hash(&[seed, point.key, rays.start]);
            self.terms_of(index as u32, point, groups, &mut terms);
            if terms.len() - start > MOST_TERMS {
                let many: Vec<Term> = terms.drain(start..).collect();
                sums[index].lamps.replicates = self.sample_terms(index, point, &many, count, seed);
            }
            if let Some(groups) = groups {
                let sampled = self.sample_groups(index, point, groups, count, seed);
                for (sum, sampled) in sums[index].lamps.replicates.iter_mut().zip(sampled) {
                    *sum += sampled;
                }
            }
            self.sun_terms_of(index as u32, point, &mut terms);
        }
        // Trace the shadow rays of all points together.
        let tests = self.test_terms(points, &terms, &shadow_rays, seed);
        for (term, tests) in terms.iter().zip(&tests) {
            let at = term.point as usize;
            let sum = &mut sums[at];
            let cap = self.cap_of(term, &points[at]);
            if term.is_delta() {
                let light = term.full * term.visible_share(tests, 0);
                self.incident
                    .add_cap(at, 0..REPLICATES, light, cap.as_ref());
                sum.lights += light;
                continue;
            }
            let sum = if term.is_sun() {
                &mut sum.outside
            } else {
                &mut sum.lamps
            };
            // Scale what formulas give by the visible share; where they are rough, samples alone count.
            let share = 1.0 / f64::from(tests.samples.max(1));
            for (r, sum) in sum.replicates.iter_mut().enumerate() {
                *sum += if term.is_rough() {
                    term.radiance * tests.visible[r] * share
                } else {
                    let light = term.full * term.visible_share(tests, r);
                    self.incident.add_cap(at, r..r + 1, light, cap.as_ref());
                    light
                };
            }
        }
        // Add what has no formula at all: surfaces that emit pictures, and environments.
        self.add_pictures(points, rays.clone(), seed, |index, replicate, value| {
            sums[index].lamps.replicates[replicate] += value;
        });
        self.add_environments(points, rays, seed, |index, replicate, value| {
            sums[index].outside.replicates[replicate] += value;
        });
        sums
    }

    /// One estimate of the direct light per point, from one shadow test each, and one for
    /// environments: unbiased, noisy.
    pub(super) fn single_sample(&mut self, points: &[GatherPoint], seed: u32) -> Vec<Rgb> {
        let mut values = vec![Rgb::BLACK; points.len()];
        let mut terms = Vec::new();
        let clusters = self.sources.clusters.as_ref();
        let flat = self.sources.flat(self.lights);
        let lone_lamp = self.sources.is_lone_lamp(self.lights);
        self.tests.clear();
        for (index, point) in points.iter().enumerate() {
            if lone_lamp {
                // There is nothing to choose, so that what it would give need not be known.
                let u = [1, 2].map(|d| f64::from(uniform(&[seed, point.key, d])));
                let weight = self.plan(point, index as u32, 0, &Target::Flat(0), (u[0], u[1]));
                values[index] = flat[0].emission.radiance * weight.unwrap_or(0.0);
                continue;
            }
            terms.clear();
            self.terms_of(index as u32, point, clusters, &mut terms);
            self.sun_terms_of(index as u32, point, &mut terms);
            let chance = |d: u32| f64::from(uniform(&[seed, point.key, d]));
            if let ([term], None) = (&terms[..], clusters) {
                let weight =
                    self.plan(point, index as u32, 0, &term.target, (chance(1), chance(2)));
                values[index] = weight.map_or(Rgb::BLACK, |weight| term.unbiased(weight));
                continue;
            }
            let of_terms = cumulative(&terms);
            let of_clusters = clusters.map_or(Vec::new(), |clusters| clusters.cumulative(point));
            let [terms_sum, clusters_sum] =
                [&of_terms, &of_clusters].map(|sums| sums.last().copied().unwrap_or(0.0));
            let share = clusters_sum / (clusters_sum + terms_sum).max(f64::MIN_POSITIVE);
            let u = (chance(1), chance(2));
            if let Some(clusters) = clusters.filter(|_| chance(0) < share) {
                let u_of_light = [chance(0) / share, chance(3)];
                let among = (self.lights, self.surfaces);
                if let Some((term, probability)) =
                    clusters.choose(&of_clusters, among, point, u_of_light)
                    && let Some(weight) = self.plan(point, index as u32, 0, &term.target, u)
                {
                    values[index] = term.unbiased(weight) / (probability * share);
                }
                continue;
            }
            let of_term = (chance(0) - share) / (1.0 - share);
            if let Some((term, probability)) = choose(&terms, &of_terms, of_term)
                && let Some(weight) = self.plan(point, index as u32, 0, &term.target, u)
            {
                values[index] = term.unbiased(weight) / (probability * (1.0 - share));
            }
        }
        let mut seen = vec![Rgb::BLACK; points.len()];
        self.tests
            .trace(|test, share, _| seen[test.tag as usize] = share);
        for (value, seen) in values.iter_mut().zip(seen) {
            *value *= seen;
        }
        self.add_picture_samples(points, seed, |index, value| values[index] += value);
        self.add_environment_samples(points, seed, |index, value| values[index] += value);
        values
    }

    /// Plans the shadow test of one sample of a target and returns its weight, kernel over
    /// density; `None` if the sample cannot light the point.
    pub(super) fn plan(
        &mut self,
        point: &GatherPoint,
        tag: u32,
        replicate: u32,
        target: &Target,
        u: (f64, f64),
    ) -> Option<f64> {
        let first = self.tests.planned();
        let from = self.surfaces.tracer.leaving(point.position, point.normal);
        let windows = &self.sources.windows;
        // Sample a point of what has an area; by way of a mirror, test both legs of the path to its image.
        let weight = match target {
            Target::Flat(k) => {
                let lamp = &self.lights.flat()[*k as usize];
                let polygon = lamp.toward(point.position);
                let lamp = LampShape {
                    polygon: &polygon,
                    normal: lamp.normal_toward(point.position),
                    area: lamp.area,
                    centre: lamp.centre,
                    radius: lamp.radius,
                };
                let (y, weight) = sample_lamp(point, &lamp, u)?;
                self.tests.push_segment(from, self.in_front(y, &lamp));
                weight
            }
            Target::Image { window, seen } => {
                let lamp = LampShape::new(seen);
                let (y, weight) = sample_lamp(point, &lamp, u)?;
                let image = self.in_front(y, &lamp);
                let window = &windows[*window as usize];
                self.tests.push_reflected(from, image, window);
                weight
            }
            Target::Curved(k) => {
                let light = &self.lights.curved[*k as usize];
                let mut y = light.point(u);
                // A surface that emits on both sides shines toward the point from the side that faces it.
                let is_behind = y.normal.dot(point.position - y.position) < 0.0;
                if light.emission.emits_back && is_behind {
                    y.normal = -y.normal;
                }
                let target = self.surfaces.tracer.leaving(y.position, y.normal);
                self.tests.push_segment(from, target);
                kernel(point, y.position, y.normal) * y.area
            }
            Target::Delta(target) => {
                self.tests.push_segment(from, *target);
                1.0
            }
            Target::DeltaImage { window, image } => {
                let window = &windows[*window as usize];
                self.tests.push_reflected(from, *image, window);
                1.0
            }
            Target::Sun(k) => {
                let sun = &self.lights.outside.suns[*k as usize];
                let direction = sun.sample([u.0, u.1]);
                let far = beyond(self.surfaces, point.position, direction);
                self.tests.push_segment(from, far);
                direction.dot(point.normal) / direction.dot(sun.toward())
            }
            Target::SunImage { window, sun } => {
                let sun = &self.lights.outside.suns[*sun as usize];
                let window = &windows[*window as usize];
                let direction = sun.sample([u.0, u.1]);
                let seen = reflect(direction, window.normal);
                let image = beyond(self.surfaces, point.position, seen);
                // A window may show a part of the sun's image only, and samples beside it give nothing.
                if !is_through(point.position, image, &window.polygon) {
                    return None;
                }
                self.tests.push_reflected(from, image, window);
                seen.dot(point.normal) / direction.dot(sun.toward())
            }
        };
        self.tests.keep(first, tag, replicate, weight)
    }

    /// A point just before a point of a lamp, so that short shadow rays, too, end before it.
    fn in_front(&self, y: DVec3, lamp: &LampShape) -> DVec3 {
        self.surfaces.tracer.leaving(y, lamp.normal)
    }

    /// Tests what of every term is visible, by samples `rays` of each replicate: consecutive
    /// stretches of one sequence per half of the replicates, so that each half can judge the
    /// other without bias.
    fn test_terms(
        &mut self,
        points: &[GatherPoint],
        terms: &[Term],
        rays: &ShadowRays,
        seed: u32,
    ) -> Vec<TermTests> {
        let (of_point, is_shared) = (rays.of_point(), matches!(rays, ShadowRays::Shared));
        let (first, rays) = (of_point.start, of_point.end - of_point.start);
        // The number of a term among those of its point.
        let (mut point_before, mut number) = (u32::MAX, 0);
        let mut term_tests = vec![TermTests::default(); terms.len()];
        self.tests.clear();
        for (t, term) in terms.iter().enumerate() {
            let point = &points[term.point as usize];
            number = if term.point == point_before {
                number + 1
            } else {
                0
            };
            point_before = term.point;
            // A light without area is one point, so one ray decides.
            let (replicates, count) = if term.is_delta() {
                (1, 1)
            } else {
                (REPLICATES as u32, rays)
            };
            term_tests[t].samples = count;
            for r in 0..replicates {
                let s = if is_shared {
                    seeds(&[seed, points[0].key, number, r / 2])
                } else {
                    seeds(&[seed, point.key, (t as u32) ^ (term.point << 16), r / 2])
                };
                for k in 0..count {
                    let k = if is_shared {
                        r % 2 * points.len() as u32 + term.point
                    } else {
                        2 * first + r % 2 * count + k
                    };
                    let u = (f64::from(sobol(k, 0, s[0])), f64::from(sobol(k, 1, s[1])));
                    self.plan(point, t as u32, r, &term.target, u);
                }
            }
        }
        let (tracer, incident) = (self.surfaces.tracer, &mut self.incident);
        self.tests.trace(|test, share, ray| {
            let of_term = &mut term_tests[test.tag as usize];
            let replicate = test.replicate as usize;
            of_term.weights[replicate] += test.weight;
            of_term.visible[replicate] += share * test.weight;
            let term = &terms[test.tag as usize];
            // Where formulas know the irradiance, they know where it comes from.
            if term.is_rough() {
                let light = term.radiance * share * (test.weight / f64::from(of_term.samples));
                let replicates = replicate..replicate + 1;
                incident.add(term.point as usize, replicates, light, (tracer, ray));
            }
        });
        term_tests
    }
}
