//! SFF text: fields separated by blanks, records that end with their line, sections that end with
//! an empty line.

use super::document::SffPosition;
use crate::ReadError;
use crate::reading::text::text;
use crate::reading::warnings::Warnings;
use crate::reading::words::Words;
use azulejo_scene::Rgb;
use glam::{DMat4, DVec3};

/// Largest magnitude of a coordinate, so that products of three stay finite. The original's limit
/// is 1e5.
const FARTHEST: f64 = 1e30;

/// A cursor in the text of a file.
pub(crate) struct SffLines<'a, 'w> {
    words: Words<'a>,
    length: usize,
    file: u32,
    name: &'a str,
    pub warnings: &'w mut Warnings,
}

impl<'a, 'w> SffLines<'a, 'w> {
    /// A cursor at the start of a text with index `file` in the [`SffSources`].
    pub fn new(bytes: &'a [u8], name: &'a str, file: u32, warnings: &'w mut Warnings) -> Self {
        SffLines {
            words: Words::new(bytes, name),
            length: bytes.len(),
            file,
            name,
            warnings,
        }
    }

    /// The position of the next field.
    pub fn place(&mut self) -> SffPosition {
        self.words.skip_spaces();
        SffPosition {
            file: self.file,
            offset: self.words.offset() as u32,
        }
    }

    /// Remaining bytes of the text.
    pub fn bytes_left(&self) -> usize {
        self.length - self.words.offset()
    }

    /// Whether the end of the text is reached.
    pub fn at_end(&self) -> bool {
        self.words.at_end()
    }

    /// Whether the rest of the line is blank.
    pub fn rest_is_blank(&mut self) -> bool {
        self.words.skip_spaces();
        self.words.at_line_end()
    }

    /// Skips the rest of the line, and following lines that begin with `#`.
    pub fn end_record(&mut self) {
        self.words.rest_of_line();
        self.skip_remarks();
    }

    /// Skips lines that begin with `#`.
    pub fn skip_remarks(&mut self) {
        while self.words.peek() == Some(b'#') {
            self.words.rest_of_line();
        }
    }

    /// At the start of a line: whether the section or block ends here. Its empty line is consumed.
    pub fn section_ends(&mut self) -> bool {
        let blank = self.rest_is_blank();
        if blank {
            self.words.rest_of_line();
        }
        blank
    }

    /// Skips line ends before the next field, but not an empty line.
    ///
    /// # Errors
    /// The section ends before the field.
    fn reach_field(&mut self, expected: &str) -> Result<(), ReadError> {
        self.words.skip_spaces();
        while self.words.at_line_end() {
            let end = self.words.offset();
            self.words.rest_of_line();
            if self.rest_is_blank() {
                let what = if self.words.at_end() {
                    "file"
                } else {
                    "section"
                };
                let found = format!("the end of the {what}");
                return Err(self.words.error_with(end, found, expected));
            }
        }
        Ok(())
    }

    /// The next field as a number within the allowed range.
    pub fn number(&mut self) -> Result<f64, ReadError> {
        self.number_of("a number")
    }

    fn number_of(&mut self, expected: &str) -> Result<f64, ReadError> {
        self.reach_field(expected)?;
        let start = self.words.offset();
        let wrong = |words: &Words<'a>| words.error(start, expected);
        let value = self.words.number().map_err(|_| wrong(&self.words))?;
        if value.abs() <= FARTHEST {
            return Ok(value);
        }
        Err(self
            .words
            .error(start, "a number with a magnitude of at most 1e30"))
    }

    /// Whether the next field on this line is a number; it is not consumed.
    pub fn number_follows(&mut self) -> bool {
        let mut ahead = self.words;
        ahead.skip_spaces();
        !ahead.at_line_end() && ahead.number().is_ok()
    }

    /// How many numbers follow on this line.
    pub fn numbers_left_on_line(&mut self) -> usize {
        let mut ahead = self.words;
        let mut count = 0;
        loop {
            ahead.skip_spaces();
            if ahead.at_line_end() || ahead.number().is_err() {
                return count;
            }
            count += 1;
        }
    }

    /// The next field as an integer, rounded, as the original reads identifiers.
    pub fn index(&mut self) -> Result<u32, ReadError> {
        let place = self.place();
        let value = self.number_of("an integer")?.round();
        if (0.0..4e9).contains(&value) {
            return Ok(value as u32);
        }
        Err(self.error(place, format!("{value}"), "a non-negative integer"))
    }

    /// The next three numbers.
    pub fn point(&mut self) -> Result<DVec3, ReadError> {
        Ok(DVec3::new(self.number()?, self.number()?, self.number()?))
    }

    /// The next three numbers as a direction.
    pub fn direction(&mut self) -> Result<DVec3, ReadError> {
        let place = self.place();
        let v = self.point()?;
        let expected = "a direction, not all zeros";
        // A unit vector is kept bit by bit, so that written values are reproduced.
        if (v.length_squared() - 1.0).abs() <= 4.0 * f64::EPSILON {
            return Ok(v);
        }
        v.try_normalize()
            .ok_or_else(|| self.error(place, "a direction of length 0", expected))
    }

    /// The next number, clamped to a range with a warning that contains `what`.
    pub fn within(&mut self, low: f64, high: f64, what: &str) -> Result<f64, ReadError> {
        let place = self.place();
        let value = self.number()?;
        if (low..=high).contains(&value) {
            return Ok(value);
        }
        let limited = value.clamp(low, high);
        self.warn(place, format!("{what} outside {low}..{high}: clamped"));
        Ok(limited)
    }

    /// The next number, which must be positive.
    pub fn positive(&mut self, what: &str) -> Result<f64, ReadError> {
        let place = self.place();
        let value = self.number()?;
        if value > 0.0 {
            return Ok(value);
        }
        Err(self.error(place, format!("{what} {value}"), "a positive number"))
    }

    /// The next three numbers as a colour in 0..=1.
    pub fn color(&mut self, what: &str) -> Result<Rgb, ReadError> {
        let mut unit = || self.within(0.0, 1.0, what);
        Ok(Rgb::new(unit()?, unit()?, unit()?))
    }

    /// The next sixteen numbers, row by row, for column vectors.
    pub fn matrix(&mut self) -> Result<DMat4, ReadError> {
        let mut rows = [0.0; 16];
        for value in &mut rows {
            *value = self.number()?;
        }
        Ok(DMat4::from_cols_array(&rows).transpose())
    }

    /// The next field on this line.
    pub fn word_on_line(&mut self) -> Option<&'a [u8]> {
        if self.rest_is_blank() {
            return None;
        }
        self.words.word()
    }

    /// The next field as a file name, `None` for `-`.
    pub fn file_name(&mut self) -> Result<Option<String>, ReadError> {
        self.reach_field("a file name, or -")?;
        let word = self.words.word().unwrap_or_default();
        Ok((word != b"-").then(|| text(word).into_owned()))
    }

    /// Reads the title line of a section.
    ///
    /// Sections are identified by their order alone, so any line is a title. An empty one is, too,
    /// but only if numbers follow it: a second empty line before a title is a mistake.
    pub fn title(&mut self) -> String {
        self.skip_remarks();
        let mut skipped = false;
        while !self.at_end() && self.rest_is_blank() {
            self.words.rest_of_line();
            self.skip_remarks();
            skipped = true;
        }
        if skipped && self.number_follows() {
            return String::new();
        }
        let place = self.place();
        if self.numbers_left_on_line() >= 2 {
            let message = "title line that begins with numbers: they are ignored";
            self.warn(place, message.into());
        }
        let title = text(self.words.rest_of_line()).into_owned();
        self.skip_remarks();
        title
    }

    /// Adds a warning at a position.
    pub fn warn(&mut self, place: SffPosition, message: String) {
        let words = &self.words;
        let position = || words.position(place.offset as usize);
        self.warnings.add(self.name, message, position);
    }

    /// An error at a position.
    pub fn error(
        &self,
        place: SffPosition,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> ReadError {
        let at = place.offset as usize;
        self.words.error_with(at, found, expected)
    }

    /// The underlying words, for blocks with rules of their own.
    pub fn words(&mut self) -> &mut Words<'a> {
        &mut self.words
    }
}
