//! Formats of text, recognized by the words at the start of lines.

use super::json::json_model;
use super::marks::LOOKED_AT;
use super::solvers::{is_abaqus, is_card, is_foam};
use super::{Detection, Format, PLAIN_TEXT, WHITE_SPACE};

/// The first word at the start of a line that belongs to one format decides.
pub(super) fn by_words(head: &[u8]) -> Detection {
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
    if is_foam(head) {
        return Ok(Format::OpenFoam);
    }
    if is_abaqus(lines.clone()) {
        return Ok(Format::Abaqus);
    }
    if is_idf(lines.clone()) {
        return Ok(Format::EnergyPlus);
    }
    let mut rest = lines.clone();
    while let Some(line) = rest.next() {
        let next = || first_word(rest.clone().next().unwrap_or_default());
        if let Some(format) = by_line(line, next, head) {
            return format;
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

/// Classes of EnergyPlus that nothing else has; nearly all files have several of them.
const ENERGYPLUS: [&str; 8] = [
    "GlobalGeometryRules",
    "BuildingSurface:Detailed",
    "FenestrationSurface:Detailed",
    "Wall:Detailed",
    "Wall:Exterior",
    "Zone",
    "Building",
    "SimulationControl",
];

/// Whether a name at the top of JSON is that of a class of EnergyPlus. One that is an everyday word does
/// not decide.
pub(super) fn is_energyplus(name: &[u8]) -> bool {
    let is = |class: &&str| class.len() > 8 && name.eq_ignore_ascii_case(class.as_bytes());
    ENERGYPLUS.iter().any(is)
}

/// Objects of EnergyPlus: a class, fields behind commas, and a semicolon; comments begin with `!`.
/// Statements of other languages have blanks, brackets or quotation marks before the first comma.
fn is_idf<'a>(lines: impl Iterator<Item = &'a [u8]>) -> bool {
    let mut begins = true;
    for line in lines {
        let bare = line.split(|&b| b == b'!').next().unwrap_or_default();
        let bare = bare.trim_ascii();
        if bare.is_empty() {
            continue;
        }
        if begins {
            let mut parts = bare.split(|b| matches!(b, b',' | b';'));
            let class = parts.next().unwrap_or_default().trim_ascii();
            let is_class = |c: &&str| class.eq_ignore_ascii_case(c.as_bytes());
            let has_fields = parts.next().is_some();
            if has_fields && ENERGYPLUS.iter().any(is_class) {
                return true;
            }
            let is_name = |b: &u8| b.is_ascii_alphanumeric() || matches!(b, b':' | b'-' | b'_');
            if !has_fields || !class.iter().all(is_name) || class.len() < 4 {
                return false;
            }
        }
        begins = bare.ends_with(b";");
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
        b"begin" if first_word(behind).eq_ignore_ascii_case(b"bulk") => Some(Ok(Format::Nastran)),
        _ if is_card(line) => Some(Ok(Format::Nastran)),
        lower if is_grf(lower, behind, next) => Some(Ok(Format::Grf)),
        _ if is_off(word, behind) => Some(Ok(Format::Off)),
        b"newmtl" => Some(Err("a material library (MTL); give the OBJ that names it")),
        b"solid" => Some(Ok(Format::Stl)),
        b"$meshformat" | b"$nod" => Some(Ok(Format::Gmsh)),
        _ if is_mgf(word, behind) => Some(Ok(Format::Mgf)),
        _ if line.starts_with(b"{") => Some(json_model(head)),
        _ if line.starts_with(b"<") => Some(xml_model(head)),
        _ if word.starts_with(b"//") || word.starts_with(b";") => Some(Ok(Format::Grf)),
        _ => None,
    }
}

/// The format of XML, by an element near its start or, behind a long comment, anywhere.
fn xml_model(head: &[u8]) -> Detection {
    let near = &head[..head.len().min(LOOKED_AT)];
    if holds(near, b"<VTKFile") {
        return Ok(Format::Vtk);
    }
    if holds(near, b"<X3D") || holds(head, b"<X3D") {
        return Ok(Format::Vrml);
    }
    if holds(head, b"<VTKFile") {
        return Ok(Format::Vtk);
    }
    Err("XML that is neither X3D nor VTK")
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

/// Whether a line begins OFF: its first word, and numbers, a comment or nothing behind it.
fn is_off(word: &[u8], behind: &[u8]) -> bool {
    let starts = word.strip_suffix(b"OFF").is_some_and(|kinds| {
        let kinds = kinds.strip_prefix(b"ST").unwrap_or(kinds);
        kinds.iter().all(|k| b"CN4n".contains(k)) && kinds.len() <= 4
    });
    let follows = matches!(behind.first(), None | Some(b'#' | b'0'..=b'9'));
    starts && (follows || behind.starts_with(b"BINARY"))
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

fn holds(bytes: &[u8], what: &[u8]) -> bool {
    bytes.windows(what.len()).any(|w| w == what)
}
