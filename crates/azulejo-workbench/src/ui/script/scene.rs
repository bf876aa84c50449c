//! Steps that edit the scene and its objects, by their first word.

use super::fields::{finite, name, number, numbers, path, split, unless, vector};
use super::selected::{selected, selected_one};
use super::step::{StepResult, command, commands};
use crate::app::App;
use crate::command::{Command, PrismBase};
use crate::document::{Edit, ItemId};
use azulejo::scene::{
    Backplate, BackplateFit, Camera, Fog, PrimitiveKind, Rgb, SceneBackground, Shape, Units, Up,
};
use glam::{DAffine3, DMat3, DQuat, DVec3, EulerRot};
use std::path::PathBuf;
use std::sync::Arc;

/// The step of this first word; `None` if it is not one of the scene.
pub(super) fn parse(word: &str, rest: &str) -> Option<StepResult> {
    Some(match word {
        "rename" => edit(name(word, rest), |app, name| {
            Ok(Edit::Rename(selected_one(app)?, name))
        }),
        "move" => edit(vector(rest), |app, by| {
            Ok(Edit::Transform(
                selected(app)?,
                DAffine3::from_translation(by),
            ))
        }),
        "scale" => edit(number(rest), |app, factor| {
            let map = DAffine3::from_scale(DVec3::splat(factor));
            Ok(Edit::Transform(selected(app)?, about_centre(app, map)))
        }),
        "turn" => edit(vector(rest), |app, degrees| {
            let [x, y, z] = degrees.to_array().map(f64::to_radians);
            let turn = DMat3::from_rotation_z(z) * DMat3::from_rotation_y(y);
            let turn = DAffine3::from_mat3(turn * DMat3::from_rotation_x(x));
            Ok(Edit::Transform(selected(app)?, about_centre(app, turn)))
        }),
        "place" => edit(place(rest), |app, placement| {
            Ok(Edit::SetPlacement(selected_one(app)?, placement))
        }),
        "cone" => edit(number(rest), cone),
        "text" => text(rest),
        "prism" => prism(rest),
        "take-view" => edit(Ok(()), |app, ()| {
            let (id, camera) = selected_camera(app)?;
            let taken = Camera {
                name: camera.name.clone(),
                size: camera.size,
                ..app.view.camera.clone()
            };
            Ok(Edit::SetCamera(id, taken))
        }),
        "look-through" => Ok(commands(|app| {
            let mut view = app.view.clone();
            view.camera = selected_camera(app)?.1.clone();
            Ok(vec![Command::SetView(Box::new(view))])
        })),
        "background" => background(rest),
        "fog" => edit(unless("none", rest, fog), |_, fog| Ok(Edit::SetFog(fog))),
        "units" => edit(units(rest), |_, units| Ok(Edit::SetUnits(units))),
        _ => return None,
    })
}

/// A step that edits the document by a value.
fn edit<T: 'static>(
    value: Result<T, String>,
    edit: impl FnOnce(&App, T) -> Result<Edit, String> + 'static,
) -> StepResult {
    let value = value?;
    Ok(commands(move |app| {
        Ok(vec![Command::Edit(edit(app, value)?, None)])
    }))
}

/// `R G B` or `none`: a colour; `scaled`, `centered` or `tiled`, with the radiance of white after it:
/// the image of `backdrop`.
fn background(text: &str) -> StepResult {
    let name = |fit: BackplateFit| format!("{fit:?}").to_ascii_lowercase();
    let (word, white) = split(text);
    let Some(fit) = BackplateFit::ALL.into_iter().find(|&fit| name(fit) == word) else {
        return edit(unless("none", text, vector), |_, color| {
            let color = color.map(|c| Rgb::from(c.to_array()).into());
            Ok(Edit::SetBackground(color))
        });
    };
    let white = match white {
        "" => Ok(None),
        white => number(white).map(Some),
    };
    edit(white, move |app, white| {
        let Some(SceneBackground::Backplate(old)) = app.document.background else {
            return Err("there is no image behind the scene".into());
        };
        let plate = Backplate {
            fit,
            radiance: white.unwrap_or(old.radiance),
            ..old
        };
        Ok(Edit::SetBackground(Some(SceneBackground::Backplate(plate))))
    })
}

/// `X Y Z`, followed by rotation in degrees and scale, if they are not 0 and 1.
fn place(text: &str) -> Result<DAffine3, String> {
    let given = finite(text).filter(|v| [3, 6, 9].contains(&v.len()));
    let given = given.ok_or_else(|| format!("\"{text}\" is not 3, 6 or 9 numbers"))?;
    let part = |k: usize, default: DVec3| match given.get(3 * k..3 * k + 3) {
        Some(&[x, y, z]) => DVec3::new(x, y, z),
        _ => default,
    };
    let angles = part(1, DVec3::ZERO).map(f64::to_radians);
    let turn = DQuat::from_euler(EulerRot::XYZ, angles.x, angles.y, angles.z);
    let (scale, translation) = (part(2, DVec3::ONE), part(0, DVec3::ZERO));
    Ok(DAffine3::from_scale_rotation_translation(
        scale,
        turn,
        translation,
    ))
}

/// `SIZE DEPTH FONT TEXT`; `-` is the built-in typeface.
fn text(rest: &str) -> StepResult {
    let (size, rest) = split(rest);
    let (depth, rest) = split(rest);
    let (font, text) = split(rest);
    Ok(command(Command::AddText {
        size: number(size)?,
        depth: number(depth)?,
        font: (font != "-").then(|| PathBuf::from(font)),
        text: name("text", text)?,
    }))
}

/// `SIZE HEIGHT SIDES` or `SIZE HEIGHT FILE`: regular, or of a drawing.
fn prism(rest: &str) -> StepResult {
    let (size, rest) = split(rest);
    let (height, base) = split(rest);
    let base = match base.parse() {
        Ok(sides) => PrismBase::Regular(sides),
        Err(_) => PrismBase::Drawing(path("prism", base)?),
    };
    Ok(command(Command::AddPrism {
        base,
        size: number(size)?,
        height: number(height)?,
    }))
}

/// `R G B VISIBILITY`, with `exponential` after it.
fn fog(text: &str) -> Result<Fog, String> {
    let (values, exponential) = match text.strip_suffix("exponential") {
        Some(rest) => (rest.trim(), true),
        None => (text, false),
    };
    let [r, g, b, visibility] = numbers(values)?;
    Ok(Fog {
        color: Rgb::new(r, g, b),
        visibility,
        exponential,
    })
}

/// `METRES y` or `z`, followed by `watts` or `lumens`.
fn units(text: &str) -> Result<Units, String> {
    match text.split_whitespace().collect::<Vec<_>>()[..] {
        [metres, up, light] => {
            let up = match up {
                "y" => Up::Y,
                "z" => Up::Z,
                other => return Err(format!("\"{other}\" is not an up axis, expected y or z")),
            };
            let photometric = match light {
                "watts" => false,
                "lumens" => true,
                other => return Err(format!("light in \"{other}\", expected watts or lumens")),
            };
            Ok(Units {
                metres_per_unit: Some(number(metres)?),
                up,
                photometric,
            })
        }
        _ => Err(format!("units \"{text}\", expected as in 0.01 z lumens")),
    }
}

/// Applies a map about the centre of the selection.
fn about_centre(app: &App, map: DAffine3) -> DAffine3 {
    let centre = app.document.bounds(Some(&app.selection.ids)).centre();
    DAffine3::from_translation(centre) * map * DAffine3::from_translation(-centre)
}

fn cone(app: &App, top: f64) -> Result<Edit, String> {
    let id = selected_one(app)?;
    if let Some(item) = app.document.object(id)
        && let Shape::Primitive(primitive) = &*item.shape
        && let PrimitiveKind::Cone { .. } = primitive.kind
    {
        let mut cone = primitive.clone();
        cone.kind = PrimitiveKind::Cone { top };
        cone.light = None;
        return Ok(Edit::SetShape(id, Arc::new(Shape::Primitive(cone))));
    }
    Err("the selection is not a cone".into())
}

fn selected_camera(app: &App) -> Result<(ItemId, &Camera), String> {
    let id = selected_one(app)?;
    let camera = app.document.camera(id);
    let camera = camera.ok_or("the selection is not a camera")?;
    Ok((id, &camera.camera))
}
