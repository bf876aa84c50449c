//! Records, and the words in them, which may run on over line ends.

use crate::reading::cursor::{TextCursor, is_line_end};
use crate::{Position, ReadError};

/// A cursor over the records of a file.
pub(super) struct Lines<'a> {
    text: TextCursor<'a>,
    /// Number of the line at the cursor, from 1.
    line: u32,
    file: &'a str,
}

/// A word, and where it begins.
#[derive(Clone, Copy)]
pub(super) struct Word<'a> {
    pub bytes: &'a [u8],
    pub at: usize,
    pub line: u32,
}

fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b',')
}

impl<'a> Lines<'a> {
    pub fn new(bytes: &'a [u8], file: &'a str) -> Lines<'a> {
        Lines {
            text: TextCursor::new(bytes),
            line: 1,
            file,
        }
    }

    fn skip_blanks(&mut self) {
        self.text.take_while(is_blank);
    }

    /// The next word of this line; a comment ends it.
    pub fn word_on_line(&mut self) -> Option<Word<'a>> {
        self.skip_blanks();
        self.plain_word().filter(|w| !w.bytes.starts_with(b"!"))
    }

    /// The next word of this line, whatever it begins with.
    pub fn plain_word(&mut self) -> Option<Word<'a>> {
        self.skip_blanks();
        let at = self.text.offset();
        let bytes = self.text.take_while(|b| !is_blank(b) && !is_line_end(b));
        let line = self.line;
        (!bytes.is_empty()).then_some(Word { bytes, at, line })
    }

    /// The next word, on this line or on one that follows.
    pub fn word(&mut self) -> Option<Word<'a>> {
        self.word_on_line().or_else(|| self.record())
    }

    /// The first word of the next line that is neither empty nor a comment.
    pub fn record(&mut self) -> Option<Word<'a>> {
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
    pub fn first_record(&mut self) -> Option<Word<'a>> {
        self.first_word().or_else(|| self.record())
    }

    /// The word with which this line begins, unless it is a comment.
    fn first_word(&mut self) -> Option<Word<'a>> {
        match self.text.peek() {
            Some(b'/') => None,
            _ => self.word_on_line(),
        }
    }

    /// The first word of the next record, which is not passed.
    pub fn peek_record(&self) -> Option<Word<'a>> {
        let ahead = Lines { ..*self };
        { ahead }.record()
    }

    /// The end of the file.
    pub fn end(&self) -> usize {
        self.text.bytes().len()
    }

    /// Leaves the rest of the line unread; its end is not passed.
    pub fn skip_line(&mut self) {
        self.rest_of_line();
    }

    /// Passes over what is left of the line, and its end.
    fn end_line(&mut self) {
        self.rest_of_line();
        if self.text.pass_line_end() {
            self.line += 1;
        }
    }

    /// What is left of the line; its end is not passed.
    pub fn rest_of_line(&mut self) -> &'a [u8] {
        self.text.take_line().trim_ascii()
    }

    /// Line and column of a byte.
    pub fn position(&self, at: usize) -> Position {
        self.text.position(at)
    }

    /// An error at a byte.
    pub fn error(
        &self,
        at: usize,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> ReadError {
        self.text.error(self.file, at, found, expected)
    }

    /// The first line that is longer than View3D reads, and how many such lines there are.
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
