//! Steps that change how the scene is shown, by their first word.

use super::fields::{
    finite, number, numbers, one_of, path, split, switch, two_points, unless, variant, whole,
};
use super::step::{StepResult, command, commands};
use crate::app::App;
use crate::command::Command;
use crate::variants::{all, script_name};
use crate::view::{Backdrop, Comparison, ModelView, SectionPlane, ViewDirection};

/// The step of this first word; `None` if it is not one of the view.
pub(super) fn parse(word: &str, rest: &str) -> Option<StepResult> {
    Some(match word {
        "shading" => set(variant("shading", rest), |view, mode| view.shading = mode),
        "view" => direction(rest),
        "camera" => camera(rest),
        "fov" => set(field_of_view(rest), |view, angle| {
            view.camera.vertical_fov = angle.to_radians();
        }),
        "exposure" => set(unless("auto", rest, number), |view, x| view.exposure = x),
        "range" => {
            let ends = |text: &str| numbers::<2>(text).map(|[low, high]| (low, high));
            let range = unless("auto", rest, ends);
            set(range, |view, range| view.false_color.range = range)
        }
        "color-map" => set(variant("colour map", rest), |view, map| {
            view.false_color.map = map
        }),
        "logarithmic" => set(switch(rest), |view, is| view.false_color.logarithmic = is),
        "isolines" if rest == "0" => set(Ok(0), |view, n| view.false_color.isolines = n),
        "isolines" => set(whole(rest, 64), |view, n| view.false_color.isolines = n),
        "backdrop" => backdrop(rest),
        "show-in" => set(variant("unit of light", rest), |view, unit| {
            view.light_unit = unit
        }),
        "compare" => {
            let comparison = unless("none", rest, comparison);
            set(comparison, |view, comparison| view.comparison = comparison)
        }
        "hide-backs" => set(switch(rest), |view, hides| view.hides_backs = hides),
        "orientation-cube" => set(switch(rest), |view, shows| view.shows_cube = shows),
        "section" => set(unless("none", rest, section), |v, plane| v.section = plane),
        _ => return None,
    })
}

/// A step that changes the view by a value.
fn set<T: 'static>(
    value: Result<T, String>,
    change: impl FnOnce(&mut ModelView, T) + 'static,
) -> StepResult {
    let value = value?;
    Ok(changed(move |_, view| change(view, value)))
}

fn changed(change: impl FnOnce(&App, &mut ModelView) + 'static) -> super::ScriptStep {
    commands(|app| {
        let mut view = app.view.clone();
        change(app, &mut view);
        Ok(vec![Command::SetView(Box::new(view))])
    })
}

/// `front` and the other standard directions, or `all` for the whole model.
fn direction(text: &str) -> StepResult {
    let sides: Vec<_> = all::<ViewDirection>().map(Some).chain([None]).collect();
    let name = |side: Option<_>| side.map_or_else(|| "all".to_owned(), script_name);
    let side = one_of("view", text, &sides, name)?;
    Ok(changed(move |app, view| {
        let (bounds, up) = (app.document.model_bounds(), app.document.units.up);
        match side {
            Some(side) => view.view_from(side, bounds, up),
            None => view.frame(bounds),
        }
    }))
}

fn camera(text: &str) -> StepResult {
    let [eye, target] = two_points(text)?;
    if eye.distance(target).is_nan() || eye.distance(target) <= 0.0 {
        return Err("the target of the camera is its own position".into());
    }
    Ok(changed(move |_, view| {
        (view.camera.eye, view.camera.target) = (eye, target);
    }))
}

fn field_of_view(text: &str) -> Result<f64, String> {
    match number(text)? {
        degrees if (1.0..=170.0).contains(&degrees) => Ok(degrees),
        degrees => Err(format!("a field of view of {degrees}°, expected 1 to 170")),
    }
}

/// `scene`, a colour of three numbers, or an image file, which becomes part of the scene.
fn backdrop(text: &str) -> StepResult {
    if text == "scene" {
        return set(Ok(Backdrop::Scene), |view, scene| view.backdrop = scene);
    }
    match finite(text).as_deref() {
        Some(&[r, g, b]) if [r, g, b].iter().all(|c| (0.0..=255.0).contains(c)) => {
            let color = Backdrop::Color([r, g, b].map(|c| c as u8));
            set(Ok(color), |view, color| view.backdrop = color)
        }
        Some([]) | None => path("backdrop", text).map(|path| command(Command::LoadBackplate(path))),
        Some(_) => Err(format!(
            "\"{text}\" is not a colour of three numbers from 0 to 255"
        )),
    }
}

/// `NAME`, or `NAME SHARE`: another shading mode at the right.
fn comparison(text: &str) -> Result<Comparison, String> {
    let (name, at) = split(text);
    let with = variant("shading", name)?;
    let at = if at.is_empty() { 0.5 } else { share(at)? };
    Ok(Comparison {
        with,
        at: at as f32,
    })
}

/// `AXIS SHARE`, with `flipped` after it for the other side.
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
    match number(text)? {
        share if (0.0..=1.0).contains(&share) => Ok(share),
        share => Err(format!("a share of {share}, expected 0 to 1")),
    }
}
