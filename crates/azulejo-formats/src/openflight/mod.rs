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
mod look;
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
use document::Document;
use part::Slot;
use std::borrow::Cow;
use transform::Place;
use walk::{Source, Walker};

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
    let document = Document::parse(Cow::Borrowed(bytes), name, "", &mut warnings)?;
    let mut walker = Walker::new(name, files, options, warnings);
    walker.slots = vec![vec![Slot::default(); document.vertices.len()]];
    let source = Source {
        document: &document,
        number: 0,
        path: "",
        palettes: &document.palettes,
        set: 0,
        scale: 1.0,
    };
    walker.top(source, &Place::world())?;
    let mut scene = walker.scene;
    if scene.objects.is_empty() {
        walker
            .warnings
            .add_whole(name, "no faces: the scene is empty");
    }
    scene.materials = walker.looks.materials.into_list();
    scene.textures = walker.looks.textures.into_list();
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
