//! Files that stand in the place of a line of another one, as decks of simulation programs have them.

use super::cursor::TextCursor;
use super::files::open_beside;
use super::gzip;
use super::text::quoted;
use crate::{Files, Position, ReadError, ReadOptions};
use std::borrow::Cow;
use std::collections::HashSet;

/// Files that include each other more deeply are refused; NASTRAN allows 10, Abaqus 5.
const DEEPEST: usize = 20;

/// The line that includes a file.
#[derive(Clone, Copy)]
pub(crate) struct IncludeSite<'a> {
    pub text: TextCursor<'a>,
    /// The name of its file in messages.
    pub file: &'a str,
    /// That name relative to the model's folder.
    pub name: &'a str,
    /// The offset of the line.
    pub at: usize,
}

/// A file that is included.
pub(crate) struct IncludedFile {
    /// Its name relative to the model's folder.
    pub name: String,
    pub bytes: Vec<u8>,
    /// Whether it has been read before.
    pub is_repeated: bool,
}

/// The files of a deck.
pub(crate) struct IncludeStack<'a> {
    files: &'a dyn Files,
    options: &'a ReadOptions,
    /// Those that are being read, the innermost last, by their names relative to the model's folder.
    open: Vec<String>,
    read: HashSet<String>,
}

impl<'a> IncludeStack<'a> {
    pub fn new(files: &'a dyn Files, options: &'a ReadOptions) -> IncludeStack<'a> {
        IncludeStack {
            files,
            options,
            open: Vec::new(),
            read: HashSet::new(),
        }
    }

    /// Begins with the model's own file.
    pub fn begin(&mut self, file: &str) {
        let own = file.replace('\\', "/");
        let own = own.rsplit('/').next().unwrap_or_default();
        self.open.push(own.to_owned());
        self.read.insert(own.to_owned());
    }

    /// Begins with an included file; the text of a warning if it cannot be read.
    ///
    /// # Errors
    /// A file that includes itself, files that are included too deeply, and damaged compression.
    pub fn open(
        &mut self,
        path: &str,
        site: IncludeSite,
    ) -> Result<Result<IncludedFile, String>, ReadError> {
        let shown = quoted(path.as_bytes());
        let (name, bytes) = match open_beside(self.files, site.name, path) {
            Ok(file) => file,
            Err(reason) => return Ok(Err(format!("included file {shown}: {reason}; skipped"))),
        };
        let fail = |found, expected| Err(site.text.error(site.file, site.at, found, expected));
        if self.open.contains(&name) {
            let found = format!("file {shown}, which includes itself");
            return fail(found, "files that do not include each other");
        }
        if self.open.len() == DEEPEST {
            let found = format!("files included more than {DEEPEST} deep");
            return fail(found, "fewer of them");
        }
        let unpacked = match gzip::unpacked(&bytes, &name, self.options)? {
            Cow::Owned(unpacked) => Some(unpacked),
            Cow::Borrowed(_) => None,
        };
        self.open.push(name.clone());
        Ok(Ok(IncludedFile {
            is_repeated: !self.read.insert(name.clone()),
            bytes: unpacked.unwrap_or(bytes),
            name,
        }))
    }

    /// Ends the innermost file; its error gets the line that includes it.
    ///
    /// # Errors
    /// That of the file.
    pub fn close(
        &mut self,
        site: IncludeSite,
        result: Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        self.open.pop();
        result.map_err(|mut error| {
            if let Position::Line(number, _) = site.text.position(site.at) {
                let from = (site.file.to_owned(), number);
                error.included_from.insert(0, from);
            }
            error
        })
    }
}
