//! A file that is edited: its parts, its text, and the numbers in it.

use super::super::accessor::Data;
use super::super::buffers::Buffers;
use super::super::container::Container;
use super::super::document;
use super::super::draco::DracoAccessors;
use super::super::messages::GltfMessages;
use super::error::PatchError;
use super::glb::{Frame, Parts};
use super::scan::{self, Span};
use super::types::GltfFile;
use gltf_json::Root;

/// The JSON of a file, parsed as the reader does.
pub fn parsed(parts: &Parts, file: &GltfFile) -> Result<Root, PatchError> {
    let container = Container {
        json: parts.text.as_bytes(),
        json_start: matches!(parts.frame, Frame::Glb(_)).then_some(20),
        bin: parts.bin(),
    };
    let mut messages = GltfMessages::default();
    Ok(document::parse(&container, file.name, &mut messages)?)
}

/// A file that is edited.
pub struct Source<'a> {
    /// Its parts.
    pub parts: Parts<'a>,
    /// The bytes of the JSON value in the text.
    pub root: Span,
    /// Its JSON and its numbers, as the reader has them.
    pub data: Data<'a>,
    /// Its name.
    pub name: &'a str,
}

impl<'a> Source<'a> {
    /// Loads the numbers of a file.
    pub fn new(parts: Parts<'a>, root: &'a Root, file: &GltfFile<'a>) -> Source<'a> {
        let buffers = Buffers::load(root, parts.bin(), file.files, file.options);
        Source {
            root: scan::whole(parts.text),
            parts,
            data: Data {
                root,
                draco: DracoAccessors::load(root, &buffers, file.options.most_unpacked),
                buffers,
            },
            name: file.name,
        }
    }

    /// The JSON text.
    pub fn text(&self) -> &'a str {
        self.parts.text
    }

    /// The value at the end of some steps from the root.
    pub fn find(&self, steps: &[&str]) -> Option<Span> {
        scan::find(self.text(), &self.root, steps)
    }

    /// The elements of a list at the root.
    pub fn list(&self, key: &str) -> Vec<Span> {
        let list = self.find(&[key]);
        list.and_then(|list| scan::elements(self.text(), &list))
            .unwrap_or_default()
    }

    /// The error with this in the way.
    pub fn refused(&self, found: impl Into<String>) -> PatchError {
        PatchError::of(self.name, found)
    }
}
