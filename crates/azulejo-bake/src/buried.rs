//! Regions of surfaces that lie inside of solids, where nobody sees them.

use crate::samples::{Samples, TexelSample};
use crate::solids::Solids;
use azulejo_radiosity::sites::SiteLight;
use azulejo_scene::Rgb;
use azulejo_scene::math::{Frame, Ray};
use azulejo_trace::sampling::{cosine_about, hash, uniform, uniform_sphere};
use azulejo_trace::{KernelHit, KernelRay, Surfaces};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// Samples of a region that are looked at.
const LOOKS: u32 = 8;

/// Rays from each.
const RAYS: u32 = 32;

/// Share of the rays that must meet the inner sides of solids.
const INSIDE: f64 = 0.9;

/// What a region may have of the mean irradiance to be inside: nothing but what leaks through cracks.
const DARK: f64 = 0.01;

/// What is known of a region.
#[derive(Clone, Default)]
struct Region {
    /// Keyed choice among its samples.
    looks: Vec<u32>,
    light: Rgb,
    area: f64,
    chart: u32,
}

/// For each region whether it lies inside of a solid, in the dark, on a chart that also has light.
pub(crate) fn buried_regions(
    samples: &Samples,
    light: &[SiteLight],
    surfaces: &Surfaces,
) -> Vec<bool> {
    let mut regions = vec![Region::default(); samples.regions as usize];
    for (number, sample) in samples.samples.iter().enumerate() {
        let region = &mut regions[sample.region as usize];
        let area = f64::from(sample.area);
        region.light += light[number].rgb() * area;
        region.area += area;
        region.chart = samples.pages[sample.page as usize].texels[sample.texel as usize].chart;
        region.looks.push(number as u32);
    }
    let mean = regions.iter().map(|r| r.light).sum::<Rgb>().max_channel()
        / f64::max(regions.iter().map(|r| r.area).sum(), f64::MIN_POSITIVE);
    let is_dark = |r: &Region| r.light.max_channel() <= DARK * mean * r.area;
    let mut has_light: HashMap<u32, bool> = HashMap::new();
    for region in &regions {
        *has_light.entry(region.chart).or_default() |= !is_dark(region);
    }
    let solids = Solids::of(surfaces.scene);
    regions
        .par_iter()
        .map(|region| {
            is_dark(region)
                && has_light[&region.chart]
                && share_inside(region, samples, &solids, surfaces) >= INSIDE
        })
        .collect()
}

/// Share of rays from a region that meet the inner sides of solids.
fn share_inside(region: &Region, samples: &Samples, solids: &Solids, surfaces: &Surfaces) -> f64 {
    let count = region.looks.len() as u32;
    let looks = (0..LOOKS.min(count)).map(|k| region.looks[(hash(&[k, count]) % count) as usize]);
    let (mut inside, mut all) = (0, 0);
    for number in looks {
        let sample = &samples.samples[number as usize];
        let rays: Vec<_> = (0..RAYS)
            .map(|k| ray(sample, number, k, surfaces))
            .collect();
        let mut hits = Vec::new();
        surfaces.tracer.closest(&rays, &mut hits);
        let is_inside = |(ray, hit): &(&KernelRay, &KernelHit)| {
            hit.is_hit() && solids.comes_from_inside(surfaces, ray, hit)
        };
        inside += rays.iter().zip(&hits).filter(is_inside).count();
        all += rays.len();
    }
    inside as f64 / f64::max(all as f64, 1.0)
}

/// For each point the share of directions in which it meets the inner side of a solid first.
pub fn shares_inside(surfaces: &Surfaces, points: &[DVec3]) -> Vec<f64> {
    let solids = Solids::of(surfaces.scene);
    let of_point = |point: &DVec3| {
        let direction = |k: u32| {
            let [u1, u2] = [0, 1].map(|d| f64::from(uniform(&[k, d, 0xb1e])));
            surfaces
                .tracer
                .kernel_ray(&Ray::new(*point, uniform_sphere(u1, u2)))
        };
        let rays: Vec<KernelRay> = (0..RAYS).map(direction).collect();
        let mut hits = Vec::new();
        surfaces.tracer.closest(&rays, &mut hits);
        let is_inside = |(ray, hit): &(&KernelRay, &KernelHit)| {
            hit.is_hit() && solids.comes_from_inside(surfaces, ray, hit)
        };
        let inside = rays.iter().zip(&hits).filter(is_inside).count();
        inside as f64 / f64::from(RAYS)
    };
    points.par_iter().map(of_point).collect()
}

fn ray(sample: &TexelSample, number: u32, k: u32, surfaces: &Surfaces) -> KernelRay {
    let frame = Frame::from_normal(sample.normal);
    let [u1, u2] = [0, 1].map(|d| f64::from(uniform(&[number, k, d, 0xb1d])));
    let origin = surfaces.tracer.leaving(sample.position, sample.normal);
    let direction = cosine_about(&frame, u1, u2);
    surfaces.tracer.kernel_ray(&Ray::new(origin, direction))
}
