//! Light that arrives at points from all around, or from above a surface, as spherical harmonics of its radiance.
//!
//! Direct light is that of the shadow tests that find the irradiance, each with its direction. Indirect light is
//! found by rays of even density: those of a gather have the density of the cosine, by which light near the horizon,
//! that counts little for irradiance and much here, would have no finite variance.

use super::collector::Collector;
use super::direct::{Direct, ShadowRays};
use super::terms::{Target, Term};
use super::{
    DiffuseLight, DirectLight, GatherOptions, GatherPoint, Gathered, Gatherer, REPLICATES,
};
use crate::follow::{Path, Scratch};
use crate::lambert::{clip, polygon_vector, solid_angle};
use crate::sampling::{hash, seeds, sobol, uniform_sphere};
use crate::{KernelRay, Tracer};
use azulejo_scene::Rgb;
use azulejo_scene::harmonics::{HARMONICS, band, real_harmonics};
use azulejo_scene::math::{Frame, Ray};
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, PI, TAU};
use std::ops::Range;

/// Cosine below which light of a sample is left out: there is next to none, and dividing by it would lose all digits.
const LEAST_COSINE: f64 = 1e-6;

/// Paths that are followed together.
const TOGETHER: usize = 1 << 14;

/// Radiance around a point, W/(sr·m²), as coefficients of the [real spherical harmonics](real_harmonics) of bands 0 to
/// 2, with one estimate per replicate each.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Harmonics {
    /// In the order of [`real_harmonics`].
    pub coefficients: [Gathered; HARMONICS],
}

impl Harmonics {
    /// The sum of two lights.
    pub fn plus(&self, other: &Harmonics) -> Harmonics {
        let sum = |k: usize| self.coefficients[k].plus(&other.coefficients[k]);
        Harmonics {
            coefficients: std::array::from_fn(sum),
        }
    }

    /// The light times a number.
    pub fn scaled(&self, factor: f64) -> Harmonics {
        Harmonics {
            coefficients: self.coefficients.map(|c| c.scaled(factor)),
        }
    }

    /// The coefficients.
    pub fn mean(&self) -> [Rgb; HARMONICS] {
        self.coefficients.map(|c| c.mean())
    }

    /// Adds light of which this is ∫ L dω, of a cap, to some of the replicates.
    fn add_cap(&mut self, replicates: Range<usize>, light: Rgb, cap: &LightCap) {
        let m = cap.concentration;
        let of_bands = [1.0, m, m * (2.0 * m - 1.0)];
        let harmonics = real_harmonics(cap.direction);
        for (k, (coefficient, y)) in self.coefficients.iter_mut().zip(harmonics).enumerate() {
            let factor = y * of_bands[band(k)];
            for replicate in &mut coefficient.replicates[replicates.clone()] {
                *replicate += light * factor;
            }
        }
    }

    /// Adds ∫ L dω of light from a unit direction to some of the replicates.
    fn add(&mut self, replicates: Range<usize>, light: Rgb, direction: DVec3) {
        for (coefficient, y) in self.coefficients.iter_mut().zip(real_harmonics(direction)) {
            for replicate in &mut coefficient.replicates[replicates.clone()] {
                *replicate += light * y;
            }
        }
    }
}

/// Where light comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IncidentDomain {
    /// The side of the normal.
    Hemisphere,
    /// All around.
    Sphere,
}

/// Where the light of a source comes from at a point, as that of a cap of even radiance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LightCap {
    /// Its middle, a unit direction.
    direction: DVec3,
    /// Scalar irradiance ∫ L dω over irradiance.
    scalar: f64,
    /// Length of the vector irradiance over the scalar one, m: 1 for a point, and (1 + cos α)/2 for a cap of half angle α.
    /// Means over the cap of the Legendre polynomials P₁ and P₂ are m and m (2m − 1).
    concentration: f64,
}

impl LightCap {
    /// A point in a unit direction that the surface sees.
    fn point(direction: DVec3, normal: DVec3) -> Option<LightCap> {
        let cos = direction.dot(normal);
        (cos > LEAST_COSINE).then(|| LightCap {
            direction,
            scalar: 1.0 / cos,
            concentration: 1.0,
        })
    }

    /// A flat source that faces the point: bands 0 and 1 are exact, and band 2 is that of a disc that has these.
    fn polygon(point: &GatherPoint, polygon: &[DVec3]) -> Option<LightCap> {
        let above = clip(polygon, point.position, point.normal);
        let vector = PI * polygon_vector(point.position, &above);
        let solid_angle = solid_angle(point.position, &above);
        let irradiance = vector.dot(point.normal);
        let is_seen = irradiance > LEAST_COSINE * solid_angle && solid_angle > 0.0;
        is_seen.then(|| LightCap {
            direction: vector.normalize_or_zero(),
            scalar: solid_angle / irradiance,
            concentration: (vector.length() / solid_angle).min(1.0),
        })
    }
}

impl Direct<'_> {
    /// Where the light of a term comes from, if that is asked for and formulas know it.
    pub(super) fn cap_of(&self, term: &Term, point: &GatherPoint) -> Option<LightCap> {
        if self.incident.sums.is_empty() || term.is_rough() {
            return None;
        }
        let toward = |place: DVec3| {
            let direction = (place - point.position).normalize_or_zero();
            LightCap::point(direction, point.normal)
        };
        match &term.target {
            Target::Flat(k) => {
                let lamp = &self.lights.flat()[*k as usize];
                LightCap::polygon(point, &lamp.toward(point.position))
            }
            Target::Image { seen, .. } => LightCap::polygon(point, seen),
            Target::Delta(place) | Target::DeltaImage { image: place, .. } => toward(*place),
            Target::Sun(k) => {
                let sun = &self.lights.outside.suns[*k as usize];
                LightCap::point(sun.toward(), point.normal)
            }
            Target::Curved(_) | Target::SunImage { .. } => None,
        }
    }
}

/// Sums where the direct light of points comes from, if that is asked for.
#[derive(Default)]
pub(super) struct IncidentSums {
    normals: Vec<DVec3>,
    sums: Vec<Harmonics>,
}

impl IncidentSums {
    /// For these points.
    pub fn new(points: &[GatherPoint]) -> IncidentSums {
        IncidentSums {
            normals: points.iter().map(|p| p.normal).collect(),
            sums: vec![Harmonics::default(); points.len()],
        }
    }

    /// Adds the irradiance that a sample of some replicates stands for.
    pub fn add(
        &mut self,
        point: usize,
        replicates: Range<usize>,
        irradiance: Rgb,
        (tracer, ray): (&Tracer, &KernelRay),
    ) {
        let Some(sum) = self.sums.get_mut(point) else {
            return;
        };
        let direction = tracer.world_ray(ray).direction.normalize_or_zero();
        let cos = direction.dot(self.normals[point]);
        if cos > LEAST_COSINE {
            sum.add(replicates, irradiance / cos, direction);
        }
    }

    /// Adds irradiance of some replicates that comes from a cap.
    pub fn add_cap(
        &mut self,
        point: usize,
        replicates: Range<usize>,
        irradiance: Rgb,
        cap: Option<&LightCap>,
    ) {
        if let (Some(sum), Some(cap)) = (self.sums.get_mut(point), cap) {
            sum.add_cap(replicates, irradiance * cap.scalar, cap);
        }
    }

    /// What was found.
    pub fn into_sums(self) -> Vec<Harmonics> {
        self.sums
    }
}

impl Gatherer<'_> {
    /// [`direct`](Gatherer::direct) with the directions of the light, from the hemisphere of each point, by these of the
    /// shadow rays per replicate and source.
    pub fn direct_harmonics(
        &self,
        points: &[GatherPoint],
        rays: Range<u32>,
        seed: u32,
    ) -> (Vec<DirectLight>, Vec<Harmonics>) {
        self.with_incident(points, ShadowRays::Own(rays), seed)
    }

    /// [`direct_at_near`](Gatherer::direct_at_near) with the directions of the light.
    pub fn direct_harmonics_at_near(
        &self,
        points: &[GatherPoint],
        seed: u32,
    ) -> (Vec<DirectLight>, Vec<Harmonics>) {
        self.with_incident(points, ShadowRays::Shared, seed)
    }

    fn with_incident(
        &self,
        points: &[GatherPoint],
        rays: ShadowRays,
        seed: u32,
    ) -> (Vec<DirectLight>, Vec<Harmonics>) {
        let mut direct = self.direct_light();
        direct.incident = IncidentSums::new(points);
        let light = direct.irradiance(points, rays, seed);
        (light, direct.incident.into_sums())
    }

    /// Indirect light that arrives at points, all that [`direct`](Gatherer::direct) does not count, from
    /// rays of even density over a domain; with fewer than [`REPLICATES`] rays, as many. Its irradiance is that of
    /// [`gather_indirect`](Gatherer::gather_indirect), with other noise.
    pub fn indirect_harmonics(
        &self,
        points: &[GatherPoint],
        domain: IncidentDomain,
        options: &GatherOptions,
        light: &impl DiffuseLight,
    ) -> Vec<Harmonics> {
        let rays = options.per_replicate() as usize * REPLICATES;
        let mut found = vec![Harmonics::default(); points.len()];
        let together = (TOGETHER / rays).max(1);
        for (points, found) in points.chunks(together).zip(found.chunks_mut(together)) {
            let directions = self.even_directions(points, domain, options, rays);
            let exitance = self.exitance_along(points, &directions, options, light);
            let solid_angle = match domain {
                IncidentDomain::Hemisphere => TAU,
                IncidentDomain::Sphere => 2.0 * TAU,
            };
            let weight = solid_angle * FRAC_1_PI * REPLICATES as f64 / rays as f64;
            for (ray, (direction, exitance)) in directions.iter().zip(exitance).enumerate() {
                let replicate = ray % rays * REPLICATES / rays;
                let replicates = replicate..replicate + 1;
                found[ray / rays].add(replicates, exitance * weight, *direction);
            }
        }
        found
    }

    /// So many directions for each point, one stretch of a sequence for each replicate.
    fn even_directions(
        &self,
        points: &[GatherPoint],
        domain: IncidentDomain,
        options: &GatherOptions,
        rays: usize,
    ) -> Vec<DVec3> {
        let of_point = |point: &GatherPoint| {
            let frame = Frame::from_normal(point.normal);
            let [s0, s1, ..] = seeds(&[options.seed, point.key, 0x5b4]);
            let first = options.spent;
            (first..first + rays as u32).map(move |k| {
                let [u1, u2] = [sobol(k, 0, s0), sobol(k, 1, s1)].map(f64::from);
                frame.to_world(match domain {
                    IncidentDomain::Hemisphere => uniform_sphere(0.5 * u1, u2),
                    IncidentDomain::Sphere => uniform_sphere(u1, u2),
                })
            })
        };
        points.iter().flat_map(of_point).collect()
    }

    /// Exitance πL that arrives along each direction, W/m²; the directions of the points follow each other.
    fn exitance_along(
        &self,
        points: &[GatherPoint],
        directions: &[DVec3],
        options: &GatherOptions,
        light: &impl DiffuseLight,
    ) -> Vec<Rgb> {
        let tracer = self.surfaces.tracer;
        let rays = directions.len() / points.len().max(1);
        // The collector sums by path, as if the rays of a replicate were a point each.
        let mut collector = Collector::new(
            self,
            light,
            directions.len() / REPLICATES,
            options.termination,
        );
        let path = |(id, &direction): (usize, &DVec3)| {
            let point = &points[id / rays];
            let side = point.normal * direction.dot(point.normal).signum();
            let origin = tracer.leaving(point.position, side);
            let ray = tracer.kernel_ray(&Ray::new(origin, direction));
            Path::new(ray, id as u32, Rgb::WHITE)
        };
        let mut paths: Vec<Path> = directions.iter().enumerate().map(path).collect();
        let origins = (0..directions.len() / REPLICATES).map(|group| {
            let point = &points[group * REPLICATES / rays];
            GatherPoint {
                key: hash(&[point.key, (group % (rays / REPLICATES)) as u32]),
                ..*point
            }
        });
        let origins: Vec<GatherPoint> = origins.collect();
        let mut scratch = Scratch::default();
        for round in 0..=options.termination.most_bounces() {
            let key = hash(&[options.seed, options.spent, round, 0x5b5]);
            collector.follow(&mut paths, &mut scratch, key, round);
            if !collector.has_contacts() {
                break;
            }
            collector.contacts(&origins, &mut paths, hash(&[key, 1]));
        }
        collector
            .sums()
            .iter()
            .flatten()
            .map(|&sum| Rgb::from(sum))
            .collect()
    }
}
