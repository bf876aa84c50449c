//! Direct light of texels: few shadow rays where all of a lamp is seen or none, many at the edges of
//! shadows, where a texel is a mean over what it covers.

use crate::atlas::Atlas;
use crate::harmonics::{TexelHarmonics, site_harmonics};
use crate::lattice::TexelCells;
use crate::samples::{PageSampler, Rows, Samples, gather_point};
use azulejo_radiosity::sites::{SiteCells, SiteDirect, SiteLight, interpolated_direct};
use azulejo_trace::run::batches::{BLOCK, in_counted_batches};
use azulejo_trace::sampling::{hash, uniform};
use azulejo_trace::time::Instant;
use azulejo_trace::{Cancelled, DirectLight, GatherPoint, Gathered, Gatherer, Harmonics, Run};
use glam::DVec2;
use rayon::prelude::*;

/// Samples that are gathered together.
const BATCH: usize = 64;

/// Uneven texels of a batch: each takes as long as many samples.
const UNEVEN_BATCH: usize = 4;

/// Where there is a deadline, light is gathered first at one sample of a square of so many texels along a side, as
/// powers of two: at the coarsest, and at what there is time for.
const COARSEST: u32 = 4;
const FINEST: u32 = 2;

/// Share of the time until a deadline that direct light may take, and of that, a lattice.
const TIME_SHARE: f64 = 0.3;
const LATTICE_SHARE: f64 = 0.5;

/// Root mean square of the standard errors of direct light, as a share of what is permitted in all, that is
/// left: texels with the largest are looked at in more places until it is reached.
const PERMITTED: f64 = 0.5;

/// Difference between neighbouring texels, as a multiple of the permitted error, above which a texel
/// is looked at in more places. Noise makes such differences too; what it hides at the edges of shadows would be
/// missed if they had to be larger than that.
const UNEVEN: f64 = 2.0;

/// Places along each axis of an uneven texel, coarse and fine.
const PLACES: [u32; 2] = [4, 8];

/// Direct light of all samples, and where it comes from, if that is asked for.
#[derive(Clone, Debug, Default)]
pub struct DirectTexels {
    /// Irradiance.
    pub light: SiteDirect,
    /// Where it comes from; without samples unless asked for.
    pub harmonics: TexelHarmonics,
}

/// Light at a point, and the coefficients of where it comes from, if that is asked for.
type DirectedLight = (Gathered, Vec<SiteLight>);

impl DirectTexels {
    fn none(count: usize, is_directional: bool) -> DirectTexels {
        DirectTexels {
            light: SiteDirect::none(count),
            harmonics: if is_directional {
                TexelHarmonics::none(count)
            } else {
                TexelHarmonics::default()
            },
        }
    }

    fn set(&mut self, sample: usize, (light, harmonics): &DirectedLight) {
        self.light.set(sample, light);
        self.harmonics.set(sample, harmonics);
    }
}

/// What all steps need.
#[derive(Clone, Copy)]
pub struct DirectGather<'a> {
    /// The points.
    pub samples: &'a Samples,
    /// What they cover.
    pub atlas: &'a Atlas,
    /// What gathers.
    pub gatherer: &'a Gatherer<'a>,
    /// Whether it is asked where light comes from.
    pub is_directional: bool,
    /// Of all random numbers.
    pub seed: u32,
}

impl DirectGather<'_> {
    /// Light at points by themselves.
    fn at(&self, points: &[GatherPoint]) -> Vec<DirectedLight> {
        if !self.is_directional {
            let light = self.gatherer.direct(points, 1, self.seed);
            return light.iter().map(|l| (l.whole(), Vec::new())).collect();
        }
        let (light, harmonics) = self.gatherer.direct_harmonics(points, 0..1, self.seed);
        let both = light.iter().zip(&harmonics);
        both.map(|(l, h)| (l.whole(), site_harmonics(h))).collect()
    }

    /// The mean light of points side by side.
    fn mean_of(&self, points: &[GatherPoint]) -> DirectedLight {
        let share = 1.0 / points.len() as f64;
        let mut sum = Gathered::default();
        let mut add = |lights: &[DirectLight]| {
            for light in lights {
                sum = sum.plus(&light.whole());
            }
        };
        let harmonics = if self.is_directional {
            let (light, harmonics) = self.gatherer.direct_harmonics_at_near(points, self.seed);
            add(&light);
            let none = Harmonics::default();
            let all = harmonics.iter().fold(none, |all, h| all.plus(h));
            site_harmonics(&all.scaled(share))
        } else {
            add(&self.gatherer.direct_at_near(points, self.seed));
            Vec::new()
        };
        (sum.scaled(share), harmonics)
    }
}

/// Sets the direct light of some samples from that of the nodes of cells; where it comes from is what it is at the node
/// of their cell.
fn interpolate(
    direct: &mut DirectTexels,
    cells: TexelCells,
    of_nodes: Vec<DirectedLight>,
    missing: &[u32],
    run: Run,
) -> Result<(), Cancelled> {
    if !direct.harmonics.is_empty() {
        let mut is_missing = vec![false; direct.light.irradiance.len()];
        missing.iter().for_each(|&s| is_missing[s as usize] = true);
        for cell in 0..cells.cell_count() {
            let of_node = &of_nodes[cells.node(cell) as usize].1;
            for &sample in cells
                .sites(cell)
                .iter()
                .filter(|s| is_missing[**s as usize])
            {
                direct.harmonics.set(sample as usize, of_node);
            }
        }
    }
    let direct = &mut direct.light;
    let of_nodes = of_nodes.into_iter().map(|found| found.0).collect();
    let light = interpolated_direct(cells, of_nodes, run)?;
    for &sample in missing {
        let SiteLight {
            irradiance,
            standard_error,
        } = light[sample as usize];
        direct.irradiance[sample as usize] = irradiance;
        direct.variance[sample as usize] = standard_error.map(|e| e * e);
    }
    Ok(())
}

/// Gathers the direct light of all samples, so that its error is a small part of `error`, a share of
/// the mean of the whole. Once its share of the time until a deadline is over, it is interpolated between one sample of
/// each few, with what that misses in its variance.
///
/// # Errors
/// The caller cancelled.
pub fn direct(gather: DirectGather, error: f64, run: Run) -> Result<DirectTexels, Cancelled> {
    run.progress.limit_phase(TIME_SHARE);
    let direct = at_centres(gather, run)?;
    let found = with_shadow_edges(gather, (direct, error), run)?;
    run.progress.limit_phase(1.0);
    Ok(found)
}

/// As [`direct`], from direct light that was gathered at the point of each sample.
///
/// # Errors
/// The caller cancelled.
pub fn direct_from(
    gather: DirectGather,
    (irradiance, error): (&[Gathered], f64),
    run: Run,
) -> Result<DirectTexels, Cancelled> {
    // Whoever gathered the irradiance did not ask where it comes from.
    let mut direct = if gather.is_directional {
        at_centres(gather, run)?
    } else {
        DirectTexels::none(irradiance.len(), false)
    };
    for (sample, light) in irradiance.iter().enumerate() {
        direct.light.set(sample, light);
    }
    with_shadow_edges(gather, (direct, error), run)
}

/// Looks at texels in more places where light is uneven or noisy.
fn with_shadow_edges(
    gather: DirectGather,
    (mut found, error): (DirectTexels, f64),
    run: Run,
) -> Result<DirectTexels, Cancelled> {
    let (progress, samples) = (run.progress, gather.samples);
    let mean = mean(samples, &found.light);
    for (round, places) in PLACES.into_iter().enumerate() {
        if progress.phase_is_over() {
            break;
        }
        let uneven = uneven(samples, &found.light, error * mean, round);
        progress.begin("shadow edges", uneven.len() as u64);
        let fine = in_counted_batches(&uneven, (UNEVEN_BATCH, BLOCK), run, |batch| {
            let light = |&s: &u32| {
                (!progress.phase_is_over()).then(|| over_texel(gather, s as usize, places))
            };
            Ok(batch.iter().map(light).collect())
        })?;
        for (&sample, light) in uneven.iter().zip(&fine) {
            if let Some(light) = light {
                found.set(sample as usize, light);
            }
        }
    }
    Ok(found)
}

/// Gathers the direct light at the point of each sample. Where there is a deadline, light at one sample of each few
/// comes first, and what there is no time for is interpolated.
fn at_centres(gathers: DirectGather, run: Run) -> Result<DirectTexels, Cancelled> {
    let (progress, samples) = (run.progress, gathers.samples);
    let count = samples.samples.len();
    progress.begin("direct light", count as u64);
    let mut direct = DirectTexels::none(count, gathers.is_directional);
    let gather = |batch: &[u32]| {
        let point = |&s: &u32| gather_point(samples, s as usize);
        gathers.at(&batch.iter().map(point).collect::<Vec<GatherPoint>>())
    };
    let mut left: Vec<u32> = (0..count as u32).collect();
    let mut sparse = None;
    // Before a deadline, gather at a sparse lattice first, from which all samples can be interpolated.
    if progress.has_deadline() {
        let (cells, light) = at_lattice(samples, &gather, run)?;
        let mut is_left = vec![true; count];
        for (&sample, light) in cells.nodes().iter().zip(&light) {
            direct.set(sample as usize, light);
            is_left[sample as usize] = false;
        }
        left.retain(|&s| is_left[s as usize]);
        sparse = Some((cells, light));
    }
    // Gather at the other samples as long as there is time.
    let light = in_counted_batches(&left, (BATCH, BLOCK), run, |batch| {
        Ok(if progress.phase_is_over() {
            vec![None; batch.len()]
        } else {
            gather(batch).into_iter().map(Some).collect()
        })
    })?;
    let mut missing = Vec::new();
    for (&sample, light) in left.iter().zip(&light) {
        match light {
            Some(light) => direct.set(sample as usize, light),
            None => missing.push(sample),
        }
    }
    // Interpolate at those for which there was none, and state the error of that as variance.
    if let Some((cells, light)) = sparse.filter(|_| !missing.is_empty()) {
        interpolate(&mut direct, cells, light, &missing, run)?;
    }
    Ok(direct)
}

/// Gathers at the nodes of the finest lattice of a few for which there is time, by the pace of those before it.
fn at_lattice<'a>(
    samples: &'a Samples,
    gather: &(impl Fn(&[u32]) -> Vec<DirectedLight> + Sync),
    run: Run,
) -> Result<(TexelCells<'a>, Vec<DirectedLight>), Cancelled> {
    let gathered = |cells: &TexelCells| {
        in_counted_batches(cells.nodes(), (BATCH, BLOCK), run, |batch| {
            Ok(gather(batch))
        })
    };
    let mut started = Instant::now();
    let mut cells = TexelCells::of_level(samples, COARSEST);
    let mut light = gathered(&cells)?;
    for level in (FINEST..COARSEST).rev() {
        let finer = TexelCells::of_level(samples, level);
        let growth = finer.nodes().len() as f64 / cells.nodes().len().max(1) as f64;
        let left = run.progress.phase_left().unwrap_or_default();
        if started.elapsed().mul_f64(growth) > left.mul_f64(LATTICE_SHARE) {
            break;
        }
        started = Instant::now();
        light = gathered(&finer)?;
        cells = finer;
    }
    Ok((cells, light))
}

/// Mean over all areas and channels.
fn mean(samples: &Samples, found: &SiteDirect) -> f64 {
    let (mut sum, mut area) = (0.0, 0.0);
    for (sample, s) in samples.samples.iter().enumerate() {
        sum += found.mean(sample).mean() * f64::from(s.area);
        area += f64::from(s.area);
    }
    sum / f64::max(area, f64::MIN_POSITIVE)
}

/// The samples that are looked at in more places, of those that are the only ones of their texels: the
/// noisiest, and in the first round those that differ from a neighbour.
fn uneven(samples: &Samples, found: &SiteDirect, permitted: f64, round: usize) -> Vec<u32> {
    let is_uneven = noisiest(samples, found, (PERMITTED * permitted).powi(2));
    let mut uneven = Vec::new();
    for (page, coverage) in samples.pages.iter().enumerate() {
        let first = samples
            .samples
            .partition_point(|s| (s.page as usize) < page);
        let end = samples.samples.partition_point(|s| s.page as usize <= page);
        let mut sample_of = vec![u32::MAX; coverage.texels.len()];
        let mut is_alone = vec![true; coverage.texels.len()];
        for (s, sample) in samples.samples[first..end].iter().enumerate() {
            let of_texel = &mut sample_of[sample.texel as usize];
            is_alone[sample.texel as usize] = *of_texel == u32::MAX;
            *of_texel = (first + s) as u32;
        }
        let rows = Rows::new(coverage);
        let differs = |a: usize, b: usize| {
            let difference = found.mean(a) - found.mean(b);
            difference.map(f64::abs).max_channel() > UNEVEN * permitted
        };
        let of_page: Vec<u32> = (0..coverage.texels.len())
            .into_par_iter()
            .filter(|&t| is_alone[t])
            .filter_map(|t| {
                let sample = sample_of[t] as usize;
                let chart = coverage.texels[t].chart;
                let [column, row] = rows.place(coverage.texels[t].index);
                let mut beside = rows
                    .around(column, row)
                    .filter(|&n| coverage.texels[n as usize].chart == chart);
                let mut is_edge =
                    || beside.any(|n| differs(sample, sample_of[n as usize] as usize));
                (is_uneven[sample] || (round == 0 && is_edge())).then_some(sample as u32)
            })
            .collect();
        uneven.extend(of_page);
    }
    uneven
}

/// For each sample whether it is one of the noisiest, without which the mean of the variance over the area
/// is `permitted`.
fn noisiest(samples: &Samples, found: &SiteDirect, permitted: f64) -> Vec<bool> {
    let area = |s: u32| f64::from(samples.samples[s as usize].area);
    let variance = |s: u32| {
        let [r, g, b] = found.variance[s as usize];
        f64::from(r.max(g).max(b))
    };
    let count = samples.samples.len();
    let mut noisy: Vec<u32> = (0..count as u32).filter(|&s| variance(s) > 0.0).collect();
    noisy.par_sort_unstable_by(|&a, &b| variance(b).total_cmp(&variance(a)).then(a.cmp(&b)));
    let all: f64 = (0..count as u32).map(area).sum();
    let mut left: f64 = noisy.iter().map(|&s| area(s) * variance(s)).sum();
    let mut is_noisy = vec![false; count];
    for sample in noisy {
        if left <= permitted * all {
            break;
        }
        is_noisy[sample as usize] = true;
        left -= area(sample) * variance(sample);
    }
    is_noisy
}

/// Direct light of a texel from points all over what it covers.
fn over_texel(gather: DirectGather, sample: usize, places: u32) -> DirectedLight {
    let (samples, seed) = (gather.samples, gather.seed);
    let s = &samples.samples[sample];
    let coverage = &samples.pages[s.page as usize];
    let tracer = gather.gatherer.surfaces().tracer;
    let sampler = PageSampler::new(gather.atlas, tracer, coverage, s.page);
    let texel = coverage.texels[s.texel as usize];
    let [column, row] = [
        texel.index % coverage.size[0],
        texel.index / coverage.size[0],
    ];
    let corner = DVec2::new(column.into(), row.into());
    let point = |k: u32| {
        let cell = DVec2::new((k % places).into(), (k / places).into());
        let jitter = [0, 1].map(|d| f64::from(uniform(&[seed, s.page, texel.index, k, d, 0xd17])));
        let place = corner + (cell + DVec2::from(jitter)) / f64::from(places);
        let (position, normal) = sampler.seen_place(s, place)?;
        Some(GatherPoint {
            position,
            normal,
            key: hash(&[s.page, texel.index, k]),
        })
    };
    let mut order: Vec<u32> = (0..places * places).collect();
    // The rays of points side by side would go to places of a lamp side by side.
    order.sort_by_key(|&k| hash(&[seed, s.page, texel.index, k, 0x0d3]));
    let points: Vec<GatherPoint> = order.into_iter().filter_map(point).collect();
    let points = if points.is_empty() {
        vec![gather_point(samples, sample)]
    } else {
        points
    };
    gather.mean_of(&points)
}
