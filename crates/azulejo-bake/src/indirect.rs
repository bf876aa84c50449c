//! Indirect light of texels from that of some of them.
//!
//! Indirect light is gathered at the nodes of a [lattice](crate::lattice) and interpolated. A first look reads the
//! light of patches; another reads that look and is [corrected](crate::correction) by paths, so that it has
//! neither what patches leak nor what they miss; and the last, with as many rays as the requested error takes,
//! reads that.

use crate::correction::corrected;
use crate::direct::SampleDirect;
use crate::lattice::Lattice;
use crate::light::{NodeLight, NodePair, TexelLight};
use crate::nodes::Nodes;
use crate::samples::Samples;
use azulejo_scene::Rgb;
use azulejo_trace::{GatherPoint, Gathered, Progress, sequence_gain};
use std::ops::Range;

/// Texels along a side of the first cells, as a power of two.
const FIRST_LEVEL: u32 = 4;

/// The same where there are so few texels that cells would be few.
const LEAST_CELLS: usize = 1500;

/// Most divisions of cells.
const MOST_ROUNDS: u32 = 6;

/// Error of interpolation in a first look, relative to that of the result.
const LOOK_ERROR: f64 = 3.0;

/// Rays of the first gather at a node.
const FIRST_RAYS: PairRays = PairRays {
    read: 128,
    traced: 32,
};

/// Most rays of a node that read light.
const MOST_RAYS: u32 = 1 << 14;

/// Noise that a node may have before cells are divided, relative to the permitted error: more would be taken for
/// errors of interpolation.
const NODE_ERROR: f64 = 2.0;

/// Part of the permitted mean square error, or of all that is not noise, that is left to noise at least.
const LEAST_NOISE: f64 = 0.25;

/// What of a requested error is aimed at: estimated errors have errors.
const MARGIN: f64 = 0.95;

/// Cost of a path beside that of a ray that reads light.
const PATH_COST: f64 = 5.0;

/// The variance of read light falls with rays n about as n^−1.2, between random, 1, and 2-D strata, 3/2.
const READ_RATE: f64 = 1.2;

/// Largest growth of rays at once.
const GROWTH: f64 = 8.0;

/// Most times that rays are added.
const MOST_RAISES: u32 = 6;

/// Numbers of rays of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PairRays {
    /// Those that read light.
    pub read: u32,
    /// Those of them that are also path traced.
    pub traced: u32,
}

/// Nodes at which a first look is to be gathered, from rays that read patches.
pub struct LookRequest<'a> {
    /// The points.
    pub points: &'a [GatherPoint],
    /// Counts the requests.
    pub round: u32,
}

/// Nodes at which light is to be gathered in two ways.
pub struct PairRequest<'a> {
    /// The points.
    pub points: &'a [GatherPoint],
    /// The area for which each stands, square scene units.
    pub areas: &'a [f64],
    /// Which rays of each read light.
    pub read: Range<u32>,
    /// Which rays of each are path traced.
    pub traced: Range<u32>,
}

/// How the light of a lightmap was computed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TexelStatistics {
    /// Samples: about as many as texels.
    pub samples: usize,
    /// Samples at which indirect light was gathered.
    pub nodes: usize,
    /// Rays of each.
    pub rays: PairRays,
    /// Root mean square of the error that interpolation makes, W/m².
    pub interpolation: f64,
}

/// A first look at the light of all samples, for others to read: `direct`, and indirect light that
/// `gather` finds at some of them, so many that interpolation is off by a few times `error`, a share of the
/// mean; and the nodes at which it was found. Nodes are not added once the deadline of `progress` has passed.
///
/// # Errors
/// Those of `gather`.
pub fn first_look<E>(
    samples: &Samples,
    direct: &SampleDirect,
    error: f64,
    progress: &Progress,
    gather: &mut dyn FnMut(&LookRequest) -> Result<Vec<Gathered>, E>,
) -> Result<(Vec<TexelLight>, NodeLattice), E> {
    let mut nodes = Nodes::new(samples, direct, first_lattice(samples));
    let mut errors = Vec::new();
    for round in 0..=MOST_ROUNDS {
        if round > 0 {
            let coarse = nodes.coarse_cells(&errors, LOOK_ERROR * error);
            if !coarse.contains(&true) || progress.out_of_time() {
                break;
            }
            nodes.lattice.divide(samples, &coarse);
        }
        let (points, _) = nodes.targets();
        let found = gather(&LookRequest {
            points: &points,
            round,
        })?;
        nodes.light.extend(found.into_iter().map(NodeLight::from));
        nodes.measure_mean();
        errors = nodes.interpolation_errors();
    }
    Ok((nodes.interpolated(&errors), NodeLattice(nodes.lattice)))
}

/// Where a first look found light to change.
#[derive(Clone, Debug)]
pub struct NodeLattice(Lattice);

/// Another look, at the nodes of the first: reads the first, and corrects that by paths.
///
/// # Errors
/// Those of `gather`.
pub fn look_again<E>(
    samples: &Samples,
    direct: &SampleDirect,
    nodes: &NodeLattice,
    gather: &mut dyn FnMut(&PairRequest) -> Result<Vec<NodePair>, E>,
) -> Result<Vec<TexelLight>, E> {
    let mut paired = PairedNodes::new(samples, direct, nodes.0.clone());
    paired.gather_new(gather)?;
    let errors = vec![0.0; paired.nodes.lattice.len()];
    Ok(paired.nodes.interpolated(&errors))
}

/// Light of all samples: `direct`, and indirect light that `gather` finds at nodes, those of a first
/// look and more, with as many rays as bring its error to `error`, a share of the mean. `is_final` says that
/// `gather` has brought its light to that error itself. No nodes or rays are added once the deadline of
/// `progress` has passed: the errors of the light say what that leaves.
///
/// # Errors
/// Those of `gather`.
pub fn with_indirect<E>(
    samples: &Samples,
    direct: &SampleDirect,
    start: NodeLattice,
    error: f64,
    is_final: bool,
    progress: &Progress,
    gather: &mut dyn FnMut(&PairRequest) -> Result<Vec<NodePair>, E>,
) -> Result<(Vec<TexelLight>, TexelStatistics), E> {
    let mut paired = PairedNodes::new(samples, direct, start.0);
    paired.gather_new(gather)?;
    if !is_final {
        paired.quieten(error, progress, gather)?;
    }
    let mut errors = paired.nodes.interpolation_errors();
    for _ in 1..=MOST_ROUNDS {
        let coarse = paired.nodes.coarse_cells(&errors, error);
        if !coarse.contains(&true) || progress.out_of_time() {
            break;
        }
        paired.nodes.lattice.divide(samples, &coarse);
        paired.gather_new(gather)?;
        errors = paired.nodes.interpolation_errors();
    }
    if !is_final {
        for _ in 0..MOST_RAISES {
            let Some(rays) = paired.wanted(&errors, error) else {
                break;
            };
            if progress.out_of_time() {
                break;
            }
            paired.raise(rays, gather)?;
            errors = paired.nodes.interpolation_errors();
        }
    }
    let nodes = &paired.nodes;
    let area: f64 = samples.samples.iter().map(|s| f64::from(s.area)).sum();
    let squares = nodes.mean_of_cells(&errors) * area;
    let statistics = TexelStatistics {
        samples: samples.samples.len(),
        nodes: nodes.light.len(),
        rays: paired.rays,
        interpolation: (squares.max(0.0) / f64::max(area, f64::MIN_POSITIVE)).sqrt(),
    };
    Ok((nodes.interpolated(&errors), statistics))
}

/// Cells as large as leaves enough of them.
fn first_lattice(samples: &Samples) -> Lattice {
    let mut level = FIRST_LEVEL;
    let mut lattice = Lattice::new(samples, level);
    while lattice.len() < LEAST_CELLS && level > 0 {
        level -= 1;
        lattice = Lattice::new(samples, level);
    }
    lattice
}

/// Nodes at which light is gathered in two ways.
struct PairedNodes<'a> {
    nodes: Nodes<'a>,
    pairs: Vec<NodePair>,
    /// Rays that every node has.
    rays: PairRays,
}

type PairGather<'g, E> = dyn FnMut(&PairRequest) -> Result<Vec<NodePair>, E> + 'g;

impl<'a> PairedNodes<'a> {
    fn new(samples: &'a Samples, direct: &'a SampleDirect, lattice: Lattice) -> PairedNodes<'a> {
        PairedNodes {
            nodes: Nodes::new(samples, direct, lattice),
            pairs: Vec::new(),
            rays: FIRST_RAYS,
        }
    }

    /// Gathers at the nodes that have no light yet, as many rays as the others have.
    fn gather_new<E>(&mut self, gather: &mut PairGather<E>) -> Result<(), E> {
        self.nodes.light.truncate(self.pairs.len());
        let (points, areas) = self.nodes.targets();
        if !points.is_empty() {
            self.pairs.extend(gather(&PairRequest {
                points: &points,
                areas: &areas,
                read: 0..self.rays.read,
                traced: 0..self.rays.traced,
            })?);
        }
        self.update();
        Ok(())
    }

    fn update(&mut self) {
        let nodes = &mut self.nodes;
        nodes.light = corrected(nodes.samples, &nodes.lattice, &self.pairs);
        let gain = sequence_gain(self.pairs.iter().map(|p| &p.read), Rgb::mean);
        nodes
            .light
            .iter_mut()
            .for_each(|light| light.noise *= gain.sqrt());
        nodes.measure_mean();
    }

    /// Brings every node to more rays.
    fn raise<E>(&mut self, rays: PairRays, gather: &mut PairGather<E>) -> Result<(), E> {
        self.nodes.light.clear();
        let (points, areas) = self.nodes.targets();
        let more = gather(&PairRequest {
            points: &points,
            areas: &areas,
            read: self.rays.read..rays.read,
            traced: self.rays.traced..rays.traced,
        })?;
        let share = |from: u32, to: u32| f64::from(to - from) / f64::from(to);
        let read = share(self.rays.read, rays.read);
        let traced = share(self.rays.traced, rays.traced);
        for (pair, more) in self.pairs.iter_mut().zip(more) {
            pair.read = pair.read.blend(&more.read, read);
            pair.few = pair.few.blend(&more.few, traced);
            pair.traced = pair.traced.blend(&more.traced, traced);
        }
        self.rays = rays;
        self.update();
        Ok(())
    }

    /// Adds rays that read light until the noise of nodes is not taken for their differences.
    fn quieten<E>(
        &mut self,
        error: f64,
        progress: &Progress,
        gather: &mut PairGather<E>,
    ) -> Result<(), E> {
        for _ in 0..MOST_RAISES {
            let (noise, _) = self.nodes.node_noise();
            let permitted = (NODE_ERROR * error * self.nodes.mean).powi(2);
            if noise <= permitted || progress.out_of_time() {
                break;
            }
            let factor = (noise / permitted).powf(1.0 / READ_RATE);
            let read = grown(self.rays.read, factor, MOST_RAYS);
            if read == self.rays.read {
                break;
            }
            let traced = self.rays.traced;
            self.raise(PairRays { read, traced }, gather)?;
        }
        Ok(())
    }

    /// Rays that bring the error to `error`, at least cost; `None` if there are enough, or no more.
    fn wanted(&self, errors: &[f64], error: f64) -> Option<PairRays> {
        let (read, shared, rest) = self.nodes.texel_noise(errors);
        let permitted = (MARGIN * error * self.nodes.mean).powi(2);
        let budget = (permitted - rest).max(LEAST_NOISE * permitted.max(rest));
        if read + shared <= budget {
            return None;
        }
        // By Lagrange, each is in proportion to the root of what it costs.
        let cost = [
            (read * f64::from(self.rays.read)).sqrt(),
            (shared * f64::from(self.rays.traced) * PATH_COST).sqrt(),
        ];
        let scale = budget / (cost[0] + cost[1]);
        let factor = |noise: f64, cost: f64| noise / (scale * cost).max(f64::MIN_POSITIVE);
        let wanted = PairRays {
            read: grown(
                self.rays.read,
                factor(read, cost[0]).powf(1.0 / READ_RATE),
                MOST_RAYS,
            ),
            traced: grown(self.rays.traced, factor(shared, cost[1]), MOST_RAYS / 4),
        };
        let wanted = PairRays {
            read: wanted.read.max(wanted.traced),
            ..wanted
        };
        (wanted != self.rays).then_some(wanted)
    }
}

/// A number of rays times about `factor`, by powers of two.
fn grown(rays: u32, factor: f64, most: u32) -> u32 {
    let steps = factor.clamp(1.0, GROWTH).log2();
    // A third of a step more than is needed would cost a quarter more on average.
    let steps = (steps - 0.15).ceil().max(0.0) as u32;
    (rays << steps).min(most.max(rays))
}
