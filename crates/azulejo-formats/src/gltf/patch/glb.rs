//! The parts of a file, and files of parts. Unlike the reader's container it keeps what it does not know.

use super::error::PatchError;

/// A mark before the text of some files.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// A file in its parts.
#[derive(Clone, Debug)]
pub struct Parts<'a> {
    /// The JSON text, without padding.
    pub text: &'a str,
    /// What holds it.
    pub frame: Frame<'a>,
}

/// What holds the JSON text of a file.
#[derive(Clone, Debug)]
pub enum Frame<'a> {
    /// The whole file is text, after these bytes.
    Text(&'a [u8]),
    /// Chunks.
    Glb(Glb<'a>),
}

/// A GLB without its JSON.
#[derive(Clone, Debug, Default)]
pub struct Glb<'a> {
    /// The length in the header, if it is not that of the file.
    pub odd_length: Option<u32>,
    /// What pads the JSON, if it is not the fewest blanks.
    pub odd_padding: Option<&'a [u8]>,
    /// All chunks after the JSON.
    pub chunks: Vec<Chunk<'a>>,
    /// What follows the last complete chunk.
    pub tail: &'a [u8],
}

/// A chunk of a GLB.
#[derive(Clone, Copy, Debug)]
pub struct Chunk<'a> {
    /// Its type.
    pub kind: [u8; 4],
    /// Its content.
    pub bytes: &'a [u8],
}

/// The type of the chunk with the numbers.
const BIN: [u8; 4] = *b"BIN\0";

impl<'a> Parts<'a> {
    /// Takes a file apart.
    ///
    /// # Errors
    /// A GLB that is cut off or not of version 2, and text that is not UTF-8.
    pub fn of(bytes: &'a [u8], name: &str) -> Result<Parts<'a>, PatchError> {
        let (text, frame) = if bytes.starts_with(b"glTF") {
            let (json, glb) = split(bytes).map_err(|found| PatchError::of(name, found))?;
            (json, Frame::Glb(glb))
        } else {
            let mark = if bytes.starts_with(BYTE_ORDER_MARK) {
                BYTE_ORDER_MARK
            } else {
                &[]
            };
            (&bytes[mark.len()..], Frame::Text(mark))
        };
        let text = std::str::from_utf8(text)
            .map_err(|_| PatchError::of(name, "JSON that is not UTF-8, as glTF has it"))?;
        Ok(Parts { text, frame })
    }

    /// The numbers of a GLB.
    pub fn bin(&self) -> Option<&'a [u8]> {
        match &self.frame {
            Frame::Glb(glb) => glb.bin(),
            Frame::Text(_) => None,
        }
    }
}

impl<'a> Glb<'a> {
    /// The numbers.
    pub fn bin(&self) -> Option<&'a [u8]> {
        self.chunks.iter().find(|c| c.kind == BIN).map(|c| c.bytes)
    }

    /// The file with these contents: JSON text, and numbers in the place of the old ones. `None` if it would
    /// be larger than a GLB can be.
    pub fn joined(&self, text: &str, bin: Option<&[u8]>) -> Option<Vec<u8>> {
        let blanks = [b' '; 4];
        let padding = self
            .odd_padding
            .unwrap_or(&blanks[..padding_of(text.len())]);
        let mut body = Vec::new();
        let json = Chunk {
            kind: *b"JSON",
            bytes: text.as_bytes(),
        };
        push_chunk(&mut body, json, padding)?;
        let old = self.chunks.iter().position(|c| c.kind == BIN);
        let new = bin.map(|bytes| Chunk { kind: BIN, bytes });
        if let (None, Some(new)) = (old, new) {
            push_chunk(&mut body, new, &[])?;
        }
        for (i, &chunk) in self.chunks.iter().enumerate() {
            match new {
                _ if Some(i) != old => push_chunk(&mut body, chunk, &[])?,
                Some(new) => push_chunk(&mut body, new, &[])?,
                None => {}
            }
        }
        body.extend_from_slice(self.tail);
        let length = u32::try_from(body.len() + 12).ok()?;
        let mut file = b"glTF\x02\0\0\0".to_vec();
        file.extend(self.odd_length.unwrap_or(length).to_le_bytes());
        file.append(&mut body);
        Some(file)
    }
}

/// Bytes after a length to the next multiple of 4.
pub fn padding_of(length: usize) -> usize {
    length.next_multiple_of(4) - length
}

fn push_chunk(body: &mut Vec<u8>, chunk: Chunk, padding: &[u8]) -> Option<()> {
    let length = u32::try_from(chunk.bytes.len() + padding.len()).ok()?;
    body.extend(length.to_le_bytes());
    body.extend(chunk.kind);
    body.extend_from_slice(chunk.bytes);
    body.extend_from_slice(padding);
    Some(())
}

/// The JSON of a GLB and the rest of it.
fn split(bytes: &[u8]) -> Result<(&[u8], Glb<'_>), &'static str> {
    let (header, mut rest) = bytes
        .split_at_checked(12)
        .ok_or("a GLB header that is cut off")?;
    if word(header, 4) != Some(2) {
        return Err("binary glTF of another version than 2");
    }
    let length = word(header, 8).unwrap_or_default();
    let json = next_chunk(&mut rest).filter(|c| &c.kind == b"JSON");
    let json = json.ok_or("a GLB that does not begin with its JSON, or whose JSON is cut off")?;
    let end = json.bytes.iter().rposition(|b| !matches!(b, 0 | b' '));
    let (text, padding) = json.bytes.split_at(end.map_or(0, |e| e + 1));
    let is_usual = padding.len() == padding_of(text.len()) && padding.iter().all(|b| *b == b' ');
    let mut glb = Glb {
        odd_length: (length as usize != bytes.len()).then_some(length),
        odd_padding: (!is_usual).then_some(padding),
        ..Glb::default()
    };
    while let Some(chunk) = next_chunk(&mut rest) {
        glb.chunks.push(chunk);
    }
    if glb.bin().is_none() && rest.get(4..8) == Some(&BIN) {
        return Err("a BIN chunk that is cut off");
    }
    glb.tail = rest;
    Ok((text, glb))
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    let word = bytes.get(at..)?.first_chunk()?;
    Some(u32::from_le_bytes(*word))
}

/// The next chunk, if it is complete.
fn next_chunk<'a>(rest: &mut &'a [u8]) -> Option<Chunk<'a>> {
    let length = usize::try_from(word(rest, 0)?).ok()?;
    let kind = *rest.get(4..)?.first_chunk()?;
    let (bytes, after) = rest.get(8..)?.split_at_checked(length)?;
    *rest = after;
    Some(Chunk { kind, bytes })
}

#[cfg(test)]
mod tests {
    use super::super::super::container::tests::glb_of;
    use super::*;

    #[test]
    fn any_glb_comes_back() {
        let mut odd = glb_of(&[
            (b"JSON", b"{}  \0"),
            (b"abc\0", b"?"),
            (b"BIN\0", b"12"),
            (b"BIN\0", b"3"),
        ]);
        odd.extend(*b"tail");
        odd[8] = 7;
        let files = [
            glb_of(&[(b"JSON", b"{}  ")]),
            glb_of(&[(b"JSON", b"{}"), (b"BIN\0", b"")]),
            odd,
        ];
        for file in files {
            let parts = Parts::of(&file, "a.glb").unwrap();
            assert_eq!(parts.text, "{}");
            let Frame::Glb(glb) = &parts.frame else {
                panic!("a GLB")
            };
            assert_eq!(glb.joined(parts.text, glb.bin()).unwrap(), file);
        }
    }

    #[test]
    fn numbers_have_one_place() {
        let file = glb_of(&[(b"JSON", b"{} "), (b"abc\0", b"?")]);
        let parts = Parts::of(&file, "a.glb").unwrap();
        let Frame::Glb(glb) = parts.frame else {
            panic!("a GLB")
        };
        let more = glb.joined("[]", Some(b"1234")).unwrap();
        let again = Parts::of(&more, "a.glb").unwrap();
        assert_eq!((again.text, again.bin()), ("[]", Some(&b"1234"[..])));
        let Frame::Glb(again) = again.frame else {
            panic!("a GLB")
        };
        assert_eq!(again.joined("{}", None).unwrap().len(), file.len());
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
