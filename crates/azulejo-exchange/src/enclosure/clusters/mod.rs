//! Rows that lie beside each other combined into clusters, until a number of them is left.
//!
//! Each cluster is a disc: one piece without holes, whose border is one closed line that meets itself
//! nowhere. The smallest cluster joins a neighbour, over and over, so that clusters are about as large as
//! each other.

mod junctions;
mod outlines;
mod regions;
#[cfg(test)]
mod tests;

use super::{Enclosure, Groups, unique};
use outlines::{OutlineMesh, RowKey};
use regions::ClusterRegions;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};
use std::fmt;

/// How rows become clusters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClusterOptions {
    /// The requested number of clusters.
    pub count: usize,
    /// Largest angle between the normals of a cluster and of any of its rows, in radians, 0..π. That
    /// of the cluster is the mean of its rows by area.
    pub angle: f64,
    /// Whether all pieces of a face belong to one cluster.
    pub whole_faces: bool,
}

/// Why there are no clusters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ClusterError {
    /// The positions of the rows are not known.
    NoGeometry,
    /// Rows are groups.
    AreGroups,
}

impl fmt::Display for ClusterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            ClusterError::NoGeometry => {
                "found factors without the polygons of their rows, expected \"points\", \"cell_corners\", \
                 \"cell_starts\" and \"cell_rows\" as azulejo writes them"
            }
            ClusterError::AreGroups => "found rows that are groups already, expected patches",
        })
    }
}

impl std::error::Error for ClusterError {}

impl Enclosure {
    /// Groups of neighbouring rows of one object, side and material, numbered by first appearance and
    /// named `object/cluster`. There are more than `count` where more cannot be joined: parts that do
    /// not touch, bends beyond the angle, and rings, which no cluster closes. Rows that are not simple
    /// polygons stay alone.
    ///
    /// # Errors
    /// [`ClusterError`]: the rows are groups, or their polygons are not known.
    pub fn clusters(&self, options: &ClusterOptions) -> Result<Groups, ClusterError> {
        if self.rows.are_groups {
            return Err(ClusterError::AreGroups);
        }
        if self.rows.cells.is_empty() && !self.is_empty() {
            return Err(ClusterError::NoGeometry);
        }
        let key = |i| self.key(i);
        let mesh = OutlineMesh::new(&self.rows.cells, self.len(), key);
        let mut regions = ClusterRegions::new(mesh, options.angle);
        if options.whole_faces {
            self.join_faces(&mut regions);
        }
        agglomerate(&mut regions, options.count);
        Ok(self.named(&mut regions))
    }

    /// Rows whose keys differ are never in one cluster.
    fn key(&self, row: usize) -> RowKey {
        let factors = &self.factors;
        RowKey {
            object: factors.faces[row].object,
            material: factors.materials[row],
            is_back: factors.is_back[row],
        }
    }

    /// Joins the pieces of each face, whatever their normals.
    fn join_faces(&self, regions: &mut ClusterRegions) {
        let faces = &self.factors.faces;
        for row in 0..self.len() {
            let has_same_face = |other: u32| faces[other as usize] == faces[row];
            loop {
                let region = regions.region_of(row as u32);
                let borders = regions.borders(region);
                let mut others = borders.iter().filter(|b| b.is_one_line());
                let Some(border) = others.find(|b| has_same_face(b.region)) else {
                    break;
                };
                regions.join(region, border);
            }
        }
    }

    fn named(&self, regions: &mut ClusterRegions) -> Groups {
        let (mut numbers, mut names) = (HashMap::new(), Vec::new());
        let mut used = HashMap::new();
        let group = |row: usize| {
            let region = regions.region_of(row as u32);
            let number = numbers.entry(region).or_insert_with(|| {
                let (face, is_back) = (self.factors.faces[row], self.factors.is_back[row]);
                let place = used.entry((face.object, is_back)).or_insert(0usize);
                let side = if is_back { " (back)" } else { "" };
                names.push(format!("{}/{place}{side}", self.rows.object(face)));
                *place += 1;
                names.len() as u32 - 1
            });
            Some(*number)
        };
        Groups {
            of_rows: (0..self.len()).map(group).collect(),
            names: unique(names),
        }
    }
}

/// The smallest region joins its best neighbour until this many are left, or none has one.
fn agglomerate(regions: &mut ClusterRegions, count: usize) {
    let entry =
        |regions: &ClusterRegions, region: u32| Reverse((rank(regions.area(region)), region));
    let mut smallest: BinaryHeap<_> = regions
        .rows_at_first()
        .map(|r| entry(&*regions, r))
        .collect();
    // Regions that no neighbour accepted, until one of these changes.
    let mut is_waiting = vec![false; smallest.len()];
    while regions.len() > count {
        let Some(Reverse((area, region))) = smallest.pop() else {
            break;
        };
        let is_current = regions.region_of(region) == region
            && rank(regions.area(region)) == area
            && !is_waiting[region as usize];
        if !is_current {
            continue;
        }
        let Some(border) = regions.best(region) else {
            is_waiting[region as usize] = true;
            continue;
        };
        let joined = regions.join(region, &border);
        is_waiting[joined as usize] = false;
        smallest.push(entry(regions, joined));
        for border in regions.borders(joined) {
            if std::mem::take(&mut is_waiting[border.region as usize]) {
                smallest.push(entry(regions, border.region));
            }
        }
    }
}

/// Numbers that are not negative sort as their bits do. Those that differ by rounding alone are equal, and
/// regions are then taken in order.
fn rank(number: f64) -> u32 {
    (number as f32).to_bits()
}
