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

/// Bytes of a file that are examined: enough to get past a long comment at its start.
const LOOKED_AT: usize = 1 << 16;

/// Recognizes the format of a model, compressed with gzip or not.
///
/// # Errors
/// [`Unrecognized`], which names the actual format if it is well known.
pub fn detect(bytes: &[u8]) -> Result<Format, Unrecognized> {
    let start = unpacked_start(bytes);
    let found = match known_mark(&start) {
        Some(found) => found,
        None => by_words(&decoded(&start[..start.len().min(LOOKED_AT)])),
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
        .take(LOOKED_AT as u64)
        .read_to_end(&mut start);
    Cow::Owned(start)
}

type Detection = Result<Format, &'static str>;

/// Formats that begin with magic bytes.
fn known_mark(bytes: &[u8]) -> Option<Detection> {
    use Format::*;
    const MARKS: [(&[u8], Detection); 22] = [
        (b"\x89PNG", Err("a PNG picture")),
        (b"\xff\xd8\xff", Err("a JPEG picture")),
        (b"GIF8", Err("a GIF picture")),
        (b"\x76\x2f\x31\x01", Err("an OpenEXR picture")),
        (b"#?RADIANCE", Err("a Radiance picture")),
        (b"IESNA", Err("an IES luminaire; name it in an MGF scene")),
        (b"PK\x03\x04", Err("a zip archive; unpack it first")),
        (b"%PDF", Err("a PDF document")),
        (b"BLENDER", Err("a Blender file; export it as glTF")),
        (b"Kaydara FBX", Err("an FBX model; export it as glTF")),
        (b"AC10", Err("a DWG drawing; export it as DXF")),
        (b"OFF\n", Err("an OFF model")),
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
    if let Some(found) = lines.clone().find_map(|line| by_line(line, head)) {
        return found;
    }
    // `o` and `p` are keywords of OBJ and of MGF; OBJ is more likely.
    if lines.clone().any(|l| matches!(first_word(l), b"o" | b"p")) {
        return Ok(Format::Obj);
    }
    match lines.next() {
        None => Err("only white space"),
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
    let is_number = matches!(behind, [b'+' | b'-' | b'.' | b'0'..=b'9', ..]);
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

fn by_line(line: &[u8], head: &[u8]) -> Option<Detection> {
    // Zero bytes may be attached to the first word.
    let zeros = line.iter().take_while(|b| **b == 0).count();
    let line = &line[zeros..];
    let word = first_word(line);
    if is_scn(word, line) {
        return Some(Ok(Format::Scn));
    }
    match word.to_ascii_lowercase().as_slice() {
        // A vertex of OBJ begins with a number, in MGF it has a name.
        b"v" | b"f" => Some(Ok(match line[1..].trim_ascii_start() {
            [b'+' | b'-' | b'.' | b'0'..=b'9', ..] => Format::Obj,
            _ => Format::Mgf,
        })),
        b"vt" | b"vn" | b"vp" | b"fo" | b"g" | b"s" | b"usemtl" | b"mtllib" | b"l" | b"cstype" => {
            Some(Ok(Format::Obj))
        }
        b"m" | b"c" | b"cxy" | b"cspec" | b"cct" | b"cmix" | b"rd" | b"td" | b"ed" | b"rs"
        | b"ts" | b"ir" | b"sides" | b"sph" | b"cyl" | b"cone" | b"prism" | b"torus" | b"ring"
        | b"fh" | b"xf" | b"ies" | b"i" => Some(Ok(Format::Mgf)),
        b"begin" | b"mesh" | b"light" | b"include" | b"transform" | b"def" | b"params" | b"ext" => {
            Some(Ok(Format::Grf))
        }
        b"newmtl" => Some(Err("a material library (MTL); give the OBJ that names it")),
        b"solid" => Some(Ok(Format::Stl)),
        _ if line.starts_with(b"{") => Some(Ok(Format::Gltf)),
        _ if line.starts_with(b"<") => Some(if holds(head, b"<X3D") {
            Ok(Format::Vrml)
        } else {
            Err("XML that is not X3D")
        }),
        _ if word.starts_with(b"//") || word.starts_with(b";") => Some(Ok(Format::Grf)),
        _ => None,
    }
}

fn holds(bytes: &[u8], what: &[u8]) -> bool {
    bytes.windows(what.len()).any(|w| w == what)
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
    fn other_formats_are_named() {
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
