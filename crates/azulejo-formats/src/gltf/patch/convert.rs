//! GLB as JSON with files beside it, and the other way round.

use super::super::uri::{self, Uri};
use super::edits::{Edit, quoted, spliced};
use super::error::PatchError;
use super::glb::{Frame, Glb, Parts};
use super::notes::Notes;
use super::scan::{self, Span};
use super::types::{Container, GltfFile, Output, PatchedFile};
use super::undo;
use crate::{FileError, Files};

/// A file and those beside it that were changed or added.
pub struct Overlay<'a> {
    /// The files there were.
    pub old: &'a dyn Files,
    /// The files there are now.
    pub new: &'a [(String, Vec<u8>)],
}

impl Files for Overlay<'_> {
    fn read(&self, name: &str) -> Result<Vec<u8>, FileError> {
        match self.new.iter().find(|(known, _)| known == name) {
            Some((_, bytes)) => Ok(bytes.clone()),
            None => self.old.read(name),
        }
    }
}

/// The file in another container; `None` if it is in that already.
///
/// # Errors
/// Buffers that cannot be read, and more than a GLB can hold.
pub fn converted(
    file: &GltfFile,
    output: &Output,
    notes: &mut Notes,
) -> Result<Option<PatchedFile>, PatchError> {
    let parts = Parts::of(file.bytes, file.name)?;
    let conversion = Conversion {
        root: scan::whole(parts.text),
        edit: Edit::default(),
        parts: &parts,
        file,
        notes,
    };
    let converted = match (output.container, &parts.frame) {
        (Container::Glb, Frame::Text(_)) => conversion.glb()?,
        (Container::Json, Frame::Glb(glb)) => conversion.json(glb, output.stem),
        _ => return Ok(None),
    };
    notes.add("another container: without its lightmap the file stays in that");
    Ok(Some(converted))
}

struct Conversion<'c, 'a> {
    parts: &'c Parts<'a>,
    root: Span,
    edit: Edit,
    file: &'c GltfFile<'a>,
    notes: &'c mut Notes,
}

impl Conversion<'_, '_> {
    fn list(&self, key: &str) -> Vec<Span> {
        let list = scan::member(self.parts.text, &self.root, key);
        let list = list.and_then(|list| scan::elements(self.parts.text, &list));
        list.unwrap_or_default()
    }

    fn uri(&self, entry: &Span) -> Option<String> {
        let uri = scan::member(self.parts.text, entry, "uri")?;
        scan::string(self.parts.text, &uri)
    }

    /// The edited text.
    fn text(&self) -> String {
        let text = self.parts.text;
        spliced(text, &self.edit.splices(text, &self.root))
    }

    fn json(mut self, glb: &Glb, stem: &str) -> PatchedFile {
        let first = self.list("buffers").into_iter().next();
        let is_used = first.is_some_and(|first| self.uri(&first).is_none());
        let mut files = Vec::new();
        let kept = match glb.bin() {
            Some(bin) if is_used => {
                let name = format!("{stem}.bin");
                let uri = quoted(&uri::escaped(&name));
                self.edit.key("buffers").index(0).key("uri").set(uri);
                files.push((name, bin.to_vec()));
                1
            }
            _ => 0,
        };
        if glb.chunks.len() > kept {
            self.notes.add("chunks that glTF does not know: left out");
        }
        PatchedFile {
            bytes: self.text().into_bytes(),
            files,
            notes: Vec::new(),
            leaves_dark: false,
        }
    }

    fn glb(mut self) -> Result<PatchedFile, PatchError> {
        let mut bin = self.buffers()?;
        let before = bin.as_ref().map_or(0, Vec::len);
        let mut new = bin.take().unwrap_or_default();
        self.images(&mut new);
        if new.len() > before {
            let buffer = self.edit.key("buffers").index(0);
            buffer.key("byteLength").set(new.len().to_string());
        }
        new.resize(new.len().next_multiple_of(4), 0);
        let bin = Some(new).filter(|new| !new.is_empty());
        let frame = Frame::Glb(Glb::default());
        let bytes = undo::assembled(&frame, &self.text(), bin.as_deref());
        let too_large = || PatchError::of(self.file.name, "a GLB of more than 4 GiB");
        Ok(PatchedFile {
            bytes: bytes.ok_or_else(too_large)?,
            ..PatchedFile::default()
        })
    }

    /// Embeds all buffers: the first, which is returned, as the numbers of the GLB.
    fn buffers(&mut self) -> Result<Option<Vec<u8>>, PatchError> {
        let mut first = None;
        for (i, buffer) in self.list("buffers").iter().enumerate() {
            let Some(uri) = self.uri(buffer) else {
                continue;
            };
            if i > 0 && uri.starts_with("data:") {
                continue;
            }
            let bytes = self
                .bytes(&uri)
                .map_err(|fault| PatchError::of(self.file.name, format!("buffer {i}: {fault}")))?;
            let change = self.edit.key("buffers").index(i).key("uri");
            match i {
                0 => {
                    change.remove();
                    first = Some(bytes);
                }
                _ => change.set(quoted(&uri::data_uri("application/octet-stream", &bytes))),
            }
        }
        Ok(first)
    }

    /// Embeds the pictures that are files, after the numbers.
    fn images(&mut self, bin: &mut Vec<u8>) {
        let buffers = self.list("buffers");
        if buffers
            .first()
            .is_some_and(|first| self.uri(first).is_none())
        {
            // A buffer without bytes keeps none.
            return;
        }
        let mut view = self.list("bufferViews").len();
        for (i, image) in self.list("images").iter().enumerate() {
            let Some(uri) = self.uri(image).filter(|uri| !uri.starts_with("data:")) else {
                continue;
            };
            let Ok(bytes) = self.bytes(&uri) else {
                self.notes.add("picture that cannot be read: stays a file");
                continue;
            };
            let media_type = media_type(&bytes, &uri);
            bin.resize(bin.len().next_multiple_of(4), 0);
            let entry = format!(
                "{{\"buffer\":0,\"byteOffset\":{},\"byteLength\":{}}}",
                bin.len(),
                bytes.len()
            );
            bin.extend(bytes);
            self.edit.key("bufferViews").index(view).set(entry);
            let change = self.edit.key("images").index(i);
            change.key("uri").remove();
            change.key("bufferView").set(view.to_string());
            change.key("mimeType").set(quoted(media_type));
            view += 1;
        }
    }

    fn bytes(&self, uri: &str) -> Result<Vec<u8>, String> {
        match uri::read(uri)? {
            Uri::Data(bytes) => Ok(bytes),
            Uri::File(name) => self.file.files.read(&name).map_err(|e| e.to_string()),
        }
    }
}

/// The type of a picture, by its first bytes or else by its name.
fn media_type(bytes: &[u8], uri: &str) -> &'static str {
    let ending = uri.rsplit('.').next().unwrap_or_default();
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => "image/png",
        [0xff, 0xd8, ..] => "image/jpeg",
        [
            b'R',
            b'I',
            b'F',
            b'F',
            _,
            _,
            _,
            _,
            b'W',
            b'E',
            b'B',
            b'P',
            ..,
        ] => "image/webp",
        [0xab, b'K', b'T', b'X', ..] => "image/ktx2",
        [b'D', b'D', b'S', b' ', ..] => "image/vnd-ms.dds",
        _ if ending.eq_ignore_ascii_case("png") => "image/png",
        _ => "image/jpeg",
    }
}
