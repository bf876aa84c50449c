//! Cells of texels with a node each, at which indirect light is gathered; between nodes it is
//! interpolated on the page.
//!
//! The cells of a region are squares of texels that are divided in four where light changes more.

use crate::samples::{Samples, gather_point};
use azulejo_radiosity::sites::{SiteCells, plane_weights};
use azulejo_trace::run::batches::in_batches;
use azulejo_trace::{Cancelled, GatherPoint, Run};
use glam::DVec2;
use rstar::RTree;
use rstar::primitives::GeomWithData;
use std::ops::Range;

/// How far apart regions are kept in the search for nodes, texels: beyond the largest page.
const APART: f64 = 1e6;

/// Cells that are worked on together.
const BATCH: usize = 64;

/// Texels along a side of the first cells, as a power of two.
const FIRST_LEVEL: u32 = 4;

/// The same where there are so few texels that cells would be few.
const LEAST_CELLS: usize = 1500;

/// The samples of a lightmap as sites of a gather.
#[derive(Clone, Debug)]
pub struct TexelCells<'a> {
    samples: &'a Samples,
    lattice: Lattice,
}

impl<'a> TexelCells<'a> {
    /// Cells as large as leaves enough of them.
    pub fn new(samples: &'a Samples) -> TexelCells<'a> {
        let mut level = FIRST_LEVEL;
        let mut cells = TexelCells::of_level(samples, level);
        while cells.cell_count() < LEAST_CELLS && level > 0 {
            level -= 1;
            cells = TexelCells::of_level(samples, level);
        }
        cells
    }

    /// Cells of 2^level texels along a side.
    pub(crate) fn of_level(samples: &'a Samples, level: u32) -> TexelCells<'a> {
        TexelCells {
            samples,
            lattice: Lattice::new(samples, level),
        }
    }
}

impl SiteCells for TexelCells<'_> {
    /// Middle of a texel on its page, texels.
    type Place = DVec2;

    fn site_count(&self) -> usize {
        self.samples.samples.len()
    }

    fn point(&self, site: u32) -> GatherPoint {
        gather_point(self.samples, site as usize)
    }

    fn area(&self, site: u32) -> f64 {
        self.samples.samples[site as usize].area.into()
    }

    fn place(&self, site: u32) -> DVec2 {
        place(self.samples, site)
    }

    fn distance(&self, a: DVec2, b: DVec2) -> f64 {
        a.distance(b)
    }

    fn weights(&self, at: DVec2, nodes: &[DVec2], found: &mut Vec<f64>) {
        plane_weights(nodes.iter().map(|node| *node - at), found);
    }

    fn cell_count(&self) -> usize {
        self.lattice.cells.len()
    }

    fn sites(&self, cell: usize) -> &[u32] {
        self.lattice.samples(cell)
    }

    fn node(&self, cell: usize) -> u32 {
        self.lattice.cells[cell].node
    }

    fn nodes(&self) -> &[u32] {
        &self.lattice.nodes
    }

    fn divide(&mut self, is_divided: &[bool]) {
        self.lattice.divide(self.samples, is_divided);
    }

    fn nodes_around(&self, count: usize, run: Run) -> Result<Vec<Vec<u32>>, Cancelled> {
        self.lattice.nodes_around(self.samples, count, run)
    }
}

/// Cells of the samples of all regions.
#[derive(Clone, Debug, Default)]
struct Lattice {
    /// Samples by region and, within it, along a Morton curve.
    order: Vec<u32>,
    codes: Vec<u64>,
    cells: Vec<LatticeCell>,
    /// Sample of each node.
    nodes: Vec<u32>,
}

/// A square of texels of one region.
#[derive(Clone, Debug, PartialEq)]
struct LatticeCell {
    /// Of `order`.
    samples: Range<usize>,
    /// Texels along a side, as a power of two.
    level: u32,
    node: u32,
}

impl Lattice {
    fn new(samples: &Samples, level: u32) -> Lattice {
        let key = |(number, s): (usize, &crate::TexelSample)| {
            let coverage = &samples.pages[s.page as usize];
            let index = coverage.texels[s.texel as usize].index;
            let code = morton(index % coverage.size[0], index / coverage.size[0]);
            (s.region, code, number as u32)
        };
        let mut keys: Vec<(u32, u64, u32)> = samples.samples.iter().enumerate().map(key).collect();
        keys.sort_unstable();
        let mut lattice = Lattice {
            order: keys.iter().map(|k| k.2).collect(),
            codes: keys.iter().map(|k| k.1).collect(),
            ..Lattice::default()
        };
        let mut start = 0;
        for of_cell in keys.chunk_by(|a, b| (a.0, a.1 >> (2 * level)) == (b.0, b.1 >> (2 * level)))
        {
            let range = start..start + of_cell.len();
            start = range.end;
            let node = lattice.nodes.len() as u32;
            lattice.nodes.push(lattice.middle(samples, &range));
            lattice.cells.push(LatticeCell {
                samples: range,
                level,
                node,
            });
        }
        lattice
    }

    fn samples(&self, cell: usize) -> &[u32] {
        &self.order[self.cells[cell].samples.clone()]
    }

    /// The sample of a cell nearest to the middle of all.
    fn middle(&self, samples: &Samples, range: &Range<usize>) -> u32 {
        let all = &self.order[range.clone()];
        let sum: DVec2 = all.iter().map(|&s| place(samples, s)).sum();
        let middle = sum / all.len() as f64;
        let distance = |s: u32| place(samples, s).distance_squared(middle);
        let nearest = |a: &u32, b: &u32| distance(*a).total_cmp(&distance(*b)).then(a.cmp(b));
        all.iter().copied().min_by(nearest).unwrap_or_default()
    }

    /// Divides cells in four; a cell's node stays that of the part that has it.
    fn divide(&mut self, samples: &Samples, is_divided: &[bool]) {
        let old = std::mem::take(&mut self.cells);
        for (cell, &divide) in old.into_iter().zip(is_divided) {
            if !divide || cell.samples.len() == 1 || cell.level == 0 {
                self.cells.push(cell);
                continue;
            }
            let level = cell.level - 1;
            let mut start = cell.samples.start;
            while start < cell.samples.end {
                let quarter = self.codes[start] >> (2 * level);
                let length = self.codes[start..cell.samples.end]
                    .iter()
                    .take_while(|&&c| c >> (2 * level) == quarter)
                    .count();
                let range = start..start + length;
                start = range.end;
                let is_known = self.order[range.clone()].contains(&self.nodes[cell.node as usize]);
                let node = if is_known {
                    cell.node
                } else {
                    let node = self.middle(samples, &range);
                    self.nodes.push(node);
                    self.nodes.len() as u32 - 1
                };
                self.cells.push(LatticeCell {
                    samples: range,
                    level,
                    node,
                });
            }
        }
    }

    /// For each cell its own node and up to `count` of those around in its region, nearest first.
    fn nodes_around(
        &self,
        samples: &Samples,
        count: usize,
        run: Run,
    ) -> Result<Vec<Vec<u32>>, Cancelled> {
        let at = |sample: u32| {
            let place = place(samples, sample);
            let region = samples.samples[sample as usize].region;
            [place.x, place.y, APART * f64::from(region)]
        };
        let places = self.nodes.iter().zip(0..);
        let places = places.map(|(&sample, node)| GeomWithData::new(at(sample), node));
        let tree = RTree::bulk_load(places.collect());
        let of_cell = |cell: &LatticeCell| -> Vec<u32> {
            let sample = self.nodes[cell.node as usize];
            let from = at(sample);
            let mut near: Vec<(f64, u32)> = tree
                .nearest_neighbor_iter_with_distance_2(&from)
                .take_while(|(_, d)| *d < APART)
                .take(count + 1)
                .map(|(n, d)| (d, n.data))
                .collect();
            near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            near.into_iter().map(|n| n.1).collect()
        };
        in_batches(&self.cells, BATCH, run, |batch| {
            Ok(batch.iter().map(of_cell).collect())
        })
    }
}

/// Middle of the texel of a sample.
fn place(samples: &Samples, sample: u32) -> DVec2 {
    let s = &samples.samples[sample as usize];
    let coverage = &samples.pages[s.page as usize];
    let index = coverage.texels[s.texel as usize].index;
    DVec2::new(
        f64::from(index % coverage.size[0]) + 0.5,
        f64::from(index / coverage.size[0]) + 0.5,
    )
}

/// Bits of both numbers in turn.
fn morton(x: u32, y: u32) -> u64 {
    spread(x) | (spread(y) << 1)
}

/// The bits of a number with a zero between each two.
fn spread(x: u32) -> u64 {
    let mut x = u64::from(x);
    for (shift, mask) in [
        (16, 0x0000_ffff_0000_ffff),
        (8, 0x00ff_00ff_00ff_00ff),
        (4, 0x0f0f_0f0f_0f0f_0f0f),
        (2, 0x3333_3333_3333_3333),
        (1, 0x5555_5555_5555_5555),
    ] {
        x = (x | (x << shift)) & mask;
    }
    x
}
