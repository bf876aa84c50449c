//! IESNA LM-63 photometric files, reduced to what azulejo's lights can represent: the luminous flux
//! by angle from the axis, and the size of the luminous opening.

use super::lines::number;
use crate::reading::cursor::TextCursor;
use crate::reading::text::{quoted, text};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Bins of one degree from the aiming direction to the opposite one.
pub(super) const BINS: usize = 180;

/// A luminaire in its own coordinates: metres, aiming at −z, the 0° plane along x, the origin at
/// the centre of the luminous opening.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Luminaire {
    /// Luminous flux within each degree from the axis, lumens, with all factors applied.
    pub flux: Vec<f64>,
    /// Luminous opening.
    pub opening: LuminousOpening,
    /// The product of all factors of the file, which also scales the emittance of a body.
    pub factor: f64,
    /// MGF file of its geometry, whose surfaces emit.
    pub body: Option<String>,
}

/// The shape of the luminous opening.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum LuminousOpening {
    /// A point source.
    Point,
    /// A box; the light leaves through its lower and upper sides.
    Rectangle {
        /// Along x.
        length: f64,
        /// Along y.
        width: f64,
        /// Along z, >= 0.
        height: f64,
    },
    /// A round box.
    Disc {
        diameter: f64,
        /// Along z, >= 0.
        height: f64,
    },
}

/// Parses a photometric file, of 1986 or later.
///
/// # Errors
/// A description of the syntax error.
pub(super) fn parse(bytes: &[u8]) -> Result<Luminaire, String> {
    // The line TILT= ends the header, and only numbers follow it.
    let (head, data) = split_at_tilt(bytes).ok_or("no line that begins with TILT=")?;
    let mut numbers = IesNumbers::new(data);
    numbers.skip_tilt(head.tilt_included)?;
    let [
        _lamps,
        _lumens,
        multiplier,
        vertical,
        horizontal,
        kind,
        units,
    ] = numbers.take()?;
    let [width, length, height, ballast, third, _watts] = numbers.take()?;
    // Angles come before the candelas, which have a row of vertical angles for each horizontal one.
    let vertical = numbers.list(vertical, "vertical angles")?;
    let horizontal = numbers.list(horizontal, "horizontal angles")?;
    let count = (vertical.len() * horizontal.len()) as f64;
    let candelas = numbers.list(count, "candelas")?;
    // Lengths are in feet or metres; the candelas have up to three factors, by the edition.
    let metres = if units == 1.0 { 0.3048 } else { 1.0 };
    let photometric = if head.has_third_factor { third } else { 1.0 };
    let factor = multiplier * ballast * photometric;
    if !(factor >= 0.0 && factor.is_finite()) {
        return Err("negative factors".into());
    }
    let web = PhotometricWeb {
        vertical: rising(vertical, "vertical angles")?,
        horizontal: rising(horizontal, "horizontal angles")?,
        candelas,
    };
    // Integrate the intensities in rings around the aim: lights here depend on that angle alone.
    let flux = if kind == 1.0 {
        web.around_axis()
    } else {
        web.across(kind == 2.0)
    };
    let flux: Vec<f64> = flux.iter().map(|lumens| lumens.max(0.0) * factor).collect();
    if !flux.iter().sum::<f64>().is_finite() {
        return Err("candelas that overflow".into());
    }
    Ok(Luminaire {
        flux,
        opening: opening([width, length, height].map(|size| size * metres)),
        factor,
        body: head.body,
    })
}

/// The header, before the numbers.
struct IesHeader {
    body: Option<String>,
    tilt_included: bool,
    /// Whether the number after the ballast factor is a factor too, the ballast-lamp photometric
    /// factor. It was in 1986 and 1991; 1995 and 2002 reserve it, and in 2019 it says where the file
    /// comes from, as 1.10100 does for an accredited laboratory.
    has_third_factor: bool,
}

/// The header, and what follows the line `TILT=`.
fn split_at_tilt(bytes: &[u8]) -> Option<(IesHeader, &[u8])> {
    let mut head = IesHeader {
        body: None,
        tilt_included: false,
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
            return Some((head, lines.rest()));
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
    /// Upper bound of their number.
    most: usize,
}

impl<'a> IesNumbers<'a> {
    fn new(bytes: &'a [u8]) -> IesNumbers<'a> {
        let words = bytes.split(|b| b.is_ascii_whitespace() || *b == b',');
        IesNumbers {
            words: Box::new(words.filter(|word| !word.is_empty())),
            most: bytes.len() / 2 + 1,
        }
    }

    fn next(&mut self) -> Result<f64, String> {
        let word = self
            .words
            .next()
            .ok_or("the end of the file, expected a number")?;
        number(word).ok_or_else(|| format!("{}, expected a number", quoted(word)))
    }

    fn take<const N: usize>(&mut self) -> Result<[f64; N], String> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.next()?;
        }
        Ok(values)
    }

    fn list(&mut self, count: f64, what: &str) -> Result<Vec<f64>, String> {
        if !(count >= 1.0 && count <= self.most as f64) {
            return Err(format!("{count} {what}"));
        }
        (0..count as usize).map(|_| self.next()).collect()
    }

    /// Skips the table of `TILT=INCLUDE`, the dimming of tilted lamps.
    fn skip_tilt(&mut self, is_included: bool) -> Result<(), String> {
        if is_included {
            let [_geometry, pairs] = self.take()?;
            self.list(2.0 * pairs, "numbers of a tilt table")?;
        }
        Ok(())
    }
}

/// Non-decreasing angles, in radians.
fn rising(degrees: Vec<f64>, what: &str) -> Result<Vec<f64>, String> {
    if degrees.is_sorted() {
        Ok(degrees.iter().map(|d| d.to_radians()).collect())
    } else {
        Err(format!("{what} that decrease"))
    }
}

/// The opening from the file's width, length and height, metres; circles have negative sizes.
fn opening([width, length, height]: [f64; 3]) -> LuminousOpening {
    let height = height.abs();
    if width > 0.0 && length > 0.0 {
        return LuminousOpening::Rectangle {
            length,
            width,
            height,
        };
    }
    if width < 0.0 && length <= 0.0 {
        // An ellipse becomes the circle of equal area.
        let across = if length < 0.0 {
            (width * length).sqrt()
        } else {
            -width
        };
        return LuminousOpening::Disc {
            diameter: across,
            height,
        };
    }
    LuminousOpening::Point
}

/// Luminous intensities by angle, candela.
struct PhotometricWeb {
    vertical: Vec<f64>,
    horizontal: Vec<f64>,
    /// All vertical angles for the first horizontal one, then for the next.
    candelas: Vec<f64>,
}

/// The centre of a bin of one degree, radians.
fn middle(bin: usize) -> f64 {
    (bin as f64 + 0.5).to_radians()
}

impl PhotometricWeb {
    /// Intensity at angles inside the web, bilinear; 0 elsewhere.
    fn at(&self, vertical: f64, horizontal: f64) -> f64 {
        let (Some((i, f)), Some((j, g))) = (
            place(&self.vertical, vertical),
            place(&self.horizontal, horizontal),
        ) else {
            return 0.0;
        };
        let n = self.vertical.len();
        let row = |j: usize| {
            let next = self.candelas[j * n + (i + 1).min(n - 1)];
            (1.0 - f) * self.candelas[j * n + i] + f * next
        };
        (1.0 - g) * row(j) + g * row((j + 1).min(self.horizontal.len() - 1))
    }

    /// Type C: vertical angles from the axis, horizontal ones around it. By symmetry, the mean over
    /// the given angles is the mean over all.
    fn around_axis(&self) -> Vec<f64> {
        let ends = [
            self.horizontal[0],
            self.horizontal[self.horizontal.len() - 1],
        ];
        let steps = if ends[0] == ends[1] { 1 } else { 360 };
        let step = (ends[1] - ends[0]) / f64::from(steps);
        let flux = |bin: usize| {
            let sum: f64 = (0..steps)
                .map(|k| self.at(middle(bin), ends[0] + (f64::from(k) + 0.5) * step))
                .sum();
            let edges = [bin, bin + 1].map(|edge| (edge as f64).to_radians().cos());
            TAU * (edges[0] - edges[1]) * sum / f64::from(steps)
        };
        (0..BINS).map(flux).collect()
    }

    /// Types A and B: elevation and azimuth, both 0 on the axis; a missing half mirrors the other.
    /// In type B the vertical angle rotates about the horizontal axis.
    fn across(&self, is_b: bool) -> Vec<f64> {
        let mut flux = vec![0.0; BINS];
        let degree = 1f64.to_radians();
        let ways = |angles: &[f64]| if angles[0] < 0.0 { 1.0 } else { 2.0 };
        let copies = ways(&self.vertical) * ways(&self.horizontal);
        for v in 0..BINS {
            for h in 0..BINS {
                let (v, h) = (middle(v) - FRAC_PI_2, middle(h) - FRAC_PI_2);
                let solid_angle = if is_b { h.cos() } else { v.cos() } * degree * degree;
                let from_aim = (v.cos() * h.cos()).clamp(-1.0, 1.0).acos();
                let bin = (from_aim / PI * BINS as f64) as usize;
                flux[bin.min(BINS - 1)] += copies * solid_angle * self.at(v, h);
            }
        }
        flux
    }
}

/// The position of a value in a non-decreasing list: the index before it and the fraction of the
/// way to the next; `None` outside. A list of one value holds everywhere.
fn place(list: &[f64], value: f64) -> Option<(usize, f64)> {
    let (first, last) = (*list.first()?, *list.last()?);
    if list.len() == 1 {
        return Some((0, 0.0));
    }
    if !(first..=last).contains(&value) {
        return None;
    }
    let behind = list
        .partition_point(|&x| x <= value)
        .clamp(1, list.len() - 1);
    let width = list[behind] - list[behind - 1];
    let share = if width > 0.0 {
        (value - list[behind - 1]) / width
    } else {
        0.0
    };
    Some((behind - 1, share))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of type C in feet with the given sizes, angles and candelas.
    fn file(sizes: &str, vertical: &str, horizontal: &str, candelas: &str) -> String {
        let count = |list: &str| list.split_whitespace().count();
        format!(
            "IESNA91\n[TEST] x\nTILT=NONE\n1 1000 2.0 {} {} 1 1 {sizes}\n0.5 1.0 60\n{vertical}\n{horizontal}\n{candelas}\n",
            count(vertical),
            count(horizontal)
        )
    }

    fn lumens(luminaire: &Luminaire) -> f64 {
        luminaire.flux.iter().sum()
    }

    #[test]
    fn light_the_same_everywhere() {
        let l = parse(file("0 0 0", "0 180", "0", "100 100").as_bytes()).unwrap();
        assert!((lumens(&l) - 400.0 * PI).abs() < 1e-9);
        assert_eq!(
            (l.opening, l.factor, l.body),
            (LuminousOpening::Point, 1.0, None)
        );
        // The same over a quarter of the horizon, and over all of it.
        for horizontal in ["0 90", "0 90 180 270 360"] {
            let candelas = "100 100 ".repeat(horizontal.split(' ').count());
            let l = parse(file("0 0 0", "0 180", horizontal, &candelas).as_bytes()).unwrap();
            assert!((lumens(&l) - 400.0 * PI).abs() < 1e-9);
        }
    }

    #[test]
    fn a_matt_opening() {
        let angles: Vec<String> = (0..=90).map(|a| a.to_string()).collect();
        let candelas: Vec<String> = (0..=90)
            .map(|a| (100.0 * f64::from(a).to_radians().cos()).to_string())
            .collect();
        let l = parse(file("1 2 0", &angles.join(" "), "0", &candelas.join(",")).as_bytes());
        let l = l.unwrap();
        // Lambert: Φ = π I.
        assert!((lumens(&l) - 100.0 * PI).abs() < 0.02);
        let rectangle = LuminousOpening::Rectangle {
            length: 0.6096,
            width: 0.3048,
            height: 0.0,
        };
        assert_eq!(l.opening, rectangle);
    }

    #[test]
    fn spotlights_of_types_a_and_b() {
        // 100 cd within 10 degrees up and across; type B gives both halves across.
        for (kind, horizontal, rows) in [("3", "0 10", 2), ("2", "-10 10", 2)] {
            let text = format!(
                "TILT=INCLUDE\n1\n2\n0 90\n1 1\n1 1 1 2 2 {kind} 2 -0.2 0 0 1 1 1 -10 10 {horizontal} {}",
                "100 100 ".repeat(rows)
            );
            let l = parse(text.as_bytes()).unwrap();
            let side = 20f64.to_radians();
            assert!(
                (lumens(&l) / (100.0 * side * side) - 1.0).abs() < 0.01,
                "{}",
                lumens(&l)
            );
            assert!(l.flux[15..].iter().all(|&f| f == 0.0));
            let disc = LuminousOpening::Disc {
                diameter: 0.2,
                height: 0.0,
            };
            assert_eq!(l.opening, disc);
        }
    }

    #[test]
    fn the_third_factor_is_one_in_old_files_only() {
        let check = |first: &str, expected: f64| {
            let text = file("0 0 0", "0 180", "0", "100 100");
            let text = text.replace("0.5 1.0 60", "0.5 1.101 60");
            let l = parse(text.replace("IESNA91", first).as_bytes()).unwrap();
            assert!((l.factor / expected - 1.0).abs() < 1e-12, "{first}");
            assert!((lumens(&l) / (400.0 * PI * expected) - 1.0).abs() < 1e-9);
        };
        for old in [
            "IESNA91",
            "iesna91",
            "A lamp of 1986",
            "",
            "IESNA:LM-63-1991",
        ] {
            check(old, 1.101);
        }
        for new in [
            "IESNA:LM-63-1995",
            "IESNA: LM-63-2002",
            "IES:LM-63-2019",
            "ies:lm-63-2019",
            "IESNA:LM-63 - 2002",
        ] {
            check(new, 1.0);
        }
    }

    #[test]
    fn bodies() {
        let with = |line: &str| {
            let text = file("0 0 0", "0 90", "0", "1 1").replace("[TEST] x", line);
            parse(text.as_bytes()).unwrap().body
        };
        assert_eq!(
            with("[LUMINOUSGEOMETRY]  lamp.mgf").as_deref(),
            Some("lamp.mgf")
        );
        assert_eq!(with("GEOM=lamp.mgf").as_deref(), Some("lamp.mgf"));
        assert_eq!(with("[LUMINOUSGEOMETRY]"), None);
    }

    #[test]
    fn what_is_wrong() {
        let check = |text: &str, expected: &str| {
            let error = parse(text.as_bytes()).unwrap_err();
            assert!(error.contains(expected), "{error}");
        };
        let good = file("0 0 0", "0 90", "0", "1 1");
        check("", "TILT=");
        check("TILT=NONE\n1 2 3", "the end of the file");
        check(&good.replace("1000", "many"), "\"many\", expected a number");
        check(
            &good.replace("2.0 2 1", "2.0 9e9 1"),
            "9000000000 vertical angles",
        );
        check(&good.replace("2.0 2 1", "2.0 0 1"), "0 vertical angles");
        check(&good.replace("0 90", "90 0"), "decrease");
        check(&good.replace("2.0 2 1", "-2.0 2 1"), "negative factors");
        check(
            &good
                .replace("\n1 1\n", "\n1e308 1e308\n")
                .replace("2.0 2 1", "9.0 2 1"),
            "overflow",
        );
    }
}
