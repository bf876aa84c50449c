//! Which filter is taken where: that of the least error, as far as it can be estimated.

use super::filter::{Candidate, FILTERS, LEAST_SLACK, NoisyImage};
use super::planes::{Features, Size};
use rayon::prelude::*;

/// Radius over which estimates of errors are averaged: single ones are as noisy as the image.
const RISK_RADIUS: usize = 4;

/// Radius over which choices are blended.
const BLEND_RADIUS: usize = 2;

/// The share of each filter in every pixel; the rest is left as it was.
pub(super) struct FilterSelection {
    pub shares: Vec<[f32; FILTERS]>,
    /// Relative error before and after.
    pub error_before: f64,
    pub error_after: f64,
}

impl FilterSelection {
    pub fn new(
        size: Size,
        noisy: &NoisyImage,
        features: &Features,
        candidates: &[Candidate],
        albedo: &[[f32; 3]],
    ) -> FilterSelection {
        let count = size.width * size.height;
        let scales = scales(noisy, albedo);
        let risk = |of: &dyn Fn(usize, usize) -> f32| -> Vec<f32> {
            let pixel = |k: usize| [0, 1, 2].map(|c| of(k, c) * scales[k][c]).iter().sum();
            (0..count).map(pixel).collect()
        };
        // The mean of both halves has half of the variance of one.
        let before = risk(&|k, c| 0.5 * noisy.variance[k][c]);
        let risks: Vec<Vec<f32>> = candidates
            .iter()
            .map(|one| risk(&|k, c| stein(noisy, one, k, c)))
            .collect();
        let all: Vec<[f32; FILTERS + 1]> = (0..count)
            .map(|k| std::array::from_fn(|f| risks.get(f).unwrap_or(&before)[k]))
            .collect();
        let smoothed = smooth(size, features, &all);
        let chosen = |k: usize| -> Option<usize> {
            let least = |f: usize| smoothed[k][f];
            let best = (0..FILTERS).min_by(|&a, &b| least(a).total_cmp(&least(b)))?;
            (least(best) < least(FILTERS)).then_some(best)
        };
        let chosen: Vec<Option<usize>> = (0..count).map(chosen).collect();
        let shares: Vec<Vec<f32>> = (0..FILTERS)
            .map(|f| {
                let is_chosen = |c: &Option<usize>| f32::from(u8::from(*c == Some(f)));
                let map: Vec<f32> = chosen.iter().map(is_chosen).collect();
                size.box_mean(&map, BLEND_RADIUS)
            })
            .collect();
        let shares: Vec<[f32; FILTERS]> = (0..count)
            .map(|k| std::array::from_fn(|f| shares[f][k]))
            .collect();
        let after = |k: usize| {
            let filtered: f32 = (0..FILTERS).map(|f| shares[k][f] * risks[f][k]).sum();
            filtered + (1.0 - shares[k].iter().sum::<f32>()) * before[k]
        };
        let root = |of: &dyn Fn(usize) -> f32| {
            let sum: f64 = (0..count).map(|k| f64::from(of(k))).sum();
            (sum / (3 * count).max(1) as f64).max(0.0).sqrt()
        };
        let (error_before, error_after) = (root(&|k| before[k]), root(&after));
        FilterSelection {
            error_before,
            error_after,
            shares,
        }
    }
}

/// Means of risks over the pixels around each that show the same surface: the edges of lamps, which no
/// filter improves, must not decide for the walls beside them.
fn smooth(
    size: Size,
    features: &Features,
    risks: &[[f32; FILTERS + 1]],
) -> Vec<[f32; FILTERS + 1]> {
    let reach = RISK_RADIUS as isize;
    let pixel = |p: usize| {
        let (x, y) = ((p % size.width) as isize, (p / size.width) as isize);
        let (mut sums, mut whole) = ([0.0; FILTERS + 1], 0.0);
        for dy in -reach..=reach {
            for q in (-reach..=reach).filter_map(|dx| size.inside(x + dx, y + dy)) {
                let weight = (-features.distance(p, q, LEAST_SLACK[0])).exp();
                whole += weight;
                (0..=FILTERS).for_each(|f| sums[f] += weight * risks[q][f]);
            }
        }
        sums.map(|sum| sum / whole)
    };
    (0..risks.len()).into_par_iter().map(pixel).collect()
}

/// What squares of errors without textures are multiplied by to be relative to the image, as in
/// [`relative_rmse`](crate::relative_rmse).
fn scales(noisy: &NoisyImage, albedo: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let [a, b] = &noisy.halves;
    let light = |k: usize, c: usize| 0.5 * (a[k][c] + b[k][c]);
    let count = albedo.len();
    let all = (0..count).flat_map(|k| [0, 1, 2].map(|c| f64::from(light(k, c) * albedo[k][c])));
    let dim = (0.1 * all.sum::<f64>() / (3 * count).max(1) as f64) as f32;
    // The light of one pixel is noise itself: errors of dark dots would count for too much.
    let planes = [0, 1, 2].map(|c| {
        let values: Vec<f32> = (0..count).map(|k| light(k, c)).collect();
        noisy.size.box_mean(&values, RISK_RADIUS)
    });
    let scale = |k: usize, c: usize| {
        let whole = (planes[c][k] * albedo[k][c]).powi(2) + dim * dim;
        if whole > 0.0 {
            albedo[k][c].powi(2) / whole
        } else {
            0.0
        }
    };
    (0..count).map(|k| [0, 1, 2].map(|c| scale(k, c))).collect()
}

/// Estimated square of the error of the mean of both filtered halves.
///
/// Of each half by Stein's risk estimate, (F − c)² + 2 σ² dF/dc − σ²; as its weights come of the other
/// half, the derivative is its own weight alone. For the mean of two errors a and b,
/// ((a + b)/2)² = (a² + b²)/2 − ((a − b)/2)², and a − b is known.
fn stein(noisy: &NoisyImage, filtered: &Candidate, k: usize, c: usize) -> f32 {
    let variance = noisy.variance[k][c];
    let one = |h: usize| {
        let moved = filtered.halves[h][k][c] - noisy.halves[h][k][c];
        moved * moved + (2.0 * filtered.own[h][k] - 1.0) * variance
    };
    let apart = filtered.halves[0][k][c] - filtered.halves[1][k][c];
    0.5 * (one(0) + one(1)) - 0.25 * apart * apart
}
