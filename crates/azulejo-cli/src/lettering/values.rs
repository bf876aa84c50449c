//! Parsers of option values of lettering: directions, slopes, colours, characters.

use crate::values::{not_negative, number};
use azulejo_scene::{BevelEnds, BevelProfile, Rgb};
use glam::DVec3;

/// A number above 0.
pub fn positive(text: &str) -> Result<f64, String> {
    match number(text)? {
        x if x > 0.0 => Ok(x),
        x => Err(format!("{x}, expected more than 0")),
    }
}

/// The edges of solids: their profile, their radius in scene units, and where they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    pub profile: BevelProfile,
    pub radius: f64,
    pub ends: BevelEnds,
}

/// `0.02`, `round:0.02`, `chamfer:0.02` or `chamfer:0.02:both`.
pub fn edge(text: &str) -> Result<Edge, String> {
    let (rest, ends) = match text.strip_suffix(":both") {
        Some(rest) => (rest, BevelEnds::Both),
        None => (text, BevelEnds::Front),
    };
    let (profile, radius) = match rest.split_once(':') {
        None => (BevelProfile::Round, rest),
        Some(("round", radius)) => (BevelProfile::Round, radius),
        Some(("chamfer", radius)) => (BevelProfile::Chamfer, radius),
        Some((other, _)) => {
            return Err(format!(
                "\"{other}\", expected round or chamfer, as in chamfer:0.02"
            ));
        }
    };
    let radius = positive(radius)?;
    Ok(Edge {
        profile,
        radius,
        ends,
    })
}

/// A luminous flux.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Flux {
    /// lm, of the whole.
    Whole(f64),
    /// lm per metre of the strokes.
    PerMetre(f64),
}

/// `1200lm`, or `800lm/m`.
pub fn flux(text: &str) -> Result<Flux, String> {
    let (value, kind): (_, fn(f64) -> Flux) = match text.strip_suffix("lm/m") {
        Some(value) => (value, Flux::PerMetre),
        None => match text.strip_suffix("lm") {
            Some(value) => (value, Flux::Whole),
            None => return Err(format!("\"{text}\", expected as in 1200lm or 800lm/m")),
        },
    };
    Ok(kind(positive(value.trim_end())?))
}

/// An angle in degrees between −90 and 90, exclusive.
pub fn slope(text: &str) -> Result<f64, String> {
    match number(text)? {
        x if x.abs() < 90.0 => Ok(x),
        x => Err(format!("{x} degrees, expected between -90 and 90")),
    }
}

/// One or two slopes, `20` or `20,-10`.
pub fn slopes(text: &str) -> Result<[f64; 2], String> {
    match text.split_once(',') {
        Some((across, up)) => Ok([slope(across)?, slope(up)?]),
        None => Ok([slope(text)?, 0.0]),
    }
}

/// A reflectance in 0..=1: sRGB, `#e8a030`, or linear, `0.8,0.4,0.1` or `0.5`.
pub fn reflectance(text: &str) -> Result<Rgb, String> {
    let color = radiance(text)?;
    if color.max_channel() <= 1.0 {
        Ok(color)
    } else {
        Err(format!("{text} exceeds 1, expected a reflectance"))
    }
}

/// A radiance: as [`reflectance`], but without upper limit.
pub fn radiance(text: &str) -> Result<Rgb, String> {
    if let Some(digits) = text.strip_prefix('#') {
        return screen_color(digits).ok_or_else(|| format!("\"{text}\", expected as in #e8a030"));
    }
    match text
        .split(',')
        .map(not_negative)
        .collect::<Result<Vec<_>, _>>()?[..]
    {
        [grey] => Ok(Rgb::grey(grey)),
        [r, g, b] => Ok(Rgb::new(r, g, b)),
        ref parts => Err(format!(
            "{} numbers, expected one or three, as in 0.8,0.4,0.1, or #e8a030",
            parts.len()
        )),
    }
}

/// Six hexadecimal digits of sRGB, IEC 61966-2-1, or three that stand for two each, as linear light.
fn screen_color(digits: &str) -> Option<Rgb> {
    let doubled: String;
    let digits = match digits.len() {
        3 => {
            doubled = digits.chars().flat_map(|d| [d, d]).collect();
            &doubled
        }
        _ => digits,
    };
    let code = u32::from_str_radix(digits, 16).ok()?;
    let linear = |shift: u32| match f64::from(code >> shift & 255) / 255.0 {
        c if c <= 0.04045 => c / 12.92,
        c => ((c + 0.055) / 1.055).powf(2.4),
    };
    let is_whole = digits.len() == 6 && !digits.starts_with('+');
    is_whole.then(|| Rgb::new(linear(16), linear(8), linear(0)))
}

/// The directions of SFF's text, nine numbers: `1,0,0,0,1,0,0,0,-1`.
pub fn orientation(text: &str) -> Result<[DVec3; 3], String> {
    let parts = text.split(|c: char| c == ',' || c.is_whitespace());
    let parts = parts.filter(|p| !p.is_empty()).map(number);
    let parts: Vec<f64> = parts.collect::<Result<_, _>>()?;
    let [px, py, pz, ux, uy, uz, ex, ey, ez] = parts[..] else {
        return Err(format!(
            "{} numbers, expected nine: the directions of the line, of up, and of extrusion",
            parts.len()
        ));
    };
    let given = [[px, py, pz], [ux, uy, uz], [ex, ey, ez]].map(DVec3::from);
    let names = ["line", "up direction", "extrusion"];
    if let Some(zero) = given.iter().position(|v| v.length() == 0.0) {
        return Err(format!("the {} has no length", names[zero]));
    }
    let [p, u, e] = given.map(|v| v.normalize());
    let volume = p.cross(u).dot(e).abs();
    if volume.is_nan() || volume < 1e-9 {
        let plane = "the three directions lie in one plane; letters in it would have no volume";
        return Err(plane.into());
    }
    Ok([p, u, e])
}

/// Ranges of characters: `ascii`, `latin1`, `all`, or hexadecimal codes, `20-7e,3b1,400-4ff`.
pub fn characters(text: &str) -> Result<Characters, String> {
    let mut ranges = Vec::new();
    for part in text.split(',') {
        match part.trim() {
            "ascii" => ranges.push((0x20, 0x7e)),
            "latin1" => ranges.extend([(0x20, 0x7e), (0xa0, 0xff)]),
            "all" => return Ok(Characters::All),
            codes => {
                let (first, last) = codes.split_once('-').unwrap_or((codes, codes));
                ranges.push((code(first)?, code(last)?));
            }
        }
    }
    Ok(Characters::Ranges(ranges))
}

/// A character's code: `20ac` or `U+20AC`.
fn code(text: &str) -> Result<u32, String> {
    let digits = text
        .trim()
        .trim_start_matches("U+")
        .trim_start_matches("u+");
    let code = u32::from_str_radix(digits, 16).ok();
    code.filter(|&c| c <= u32::from(char::MAX)).ok_or_else(|| {
        format!("\"{text}\" is not a character code, expected as in 20ac or 400-4ff")
    })
}

/// A selection of characters of a typeface.
#[derive(Clone, Debug, PartialEq)]
pub enum Characters {
    /// All that have a glyph.
    All,
    /// First and last character of each range.
    Ranges(Vec<(u32, u32)>),
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::values::tests::{check, refuse};

    #[test]
    fn colors_are_linear_or_of_the_screen() {
        check(reflectance, "0.5", Rgb::grey(0.5));
        check(reflectance, "1,0.5,0", Rgb::new(1.0, 0.5, 0.0));
        check(reflectance, "#ff0000", Rgb::new(1.0, 0.0, 0.0));
        check(reflectance, "#f00", Rgb::new(1.0, 0.0, 0.0));
        let grey = reflectance("#808080").unwrap();
        assert!(
            grey.is_grey() && (grey.mean() - 0.2159).abs() < 1e-4,
            "{grey:?}"
        );
        refuse(
            reflectance,
            &["", "2", "-1", "1,2", "#12345", "#+12345", "#ggg000", "red"],
        );
        check(radiance, "40,30,20", Rgb::new(40.0, 30.0, 20.0));
    }

    #[test]
    fn edges_have_a_profile_and_a_radius() {
        let round = Edge {
            profile: BevelProfile::Round,
            radius: 0.02,
            ends: BevelEnds::Front,
        };
        check(edge, "0.02", round);
        check(edge, "round:0.02", round);
        let both = Edge {
            ends: BevelEnds::Both,
            ..round
        };
        check(edge, "0.02:both", both);
        let chamfer = Edge {
            profile: BevelProfile::Chamfer,
            ..both
        };
        check(edge, "chamfer:0.02:both", chamfer);
        refuse(
            edge,
            &[
                "",
                "0",
                "-1",
                "both",
                "chamfer",
                "flat:1",
                "round:1:front",
                "round:round:1",
                "1:2",
            ],
        );
    }

    #[test]
    fn flux_is_of_the_whole_or_per_metre() {
        check(flux, "1200lm", Flux::Whole(1200.0));
        check(flux, "0.5 lm/m", Flux::PerMetre(0.5));
        refuse(flux, &["", "lm", "800", "0lm", "-1lm/m", "3W", "1lm/ft"]);
    }

    #[test]
    fn text_lies_in_three_directions() {
        let plain = [DVec3::X, DVec3::Y, DVec3::NEG_Z];
        check(orientation, "1,0,0,0,1,0,0,0,-1", plain);
        check(orientation, "2 0 0  0 3 0  0 0 -0.5", plain);
        refuse(
            orientation,
            &[
                "1 0 0 0 1 0 0 0",
                "0 0 0 0 1 0 0 0 1",
                "1 0 0 2 0 0 0 0 1",
                "1 0 0 0 1 0 1 1 0",
                "1 0 0 0 1 0 0 0 x",
            ],
        );
        check(slopes, "20", [20.0, 0.0]);
        check(slopes, "20,-5", [20.0, -5.0]);
        refuse(slopes, &["", "90", "1,2,3", "-90,0"]);
        check(positive, "0.1", 0.1);
        refuse(positive, &["0", "-1", "inf"]);
    }

    #[test]
    fn characters_come_in_ranges() {
        check(characters, "all", Characters::All);
        let ranges = Characters::Ranges(vec![(0x20, 0x7e), (0x20ac, 0x20ac), (0x400, 0x4ff)]);
        check(characters, "ascii,U+20AC, 400-4FF", ranges);
        refuse(characters, &["", "latin", "110000", "20-"]);
    }
}
