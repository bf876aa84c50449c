//! The container of a file: JSON text alone, or the chunks of a GLB.

use super::messages::GltfMessages;
use crate::reading::bytes::Bytes;
use crate::{Position, ReadError};
use std::io::{self, Write};

/// The parts of a file.
#[derive(Debug)]
pub(super) struct Container<'a> {
    /// The JSON text without padding.
    pub json: &'a [u8],
    /// Its offset in a GLB; `None` if the whole file is text.
    pub json_start: Option<u64>,
    /// The bytes of a GLB after its JSON.
    pub bin: Option<&'a [u8]>,
}

/// Splits a file into its parts.
///
/// # Errors
/// A GLB of another version than 2, or whose JSON is missing or truncated.
pub(super) fn split<'a>(
    bytes: &'a [u8],
    file: &str,
    messages: &mut GltfMessages,
) -> Result<Container<'a>, ReadError> {
    if bytes.starts_with(b"glTF") {
        return glb(bytes, file, messages);
    }
    Ok(Container {
        json: bytes,
        json_start: None,
        bin: None,
    })
}

fn glb<'a>(
    bytes: &'a [u8],
    file: &str,
    messages: &mut GltfMessages,
) -> Result<Container<'a>, ReadError> {
    let mut at = Bytes::new(bytes);
    let header = (at.skip(4), at.u32_le(), at.u32_le());
    let (Some(()), Some(version), Some(length)) = header else {
        let found = "a GLB header that is cut off";
        return Err(ReadError::at_byte(file, at.offset(), found, "12 bytes"));
    };
    if version != 2 {
        let found = format!("binary glTF of version {version}");
        return Err(ReadError::at_byte(file, 4, found, "version 2"));
    }
    if u64::from(length) != bytes.len() as u64 {
        let message = "GLB whose length differs from that in its header: read to its actual end";
        messages.at(message, Position::Byte(8));
    }
    let json_start = at.offset() + 8;
    let json = match chunk(&mut at) {
        Some((b"JSON", json, true)) => json,
        Some((b"JSON", _, false)) => {
            let found = "a JSON chunk that is cut off";
            return Err(ReadError::at_byte(file, 12, found, "a complete file"));
        }
        _ => {
            let found = "a GLB that does not begin with its JSON";
            return Err(ReadError::at_byte(file, 12, found, "a chunk of type JSON"));
        }
    };
    Ok(Container {
        json: without_padding(json),
        json_start: Some(json_start),
        bin: bin(&mut at, messages),
    })
}

/// The first chunk of type BIN, up to the end of the file if it is truncated.
fn bin<'a>(at: &mut Bytes<'a>, messages: &mut GltfMessages) -> Option<&'a [u8]> {
    let mut bin = None;
    while at.left() > 0 {
        let start = Position::Byte(at.offset());
        match chunk(at) {
            Some((b"BIN\0", content, whole)) if bin.is_none() => {
                bin = Some(content);
                if !whole {
                    messages.at("BIN chunk that is cut off: read as far as it goes", start);
                }
            }
            Some((kind, ..)) => {
                let kind = kind.escape_ascii();
                messages.at(&format!("chunk of type \"{kind}\": skipped"), start);
            }
            // Some writers pad the end of the file after its last chunk.
            None => return bin,
        }
    }
    bin
}

/// The next chunk: its type, its content, and whether it is complete.
pub(super) fn chunk<'a>(at: &mut Bytes<'a>) -> Option<(&'a [u8; 4], &'a [u8], bool)> {
    let length = at.u32_le()? as usize;
    let kind = at.take(4)?.first_chunk()?;
    let whole = length <= at.left();
    let content = at.take(length.min(at.left()))?;
    Some((kind, content, whole))
}

/// The type and the content of a chunk.
pub(super) type Chunk<'a> = ([u8; 4], &'a [u8]);

/// The type of the chunk with the numbers.
pub(super) const BIN: [u8; 4] = *b"BIN\0";

/// Writes a GLB of chunks, the first of which is the JSON.
///
/// # Errors
/// Those of `out`, and more than 4 GiB, of which nothing is written.
pub(super) fn write_glb(chunks: &[Chunk], out: &mut dyn Write) -> io::Result<()> {
    let length = chunks.iter().map(|(_, content)| 8 + content.len());
    let length = u32::try_from(12 + length.sum::<usize>());
    let length = length.map_err(|_| io::Error::other("a GLB holds at most 4 GiB"))?;
    out.write_all(b"glTF\x02\0\0\0")?;
    out.write_all(&length.to_le_bytes())?;
    for (kind, content) in chunks {
        out.write_all(&(content.len() as u32).to_le_bytes())?;
        out.write_all(kind)?;
        out.write_all(content)?;
    }
    Ok(())
}

/// JSON is padded with blanks; some writers use zeros.
pub(super) fn without_padding(json: &[u8]) -> &[u8] {
    let end = json.iter().rposition(|b| !matches!(b, 0 | b' '));
    &json[..end.map_or(0, |e| e + 1)]
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::reading::warnings::Warnings;

    /// A GLB of these chunks, without padding.
    pub fn glb_of(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
        let mut body = Vec::new();
        for (kind, content) in chunks {
            body.extend((content.len() as u32).to_le_bytes());
            body.extend(*kind);
            body.extend(*content);
        }
        let mut glb = b"glTF\x02\0\0\0".to_vec();
        glb.extend((body.len() as u32 + 12).to_le_bytes());
        glb.extend(body);
        glb
    }

    /// Checks JSON and BIN of a file, and the number of its warnings.
    fn check(bytes: &[u8], expected: Result<(&str, Option<&[u8]>, usize), &str>) {
        let mut messages = GltfMessages::default();
        match (split(bytes, "a.glb", &mut messages), expected) {
            (Ok(container), Ok((json, bin, warned))) => {
                let mut warnings = Warnings::default();
                messages.report("a.glb", &mut warnings);
                assert_eq!((container.json, container.bin), (json.as_bytes(), bin));
                assert_eq!(warnings.finish("a.glb").len(), warned);
            }
            (Err(e), Err(part)) => assert!(e.to_string().contains(part), "{e}"),
            (result, _) => panic!("{result:?}, expected {expected:?}"),
        }
    }

    #[test]
    fn chunks() {
        check(b"{}", Ok(("{}", None, 0)));
        check(&glb_of(&[(b"JSON", b"{} \0")]), Ok(("{}", None, 0)));
        let whole = glb_of(&[
            (b"JSON", b"{}"),
            (b"abc\0", b"?"),
            (b"BIN\0", b"12"),
            (b"BIN\0", b"3"),
        ]);
        check(&whole, Ok(("{}", Some(b"12"), 2)));
        let mut padded = glb_of(&[(b"JSON", b"{}"), (b"BIN\0", b"")]);
        padded.push(0);
        check(&padded, Ok(("{}", Some(b""), 1)));
    }

    #[test]
    fn damage() {
        check(b"glTF\x02\0\0", Err("byte 4"));
        check(b"glTF\x01\0\0\0\0\0\0\0", Err("version 1"));
        check(b"glTF\x02\0\0\0\0\0\0\0", Err("does not begin"));
        check(&glb_of(&[(b"BIN\0", b"")]), Err("does not begin"));
        let whole = glb_of(&[(b"JSON", b"{}"), (b"BIN\0", b"1234")]);
        check(&whole[..21], Err("cut off"));
        check(&whole[..whole.len() - 1], Ok(("{}", Some(b"123"), 2)));
    }
}
