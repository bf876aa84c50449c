//! NumPy arrays from vectors, and back.

use crate::error::refused;
use azulejo_factors::form_factors::SkyFactors;
use azulejo_radiosity::PointNormal;
use azulejo_scene::{Rgb, Up};
use glam::DVec3;
use numpy::ndarray::{Array2, Array3};
use numpy::{Element, IntoPyArray, PyArray1, PyArray2, PyArray3, PyReadonlyArray2};
use pyo3::prelude::*;

/// An array of n rows of three numbers.
pub fn triples<'py>(
    py: Python<'py>,
    rows: impl IntoIterator<Item = [f64; 3]>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let numbers: Vec<f64> = rows.into_iter().flatten().collect();
    let shape = (numbers.len() / 3, 3);
    let array = Array2::from_shape_vec(shape, numbers).map_err(refused)?;
    Ok(array.into_pyarray(py))
}

/// An array of red, green and blue for each entry.
pub fn colours<'py>(py: Python<'py>, values: &[Rgb]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    triples(py, values.iter().map(|c| c.to_array()))
}

/// An image: rows from the top, columns, channels.
pub fn image<'py, E: Element>(
    py: Python<'py>,
    (width, height): (u32, u32),
    numbers: Vec<E>,
) -> PyResult<Bound<'py, PyArray3<E>>> {
    let shape = (height as usize, width as usize, 3);
    let array = Array3::from_shape_vec(shape, numbers).map_err(refused)?;
    Ok(array.into_pyarray(py))
}

/// Shares of patches of the sky, their standard errors, directions and solid angles of the patches, and the name of the
/// division.
pub type SkyArrays<'py> = (
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
    String,
);

/// What rows see of the patches of the sky in a scene of this up axis.
pub fn sky_arrays<'py>(py: Python<'py>, sky: &SkyFactors, up: Up) -> PyResult<SkyArrays<'py>> {
    let count = sky.division.count();
    let table = |numbers: &[f32]| {
        let shape = (numbers.len() / count, count);
        let array = Array2::from_shape_vec(shape, numbers.to_vec()).map_err(refused)?;
        Ok::<_, PyErr>(array.into_pyarray(py))
    };
    let directions = sky.directions(up).into_iter().map(|d| d.to_array());
    Ok((
        table(&sky.shares)?,
        table(&sky.errors)?,
        triples(py, directions)?,
        sky.solid_angles().into_pyarray(py),
        sky.division.to_string(),
    ))
}

/// Rows of three numbers as vectors.
pub fn vectors(array: &PyReadonlyArray2<f64>) -> PyResult<Vec<DVec3>> {
    let array = array.as_array();
    if array.ncols() != 3 {
        let (rows, columns) = array.dim();
        return Err(refused(format_args!(
            "an array of shape ({rows}, {columns}), expected (n, 3)"
        )));
    }
    let row = |r: numpy::ndarray::ArrayView1<f64>| DVec3::new(r[0], r[1], r[2]);
    Ok(array.rows().into_iter().map(row).collect())
}

/// Points with unit normals.
pub fn points_with_normals(
    points: &PyReadonlyArray2<f64>,
    normals: &PyReadonlyArray2<f64>,
) -> PyResult<Vec<PointNormal>> {
    let (points, normals) = (vectors(points)?, vectors(normals)?);
    let pair = |(i, (position, normal)): (usize, (DVec3, &DVec3))| match normal.try_normalize() {
        Some(normal) if position.is_finite() => Ok(PointNormal { position, normal }),
        Some(_) => Err(refused(format_args!("point {i} is not finite"))),
        None => Err(refused(format_args!("normal {i} is zero or not finite"))),
    };
    points
        .into_iter()
        .zip(&normals)
        .enumerate()
        .map(pair)
        .collect()
}
