//! Words and numbers of legacy files.

use super::values::{VtkType, VtkValues, next_integer, next_real};
use crate::ReadError;
use crate::reading::text::{quoted, text};
use crate::reading::words::Words;

/// A cursor over a file, whose keywords stand on lines of text even in binary files.
pub(super) struct LegacySource<'a> {
    file: &'a str,
    bytes: &'a [u8],
    words: Words<'a>,
    pub is_binary: bool,
    pub version: f64,
    /// Where the last word began.
    last: usize,
}

impl<'a> LegacySource<'a> {
    /// A cursor behind the three lines of the header.
    pub fn new(bytes: &'a [u8], file: &'a str) -> Result<LegacySource<'a>, ReadError> {
        let mut words = Words::new(bytes, file);
        let mark = text(words.rest_of_line());
        let version = mark.rsplit(' ').next().and_then(|v| v.parse().ok());
        // The title, which may be anything.
        words.rest_of_line();
        words.skip_blanks();
        let start = words.offset();
        let is_binary = match words
            .word()
            .unwrap_or_default()
            .to_ascii_uppercase()
            .as_slice()
        {
            b"ASCII" => false,
            b"BINARY" => true,
            _ => return Err(words.error(start, "ASCII or BINARY on the third line")),
        };
        Ok(LegacySource {
            file,
            bytes,
            words,
            is_binary,
            version: version.unwrap_or(3.0),
            last: start,
        })
    }

    /// Offset of the next byte.
    pub fn offset(&self) -> usize {
        self.words.offset()
    }

    /// The next word and where it begins.
    pub fn word(&mut self) -> (usize, &'a [u8]) {
        self.words.skip_blanks();
        self.last = self.words.offset();
        (self.last, self.words.word().unwrap_or_default())
    }

    /// The next word as a keyword, in capitals; `None` at the end.
    pub fn keyword(&mut self) -> Option<String> {
        let (_, word) = self.word();
        (!word.is_empty()).then(|| text(word).to_ascii_uppercase())
    }

    /// The next word as a count.
    pub fn count(&mut self, expected: &str) -> Result<usize, ReadError> {
        let (_, word) = self.word();
        let count = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
        count.ok_or_else(|| self.error_before(expected))
    }

    /// A count, if the line has one more word.
    pub fn count_on_line(&mut self) -> Option<usize> {
        self.words.skip_spaces();
        self.words.small_integer().map(|count| count as usize)
    }

    /// The next word as a type.
    pub fn kind(&mut self) -> Result<VtkType, ReadError> {
        let (_, word) = self.word();
        let kind = VtkType::of_legacy(&text(word));
        kind.ok_or_else(|| self.error_before("a type of numbers, as float"))
    }

    /// Passes the rest of the line and its end, behind which binary numbers may begin.
    pub fn end_line(&mut self) {
        self.words.rest_of_line();
    }

    /// Passes the next line, if it begins with a keyword.
    pub fn pass_line(&mut self, keyword: &str) {
        let mut ahead = self.words;
        if ahead.word() == Some(keyword.as_bytes()) {
            ahead.rest_of_line();
            self.words = ahead;
        }
    }

    /// Passes lines up to an empty one.
    pub fn skip_paragraph(&mut self) {
        self.words.rest_of_line();
        while !self.words.at_end() && !self.words.rest_of_line().is_empty() {}
    }

    /// Passes what is known of the last array, if it follows.
    pub fn pass_metadata(&mut self) {
        let mut ahead = self.words;
        if ahead.word() == Some(b"METADATA") {
            self.words = ahead;
            self.skip_paragraph();
        }
    }

    /// The next values of an array.
    ///
    /// # Errors
    /// The end of the file, and words that are not numbers.
    pub fn values(
        &mut self,
        kind: VtkType,
        tuples: usize,
        components: usize,
    ) -> Result<VtkValues, ReadError> {
        let (count, bytes) = self.size(kind, tuples, components)?;
        if kind == VtkType::Text {
            return self.texts(count);
        }
        if self.is_binary {
            let raw = self.take(bytes, count)?;
            return Ok(VtkValues::decode(kind, raw, count, true));
        }
        match kind {
            VtkType::Real(_) => self.repeated(count, next_real).map(VtkValues::Reals),
            _ => self.repeated(count, next_integer).map(VtkValues::Integers),
        }
    }

    /// Passes the values of an array.
    ///
    /// # Errors
    /// As [`LegacySource::values`], but for words that are not numbers.
    pub fn skip(
        &mut self,
        kind: VtkType,
        tuples: usize,
        components: usize,
    ) -> Result<(), ReadError> {
        let (count, bytes) = self.size(kind, tuples, components)?;
        if kind == VtkType::Text {
            return self.texts(count).map(drop);
        }
        if self.is_binary {
            return self.take(bytes, count).map(drop);
        }
        for done in 0..count {
            if self.words.word().is_none() {
                return Err(self.ended(done, count));
            }
        }
        Ok(())
    }

    /// Number of values, and their bytes in a binary file.
    fn size(
        &self,
        kind: VtkType,
        tuples: usize,
        components: usize,
    ) -> Result<(usize, usize), ReadError> {
        let count = tuples.checked_mul(components);
        let size = count.and_then(|count| Some((count, kind.bytes(count)?)));
        let many = "more numbers than a file can have";
        size.ok_or_else(|| self.error(self.words.offset(), many, "fewer"))
    }

    /// Numbers of a text.
    fn repeated<T>(
        &mut self,
        count: usize,
        next: fn(&mut Words) -> Option<Result<T, usize>>,
    ) -> Result<Vec<T>, ReadError> {
        let mut numbers = Vec::new();
        for _ in 0..count {
            match next(&mut self.words) {
                Some(Ok(number)) => numbers.push(number),
                Some(Err(at)) => return Err(self.words.error(at, "a number")),
                None => return Err(self.ended(numbers.len(), count)),
            }
        }
        Ok(numbers)
    }

    /// The error for an array that the file does not have to its end.
    #[cold]
    fn ended(&self, done: usize, count: usize) -> ReadError {
        let found = format!("the end of the file after {done} values");
        self.error(self.bytes.len(), found, format!("{count} values"))
    }

    /// The next bytes of a binary file.
    fn take(&mut self, bytes: usize, values: usize) -> Result<&'a [u8], ReadError> {
        let at = self.words.offset();
        let raw = at
            .checked_add(bytes)
            .and_then(|end| self.bytes.get(at..end));
        let raw = raw.ok_or_else(|| {
            let found = format!("{} bytes up to the end of the file", self.bytes.len() - at);
            self.error(at, found, format!("{bytes} bytes for {values} values"))
        })?;
        self.words = self.words.from(at + bytes);
        Ok(raw)
    }

    /// Texts: lines, or bytes behind their number.
    fn texts(&mut self, count: usize) -> Result<VtkValues, ReadError> {
        let mut texts = Vec::new();
        for _ in 0..count {
            if self.words.at_end() {
                return Err(self.ended(texts.len(), count));
            }
            if self.is_binary {
                let length = self.length()?;
                let raw = self.take(length, 1)?;
                texts.push(text(raw).into_owned());
            } else {
                texts.push(unescaped(&text(self.words.rest_of_line())));
            }
        }
        Ok(VtkValues::Texts(texts))
    }

    /// The length of a text: the first two bits tell how many bytes it has itself.
    fn length(&mut self) -> Result<usize, ReadError> {
        let first = self.bytes[self.words.offset()];
        let bytes = match first >> 6 {
            3 => 1,
            2 => 2,
            1 => 4,
            _ => 8,
        };
        let raw = self.take(bytes, 1)?;
        let rest = raw[1..]
            .iter()
            .fold(usize::from(first & 0x3f), |n, &b| n << 8 | usize::from(b));
        Ok(rest)
    }

    /// An error at the last word.
    pub fn error_before(&self, expected: &str) -> ReadError {
        match self.words.from(self.last).word() {
            Some(word) => self.error(self.last, quoted(word), expected),
            None => self.error(self.last, "the end of the file", expected),
        }
    }

    /// An error at a byte, by line and column in text.
    pub fn error(
        &self,
        at: usize,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> ReadError {
        if self.is_binary {
            return ReadError::at_byte(self.file, at as u64, found, expected);
        }
        self.words.error_with(at, found, expected)
    }
}

/// A text of a legacy file, in which characters may be written as `%20`.
pub(super) fn unescaped(text: &str) -> String {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&first, behind)) = rest.split_first() {
        let digit = |k: usize| char::from(*behind.get(k)?).to_digit(16);
        let code = (first == b'%')
            .then(|| Some(16 * digit(0)? + digit(1)?))
            .flatten();
        match code {
            Some(code) => {
                bytes.push(code as u8);
                rest = &behind[2..];
            }
            None => {
                bytes.push(first);
                rest = behind;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
