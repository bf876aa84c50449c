//! GRF (GRanada File): the scenes of the "Wannabe Amazing" workbench, with irradiance on their
//! vertices.
//!
//! Text, by Montes, Ureña, Revelles and Lastra (University of Granada, 2001): meshes with
//! attributes before each vertex, definitions with scopes, transforms, includes. What sets it
//! apart is `irad`: a solved scene keeps its light. The grammar as azulejo reads it, its
//! extensions and its deviations stand in `docs/formats/grf.md`.
//!
//! [`read`] and [`write()`] go between bytes and [`Scene`]. A [`Document`] mirrors a file
//! literally, for programs that save a file which somebody wrote by hand.
//!
//! Invariants: numbers are written in the shortest form that reads back to the same bits;
//! `read(write(scene))` is `scene`, but for pixels of textures and for normals and texture
//! coordinates on corners, which become attributes of vertices by splitting them.

mod brdf;
mod document;
mod entries;
mod extension;
mod from_scene;
mod irradiance;
mod look;
mod materials;
mod mesh;
mod parse;
mod parser;
mod placement;
mod resolve;
mod solids;
#[cfg(test)]
mod tests;
mod textures;
mod write;

pub use document::Document;
pub use textures::load_textures;

use crate::{Files, Loaded, ReadError, ReadOptions};
use azulejo_scene::{Camera, PrimitiveKind, Scene};
use glam::{DAffine3, DVec3};
use std::io::{self, Write};

/// Reads a scene. `name` is what messages call the file; includes and textures come from `files`
/// by their path from the file's folder.
///
/// # Errors
/// The first thing that is not GRF: file, line, column, what was found and what expected, and
/// the chain of includes that led there.
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
    let (document, mut warnings) = Document::parse(bytes, name, files)?;
    let mut loaded = document.resolve_with(options)?;
    warnings.append(&mut loaded.warnings);
    loaded.warnings = warnings;
    load_textures(&mut loaded, name, files);
    Ok(loaded)
}

/// Writes a scene that keeps the promises of [`Scene::validate`], canonically and through a
/// buffer of its own. [`read`] gives the same scene back, with the exceptions named
/// [above](self).
///
/// # Errors
/// Those of `out`.
pub fn write(scene: &Scene, out: &mut dyn Write) -> io::Result<()> {
    Document::from_scene(scene).write(out)
}

/// As [`write()`], with other names for the files of the scene's textures, in their order.
///
/// # Errors
/// Those of `out`.
pub fn write_with_pictures(
    scene: &Scene,
    pictures: &[String],
    out: &mut dyn Write,
) -> io::Result<()> {
    let names = pictures.iter().map(String::as_str);
    Document::with_pictures(scene, names).write(out)
}

/// What [`write()`] would leave out of a scene, in words.
pub fn losses(scene: &Scene) -> Vec<String> {
    let numbers = scene.rtrace.iter();
    numbers
        .map(|_| "the numbers of RTRACE's own shading".to_owned())
        .collect()
}

/// Whether two edges span a parallelogram.
fn has_area(a: DVec3, b: DVec3) -> bool {
    let area = a.cross(b).length();
    area > 0.0 && area.is_finite()
}

/// Whether a map places a primitive so that it can be hit.
fn is_invertible(kind: PrimitiveKind, map: &DAffine3) -> bool {
    let m = map.matrix3;
    let size = match kind {
        PrimitiveKind::Square => m.x_axis.cross(m.y_axis).length(),
        _ => m.determinant(),
    };
    map.is_finite() && size != 0.0 && size.is_finite()
}

/// Whether a camera sees something.
fn is_camera(camera: &Camera) -> bool {
    let (right, up, forward) = camera.axes();
    let spans =
        camera.eye.is_finite() && right.is_finite() && up.is_finite() && forward.is_finite();
    spans && camera.vertical_fov > 0.0 && camera.vertical_fov < std::f64::consts::PI
}

/// A unit vector as it is, another one shortened or lengthened; `None` for no direction.
fn unit(v: DVec3) -> Option<DVec3> {
    // Half of what a scene allows, so that what a file says is kept to the bit.
    if (v.length() - 1.0).abs() < 5e-4 {
        return Some(v);
    }
    v.try_normalize()
}
