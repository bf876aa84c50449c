//! SCN, the scene description language that scn2sff translates to SFF.
//!
//! A scene is translated to SFF records, and then converted by the rules of [`sff`](crate::sff).
//! `docs/formats/scn.md` describes how every command is interpreted.

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

/// The result of reading a part of a file.
type ScnResult<T> = Result<T, ReadError>;

/// Reads a scene; `name` is used in messages, `files` provides included files, fonts, encodings,
/// data, colour maps and images.
///
/// # Errors
/// Invalid commands, and whatever [`sff::read`](crate::sff::read) rejects.
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
