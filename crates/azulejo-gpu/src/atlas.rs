//! The layout of hemicubes in textures.

use azulejo_trace::item_buffer::DrawError;

/// Faces of a hemicube: the top, and those towards +x, −x, +y, −y.
pub const FACES: usize = 5;

/// A grid of tiles, one hemicube each: `n` columns, and rows in the order of
/// [`Hemicube`](azulejo_trace::item_buffer::Hemicube)'s pixels, so that a tile read row by row is a
/// hemicube.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Atlas {
    /// Pixels along the side of the top face.
    pub resolution: u32,
    /// Tiles in a row.
    pub columns: u32,
    /// Number of tiles.
    pub tiles: u32,
}

/// A rectangle of texels: left, top, width, height.
pub type Rectangle = [u32; 4];

impl Atlas {
    /// As many tiles as `pixels` and the limits allow; at least one.
    ///
    /// # Errors
    /// [`DrawError::TooLarge`]: not even one.
    pub fn new(resolution: u32, pixels: u64, limits: &wgpu::Limits) -> Result<Atlas, DrawError> {
        let n = resolution;
        let edge = limits.max_texture_dimension_2d;
        if 3 * n > edge {
            return Err(DrawError::TooLarge(format!(
                "a hemicube of {n} pixels is an image of {n} × {} pixels, but the card's \
                 limit is {edge}; use at most {} pixels",
                3 * n,
                edge / 3 / 2 * 2
            )));
        }
        let mut atlas = Atlas {
            resolution,
            columns: 1,
            tiles: 1,
        };
        let most_bytes = limits.max_buffer_size;
        if atlas.tile_bytes() > most_bytes {
            return Err(DrawError::TooLarge(format!(
                "a hemicube of {n} pixels takes {} bytes, but the card's buffers are limited \
                 to {most_bytes}; use fewer pixels",
                atlas.tile_bytes()
            )));
        }
        let tile_count = (pixels / u64::from(3 * n * n)).min(most_bytes / atlas.tile_bytes());
        let tile_count = tile_count.clamp(1, 1 << 16) as u32;
        // Nearly square, because textures are limited in either direction.
        let square = f64::from(3 * tile_count).sqrt().ceil() as u32;
        atlas.columns = square.min(edge / n).min(tile_count);
        let rows = tile_count.div_ceil(atlas.columns).min(edge / (3 * n));
        atlas.tiles = tile_count.min(atlas.columns * rows);
        Ok(atlas)
    }

    /// The same with fewer tiles.
    pub fn with_tiles(&self, tiles: u32) -> Atlas {
        let tiles = tiles.clamp(1, self.tiles);
        Atlas {
            columns: self.columns.min(tiles),
            tiles,
            ..*self
        }
    }

    /// Width and height of the texture.
    pub fn size(&self) -> wgpu::Extent3d {
        wgpu::Extent3d {
            width: self.columns * self.resolution,
            height: self.tiles.div_ceil(self.columns) * 3 * self.resolution,
            depth_or_array_layers: 1,
        }
    }

    /// Left and top of a tile.
    pub fn origin(&self, tile: u32) -> [u32; 2] {
        let n = self.resolution;
        [tile % self.columns * n, tile / self.columns * 3 * n]
    }

    /// A face of a tile.
    pub fn face(&self, tile: u32, face: usize) -> Rectangle {
        let [x, y] = self.origin(tile);
        let n = self.resolution;
        match face {
            0 => [x, y, n, n],
            _ => [x, y + n + (face as u32 - 1) * (n / 2), n, n / 2],
        }
    }

    /// Face, column and row of a pixel; rows of side faces begin at the horizon.
    pub fn locate(&self, pixel: u32) -> (usize, u32, u32) {
        let n = self.resolution;
        let (column, row) = (pixel % n, pixel / n);
        if row < n {
            return (0, column, row);
        }
        let half = n / 2;
        (((row - n) / half) as usize + 1, column, (row - n) % half)
    }

    /// Row stride in bytes for reading back: copies require multiples of 256.
    pub fn row_bytes(&self) -> u32 {
        (4 * self.resolution).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
    }

    /// Size of a tile in bytes when read back.
    pub fn tile_bytes(&self) -> u64 {
        u64::from(self.row_bytes()) * u64::from(3 * self.resolution)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_fill_the_texture_and_do_not_leave_it() {
        let limits = wgpu::Limits::default();
        for (n, pixels) in [
            (2, 1 << 20),
            (64, 1 << 21),
            (128, 1 << 25),
            (512, 1),
            (2048, 1 << 28),
        ] {
            let atlas = Atlas::new(n, pixels, &limits).expect("fits");
            let size = atlas.size();
            assert!(size.width <= limits.max_texture_dimension_2d);
            assert!(size.height <= limits.max_texture_dimension_2d);
            let [x, y] = atlas.origin(atlas.tiles - 1);
            assert!(x + n <= size.width && y + 3 * n <= size.height, "{atlas:?}");
        }
    }

    #[test]
    fn a_small_limit_is_named() {
        let limits = wgpu::Limits {
            max_texture_dimension_2d: 256,
            ..wgpu::Limits::default()
        };
        let error = Atlas::new(128, 1, &limits).unwrap_err().to_string();
        assert!(
            error.contains("128 × 384") && error.contains("84 pixels"),
            "{error}"
        );
    }

    #[test]
    fn pixels_are_where_the_hemicube_has_them() {
        let atlas = Atlas::new(4, 1, &wgpu::Limits::default()).expect("fits");
        let n2 = 16;
        assert_eq!(atlas.locate(5), (0, 1, 1));
        assert_eq!(atlas.locate(n2), (1, 0, 0));
        assert_eq!(atlas.locate(n2 + 2 * 8 + 7), (3, 3, 1));
        assert_eq!(atlas.face(0, 3), [0, 8, 4, 2]);
    }
}
