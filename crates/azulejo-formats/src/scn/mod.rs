//! SCN, the language that scn2sff translated to SFF.
//!
//! A scene becomes the records of SFF and then a scene by the rules of [`sff`](crate::sff).
//! `docs/formats/scn.md` says how every command is understood.

mod attributes;
mod colors;
mod objects;
mod scope;
mod solids;
#[cfg(test)]
mod tests;
mod tokens;
mod translate;
mod values;

use crate::reading::options::Budget;
use crate::reading::warnings::Warnings;
use crate::sff::document::{SffDocument, SffSources};
use crate::sff::read_by;
use crate::{Files, Loaded, ReadError, ReadOptions};
use values::TokenStream;

/// What the readers of parts of a file return.
type ScnResult<T> = Result<T, ReadError>;

/// Reads a scene; `name` stands in messages, `files` gives what it includes, fonts, encodings, data,
/// colour maps and pictures.
///
/// # Errors
/// Commands that are not as the language has them, and whatever [`sff::read`](crate::sff::read)
/// refuses.
pub fn read(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    read_by(bytes, name, files, options, |text, sources, warnings| {
        sources.add(name, text);
        document(sources, files, options, warnings)
    })
}

/// The records that a scene translates to.
fn document(
    sources: &mut SffSources,
    files: &dyn Files,
    options: &ReadOptions,
    warnings: &mut Warnings,
) -> Result<SffDocument, ReadError> {
    let mut budget = Budget::new(options);
    let tokens = tokens::read(sources, files, &mut budget, warnings)?;
    translate::translate(TokenStream::new(&tokens, sources, warnings), &mut budget)
}
