//! Direct light of many lamps: samples of lamps that are chosen in proportion to what they would
//! give if nothing stood between.
//!
//! At a single point the terms are those of [`Direct::terms_of`], sampled instead of tested one by
//! one. Over a surface, formulas at a few points give what every lamp, and every image of one in a
//! mirror, would contribute. What stands between is found by shadow rays from points all over the
//! surface: one ray a point, in five dimensions. Either way the share that is visible serves as a
//! control variate, so that a surface that sees all or nothing of the lamps has no error but that
//! of the few points.

use super::direct::{Direct, MOST_TERMS};
use super::light_clusters::LightClusters;
use super::terms::{FlatSource, Term, ratio_of_others};
use super::{DirectLight, GatherPoint, REPLICATES};
use crate::sampling::{cumulative_sums, hash, sample_discrete, seeds, sobol};
use azulejo_scene::Rgb;
use std::borrow::Borrow;
use std::f64::consts::PI;

/// Points on a surface: as many for each replicate, one replicate after the other.
pub struct SurfaceSamples<'p> {
    /// Where formulas are evaluated.
    pub formulas: &'p [GatherPoint],
    /// Where shadow rays begin.
    pub rays: &'p [GatherPoint],
    /// How many shadow rays of each replicate's sequence came before these.
    pub before: u32,
}

impl Direct<'_> {
    /// Direct light of a point from the terms of very many sources: samples of sources chosen in
    /// proportion to what they would give, evenly spaced over all of it. Unbiased.
    pub(super) fn sample_terms(
        &mut self,
        index: usize,
        point: &GatherPoint,
        terms: &[Term],
        rays: u32,
        seed: u32,
    ) -> [Rgb; REPLICATES] {
        let cumulative = cumulative(terms);
        let known: Rgb = terms.iter().filter(|t| !t.is_rough()).map(|t| t.full).sum();
        self.sample_chosen((index, point), known, rays, seed, |[c, _]| {
            choose(terms, &cumulative, c)
        })
    }

    /// The same of the lights in groups.
    pub(super) fn sample_groups(
        &mut self,
        index: usize,
        point: &GatherPoint,
        groups: &LightClusters,
        rays: u32,
        seed: u32,
    ) -> [Rgb; REPLICATES] {
        let cumulative = groups.cumulative(point);
        let among = (self.lights, self.surfaces);
        self.sample_chosen((index, point), Rgb::BLACK, rays, hash(&[seed, 0x67]), |u| {
            groups.choose(&cumulative, among, point, u)
        })
    }

    /// Direct light of a point from the terms, each with its probability, that `choose` makes of two numbers in 0..1.
    /// `known` is the sum of all those whose light formulas know.
    fn sample_chosen<T: Borrow<Term>>(
        &mut self,
        (index, point): (usize, &GatherPoint),
        known: Rgb,
        rays: u32,
        seed: u32,
        choose: impl Fn([f64; 2]) -> Option<(T, f64)>,
    ) -> [Rgb; REPLICATES] {
        let count = (4 * rays).max(MOST_TERMS as u32 / 2);
        self.tests.clear();
        let mut values = Vec::new();
        for r in 0..REPLICATES as u32 {
            let s = seeds(&[seed, r]);
            for k in 0..count {
                let [c, u1, u2, m] = [0, 1, 2, 3].map(|d| f64::from(sobol(k, d, s[d])));
                let Some((term, probability)) = choose([c, m]) else {
                    continue;
                };
                let (term, tag) = (term.borrow(), values.len() as u32);
                if let Some(weight) = self.plan(point, tag, r, &term.target, (u1, u2)) {
                    let value = term.unbiased(weight) / (probability * f64::from(count));
                    values.push((value, term.is_rough()));
                }
            }
        }
        self.visible_light(Some(index), &values, [known; REPLICATES])
    }

    /// Mean direct light of flat emitters over a surface, one estimate per replicate.
    pub(super) fn over(&mut self, samples: &SurfaceSamples, seed: u32) -> DirectLight {
        let sources = self.flat_sources();
        let (known, cumulative) = self.known(&sources, samples.formulas);
        let mut light = DirectLight::default();
        self.tests.clear();
        let mut values = Vec::with_capacity(samples.rays.len());
        let each = samples.rays.len() / REPLICATES;
        for (index, point) in samples.rays.iter().enumerate() {
            let (r, k) = (index / each, samples.before + (index % each) as u32);
            let [s1, s2, s3, ..] = seeds(&[hash(&[seed, r as u32]), 0xc0]);
            let [c, u1, u2] = [(2, s1), (3, s2), (4, s3)].map(|(d, s)| f64::from(sobol(k, d, s)));
            let Some((chosen, probability)) = sample_discrete(&cumulative, c) else {
                return light;
            };
            let source = sources[chosen];
            let Some(target) = self.target(source, point) else {
                continue;
            };
            let tag = values.len() as u32;
            if let Some(weight) = self.plan(point, tag, r as u32, &target, (u1, u2)) {
                let value = self.radiance(source) * (weight / (probability * each as f64));
                values.push((value, false));
            }
        }
        light.lamps.replicates = self.visible_light(None, &values, known);
        light
    }

    /// All flat emitters, straight and in each window.
    fn flat_sources(&self) -> Vec<FlatSource> {
        let windows = 0..self.sources.windows.len();
        let windows = std::iter::once(None).chain(windows.map(Some));
        let lamps = 0..self.sources.flat(self.lights).len();
        windows
            .flat_map(|window| lamps.clone().map(move |lamp| FlatSource { lamp, window }))
            .collect()
    }

    /// Irradiance per replicate if nothing stood between, and the cumulative sums of what each source
    /// gives, by which they are chosen.
    fn known(
        &self,
        sources: &[FlatSource],
        points: &[GatherPoint],
    ) -> ([Rgb; REPLICATES], Vec<f64>) {
        let each = points.len() / REPLICATES;
        let (mut known, mut cumulative) =
            ([Rgb::BLACK; REPLICATES], Vec::with_capacity(sources.len()));
        let mut sum = 0.0;
        for &source in sources {
            let radiance = self.radiance(source);
            for (index, point) in points.iter().enumerate() {
                let full = radiance * (PI * self.form_factor(source, point) / each as f64);
                known[index / each] += full;
                sum += full.max_channel();
            }
            cumulative.push(sum);
        }
        (known, cumulative)
    }

    /// Traces the planned tests, whose tags are indices of `values`: what each gives, and whether
    /// no formula knows the sum of its kind. `known` is the sum of those that formulas know. All are of the point
    /// `index`, if of one.
    fn visible_light(
        &mut self,
        index: Option<usize>,
        values: &[(Rgb, bool)],
        known: [Rgb; REPLICATES],
    ) -> [Rgb; REPLICATES] {
        let mut sums = SampleSums::default();
        let (tracer, incident) = (self.surfaces.tracer, &mut self.incident);
        self.tests.trace(|test, share, ray| {
            let (value, is_rough) = values[test.tag as usize];
            let replicate = test.replicate as usize;
            sums.add(replicate, value, is_rough, share);
            if let Some(index) = index {
                let replicates = replicate..replicate + 1;
                incident.add(index, replicates, value * share, (tracer, ray));
            }
        });
        std::array::from_fn(|r| sums.irradiance(r, known[r]))
    }
}

/// What samples of many sources found, per replicate.
#[derive(Default)]
struct SampleSums {
    all: [Rgb; REPLICATES],
    seen: [Rgb; REPLICATES],
    /// What was seen of sources whose sum no formula knows.
    rough: [Rgb; REPLICATES],
}

impl SampleSums {
    fn add(&mut self, r: usize, value: Rgb, is_rough: bool, share: Rgb) {
        let seen = value * share;
        if is_rough {
            self.rough[r] += seen;
        } else {
            self.all[r] += value;
            self.seen[r] += seen;
        }
    }

    /// The estimate of a replicate, as [`Term::visible_share`] does it; `known` is the sum of all.
    fn irradiance(&self, r: usize, known: Rgb) -> Rgb {
        let grey = self.seen.map(|seen| Rgb::grey(seen.mean()));
        let share = ratio_of_others(&grey, &self.all.map(Rgb::mean), r);
        known * share + (self.seen[r] - self.all[r] * share) + self.rough[r]
    }
}

/// The cumulative sums of the full irradiance of terms.
pub(super) fn cumulative(terms: &[Term]) -> Vec<f64> {
    cumulative_sums(terms.iter().map(|term| term.full.max_channel()))
}

/// A term chosen by `u` in 0..1 in proportion to its full irradiance, and its probability, from the cumulative sums of
/// the terms.
pub(super) fn choose<'t>(terms: &'t [Term], cumulative: &[f64], u: f64) -> Option<(&'t Term, f64)> {
    let (chosen, _) = sample_discrete(cumulative, u)?;
    let term = &terms[chosen];
    // Its own share has not lost what a difference of sums loses.
    Some((term, term.full.max_channel() / cumulative.last()?))
}
