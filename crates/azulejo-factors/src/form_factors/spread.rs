//! Variances estimated from a handful of replicates.

use azulejo_trace::REPLICATES;

/// Degrees of freedom of the prior model of the noise, besides those of the replicates.
const MODEL_FREEDOM: f64 = 4.0;

/// Degrees of freedom of the variance of four replicates.
pub(super) const SPREAD_FREEDOM: f64 = (REPLICATES - 1) as f64;

/// Degrees of freedom of the variance of a pair by rays: four replicates from either side.
pub(super) const PAIR_FREEDOM: f64 = 2.0 * SPREAD_FREEDOM + MODEL_FREEDOM;

/// Mean of the replicates, and the variance of that mean from their spread.
pub(super) fn mean_and_variance(values: [f64; REPLICATES]) -> (f64, f64) {
    let n = REPLICATES as f64;
    let mean = values.iter().sum::<f64>() / n;
    let spread: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
    (mean, spread / (n * (n - 1.0)))
}

/// The noise of an engine's estimates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum NoiseModel {
    /// That of counts of hits.
    Hits,
    /// Unknown: only the spread of the replicates counts. A hemicube has a million pixels, but they
    /// share a handful of viewpoints, which cause the error.
    Unknown,
    /// There is a single estimate, and so no spread: variances are NaN.
    NoSpread,
}

impl NoiseModel {
    /// The variance to be used for an estimate: from the variance of its replicates, `spread`, with
    /// `freedom` degrees of freedom, and from the prior model; `hit` is the value of a single hit.
    /// `missing` is the share of the row that did not hit: 1 for small targets.
    pub fn posterior_variance(
        self,
        value: f64,
        spread: f64,
        freedom: f64,
        hit: f64,
        missing: f64,
    ) -> f64 {
        match self {
            NoiseModel::Hits => joined(value, spread, freedom, hit, missing),
            NoiseModel::Unknown => student(freedom).powi(2) * spread,
            NoiseModel::NoSpread => f64::NAN,
        }
    }

    /// The standard error of the mean of one row's replicates, from the variance of that mean, `spread`; `hit` is
    /// the value of a single hit.
    pub fn error(self, value: f64, spread: f64, hit: f64) -> f64 {
        let missing = (1.0 - value).max(0.0);
        self.posterior_variance(value, spread, SPREAD_FREEDOM, hit, missing)
            .sqrt()
    }

    /// Degrees of freedom of the sum of two variances of four replicates each. If one of them
    /// dominates, there are only its three (Welch 1947).
    pub fn freedom(self, [a, b]: [f64; 2]) -> f64 {
        match self {
            NoiseModel::Unknown if a + b > 0.0 => {
                SPREAD_FREEDOM * (a + b).powi(2) / (a * a + b * b)
            }
            _ => 2.0 * SPREAD_FREEDOM,
        }
    }
}

/// A handful of hits has a poor variance: with one hit in each of eight replicates it is zero. So
/// it is combined, weighted by degrees of freedom, with a model: hits vary as a binomial count,
/// less once strata are smaller than the patch. By the measured decline of the error, rays^−0.63,
/// the variance of a count M falls from M to about M^¾. `hit` is the value of a single hit.
fn joined(value: f64, spread: f64, freedom: f64, hit: f64, missing: f64) -> f64 {
    let model = missing * model(value, value * hit);
    let joined = (freedom * spread + MODEL_FREEDOM * model) / (freedom + MODEL_FREEDOM);
    student(freedom + MODEL_FREEDOM).powi(2) * joined
}

/// The variance of a share from the sum of the squares of what single rays bring.
fn model(value: f64, squares: f64) -> f64 {
    let hits = value * value / squares.max(f64::MIN_POSITIVE);
    squares * (hits / 8.0).max(1.0).powf(-0.25)
}

/// What to add to the spread of a share where the squares of what single rays bring are larger by `excess` than if
/// each hit were a ray, so that the [posterior variance](NoiseModel::posterior_variance) with `freedom` degrees of
/// freedom is that of a model which knows them.
pub(super) fn excess_spread(value: f64, hit: f64, excess: f64, freedom: f64) -> f64 {
    if excess <= 0.0 {
        return 0.0;
    }
    let squares = value * hit;
    let more = model(value, squares + excess) - model(value, squares);
    more.max(0.0) * MODEL_FREEDOM / freedom
}

/// Student's t over the normal quantile at 95.4%: 1.142 with ten degrees of freedom, 1.216 with
/// seven, 1.65 with three. Fisher's expansion in 1/ν (Abramowitz and Stegun, 26.7.5).
pub(super) fn student(freedom: f64) -> f64 {
    let (z, v) = (2.0f64, freedom);
    let first = (z.powi(3) + z) / (4.0 * v);
    let second = (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / (96.0 * v * v);
    let third = 3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z;
    (z + first + second + third / (384.0 * v.powi(3))) / z
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_replicates_are_believed_less() {
        for (freedom, table) in [
            (3.0, 3.307),
            (6.0, 2.516),
            (7.0, 2.429),
            (10.0, 2.284),
            (30.0, 2.087),
        ] {
            let quantile = 2.0 * student(freedom);
            assert!(
                (quantile - table).abs() < 0.01 + 0.3 / freedom.powi(2),
                "{freedom}: {quantile} {table}"
            );
        }
    }

    #[test]
    fn what_all_rays_do_is_certain() {
        let rays = NoiseModel::Hits;
        assert_eq!(rays.posterior_variance(1.0, 0.0, 3.0, 0.25, 0.0), 0.0);
        assert!(rays.posterior_variance(0.5, 0.0, 3.0, 0.25, 0.5) > 0.0);
    }

    #[test]
    fn without_a_law_the_spread_decides() {
        let variance = NoiseModel::Unknown.posterior_variance(0.5, 4.0, 30.0, 1.0, 1.0);
        assert!((variance.sqrt() - 2.087).abs() < 0.01, "{variance}");
        let variance = NoiseModel::NoSpread.posterior_variance(0.5, 0.0, 3.0, 1.0, 1.0);
        assert!(variance.is_nan(), "{variance}");
        for (spreads, freedom) in [([1.0, 1.0], 6.0), ([0.0, 2.0], 3.0), ([0.0, 0.0], 6.0)] {
            assert_eq!(NoiseModel::Unknown.freedom(spreads), freedom);
        }
    }
}
