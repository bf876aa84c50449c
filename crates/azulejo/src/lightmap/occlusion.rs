//! Ambient occlusion: which share of the hemisphere over each texel is free of things that are near.
//!
//! Weighted by the cosine, as irradiance of an even sky that ends at a distance. No light is solved, so that models
//! without lamps have it, too.

use super::charts::{agreed_samples, arranged, receivers_of};
use super::{BakeError, BakeOptions, Baked, BakedSides};
use azulejo_bake::{Hemispheres, Samples, ShownSamples, TexelCells};
use azulejo_radiosity::sites::{
    IndirectGoal, SiteDirect, SiteLight, SiteStatistics, first_look, with_indirect,
};
use azulejo_radiosity::{PairTargets, PathPair, SolveError};
use azulejo_scene::Scene;
use azulejo_trace::sampling::hash;
use azulejo_trace::{Cancelled, REPLICATES, Run, Surfaces, Tracer};

/// Fewest and most strata along each axis of a replicate's rays.
const STRATA: [u32; 2] = [4, 32];

/// Most strata along each axis where the number of rays is given.
const MOST_STRATA: u32 = 64;

/// Strata that are enough to see which side of a surface is free.
const FEW_STRATA: u32 = 4;

/// Part of the permitted error that is noise.
const NOISE_SHARE: f64 = 0.5;

/// Bakes the free share, 0 to 1, of the hemispheres over the objects that are listed, within `distance`, scene units,
/// in place of irradiance. Of `options` the charts, the sides ([`BakedSides::Brighter`] is the side that is freer,
/// and [`BakedSides::Both`] the fronts), and the error or the rays, the seed and the memory of the first pass count.
///
/// # Errors
/// [`BakeError`].
pub fn bake_occlusion<'r>(
    scene: &Scene,
    tracer: &Tracer,
    objects: &[u32],
    options: &BakeOptions,
    distance: f64,
    run: impl Into<Run<'r>>,
) -> Result<Baked, BakeError> {
    let run = run.into();
    let progress = run.progress;
    let (receivers, objects) = receivers_of(scene, objects, &options.densities);
    let mut atlas = arranged(receivers, options, tracer, run)?;
    let seed = hash(&[
        options.pass.seed as u32,
        (options.pass.seed >> 32) as u32,
        5,
    ]);
    let hemispheres = Hemispheres {
        tracer,
        distance,
        seed,
        run,
    };
    // Choose the side of each chart before its points are placed on it.
    if options.sides == BakedSides::Brighter {
        atlas.turned = hemispheres.freer_sides(&atlas)?;
    }
    let samples = agreed_samples(&atlas, tracer, run)?;
    let count = samples.samples.len();
    // The free share takes the place of indirect light, with no direct light beside it.
    let none = SiteDirect::none(count);
    // Gather at all samples if the number of rays is given, else at some, by how the share changes.
    let (light, texels) = match options.fixed_rays(progress) {
        Some(rays) => everywhere(&hemispheres, (&samples, &none), rays)?,
        None => to_error(&hemispheres, (&samples, &none), options.error())?,
    };
    let surfaces = Surfaces::new(scene, tracer);
    let shown = ShownSamples::new(&samples, &light, &surfaces);
    let light: Vec<SiteLight> = light.into_iter().map(limited).collect();
    let mut lightmap = shown.lightmap(&samples, &light);
    if options.denoises && options.fixed_rays(progress).is_some() {
        azulejo_bake::denoise(&mut lightmap, &shown, &samples, progress)?;
    }
    // Prepare the pages for viewers, who interpolate across charts and read smaller copies.
    for page in &mut lightmap.pages {
        azulejo_bake::pad_charts(page, options.charts.padding);
    }
    let seams = azulejo_bake::stitch(&mut lightmap, &atlas);
    for page in &mut lightmap.pages {
        azulejo_bake::fill(page);
    }
    Ok(Baked {
        harmonics: None,
        atlas,
        objects,
        lightmap,
        texels,
        report: None,
        seams,
        differing_sides: 0.0,
        beside_patches: 0.0,
        between_texels: 0.0,
        follows_light: false,
    })
}

/// The free share at some samples, interpolated between, so that its error is `error`, relative to the mean.
fn to_error(
    hemispheres: &Hemispheres,
    (samples, none): (&Samples, &SiteDirect),
    error: f64,
) -> Result<(Vec<SiteLight>, SiteStatistics), Cancelled> {
    let goal = IndirectGoal {
        relative: error,
        least: 0.0,
    };
    let run = hemispheres.run;
    let strata = strata(NOISE_SHARE * error);
    let cells = TexelCells::new(samples);
    let (light, cells) = first_look(cells, none, goal, run, &mut |points| {
        hemispheres.free(points, FEW_STRATA)
    })?;
    drop(light);
    let free = |targets: &PairTargets| -> Result<Vec<PathPair>, Cancelled> {
        let visibility = hemispheres.free(targets.points, strata)?;
        let node = |read| PathPair {
            read,
            ..PathPair::default()
        };
        Ok(visibility.into_iter().map(node).collect())
    };
    with_indirect(cells, none, goal, true, run, &mut |targets| {
        targets.iter().map(free).collect()
    })
}

/// The free share at all samples, from this many rays at each.
fn everywhere(
    hemispheres: &Hemispheres,
    (samples, none): (&Samples, &SiteDirect),
    rays: u32,
) -> Result<(Vec<SiteLight>, SiteStatistics), SolveError> {
    let (points, _) = azulejo_bake::sample_points(samples);
    let visibility = hemispheres.free_of_all(&points, strata_of(rays))?;
    let visibility = visibility.ok_or(SolveError::Elsewhere)?;
    let free = visibility
        .iter()
        .map(|free| (free.mean(), free.variance().map(f64::sqrt)));
    let texels = SiteStatistics {
        sites: points.len(),
        nodes: points.len(),
    };
    Ok((none.plus(free), texels))
}

/// Interpolation may go beyond what is free at all.
fn limited(light: SiteLight) -> SiteLight {
    SiteLight {
        irradiance: light.irradiance.map(|free| free.min(1.0)),
        ..light
    }
}

/// Strata along an axis of each replicate with which the free share has this error at most: that of shares in
/// strata falls with their number as n^−3/4.
fn strata(error: f64) -> u32 {
    let rays = (0.5 / error).powf(4.0 / 3.0);
    let of_replicate = (rays / REPLICATES as f64).sqrt().ceil();
    (of_replicate as u32).clamp(STRATA[0], STRATA[1])
}

/// Strata along an axis of each replicate that take this many rays, or as few more as squares allow.
fn strata_of(rays: u32) -> u32 {
    let of_replicate = rays.div_ceil(REPLICATES as u32);
    let root = of_replicate.isqrt();
    let strata = root + u32::from(root * root < of_replicate);
    strata.min(MOST_STRATA)
}
