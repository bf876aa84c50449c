//! IES LM-63, editions of 1986 to 2019.

use super::{LuminousOpening, PhotometricFile, PhotometryError};
use crate::reading::cursor::TextCursor;
use crate::reading::number;
use crate::reading::text::{quoted, text};
use azulejo_scene::{PhotometricWeb, WebType};
use std::sync::Arc;

/// Reads a file.
///
/// # Errors
/// What is wrong, and where.
pub(crate) fn parse(bytes: &[u8]) -> Result<PhotometricFile, PhotometryError> {
    // The line TILT= ends the header, and only numbers follow it.
    let (head, data) = split_at_tilt(bytes).ok_or_else(|| PhotometryError {
        at: 0,
        found: "no line that begins with TILT=".to_owned(),
        expected: "a file of IES LM-63",
    })?;
    let mut numbers = IesNumbers::new(bytes, data);
    let tilt = numbers.tilt(head.tilt_included)?;
    // Candelas are of all lamps, and of the luminaire itself where lumens are −1.
    let [
        _lamps,
        _lumens,
        multiplier,
        vertical,
        horizontal,
        kind,
        units,
    ] = numbers.take()?;
    let kind = match kind {
        1.0 => WebType::C,
        2.0 => WebType::B,
        3.0 => WebType::A,
        _ => {
            return Err(numbers.wrong(
                format!("photometry of type {kind}"),
                "1 to 3, for C, B and A",
            ));
        }
    };
    let [width, length, _height, ballast, third, _watts] = numbers.take()?;
    let at_factors = numbers.at;
    // Angles come before the candelas, which have a row of vertical angles for each horizontal one.
    let (vertical, at_vertical) = numbers.list(vertical, "vertical angles")?;
    let (horizontal, at_horizontal) = numbers.list(horizontal, "horizontal angles")?;
    let count = (vertical.len() * horizontal.len()) as f64;
    let (candelas, at_candelas) = numbers.list(count, "candelas")?;
    // Lengths are in feet or metres; the candelas have up to three factors, by the edition.
    let metres = if units == 1.0 { 0.3048 } else { 1.0 };
    let photometric = if head.has_third_factor { third } else { 1.0 };
    let factor = multiplier * ballast * photometric;
    let wrong = |at: usize, found: String| PhotometryError {
        at,
        found,
        expected: "angles that rise, and candelas of 0 or more",
    };
    if !(factor >= 0.0 && factor.is_finite()) {
        return Err(wrong(at_factors, "negative factors".to_owned()));
    }
    // A little less than nothing is the noise of a measurement.
    let noise = -NOISE * candelas.iter().copied().fold(0.0, f64::max);
    let scaled = |&c: &f64| {
        if (noise..0.0).contains(&c) {
            0.0
        } else {
            c * factor
        }
    };
    let candelas = candelas.iter().map(scaled).collect();
    let web = PhotometricWeb::new(kind, [&vertical, &horizontal], candelas).map_err(|found| {
        let at = match found.split(' ').next() {
            Some("vertical") => at_vertical,
            Some("horizontal") => at_horizontal,
            _ => at_candelas,
        };
        wrong(at, found)
    })?;
    Ok(PhotometricFile {
        name: head.name,
        web: Arc::new(web),
        opening: opening([width, length].map(|size| size * metres)),
        factor,
        tilt,
        tilt_file: head.tilt_file,
        body: head.body,
        sets: Vec::new(),
    })
}

/// Reads the table of a file that `TILT=` names: the four lines that follow `TILT=INCLUDE` in others.
///
/// # Errors
/// What is wrong, and where.
pub(super) fn tilt_table(bytes: &[u8]) -> Result<Vec<[f64; 2]>, PhotometryError> {
    IesNumbers::new(bytes, bytes).tilt(true)
}

/// Share of the largest intensity below 0 that is taken for 0.
const NOISE: f64 = 1e-3;

/// The header, before the numbers.
struct IesHeader {
    name: String,
    body: Option<String>,
    tilt_included: bool,
    tilt_file: Option<String>,
    /// Whether the number after the ballast factor is a factor too, the ballast-lamp photometric
    /// factor. It was in 1986 and 1991; 1995 and 2002 reserve it, and in 2019 it says where the file
    /// comes from, as 1.10100 does for an accredited laboratory.
    has_third_factor: bool,
}

/// The header, and what follows the line `TILT=`.
fn split_at_tilt(bytes: &[u8]) -> Option<(IesHeader, &[u8])> {
    let mut head = IesHeader {
        name: String::new(),
        body: None,
        tilt_included: false,
        tilt_file: None,
        has_third_factor: true,
    };
    let mut lines = TextCursor::new(bytes);
    while !lines.at_end() {
        let line = text(lines.take_line().trim_ascii());
        lines.pass_line_end();
        if let Some(version) = after(&line, "IES") {
            head.has_third_factor &= !is_later_than_1991(version);
        }
        if let Some(tilt) = after(&line, "TILT=") {
            head.tilt_included = tilt.eq_ignore_ascii_case("INCLUDE");
            let is_none = tilt.is_empty() || tilt.eq_ignore_ascii_case("NONE");
            head.tilt_file = (!is_none && !head.tilt_included).then(|| tilt.to_owned());
            return Some((head, lines.rest()));
        }
        for key in ["[LUMINAIRE]", "[LUMCAT]"] {
            if let Some(name) = after(&line, key).filter(|name| !name.is_empty()) {
                name.clone_into(&mut head.name);
            }
        }
        let body = after(&line, "[LUMINOUSGEOMETRY]").or_else(|| after(&line, "GEOM="));
        head.body = head
            .body
            .or(body.filter(|b| !b.is_empty()).map(str::to_owned));
    }
    None
}

/// Whether the first line, after its `IES`, names an edition of the standard whose third factor is none:
/// `NA:LM-63-1995`, `NA:LM-63-2002`, `:LM-63-2019`, with blanks or in lower case in some files. That
/// of 1991 is `NA91`, and files of 1986 name none.
fn is_later_than_1991(version: &str) -> bool {
    let upper = version.to_ascii_uppercase();
    let year = upper.rsplit("LM-63").next().filter(|y| *y != upper);
    let digits = year.map(|y| y.trim_start_matches([' ', '-', ':']));
    let year = digits.and_then(|y| y.get(..4)?.parse::<u32>().ok());
    year.is_some_and(|y| y > 1991)
}

/// What follows a keyword at the start of a line, in any case.
fn after<'a>(line: &'a str, keyword: &str) -> Option<&'a str> {
    let start = line.get(..keyword.len())?;
    start
        .eq_ignore_ascii_case(keyword)
        .then(|| line[keyword.len()..].trim())
}

/// Numbers separated by blanks or commas.
struct IesNumbers<'a> {
    words: Box<dyn Iterator<Item = &'a [u8]> + 'a>,
    /// Where the file begins in memory, and where the number before began in it.
    start: usize,
    at: usize,
    /// Upper bound of their number.
    most: usize,
}

impl<'a> IesNumbers<'a> {
    fn new(file: &'a [u8], data: &'a [u8]) -> IesNumbers<'a> {
        let words = data.split(|b| b.is_ascii_whitespace() || *b == b',');
        let start = file.as_ptr().addr();
        IesNumbers {
            words: Box::new(words.filter(|word| !word.is_empty())),
            start,
            at: data.as_ptr().addr() - start,
            most: data.len() / 2 + 1,
        }
    }

    fn wrong(&self, found: String, expected: &'static str) -> PhotometryError {
        PhotometryError {
            at: self.at,
            found,
            expected,
        }
    }

    fn next(&mut self) -> Result<f64, PhotometryError> {
        let Some(word) = self.words.next() else {
            return Err(self.wrong("the end of the file".to_owned(), "more numbers"));
        };
        self.at = word.as_ptr().addr() - self.start;
        let parsed = number::parse(word).filter(|n| n.length == word.len() && n.value.is_finite());
        match parsed {
            Some(parsed) => Ok(parsed.value),
            None => Err(self.wrong(quoted(word), "a number")),
        }
    }

    fn take<const N: usize>(&mut self) -> Result<[f64; N], PhotometryError> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.next()?;
        }
        Ok(values)
    }

    /// That many numbers, and where the first one is.
    fn list(&mut self, count: f64, what: &str) -> Result<(Vec<f64>, usize), PhotometryError> {
        if !(count >= 1.0 && count <= self.most as f64) {
            let found = format!("{count} {what}");
            return Err(self.wrong(found, "1 or more, and no more than the file has"));
        }
        let mut values = vec![self.next()?];
        let first = self.at;
        for _ in 1..count as usize {
            values.push(self.next()?);
        }
        Ok((values, first))
    }

    /// The table of `TILT=INCLUDE`: angles in degrees by which a luminaire is tilted, and what is then left of its light.
    fn tilt(&mut self, is_included: bool) -> Result<Vec<[f64; 2]>, PhotometryError> {
        if !is_included {
            return Ok(Vec::new());
        }
        let [_geometry, pairs] = self.take()?;
        let (angles, _) = self.list(pairs, "angles of a tilt table")?;
        let (factors, _) = self.list(pairs, "factors of a tilt table")?;
        if !angles.is_sorted() || factors.iter().any(|f| *f < 0.0) {
            let found = "a tilt table with decreasing angles or negative factors".to_owned();
            return Err(self.wrong(found, "angles that rise, and factors of 0 or more"));
        }
        Ok(angles
            .into_iter()
            .zip(factors)
            .map(<[f64; 2]>::from)
            .collect())
    }
}

/// The opening from the file's width and length, metres; circles have negative sizes.
fn opening([width, length]: [f64; 2]) -> LuminousOpening {
    if width > 0.0 && length > 0.0 {
        return LuminousOpening::Rectangle { length, width };
    }
    if width < 0.0 && length <= 0.0 {
        // An ellipse becomes the circle of equal area.
        let across = if length < 0.0 {
            (width * length).sqrt()
        } else {
            -width
        };
        return LuminousOpening::Disc { diameter: across };
    }
    LuminousOpening::Point
}
