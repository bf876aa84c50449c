//! Records and their words, which may continue over line ends.

use crate::reading::cursor::{TextCursor, is_line_end};
use crate::{Position, ReadError};

/// A cursor over the records of a file.
pub(super) struct View3dLines<'a> {
    text: TextCursor<'a>,
    /// Number of the line at the cursor, from 1.
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
    matches!(byte, b' ' | b'\t' | b',')
}

impl<'a> View3dLines<'a> {
    pub fn new(bytes: &'a [u8], file: &'a str) -> View3dLines<'a> {
        View3dLines {
            text: TextCursor::new(bytes),
            line: 1,
            file,
        }
    }

    fn skip_blanks(&mut self) {
        self.text.take_while(is_blank);
    }

    /// The next word of this line; a comment ends it.
    pub fn word_on_line(&mut self) -> Option<LineWord<'a>> {
        self.skip_blanks();
        self.plain_word().filter(|w| !w.bytes.starts_with(b"!"))
    }

    /// The next word of this line, whatever it begins with.
    pub fn plain_word(&mut self) -> Option<LineWord<'a>> {
        self.skip_blanks();
        let at = self.text.offset();
        let bytes = self.text.take_while(|b| !is_blank(b) && !is_line_end(b));
        let line = self.line;
        (!bytes.is_empty()).then_some(LineWord { bytes, at, line })
    }

    /// The next word, on this line or on one that follows.
    pub fn word(&mut self) -> Option<LineWord<'a>> {
        self.word_on_line().or_else(|| self.record())
    }

    /// The first word of the next line that is neither empty nor a comment.
    pub fn record(&mut self) -> Option<LineWord<'a>> {
        loop {
            self.end_line();
            if self.text.at_end() {
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
        match self.text.peek() {
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
        self.text.bytes().len()
    }

    /// Skips the rest of the line, but not its end.
    pub fn skip_line(&mut self) {
        self.rest_of_line();
    }

    /// Skips the rest of the line, and its end.
    fn end_line(&mut self) {
        self.rest_of_line();
        if self.text.pass_line_end() {
            self.line += 1;
        }
    }

    /// The rest of the line; its end is not consumed.
    pub fn rest_of_line(&mut self) -> &'a [u8] {
        self.text.take_line().trim_ascii()
    }

    /// Line and column of a byte offset.
    pub fn position(&self, at: usize) -> Position {
        self.text.position(at)
    }

    /// An error at a byte offset.
    pub fn error(
        &self,
        at: usize,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> ReadError {
        self.text.error(self.file, at, found, expected)
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
