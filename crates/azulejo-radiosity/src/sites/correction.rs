//! Indirect light of nodes, corrected by a few paths.
//!
//! Light that is read at the ends of rays has little noise, but is as wrong as what is read: what leaks
//! into a dark cavity stays there. Path traced light is right on average, and noisy. Their difference
//! along the same rays changes slowly over a surface, so its mean over many nodes is known well: read
//! light serves as a control variate, whose coefficient is that of the regression over the nodes around
//! (Glasserman, *Monte Carlo Methods in Financial Engineering*, 2004, section 4.1). In a cavity that no
//! light reaches it is 0, and paths alone count.

use super::cells::SiteCells;
use super::light::{NodeLight, PairRays};
use super::nodes::{MOST_NEIGHBOURS, Nodes};
use super::rays::READ_RATE;
use crate::path_pairs::PathPair;
use azulejo_scene::Rgb;
use azulejo_trace::run::batches::in_batches;
use azulejo_trace::run::{Record, RecordReader};
use azulejo_trace::{Cancelled, Gathered, REPLICATES, Run};

/// Nodes over which differences are averaged: as many as leave the least error. Of few, noise is left; over many,
/// what changes from place to place is blurred.
const NEIGHBOURS: [usize; 4] = [6, 12, 24, MOST_NEIGHBOURS];

/// Cells that are worked on together.
const BATCH: usize = 64;

/// Standard errors by which the coefficient must differ from 1.
const SURE: f64 = 2.0;

/// Nodes side by side that share the light that was left out of their corrections.
const GROUP: usize = 256;

/// Least part of its light that a group keeps.
const LEAST_SHARE: f64 = 0.1;

/// Strata of brightness in which noise and variation are measured: of one node they are hardly known.
const STRATA: usize = 16;

/// The light of every node of a cells.
///
/// # Errors
/// The caller cancelled.
pub(crate) fn corrected<C: SiteCells>(
    nodes: &Nodes<C>,
    pairs: &[PathPair],
    rays: &[PairRays],
    run: Run,
) -> Result<Vec<NodeLight>, Cancelled> {
    let cells = nodes.cells();
    let around = nodes.around(run)?;
    let smooth = |count| Smoothed::new(nodes, (pairs, rays), around, count, run);
    let nearest = smooth(NEIGHBOURS[0])?;
    let strata = nearest.strata();
    // Light hardly changes between the nearest nodes: what their corrections differ by is noise (Rice, *Bandwidth
    // choice for nonparametric regression*, 1984). Replicates of one node know a part of it alone.
    let scales: Vec<f64> = strata.iter().map(|s| nearest.noise_scale(s)).collect();
    let mut best: Option<(f64, Vec<NodeLight>)> = None;
    for count in NEIGHBOURS {
        let smoothed = if count == NEIGHBOURS[0] {
            nearest.clone()
        } else {
            smooth(count)?
        };
        let (error, light) = smoothed.stated(cells, &strata, &scales);
        if best.as_ref().is_none_or(|(least, _)| error < *least) {
            best = Some((error, light));
        }
    }
    Ok(best.map_or(Vec::new(), |(_, light)| light))
}

/// The light of all nodes with corrections over this many of them.
#[derive(Clone)]
struct Smoothed {
    light: Vec<NodeLight>,
    /// For each node the mean square by which corrections around differ from their mean, (W/m²)², and what it would
    /// be from the noise of replicates alone.
    differences: Vec<[f64; 2]>,
    /// The part of each node's correction that may be noise, and was left out.
    left_out: Vec<Gathered>,
}

impl Smoothed {
    fn new<C: SiteCells>(
        nodes: &Nodes<C>,
        (pairs, rays): (&[PathPair], &[PairRays]),
        around: &[Vec<u32>],
        count: usize,
        run: Run,
    ) -> Result<Smoothed, Cancelled> {
        let cells = nodes.cells();
        let numbers: Vec<u32> = (0..cells.cell_count() as u32).collect();
        let of_cell = |&cell: &u32| {
            let around = &around[cell as usize];
            let near = &around[..around.len().min(count + 1)];
            let node = cells.node(cell as usize);
            node_light(cells, (pairs, rays), node, near)
        };
        let of_cells = in_batches(&numbers, BATCH, run, |batch| {
            Ok(batch.iter().map(of_cell).collect())
        })?;
        let mut smoothed = Smoothed {
            light: vec![NodeLight::default(); pairs.len()],
            differences: vec![[0.0; 2]; pairs.len()],
            left_out: vec![Gathered::default(); pairs.len()],
        };
        for (cell, of_node) in of_cells.into_iter().enumerate() {
            let node = cells.node(cell) as usize;
            smoothed.light[node] = of_node.light;
            smoothed.differences[node] = of_node.differences;
            smoothed.left_out[node] = of_node.left_out;
        }
        Ok(smoothed)
    }

    /// The nodes by brightness.
    fn strata(&self) -> Vec<Vec<u32>> {
        let brightness = |n: &u32| self.light[*n as usize].irradiance.mean().mean();
        let mut order: Vec<u32> = (0..self.light.len() as u32).collect();
        order.sort_by(|a, b| brightness(a).total_cmp(&brightness(b)).then(a.cmp(b)));
        let size = order.len().div_ceil(STRATA).max(1);
        order.chunks(size).map(<[u32]>::to_vec).collect()
    }

    /// Sums over a stratum of what corrections differ by, and of what they would by the noise of replicates.
    fn sums(&self, stratum: &[u32]) -> [f64; 2] {
        stratum.iter().fold([0.0; 2], |[a, b], &n| {
            let [difference, expected] = self.differences[n as usize];
            [a + difference, b + expected]
        })
    }

    /// Variance of corrections relative to that of replicates.
    fn noise_scale(&self, stratum: &[u32]) -> f64 {
        let [difference, expected] = self.sums(stratum);
        if expected > 0.0 {
            difference / expected
        } else {
            1.0
        }
    }

    /// Makes the light of each group of nodes more or less by what was left out of their corrections: light that few
    /// paths find is noise at any one of them, and would be missing in all. What is dark stays dark.
    fn restore<C: SiteCells>(&mut self, cells: &C, areas: &[f64]) {
        let numbers: Vec<usize> = (0..cells.cell_count()).collect();
        for group in numbers.chunks(GROUP) {
            let (mut left, mut all) = (Gathered::default(), Rgb::BLACK);
            for &cell in group {
                let node = cells.node(cell) as usize;
                let of_node = self.left_out[node].replicates.map(|r| r * areas[cell]);
                left = left.plus(&Gathered {
                    replicates: of_node,
                });
                all += self.light[node].irradiance.mean() * areas[cell];
            }
            // Relative to the light of the group, channel by channel.
            let per_light = all.map(|light| if light > 0.0 { 1.0 / light } else { 0.0 });
            let share = left.mean() * per_light;
            let factor = share.map(|s| (1.0 + s).max(LEAST_SHARE));
            let doubt = left.variance().map(f64::sqrt) * per_light;
            for &cell in group {
                let light = &mut self.light[cells.node(cell) as usize];
                let noise = light.irradiance.mean() * doubt;
                let square = light.shared_noise * light.shared_noise + noise * noise;
                light.shared_noise = square.map(f64::sqrt);
                light.irradiance.replicates = light.irradiance.replicates.map(|r| r * factor);
            }
        }
    }

    /// The light with its errors, and the mean square of those by area, (W/m²)².
    fn stated<C: SiteCells>(
        mut self,
        cells: &C,
        strata: &[Vec<u32>],
        scales: &[f64],
    ) -> (f64, Vec<NodeLight>) {
        for (stratum, &scale) in strata.iter().zip(scales) {
            let [difference, expected] = self.sums(stratum);
            let variation = (difference - scale * expected) / stratum.len() as f64;
            for &n in stratum {
                let light = &mut self.light[n as usize];
                light.shared_noise *= scale.sqrt();
                light.bias = variation.max(0.0).sqrt();
            }
        }
        let areas: Vec<f64> = (0..cells.cell_count())
            .map(|cell| cells.cell_area(cell))
            .collect();
        self.restore(cells, &areas);
        let (mut squares, mut area) = (0.0, 0.0);
        for (cell, &of_cell) in areas.iter().enumerate() {
            let light = &self.light[cells.node(cell) as usize];
            let noise = light.shared_noise * light.shared_noise;
            squares += of_cell * (noise.mean() + light.bias.powi(2));
            area += of_cell;
        }
        (squares / f64::max(area, f64::MIN_POSITIVE), self.light)
    }
}

/// The light of a node, with what is known of its correction.
struct FoundLight {
    light: NodeLight,
    /// The mean square by which the corrections of single nodes around differ from their mean, and what that would
    /// be by the noise of their replicates, (W/m²)².
    differences: [f64; 2],
    /// What was left out of the correction.
    left_out: Gathered,
}

impl Record for FoundLight {
    fn write(&self, bytes: &mut Vec<u8>) {
        self.light.write(bytes);
        self.differences.write(bytes);
        self.left_out.write(bytes);
    }

    fn read(bytes: &mut RecordReader) -> Option<FoundLight> {
        Some(FoundLight {
            light: Record::read(bytes)?,
            differences: Record::read(bytes)?,
            left_out: Record::read(bytes)?,
        })
    }
}

/// The light of a node from its pair and those around.
fn node_light<C: SiteCells>(
    cells: &C,
    (pairs, rays): (&[PathPair], &[PairRays]),
    node: u32,
    around: &[u32],
) -> FoundLight {
    let read = pairs[node as usize].read;
    let weights = weights(cells, node, around);
    let coefficient = coefficient(pairs, around, &weights);
    // The correction of what is read, and its variance.
    let mut correction = read.mean() * (coefficient - 1.0);
    let mut variance = read.variance() * (1.0 - coefficient).powi(2);
    let (mut rests, mut own_noise, mut noise) = (Rgb::BLACK, 0.0, Rgb::BLACK);
    let mut whole = Gathered {
        replicates: read.replicates.map(|r| r * (coefficient - 1.0)),
    };
    for (&n, &w) in around.iter().zip(&weights) {
        let rest = difference(&pairs[n as usize], coefficient);
        rests += rest.mean() * w;
        whole = whole.plus(&Gathered {
            replicates: rest.replicates.map(|r| r * w),
        });
        variance += rest.variance() * (w * w);
        own_noise += w * rest.variance().mean();
        // What others would vary with as many rays as this one.
        let fewer = f64::from(rays[n as usize].read) / f64::from(rays[node as usize].read.max(1));
        noise += pairs[n as usize].read.variance() * (w * fewer.powf(READ_RATE));
    }
    correction += rests;
    let squares = around.iter().zip(&weights).map(|(&n, &w)| {
        let off = difference(&pairs[n as usize], coefficient).mean() - rests;
        w * (off * off).mean()
    });
    let concentration: f64 = weights.iter().map(|w| w * w).sum();
    let differences = [squares.sum(), own_noise * (1.0 - concentration)];
    // What may be noise alone is not corrected (James and Stein, *Estimation with quadratic loss*, 1961).
    let square = (correction * correction).mean();
    let share = if square > variance.mean() {
        1.0 - variance.mean() / square
    } else {
        0.0
    };
    let light = NodeLight {
        irradiance: Gathered {
            replicates: read.replicates.map(|r| r + correction * share),
        },
        noise: noise.map(f64::sqrt),
        shared_noise: variance.map(|v| share.sqrt() * v.sqrt()),
        bias: 0.0,
    };
    let left_out = Gathered {
        replicates: whole.replicates.map(|r| r * (1.0 - share)),
    };
    FoundLight {
        light,
        differences,
        left_out,
    }
}

/// What paths have beyond `coefficient` times what is read along the same rays.
fn difference(pair: &PathPair, coefficient: f64) -> Gathered {
    let of = |r: usize| pair.traced.replicates[r] - pair.few.replicates[r] * coefficient;
    Gathered {
        replicates: std::array::from_fn(of),
    }
}

/// Weights of the nodes around one, larger for those near; their sum is 1.
fn weights<C: SiteCells>(cells: &C, node: u32, around: &[u32]) -> Vec<f64> {
    let at = |n: u32| cells.place(cells.nodes()[n as usize]);
    let centre = at(node);
    let reach = around
        .iter()
        .map(|&n| cells.distance(at(n), centre))
        .fold(0.0, f64::max);
    let weight = |&n: &u32| {
        let share = cells.distance(at(n), centre) / (1.05 * reach).max(f64::MIN_POSITIVE);
        (1.0 - share * share).max(0.0)
    };
    let weights: Vec<f64> = around.iter().map(weight).collect();
    let sum: f64 = weights.iter().sum();
    weights.into_iter().map(|w| w / sum).collect()
}

/// How much paths change with what is read along the same rays, 0 to 1: less than 1 only as far as that is
/// sure, because the mean over many nodes blurs what is left to paths.
fn coefficient(pairs: &[PathPair], around: &[u32], weights: &[f64]) -> f64 {
    let (mut both, mut own, mut other) = (0.0, 0.0, 0.0);
    for (&n, w) in around.iter().zip(weights) {
        let pair = &pairs[n as usize];
        let (traced, few) = (pair.traced.mean(), pair.few.mean());
        for (&t, &f) in pair.traced.replicates.iter().zip(&pair.few.replicates) {
            both += w * ((t - traced) * (f - few)).mean();
            own += w * ((f - few) * (f - few)).mean();
            other += w * ((t - traced) * (t - traced)).mean();
        }
    }
    if own <= 0.0 {
        return 1.0;
    }
    let slope = both / own;
    // The square of the slope's standard error, from what the line leaves of the replicates.
    let squares: f64 = weights.iter().map(|w| w * w).sum();
    let left = (other - slope * both).max(0.0);
    let doubt = squares * left / (own * (REPLICATES - 1) as f64);
    let short = 1.0 - slope;
    let share = 1.0 - SURE * SURE * doubt / (short * short).max(f64::MIN_POSITIVE);
    (1.0 - short * share.max(0.0)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gathered(values: [f64; 4]) -> Gathered {
        Gathered {
            replicates: values.map(Rgb::grey),
        }
    }

    #[test]
    fn what_is_read_counts_as_far_as_paths_follow_it() {
        let read = gathered([1.0, 1.2, 0.9, 0.9]);
        let pair = |traced| PathPair {
            read,
            few: read,
            traced,
        };
        let follows = pair(gathered([0.8, 1.0, 0.7, 0.7]));
        let dark = pair(gathered([0.0; 4]));
        let of =
            |pair: PathPair| coefficient(&[pair; 9], &[0, 1, 2, 3, 4, 5, 6, 7, 8], &[1.0 / 9.0; 9]);
        assert!((of(follows) - 1.0).abs() < 1e-12);
        assert!(of(dark).abs() < 1e-12);
    }
}
