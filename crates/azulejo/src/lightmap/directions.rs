//! Pictures of where the light of a lightmap comes from, for viewers with normal maps.

use super::Baked;
use azulejo_bake::{DIRECTIONAL, Lightmap};
use azulejo_scene::harmonics::{Y00, Y1};
use azulejo_scene::{Rgb, Up};
use glam::DVec3;

/// The form of [`direction_bytes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DirectionForm {
    /// Of each channel of the light, in a picture each for the x, y and z axis.
    Harmonics,
    /// Of the luminance, in one picture: the dominant direction, times how much it dominates.
    Dominant,
}

impl DirectionForm {
    /// Its pictures of each page.
    pub fn pictures(self) -> usize {
        match self {
            DirectionForm::Harmonics => 3,
            DirectionForm::Dominant => 1,
        }
    }
}

/// Errors of the coefficients of a lightmap: root mean squares over area and channels, of bands 0 and 1, relative to the
/// mean of band 0.
pub fn direction_errors(harmonics: &[Lightmap; DIRECTIONAL]) -> [f64; 2] {
    let mean = harmonics[0].mean().mean().max(f64::MIN_POSITIVE);
    let square = |lightmap: &Lightmap| {
        let [squares, area] = (lightmap.quarters().iter()).fold([0.0, 0.0], |[s, n], quarter| {
            [s + quarter.error * quarter.error, n + 1.0]
        });
        squares / area
    };
    let of_first = square(&harmonics[0]);
    let others: f64 = harmonics[1..].iter().map(square).sum();
    [of_first, others].map(|square| square.sqrt() / mean)
}

/// The pictures of a page, three linear bytes per pixel each, of G/φ in −1..=1 as 0..=255, in the axes of glTF: φ is
/// the scalar irradiance ∫ L dω of the light above the surface, G the vector irradiance ∫ L ω dω. Black texels have 0.
/// Empty if the lightmap has no directions.
pub fn direction_bytes(baked: &Baked, page: usize, form: DirectionForm, up: Up) -> Vec<Vec<u8>> {
    let Some(harmonics) = &baked.harmonics else {
        return Vec::new();
    };
    let count = harmonics[0].pages[page].irradiance.len();
    let mut pictures = vec![Vec::with_capacity(3 * count); form.pictures()];
    for texel in 0..count {
        let coefficient = |k: usize| {
            let [r, g, b] = harmonics[k].pages[page].irradiance[texel].map(f64::from);
            Rgb::from([r, g, b])
        };
        let scalar = coefficient(0) / Y00;
        // Band 1 is that of y, z and x.
        let [y, z, x] = [1, 2, 3].map(|k| coefficient(k) / Y1);
        let of_channels = match form {
            DirectionForm::Harmonics => {
                [0, 1, 2].map(|c| relative(DVec3::new(x[c], y[c], z[c]), scalar[c], up).to_array())
            }
            DirectionForm::Dominant => {
                let vector = DVec3::from([x, y, z].map(Rgb::luminance));
                [relative(vector, scalar.luminance(), up).to_array(); 3]
            }
        };
        match form {
            DirectionForm::Harmonics => {
                for (axis, picture) in pictures.iter_mut().enumerate() {
                    picture.extend(of_channels.map(|vector| byte(vector[axis])));
                }
            }
            DirectionForm::Dominant => pictures[0].extend(of_channels[0].map(byte)),
        }
    }
    pictures
}

/// G/φ in the axes of glTF, no longer than 1.
fn relative(vector: DVec3, scalar: f64, up: Up) -> DVec3 {
    if scalar <= 0.0 {
        return DVec3::ZERO;
    }
    let DVec3 { x, y, z } = (vector / scalar).clamp_length_max(1.0);
    match up {
        Up::Y => DVec3::new(x, y, z),
        Up::Z => DVec3::new(x, z, -y),
    }
}

fn byte(value: f64) -> u8 {
    (127.5 * (value + 1.0)).round() as u8
}
