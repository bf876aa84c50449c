//! Records, such as entities: the groups from one of code 0 to the next.

use super::pairs::{Pair, Pairs, Value};
use crate::reading::text::text;
use glam::DVec3;
use std::borrow::Cow;
use std::cell::Cell;

/// Larger numbers are damage, and their squares could overflow.
const LARGEST: f64 = 1e100;

/// First code of data of applications.
const FIRST_OF_APPLICATIONS: i16 = 1000;

/// An entity, a table entry or another item that begins with a group of code 0.
#[derive(Debug, Default)]
pub(super) struct Record<'a> {
    /// Its type: `LINE`, `SECTION`...
    pub kind: &'a [u8],
    /// Its offset in the file.
    pub offset: usize,
    /// Its groups after the first, without application data.
    pub pairs: Vec<Pair<'a>>,
    /// Number of malformed numeric values since the last [`Record::take_malformed`].
    malformed: Cell<usize>,
}

/// The records of a file.
#[derive(Debug)]
pub(super) struct Records<'a> {
    /// The unread groups.
    pub pairs: Pairs<'a>,
    /// Type and offset of the next record.
    next: Option<(&'a [u8], usize)>,
}

impl<'a> Records<'a> {
    /// The start of a file. Groups before the first of code 0 are ignored.
    pub fn new(bytes: &'a [u8]) -> Records<'a> {
        let mut records = Records {
            pairs: Pairs::new(bytes),
            next: None,
        };
        records.collect(&mut Vec::new());
        records
    }

    /// Replaces `record` by the next one; `false` at the end.
    pub fn read(&mut self, record: &mut Record<'a>) -> bool {
        let Some((kind, offset)) = self.next.take() else {
            return false;
        };
        record.pairs.clear();
        (record.kind, record.offset) = (kind, offset);
        if kind != b"EOF" {
            self.collect(&mut record.pairs);
        }
        true
    }

    /// Collects groups up to the next record.
    fn collect(&mut self, into: &mut Vec<Pair<'a>>) {
        loop {
            let offset = self.pairs.offset();
            let Some(pair) = self.pairs.next() else {
                return;
            };
            if pair.code == 0 {
                self.next = Some((pair.value.text(), offset));
                return;
            }
            if pair.code < FIRST_OF_APPLICATIONS {
                into.push(pair);
            }
        }
    }
}

impl<'a> Record<'a> {
    /// The value of the first group of a code.
    #[inline]
    pub fn find(&self, code: i16) -> Option<Value<'a>> {
        let pair = self.pairs.iter().find(|pair| pair.code == code)?;
        Some(pair.value)
    }

    /// A number, or `default` if it is missing or malformed.
    pub fn real(&self, code: i16, default: f64) -> f64 {
        self.find(code)
            .map_or(default, |value| self.finite(value).unwrap_or(default))
    }

    /// An integer, or `default` if it is missing or malformed.
    pub fn integer(&self, code: i16, default: i64) -> i64 {
        self.find(code)
            .map_or(default, |value| self.whole(value).unwrap_or(default))
    }

    /// Text as stored in the file, without blanks around it; empty if it is missing.
    pub fn bytes(&self, code: i16) -> &'a [u8] {
        self.find(code).map(Value::text).unwrap_or_default()
    }

    /// Text, decoded; empty if it is missing.
    pub fn text(&self, code: i16) -> Cow<'a, str> {
        decoded(self.bytes(code))
    }

    /// A handle: the number by which other records refer to this one; 0 if it is missing.
    pub fn handle(&self, code: i16) -> u64 {
        let digits = std::str::from_utf8(self.bytes(code)).unwrap_or_default();
        u64::from_str_radix(digits, 16).unwrap_or(0)
    }

    /// A point whose x has this code, y the code plus ten and z the code plus twenty; missing
    /// coordinates are 0.
    #[inline]
    pub fn point(&self, code: i16) -> DVec3 {
        match self.pairs.iter().position(|pair| pair.code == code) {
            Some(at) => DVec3::new(
                self.coordinate(at, code),
                self.coordinate(at + 1, code + 10),
                self.coordinate(at + 2, code + 20),
            ),
            None => DVec3::new(0.0, self.real(code + 10, 0.0), self.real(code + 20, 0.0)),
        }
    }

    /// The number of a code, which is expected at an index but may be anywhere.
    #[inline]
    fn coordinate(&self, at: usize, code: i16) -> f64 {
        match self.pairs.get(at) {
            Some(pair) if pair.code == code => self.finite(pair.value).unwrap_or(0.0),
            _ => self.real(code, 0.0),
        }
    }

    /// A value as a number; `None` and counted as malformed if it is not one.
    #[inline]
    pub fn finite(&self, value: Value<'a>) -> Option<f64> {
        let number = value.real().filter(|value| value.abs() <= LARGEST);
        self.note(number)
    }

    /// A value as an integer; `None` and counted as malformed if it is not one.
    pub fn whole(&self, value: Value<'a>) -> Option<i64> {
        self.note(value.integer())
    }

    #[inline]
    fn note<T>(&self, value: Option<T>) -> Option<T> {
        if value.is_none() {
            self.malformed.set(self.malformed.get() + 1);
        }
        value
    }

    /// Number of malformed values since the last call.
    pub fn take_malformed(&self) -> usize {
        self.malformed.take()
    }
}

/// Longest name that is kept, in characters: the limit of the format, so that a long path through
/// blocks cannot fill memory.
const LONGEST_NAME: usize = 255;

/// Bytes as text: UTF-8 or Latin-1, with `\U+XXXX` for characters that older releases could not
/// represent. Text longer than a name may be is truncated.
pub(super) fn decoded(bytes: &[u8]) -> Cow<'_, str> {
    let text = text(bytes);
    let text = if text.contains("\\U+") {
        Cow::Owned(unescaped(&text))
    } else {
        text
    };
    match text.char_indices().nth(LONGEST_NAME) {
        Some((end, _)) => Cow::Owned(text[..end].to_owned()),
        None => text,
    }
}

fn unescaped(text: &str) -> String {
    let mut pieces = text.split("\\U+");
    let mut result = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let code = piece
            .get(..4)
            .and_then(|hex| u32::from_str_radix(hex, 16).ok());
        match code.and_then(char::from_u32) {
            Some(character) => {
                result.push(character);
                result.push_str(&piece[4..]);
            }
            None => {
                result.push_str("\\U+");
                result.push_str(piece);
            }
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    fn records(text: &str) -> Vec<(String, Vec<i16>)> {
        let (mut records, mut record) = (Records::new(text.as_bytes()), Record::default());
        let mut read = Vec::new();
        while records.read(&mut record) {
            let codes = record.pairs.iter().map(|pair| pair.code).collect();
            read.push((decoded(record.kind).into_owned(), codes));
        }
        read
    }

    #[test]
    fn groups_are_gathered() {
        assert_eq!(
            records("8\nlost\n0\nLINE\n8\na\n1000\nx\n10\n1\n0\nEOF\n8\nb\n"),
            [("LINE".to_owned(), vec![8, 10]), ("EOF".to_owned(), vec![]),]
        );
        assert_eq!(records(""), []);
    }

    fn only(text: &str) -> Record<'_> {
        let mut record = Record::default();
        assert!(Records::new(text.as_bytes()).read(&mut record));
        record
    }

    #[test]
    fn points_in_any_order() {
        let record = only("0\nA\n10\n1\n20\n2\n30\n3\n31\n6\n11\n4\n12\n7\n12\n8\n23\n9\n");
        assert_eq!(record.point(10), DVec3::new(1.0, 2.0, 3.0));
        assert_eq!(record.point(11), DVec3::new(4.0, 0.0, 6.0));
        assert_eq!(record.point(12), DVec3::new(7.0, 0.0, 0.0));
        assert_eq!(record.point(13), DVec3::new(0.0, 9.0, 0.0));
    }

    #[test]
    fn malformed_numbers_are_counted() {
        let record = only("0\nA\n10\n1,5\n40\n1e200\n70\nx\n5\nffz\n330\n1F\n");
        assert_eq!(record.point(10), DVec3::ZERO);
        assert_eq!((record.real(40, 2.0), record.integer(70, 3)), (2.0, 3));
        assert_eq!((record.take_malformed(), record.take_malformed()), (3, 0));
        assert_eq!(
            (record.handle(5), record.handle(330), record.handle(6)),
            (0, 31, 0)
        );
    }

    #[test]
    fn names() {
        let check = |bytes: &[u8], expected: &str| assert_eq!(decoded(bytes), expected);
        check(b"W\xe4nde", "Wände");
        check("Wände".as_bytes(), "Wände");
        check(b"W\\U+00E4nde \\U+4E2D", "Wände 中");
        check(b"\\U+12 \\U+D800", "\\U+12 \\U+D800");
        assert_eq!(decoded(&[b'a'; 1000]).len(), LONGEST_NAME);
    }
}
