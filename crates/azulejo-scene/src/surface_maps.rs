//! Pictures of properties other than colour: metalness and roughness, relief, and irradiance.

use crate::{Image, Rgb, Texture, TextureId, WrapMode};
use glam::{DVec2, DVec3};

/// A channel of a picture whose stored values are numbers 0..=1, not light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct NumberPicture {
    /// The picture.
    pub texture: TextureId,
    /// Its part that counts.
    pub channel: PictureChannel,
}

/// A channel of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PictureChannel {
    /// The first.
    Red,
    /// The second.
    Green,
    /// The third.
    Blue,
}

impl PictureChannel {
    /// Its value among those of a pixel.
    pub fn of(self, values: DVec3) -> f64 {
        match self {
            PictureChannel::Red => values.x,
            PictureChannel::Green => values.y,
            PictureChannel::Blue => values.z,
        }
    }
}

/// Metalness and roughness of a surface by the model `gltf_mr`, as pictures vary them.
///
/// The material's own model and reflectances are those of the means, for the first pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FinishMaps {
    /// Colour of the base or of the metal, 0..=1, which vertex colours and textures multiply.
    pub base: Rgb,
    /// Metalness, 0..=1: a factor of the picture.
    pub metallic: f64,
    /// Roughness, 0..=1: a factor of the picture.
    pub roughness: f64,
    /// What multiplies the metalness.
    pub metallic_picture: Option<NumberPicture>,
    /// What multiplies the roughness.
    pub roughness_picture: Option<NumberPicture>,
}

impl FinishMaps {
    /// Its pictures.
    pub fn pictures(&self) -> impl Iterator<Item = TextureId> {
        let both = [self.metallic_picture, self.roughness_picture];
        both.into_iter().flatten().map(|p| p.texture)
    }

    /// Numbers its pictures anew.
    pub(crate) fn renumber(&mut self, number: &impl Fn(TextureId) -> TextureId) {
        let both = [&mut self.metallic_picture, &mut self.roughness_picture];
        both.into_iter()
            .flatten()
            .for_each(|p| p.texture = number(p.texture));
    }
}

/// A picture of the small relief of a surface, which tilts its normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relief {
    /// The picture.
    pub texture: TextureId,
    /// What it shows.
    pub kind: ReliefKind,
}

/// What a picture shows of a relief.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ReliefKind {
    /// Normals n as (n + 1)/2: x along the first texture coordinate, y along the second, z outward.
    Normals {
        /// Factor of x and y.
        scale: f64,
    },
    /// Heights, bright is high.
    Heights {
        /// Slope where neighbouring pixels are black and white.
        slope: f64,
    },
}

impl Relief {
    /// Unit normal in the frame of the texture coordinates where the picture is `map`; z > 0.
    pub fn normal(&self, map: &NumberMap, uv: DVec2) -> DVec3 {
        let tilted = match self.kind {
            ReliefKind::Normals { scale } => {
                let n = 2.0 * map.sample(uv) - DVec3::ONE;
                DVec3::new(scale * n.x, scale * n.y, n.z.max(0.0))
            }
            ReliefKind::Heights { slope } => {
                let [w, h] = map.size().map(|n| 1.0 / f64::from(n));
                let height = |du: f64, dv: f64| {
                    let values = map.sample(uv + 0.5 * DVec2::new(du, dv));
                    values.dot(DVec3::new(0.2126, 0.7152, 0.0722))
                };
                let along = height(w, 0.0) - height(-w, 0.0);
                let across = height(0.0, h) - height(0.0, -h);
                DVec3::new(-slope * along, -slope * across, 1.0)
            }
        };
        tilted
            .try_normalize()
            .filter(|n| n.z > 0.0)
            .unwrap_or(DVec3::Z)
    }
}

/// The numbers of a picture, pixel by pixel, as they are stored.
#[derive(Clone, Debug, PartialEq)]
pub struct NumberMap {
    width: u32,
    height: u32,
    values: Vec<[f32; 3]>,
    wrap: [WrapMode; 2],
}

impl NumberMap {
    /// Those of a texture; `None` if its pixels could not be loaded.
    pub fn new(texture: &Texture) -> Option<NumberMap> {
        let image = texture.image.as_ref()?;
        let is_whole = image.pixels.len() == image.width as usize * image.height as usize;
        (is_whole && !image.pixels.is_empty()).then(|| NumberMap {
            width: image.width,
            height: image.height,
            values: image.pixels.iter().map(|p| p.map(stored_value)).collect(),
            wrap: texture.wrap,
        })
    }

    /// Columns and rows.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// Bilinear lookup, as [`Image::sample`].
    pub fn sample(&self, uv: DVec2) -> DVec3 {
        let value = |[x, y]: [u32; 2]| {
            let [r, g, b] = self.values[y as usize * self.width as usize + x as usize];
            DVec3::new(r.into(), g.into(), b.into())
        };
        let corners = Image::bilinear(self.size(), uv, self.wrap);
        let corners = corners.into_iter().flatten();
        corners
            .map(|(at, weight)| f64::from(weight) * value(at))
            .sum()
    }

    /// The mean of its numbers.
    pub fn mean(&self) -> DVec3 {
        let values = self.values.iter();
        let values = values.map(|&[r, g, b]| DVec3::new(r.into(), g.into(), b.into()));
        values.sum::<DVec3>() / self.values.len() as f64
    }
}

/// The sRGB value of linear light, 0..=1: readers take all pictures for colours.
pub(crate) fn stored_value(light: f32) -> f32 {
    let stored = if light <= 0.003_130_8 {
        12.92 * light
    } else {
        1.055 * light.powf(1.0 / 2.4) - 0.055
    };
    stored.clamp(0.0, 1.0)
}

/// The irradiance of the surfaces of one material, as a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IrradiancePicture {
    /// The picture.
    pub texture: TextureId,
    /// Irradiance of a texel of 1, W/m², >= 0.
    pub scale: f64,
}

impl IrradiancePicture {
    /// Irradiance at coordinates of the lightmap in its picture: bilinear, and beyond its edges as at them.
    pub fn at(&self, image: &Image, uv: DVec2) -> Rgb {
        let texel = image.sample_wrapped(uv, [WrapMode::Clamp; 2]);
        // A filter of floats may end just below zero.
        Rgb::from(texel.map(|t| f64::from(t).max(0.0))) * self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn linear(stored: f32) -> f32 {
        if stored <= 0.040_45 {
            stored / 12.92
        } else {
            ((stored + 0.055) / 1.055).powf(2.4)
        }
    }

    fn map(width: u32, pixels: Vec<[f32; 3]>) -> NumberMap {
        let height = pixels.len() as u32 / width;
        let image = Image::opaque(width, height, pixels);
        let image = Some(image);
        NumberMap::new(&Texture {
            image,
            ..Texture::default()
        })
        .unwrap()
    }

    #[test]
    fn numbers_are_those_that_were_stored() {
        let stored = [0.0, 0.02, 0.5, 0.8, 1.0];
        let map = map(5, stored.map(|s| [linear(s); 3]).to_vec());
        for (k, s) in stored.into_iter().enumerate() {
            let value = map.sample(DVec2::new((k as f64 + 0.5) / 5.0, 0.5));
            assert!((value.y - f64::from(s)).abs() < 1e-5, "{value} {s}");
        }
        assert!((map.mean().x - 2.32 / 5.0).abs() < 1e-5);
    }

    #[test]
    fn reliefs_tilt_the_normal() {
        let n = DVec3::new(0.6, 0.0, 0.8);
        let pixel = (0.5 * (n + DVec3::ONE))
            .to_array()
            .map(|v| linear(v as f32));
        let tilted = map(1, vec![pixel]);
        let relief = |kind| Relief { texture: 0, kind };
        let full = relief(ReliefKind::Normals { scale: 1.0 });
        assert!((full.normal(&tilted, DVec2::ZERO) - n).length() < 1e-5);
        let flat = relief(ReliefKind::Normals { scale: 0.0 });
        assert!((flat.normal(&tilted, DVec2::ZERO) - DVec3::Z).length() < 1e-9);
        // A step from black to white along u: slope 1 there leans back at 45°.
        let step = map(2, vec![[0.0; 3], [1.0; 3]]);
        let bump = relief(ReliefKind::Heights { slope: 1.0 });
        let leaning = bump.normal(&step, DVec2::splat(0.5));
        let expected = DVec3::new(-1.0, 0.0, 1.0).normalize();
        assert!((leaning - expected).length() < 1e-5, "{leaning}");
    }
}
