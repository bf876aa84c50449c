//! Tokens of azulejo's own languages, GRF and reflection models: words, numbers and names,
//! without an intermediate token list.
//!
//! The parser requests the token it needs next; blanks and comments before it are skipped. Nothing
//! here allocates, so that a vertex costs little more than its numbers.

use super::cursor::TextCursor;
use super::text::shortened;

/// A cursor over the tokens of a text. Copies serve for lookahead.
#[derive(Clone, Copy)]
pub(crate) struct Lexer<'a> {
    cursor: TextCursor<'a, str>,
}

/// Why a number could not be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BadNumber {
    /// The next token is something else.
    Missing,
    /// It begins like a number, but is malformed.
    Malformed,
    /// It has no finite value, or an index has more digits than any mesh could need.
    TooLarge,
}

/// Whether a byte may occur in a keyword or identifier. The grammar allows ASCII only; letters of
/// other alphabets are accepted because they occur in practice.
fn is_word_byte(b: u8) -> bool {
    b.is_ascii_alphanumeric() || matches!(b, b'_' | b'$') || b >= 0x80
}

fn is_blank(b: u8) -> bool {
    matches!(b, b' ' | b'\t' | b'\n' | b'\r' | 0x0b | 0x0c)
}

impl<'a> Lexer<'a> {
    pub fn new(text: &'a str) -> Lexer<'a> {
        Lexer {
            cursor: TextCursor::new(text),
        }
    }

    /// The whole text, whatever the position.
    pub fn text(&self) -> &'a str {
        self.cursor.text()
    }

    /// Byte offset of the unread text, including blanks.
    pub fn pos(&self) -> usize {
        self.cursor.offset()
    }

    /// The text from `start` to the cursor.
    fn since(&self, start: usize) -> &'a str {
        &self.text()[start..self.pos()]
    }

    fn byte(&self, pos: usize) -> Option<u8> {
        self.cursor.bytes().get(pos).copied()
    }

    /// The end of the longest run of matching bytes from here.
    fn run(&self, matches: impl Fn(u8) -> bool) -> usize {
        let rest = self.cursor.rest();
        self.pos() + rest.iter().position(|&b| !matches(b)).unwrap_or(rest.len())
    }

    /// Skips blanks and comments; returns the offset of the next token.
    pub fn skip_blank(&mut self) -> usize {
        loop {
            self.cursor.move_to(self.run(is_blank));
            if !self.cursor.rest().starts_with(b"//") {
                return self.pos();
            }
            self.cursor.take_line();
        }
    }

    /// The comments before anything else, without their `//`.
    pub fn leading_comments(&self) -> Vec<String> {
        let mut comments = Vec::new();
        let mut lexer = *self;
        loop {
            lexer.cursor.take_while(is_blank);
            let start = lexer.pos();
            lexer.cursor.take_line();
            match lexer.since(start).strip_prefix("//") {
                Some(comment) => comments.push(comment.trim_end().to_owned()),
                None => return comments,
            }
        }
    }

    /// The next byte that is neither blank nor comment.
    pub fn peek(&mut self) -> Option<u8> {
        let pos = self.skip_blank();
        self.byte(pos)
    }

    /// Takes one ASCII character if it comes next.
    pub fn eat(&mut self, wanted: u8) -> bool {
        let is_next = self.peek() == Some(wanted);
        self.cursor.advance(usize::from(is_next));
        is_next
    }

    /// The next word, which is not consumed.
    pub fn peek_word(mut self) -> Option<&'a str> {
        self.word()
    }

    /// Reads a keyword or identifier: letters, digits, `$`, `_`; hyphens inside, as in
    /// `oren-nayar`.
    pub fn word(&mut self) -> Option<&'a str> {
        let start = self.skip_blank();
        let mut end = self.run(is_word_byte);
        while end > start
            && self.byte(end) == Some(b'-')
            && self.byte(end + 1).is_some_and(|b| b.is_ascii_alphabetic())
        {
            self.cursor.move_to(end + 1);
            end = self.run(is_word_byte);
        }
        self.cursor.move_to(end);
        (end > start).then(|| &self.text()[start..end])
    }

    /// Consumes a keyword, case-insensitively, if it comes next.
    pub fn eat_word(&mut self, keyword: &str) -> bool {
        let mut ahead = *self;
        let is_next = ahead
            .word()
            .is_some_and(|word| word.eq_ignore_ascii_case(keyword));
        if is_next {
            *self = ahead;
        }
        is_next
    }

    /// Whether a number comes next.
    pub fn at_number(&mut self) -> bool {
        let mut ahead = *self;
        ahead.number() != Err(BadNumber::Missing)
    }

    fn skip_digits(&mut self) -> usize {
        let start = self.pos();
        self.cursor.move_to(self.run(|b| b.is_ascii_digit()));
        self.pos() - start
    }

    /// Reads a number: sign, digits, fraction, exponent, and a suffix `f` or `d`.
    pub fn number(&mut self) -> Result<f64, BadNumber> {
        let start = self.skip_blank();
        let scanned = self.scan_number();
        let end = self.pos();
        if scanned.is_err() {
            self.cursor.move_to(start);
        }
        let digits = scanned?;
        let value: f64 = self.text()[start..digits]
            .parse()
            .map_err(|_| BadNumber::Malformed)?;
        if !value.is_finite() {
            self.cursor.move_to(start);
            return Err(BadNumber::TooLarge);
        }
        self.cursor.move_to(end);
        Ok(value)
    }

    /// Skips a number; returns its end without the suffix.
    fn scan_number(&mut self) -> Result<usize, BadNumber> {
        let start = self.pos();
        if matches!(self.byte(self.pos()), Some(b'+' | b'-')) {
            self.cursor.advance(1);
        }
        let mut digits = self.skip_digits();
        let point = self.byte(self.pos()) == Some(b'.');
        if point {
            self.cursor.advance(1);
            digits += self.skip_digits();
        }
        if digits == 0 {
            return Err(BadNumber::Missing);
        }
        if matches!(self.byte(self.pos()), Some(b'e' | b'E')) {
            self.cursor.advance(1);
            if matches!(self.byte(self.pos()), Some(b'+' | b'-')) {
                self.cursor.advance(1);
            }
            if self.skip_digits() == 0 {
                return Err(self.word_or_malformed(start));
            }
        }
        let end = self.pos();
        if matches!(self.byte(end), Some(b'f' | b'F' | b'd' | b'D')) {
            self.cursor.advance(1);
        }
        match self.byte(self.pos()) {
            Some(b) if is_word_byte(b) => Err(self.word_or_malformed(start)),
            Some(b'.')
                if self
                    .byte(self.pos() + 1)
                    .is_some_and(|b| b.is_ascii_digit()) =>
            {
                Err(BadNumber::Malformed)
            }
            _ => Ok(end),
        }
    }

    /// The error for a token that begins like a number: `3rd` is an identifier.
    fn word_or_malformed(&self, start: usize) -> BadNumber {
        let mut word = Lexer {
            cursor: self.cursor.moved_to(start),
        };
        match word.word() {
            Some(text)
                if text.bytes().any(|b| b.is_ascii_alphabetic()) && word.pos() > self.pos() =>
            {
                BadNumber::Missing
            }
            _ => BadNumber::Malformed,
        }
    }

    /// Reads an index: digits only, below 2^32.
    pub fn index(&mut self) -> Result<u32, BadNumber> {
        let start = self.skip_blank();
        let count = self.skip_digits();
        let fail = |lexer: &mut Lexer<'a>, bad| {
            lexer.cursor.move_to(start);
            Err(bad)
        };
        if count == 0 {
            return Err(BadNumber::Missing);
        }
        if self
            .byte(self.pos())
            .is_some_and(|b| is_word_byte(b) || b == b'.')
        {
            return fail(self, BadNumber::Malformed);
        }
        match self.since(start).parse() {
            Ok(index) => Ok(index),
            Err(_) => fail(self, BadNumber::TooLarge),
        }
    }

    /// Reads a file name: in double quotes, or without blanks. `None` if the quotes are not closed
    /// on the line, or nothing follows.
    pub fn file_name(&mut self) -> Option<&'a str> {
        let start = self.skip_blank();
        if self.byte(start) != Some(b'"') {
            self.cursor.move_to(self.run(|b| !is_blank(b)));
            return (self.pos() > start).then(|| self.since(start));
        }
        let inner = &self.text()[start + 1..];
        let end = inner.find(['"', '\n', '\r'])?;
        if inner.as_bytes()[end] != b'"' {
            return None;
        }
        self.cursor.move_to(start + end + 2);
        Some(&inner[..end])
    }

    /// Reads the quoted text of an extension, with its escapes unresolved: a backslash escapes the
    /// next character. `None` if it is not closed on the line.
    pub fn escaped_text(&mut self) -> Option<&'a str> {
        let start = self.skip_blank();
        let bytes = self.cursor.bytes();
        let mut end = start + 1;
        loop {
            match bytes.get(end)? {
                b'"' => break,
                b'\n' | b'\r' => return None,
                b'\\' if !matches!(bytes.get(end + 1), Some(b'\n' | b'\r')) => end += 2,
                _ => end += 1,
            }
        }
        self.cursor.move_to(end + 1);
        Some(&self.text()[start + 1..end])
    }

    /// Skips one token of any type; `false` at the end of the text and before an unterminated text.
    pub fn skip_any(&mut self) -> bool {
        match self.peek() {
            None => false,
            Some(b'"') => self.escaped_text().is_some(),
            Some(b) if is_word_byte(b) => self.word().is_some(),
            Some(_) => {
                self.cursor.advance(1);
                true
            }
        }
    }

    /// Describes the next token, for messages.
    pub fn describe(mut self) -> String {
        let start = self.skip_blank();
        let Some(first) = self.byte(start) else {
            return "the end of the file".into();
        };
        if first == b'"' {
            return match self.file_name() {
                Some(name) => format!("the text \"{}\"", shortened(name)),
                None => "a string that does not end on its line".into(),
            };
        }
        if is_word_byte(first) || matches!(first, b'+' | b'-' | b'.') {
            self.cursor
                .move_to(self.run(|b| is_word_byte(b) || matches!(b, b'+' | b'-' | b'.')));
            let shown = shortened(self.since(start));
            let numeric = first.is_ascii_digit() || (first != b'.' && !is_word_byte(first));
            let kind = if numeric { "number" } else { "word" };
            return if shown == "." {
                "`.`".into()
            } else {
                format!("the {kind} `{shown}`")
            };
        }
        format!("`{}`", char::from(first))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check_number(text: &str, expected: Result<f64, BadNumber>) {
        assert_eq!(Lexer::new(text).number(), expected, "{text}");
    }

    #[test]
    fn numbers() {
        check_number(" 5.", Ok(5.0));
        check_number("-.5f", Ok(-0.5));
        check_number("+1.5E-3d,", Ok(1.5e-3));
        check_number("// none\n12)", Ok(12.0));
        check_number("0.1", Ok(0.1));
        check_number("1e999", Err(BadNumber::TooLarge));
        check_number("1e", Err(BadNumber::Malformed));
        check_number("1.2.3", Err(BadNumber::Malformed));
        check_number("1.5x", Err(BadNumber::Malformed));
        check_number("3rd", Err(BadNumber::Missing));
        check_number("nan", Err(BadNumber::Missing));
        check_number("-inf", Err(BadNumber::Missing));
        check_number(".", Err(BadNumber::Missing));
        check_number("", Err(BadNumber::Missing));
    }

    #[test]
    fn indices() {
        assert_eq!(Lexer::new(" 42,").index(), Ok(42));
        assert_eq!(Lexer::new("4.2").index(), Err(BadNumber::Malformed));
        assert_eq!(Lexer::new("-4").index(), Err(BadNumber::Missing));
        assert_eq!(Lexer::new("4294967296").index(), Err(BadNumber::TooLarge));
    }

    #[test]
    fn words_and_names() {
        let mut lexer = Lexer::new("oren-nayar $a_1-2 \"my file\" plain/name.grf \"open\n");
        assert_eq!(lexer.word(), Some("oren-nayar"));
        assert_eq!(lexer.word(), Some("$a_1"));
        assert_eq!(lexer.number(), Ok(-2.0));
        assert_eq!(lexer.file_name(), Some("my file"));
        assert_eq!(lexer.file_name(), Some("plain/name.grf"));
        assert_eq!(lexer.file_name(), None);
        assert_eq!(
            Lexer::new(r#""a\"b\\" c"#).escaped_text(),
            Some(r#"a\"b\\"#)
        );
        assert_eq!(Lexer::new("\"a\\").escaped_text(), None);
    }
}
