//! Reads the lines of a file and of those that it includes.

use super::assembly::AbaqusAssembly;
use super::data::DataBlock;
use super::keyword::{InputLines, KeywordLine};
use super::part::AbaqusModel;
use crate::reading::cursor::{LineCounter, TextCursor};
use crate::reading::include::{IncludeSite, IncludeStack};
use crate::reading::options::{Budget, check_length};
use crate::reading::text::decoded;
use crate::reading::warnings::Warnings;
use crate::{Files, Loaded, ReadError, ReadOptions};

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
    includes: IncludeStack<'a>,
    budget: Budget,
    /// Sectors of bodies of revolution.
    pub sectors: Option<u32>,
    warnings: Warnings,
    pub model: AbaqusModel,
    /// Index of the part that is being read.
    pub scope: usize,
    /// What the data lines are.
    pub block: DataBlock,
    /// The first keyword that says nothing of geometry.
    pub first_other: Option<String>,
}

impl<'a> AbaqusReader<'a> {
    pub fn new(files: &'a dyn Files, options: &'a ReadOptions) -> AbaqusReader<'a> {
        AbaqusReader {
            includes: IncludeStack::new(files, options),
            budget: Budget::new(options),
            sectors: options.sectors,
            warnings: Warnings::default(),
            model: AbaqusModel::default(),
            scope: 0,
            block: DataBlock::Skipped,
            first_other: None,
        }
    }

    /// Reads the model's own file.
    pub fn read(mut self, bytes: &[u8], file: &str) -> Result<Loaded, ReadError> {
        self.includes.begin(file);
        self.run(bytes, file, "")?;
        let assembly =
            AbaqusAssembly::new(&self.model, self.sectors, self.budget, &mut self.warnings)?;
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
                self.data(&line, &mut source)?;
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
        path: &str,
        at: usize,
        source: &InputSource,
    ) -> Result<(), ReadError> {
        let site = IncludeSite {
            text: source.text,
            file: source.file,
            name: source.name,
            at,
        };
        let included = match self.includes.open(path, site)? {
            Ok(included) => included,
            Err(message) => {
                self.warn(source, at, message);
                return Ok(());
            }
        };
        if included.is_repeated {
            let elements = included.bytes.len() as u64 / BYTES_PER_ELEMENT + 16;
            let spent = self.budget.spend(elements);
            spent.map_err(|e| e.error(source.file))?;
        }
        let result = self.run(&included.bytes, &included.name, &included.name);
        self.includes.close(site, result)
    }
}
