//! Words, numbers and strings of VRML 1.0, VRML97 and classic X3D, over bytes.
//!
//! The three share their tokens: blanks, commas and comments separate them, brackets stand alone,
//! and whatever begins like a number is one. Words are accepted liberally, because files of all
//! ages contain names with dots and signs that no grammar allows. An unterminated string or comment
//! ends with the file.

use crate::ReadError;
use crate::reading::cursor::TextCursor;
use crate::reading::number;
use crate::reading::text::{quoted, shortened, text};
use std::borrow::Cow;

/// A cursor over the tokens of a text.
#[derive(Clone, Copy, Debug)]
pub(super) struct VrmlLexer<'a> {
    text: TextCursor<'a>,
}

/// Blanks; the comma, which is one everywhere; and NUL, which old programs use for padding.
#[inline]
fn is_blank(b: u8) -> bool {
    matches!(b, b' ' | b'\n' | b'\r' | b'\t' | b',' | 0x0b | 0x0c | 0)
}

/// Whether this byte terminates a word.
#[inline]
fn ends_word(b: u8) -> bool {
    is_blank(b) || matches!(b, b'{' | b'}' | b'[' | b']' | b'"' | b'#')
}

impl<'a> VrmlLexer<'a> {
    /// A cursor at the start of a text. The header is a comment.
    pub fn new(bytes: &'a [u8]) -> VrmlLexer<'a> {
        VrmlLexer {
            text: TextCursor::new(bytes),
        }
    }

    /// The current offset, for a position.
    pub fn offset(&self) -> usize {
        self.text.offset()
    }

    /// The remaining bytes.
    fn rest(&self) -> &'a [u8] {
        self.text.rest()
    }

    /// Skips blanks, commas and comments.
    #[inline]
    pub fn skip_blanks(&mut self) {
        while let Some(b) = self.text.peek() {
            if is_blank(b) {
                self.text.advance(1);
            } else if b == b'#' {
                self.text.take_line();
            } else if b == b'/' && self.text.peek_at(1) == Some(b'*') {
                self.skip_block();
            } else {
                break;
            }
        }
    }

    /// Skips a block comment of X3D 4.
    fn skip_block(&mut self) {
        let rest = &self.rest()[2..];
        let end = rest.windows(2).position(|w| w == b"*/");
        self.text.advance(2 + end.map_or(rest.len(), |end| end + 2));
    }

    /// The first byte of the next token, which is not consumed; `None` at the end.
    #[inline]
    pub fn peek(&mut self) -> Option<u8> {
        self.skip_blanks();
        self.text.peek()
    }

    /// Takes `mark` (one of `{ } [ ]`, or any other byte) if it comes next.
    #[inline]
    pub fn take(&mut self, mark: u8) -> bool {
        let is_next = self.peek() == Some(mark);
        self.text.advance(usize::from(is_next));
        is_next
    }

    /// The next word, up to a blank, a bracket, a quote or a comment; `None` if something else
    /// comes next.
    #[inline]
    pub fn word(&mut self) -> Option<&'a [u8]> {
        self.word_until(|_| false)
    }

    /// Like [`VrmlLexer::word`], but bytes for which `is_mark` holds end a word, too.
    #[inline]
    pub fn word_until(&mut self, is_mark: impl Fn(u8) -> bool) -> Option<&'a [u8]> {
        self.skip_blanks();
        let rest = self.rest();
        let end = rest.iter().position(|&b| ends_word(b) || is_mark(b));
        let word = &rest[..end.unwrap_or(rest.len())];
        self.text.advance(word.len());
        (!word.is_empty()).then_some(word)
    }

    /// The next word, which is not consumed.
    pub fn peek_word(&mut self) -> Option<&'a [u8]> {
        { *self }.word()
    }

    /// Takes the next word if it is `word`.
    pub fn take_word(&mut self, word: &[u8]) -> bool {
        self.skip_blanks();
        let is_next = self.peek_word() == Some(word);
        if is_next {
            self.text.advance(word.len());
        }
        is_next
    }

    /// Whether a number comes next.
    pub fn at_number(&mut self) -> bool {
        { *self }.number().is_some()
    }

    /// The next token as a number: decimal, `0x` hexadecimal, or NaN for what printing functions
    /// emit for invalid results (`nan`, `-1.#IND`, `inf`).
    #[inline]
    pub fn number(&mut self) -> Option<f64> {
        self.skip_blanks();
        let rest = self.rest();
        let Some(number) = number::parse(rest) else {
            return self.no_number();
        };
        match rest.get(number.length) {
            Some(b'x' | b'X') if number.value == 0.0 => Some(self.hexadecimal(number.length + 1)),
            Some(b'#') => Some(self.printed_nan(number)),
            _ => {
                self.text.advance(number.length);
                Some(number.value)
            }
        }
    }

    /// Digits after `0x`, which ends `start` bytes into the rest.
    #[cold]
    fn hexadecimal(&mut self, start: usize) -> f64 {
        let digits = self.rest()[start..]
            .iter()
            .map_while(|&b| (b as char).to_digit(16));
        let (value, count) = digits.fold((0.0, 0), |(value, count), digit| {
            (value * 16.0 + f64::from(digit), count + 1)
        });
        self.text.advance(start + count);
        value
    }

    /// A number with a `#` directly behind it: `1.#QNAN`, or a comment.
    #[cold]
    fn printed_nan(&mut self, number: number::Number) -> f64 {
        self.text.advance(number.length);
        let words: [&[u8]; 4] = [b"#QNAN", b"#SNAN", b"#IND", b"#INF"];
        match words.iter().find(|w| self.rest().starts_with(w)) {
            Some(word) => {
                self.text.advance(word.len());
                let digits = self.rest().iter().take_while(|b| b.is_ascii_digit());
                self.text.advance(digits.count());
                f64::NAN
            }
            None => number.value,
        }
    }

    /// `nan`, `inf` and the like, as NaN.
    #[cold]
    fn no_number(&mut self) -> Option<f64> {
        let word = self.peek_word()?;
        let bare = word.strip_prefix(b"-").unwrap_or(word);
        let bare = bare.strip_prefix(b"+").unwrap_or(bare);
        let known: [&[u8]; 4] = [b"nan", b"nan(ind)", b"inf", b"infinity"];
        known.iter().any(|k| bare.eq_ignore_ascii_case(k)).then(|| {
            self.text.advance(word.len());
            f64::NAN
        })
    }

    /// All numbers up to the next other token, or up to `most`.
    pub fn numbers(&mut self, most: usize, into: &mut Vec<f64>) {
        let most = into.len().saturating_add(most);
        while into.len() < most
            && let Some(value) = self.number()
        {
            into.push(value);
        }
    }

    /// All numbers up to the next other token, as integers: truncated towards zero, clamped to the
    /// range of the type, 0 for NaN.
    pub fn integers(&mut self, into: &mut Vec<i32>) {
        while let Some(value) = self.integer() {
            into.push(value);
        }
    }

    /// The next number as an integer.
    #[inline]
    pub fn integer(&mut self) -> Option<i32> {
        self.skip_blanks();
        let rest = self.rest();
        let negative = rest.first() == Some(&b'-');
        let start = usize::from(negative);
        let digits = rest[start..].iter().take(9);
        let (mut value, mut count) = (0i32, 0);
        for &b in digits.take_while(|b| b.is_ascii_digit()) {
            value = 10 * value + i32::from(b - b'0');
            count += 1;
        }
        // Anything longer or more complex than nine digits takes the general path.
        let plain = rest.get(start + count).is_none_or(|&b| ends_word(b));
        if count == 0 || !plain {
            return self.number().map(|value| value as i32);
        }
        self.text.advance(start + count);
        Some(if negative { -value } else { value })
    }

    /// A string in double quotes; `None` if something else comes next. `\"` and `\\` stand for the
    /// escaped character.
    pub fn string(&mut self) -> Option<Cow<'a, str>> {
        if !self.take(b'"') {
            return None;
        }
        let rest = self.rest();
        let mut escaped = false;
        let end = rest.iter().position(|&b| match b {
            _ if escaped => {
                escaped = false;
                false
            }
            b'\\' => {
                escaped = true;
                false
            }
            b => b == b'"',
        });
        let inside = &rest[..end.unwrap_or(rest.len())];
        self.text.advance((inside.len() + 1).min(rest.len()));
        Some(unescaped(inside))
    }

    /// Skips the next token, whatever it is; `false` at the end.
    pub fn skip_token(&mut self) -> bool {
        match self.peek() {
            None => return false,
            Some(b'"') => drop(self.string()),
            Some(_) if self.word().is_some() => {}
            Some(_) => self.text.advance(1),
        }
        true
    }

    /// Skips tokens up to and including the bracket that closes the current nesting level. `false`
    /// if the file ends first.
    pub fn skip_to_close(&mut self) -> bool {
        let mut depth = 0u64;
        loop {
            let mark = self.peek();
            if !self.skip_token() {
                return false;
            }
            match mark {
                Some(b'{' | b'[') => depth += 1,
                Some(b'}' | b']') if depth == 0 => return true,
                Some(b'}' | b']') => depth -= 1,
                _ => {}
            }
        }
    }

    /// Whether only blanks are left.
    pub fn at_end(&mut self) -> bool {
        self.peek().is_none()
    }

    /// A description of the next token, for messages.
    pub fn found(&self) -> String {
        let mut ahead = *self;
        match ahead.peek() {
            None => "the end of the file".into(),
            Some(b'"') => {
                let string = ahead.string().unwrap_or_default();
                format!("the string \"{}\"", shortened(&string))
            }
            Some(b) => match ahead.word() {
                Some(word) => quoted(word),
                None => format!("\"{}\"", b.escape_ascii()),
            },
        }
    }

    /// An error at the position of the next token.
    pub fn error(&mut self, file: &str, expected: &str) -> ReadError {
        let found = self.found();
        self.skip_blanks();
        self.text.error(file, self.text.offset(), found, expected)
    }
}

/// A string with its escapes resolved.
fn unescaped(inside: &[u8]) -> Cow<'_, str> {
    if !inside.contains(&b'\\') {
        return text(inside);
    }
    let mut plain = Vec::with_capacity(inside.len());
    let mut bytes = inside.iter();
    while let Some(&b) = bytes.next() {
        let b = if b == b'\\' { bytes.next() } else { Some(&b) };
        plain.extend(b);
    }
    Cow::Owned(text(&plain).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens() {
        let mut l = VrmlLexer::new(b"#VRML V2.0 utf8\r\nDEF a.b-1{x[,,1 -2,]/* * */}#end");
        assert_eq!(l.word(), Some(&b"DEF"[..]));
        assert!(!l.take_word(b"a"));
        assert!(l.take_word(b"a.b-1"));
        assert_eq!(l.word(), None);
        assert!(l.take(b'{') && l.take_word(b"x") && l.take(b'['));
        let mut numbers = Vec::new();
        l.numbers(usize::MAX, &mut numbers);
        assert_eq!(numbers, [1.0, -2.0]);
        assert!(l.take(b']') && l.take(b'}') && l.at_end() && !l.skip_token());
    }

    #[test]
    fn numbers_of_every_kind() {
        let check = |text: &str, expected: Option<f64>| {
            let number = VrmlLexer::new(text.as_bytes()).number();
            assert_eq!(
                number.map(f64::to_bits),
                expected.map(f64::to_bits),
                "{text}"
            );
        };
        check(" +1.5e1,", Some(15.0));
        check("0xFF00", Some(65280.0));
        check("0x", Some(0.0));
        check("1.#comment", Some(1.0));
        check("-1.#IND00", Some(f64::NAN));
        check("-NaN", Some(f64::NAN));
        check("information", None);
        check("]", None);
    }

    #[test]
    fn integers_of_every_kind() {
        let check = |text: &str, expected: &[i32]| {
            let mut integers = Vec::new();
            VrmlLexer::new(text.as_bytes()).integers(&mut integers);
            assert_eq!(integers, expected, "{text}");
        };
        check("0 1,2 -1]", &[0, 1, 2, -1]);
        check("+3 2.9 0x10 1e2", &[3, 2, 16, 100]);
        check(
            "123456789 1234567890 99999999999 -99999999999",
            &[123_456_789, 1_234_567_890, i32::MAX, i32::MIN],
        );
        check("-", &[]);
    }

    #[test]
    fn strings() {
        let check = |text: &str, expected: Option<&str>, rest: &str| {
            let mut l = VrmlLexer::new(text.as_bytes());
            assert_eq!(l.string().as_deref(), expected, "{text}");
            assert_eq!(l.rest(), rest.as_bytes(), "{text}");
        };
        check("\"a b\nc\"d", Some("a b\nc"), "d");
        check(r#" "say \"\\\" # 1"]"#, Some(r#"say "\" # 1"#), "]");
        check("\"never ends", Some("never ends"), "");
        check("\"ends in \\", Some("ends in "), "");
        check("word", None, "word");
    }

    #[test]
    fn closing_brackets_are_found_past_strings_and_comments() {
        let mut l = VrmlLexer::new(b"a [ b { \"}\" # }\n } ] } c");
        assert!(l.skip_to_close());
        assert_eq!(l.word(), Some(&b"c"[..]));
        assert!(!l.skip_to_close());
    }

    #[test]
    fn an_error_shows_its_line() {
        let mut l = VrmlLexer::new(b"Group {\r  children ]\r}");
        l.word();
        l.take(b'{');
        l.word();
        let message = l.error("a.wrl", "a node").to_string();
        assert!(
            message.starts_with("a.wrl:2:12: found \"]\", expected a node"),
            "{message}"
        );
        assert!(message.contains("2 |   children ]"), "{message}");
    }
}
