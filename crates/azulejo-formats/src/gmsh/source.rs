//! Numbers of a file, as text or binary of either byte order.

use crate::ReadError;
use crate::reading::text::quoted;
use crate::reading::words::Words;

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MshEncoding {
    Text,
    /// Binary, with the most significant byte first or last.
    Binary {
        is_big: bool,
    },
}

/// A cursor over a file, whose sections begin with a line of text even in binary files.
#[derive(Clone, Copy, Debug)]
pub(super) struct MshSource<'a> {
    file: &'a str,
    bytes: &'a [u8],
    words: Words<'a>,
    pub encoding: MshEncoding,
    /// Bytes of a size: 4 or 8.
    pub size_bytes: usize,
}

impl<'a> MshSource<'a> {
    pub fn new(bytes: &'a [u8], file: &'a str) -> MshSource<'a> {
        MshSource {
            file,
            bytes,
            words: Words::new(bytes, file),
            encoding: MshEncoding::Text,
            size_bytes: 8,
        }
    }

    /// The next word, which is text in binary files, too, with its offset; `None` at the end.
    pub fn word(&mut self) -> Option<(usize, &'a [u8])> {
        let word = self.words.word()?;
        Some((self.words.offset() - word.len(), word))
    }

    /// The rest of the line, which is text; its end is passed.
    pub fn rest_of_line(&mut self) -> &'a [u8] {
        self.words.rest_of_line()
    }

    /// Offset of the next byte.
    pub fn offset(&self) -> usize {
        self.words.offset()
    }

    /// Offset of the next number.
    pub fn next_offset(&mut self) -> usize {
        if self.encoding == MshEncoding::Text {
            self.words.skip_blanks();
        }
        self.words.offset()
    }

    /// A number that is text in binary files, too, with nothing but the line end behind it.
    pub fn count_line(&mut self, expected: &str) -> Result<u64, ReadError> {
        let count = self.parsed(expected)?;
        self.rest_of_line();
        Ok(count)
    }

    /// The next word as an integer.
    fn parsed<T: std::str::FromStr>(&mut self, expected: &str) -> Result<T, ReadError> {
        self.words.skip_blanks();
        let start = self.words.offset();
        let word = std::str::from_utf8(self.words.word().unwrap_or_default()).ok();
        let value = word.and_then(|w| w.parse().ok());
        value.ok_or_else(|| self.words.error(start, expected))
    }

    /// The next bytes of a binary file, in the order of the processor.
    fn array<const N: usize>(&mut self, expected: &str) -> Result<[u8; N], ReadError> {
        let start = self.words.offset();
        let bytes = self.bytes[start..].first_chunk::<N>();
        let mut bytes = *bytes.ok_or_else(|| {
            ReadError::at_byte(self.file, start as u64, "the end of the file", expected)
        })?;
        self.words = self.words.from(start + N);
        if self.encoding == (MshEncoding::Binary { is_big: true }) {
            bytes.reverse();
        }
        Ok(bytes)
    }

    /// The next integer.
    pub fn int(&mut self, expected: &str) -> Result<i64, ReadError> {
        match self.encoding {
            MshEncoding::Text => self.parsed(expected),
            MshEncoding::Binary { .. } => Ok(i32::from_le_bytes(self.array(expected)?).into()),
        }
    }

    /// The next count, or the number of a node or element.
    pub fn size(&mut self, expected: &str) -> Result<u64, ReadError> {
        match (self.encoding, self.size_bytes) {
            (MshEncoding::Text, _) => self.parsed(expected),
            (_, 4) => Ok(u32::from_le_bytes(self.array(expected)?).into()),
            _ => Ok(u64::from_le_bytes(self.array(expected)?)),
        }
    }

    /// The next coordinate, which need not be finite.
    pub fn number(&mut self, expected: &str) -> Result<f64, ReadError> {
        match self.encoding {
            MshEncoding::Text => self.words.number(),
            MshEncoding::Binary { .. } => Ok(f64::from_le_bytes(self.array(expected)?)),
        }
    }

    /// Passes coordinates.
    pub fn skip_numbers(&mut self, count: u64) -> Result<(), ReadError> {
        (0..count).try_for_each(|_| self.number("a coordinate").map(drop))
    }

    /// Passes the end of a section.
    ///
    /// # Errors
    /// Anything else comes next: its counts are wrong.
    pub fn end(&mut self, section: &str) -> Result<(), ReadError> {
        let expected = format!("$End{section}");
        match self.word() {
            Some((_, word)) if word == expected.as_bytes() => Ok(()),
            Some((at, word)) => Err(self.error(at, quoted(word), expected)),
            None => Err(self.error(self.offset(), "the end of the file", expected)),
        }
    }

    /// Passes a section without reading it.
    pub fn skip(&mut self, section: &str) -> Result<(), ReadError> {
        let end = format!("$End{section}");
        let mut at = self.offset();
        while let Some(step) = self.bytes[at..].iter().position(|&b| b == b'$') {
            at += step;
            if self.bytes[at..].starts_with(end.as_bytes()) {
                self.words = self.words.from(at + end.len());
                return Ok(());
            }
            at += 1;
        }
        Err(self.error(self.bytes.len(), "the end of the file", end))
    }

    /// An error at a byte, by line and column in text.
    #[cold]
    pub fn error(
        &self,
        at: usize,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> ReadError {
        match self.encoding {
            MshEncoding::Text => self.words.error_with(at, found, expected),
            MshEncoding::Binary { .. } => ReadError::at_byte(self.file, at as u64, found, expected),
        }
    }
}
