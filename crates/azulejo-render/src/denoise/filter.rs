//! Joint non-local means: weights of all neighbours of all pixels, offset by offset.

use super::planes::{Features, Size};
use crate::measured::MeasuredImage;
use azulejo_trace::{Cancelled, Progress};
use rayon::prelude::*;

/// Neighbours reach so far in each direction, in pixels.
const REACH: isize = 8;

/// Rows that one task filters.
const BAND: usize = 16;

/// Half edges of the patches that the first two filters compare, in pixels.
const PATCHES: [isize; 2] = [1, 3];

/// k_c of the paper: how much colours may differ, in their standard deviations.
const COLOR_WIDTH: f32 = 0.45;

/// τ_f of the paper for filters that compare colours, and for that which does not.
pub(super) const LEAST_SLACK: [f32; 2] = [1e-3, 1e-4];

/// Added to variances, so that pixels without noise are only like their equals.
const TINY: f32 = 1e-10;

/// A distance at which weights are left out.
const FAR: f32 = 20.0;

/// Radius over which variances are compared with the difference between the halves.
const VARIANCE_RADIUS: usize = 10;

/// Two halves of an image without its textures, with their variances.
pub(super) struct NoisyImage {
    pub size: Size,
    pub halves: [Vec<[f32; 3]>; 2],
    /// Variance of one half.
    pub variance: Vec<[f32; 3]>,
}

impl NoisyImage {
    /// Samples of one pixel are stratified, so their spread says too much, above all at edges; the
    /// difference between the halves says how much in all (Rousselle, Knaus and Zwicker 2012,
    /// section 4.1).
    pub fn new(size: Size, found: &MeasuredImage, albedo: &[[f32; 3]]) -> NoisyImage {
        let divided =
            |pixels: &[[f32; 3]], k: usize| std::array::from_fn(|c| pixels[k][c] / albedo[k][c]);
        let count = size.width * size.height;
        let all = |pixels: &[[f32; 3]]| -> Vec<[f32; 3]> {
            (0..count).map(|k| divided(pixels, k)).collect()
        };
        let halves = [0, 1].map(|h: usize| all(&found.halves[h].pixels));
        let mut variance: Vec<[f32; 3]> = all(&found.error.pixels);
        variance
            .iter_mut()
            .flatten()
            .for_each(|e| *e = 2.0 * *e * *e);
        let mean = |values: [f32; 3]| (values[0] + values[1] + values[2]) / 3.0;
        let between = |k: usize| {
            let square = |c: usize| 0.5 * (halves[0][k][c] - halves[1][k][c]).powi(2);
            mean([0, 1, 2].map(square))
        };
        let seen: Vec<f32> = (0..count).map(between).collect();
        let spread: Vec<f32> = variance.iter().map(|&v| mean(v)).collect();
        let [seen, spread] = [seen, spread].map(|v| size.box_mean(&v, VARIANCE_RADIUS));
        for (k, variance) in variance.iter_mut().enumerate() {
            let share = if spread[k] > 0.0 {
                seen[k] / spread[k]
            } else {
                1.0
            };
            *variance = variance.map(|v| v * share.min(1.0));
        }
        NoisyImage {
            size,
            halves,
            variance,
        }
    }

    /// Squared distance of two pixels by the colours of one half, in their variances.
    fn distance(&self, half: usize, p: usize, q: usize) -> f32 {
        let (a, b) = (&self.halves[half][p], &self.halves[half][q]);
        let (va, vb) = (&self.variance[p], &self.variance[q]);
        let one = |c: usize| {
            let square = (a[c] - b[c]).powi(2) - (va[c] + va[c].min(vb[c]));
            square / (TINY + COLOR_WIDTH * COLOR_WIDTH * (va[c] + vb[c]))
        };
        (one(0) + one(1) + one(2)) / 3.0
    }
}

/// The image as one filter gives it.
#[derive(Clone, Default)]
pub(super) struct Candidate {
    /// Both halves.
    pub halves: [Vec<[f32; 3]>; 2],
    /// Share of a pixel's own value in its result, of either half: what changes with its noise.
    pub own: [Vec<f32>; 2],
}

impl Candidate {
    /// A pixel, of both halves.
    pub fn mean(&self, k: usize) -> [f32; 3] {
        std::array::from_fn(|c| 0.5 * (self.halves[0][k][c] + self.halves[1][k][c]))
    }
}

/// All filters: two that compare colours and features, and one that compares features.
pub(super) const FILTERS: usize = 3;

/// Runs all filters over all bands of rows.
pub(super) fn filter_bands(
    noisy: &NoisyImage,
    features: &Features,
    progress: &Progress,
) -> Result<Vec<Candidate>, Cancelled> {
    let rows: Vec<usize> = (0..noisy.size.height).step_by(BAND).collect();
    let bands: Result<Vec<[Candidate; FILTERS]>, Cancelled> = rows
        .into_par_iter()
        .map(|first| {
            let last = (first + BAND).min(noisy.size.height);
            let mut band = FilterBand::new(noisy, first, last);
            for dy in -REACH..=REACH {
                progress.advance(0)?;
                for dx in -REACH..=REACH {
                    band.add(features, (dx, dy));
                }
            }
            progress.advance(((last - first) * noisy.size.width) as u64)?;
            Ok(band.candidates())
        })
        .collect();
    let mut joined = vec![Candidate::default(); FILTERS];
    for band in bands? {
        for (all, part) in joined.iter_mut().zip(band) {
            for h in 0..2 {
                all.halves[h].extend_from_slice(&part.halves[h]);
                all.own[h].extend_from_slice(&part.own[h]);
            }
        }
    }
    Ok(joined)
}

/// Sums over the neighbours of the pixels of some rows.
struct FilterBand<'a> {
    noisy: &'a NoisyImage,
    first: usize,
    last: usize,
    /// Per filter, half and pixel: weighted colours, and weights.
    sums: Vec<[f32; 4]>,
    /// Distances of pixels at one offset, per half, with a border as wide as the largest patch.
    distances: [Vec<f32>; 2],
    /// Sums of them along rows, per half and patch.
    rows: [[Vec<f32>; 2]; 2],
}

/// The border.
const BORDER: isize = PATCHES[1];

impl<'a> FilterBand<'a> {
    fn new(noisy: &'a NoisyImage, first: usize, last: usize) -> FilterBand<'a> {
        let width = noisy.size.width;
        let tall = last - first + 2 * BORDER as usize;
        let distances = || vec![0.0; tall * (width + 2 * BORDER as usize)];
        let rows = || [(); 2].map(|()| vec![0.0; tall * width]);
        FilterBand {
            noisy,
            first,
            last,
            sums: vec![[0.0; 4]; 2 * FILTERS * (last - first) * width],
            distances: [distances(), distances()],
            rows: [rows(), rows()],
        }
    }

    /// Adds the neighbour at that offset of every pixel.
    fn add(&mut self, features: &Features, offset: (isize, isize)) {
        self.measure(offset);
        let (noisy, size) = (self.noisy, self.noisy.size);
        let pixels = (self.last - self.first) * size.width;
        for k in 0..pixels {
            let p = self.first * size.width + k;
            let (x, y) = ((p % size.width) as isize, (p / size.width) as isize);
            let Some(q) = size.inside(x + offset.0, y + offset.1) else {
                continue;
            };
            let strict = features.distance(p, q, LEAST_SLACK[1]);
            let lax = if strict > 0.0 {
                features.distance(p, q, LEAST_SLACK[0])
            } else {
                strict
            };
            if lax > FAR {
                continue;
            }
            for half in 0..2 {
                // The weights of one half are for the other.
                let colors = noisy.halves[1 - half][q];
                let patches = [0, 1].map(|n| self.patch(half, n, k));
                let all = [patches[0].max(lax), patches[1].max(lax), strict];
                for (filter, distance) in all.into_iter().enumerate() {
                    if distance > FAR {
                        continue;
                    }
                    let weight = (-distance.max(0.0)).exp();
                    let sum = &mut self.sums[(2 * filter + 1 - half) * pixels + k];
                    (0..3).for_each(|c| sum[c] += weight * colors[c]);
                    sum[3] += weight;
                }
            }
        }
    }

    /// Finds the distances of all pixels and of those around them at an offset.
    fn measure(&mut self, (dx, dy): (isize, isize)) {
        let size = self.noisy.size;
        let wide = size.width + 2 * BORDER as usize;
        let tall = self.last - self.first + 2 * BORDER as usize;
        for row in 0..tall {
            let y = self.first as isize + row as isize - BORDER;
            for column in 0..wide {
                let x = column as isize - BORDER;
                let (p, q) = (size.clamped(x, y), size.clamped(x + dx, y + dy));
                for half in 0..2 {
                    self.distances[half][row * wide + column] = self.noisy.distance(half, p, q);
                }
            }
        }
        for half in 0..2 {
            for (n, patch) in PATCHES.into_iter().enumerate() {
                for row in 0..tall {
                    for x in 0..size.width {
                        let start = row * wide + x + (BORDER - patch) as usize;
                        let around = &self.distances[half][start..=start + 2 * patch as usize];
                        self.rows[half][n][row * size.width + x] = around.iter().sum();
                    }
                }
            }
        }
    }

    /// Mean distance of the patches around pixel `k` of the band and its neighbour.
    fn patch(&self, half: usize, n: usize, k: usize) -> f32 {
        let (width, patch) = (self.noisy.size.width, PATCHES[n] as usize);
        let edge = 2 * patch + 1;
        let start = k + (BORDER as usize - patch) * width;
        let sum: f32 = (0..edge)
            .map(|r| self.rows[half][n][start + r * width])
            .sum();
        sum / (edge * edge) as f32
    }

    /// The results.
    fn candidates(&self) -> [Candidate; FILTERS] {
        let pixels = (self.last - self.first) * self.noisy.size.width;
        std::array::from_fn(|filter| {
            let sums = |half: usize| &self.sums[(2 * filter + half) * pixels..][..pixels];
            let colors = |s: &[f32; 4]| [0, 1, 2].map(|c| s[c] / s[3]);
            Candidate {
                halves: [0, 1].map(|h| sums(h).iter().map(colors).collect()),
                own: [0, 1].map(|h| sums(h).iter().map(|s| 1.0 / s[3]).collect()),
            }
        })
    }
}
