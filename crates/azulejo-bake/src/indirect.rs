//! Indirect light of texels from that of some of them.
//!
//! Indirect light is gathered at the nodes of a [lattice](crate::lattice). Leaving out a node and
//! interpolating it from the others measures the error of interpolation, beyond the noise of both;
//! cells are divided where it is largest, until it is a small part of what is permitted.

use crate::direct::{SampleDirect, gather_point};
use crate::lattice::{Lattice, place, weights};
use crate::light::TexelLight;
use crate::samples::Samples;
use azulejo_scene::Rgb;
use azulejo_trace::{GatherPoint, Gathered};
use glam::DVec2;
use rayon::prelude::*;

/// Texels along a side of the first cells, as a power of two.
const FIRST_LEVEL: u32 = 4;

/// The same where there are so few texels that cells would be few.
const LEAST_CELLS: usize = 1500;

/// Part of the permitted mean square error that interpolation may make.
const SHARE: f64 = 0.25;

/// Mean square error of interpolation at a texel relative to that at a node that was left out, which is
/// farther from the others.
const LEFT_OUT: f64 = 0.5;

/// The same after its cell was divided, where light is smooth.
const DIVIDED: f64 = 0.25;

/// Most divisions.
const MOST_ROUNDS: u32 = 6;

/// Error that nodes may have, relative to the permitted one: interpolation averages their noise.
const NODE_ERROR: f64 = 1.5;

/// Error of interpolation in a first look, relative to that of the result.
const LOOK_ERROR: f64 = 3.0;

/// Indirect light of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NodeLight {
    /// Irradiance, W/m².
    pub irradiance: Gathered,
    /// Its standard error.
    pub standard_error: Rgb,
}

/// Points at which indirect light is to be gathered.
pub struct NodeRequest<'a> {
    /// The points.
    pub points: &'a [GatherPoint],
    /// The area for which each stands, square scene units.
    pub areas: &'a [f64],
    /// The error that is permitted, relative to the mean light of these points; `None` for a first
    /// look.
    pub error: Option<f64>,
    /// Counts the requests.
    pub round: u32,
}

/// How the light of a lightmap was computed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TexelStatistics {
    /// Samples: about as many as texels.
    pub samples: usize,
    /// Samples at which indirect light was gathered.
    pub nodes: usize,
    /// Root mean square of the error that interpolation makes, W/m².
    pub interpolation: f64,
}

/// A first look at the light of all samples, for others to read: `direct`, and indirect light that
/// `gather` finds at some of them, so many that interpolation is off by a few times
/// `error`; and the nodes at which it was found.
///
/// # Errors
/// Those of `gather`.
pub fn first_look<E>(
    samples: &Samples,
    direct: &SampleDirect,
    error: f64,
    gather: &mut dyn FnMut(&NodeRequest) -> Result<Vec<NodeLight>, E>,
) -> Result<(Vec<TexelLight>, NodeLattice), E> {
    let mut nodes = Nodes::new(samples, direct, first_lattice(samples), LOOK_ERROR * error);
    nodes.is_look = true;
    let errors = nodes.refine(gather)?;
    Ok((nodes.interpolated(&errors), NodeLattice(nodes.lattice)))
}

/// Where a first look found light to change.
pub struct NodeLattice(Lattice);

/// Light of all samples: `direct`, and indirect light that `gather` finds at nodes, those of a first
/// look and more; its error is to be `error` of the mean.
///
/// # Errors
/// Those of `gather`.
pub fn with_indirect<E>(
    samples: &Samples,
    direct: &SampleDirect,
    start: NodeLattice,
    error: f64,
    gather: &mut dyn FnMut(&NodeRequest) -> Result<Vec<NodeLight>, E>,
) -> Result<(Vec<TexelLight>, TexelStatistics), E> {
    let mut nodes = Nodes::new(samples, direct, start.0, error);
    let errors = nodes.refine(gather)?;
    let light = nodes.interpolated(&errors);
    let area: f64 = samples.samples.iter().map(|s| f64::from(s.area)).sum();
    let squares: f64 = (0..nodes.lattice.len())
        .map(|cell| nodes.cell_area(cell) * errors[cell])
        .sum();
    let statistics = TexelStatistics {
        samples: samples.samples.len(),
        nodes: nodes.light.len(),
        interpolation: (squares.max(0.0) / f64::max(area, f64::MIN_POSITIVE)).sqrt(),
    };
    Ok((light, statistics))
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

/// The nodes of a lattice with their light.
struct Nodes<'a> {
    samples: &'a Samples,
    direct: &'a SampleDirect,
    lattice: Lattice,
    light: Vec<NodeLight>,
    /// Mean irradiance of all samples, W/m².
    mean: f64,
    error: f64,
    is_look: bool,
}

impl<'a> Nodes<'a> {
    fn new(
        samples: &'a Samples,
        direct: &'a SampleDirect,
        lattice: Lattice,
        error: f64,
    ) -> Nodes<'a> {
        Nodes {
            samples,
            direct,
            lattice,
            light: Vec::new(),
            mean: 0.0,
            error,
            is_look: false,
        }
    }

    /// Gathers at nodes, and at more of them where interpolation is too coarse. Returns its mean square
    /// error by cell.
    fn refine<E>(
        &mut self,
        gather: &mut dyn FnMut(&NodeRequest) -> Result<Vec<NodeLight>, E>,
    ) -> Result<Vec<f64>, E> {
        self.gather(0, gather)?;
        let mut errors = self.interpolation_errors();
        for round in 1..=MOST_ROUNDS {
            let coarse = self.coarse_cells(&errors);
            if !coarse.contains(&true) {
                break;
            }
            self.lattice.divide(self.samples, &coarse);
            self.gather(round, gather)?;
            errors = self.interpolation_errors();
        }
        Ok(errors)
    }

    fn cell_area(&self, cell: usize) -> f64 {
        let area = |&s: &u32| f64::from(self.samples.samples[s as usize].area);
        self.lattice.samples(cell).iter().map(area).sum()
    }

    fn direct_of(&self, sample: u32) -> Rgb {
        Rgb::from(self.direct.irradiance[sample as usize].map(f64::from))
    }

    /// Gathers at all nodes that have no light yet.
    fn gather<E>(
        &mut self,
        round: u32,
        gather: &mut dyn FnMut(&NodeRequest) -> Result<Vec<NodeLight>, E>,
    ) -> Result<(), E> {
        let known = self.light.len();
        let new = &self.lattice.nodes[known..];
        if new.is_empty() {
            return Ok(());
        }
        let points: Vec<GatherPoint> = new
            .iter()
            .map(|&s| gather_point(self.samples, s as usize))
            .collect();
        let mut areas = vec![0.0; new.len()];
        for cell in 0..self.lattice.len() {
            if let Some(of_node) = (self.lattice.node(cell) as usize).checked_sub(known) {
                areas[of_node] += self.cell_area(cell);
            }
        }
        let brightness = self.brightness(new, &areas);
        let error = (!self.is_look).then_some(NODE_ERROR * self.error * brightness);
        let found = gather(&NodeRequest {
            points: &points,
            areas: &areas,
            error,
            round,
        })?;
        self.light.extend(found);
        if known == 0 {
            let all: f64 = areas.iter().sum();
            let of_nodes = self.lattice.nodes.iter().zip(&self.light).zip(&areas);
            let light = |((&s, l), a): ((&u32, &NodeLight), &f64)| {
                (self.direct_of(s) + l.irradiance.mean()).mean() * a
            };
            self.mean = of_nodes.map(light).sum::<f64>() / f64::max(all, f64::MIN_POSITIVE);
        }
        Ok(())
    }

    /// The mean light of all nodes, relative to that of these: in the dark, less is permitted.
    fn brightness(&self, nodes: &[u32], areas: &[f64]) -> f64 {
        if self.light.is_empty() {
            return 1.0;
        }
        let all: f64 = areas.iter().sum();
        let direct = nodes.iter().zip(areas);
        let direct: f64 = direct.map(|(&s, a)| self.direct_of(s).mean() * a).sum();
        let indirect = self.light.iter().map(|l| l.irradiance.mean().mean());
        let indirect = indirect.sum::<f64>() / self.light.len() as f64;
        let here = direct / f64::max(all, f64::MIN_POSITIVE) + indirect;
        (self.mean / f64::max(here, f64::MIN_POSITIVE)).clamp(0.25, 16.0)
    }

    /// For each cell the mean square error of interpolating in it, (W/m²)², mean of the channels.
    fn interpolation_errors(&self) -> Vec<f64> {
        let around = self.lattice.nodes_around(self.samples);
        let own: Vec<f64> = (0..self.lattice.len())
            .into_par_iter()
            .map(|cell| self.left_out(cell, &around[cell]))
            .collect();
        let mut of_node = vec![0.0; self.light.len()];
        for (cell, &error) in own.iter().enumerate() {
            of_node[self.lattice.node(cell) as usize] = error;
        }
        // One difference has one degree of freedom; those around it say more.
        let pooled = |nodes: &Vec<u32>| {
            let sum: f64 = nodes.iter().map(|&n| of_node[n as usize]).sum();
            LEFT_OUT * (sum / nodes.len().max(1) as f64).max(0.0)
        };
        around.iter().map(pooled).collect()
    }

    /// The squared difference between a cell's node and what those around it give, less its noise.
    fn left_out(&self, cell: usize, around: &[u32]) -> f64 {
        let own = self.lattice.node(cell);
        let others: Vec<u32> = around.iter().copied().filter(|&n| n != own).collect();
        if others.len() < 3 {
            return 0.0;
        }
        let node = self.lattice.nodes[own as usize];
        let places = self.places(&others);
        let mut shares = Vec::new();
        weights(place(self.samples, node), &places, &mut shares);
        let mut difference = self.light[own as usize].irradiance;
        for (&n, w) in others.iter().zip(shares) {
            let other = self.light[n as usize].irradiance;
            for (d, o) in difference.replicates.iter_mut().zip(other.replicates) {
                *d = *d - o * w;
            }
        }
        let mean = difference.mean();
        (mean * mean - difference.variance()).mean()
    }

    fn places(&self, nodes: &[u32]) -> Vec<DVec2> {
        let at = |&n: &u32| place(self.samples, self.lattice.nodes[n as usize]);
        nodes.iter().map(at).collect()
    }

    /// The cells to be divided, those with the largest errors, so that the whole is within its share.
    fn coarse_cells(&self, errors: &[f64]) -> Vec<bool> {
        let areas: Vec<f64> = (0..self.lattice.len()).map(|c| self.cell_area(c)).collect();
        let all: f64 = areas.iter().sum();
        let permitted = SHARE * (self.error * self.mean).powi(2) * all;
        let of_cell = |c: usize| {
            // A cell of one texel is gathered, not interpolated.
            if self.lattice.samples(c).len() > 1 {
                areas[c] * errors[c]
            } else {
                0.0
            }
        };
        let mut left: f64 = (0..areas.len()).map(of_cell).sum();
        let mut worst: Vec<usize> = (0..areas.len()).filter(|&c| of_cell(c) > 0.0).collect();
        worst.sort_by(|&a, &b| errors[b].total_cmp(&errors[a]).then(a.cmp(&b)));
        let mut is_coarse = vec![false; areas.len()];
        for cell in worst {
            if left <= permitted {
                break;
            }
            is_coarse[cell] = true;
            left -= (1.0 - DIVIDED) * of_cell(cell);
        }
        is_coarse
    }

    /// The light of every sample.
    fn interpolated(&self, errors: &[f64]) -> Vec<TexelLight> {
        let around = self.lattice.nodes_around(self.samples);
        let mut light = vec![TexelLight::default(); self.samples.samples.len()];
        let found: Vec<Vec<(u32, TexelLight)>> = (0..self.lattice.len())
            .into_par_iter()
            .map(|cell| {
                let places = self.places(&around[cell]);
                let mut shares = Vec::new();
                let of_sample = |&s: &u32| {
                    weights(place(self.samples, s), &places, &mut shares);
                    (
                        s,
                        self.sample_light(s, &around[cell], &shares, errors[cell]),
                    )
                };
                self.lattice.samples(cell).iter().map(of_sample).collect()
            })
            .collect();
        for (sample, of_sample) in found.into_iter().flatten() {
            light[sample as usize] = of_sample;
        }
        light
    }

    fn sample_light(
        &self,
        sample: u32,
        nodes: &[u32],
        shares: &[f64],
        interpolation: f64,
    ) -> TexelLight {
        let (mut indirect, mut variance) = (Rgb::BLACK, Rgb::grey(interpolation));
        for (&n, &w) in nodes.iter().zip(shares) {
            let node = &self.light[n as usize];
            indirect += node.irradiance.mean() * w;
            let error = node.standard_error * w;
            variance += error * error;
        }
        variance += Rgb::from(self.direct.variance[sample as usize].map(f64::from));
        TexelLight {
            irradiance: (self.direct_of(sample) + indirect).map(|e| e.max(0.0)),
            standard_error: variance.map(f64::sqrt),
        }
    }
}
