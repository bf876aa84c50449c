//! GLB as JSON with files beside it, and the other way round.

use super::super::uri::{self, Uri};
use super::error::PatchError;
use super::glb::Parts;
use super::json::{Json, MOST_LEVELS};
use super::notes::Notes;
use super::types::{Container, GltfFile, Output, PatchedFile};
use crate::{FileError, Files};
use serde_json::json;

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

/// The file in another container, with the files beside it; `None` if it is in that already.
///
/// # Errors
/// Buffers that cannot be read, and more than a GLB can hold.
pub fn converted(
    file: &GltfFile,
    output: &Output,
    notes: &mut Notes,
) -> Result<Option<PatchedFile>, PatchError> {
    let parts = Parts::of(file.bytes, file.name)?;
    let json = || Json::parse(parts.text, MOST_LEVELS).map_err(|f| PatchError::of(file.name, f));
    let (bytes, files) = match (output.container, &parts.chunks) {
        (Container::Glb, None) => {
            let (mut json, chunks) = (json()?, Some(Vec::new()));
            let bin = embed(&mut json, file, notes)?;
            let frame = Parts { chunks, ..parts };
            let bin = Some(bin).filter(|bin| !bin.is_empty());
            (frame.joined(&json, bin.as_deref(), file.name)?, Vec::new())
        }
        (Container::Json, Some(chunks)) => {
            let mut json = json()?;
            let files = beside(&mut json, parts.bin(), output.stem);
            if chunks.len() > files.len() {
                notes.add("chunks that glTF does not know: left out");
            }
            (json.to_string().into_bytes(), files)
        }
        _ => return Ok(None),
    };
    notes.add("another container: without its lightmap the file stays in that");
    Ok(Some(PatchedFile {
        bytes,
        files,
        ..PatchedFile::default()
    }))
}

fn uri_of(entry: &Json) -> Option<String> {
    Some(entry.get("uri")?.text()?.into_owned())
}

/// Makes a file of the numbers of a GLB.
fn beside(json: &mut Json, bin: Option<&[u8]>, stem: &str) -> Vec<(String, Vec<u8>)> {
    let first = json.entries("buffers").first();
    let Some(bin) = bin.filter(|_| first.is_some_and(|first| uri_of(first).is_none())) else {
        return Vec::new();
    };
    let name = format!("{stem}.bin");
    let buffer = json.key("buffers").at(0);
    buffer.key("uri").set(&*uri::escaped(&name));
    vec![(name, bin.to_vec())]
}

/// Puts all buffers and pictures into the document: the first buffer, and the pictures after it, as the numbers
/// of a GLB, which are returned.
fn embed(json: &mut Json, file: &GltfFile, notes: &mut Notes) -> Result<Vec<u8>, PatchError> {
    let uris = |json: &Json, list: &str| -> Vec<Option<String>> {
        json.entries(list).iter().map(uri_of).collect()
    };
    let bytes_of = |uri: &str| -> Result<Vec<u8>, String> {
        match uri::read(uri)? {
            Uri::Data(bytes) => Ok(bytes),
            Uri::File(name) => file.files.read(&name).map_err(|e| e.to_string()),
        }
    };
    let mut bin = Vec::new();
    let buffers = uris(json, "buffers");
    for (i, uri) in buffers.iter().enumerate() {
        let is_file = |uri: &&String| i == 0 || !uri.starts_with("data:");
        let Some(uri) = uri.as_ref().filter(is_file) else {
            continue;
        };
        let bytes = bytes_of(uri)
            .map_err(|fault| PatchError::of(file.name, format!("buffer {i}: {fault}")))?;
        let buffer = json.key("buffers").at(i);
        if i == 0 {
            buffer.remove("uri");
            bin = bytes;
        } else {
            let data = uri::data_uri("application/octet-stream", &bytes);
            buffer.key("uri").set(&*data);
        }
    }
    if matches!(buffers.first(), Some(None)) {
        // A buffer without bytes keeps none.
        return Ok(bin);
    }
    let before = bin.len();
    for (i, uri) in uris(json, "images").into_iter().enumerate() {
        let Some(uri) = uri.filter(|uri| !uri.starts_with("data:")) else {
            continue;
        };
        let Ok(bytes) = bytes_of(&uri) else {
            notes.add("picture that cannot be read: stays a file");
            continue;
        };
        bin.resize(bin.len().next_multiple_of(4), 0);
        let (start, length) = (bin.len(), bytes.len());
        let view = json!({ "buffer": 0, "byteOffset": start, "byteLength": length });
        let view = json.key("bufferViews").push(view);
        let image = json.key("images").at(i);
        image.remove("uri");
        image.key("bufferView").set(view);
        image.key("mimeType").set(media_type(&bytes, &uri));
        bin.extend(bytes);
    }
    if bin.len() > before {
        json.key("buffers").at(0).key("byteLength").set(bin.len());
    }
    bin.resize(bin.len().next_multiple_of(4), 0);
    Ok(bin)
}

/// The type of a picture, by its first bytes or else by its name.
fn media_type(bytes: &[u8], uri: &str) -> &'static str {
    let ending = uri.rsplit('.').next().unwrap_or_default();
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => "image/png",
        [0xff, 0xd8, ..] => "image/jpeg",
        [b'R', b'I', b'F', b'F', ..] => "image/webp",
        [0xab, b'K', b'T', b'X', ..] => "image/ktx2",
        [b'D', b'D', b'S', b' ', ..] => "image/vnd-ms.dds",
        _ if ending.eq_ignore_ascii_case("png") => "image/png",
        _ => "image/jpeg",
    }
}
