//! Nodes with their indirect light, and the light of sites between them.
//!
//! Leaving out a node and interpolating it from the others measures the error of interpolation, beyond the
//! noise of both; cells are divided where it is largest, until it is a small part of what is permitted.

use super::cells::SiteCells;
use super::light::{NodeLight, SiteDirect, SiteLight};
use azulejo_scene::Rgb;
use azulejo_trace::run::Record;
use azulejo_trace::run::batches::in_batches;
use azulejo_trace::{Cancelled, GatherPoint, Gathered, Run};
use std::sync::OnceLock;

/// Part of the permitted mean square error that interpolation may make.
const SHARE: f64 = 0.25;

/// Mean square error of interpolation at a texel relative to that at a node that was left out, which is
/// farther from the others.
const LEFT_OUT: f64 = 0.5;

/// The same after its cell was divided, where light is smooth.
const DIVIDED: f64 = 0.25;

/// Nodes of one interpolation.
const NEIGHBOURS: usize = 12;

/// Most nodes of a correction.
pub(crate) const MOST_NEIGHBOURS: usize = 48;

/// Cells that are worked on together.
const BATCH: usize = 32;

/// Cells whose sites get their light at once: that of all would be as much again as the result.
const AT_ONCE: usize = 1 << 16;

/// The nodes of cells with their light.
pub(crate) struct Nodes<'a, C> {
    direct: &'a SiteDirect,
    cells: C,
    /// For each cell the nodes around, once they are known.
    around: OnceLock<Vec<Vec<u32>>>,
    /// Of the first nodes; those behind have none yet.
    pub light: Vec<NodeLight>,
    /// Mean irradiance of all sites, W/m².
    pub mean: f64,
    /// Whether values may be below zero.
    is_signed: bool,
}

impl<'a, C: SiteCells> Nodes<'a, C> {
    pub fn new(direct: &'a SiteDirect, cells: C) -> Nodes<'a, C> {
        Nodes {
            direct,
            cells,
            around: OnceLock::new(),
            light: Vec::new(),
            mean: 0.0,
            is_signed: false,
        }
    }

    /// Where the nodes are.
    pub fn cells(&self) -> &C {
        &self.cells
    }

    /// The same, when the nodes are no longer needed.
    pub fn into_cells(self) -> C {
        self.cells
    }

    /// Divides cells in four.
    pub fn divide(&mut self, is_divided: &[bool]) {
        self.cells.divide(is_divided);
        self.around = OnceLock::new();
    }

    /// For each cell its own node and those that a correction may be averaged over, nearest first; those of one
    /// interpolation are the first of them.
    ///
    /// # Errors
    /// The caller cancelled.
    pub fn around(&self, run: Run) -> Result<&[Vec<u32>], Cancelled> {
        if self.around.get().is_none() {
            let around = self.cells.nodes_around(MOST_NEIGHBOURS, run)?;
            return Ok(self.around.get_or_init(|| around));
        }
        Ok(self.around.get().map_or(&[], Vec::as_slice))
    }

    /// For each cell its own node and those of one interpolation.
    fn near_around(&self, run: Run) -> Result<Vec<&[u32]>, Cancelled> {
        let near = |nodes: &'_ Vec<u32>| nodes.len().min(NEIGHBOURS + 1);
        let around = self.around(run)?;
        Ok(around.iter().map(|nodes| &nodes[..near(nodes)]).collect())
    }

    /// What `of_cell` finds for all cells in their order.
    fn of_cells<T: Record + Send>(
        &self,
        run: Run,
        of_cell: impl Fn(usize) -> T + Sync,
    ) -> Result<Vec<T>, Cancelled> {
        let cells: Vec<u32> = (0..self.cells.cell_count() as u32).collect();
        in_batches(&cells, BATCH, run, |batch| {
            Ok(batch.iter().map(|&cell| of_cell(cell as usize)).collect())
        })
    }

    /// Points and areas of the nodes that have no light yet.
    pub fn targets(&self) -> (Vec<GatherPoint>, Vec<f64>) {
        let known = self.light.len();
        let new = &self.cells.nodes()[known..];
        let point = |&s: &u32| self.cells.point(s);
        let mut areas = vec![0.0; new.len()];
        for cell in 0..self.cells.cell_count() {
            if let Some(of_node) = (self.cells.node(cell) as usize).checked_sub(known) {
                areas[of_node] += self.cells.cell_area(cell);
            }
        }
        (new.iter().map(point).collect(), areas)
    }

    /// Sets the mean irradiance, from that of all nodes.
    pub fn measure_mean(&mut self) {
        let light = |cell: usize| {
            let node = self.cells.node(cell) as usize;
            let site = self.cells.nodes()[node];
            (self.direct_of(site) + self.light[node].irradiance.mean()).mean()
        };
        let lights: Vec<f64> = (0..self.cells.cell_count()).map(light).collect();
        self.mean = self.mean_of_cells(&lights);
    }

    /// The mean of values of cells by area.
    pub fn mean_of_cells(&self, values: &[f64]) -> f64 {
        let (mut sum, mut area) = (0.0, 0.0);
        for (cell, value) in values.iter().enumerate() {
            let of_cell = self.cells.cell_area(cell);
            sum += of_cell * value;
            area += of_cell;
        }
        sum / f64::max(area, f64::MIN_POSITIVE)
    }

    fn direct_of(&self, site: u32) -> Rgb {
        Rgb::from(self.direct.irradiance[site as usize].map(f64::from))
    }

    /// Mean squares of the noise of nodes, their own and that which they share with those around, (W/m²)².
    pub fn node_noise(&self) -> (f64, f64) {
        let of = |part: fn(&NodeLight) -> Rgb| {
            let square = |cell: usize| {
                let noise = part(&self.light[self.cells.node(cell) as usize]);
                (noise * noise).mean()
            };
            let squares: Vec<f64> = (0..self.cells.cell_count()).map(square).collect();
            self.mean_of_cells(&squares)
        };
        (of(|light| light.noise), of(|light| light.shared_noise))
    }

    /// Mean squares of the errors of texels, (W/m²)²: noise of nodes, averaged by interpolation; noise that
    /// nodes share; and the rest, of interpolation with `errors` by cell, corrections and direct light.
    ///
    /// # Errors
    /// The caller cancelled.
    pub fn texel_noise(&self, errors: &[f64], run: Run) -> Result<(f64, f64, f64), Cancelled> {
        let around = self.near_around(run)?;
        let own = self.of_cells(run, |cell| {
            // The middle of a cell and its rim: a node and a texel between.
            let places = self.places(around[cell]);
            let mut shares = Vec::new();
            let of_cell = self.cells.sites(cell);
            let some = [
                of_cell[0],
                of_cell[of_cell.len() / 2],
                of_cell[of_cell.len() - 1],
            ];
            let noise = some.map(|s| {
                (self.cells).weights(self.cells.place(s), &places, &mut shares);
                let square = |(&n, w): (&u32, &f64)| {
                    let noise = self.light[n as usize].noise * *w;
                    (noise * noise).mean()
                };
                around[cell].iter().zip(&shares).map(square).sum::<f64>()
            });
            noise.iter().sum::<f64>() / 3.0
        })?;
        let of_node = |cell: usize| &self.light[self.cells.node(cell) as usize];
        let rest = |cell: usize| errors[cell] + of_node(cell).bias.powi(2);
        let rest: Vec<f64> = (0..self.cells.cell_count()).map(rest).collect();
        let (mut direct, mut area) = (0.0, 0.0);
        for (site, variance) in (0..).zip(&self.direct.variance) {
            let of_site = self.cells.area(site);
            direct += of_site * Rgb::from(variance.map(f64::from)).mean();
            area += of_site;
        }
        Ok((
            self.mean_of_cells(&own),
            self.node_noise().1,
            self.mean_of_cells(&rest) + direct / f64::max(area, f64::MIN_POSITIVE),
        ))
    }

    /// For each cell the mean square error of interpolating in it, (W/m²)², mean of the channels.
    ///
    /// # Errors
    /// The caller cancelled.
    pub fn interpolation_errors(&self, run: Run) -> Result<Vec<f64>, Cancelled> {
        let around = self.near_around(run)?;
        let own = self.of_cells(run, |cell| self.left_out(cell, around[cell]))?;
        let mut of_node = vec![0.0; self.light.len()];
        for (cell, &error) in own.iter().enumerate() {
            of_node[self.cells.node(cell) as usize] = error;
        }
        // One difference has one degree of freedom; those around it say more.
        let pooled = |nodes: &[u32]| {
            let sum: f64 = nodes.iter().map(|&n| of_node[n as usize]).sum();
            LEFT_OUT * (sum / nodes.len().max(1) as f64).max(0.0)
        };
        let of_cell = |(cell, nodes): (usize, &&[u32])| match self.cells.sites(cell).len() {
            // A cell of one site is gathered, not interpolated.
            1 => 0.0,
            _ => pooled(nodes),
        };
        Ok(around.iter().enumerate().map(of_cell).collect())
    }

    /// The squared difference between a cell's node and what those around it give, less its noise.
    fn left_out(&self, cell: usize, around: &[u32]) -> f64 {
        let own = self.cells.node(cell);
        let others: Vec<u32> = around.iter().copied().filter(|&n| n != own).collect();
        if others.len() < 3 {
            return 0.0;
        }
        let node = self.cells.nodes()[own as usize];
        let places = self.places(&others);
        let mut shares = Vec::new();
        (self.cells).weights(self.cells.place(node), &places, &mut shares);
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

    fn places(&self, nodes: &[u32]) -> Vec<C::Place> {
        let at = |&n: &u32| self.cells.place(self.cells.nodes()[n as usize]);
        nodes.iter().map(at).collect()
    }

    /// The cells to be divided, those with the largest errors, so that the whole is within its share of
    /// an error, W/m².
    pub fn coarse_cells(&self, errors: &[f64], permitted: f64) -> Vec<bool> {
        let areas: Vec<f64> = (0..self.cells.cell_count())
            .map(|c| self.cells.cell_area(c))
            .collect();
        let all: f64 = areas.iter().sum();
        let permitted = SHARE * permitted.powi(2) * all;
        let of_cell = |c: usize| areas[c] * errors[c];
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

    /// The light of every site.
    ///
    /// # Errors
    /// The caller cancelled.
    pub fn interpolated(&self, errors: &[f64], run: Run) -> Result<Vec<SiteLight>, Cancelled> {
        let around = self.near_around(run)?;
        let mut light = vec![SiteLight::default(); self.cells.site_count()];
        let of_cell = |cell: usize| -> Vec<SiteLight> {
            let places = self.places(around[cell]);
            let mut shares = Vec::new();
            let of_site = |&s: &u32| {
                (self.cells).weights(self.cells.place(s), &places, &mut shares);
                self.site_light(s, around[cell], &shares, errors[cell])
            };
            self.cells.sites(cell).iter().map(of_site).collect()
        };
        let cells: Vec<u32> = (0..self.cells.cell_count() as u32).collect();
        for cells in cells.chunks(AT_ONCE) {
            let of_sites = in_batches(cells, BATCH, run, |batch| {
                let of_cells = batch.iter().flat_map(|&cell| of_cell(cell as usize));
                Ok(of_cells.collect())
            })?;
            let sites = cells
                .iter()
                .flat_map(|&cell| self.cells.sites(cell as usize));
            for (&site, of_site) in sites.zip(of_sites) {
                light[site as usize] = of_site;
            }
        }
        Ok(light)
    }

    /// The light of all sites from that of the nodes.
    fn between(&mut self, of_nodes: Vec<Gathered>, run: Run) -> Result<Vec<SiteLight>, Cancelled> {
        self.light = of_nodes.into_iter().map(NodeLight::from).collect();
        let errors = self.interpolation_errors(run)?;
        self.interpolated(&errors, run)
    }

    fn site_light(
        &self,
        site: u32,
        nodes: &[u32],
        shares: &[f64],
        interpolation: f64,
    ) -> SiteLight {
        let mut indirect = Rgb::BLACK;
        let (mut own, mut shared, mut bias) = (Rgb::BLACK, Rgb::BLACK, 0.0);
        for (&n, &w) in nodes.iter().zip(shares) {
            let node = &self.light[n as usize];
            indirect += node.irradiance.mean() * w;
            own += (node.noise * w) * (node.noise * w);
            // Nodes side by side share all of this.
            shared += node.shared_noise * w.abs();
            bias += node.bias * w.abs();
        }
        let direct = Rgb::from(self.direct.variance[site as usize].map(f64::from));
        let variance = own + shared * shared + Rgb::grey(interpolation + bias * bias) + direct;
        let least = if self.is_signed {
            f64::NEG_INFINITY
        } else {
            0.0
        };
        SiteLight {
            irradiance: (self.direct_of(site) + indirect)
                .map(|e| e.max(least))
                .to_f32(),
            standard_error: variance.map(f64::sqrt).to_f32(),
        }
    }
}

/// Direct light of all sites, from what was found at the nodes of cells.
///
/// # Errors
/// The caller cancelled.
pub fn interpolated_direct<C: SiteCells>(
    cells: C,
    of_nodes: Vec<Gathered>,
    run: Run,
) -> Result<Vec<SiteLight>, Cancelled> {
    let none = SiteDirect::none(cells.site_count());
    Nodes::new(&none, cells).between(of_nodes, run)
}

/// Several values of all sites, also below zero, in place of irradiance, from those at the nodes of cells.
///
/// # Errors
/// The caller cancelled.
pub fn interpolated_signed<C: SiteCells>(
    cells: C,
    values: impl Iterator<Item = Vec<Gathered>>,
    run: Run,
) -> Result<Vec<Vec<SiteLight>>, Cancelled> {
    let none = SiteDirect::none(cells.site_count());
    let mut nodes = Nodes::new(&none, cells);
    nodes.is_signed = true;
    values
        .map(|of_nodes| nodes.between(of_nodes, run))
        .collect()
}
