//! Reads the lines of a file and of those that it includes.

use super::assembly::AbaqusAssembly;
use super::data::DataBlock;
use super::keyword::{InputLines, KeywordLine};
use super::part::AbaqusModel;
use crate::reading::cursor::{LineCounter, TextCursor};
use crate::reading::files::open_beside;
use crate::reading::gzip;
use crate::reading::options::{Budget, check_length};
use crate::reading::text::{decoded, quoted};
use crate::reading::warnings::Warnings;
use crate::{Files, Loaded, Position, ReadError, ReadOptions};
use std::collections::HashSet;

/// Files that include each other more deeply are refused; Abaqus allows 5.
const DEEPEST: usize = 20;

/// Bytes of a file that count as one element if it is included again.
const BYTES_PER_ELEMENT: u64 = 8;

/// A file that is being read.
pub(super) struct InputSource<'a> {
    pub text: TextCursor<'a>,
    /// Its name in messages.
    pub file: &'a str,
    /// Its name relative to the model's folder.
    name: &'a str,
    /// Index among all files.
    number: u32,
    lines: LineCounter,
}

impl InputSource<'_> {
    /// File and line of an offset, which must not be before that of the call before.
    pub fn place(&mut self, at: usize) -> (u32, u32) {
        (self.number, self.lines.at(self.text.bytes(), at))
    }

    /// An error at an offset.
    pub fn error(&self, at: usize, found: impl Into<String>, expected: &str) -> ReadError {
        self.text.error(self.file, at, found, expected)
    }
}

/// Reads input of Abaqus.
pub(super) struct AbaqusReader<'a> {
    files: &'a dyn Files,
    options: &'a ReadOptions,
    budget: Budget,
    warnings: Warnings,
    pub model: AbaqusModel,
    /// Index of the part that is being read.
    pub scope: usize,
    /// What the data lines are.
    pub block: DataBlock,
    /// The first keyword that says nothing of geometry.
    pub first_other: Option<String>,
    /// The files that are being read, by their names relative to the model's folder.
    open: Vec<String>,
    read: HashSet<String>,
}

impl<'a> AbaqusReader<'a> {
    pub fn new(files: &'a dyn Files, options: &'a ReadOptions) -> AbaqusReader<'a> {
        AbaqusReader {
            files,
            options,
            budget: Budget::new(options),
            warnings: Warnings::default(),
            model: AbaqusModel::default(),
            scope: 0,
            block: DataBlock::Skipped,
            first_other: None,
            open: Vec::new(),
            read: HashSet::new(),
        }
    }

    /// Reads the model's own file.
    pub fn read(mut self, bytes: &[u8], file: &str) -> Result<Loaded, ReadError> {
        let own = file.replace('\\', "/");
        let own = own.rsplit('/').next().unwrap_or_default().to_owned();
        self.open.push(own.clone());
        self.read.insert(own);
        self.run(bytes, file, "")?;
        let assembly = AbaqusAssembly::new(&self.model, self.budget, &mut self.warnings)?;
        let scene = assembly.scene()?;
        Ok(Loaded {
            scene,
            warnings: self.warnings.finish(file),
        })
    }

    fn run(&mut self, bytes: &[u8], file: &str, name: &str) -> Result<(), ReadError> {
        let bytes = &*decoded(bytes);
        check_length(bytes, file)?;
        let mut source = InputSource {
            text: TextCursor::new(bytes),
            file,
            name,
            number: self.model.files.len() as u32,
            lines: LineCounter::default(),
        };
        self.model.files.push(file.to_owned());
        let mut lines = InputLines { text: source.text };
        while let Some(line) = lines.next() {
            if line.is_keyword() {
                let keyword = KeywordLine::read(line, &mut lines);
                self.keyword(&keyword, &mut source)?;
            } else {
                self.data(&line, &source)?;
            }
        }
        Ok(())
    }

    /// Counts a warning.
    pub fn warn(&mut self, source: &InputSource, at: usize, message: impl Into<String>) {
        let text = source.text;
        self.warnings
            .add(source.file, message.into(), || text.position(at));
    }

    /// Reads a file whose lines stand in the place of the keyword.
    pub fn include(
        &mut self,
        wanted: &str,
        at: usize,
        source: &InputSource,
    ) -> Result<(), ReadError> {
        let shown = quoted(wanted.as_bytes());
        let (name, bytes) = match open_beside(self.files, source.name, wanted) {
            Ok(found) => found,
            Err(reason) => {
                self.warn(
                    source,
                    at,
                    format!("included file {shown}: {reason}; skipped"),
                );
                return Ok(());
            }
        };
        if self.open.contains(&name) {
            let found = format!("file {shown}, which includes itself");
            return Err(source.error(at, found, "files that do not include each other"));
        }
        if self.open.len() == DEEPEST {
            let found = format!("files included more than {DEEPEST} deep");
            return Err(source.error(at, found, "fewer of them"));
        }
        let bytes = gzip::unpacked(&bytes, &name, self.options)?;
        if !self.read.insert(name.clone()) {
            let spent = self
                .budget
                .spend(bytes.len() as u64 / BYTES_PER_ELEMENT + 16);
            spent.map_err(|e| e.error(source.file))?;
        }
        self.open.push(name.clone());
        let result = self.run(&bytes, &name, &name);
        self.open.pop();
        result.map_err(|mut error| {
            if let Position::Line(number, _) = source.text.position(at) {
                error
                    .included_from
                    .insert(0, (source.file.to_owned(), number));
            }
            error
        })
    }
}
