//! `font convert`: converts fonts to RTRACE's format.

use super::args::{FontConvertArgs, FontPart};
use super::typeface::FontFile;
use super::values::Characters;
use crate::failure::Failure;
use crate::report::{Report, count};
use crate::session::Session;
use azulejo::output::{self, Output};
use azulejo_formats::outline::typeface::{Converted, Typeface, encoding_of};
use azulejo_formats::outline::{ppe, ppf};
use std::path::Path;

/// Runs `font convert`.
pub fn run(args: &FontConvertArgs, session: &mut Session) -> Result<Report, Failure> {
    let font = Output::check(&args.output)?;
    let encoding = args.encoding.as_deref().map(Output::check).transpose()?;
    session.claim_stdout(font.is_stdout())?;
    let converted = converted(&args.font, &args.part, session)?;
    let mut drafts = Vec::new();
    if let Some(encoding) = &encoding {
        let mut draft = encoding.draft()?;
        ppe::write(&converted.encoding, &mut draft).map_err(|e| draft.error(e))?;
        drafts.push(draft);
    }
    let mut draft = font.draft()?;
    ppf::write(&converted.font, &mut draft).map_err(|e| draft.error(e))?;
    drafts.push(draft);
    output::commit(drafts, session.progress())?;
    Ok(report(args, &converted))
}

fn report(args: &FontConvertArgs, converted: &Converted) -> Report {
    let (glyphs, codes) = (converted.font.glyphs.len(), converted.encoding.names.len());
    let mut report = Report::default();
    let path = args.output.display().to_string();
    let words = format!("{path}: {} glyphs", count(glyphs));
    report.fact("output", path, "wrote", words);
    report.value("glyphs", glyphs);
    report.value("characters", codes);
    if let Some(path) = &args.encoding {
        let path = path.display().to_string();
        let words = format!("{path}: {} characters", count(codes));
        report.fact("encoding", path, "wrote", words);
    }
    report
}

/// Part of a font file as PPF; reports what could not be kept.
pub fn converted(
    path: &Path,
    part: &FontPart,
    session: &mut Session,
) -> Result<Converted, Failure> {
    let converted = match FontFile::read(path, session)? {
        FontFile::Ppf(font) => Converted {
            encoding: encoding_of(&font),
            font,
            ..Converted::default()
        },
        FontFile::Typeface(typeface) => {
            let characters = characters(&part.characters, &typeface);
            let converted = typeface.convert(characters);
            converted.map_err(|e| Failure::failed(format_args!("{}: {e}", path.display())))?
        }
    };
    let lost = |names: Vec<String>, what: &str| {
        let more = names.len().saturating_sub(SHOWN);
        let names = names[..names.len() - more].join(", ");
        let behind = if more > 0 {
            format!(" and {more} more")
        } else {
            String::new()
        };
        format!("{}: {what}: {names}{behind}", path.display())
    };
    if !converted.overlapping.is_empty() {
        let what = "overlapping contours, which become holes in PPF";
        session.note(&lost(converted.overlapping.clone(), what));
    }
    if !converted.missing.is_empty() {
        let codes = converted
            .missing
            .iter()
            .map(|c| format!("U+{:04X}", u32::from(*c)));
        session.note(&lost(codes.collect(), "no glyphs for"));
    }
    if converted.font.glyphs.is_empty() {
        let message = format!("{}: none of the characters has a glyph", path.display());
        return Err(Failure::Failed(message));
    }
    Ok(converted)
}

/// Number of names listed in a warning.
const SHOWN: usize = 20;

fn characters(characters: &Characters, typeface: &Typeface) -> Vec<char> {
    match characters {
        Characters::All => typeface.characters(),
        Characters::Ranges(ranges) => {
            let codes = ranges.iter().flat_map(|&(first, last)| first..=last);
            codes.filter_map(char::from_u32).collect()
        }
    }
}
