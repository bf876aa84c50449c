//! Steps that change how the scene is shown, by their first word.

use super::fields::{
    finite, number, numbers, one_of, path, split, switch, two_points, unless, whole,
};
use crate::app::App;
use crate::command::Command;
use crate::view::{
    Backdrop, ColorMap, Comparison, LightUnit, ModelView, SectionPlane, Shading, ViewDirection,
};
use azulejo::scene::Camera;
use glam::DVec3;
use std::path::PathBuf;

/// What a step that changes the view does.
#[derive(Clone, Debug, PartialEq)]
pub enum ViewStep {
    /// `shading NAME`, such as `irradiance` or `false-color`.
    Shading(Shading),
    /// `view front`, `back`, `left`, `right`, `top`, `bottom`, `corner`, `all`.
    From(Option<ViewDirection>),
    /// `camera EX EY EZ TX TY TZ`: sets the camera's position and target.
    Camera(DVec3, DVec3),
    /// `fov DEGREES`: sets the vertical field of view.
    Fov(f64),
    /// `exposure FACTOR`, `exposure auto`.
    Exposure(Option<f64>),
    /// `range LOW HIGH`, `range auto`: of false colours, W/m² or lx.
    Range(Option<(f64, f64)>),
    /// `color-map NAME`: of false colours.
    ColorMap(ColorMap),
    /// `logarithmic on`, `off`: of false colours.
    Logarithmic(bool),
    /// `isolines N`: of false colours; 0 for none.
    Isolines(u32),
    /// `backdrop scene`, `backdrop R G B` of 0 to 255.
    Backdrop(Option<[u8; 3]>),
    /// `backdrop FILE`: an image, which belongs to the scene.
    BackdropImage(PathBuf),
    /// `show-in file`, `watts`, `lumens`: the unit in which light is shown.
    LightUnit(LightUnit),
    /// `compare NAME`, `compare NAME SHARE`, `compare none`: another shading mode at the right.
    Compare(Option<Comparison>),
    /// `hide-backs on`, `off`.
    HideBacks(bool),
    /// `orientation-cube on`, `off`.
    OrientationCube(bool),
    /// `section AXIS SHARE`, with `flipped` after it, `section none`: a plane that cuts the model
    /// open.
    Section(Option<SectionPlane>),
}

/// The step of this first word; `None` if it is not one of the view.
pub(super) fn parse(word: &str, rest: &str) -> Option<Result<ViewStep, String>> {
    Some(match word {
        "shading" => one_of("shading", rest, &Shading::ALL, |s| s.script_name().into())
            .map(ViewStep::Shading),
        "view" => direction(rest).map(ViewStep::From),
        "camera" => camera(rest),
        "fov" => number(rest).and_then(|degrees| {
            let is_angle = (1.0..=170.0).contains(&degrees);
            let wrong = || format!("a field of view of {degrees}°, expected 1 to 170");
            is_angle.then_some(ViewStep::Fov(degrees)).ok_or_else(wrong)
        }),
        "exposure" => unless("auto", rest, number).map(ViewStep::Exposure),
        "range" => {
            unless("auto", rest, |t| numbers::<2>(t).map(|[a, b]| (a, b))).map(ViewStep::Range)
        }
        "color-map" => {
            let name = |map: ColorMap| format!("{map:?}").to_ascii_lowercase();
            one_of("colour map", rest, &ColorMap::ALL, name).map(ViewStep::ColorMap)
        }
        "logarithmic" => switch(rest).map(ViewStep::Logarithmic),
        "isolines" if rest == "0" => Ok(ViewStep::Isolines(0)),
        "isolines" => whole(rest, 64).map(ViewStep::Isolines),
        "backdrop" => backdrop(rest),
        "show-in" => light_unit(rest).map(ViewStep::LightUnit),
        "compare" => unless("none", rest, comparison).map(ViewStep::Compare),
        "hide-backs" => switch(rest).map(ViewStep::HideBacks),
        "orientation-cube" => switch(rest).map(ViewStep::OrientationCube),
        "section" => unless("none", rest, section).map(ViewStep::Section),
        _ => return None,
    })
}

fn direction(text: &str) -> Result<Option<ViewDirection>, String> {
    use ViewDirection::{Back, Bottom, Corner, Front, Left, Right, Top};
    let all = [Front, Back, Left, Right, Top, Bottom, Corner].map(Some);
    let all: Vec<_> = all.into_iter().chain([None]).collect();
    one_of("view", text, &all, |side| match side {
        Some(side) => format!("{side:?}").to_ascii_lowercase(),
        None => "all".to_owned(),
    })
}

fn camera(text: &str) -> Result<ViewStep, String> {
    let [eye, target] = two_points(text)?;
    if eye.distance(target).is_nan() || eye.distance(target) <= 0.0 {
        return Err("the target of the camera is its own position".into());
    }
    Ok(ViewStep::Camera(eye, target))
}

fn backdrop(text: &str) -> Result<ViewStep, String> {
    if text == "scene" {
        return Ok(ViewStep::Backdrop(None));
    }
    match finite(text).as_deref() {
        Some(&[r, g, b]) if [r, g, b].iter().all(|c| (0.0..=255.0).contains(c)) => {
            Ok(ViewStep::Backdrop(Some([r, g, b].map(|c| c as u8))))
        }
        Some([]) | None => Ok(ViewStep::BackdropImage(path("backdrop", text)?)),
        Some(_) => Err(format!(
            "\"{text}\" is not a colour of three numbers from 0 to 255"
        )),
    }
}

fn light_unit(text: &str) -> Result<LightUnit, String> {
    one_of("unit of light", text, &LightUnit::ALL, |unit| {
        let name = match unit {
            LightUnit::Document => "file",
            LightUnit::Radiometric => "watts",
            LightUnit::Photometric => "lumens",
        };
        name.to_owned()
    })
}

fn comparison(text: &str) -> Result<Comparison, String> {
    let (name, at) = split(text);
    let with = one_of("shading", name, &Shading::ALL, |s| s.script_name().into())?;
    let at = if at.is_empty() { 0.5 } else { share(at)? };
    Ok(Comparison {
        with,
        at: at as f32,
    })
}

fn section(text: &str) -> Result<SectionPlane, String> {
    let (axis, rest) = split(text);
    let (at, side) = split(rest);
    let axis = one_of("axis", axis, &[0, 1, 2], |k| ["x", "y", "z"][k].to_owned())?;
    let is_flipped = match side {
        "" => false,
        "flipped" => true,
        other => return Err(format!("\"{other}\" after the share, expected flipped")),
    };
    Ok(SectionPlane {
        axis,
        at: share(at)?,
        is_flipped,
    })
}

fn share(text: &str) -> Result<f64, String> {
    let share = number(text)?;
    let wrong = || format!("a share of {share}, expected 0 to 1");
    (0.0..=1.0)
        .contains(&share)
        .then_some(share)
        .ok_or_else(wrong)
}

impl ViewStep {
    /// The command of the step.
    pub(super) fn command(self, app: &App) -> Command {
        if let ViewStep::BackdropImage(path) = self {
            return Command::LoadBackplate(path);
        }
        let mut view = app.view.clone();
        self.change(app, &mut view);
        Command::SetView(Box::new(view))
    }

    fn change(self, app: &App, view: &mut ModelView) {
        match self {
            ViewStep::Shading(shading) => view.shading = shading,
            ViewStep::From(side) => {
                let (bounds, up) = (app.document.model_bounds(), app.document.units.up);
                match side {
                    Some(side) => view.view_from(side, bounds, up),
                    None => view.frame(bounds),
                }
            }
            ViewStep::Camera(eye, target) => {
                view.camera = Camera {
                    eye,
                    target,
                    ..view.camera.clone()
                };
            }
            ViewStep::Fov(degrees) => view.camera.vertical_fov = degrees.to_radians(),
            ViewStep::Exposure(exposure) => view.exposure = exposure,
            ViewStep::Range(range) => view.false_color.range = range,
            ViewStep::ColorMap(map) => view.false_color.map = map,
            ViewStep::Logarithmic(is_so) => view.false_color.logarithmic = is_so,
            ViewStep::Isolines(count) => view.false_color.isolines = count,
            ViewStep::Backdrop(color) => {
                view.backdrop = color.map_or(Backdrop::Scene, Backdrop::Color);
            }
            ViewStep::BackdropImage(_) => {}
            ViewStep::LightUnit(unit) => view.light_unit = unit,
            ViewStep::Compare(comparison) => view.comparison = comparison,
            ViewStep::HideBacks(hides) => view.hides_backs = hides,
            ViewStep::OrientationCube(shows) => view.shows_cube = shows,
            ViewStep::Section(section) => view.section = section,
        }
    }
}
