//! Where the rows of a matrix lie.

use crate::arrays::triples;
use azulejo_factors::{FormFactors, Patches};
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;

/// Corners, centres and normals of patches, a row each.
pub struct RowGeometry {
    corners: Vec<[f64; 3]>,
    /// Where the corners of each row start, and the end of the last.
    offsets: Vec<i64>,
    centroids: Vec<[f64; 3]>,
    normals: Vec<[f64; 3]>,
}

/// Corners, their offsets, centroids and normals.
pub type GeometryArrays<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
);

impl RowGeometry {
    /// The geometry of rows that are patches, or their sides.
    pub fn new(patches: &Patches, factors: &FormFactors) -> RowGeometry {
        let mut geometry = RowGeometry {
            corners: Vec::new(),
            offsets: vec![0],
            centroids: Vec::new(),
            normals: Vec::new(),
        };
        let two_sided = factors.len() != patches.len();
        for (row, &is_back) in factors.is_back.iter().enumerate() {
            geometry.push(patches, if two_sided { row / 2 } else { row }, is_back);
        }
        geometry
    }

    /// Backs have their corners in the other order.
    fn push(&mut self, patches: &Patches, patch: usize, is_back: bool) {
        let mut corners: Vec<[f64; 3]> = match patches.polygon(patch) {
            Some(polygon) => polygon.iter().map(|p| p.to_array()).collect(),
            None => {
                let vertices = patches.corner_vertices(patch).iter();
                let position = |&v: &u32| patches.vertices()[v as usize].position.to_array();
                vertices.map(position).collect()
            }
        };
        let mut normal = patches.normal(patch);
        if is_back {
            corners.reverse();
            normal = -normal;
        }
        self.corners.extend(corners);
        self.offsets.push(self.corners.len() as i64);
        self.centroids.push(patches.centre(patch).to_array());
        self.normals.push(normal.to_array());
    }

    /// As arrays.
    pub fn arrays<'py>(&self, py: Python<'py>) -> PyResult<GeometryArrays<'py>> {
        Ok((
            triples(py, self.corners.iter().copied())?,
            self.offsets.clone().into_pyarray(py),
            triples(py, self.centroids.iter().copied())?,
            triples(py, self.normals.iter().copied())?,
        ))
    }
}
