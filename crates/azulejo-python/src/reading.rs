//! Models from files, as the command reads them.

use crate::choices;
use crate::error::{reading_error, refused};
use crate::scene::NativeScene;
use crate::work::{self, WorkOptions};
use azulejo::models::{self, Reading};
use azulejo_formats::{Lod, ReadOptions};
use azulejo_scene::{Scene, Units, Up};
use azulejo_trace::Progress;
use pyo3::prelude::*;
use std::path::{Path, PathBuf};

/// Which units a scene is requested in.
#[derive(Clone, Copy)]
struct RequestedUnits {
    unit: Option<f64>,
    up: Option<Up>,
}

/// Reads a model of any format.
#[pyfunction]
#[pyo3(signature = (path, unit, up, lod, allow, keep_light, threads, progress))]
#[allow(
    clippy::too_many_arguments,
    reason = "they are the keywords of a Python function"
)]
pub fn load_scene(
    py: Python<'_>,
    path: PathBuf,
    unit: Option<f64>,
    up: Option<&str>,
    lod: LodChoice,
    allow: Vec<PathBuf>,
    keep_light: bool,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<NativeScene> {
    let requested = RequestedUnits {
        unit,
        up: up.map(choices::up).transpose()?,
    };
    let how = Reading {
        options: ReadOptions {
            lod: lod.level()?,
            ..ReadOptions::default()
        },
        allow,
        home: None,
    };
    let (scene, warnings) = work::run(py, &WorkOptions::new(threads, progress), move |p| {
        read(&path, &how, requested, keep_light, p)
    })?;
    Ok(NativeScene::new(scene, warnings))
}

/// A level of detail: `finest`, `coarsest`, `all`, or a viewing distance.
#[derive(FromPyObject)]
pub enum LodChoice {
    /// One by its name.
    Name(String),
    /// The one for a distance.
    Distance(f64),
}

impl LodChoice {
    fn level(&self) -> PyResult<Lod> {
        match self {
            LodChoice::Distance(distance) => Ok(Lod::Distance(*distance)),
            LodChoice::Name(name) => match name.as_str() {
                "finest" => Ok(Lod::Finest),
                "coarsest" => Ok(Lod::Coarsest),
                "all" => Ok(Lod::All),
                other => Err(refused(azulejo::spelling::unknown(
                    "level of detail",
                    other,
                    &["finest", "coarsest", "all"],
                ))),
            },
        }
    }
}

/// The scene, and what was skipped, repaired and changed.
fn read(
    path: &Path,
    how: &Reading,
    requested: RequestedUnits,
    keep_light: bool,
    progress: &Progress,
) -> PyResult<(Scene, Vec<String>)> {
    let mut words = Vec::new();
    let model = if keep_light {
        models::read(path, how, progress).map_err(reading_error)?
    } else {
        let (model, notes) = models::read_unbaked(path, how, progress).map_err(reading_error)?;
        words.extend(notes);
        model
    };
    words.extend(model.warnings.iter().map(ToString::to_string));
    let mut scene = model.scene;
    if !keep_light && scene.drop_lightmaps() {
        words.push("the light of another program's lightmap is left out".to_owned());
    }
    let units = Units {
        metres_per_unit: requested.unit.or(scene.units.metres_per_unit),
        up: requested.up.unwrap_or(scene.units.up),
        ..scene.units
    };
    // A unit or an axis that the caller requested is not a surprise to him.
    Ok((scene.adapted(units), words))
}
