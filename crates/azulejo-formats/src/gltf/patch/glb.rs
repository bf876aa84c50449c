//! The parts of a file, and files of parts. Unlike the reader's container they keep chunks that glTF does not know.

use super::super::container::{BIN, Chunk, chunk, without_padding, write_glb};
use super::error::PatchError;
use super::json::Json;
use crate::reading::bytes::Bytes;

/// A file in its parts.
#[derive(Clone, Debug)]
pub struct Parts<'a> {
    /// The JSON text, without a mark before it and padding behind it.
    pub text: &'a str,
    /// All chunks of a GLB after the JSON: their types and contents. `None` if the file is text.
    pub chunks: Option<Vec<Chunk<'a>>>,
}

impl<'a> Parts<'a> {
    /// Takes a file apart.
    ///
    /// # Errors
    /// A GLB that is cut off or not of version 2, and text that is not UTF-8.
    pub fn of(bytes: &'a [u8], name: &str) -> Result<Parts<'a>, PatchError> {
        let (text, chunks) = if bytes.starts_with(b"glTF") {
            let (json, chunks) = split(bytes).map_err(|found| PatchError::of(name, found))?;
            (json, Some(chunks))
        } else {
            (bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), None)
        };
        let text = std::str::from_utf8(text)
            .map_err(|_| PatchError::of(name, "JSON that is not UTF-8, as glTF has it"))?;
        Ok(Parts { text, chunks })
    }

    /// The numbers of a GLB.
    pub fn bin(&self) -> Option<&'a [u8]> {
        let bin = self.chunks.iter().flatten().find(|(kind, _)| *kind == BIN);
        bin.map(|(_, bytes)| *bytes)
    }

    /// The file with another document, and numbers in the place of the old ones.
    ///
    /// # Errors
    /// A GLB of more than 4 GiB.
    pub fn joined(
        &self,
        json: &Json,
        bin: Option<&[u8]>,
        name: &str,
    ) -> Result<Vec<u8>, PatchError> {
        let Some(chunks) = &self.chunks else {
            return Ok(json.to_string().into_bytes());
        };
        let mut text = json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let others = chunks.iter().copied().filter(|(kind, _)| *kind != BIN);
        let old = chunks
            .iter()
            .copied()
            .filter(|(kind, _)| *kind == BIN)
            .skip(1);
        // The JSON is the first chunk, and numbers the second.
        let json = (*b"JSON", &text[..]);
        let bin = bin.map(|bytes| (BIN, bytes));
        let all = [json].into_iter().chain(bin).chain(others).chain(old);
        let mut file = Vec::new();
        write_glb(&all.collect::<Vec<_>>(), &mut file)
            .map_err(|_| PatchError::of(name, "a GLB of more than 4 GiB"))?;
        Ok(file)
    }
}

/// The JSON of a GLB, and its other chunks. What follows the last one is padding of some writers.
fn split(bytes: &[u8]) -> Result<(&[u8], Vec<Chunk<'_>>), &'static str> {
    let mut at = Bytes::new(bytes);
    let (Some(()), Some(version), Some(_)) = (at.skip(4), at.u32_le(), at.u32_le()) else {
        return Err("a GLB header that is cut off");
    };
    if version != 2 {
        return Err("binary glTF of another version than 2");
    }
    let Some((b"JSON", json, true)) = chunk(&mut at) else {
        return Err("a GLB that does not begin with its JSON, or whose JSON is cut off");
    };
    let mut chunks = Vec::new();
    while let Some((kind, bytes, is_whole)) = chunk(&mut at) {
        match (kind, is_whole) {
            (_, true) => chunks.push((*kind, bytes)),
            (&BIN, false) => return Err("a BIN chunk that is cut off"),
            (_, false) => break,
        }
    }
    Ok((without_padding(json), chunks))
}

#[cfg(test)]
mod tests {
    use super::super::super::container::tests::glb_of;
    use super::*;

    #[test]
    fn chunks_come_back() {
        let file = glb_of(&[
            (b"JSON", b"{}  "),
            (b"BIN\0", b"12"),
            (b"abc\0", b"?"),
            (b"BIN\0", b"3"),
        ]);
        let padded = [&file[..], b"tail"].concat();
        let parts = Parts::of(&padded, "a.glb").unwrap();
        let json = Json::parse(parts.text, 1).unwrap();
        assert_eq!(parts.joined(&json, parts.bin(), "a.glb").unwrap(), file);
        let more = parts.joined(&json, Some(b"1234"), "a.glb").unwrap();
        assert_eq!(Parts::of(&more, "a.glb").unwrap().bin(), Some(&b"1234"[..]));
        let none = parts.joined(&json, None, "a.glb").unwrap();
        assert_eq!(none.len(), file.len() - 10);
    }

    #[test]
    fn damage() {
        let check = |bytes: &[u8], part: &str| {
            let error = Parts::of(bytes, "a.glb").unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        };
        check(b"glTF\x02\0\0\0", "header");
        check(b"glTF\x01\0\0\0\0\0\0\0", "version");
        let whole = glb_of(&[(b"JSON", b"{}"), (b"BIN\0", b"1234")]);
        check(&whole[..21], "cut off");
        check(&whole[..whole.len() - 1], "BIN chunk that is cut off");
        check(b"\xff\xfe{\0}\0", "UTF-8");
    }
}
