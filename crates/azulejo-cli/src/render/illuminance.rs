//! `render --look illuminance`: how much light arrives at what the camera sees, in false colours.

use super::args::{RenderArgs, RenderStyle};
use crate::drawing::{Color, Drawing, INK, RgbImage, TextAnchor, raster};
use crate::failure::Failure;
use crate::report::short;
use azulejo::luminaire::kinds::round_step;
use azulejo_render::NO_IRRADIANCE;
use azulejo_scene::{Image, Rgb};
use glam::DVec2;

/// Viridis, by van der Walt and Smith, at even steps, sRGB: distinct with any colour vision, and rising in lightness.
const COLORS: [Color; 9] = [
    [68, 1, 84],
    [71, 44, 122],
    [59, 81, 139],
    [44, 113, 142],
    [33, 144, 141],
    [39, 173, 129],
    [92, 200, 99],
    [170, 220, 50],
    [253, 231, 37],
];

/// Where no surface is.
const NOTHING: Color = [200, 200, 200];

/// Share of the pixels that may exceed the scale: lamps shine on themselves and on what touches them.
const ABOVE: f64 = 0.005;

/// Colours of the scale: with those of its text, few enough for a palette.
const LEVELS: f64 = 160.0;

/// Steps of the scale.
const STEPS: f64 = 5.0;

/// Height of the scale below the picture, and of its text, relative to the width of 512 pixels.
const FOOT: f64 = 44.0;
const TEXT: f64 = 13.0;

/// Refuses options for pictures of light.
pub fn check(args: &RenderArgs) -> Result<(), Failure> {
    if args.look.look != RenderStyle::Illuminance {
        return Ok(());
    }
    let given = [
        ("exposure", args.picture.exposure.is_some()),
        ("reference", args.picture.reference),
        ("layers", args.picture.layers.is_some()),
        ("denoise", args.picture.denoise),
    ];
    match given.into_iter().find(|(_, is_given)| *is_given) {
        Some((name, _)) => Err(Failure::misuse(format_args!(
            "--{name} does not apply to --look illuminance, which shows what arrives at surfaces"
        ))),
        None => Ok(()),
    }
}

/// The illuminance of a pixel: the luminous part where light is photometric, else the mean of its channels.
fn value(pixel: [f32; 3], is_photometric: bool) -> f64 {
    let color = Rgb::from(pixel.map(f64::from));
    if is_photometric {
        color.luminance()
    } else {
        color.mean()
    }
}

/// The picture with its scale, sRGB, and the value at the end of the scale.
pub fn picture(image: &Image, is_photometric: bool) -> Option<(RgbImage, f64)> {
    let is_surface = |pixel: &[f32; 3]| pixel[0] != NO_IRRADIANCE;
    let surfaces = image.pixels.iter().filter(|p| is_surface(p));
    let mut values: Vec<f64> = surfaces.map(|p| value(*p, is_photometric)).collect();
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    let most = values.get(last - (ABOVE * last as f64) as usize).copied();
    let step = round_step(most.unwrap_or(0.0) / STEPS);
    let end = step * (most.unwrap_or(0.0) / step).ceil().max(1.0);
    let color = |pixel: &[f32; 3]| {
        if is_surface(pixel) {
            color_at(value(*pixel, is_photometric) / end)
        } else {
            NOTHING
        }
    };
    let colored = RgbImage {
        width: image.width,
        height: image.height,
        rgb: image.pixels.iter().flat_map(color).collect(),
    };
    let unit = if is_photometric { "lx" } else { "W/m²" };
    Some((with_scale(colored, [step, end], unit)?, end))
}

/// The colour of the level at a share of the scale.
fn color_at(share: f64) -> Color {
    let level = (share * LEVELS).floor().clamp(0.0, LEVELS - 1.0);
    let at = level / (LEVELS - 1.0) * (COLORS.len() - 1) as f64;
    let low = (at as usize).min(COLORS.len() - 2);
    let t = at - low as f64;
    let mixed = |k: usize| {
        let [a, b] = [COLORS[low][k], COLORS[low + 1][k]].map(f64::from);
        (a + t * (b - a)).round() as u8
    };
    [mixed(0), mixed(1), mixed(2)]
}

fn with_scale(picture: RgbImage, [step, end]: [f64; 2], unit: &str) -> Option<RgbImage> {
    let [width, height] = [picture.width, picture.height].map(f64::from);
    let size = (width / 512.0).max(0.5);
    let pixels = picture.width;
    let mut sheet = Drawing::on_white(width, (height + FOOT * size).round());
    sheet.image(DVec2::ZERO, DVec2::new(width, height), picture);
    let (left, right) = (24.0 * size, width - 60.0 * size);
    let (top, bottom) = (height + 8.0 * size, height + 20.0 * size);
    let place = |share: f64| left + share * (right - left);
    for level in 0..LEVELS as u32 {
        // To the end, under those that follow, so that no gap shows between them.
        let x = place(f64::from(level) / LEVELS);
        let corners = [(x, top), (right, top), (right, bottom), (x, bottom)];
        let color = color_at((f64::from(level) + 0.5) / LEVELS);
        sheet.polygon(corners.map(DVec2::from).into(), color);
    }
    let count = (end / step).round() as u32;
    for k in 0..=count {
        let value = f64::from(k) * step;
        let at = DVec2::new(place(value / end), bottom + (TEXT + 3.0) * size);
        sheet.text(at, TextAnchor::Middle, TEXT * size, INK, &short(value));
    }
    let at = DVec2::new(right + 12.0 * size, bottom);
    sheet.text(at, TextAnchor::Start, TEXT * size, INK, unit);
    raster::rasterize(&sheet, pixels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_end_at_round_numbers() {
        let mut image = Image::new(100, 10);
        for (k, pixel) in image.pixels.iter_mut().enumerate() {
            *pixel = [k as f32 * 0.87; 3];
        }
        image.pixels[0] = [NO_IRRADIANCE; 3];
        let (picture, end) = picture(&image, true).unwrap();
        assert_eq!(end, 1000.0);
        assert_eq!((picture.width, picture.height), (100, 32));
        assert_eq!(picture.rgb[..3], NOTHING);
        assert_eq!(picture.rgb[3..6], COLORS[0]);
        // Rising in lightness.
        let sum = |c: Color| c.iter().map(|x| u32::from(*x)).sum::<u32>();
        assert!(sum(color_at(1.0)) > sum(color_at(0.5)) && color_at(2.0) == COLORS[8]);
    }

    #[test]
    fn darkness_has_a_scale_too() {
        let (_, end) = picture(&Image::new(8, 8), false).unwrap();
        assert!(end > 0.0);
    }
}
