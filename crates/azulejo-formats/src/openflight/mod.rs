//! OpenFlight (.flt), a format for flight simulators.
//!
//! Revisions 14.2 to 16 are read: the hierarchy with its transforms, instances, replication and
//! external files, levels of detail, switches, faces and meshes with their colours, materials and
//! textures, and light sources. `docs/formats/openflight.md` describes how every record is
//! interpreted.

mod document;
mod external;
mod faces;
mod fields;
mod lights;
mod materials;
mod opcode;
mod palettes;
mod part;
mod select;
#[cfg(test)]
mod tests;
mod transform;
mod vertices;
mod walk;
mod warn;

use crate::reading::warnings::Warnings;
use crate::{Files, Loaded, ReadError, ReadOptions};
use azulejo_scene::{Units, Up};
use document::FltDocument;
use part::VertexSlot;
use std::borrow::Cow;
use transform::InheritedState;
use walk::{FltSource, FltWalker};

/// Reads an OpenFlight file. `name` is used in messages; `files` provides the files and textures
/// that the model refers to, relative to the model's folder.
///
/// Each node with faces directly below it becomes one object: an OpenFlight object, or any other
/// parent of faces. It contains the vertices that its faces use. Anything skipped, damaged or
/// missing is reported as a warning.
///
/// # Errors
/// Bytes that do not begin with a header; a file of 4 GiB or more; more than 128 levels; more
/// vertices, corners and nodes than `options` allow.
pub fn read(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    let mut warnings = Warnings::default();
    let document = FltDocument::parse(Cow::Borrowed(bytes), name, "", &mut warnings)?;
    let mut walker = FltWalker::new(name, files, options, warnings);
    walker.slots = vec![vec![VertexSlot::default(); document.vertices.len()]];
    let source = FltSource {
        document: &document,
        number: 0,
        path: "",
        palettes: &document.palettes,
        set: 0,
        scale: 1.0,
    };
    walker.top(source, InheritedState::world())?;
    let mut scene = walker.scene;
    if scene.objects.is_empty() {
        walker
            .warnings
            .add_whole(name, "no faces: the scene is empty");
    }
    scene.materials = walker.materials.materials.into_list();
    scene.textures = walker.materials.textures.into_list();
    scene.units = Units {
        metres_per_unit: document.metres_per_unit,
        up: Up::Z,
        photometric: false,
    };
    Ok(Loaded {
        scene,
        warnings: walker.warnings.finish(name),
    })
}
