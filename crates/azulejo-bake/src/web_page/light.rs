//! Light as logarithms, predicted from its neighbours.
//!
//! A value v of a map whose largest is p becomes the integer `STEPS·log2(v/p) + TOP`, at least 1,
//! and 0 where there is no light. For each texel, row by row, four such integers g, r − g, b − g and
//! that of the standard error's luminance (if known) are predicted from the texels to the left, above,
//! and above left; what is stored is the difference, the lower bytes of a list before the upper ones.

use super::PageLightmap;
use super::planes::zigzag16;
use azulejo_scene::Rgb;

/// Codes per factor 2 of irradiance: half a step is 0.27%.
pub(super) const LIGHT_STEPS: u16 = 128;

/// Codes per factor 2 of standard errors: half a step is 4.4%.
pub(super) const ERROR_STEPS: u16 = 8;

/// Octaves below the largest value that are kept; half floats have no more at full precision.
pub(super) const OCTAVES: u16 = 28;

/// A lightmap as it is stored.
pub(super) struct LightCodes {
    /// The largest channel of the irradiance, > 0.
    pub(super) peak: f32,
    /// The largest luminance of the standard errors, > 0; `None` if they are unknown.
    pub(super) error_peak: Option<f32>,
    /// The lists, before their compression.
    pub(super) bytes: Vec<u8>,
}

impl LightCodes {
    pub(super) fn new(map: &PageLightmap) -> LightCodes {
        let peak = largest(map.irradiance.iter().flatten().copied());
        let codes = |channel: usize| -> Vec<u16> {
            let values = map.irradiance.iter().map(|e| e[channel]);
            values.map(|v| code(v, peak, LIGHT_STEPS)).collect()
        };
        let [red, green, blue] = [0, 1, 2].map(codes);
        let width = map.width as usize;
        let mut bytes = Vec::new();
        push_residuals(&green, width, &mut bytes);
        push_residuals(&less(red, &green), width, &mut bytes);
        push_residuals(&less(blue, &green), width, &mut bytes);
        let errors: Vec<f32> = map.standard_error.iter().map(|e| luminance(*e)).collect();
        let error_peak = (!errors.is_empty()).then(|| largest(errors.iter().copied()));
        if let Some(peak) = error_peak {
            let codes: Vec<u16> = errors.iter().map(|&e| code(e, peak, ERROR_STEPS)).collect();
            push_residuals(&codes, width, &mut bytes);
        }
        LightCodes {
            peak,
            error_peak,
            bytes,
        }
    }
}

/// The largest finite value, or 1 if none is positive.
fn largest(values: impl Iterator<Item = f32>) -> f32 {
    let largest = values.filter(|v| v.is_finite()).fold(0.0, f32::max);
    if largest > 0.0 { largest } else { 1.0 }
}

/// Luminance of an error. Channels of one estimate err together, so their errors add up.
fn luminance(error: [f32; 3]) -> f32 {
    Rgb::from(error.map(f64::from)).luminance() as f32
}

/// The logarithm of `value`/`peak`, or 0 if it is not a positive finite number.
pub(super) fn code(value: f32, peak: f32, steps: u16) -> u16 {
    if !(value > 0.0 && value.is_finite()) {
        return 0;
    }
    let octaves = (f64::from(value) / f64::from(peak)).log2() + f64::from(OCTAVES);
    let code = (octaves * f64::from(steps)).round();
    // What is darker than all octaves is darker than anything beside it can make visible.
    if code < 1.0 { 0 } else { code as u16 }
}

fn less(mut codes: Vec<u16>, green: &[u16]) -> Vec<u16> {
    for (code, green) in codes.iter_mut().zip(green) {
        *code = code.wrapping_sub(*green);
    }
    codes
}

/// Adds what the prediction of each number leaves.
fn push_residuals(numbers: &[u16], width: usize, bytes: &mut Vec<u8>) {
    let residual = |k: usize| zigzag16(numbers[k].wrapping_sub(predicted(numbers, width, k)));
    let residuals: Vec<u16> = (0..numbers.len()).map(residual).collect();
    bytes.extend(residuals.iter().map(|r| *r as u8));
    bytes.extend(residuals.iter().map(|r| (*r >> 8) as u8));
}

/// The median of left, above, and left + above − above left: Weinberger, Seroussi and Sapiro, *The
/// LOCO-I Lossless Image Compression Algorithm*, 2000. Numbers count as signed.
pub(super) fn predicted(numbers: &[u16], width: usize, k: usize) -> u16 {
    let at = |k: usize| i32::from(numbers[k] as i16);
    let (row, column) = (k / width, k % width);
    let prediction = match (row, column) {
        (0, 0) => 0,
        (0, _) => at(k - 1),
        (_, 0) => at(k - width),
        _ => {
            let (left, above, corner) = (at(k - 1), at(k - width), at(k - width - 1));
            (left + above - corner).clamp(left.min(above), left.max(above))
        }
    };
    prediction as u16
}
