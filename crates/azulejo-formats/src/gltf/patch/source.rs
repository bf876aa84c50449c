//! A file that is edited: its parts, its document, and the numbers in it.

use super::super::accessor::Data;
use super::super::buffers::Buffers;
use super::super::container::Container;
use super::super::document;
use super::super::draco::DracoAccessors;
use super::super::messages::GltfMessages;
use super::error::PatchError;
use super::glb::Parts;
use super::json::{Json, MOST_LEVELS};
use super::types::GltfFile;

/// A file that is edited.
pub struct Source<'a> {
    /// The file.
    pub file: &'a GltfFile<'a>,
    /// Its parts.
    pub parts: Parts<'a>,
    /// Its document.
    pub json: Json<'a>,
    /// Its JSON and its numbers, as the reader has them.
    pub data: Data<'a>,
}

/// Works with a file.
///
/// # Errors
/// Files that cannot be read or are nested too deep, and those of the work.
pub fn with_source<T>(
    file: &GltfFile,
    work: impl FnOnce(&Source) -> Result<T, PatchError>,
) -> Result<T, PatchError> {
    let parts = Parts::of(file.bytes, file.name)?;
    let container = Container {
        json: parts.text.as_bytes(),
        json_start: parts.chunks.is_some().then_some(20),
        bin: parts.bin(),
    };
    let root = document::parse(&container, file.name, &mut GltfMessages::default())?;
    let buffers = Buffers::load(&root, parts.bin(), file.files, file.options);
    let json = Json::parse(parts.text, MOST_LEVELS);
    work(&Source {
        file,
        json: json.map_err(|found| PatchError::of(file.name, found))?,
        parts,
        data: Data {
            root: &root,
            draco: DracoAccessors::load(&root, &buffers, file.options.most_unpacked),
            buffers,
        },
    })
}

impl Source<'_> {
    /// The error with this in the way.
    pub fn refused(&self, found: impl Into<String>) -> PatchError {
        PatchError::of(self.file.name, found)
    }

    /// The mesh of a node.
    pub fn mesh_of(&self, node: usize) -> Option<usize> {
        let node = self.data.root.nodes.get(node)?;
        node.mesh.map(|mesh| mesh.value())
    }
}
