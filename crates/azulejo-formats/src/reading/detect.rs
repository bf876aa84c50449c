//! Recognizes the format of a file by its content rather than by its name.

use super::gzip;
use super::text::decoded;
use flate2::read::MultiGzDecoder;
use std::borrow::Cow;
use std::fmt;
use std::io::Read;

/// The model formats that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// GRanada File, azulejo's own format.
    Grf,
    /// Wavefront OBJ.
    Obj,
    /// 3D Studio (3DS).
    Studio3ds,
    /// AutoCAD drawing exchange, ASCII or binary.
    Dxf,
    /// OpenFlight.
    OpenFlight,
    /// VRML 1.0, VRML97 and X3D, in XML or in the classic encoding.
    Vrml,
    /// Materials and Geometry Format.
    Mgf,
    /// glTF 2.0, JSON or binary (GLB).
    Gltf,
    /// Stanford polygon file.
    Ply,
    /// Stereolithography, ASCII or binary.
    Stl,
    /// Scenes of RTRACE.
    Sff,
    /// The scene language from which SFF was generated.
    Scn,
    /// Input of View3D.
    View3d,
}

impl Format {
    /// The name of the format as users know it.
    pub fn name(self) -> &'static str {
        match self {
            Format::Grf => "GRF",
            Format::Obj => "Wavefront OBJ",
            Format::Studio3ds => "3DS",
            Format::Dxf => "DXF",
            Format::OpenFlight => "OpenFlight",
            Format::Vrml => "VRML or X3D",
            Format::Mgf => "MGF",
            Format::Gltf => "glTF",
            Format::Ply => "PLY",
            Format::Stl => "STL",
            Format::Sff => "SFF",
            Format::Scn => "SCN",
            Format::View3d => "View3D",
        }
    }
}

/// The error for bytes in none of the supported formats.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unrecognized {
    /// A description of what they seem to be: "a PNG picture", "text in no known format".
    pub looks_like: &'static str,
}

impl fmt::Display for Unrecognized {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "found {}, expected {EXPECTED}", self.looks_like)
    }
}

impl std::error::Error for Unrecognized {}

/// What errors list as expected.
pub(crate) const EXPECTED: &str =
    "a model in 3DS, DXF, glTF, GRF, MGF, OBJ, OpenFlight, PLY, SCN, SFF, STL, View3D, VRML or X3D";

/// Recognizes the format of a model by its content or, if that is ambiguous, by its file name.
///
/// # Errors
/// As [`detect`].
pub fn recognize(bytes: &[u8], name: &str) -> Result<Format, Unrecognized> {
    by_extension(name, detect(bytes))
}

/// A format without magic bytes or keywords is recognized by the file name, unless the content
/// contradicts it.
fn by_extension(
    name: &str,
    detected: Result<Format, Unrecognized>,
) -> Result<Format, Unrecognized> {
    let lower = name.to_ascii_lowercase();
    let name = lower.strip_suffix(".gz").unwrap_or(&lower);
    match &detected {
        // A list of no blocks; a file without a byte is rather one that could not be written.
        Err(e) if e.looks_like == WHITE_SPACE && name.ends_with(".grf") => Ok(Format::Grf),
        Err(e) if e.looks_like == PLAIN_TEXT && name.ends_with(".sff") => Ok(Format::Sff),
        Err(e) if e.looks_like == PLAIN_TEXT && name.ends_with(".scn") => Ok(Format::Scn),
        // A single letter begins a line in several formats.
        Err(e) if e.looks_like == PLAIN_TEXT && name.ends_with(".vs3") => Ok(Format::View3d),
        Ok(Format::Grf | Format::Mgf | Format::Obj | Format::Scn) if name.ends_with(".vs3") => {
            Ok(Format::View3d)
        }
        // Words that several languages share, and comments after a semicolon.
        Ok(Format::Grf | Format::Mgf | Format::Obj) if name.ends_with(".scn") => Ok(Format::Scn),
        _ => detected,
    }
}

/// Description of text without a keyword of any format.
const PLAIN_TEXT: &str = "text in no known format";

/// Description of text without a word.
const WHITE_SPACE: &str = "only white space";

/// Bytes of a file that are examined for magic bytes, and decompressed for its words.
const LOOKED_AT: usize = 1 << 16;

/// Most bytes that are decompressed to get past a long comment.
const MOST_UNPACKED: u64 = 1 << 24;

/// Recognizes the format of a model, compressed with gzip or not.
///
/// # Errors
/// [`Unrecognized`], which names the actual format if it is well known.
pub fn detect(bytes: &[u8]) -> Result<Format, Unrecognized> {
    let start = unpacked_start(bytes);
    let found = match known_mark(&start) {
        Some(found) => found,
        // The whole file: a comment at its start may be of any length.
        None => by_words(&decoded(&start)),
    };
    found.map_err(|looks_like| Unrecognized { looks_like })
}

/// The bytes, or the first of their decompressed bytes.
fn unpacked_start(bytes: &[u8]) -> Cow<'_, [u8]> {
    if !gzip::is_gzip(bytes) {
        return Cow::Borrowed(bytes);
    }
    let mut start = Vec::new();
    // What could be decompressed before the damage is enough to recognize the format.
    let _ = MultiGzDecoder::new(bytes)
        .take(MOST_UNPACKED)
        .read_to_end(&mut start);
    Cow::Owned(start)
}

type Detection = Result<Format, &'static str>;

/// Formats that begin with magic bytes.
fn known_mark(bytes: &[u8]) -> Option<Detection> {
    use Format::*;
    const MARKS: [(&[u8], Detection); 27] = [
        (b"\x89PNG", Err("a PNG picture")),
        (b"\xff\xd8\xff", Err("a JPEG picture")),
        (b"GIF8", Err("a GIF picture")),
        (b"\x76\x2f\x31\x01", Err("an OpenEXR picture")),
        (b"#?RADIANCE", Err("a Radiance picture")),
        (b"IESNA", Err("an IES luminaire; name it in an MGF scene")),
        (
            b"IES:LM-63",
            Err("an IES luminaire; name it in an MGF scene"),
        ),
        (b"PK\x03\x04", Err("a zip archive; unpack it first")),
        (b"%PDF", Err("a PDF document")),
        (b"BLENDER", Err("a Blender file; export it as glTF")),
        (b"Kaydara FBX", Err("an FBX model; export it as glTF")),
        (b"AC10", Err("a DWG drawing; export it as DXF")),
        (b"OFF\n", Err("an OFF model")),
        (b"; FBX", Err("an FBX model; export it as glTF")),
        (b"//Maya ASCII", Err("a Maya scene; export it as glTF")),
        (b"ISO-10303-21;", Err("a STEP or IFC model")),
        (b"#usda", Err("a USD scene; export it as glTF")),
        (b"\x7fELF", Err("a program")),
        (b"AutoCAD Binary DXF", Ok(Dxf)),
        (b"glTF", Ok(Gltf)),
        (b"ply\n", Ok(Ply)),
        (b"ply\r", Ok(Ply)),
        (b"ply ", Ok(Ply)),
        (b"#VRML", Ok(Vrml)),
        (b"#X3D", Ok(Vrml)),
        (b"#Inventor V1.0 ascii", Ok(Vrml)),
        (b"#Inventor V2", Ok(Vrml)),
    ];
    if bytes.is_empty() {
        return Some(Err("an empty file"));
    }
    let text = decoded(&bytes[..bytes.len().min(LOOKED_AT)]);
    let mark = MARKS.iter().find(|(mark, _)| text.starts_with(mark));
    mark.map(|(_, found)| *found)
        .or_else(|| is_openflight(bytes).then_some(Ok(OpenFlight)))
        .or_else(|| is_3ds(bytes).then_some(Ok(Studio3ds)))
        .or_else(|| is_binary_stl(bytes).then_some(Ok(Stl)))
        .or_else(|| is_tiff(bytes).then_some(Err("a TIFF picture")))
}

/// A header record: opcode 1 and a length that occurs in some revision.
fn is_openflight(bytes: &[u8]) -> bool {
    matches!(bytes, [0, 1, high, low, ..]
        if (128..=1024).contains(&u16::from_be_bytes([*high, *low])))
}

/// The main chunk, followed by a chunk that may come first in it.
fn is_3ds(bytes: &[u8]) -> bool {
    let first = |at: usize| Some(u16::from_le_bytes([*bytes.get(at)?, *bytes.get(at + 1)?]));
    first(0) == Some(0x4d4d) && matches!(first(6), None | Some(0x0002 | 0x3d3d | 0x3d3e | 0xb000))
}

/// Either byte order; behind 3DS, with which one of them shares its first bytes.
fn is_tiff(bytes: &[u8]) -> bool {
    bytes.starts_with(b"MM\0*") || bytes.starts_with(b"II*\0")
}

/// 80 arbitrary bytes, a count, and 50 bytes for each triangle. Some writers append a few bytes,
/// some begin the 80 bytes like the text format, and a few used the other byte order.
fn is_binary_stl(bytes: &[u8]) -> bool {
    let length = bytes.len() as u64;
    let expected = |count: u32| 84 + 50 * u64::from(count);
    let fits = |e: u64| e == length || (e > 84 && e < length && length - e < 50);
    let count = bytes.get(80..84).and_then(|b| b.try_into().ok());
    count.is_some_and(|c| {
        fits(expected(u32::from_le_bytes(c))) || expected(u32::from_be_bytes(c)) == length
    })
}

/// The first word at the start of a line that belongs to one format decides.
fn by_words(head: &[u8]) -> Detection {
    let mut lines = head
        .split(|b| matches!(b, b'\n' | b'\r'))
        .map(|line| line.trim_ascii())
        .filter(|line| !line.is_empty());
    if is_sff(lines.clone()) {
        return Ok(Format::Sff);
    }
    if is_dxf(lines.clone()) {
        return Ok(Format::Dxf);
    }
    if is_view3d(lines.clone()) {
        return Ok(Format::View3d);
    }
    let mut rest = lines.clone();
    while let Some(line) = rest.next() {
        let next = || first_word(rest.clone().next().unwrap_or_default());
        if let Some(found) = by_line(line, next, head) {
            return found;
        }
    }
    // `o` and `p` are keywords of OBJ and of MGF; OBJ is more likely.
    if lines.clone().any(|l| matches!(first_word(l), b"o" | b"p")) {
        return Ok(Format::Obj);
    }
    match lines.next() {
        None => Err(WHITE_SPACE),
        Some(_) if head.contains(&0) => Err("binary data in no known format"),
        Some(_) => Err(PLAIN_TEXT),
    }
}

/// Pairs of lines with a group code and a value; the first pair after comments begins a section.
fn is_dxf<'a>(mut lines: impl Iterator<Item = &'a [u8]>) -> bool {
    while let (Some(code), Some(value)) = (lines.next(), lines.next()) {
        match code {
            b"999" => {}
            b"0" => return value.eq_ignore_ascii_case(b"SECTION"),
            _ => return false,
        }
    }
    false
}

/// Records of View3D: a geometry, which is one word, or a control line of pairs, before the first
/// numbered vertex or surface. Faces of OBJ have three or more words, and colours of MGF a name.
fn is_view3d<'a>(lines: impl Iterator<Item = &'a [u8]>) -> bool {
    let words = |line: &'a [u8]| {
        let words = line.split(|b| matches!(b, b' ' | b'\t' | b','));
        words
            .filter(|w| !w.is_empty())
            .take_while(|w| !w.starts_with(b"!"))
    };
    let is_number = |word: &[u8]| word.iter().all(u8::is_ascii_digit);
    let mut says_so = false;
    for line in lines.filter(|l| !l.starts_with(b"!") && !l.starts_with(b"/")) {
        let mut words = words(line);
        let (first, second) = (
            words.next().unwrap_or_default(),
            words.next().unwrap_or_default(),
        );
        match first.to_ascii_uppercase().as_slice() {
            b"T" => {}
            b"F" => says_so = matches!(second, b"3" | b"3a" | b"3A") && words.next().is_none(),
            b"C" => says_so |= second.contains(&b'=') && !second.starts_with(b"="),
            b"V" | b"S" | b"M" | b"N" | b"O" => return says_so && is_number(second),
            _ => return false,
        }
    }
    false
}

/// Section titles, which may be anything but numbers, and the least count of numbers on the lines
/// between them: eye, target, up and angles; background and ambient light.
fn is_sff<'a>(lines: impl Iterator<Item = &'a [u8]>) -> bool {
    let is_number = |word: &[u8]| std::str::from_utf8(word).is_ok_and(|w| w.parse::<f64>().is_ok());
    let numbers = |line: &[u8]| {
        let words = line
            .split(u8::is_ascii_whitespace)
            .filter(|w| !w.is_empty());
        words.take_while(|w| is_number(w)).count()
    };
    let mut lines = lines.filter(|l| !l.starts_with(b"#"));
    let mut next = || lines.next().map(numbers);
    [0, 3, 3, 3, 2, 0, 3, 3].map(|least| match least {
        0 => next() == Some(0),
        _ => next().is_some_and(|n| n >= least),
    }) == [true; 8]
}

/// A command of SCN: its keyword, which other languages may share, and what follows it.
fn is_scn(word: &[u8], line: &[u8]) -> bool {
    let behind = first_word(line[word.len()..].trim_ascii_start());
    let names_one = || {
        let rest = line[word.len()..].trim_ascii_start()[behind.len()..].trim_ascii();
        !behind.is_empty() && matches!(rest.first(), None | Some(b'%' | b';' | b'#'))
    };
    let is_number = is_number(behind);
    match word {
        b"eye" | b"from" | b"look" | b"at" | b"fov" => is_number,
        b"background" | b"ambient" => is_number || behind == b"mono" || names_one(),
        b"light" => {
            let kinds = [
                "point",
                "directional",
                "dir",
                "spot",
                "extended",
                "ext",
                "linear",
                "planar",
            ];
            kinds.iter().any(|k| k.as_bytes() == behind)
        }
        b"csg" => matches!(
            behind,
            b"union" | b"subtraction" | b"difference" | b"intersection"
        ),
        b"sphere" | b"box" | b"cube" | b"cylinder" | b"disc" | b"wedge" | b"tetra" => {
            is_number || matches!(behind, b"surface" | b"transform" | b"open")
        }
        b"surface" => {
            let forms = [
                "matte",
                "plastic",
                "metal",
                "metallic",
                "strauss",
                "glass",
                "dielectric",
            ];
            forms.iter().any(|form| form.as_bytes() == behind)
        }
        b"text3d" => behind == b"file",
        _ => false,
    }
}

fn first_word(line: &[u8]) -> &[u8] {
    let end = |b: &u8| b.is_ascii_whitespace() || matches!(b, b'(' | b'=' | b'"' | 0);
    line.split(end).next().unwrap_or_default()
}

/// The format that a line belongs to, if it decides; `next` is the first word of the next line.
fn by_line<'a>(line: &[u8], next: impl Fn() -> &'a [u8], head: &[u8]) -> Option<Detection> {
    // Zero bytes may be attached to the first word.
    let zeros = line.iter().take_while(|b| **b == 0).count();
    let line = &line[zeros..];
    let word = first_word(line);
    if is_scn(word, line) {
        return Some(Ok(Format::Scn));
    }
    let behind = line[word.len()..].trim_ascii_start();
    match word.to_ascii_lowercase().as_slice() {
        // A vertex of OBJ begins with a number, in MGF it has a name.
        b"v" | b"f" if is_number(first_word(behind)) => Some(Ok(Format::Obj)),
        b"vt" | b"vn" | b"vp" | b"fo" | b"g" | b"s" | b"usemtl" | b"mtllib" | b"l" | b"cstype" => {
            Some(Ok(Format::Obj))
        }
        b"begin" if first_word(behind).eq_ignore_ascii_case(b"bulk") => {
            Some(Err("a Nastran model"))
        }
        lower if is_grf(lower, behind, next) => Some(Ok(Format::Grf)),
        b"newmtl" => Some(Err("a material library (MTL); give the OBJ that names it")),
        b"solid" => Some(Ok(Format::Stl)),
        _ if is_mgf(word, behind) => Some(Ok(Format::Mgf)),
        _ if line.starts_with(b"{") => Some(json_model(head)),
        _ if line.starts_with(b"<") => Some(if holds(head, b"<X3D") {
            Ok(Format::Vrml)
        } else {
            Err("XML that is not X3D")
        }),
        _ if word.starts_with(b"//") || word.starts_with(b";") => Some(Ok(Format::Grf)),
        _ => None,
    }
}

/// Whether a word begins as a number does, or is one that is not finite.
fn is_number(word: &[u8]) -> bool {
    let unsigned = word.strip_prefix(b"+").or(word.strip_prefix(b"-"));
    let unsigned = unsigned.unwrap_or(word).to_ascii_lowercase();
    let starts = matches!(word, [b'+' | b'-' | b'.' | b'0'..=b'9', ..]);
    starts || matches!(unsigned.as_slice(), b"nan" | b"inf" | b"infinity")
}

/// Whether a line begins a block of GRF: its first word in lower case, and what is behind it or, if that
/// is nothing or a comment, the first word of the next line.
fn is_grf<'a>(word: &[u8], behind: &[u8], next: impl Fn() -> &'a [u8]) -> bool {
    let is_end = behind.is_empty() || behind.starts_with(b"//");
    let second = if is_end { next() } else { first_word(behind) };
    let is_followed_by = |words: &[&[u8]]| {
        let is_comment = is_end && (second.is_empty() || second.starts_with(b"//"));
        is_comment || words.iter().any(|w| w.eq_ignore_ascii_case(second))
    };
    match word {
        b"begin" => is_followed_by(&[b"mesh"]),
        b"mesh" => is_followed_by(&[b"light", b"begin", b"use"]),
        b"light" => is_followed_by(&[b"begin", b"rgb"]) || behind.starts_with(b"("),
        b"transform" => is_followed_by(&[b"scale", b"rotation", b"translation", b"begin"]),
        b"params" => is_followed_by(&[b"begin"]),
        // Those of Nastran and other languages have single quotes or none.
        b"include" => !is_end && !behind.starts_with(b"'") && !behind.starts_with(b"<"),
        b"def" => !behind.starts_with(b"="),
        b"ext" => true,
        _ => false,
    }
}

/// Whether a line is a statement of MGF, whose keywords are in lower case and often single letters: as
/// the first word of a sentence they must not decide.
fn is_mgf(word: &[u8], behind: &[u8]) -> bool {
    let mut words = behind
        .split(u8::is_ascii_whitespace)
        .filter(|w| !w.is_empty());
    let (first, second) = (words.next(), words.next());
    let is_name = |word: &[u8]| word.first().is_some_and(u8::is_ascii_graphic);
    match word {
        // A name, and behind `=` another one or nothing.
        b"v" | b"c" | b"m" => matches!(second, None | Some(b"=")),
        b"f" | b"fh" | b"cyl" | b"prism" | b"ring" | b"sph" | b"torus" | b"cone" => {
            first.is_some_and(is_name)
        }
        b"cxy" | b"cspec" | b"cct" | b"cmix" | b"rd" | b"td" | b"ed" | b"rs" | b"ts" | b"ir" => {
            first.is_some_and(is_number)
        }
        b"sides" => first.is_some_and(is_number),
        b"xf" => first.is_some_and(|w| w.starts_with(b"-")),
        // A file, and a transform.
        b"i" | b"ies" => first.is_some_and(is_name) && second.is_none_or(|w| w.starts_with(b"-")),
        _ => false,
    }
}

/// The format of JSON, by the names at its top level.
fn json_model(bytes: &[u8]) -> Detection {
    // glTF without `asset` is for its reader to refuse.
    const GLTF: [&[u8]; 6] = [
        b"asset",
        b"scenes",
        b"nodes",
        b"meshes",
        b"accessors",
        b"buffers",
    ];
    let mut found = Err("JSON that is not glTF");
    for name in TopLevelNames::new(bytes) {
        match name {
            b"CityObjects" => return Err("a CityJSON model"),
            b"asset" => return Ok(Format::Gltf),
            _ if GLTF.contains(&name) => found = Ok(Format::Gltf),
            _ => {}
        }
    }
    found
}

/// The names of the outermost object of JSON, which need not be well-formed.
struct TopLevelNames<'a> {
    bytes: &'a [u8],
    at: usize,
    depth: u32,
}

impl<'a> TopLevelNames<'a> {
    fn new(bytes: &'a [u8]) -> TopLevelNames<'a> {
        TopLevelNames {
            bytes,
            at: 0,
            depth: 0,
        }
    }

    /// The text in quotes that begins at the current byte, which is passed.
    fn quoted(&mut self) -> Option<&'a [u8]> {
        let start = self.at + 1;
        let mut end = start;
        while *self.bytes.get(end)? != b'"' {
            end += if self.bytes[end] == b'\\' { 2 } else { 1 };
        }
        self.at = end + 1;
        self.bytes.get(start..end)
    }
}

impl<'a> Iterator for TopLevelNames<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        loop {
            match *self.bytes.get(self.at)? {
                b'{' | b'[' => self.depth += 1,
                b'}' | b']' => self.depth = self.depth.saturating_sub(1),
                b'"' => {
                    let text = self.quoted()?;
                    let behind = self.bytes[self.at..].iter();
                    let next = behind.copied().find(|b| !b.is_ascii_whitespace());
                    if self.depth == 1 && next == Some(b':') {
                        return Some(text);
                    }
                    continue;
                }
                _ => {}
            }
            self.at += 1;
        }
    }
}

fn holds(bytes: &[u8], what: &[u8]) -> bool {
    bytes.windows(what.len()).any(|w| w == what)
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::write::GzEncoder;
    use std::io::Write;

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
        check(b"MM\x06\0\0\0", Ok(Format::Studio3ds));
        check(b"MM\xff\0\0\0\x02\0", Ok(Format::Studio3ds));
        check(b"\0\x01\x01\x44TheHeader", Ok(Format::OpenFlight));
        check(b"ply\nformat ascii 1.0", Ok(Format::Ply));
        check(b"solid cube\nfacet", Ok(Format::Stl));
        check(&[b' '; 84].map(|_| 0), Ok(Format::Stl));
        check(b"{ \"asset\": {} }", Ok(Format::Gltf));
        check(b"{\"asset\":{}}", Ok(Format::Gltf));
        check(b"glTF\x02\0\0\0", Ok(Format::Gltf));
        check(b"#VRML V2.0 utf8", Ok(Format::Vrml));
        check(
            b"<?xml version='1.0'?>\n<X3D profile='Full'>",
            Ok(Format::Vrml),
        );
        check(b"  0\nSECTION\n", Ok(Format::Dxf));
        check(b"999\nv 1 2 3\n0\nSECTION\n", Ok(Format::Dxf));
        check(b"AutoCAD Binary DXF\r\n\x1a\0", Ok(Format::Dxf));
        check(b"# a room\nm white =\n", Ok(Format::Mgf));
        check(b"o room\nv a =\n\tp 1 2 3\n", Ok(Format::Mgf));
        check(b"o cube\no cube\n", Ok(Format::Obj));
        check(
            b"view\n1 1 5 - eye\n0 0 0\n0 1 0\n30 30\nlight\n0 0 0\n1 1 1\nlights\n",
            Ok(Format::Sff),
        );
        check(
            b"% a scene\nlight point 4 3 1\nsphere 0 0 0 1",
            Ok(Format::Scn),
        );
        check(b"eye 5 2 2\n", Ok(Format::Scn));
        check(b"background light_sky_blue\n", Ok(Format::Scn));
        check(b"csg subtraction begin\n", Ok(Format::Scn));
    }

    #[test]
    fn words_decide_only_where_they_are_statements() {
        // Numbers that are not finite are for the reader to refuse.
        for number in ["nan", "-NaN", "inf", "+Infinity", ".5", "-1"] {
            let line = format!("v {number} 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
            check(line.as_bytes(), Ok(Format::Obj));
        }
        check(b"v nano =\n p 1 2 3", Ok(Format::Mgf));
        check(b"v info\nm dark\n", Ok(Format::Mgf));
        check(b"i \"a b.mgf\"\n", Err("text in no known format"));
        check(b"i lamp.mgf -t 0 0 1 -a 3 -rz 5", Ok(Format::Mgf));
        check(b"ies lamp.ies -m 2", Ok(Format::Mgf));
        check(b"rd .5\n", Ok(Format::Mgf));
        check(b"I am a letter.\n", Err("text in no known format"));
        check(b"c'est la vie\n", Err("text in no known format"));
        // Nastran, in which a deck of cards begins like a mesh.
        let deck = b"$ a deck\nSOL 101\nCEND\nBEGIN BULK\nGRID,1,,0.,0.,0.\nENDDATA\n";
        check(deck, Err("a Nastran model"));
        check(b"INCLUDE 'a.bdf'\nGRID,1\n", Err("text in no known format"));
        check(b"begin\n// a comment\nmesh\n", Ok(Format::Grf));
        check(b"begin // one\n", Ok(Format::Grf));
        check(b"begin reading here\n", Err("text in no known format"));
        check(b"light (0,0,0) (1,0,0) (0,1,0) end light", Ok(Format::Grf));
        check(b"light reading\n", Err("text in no known format"));
        check(b"transform\nscale (1,1,1)", Ok(Format::Grf));
    }

    #[test]
    fn json_is_told_by_its_names() {
        check(
            b"{\"type\": \"CityJSON\", \"CityObjects\": {\"asset\": 1}}",
            Err("a CityJSON model"),
        );
        check(
            b"{\"type\": \"FeatureCollection\", \"features\": []}",
            Err("JSON that is not glTF"),
        );
        check(
            b"{\"a\": [{\"asset\": 1}], \"\\\"asset\": 2}",
            Err("JSON that is not glTF"),
        );
        check(
            b"{\"extras\": {\"CityObjects\": []},\n\"asset\"\n: {}}",
            Ok(Format::Gltf),
        );
        check(b"{\"scenes\": [", Ok(Format::Gltf));
        check(b"{\"asset", Err("JSON that is not glTF"));
    }

    /// Comments at the start, of every format that has them.
    #[test]
    fn comments_may_be_of_any_length() {
        let long = |start: &str, end: &str| {
            let line = format!("{start} v of a long comment {end}\n");
            line.repeat(3 * LOOKED_AT / line.len())
        };
        for (comment, model, format) in [
            (long("#", ""), "v 1 2 3\n", Format::Obj),
            (long("#", ""), "v a =\n p 1 2 3\n", Format::Mgf),
            (long("//", ""), "begin mesh\n", Format::Grf),
            (long("999\n", ""), "0\nSECTION\n", Format::Dxf),
            (long("!", ""), "F 3\nV 1 0 0 0\n", Format::View3d),
            (long("%", ""), "sphere 0 0 0 1\n", Format::Scn),
            (long("<!--", "-->"), "<X3D>", Format::Vrml),
            ("\n".repeat(2 * LOOKED_AT), "v 1 2 3\n", Format::Obj),
        ] {
            let text = comment + model;
            check(text.as_bytes(), Ok(format));
            let mut packer = GzEncoder::new(Vec::new(), flate2::Compression::fast());
            packer.write_all(text.as_bytes()).unwrap();
            check(&packer.finish().unwrap(), Ok(format));
        }
    }

    #[test]
    fn white_space_is_a_scene_without_blocks() {
        assert_eq!(recognize(b"\n", "a.grf"), Ok(Format::Grf));
        assert!(recognize(b"", "a.grf").is_err() && recognize(b"\n", "a.obj").is_err());
    }

    #[test]
    fn other_formats_are_named() {
        check(b"MM\0*\0\0\0\x08", Err("a TIFF picture"));
        check(
            b"; FBX 7.3.0 project file\n",
            Err("an FBX model; export it as glTF"),
        );
        check(b"ISO-10303-21;\nHEADER;\n", Err("a STEP or IFC model"));
        check(b"", Err("an empty file"));
        check(b" \n\t\n", Err("only white space"));
        check(b"\x89PNG\r\n\x1a\n", Err("a PNG picture"));
        check(b"\x1f\x8b\x08", Err("an empty file"));
        check(
            b"MM\x07\0\0\0\x01\x01",
            Err("binary data in no known format"),
        );
        check(
            b"<?xml version='1.0'?>\n<COLLADA/>",
            Err("XML that is not X3D"),
        );
        check(
            b"newmtl a\nKd 1 1 1",
            Err("a material library (MTL); give the OBJ that names it"),
        );
        check(b"Dear diary", Err("text in no known format"));
        check(b"\x02\x00\x03", Err("binary data in no known format"));
    }
}
