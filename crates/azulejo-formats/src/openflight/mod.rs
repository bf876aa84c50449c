//! OpenFlight (.flt), the format of flight simulators.
//!
//! What is read: revisions 14.2 to 16, the hierarchy with its transforms, instances, replication
//! and external files, levels of detail, switches, faces and meshes with their colours, materials
//! and pictures, and light sources. `docs/formats/openflight.md` says how every record is
//! understood.

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

/// Reads an OpenFlight file. `name` stands in messages; `files` gives the files and pictures that
/// the model names, relative to the model's folder.
///
/// One object comes out for each node that has faces directly below it: an OpenFlight object, or
/// whatever else holds faces. It holds the vertices that its faces use. What is skipped, damaged
/// or missing is a warning.
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
    walker.top(source, &InheritedState::world())?;
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
