//! Font files of any kind, and lines set in them.

use super::args::{LinesArgs, TypefaceArgs};
use crate::failure::Failure;
use crate::session::Session;
use azulejo::models::read_bytes;
use azulejo_formats::outline::typeface::{Typeface, encoding_of};
use azulejo_formats::outline::{ppe, ppf};
use azulejo_scene::{Encoding, Font, Line, PlacedGlyph};
use std::path::Path;

/// The content of a font file.
pub enum FontFile {
    /// RTRACE's glyphs by name.
    Ppf(Font),
    /// TrueType, OpenType or Type 1.
    Typeface(Typeface),
}

impl FontFile {
    /// Reads a font, whatever its format.
    pub fn read(path: &Path, face: u32, session: &mut Session) -> Result<FontFile, Failure> {
        let bytes = read_bytes(path)?;
        let name = path.display().to_string();
        if !ppf::is_ppf(&bytes) {
            let typeface = Typeface::read(&bytes, &name, face).map_err(Failure::failed)?;
            return Ok(FontFile::Typeface(typeface));
        }
        if face > 0 {
            return Err(Failure::misuse("a .ppf has one face, expected --face 0"));
        }
        let (font, warnings) = ppf::read(&bytes, &name).map_err(Failure::failed)?;
        warnings.iter().for_each(|w| session.warn(w));
        Ok(FontFile::Ppf(font))
    }
}

/// Reads an encoding.
pub fn read_encoding(path: &Path, session: &mut Session) -> Result<Encoding, Failure> {
    let name = path.display().to_string();
    let (encoding, warnings) = ppe::read(&read_bytes(path)?, &name).map_err(Failure::failed)?;
    warnings.iter().for_each(|w| session.warn(w));
    Ok(encoding)
}

/// Sets all lines of a text, in the units of one em.
pub fn set(
    text: &str,
    args: &TypefaceArgs,
    lines: &LinesArgs,
    session: &mut Session,
) -> Result<Vec<PlacedGlyph>, Failure> {
    let font = FontFile::read(&args.font, args.face, session)?;
    let placed: Vec<Line> = match (&font, &args.encoding) {
        (FontFile::Ppf(font), encoding) => {
            let encoding = match encoding {
                Some(path) => read_encoding(path, session)?,
                None => encoding_of(font),
            };
            let set = |line: &str| font.set_line(line, &encoding, lines.spacing);
            each_line(text, set)?
        }
        (FontFile::Typeface(_), Some(_)) => {
            let message = "--encoding is for a .ppf: other typefaces know their characters";
            return Err(Failure::misuse(message));
        }
        (FontFile::Typeface(typeface), None) => {
            let mut setting = typeface.setting();
            each_line(text, |line| setting.line(line, lines.spacing))?
        }
    };
    Ok(lines.align.align().stack(placed, lines.line_spacing))
}

/// Sets line by line; an error contains the number of its line.
fn each_line<E: std::fmt::Display>(
    text: &str,
    mut set: impl FnMut(&str) -> Result<Line, E>,
) -> Result<Vec<Line>, Failure> {
    let numbered = text.lines().enumerate();
    let set = |(i, line)| {
        set(line).map_err(|e| Failure::failed(format_args!("line {} of the text: {e}", i + 1)))
    };
    numbered.map(set).collect()
}
