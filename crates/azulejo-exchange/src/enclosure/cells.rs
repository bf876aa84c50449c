//! Polygons that rows consist of.

use azulejo_scene::math::area_vector;
use glam::DVec3;
use std::collections::HashMap;
use std::ops::Range;

/// Polygons with the row that each belongs to, in the world of the scene. Their corners run
/// counter-clockwise as seen from the side that the row is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CellMesh {
    /// Positions, in scene units; each once.
    pub points: Vec<DVec3>,
    /// Corners of all cells, one after the other, among `points`.
    pub corners: Vec<u32>,
    /// The first corner of each cell among `corners`, and the end of the last.
    pub starts: Vec<u32>,
    /// The row of each cell.
    pub rows: Vec<u32>,
}

impl CellMesh {
    /// One cell for each row. Equal positions become one point.
    pub fn new(outlines: impl IntoIterator<Item = Vec<DVec3>>) -> CellMesh {
        let mut mesh = CellMesh {
            starts: vec![0],
            ..CellMesh::default()
        };
        let mut known = HashMap::new();
        for (row, outline) in outlines.into_iter().enumerate() {
            for point in outline {
                // Adding 0 makes −0 the same point as 0.
                let key = (point + DVec3::ZERO).to_array().map(f64::to_bits);
                let points = &mut mesh.points;
                let index = *known.entry(key).or_insert_with(|| {
                    points.push(point);
                    points.len() as u32 - 1
                });
                mesh.corners.push(index);
            }
            mesh.starts.push(mesh.corners.len() as u32);
            mesh.rows.push(row as u32);
        }
        mesh
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there are no cells, as with factors that came from a file without geometry.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The corners of a cell, among `points`.
    ///
    /// # Panics
    /// If there is no such cell.
    pub fn cell(&self, i: usize) -> &[u32] {
        let range: Range<usize> = self.starts[i] as usize..self.starts[i + 1] as usize;
        &self.corners[range]
    }

    /// The positions of a cell's corners.
    ///
    /// # Panics
    /// If there is no such cell.
    pub fn polygon(&self, i: usize) -> Vec<DVec3> {
        let corners = self.cell(i).iter();
        corners.map(|&c| self.points[c as usize]).collect()
    }

    /// Whether all numbers are in range, for this many rows, and all positions finite.
    pub(crate) fn is_valid(&self, rows: usize) -> bool {
        let starts = &self.starts;
        starts.len() == self.len() + 1
            && starts.first() == Some(&0)
            && starts.last() == Some(&(self.corners.len() as u32))
            && starts.is_sorted()
            && self.rows.iter().all(|&r| (r as usize) < rows)
            && self
                .corners
                .iter()
                .all(|&c| (c as usize) < self.points.len())
            && self.points.iter().all(|p| p.is_finite())
    }

    /// Centroid and unit normal of each of this many rows: means of its cells, weighted by area. The
    /// normal is zero for rows whose cells face all ways, as those of a closed box do.
    pub fn frames(&self, rows: usize) -> Vec<(DVec3, DVec3)> {
        let mut sums = vec![(DVec3::ZERO, DVec3::ZERO, 0.0); rows];
        for (i, &row) in self.rows.iter().enumerate() {
            let polygon = self.polygon(i);
            let (centroid, vector) = (centroid(&polygon), area_vector(&polygon));
            let (sum, normal, area) = &mut sums[row as usize];
            *sum += centroid * vector.length();
            *normal += vector;
            *area += vector.length();
        }
        let frame = |(sum, normal, area): (DVec3, DVec3, f64)| {
            let is_flat = normal.length() > 1e-9 * area;
            let normal = if is_flat {
                normal.normalize()
            } else {
                DVec3::ZERO
            };
            (sum / area.max(f64::MIN_POSITIVE), normal)
        };
        sums.into_iter().map(frame).collect()
    }
}

/// Centroid of a flat polygon: of its triangles around the first corner, weighted by area; the mean
/// of its corners if it has no area.
fn centroid(polygon: &[DVec3]) -> DVec3 {
    let whole = area_vector(polygon);
    let (mut sum, mut area) = (DVec3::ZERO, 0.0);
    for pair in polygon.windows(2).skip(1) {
        let triangle = [polygon[0], pair[0], pair[1]];
        // Signed, so that concave outlines come out right.
        let signed = area_vector(&triangle).dot(whole);
        sum += signed * (triangle[0] + triangle[1] + triangle[2]) / 3.0;
        area += signed;
    }
    if area > 0.0 {
        sum / area
    } else {
        polygon.iter().sum::<DVec3>() / polygon.len().max(1) as f64
    }
}
