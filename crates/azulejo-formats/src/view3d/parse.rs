//! Parses records into a document.

use super::check::View3dChecker;
use super::document::{
    MatrixLayout, PlanarShape, SurfaceKind, SurfaceOutline, View3dControls, View3dDocument,
    View3dSurface,
};
use super::lines::{LineWord, View3dLines};
use crate::reading::number;
use crate::reading::text::{shortened, text};
use crate::reading::warnings::Warnings;
use crate::{Position, ReadError};
use glam::DVec3;
use std::ops::RangeInclusive;

/// Reads a whole file.
pub(super) fn read(
    bytes: &[u8],
    file: &str,
    warnings: &mut Warnings,
) -> Result<View3dDocument, ReadError> {
    let mut reader = View3dParser {
        lines: View3dLines::new(bytes, file),
        file,
        warnings,
        document: View3dDocument::default(),
        is_placed: None,
        has_obstructions: false,
        checker: View3dChecker::default(),
    };
    reader.records()?;
    let (line, count) = View3dLines::long_lines(bytes);
    let message = "lines with more than 255 characters, which View3D truncates";
    let place = || Position::Line(line, 256);
    reader
        .warnings
        .add_many(file, message.to_owned(), count, place);
    Ok(reader.document)
}

struct View3dParser<'a> {
    lines: View3dLines<'a>,
    file: &'a str,
    warnings: &'a mut Warnings,
    document: View3dDocument,
    /// Whether surfaces are given as F 3a; `None` until the file states it or contains one.
    is_placed: Option<bool>,
    has_obstructions: bool,
    checker: View3dChecker,
}

/// The range to which emissivities are clamped.
const EMISSIVITIES: RangeInclusive<f64> = 0.001..=0.999;

impl<'a> View3dParser<'a> {
    fn records(&mut self) -> Result<(), ReadError> {
        let mut next = self.lines.first_record();
        while let Some(word) = next {
            match word.bytes[0].to_ascii_uppercase() {
                b'T' => self.document.title = text(self.lines.rest_of_line()).into_owned(),
                b'F' => self.geometry(word)?,
                b'C' => self.controls()?,
                b'V' => self.vertex(word)?,
                b'S' => self.surface(word, SurfaceKind::Radiating)?,
                b'M' => self.surface(word, SurfaceKind::Mask)?,
                b'N' => self.surface(word, SurfaceKind::Null)?,
                b'O' => self.surface(word, SurfaceKind::Obstruction)?,
                b'X' => self.warn(word.at, "X is reserved: line skipped"),
                b'E' | b'*' => break,
                _ => {
                    let shown = shortened(&text(word.bytes));
                    self.warn(
                        word.at,
                        format!("\"{shown}\" is not a record type: line skipped"),
                    );
                }
            }
            next = self.lines.record();
        }
        self.checker.all(&self.document, &self.lines)
    }

    #[cold]
    fn warn(&mut self, at: usize, message: impl Into<String>) {
        let lines = &self.lines;
        self.warnings
            .add(self.file, message.into(), || lines.position(at));
    }

    fn geometry(&mut self, record: LineWord<'a>) -> Result<(), ReadError> {
        let word = self.field("3 or 3a")?;
        let is_placed = match word.bytes {
            b"3" => false,
            b"3a" | b"3A" => true,
            other => {
                let found = format!("geometry \"{}\"", shortened(&text(other)));
                let expected = "3 (vertices) or 3a (placed shapes)";
                return Err(self.lines.error(word.at, found, expected));
            }
        };
        let late = !self.document.vertices.is_empty() || !self.document.surfaces.is_empty();
        if late && self.is_placed != Some(is_placed) {
            let expected = "F before all vertices and surfaces";
            return Err(self.lines.error(record.at, "F after them", expected));
        }
        self.is_placed = Some(is_placed);
        Ok(())
    }

    /// Reads `name=value`, separated by blanks or commas; comments are not allowed here.
    fn controls(&mut self) -> Result<(), ReadError> {
        while let Some(word) = self.lines.plain_word() {
            let pair = text(word.bytes);
            match pair.split_once('=') {
                Some((name, value)) if !name.is_empty() => self.control(word, name, value)?,
                _ => self.warn(
                    word.at,
                    "words on a control line that are not name=value: skipped",
                ),
            }
        }
        Ok(())
    }

    fn control(&mut self, word: LineWord<'a>, name: &str, value: &str) -> Result<(), ReadError> {
        let mut controls = std::mem::take(&mut self.document.controls);
        let name = name.to_ascii_lowercase();
        let set = self.set(&mut controls, word, &name, value.as_bytes());
        self.document.controls = controls;
        set
    }

    fn set(
        &mut self,
        controls: &mut View3dControls,
        word: LineWord<'a>,
        name: &str,
        value: &[u8],
    ) -> Result<(), ReadError> {
        const MOST: i64 = i16::MAX as i64;
        match name {
            "eps" => controls.eps = self.limit(word, value)?,
            "row" => controls.row = self.whole(word, value, 0..=MOST)? as u32,
            "col" => controls.column = self.whole(word, value, 0..=MOST)? as u32,
            // As in View3D, a 1 cannot be reset.
            "encl" => controls.encl |= self.whole(word, value, 0..=1)? == 1,
            "emit" => controls.emit = self.whole(word, value, 0..=1)? == 1,
            "out" => controls.out = self.layout(word, value)?,
            _ => {
                let own = ["maxU", "maxO", "minO", "list", "prjD", "maxV"];
                let Some(&own) = own.iter().find(|own| own.eq_ignore_ascii_case(name)) else {
                    let shown = shortened(name);
                    let message = format!("unknown control parameter \"{shown}\": skipped");
                    self.warn(word.at, message);
                    return Ok(());
                };
                let value = self.whole(word, value, -MOST - 1..=MOST)?;
                controls.others.retain(|(name, _)| *name != own);
                controls.others.push((own, value as i16));
            }
        }
        Ok(())
    }

    /// The value of an integer parameter.
    fn whole(
        &self,
        word: LineWord<'a>,
        value: &[u8],
        range: RangeInclusive<i64>,
    ) -> Result<i64, ReadError> {
        let within = integer(value).filter(|v| range.contains(v));
        within.ok_or_else(|| {
            let expected = format!("an integer from {} to {}", range.start(), range.end());
            self.odd(word, expected)
        })
    }

    fn limit(&mut self, word: LineWord<'a>, value: &[u8]) -> Result<f64, ReadError> {
        let Some(eps) = real(value).filter(|&e| e > 0.0) else {
            return Err(self.odd(word, "eps=1e-4 or another positive number"));
        };
        if !(1e-6..=1e-2).contains(&eps) {
            self.warn(word.at, "eps is outside 1e-6 to 1e-2");
        }
        Ok(eps)
    }

    fn layout(&mut self, word: LineWord<'a>, value: &[u8]) -> Result<MatrixLayout, ReadError> {
        Ok(match self.whole(word, value, 0..=2)? {
            0 => MatrixLayout::Text,
            1 => MatrixLayout::Binary,
            _ => {
                self.warn(
                    word.at,
                    "out=2 is a format that View3D cannot write: taken as 0",
                );
                MatrixLayout::Text
            }
        })
    }

    fn odd(&self, word: LineWord<'a>, expected: impl Into<String>) -> ReadError {
        let found = format!("\"{}\"", shortened(&text(word.bytes)));
        self.lines.error(word.at, found, expected)
    }

    /// The next field of a record.
    fn field(&mut self, expected: &str) -> Result<LineWord<'a>, ReadError> {
        let end =
            |lines: &View3dLines<'a>| lines.error(lines.end(), "the end of the file", expected);
        self.lines.word().ok_or_else(|| end(&self.lines))
    }

    fn number(&mut self, expected: &str) -> Result<f64, ReadError> {
        let word = self.field(expected)?;
        real(word.bytes).ok_or_else(|| self.odd(word, expected))
    }

    fn numbers<const N: usize>(&mut self, expected: &str) -> Result<[f64; N], ReadError> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.number(expected)?;
        }
        Ok(numbers)
    }

    /// The next field as a non-negative integer, and its position.
    fn count(&mut self, expected: &str) -> Result<(u32, LineWord<'a>), ReadError> {
        let word = self.field(expected)?;
        let count = integer(word.bytes).and_then(|v| u32::try_from(v).ok());
        let count = count.ok_or_else(|| self.odd(word, expected))?;
        Ok((count, word))
    }

    /// Numbers of vertices and surfaces must be consecutive.
    fn next_number(&mut self, what: &str, known: usize) -> Result<(), ReadError> {
        let (n, word) = self.count(&format!("the number of the {what}"))?;
        if n as usize == known + 1 {
            Ok(())
        } else {
            let found = format!("{what} {n}");
            let expected = format!("{what} {}: they are numbered consecutively", known + 1);
            Err(self.lines.error(word.at, found, expected))
        }
    }

    fn vertex(&mut self, record: LineWord<'a>) -> Result<(), ReadError> {
        if *self.is_placed.get_or_insert(false) {
            let expected = "no vertices in an F 3a file";
            return Err(self.lines.error(record.at, "a vertex", expected));
        }
        self.next_number("vertex", self.document.vertices.len())?;
        let coordinates = self.numbers::<3>("a coordinate")?;
        self.document.vertices.push(position(coordinates));
        Ok(())
    }

    fn surface(&mut self, record: LineWord<'a>, kind: SurfaceKind) -> Result<(), ReadError> {
        if self.has_obstructions && kind != SurfaceKind::Obstruction {
            let expected = "all obstructions (O) after all other surfaces";
            return Err(self
                .lines
                .error(record.at, "a surface after an obstruction", expected));
        }
        self.has_obstructions |= kind == SurfaceKind::Obstruction;
        self.next_number("surface", self.document.surfaces.len())?;
        let blank = View3dSurface {
            kind,
            outline: SurfaceOutline::Vertices(Vec::new()),
            base: 0,
            combined: 0,
            emissivity: *EMISSIVITIES.end(),
            name: String::new(),
            line: record.line,
        };
        let surface = if *self.is_placed.get_or_insert(false) {
            self.placed(blank)?
        } else {
            self.with_vertices(blank)?
        };
        self.document.surfaces.push(surface);
        let number = self.document.surfaces.len();
        self.checker
            .outline(&self.document, number - 1, record.at, &self.lines)?;
        if let Some(message) = self.checker.bend(&self.document, number - 1) {
            self.warn(record.at, message);
        }
        Ok(())
    }

    /// Reads the rest of an F 3 surface.
    fn with_vertices(&mut self, mut surface: View3dSurface) -> Result<View3dSurface, ReadError> {
        let known = self.document.vertices.len();
        let mut numbers = Vec::with_capacity(4);
        for k in 0..4 {
            let (n, word) = self.count("the number of a vertex")?;
            match n as usize {
                0 if k == 3 => {}
                n if (1..=known).contains(&n) => numbers.push(n as u32),
                _ => {
                    let expected = match known {
                        0 => "vertices (V) before the surfaces".to_owned(),
                        _ => format!("one of the {known} vertices above"),
                    };
                    return Err(self.odd(word, expected));
                }
            }
        }
        surface.outline = SurfaceOutline::Vertices(numbers);
        if surface.kind != SurfaceKind::Obstruction {
            self.properties(&mut surface)?;
        }
        Ok(surface)
    }

    /// Reads the rest of an F 3a surface.
    fn placed(&mut self, mut surface: View3dSurface) -> Result<View3dSurface, ReadError> {
        let letter = self.field("the shape R, T or Q")?;
        let corners = match letter.bytes {
            b"R" | b"r" => 0,
            b"T" | b"t" => 3,
            b"Q" | b"q" => 4,
            _ => return Err(self.odd(letter, "the shape R, T or Q")),
        };
        if surface.kind != SurfaceKind::Obstruction {
            self.properties(&mut surface)?;
        }
        // The rest of the first line is a comment.
        self.lines.skip_line();
        let origin = self.numbers::<3>("a coordinate")?;
        let [azimuth, tilt] = self.numbers::<2>("an angle in degrees")?;
        let shape = match corners {
            0 => PlanarShape::Rectangle(self.numbers::<2>("width and height")?),
            _ => {
                let corner = |_| self.numbers::<2>("a corner (u, v)");
                PlanarShape::Polygon((0..corners).map(corner).collect::<Result<_, _>>()?)
            }
        };
        surface.outline = SurfaceOutline::Placed {
            shape,
            origin: position(origin),
            azimuth,
            tilt,
        };
        Ok(surface)
    }

    /// Reads base, combination, emissivity and name.
    fn properties(&mut self, surface: &mut View3dSurface) -> Result<(), ReadError> {
        let (base, at_base) = self.count("the number of a base surface, or 0")?;
        let (combined, at_combined) = self.count("the number of a surface to combine, or 0")?;
        (surface.base, surface.combined) = (base, combined);
        self.checker.fields.push([at_base.at, at_combined.at]);
        let word = self.field("an emissivity")?;
        let emissivity = real(word.bytes).ok_or_else(|| self.odd(word, "an emissivity"))?;
        surface.emissivity = emissivity.clamp(*EMISSIVITIES.start(), *EMISSIVITIES.end());
        if surface.emissivity != emissivity {
            self.warn(word.at, "emissivities outside 0.001 to 0.999: clamped");
        }
        surface.name = self.name(word);
        Ok(())
    }

    /// Reads the name of a surface, on the same line or alone on the next.
    ///
    /// View3D takes the next word, whatever it is, and so loses the record after a surface without
    /// a name.
    fn name(&mut self, before: LineWord<'a>) -> String {
        let on_line = self.lines.word_on_line();
        let word = on_line.or_else(|| {
            let next = self.lines.peek_record()?;
            let first = next.bytes[0].to_ascii_uppercase();
            let is_record = next.bytes.len() == 1 || first == b'*' || is_end(next.bytes);
            let is_number = matches!(first, b'0'..=b'9' | b'+' | b'-' | b'.');
            (!is_record && !is_number).then(|| self.lines.record())?
        });
        if word.is_none() {
            let message = "surfaces without a name: View3D would take the next line's first word";
            self.warn(before.at, message);
        }
        word.map_or_else(String::new, |w| text(w.bytes).into_owned())
    }
}

fn is_end(word: &[u8]) -> bool {
    word.eq_ignore_ascii_case(b"end")
}

/// An integer as C parses it in base 0: `010` is eight, `0x10` sixteen.
fn integer(word: &[u8]) -> Option<i64> {
    let text = std::str::from_utf8(word).ok()?;
    let (sign, digits) = match text.as_bytes().first()? {
        b'-' => (-1, &text[1..]),
        b'+' => (1, &text[1..]),
        _ => (1, text),
    };
    let (radix, digits) = match digits.as_bytes() {
        [b'0', b'x' | b'X', ..] => (16, &digits[2..]),
        [b'0', _, ..] => (8, &digits[1..]),
        _ => (10, digits),
    };
    // A second sign is not a digit.
    let plain = digits.bytes().all(|b| b.is_ascii_alphanumeric());
    let value = plain.then(|| i64::from_str_radix(digits, radix).ok())?;
    value.map(|v| sign * v)
}

/// A finite number that spans the whole word.
fn real(word: &[u8]) -> Option<f64> {
    let number = number::parse(word)?;
    let is_whole = number.length == word.len() && !number.misplaced_sign;
    (is_whole && number.value.is_finite()).then_some(number.value)
}

/// Coordinates below 1e-14 are 0.
fn position(coordinates: [f64; 3]) -> DVec3 {
    DVec3::from(coordinates.map(|x| if x.abs() < 1e-14 { 0.0 } else { x }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_as_c_reads_them() {
        for (word, expected) in [
            ("12", Some(12)),
            ("010", Some(8)),
            ("0x10", Some(16)),
            ("-0X1f", Some(-31)),
            ("+7", Some(7)),
            ("0", Some(0)),
            ("08", None),
            ("1.0", None),
            ("--1", None),
            ("0x", None),
            ("", None),
            ("99999999999999999999", None),
        ] {
            assert_eq!(integer(word.as_bytes()), expected, "{word}");
        }
    }
}
