//! Pixels as planes of numbers, and the features that tell surfaces apart.

use crate::layers::{NO_DEPTH, PictureLayers};

/// Columns and rows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Size {
    pub width: usize,
    pub height: usize,
}

impl Size {
    /// The index of a pixel; coordinates beyond the border are those of the pixel there.
    pub fn clamped(self, x: isize, y: isize) -> usize {
        let x = x.clamp(0, self.width as isize - 1) as usize;
        let y = y.clamp(0, self.height as isize - 1) as usize;
        y * self.width + x
    }

    /// The index of a pixel; `None` beyond the border.
    pub fn inside(self, x: isize, y: isize) -> Option<usize> {
        let is_inside = x >= 0 && y >= 0 && x < self.width as isize && y < self.height as isize;
        is_inside.then(|| y as usize * self.width + x as usize)
    }

    /// Mean over the square of `2 radius + 1` pixels around each.
    pub fn box_mean(self, values: &[f32], radius: usize) -> Vec<f32> {
        let along = |from: &[f32], is_row: bool| -> Vec<f32> {
            let (length, step) = if is_row {
                (self.width, 1)
            } else {
                (self.height, self.width)
            };
            let mean = |k: usize| {
                let (at, start) = if is_row {
                    (k % self.width, k - k % self.width)
                } else {
                    (k / self.width, k % self.width)
                };
                let range = at.saturating_sub(radius)..(at + radius + 1).min(length);
                let count = range.len() as f32;
                range.map(|i| from[start + i * step]).sum::<f32>() / count
            };
            (0..from.len()).map(mean).collect()
        };
        along(&along(values, true), false)
    }
}

/// Number of features: albedo, normal, depth.
const FEATURES: usize = 7;

/// Features of all pixels.
pub(super) struct Features {
    /// Values, and the square of their standard errors.
    values: Vec<[f32; FEATURES]>,
    variances: Vec<[f32; FEATURES]>,
    /// The larger of that and of the squared gradient.
    slack: Vec<[f32; FEATURES]>,
}

/// k_f of the paper: how much features may differ, in their own slack.
const FEATURE_WIDTH: f32 = 0.6;

impl Features {
    pub fn new(size: Size, layers: &PictureLayers) -> Features {
        let depth = relative_depth(&layers.depth);
        let join = |a: [f32; 3], n: [f32; 3], z: f32| [a[0], a[1], a[2], n[0], n[1], n[2], z];
        let count = size.width * size.height;
        let (albedo, normal) = (&layers.albedo.pixels, &layers.normal.pixels);
        let values: Vec<[f32; FEATURES]> = (0..count)
            .map(|k| join(albedo[k], normal[k], depth[k]))
            .collect();
        let errors = [&layers.albedo_error.pixels, &layers.normal_error.pixels];
        let variances: Vec<[f32; FEATURES]> = (0..count)
            .map(|k| join(errors[0][k], errors[1][k], 0.0).map(|e| e * e))
            .collect();
        let slack = (0..count).map(|k| {
            let (x, y) = ((k % size.width) as isize, (k / size.width) as isize);
            let ends = [
                [size.clamped(x - 1, y), size.clamped(x + 1, y)],
                [size.clamped(x, y - 1), size.clamped(x, y + 1)],
            ];
            std::array::from_fn(|f| {
                let half = |[a, b]: [usize; 2]| 0.5 * (values[b][f] - values[a][f]);
                let gradient = half(ends[0]).powi(2) + half(ends[1]).powi(2);
                variances[k][f].max(gradient)
            })
        });
        Features {
            slack: slack.collect(),
            values,
            variances,
        }
    }

    /// Squared distance of two pixels, of the feature in which they differ most; `least` is the
    /// slack of a feature without error.
    pub fn distance(&self, p: usize, q: usize, least: f32) -> f32 {
        let (a, b) = (&self.values[p], &self.values[q]);
        let (va, vb) = (&self.variances[p], &self.variances[q]);
        let slack = &self.slack[p];
        let mut most = 0f32;
        for f in 0..FEATURES {
            let square = (a[f] - b[f]).powi(2) - (va[f] + va[f].min(vb[f]));
            most = most.max(square / (FEATURE_WIDTH * FEATURE_WIDTH * slack[f].max(least)));
        }
        most
    }
}

/// Depths relative to their mean; the background lies twice as far as anything.
fn relative_depth(depth: &[f32]) -> Vec<f32> {
    let near = || depth.iter().filter(|&&z| z < NO_DEPTH);
    let count = near().count().max(1) as f64;
    let mean = (near().map(|&z| f64::from(z)).sum::<f64>() / count) as f32;
    let scale = mean.abs().max(f32::MIN_POSITIVE);
    let farthest = near().fold(0.0, |a: f32, &z| a.max(z));
    let of = |&z: &f32| if z < NO_DEPTH { z } else { 2.0 * farthest } / scale;
    depth.iter().map(of).collect()
}
