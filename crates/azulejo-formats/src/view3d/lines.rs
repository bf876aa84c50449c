//! Records and their words, which may continue over line ends.

use crate::reading::words::Words;
use crate::{Position, ReadError};

/// A cursor in a file.
pub(super) struct View3dLines<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Number of the line at `at`, from 1.
    line: u32,
    file: &'a str,
}

/// A word and its offset.
#[derive(Clone, Copy)]
pub(super) struct LineWord<'a> {
    pub bytes: &'a [u8],
    pub at: usize,
    pub line: u32,
}

fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b',' | b'\r')
}

impl<'a> View3dLines<'a> {
    pub fn new(bytes: &'a [u8], file: &'a str) -> View3dLines<'a> {
        let mark = bytes.starts_with(b"\xef\xbb\xbf");
        View3dLines {
            bytes,
            at: if mark { 3 } else { 0 },
            line: 1,
            file,
        }
    }

    fn skip_blanks(&mut self) {
        while self.bytes.get(self.at).is_some_and(|&b| is_blank(b)) {
            self.at += 1;
        }
    }

    /// The next word of this line; a comment ends it.
    pub fn word_on_line(&mut self) -> Option<LineWord<'a>> {
        self.skip_blanks();
        self.plain_word().filter(|w| !w.bytes.starts_with(b"!"))
    }

    /// The next word of this line, whatever it begins with.
    pub fn plain_word(&mut self) -> Option<LineWord<'a>> {
        self.skip_blanks();
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|&b| is_blank(b) || b == b'\n');
        let word = &rest[..length.unwrap_or(rest.len())];
        let found = LineWord {
            bytes: word,
            at: self.at,
            line: self.line,
        };
        self.at += word.len();
        (!word.is_empty()).then_some(found)
    }

    /// The next word, on this line or on one that follows.
    pub fn word(&mut self) -> Option<LineWord<'a>> {
        self.word_on_line().or_else(|| self.record())
    }

    /// The first word of the next line that is neither empty nor a comment.
    pub fn record(&mut self) -> Option<LineWord<'a>> {
        loop {
            self.end_line();
            if self.at >= self.bytes.len() {
                return None;
            }
            if let Some(word) = self.first_word() {
                return Some(word);
            }
        }
    }

    /// The first word of the file's first line, or of one that follows.
    pub fn first_record(&mut self) -> Option<LineWord<'a>> {
        self.first_word().or_else(|| self.record())
    }

    /// The word with which this line begins, unless it is a comment.
    fn first_word(&mut self) -> Option<LineWord<'a>> {
        match self.bytes.get(self.at) {
            Some(b'/') => None,
            _ => self.word_on_line(),
        }
    }

    /// The first word of the next record, which is not consumed.
    pub fn peek_record(&self) -> Option<LineWord<'a>> {
        let ahead = View3dLines { ..*self };
        { ahead }.record()
    }

    /// The offset of the end of the file.
    pub fn end(&self) -> usize {
        self.bytes.len()
    }

    /// Skips the rest of the line, but not its end.
    pub fn skip_line(&mut self) {
        self.rest_of_line();
    }

    /// Skips the rest of the line, and its end.
    fn end_line(&mut self) {
        self.rest_of_line();
        if self.at < self.bytes.len() {
            self.at += 1;
            self.line += 1;
        }
    }

    /// The rest of the line; its end is not consumed.
    pub fn rest_of_line(&mut self) -> &'a [u8] {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        self.at += length;
        rest[..length].trim_ascii()
    }

    /// Line and column of a byte offset.
    pub fn position(&self, at: usize) -> Position {
        Words::new(self.bytes, self.file).position(at)
    }

    /// An error at a byte offset.
    pub fn error(
        &self,
        at: usize,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> ReadError {
        Words::new(self.bytes, self.file).error_saying(at, found, expected)
    }

    /// The first line longer than View3D's limit, and the number of such lines.
    pub fn long_lines(bytes: &[u8]) -> (u32, usize) {
        const LONGEST: usize = 255;
        let lines = bytes.split(|&b| b == b'\n').zip(1..);
        let mut long = lines.filter(|(line, _)| line.len() > LONGEST);
        match long.next() {
            Some((_, first)) => (first, 1 + long.count()),
            None => (0, 0),
        }
    }
}
