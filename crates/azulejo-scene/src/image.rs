//! Images: linear RGB, `f32`.

/// An image of linear RGB values, rows from the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Image {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width × height` pixels, row by row from the upper left corner.
    pub pixels: Vec<[f32; 3]>,
}

impl Image {
    /// A black image.
    pub fn new(width: u32, height: u32) -> Image {
        Image {
            width,
            height,
            pixels: vec![[0.0; 3]; width as usize * height as usize],
        }
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
        if self.width == 0 || self.height == 0 || !u.is_finite() || !v.is_finite() {
            return [0.0; 3];
        }
        let (w, h) = (i64::from(self.width), i64::from(self.height));
        let (x, y) = (
            u.rem_euclid(1.0) * w as f64 - 0.5,
            (1.0 - v.rem_euclid(1.0)) * h as f64 - 0.5,
        );
        let (fx, fy) = ((x - x.floor()) as f32, (y - y.floor()) as f32);
        let at = |dx: i64, dy: i64| {
            let column = (x.floor() as i64 + dx).rem_euclid(w) as u32;
            let row = (y.floor() as i64 + dy).rem_euclid(h) as u32;
            self.pixel(column, row)
        };
        let corners = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
        let weights = [
            (1.0 - fx) * (1.0 - fy),
            fx * (1.0 - fy),
            (1.0 - fx) * fy,
            fx * fy,
        ];
        let mut out = [0.0; 3];
        for (c, w) in corners.iter().zip(weights) {
            for k in 0..3 {
                out[k] += w * c[k];
            }
        }
        out
    }
}
