//! Chromaticities: CIE coordinates, spectra, mixtures and black bodies.

use azulejo_scene::Rgb;
use std::ops::RangeInclusive;
use std::sync::LazyLock;

/// CIE 1931 2° colour-matching functions x̄, ȳ, z̄ from 380 to 780 nm in steps of 10 nm.
///
/// CIE 15, *Colorimetry*, table of the CIE 1931 standard colorimetric observer.
static CURVES: LazyLock<Vec<[f64; 3]>> = LazyLock::new(|| {
    let curves = |line: &str| {
        let mut numbers = line.split(',').map_while(|n| n.parse().ok());
        // The first one is the wavelength.
        numbers.next()?;
        Some([numbers.next()?, numbers.next()?, numbers.next()?])
    };
    include_str!("cie_1931.csv")
        .lines()
        .filter_map(curves)
        .collect()
});

/// First and last wavelength of [`CURVES`], nm.
const VISIBLE: RangeInclusive<u32> = 380..=780;

/// Converts XYZ with white point E to linear BT.709 RGB, by rows.
///
/// The inverse of the matrix of the primaries (ITU-R BT.709, white D65 at 0.3127, 0.3290) after
/// Bradford adaptation from E to D65, so that equal energy is grey.
const RGB_FROM_XYZ: [[f64; 3]; 3] = [
    [3.1466576541, -1.6664637545, -0.4801938996],
    [-0.9955216058, 1.9557567338, 0.0397648720],
    [0.0635948029, -0.2145632222, 1.1509684193],
];

/// Chromaticities this close to white are taken as white: files round 1/3 to three digits.
const NEAR_WHITE: f64 = 5e-4;

/// Below this y, the luminance is negligible.
const LEAST_Y: f64 = 1e-6;

/// A chromaticity: the tristimulus values for Y = 1, or all 0 for black.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Chroma {
    xyz: [f64; 3],
}

impl Default for Chroma {
    fn default() -> Chroma {
        Chroma::WHITE
    }
}

impl Chroma {
    /// Illuminant E: equal power at all wavelengths.
    pub const WHITE: Chroma = Chroma { xyz: [1.0; 3] };

    /// From chromaticity coordinates; `None` outside x, y >= 0, x + y <= 1 by more than rounding.
    pub fn new(x: f64, y: f64) -> Option<Chroma> {
        let is_possible = x >= 0.0 && y >= 0.0 && x + y <= 1.0 + 1e-6;
        is_possible.then(|| Chroma::from_xyz([x, y, (1.0 - x - y).max(0.0)]))
    }

    fn from_xyz(xyz: [f64; 3]) -> Chroma {
        let [x, y, z] = xyz;
        let sum = x + y + z;
        let near = |v: f64| (v / sum - 1.0 / 3.0).abs() < NEAR_WHITE;
        // Negated so that non-finite sums are black.
        if !(y > LEAST_Y * sum && y.is_finite() && sum.is_finite()) {
            Chroma { xyz: [0.0; 3] }
        } else if near(x) && near(y) {
            Chroma::WHITE
        } else {
            Chroma {
                xyz: [x / y, 1.0, z / y],
            }
        }
    }

    /// The colour of a spectrum, given its power at a wavelength in nm; `None` if it is invisible.
    ///
    /// Both the power and the interpolated curves are evaluated at every nanometre, and scaled so
    /// that equal energy is exactly white.
    fn from_power(power: impl Fn(f64) -> f64) -> Option<Chroma> {
        let (mut seen, mut white) = ([0.0; 3], [0.0; 3]);
        for wavelength in VISIBLE {
            let p = power(f64::from(wavelength));
            for (k, curve) in curves_at(wavelength).into_iter().enumerate() {
                seen[k] += curve * p;
                white[k] += curve;
            }
        }
        let xyz = [0, 1, 2].map(|k| seen[k] / white[k]);
        let visible = xyz[1] > 0.0 && xyz.iter().sum::<f64>() > 0.0;
        visible.then(|| Chroma::from_xyz(xyz))
    }

    /// The colour of a spectrum, given by values evenly spaced from `first` to `last` nm with
    /// linear interpolation, and zero outside. `None` for fewer than two values, an empty range, or
    /// an invisible spectrum.
    pub fn spectrum(first: f64, last: f64, values: &[f64]) -> Option<Chroma> {
        if values.len() < 2 || first >= last {
            return None;
        }
        let scale = (values.len() - 1) as f64 / (last - first);
        Chroma::from_power(|wavelength| {
            let at = (wavelength - first) * scale;
            if at < 0.0 || at > (values.len() - 1) as f64 {
                return 0.0;
            }
            let k = (at as usize).min(values.len() - 2);
            let f = at - k as f64;
            (1.0 - f) * values[k] + f * values[k + 1]
        })
    }

    /// The colour of a black body at a temperature in kelvin, by Planck's law; `None` if it is
    /// invisible.
    pub fn black_body(kelvin: f64) -> Option<Chroma> {
        /// Second radiation constant, nm K (CODATA 2018).
        const C2: f64 = 1.438_776_877e7;
        let longest = f64::from(*VISIBLE.end());
        let factor = |wavelength: f64| (C2 / (wavelength * kelvin)).exp_m1();
        if kelvin <= 0.0 {
            return None;
        }
        if !factor(longest).is_finite() {
            // At temperatures this low, only the ratio to the red end is representable, and Wien's
            // law holds.
            let wien = |w: f64| (C2 / kelvin * (1.0 / longest - 1.0 / w)).exp() / w.powi(5);
            return Chroma::from_power(wien);
        }
        Chroma::from_power(|w| factor(longest) / (factor(w) * w.powi(5)))
    }

    /// A mixture of colours weighted by luminance; `None` if no luminance is left.
    ///
    /// Mixing tristimulus values is equivalent to mixing spectra with these luminances.
    pub fn mix(parts: impl IntoIterator<Item = (f64, Chroma)>) -> Option<Chroma> {
        let mut sum = [0.0; 3];
        for (weight, part) in parts {
            for (sum, value) in sum.iter_mut().zip(part.xyz) {
                *sum += weight * value;
            }
        }
        (sum[1] > 0.0).then(|| Chroma::from_xyz(sum))
    }

    /// The colour at a given luminance, in linear RGB.
    ///
    /// Out-of-gamut colours are desaturated towards grey of the same luminance, so that the
    /// luminance is always exact.
    pub fn rgb(self, luminance: f64) -> Rgb {
        if self == Chroma::WHITE {
            return Rgb::grey(luminance);
        }
        if self.xyz == [0.0; 3] {
            return Rgb::BLACK;
        }
        let linear = Rgb::from(RGB_FROM_XYZ.map(|row| {
            let terms = [0, 1, 2].map(|k| row[k] * self.xyz[k]);
            terms.iter().sum()
        }));
        // Chromatic adaptation changes Y slightly.
        let y = linear.luminance();
        if y <= 0.0 {
            return Rgb::grey(luminance);
        }
        let unit = linear.map(|c| c / y);
        let least = unit.r.min(unit.g).min(unit.b);
        let kept = if least < 0.0 {
            1.0 / (1.0 - least)
        } else {
            1.0
        };
        unit.map(|c| luminance * (1.0 + kept * (c - 1.0)).max(0.0))
    }
}

/// The linear RGB weights of a reflectance spectrum sampled at `wavelengths` in nm, with linear
/// interpolation. The illuminant has equal power at all wavelengths, so equal weights give grey for
/// a constant spectrum. `None` unless the wavelengths increase and some of them are visible.
pub(crate) fn rgb_weights(wavelengths: &[f32]) -> Option<Vec<[f64; 3]>> {
    let rises = wavelengths.windows(2).all(|pair| pair[0] < pair[1]);
    if wavelengths.len() < 2 || !rises {
        return None;
    }
    let mut seen = vec![[0.0; 3]; wavelengths.len()];
    let mut white = [0.0; 3];
    for wavelength in VISIBLE {
        let at = f64::from(wavelength);
        let after = wavelengths.partition_point(|w| f64::from(*w) <= at);
        let k = after.saturating_sub(1).min(wavelengths.len() - 2);
        let (a, b) = (f64::from(wavelengths[k]), f64::from(wavelengths[k + 1]));
        let t = (at - a) / (b - a);
        if !(0.0..=1.0).contains(&t) {
            continue;
        }
        for (c, curve) in curves_at(wavelength).into_iter().enumerate() {
            seen[k][c] += curve * (1.0 - t);
            seen[k + 1][c] += curve * t;
            white[c] += curve;
        }
    }
    let is_seen = white.iter().all(|sum| *sum > 0.0);
    is_seen.then(|| {
        let rgb = |xyz: &[f64; 3]| {
            RGB_FROM_XYZ.map(|row| [0, 1, 2].map(|c| row[c] * xyz[c] / white[c]).iter().sum())
        };
        seen.iter().map(rgb).collect()
    })
}

/// The colour-matching functions at a wavelength within [`VISIBLE`], nm, interpolated linearly.
fn curves_at(wavelength: u32) -> [f64; 3] {
    let from_start = wavelength - VISIBLE.start();
    let k = (from_start / 10).min(39) as usize;
    let f = f64::from(from_start) / 10.0 - k as f64;
    [0, 1, 2].map(|c| (1.0 - f) * CURVES[k][c] + f * CURVES[k + 1][c])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(chroma: Chroma, x: f64, y: f64, tolerance: f64) {
        let sum: f64 = chroma.xyz.iter().sum();
        let [fx, fy] = [chroma.xyz[0] / sum, chroma.xyz[1] / sum];
        let error = (fx - x).abs().max((fy - y).abs());
        assert!(error < tolerance, "{fx} {fy}, expected {x} {y}");
    }

    #[test]
    fn white_is_grey_to_the_last_bit() {
        assert_eq!(Chroma::new(1.0 / 3.0, 1.0 / 3.0), Some(Chroma::WHITE));
        assert_eq!(Chroma::new(0.333, 0.333).unwrap().rgb(0.4), Rgb::grey(0.4));
        assert_eq!(
            Chroma::spectrum(380.0, 780.0, &[3.0, 3.0]),
            Some(Chroma::WHITE)
        );
        // The matrix itself maps only this white to grey.
        for row in RGB_FROM_XYZ {
            assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn black_bodies() {
        // CIE 15: illuminant A is a Planckian radiator of about 2856 K.
        check(Chroma::black_body(2855.5).unwrap(), 0.4476, 0.4074, 4e-4);
        check(Chroma::black_body(6504.0).unwrap(), 0.3135, 0.3236, 4e-4);
        // At a temperature this low, the magnitude underflows; the hue is at the red end.
        let cold = Chroma::black_body(1.0).unwrap();
        check(cold, 0.735, 0.265, 2e-2);
        assert!(cold.rgb(1.0).is_finite());
        assert_eq!(Chroma::black_body(0.0), None);
        assert_eq!(Chroma::black_body(-5.0), None);
    }

    #[test]
    fn spectra() {
        // Monochromatic light lies on the spectral locus (CIE 15).
        let line = Chroma::spectrum(549.0, 551.0, &[0.0, 1.0, 0.0]).unwrap();
        check(line, 0.3016, 0.6923, 1e-3);
        assert_eq!(Chroma::spectrum(380.0, 780.0, &[1.0]), None);
        assert_eq!(Chroma::spectrum(780.0, 380.0, &[1.0, 1.0]), None);
        assert_eq!(Chroma::spectrum(800.0, 900.0, &[1.0, 1.0]), None);
        assert_eq!(Chroma::spectrum(380.0, 780.0, &[0.0, 0.0]), None);
        assert_eq!(Chroma::spectrum(380.0, 780.0, &[-1.0, -1.0]), None);
    }

    #[test]
    fn mixtures_weigh_luminance() {
        let (red, green) = (
            Chroma::new(0.6, 0.3).unwrap(),
            Chroma::new(0.3, 0.6).unwrap(),
        );
        // By the formula: x = Σ w x/y / Σ w/y, y = Σ w / Σ w/y.
        let mixed = Chroma::mix([(1.0, red), (3.0, green)]).unwrap();
        let weights = 1.0 / 0.3 + 3.0 / 0.6;
        check(mixed, (2.0 + 1.5) / weights, 4.0 / weights, 1e-12);
        assert_eq!(Chroma::mix([(0.0, red)]), None);
        assert_eq!(Chroma::mix([(1.0, red), (-1.0, green)]), None);
    }

    #[test]
    fn luminance_is_kept_also_outside_the_triangle_of_rgb() {
        let colors = [
            (0.4, 0.4),
            (0.75, 0.1),
            (0.0, 0.38),
            (0.1, 0.8),
            (0.6, 1e-5),
        ];
        for (x, y) in colors {
            let rgb = Chroma::new(x, y).unwrap().rgb(0.3);
            assert!((rgb.luminance() - 0.3).abs() < 1e-12, "{x} {y}: {rgb:?}");
            assert!(rgb.r >= 0.0 && rgb.g >= 0.0 && rgb.b >= 0.0, "{rgb:?}");
        }
        assert_eq!(Chroma::new(0.5, 0.0).unwrap().rgb(1.0), Rgb::BLACK);
        assert_eq!(Chroma::new(0.7, 0.4), None);
        assert_eq!(Chroma::new(-0.1, 0.4), None);
    }

    #[test]
    fn a_primary_of_another_white() {
        // BT.709 red under E: adapted to D65 it stays the most saturated red there is, nearly.
        let red = Chroma::new(0.64, 0.33).unwrap().rgb(0.2126);
        assert!(red.r > 0.9 && red.g < 0.05 && red.b < 0.05, "{red:?}");
    }
}
