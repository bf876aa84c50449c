//! Tone mapping from radiance to display values: exposure, tone curve, sRGB.

use azulejo_scene::{Image, Rgb};

/// How exposed radiance becomes display light in 0..=1; display light is linear, sRGB comes after.
///
/// Every curve maps 0 to 0 and never falls.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tone {
    /// Clips each channel at 1. Right for comparing values by eye.
    Linear,
    /// Compresses luminance and keeps chromaticity, so that lamps and bright walls keep their
    /// detail: Reinhard et al., *Photographic Tone Reproduction for Digital Images*, SIGGRAPH
    /// 2002, eq. (4), with [`REINHARD_WHITE`] as the luminance that becomes white.
    #[default]
    Reinhard,
    /// A film-like curve per channel, with a soft toe and shoulder; saturated lights turn white
    /// as on film. Narkowicz, *ACES Filmic Tone Mapping Curve*, 2015: the rational fit to the
    /// ACES reference transforms, with the factor 0.6 that aligns its exposure with theirs.
    Filmic,
}

/// The exposed luminance that [`Tone::Reinhard`] maps to 1.
pub const REINHARD_WHITE: f64 = 6.0;

/// Exposed luminance that [`auto_exposure`] gives to the typical pixel: photographers' grey card.
const KEY: f64 = 0.18;

impl Tone {
    /// Display light, 0..=1 per channel, of exposed radiance. Negative channels and NaN count
    /// as zero, infinity as the brightest finite value.
    pub fn map(self, exposed: Rgb) -> Rgb {
        let c = exposed.map(|x| if x > 0.0 { x.min(1e30) } else { 0.0 });
        let shown = match self {
            Tone::Linear => c,
            Tone::Reinhard => c * reinhard_scale(c.luminance()),
            Tone::Filmic => c.map(|x| filmic(0.6 * x)),
        };
        shown.map(|x| x.min(1.0))
    }
}

/// Display luminance over exposed luminance `l` of Reinhard's eq. (4).
fn reinhard_scale(l: f64) -> f64 {
    (1.0 + l / (REINHARD_WHITE * REINHARD_WHITE)) / (1.0 + l)
}

/// Narkowicz's rational fit, 0 at 0, rising to 2.51/2.43 at infinity.
fn filmic(x: f64) -> f64 {
    x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
}

/// Nonlinear sRGB value of a linear one, both 0..=1; IEC 61966-2-1.
pub fn srgb_from_linear(x: f64) -> f64 {
    if x <= 0.003_130_8 {
        12.92 * x
    } else {
        1.055 * x.powf(1.0 / 2.4) - 0.055
    }
}

/// The image as 8-bit sRGB, three bytes per pixel, rows from the top.
///
/// `exposure` multiplies radiance before the curve; n stops are a factor 2ⁿ. Negative and NaN
/// exposures give black.
pub fn tone_map(image: &Image, exposure: f64, tone: Tone) -> Vec<u8> {
    let byte = |x: f64| (255.0 * srgb_from_linear(x)).round() as u8;
    let display = |p: &[f32; 3]| {
        tone.map(Rgb::from(p.map(f64::from)) * exposure)
            .to_array()
            .map(byte)
    };
    image.pixels.iter().flat_map(display).collect()
}

/// An exposure for [`tone_map`] under which an unknown image is neither black nor overexposed.
///
/// The logarithmic mean of luminance becomes a middle grey (Reinhard et al. 2002, eqs. (1) and
/// (2)), made robust in two ways: pixels without light (the empty background) are left out, and
/// each pixel's luminance is clamped between 1/64 and 8 times the upper quartile, so that
/// neither deep shadow nor a lamp in view dominates. Scales inversely with the image; 1 for a
/// black image.
pub fn auto_exposure(image: &Image) -> f64 {
    let mut lit: Vec<f64> = image
        .pixels
        .iter()
        .map(|p| Rgb::from(p.map(f64::from)).luminance())
        .filter(|&l| l > 0.0 && l.is_finite())
        .collect();
    if lit.is_empty() {
        return 1.0;
    }
    let rank = lit.len() * 3 / 4;
    let (_, &mut quartile, _) = lit.select_nth_unstable_by(rank, f64::total_cmp);
    let (low, high) = (quartile / 64.0, 8.0 * quartile);
    let mean_log = lit.iter().map(|l| l.clamp(low, high).ln()).sum::<f64>() / lit.len() as f64;
    let exposure = KEY / mean_log.exp();
    // Denormal luminance would ask for an infinite factor.
    if exposure.is_finite() { exposure } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TONES: [Tone; 3] = [Tone::Linear, Tone::Reinhard, Tone::Filmic];

    fn image(pixels: &[f32]) -> Image {
        Image {
            width: pixels.len() as u32,
            height: 1,
            pixels: pixels.iter().map(|&x| [x; 3]).collect(),
            alpha: None,
        }
    }

    #[test]
    fn srgb_at_known_points() {
        // Bytes of IEC 61966-2-1; 0.2140 is the linear value of the middle byte 127.5.
        let check = |linear: f32, expected: u8| {
            let bytes = tone_map(&image(&[linear]), 1.0, Tone::Linear);
            assert_eq!(bytes, [expected; 3], "{linear}");
        };
        check(0.0, 0);
        check(0.003_130_8, 10);
        check(0.001, 3);
        check(0.18, 118);
        check(0.5, 188);
        check(0.215_860_5, 128);
        check(1.0, 255);
        check(7.0, 255);
        check(-1.0, 0);
        check(f32::NAN, 0);
        check(f32::INFINITY, 255);
    }

    #[test]
    fn both_branches_of_srgb_meet() {
        let knee = 0.003_130_8;
        assert!((srgb_from_linear(knee) - srgb_from_linear(knee * (1.0 + 1e-9))).abs() < 1e-7);
        assert!((srgb_from_linear(1.0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn curves_rise_from_zero_and_stay_in_range() {
        for tone in TONES {
            assert_eq!(tone.map(Rgb::BLACK), Rgb::BLACK);
            let mut last = 0.0;
            for k in -200..200 {
                let shown = tone.map(Rgb::grey(1.05f64.powi(k)));
                assert!(shown.r >= last && shown.r <= 1.0, "{tone:?} {k} {shown:?}");
                last = shown.r;
            }
            assert!(last > 0.99, "{tone:?} never reaches white: {last}");
        }
    }

    #[test]
    fn reinhard_keeps_chromaticity_and_maps_its_white_to_white() {
        let shown = Tone::Reinhard.map(Rgb::new(0.4, 0.2, 0.1));
        assert!((shown.r / shown.g - 2.0).abs() < 1e-12 && (shown.g / shown.b - 2.0).abs() < 1e-12);
        let white = Tone::Reinhard.map(Rgb::grey(REINHARD_WHITE));
        assert!((white.g - 1.0).abs() < 1e-12);
    }

    #[test]
    fn auto_exposure_ignores_lamp_background_and_deep_shadow() {
        let check = |pixels: &[f32]| {
            let exposed = auto_exposure(&image(pixels)) * 0.02;
            assert!((0.1..0.7).contains(&exposed), "{pixels:?}: {exposed}");
        };
        check(&[0.02; 10]);
        check(&[0.02, 0.02, 0.02, 0.02, 0.02, 0.02, 0.02, 0.02, 0.02, 900.0]);
        check(&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.02, 0.02, 0.02]);
        check(&[1e-9, 1e-9, 0.02, 0.02, 0.02, 0.02, 0.02, 0.02, 0.02, 0.02]);
        assert_eq!(auto_exposure(&image(&[0.0; 4])), 1.0);
        assert_eq!(auto_exposure(&image(&[])), 1.0);
        assert!(auto_exposure(&image(&[f32::NAN, f32::INFINITY, 1e-45])).is_finite());
    }
}
