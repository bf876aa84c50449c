//! GRF (GRanada File): the scenes of the "Wannabe Amazing" workbench, with irradiance on their
//! vertices.
//!
//! A text format by Montes, Ureña, Revelles and Lastra (University of Granada, 2001): meshes with
//! attributes before each vertex, definitions with scopes, transforms, includes. Its distinctive
//! feature is `irad`: a solved scene includes its irradiance. `docs/formats/grf.md` describes the
//! grammar as read by azulejo, the extensions and the deviations.
//!
//! [`read`] and [`write()`] convert between bytes and [`Scene`]. A [`GrfDocument`] mirrors the
//! blocks of a file; a [`GrfText`] is the file itself, which takes the light of a solved scene and
//! keeps every other byte.
//!
//! Invariants: numbers are written in the shortest form that reads back to the same bits;
//! `read(write(scene))` equals `scene`, except for pixels of textures, the third axis of lamps, and
//! the order of the values of normals and texture coordinates per corner.

mod appearance;
mod brdf;
mod document;
mod entries;
mod extension;
mod format;
mod from_scene;
mod instances;
mod layout;
mod lint;
mod literal;
mod luminaire;
mod materials;
mod mesh;
mod parse;
mod parser;
mod placement;
mod plain;
mod resolve;
mod shared;
mod solids;
mod surroundings;
#[cfg(test)]
mod tests;
mod text_edit;
mod textures;
mod write;

pub use document::GrfDocument;
pub use format::formatted;
pub use lint::{LintFinding, lint};
pub use literal::{GrfText, LitText, NotLiteral};
pub use plain::{plain_losses, write_plain};
pub use textures::load_textures;

use crate::{Files, Loaded, ReadError, ReadOptions};
use azulejo_scene::{Camera, PrimitiveKind, Scene};
use glam::{DAffine3, DVec3};
use std::io::{self, Write};

/// Reads a scene. `name` is the file's name in messages; includes and textures come from `files`,
/// with paths relative to the file's folder.
///
/// # Errors
/// The first syntax error: file, line, column, what was found and what was expected, and the chain
/// of includes that led there.
pub fn read(bytes: &[u8], name: &str, files: &dyn Files) -> Result<Loaded, ReadError> {
    read_with(bytes, name, files, &ReadOptions::default())
}

/// As [`read`], with limits for what instances may unfold to.
///
/// # Errors
/// Also instances that unfold to more.
pub fn read_with(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    let (document, mut warnings) = GrfDocument::parse(bytes, name, files)?;
    let mut loaded = document.resolve_with(options)?;
    warnings.append(&mut loaded.warnings);
    loaded.warnings = warnings;
    load_textures(&mut loaded, name, files);
    Ok(loaded)
}

/// Writes a scene that satisfies [`Scene::validate`], canonically and through an internal buffer.
/// [`read`] returns the same scene, with the exceptions named [above](self).
///
/// # Errors
/// Those of `out`.
pub fn write(scene: &Scene, out: &mut dyn Write) -> io::Result<()> {
    GrfDocument::from_scene(scene).write(out)
}

/// As [`write()`], with other file names for the scene's textures, in their order.
///
/// # Errors
/// Those of `out`.
pub fn write_with_pictures(
    scene: &Scene,
    pictures: &[String],
    out: &mut dyn Write,
) -> io::Result<()> {
    let names = pictures.iter().map(String::as_str);
    GrfDocument::with_pictures(scene, names).write(out)
}

/// Descriptions of what [`write()`] would omit from a scene.
pub fn losses(scene: &Scene) -> Vec<String> {
    let numbers = scene.rtrace.iter();
    numbers
        .map(|_| "parameters of RTRACE's own shading".to_owned())
        .collect()
}

/// Whether two edges span a parallelogram.
fn has_area(a: DVec3, b: DVec3) -> bool {
    let area = a.cross(b).length();
    area > 0.0 && area.is_finite()
}

/// Whether a map leaves a primitive with a volume or area that rays can hit.
fn is_invertible(kind: PrimitiveKind, map: &DAffine3) -> bool {
    let m = map.matrix3;
    let size = match kind {
        PrimitiveKind::Square => m.x_axis.cross(m.y_axis).length(),
        _ => m.determinant(),
    };
    map.is_finite() && size != 0.0 && size.is_finite()
}

/// Whether a camera has a valid view.
fn is_camera(camera: &Camera) -> bool {
    let (right, up, forward) = camera.axes();
    let spans =
        camera.eye.is_finite() && right.is_finite() && up.is_finite() && forward.is_finite();
    spans && camera.vertical_fov > 0.0 && camera.vertical_fov < std::f64::consts::PI
}

/// The normalized vector, unchanged if it is a unit vector already; `None` for zero.
fn unit(v: DVec3) -> Option<DVec3> {
    // Half of the tolerance of a scene, so that values in a file are preserved bit by bit.
    if (v.length() - 1.0).abs() < 5e-4 {
        return Some(v);
    }
    v.try_normalize()
}
