//! Where rows come from: text, or bytes of either order.

use super::NONE;
use super::header::Kind;
use crate::reading::warnings::Warnings;
use crate::reading::words::Words;
use crate::{Position, ReadError};

/// Why a row could not be read.
pub(super) enum Stop {
    /// The file ends.
    End,
    /// Something that is no number.
    Error(Box<ReadError>),
}

/// Gives the numbers of a file in their order.
pub(super) trait Source {
    /// Goes to the start of the next row.
    fn begin_row(&mut self) -> Result<(), Stop>;

    /// The next number.
    fn number(&mut self, kind: Kind) -> Result<f64, Stop>;

    /// The next number as an index; [`NONE`] if it is none.
    fn index(&mut self, kind: Kind) -> Result<u32, Stop>;

    /// How many items a list has that follow. There are bytes enough for them.
    fn count(&mut self, count: Kind, item: Kind) -> Result<usize, Stop>;

    /// Passes what the row should not hold.
    fn end_row(&mut self);

    /// Passes half a row at the end of the file.
    fn give_up(&mut self);

    /// How many bytes are left.
    fn left(&self) -> usize;

    /// Where the next byte is.
    fn position(&self) -> Position;

    /// Says what was odd.
    fn finish(&mut self, file: &str, warnings: &mut Warnings);
}

/// Rows as lines of text.
pub(super) struct Text<'a> {
    words: Words<'a>,
    length: usize,
    longer: Oddity,
    without_list: Oddity,
}

/// Something that is wrong with lines: where first, and how often.
#[derive(Default)]
struct Oddity {
    first: usize,
    count: usize,
}

impl Oddity {
    #[cold]
    fn at(&mut self, offset: usize) {
        if self.count == 0 {
            self.first = offset;
        }
        self.count += 1;
    }
}

impl<'a> Text<'a> {
    pub fn new(bytes: &'a [u8], start: usize, file: &'a str) -> Text<'a> {
        Text {
            words: Words::new(bytes, file).from(start),
            length: bytes.len(),
            longer: Oddity::default(),
            without_list: Oddity::default(),
        }
    }

    /// What to make of a line that ends before its row, or of the end of the file.
    #[cold]
    fn ends(&self) -> Stop {
        if self.words.at_end() {
            return Stop::End;
        }
        let at = self.words.offset();
        let found = "the end of the line";
        let expected = "as many numbers as the header promises";
        Stop::Error(Box::new(self.words.error_saying(at, found, expected)))
    }
}

impl Source for Text<'_> {
    fn begin_row(&mut self) -> Result<(), Stop> {
        self.words.skip_blanks();
        match self.words.at_end() {
            true => Err(Stop::End),
            false => Ok(()),
        }
    }

    #[inline]
    fn number(&mut self, _kind: Kind) -> Result<f64, Stop> {
        self.words.skip_spaces();
        if self.words.at_line_end() {
            return Err(self.ends());
        }
        self.words.number().map_err(|e| Stop::Error(Box::new(e)))
    }

    #[inline]
    fn index(&mut self, kind: Kind) -> Result<u32, Stop> {
        match self.words.small_integer() {
            Some(index) => Ok(index),
            None => self.number(kind).map(index_of),
        }
    }

    #[inline]
    fn count(&mut self, count: Kind, _item: Kind) -> Result<usize, Stop> {
        if let Some(count) = self.words.small_integer() {
            return Ok(count as usize);
        }
        if self.words.at_line_end() {
            self.without_list.at(self.words.offset());
            return Ok(0);
        }
        let count = self.number(count)?;
        // The line ends before an absurd count does.
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

    fn give_up(&mut self) {
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
        let mut add = |odd: &Oddity, message: &str| {
            let position = || words.position(odd.first);
            warnings.add_many(file, message.into(), odd.count, position);
        };
        add(
            &self.longer,
            "numbers behind the last property of a line: skipped",
        );
        add(
            &self.without_list,
            "line that ends before a list: taken as empty",
        );
        self.words.skip_blanks();
        let behind = Oddity {
            first: self.words.offset(),
            count: usize::from(!self.words.at_end()),
        };
        add(&behind, "text behind the last element: skipped");
    }
}

/// Rows as bytes, big-endian or little-endian.
pub(super) struct Binary<'a, const BIG: bool> {
    rest: &'a [u8],
    length: usize,
}

impl<'a, const BIG: bool> Binary<'a, BIG> {
    pub fn new(bytes: &'a [u8], start: usize) -> Binary<'a, BIG> {
        Binary {
            rest: &bytes[start..],
            length: bytes.len(),
        }
    }

    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Stop> {
        let (taken, rest) = self.rest.split_first_chunk::<N>().ok_or(Stop::End)?;
        self.rest = rest;
        let mut bytes = *taken;
        if BIG {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

impl<const BIG: bool> Source for Binary<'_, BIG> {
    #[inline]
    fn begin_row(&mut self) -> Result<(), Stop> {
        Ok(())
    }

    #[inline]
    fn number(&mut self, kind: Kind) -> Result<f64, Stop> {
        Ok(match kind {
            Kind::I8 => i8::from_le_bytes(self.take()?).into(),
            Kind::U8 => u8::from_le_bytes(self.take()?).into(),
            Kind::I16 => i16::from_le_bytes(self.take()?).into(),
            Kind::U16 => u16::from_le_bytes(self.take()?).into(),
            Kind::I32 => i32::from_le_bytes(self.take()?).into(),
            Kind::U32 => u32::from_le_bytes(self.take()?).into(),
            Kind::F32 => f32::from_le_bytes(self.take()?).into(),
            Kind::F64 => f64::from_le_bytes(self.take()?),
        })
    }

    #[inline]
    fn index(&mut self, kind: Kind) -> Result<u32, Stop> {
        match kind {
            Kind::I32 => Ok(u32::try_from(i32::from_le_bytes(self.take()?)).unwrap_or(NONE)),
            Kind::U32 => Ok(u32::from_le_bytes(self.take()?)),
            _ => self.number(kind).map(index_of),
        }
    }

    #[inline]
    fn count(&mut self, count: Kind, item: Kind) -> Result<usize, Stop> {
        let count = match count {
            Kind::U8 => u8::from_le_bytes(self.take()?).into(),
            _ => self.number(count)?.max(0.0) as usize,
        };
        // Saturating: an absurd count is more than any file holds.
        match count.saturating_mul(item.size()) > self.rest.len() {
            true => Err(Stop::End),
            false => Ok(count),
        }
    }

    #[inline]
    fn end_row(&mut self) {}

    fn give_up(&mut self) {
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
            let message = format!("{} bytes behind the last element: skipped", self.rest.len());
            let position = self.position();
            warnings.add(file, message, || position);
        }
    }
}

#[cold]
fn index_of(number: f64) -> u32 {
    let is_index = number >= 0.0 && number < f64::from(NONE) && number.fract() == 0.0;
    if is_index { number as u32 } else { NONE }
}
