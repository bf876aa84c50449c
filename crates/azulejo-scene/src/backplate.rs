//! Pictures behind a scene that are fixed to the image, and not to the world.

use crate::{Image, Rgb, TextureId};

/// A picture that fills the image behind a scene, whichever way the camera looks: a photograph into
/// which a model is composed. Photographers and compositors call it a backplate.
///
/// It is infinitely far away and as large as what the camera sees, so mirrors and glass show it where
/// they bend a line of sight back into the image. It lights nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Backplate {
    /// The picture.
    pub texture: TextureId,
    /// How it fills the image.
    pub fit: BackplateFit,
    /// Radiance where the picture is white, W/(sr·m²), at least 0.
    pub radiance: f64,
}

/// How a picture fills the image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum BackplateFit {
    /// Stretched to the size of the image.
    #[default]
    Scaled,
    /// In the middle, one of its pixels on one of the image; black around it.
    Centered,
    /// Repeated from the upper left corner, one of its pixels on one of the image.
    Tiled,
}

impl BackplateFit {
    /// All of them.
    pub const ALL: [BackplateFit; 3] = [
        BackplateFit::Scaled,
        BackplateFit::Centered,
        BackplateFit::Tiled,
    ];

    /// Factors and offsets from pixels of an image of size `image`, counted from its upper left
    /// corner, to shares of a picture of size `picture`: 0..1 from its upper left corner.
    pub fn placement(self, picture: [f64; 2], image: [f64; 2]) -> ([f64; 2], [f64; 2]) {
        let each = |k: usize| match self {
            BackplateFit::Scaled => (1.0 / image[k], 0.0),
            BackplateFit::Tiled => (1.0 / picture[k], 0.0),
            // Whole pixels keep the picture sharp.
            BackplateFit::Centered => {
                let border = (0.5 * (image[k] - picture[k])).floor();
                (1.0 / picture[k], -border / picture[k])
            }
        };
        let (x, y) = (each(0), each(1));
        ([x.0, y.0], [x.1, y.1])
    }
}

impl Backplate {
    /// The radiance at a point of an image of `size` pixels; `x` and `y` are 0..1 from its upper left
    /// corner. Black where there is no picture.
    pub fn seen(&self, (x, y): (f64, f64), size: [f64; 2], picture: Option<&Image>) -> Rgb {
        let Some(picture) = picture.filter(|p| p.width > 0 && p.height > 0) else {
            return Rgb::BLACK;
        };
        let own = [f64::from(picture.width), f64::from(picture.height)];
        let (factor, offset) = self.fit.placement(own, size);
        let place = [
            x * size[0] * factor[0] + offset[0],
            y * size[1] * factor[1] + offset[1],
        ];
        let place = match self.fit {
            BackplateFit::Tiled => place,
            // Opposite edges of a picture that is shown once must not blend.
            _ if place.iter().all(|p| (0.0..=1.0).contains(p)) => {
                let within = |k: usize| place[k].clamp(0.5 / own[k], 1.0 - 0.5 / own[k]);
                [within(0), within(1)]
            }
            _ => return Rgb::BLACK,
        };
        Rgb::from(picture.sample(place[0], 1.0 - place[1]).map(f64::from)) * self.radiance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Red and green above blue and white.
    fn picture() -> Image {
        let pixels = vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0; 3]];
        Image::opaque(2, 2, pixels)
    }

    fn seen(fit: BackplateFit, x: f64, y: f64, size: [f64; 2]) -> [f64; 3] {
        let plate = Backplate {
            texture: 0,
            fit,
            radiance: 2.0,
        };
        let Rgb { r, g, b } = plate.seen((x, y), size, Some(&picture()));
        [r, g, b].map(|c| (c * 1e6).round() / 1e6)
    }

    #[test]
    fn corners_of_a_stretched_picture_are_its_corners() {
        let at = |x, y| seen(BackplateFit::Scaled, x, y, [640.0, 480.0]);
        assert_eq!(at(0.0, 0.0), [2.0, 0.0, 0.0]);
        assert_eq!(at(1.0, 0.0), [0.0, 2.0, 0.0]);
        assert_eq!(at(0.0, 1.0), [0.0, 0.0, 2.0]);
        assert_eq!(at(0.5, 0.5), [1.0; 3]);
    }

    #[test]
    fn a_centred_picture_has_black_around_it() {
        let at = |x, y| seen(BackplateFit::Centered, x / 6.0, y / 4.0, [6.0, 4.0]);
        assert_eq!(at(2.5, 1.5), [2.0, 0.0, 0.0]);
        assert_eq!(at(3.5, 2.5), [2.0; 3]);
        assert_eq!(at(1.9, 1.5), [0.0; 3]);
        assert_eq!(at(3.5, 3.1), [0.0; 3]);
    }

    #[test]
    fn a_tiled_picture_begins_above_on_the_left() {
        let at = |x, y| seen(BackplateFit::Tiled, x / 6.0, y / 4.0, [6.0, 4.0]);
        for (x, y) in [(0.5, 0.5), (4.5, 2.5)] {
            assert_eq!(at(x, y), [2.0, 0.0, 0.0]);
        }
        assert_eq!(at(5.5, 0.5), [0.0, 2.0, 0.0]);
    }

    #[test]
    fn no_picture_is_black() {
        let plate = Backplate {
            texture: 0,
            fit: BackplateFit::Scaled,
            radiance: 1.0,
        };
        let empty = Image::new(0, 3);
        for none in [None, Some(&empty)] {
            assert_eq!(plate.seen((0.5, 0.5), [2.0, 2.0], none), Rgb::BLACK);
        }
    }
}
