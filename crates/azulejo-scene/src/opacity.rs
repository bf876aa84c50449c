//! Opacity: which share of the light that meets a surface the surface takes, and which passes.

use crate::surface_maps::stored_value;
use crate::{Image, TextureId, WrapMode};
use glam::DVec2;

/// How much of a surface is there: leaves cut out of a card, fences, gauze.
///
/// The share `opacity` of the light that meets a point is reflected or absorbed as the material's other
/// properties say; the rest passes straight on, unchanged. At a point the opacity is `constant`, times
/// what the picture says there; a mask rounds it to 0 or 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opacity {
    /// Opacity of the whole surface, 0..=1.
    pub constant: f64,
    /// A picture that multiplies it where the mesh has texture coordinates. One that could not be
    /// loaded is opaque.
    pub picture: Option<OpacityPicture>,
    /// What becomes of values between 0 and 1.
    pub mode: OpacityMode,
}

/// A picture of which a channel is an opacity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OpacityPicture {
    /// The picture.
    pub texture: TextureId,
    /// Its part that counts.
    pub channel: OpacityChannel,
}

/// The part of a picture that is an opacity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum OpacityChannel {
    /// The alpha channel; 1 where there is none.
    Alpha,
    /// Its sRGB value as stored, between 0 (black) and 1 (white); of colours, their luminance.
    Luminance,
}

/// What becomes of opacities between 0 and 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OpacityMode {
    /// The surface is there where the opacity is at least `cutoff`, which is ≥ 0.
    Mask {
        /// The least opacity that counts as 1.
        cutoff: f64,
    },
    /// They are shares.
    Blend,
}

impl Opacity {
    /// The same opacity everywhere.
    pub fn constant(opacity: f64) -> Opacity {
        Opacity {
            constant: opacity,
            picture: None,
            mode: OpacityMode::Blend,
        }
    }

    /// The opacity where the picture says `value`: 0..=1 if `value` is.
    pub fn at(&self, value: f64) -> f64 {
        let opacity = self.constant * value;
        match self.mode {
            OpacityMode::Mask { cutoff } if opacity >= cutoff => 1.0,
            OpacityMode::Mask { .. } => 0.0,
            OpacityMode::Blend => opacity,
        }
    }

    /// Whether nothing passes anywhere.
    pub fn is_opaque(&self) -> bool {
        self.picture.is_none() && self.at(1.0) >= 1.0
    }
}

/// The opacities of a picture, pixel by pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct OpacityMap {
    width: u32,
    height: u32,
    values: Vec<f32>,
    wrap: [WrapMode; 2],
}

impl OpacityMap {
    /// Those of one part of an image, which goes on beyond its edges as `wrap` says; `None` for an image without pixels, or opaque everywhere.
    pub fn new(image: &Image, channel: OpacityChannel, wrap: [WrapMode; 2]) -> Option<OpacityMap> {
        let values: Vec<f32> = match channel {
            OpacityChannel::Alpha => image.alpha.clone()?,
            OpacityChannel::Luminance => image.pixels.iter().map(stored_luminance).collect(),
        };
        let (width, height) = (image.width, image.height);
        let is_whole = values.len() == width as usize * height as usize;
        (is_whole && values.iter().any(|&v| v < 1.0)).then_some(OpacityMap {
            width,
            height,
            wrap,
            values,
        })
    }

    /// Columns and rows.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// Bilinear lookup, as [`Image::sample`].
    pub fn sample(&self, uv: DVec2) -> f64 {
        let value = |[x, y]: [u32; 2]| {
            f64::from(self.values[y as usize * self.width as usize + x as usize])
        };
        let corners = Image::bilinear(self.size(), uv, self.wrap);
        let corners = corners.into_iter().flatten();
        corners.fold(0.0, |sum, (at, weight)| sum + f64::from(weight) * value(at))
    }
}

/// The sRGB value of the luminance, 0..=1: opacities are stored as numbers, not as light.
fn stored_luminance(&[r, g, b]: &[f32; 3]) -> f32 {
    let light = if r == g && g == b {
        r
    } else {
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    stored_value(light)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Material, Rgb};

    #[test]
    fn masks_round_and_blends_do_not() {
        let mask = Opacity {
            mode: OpacityMode::Mask { cutoff: 0.5 },
            ..Opacity::constant(0.8)
        };
        assert_eq!((mask.at(0.6), mask.at(0.7)), (0.0, 1.0));
        assert_eq!(Opacity::constant(0.5).at(0.5), 0.25);
        assert!(mask.is_opaque() && !Opacity::constant(0.8).is_opaque());
    }

    #[test]
    fn pictures_of_materials_are_renumbered() {
        let mut leaf = Material {
            textures: vec![0, 2],
            opacity: Some(Opacity {
                picture: Some(OpacityPicture {
                    texture: 1,
                    channel: OpacityChannel::Alpha,
                }),
                ..Opacity::constant(1.0)
            }),
            ..Material::default()
        };
        leaf.renumber_pictures(3);
        assert_eq!(leaf.pictures().collect::<Vec<_>>(), [3, 5, 4]);
        leaf.emission = Rgb::WHITE;
        assert!(leaf.see_through().is_none());
        leaf.drop_pictures();
        assert_eq!(leaf.pictures().next(), None);
    }

    #[test]
    fn pictures_hold_opacities_as_they_store_them() {
        let linear = ((188.0f32 / 255.0 + 0.055) / 1.055).powf(2.4);
        let image = Image::opaque(2, 1, vec![[linear; 3], [1.0; 3]]);
        assert_eq!(
            OpacityMap::new(&image, OpacityChannel::Alpha, [WrapMode::Repeat; 2]),
            None
        );
        let map =
            OpacityMap::new(&image, OpacityChannel::Luminance, [WrapMode::Repeat; 2]).unwrap();
        assert!((map.sample(DVec2::new(0.25, 0.5)) - 188.0 / 255.0).abs() < 1e-6);
        let image = image.with_alpha(vec![0.25, 1.0]);
        let map = OpacityMap::new(&image, OpacityChannel::Alpha, [WrapMode::Repeat; 2]).unwrap();
        assert_eq!(map.sample(DVec2::new(0.25, 0.5)), 0.25);
        assert_eq!(map.sample(DVec2::new(0.5, 0.5)), 0.625);
    }
}
