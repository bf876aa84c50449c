//! VRML 1.0, and of Open Inventor's text files the nodes that VRML 1.0 has from it.
//!
//! A file is a stream of nodes: some change a state (where, what colour, which points), the
//! shapes take what the state is when they come, and separators bring back what it was before.
//! [`parse`] makes nodes of the text; [`walk`] follows the stream; [`shapes`], [`solids`],
//! [`looks`] and [`lights`] turn what it meets into objects, materials, and lights and cameras.
//! `docs/formats/vrml1.md` says how every node is understood.

mod lights;
mod looks;
mod node;
mod parse;
mod shapes;
mod solids;
mod state;
#[cfg(test)]
mod tests;
mod walk;

use super::stage::{Frame, Source, Stage};
use crate::ReadError;

/// Whether a text is one that [`read_into`] reads, by its header.
pub(super) fn is_meant(text: &[u8]) -> bool {
    text.starts_with(b"#VRML V1.") || is_inventor(text)
}

/// Inventor's files are text or binary, as their header says.
fn is_inventor(text: &[u8]) -> bool {
    let header = text.split(|b| matches!(b, b'\n' | b'\r')).next();
    header.is_some_and(|h| h.starts_with(b"#Inventor V") && h.windows(5).any(|w| w == b"ascii"))
}

/// Reads a file and puts what it holds under `frame`.
///
/// # Errors
/// Text without a node, nodes nested too deep, and a model that unfolds to more than the options
/// allow.
pub(super) fn read_into(
    stage: &mut Stage,
    source: &Source,
    frame: &Frame,
) -> Result<(), ReadError> {
    let document = parse::parse(stage, source)?;
    let inventor = is_inventor(&source.bytes);
    if inventor && stage.is_outermost() {
        // VRML 1.0 counts in metres, Inventor does not say.
        stage.scene.units.metres_per_unit = None;
    }
    walk::walk(stage, source, &document, frame, inventor)
}
