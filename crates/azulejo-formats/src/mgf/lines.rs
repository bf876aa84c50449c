//! Statements of a text file and their words, for MGF.
//!
//! A line is a statement. A backslash at the end of a line continues it, also in comments. A word
//! that begins with `#` begins a comment.

use crate::Position;
use crate::reading::cursor::{TextCursor, is_line_end};
use crate::reading::number;
use crate::surface::repeated::TextAddress;

/// A cursor over the bytes of a text file, between two statements.
#[derive(Clone, Debug)]
pub(super) struct MgfLines<'a> {
    text: TextCursor<'a>,
}

/// A position to return to, or to report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct StatementMark {
    at: usize,
}

#[inline]
fn is_blank(b: u8) -> bool {
    matches!(b, b' ' | b'\t' | 0x0b | 0x0c)
}

impl<'a> MgfLines<'a> {
    /// A cursor at the start of a text.
    pub fn new(bytes: &'a [u8]) -> MgfLines<'a> {
        MgfLines {
            text: TextCursor::new(bytes),
        }
    }

    /// The position after the last statement.
    pub fn mark(&self) -> StatementMark {
        StatementMark {
            at: self.text.offset(),
        }
    }

    /// The address of the statement at a position.
    pub fn address(&self, mark: StatementMark) -> TextAddress {
        self.text.bytes()[mark.at..].as_ptr()
    }

    /// Returns to a position in this text.
    pub fn return_to(&mut self, mark: StatementMark) {
        self.text.move_to(mark.at);
    }

    /// Line and column of a position. Takes time proportional to its offset.
    pub fn position(&self, mark: StatementMark) -> Position {
        self.text.position(mark.at)
    }

    /// Reads the words of the next statement, at least one, into `words`, and returns its position;
    /// `None` at the end of the text.
    pub fn next(&mut self, words: &mut Vec<&'a [u8]>) -> Option<StatementMark> {
        words.clear();
        let mut start = self.mark();
        loop {
            match self.text.peek() {
                None => return (!words.is_empty()).then_some(start),
                Some(b) if is_line_end(b) => {
                    self.text.pass_line_end();
                    if !words.is_empty() {
                        return Some(start);
                    }
                }
                Some(b) if is_blank(b) => self.text.advance(1),
                Some(b'\\') if self.continues() => self.pass_continuation(),
                Some(b'#') => self.skip_comment(),
                Some(_) => {
                    if words.is_empty() {
                        start = self.mark();
                    }
                    words.push(self.word());
                }
            }
        }
    }

    fn word(&mut self) -> &'a [u8] {
        let start = self.text.offset();
        while let Some(b) = self.text.peek() {
            if is_blank(b) || is_line_end(b) || (b == b'\\' && self.continues()) {
                break;
            }
            self.text.advance(1);
        }
        &self.text.bytes()[start..self.text.offset()]
    }

    /// Whether the backslash here is the last of its line.
    fn continues(&self) -> bool {
        self.text.peek_at(1).is_none_or(is_line_end)
    }

    fn pass_continuation(&mut self) {
        self.text.advance(1);
        self.text.pass_line_end();
    }

    fn skip_comment(&mut self) {
        while let Some(b) = self.text.peek() {
            match b {
                b'\\' if self.continues() => self.pass_continuation(),
                _ if is_line_end(b) => break,
                _ => self.text.advance(1),
            }
        }
    }
}

/// A word as a finite number.
pub(super) fn number(word: &[u8]) -> Option<f64> {
    let parsed = number::parse(word)?;
    (parsed.length == word.len() && parsed.value.is_finite()).then_some(parsed.value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reading::text::text;

    fn check(source: &str, expected: &[&str]) {
        let (mut lines, mut words) = (MgfLines::new(source.as_bytes()), Vec::new());
        let mut statements = Vec::new();
        while let Some(mark) = lines.next(&mut words) {
            let Position::Line(line, column) = lines.position(mark) else {
                unreachable!("text has lines")
            };
            let words: Vec<_> = words.iter().map(|w| text(w)).collect();
            statements.push(format!("{line}:{column} {}", words.join("|")));
        }
        assert_eq!(statements, expected, "{source:?}");
    }

    #[test]
    fn statements() {
        check(
            "c red =\n\n\tcxy .6 .3 # warm\r\nm",
            &["1:1 c|red|=", "3:2 cxy|.6|.3", "4:1 m"],
        );
        check("f a\\\n b \\\r\n\tc\nf d", &["1:1 f|a|b|c", "4:1 f|d"]);
        check("# lost \\\n also lost\r#lost\ro x\\", &["4:1 o|x"]);
        check("i ..\\a\\b.mgf\\c", &["1:1 i|..\\a\\b.mgf\\c"]);
        check("", &[]);
        check("\\", &[]);
        check("é x\n  é\u{0} y", &["1:1 é|x", "2:3 é\u{0}|y"]);
    }

    #[test]
    fn places_can_be_returned_to() {
        let (mut lines, mut words) = (MgfLines::new(b"a\nb\n\nc"), Vec::new());
        lines.next(&mut words);
        let mark = lines.mark();
        lines.next(&mut words);
        lines.next(&mut words);
        assert_eq!(words, [b"c"]);
        lines.return_to(mark);
        let start = lines.next(&mut words).unwrap();
        assert_eq!(
            (words[0], lines.position(start)),
            (&b"b"[..], Position::Line(2, 1))
        );
    }

    #[test]
    fn numbers_are_whole_words() {
        assert_eq!(number(b"-.5e1"), Some(-5.0));
        assert_eq!(number(b"5m"), None);
        assert_eq!(number(b"1e999"), None);
        assert_eq!(number(b""), None);
    }
}
