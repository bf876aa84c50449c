//! `render --look rtrace`: renders as RTRACE did, with its options.

use super::args::{RenderArgs, RenderStyle, RtraceArgs};
use crate::camera;
use crate::failure::Failure;
use crate::session::Session;
use crate::values::UpArg;
use azulejo_render::rtrace::{
    self, Antialiasing, AntialiasingMode, Model, Options, Shadows, Textures, View,
};
use azulejo_scene::{Image, Rtrace, Scene};

/// RTRACE's image size, if neither the command line nor the scene specifies one.
const SIZE: (u32, u32) = (256, 256);

/// Refuses options that do not apply to the chosen look.
pub fn check(args: &RenderArgs) -> Result<(), Failure> {
    if args.look.look != RenderStyle::Rtrace {
        return match args.look.given() {
            Some(name) => Err(Failure::misuse(format_args!(
                "--{name} requires --look rtrace"
            ))),
            None => Ok(()),
        };
    }
    let given = [
        ("exposure", args.picture.exposure.is_some()),
        ("gather", args.picture.gather.is_some()),
        ("reference", args.picture.reference),
        ("clamp", args.picture.clamp.is_some()),
        ("layers", args.picture.layers.is_some()),
        ("denoise", args.picture.denoise),
    ];
    let views = [
        ("cameras", args.cameras.is_some()),
        ("turntable", args.turntable.is_some()),
    ];
    if let Some((name, _)) = views.into_iter().find(|(_, is_given)| *is_given) {
        return Err(Failure::misuse(format_args!(
            "--{name} does not apply to --look rtrace, which has the one view of its scene"
        )));
    }
    match given.into_iter().find(|(_, is_given)| *is_given) {
        Some((name, _)) => Err(Failure::misuse(format_args!(
            "--{name} does not apply to --look rtrace, which shows RTRACE's values unchanged"
        ))),
        None => Ok(()),
    }
}

/// Renders the scene as RTRACE does.
pub fn draw(scene: &Scene, args: &RenderArgs, session: &Session) -> Result<Image, Failure> {
    let Some(numbers) = &scene.rtrace else {
        return Err(Failure::failed(
            "--look rtrace needs the surfaces and lights of a single SFF or SCN scene that is \
             neither moved nor scaled; this scene has none",
        ));
    };
    let view = view(scene, numbers, args)?;
    let options = options(&args.look);
    let image = session
        .with_progress(|progress| rtrace::render(scene, numbers, &view, &options, progress))?;
    Ok(image)
}

/// The scene's view with the changes of the command line. If that specifies a field of view, pixels
/// are square.
fn view(scene: &Scene, numbers: &Rtrace, args: &RenderArgs) -> Result<View, Failure> {
    let given = &args.view;
    let camera = match &given.camera {
        Some(name) => Some(camera::by_name_or_file(name, scene)?),
        None => None,
    };
    let own_size = scene.cameras.first().and_then(|c| c.size);
    let size = args.picture.size;
    let size = size.or(camera.as_ref().map_or(own_size, |c| c.size));
    let size = size.unwrap_or(SIZE);
    camera::check_size(size)?;
    let mut view = View::of(numbers, size);
    let mut field = given.fov.map(f64::to_radians);
    if let Some(camera) = camera {
        (view.eye, view.look, view.up) = (camera.eye, camera.target, camera.up);
        field = field.or(Some(camera.vertical_fov));
    }
    if let Some(UpArg::Picture(up)) = args.input.reading.up {
        view.up = up;
    }
    view.eye = given.from.unwrap_or(view.eye);
    view.look = given.at.unwrap_or(view.look);
    if let Some(field) = field {
        let aspect = f64::from(size.0) / f64::from(size.1);
        view.half_angles = [((0.5 * field).tan() * aspect).atan(), 0.5 * field];
    }
    (view.aperture, view.focus) = (args.look.look_aperture.unwrap_or(0.0), args.look.look_focus);
    if (view.look - view.eye).cross(view.up).length() > 0.0 {
        return Ok(match args.look.look_eye {
            Some((side, apart)) => view.of_eye(side, apart),
            None => view,
        });
    }
    Err(Failure::misuse(
        "the view has no direction: --from and --at coincide, or --up points along the view",
    ))
}

fn options(look: &RtraceArgs) -> Options {
    let default = Options::default();
    let antialiasing = Antialiasing {
        mode: match look.look_antialiasing {
            None | Some(0) => AntialiasingMode::Adaptive,
            Some(1) => AntialiasingMode::SemiAdaptive,
            Some(_) => AntialiasingMode::Fixed,
        },
        levels: look.look_levels.map_or(0, u32::from),
        threshold: look
            .look_threshold
            .unwrap_or(default.antialiasing.threshold),
        all_objects: look.look_all_objects,
    };
    Options {
        model: match look.look_model {
            Some(0) => Model::Phong,
            _ => Model::Strauss,
        },
        textures: match look.look_textures {
            None | Some(0) => Textures::None,
            Some(1) => Textures::Inline,
            Some(_) => Textures::Section,
        },
        shadows: match look.look_shadows {
            None | Some(0) => Shadows::Opaque,
            Some(1) => Shadows::Filtered,
            Some(_) => Shadows::Transmitted,
        },
        depth: look.look_depth.unwrap_or(default.depth),
        cut: look.look_cut.unwrap_or(default.cut),
        antialiasing,
        ambient_depth: look.look_ambient_depth.unwrap_or(default.ambient_depth),
        ambient_samples: look.look_ambient_samples.unwrap_or(default.ambient_samples),
    }
}

impl RtraceArgs {
    /// The name of the first RTRACE option on the command line.
    fn given(&self) -> Option<&'static str> {
        let given = [
            ("look-model", self.look_model.is_some()),
            ("look-textures", self.look_textures.is_some()),
            ("look-shadows", self.look_shadows.is_some()),
            ("look-levels", self.look_levels.is_some()),
            ("look-threshold", self.look_threshold.is_some()),
            ("look-antialiasing", self.look_antialiasing.is_some()),
            ("look-all-objects", self.look_all_objects),
            ("look-depth", self.look_depth.is_some()),
            ("look-cut", self.look_cut.is_some()),
            ("look-ambient-depth", self.look_ambient_depth.is_some()),
            ("look-ambient-samples", self.look_ambient_samples.is_some()),
            ("look-aperture", self.look_aperture.is_some()),
            ("look-focus", self.look_focus.is_some()),
            ("look-eye", self.look_eye.is_some()),
        ];
        given.into_iter().find(|(_, is)| *is).map(|(name, _)| name)
    }
}
