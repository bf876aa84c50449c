//! Colours: by the AutoCAD colour index, or as red, green and blue.

use super::record::Record;
use crate::picture::srgb::linear_from_srgb_f64;
use azulejo_scene::Rgb;
use std::fmt;

/// The colour of an entity or a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Color {
    /// That of the entity's layer.
    ByLayer,
    /// That of the INSERT that instantiates the entity's block.
    ByBlock,
    /// The entity's own colour.
    Own(Paint),
}

/// An explicit colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Paint {
    /// The AutoCAD colour index, 1..=255.
    Index(u8),
    /// Red, green and blue, eight bits each from the highest.
    True(u32),
}

/// The default pen colour: black on white and white on black. It does not describe a
/// surface, and layers have it until the user chooses another.
pub(super) const FOREGROUND: Paint = Paint::Index(7);

/// Reflectance of surfaces without a meaningful colour.
const DEFAULT_REFLECTANCE: Rgb = Rgb::grey(0.5);

impl Color {
    /// The colour of an entity.
    pub fn of(record: &Record) -> Color {
        Color::with_codes(record, 62, 420)
    }

    /// The colour in groups of these codes, one for the index and one for a true colour.
    pub fn with_codes(record: &Record, index: i16, true_color: i16) -> Color {
        if let Some(paint) = Paint::true_color(record, true_color) {
            return Color::Own(paint);
        }
        match record.integer(index, 256) {
            0 => Color::ByBlock,
            index @ 1..=255 => Color::Own(Paint::Index(index as u8)),
            _ => Color::ByLayer,
        }
    }
}

impl Paint {
    /// The true colour in a group of this code, if there is one.
    pub fn true_color(record: &Record, code: i16) -> Option<Paint> {
        let value = record.whole(record.find(code)?)?;
        Some(Paint::True(value as u32 & 0xff_ffff))
    }

    /// A colour of a MATERIAL: its highest byte determines the meaning of the others.
    pub fn of_material(value: i64) -> Paint {
        const BY_INDEX: i64 = 0xc3;
        match (value >> 24) & 0xff {
            BY_INDEX => Paint::Index(value as u8),
            _ => Paint::True(value as u32 & 0xff_ffff),
        }
    }

    /// The diffuse reflectance of a surface of this colour.
    pub fn reflectance(self) -> Rgb {
        match self {
            FOREGROUND => DEFAULT_REFLECTANCE,
            other => other.linear(),
        }
    }

    /// The displayed colour (sRGB) as linear light.
    pub fn linear(self) -> Rgb {
        let [r, g, b] = match self {
            Paint::Index(index) => index_to_rgb(index),
            Paint::True(value) => [(value >> 16) as u8, (value >> 8) as u8, value as u8],
        };
        [r, g, b]
            .map(|byte| linear_from_srgb_f64(f64::from(byte) / 255.0))
            .into()
    }
}

impl fmt::Display for Paint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Paint::Index(index) => write!(f, "{index}"),
            Paint::True(value) => write!(f, "#{value:06x}"),
        }
    }
}

/// The AutoCAD colour index as red, green and blue.
///
/// 1 to 9 are named colours, 250 to 255 greys. In between, the tens are 24 hues in steps of 15° from
/// red; the units are five brightness levels, and odd ones are half as saturated.
fn index_to_rgb(index: u8) -> [u8; 3] {
    const NAMED: [[u8; 3]; 10] = [
        [0, 0, 0],
        [255, 0, 0],
        [255, 255, 0],
        [0, 255, 0],
        [0, 255, 255],
        [0, 0, 255],
        [255, 0, 255],
        [255, 255, 255],
        [128, 128, 128],
        [192, 192, 192],
    ];
    const BRIGHTNESSES: [f64; 5] = [255.0, 165.0, 127.0, 76.0, 38.0];
    const GREYS: [u8; 6] = [51, 91, 132, 173, 214, 255];
    match index {
        0..=9 => NAMED[usize::from(index)],
        10..=249 => {
            let (hue, unit) = (f64::from(index / 10 - 1) / 4.0, index % 10);
            let brightness = BRIGHTNESSES[usize::from(unit / 2)];
            let saturation = if unit % 2 == 1 { 0.5 } else { 1.0 };
            // Sixths of the colour circle, with red, green and blue at 0, 2 and 4.
            [0.0, 2.0, 4.0].map(|peak: f64| {
                let away = (hue - peak).abs();
                let share = (2.0 - away.min(6.0 - away)).clamp(0.0, 1.0);
                (brightness * (1.0 - saturation * (1.0 - share))) as u8
            })
        }
        250..=255 => [GREYS[usize::from(index - 250)]; 3],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices() {
        let check = |index, expected| assert_eq!(index_to_rgb(index), expected, "{index}");
        check(1, [255, 0, 0]);
        check(8, [128, 128, 128]);
        check(10, [255, 0, 0]);
        check(11, [255, 127, 127]);
        check(12, [165, 0, 0]);
        check(30, [255, 127, 0]);
        check(50, [255, 255, 0]);
        check(71, [191, 255, 127]);
        check(90, [0, 255, 0]);
        check(130, [0, 255, 255]);
        check(170, [0, 0, 255]);
        check(178, [0, 0, 38]);
        check(210, [255, 0, 255]);
        check(240, [255, 0, 63]);
        check(249, [38, 19, 23]);
        check(250, [51, 51, 51]);
        check(255, [255, 255, 255]);
    }

    #[test]
    fn reflectances() {
        assert_eq!(Paint::Index(1).reflectance(), Rgb::new(1.0, 0.0, 0.0));
        assert_eq!(Paint::Index(7).reflectance(), Rgb::grey(0.5));
        let grey = Paint::True(0x80_8080).reflectance();
        assert!((grey.r - 0.215_86).abs() < 1e-5, "{grey:?}");
        assert_eq!(
            Paint::of_material(0xc200_ff00).reflectance(),
            Rgb::new(0.0, 1.0, 0.0)
        );
        // Also as signed 32-bit numbers.
        assert_eq!(Paint::of_material(0xc300_0005 - (1 << 32)), Paint::Index(5));
        assert_eq!(Paint::True(0xff_8000).to_string(), "#ff8000");
    }
}
