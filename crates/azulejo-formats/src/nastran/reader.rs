//! Reads the cards of a file and of those that it includes.

use super::card::{BulkCard, BulkLine, BulkLines};
use super::deck::BulkDeck;
use crate::reading::cursor::{LineCounter, TextCursor};
use crate::reading::include::{IncludeSite, IncludeStack};
use crate::reading::options::check_length;
use crate::reading::text::{decoded, quoted, text};
use crate::reading::warnings::Warnings;
use crate::{Files, Loaded, ReadError, ReadOptions};

/// Most lines that the name of an included file is spread over.
const LONGEST_NAME: usize = 20;

/// The warning for continuations that may be out of order.
const OTHER_NAME: &str = "continuation of another name than the line before it expects: taken as its \
     continuation";

/// A file that is being read.
#[derive(Clone, Copy)]
pub(super) struct BulkSource<'a> {
    pub text: TextCursor<'a>,
    /// Its name in messages.
    pub file: &'a str,
    /// Its name relative to the model's folder.
    name: &'a str,
    /// Index among all files.
    pub number: u32,
}

/// Reads bulk data.
pub(super) struct BulkReader<'a> {
    includes: IncludeStack<'a>,
    warnings: Warnings,
    pub(super) deck: BulkDeck,
    /// The first card that says nothing of geometry.
    pub(super) first_other: Option<String>,
    /// Whether the end of the data has been read.
    is_done: bool,
}

impl<'a> BulkReader<'a> {
    pub fn new(files: &'a dyn Files, options: &'a ReadOptions) -> BulkReader<'a> {
        BulkReader {
            includes: IncludeStack::new(files, options),
            warnings: Warnings::default(),
            deck: BulkDeck::default(),
            first_other: None,
            is_done: false,
        }
    }

    /// Reads the model's own file, from `BEGIN BULK` on if it has that.
    pub fn read(mut self, bytes: &[u8], file: &str) -> Result<Loaded, ReadError> {
        self.includes.begin(file);
        self.run(bytes, file, "")?;
        let scene = self.deck.scene(&mut self.warnings)?;
        Ok(Loaded {
            scene,
            warnings: self.warnings.finish(file),
        })
    }

    fn run(&mut self, bytes: &[u8], file: &str, name: &str) -> Result<(), ReadError> {
        let bytes = &*decoded(bytes);
        check_length(bytes, file)?;
        let source = BulkSource {
            text: TextCursor::new(bytes),
            file,
            name,
            number: self.deck.files.len() as u32,
        };
        self.deck.files.push(file.to_owned());
        let mut lines = BulkLines {
            text: source.text.moved_to(start_of_bulk(bytes)),
        };
        let mut card: Option<BulkCard> = None;
        let mut spare = BulkCard::default();
        // Lines are counted once, not anew for every card.
        let mut line_number = LineCounter::default();
        while let Some(line) = lines.next() {
            if !line.comment.is_empty() {
                self.deck.names.read_comment(&line);
            }
            if line.text.trim_ascii().is_empty() {
                continue;
            }
            if line.continues() {
                match card.as_mut().map(|card| card.push(&line)) {
                    Some(true) => {}
                    Some(false) => self.warn(&source, line.at, OTHER_NAME),
                    None => self.warn(&source, line.at, "continuation without a card: skipped"),
                }
                continue;
            }
            if let Some(done) = card.take() {
                self.card(&done, &source, line_number.at(bytes, done.at))?;
                spare = done;
            }
            match &*line.name() {
                b"INCLUDE" => self.include(&line, &mut lines, &source)?,
                b"ENDDATA" => self.is_done = true,
                b"BEGIN" => self.begin(&source, &line),
                _ => {
                    let mut next = std::mem::take(&mut spare);
                    next.begin(&line);
                    card = Some(next);
                }
            }
            if self.is_done {
                return Ok(());
            }
        }
        match card {
            Some(card) => self.card(&card, &source, line_number.at(bytes, card.at)),
            None => Ok(()),
        }
    }

    pub(super) fn warn(&mut self, source: &BulkSource, at: usize, message: impl Into<String>) {
        let text = source.text;
        self.warnings
            .add(source.file, message.into(), || text.position(at));
    }

    /// Superelements have numbers of their own, which are rarely used twice.
    fn begin(&mut self, source: &BulkSource, line: &BulkLine) {
        let words = text(line.text).to_ascii_uppercase();
        if !words.contains("BULK") || words.contains('=') {
            self.warn(
                source,
                line.at,
                "part of the bulk data (BEGIN SUPER): read as if it were one with the rest",
            );
        }
    }

    /// Reads a file that is included.
    fn include(
        &mut self,
        line: &BulkLine,
        lines: &mut BulkLines,
        source: &BulkSource,
    ) -> Result<(), ReadError> {
        let path = included_name(line, lines);
        if path.is_empty() {
            let (found, expected) = ("INCLUDE without a name", "the name of a file");
            return Err((source.text).error(source.file, line.at, found, expected));
        }
        let site = IncludeSite {
            text: source.text,
            file: source.file,
            name: source.name,
            at: line.at,
        };
        let included = match self.includes.open(&path, site)? {
            Ok(included) => included,
            Err(message) => {
                self.warn(source, line.at, message);
                return Ok(());
            }
        };
        let result = if included.is_repeated {
            let shown = quoted(path.as_bytes());
            let message = format!("file {shown}, included again: skipped");
            self.warn(source, line.at, message);
            Ok(())
        } else {
            self.run(&included.bytes, &included.name, &included.name)
        };
        self.includes.close(site, result)
    }
}

/// Where bulk data begin: after the first line `BEGIN BULK`, or at the start.
fn start_of_bulk(bytes: &[u8]) -> usize {
    let mut lines = BulkLines {
        text: TextCursor::new(bytes),
    };
    while let Some(line) = lines.next() {
        let words = line.text.trim_ascii();
        let mut words = words.split(|b| b.is_ascii_whitespace() || *b == b',');
        let is_begin = words
            .next()
            .is_some_and(|w| w.eq_ignore_ascii_case(b"BEGIN"));
        if is_begin && words.any(|w| w.eq_ignore_ascii_case(b"BULK")) {
            return lines.text.offset();
        }
    }
    0
}

/// The name behind `INCLUDE`; in quotes it may continue on the lines that follow.
fn included_name(line: &BulkLine, lines: &mut BulkLines) -> String {
    let line_text = [line.text, line.comment].concat();
    let rest = line_text.trim_ascii()["INCLUDE".len()..].trim_ascii();
    let rest = rest
        .strip_prefix(b",")
        .or(rest.strip_prefix(b"="))
        .unwrap_or(rest);
    let rest = rest.trim_ascii();
    let (quote, mut name) = match rest {
        [quote @ (b'\'' | b'"'), name @ ..] => (*quote, name.to_vec()),
        other => {
            return text(
                other
                    .split(|b| matches!(b, b' ' | b'$'))
                    .next()
                    .unwrap_or_default(),
            )
            .into_owned();
        }
    };
    for _ in 0..LONGEST_NAME {
        if name.contains(&quote) {
            break;
        }
        let Some(line) = lines.next() else { break };
        name.extend_from_slice([line.text, line.comment].concat().trim_ascii());
    }
    let name = name.split(|&b| b == quote).next().unwrap_or_default();
    text(name.trim_ascii()).into_owned()
}
