//! 3D Studio, `.3ds`.
//!
//! Meshes with texture coordinates and smoothing groups, materials per face, lights and cameras are
//! read, at the positions of the keyframer's first frame. `docs/formats/3ds.md` describes how every
//! chunk is interpreted.

mod build;
mod chunk;
mod keyframer;
mod material;
mod mesh;
mod parse;
#[cfg(test)]
mod tests;

use crate::reading::bytes::Bytes;
use crate::reading::options::Budget;
use crate::surface::single;
use crate::{Files, Loaded, ReadError, ReadOptions};

/// The first chunk of a model.
const MAIN: u16 = 0x4d4d;

/// Reads a model. `name` is used in messages; `files` provides the textures that it refers to,
/// relative to its own folder.
///
/// # Errors
/// Bytes that do not begin like a model, and instances that unfold to more than `options` allow.
/// Any other error in a file is a warning that counts what was lost.
pub fn read(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    check_start(bytes, name)?;
    let mut parser = parse::Studio3dsParser::new(name);
    parser.file(Bytes::new(bytes));
    let (model, walker) = parser.finish();
    let mut builder = build::Studio3dsBuilder {
        files,
        walker,
        budget: Budget::new(options),
    };
    let scene = builder.scene(&model)?;
    single::warn(&scene, name, &mut builder.walker.warnings);
    Ok(Loaded {
        scene,
        warnings: builder.walker.warnings.finish(name),
    })
}

/// Rejects files that are not models.
fn check_start(bytes: &[u8], name: &str) -> Result<(), ReadError> {
    let expected = "a 3DS model, which begins with chunk 4D4D";
    let found = match Bytes::new(bytes).u16_le() {
        Some(MAIN) => return Ok(()),
        None => "the end of the file".to_owned(),
        Some(0xc23d) => "a project of 3D Studio (PRJ)".to_owned(),
        Some(0x3daa) => "a material library of 3D Studio (MLI)".to_owned(),
        Some(other) => format!("chunk {other:04X}"),
    };
    Err(ReadError::at_byte(name, 0, found, expected))
}
