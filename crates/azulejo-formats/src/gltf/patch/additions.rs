//! What an edit adds to a file: entries at the end of its lists, and bytes after its numbers.

use super::super::uri;
use super::error::PatchError;
use super::json::Json;
use super::source::Source;
use gltf_json::Index;
use serde_json::{Value, json};
use std::collections::HashMap;
use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};
use std::ops::Range;

/// A document that is edited, and what is added to its file.
pub struct Additions<'s> {
    /// The document.
    pub json: Json<'s>,
    /// Files beside it.
    pub files: Vec<(String, Vec<u8>)>,
    /// The file.
    pub source: &'s Source<'s>,
    stem: &'s str,
    what: &'static str,
    bytes: Vec<u8>,
    place: NewBytes,
    /// Views that were added, and where their bytes are, by a hash of these.
    views: HashMap<u64, Vec<(usize, Range<usize>)>>,
    accessors: HashMap<String, usize>,
    /// How many more bytes may be added; `None` if there were more.
    pub left: Option<u64>,
}

/// Where new bytes go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum NewBytes {
    /// After the binary chunk of a GLB, which has this number of bytes.
    Bin(usize),
    /// Into a buffer of their own: a file beside a JSON file, else embedded.
    Own,
}

/// Whether a view is damaged: one that reaches beyond the numbers would reach into new ones.
fn reaches_beyond(source: &Source) -> bool {
    let mut views = 0..source.data.root.buffer_views.len() as u32;
    views.any(|view| source.data.buffers.view(Index::new(view)).is_err())
}

impl<'s> Additions<'s> {
    /// Nothing yet. Files beside the file begin with `stem`, and say `what` they are for.
    pub fn new(source: &'s Source<'s>, stem: &'s str, what: &'static str) -> Additions<'s> {
        let buffers = &source.data.root.buffers;
        let can_extend = buffers.first().is_none_or(|b| b.uri.is_none()) && !reaches_beyond(source);
        let place = match (&source.parts.chunks, source.parts.bin()) {
            (Some(_), Some(bin)) if can_extend => NewBytes::Bin(bin.len()),
            (Some(_), None) if buffers.is_empty() => NewBytes::Bin(0),
            _ => NewBytes::Own,
        };
        Additions {
            json: source.json.clone(),
            files: Vec::new(),
            source,
            stem,
            what,
            bytes: Vec::new(),
            place,
            views: HashMap::new(),
            accessors: HashMap::new(),
            left: Some(source.file.options.most_unpacked),
        }
    }

    /// Adds an entry to a list at the root, and returns its index.
    pub fn append(&mut self, list: &str, entry: impl Into<Json<'s>>) -> usize {
        self.json.key(list).push(entry)
    }

    /// Whether there is room for `bytes` more bytes; if not, the edit fails at its end ([`Additions::finish`]).
    fn spend(&mut self, bytes: usize) -> bool {
        self.left = self.left.and_then(|left| left.checked_sub(bytes as u64));
        self.left.is_some()
    }

    /// The view of some bytes, with this beside their place. Equal ones share a view.
    pub fn view(&mut self, bytes: &[u8], beside: Value) -> usize {
        let mut hasher = DefaultHasher::new();
        (bytes, beside.to_string()).hash(&mut hasher);
        let hash = hasher.finish();
        for (view, place) in self.views.get(&hash).into_iter().flatten() {
            if self.bytes.get(place.clone()) == Some(bytes) {
                return *view;
            }
        }
        if !self.spend(bytes.len()) {
            return 0;
        }
        let start = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let (buffer, before) = match self.place {
            NewBytes::Bin(length) => (0, length.next_multiple_of(4)),
            NewBytes::Own => (self.source.json.entries("buffers").len(), 0),
        };
        let mut entry = Json::from(beside);
        entry.key("buffer").set(buffer);
        entry.key("byteOffset").set(before + start);
        entry.key("byteLength").set(bytes.len());
        let view = self.append("bufferViews", entry);
        let place = start..start + bytes.len();
        self.views.entry(hash).or_default().push((view, place));
        view
    }

    /// The accessor with these members. Equal ones are one.
    pub fn accessor(&mut self, entry: Json<'s>) -> usize {
        let spelled = entry.to_string();
        if let Some(&known) = self.accessors.get(&spelled) {
            return known;
        }
        let index = self.append("accessors", entry);
        self.accessors.insert(spelled, index);
        index
    }

    /// The accessor of vectors, one for each vertex.
    pub fn vectors<const N: usize>(&mut self, values: impl Iterator<Item = [f32; N]>) -> usize {
        let values = values.flatten().flat_map(f32::to_le_bytes);
        let bytes: Vec<u8> = values.collect();
        // The stride is needed where accessors share the view.
        let view = self.view(&bytes, json!({ "byteStride": 4 * N, "target": 34962 }));
        let count = bytes.len() / (4 * N);
        let kind = format!("VEC{N}");
        let entry =
            json!({ "bufferView": view, "componentType": 5126, "count": count, "type": kind });
        self.accessor(entry.into())
    }

    /// Adds a picture, and returns the index of its image.
    pub fn image(&mut self, name: &str, bytes: &[u8], media_type: &str, ending: &str) -> usize {
        let mut entry = if self.source.parts.chunks.is_none() {
            let file = format!("{}.{}-{}.{ending}", self.stem, self.what, self.files.len());
            let uri = uri::escaped(&file);
            if self.spend(bytes.len()) {
                self.files.push((file, bytes.to_vec()));
            }
            json!({ "uri": uri })
        } else {
            json!({ "bufferView": self.view(bytes, json!({})), "mimeType": media_type })
        };
        if !name.is_empty() {
            entry["name"] = name.into();
        }
        self.append("images", entry)
    }

    /// Adds a name to a list of extensions, if it is not there.
    pub fn use_extension(&mut self, list: &str, name: &str) {
        let mut known = self.json.entries(list).iter();
        if !known.any(|known| known.text().as_deref() == Some(name)) {
            self.append(list, name);
        }
    }

    /// Adds the new bytes to the document, and returns all numbers of a GLB.
    ///
    /// # Errors
    /// More bytes than are allowed.
    pub fn finish(&mut self) -> Result<Option<Vec<u8>>, PatchError> {
        if self.left.is_none() {
            let found =
                "a lightmap that takes more bytes than allowed (ReadOptions::most_unpacked)";
            return Err(self.source.refused(found));
        }
        let mut bin = self.source.parts.bin().map(<[u8]>::to_vec);
        if self.bytes.is_empty() {
            return Ok(bin);
        }
        let new = std::mem::take(&mut self.bytes);
        if let NewBytes::Bin(length) = self.place {
            let bin = bin.get_or_insert_default();
            bin.resize(length.next_multiple_of(4), 0);
            bin.extend(new);
            let buffer = self.json.key("buffers").at(0);
            buffer.key("byteLength").set(bin.len());
        } else {
            let name = format!("{}.{}.bin", self.stem, self.what);
            let is_file = self.source.parts.chunks.is_none();
            let uri = if is_file {
                uri::escaped(&name)
            } else {
                uri::data_uri("application/octet-stream", &new)
            };
            self.append("buffers", json!({ "byteLength": new.len(), "uri": uri }));
            if is_file {
                self.files.push((name, new));
            }
        }
        Ok(bin)
    }
}
