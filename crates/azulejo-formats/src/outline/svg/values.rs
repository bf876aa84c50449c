//! Numbers, lengths, transforms and colours in SVG syntax.

use crate::reading::number;
use azulejo_scene::Rgb;
use glam::{DAffine2, DMat2, DVec2};

/// Reads values separated by blanks and commas.
#[derive(Clone, Copy, Debug)]
pub(super) struct SvgScanner<'a> {
    rest: &'a [u8],
}

impl<'a> SvgScanner<'a> {
    /// A scanner at the start of a text.
    pub fn new(text: &'a str) -> SvgScanner<'a> {
        SvgScanner {
            rest: text.as_bytes(),
        }
    }

    /// The next byte after blanks and commas, which is not consumed.
    pub fn peek(&mut self) -> Option<u8> {
        let is_blank = |b: &u8| b.is_ascii_whitespace() || *b == b',';
        let blanks = self.rest.iter().take_while(|b| is_blank(b)).count();
        self.rest = &self.rest[blanks..];
        self.rest.first().copied()
    }

    /// The next byte.
    pub fn byte(&mut self) -> Option<u8> {
        let byte = self.peek()?;
        self.rest = &self.rest[1..];
        Some(byte)
    }

    /// The next number, which ends where it cannot continue: `1.5.5-3` is three numbers.
    pub fn number(&mut self) -> Option<f64> {
        self.peek()?;
        let found = number::parse(self.rest)?;
        let is_good = found.value.abs() <= LARGEST && !found.misplaced_sign;
        self.rest = &self.rest[found.length..];
        is_good.then_some(found.value)
    }

    /// Two numbers.
    pub fn point(&mut self) -> Option<DVec2> {
        Some(DVec2::new(self.number()?, self.number()?))
    }

    /// One digit, 0 or 1, with or without a following blank.
    pub fn flag(&mut self) -> Option<bool> {
        let flag = match self.peek()? {
            b'0' => false,
            b'1' => true,
            _ => return None,
        };
        self.rest = &self.rest[1..];
        Some(flag)
    }

    /// All remaining numbers.
    pub fn numbers(mut self) -> Option<Vec<f64>> {
        let mut numbers = Vec::new();
        while self.peek().is_some() {
            numbers.push(self.number()?);
        }
        Some(numbers)
    }
}

/// Larger numbers are damage, and their squares could overflow.
const LARGEST: f64 = 1e30;

/// The length of a CSS unit in SVG's user units, of which there are 96 to the inch.
fn unit(name: &str) -> Option<f64> {
    const PER_INCH: f64 = 96.0;
    Some(match name {
        "" | "px" => 1.0,
        "pt" => PER_INCH / 72.0,
        "pc" => PER_INCH / 6.0,
        "mm" => PER_INCH / 25.4,
        "cm" => PER_INCH / 2.54,
        "in" => PER_INCH,
        _ => return None,
    })
}

/// A length in SVG's user units, and whether its unit is a physical one.
pub(super) fn length(text: &str) -> Option<(f64, bool)> {
    let text = text.trim();
    let found = number::parse(text.as_bytes())?;
    let name = text[found.length..].trim();
    let value = found.value * unit(name)?;
    (value.abs() <= LARGEST).then_some((value, !matches!(name, "" | "px")))
}

/// A list of transforms as one; `None` if it is malformed.
pub(super) fn transform(text: &str) -> Option<DAffine2> {
    let mut map = DAffine2::IDENTITY;
    let mut rest = text.trim_matches(is_separator);
    while !rest.is_empty() {
        let (name, behind) = rest.split_once('(')?;
        let (numbers, behind) = behind.split_once(')')?;
        let numbers = SvgScanner::new(numbers).numbers()?;
        map *= one_transform(name.trim(), &numbers)?;
        rest = behind.trim_start_matches(is_separator);
    }
    map.is_finite().then_some(map)
}

fn is_separator(c: char) -> bool {
    c.is_whitespace() || c == ','
}

fn one_transform(name: &str, numbers: &[f64]) -> Option<DAffine2> {
    let shear = |x: f64, y: f64| {
        let tan = |degrees: f64| degrees.to_radians().tan();
        DAffine2::from_mat2(DMat2::from_cols_array(&[1.0, tan(y), tan(x), 1.0]))
    };
    Some(match (name, numbers) {
        ("matrix", &[a, b, c, d, e, f]) => DAffine2::from_cols_array(&[a, b, c, d, e, f]),
        ("translate", &[x]) => DAffine2::from_translation(DVec2::new(x, 0.0)),
        ("translate", &[x, y]) => DAffine2::from_translation(DVec2::new(x, y)),
        ("scale", &[s]) => DAffine2::from_scale(DVec2::splat(s)),
        ("scale", &[x, y]) => DAffine2::from_scale(DVec2::new(x, y)),
        ("rotate", &[degrees]) => DAffine2::from_angle(degrees.to_radians()),
        ("rotate", &[degrees, x, y]) => {
            let centre = DVec2::new(x, y);
            DAffine2::from_translation(centre)
                * DAffine2::from_angle(degrees.to_radians())
                * DAffine2::from_translation(-centre)
        }
        ("skewX", &[degrees]) => shear(degrees, 0.0),
        ("skewY", &[degrees]) => shear(0.0, degrees),
        _ => return None,
    })
}

/// A colour, linear: `#rgb`, `#rrggbb`, `rgb(…)`, and the sixteen names of HTML.
pub(super) fn color(text: &str) -> Option<Rgb> {
    const NAMES: [(&str, [u8; 3]); 18] = [
        ("black", [0, 0, 0]),
        ("silver", [192, 192, 192]),
        ("gray", [128, 128, 128]),
        ("grey", [128, 128, 128]),
        ("white", [255, 255, 255]),
        ("maroon", [128, 0, 0]),
        ("red", [255, 0, 0]),
        ("purple", [128, 0, 128]),
        ("fuchsia", [255, 0, 255]),
        ("green", [0, 128, 0]),
        ("lime", [0, 255, 0]),
        ("olive", [128, 128, 0]),
        ("yellow", [255, 255, 0]),
        ("navy", [0, 0, 128]),
        ("blue", [0, 0, 255]),
        ("teal", [0, 128, 128]),
        ("aqua", [0, 255, 255]),
        ("orange", [255, 165, 0]),
    ];
    let text = text.trim().to_ascii_lowercase();
    if let Some((_, bytes)) = NAMES.iter().find(|(name, _)| *name == text) {
        return Some(linear(bytes.map(f64::from)));
    }
    if let Some(digits) = text.strip_prefix('#') {
        return hexadecimal(digits);
    }
    let inner = text.strip_prefix("rgb(")?.strip_suffix(')')?;
    let part = |part: &str| match part.trim().strip_suffix('%') {
        Some(percent) => Some(2.55 * percent.trim().parse::<f64>().ok()?),
        None => part.trim().parse::<f64>().ok(),
    };
    let parts: Option<Vec<f64>> = inner.split(',').map(part).collect();
    match parts?[..] {
        [r, g, b] if (r + g + b).is_finite() => Some(linear([r, g, b])),
        _ => None,
    }
}

fn hexadecimal(digits: &str) -> Option<Rgb> {
    let code = u32::from_str_radix(digits, 16).ok()?;
    let part = |shift: u32, mask: u32| f64::from(code >> shift & mask);
    match digits.len() {
        3 => Some(linear([8, 4, 0].map(|s| 17.0 * part(s, 15)))),
        6 => Some(linear([16, 8, 0].map(|s| part(s, 255)))),
        _ => None,
    }
}

/// sRGB from 0 to 255 as linear light, IEC 61966-2-1.
fn linear(parts: [f64; 3]) -> Rgb {
    let [r, g, b] = parts.map(|part| match (part / 255.0).clamp(0.0, 1.0) {
        c if c <= 0.04045 => c / 12.92,
        c => ((c + 0.055) / 1.055).powf(2.4),
    });
    Rgb::new(r, g, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_run_into_each_other() {
        let check = |text: &str, expected: Option<&[f64]>| {
            let found = SvgScanner::new(text).numbers();
            assert_eq!(found.as_deref(), expected, "{text}");
        };
        check(" 1,-2 \n+3e1", Some(&[1.0, -2.0, 30.0]));
        check("1.5.5-3-.25e-1", Some(&[1.5, 0.5, -3.0, -0.025]));
        check("", Some(&[]));
        check("1 x", None);
        check("1e99", None);
    }

    #[test]
    fn lengths_have_units() {
        assert_eq!(length("25.4mm"), Some((96.0, true)));
        assert_eq!(length(" 1in "), Some((96.0, true)));
        assert_eq!(length("12"), Some((12.0, false)));
        assert_eq!(length("12px"), Some((12.0, false)));
        assert_eq!(
            (length("50%"), length("auto"), length("2em")),
            (None, None, None)
        );
    }

    #[test]
    fn transforms_are_applied_from_the_right() {
        let check = |text: &str, expected: [f64; 2]| {
            let found = transform(text)
                .unwrap()
                .transform_point2(DVec2::new(1.0, 2.0));
            assert!(found.distance(expected.into()) < 1e-12, "{text} {found}");
        };
        check("", [1.0, 2.0]);
        check("translate(10)", [11.0, 2.0]);
        check("translate(10, 20) scale(2)", [12.0, 24.0]);
        check("scale(2,3),translate(1 1)", [4.0, 9.0]);
        check("rotate(90)", [-2.0, 1.0]);
        check("rotate(90 1 1)", [0.0, 1.0]);
        check("matrix(1 0 2 1 5 6)", [10.0, 8.0]);
        check("skewX(45) ", [3.0, 2.0]);
        check("skewY(45)", [1.0, 3.0]);
        for bad in [
            "scale",
            "scale(",
            "scale()",
            "spin(3)",
            "rotate(1,2)",
            "scale(a)",
        ] {
            assert_eq!(transform(bad), None, "{bad}");
        }
    }

    #[test]
    fn colors_are_linear() {
        let check = |text: &str, expected: [f64; 3]| {
            let [r, g, b] = expected;
            assert_eq!(color(text), Some(Rgb::new(r, g, b)), "{text}");
        };
        check("#f00", [1.0, 0.0, 0.0]);
        check("#00FF00", [0.0, 1.0, 0.0]);
        check("rgb(0, 0,255)", [0.0, 0.0, 1.0]);
        check("rgb(100%,0%,100%)", [1.0, 0.0, 1.0]);
        check(" White ", [1.0, 1.0, 1.0]);
        assert!((color("#808080").unwrap().r - 0.2159).abs() < 1e-4);
        for bad in ["url(#a)", "#12", "rgb(1,2)", "chartreusy", "", "#é12"] {
            assert_eq!(color(bad), None, "{bad}");
        }
    }
}
