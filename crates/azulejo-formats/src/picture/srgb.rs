//! The sRGB transfer function. IEC 61966-2-1.

use azulejo_scene::{Image, Rgb};

/// Linear light of an sRGB value, both 0..=1. IEC 61966-2-1.
pub(crate) fn linear_from_srgb(v: f32) -> f32 {
    if v <= 0.04045 {
        v / 12.92
    } else {
        ((v + 0.055) / 1.055).powf(2.4)
    }
}

/// The same in double precision.
pub(crate) fn linear_from_srgb_f64(v: f64) -> f64 {
    match v {
        v if v <= 0.04045 => v / 12.92,
        v => ((v + 0.055) / 1.055).powf(2.4),
    }
}

/// The linear colour of an sRGB one, both 0..=1.
pub(crate) fn linear_color(srgb: Rgb) -> Rgb {
    srgb.map(linear_from_srgb_f64)
}

/// The sRGB value of linear light, both 0..=1 where the light is. IEC 61966-2-1.
pub(crate) fn srgb_from_linear(v: f32) -> f32 {
    match v {
        v if v <= 0.003_130_8 => 12.92 * v,
        v => 1.055 * v.powf(1.0 / 2.4) - 0.055,
    }
}

/// The pixels as sRGB bytes, three per pixel. Values above 1 become white.
pub(crate) fn srgb_bytes(image: &Image) -> Vec<u8> {
    let byte = |&v: &f32| (255.0 * srgb_from_linear(v)).round().clamp(0.0, 255.0) as u8;
    image.pixels.iter().flatten().map(byte).collect()
}

/// Linear light of each sRGB byte.
pub(crate) fn linear_table() -> [f32; 256] {
    std::array::from_fn(|v| linear_from_srgb(v as f32 / 255.0))
}
