//! View3D, `.vs3`: polygons for which view factors are computed, and the resulting matrices.
//!
//! [`View3dDocument::read`] reads the content of a file, [`View3dModel::new`] computes the polygons
//! that remain after subtracting subsurfaces, masks and holes from their bases, and [`read`]
//! returns these as a scene. [`write()`] writes a scene as a View3D file, [`write_factors`] a
//! matrix in the formats of View3D 4.0.0. `docs/formats/view3d.md` has the details.

mod check;

mod document;
mod factors;
mod lines;
mod model;
mod parse;
#[cfg(test)]
mod tests;
mod write;

pub use document::{
    MatrixLayout, PlanarShape, SurfaceKind, SurfaceOutline, View3dControls, View3dDocument,
    View3dSurface,
};
pub use factors::{FactorHeader, write_factors};
pub use model::{CoveringMask, View3dModel};
pub use write::{losses, write};

use crate::reading::gzip;
use crate::reading::options::check_length;
use crate::reading::text::decoded;
use crate::reading::warnings::Warnings;
use crate::{Files, Loaded, ReadError, ReadOptions, Warning};

/// Reads the polygons as a scene; View3D files refer to no others.
///
/// # Errors
/// Those of [`View3dDocument::read`] and [`View3dModel::new`].
pub fn read(
    bytes: &[u8],
    name: &str,
    _files: &dyn Files,
    options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    let (document, mut warnings) = View3dDocument::read(bytes, name, options)?;
    let model = View3dModel::new(&document, name)?;
    warnings.extend(model.warning(name));
    Ok(Loaded {
        scene: model.scene,
        warnings,
    })
}

impl View3dDocument {
    /// Reads a file, with or without gzip compression, and checks it as View3D does. `name` is used
    /// in messages.
    ///
    /// # Errors
    /// Invalid words, numbers out of sequence, surfaces that are not flat, not convex or not within
    /// their bases; with the line.
    pub fn read(
        bytes: &[u8],
        name: &str,
        options: &ReadOptions,
    ) -> Result<(View3dDocument, Vec<Warning>), ReadError> {
        let bytes = &*gzip::unpacked(bytes, name, options)?;
        let bytes = &*decoded(bytes);
        check_length(bytes, name)?;
        let mut warnings = Warnings::default();
        let document = parse::read(bytes, name, &mut warnings)?;
        Ok((document, warnings.finish(name)))
    }
}
