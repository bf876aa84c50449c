//! Colour lookup: maps of 256 entries, and images.

use azulejo_scene::rtrace::ColorMap;
use azulejo_scene::{Image, Rgb};

/// The colour at `t`: the first and last outside of 0..1.
///
/// Between two entries RTRACE blends the wrong way round, from the next to this one. Kept, as its
/// images depend on it.
pub(super) fn color_at(map: &ColorMap, t: f64) -> Rgb {
    if t >= 1.0 {
        return map[255];
    }
    if t < 0.0 || t.is_nan() {
        return map[0];
    }
    let position = 256.0 * t;
    let (entry, share) = (position as usize, position.fract());
    share * map[entry] + (1.0 - share) * map[(entry + 1) % 256]
}

/// The image, interpolated bilinearly; `u` and `v` run from the lower right corner to the left and
/// up, and repeat.
pub(super) fn image_at(image: &Image, u: f64, v: f64) -> Rgb {
    let along = |x: f64, pixels: u32| {
        let position = (1.0 - (x - x.floor())) * f64::from(pixels - 1);
        let first = (position as u32).min(pixels - 1);
        (first, (first + 1).min(pixels - 1), position.fract())
    };
    let (x, next_x, fx) = along(u, image.width);
    let (y, next_y, fy) = along(v, image.height);
    let pixel = |x, y| Rgb::from(image.pixel(x, y).map(f64::from));
    let upper = (1.0 - fx) * pixel(x, y) + fx * pixel(next_x, y);
    let lower = (1.0 - fx) * pixel(x, next_y) + fx * pixel(next_x, next_y);
    // RTRACE divides bytes by 256, so 255 is not quite white.
    255.0 / 256.0 * ((1.0 - fy) * upper + fy * lower)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    #[test]
    fn a_map_runs_from_first_to_last() {
        let map: ColorMap = Arc::new(std::array::from_fn(|i| Rgb::grey(i as f64 / 255.0)));
        let check = |t: f64, expected: f64| {
            assert!((color_at(&map, t).r - expected).abs() < 1e-12, "{t}");
        };
        check(-1.0, 0.0);
        check(f64::NAN, 0.0);
        check(2.0, 1.0);
        check(0.5, 129.0 / 255.0);
        check(0.5 + 0.75 / 256.0, 128.25 / 255.0);
    }

    #[test]
    fn an_image_runs_to_the_left_and_up() {
        let mut image = Image::new(2, 2);
        image.pixels[0] = [1.0; 3];
        image.pixels[3] = [0.5; 3];
        let check = |u, v, expected: f64| {
            let green = image_at(&image, u, v).g * 256.0 / 255.0;
            assert!((green - expected).abs() < 1e-6, "{u} {v}: {green}");
        };
        check(0.0, 0.0, 0.5);
        check(0.999_999_9, 0.999_999_9, 1.0);
        check(0.5, 0.5, 0.375);
        check(-3.5, 7.5, 0.375);
    }
}
