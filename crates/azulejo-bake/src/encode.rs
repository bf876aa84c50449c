//! Light as bytes of pictures.

use azulejo_trace::sampling::hash;

/// Linear light as sRGB bytes, rows from the top, and the light of the value 1: the largest of all
/// texels.
///
/// Each byte is rounded up or down at random, keyed on the texel, so that the mean of a few texels is nearer
/// than half a step: the same for all runs.
pub fn srgb_bytes(light: &[[f32; 3]]) -> (Vec<u8>, f64) {
    let most = light.iter().flatten().copied().fold(0.0, f32::max);
    if most.is_nan() || most <= 0.0 {
        return (vec![0; 3 * light.len()], 0.0);
    }
    (srgb_bytes_up_to(light, most), f64::from(most))
}

/// Linear light as [`srgb_bytes`], with a given light of the value 1, above 0: what is brighter is cut there.
pub fn srgb_bytes_up_to(light: &[[f32; 3]], most: f32) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(3 * light.len());
    for (texel, value) in light.iter().enumerate() {
        for (channel, &v) in value.iter().enumerate() {
            bytes.push(dithered(v / most, texel as u32, channel as u32));
        }
    }
    bytes
}

/// Values of 0..=1 as linear bytes of grey, rounded as in [`srgb_bytes`].
pub fn linear_bytes(values: &[[f32; 3]]) -> Vec<u8> {
    let byte = |(texel, value): (usize, &[f32; 3])| {
        let value = 255.0 * (value.iter().sum::<f32>() / 3.0).clamp(0.0, 1.0);
        let below = value.floor().min(254.0);
        let is_up = value - below > threshold(texel as u32, 0);
        [below as u8 + u8::from(is_up); 3]
    };
    values.iter().enumerate().flat_map(byte).collect()
}

/// One of the two bytes around a linear value 0..=1, so that the mean of what they decode to is the value.
fn dithered(linear: f32, texel: u32, channel: u32) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let below = (255.0 * encoded(linear)).floor().min(254.0);
    let (low, high) = (decoded(below / 255.0), decoded((below + 1.0) / 255.0));
    let share = ((linear - low) / (high - low)).clamp(0.0, 1.0);
    below as u8 + u8::from(share > threshold(texel, channel))
}

/// What share of a step is rounded up, 0..1.
fn threshold(texel: u32, channel: u32) -> f32 {
    (hash(&[texel, channel, 0xd17]) >> 8) as f32 / (1 << 24) as f32
}

/// The transfer function of sRGB (IEC 61966-2-1).
fn encoded(linear: f32) -> f32 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

/// Its inverse.
fn decoded(value: f32) -> f32 {
    if value <= 0.040_45 {
        value / 12.92
    } else {
        ((value + 0.055) / 1.055).powf(2.4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean of many texels of one value is the value, far nearer than a step.
    #[test]
    fn dither_keeps_the_mean() {
        for value in [0.001, 0.03, 0.217, 0.9] {
            let mut light = vec![[value; 3]; 4096];
            light[0] = [1.0; 3];
            let (bytes, intensity) = srgb_bytes(&light);
            assert_eq!(intensity, 1.0);
            let sum: f32 = bytes[3..]
                .iter()
                .map(|&b| decoded(f32::from(b) / 255.0))
                .sum();
            let mean = sum / (3.0 * 4095.0);
            assert!((mean / value - 1.0).abs() < 0.004, "{value}: {mean}");
        }
        assert_eq!(srgb_bytes(&[[0.0; 3]; 2]), (vec![0; 6], 0.0));
        assert_eq!(srgb_bytes_up_to(&[[0.0, 2.0, 9.0]], 2.0), [0, 255, 255]);
        assert_eq!(
            linear_bytes(&[[0.0; 3], [1.0; 3]]),
            [0, 0, 0, 255, 255, 255]
        );
        let sum: u32 = linear_bytes(&[[0.3; 3]; 4096])
            .into_iter()
            .map(u32::from)
            .sum();
        assert!((f64::from(sum) / (3.0 * 255.0 * 4096.0) - 0.3).abs() < 2e-4);
    }
}
