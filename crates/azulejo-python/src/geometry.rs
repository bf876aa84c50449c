//! Where the rows of a matrix lie.

use crate::arrays::triples;
use azulejo_exchange::Enclosure;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;

/// Corners, their offsets, centroids and normals.
pub type GeometryArrays<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
);

/// The corners of all rows, one polygon each, where those of each row start, centroids and normals.
pub fn arrays<'py>(enclosure: &Enclosure, py: Python<'py>) -> PyResult<GeometryArrays<'py>> {
    let cells = &enclosure.rows.cells;
    let corner = |&c: &u32| cells.points[c as usize].to_array();
    let starts: Vec<i64> = cells.starts.iter().map(|&s| i64::from(s)).collect();
    let frames = cells.frames(enclosure.len());
    Ok((
        triples(py, cells.corners.iter().map(corner))?,
        starts.into_pyarray(py),
        triples(py, frames.iter().map(|f| f.0.to_array()))?,
        triples(py, frames.iter().map(|f| f.1.to_array()))?,
    ))
}
