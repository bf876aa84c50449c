//! View3D, `.vs3`: polygons whose view factors are wanted, and the matrices that come of them.
//!
//! [`Document::read`] gives what a file says, [`Model::new`] the polygons that are left when
//! subsurfaces, masks and holes are cut out of what holds them, [`read`] a scene of those.
//! [`write()`] makes a file of a scene, [`write_factors`] a matrix as View3D 4.0.0 lays it out.
//! `docs/formats/view3d.md` says more.

mod check;
mod cut;
mod document;
mod factors;
mod lines;
mod model;
mod parse;
#[cfg(test)]
mod tests;
mod write;

pub use document::{Controls, Document, Kind, Layout, Outline, PlacedShape, Surface};
pub use factors::{FactorHeader, write_factors};
pub use model::{CoveringMask, Model};
pub use write::{losses, write};

use crate::reading::gzip;
use crate::reading::options::check_length;
use crate::reading::text::decoded;
use crate::reading::warnings::Warnings;
use crate::{Files, Loaded, ReadError, ReadOptions, Warning};

/// Reads the polygons as a scene; View3D's files name no others.
///
/// # Errors
/// What [`Document::read`] and [`Model::new`] say.
pub fn read(
    bytes: &[u8],
    name: &str,
    _files: &dyn Files,
    options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    let (document, mut warnings) = Document::read(bytes, name, options)?;
    let model = Model::new(&document, name)?;
    warnings.extend(model.warning(name));
    Ok(Loaded {
        scene: model.scene,
        warnings,
    })
}

impl Document {
    /// Reads a file, packed with gzip or not, and checks it as View3D does. `name` stands in messages.
    ///
    /// # Errors
    /// Words that are none of the format's, numbers out of sequence, surfaces that are not flat,
    /// not convex or not within their bases: with the line.
    pub fn read(
        bytes: &[u8],
        name: &str,
        options: &ReadOptions,
    ) -> Result<(Document, Vec<Warning>), ReadError> {
        let bytes = &*gzip::unpacked(bytes, name, options)?;
        let bytes = &*decoded(bytes);
        check_length(bytes, name)?;
        let mut warnings = Warnings::default();
        let document = parse::read(bytes, name, &mut warnings)?;
        Ok((document, warnings.finish(name)))
    }
}
