//! Reflection models, as `azulejo brdf eval` evaluates them.

use crate::arrays::{triples, vectors};
use crate::error::{cancelled, reading_error, refused};
use crate::work::{self, WorkOptions};
use azulejo::models::read_bytes;
use azulejo::spelling::unknown;
use azulejo_formats::Folder;
use azulejo_formats::brdf::LoadedBrdf;
use azulejo_scene::brdf::{BrdfError, Description, find};
use azulejo_scene::{Brdf, Rgb};
use glam::DVec3;
use numpy::{PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use rayon::prelude::*;
use std::path::Path;
use std::sync::Arc;

/// Pairs of directions between two looks at the progress.
const BATCH: usize = 4096;

/// A model of one text: `name key=value ...`, or the name of a file.
///
/// # Errors
/// What is wrong with it; what the file system refused.
pub fn model(text: &str) -> PyResult<Brdf> {
    let mut words = text.split_whitespace();
    let name = words.next().unwrap_or_default();
    let description = if is_file(name) {
        if let Some(parameter) = words.next() {
            return Err(refused(format_args!(
                "{name} is a file, for which `{parameter}` cannot be set"
            )));
        }
        read_file(Path::new(name))?
    } else {
        text.parse().map_err(explained)?
    };
    Brdf::new(description).map_err(explained)
}

/// Names of models take precedence: a file of the same name is given as `./ward`.
fn is_file(name: &str) -> bool {
    let is_model = name.eq_ignore_ascii_case("combination") || find(name).is_ok();
    !is_model && (name.contains(['/', '\\', '.']) || Path::new(name).exists())
}

fn read_file(path: &Path) -> PyResult<Description> {
    let bytes = read_bytes(path).map_err(reading_error)?;
    let name = path.to_string_lossy();
    let read = azulejo_formats::brdf::read(&bytes, &name, &Folder::of_model(path));
    let LoadedBrdf { content, .. } = read.map_err(refused)?;
    Ok(Description::File {
        path: name.into_owned(),
        content: Some(Arc::new(content)),
    })
}

fn explained(problem: BrdfError) -> PyErr {
    match problem {
        BrdfError::UnknownModel { .. } => {
            refused(format_args!("{problem}, and there is no file of that name"))
        }
        other => refused(other),
    }
}

/// What is evaluated.
#[derive(Clone, Copy)]
enum BrdfQuantity {
    /// f_r, 1/sr.
    Value,
    /// Reflectance of the perfect mirror at the angle of `wi`.
    Mirror,
    /// All that is reflected of light from `wi`.
    Albedo,
}

impl BrdfQuantity {
    fn named(name: &str) -> PyResult<BrdfQuantity> {
        match name {
            "brdf" => Ok(BrdfQuantity::Value),
            "mirror" => Ok(BrdfQuantity::Mirror),
            "albedo" => Ok(BrdfQuantity::Albedo),
            other => {
                let known = ["brdf", "mirror", "albedo"];
                Err(refused(unknown("quantity", other, &known)))
            }
        }
    }

    fn of(self, brdf: &Brdf, wi: DVec3, wo: DVec3) -> Rgb {
        match self {
            BrdfQuantity::Value => brdf.eval(wo, wi),
            BrdfQuantity::Mirror => brdf.mirror(wi.z),
            BrdfQuantity::Albedo => brdf.albedo(wi),
        }
    }
}

/// A model for pairs of unit directions, n × 3 each.
#[pyfunction]
pub fn evaluate_brdf<'py>(
    py: Python<'py>,
    text: &str,
    wi: PyReadonlyArray2<'py, f64>,
    wo: PyReadonlyArray2<'py, f64>,
    quantity: &str,
    threads: Option<usize>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (wi, wo) = (vectors(&wi)?, vectors(&wo)?);
    let (brdf, quantity) = (model(text)?, BrdfQuantity::named(quantity)?);
    if wi.len() != wo.len() {
        return Err(refused("as many wi as wo are needed"));
    }
    let values = work::run(py, &WorkOptions::new(threads, None), move |p| {
        p.begin("evaluating", wi.len() as u64);
        let batches = wi.par_chunks(BATCH).zip(wo.par_chunks(BATCH));
        let values = batches.map(|(wi, wo)| {
            p.advance(wi.len() as u64).map_err(cancelled)?;
            let pairs = wi.iter().zip(wo);
            Ok(pairs
                .map(|(&i, &o)| quantity.of(&brdf, i, o).to_array())
                .collect())
        });
        let values: PyResult<Vec<Vec<[f64; 3]>>> = values.collect();
        Ok(values?.concat())
    })?;
    triples(py, values)
}
