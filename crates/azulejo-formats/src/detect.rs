//! Which format bytes are in, by what they say rather than by the file's name.

use crate::obj::{self, without_utf16};
use crate::{Files, Loaded, ReadError, grf};
use std::fmt;

/// The model formats that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// GRanada File, azulejo's own.
    Grf,
    /// Wavefront OBJ.
    Obj,
}

/// Bytes in none of the formats that can be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unrecognised {
    /// What they look like: "a PNG picture", "text of no known kind".
    pub looks_like: &'static str,
}

impl fmt::Display for Unrecognised {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "found {}, expected {EXPECTED}", self.looks_like)
    }
}

impl std::error::Error for Unrecognised {}

/// What every message asks for instead.
const EXPECTED: &str = "a model in GRF or OBJ";

/// Reads a model in whatever format it is. `name` stands in messages; `files` gives the files
/// that the model names, relative to the model's folder.
///
/// # Errors
/// A format that is not read, and what the format's own reader says.
pub fn read(bytes: &[u8], name: &str, files: &dyn Files) -> Result<Loaded, ReadError> {
    match detect(bytes) {
        Ok(Format::Grf) => grf::read(bytes, name, files),
        Ok(Format::Obj) => obj::read(bytes, name, files),
        Err(Unrecognised { looks_like }) => Err(ReadError::whole(name, looks_like, EXPECTED)),
    }
}

/// How much of a file is looked at: enough to come past a long comment at its head.
const LOOKED_AT: usize = 1 << 16;

/// Recognises the format of a model.
///
/// # Errors
/// [`Unrecognised`], with a name for what it is instead where that is well known.
pub fn detect(bytes: &[u8]) -> Result<Format, Unrecognised> {
    let head = without_utf16(&bytes[..bytes.len().min(LOOKED_AT)]);
    let found = match known_mark(bytes) {
        Some(other) => Err(other),
        None => by_words(&head),
    };
    found.map_err(|looks_like| Unrecognised { looks_like })
}

/// Formats that begin with bytes of their own.
fn known_mark(bytes: &[u8]) -> Option<&'static str> {
    const MARKS: [(&[u8], &str); 21] = [
        (b"\x89PNG", "a PNG picture"),
        (b"\xff\xd8\xff", "a JPEG picture"),
        (b"GIF8", "a GIF picture"),
        (b"BM", "a BMP picture"),
        (b"\x76\x2f\x31\x01", "an OpenEXR picture"),
        (b"#?RADIANCE", "a Radiance picture"),
        (b"\x1f\x8b", "a gzip archive; unpack it first"),
        (b"PK\x03\x04", "a zip archive; unpack it first"),
        (b"%PDF", "a PDF document"),
        (b"BLENDER", "a Blender file; export it as OBJ"),
        (b"Kaydara FBX", "an FBX model"),
        (b"glTF", "a binary glTF model"),
        (b"ply\n", "a PLY model"),
        (b"ply\r", "a PLY model"),
        (b"#VRML", "a VRML model"),
        (b"#X3D", "an X3D model"),
        (b"#Inventor", "an Open Inventor model"),
        (b"AutoCAD Binary DXF", "a DXF drawing"),
        (b"OFF\n", "an OFF model"),
        (b"\x00\x01\x01\x44", "an OpenFlight model"),
        (b"\x7fELF", "a program"),
    ];
    if bytes.is_empty() {
        return Some("an empty file");
    }
    let mark = MARKS.iter().find(|(mark, _)| bytes.starts_with(mark));
    mark.map(|(_, name)| *name)
        .or_else(|| is_3ds(bytes).then_some("a 3DS model"))
        .or_else(|| is_binary_stl(bytes).then_some("an STL model"))
}

/// The main chunk's id, and a length that the file has.
fn is_3ds(bytes: &[u8]) -> bool {
    match bytes {
        [b'M', b'M', a, b, c, d, ..] => {
            let length = u32::from_le_bytes([*a, *b, *c, *d]) as usize;
            (6..=bytes.len()).contains(&length)
        }
        _ => false,
    }
}

/// 80 bytes of anything, a count, and 50 bytes for each triangle.
fn is_binary_stl(bytes: &[u8]) -> bool {
    let count = bytes.get(80..84).and_then(|b| b.try_into().ok());
    count.is_some_and(|c| bytes.len() as u64 == 84 + 50 * u64::from(u32::from_le_bytes(c)))
}

/// The first word that begins a line and belongs to one format decides.
fn by_words(head: &[u8]) -> Result<Format, &'static str> {
    let mut lines = head
        .split(|b| matches!(b, b'\n' | b'\r'))
        .map(|line| line.trim_ascii())
        .filter(|line| !line.is_empty());
    if let Some(found) = lines.clone().find_map(by_line) {
        return found;
    }
    match lines.next() {
        None => Err("nothing but blanks"),
        Some(_) if head.contains(&0) => Err("binary data of no known kind"),
        Some(_) => Err("text of no known kind"),
    }
}

fn by_line(line: &[u8]) -> Option<Result<Format, &'static str>> {
    let line = line.trim_ascii_start();
    let end = |b: &u8| b.is_ascii_whitespace() || matches!(b, b'(' | b'=' | b'"' | 0);
    let word = line.split(end).next().unwrap_or_default();
    // A byte order mark or zero bytes may cling to the first word.
    let word = word.strip_prefix(b"\xef\xbb\xbf").unwrap_or(word);
    match word.to_ascii_lowercase().as_slice() {
        b"v" | b"vt" | b"vn" | b"vp" | b"f" | b"fo" | b"o" | b"g" | b"s" | b"usemtl"
        | b"mtllib" | b"p" | b"l" | b"cstype" => Some(Ok(Format::Obj)),
        b"begin" | b"mesh" | b"light" | b"include" | b"transform" | b"def" | b"params" | b"ext" => {
            Some(Ok(Format::Grf))
        }
        b"newmtl" => Some(Err("a material library (MTL); give the OBJ that names it")),
        b"solid" => Some(Err("an STL model")),
        b"section" => Some(Err("a DXF drawing")),
        b"{" => Some(Err("JSON, perhaps a glTF model")),
        _ if word.starts_with(b"<") => Some(Err("XML, perhaps an X3D or Collada model")),
        _ if word.starts_with(b"//") || word.starts_with(b";") => Some(Ok(Format::Grf)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(bytes: &[u8], expected: Result<Format, &str>) {
        let found = detect(bytes).map_err(|e| e.looks_like);
        assert_eq!(found, expected, "{}", bytes.escape_ascii());
    }

    #[test]
    fn models() {
        check(b"# a comment\r\n\r\n  v 1 2 3", Ok(Format::Obj));
        check(b"\xef\xbb\xbfmtllib a.mtl\n", Ok(Format::Obj));
        check(b"o db\r\0\0v 1 2 3", Ok(Format::Obj));
        check(b"\xfe\xff\0o\0 \x001\0\n", Ok(Format::Obj));
        check(b"what is this\nf 1 2 3", Ok(Format::Obj));
        check(b"Begin Mesh\n", Ok(Format::Grf));
        check(b"// Wannabe Amazing\n", Ok(Format::Grf));
        check(b"def a = rgb (1,1,1)", Ok(Format::Grf));
        check(b"include\"a.grf\"", Ok(Format::Grf));
        check(b"light begin", Ok(Format::Grf));
    }

    #[test]
    fn what_it_is_instead() {
        check(b"", Err("an empty file"));
        check(b" \n\t\n", Err("nothing but blanks"));
        check(b"\x89PNG\r\n\x1a\n", Err("a PNG picture"));
        check(b"\x1f\x8b\x08", Err("a gzip archive; unpack it first"));
        check(b"MM\x06\0\0\0", Err("a 3DS model"));
        check(b"MM\x07\0\0\0", Err("binary data of no known kind"));
        check(b"ply\nformat ascii 1.0", Err("a PLY model"));
        check(b"solid cube\nfacet", Err("an STL model"));
        check(&[b' '; 84].map(|_| 0), Err("an STL model"));
        check(b"{ \"asset\": {} }", Err("JSON, perhaps a glTF model"));
        check(b"glTF\x02\0\0\0", Err("a binary glTF model"));
        check(b"#VRML V2.0 utf8", Err("a VRML model"));
        check(
            b"<?xml version",
            Err("XML, perhaps an X3D or Collada model"),
        );
        check(
            b"newmtl a\nKd 1 1 1",
            Err("a material library (MTL); give the OBJ that names it"),
        );
        check(b"  0\nSECTION\n", Err("a DXF drawing"));
        check(b"Dear diary", Err("text of no known kind"));
        check(b"\x02\x00\x03", Err("binary data of no known kind"));
    }
}
