//! What the gather at sites asks of each kind of them.

use azulejo_trace::{Cancelled, GatherPoint, Run};

/// Sites, divided into cells with a node each: one of the sites of the cell.
///
/// Cells, sites and nodes have numbers from 0; those of nodes stay when cells are divided.
pub trait SiteCells: Clone + Sync {
    /// What tells how far sites are apart.
    type Place: Copy + Send + Sync;

    /// Number of sites.
    fn site_count(&self) -> usize;

    /// Where a site is.
    fn point(&self, site: u32) -> GatherPoint;

    /// What a site stands for, square scene units.
    fn area(&self, site: u32) -> f64;

    /// Where a site is among its neighbours.
    fn place(&self, site: u32) -> Self::Place;

    /// How far two places are apart, in any unit.
    fn distance(&self, a: Self::Place, b: Self::Place) -> f64;

    /// Replaces `found` by the weights of values at nodes for the value at a place, which sum to 1.
    fn weights(&self, at: Self::Place, nodes: &[Self::Place], found: &mut Vec<f64>);

    /// Number of cells.
    fn cell_count(&self) -> usize;

    /// The sites of a cell.
    fn sites(&self, cell: usize) -> &[u32];

    /// The area of a cell, square scene units.
    fn cell_area(&self, cell: usize) -> f64 {
        self.sites(cell).iter().map(|&site| self.area(site)).sum()
    }

    /// The node of a cell.
    fn node(&self, cell: usize) -> u32;

    /// The site of each node.
    fn nodes(&self) -> &[u32];

    /// Divides the cells whose entry is set; a cell's node stays that of the part that has it.
    fn divide(&mut self, is_divided: &[bool]);

    /// For each cell its own node, and up to `count` of those around it that say something of its sites, nearest first.
    ///
    /// # Errors
    /// The caller cancelled.
    fn nodes_around(&self, count: usize, run: Run) -> Result<Vec<Vec<u32>>, Cancelled>;
}
