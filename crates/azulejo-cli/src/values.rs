//! Parsers of option values: `1%`, `60s`, `4G`, `640x480`, `1,2,3`.

use azulejo_formats::Lod;
use azulejo_render::FinalGather;
use azulejo_render::rtrace::Side;
use azulejo_scene::Up;
use glam::DVec3;
use globset::{Glob, GlobMatcher};
use jiff::Timestamp;
use std::time::Duration;

/// Largest width and height of an image; more is a typing error.
const MAX_SIDE: u32 = 65_536;

/// Any finite number.
pub fn number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => Err(format!("\"{text}\" is not a number")),
    }
}

/// Most rays of a final gather.
const MOST_GATHER_RAYS: u32 = 1_000_000;

/// The default of images: few rays, as there are many samples in a pixel.
pub const DEFAULT_GATHER: FinalGather = FinalGather::Uneven(16);

/// Where irradiance is gathered: `auto`, `off`, or a number of rays for everywhere.
pub fn final_gather(text: &str) -> Result<FinalGather, String> {
    match text.parse() {
        _ if text == "auto" => Ok(DEFAULT_GATHER),
        _ if text == "off" => Ok(FinalGather::Unknown),
        Ok(rays @ 1..=MOST_GATHER_RAYS) => Ok(FinalGather::Everywhere(rays)),
        _ => Err(format!(
            "\"{text}\" is not auto, off, or a number of rays from 1 to {MOST_GATHER_RAYS}"
        )),
    }
}

/// A number that is not negative.
pub fn not_negative(text: &str) -> Result<f64, String> {
    match number(text)? {
        x if x >= 0.0 => Ok(x),
        x => Err(format!("{x} is below 0")),
    }
}

/// A relative error: `1%` or `0.01`; above 0, at most 1.
pub fn fraction(text: &str) -> Result<f64, String> {
    let share = match text.strip_suffix('%') {
        Some(percent) => number(percent)? / 100.0,
        None => number(text)?,
    };
    if share > 0.0 && share <= 1.0 {
        Ok(share)
    } else {
        Err("expected more than 0 and at most 100%, as in 1% or 0.01".into())
    }
}

/// The error that row sums may have.
pub fn tolerance(text: &str) -> Result<f64, String> {
    match number(text)? {
        x if (1e-12..=0.01).contains(&x) => Ok(x),
        _ => Err("expected 1e-12 to 0.01".into()),
    }
}

/// The tolerance of compression.
pub fn compression(text: &str) -> Result<f64, String> {
    match number(text)? {
        x if (1e-9..=0.1).contains(&x) => Ok(x),
        _ => Err("expected 1e-9 to 0.1".into()),
    }
}

/// The resolution of a hemicube: even, 2 to 4096.
pub fn resolution(text: &str) -> Result<u32, String> {
    match text.trim().parse::<u32>() {
        Ok(n) if n % 2 == 0 && (2..=4096).contains(&n) => Ok(n),
        _ => Err("expected an even number from 2 to 4096".into()),
    }
}

/// A number above 0.
pub fn positive(text: &str) -> Result<f64, String> {
    match number(text)? {
        x if x > 0.0 => Ok(x),
        x => Err(format!("{x} is not above 0")),
    }
}

/// One eye of a stereo pair with their distance: `left=0.5`.
pub fn eye(text: &str) -> Result<(Side, f64), String> {
    match text.split_once('=') {
        Some(("left", apart)) => Ok((Side::Left, positive(apart)?)),
        Some(("right", apart)) => Ok((Side::Right, positive(apart)?)),
        _ => Err("expected left or right with a distance, as in left=0.5".into()),
    }
}

/// A threshold that may be negative: between −1 and 1.
pub fn threshold(text: &str) -> Result<f64, String> {
    match number(text)? {
        x if x.abs() < 1.0 => Ok(x),
        x => Err(format!("{x} is not between -1 and 1")),
    }
}

/// Splits `60s` into number and unit, which may be empty.
fn with_unit(text: &str) -> Result<(f64, &str), String> {
    let unit = text
        .rfind(|c: char| c.is_ascii_digit() || c == '.')
        .map_or(text, |end| &text[end + 1..]);
    Ok((number(&text[..text.len() - unit.len()])?, unit.trim()))
}

/// A length of time: `90`, `60s`, `500ms`, `2m`, `1.5h`; above 0, at most a year.
pub fn duration(text: &str) -> Result<Duration, String> {
    let (value, unit) = with_unit(text)?;
    let seconds = match unit {
        "ms" => value / 1000.0,
        "" | "s" => value,
        "m" | "min" => value * 60.0,
        "h" => value * 3600.0,
        _ => return Err(format!("unknown unit \"{unit}\", expected ms, s, m or h")),
    };
    if seconds > 0.0 && seconds < 366.0 * 86_400.0 {
        Ok(Duration::from_secs_f64(seconds))
    } else {
        Err("expected more than 0 seconds and at most a year".into())
    }
}

/// The value of `--time`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeArg {
    /// How long to work.
    Limit(Duration),
    /// When the sun stands where it stands.
    Instant(Timestamp),
}

/// An instant with its offset: `2025-06-21T14:00+02:00` or `...T12:00Z`; `None` if the text does
/// not begin as one.
pub fn instant(text: &str) -> Option<Result<Timestamp, String>> {
    let mut parts = text.splitn(3, '-');
    let is_date = parts
        .next()
        .is_some_and(|year| year.len() == 4 && year.bytes().all(|b| b.is_ascii_digit()))
        && parts.next().is_some();
    is_date.then(|| {
        text.parse().map_err(|e| {
            let local: Result<jiff::civil::DateTime, _> = text.parse();
            match local {
                Ok(_) => format!(
                    "\"{text}\" says no offset from UTC: write {text}+02:00, {text}-05:00 or {text}Z"
                ),
                Err(_) => format!("\"{text}\": {e}; expected as in 2025-06-21T14:00+02:00"),
            }
        })
    })
}

/// An instant alone.
pub fn when(text: &str) -> Result<Timestamp, String> {
    instant(text).unwrap_or_else(|| Err("expected as in 2025-06-21T14:00+02:00".to_owned()))
}

/// A length of time, or an instant with its offset from UTC: `60s`, `2025-06-21T14:00+02:00`.
pub fn time(text: &str) -> Result<TimeArg, String> {
    match instant(text) {
        Some(instant) => instant.map(TimeArg::Instant),
        None => duration(text).map(TimeArg::Limit),
    }
}

/// An amount of memory: `500000000`, `512M`, `4G`, `4GiB` (powers of 1024); at least 1 MiB.
pub fn bytes(text: &str) -> Result<u64, String> {
    let (value, unit) = with_unit(text)?;
    let letter = unit.trim_end_matches(['B', 'b']).trim_end_matches('i');
    let power = match letter.to_ascii_uppercase().as_str() {
        "" => 0,
        "K" => 1,
        "M" => 2,
        "G" => 3,
        "T" => 4,
        _ => return Err(format!("unknown unit \"{unit}\", expected K, M, G or T")),
    };
    let bytes = value * 1024f64.powi(power);
    if (1_048_576.0..1e18).contains(&bytes) {
        Ok(bytes as u64)
    } else {
        Err("expected at least 1M".into())
    }
}

/// An image size in pixels: `640x480`.
pub fn size(text: &str) -> Result<(u32, u32), String> {
    let side = |t: &str| {
        t.trim()
            .parse::<u32>()
            .ok()
            .filter(|s| (1..=MAX_SIDE).contains(s))
    };
    text.split_once(['x', 'X', '×'])
        .and_then(|(w, h)| Some((side(w)?, side(h)?)))
        .ok_or_else(|| format!("expected width x height, each from 1 to {MAX_SIDE}, as in 640x480"))
}

/// Numbers with commas between them.
pub fn numbers(text: &str) -> Result<Vec<f64>, String> {
    text.split(',').map(number).collect()
}

/// A point or a direction: `1,2,3`.
pub fn vector(text: &str) -> Result<DVec3, String> {
    match numbers(text)?[..] {
        [x, y, z] => Ok(DVec3::new(x, y, z)),
        ref parts => Err(format!(
            "{} numbers, expected three, as in 1,2,3",
            parts.len()
        )),
    }
}

/// An angle in degrees, 0 to 180.
pub fn angle(text: &str) -> Result<f64, String> {
    match number(text)? {
        x if (0.0..=180.0).contains(&x) => Ok(x),
        x => Err(format!("{x} degrees, expected 0 to 180")),
    }
}

/// A field of view in degrees, between 0 and 180.
pub fn degrees(text: &str) -> Result<f64, String> {
    match number(text)? {
        x if x > 0.0 && x < 180.0 => Ok(x),
        x => Err(format!("{x} degrees, expected between 0 and 180")),
    }
}

/// The value of `--up`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UpArg {
    /// The scene's up axis.
    Scene(Up),
    /// A direction that points up in the image.
    Picture(DVec3),
}

/// An axis, `y` or `z`, or a direction for the image only, `0,1,1`.
pub fn up(text: &str) -> Result<UpArg, String> {
    match axis(text) {
        Ok(up) => Ok(UpArg::Scene(up)),
        Err(_) => vector(text)
            .map(UpArg::Picture)
            .map_err(|_| "expected y or z, or for an image a direction as in 0,1,1".into()),
    }
}

/// An up axis: `y` or `z`.
pub fn axis(text: &str) -> Result<Up, String> {
    match text.trim() {
        "y" | "Y" => Ok(Up::Y),
        "z" | "Z" => Ok(Up::Z),
        other => Err(format!("\"{other}\" is not an up axis, expected y or z")),
    }
}

/// A length in metres: `mm`, `in`, or a number.
pub fn unit(text: &str) -> Result<f64, String> {
    let metres = match text.trim() {
        "um" | "µm" => 1e-6,
        "mm" => 1e-3,
        "cm" => 1e-2,
        "dm" => 1e-1,
        "m" => 1.0,
        "km" => 1e3,
        "in" => 0.0254,
        "ft" => 0.3048,
        "yd" => 0.9144,
        "mi" => 1609.344,
        "nmi" => 1852.0,
        other => number(other).map_err(|e| {
            format!("{e} of metres or one of mm, cm, dm, m, km, in, ft, yd, mi, nmi")
        })?,
    };
    if metres > 0.0 {
        Ok(metres)
    } else {
        Err(format!("the unit is {metres} m, expected more than 0"))
    }
}

/// A level of detail: `finest`, `coarsest`, `all`, a distance, or a number behind `lod`.
pub fn lod(text: &str) -> Result<Lod, String> {
    if let Some(number) = text.strip_prefix("lod") {
        let number = not_negative(number).map(Lod::Numbered);
        return number.map_err(|e| format!("{e} after \"lod\", as in lod1.3"));
    }
    match text {
        "finest" => Ok(Lod::Finest),
        "coarsest" => Ok(Lod::Coarsest),
        "all" => Ok(Lod::All),
        other => not_negative(other).map(Lod::Distance).map_err(|e| {
            format!("{e}; expected finest, coarsest, all, a distance or a number as in lod1.3")
        }),
    }
}

/// `yes` or `no`.
pub fn yes_or_no(text: &str) -> Result<bool, String> {
    match text {
        "yes" => Ok(true),
        "no" => Ok(false),
        _ => Err("expected yes or no".to_owned()),
    }
}

/// A name in which `*` and `?` stand for any characters and any one.
pub fn names(text: &str) -> Result<GlobMatcher, String> {
    let glob = Glob::new(text).map_err(|e| e.to_string())?;
    Ok(glob.compile_matcher())
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use std::fmt::Debug;

    pub(crate) fn check<T: PartialEq + Debug>(
        parse: fn(&str) -> Result<T, String>,
        input: &str,
        want: T,
    ) {
        assert_eq!(parse(input), Ok(want), "{input}");
    }

    pub(crate) fn refuse<T: Debug>(parse: fn(&str) -> Result<T, String>, inputs: &[&str]) {
        for input in inputs {
            assert!(parse(input).is_err(), "{input:?} -> {:?}", parse(input));
        }
    }

    #[test]
    fn errors_are_shares() {
        check(fraction, "1%", 0.01);
        check(fraction, "0.01", 0.01);
        check(fraction, "2.5 %", 0.025);
        refuse(
            fraction,
            &["", "%", "0", "-1%", "101%", "nan", "inf", "1 %%"],
        );
    }

    #[test]
    fn times_have_units() {
        check(duration, "90", Duration::from_secs(90));
        check(duration, "60s", Duration::from_secs(60));
        check(duration, "1.5h", Duration::from_secs(5400));
        check(duration, "250 ms", Duration::from_millis(250));
        refuse(
            duration,
            &["", "s", "0s", "-3s", "5 parsecs", "1e300h", "NaN", "5é"],
        );
    }

    #[test]
    fn memory_has_units() {
        check(bytes, "4G", 4 << 30);
        check(bytes, "512MiB", 512 << 20);
        check(bytes, "2097152", 2 << 20);
        refuse(bytes, &["", "G", "1K", "-4G", "4X", "1e30T"]);
    }

    #[test]
    fn units_axes_and_levels_of_detail() {
        check(up, "z", UpArg::Scene(Up::Z));
        check(up, "0,1,1", UpArg::Picture(DVec3::new(0.0, 1.0, 1.0)));
        refuse(up, &["", "x", "w", "1,2"]);
        check(unit, "in", 0.0254);
        check(unit, "0.5", 0.5);
        refuse(unit, &["", "parsec", "0", "-1", "nan"]);
        check(lod, "coarsest", Lod::Coarsest);
        check(lod, "120.5", Lod::Distance(120.5));
        check(lod, "lod1.3", Lod::Numbered(1.3));
        refuse(lod, &["", "-1", "best", "lod", "lod-1", "lodx"]);
    }

    #[test]
    fn sizes_and_vectors() {
        check(size, "640x480", (640, 480));
        check(size, "1×1", (1, 1));
        refuse(
            size,
            &["", "640", "0x4", "4x", "-1x2", "99999999x1", "1x2x3"],
        );
        check(vector, "1,-2.5,3e1", DVec3::new(1.0, -2.5, 30.0));
        refuse(vector, &["", "1,2", "1,2,3,4", "1,2,z", "1,2,inf"]);
        check(not_negative, "0", 0.0);
        refuse(not_negative, &["-1", "inf", "one"]);
        check(angle, "0", 0.0);
        check(angle, "180", 180.0);
        refuse(angle, &["-1", "180.5", "x", "nan"]);
        check(degrees, "40", 40.0);
        refuse(degrees, &["0", "180", "-5", "x"]);
    }
}
