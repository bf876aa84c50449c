//! Steps that edit the scene and its objects, by their first word.

use super::fields::{finite, name, number, numbers, path, split, unless, vector};
use super::selected::{selected, selected_one};
use crate::app::App;
use crate::command::{Command, PrismBase};
use crate::document::Edit;
use azulejo::scene::{
    Backplate, BackplateFit, Camera, Fog, PrimitiveKind, Rgb, SceneBackground, Shape, Units, Up,
};
use glam::{DAffine3, DMat3, DQuat, DVec3, EulerRot};
use std::path::PathBuf;
use std::sync::Arc;

/// What a step that edits the scene does.
#[derive(Clone, Debug, PartialEq)]
pub enum SceneStep {
    /// `rename NAME`: renames the selection.
    Rename(String),
    /// `move X Y Z`, `scale F`, `turn X Y Z` in degrees: transforms the selection.
    Move(DVec3),
    /// See [`SceneStep::Move`].
    Scale(f64),
    /// See [`SceneStep::Move`].
    Turn(DVec3),
    /// `place X Y Z`, followed by rotation in degrees and scale, if they are not 0 and 1: sets the
    /// placement of the selected object.
    Place(DAffine3),
    /// `cone TOP`: sets the radius at the top of the selected cone, relative to that at the bottom.
    Cone(f64),
    /// `text SIZE DEPTH FONT TEXT`: adds solid text; `-` is the built-in typeface.
    Text {
        /// World units per em.
        size: f64,
        /// Depth of the letters in ems.
        depth: f64,
        /// A font file; `None` for the built-in typeface.
        font: Option<PathBuf>,
        /// The rest of the line.
        text: String,
    },
    /// `prism SIZE HEIGHT SIDES`, `prism SIZE HEIGHT FILE`: adds a prism, regular or of a drawing.
    Prism(f64, f64, PrismBase),
    /// `take-view`: moves the selected camera to the view.
    TakeView,
    /// `look-through`: views the scene through the selected camera.
    LookThrough,
    /// `background R G B`, `background none`: the scene's own.
    Background(Option<DVec3>),
    /// `background scaled`, `centered` or `tiled`, and the radiance of white: the image of `backdrop`.
    Backplate(BackplateFit, Option<f64>),
    /// `fog R G B VISIBILITY`, `fog R G B VISIBILITY exponential`, `fog none`.
    Fog(Option<Fog>),
    /// `units METRES y`, or `z`, followed by `watts` or `lumens`.
    Units(f64, Up, bool),
}

/// The step of this first word; `None` if it is not one of the scene.
pub(super) fn parse(word: &str, rest: &str) -> Option<Result<SceneStep, String>> {
    Some(match word {
        "rename" => name(word, rest).map(SceneStep::Rename),
        "move" => vector(rest).map(SceneStep::Move),
        "scale" => number(rest).map(SceneStep::Scale),
        "turn" => vector(rest).map(SceneStep::Turn),
        "place" => place(rest).map(SceneStep::Place),
        "cone" => number(rest).map(SceneStep::Cone),
        "text" => text(rest),
        "prism" => prism(rest),
        "take-view" => Ok(SceneStep::TakeView),
        "look-through" => Ok(SceneStep::LookThrough),
        "background" => background(rest),
        "fog" => unless("none", rest, fog).map(SceneStep::Fog),
        "units" => units(rest),
        _ => return None,
    })
}

fn background(text: &str) -> Result<SceneStep, String> {
    let name = |fit: BackplateFit| format!("{fit:?}").to_ascii_lowercase();
    let (word, white) = split(text);
    match BackplateFit::ALL.into_iter().find(|&fit| name(fit) == word) {
        Some(fit) if white.is_empty() => Ok(SceneStep::Backplate(fit, None)),
        Some(fit) => Ok(SceneStep::Backplate(fit, Some(number(white)?))),
        None => unless("none", text, vector).map(SceneStep::Background),
    }
}

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

fn text(rest: &str) -> Result<SceneStep, String> {
    let (size, rest) = split(rest);
    let (depth, rest) = split(rest);
    let (font, text) = split(rest);
    Ok(SceneStep::Text {
        size: number(size)?,
        depth: number(depth)?,
        font: (font != "-").then(|| PathBuf::from(font)),
        text: name("text", text)?,
    })
}

fn prism(rest: &str) -> Result<SceneStep, String> {
    let (size, rest) = split(rest);
    let (height, base) = split(rest);
    let base = match base.parse() {
        Ok(sides) => PrismBase::Regular(sides),
        Err(_) => PrismBase::Drawing(path("prism", base)?),
    };
    Ok(SceneStep::Prism(number(size)?, number(height)?, base))
}

fn fog(text: &str) -> Result<Fog, String> {
    let (numbers_of, exponential) = match text.strip_suffix("exponential") {
        Some(rest) => (rest.trim(), true),
        None => (text, false),
    };
    let [r, g, b, visibility] = numbers(numbers_of)?;
    Ok(Fog {
        color: Rgb::new(r, g, b),
        visibility,
        exponential,
    })
}

fn units(text: &str) -> Result<SceneStep, String> {
    match text.split_whitespace().collect::<Vec<_>>()[..] {
        [metres, up, light] => {
            let up = match up {
                "y" => Up::Y,
                "z" => Up::Z,
                other => return Err(format!("\"{other}\" is not up, expected y or z")),
            };
            let photometric = match light {
                "watts" => false,
                "lumens" => true,
                other => return Err(format!("light in \"{other}\", expected watts or lumens")),
            };
            Ok(SceneStep::Units(number(metres)?, up, photometric))
        }
        _ => Err(format!("units \"{text}\", expected as in 0.01 z lumens")),
    }
}

impl SceneStep {
    /// The command of the step.
    pub(super) fn command(self, app: &App) -> Result<Command, String> {
        let edit = match self {
            SceneStep::Text {
                size,
                depth,
                font,
                text,
            } => {
                return Ok(Command::AddText {
                    text,
                    size,
                    depth,
                    font,
                });
            }
            SceneStep::Prism(size, height, base) => {
                return Ok(Command::AddPrism { base, size, height });
            }
            SceneStep::LookThrough => {
                let mut view = app.view.clone();
                view.camera = selected_camera(app)?.1.clone();
                return Ok(Command::SetView(Box::new(view)));
            }
            other => other.edit(app)?,
        };
        Ok(Command::Edit(edit, None))
    }

    fn edit(self, app: &App) -> Result<Edit, String> {
        Ok(match self {
            SceneStep::Rename(name) => Edit::Rename(selected_one(app)?, name),
            SceneStep::Move(by) => Edit::Transform(selected(app)?, DAffine3::from_translation(by)),
            SceneStep::Scale(factor) => {
                let map = DAffine3::from_scale(DVec3::splat(factor));
                Edit::Transform(selected(app)?, about(app, map))
            }
            SceneStep::Turn(degrees) => {
                let [x, y, z] = degrees.to_array().map(f64::to_radians);
                let turn = DMat3::from_rotation_z(z) * DMat3::from_rotation_y(y);
                let turn = turn * DMat3::from_rotation_x(x);
                Edit::Transform(selected(app)?, about(app, DAffine3::from_mat3(turn)))
            }
            SceneStep::Place(placement) => Edit::SetPlacement(selected_one(app)?, placement),
            SceneStep::Cone(top) => cone(app, top)?,
            SceneStep::TakeView => {
                let (id, camera) = selected_camera(app)?;
                let taken = Camera {
                    name: camera.name.clone(),
                    size: camera.size,
                    ..app.view.camera.clone()
                };
                Edit::SetCamera(id, taken)
            }
            SceneStep::Background(color) => {
                Edit::SetBackground(color.map(|c| Rgb::from(c.to_array()).into()))
            }
            SceneStep::Backplate(fit, white) => {
                let Some(SceneBackground::Backplate(old)) = app.document.background else {
                    return Err("no image is behind the scene".into());
                };
                let plate = Backplate {
                    fit,
                    radiance: white.unwrap_or(old.radiance),
                    ..old
                };
                Edit::SetBackground(Some(SceneBackground::Backplate(plate)))
            }
            SceneStep::Fog(fog) => Edit::SetFog(fog),
            SceneStep::Units(metres, up, photometric) => Edit::SetUnits(Units {
                metres_per_unit: Some(metres),
                up,
                photometric,
            }),
            SceneStep::Text { .. } | SceneStep::Prism(..) | SceneStep::LookThrough => {
                return Err(format!("{self:?} is not an edit of the document"));
            }
        })
    }
}

/// Applies a map about the centre of the selection.
fn about(app: &App, map: DAffine3) -> DAffine3 {
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

fn selected_camera(app: &App) -> Result<(crate::document::ItemId, &Camera), String> {
    let id = selected_one(app)?;
    let camera = app.document.camera(id);
    let camera = camera.ok_or("the selection is not a camera")?;
    Ok((id, &camera.camera))
}
