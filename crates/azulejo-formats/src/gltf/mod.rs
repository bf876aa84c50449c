//! glTF 2.0, JSON or binary (GLB).
//!
//! The page `docs/formats/gltf.md` documents the conversion. `gltf-json`, the lower half of the
//! `gltf` crate, mirrors the file literally; its upper half is not used, because it
//! panics on damaged buffers.

mod accessor;
mod animations;
mod attributes;
mod buffers;
mod container;
mod cube_map;
mod document;
mod draco;
mod image_based;
mod instances;
mod irradiance;
mod json_parts;
mod lightmap;
mod local_origin;
mod losses;
mod material;
mod mesh;
mod meshopt;
mod messages;
mod nodes;
mod origin;
mod pack;
pub mod patch;
mod pictures;
mod skin;
#[cfg(test)]
mod tests;
mod topology;
mod transforms;
mod uri;
mod vertices;
mod walk;
mod write;
mod write_image_based;
mod write_material;
mod write_mesh;

pub use local_origin::local_origin;
pub use losses::losses;
pub use origin::{FaceOrigin, ObjectOrigin, Stillness};
pub use write::{write, write_json, write_with};
pub use write_material::MattSurfaces;

use crate::reading::options::counted_first;
use crate::reading::text::decoded;
use crate::reading::warnings::Warnings;
use crate::{Files, Loaded, ReadError, ReadOptions};
use accessor::Data;
use azulejo_scene::{Scene, Units, Up};
use buffers::Buffers;
use draco::DracoAccessors;
use gltf_json::Root;
use material::Surfaces;
use messages::GltfMessages;
use nodes::Tree;
use origin::OriginRecorder;
use walk::GltfWalk;

/// Reads a glTF or GLB file.
///
/// `name` is used in messages; `files` provides the buffers and textures that the file names.
///
/// # Errors
/// Text that is not JSON, JSON that is not glTF 2.0, indices out of range, nodes that are their own
/// ancestors, required extensions that are not supported, and files all of whose meshes are damaged.
pub fn read(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    Ok(read_recorded(bytes, name, files, options, false)?.0)
}

/// Like [`read`], with the origin of each object of the scene, in the same order. A file that expands to
/// more than the options allow is refused before it takes the memory.
///
/// # Errors
/// As [`read`].
pub fn read_with_origins(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<(Loaded, Vec<ObjectOrigin>), ReadError> {
    counted_first(bytes.len(), options, |options| {
        read_recorded(bytes, name, files, options, true)
    })
}

fn read_recorded(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
    records: bool,
) -> Result<(Loaded, Vec<ObjectOrigin>), ReadError> {
    let bytes = &*decoded(bytes);
    let mut messages = GltfMessages::default();
    let container = container::split(bytes, name, &mut messages)?;
    let root = document::parse(&container, name, &mut messages)?;
    let tree = Tree::of(&root, container.json, name)?;
    origin::warn_of_rest(&root, container.json, &mut messages);
    let buffers = Buffers::load(&root, container.bin, files, options);
    let data = Data {
        root: &root,
        draco: DracoAccessors::load(&root, &buffers, options.most_unpacked),
        buffers,
    };
    let surfaces = Surfaces::new(&data, files);
    let recorder = records.then(|| OriginRecorder::new(&root, container.json));
    let walk = GltfWalk::new(
        &data,
        &tree,
        surfaces,
        options,
        &mut messages,
        recorder,
        name,
    );
    let (mut scene, origins) = walk.scene()?;
    scene.units = units(&root);
    check_result(&scene, name, &mut messages)?;
    let mut warnings = Warnings::default();
    messages.report(name, &mut warnings);
    let loaded = Loaded {
        scene,
        warnings: warnings.finish(name),
    };
    Ok((loaded, origins))
}

/// Metres, y up and photometric units, by the standard; azulejo's own files declare whether their
/// light is in watts.
fn units(root: &Root) -> Units {
    let extras = root.asset.extras.as_ref();
    let extras = extras.and_then(|e| serde_json::from_str::<serde_json::Value>(e.get()).ok());
    let photometric = extras.and_then(|e| e.get("azulejo")?.get("photometric")?.as_bool());
    Units {
        metres_per_unit: Some(1.0),
        up: Up::Y,
        photometric: photometric.unwrap_or(true),
    }
}

/// Warns about empty scenes, and rejects files without a readable mesh.
fn check_result(scene: &Scene, file: &str, messages: &mut GltfMessages) -> Result<(), ReadError> {
    if !scene.objects.is_empty() {
        return Ok(());
    }
    if let Some(found) = messages.first_of(mesh::LEFT_OUT) {
        return Err(ReadError::whole(file, found, "a mesh that can be read"));
    }
    messages.whole("no faces: the scene is empty");
    Ok(())
}
