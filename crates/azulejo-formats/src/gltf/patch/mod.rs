//! Edits of glTF files that keep everything else in them.
//!
//! The JSON is edited as a document that keeps the order of members and the spelling of numbers: entries are added at
//! the end of lists, a few values are replaced, and the rest stays as it is, also what azulejo does not know. New
//! numbers follow the old ones. A `mark` in the file says what was there before, so that [`strip`] gives it back.
//!
//! | module | purpose |
//! |---|---|
//! | `types`, `error`, `notes` | what goes in and out |
//! | `json`, `glb` | documents, parts of a file |
//! | `source`, `primitives` | a file that is edited |
//! | `additions`, `accessors` | new entries and bytes |
//! | `assign`, `splits` | texture coordinates of objects as those of vertices |
//! | `work`, `meshes` | the meshes of a file with them |
//! | `looks`, `materials`, `lights` | what shows them |
//! | `lightmap`, `vertex_light`, `expansion` | the edits as a whole |
//! | `mark`, `strip` | what was there before |
//! | `convert` | other containers |
//! | `existing` | the lightmap that a file has |

mod accessors;
mod additions;
mod assign;
mod convert;
mod error;
mod existing;
mod expansion;
mod glb;
mod json;
mod lightmap;
mod lights;
mod looks;
mod mark;
mod materials;
mod meshes;
mod notes;
mod primitives;
mod source;
mod splits;
mod strip;
#[cfg(test)]
mod tests;
mod types;
mod vertex_light;
mod work;

pub use error::PatchError;
pub use existing::{coordinates, found_lightmap};
pub use expansion::expanded;
pub use strip::{content, lost, strip};
pub use types::{
    Container, Convention, FoundLightmap, FoundPage, GltfFile, InstanceMode, LightmapEdit,
    LightmapPage, LightmapUvs, LightsMode, MediaType, NO_PAGE, ObjectLayout, Output, PatchedFile,
    StrippedFile,
};

use super::origin::ObjectOrigin;
use super::uri::{self, Uri};
use azulejo_scene::Scene;
use glb::Parts;
use json::{Json, MOST_LEVELS};
use notes::Notes;
use source::with_source;

/// Puts a lightmap into a file. `origins` are those of its objects; if it has a lightmap of azulejo's, that is
/// removed first. (Its lights are dimmed, so [`strip`] a file before it is read to be lit again.) Instances have none
/// unless the file is [`expanded`].
///
/// # Errors
/// Files that cannot be read or are not UTF-8, layouts that do not fit the origins, and more bytes than
/// the options or a GLB allow.
pub fn with_lightmap(
    original: &GltfFile,
    origins: &[ObjectOrigin],
    edit: &LightmapEdit,
) -> Result<PatchedFile, PatchError> {
    let mut notes = Notes::default();
    let parts = Parts::of(original.bytes, original.name)?;
    let mut bytes = None;
    let mut expands = false;
    let json = Json::parse(parts.text, MOST_LEVELS);
    if let Some(mark) = json.as_ref().ok().and_then(|json| json.find(&mark::MARK)) {
        expands = expansion::is_of_expansion(mark);
        if !expands {
            notes.add("the file had a lightmap, or light on its vertices: removed");
        }
        bytes = Some(strip(original.bytes, original.name)?.bytes);
    }
    let file = GltfFile {
        bytes: bytes.as_deref().unwrap_or(original.bytes),
        ..*original
    };
    in_container(&file, &edit.output, notes, |file, notes| {
        // The container has changed, if at all, before the nodes do, so that what undoes the edit has both.
        let bytes = if expands { expanded(file)? } else { None };
        let file = GltfFile {
            bytes: bytes.as_deref().unwrap_or(file.bytes),
            ..*file
        };
        with_source(&file, |source| {
            lightmap::edited(source, origins, edit, notes)
        })
    })
}

/// The names of the files that a file names, relative to its own: buffers and images.
///
/// # Errors
/// Files that cannot be read or are not UTF-8 JSON.
pub fn named_files(bytes: &[u8], name: &str) -> Result<Vec<String>, PatchError> {
    let parts = Parts::of(bytes, name)?;
    let json = Json::parse(parts.text, MOST_LEVELS).map_err(|found| PatchError::of(name, found))?;
    let mut names = Vec::new();
    for entry in ["buffers", "images"]
        .iter()
        .flat_map(|list| json.entries(list))
    {
        let uri = entry.get("uri").and_then(Json::text);
        if let Some(Ok(Uri::File(file))) = uri.as_deref().map(uri::read) {
            names.push(file.into_owned());
        }
    }
    Ok(names)
}

/// Puts the irradiance of the vertices of `scene` into its file: as colours of the same vertices, with the
/// extras that [`read`](super::read) and [`write()`](super::write()) know. Everything else stays, a
/// lightmap, too. The objects of the scene have the faces that were read, with `origins`; those
/// without irradiance stay as they are. Nodes that share a mesh get entries of their own. [`strip`] undoes it; if the
/// file has been edited before, both edits at once.
///
/// # Errors
/// As [`with_lightmap`].
pub fn with_vertex_light(
    original: &GltfFile,
    origins: &[ObjectOrigin],
    scene: &Scene,
    output: Output,
) -> Result<PatchedFile, PatchError> {
    in_container(original, &output, Notes::default(), |file, notes| {
        with_source(file, |source| {
            vertex_light::edited(source, origins, scene, output, notes)
        })
    })
}

/// Edits a file in the container that is asked for.
fn in_container(
    file: &GltfFile,
    output: &Output,
    mut notes: Notes,
    edited: impl Fn(&GltfFile, Notes) -> Result<PatchedFile, PatchError>,
) -> Result<PatchedFile, PatchError> {
    let Some(other) = convert::converted(file, output, &mut notes)? else {
        return edited(file, notes);
    };
    let files = convert::Overlay {
        old: file.files,
        new: &other.files,
    };
    let other_file = GltfFile {
        bytes: &other.bytes,
        files: &files,
        ..*file
    };
    let mut patched = edited(&other_file, notes)?;
    patched.files.splice(0..0, other.files.iter().cloned());
    Ok(patched)
}
