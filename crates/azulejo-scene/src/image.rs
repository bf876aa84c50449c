//! Images: linear RGB, `f32`, with an alpha channel where a file has one; and textures.

use crate::Rgb;
use glam::DVec2;

/// What a texture shows where coordinates leave 0..1, along one axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum WrapMode {
    /// The picture again.
    #[default]
    Repeat,
    /// The picture's edge.
    Clamp,
    /// The picture again, every second time mirrored.
    Mirror,
}

impl WrapMode {
    /// The column or row of `count` that is shown in place of column or row `k`.
    fn index(self, k: i64, count: i64) -> u32 {
        // Most places need no division.
        let k = match self {
            _ if (0..count).contains(&k) => k,
            WrapMode::Repeat => k.rem_euclid(count),
            WrapMode::Clamp => k.clamp(0, count - 1),
            WrapMode::Mirror => {
                let k = k.rem_euclid(2 * count);
                k.min(2 * count - 1 - k)
            }
        };
        k as u32
    }

    /// The coordinate in 0..1, or up to 2 where the picture is mirrored, in which all is shown.
    fn place(self, x: f64) -> f64 {
        match self {
            // Most places need no division.
            _ if (0.0..1.0).contains(&x) => x,
            WrapMode::Repeat => x.rem_euclid(1.0),
            WrapMode::Clamp => x.clamp(0.0, 1.0),
            WrapMode::Mirror => x.rem_euclid(2.0),
        }
    }
}

/// Index of a texture in [`Scene::textures`](crate::Scene::textures).
pub type TextureId = u32;

/// An image of linear RGB values, rows from the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Image {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width × height` pixels, row by row from the upper left corner.
    pub pixels: Vec<[f32; 3]>,
    /// Opacity of each pixel, 0..=1, if any pixel is not opaque. Colours are not multiplied by it.
    pub alpha: Option<Vec<f32>>,
}

impl Image {
    /// An opaque image of these pixels.
    pub fn opaque(width: u32, height: u32, pixels: Vec<[f32; 3]>) -> Image {
        Image {
            width,
            height,
            pixels,
            alpha: None,
        }
    }

    /// The image with these opacities, which are dropped if all are 1.
    pub fn with_alpha(self, alpha: Vec<f32>) -> Image {
        let alpha = Some(alpha).filter(|a| a.iter().any(|&v| v < 1.0));
        Image { alpha, ..self }
    }

    /// A black image.
    pub fn new(width: u32, height: u32) -> Image {
        let pixels = vec![[0.0; 3]; width as usize * height as usize];
        Image::opaque(width, height, pixels)
    }

    /// The pixel in column `x`, row `y`.
    ///
    /// # Panics
    /// If the pixel is outside the image.
    pub fn pixel(&self, x: u32, y: u32) -> [f32; 3] {
        assert!(
            x < self.width && y < self.height,
            "pixel ({x}, {y}) of {}×{}",
            self.width,
            self.height
        );
        self.pixels[y as usize * self.width as usize + x as usize]
    }

    /// Bilinear lookup that repeats the image; `(0, 0)` is the lower left corner of the
    /// lower left pixel, as texture coordinates have it. Black for an image without pixels.
    pub fn sample(&self, u: f64, v: f64) -> [f32; 3] {
        self.sample_wrapped(DVec2::new(u, v), [WrapMode::Repeat; 2])
    }

    /// As [`sample`](Image::sample), with other ways to go on beyond the picture, in u and in v.
    pub fn sample_wrapped(&self, uv: DVec2, wrap: [WrapMode; 2]) -> [f32; 3] {
        let mut out = [0.0; 3];
        let corners = Image::bilinear([self.width, self.height], uv, wrap);
        for ([x, y], weight) in corners.into_iter().flatten() {
            let color = self.pixel(x, y);
            for k in 0..3 {
                out[k] += weight * color[k];
            }
        }
        out
    }

    /// Whether every pixel that [`sample_wrapped`](Image::sample_wrapped) reads between two corners is
    /// black; `None` if it reads more than `most`, or the corners are not finite.
    pub(crate) fn is_black_between(
        &self,
        [low, high]: [DVec2; 2],
        wrap: [WrapMode; 2],
        most: u64,
    ) -> Option<bool> {
        let size = [i64::from(self.width), i64::from(self.height)];
        if size.contains(&0) {
            return Some(true);
        }
        let range = |from: f64, to: f64, count: i64| {
            let pixel = |x: f64| (x * count as f64 - 0.5).floor();
            let (first, last) = (pixel(from), pixel(to) + 1.0);
            let is_short = first.abs() < 1e15 && last - first < most as f64;
            is_short.then_some(first as i64..=last as i64)
        };
        let columns = range(low.x, high.x, size[0])?;
        let rows = range(1.0 - high.y, 1.0 - low.y, size[1])?;
        let count = |r: &std::ops::RangeInclusive<i64>| (r.end() - r.start() + 1) as u64;
        if count(&columns) * count(&rows) > most {
            return None;
        }
        Some(rows.clone().all(|y| {
            let y = wrap[1].index(y, size[1]);
            (columns.clone()).all(|x| self.pixel(wrap[0].index(x, size[0]), y) == [0.0; 3])
        }))
    }

    /// The four pixels around a point of an image of that size, column and row, and their weights;
    /// `None` for an image without pixels, and coordinates that are not finite.
    pub(crate) fn bilinear(
        size: [u32; 2],
        uv: DVec2,
        wrap: [WrapMode; 2],
    ) -> Option<[([u32; 2], f32); 4]> {
        if size.contains(&0) || !uv.is_finite() {
            return None;
        }
        let (w, h) = (i64::from(size[0]), i64::from(size[1]));
        let (x, y) = (
            wrap[0].place(uv.x) * w as f64 - 0.5,
            (1.0 - wrap[1].place(uv.y)) * h as f64 - 0.5,
        );
        let (left, top) = (x.floor(), y.floor());
        let (fx, fy) = ((x - left) as f32, (y - top) as f32);
        let at = |dx: i64, dy: i64| {
            let column = wrap[0].index(left as i64 + dx, w);
            [column, wrap[1].index(top as i64 + dy, h)]
        };
        Some([
            (at(0, 0), (1.0 - fx) * (1.0 - fy)),
            (at(1, 0), fx * (1.0 - fy)),
            (at(0, 1), (1.0 - fx) * fy),
            (at(1, 1), fx * fy),
        ])
    }
}

/// An image that materials refer to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Texture {
    /// File name as the model gives it, relative to the model.
    pub path: String,
    /// Its pixels, linear, if they could be loaded.
    pub image: Option<Image>,
    /// What it shows beyond its edges: in u, and in v.
    pub wrap: [WrapMode; 2],
}

impl Texture {
    /// Its colour at texture coordinates; `None` if its pixels could not be loaded.
    pub fn sample(&self, uv: DVec2) -> Option<[f32; 3]> {
        Some(self.image.as_ref()?.sample_wrapped(uv, self.wrap))
    }

    /// Whether all that it shows between two corners of texture coordinates is black; `None` if that are
    /// more than `most` texels. One that could not be loaded is black.
    pub fn is_black_between(&self, low: DVec2, high: DVec2, most: u64) -> Option<bool> {
        let Some(image) = &self.image else {
            return Some(true);
        };
        image.is_black_between([low, high], self.wrap, most)
    }

    /// The mean colour of its pixels; black if they could not be loaded.
    pub fn mean(&self) -> Rgb {
        let pixels = self.image.iter().flat_map(|image| &image.pixels);
        let (sum, count) = pixels.fold((Rgb::BLACK, 0u32), |(sum, count), pixel| {
            (sum + Rgb::from(pixel.map(f64::from)), count + 1)
        });
        sum / f64::from(count.max(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn textures_go_on_as_they_are_told() {
        let image = Image::opaque(2, 2, vec![[0.0; 3], [1.0; 3], [2.0; 3], [3.0; 3]]);
        let at =
            |u: f64, v: f64, wrap: WrapMode| image.sample_wrapped(DVec2::new(u, v), [wrap; 2])[0];
        use WrapMode::{Clamp, Mirror, Repeat};
        for wrap in [Clamp, Mirror, Repeat] {
            assert_eq!([at(0.25, 0.75, wrap), at(0.75, 0.25, wrap)], [0.0, 3.0]);
        }
        // Beyond the right edge, in the upper row: the left, the right and the right column.
        assert_eq!(at(1.25, 0.75, Repeat), 0.0);
        assert_eq!(at(1.25, 0.75, Mirror), 1.0);
        assert_eq!(at(1.75, 0.75, Mirror), 0.0);
        assert_eq!(at(7.0, 0.75, Clamp), 1.0);
        assert_eq!(at(-7.0, 0.75, Clamp), 0.0);
        // Above and below.
        assert_eq!([at(0.25, 1.25, Repeat), at(0.25, 1.25, Mirror)], [2.0, 0.0]);
        assert_eq!([at(0.25, 9.0, Clamp), at(0.25, -9.0, Clamp)], [0.0, 2.0]);
        assert_eq!(
            [at(-0.25, 0.75, Repeat), at(-0.25, 0.75, Mirror)],
            [1.0, 0.0]
        );
        // Edges: repeated, the opposite one shows through; otherwise not.
        assert_eq!(at(0.0, 0.75, Repeat), 0.5);
        assert_eq!([at(0.0, 0.75, Clamp), at(0.0, 0.75, Mirror)], [0.0; 2]);
    }
}
