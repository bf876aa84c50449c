//! Direct light at points: exact formulas where nothing stands between, shadow rays where
//! something may.
//!
//! The irradiance that a flat lamp would give if nothing stood between is Lambert's formula,
//! without noise; rays are spent only on the share of it that is visible. The estimate of that
//! share is weighted by the transport kernel cos θ cos θ′/r², whose mean the formula knows: a
//! control variate, so that a point that sees all or nothing of a lamp has no error at all.

use super::emitters::Emitters;
use super::{DirectLight, GatherPoint, REPLICATES};
use crate::lambert::{
    ArrayPolygon, clip, clip_to_window, is_in_front, mirror_point, point_to_polygon,
};
use crate::sampling::{cosine_about, hash, seeds, sobol, uniform};
use crate::{KernelRay, Surfaces};
use azulejo_scene::math::{Frame, Ray, area_vector};
use azulejo_scene::{LightKind, Rgb};
use glam::DVec3;
use std::f64::consts::PI;
use std::ops::Range;

/// Shadow rays end this share of their length before the lamp, so that they don't meet it.
const SHORT: f64 = 1.0 - 1e-4;

/// More terms than this at one point are sampled by importance instead of one by one.
pub(super) const MOST_TERMS: usize = 32;

/// One source of direct light at one point.
struct Term {
    point: u32,
    /// Irradiance if nothing stood between.
    full: Rgb,
    /// Radiance of the lamp as it arrives; black for lights without area.
    radiance: Rgb,
    source: Source,
    /// Sums of weights and of visible weights per replicate.
    weights: [f64; REPLICATES],
    visible: [f64; REPLICATES],
    /// Samples per replicate, those without weight included.
    samples: u32,
}

enum Source {
    /// A lamp, or what of it is above the horizon; its number among the lamps.
    Lamp(u32),
    /// The part of a lamp's image that a window shows.
    Image {
        window: u32,
        seen: Box<ArrayPolygon>,
    },
    /// A curved lamp, by its number; nothing but samples tells what it gives.
    Globe(u32),
    /// A light without area: one place decides.
    Place(DVec3),
    /// A light without area by way of a window; the place of its image.
    PlaceImage { window: u32, image: DVec3 },
}

/// A planned shadow test: `count` rays from `first`, all of which must be free.
pub(super) struct Test {
    pub term: u32,
    pub replicate: u32,
    weight: f64,
    first: u32,
    count: u32,
}

/// Computes the direct light of batches of points.
pub(super) struct Direct<'a> {
    pub(super) surfaces: &'a Surfaces<'a>,
    pub(super) emitters: &'a Emitters<'a>,
    rays: Vec<KernelRay>,
    blocked: Vec<bool>,
    tests: Vec<Test>,
}

impl<'a> Direct<'a> {
    pub(super) fn new(surfaces: &'a Surfaces<'a>, emitters: &'a Emitters<'a>) -> Direct<'a> {
        Direct {
            surfaces,
            emitters,
            rays: Vec::new(),
            blocked: Vec::new(),
            tests: Vec::new(),
        }
    }

    /// Direct irradiance of each point, one estimate per replicate, from shadow rays number
    /// `rays` of every replicate and source.
    ///
    /// Always as many: to spend more where the first few disagree would favour what they saw.
    pub(super) fn irradiance(
        &mut self,
        points: &[GatherPoint],
        rays: Range<u32>,
        seed: u32,
    ) -> Vec<DirectLight> {
        let mut sums = vec![DirectLight::default(); points.len()];
        let mut terms = Vec::new();
        for (index, point) in points.iter().enumerate() {
            let start = terms.len();
            self.terms_of(index as u32, point, &mut terms);
            if terms.len() - start > MOST_TERMS {
                let crowd: Vec<Term> = terms.drain(start..).collect();
                sums[index].lamps.replicates = self.pick(
                    point,
                    &crowd,
                    rays.end - rays.start,
                    hash(&[seed, point.key, rays.start]),
                );
            }
        }
        self.test_terms(points, &mut terms, rays, seed);
        for term in &terms {
            let sum = &mut sums[term.point as usize];
            if term.is_place() {
                sum.lights += term.full * term.visible_share(0);
            } else if term.is_rough() {
                let share = 1.0 / f64::from(term.samples.max(1));
                (0..REPLICATES).for_each(|r| {
                    sum.lamps.replicates[r] += term.radiance * (term.visible[r] * share)
                });
            } else {
                (0..REPLICATES)
                    .for_each(|r| sum.lamps.replicates[r] += term.full * term.visible_share(r));
            }
        }
        sums
    }

    /// One estimate of the direct light per point, from one shadow test each: unbiased, noisy.
    pub(super) fn glimpse(&mut self, points: &[GatherPoint], seed: u32) -> Vec<Rgb> {
        let mut values = vec![Rgb::BLACK; points.len()];
        let mut terms = Vec::new();
        self.tests.clear();
        self.rays.clear();
        for (index, point) in points.iter().enumerate() {
            terms.clear();
            self.terms_of(index as u32, point, &mut terms);
            let chance = uniform(&[seed, point.key, 0]);
            if let Some((term, probability)) = choose(&terms, f64::from(chance)) {
                let [u1, u2] = [1, 2].map(|d| f64::from(uniform(&[seed, point.key, d])));
                if let Some(value) = self.plan(point, index as u32, 0, term, (u1, u2)) {
                    values[index] = unbiased(term, value) / probability;
                }
            }
        }
        self.surfaces.tracer.any(&self.rays, &mut self.blocked);
        let mut seen = vec![false; points.len()];
        for test in &self.tests {
            seen[test.term as usize] = self.is_free(test);
        }
        values
            .iter()
            .zip(seen)
            .map(|(&v, s)| if s { v } else { Rgb::BLACK })
            .collect()
    }

    /// All sources that could light `point`, with the irradiance they would give.
    fn terms_of(&self, index: u32, point: &GatherPoint, terms: &mut Vec<Term>) {
        let mut push = |full: Rgb, radiance: Rgb, source: Source| {
            if full.max_channel() > 0.0 {
                let zero = [0.0; REPLICATES];
                terms.push(Term {
                    point: index,
                    full,
                    radiance,
                    source,
                    weights: zero,
                    visible: zero,
                    samples: 0,
                });
            }
        };
        let (p, n) = (point.position, point.normal);
        for (j, lamp) in self.emitters.lamps.iter().enumerate() {
            let f = point_to_polygon(p, n, &lamp.polygon);
            push(
                lamp.radiance * (PI * f),
                lamp.radiance,
                Source::Lamp(j as u32),
            );
        }
        for (j, globe) in self.emitters.globes.iter().enumerate() {
            let d = globe.centre - p;
            let reach = d.dot(n) + globe.radius2.sqrt() * 3f64.sqrt();
            if reach > 0.0 {
                // Only a guide to where rays are worth spending.
                let rough = PI * (globe.radius2 / d.length_squared()).min(1.0);
                push(
                    globe.radiance * rough,
                    globe.radiance,
                    Source::Globe(j as u32),
                );
            }
        }
        for light in &self.emitters.lights {
            if let Some((place, full)) = unoccluded(light, p, n, self.surfaces) {
                push(full, Rgb::BLACK, Source::Place(place));
            }
        }
        for (w, window) in self.emitters.windows.iter().enumerate() {
            let side = (p - window.polygon[0]).dot(window.normal);
            for (image, lamp) in window.images.iter().zip(&self.emitters.lamps) {
                if is_hidden(point, image, &window.polygon) {
                    continue;
                }
                // Only what of the lamp is on the point's side of the mirror has an image there,
                // and that image lies on the other side.
                let beyond = clip(image, window.polygon[0], -side.signum() * window.normal);
                let seen = clip_to_window(&beyond, p, &window.polygon);
                let f = if seen.len() < 3 {
                    0.0
                } else {
                    point_to_polygon(p, n, &seen)
                };
                if f > 0.0 {
                    let radiance = lamp.radiance * window.reflectance;
                    push(
                        radiance * (PI * f),
                        radiance,
                        Source::Image {
                            window: w as u32,
                            seen: Box::new(seen),
                        },
                    );
                }
            }
            for light in &self.emitters.lights {
                let lit =
                    unoccluded_image(light, p, n, window.polygon[0], window.normal, self.surfaces);
                if let Some((image, full)) =
                    lit.filter(|(image, _)| is_through(p, *image, &window.polygon))
                {
                    push(
                        full * window.reflectance,
                        Rgb::BLACK,
                        Source::PlaceImage {
                            window: w as u32,
                            image,
                        },
                    );
                }
            }
        }
    }

    /// Plans the shadow test of one sample of a term and returns its weight, kernel over density;
    /// `None` if the sample can't light the point.
    fn plan(
        &mut self,
        point: &GatherPoint,
        tag: u32,
        replicate: u32,
        term: &Term,
        u: (f64, f64),
    ) -> Option<f64> {
        let first = self.rays.len() as u32;
        let from = self.surfaces.tracer.leaving(point.position, point.normal);
        let weight = match &term.source {
            Source::Lamp(j) => {
                let polygon = &self.emitters.lamps[*j as usize].polygon;
                let (y, weight) = aim(point, polygon, u)?;
                self.push_segment(from, self.in_front(y, polygon));
                weight
            }
            Source::Image { window, seen } => {
                let (y, weight) = aim(point, seen, u)?;
                self.push_reflected(from, self.in_front(y, seen), *window);
                weight
            }
            Source::Globe(j) => {
                let globe = &self.emitters.globes[*j as usize];
                let mut y = globe.primitive.point(globe.part, u.0, u.1);
                if globe.emits_back && y.normal.dot(point.position - y.position) < 0.0 {
                    y.normal = -y.normal;
                }
                self.push_segment(from, self.surfaces.tracer.leaving(y.position, y.normal));
                kernel(point, y.position, y.normal) * y.area_density
            }
            Source::Place(place) => {
                self.push_segment(from, *place);
                1.0
            }
            Source::PlaceImage { window, image } => {
                self.push_reflected(from, *image, *window);
                1.0
            }
        };
        self.keep(first, tag, replicate, weight)
    }

    /// Forgets all tests.
    pub(super) fn forget(&mut self) {
        self.tests.clear();
        self.rays.clear();
    }

    /// Number of the next ray.
    pub(super) fn planned(&self) -> u32 {
        self.rays.len() as u32
    }

    /// Makes a test of the rays from `first` on, if they can tell anything; returns the weight.
    pub(super) fn keep(
        &mut self,
        first: u32,
        tag: u32,
        replicate: u32,
        weight: f64,
    ) -> Option<f64> {
        let count = self.planned() - first;
        if weight > 0.0 && count > 0 {
            self.tests.push(Test {
                term: tag,
                replicate,
                weight,
                first,
                count,
            });
            return Some(weight);
        }
        self.rays.truncate(first as usize);
        None
    }

    /// Traces all tests and tells of each whether nothing stands between.
    pub(super) fn ask(&mut self, mut tell: impl FnMut(&Test, bool)) {
        self.surfaces.tracer.any(&self.rays, &mut self.blocked);
        for test in &self.tests {
            tell(test, self.is_free(test));
        }
    }

    /// A place just before a point of a lamp, so that short shadow rays, too, end before it.
    pub(super) fn in_front(&self, y: DVec3, polygon: &[DVec3]) -> DVec3 {
        self.surfaces
            .tracer
            .leaving(y, area_vector(polygon).normalize_or_zero())
    }

    pub(super) fn push_segment(&mut self, from: DVec3, to: DVec3) {
        let ray = Ray {
            t_max: SHORT,
            ..Ray::between(from, to)
        };
        self.rays.push(self.surfaces.tracer.kernel_ray(&ray));
    }

    /// Both legs of the way to a point behind a mirror.
    pub(super) fn push_reflected(&mut self, from: DVec3, image: DVec3, window: u32) {
        let window = &self.emitters.windows[window as usize];
        let (here, there) = (
            (from - window.polygon[0]).dot(window.normal),
            (image - window.polygon[0]).dot(window.normal),
        );
        if here * there >= 0.0 {
            return;
        }
        let at = from + (image - from) * (here / (here - there));
        let target = mirror_point(image, window.polygon[0], window.normal);
        let before = self
            .surfaces
            .tracer
            .leaving(at, window.normal * here.signum());
        self.push_segment(from, before);
        self.push_segment(before, target);
    }

    fn is_free(&self, test: &Test) -> bool {
        (test.first..test.first + test.count).all(|k| !self.blocked[k as usize])
    }

    /// Tests what of every term is visible, by samples `rays` of each replicate: consecutive
    /// stretches of one sequence per half of the replicates, so that each half can judge the
    /// other without bias.
    fn test_terms(
        &mut self,
        points: &[GatherPoint],
        terms: &mut [Term],
        rays: Range<u32>,
        seed: u32,
    ) {
        let (first, rays) = (rays.start, rays.end - rays.start);
        self.tests.clear();
        self.rays.clear();
        for (t, term) in terms.iter_mut().enumerate() {
            let point = &points[term.point as usize];
            // A light without area has one place, so one ray tells all.
            let (replicates, count) = if term.is_place() {
                (1, 1)
            } else {
                (REPLICATES as u32, rays)
            };
            term.samples = count;
            for r in 0..replicates {
                let s = seeds(&[seed, point.key, (t as u32) ^ (term.point << 16), r / 2]);
                for k in 0..count {
                    let k = 2 * first + r % 2 * count + k;
                    let u = (f64::from(sobol(k, 0, s[0])), f64::from(sobol(k, 1, s[1])));
                    self.plan(point, t as u32, r, term, u);
                }
            }
        }
        self.surfaces.tracer.any(&self.rays, &mut self.blocked);
        for test in &self.tests {
            let term = &mut terms[test.term as usize];
            term.weights[test.replicate as usize] += test.weight;
            if self.is_free(test) {
                term.visible[test.replicate as usize] += test.weight;
            }
        }
    }

    /// Direct light of a point with very many sources: samples of sources chosen in proportion
    /// to what they would give, evenly spaced over all of it. Unbiased.
    fn pick(
        &mut self,
        point: &GatherPoint,
        terms: &[Term],
        rays: u32,
        seed: u32,
    ) -> [Rgb; REPLICATES] {
        let count = (4 * rays).max(MOST_TERMS as u32 / 2);
        self.tests.clear();
        self.rays.clear();
        let mut values = Vec::new();
        for r in 0..REPLICATES as u32 {
            let s = seeds(&[seed, r]);
            for k in 0..count {
                let [c, u1, u2] = [0, 1, 2].map(|d| f64::from(sobol(k, d, s[d])));
                let Some((term, probability)) = choose(terms, c) else {
                    continue;
                };
                if let Some(weight) = self.plan(point, values.len() as u32, r, term, (u1, u2)) {
                    values.push((
                        unbiased(term, weight) / (probability * f64::from(count)),
                        term.is_rough(),
                    ));
                }
            }
        }
        self.surfaces.tracer.any(&self.rays, &mut self.blocked);
        let known: Rgb = terms.iter().filter(|t| !t.is_rough()).map(|t| t.full).sum();
        let mut sums = Picked::default();
        for test in &self.tests {
            sums.add(
                test.replicate as usize,
                values[test.term as usize],
                self.is_free(test),
            );
        }
        std::array::from_fn(|r| sums.irradiance(r, known))
    }
}

/// What the samples of a crowd of terms found, per replicate.
#[derive(Default)]
pub(super) struct Picked {
    all: [Rgb; REPLICATES],
    seen: [Rgb; REPLICATES],
    /// What was seen of terms whose sum no formula knows.
    rough: [Rgb; REPLICATES],
}

impl Picked {
    pub(super) fn add(&mut self, r: usize, (value, is_rough): (Rgb, bool), is_free: bool) {
        let seen = if is_free { value } else { Rgb::BLACK };
        if is_rough {
            self.rough[r] += seen;
        } else {
            self.all[r] += value;
            self.seen[r] += seen;
        }
    }

    /// The estimate of a replicate, as [`Term::visible_share`] does it; `known` is the sum of all.
    pub(super) fn irradiance(&self, r: usize, known: Rgb) -> Rgb {
        let share = ratio_of_others(&self.seen.map(Rgb::mean), &self.all.map(Rgb::mean), r);
        known * share + (self.seen[r] - self.all[r] * share) + self.rough[r]
    }
}

impl Term {
    /// Whether `full` is a guess.
    fn is_rough(&self) -> bool {
        matches!(self.source, Source::Globe(_))
    }

    /// Whether it is a light without area, of which one ray tells all.
    fn is_place(&self) -> bool {
        matches!(self.source, Source::Place(_) | Source::PlaceImage { .. })
    }

    /// The visible share as replicate `r` sees it.
    ///
    /// Formulas know the sum of all weights, so what the other half of the replicates found to
    /// be the visible share serves as a control variate: unbiased, because it is independent of
    /// this half, and exact where all or nothing is visible.
    fn visible_share(&self, r: usize) -> f64 {
        if self.is_place() {
            return if self.visible[0] > 0.0 { 1.0 } else { 0.0 };
        }
        let share = ratio_of_others(&self.visible, &self.weights, r);
        let sum = f64::from(self.samples) * self.full.max_channel() / self.radiance.max_channel();
        share + (self.visible[r] - share * self.weights[r]) / sum
    }
}

/// Σ parts / Σ wholes over the half of the replicates that `r` is not in; 1 without wholes.
fn ratio_of_others(parts: &[f64; REPLICATES], wholes: &[f64; REPLICATES], r: usize) -> f64 {
    let others = (0..REPLICATES).filter(|s| s / 2 != r / 2);
    let [part, whole] = [parts, wholes].map(|sums| others.clone().map(|s| sums[s]).sum::<f64>());
    if whole > 0.0 { part / whole } else { 1.0 }
}

/// A term chosen by `u` in 0..1 in proportion to its full irradiance, and its probability.
fn choose(terms: &[Term], u: f64) -> Option<(&Term, f64)> {
    let total: f64 = terms.iter().map(|t| t.full.max_channel()).sum();
    let mut rest = u * total;
    let last = terms.len().checked_sub(1)?;
    for (k, term) in terms.iter().enumerate() {
        let share = term.full.max_channel();
        if rest < share || k == last {
            return Some((term, share / total));
        }
        rest -= share;
    }
    None
}

/// Irradiance from one sample of a term and its weight.
fn unbiased(term: &Term, weight: f64) -> Rgb {
    if term.is_place() {
        term.full
    } else {
        term.radiance * weight
    }
}

/// A point of a lamp to look at, and kernel over density, its weight; `None` where `u` misses.
///
/// The density is even over the lamp. Near a lamp, where the kernel has a peak, half of the
/// samples follow the cosine's directions instead, which bounds the weight (Veach and Guibas
/// 1995, balance heuristic for one sample).
pub(super) fn aim(point: &GatherPoint, polygon: &[DVec3], u: (f64, f64)) -> Option<(DVec3, f64)> {
    let area = area_vector(polygon);
    let even = 1.0 / area.length();
    if !is_near(point.position, polygon) {
        let y = sample_polygon(polygon, u);
        return Some((y, kernel(point, y, area) / even));
    }
    let y = if u.0 < 0.5 {
        sample_polygon(polygon, (2.0 * u.0, u.1))
    } else {
        let direction = cosine_about(&Frame::from_normal(point.normal), 2.0 * u.0 - 1.0, u.1);
        meeting(point.position, direction, polygon, area)?
    };
    let kernel = kernel(point, y, area);
    Some((y, kernel / (0.5 * even + 0.5 * kernel / PI)))
}

/// Whether a point is nearer to a polygon than the polygon is wide.
fn is_near(p: DVec3, polygon: &[DVec3]) -> bool {
    let centre = polygon.iter().sum::<DVec3>() / polygon.len() as f64;
    let radius2 = polygon
        .iter()
        .map(|c| c.distance_squared(centre))
        .fold(0.0, f64::max);
    p.distance_squared(centre) < 4.0 * radius2
}

/// Where a ray meets a convex polygon of a normal of any length.
fn meeting(from: DVec3, direction: DVec3, polygon: &[DVec3], normal: DVec3) -> Option<DVec3> {
    let t = (polygon[0] - from).dot(normal) / direction.dot(normal);
    let at = from + t * direction;
    (t > 0.0 && is_inside(at, polygon, normal)).then_some(at)
}

/// Whether a point of a convex polygon's plane lies in it.
fn is_inside(at: DVec3, polygon: &[DVec3], normal: DVec3) -> bool {
    (0..polygon.len()).all(|k| {
        let (p, q) = (polygon[k], polygon[(k + 1) % polygon.len()]);
        (q - p).cross(at - p).dot(normal) >= 0.0
    })
}

/// cos θ cos θ′/r² between a point and a point on a polygon of area vector `area`; zero where
/// either turns its back.
fn kernel(point: &GatherPoint, y: DVec3, area: DVec3) -> f64 {
    let d = y - point.position;
    let r2 = d.length_squared();
    let (cos_p, cos_y) = (d.dot(point.normal), -d.dot(area.normalize_or_zero()));
    if cos_p > 0.0 && cos_y > 0.0 && r2 > 0.0 {
        cos_p * cos_y / (r2 * r2)
    } else {
        0.0
    }
}

/// A point of a convex polygon, uniform by area, continuous in `u` but for fan borders.
fn sample_polygon(polygon: &[DVec3], u: (f64, f64)) -> DVec3 {
    let o = polygon[0];
    let is_parallelogram = polygon.len() == 4
        && (polygon[1] + polygon[3] - polygon[0] - polygon[2]).length_squared()
            < 1e-18 * (polygon[2] - o).length_squared();
    if is_parallelogram {
        return o + u.0 * (polygon[1] - o) + u.1 * (polygon[3] - o);
    }
    let area = |k: usize| (polygon[k] - o).cross(polygon[k + 1] - o).length();
    let total: f64 = (1..polygon.len() - 1).map(area).sum();
    let mut rest = u.0 * total;
    let mut k = 1;
    while k + 2 < polygon.len() && rest >= area(k) {
        rest -= area(k);
        k += 1;
    }
    let a = (rest / area(k).max(f64::MIN_POSITIVE))
        .clamp(0.0, 1.0)
        .sqrt();
    o + a * (1.0 - u.1) * (polygon[k] - o) + a * u.1 * (polygon[k + 1] - o)
}

/// Place to test and irradiance at a point from a light without area, if it is above the
/// horizon.
pub(crate) fn unoccluded(
    light: &LightKind,
    p: DVec3,
    n: DVec3,
    surfaces: &Surfaces,
) -> Option<(DVec3, Rgb)> {
    match *light {
        LightKind::Point { position, .. } | LightKind::Spot { position, .. } => {
            let d = position - p;
            let r2 = d.length_squared();
            let cos = d.dot(n) / r2.sqrt();
            (cos > 0.0).then(|| {
                (
                    position,
                    light.intensity_toward(-d / r2.sqrt()) * (cos / r2),
                )
            })
        }
        LightKind::Directional {
            direction,
            irradiance,
        } => {
            let cos = -direction.dot(n);
            (cos > 0.0).then(|| (p - direction * far(surfaces, p), irradiance * cos))
        }
        LightKind::Ambient { .. } => None,
    }
}

/// The same by way of a mirror plane: place of the image, irradiance before the mirror's loss.
fn unoccluded_image(
    light: &LightKind,
    p: DVec3,
    n: DVec3,
    plane: DVec3,
    normal: DVec3,
    surfaces: &Surfaces,
) -> Option<(DVec3, Rgb)> {
    let flip = |d: DVec3| azulejo_scene::math::reflect(d, normal);
    let image = match *light {
        LightKind::Point {
            position,
            intensity,
        } => LightKind::Point {
            position: mirror_point(position, plane, normal),
            intensity,
        },
        LightKind::Spot {
            position,
            direction,
            intensity,
            inner,
            outer,
        } => LightKind::Spot {
            position: mirror_point(position, plane, normal),
            direction: flip(direction),
            intensity,
            inner,
            outer,
        },
        LightKind::Directional {
            direction,
            irradiance,
        } => LightKind::Directional {
            direction: flip(direction),
            irradiance,
        },
        LightKind::Ambient { .. } => return None,
    };
    unoccluded(&image, p, n, surfaces)
}

/// A distance beyond everything in the scene.
fn far(surfaces: &Surfaces, p: DVec3) -> f64 {
    let bounds = surfaces.tracer.bounds();
    2.0 * bounds.diagonal() + (p - bounds.centre()).length()
}

/// Whether a quick look shows that `point` can't see anything of `image` through `window`: all
/// of the image, or all of the window, is below the horizon, or the image shows its back or is
/// beyond one edge.
pub(super) fn is_hidden(point: &GatherPoint, image: &[DVec3], window: &[DVec3]) -> bool {
    let p = point.position;
    let below = |polygon: &[DVec3]| polygon.iter().all(|&c| (c - p).dot(point.normal) <= 0.0);
    if !is_in_front(p, image) || below(image) || below(window) {
        return true;
    }
    let facing = (p - window[0]).dot(area_vector(window)).signum();
    (0..window.len()).any(|k| {
        let (a, b) = (window[k], window[(k + 1) % window.len()]);
        let inward = (b - p).cross(a - p) * facing;
        image.iter().all(|&c| (c - p).dot(inward) <= 0.0)
    })
}

/// Whether the segment between two points crosses a convex polygon.
fn is_through(from: DVec3, to: DVec3, polygon: &[DVec3]) -> bool {
    let normal = area_vector(polygon);
    let (a, b) = (
        (from - polygon[0]).dot(normal),
        (to - polygon[0]).dot(normal),
    );
    if a * b >= 0.0 {
        return false;
    }
    is_inside(from + (to - from) * (a / (a - b)), polygon, normal)
}
