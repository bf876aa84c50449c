//! VRML 1.0, and the nodes of Open Inventor's ASCII files from which VRML 1.0 is derived.
//!
//! A file is a stream of nodes: property nodes change the traversal state (transformation,
//! material, coordinates), shapes use the current state, and separators restore the previous one.
//! [`parse`] turns the text into nodes; [`walk`] traverses them; [`shapes`], [`solids`],
//! [`materials`] and [`lights`] convert them to objects, materials, and lights and cameras.
//! `docs/formats/vrml1.md` describes how every node is interpreted.

mod lights;
mod materials;
mod node;
mod parse;
mod shapes;
mod solids;
mod state;
#[cfg(test)]
mod tests;
#[cfg(feature = "fonts")]
mod text;
mod walk;

use super::builder::{VrmlPlacement, VrmlSceneBuilder, VrmlSource};
use crate::ReadError;

/// Whether [`read_into`] can read this text, by its header.
pub(super) fn is_meant(text: &[u8]) -> bool {
    text.starts_with(b"#VRML V1.") || is_inventor(text)
}

/// Whether this is an Inventor file; these are ASCII or binary, as their header states.
fn is_inventor(text: &[u8]) -> bool {
    let header = text.split(|b| matches!(b, b'\n' | b'\r')).next();
    header.is_some_and(|h| h.starts_with(b"#Inventor V") && h.windows(5).any(|w| w == b"ascii"))
}

/// Reads a file and adds its content under `frame`.
///
/// # Errors
/// Text without a node, nodes nested too deeply, and a model that unfolds to more than the options
/// allow.
pub(super) fn read_into(
    builder: &mut VrmlSceneBuilder,
    source: &VrmlSource,
    frame: &VrmlPlacement,
) -> Result<(), ReadError> {
    let document = parse::parse(builder, source)?;
    let inventor = is_inventor(&source.bytes);
    if inventor && builder.is_outermost() {
        // VRML 1.0 uses metres, Inventor does not define a unit.
        builder.scene.units.metres_per_unit = None;
    }
    walk::walk(builder, source, &document, frame, inventor)
}
