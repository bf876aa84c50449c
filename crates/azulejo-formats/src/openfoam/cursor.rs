//! Words of OpenFOAM's files, and the lists of numbers between them.

use crate::ReadError;
use crate::reading::cursor::TextCursor;
use crate::reading::number;
use crate::reading::text::quoted;

/// What the header of a file says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct FoamHeader {
    /// What the file holds: `polyBoundaryMesh`, `faceList`, `vectorField`…
    pub class: String,
    /// Whether lists of numbers are binary.
    pub is_binary: bool,
    /// Bytes of an integer.
    pub label: usize,
    /// Bytes of a real number.
    pub scalar: usize,
    /// Whether the most significant byte comes first.
    pub is_big: bool,
}

impl Default for FoamHeader {
    fn default() -> FoamHeader {
        FoamHeader {
            class: String::new(),
            is_binary: false,
            label: 4,
            scalar: 8,
            is_big: false,
        }
    }
}

/// A cursor over the words of a file; comments are blanks.
#[derive(Clone, Copy)]
pub(super) struct FoamCursor<'a> {
    pub text: TextCursor<'a>,
    file: &'a str,
    /// Whether errors state the byte, because lines mean nothing between binary numbers.
    by_byte: bool,
}

impl<'a> FoamCursor<'a> {
    pub fn new(bytes: &'a [u8], file: &'a str) -> FoamCursor<'a> {
        FoamCursor {
            text: TextCursor::new(bytes),
            file,
            by_byte: false,
        }
    }

    /// Passes blanks and comments.
    pub fn skip_blanks(&mut self) {
        loop {
            self.text.take_while(|b| b.is_ascii_whitespace());
            match self.text.rest() {
                [b'/', b'/', ..] => {
                    self.text.take_line();
                }
                [b'/', b'*', comment @ ..] => {
                    let end = comment.windows(2).position(|w| w == b"*/");
                    let length = end.map_or(comment.len(), |end| end + 2);
                    self.text.advance(2 + length);
                }
                _ => return,
            }
        }
    }

    /// The next word, text in quotes or punctuation mark; `None` at the end.
    pub fn word(&mut self) -> Option<&'a [u8]> {
        self.skip_blanks();
        let start = self.text.offset();
        match self.text.peek()? {
            b'"' => {
                self.text.advance(1);
                self.text.take_while(|b| b != b'"');
                self.text.advance(usize::from(!self.text.at_end()));
            }
            b'(' | b')' | b'{' | b'}' | b';' => self.text.advance(1),
            _ => {
                let is_mark = |b: u8| matches!(b, b'(' | b')' | b'{' | b'}' | b';' | b'"');
                self.text
                    .take_while(|b| !b.is_ascii_whitespace() && !is_mark(b));
            }
        }
        Some(&self.text.bytes()[start..self.text.offset()])
    }

    /// Passes a punctuation mark if it comes next.
    pub fn pass(&mut self, mark: u8) -> bool {
        self.skip_blanks();
        let is_there = self.text.peek() == Some(mark);
        self.text.advance(usize::from(is_there));
        is_there
    }

    /// Passes a punctuation mark that must come next.
    pub fn expect(&mut self, mark: u8) -> Result<(), ReadError> {
        if self.pass(mark) {
            Ok(())
        } else {
            Err(self.odd(format!("\"{}\"", char::from(mark))))
        }
    }

    /// A whole number that is not negative.
    pub fn label(&mut self) -> Result<u64, ReadError> {
        self.skip_blanks();
        let before = *self;
        let digits = self.text.take_while(|b| b.is_ascii_digit());
        let number = std::str::from_utf8(digits)
            .ok()
            .and_then(|d| d.parse().ok());
        number.ok_or_else(|| before.odd("a whole number"))
    }

    /// A real number.
    pub fn scalar(&mut self) -> Result<f64, ReadError> {
        self.skip_blanks();
        if let Some(number) = number::parse(self.text.rest()) {
            self.text.advance(number.length);
            return Ok(number.value);
        }
        // What C++ prints for infinities and NaN.
        let before = *self;
        match self.word().map(<[u8]>::to_ascii_lowercase).as_deref() {
            Some(b"nan" | b"-nan" | b"inf" | b"-inf") => Ok(f64::NAN),
            _ => Err(before.odd("a number")),
        }
    }

    /// The bytes of `count` binary values of `width` bytes, in parentheses.
    pub fn raw(&mut self, count: u64, width: usize) -> Result<&'a [u8], ReadError> {
        if count == 0 {
            // An empty list may have parentheses or not.
            if self.pass(b'(') {
                self.expect(b')')?;
            }
            return Ok(&[]);
        }
        self.expect(b'(')?;
        let rest = self.text.rest();
        let length = usize::try_from(count)
            .ok()
            .and_then(|c| c.checked_mul(width));
        let Some(bytes) = length.and_then(|length| rest.get(..length)) else {
            let found = format!("{} bytes before the end of the file", rest.len());
            let expected = format!("{count} values of {width} bytes");
            return Err(self.error(self.text.offset(), found, expected));
        };
        self.text.advance(bytes.len());
        self.expect(b')')?;
        Ok(bytes)
    }

    /// Reads the header, which every file begins with.
    pub fn header(&mut self) -> Result<FoamHeader, ReadError> {
        let mut header = FoamHeader::default();
        let start = *self;
        if self.word() != Some(b"FoamFile") || !self.pass(b'{') {
            return Err(start.odd("the header FoamFile of OpenFOAM"));
        }
        while !self.pass(b'}') {
            let mut value = || self.word().unwrap_or_default();
            match value() {
                b"" => return Err(self.odd("an entry of the header")),
                b"class" => header.class = String::from_utf8_lossy(value()).into_owned(),
                b"format" => header.is_binary = value() == b"binary",
                b"arch" => header.read_arch(value()),
                _ => {}
            }
            self.skip_entry()?;
        }
        self.by_byte = header.is_binary;
        Ok(header)
    }

    /// Passes the rest of an entry: up to a semicolon, or a dictionary.
    pub fn skip_entry(&mut self) -> Result<(), ReadError> {
        let mut depth = 0u64;
        loop {
            match self.word() {
                Some(b"{" | b"(") => depth += 1,
                Some(b"}") if depth <= 1 => return Ok(()),
                Some(b"}" | b")") => depth = depth.saturating_sub(1),
                Some(b";") if depth == 0 => return Ok(()),
                Some(_) => {}
                None => return Err(self.odd("\";\"")),
            }
        }
    }

    /// An error about the word that comes next.
    pub fn odd(&self, expected: impl Into<String>) -> ReadError {
        let mut ahead = *self;
        ahead.skip_blanks();
        let at = ahead.text.offset();
        let found = match ahead.word() {
            Some(word) => quoted(word),
            None => "the end of the file".to_owned(),
        };
        self.error(at, found, expected)
    }

    /// An error at a byte.
    pub fn error(
        &self,
        at: usize,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> ReadError {
        if self.by_byte {
            ReadError::at_byte(self.file, at as u64, found, expected)
        } else {
            self.text.error(self.file, at, found, expected)
        }
    }
}

impl FoamHeader {
    /// `"LSB;label=32;scalar=64"`.
    fn read_arch(&mut self, value: &[u8]) {
        let value = value.trim_ascii();
        let value = value.strip_prefix(b"\"").unwrap_or(value);
        let value = value.strip_suffix(b"\"").unwrap_or(value);
        for part in value.split(|&b| b == b';') {
            match part {
                b"MSB" => self.is_big = true,
                b"label=32" => self.label = 4,
                b"label=64" => self.label = 8,
                b"scalar=32" => self.scalar = 4,
                b"scalar=64" => self.scalar = 8,
                _ => {}
            }
        }
    }
}
