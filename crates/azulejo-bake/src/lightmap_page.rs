//! One page of texels, and the texels around one of them.

use crate::layout::NO_CHART;
use azulejo_scene::Rgb;

/// The texels of one page.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightmapPage {
    /// Width and height, texels.
    pub size: [u32; 2],
    /// Irradiance, W/m² (lx in photometric scenes), row by row from v = 0: the top row of a picture.
    pub irradiance: Vec<[f32; 3]>,
    /// Its standard error.
    pub standard_error: Vec<[f32; 3]>,
    /// The chart that each texel covers or pads; [`NO_CHART`] between charts.
    pub charts: Vec<u32>,
    /// What each texel covers, square scene units: none where it pads a chart, or lies inside of a
    /// solid.
    pub areas: Vec<f32>,
}

impl LightmapPage {
    /// A page without light or charts.
    pub fn dark(size: [u32; 2]) -> LightmapPage {
        let count = size[0] as usize * size[1] as usize;
        LightmapPage {
            size,
            irradiance: vec![[0.0; 3]; count],
            standard_error: vec![[0.0; 3]; count],
            charts: vec![NO_CHART; count],
            areas: vec![0.0; count],
        }
    }

    /// Irradiance between the centres of texels, as viewers interpolate it, at texture coordinates 0..=1.
    pub fn bilinear(&self, uv: [f64; 2]) -> Rgb {
        let (cells, weights) = bilinear_cells(self.size, uv);
        let value = |c: usize| Rgb::from(self.irradiance[c].map(f64::from));
        cells.iter().zip(weights).map(|(&c, w)| value(c) * w).sum()
    }
}

/// The four texels around a place, and their weights; beyond the border the texels at it.
pub(crate) fn bilinear_cells(size: [u32; 2], uv: [f64; 2]) -> ([usize; 4], [f64; 4]) {
    let split = |x: f64, n: u32| {
        let x = (x * f64::from(n) - 0.5).clamp(0.0, f64::from(n - 1));
        let low = (x.floor() as usize).min(n as usize - 1);
        (low, (low + 1).min(n as usize - 1), x - low as f64)
    };
    let (left, right, fx) = split(uv[0], size[0]);
    let (top, bottom, fy) = split(uv[1], size[1]);
    let at = |column: usize, row: usize| row * size[0] as usize + column;
    (
        [
            at(left, top),
            at(right, top),
            at(left, bottom),
            at(right, bottom),
        ],
        [
            (1.0 - fx) * (1.0 - fy),
            fx * (1.0 - fy),
            (1.0 - fx) * fy,
            fx * fy,
        ],
    )
}

/// Columns and rows around a texel, those with an edge in common first.
const AROUND: [(i32, i32); 8] = [
    (-1, 0),
    (1, 0),
    (0, -1),
    (0, 1),
    (-1, -1),
    (1, -1),
    (-1, 1),
    (1, 1),
];

/// The texels around one, with their places in [`AROUND`].
pub(crate) fn neighbours(size: [u32; 2], texel: u32) -> impl Iterator<Item = (usize, usize)> {
    let (column, row) = (texel % size[0], texel / size[0]);
    AROUND.iter().enumerate().filter_map(move |(k, &(x, y))| {
        let (column, row) = (column.checked_add_signed(x)?, row.checked_add_signed(y)?);
        let is_inside = column < size[0] && row < size[1];
        is_inside.then_some((k, row as usize * size[0] as usize + column as usize))
    })
}

/// The mean of some of the values.
pub(crate) fn mean(values: &[[f32; 3]], of: &[usize]) -> [f32; 3] {
    let share = 1.0 / of.len() as f32;
    let mut sum = [0.0; 3];
    for &i in of {
        for (s, v) in sum.iter_mut().zip(values[i]) {
            *s += share * v;
        }
    }
    sum
}
