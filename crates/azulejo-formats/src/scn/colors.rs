//! Colour names.

use azulejo_scene::Rgb;
use std::collections::HashMap;

/// A hash table of all names.
#[derive(Debug)]
pub(super) struct ColorNames {
    known: HashMap<&'static str, u32>,
}

impl ColorNames {
    /// The table.
    pub fn new() -> ColorNames {
        let pairs = NAMES.split_ascii_whitespace();
        let entry = |pair: &'static str| {
            let (name, hex) = pair.split_once(':')?;
            Some((name, u32::from_str_radix(hex, 16).ok()?))
        };
        ColorNames {
            known: pairs.filter_map(entry).collect(),
        }
    }

    /// The colour with a name in either spelling: `sky_blue`, `SkyBlue`.
    pub fn get(&self, name: &str) -> Option<Rgb> {
        let known = self.known.get(name);
        let value = *known.or_else(|| self.known.get(&*snake(name)?))?;
        let channel = |shift: u32| f64::from(value >> shift & 0xff) / 255.0;
        Some(Rgb::new(channel(16), channel(8), channel(0)))
    }
}

/// Converts `SkyBlue` to `sky_blue`; `None` for other spellings.
fn snake(name: &str) -> Option<String> {
    if name.contains('_') || !name.starts_with(|c: char| c.is_ascii_uppercase()) {
        return None;
    }
    let mut snake = String::new();
    for c in name.chars() {
        if c.is_ascii_uppercase() && !snake.is_empty() {
            snake.push('_');
        }
        snake.push(c.to_ascii_lowercase());
    }
    Some(snake)
}

/// Names with their colours as sRGB bytes, which RTRACE uses as linear values without conversion. At the end,
/// capitalized names whose colour differs from that of the lower-case spelling, or that have no lower-case
/// spelling.
const NAMES: &str = include_str!("colors.txt");

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_spellings() {
        let colors = ColorNames::new();
        let check = |name: &str, expected: Option<[u8; 3]>| {
            let bytes = |c: Rgb| c.to_array().map(|v| (255.0 * v).round() as u8);
            assert_eq!(colors.get(name).map(bytes), expected, "{name}");
        };
        check("light_sky_blue", Some([0x87, 0xce, 0xfa]));
        check("LightSkyBlue", Some([0x87, 0xce, 0xfa]));
        check("white", Some([255; 3]));
        check("White", Some([252; 3]));
        check("IndianRed1", Some([0xff, 0x6a, 0x6a]));
        check("AntiqueWhite1", Some([0xff, 0xef, 0xdb]));
        check("dark_grey", None);
        check("DarkGrey", None);
        check("lightSkyBlue", None);
        check("Light_sky_blue", None);
        assert_eq!(colors.known.len(), 450 + 8);
    }
}
