//! Groups: pairs of a code that determines the meaning of a value, and the value. In text form each
//! has its own line; the binary form has the same groups.

use crate::reading::cursor::is_line_end;

/// A group: its code and its value.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair<'a> {
    /// The meaning of the value; 0 begins a record.
    pub code: i16,
    /// The value.
    pub value: Value<'a>,
}

/// The value of a group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Value<'a> {
    /// Text, which in a text file may be an unparsed number.
    Text(&'a [u8]),
    /// A floating-point number of the binary form.
    Real(f64),
    /// An integer of the binary form.
    Integer(i64),
}

impl<'a> Value<'a> {
    /// The value as a number; `None` if it is not one.
    #[inline]
    pub fn real(self) -> Option<f64> {
        match self {
            Value::Text(text) => {
                let text = text.trim_ascii();
                let number = crate::reading::number::parse(text)?;
                (number.length == text.len()).then_some(number.value)
            }
            Value::Real(value) => Some(value),
            Value::Integer(value) => Some(value as f64),
        }
    }

    /// The value as an integer; fractions, which some writers add, are truncated.
    #[inline]
    pub fn integer(self) -> Option<i64> {
        match self {
            Value::Text(text) => whole(text).or_else(|| self.real().map(|value| value as i64)),
            Value::Real(value) => Some(value as i64),
            Value::Integer(value) => Some(value),
        }
    }

    /// The value as text without blanks around it; empty for a binary number.
    pub fn text(self) -> &'a [u8] {
        match self {
            Value::Text(text) => text.trim_ascii(),
            Value::Real(_) | Value::Integer(_) => b"",
        }
    }
}

/// An integer of up to nine digits with blanks around it.
#[inline]
fn whole(text: &[u8]) -> Option<i64> {
    let text = text.trim_ascii();
    let (negative, digits) = match text {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, text),
    };
    if digits.is_empty() || digits.len() > 9 {
        return None;
    }
    let mut value = 0;
    for digit in digits {
        let digit = digit.wrapping_sub(b'0');
        if digit > 9 {
            return None;
        }
        value = value * 10 + i64::from(digit);
    }
    Some(if negative { -value } else { value })
}

/// The encoding of the groups.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    /// Text, two lines each.
    Text,
    /// Binary with codes of one byte, until release 12; 255 is followed by a code of two bytes.
    Bytes,
    /// Binary with codes of two bytes.
    Words,
}

/// Start of a binary file, without the following bytes that text-mode transfers change.
const MARK: &[u8] = b"AutoCAD Binary DXF";

/// The bytes after the mark.
const AFTER_MARK: &[u8] = b"\r\n\x1a\0";

/// Comments, which may occur anywhere.
const COMMENT: i16 = 999;

/// Valid codes; other numbers mean that the lines are out of step.
const CODES: std::ops::RangeInclusive<i64> = -5..=1071;

/// A position in a file, from which groups are read.
#[derive(Debug)]
pub(super) struct Pairs<'a> {
    bytes: &'a [u8],
    at: usize,
    /// The encoding of the groups.
    pub encoding: Encoding,
    /// Whether the binary mark lost its carriage return in a transfer.
    pub mark_is_damaged: bool,
    /// Malformed groups.
    pub damage: Option<Damage>,
}

/// Lines that should be group codes but are not; in a binary file, the first unknown code, after
/// which nothing can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Damage {
    /// Offset of the first.
    pub offset: usize,
    /// Number of them.
    pub count: usize,
}

impl<'a> Pairs<'a> {
    /// The start of a file.
    pub fn new(bytes: &'a [u8]) -> Pairs<'a> {
        let mut pairs = Pairs {
            bytes,
            at: 0,
            encoding: Encoding::Text,
            mark_is_damaged: false,
            damage: None,
        };
        if let Some(rest) = bytes.strip_prefix(MARK) {
            pairs.begin_binary(rest);
        }
        pairs
    }

    fn begin_binary(&mut self, rest: &[u8]) {
        self.mark_is_damaged = !rest.starts_with(AFTER_MARK);
        // The first code is 0, so the zero byte that ends the mark also ends a damaged one.
        let mark = rest
            .iter()
            .position(|b| *b == 0)
            .map_or(rest.len(), |end| end + 1);
        self.at = MARK.len() + mark;
        // With one-byte codes, the code 0 is followed by the S of SECTION.
        self.encoding = match self.bytes.get(self.at + 1) {
            Some(0) => Encoding::Words,
            _ => Encoding::Bytes,
        };
    }

    /// Offset of the next group.
    pub fn offset(&self) -> usize {
        self.at
    }

    /// The unread bytes.
    pub fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at.min(self.bytes.len())..]
    }

    /// The next group that is not a comment.
    #[inline]
    pub fn next(&mut self) -> Option<Pair<'a>> {
        loop {
            let pair = match self.encoding {
                Encoding::Text => self.text_pair()?,
                Encoding::Bytes | Encoding::Words => self.binary_pair()?,
            };
            if pair.code != COMMENT {
                return Some(pair);
            }
        }
    }

    /// Reads two lines. A line that should be a code but is not is skipped, so that the pairs
    /// get back into step after a lost line.
    #[inline]
    fn text_pair(&mut self) -> Option<Pair<'a>> {
        loop {
            let start = self.at;
            let line = self.line()?;
            let Some(code) = whole(line).filter(|code| CODES.contains(code)) else {
                self.note_damage(start, line);
                continue;
            };
            let second = self.at;
            let value = self.line()?;
            if code == 0 && !begins_a_name(value) {
                self.note_damage(start, line);
                self.at = second;
                continue;
            }
            let (code, value) = (code as i16, Value::Text(value));
            return Some(Pair { code, value });
        }
    }

    #[cold]
    fn note_damage(&mut self, offset: usize, line: &[u8]) {
        if !line
            .iter()
            .all(|b| b.is_ascii_whitespace() || matches!(b, 0 | 0x1a))
        {
            let first = Damage { offset, count: 0 };
            self.damage.get_or_insert(first).count += 1;
        }
    }

    /// The next line, ended by LF, CR, CR LF, or CR CR LF of a bad transfer.
    #[inline]
    fn line(&mut self) -> Option<&'a [u8]> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let end = rest
            .iter()
            .position(|&b| is_line_end(b))
            .unwrap_or(rest.len());
        let ends = match &rest[end..] {
            [b'\r', b'\r', b'\n', ..] => 3,
            [b'\r', b'\n', ..] => 2,
            [_, ..] => 1,
            [] => 0,
        };
        self.at += end + ends;
        Some(&rest[..end])
    }

    fn binary_pair(&mut self) -> Option<Pair<'a>> {
        let start = self.at;
        let code = self.binary_code()?;
        let Some(kind) = ValueKind::of(code) else {
            // The length of the value is unknown.
            self.damage = Some(Damage {
                offset: start,
                count: 1,
            });
            self.at = self.bytes.len();
            return None;
        };
        let value = match kind {
            ValueKind::Text => Value::Text(self.zero_ended()?),
            ValueKind::Chunk => {
                let [length] = self.take()?;
                Value::Text(self.slice(usize::from(length))?)
            }
            ValueKind::Real => Value::Real(f64::from_le_bytes(self.take()?)),
            ValueKind::Int8 => Value::Integer(i64::from(self.take::<1>()?[0])),
            ValueKind::Int16 => Value::Integer(i16::from_le_bytes(self.take()?).into()),
            ValueKind::Int32 => Value::Integer(i32::from_le_bytes(self.take()?).into()),
            ValueKind::Int64 => Value::Integer(i64::from_le_bytes(self.take()?)),
        };
        Some(Pair { code, value })
    }

    fn binary_code(&mut self) -> Option<i16> {
        if self.encoding == Encoding::Bytes {
            let [code] = self.take()?;
            if code != 255 {
                return Some(code.into());
            }
        }
        Some(i16::from_le_bytes(self.take()?))
    }

    fn zero_ended(&mut self) -> Option<&'a [u8]> {
        let length = self.rest().iter().position(|b| *b == 0)?;
        let text = self.slice(length)?;
        self.at += 1;
        Some(text)
    }

    fn slice(&mut self, length: usize) -> Option<&'a [u8]> {
        let taken = self.rest().get(..length)?;
        self.at += length;
        Some(taken)
    }

    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.slice(N)?.try_into().ok()
    }
}

/// Whether a value may be the name of an entity: out of step, there are numbers instead.
fn begins_a_name(value: &[u8]) -> bool {
    match value.trim_ascii() {
        [] => false,
        [b'3', b'D' | b'd', ..] => true,
        [first, ..] => !matches!(first, b'0'..=b'9' | b'-' | b'+' | b'.'),
    }
}

/// The binary encoding of the value of a group.
enum ValueKind {
    Text,
    Chunk,
    Real,
    Int8,
    Int16,
    Int32,
    Int64,
}

impl ValueKind {
    /// *DXF Reference*, "Group code value types".
    fn of(code: i16) -> Option<ValueKind> {
        Some(match code {
            0..=9
            | 100..=105
            | 300..=309
            | 320..=369
            | 390..=399
            | 410..=419
            | 430..=439
            | 470..=481
            | 999..=1003
            | 1005..=1009 => ValueKind::Text,
            310..=319 | 1004 => ValueKind::Chunk,
            10..=59 | 110..=149 | 210..=239 | 460..=469 | 1010..=1059 => ValueKind::Real,
            60..=79 | 170..=179 | 270..=289 | 370..=389 | 400..=409 | 1060..=1070 => {
                ValueKind::Int16
            }
            90..=99 | 420..=429 | 440..=459 | 1071 => ValueKind::Int32,
            160..=169 => ValueKind::Int64,
            290..=299 => ValueKind::Int8,
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Groups = Vec<(i16, String)>;

    /// All groups, and position and count of damage.
    fn all(bytes: &[u8]) -> (Groups, Option<(usize, usize)>) {
        let mut pairs = Pairs::new(bytes);
        let mut read = Vec::new();
        while let Some(pair) = pairs.next() {
            let value = match pair.value {
                Value::Text(text) => text.escape_ascii().to_string(),
                Value::Real(value) => format!("{value}r"),
                Value::Integer(value) => format!("{value}i"),
            };
            read.push((pair.code, value));
        }
        (read, pairs.damage.map(|d| (d.offset, d.count)))
    }

    fn check(bytes: &[u8], expected: &[(i16, &str)]) {
        let (read, damage) = all(bytes);
        let pairs: Vec<(i16, &str)> = read.iter().map(|(c, v)| (*c, v.as_str())).collect();
        assert_eq!(
            (&*pairs, damage),
            (expected, None),
            "{}",
            bytes.escape_ascii()
        );
    }

    #[test]
    fn line_ends_and_comments() {
        let expected = [(0, "SECTION"), (2, "A B "), (1, ""), (70, "  1")];
        check(b"  0\nSECTION\n2\nA B \n1\n\n70\n  1\n", &expected);
        check(
            b"0\r\nSECTION\r\n2\r\nA B \r\n1\r\n\r\n70\r\n  1",
            &expected,
        );
        check(b"0\rSECTION\r2\rA B \r1\r\r70\r  1", &expected);
        check(
            b"0\r\r\nSECTION\r\r\n2\r\r\nA B \r\r\n1\r\r\n\r\r\n70\r\r\n  1",
            &expected,
        );
        check(
            b"999\nv 1\n0\nSECTION\n999\n\n2\nA B \n1\n\n70\n  1\n\n",
            &expected,
        );
    }

    #[test]
    fn lost_lines_are_skipped() {
        // The x of a point lost its value.
        let (pairs, damage) = all(b"0\nLINE\n10\n20\n2.5\n30\n3.5\n0\nEOF\n");
        let codes: Vec<i16> = pairs.iter().map(|(code, _)| *code).collect();
        assert_eq!((codes, damage), (vec![0, 10, 30, 0], Some((13, 1))));
        // A name lost its code.
        let (pairs, damage) = all(b"0\n8\nwalls\n8\nfloor\n");
        assert_eq!(pairs, [(8, "walls".to_owned()), (8, "floor".to_owned())]);
        assert_eq!(damage, Some((0, 1)));
    }

    #[test]
    fn numbers() {
        let real = |text: &str| Value::Text(text.as_bytes()).real();
        assert_eq!(real(" 4 "), Some(4.0));
        assert_eq!(real("-1.5E+02"), Some(-150.0));
        assert_eq!((real("1,5"), real(""), real("x")), (None, None, None));
        let integer = |text: &str| Value::Text(text.as_bytes()).integer();
        assert_eq!((integer("  -7 "), integer("+2")), (Some(-7), Some(2)));
        assert_eq!(
            (integer("1.0"), integer("1e300")),
            (Some(1), Some(i64::MAX))
        );
        assert_eq!(
            (integer("12345678901"), integer("-")),
            (Some(12_345_678_901), None)
        );
    }

    #[test]
    fn binary_of_both_kinds() {
        let expected = [(0, "SECTION"), (70, "-2i"), (10, "1.5r"), (1071, "65536i")];
        let real = 1.5f64.to_le_bytes();
        let old = [
            b"AutoCAD Binary DXF\r\n\x1a\0\0SECTION\0\x46\xfe\xff\x0a",
            &real[..],
            b"\xff\x2f\x04\0\0\x01\0",
        ];
        check(&old.concat(), &expected);
        let new = [
            b"AutoCAD Binary DXF\r\n\x1a\0\0\0SECTION\0\x46\0\xfe\xff\x0a\0",
            &real[..],
            b"\x2f\x04\0\0\x01\0",
        ];
        check(&new.concat(), &expected);
        check(
            b"AutoCAD Binary DXF\r\n\x1a\0\0\0SECTION\0\x36\x01\x02ab\x22\x01\x07",
            &[(0, "SECTION"), (310, "ab"), (290, "7i")],
        );
    }

    #[test]
    fn binary_damage_ends_the_groups() {
        let (pairs, damage) = all(b"AutoCAD Binary DXF\n\x1a\0\0SECTION\0\x50\0\0EOF\0");
        assert_eq!(pairs, [(0, "SECTION".to_owned())]);
        assert_eq!(damage, Some((30, 1)));
        let (pairs, damage) = all(b"AutoCAD Binary DXF\r\n\x1a\0\0SECTION\0\x0a\0\0");
        assert_eq!((pairs.len(), damage), (1, None));
    }
}
