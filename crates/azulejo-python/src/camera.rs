//! The camera of an image.

use crate::error::refused;
use crate::scene::SharedScene;
use azulejo_scene::Camera;
use glam::DVec3;
use pyo3::prelude::*;

/// Image size if neither the caller nor the camera says one.
const SIZE: (u32, u32) = (512, 512);
/// Largest number of pixels: more are a typing error, and need more memory than most machines have.
const MOST_PIXELS: u64 = 1 << 28;

/// What is said of a view; the rest is that of the scene's camera, or of a look at all of it.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct CameraArgs {
    camera: Option<String>,
    eye: Option<[f64; 3]>,
    target: Option<[f64; 3]>,
    up: Option<[f64; 3]>,
    fov: Option<f64>,
    size: Option<(u32, u32)>,
}

impl CameraArgs {
    /// The camera and the size of the image.
    pub fn choose(&self, shared: &SharedScene) -> PyResult<(Camera, (u32, u32))> {
        let given = self.given(shared)?;
        let own_size = given.as_ref().and_then(|c| c.size);
        let size = self.size.or(own_size).unwrap_or(SIZE);
        if !(1..=MOST_PIXELS).contains(&(u64::from(size.0) * u64::from(size.1))) {
            return Err(refused(format_args!(
                "an image of {} x {} pixels, expected 1 to {MOST_PIXELS} in total",
                size.0, size.1
            )));
        }
        let aspect = f64::from(size.0) / f64::from(size.1);
        let camera = match given {
            Some(camera) => camera,
            None => self.whole(shared, aspect)?,
        };
        let camera = Camera {
            eye: self.eye.map_or(camera.eye, DVec3::from),
            target: self.target.map_or(camera.target, DVec3::from),
            up: self.up.map_or(camera.up, DVec3::from),
            vertical_fov: self.fov.map_or(camera.vertical_fov, f64::to_radians),
            ..camera
        };
        let (right, up, forward) = camera.axes();
        if right.is_finite() && up.is_finite() && forward.is_finite() {
            return Ok((camera, size));
        }
        Err(refused(
            "the view has no direction: eye and target coincide, or up points along the view",
        ))
    }

    /// The camera of that name, or the scene's first.
    fn given(&self, shared: &SharedScene) -> PyResult<Option<Camera>> {
        let cameras = &shared.scene.cameras;
        let Some(name) = &self.camera else {
            return Ok(cameras.first().cloned());
        };
        let camera = cameras.iter().find(|c| c.name == *name);
        let names: Vec<&str> = cameras.iter().map(|c| c.name.as_str()).collect();
        let unknown = || refused(azulejo::spelling::unknown("camera", name, &names));
        camera.cloned().map(Some).ok_or_else(unknown)
    }

    /// A view of all of the scene; where no part of it is given, from within if that shows more.
    fn whole(&self, shared: &SharedScene, aspect: f64) -> PyResult<Camera> {
        let bounds = shared.scene.main_bounds();
        if bounds.is_empty() {
            return Err(refused("the scene has no surfaces to view"));
        }
        if self.eye.is_some() || self.target.is_some() {
            return Ok(Camera::framing(
                bounds,
                aspect,
                shared.scene.units.up.axis(),
            ));
        }
        Ok(azulejo_render::first_view(
            &shared.scene,
            shared.tracer(),
            aspect,
        ))
    }
}
