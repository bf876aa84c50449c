//! Words separated by white space, for the text formats STL, PLY and SFF.

use super::cursor::{TextCursor, is_line_end};
use super::number;
use super::text::quoted;
use crate::{Position, ReadError};

/// A cursor over a text of words separated by white space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Words<'a> {
    file: &'a str,
    cursor: TextCursor<'a>,
}

/// Words are separated by blanks, line ends and other control characters.
#[inline]
fn is_blank(byte: u8) -> bool {
    byte <= b' '
}

impl<'a> Words<'a> {
    /// A cursor at the start of a text. `file` is used in messages.
    pub fn new(bytes: &'a [u8], file: &'a str) -> Words<'a> {
        Words {
            file,
            cursor: TextCursor::new(bytes),
        }
    }

    /// The same text from byte `at` on.
    pub fn from(self, at: usize) -> Words<'a> {
        Words {
            cursor: self.cursor.moved_to(at),
            ..self
        }
    }

    /// Offset of the next byte.
    pub fn offset(&self) -> usize {
        self.cursor.offset()
    }

    /// Whether only blanks precede the cursor on its line.
    pub fn starts_line(&self) -> bool {
        let before = self.cursor.bytes()[..self.offset()].iter().rev();
        let mut before = before.skip_while(|&&b| is_blank(b) && !is_line_end(b));
        before.next().is_none_or(|&b| is_line_end(b))
    }

    /// The rest of the line, which is not consumed.
    pub fn line_ahead(&self) -> &'a [u8] {
        self.cursor.line_ahead()
    }

    /// Skips blanks and line ends.
    #[inline]
    pub fn skip_blanks(&mut self) {
        self.cursor.take_while(is_blank);
    }

    /// The next word; `None` at the end of the text.
    #[inline]
    pub fn word(&mut self) -> Option<&'a [u8]> {
        self.skip_blanks();
        let word = self.cursor.take_while(|b| !is_blank(b));
        (!word.is_empty()).then_some(word)
    }

    /// The rest of the line, without the blanks around it. Consumes the line end.
    pub fn rest_of_line(&mut self) -> &'a [u8] {
        let line = self.cursor.take_line();
        self.cursor.pass_line_end();
        line.trim_ascii()
    }

    /// The next word as a number; NaN and infinities included.
    ///
    /// # Errors
    /// Another word, or the end of the text.
    #[inline]
    pub fn number(&mut self) -> Result<f64, ReadError> {
        self.skip_blanks();
        if let Some(number) = number::parse(self.cursor.rest())
            && self.cursor.peek_at(number.length).is_none_or(is_blank)
        {
            self.cursor.advance(number.length);
            return Ok(number.value);
        }
        let start = self.offset();
        let word = self.word().unwrap_or_default();
        number::non_finite(word).ok_or_else(|| self.error(start, "a number"))
    }

    /// Skips blanks before the next word or line end.
    #[inline]
    pub fn skip_spaces(&mut self) {
        self.cursor.take_while(|b| is_blank(b) && !is_line_end(b));
    }

    /// The next byte, blank or not.
    #[inline]
    pub fn peek(&self) -> Option<u8> {
        self.cursor.peek()
    }

    /// Whether the line or the text ends here.
    #[inline]
    pub fn at_line_end(&self) -> bool {
        self.cursor.at_line_end()
    }

    /// Whether the text ends here.
    #[inline]
    pub fn at_end(&self) -> bool {
        self.cursor.at_end()
    }

    /// The next word as a decimal integer of at most nine digits. Any other word is not consumed.
    #[inline]
    pub fn small_integer(&mut self) -> Option<u32> {
        self.skip_spaces();
        let (mut value, mut count) = (0, 0);
        while let Some(digit) = self.cursor.peek_at(count).map(|b| b.wrapping_sub(b'0'))
            && digit < 10
            && count < 10
        {
            value = 10 * value + u64::from(digit);
            count += 1;
        }
        let ends = self.cursor.peek_at(count).is_none_or(is_blank);
        if count == 0 || !ends || count > 9 {
            return None;
        }
        self.cursor.advance(count);
        Some(value as u32)
    }

    /// Line and column of a byte, both from 1.
    pub fn position(&self, offset: usize) -> Position {
        self.cursor.position(offset)
    }

    /// An error about the word at byte `offset`.
    #[cold]
    pub fn error(&self, offset: usize, expected: &str) -> ReadError {
        let found = match self.from(offset).word() {
            Some(word) => quoted(word),
            None => "the end of the file".to_owned(),
        };
        self.error_with(offset, found, expected)
    }

    /// An error at byte `offset` with the caller's description.
    #[cold]
    pub fn error_with(
        &self,
        offset: usize,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> ReadError {
        self.cursor.error(self.file, offset, found, expected)
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
    fn words_that_are_not_numbers() {
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
