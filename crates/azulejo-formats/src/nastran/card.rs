//! Cards of bulk data: a name and its fields, over one or more lines.
//!
//! A line has fields of 8 characters; of 16, where an asterisk follows the name or begins the continuation;
//! or any, separated by commas, where one of them is among the first ten characters.

use crate::reading::cursor::{TextCursor, is_line_end};
use std::borrow::Cow;

/// A line of a bulk data file, without its comment.
#[derive(Clone, Copy)]
pub(super) struct BulkLine<'a> {
    /// What precedes the comment, without blanks at the end.
    pub text: &'a [u8],
    /// The comment from its dollar sign on; empty if there is none.
    pub comment: &'a [u8],
    /// Offset of the line.
    pub at: usize,
}

/// The lines of a file.
#[derive(Clone, Copy)]
pub(super) struct BulkLines<'a> {
    pub text: TextCursor<'a>,
}

impl<'a> Iterator for BulkLines<'a> {
    type Item = BulkLine<'a>;

    fn next(&mut self) -> Option<BulkLine<'a>> {
        if self.text.at_end() {
            return None;
        }
        let at = self.text.offset();
        let line = self.text.take_while(|b| !is_line_end(b));
        self.text.pass_line_end();
        let dollar = line.iter().position(|&b| b == b'$');
        let (text, comment) = line.split_at(dollar.unwrap_or(line.len()));
        Some(BulkLine {
            text: text.trim_ascii_end(),
            comment,
            at,
        })
    }
}

impl BulkLine<'_> {
    /// Whether this continues the card before it.
    pub fn continues(&self) -> bool {
        let head = &self.text[..self.text.len().min(8)];
        let first = head.split(|b| matches!(b, b',' | b'\t')).next();
        let first = first.unwrap_or_default().trim_ascii_start();
        matches!(first, [] | [b'+' | b'*', ..])
    }

    /// The name of the card in capitals, without the asterisk; blank in a continuation.
    pub fn name(&self) -> Vec<u8> {
        let end = |b: &u8| matches!(b, b',' | b'*' | b' ' | b'\t');
        let text = self.text.trim_ascii_start();
        let name = text.split(end).next().unwrap_or_default();
        name[..name.len().min(8)].to_ascii_uppercase()
    }
}

/// A field of a card.
#[derive(Clone, Copy, Debug)]
struct CardField {
    start: usize,
    end: usize,
    /// Offset in the file.
    at: usize,
}

/// A card with all its fields.
#[derive(Debug, Default)]
pub(super) struct BulkCard {
    /// The name in capitals.
    pub name: Vec<u8>,
    /// Offset of its first line.
    pub at: usize,
    text: Vec<u8>,
    fields: Vec<CardField>,
    /// What the last field of the last line says of the continuation.
    next: Vec<u8>,
    /// Whether a line has more fields than there are.
    pub is_long: bool,
}

/// Fields of data in a line.
const FIELDS: usize = 8;

impl BulkCard {
    /// Begins a card with its first line.
    pub fn begin(&mut self, line: &BulkLine) {
        self.name = line.name();
        self.at = line.at;
        self.text.clear();
        self.fields.clear();
        self.next.clear();
        self.is_long = false;
        self.push_line(line);
    }

    /// Appends a line that continues the card; returns whether it is named as the line before expects.
    pub fn push(&mut self, line: &BulkLine) -> bool {
        let expected = std::mem::take(&mut self.next);
        let name = self.push_line(line);
        let plain = |name: &[u8]| match name {
            [b'+' | b'*', rest @ ..] => rest.trim_ascii().to_ascii_uppercase(),
            other => other.trim_ascii().to_ascii_uppercase(),
        };
        let (name, expected) = (plain(&name), plain(&expected));
        name.is_empty() || expected.is_empty() || name == expected
    }

    /// Appends the fields of a line, and returns what stands in the place of the name.
    fn push_line(&mut self, line: &BulkLine) -> Vec<u8> {
        let head = &line.text[..line.text.len().min(10)];
        if head.contains(&b',') {
            return self.push_free(line);
        }
        let text = expanded(line.text);
        let first = &text[..text.len().min(8)];
        let (width, count) = if first.contains(&b'*') {
            (16, FIELDS / 2)
        } else {
            (8, FIELDS)
        };
        for k in 0..count {
            let start = 8 + width * k;
            let end = (start + width).min(text.len());
            self.push_field(text.get(start..end).unwrap_or_default(), line.at + start);
        }
        self.next = text.get(72..).unwrap_or_default().to_vec();
        first.to_vec()
    }

    fn push_free(&mut self, line: &BulkLine) -> Vec<u8> {
        let mut offset = line.at;
        let mut fields = line.text.split(|&b| b == b',').map(|field| {
            let at = offset;
            offset += field.len() + 1;
            (field, at)
        });
        let (first, _) = fields.next().unwrap_or_default();
        let count = if first.contains(&b'*') {
            FIELDS / 2
        } else {
            FIELDS
        };
        let mut done = 0;
        for (field, at) in fields.by_ref().take(count) {
            self.push_field(field, at);
            done += 1;
        }
        self.next = fields
            .next()
            .map(|(field, _)| field.to_vec())
            .unwrap_or_default();
        self.is_long |= fields.any(|(field, _)| !field.trim_ascii().is_empty());
        for _ in done..count {
            self.push_field(b"", line.at);
        }
        first.to_vec()
    }

    fn push_field(&mut self, field: &[u8], at: usize) {
        let blanks = field.len() - field.trim_ascii_start().len();
        let start = self.text.len();
        self.text.extend_from_slice(field.trim_ascii());
        self.fields.push(CardField {
            start,
            end: self.text.len(),
            at: at + blanks,
        });
    }

    /// A field by its number, where 1 is the one after the name, and each further line adds eight, or four
    /// if it is wide. Blank beyond the last.
    pub fn field(&self, number: usize) -> &[u8] {
        let field = self.fields.get(number - 1);
        field.map_or(b"", |f| &self.text[f.start..f.end])
    }

    /// Number of fields, blank ones included.
    pub fn len(&self) -> usize {
        self.fields.len()
    }

    /// The offset of a field in the file.
    pub fn offset(&self, number: usize) -> usize {
        self.fields.get(number - 1).map_or(self.at, |f| f.at)
    }
}

/// A line whose tabs are blanks up to the next column of a field.
fn expanded(line: &[u8]) -> Cow<'_, [u8]> {
    if !line.contains(&b'\t') {
        return line.into();
    }
    let mut text = Vec::with_capacity(line.len() + 8);
    for &byte in line {
        match byte {
            b'\t' => text.resize(text.len() / 8 * 8 + 8, b' '),
            other => text.push(other),
        }
    }
    text.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str, name: &str, expected: &[&str]) {
        let mut lines = BulkLines {
            text: TextCursor::new(text.as_bytes()),
        };
        let mut card = BulkCard::default();
        card.begin(&lines.next().unwrap());
        for line in lines {
            assert!(line.continues(), "{text}");
            assert!(card.push(&line), "{text}");
        }
        let mut fields: Vec<_> = (1..=card.len())
            .map(|k| String::from_utf8_lossy(card.field(k)).into_owned())
            .collect();
        while fields.last().is_some_and(String::is_empty) {
            fields.pop();
        }
        assert_eq!(
            (&*card.name, fields),
            (
                name.as_bytes(),
                expected.iter().map(|s| s.to_string()).collect()
            ),
            "{text}"
        );
    }

    #[test]
    fn fields_of_every_width() {
        check(
            "GRID          12       2  1.5-3     2.$ here",
            "GRID",
            &["12", "2", "1.5-3", "2."],
        );
        check(
            "grid*                 12               2           1.5-3              2.*A\n*A              -1.0",
            "GRID",
            &["12", "2", "1.5-3", "2.", "-1.0"],
        );
        check("GRID,12,,0., .5 ,1.", "GRID", &["12", "", "0.", ".5", "1."]);
        check(
            "GRID*,12,,0., .5\n*,1.",
            "GRID",
            &["12", "", "0.", ".5", "1."],
        );
        check(
            "CQUAD8  1       2       3       4       5       6       7       8       +\n+       9       10",
            "CQUAD8",
            &["1", "2", "3", "4", "5", "6", "7", "8", "9", "10"],
        );
        check(
            "CTRIA3\t1\t2\t3\t4\t5",
            "CTRIA3",
            &["1", "2", "3", "4", "5"],
        );
        check(
            "CQUAD8,1,2,3,4,5,6,7,8,+A\n+A,9\n,,17",
            "CQUAD8",
            &[
                "1", "2", "3", "4", "5", "6", "7", "8", "9", "", "", "", "", "", "", "", "", "17",
            ],
        );
    }

    #[test]
    fn continuations_are_told_by_their_names() {
        let mut card = BulkCard::default();
        let line = |text: &'static str| {
            BulkLines {
                text: TextCursor::new(text.as_bytes()),
            }
            .next()
            .unwrap()
        };
        card.begin(&line("CHEXA,1,2,3,4,5,6,7,8,+A"));
        assert!(!card.push(&line("+B,9")));
        for text in ["CHEXA", " CHEXA,1", "  CHEXA 1"] {
            assert!(!line(text).continues(), "{text}");
        }
        for text in ["+A", "*,1", ",1", "\t1", "        CHEXA", "  +,1"] {
            assert!(line(text).continues(), "{text}");
        }
    }
}
