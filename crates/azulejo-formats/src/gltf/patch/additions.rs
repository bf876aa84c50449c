//! What an edit adds to a file: entries at the end of its lists, and bytes after its numbers.

use super::super::uri;
use super::edits::{Edit, quoted};
use super::error::PatchError;
use super::glb::{Frame, padding_of};
use super::scan;
use super::source::Source;
use gltf_json::Index;
use std::collections::HashMap;
use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};

/// What an edit adds to a file, and how it changes its text.
pub struct Additions<'s> {
    /// The changes of the text.
    pub edit: Edit,
    /// Files beside it.
    pub files: Vec<(String, Vec<u8>)>,
    source: &'s Source<'s>,
    stem: &'s str,
    what: &'static str,
    bytes: Vec<u8>,
    place: NewBytes,
    /// The index of the next entry of each list.
    next: HashMap<&'static str, usize>,
    /// Views that were added, by a hash of their bytes: the view, and where its bytes begin and end.
    views: HashMap<u64, Vec<(usize, usize, usize)>>,
    accessors: HashMap<String, usize>,
    /// How many more bytes may be added.
    left: u64,
}

/// Where new bytes go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum NewBytes {
    /// After the numbers of a GLB, of which there are so many bytes.
    Bin(usize),
    /// Into a buffer of their own: a file beside a JSON file, else embedded.
    Own,
}

/// Whether a view is damaged: one that reaches beyond the numbers would reach into new ones.
fn reaches_beyond(source: &Source) -> bool {
    let mut views = 0..source.data.root.buffer_views.len();
    views.any(|view| {
        let index = u32::try_from(view).map(Index::new);
        index.is_ok_and(|index| source.data.buffers.view(index).is_err())
    })
}

impl<'s> Additions<'s> {
    /// Nothing yet. At most `left` bytes are added; files beside the file begin with `stem`, and say `what`
    /// they are for.
    pub fn new(
        source: &'s Source<'s>,
        stem: &'s str,
        what: &'static str,
        left: u64,
    ) -> Additions<'s> {
        let buffers = &source.data.root.buffers;
        let of_bin = buffers.first().is_none_or(|b| b.uri.is_none()) && !reaches_beyond(source);
        let place = match (&source.parts.frame, source.parts.bin()) {
            (Frame::Glb(_), Some(bin)) if of_bin => NewBytes::Bin(bin.len()),
            (Frame::Glb(_), None) if buffers.is_empty() => NewBytes::Bin(0),
            _ => NewBytes::Own,
        };
        Additions {
            edit: Edit::default(),
            files: Vec::new(),
            source,
            stem,
            what,
            bytes: Vec::new(),
            place,
            next: HashMap::new(),
            views: HashMap::new(),
            accessors: HashMap::new(),
            left,
        }
    }

    /// Whether pictures and numbers become files beside the file.
    pub fn has_files(&self) -> bool {
        matches!(self.source.parts.frame, Frame::Text(_))
    }

    /// Adds an entry to a list at the root, and returns its index.
    pub fn append(&mut self, list: &'static str, entry: String) -> usize {
        let source = self.source;
        let next = self.next.entry(list);
        let next = next.or_insert_with(|| source.list(list).len());
        let index = *next;
        *next += 1;
        self.edit.key(list).index(index).set(entry);
        index
    }

    /// Counts bytes that are going to be added.
    ///
    /// # Errors
    /// More than are allowed.
    pub fn spend(&mut self, bytes: usize) -> Result<(), PatchError> {
        let left = self.left.checked_sub(bytes as u64);
        self.left = left.ok_or_else(|| {
            let found =
                "a lightmap that takes more bytes than allowed (ReadOptions::most_unpacked)";
            self.source.refused(found)
        })?;
        Ok(())
    }

    /// The view of some bytes, with this beside their place. Equal ones share a view.
    pub fn view(&mut self, bytes: &[u8], beside: &str) -> usize {
        let mut hasher = DefaultHasher::new();
        (bytes, beside).hash(&mut hasher);
        let hash = hasher.finish();
        let known = self.views.get(&hash).into_iter().flatten();
        for &(view, start, end) in known {
            if self.bytes.get(start..end) == Some(bytes) {
                return view;
            }
        }
        let start = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        let end = self.bytes.len();
        self.bytes.resize(end + padding_of(end), 0);
        let (buffer, before) = match self.place {
            NewBytes::Bin(length) => (0, length.next_multiple_of(4)),
            NewBytes::Own => (self.source.data.root.buffers.len(), 0),
        };
        let entry = format!(
            "{{\"buffer\":{buffer},\"byteOffset\":{},\"byteLength\":{}{beside}}}",
            before + start,
            bytes.len()
        );
        let view = self.append("bufferViews", entry);
        self.views.entry(hash).or_default().push((view, start, end));
        view
    }

    /// The accessor with these members. Equal ones are one.
    pub fn accessor(&mut self, entry: String) -> usize {
        if let Some(&known) = self.accessors.get(&entry) {
            return known;
        }
        let index = self.append("accessors", entry.clone());
        self.accessors.insert(entry, index);
        index
    }

    /// Adds a picture, and returns the index of its image.
    pub fn image(&mut self, name: &str, bytes: &[u8], media_type: &str, ending: &str) -> usize {
        let named = match name {
            "" => String::new(),
            name => format!(",\"name\":{}", quoted(name)),
        };
        let entry = if self.has_files() {
            let file = format!("{}.{}-{}.{ending}", self.stem, self.what, self.files.len());
            let uri = quoted(&uri::escaped(&file));
            self.files.push((file, bytes.to_vec()));
            format!("{{\"uri\":{uri}{named}}}")
        } else {
            let view = self.view(bytes, "");
            format!("{{\"bufferView\":{view},\"mimeType\":\"{media_type}\"{named}}}")
        };
        self.append("images", entry)
    }

    /// Adds a name to a list of extensions, if it is not there.
    pub fn use_extension(&mut self, list: &'static str, name: &str) {
        let text = self.source.text();
        let known = self.source.list(list);
        let is_known = known
            .iter()
            .any(|span| scan::string(text, span).as_deref() == Some(name));
        let entry = quoted(name);
        let is_new = matches!(self.edit.key(list), Edit::Within { elements, .. }
            if !elements.values().any(|e| matches!(e, Edit::Set(text) if *text == entry)));
        if !is_known && is_new {
            self.append(list, entry);
        }
    }

    /// Adds the new bytes to the text, and returns all numbers of a GLB.
    pub fn finish_bytes(&mut self) -> Option<Vec<u8>> {
        let old = self.source.parts.bin();
        if self.bytes.is_empty() {
            return old.map(<[u8]>::to_vec);
        }
        let new = std::mem::take(&mut self.bytes);
        match self.place {
            NewBytes::Bin(_) => {
                let mut bin = old.unwrap_or_default().to_vec();
                bin.resize(bin.len().next_multiple_of(4), 0);
                bin.extend(new);
                let length = bin.len().to_string();
                let buffer = self.edit.key("buffers").index(0);
                buffer.key("byteLength").set(length);
                Some(bin)
            }
            NewBytes::Own => {
                let name = format!("{}.{}.bin", self.stem, self.what);
                let uri = if self.has_files() {
                    uri::escaped(&name)
                } else {
                    uri::data_uri("application/octet-stream", &new)
                };
                let entry = format!("{{\"byteLength\":{},\"uri\":{}}}", new.len(), quoted(&uri));
                self.append("buffers", entry);
                if self.has_files() {
                    self.files.push((name, new));
                }
                old.map(<[u8]>::to_vec)
            }
        }
    }
}
