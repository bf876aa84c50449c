//! The bytes of buffers and of buffer views.

use super::meshopt;
use super::uri::{self, Uri};
use crate::reading::text::shortened;
use crate::{Files, ReadOptions};
use gltf_json::buffer::View;
use gltf_json::{Buffer, Index, Root};
use std::borrow::Cow;
use std::collections::HashMap;

/// All buffers of a file. Reading from one that could not be loaded returns the reason.
#[derive(Debug)]
pub(super) struct Buffers<'a> {
    root: &'a Root,
    /// Index of the content of each buffer: buffers of the same URI share it.
    contents: Vec<usize>,
    list: Vec<Result<Cow<'a, [u8]>, String>>,
    /// Views that were compressed (`EXT_meshopt_compression`, `KHR_meshopt_compression`), by their index.
    unpacked: HashMap<usize, Result<Vec<u8>, String>>,
}

impl<'a> Buffers<'a> {
    /// Loads every buffer; `bin` is the BIN chunk of a GLB.
    pub fn load(
        root: &'a Root,
        bin: Option<&'a [u8]>,
        files: &dyn Files,
        options: &ReadOptions,
    ) -> Buffers<'a> {
        let mut buffers = Buffers {
            root,
            contents: Vec::with_capacity(root.buffers.len()),
            list: Vec::new(),
            unpacked: HashMap::new(),
        };
        let mut known: HashMap<&str, usize> = HashMap::new();
        let mut left = options.most_unpacked;
        for (i, buffer) in root.buffers.iter().enumerate() {
            let next = buffers.list.len();
            let place = match buffer.uri.as_deref() {
                Some(uri) => *known.entry(uri).or_insert(next),
                None => next,
            };
            if place == next {
                buffers.list.push(content(buffer, i, bin, files, &mut left));
            }
            buffers.contents.push(place);
        }
        buffers.unpack(options);
        buffers
    }

    /// Total size of all buffers in bytes, before decompression.
    pub fn size(&self) -> usize {
        self.list.iter().flatten().map(|b| b.len()).sum()
    }

    /// The bytes of a view.
    ///
    /// # Errors
    /// The reason, for a buffer that could not be loaded or a view that exceeds it.
    pub fn view(&self, index: Index<View>) -> Result<&[u8], String> {
        if let Some(unpacked) = self.unpacked.get(&index.value()) {
            return unpacked.as_deref().map_err(String::clone);
        }
        let view = self.root.get(index).ok_or("a buffer view out of range")?;
        let offset = view.byte_offset.unwrap_or_default().0;
        self.part(view.buffer.value(), offset, view.byte_length.0)
    }

    /// A range of bytes of a buffer.
    fn part(&self, buffer: usize, offset: u64, length: u64) -> Result<&[u8], String> {
        let content = self.contents.get(buffer).map(|&place| &self.list[place]);
        let content = content.ok_or("a buffer out of range")?;
        let content = content.as_ref().map_err(String::clone)?;
        let range = usize::try_from(offset).ok().zip(
            offset
                .checked_add(length)
                .and_then(|end| usize::try_from(end).ok()),
        );
        let bytes = range.and_then(|(start, end)| content.get(start..end));
        bytes.ok_or_else(|| {
            format!(
                "a view reaches beyond the {} bytes of its buffer",
                content.len()
            )
        })
    }

    /// Decompresses every compressed view; in an undamaged file each one is used.
    fn unpack(&mut self, options: &ReadOptions) {
        let mut left = options.most_unpacked;
        for (i, view) in self.root.buffer_views.iter().enumerate() {
            let Some(packed) = meshopt::CompressedView::of(view) else {
                continue;
            };
            let unpacked = packed.and_then(|packed| {
                let enough = left.checked_sub(packed.size());
                left = enough.ok_or("compressed data that decompresses to more than is allowed")?;
                packed.decode(self.part(packed.buffer, packed.offset, packed.length)?)
            });
            self.unpacked.insert(i, unpacked);
        }
    }
}

fn content<'a>(
    buffer: &Buffer,
    index: usize,
    bin: Option<&'a [u8]>,
    files: &dyn Files,
    left: &mut u64,
) -> Result<Cow<'a, [u8]>, String> {
    let Some(uri) = &buffer.uri else {
        let bin = bin.filter(|_| index == 0);
        return bin
            .map(Cow::Borrowed)
            .ok_or_else(|| format!("buffer {index} has no uri"));
    };
    match uri::read(uri)? {
        Uri::Data(bytes) => Ok(Cow::Owned(bytes)),
        Uri::File(name) => {
            let shown = shortened(&name);
            let bytes = files
                .read(&name)
                .map_err(|e| format!("buffer \"{shown}\": {e}"))?;
            let enough = left.checked_sub(bytes.len() as u64);
            *left = enough.ok_or_else(|| {
                format!("buffer \"{shown}\": the buffers are together larger than allowed")
            })?;
            Ok(Cow::Owned(bytes))
        }
    }
}
