//! The camera of an image, and the image's size.

use super::failure::Failure;
use super::values::{self, UpArg};
use azulejo::models;
use azulejo_formats::camera_json;
use azulejo_scene::{Camera, Scene};
use azulejo_trace::Tracer;
use clap::{Args, ValueHint};
use glam::{DQuat, DVec3};
use std::f64::consts::TAU;
use std::path::Path;

/// The camera.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Camera")]
pub struct CameraArgs {
    /// A camera file (.json), or the name of one of the scene's cameras [default: the scene's
    /// first camera, or a view of the whole scene]
    #[arg(long, value_name = "FILE|NAME", value_hint = ValueHint::FilePath)]
    pub camera: Option<String>,
    /// Position of the camera
    #[arg(long, value_name = "X,Y,Z", value_parser = values::vector, allow_hyphen_values = true)]
    pub from: Option<DVec3>,
    /// Point that the camera looks at
    #[arg(long, value_name = "X,Y,Z", value_parser = values::vector, allow_hyphen_values = true)]
    pub at: Option<DVec3>,
    /// Vertical field of view in degrees
    #[arg(long, value_name = "DEGREES", value_parser = values::degrees)]
    pub fov: Option<f64>,
}

/// Image size if neither the command line nor the camera specifies one.
pub const SIZE: (u32, u32) = (512, 512);
/// Largest number of pixels: more are a typing error, and need more memory than most machines have.
const MAX_PIXELS: u64 = 1 << 28;

/// The camera and the size of the image: from the command line, otherwise from the scene, otherwise
/// what `first` finds to be worth a look, for the image's width over its height.
pub fn choose(
    view: &CameraArgs,
    size: Option<(u32, u32)>,
    scene: &Scene,
    up: Option<UpArg>,
    first: impl FnOnce(&Scene, f64) -> Camera,
) -> Result<(Camera, (u32, u32)), Failure> {
    let up = match up {
        Some(UpArg::Picture(direction)) => Some(direction),
        _ => None,
    };
    let given = match &view.camera {
        Some(name) => Some(by_name_or_file(name, scene)?),
        None => scene.cameras.first().cloned(),
    };
    let size = size.or(given.as_ref().and_then(|c| c.size)).unwrap_or(SIZE);
    check_size(size)?;
    let camera = match given {
        Some(camera) => camera,
        None if scene.bounds().is_empty() => {
            return Err(Failure::failed("the scene has no surfaces to view"));
        }
        // A view that is given in parts is completed by that of the whole scene.
        None if view.from.is_some() || view.at.is_some() => overview(scene, aspect(size)),
        None => first(scene, aspect(size)),
    };
    let up = up.or_else(|| upright(&camera, view, scene.units.up.axis()));
    let camera = overridden(camera, view, up);
    check(&camera)?;
    Ok((camera, size))
}

/// A camera of the scene, or of a camera file.
pub fn by_name_or_file(name: &str, scene: &Scene) -> Result<Camera, Failure> {
    if let Some(camera) = scene.cameras.iter().find(|c| c.name == name) {
        return Ok(camera.clone());
    }
    let path = Path::new(name);
    if path.exists() || name.to_ascii_lowercase().ends_with(".json") {
        let bytes = models::read_bytes(path)?;
        return camera_json::read(&bytes, name).map_err(Failure::failed);
    }
    let known: Vec<String> = scene
        .cameras
        .iter()
        .map(|c| format!("\"{}\"", c.name))
        .collect();
    let known = match known.len() {
        0 => "none".to_owned(),
        _ => known.join(", "),
    };
    Err(Failure::Failed(format!(
        "there is no camera \"{name}\" and no file of that name; the scene's cameras: {known}"
    )))
}

fn aspect((width, height): (u32, u32)) -> f64 {
    f64::from(width) / f64::from(height)
}

/// A view of all of the scene.
pub fn overview(scene: &Scene, aspect: f64) -> Camera {
    Camera::framing(scene.main_bounds(), aspect, scene.units.up.axis())
}

/// A view of all of the scene, or from within where that shows nothing.
pub fn first_look(scene: &Scene, aspect: f64) -> Camera {
    azulejo_render::first_view(scene, &Tracer::new(scene), aspect)
}

/// Views from all around: `count` of them, turned about the up axis through what the camera looks
/// at, the first its own.
pub fn turntable(camera: &Camera, count: u32, up: DVec3) -> Vec<Camera> {
    let turned = |k: u32| {
        let turn = DQuat::from_axis_angle(up, TAU * f64::from(k) / f64::from(count));
        Camera {
            eye: camera.target + turn * (camera.eye - camera.target),
            up: turn * camera.up,
            ..camera.clone()
        }
    };
    (0..count).map(turned).collect()
}

/// The up axis for a camera that is moved: from elsewhere, the tilt of the scene's own camera would be a
/// roll. `None` if it is not moved, has another axis, or looks along it.
fn upright(camera: &Camera, view: &CameraArgs, axis: DVec3) -> Option<DVec3> {
    let is_moved = view.camera.is_none() && (view.from.is_some() || view.at.is_some());
    let eye = view.from.unwrap_or(camera.eye);
    let forward = (view.at.unwrap_or(camera.target) - eye).normalize_or_zero();
    let has_axis = camera.up.normalize_or_zero().dot(axis) > 0.5;
    (is_moved && has_axis && forward.cross(axis).length() > 0.01).then_some(axis)
}

fn overridden(camera: Camera, view: &CameraArgs, up: Option<DVec3>) -> Camera {
    Camera {
        eye: view.from.unwrap_or(camera.eye),
        target: view.at.unwrap_or(camera.target),
        up: up.unwrap_or(camera.up),
        vertical_fov: view.fov.map_or(camera.vertical_fov, f64::to_radians),
        ..camera
    }
}

fn check(camera: &Camera) -> Result<(), Failure> {
    let (right, up, forward) = camera.axes();
    if right.is_finite() && up.is_finite() && forward.is_finite() {
        return Ok(());
    }
    Err(Failure::misuse(
        "the view has no direction: --from and --at coincide, or --up points along the view",
    ))
}

/// Refuses images without pixels, and very large ones.
pub fn check_size((width, height): (u32, u32)) -> Result<(), Failure> {
    if (1..=MAX_PIXELS).contains(&(u64::from(width) * u64::from(height))) {
        return Ok(());
    }
    Err(Failure::misuse(format_args!(
        "an image of {width}x{height} pixels, expected 1 to {MAX_PIXELS} in total"
    )))
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::{Object, Primitive, Shape};

    fn scene() -> Scene {
        let mut scene = Scene::default();
        let ball = Primitive::sphere(DVec3::new(5.0, 0.0, 0.0), 1.0, 0);
        scene
            .objects
            .push(Object::new("ball", Shape::Primitive(ball)));
        scene
    }

    fn camera(name: &str, size: Option<(u32, u32)>) -> Camera {
        Camera {
            name: name.into(),
            eye: DVec3::ZERO,
            target: DVec3::X,
            up: DVec3::Y,
            vertical_fov: 0.5,
            size,
        }
    }

    fn view() -> CameraArgs {
        CameraArgs {
            camera: None,
            from: None,
            at: None,
            fov: None,
        }
    }

    #[test]
    fn a_scene_without_camera_is_framed_whole() {
        let (camera, size) = choose(&view(), None, &scene(), None, overview).unwrap();
        assert_eq!(size, (512, 512));
        let half_angle = (1.0 / (camera.eye - camera.target).length()).asin();
        assert!(half_angle < 0.5 * camera.vertical_fov);
        assert!(choose(&view(), None, &Scene::default(), None, overview).is_err());
    }

    #[test]
    fn turntables_go_all_around() {
        let start = overview(&scene(), 1.0);
        let views = turntable(&start, 4, DVec3::Y);
        assert_eq!(views.len(), 4);
        assert!(views[0].eye.distance(start.eye) < 1e-12);
        for view in &views {
            let apart = |c: &Camera| c.eye.distance(c.target);
            assert!((apart(view) - apart(&start)).abs() < 1e-9);
            assert!((view.eye.y - start.eye.y).abs() < 1e-9);
        }
        let across = |a: usize, b: usize| views[a].eye - views[b].eye;
        assert!(across(0, 2).dot(across(1, 3)).abs() < 1e-9);
    }

    #[test]
    fn the_command_line_wins_over_the_file() {
        let mut scene = scene();
        scene.cameras = vec![camera("a", None), camera("b", Some((30, 20)))];
        let mut view = view();
        view.camera = Some("b".into());
        view.fov = Some(90.0);
        view.from = Some(DVec3::new(0.0, 0.0, 9.0));
        let (chosen, size) = choose(&view, None, &scene, None, overview).unwrap();
        assert_eq!((chosen.name.as_str(), size), ("b", (30, 20)));
        assert_eq!(
            (chosen.eye.z, chosen.vertical_fov),
            (9.0, std::f64::consts::FRAC_PI_2)
        );
        assert_eq!(
            choose(&view, Some((7, 5)), &scene, None, overview)
                .unwrap()
                .1,
            (7, 5)
        );
    }

    #[test]
    fn impossible_views_are_refused() {
        let mut scene = scene();
        scene.cameras = vec![camera("a", None)];
        let along = Some(UpArg::Picture(DVec3::X));
        assert!(matches!(
            choose(&view(), None, &scene, along, overview),
            Err(Failure::Misuse(_))
        ));
        let mut unknown = view();
        unknown.camera = Some("c".into());
        let message = choose(&unknown, None, &scene, None, overview)
            .unwrap_err()
            .to_string();
        assert!(message.contains("\"a\""), "{message}");
        assert!(choose(&view(), Some((65_536, 65_536)), &scene, None, overview).is_err());
    }
}
