//! Images: linear RGB, `f32`, with an alpha channel where a file has one.

use glam::DVec2;

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
        let mut out = [0.0; 3];
        let corners = Image::bilinear([self.width, self.height], DVec2::new(u, v));
        for ([x, y], weight) in corners.into_iter().flatten() {
            let color = self.pixel(x, y);
            for k in 0..3 {
                out[k] += weight * color[k];
            }
        }
        out
    }

    /// The four pixels around a point of an image of that size, column and row, and their weights;
    /// `None` for an image without pixels, and coordinates that are not finite.
    pub(crate) fn bilinear(size: [u32; 2], uv: DVec2) -> Option<[([u32; 2], f32); 4]> {
        if size.contains(&0) || !uv.is_finite() {
            return None;
        }
        let (w, h) = (i64::from(size[0]), i64::from(size[1]));
        let (x, y) = (
            uv.x.rem_euclid(1.0) * w as f64 - 0.5,
            (1.0 - uv.y.rem_euclid(1.0)) * h as f64 - 0.5,
        );
        let (left, top) = (x.floor(), y.floor());
        let (fx, fy) = ((x - left) as f32, (y - top) as f32);
        let at = |dx: i64, dy: i64| {
            let column = (left as i64 + dx).rem_euclid(w) as u32;
            [column, (top as i64 + dy).rem_euclid(h) as u32]
        };
        Some([
            (at(0, 0), (1.0 - fx) * (1.0 - fy)),
            (at(1, 0), fx * (1.0 - fy)),
            (at(0, 1), (1.0 - fx) * fy),
            (at(1, 1), fx * fy),
        ])
    }
}
