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
use gltf_json::Root;

/// The JSON of a file, parsed as the reader does.
pub fn parsed(parts: &Parts, file: &GltfFile) -> Result<Root, PatchError> {
    let container = Container {
        json: parts.text.as_bytes(),
        json_start: parts.chunks.is_some().then_some(20),
        bin: parts.bin(),
    };
    let mut messages = GltfMessages::default();
    Ok(document::parse(&container, file.name, &mut messages)?)
}

/// A file that is edited.
pub struct Source<'a> {
    /// Its parts.
    pub parts: Parts<'a>,
    /// Its document.
    pub json: Json<'a>,
    /// Its JSON and its numbers, as the reader has them.
    pub data: Data<'a>,
    /// Its name.
    pub name: &'a str,
}

impl<'a> Source<'a> {
    /// Loads the numbers of a file.
    ///
    /// # Errors
    /// Text that is no JSON, or nested too deep.
    pub fn new(
        parts: Parts<'a>,
        root: &'a Root,
        file: &GltfFile<'a>,
    ) -> Result<Source<'a>, PatchError> {
        let buffers = Buffers::load(root, parts.bin(), file.files, file.options);
        let json = Json::parse(parts.text, MOST_LEVELS);
        Ok(Source {
            json: json.map_err(|found| PatchError::of(file.name, found))?,
            parts,
            data: Data {
                root,
                draco: DracoAccessors::load(root, &buffers, file.options.most_unpacked),
                buffers,
            },
            name: file.name,
        })
    }

    /// The error with this in the way.
    pub fn refused(&self, found: impl Into<String>) -> PatchError {
        PatchError::of(self.name, found)
    }

    /// The mesh of a node.
    pub fn mesh_of(&self, node: usize) -> Option<usize> {
        let node = self.data.root.nodes.get(node)?;
        node.mesh.map(|mesh| mesh.value())
    }
}
