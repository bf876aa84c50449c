//! Sources of rows: text, or bytes of either byte order.

use super::NONE;
use super::header::ScalarType;
use crate::reading::warnings::Warnings;
use crate::reading::words::Words;
use crate::{Position, ReadError};

/// Why a row could not be read.
pub(super) enum RowError {
    /// The end of the file.
    End,
    /// A word that is not a number.
    Error(Box<ReadError>),
}

/// A source of the numbers in a file, in their order.
pub(super) trait RowSource {
    /// Advances to the start of the next row.
    fn begin_row(&mut self) -> Result<(), RowError>;

    /// The next number.
    fn number(&mut self, kind: ScalarType) -> Result<f64, RowError>;

    /// The next number as an index; [`NONE`] if it is not a valid one.
    fn index(&mut self, kind: ScalarType) -> Result<u32, RowError>;

    /// The length of the list that follows. The remaining bytes suffice for it.
    fn count(&mut self, count: ScalarType, item: ScalarType) -> Result<usize, RowError>;

    /// Skips surplus values in the row.
    fn end_row(&mut self);

    /// Skips an incomplete row at the end of the file.
    fn skip_incomplete_row(&mut self);

    /// The number of remaining bytes.
    fn left(&self) -> usize;

    /// The position of the next byte.
    fn position(&self) -> Position;

    /// Adds warnings about irregularities.
    fn finish(&mut self, file: &str, warnings: &mut Warnings);
}

/// Rows as lines of text.
pub(super) struct AsciiRows<'a> {
    words: Words<'a>,
    length: usize,
    longer: LineOddity,
    without_list: LineOddity,
}

/// An irregularity of lines: its first position, and its count.
#[derive(Default)]
struct LineOddity {
    first: usize,
    count: usize,
}

impl LineOddity {
    #[cold]
    fn at(&mut self, offset: usize) {
        if self.count == 0 {
            self.first = offset;
        }
        self.count += 1;
    }
}

impl<'a> AsciiRows<'a> {
    pub fn new(bytes: &'a [u8], start: usize, file: &'a str) -> AsciiRows<'a> {
        AsciiRows {
            words: Words::new(bytes, file).from(start),
            length: bytes.len(),
            longer: LineOddity::default(),
            without_list: LineOddity::default(),
        }
    }

    /// The error for a line that ends before its row, or for the end of the file.
    #[cold]
    fn ends(&self) -> RowError {
        if self.words.at_end() {
            return RowError::End;
        }
        let at = self.words.offset();
        let found = "the end of the line";
        let expected = "as many numbers as the header declares";
        RowError::Error(Box::new(self.words.error_with(at, found, expected)))
    }
}

impl RowSource for AsciiRows<'_> {
    fn begin_row(&mut self) -> Result<(), RowError> {
        self.words.skip_blanks();
        if self.words.at_end() {
            Err(RowError::End)
        } else {
            Ok(())
        }
    }

    #[inline]
    fn number(&mut self, _kind: ScalarType) -> Result<f64, RowError> {
        self.words.skip_spaces();
        if self.words.at_line_end() {
            return Err(self.ends());
        }
        self.words
            .number()
            .map_err(|e| RowError::Error(Box::new(e)))
    }

    #[inline]
    fn index(&mut self, kind: ScalarType) -> Result<u32, RowError> {
        match self.words.small_integer() {
            Some(index) => Ok(index),
            None => self.number(kind).map(index),
        }
    }

    #[inline]
    fn count(&mut self, count: ScalarType, _item: ScalarType) -> Result<usize, RowError> {
        if let Some(count) = self.words.small_integer() {
            return Ok(count as usize);
        }
        if self.words.at_line_end() {
            self.without_list.at(self.words.offset());
            return Ok(0);
        }
        let count = self.number(count)?;
        // An invalid count is limited by the end of the line.
        Ok(if count > 0.0 { count as usize } else { 0 })
    }

    #[inline]
    fn end_row(&mut self) {
        self.words.skip_spaces();
        if !self.words.at_line_end() {
            self.longer.at(self.words.offset());
            self.words.rest_of_line();
        }
    }

    fn skip_incomplete_row(&mut self) {
        self.words = self.words.from(self.length);
    }

    fn left(&self) -> usize {
        self.length - self.words.offset()
    }

    fn position(&self) -> Position {
        self.words.position(self.words.offset())
    }

    fn finish(&mut self, file: &str, warnings: &mut Warnings) {
        let words = self.words;
        let mut add = |odd: &LineOddity, message: &str| {
            let position = || words.position(odd.first);
            warnings.add_many(file, message.into(), odd.count, position);
        };
        add(
            &self.longer,
            "numbers after the last property of a line: skipped",
        );
        add(
            &self.without_list,
            "line that ends before a list: the list is taken as empty",
        );
        self.words.skip_blanks();
        let rest = LineOddity {
            first: self.words.offset(),
            count: usize::from(!self.words.at_end()),
        };
        add(&rest, "text after the last element: skipped");
    }
}

/// Rows as bytes, big-endian or little-endian.
pub(super) struct BinaryRows<'a, const BIG: bool> {
    rest: &'a [u8],
    length: usize,
}

impl<'a, const BIG: bool> BinaryRows<'a, BIG> {
    pub fn new(bytes: &'a [u8], start: usize) -> BinaryRows<'a, BIG> {
        BinaryRows {
            rest: &bytes[start..],
            length: bytes.len(),
        }
    }

    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], RowError> {
        let (taken, rest) = self.rest.split_first_chunk::<N>().ok_or(RowError::End)?;
        self.rest = rest;
        let mut bytes = *taken;
        if BIG {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

impl<const BIG: bool> RowSource for BinaryRows<'_, BIG> {
    #[inline]
    fn begin_row(&mut self) -> Result<(), RowError> {
        Ok(())
    }

    #[inline]
    fn number(&mut self, kind: ScalarType) -> Result<f64, RowError> {
        Ok(match kind {
            ScalarType::I8 => i8::from_le_bytes(self.take()?).into(),
            ScalarType::U8 => u8::from_le_bytes(self.take()?).into(),
            ScalarType::I16 => i16::from_le_bytes(self.take()?).into(),
            ScalarType::U16 => u16::from_le_bytes(self.take()?).into(),
            ScalarType::I32 => i32::from_le_bytes(self.take()?).into(),
            ScalarType::U32 => u32::from_le_bytes(self.take()?).into(),
            ScalarType::F32 => f32::from_le_bytes(self.take()?).into(),
            ScalarType::F64 => f64::from_le_bytes(self.take()?),
        })
    }

    #[inline]
    fn index(&mut self, kind: ScalarType) -> Result<u32, RowError> {
        match kind {
            ScalarType::I32 => Ok(u32::try_from(i32::from_le_bytes(self.take()?)).unwrap_or(NONE)),
            ScalarType::U32 => Ok(u32::from_le_bytes(self.take()?)),
            _ => self.number(kind).map(index),
        }
    }

    #[inline]
    fn count(&mut self, count: ScalarType, item: ScalarType) -> Result<usize, RowError> {
        let count = match count {
            ScalarType::U8 => u8::from_le_bytes(self.take()?).into(),
            _ => self.number(count)?.max(0.0) as usize,
        };
        // Saturating: an absurd count exceeds any file.
        if count.saturating_mul(item.size()) > self.rest.len() {
            Err(RowError::End)
        } else {
            Ok(count)
        }
    }

    #[inline]
    fn end_row(&mut self) {}

    fn skip_incomplete_row(&mut self) {
        self.rest = &[];
    }

    fn left(&self) -> usize {
        self.rest.len()
    }

    fn position(&self) -> Position {
        Position::Byte((self.length - self.rest.len()) as u64)
    }

    fn finish(&mut self, file: &str, warnings: &mut Warnings) {
        if !self.rest.is_empty() {
            let message = format!("{} bytes after the last element: skipped", self.rest.len());
            let position = self.position();
            warnings.add(file, message, || position);
        }
    }
}

#[cold]
fn index(number: f64) -> u32 {
    let is_index = number >= 0.0 && number < f64::from(NONE) && number.fract() == 0.0;
    if is_index { number as u32 } else { NONE }
}
