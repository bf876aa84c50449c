//! The third pass: lightmaps.

use crate::arrays::image;
use crate::choices;
use crate::error::{output_error, refused};
use crate::light::{self, LightArgs};
use crate::page;
use crate::scene::NativeScene;
use crate::work::{self, WorkOptions};
use azulejo::bake::{LightmapPage, Resolution, UnwrapOptions};
use azulejo::lightmap::{BakeError, BakeOptions, BakeSource, Baked, Coordinates, bake};
use azulejo::output::Output;
use azulejo_scene::Scene;
use azulejo_trace::{Progress, Tracer};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyArray3};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::Arc;

/// A lightmap with the model that has it.
#[pyclass(frozen, module = "pyazulejo._pyazulejo")]
pub struct NativeLightmap {
    model: Arc<BakedModel>,
}

struct BakedModel {
    source: BakeSource,
    baked: Baked,
}

/// Which texels there are, and what they hold.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct TexelArgs {
    size: Option<u32>,
    texels: Option<f64>,
    texels_per_metre: Option<f64>,
    pages: u32,
    light: String,
    sides: String,
}

impl TexelArgs {
    /// The library's options, as the command makes them of its own; the light is that of a scene of this unit.
    fn options(&self, light: &LightArgs, metres: f64) -> PyResult<BakeOptions> {
        let resolution = match (self.texels_per_metre, self.texels) {
            (Some(density), _) => Resolution::PerUnit(density * metres),
            (None, Some(texels)) => Resolution::Texels(texels),
            (None, None) => Resolution::Fill,
        };
        Ok(BakeOptions {
            denoises: false,
            is_directional: false,
            charts: UnwrapOptions {
                resolution,
                size: self.size.unwrap_or(resolution.page_size()),
                pages: self.pages,
                ..UnwrapOptions::default()
            },
            coordinates: Coordinates::New,
            densities: Vec::new(),
            follows_light: false,
            pass: light.options()?,
            light: choices::baked_light(&self.light)?,
            sides: choices::baked_sides(&self.sides)?,
        })
    }
}

/// Bakes the lightmap of a scene.
#[pyfunction]
pub fn bake_lightmap(
    py: Python<'_>,
    scene: &NativeScene,
    texels: TexelArgs,
    light: LightArgs,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<NativeLightmap> {
    let scene = scene.scene.clone();
    let options = texels.options(&light, scene.units.metres())?;
    let model = work::run(py, &light.work(threads, progress), move |p| {
        baked(&scene, &options, p)
    })?;
    if let Some(report) = &model.baked.report {
        light.check(report)?;
    }
    Ok(NativeLightmap {
        model: Arc::new(model),
    })
}

/// Bakes as the command does for models that are not glTF.
fn baked(scene: &Scene, options: &BakeOptions, progress: &Progress) -> PyResult<BakedModel> {
    let mut dark = scene.clone();
    dark.drop_lightmaps();
    let mut source = BakeSource::written(&dark, true).map_err(refused)?;
    if source.receivers.is_empty() {
        return Err(refused(
            "the scene has no surface that could receive a lightmap",
        ));
    }
    let tracer = Tracer::new(&source.scene);
    let baked = bake(&source.scene, &tracer, &source.receivers, options, progress);
    let mut baked = baked.map_err(|error| match error {
        BakeError::Solve(error) => light::explained(error),
        BakeError::Memory { .. } => PyMemoryError::new_err(error.to_string()),
        other => refused(other),
    })?;
    source.turn_to_light(&mut baked).map_err(refused)?;
    Ok(BakedModel { source, baked })
}

/// A page: irradiance and its standard error, rows from the top, and the area that each texel covers.
type PageArrays<'py> = (
    Bound<'py, PyArray3<f32>>,
    Bound<'py, PyArray3<f32>>,
    Bound<'py, PyArray2<f32>>,
);

#[pymethods]
impl NativeLightmap {
    /// Its pages.
    #[getter]
    fn pages<'py>(&self, py: Python<'py>) -> PyResult<Vec<PageArrays<'py>>> {
        let arrays = |page: &LightmapPage| {
            let [width, height] = page.size;
            let texels =
                |values: &[[f32; 3]]| image(py, (width, height), values.as_flattened().to_vec());
            let shape = (height as usize, width as usize);
            let areas = Array2::from_shape_vec(shape, page.areas.clone()).map_err(refused)?;
            let (light, errors) = (texels(&page.irradiance)?, texels(&page.standard_error)?);
            Ok((light, errors, areas.into_pyarray(py)))
        };
        let pages = &self.model.baked.lightmap.pages;
        pages.iter().map(arrays).collect()
    }

    /// Statistics by name.
    #[getter]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let baked = &self.model.baked;
        let statistics = match &baked.report {
            Some(report) => light::described(py, report)?,
            None => PyDict::new(py),
        };
        statistics.set_item("error", baked.lightmap.relative_error())?;
        statistics.set_item("mean", baked.lightmap.mean().to_array())?;
        statistics.set_item("texels", baked.texels.sites)?;
        statistics.set_item("gathered_texels", baked.texels.nodes)?;
        statistics.set_item("charts", baked.atlas.layout.charts)?;
        statistics.set_item("differing_sides", baked.differing_sides)?;
        Ok(statistics)
    }

    /// The page that shows it, as HTML.
    fn html(&self, py: Python<'_>, words: page::Words, most: Option<u64>) -> PyResult<String> {
        let model = self.model.clone();
        page::html(py, move || model.page(words, most))
    }

    /// Writes the page, or the model with the lightmap as a binary glTF file; returns what is to be said of that.
    fn save(
        &self,
        py: Python<'_>,
        path: PathBuf,
        is_page: bool,
        words: page::Words,
    ) -> PyResult<Vec<String>> {
        let model = self.model.clone();
        work::run(py, &WorkOptions::new(None, None), move |p| {
            let output = Output::check(&path).map_err(output_error)?;
            let (bytes, notes) = if is_page {
                (model.page(words, None)?, Vec::new())
            } else {
                let file = model.source.glb(&model.baked).map_err(refused)?;
                (file.bytes, file.notes)
            };
            let written = output.write(p, |out| out.write_all(&bytes));
            written.map_err(output_error)?;
            Ok(notes)
        })
    }
}

impl BakedModel {
    fn page(&self, words: page::Words, most: Option<u64>) -> PyResult<Vec<u8>> {
        let (scene, texels) = (&self.source.scene, self.baked.texels.sites as u64);
        page::check_size(azulejo::page::least_size(scene) + texels, most)?;
        let model = azulejo::page::of_baked(scene, &self.baked).map_err(refused)?;
        page::written(model, words, most)
    }
}
