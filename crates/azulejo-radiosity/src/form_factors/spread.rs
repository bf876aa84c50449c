//! How well a handful of replicates is known.

use azulejo_trace::REPLICATES;

/// Degrees of freedom that the model of the noise counts for beside those of the replicates.
const MODEL_FREEDOM: f64 = 4.0;

/// Mean of the replicates, and the variance of that mean from their spread.
pub(super) fn mean_and_variance(values: [f64; REPLICATES]) -> (f64, f64) {
    let n = REPLICATES as f64;
    let mean = values.iter().sum::<f64>() / n;
    let spread: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
    (mean, spread / (n * (n - 1.0)))
}

/// The variance of an estimate to be believed, from the spread of its replicates, which has
/// `freedom` degrees of freedom, and from what is known of such rays anyhow; `one_ray` is the
/// value that a single hit makes.
///
/// A handful of hits spreads as they do by chance: in eight replicates one hit each have no
/// spread at all. So the spread is joined, by degrees of freedom, by a model: hits vary as a
/// binomial count, less as strata get to be smaller than the patch. Their number is M then, and
/// by the measured decline of the error, rays^−0.63, the variance of a count M falls from M to
/// about M^¾. `missing` is the share of the rays that did not hit: 1 for small targets.
pub(super) fn believed(value: f64, spread: f64, freedom: f64, one_ray: f64, missing: f64) -> f64 {
    let hits = value / one_ray;
    let model = value * one_ray * missing * (hits / 8.0).max(1.0).powf(-0.25);
    let joined = (freedom * spread + MODEL_FREEDOM * model) / (freedom + MODEL_FREEDOM);
    student(freedom + MODEL_FREEDOM).powi(2) * joined
}

/// Student's t over the normal law's at 95.4%: 1.142 with ten degrees of freedom, 1.216 with
/// seven. Fisher's expansion in 1/ν.
fn student(freedom: f64) -> f64 {
    let (z, v) = (2.0f64, freedom);
    let first = (z.powi(3) + z) / (4.0 * v);
    let second = (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / (96.0 * v * v);
    (z + first + second) / z
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_replicates_are_believed_less() {
        for (freedom, table) in [(7.0, 2.429), (10.0, 2.284), (30.0, 2.087)] {
            let said = 2.0 * student(freedom);
            assert!((said - table).abs() < 0.01, "{freedom}: {said} {table}");
        }
    }

    #[test]
    fn what_all_rays_do_is_certain() {
        assert_eq!(believed(1.0, 0.0, 3.0, 0.25, 0.0), 0.0);
        assert!(believed(0.5, 0.0, 3.0, 0.25, 0.5) > 0.0);
    }
}
