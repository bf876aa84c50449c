//! The second pass: images.

use crate::arrays::image;
use crate::camera::CameraArgs;
use crate::error::{cancelled, refused};
use crate::scene::{NativeScene, SharedScene};
use crate::work::{self, WorkOptions};
use azulejo::spelling::unknown;
use azulejo_render::{FinalGather, ReferencePass, SecondPass, Tone, auto_exposure};
use azulejo_scene::{Camera, Image};
use azulejo_trace::Progress;
use numpy::{PyArray3, PyReadonlyArray3};
use pyo3::prelude::*;

/// How an image is rendered.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct ImageArgs {
    samples: Option<u32>,
    /// Rays of a final gather everywhere; 0 for none; `None` where light is uneven.
    gather: Option<u32>,
    clamp: Option<f64>,
    seed: u64,
    reference: bool,
}

/// Rays of a gather where light is uneven, as the command has it.
const UNEVEN_RAYS: u32 = 16;
/// Samples per pixel, if they are not said.
const SAMPLES: u32 = 16;
const REFERENCE_SAMPLES: u32 = 256;

/// Renders a scene that carries light, or by path tracing one that need not.
#[pyfunction]
pub fn render_image<'py>(
    py: Python<'py>,
    scene: &NativeScene,
    camera: CameraArgs,
    how: ImageArgs,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyArray3<f32>>> {
    let shared = scene.shared();
    let picture = work::run(py, &WorkOptions::new(threads, progress), move |p| {
        let (camera, size) = camera.choose(&shared)?;
        how.render(&shared, &camera, size, p)
    })?;
    let lost = |pixel: &[f32; 3]| !pixel.iter().all(|x| x.is_finite());
    if picture.pixels.iter().any(lost) {
        return Err(refused(
            "some pixels are not finite: lights too bright for numbers of 32 bits",
        ));
    }
    let size = (picture.width, picture.height);
    image(py, size, picture.pixels.into_flattened())
}

impl ImageArgs {
    fn render(
        &self,
        shared: &SharedScene,
        camera: &Camera,
        size: (u32, u32),
        progress: &Progress,
    ) -> PyResult<Image> {
        let (scene, tracer) = (&shared.scene, shared.tracer());
        if self.reference {
            let options = ReferencePass {
                size,
                samples_per_pixel: self.samples.unwrap_or(REFERENCE_SAMPLES),
                seed: self.seed,
                clamp: self.clamp,
                ..ReferencePass::default()
            };
            let picture = azulejo_render::reference(scene, tracer, camera, &options, progress);
            return Ok(picture.map_err(cancelled)?.image);
        }
        let options = SecondPass {
            size,
            samples_per_pixel: self.samples.unwrap_or(SAMPLES),
            gather: match self.gather {
                None => FinalGather::Uneven(UNEVEN_RAYS),
                Some(0) => FinalGather::Unknown,
                Some(rays) => FinalGather::Everywhere(rays),
            },
            seed: self.seed,
            clamp: self.clamp,
            ..SecondPass::default()
        };
        azulejo_render::render(scene, tracer, camera, &options, progress).map_err(cancelled)
    }
}

/// Radiance as 8-bit sRGB; without an exposure, one that suits the image.
#[pyfunction]
pub fn tone_map<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<'py, f32>,
    exposure: Option<f64>,
    tone: &str,
) -> PyResult<Bound<'py, PyArray3<u8>>> {
    let tone = match tone {
        "linear" => Tone::Linear,
        "reinhard" => Tone::Reinhard,
        "filmic" => Tone::Filmic,
        other => {
            let known = ["linear", "reinhard", "filmic"];
            return Err(refused(unknown("tone curve", other, &known)));
        }
    };
    let array = radiance.as_array();
    let (height, width, channels) = array.dim();
    let sides = (u32::try_from(width), u32::try_from(height));
    let ((Ok(width), Ok(height)), 3) = (sides, channels) else {
        return Err(refused("an image has the shape (height, width, 3)"));
    };
    let pixels = array.rows().into_iter().map(|p| [p[0], p[1], p[2]]);
    let linear = Image::opaque(width, height, pixels.collect());
    let factor = exposure.map_or_else(|| auto_exposure(&linear), f64::exp2);
    let bytes = azulejo_render::tone_map(&linear, factor, tone);
    image(py, (width, height), bytes)
}
