//! Indirect light at many sites from that at some of them.
//!
//! Indirect light is gathered at the nodes of [cells](SiteCells) and interpolated. A first look reads the
//! light of patches; another reads that look and is corrected by paths, so that it has
//! neither what patches leak nor what they miss; and the last, with as many rays as the requested error takes,
//! reads that.

use super::cells::SiteCells;
use super::correction::corrected;
use super::light::{NodeLight, PairRays, SiteDirect, SiteLight};
use super::nodes::Nodes;
use super::rays::{NodeNoise, allocated};
use crate::path_pairs::{PairTargets, PathPair};
use azulejo_scene::Rgb;
use azulejo_trace::time::Instant;
use azulejo_trace::{Cancelled, GatherPoint, Gathered, Progress, REPLICATES, Run, sequence_gain};
use std::collections::BTreeMap;

/// Most divisions of cells.
const MOST_ROUNDS: u32 = 6;

/// Error of interpolation in a first look, relative to that of the result.
const LOOK_ERROR: f64 = 3.0;

/// Rays of the first gather at a node, where there are few nodes.
const FIRST_RAYS: PairRays = PairRays {
    read: 128,
    traced: 32,
};

/// With this many nodes each gets half as many rays at first, with twice as many a quarter.
const MANY_NODES: usize = 16_384;

/// Times that these are halved once the deadline has passed.
const LATE: u32 = 2;

/// Noise that a node may have before cells are divided, relative to the permitted error: more would be taken for
/// errors of interpolation.
const NODE_ERROR: f64 = 2.0;

/// Part of the permitted mean square error, or of all that is not noise, that is left to noise at least.
const LEAST_NOISE: f64 = 0.4;

/// Part of the permitted mean square noise that is aimed at when rays are added, so that one time suffices.
const AIM: f64 = 0.85;

/// What of a requested error is aimed at: estimated errors have errors.
const MARGIN: f64 = 0.95;

/// Most nodes that get more rays between two looks at a clock that matters, and the share of the time until a deadline
/// that these may take.
const BETWEEN_LOOKS: usize = 2048;
const BETWEEN_SHARE: f64 = 0.05;

/// Nodes with the fewest rays that tell, before a deadline, what a path takes: in white rooms paths are long.
const SAMPLED: usize = 64;
const SAMPLE_RAYS: PairRays = PairRays {
    read: 4 * REPLICATES as u32,
    traced: REPLICATES as u32,
};

/// Share of the time until a deadline that the first gather at all nodes may take.
const FIRST_SHARE: f64 = 0.25;

/// Rays that read light in the time of a path.
const READ_PER_PATH: u32 = 8;

/// Share of the time until a deadline that new nodes may take. Those of a first look get light again in every gather
/// after it, from more rays.
const NEW_SHARE: f64 = 0.5;
const NEW_LOOK_SHARE: f64 = 0.1;

/// Most times that rays are added.
const MOST_RAISES: u32 = 6;

/// The error that indirect light may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IndirectGoal {
    /// Root mean square over the mean.
    pub relative: f64,
    /// What it may be at least, W/m²: a small part of other errors, which less would not help.
    pub least: f64,
}

impl IndirectGoal {
    /// The error where the mean is this, W/m².
    fn permitted(&self, mean: f64) -> f64 {
        (self.relative * mean).max(self.least)
    }
}

/// How the light of sites was computed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SiteStatistics {
    /// Sites.
    pub sites: usize,
    /// Sites at which indirect light was gathered.
    pub nodes: usize,
}

/// The indirect light at points, from rays that read that of patches.
pub type LookGather<'g, E> = dyn FnMut(&[GatherPoint]) -> Result<Vec<Gathered>, E> + 'g;

/// A first look at the light of all sites, for others to read: `direct`, and indirect light that
/// `gather` finds at the nodes of cells, divided until interpolation is off by a few times `goal`; and these cells.
/// None are divided if that would take too much of the time until a deadline.
///
/// # Errors
/// Those of `gather`.
pub fn first_look<C: SiteCells, E: From<Cancelled>>(
    cells: C,
    direct: &SiteDirect,
    goal: IndirectGoal,
    run: Run,
    gather: &mut LookGather<E>,
) -> Result<(Vec<SiteLight>, C), E> {
    let mut nodes = Nodes::new(direct, cells);
    let mut errors = Vec::new();
    let mut pace = NodePace::default();
    for round in 0..=MOST_ROUNDS {
        if round > 0 {
            let coarse = nodes.coarse_cells(&errors, LOOK_ERROR * goal.permitted(nodes.mean));
            if !coarse.contains(&true) || pace.is_late(&coarse, NEW_LOOK_SHARE, run.progress) {
                break;
            }
            nodes.divide(&coarse);
        }
        let (points, _) = nodes.targets();
        let light = pace.timed(points.len(), || gather(&points))?;
        nodes.light.extend(light.into_iter().map(NodeLight::from));
        nodes.measure_mean();
        errors = nodes.interpolation_errors(run)?;
    }
    let light = nodes.interpolated(&errors, run)?;
    Ok((light, nodes.into_cells()))
}

/// Another look, at the nodes of the first: reads the first, and corrects that by paths.
///
/// # Errors
/// Those of `gather`.
pub fn look_again<C: SiteCells, E: From<Cancelled>>(
    cells: &C,
    direct: &SiteDirect,
    run: Run,
    gather: &mut PairGather<E>,
) -> Result<Vec<SiteLight>, E> {
    let mut paired = PairedNodes::new(cells.clone(), direct, run);
    paired.gather_new(&mut NodePace::default(), gather)?;
    let errors = vec![0.0; paired.nodes.cells().cell_count()];
    Ok(paired.nodes.interpolated(&errors, run)?)
}

/// Light of all sites: `direct`, and indirect light that `gather` finds at the nodes of cells, such as those of a first
/// look, and more, with as many rays as bring its error to `goal`. `is_final` says that `gather` has brought its light to
/// that error itself. No nodes or rays are added for which there is no time before a deadline: the errors of the light
/// say what that leaves.
///
/// # Errors
/// Those of `gather`.
pub fn with_indirect<C: SiteCells, E: From<Cancelled>>(
    cells: C,
    direct: &SiteDirect,
    goal: IndirectGoal,
    is_final: bool,
    run: Run,
    gather: &mut PairGather<E>,
) -> Result<(Vec<SiteLight>, SiteStatistics), E> {
    // Gather at the nodes, with noise so small that it is not taken for their differences.
    let mut paired = PairedNodes::new(cells, direct, run);
    let mut pace = NodePace::default();
    paired.gather_new(&mut pace, gather)?;
    if !is_final {
        paired.quieten(goal, gather)?;
    }
    // Divide cells where interpolation is too coarse.
    let mut errors = paired.nodes.interpolation_errors(run)?;
    for _ in 1..=MOST_ROUNDS {
        let permitted = goal.permitted(paired.nodes.mean);
        let coarse = paired.nodes.coarse_cells(&errors, permitted);
        if !coarse.contains(&true) || pace.is_late(&coarse, NEW_SHARE, run.progress) {
            break;
        }
        paired.nodes.divide(&coarse);
        paired.gather_new(&mut pace, gather)?;
        errors = paired.nodes.interpolation_errors(run)?;
    }
    // Add rays where they lower the error at least cost.
    if !is_final {
        for _ in 0..MOST_RAISES {
            let Some(rays) = paired.wanted(&errors, goal)? else {
                break;
            };
            if run.progress.out_of_time() {
                break;
            }
            paired.raise(&rays, gather)?;
            errors = paired.nodes.interpolation_errors(run)?;
        }
    }
    let nodes = &paired.nodes;
    let statistics = SiteStatistics {
        sites: nodes.cells().site_count(),
        nodes: nodes.light.len(),
    };
    Ok((nodes.interpolated(&errors, run)?, statistics))
}

/// The time that nodes take, to foresee that of more of them before a deadline.
#[derive(Default)]
struct NodePace {
    seconds: f64,
    nodes: usize,
}

impl NodePace {
    /// Gathers light at so many nodes.
    fn timed<T>(&mut self, nodes: usize, gather: impl FnOnce() -> T) -> T {
        let started = Instant::now();
        let light = gather();
        self.seconds += started.elapsed().as_secs_f64();
        self.nodes += nodes;
        light
    }

    /// Whether the nodes that dividing these cells adds would take more than a share of the time until a deadline.
    fn is_late(&self, is_divided: &[bool], share: f64, progress: &Progress) -> bool {
        let Some(left) = progress.time_left() else {
            return false;
        };
        // Each cell becomes four, of which one has its node.
        let new = 3 * is_divided.iter().filter(|divided| **divided).count();
        let seconds = self.seconds * new as f64 / self.nodes.max(1) as f64;
        seconds >= share * left.as_secs_f64()
    }
}

/// Rays of the first gather at each of this many nodes, fewer once there is no time.
fn first_rays(nodes: usize, progress: &Progress) -> PairRays {
    let late = if progress.out_of_time() { LATE } else { 0 };
    let halvings = (nodes / MANY_NODES)
        .min(3)
        .checked_ilog2()
        .map_or(0, |log| log + 1);
    // A path for each of the replicates is left.
    let halvings = (halvings + late).min(FIRST_RAYS.traced.ilog2() - REPLICATES.ilog2());
    PairRays {
        read: FIRST_RAYS.read >> halvings,
        traced: FIRST_RAYS.traced >> halvings,
    }
}

/// Nodes at which light is gathered in two ways.
struct PairedNodes<'a, C> {
    nodes: Nodes<'a, C>,
    pairs: Vec<PathPair>,
    /// Rays that each node has.
    rays: Vec<PairRays>,
    /// What a path takes, s; measured where there is a deadline.
    path_seconds: f64,
    run: Run<'a>,
}

/// The light at the nodes of each request, in their order.
pub type PairGather<'g, E> = dyn FnMut(&[PairTargets]) -> Result<Vec<Vec<PathPair>>, E> + 'g;

impl<'a, C: SiteCells> PairedNodes<'a, C> {
    fn new(cells: C, direct: &'a SiteDirect, run: Run<'a>) -> PairedNodes<'a, C> {
        PairedNodes {
            run,
            nodes: Nodes::new(direct, cells),
            pairs: Vec::new(),
            rays: Vec::new(),
            path_seconds: 0.0,
        }
    }

    /// Gathers at the nodes that have no light yet.
    fn gather_new<E: From<Cancelled>>(
        &mut self,
        pace: &mut NodePace,
        gather: &mut PairGather<E>,
    ) -> Result<(), E> {
        self.nodes.light.truncate(self.pairs.len());
        let (points, areas) = self.nodes.targets();
        if !points.is_empty() {
            let rays = first_rays(self.nodes.cells().cell_count(), self.run.progress);
            let rays = self.affordable((&points, &areas), rays, gather)?;
            self.rays.resize(self.rays.len() + points.len(), rays);
            let request = PairTargets {
                points: &points,
                areas: &areas,
                read: 0..rays.read,
                traced: 0..rays.traced,
            };
            let gathered = pace.timed(points.len(), || gather(&[request]))?;
            self.pairs.extend(gathered.into_iter().flatten());
        }
        self.update()?;
        Ok(())
    }

    /// So many rays, or as many as there is time for before a deadline, by a few paths from some of the points.
    fn affordable<E: From<Cancelled>>(
        &mut self,
        (points, areas): (&[GatherPoint], &[f64]),
        mut rays: PairRays,
        gather: &mut PairGather<E>,
    ) -> Result<PairRays, E> {
        let Some(left) = self.run.progress.time_left() else {
            return Ok(rays);
        };
        let step = points.len().div_ceil(SAMPLED);
        let sampled: Vec<GatherPoint> = points.iter().step_by(step).copied().collect();
        let of_sampled: Vec<f64> = areas.iter().step_by(step).copied().collect();
        let started = Instant::now();
        gather(&[PairTargets {
            points: &sampled,
            areas: &of_sampled,
            read: 0..SAMPLE_RAYS.read,
            traced: 0..SAMPLE_RAYS.traced,
        }])?;
        let paths = f64::from(SAMPLE_RAYS.traced) * sampled.len() as f64;
        self.path_seconds = started.elapsed().as_secs_f64() / paths;
        let seconds =
            |rays: PairRays| self.path_seconds * f64::from(rays.traced) * points.len() as f64;
        let most = FIRST_SHARE * left.as_secs_f64();
        while rays.traced > SAMPLE_RAYS.traced && seconds(rays) > most {
            rays.read /= 2;
            rays.traced /= 2;
        }
        Ok(rays)
    }

    /// Nodes that get so many more rays together, until there is another look at a clock that matters.
    fn together(&self, [read, to_read, traced, to_traced]: [u32; 4]) -> usize {
        let Some(left) = self.run.progress.time_left() else {
            return usize::MAX;
        };
        let paths =
            f64::from(to_traced - traced) + f64::from(to_read - read) / f64::from(READ_PER_PATH);
        let nodes = BETWEEN_SHARE * left.as_secs_f64() / (self.path_seconds * paths);
        (nodes as usize).clamp(1, BETWEEN_LOOKS)
    }

    fn update(&mut self) -> Result<(), Cancelled> {
        let nodes = &mut self.nodes;
        nodes.light = corrected(nodes, &self.pairs, &self.rays, self.run)?;
        let gain = sequence_gain(self.pairs.iter().map(|p| &p.read), Rgb::mean);
        nodes
            .light
            .iter_mut()
            .for_each(|light| light.noise *= gain.sqrt());
        nodes.measure_mean();
        Ok(())
    }

    /// Brings nodes to more rays, as many of them as there is time for.
    fn raise<E: From<Cancelled>>(
        &mut self,
        rays: &[PairRays],
        gather: &mut PairGather<E>,
    ) -> Result<(), E> {
        self.nodes.light.clear();
        let (points, areas) = self.nodes.targets();
        // Nodes that get the same rays are gathered together.
        let mut alike: BTreeMap<[u32; 4], Vec<usize>> = BTreeMap::new();
        for (node, (old, new)) in self.rays.iter().zip(rays).enumerate() {
            if old != new {
                let ranges = [old.read, new.read, old.traced, new.traced];
                alike.entry(ranges).or_default().push(node);
            }
        }
        let share = |from: u32, to: u32| f64::from(to - from) / f64::from(to.max(1));
        // All at once, so that processes that share the work meet once; before a deadline one part after the other.
        let at_once = if self.run.progress.has_deadline() {
            1
        } else {
            alike.len().max(1)
        };
        let parts = alike.iter().flat_map(|(range, members)| {
            let parts = members.chunks(self.together(*range).min(members.len()));
            parts.map(move |members| (*range, members))
        });
        let parts: Vec<([u32; 4], &[usize])> = parts.collect();
        for parts in parts.chunks(at_once) {
            if self.run.progress.out_of_time() {
                break;
            }
            let targets = parts.iter().map(|(_, members)| {
                let points: Vec<GatherPoint> = members.iter().map(|&n| points[n]).collect();
                let areas: Vec<f64> = members.iter().map(|&n| areas[n]).collect();
                (points, areas)
            });
            let targets: Vec<(Vec<GatherPoint>, Vec<f64>)> = targets.collect();
            let requests = parts.iter().zip(&targets).map(|((range, _), target)| {
                let &[read, to_read, traced, to_traced] = range;
                PairTargets {
                    points: &target.0,
                    areas: &target.1,
                    read: read..to_read,
                    traced: traced..to_traced,
                }
            });
            let pairs = gather(&requests.collect::<Vec<_>>())?;
            for (&([read, to_read, traced, to_traced], members), added) in parts.iter().zip(pairs) {
                let (read, traced) = (share(read, to_read), share(traced, to_traced));
                for (&node, more) in members.iter().zip(added) {
                    self.rays[node] = rays[node];
                    let pair = &mut self.pairs[node];
                    pair.read = pair.read.blend(&more.read, read);
                    pair.few = pair.few.blend(&more.few, traced);
                    pair.traced = pair.traced.blend(&more.traced, traced);
                }
            }
        }
        self.update()?;
        Ok(())
    }

    /// Adds rays that read light until the noise of nodes is not taken for their differences.
    fn quieten<E: From<Cancelled>>(
        &mut self,
        goal: IndirectGoal,
        gather: &mut PairGather<E>,
    ) -> Result<(), E> {
        for _ in 0..MOST_RAISES {
            let (noise, _) = self.nodes.node_noise();
            let permitted = (NODE_ERROR * goal.permitted(self.nodes.mean)).powi(2);
            if noise <= permitted || self.run.progress.out_of_time() {
                break;
            }
            let rays = self.allocated([1.0, 0.0], permitted);
            if rays == self.rays {
                break;
            }
            self.raise(&rays, gather)?;
        }
        Ok(())
    }

    /// Rays that bring the error to `goal`, at least cost; `None` if there are enough, or no more.
    fn wanted(
        &self,
        errors: &[f64],
        goal: IndirectGoal,
    ) -> Result<Option<Vec<PairRays>>, Cancelled> {
        let (read, shared, rest) = self.nodes.texel_noise(errors, self.run)?;
        let permitted = (MARGIN * goal.permitted(self.nodes.mean)).powi(2);
        let budget = (permitted - rest).max(LEAST_NOISE * permitted.max(rest));
        if read + shared <= budget {
            return Ok(None);
        }
        // Interpolation averages the noise of nodes.
        let averaged = read / self.nodes.node_noise().0.max(f64::MIN_POSITIVE);
        let rays = self.allocated([averaged, 1.0], budget);
        Ok((rays != self.rays).then_some(rays))
    }

    /// Rays with which the mean square noise is as permitted, if that of read light and of corrections counts by
    /// these factors.
    fn allocated(&self, factors: [f64; 2], permitted: f64) -> Vec<PairRays> {
        let (mut noise, mut area) = (vec![NodeNoise::default(); self.rays.len()], 0.0);
        for cell in 0..self.nodes.cells().cell_count() {
            let node = self.nodes.cells().node(cell) as usize;
            let light = &self.nodes.light[node];
            let of_cell = self.nodes.cells().cell_area(cell);
            let square = |noise: Rgb| of_cell * (noise * noise).mean();
            noise[node].read += factors[0] * square(light.noise);
            noise[node].traced += factors[1] * square(light.shared_noise);
            area += of_cell;
        }
        allocated(&self.rays, &noise, AIM * permitted * area)
    }
}
