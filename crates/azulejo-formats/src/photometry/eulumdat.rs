//! EULUMDAT, `.ldt`: one value in each line, by its number (A. W. Stockmar, 1990; revised 1998). The tilt of line 25 is that
//! of the measurement, which the intensities hold already.

use super::{LuminousOpening, PhotometricFile, PhotometryError};
use crate::reading::number;
use crate::reading::text::{quoted, text};
use azulejo_scene::{PhotometricWeb, WebType};
use std::sync::Arc;

/// Most sets of lamps of a file.
const MOST_SETS: usize = 20;

/// Lines of a set of lamps.
const LINES_OF_A_SET: usize = 6;

/// Direct ratios for the indices of rooms, which follow the sets.
const DIRECT_RATIOS: usize = 10;

/// Reads a file with a set of its lamps, counted from 1.
///
/// # Errors
/// What is wrong, and where.
pub(super) fn parse(bytes: &[u8], set: usize) -> Result<PhotometricFile, PhotometryError> {
    let lines = EulumdatLines::new(bytes);
    let symmetry = lines.whole(3, 4)?;
    let [planes, in_plane] = [lines.whole(4, 721)?, lines.whole(6, 361)?];
    if planes == 0 || in_plane == 0 {
        return Err(lines.wrong(4, "no planes or no angles in them", "1 or more"));
    }
    let name = text(lines.line(9)?).into_owned();
    // Millimetres. The length is along the lamps, across the plane of 0 degrees.
    let [length, width] = [lines.positive(16)?, lines.positive(17)?];
    let conversion = lines.positive(24)?;
    let count = lines.whole(26, MOST_SETS)?;
    let sets: Vec<LampSet> = (0..count)
        .map(|k| lines.lamps(27 + LINES_OF_A_SET * k))
        .collect::<Result<_, _>>()?;
    let Some(lamps) = set.checked_sub(1).and_then(|k| sets.get(k)) else {
        let found = format!("set {set} of the lamps, of which the file has {count}");
        return Err(lines.wrong(26, &found, "a set that it has, from 1"));
    };
    // Then come angles, and the intensities of those planes that the others do not mirror.
    let first = 27 + LINES_OF_A_SET * count + DIRECT_RATIOS;
    let given = match symmetry {
        0 => planes,
        1 => 1,
        2 | 3 => planes / 2 + 1,
        _ => planes / 4 + 1,
    };
    let horizontal = lines.numbers(first, planes)?;
    let vertical = lines.numbers(first + planes, in_plane)?;
    let at = first + planes + in_plane;
    let values = lines.numbers(at, given * in_plane)?;
    let per_lumen = lamps.lumens / 1000.0 * conversion;
    let candelas: Vec<f64> = values.iter().map(|v| v.max(0.0) * per_lumen).collect();
    let (angles, candelas) = mirrored(symmetry, &horizontal, given, candelas);
    let web = PhotometricWeb::new(WebType::C, [&vertical, &angles], candelas);
    let web = web.map_err(|found| {
        lines.wrong(
            first,
            &found,
            "angles that rise, and intensities of 0 or more",
        )
    })?;
    let size = [length, width].map(|mm| mm / 1000.0);
    Ok(PhotometricFile {
        name: name.trim().to_owned(),
        web: Arc::new(web),
        opening: match size {
            [0.0, _] => LuminousOpening::Point,
            [diameter, 0.0] => LuminousOpening::Disc { diameter },
            [length, width] => LuminousOpening::Rectangle {
                length: width,
                width: length,
            },
        },
        factor: 1.0,
        tilt: Vec::new(),
        tilt_file: None,
        body: None,
        sets: sets.iter().map(LampSet::words).collect(),
    })
}

/// The planes of a web and their intensities: those that the file has, as a part of the circle that the others mirror.
fn mirrored(
    symmetry: usize,
    horizontal: &[f64],
    given: usize,
    candelas: Vec<f64>,
) -> (Vec<f64>, Vec<f64>) {
    let in_plane = candelas.len() / given.max(1);
    match symmetry {
        1 => (vec![0.0], candelas),
        // From 270 over 0 to 90 degrees, and so the mirror image of what is between 90 and 270.
        3 => {
            let step = 180.0 / (given.max(2) - 1) as f64;
            let angles = (0..given).map(|k| 90.0 + step * k as f64).collect();
            let planes = candelas.chunks(in_plane.max(1)).rev();
            (angles, planes.flatten().copied().collect())
        }
        _ => (horizontal[..given.min(horizontal.len())].to_vec(), candelas),
    }
}

/// Lamps that a luminaire may have.
struct LampSet {
    count: f64,
    kind: String,
    /// Of all lamps together.
    lumens: f64,
}

impl LampSet {
    fn words(&self) -> String {
        format!("{} × {}, {} lm", self.count.abs(), self.kind, self.lumens)
    }
}

/// The lines of a file, numbered from 1.
struct EulumdatLines<'a> {
    /// Offset and content of each.
    lines: Vec<(usize, &'a [u8])>,
    length: usize,
}

impl<'a> EulumdatLines<'a> {
    fn new(bytes: &'a [u8]) -> EulumdatLines<'a> {
        let mut at = 0;
        let lines = bytes.split(|b| *b == b'\n').map(|line| {
            let place = (at, line.trim_ascii());
            at += line.len() + 1;
            place
        });
        EulumdatLines {
            lines: lines.collect(),
            length: bytes.len(),
        }
    }

    fn wrong(&self, line: usize, found: &str, expected: &'static str) -> PhotometryError {
        let at = self.lines.get(line - 1).map_or(self.length, |(at, _)| *at);
        PhotometryError {
            at,
            found: found.to_owned(),
            expected,
        }
    }

    fn line(&self, line: usize) -> Result<&'a [u8], PhotometryError> {
        let content = self.lines.get(line - 1).map(|(_, content)| *content);
        content.ok_or_else(|| self.wrong(line, "the end of the file", "more lines of EULUMDAT"))
    }

    /// Some programs write a comma for the decimal point.
    fn number(&self, line: usize) -> Result<f64, PhotometryError> {
        let content = self.line(line)?;
        let pointed: Vec<u8> = content
            .iter()
            .map(|b| if *b == b',' { b'.' } else { *b })
            .collect();
        let parsed = number::parse(&pointed).filter(|n| n.length == pointed.len());
        match parsed {
            Some(number) if number.value.is_finite() => Ok(number.value),
            _ => Err(self.wrong(line, &quoted(content), "a number")),
        }
    }

    fn positive(&self, line: usize) -> Result<f64, PhotometryError> {
        let number = self.number(line)?;
        if number >= 0.0 {
            return Ok(number);
        }
        Err(self.wrong(line, &format!("{number}"), "0 or more"))
    }

    fn whole(&self, line: usize, most: usize) -> Result<usize, PhotometryError> {
        let number = self.number(line)?;
        if number.fract() == 0.0 && (0.0..=most as f64).contains(&number) {
            return Ok(number as usize);
        }
        Err(self.wrong(line, &format!("{number}"), "a whole number in its range"))
    }

    fn numbers(&self, first: usize, count: usize) -> Result<Vec<f64>, PhotometryError> {
        (first..first + count)
            .map(|line| self.number(line))
            .collect()
    }

    fn lamps(&self, first: usize) -> Result<LampSet, PhotometryError> {
        let set = LampSet {
            count: self.number(first)?,
            kind: text(self.line(first + 1)?).into_owned(),
            lumens: self.positive(first + 2)?,
        };
        Ok(set)
    }
}
