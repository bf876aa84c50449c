//! Rows by formulas against a few rays.
//!
//! A formula that goes wrong states a small error all the same. What a few rays from a row find is too coarse
//! to be its value, but enough to tell that half of it is missing. Columns are compared in strata of
//! neighbours, by the probability of this many hits: if it is smaller than e^−18 even with the formula moved
//! towards the rays by its own error and by what rays lose at edges, the two disagree.

/// Groups of neighbouring columns.
pub(crate) const STRATA: usize = 8;

/// Share of a row that rays may lose at edges.
const LOST: f64 = 2e-3;

/// Standard errors by which the formula may be off.
const ERRORS: f64 = 4.0;

/// Logarithm of the odds from which it is not by chance.
const ODDS: f64 = 18.0;

/// What a stratum of columns gets of a row's light.
#[derive(Clone, Copy, Debug, Default)]
struct Stratum {
    /// By formulas, with the sum of the errors.
    value: f64,
    error: f64,
    /// The share of the rays.
    hits: f64,
}

/// What all strata get of the light of a row, or of several rows on average.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Strata([Stratum; STRATA]);

impl Strata {
    /// Adds a form factor with its standard error.
    pub fn add_factor(&mut self, stratum: usize, value: f64, error: f64) {
        self.0[stratum].value += value;
        self.0[stratum].error += error;
    }

    /// Adds a share of the rays.
    pub fn add_hits(&mut self, stratum: usize, share: f64) {
        self.0[stratum].hits += share;
    }

    /// The mean of several rows.
    pub fn mean(rows: &[&Strata]) -> Strata {
        let mut mean = Strata::default();
        let share = 1.0 / rows.len().max(1) as f64;
        for (stratum, s) in rows.iter().flat_map(|row| row.0.iter().enumerate()) {
            mean.add_factor(stratum, share * s.value, share * s.error);
            mean.add_hits(stratum, share * s.hits);
        }
        mean
    }

    /// Whether the hits of this many rays are too improbable.
    ///
    /// Chernoff's bound: of K rays that each hit with probability p, a share h hits with a probability of at
    /// most e^(−K D), where D is the relative entropy of h and p (Hoeffding, *Probability inequalities for sums
    /// of bounded random variables*, JASA 58, 1963, theorem 1). Rays of a Sobol sequence vary less.
    pub fn disagree(&self, rays: usize) -> bool {
        self.0.iter().any(|s| {
            let slack = LOST + ERRORS * s.error;
            let expected = s.value + (s.hits - s.value).clamp(-slack, slack);
            rays as f64 * relative_entropy(s.hits, expected.clamp(0.0, 1.0)) > ODDS
        })
    }
}

/// h ln(h / p) + (1 − h) ln((1 − h) / (1 − p)), each term 0 where h or 1 − h is.
fn relative_entropy(h: f64, p: f64) -> f64 {
    let term = |h: f64, p: f64| if h > 1e-12 { h * (h / p).ln() } else { 0.0 };
    term(h, p) + term(1.0 - h, 1.0 - p)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(value: f64, error: f64, hits: f64, rays: usize, expected: bool) {
        let mut strata = Strata::default();
        strata.add_factor(3, value, error);
        strata.add_hits(3, hits);
        assert_eq!(strata.disagree(rays), expected);
    }

    #[test]
    fn what_is_too_improbable_is_no_chance() {
        check(1.0, 1e-6, 1.0, 64, false);
        check(0.7, 1e-6, 1.0, 64, true);
        check(0.7, 0.1, 1.0, 64, false);
        check(0.5, 1e-6, 0.6, 64, false);
        check(0.5, 1e-6, 0.6, 4096, true);
        check(0.0, 0.0, 1.0 / 64.0, 64, false);
        check(0.0, 0.0, 8.0 / 64.0, 64, true);
        check(0.2, 1e-6, 0.0, 64, false);
        check(0.3, 1e-6, 0.0, 64, true);
    }
}
