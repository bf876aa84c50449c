//! Font files of any kind, and texts set in them.

use super::args::{AlignName, LinesArgs, TextArgs, TypefaceArgs};
use crate::failure::Failure;
use crate::session::Session;
use azulejo::models::read_bytes;
use azulejo_formats::outline::typeface::{
    FontFace, Layout, Setting, StyledText, Typeface, encoding_of, vary,
};
use azulejo_formats::outline::{TextPath, ppe, ppf, svg};
use azulejo_scene::{Encoding, Font, Line, PlacedGlyph};
use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// The content of a font file.
pub enum FontFile {
    /// RTRACE's glyphs by name.
    Ppf(Font),
    /// TrueType, OpenType or Type 1.
    Typeface(Box<Typeface>),
}

impl FontFile {
    /// Reads a font, whatever its format. A number behind the name, as in `Fonts.ttc#2`, is the index of a face.
    pub fn read(path: &Path, session: &mut Session) -> Result<FontFile, Failure> {
        let (path, face) = face_of(path);
        let bytes = read_bytes(&path)?;
        let name = path.display().to_string();
        if ppf::is_ppf(&bytes) {
            let (font, warnings) = ppf::read(&bytes, &name).map_err(Failure::failed)?;
            warnings.iter().for_each(|w| session.warn(w));
            return Ok(FontFile::Ppf(font));
        }
        let mut typeface = Typeface::read(&bytes, &name, face).map_err(Failure::failed)?;
        let metrics = ["afm", "AFM"].map(|ending| path.with_extension(ending));
        let metrics = metrics
            .iter()
            .find(|m| m.is_file())
            .filter(|_| is_type_1(&path));
        if let Some(metrics) = metrics {
            let name = metrics.display().to_string();
            let pairs = typeface.kern(&read_bytes(metrics)?, &name);
            pairs.map_err(Failure::failed)?;
        }
        Ok(FontFile::Typeface(Box::new(typeface)))
    }
}

/// Splits the index of a face off a name, unless a file has all of it as its name.
fn face_of(path: &Path) -> (PathBuf, u32) {
    let (path, face) = numbered(path);
    (path, face.unwrap_or(0))
}

/// Splits a number after `#` off a name, unless a file has all of it as its name.
pub fn numbered<T: FromStr>(path: &Path) -> (PathBuf, Option<T>) {
    let parts = path.to_str().and_then(|p| p.rsplit_once('#'));
    let parts = parts.and_then(|(file, number)| Some((file, number.parse().ok()?)));
    match parts {
        Some((file, number)) if !path.exists() => (PathBuf::from(file), Some(number)),
        _ => (path.to_owned(), None),
    }
}

fn is_type_1(path: &Path) -> bool {
    let ending = path.extension().and_then(OsStr::to_str).unwrap_or_default();
    ["pfb", "pfa", "t1"].contains(&&*ending.to_ascii_lowercase())
}

/// The names of files in a list, divided at commas; commas of a name that exists stay.
fn files(list: &[PathBuf]) -> Vec<PathBuf> {
    let names = |path: &PathBuf| match path.to_str() {
        Some(names) if !face_of(path).0.exists() => names.split(',').map(PathBuf::from).collect(),
        _ => vec![path.clone()],
    };
    list.iter().flat_map(names).collect()
}

/// Reads an encoding.
fn read_encoding(path: &Path, session: &mut Session) -> Result<Encoding, Failure> {
    let name = path.display().to_string();
    let (encoding, warnings) = ppe::read(&read_bytes(path)?, &name).map_err(Failure::failed)?;
    warnings.iter().for_each(|w| session.warn(w));
    Ok(encoding)
}

/// The fonts, and what there is to say of them.
pub struct Fonts {
    faces: Vec<FontFace>,
    /// Which instance of each variable font is used, and its axes.
    pub instances: Vec<String>,
}

impl Fonts {
    /// Reads the fonts of a command.
    pub fn read(args: &TypefaceArgs, session: &mut Session) -> Result<Fonts, Failure> {
        let paths = files(&args.font);
        let mut faces = Vec::new();
        for path in &paths {
            faces.push(match FontFile::read(path, session)? {
                FontFile::Typeface(typeface) => FontFace::Typeface(*typeface),
                FontFile::Ppf(font) => {
                    let encoding = match &args.encoding {
                        Some(path) => read_encoding(path, session)?,
                        None => encoding_of(&font),
                    };
                    FontFace::Ppf(font, encoding)
                }
            });
        }
        if args.encoding.is_some() && faces.iter().all(|f| f.typeface().is_some()) {
            let message = "--encoding is for a .ppf: other typefaces know their characters";
            return Err(Failure::misuse(message));
        }
        if !args.variation.is_empty() {
            let varied = vary(&mut faces, &args.variation);
            varied.map_err(|e| Failure::misuse(format!("--variation: {e}")))?;
        }
        note_unknown_features(args, &faces, session);
        let described = paths.iter().zip(&faces);
        let instances = described.filter_map(|(path, face)| instance(path, face.typeface()?));
        Ok(Fonts {
            instances: instances.collect(),
            faces,
        })
    }
}

/// Says which features change nothing, as no font has them.
fn note_unknown_features(args: &TypefaceArgs, faces: &[FontFace], session: &mut Session) {
    let typefaces = faces.iter().filter_map(FontFace::typeface);
    let of_each: Option<Vec<BTreeSet<String>>> = typefaces.map(Typeface::features).collect();
    let Some(of_each) = of_each else {
        return;
    };
    let known: BTreeSet<String> = of_each.into_iter().flatten().collect();
    let tags = args.features.iter().map(|feature| feature.tag());
    let unknown: Vec<String> = tags.filter(|tag| !known.contains(tag)).collect();
    if !unknown.is_empty() {
        let known: Vec<String> = known.into_iter().collect();
        let (unknown, known) = (unknown.join(", "), known.join(", "));
        session.note(&format!(
            "no font has the feature {unknown}; there are: {known}"
        ));
    }
}

/// The instance of a variable font, in words.
fn instance(path: &Path, typeface: &Typeface) -> Option<String> {
    let axes = typeface.axes();
    if axes.is_empty() {
        return None;
    }
    let axes: Vec<String> = axes.iter().map(|axis| axis.to_string()).collect();
    let name = typeface
        .instance()
        .unwrap_or_else(|| "an instance without a name".into());
    Some(format!(
        "{}: {name}; axes {}",
        path.display(),
        axes.join(", ")
    ))
}

/// Sets a text, in the units of one em.
pub fn set(
    text: &StyledText,
    fonts: &Fonts,
    args: &TextArgs,
    session: &mut Session,
) -> Result<Vec<PlacedGlyph>, Failure> {
    let LinesArgs {
        align,
        width,
        spacing,
        line_spacing,
        ..
    } = args.lines;
    let size = args.solid.size;
    let path = args
        .lines
        .path
        .as_deref()
        .map(|p| text_path(p, size))
        .transpose()?;
    let layout = Layout {
        spacing,
        width: width.map(|w| w / size),
    };
    let mut setting = Setting::new(&fonts.faces, &args.typeface.features);
    let mut lines = Vec::new();
    for (k, paragraph) in text.paragraphs().enumerate() {
        let set = setting.paragraph(paragraph, &layout);
        let fail = |e| Failure::failed(format_args!("line {} of the text: {e}", k + 1));
        lines.extend(set.map_err(fail)?);
    }
    note_losses(&setting, session);
    note_long_lines(&lines, layout.width, size, session);
    let room = path.as_ref().map(TextPath::length).or(layout.width);
    if align == AlignName::Justify {
        let expected = "--align justify needs a --width or a --path to fill";
        let room = room.ok_or_else(|| Failure::misuse(expected))?;
        // What goes along a path fills all of it.
        lines
            .iter_mut()
            .for_each(|line| line.is_broken |= path.is_some());
        lines.iter_mut().for_each(|line| line.justify(room));
    }
    match path {
        Some(path) => path.place(lines, align.align(), line_spacing).map_err(|e| {
            let file = args
                .lines
                .path
                .as_deref()
                .unwrap_or(Path::new(""))
                .display();
            Failure::failed(format_args!("{file}: {e}"))
        }),
        None => Ok(align.align().stack(lines, line_spacing)),
    }
}

/// The first path of a drawing, in ems.
fn text_path(path: &Path, size: f64) -> Result<TextPath, Failure> {
    let name = path.display().to_string();
    let segments = svg::first_path(&read_bytes(path)?, &name).map_err(Failure::failed)?;
    Ok(TextPath::new(&segments, 1.0 / size))
}

fn note_losses(setting: &Setting, session: &mut Session) {
    let blank = setting
        .blank()
        .iter()
        .map(|c| format!("`{c}` (U+{:04X})", u32::from(*c)));
    let blank: Vec<String> = blank.take(20).collect();
    if !blank.is_empty() {
        let names = blank.join(", ");
        session.note(&format!(
            "glyphs without outlines, such as pictures, are left blank: {names}"
        ));
    }
    for loss in setting.losses() {
        session.note(&format!("glyphs in colours: {loss}"));
    }
}

fn note_long_lines(lines: &[Line], width: Option<f64>, size: f64, session: &mut Session) {
    let long = |line: &&Line| width.is_some_and(|w| line.advance > (1.0 + 1e-9) * w);
    let count = lines.iter().filter(long).count();
    let longest = lines.iter().map(|line| line.advance).fold(0.0, f64::max);
    if count > 0 {
        let longest = longest * size;
        session.note(&format!(
            "{count} lines cannot be broken and are longer than --width, up to {longest:.4}"
        ));
    }
}
