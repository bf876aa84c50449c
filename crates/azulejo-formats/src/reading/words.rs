//! Text formats whose words stand between blanks: STL, PLY and SFF.

use crate::reading::number;
use crate::reading::text::{shortened, text};
use crate::{Position, ReadError};

/// A place in a text.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Words<'a> {
    file: &'a str,
    bytes: &'a [u8],
    at: usize,
}

/// Blanks, line ends and other control characters stand between words.
#[inline]
fn is_blank(byte: u8) -> bool {
    byte <= b' '
}

fn is_line_end(byte: u8) -> bool {
    matches!(byte, b'\n' | b'\r')
}

impl<'a> Words<'a> {
    /// The start of a text. `file` stands in messages.
    pub fn new(bytes: &'a [u8], file: &'a str) -> Words<'a> {
        Words { file, bytes, at: 0 }
    }

    /// The same text from byte `at` on.
    pub fn from(self, at: usize) -> Words<'a> {
        Words { at, ..self }
    }

    /// Offset of the next byte.
    pub fn offset(&self) -> usize {
        self.at
    }

    /// Whether nothing but blanks stands before this place on its line.
    pub fn starts_line(&self) -> bool {
        let before = self.bytes[..self.at].iter().rev();
        let mut before = before.skip_while(|&&b| is_blank(b) && !is_line_end(b));
        before.next().is_none_or(|&b| is_line_end(b))
    }

    /// What is left of the line, which is not passed.
    pub fn line_ahead(&self) -> &'a [u8] {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|&b| is_line_end(b));
        &rest[..length.unwrap_or(rest.len())]
    }

    /// Passes over blanks and line ends.
    #[inline]
    pub fn skip_blanks(&mut self) {
        while self.bytes.get(self.at).is_some_and(|&b| is_blank(b)) {
            self.at += 1;
        }
    }

    /// The next word; `None` at the end of the text.
    #[inline]
    pub fn word(&mut self) -> Option<&'a [u8]> {
        self.skip_blanks();
        let start = self.at;
        while self.bytes.get(self.at).is_some_and(|&b| !is_blank(b)) {
            self.at += 1;
        }
        (self.at > start).then(|| &self.bytes[start..self.at])
    }

    /// What is left of the line, without the blanks around it. Its end is passed.
    pub fn rest_of_line(&mut self) -> &'a [u8] {
        let line = self.line_ahead();
        self.at += line.len();
        if self.bytes[self.at..].starts_with(b"\r\n") {
            self.at += 2;
        } else if self.at < self.bytes.len() {
            self.at += 1;
        }
        line.trim_ascii()
    }

    /// The next word as a number; NaN and infinities included.
    ///
    /// # Errors
    /// Another word, or the end of the text.
    #[inline]
    pub fn number(&mut self) -> Result<f64, ReadError> {
        self.skip_blanks();
        if let Some(found) = number::parse(&self.bytes[self.at..]) {
            let end = self.at + found.length;
            if self.bytes.get(end).is_none_or(|&b| is_blank(b)) {
                self.at = end;
                return Ok(found.value);
            }
        }
        self.odd_number()
    }

    /// What C libraries print for numbers that are none: `nan`, `-nan(ind)`, `1.#QNAN`, `inf`.
    #[cold]
    fn odd_number(&mut self) -> Result<f64, ReadError> {
        let start = self.at;
        let word = text(self.word().unwrap_or_default()).to_ascii_lowercase();
        match word.trim_start_matches(['+', '-']) {
            bare if bare.starts_with("nan") || bare.starts_with("1.#") => Ok(f64::NAN),
            "inf" | "infinity" => Ok(f64::INFINITY),
            _ => Err(self.error(start, "a number")),
        }
    }

    /// Passes over blanks before the next word or line end.
    #[inline]
    pub fn skip_spaces(&mut self) {
        let is_space = |b: u8| is_blank(b) && !is_line_end(b);
        while self.bytes.get(self.at).is_some_and(|&b| is_space(b)) {
            self.at += 1;
        }
    }

    /// The next byte, blank or not.
    #[inline]
    pub fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    /// Whether the line or the text ends here.
    #[inline]
    pub fn at_line_end(&self) -> bool {
        self.bytes.get(self.at).is_none_or(|&b| is_line_end(b))
    }

    /// Whether the text ends here.
    #[inline]
    pub fn at_end(&self) -> bool {
        self.at == self.bytes.len()
    }

    /// The next word as a decimal integer of at most nine digits. Another word is not passed.
    #[inline]
    pub fn small_integer(&mut self) -> Option<u32> {
        self.skip_spaces();
        let (mut value, mut at) = (0, self.at);
        while let Some(digit) = self.bytes.get(at).map(|b| b.wrapping_sub(b'0'))
            && digit < 10
            && at - self.at < 10
        {
            value = 10 * value + u64::from(digit);
            at += 1;
        }
        let ends = self.bytes.get(at).is_none_or(|&b| is_blank(b));
        if at == self.at || !ends || at - self.at > 9 {
            return None;
        }
        self.at = at;
        Some(value as u32)
    }

    /// Line and column of a byte, both from 1.
    pub fn position(&self, offset: usize) -> Position {
        let before = &self.bytes[..offset];
        let ends = before.iter().enumerate().filter(|&(i, &b)| match b {
            b'\r' => before.get(i + 1) != Some(&b'\n'),
            _ => b == b'\n',
        });
        let start = before.iter().rposition(|&b| is_line_end(b));
        let column = text(&before[start.map_or(0, |s| s + 1)..]).chars().count();
        Position::Line(ends.count() as u32 + 1, column as u32 + 1)
    }

    /// An error about the word at byte `offset`.
    #[cold]
    pub fn error(&self, offset: usize, expected: &str) -> ReadError {
        let found = match self.from(offset).word() {
            Some(word) => format!("\"{}\"", shortened(&text(word))),
            None => "the end of the file".to_owned(),
        };
        self.error_saying(offset, found, expected)
    }

    /// An error at byte `offset` in the words of the caller.
    #[cold]
    pub fn error_saying(
        &self,
        offset: usize,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> ReadError {
        let start = self.bytes[..offset]
            .iter()
            .rposition(|&b| is_line_end(b))
            .map_or(0, |i| i + 1);
        let rest = &self.bytes[start..];
        let end = rest.iter().position(|&b| is_line_end(b));
        ReadError {
            position: self.position(offset),
            source_line: Some(text(&rest[..end.unwrap_or(rest.len())]).into_owned()),
            ..ReadError::whole(self.file, found, expected)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_lines_and_numbers() {
        let mut words = Words::new(b" solid a b \r\nvertex 1.5\t-2e1\rend", "a");
        assert_eq!(words.word(), Some(&b"solid"[..]));
        assert_eq!(words.rest_of_line(), b"a b");
        assert_eq!(words.word(), Some(&b"vertex"[..]));
        assert_eq!((words.number(), words.number()), (Ok(1.5), Ok(-20.0)));
        assert_eq!(words.rest_of_line(), b"");
        assert_eq!(words.position(words.offset()), Position::Line(3, 1));
        assert_eq!(words.rest_of_line(), b"end");
        assert_eq!((words.word(), words.rest_of_line()), (None, &b""[..]));
    }

    #[test]
    fn integers_and_line_ends() {
        let mut words = Words::new(b"12 999999999 1234567890 1.5\n7", "a");
        assert_eq!(words.small_integer(), Some(12));
        assert_eq!(words.small_integer(), Some(999_999_999));
        assert_eq!(
            (words.small_integer(), words.number()),
            (None, Ok(1_234_567_890.0))
        );
        assert_eq!((words.small_integer(), words.number()), (None, Ok(1.5)));
        words.skip_spaces();
        assert!(words.at_line_end() && !words.at_end());
        assert_eq!(words.small_integer(), None);
        words.skip_blanks();
        assert_eq!(words.small_integer(), Some(7));
        assert!(words.at_line_end() && words.at_end());
    }

    #[test]
    fn numbers_that_are_none() {
        let mut words = Words::new(b"nan -inf 1.#QNAN 1x", "a.stl");
        assert!(words.number().unwrap().is_nan());
        assert_eq!(words.number(), Ok(f64::INFINITY));
        assert!(words.number().unwrap().is_nan());
        let error = words.number().unwrap_err().to_string();
        assert!(
            error.starts_with("a.stl:1:18: found \"1x\", expected a number"),
            "{error}"
        );
    }
}
