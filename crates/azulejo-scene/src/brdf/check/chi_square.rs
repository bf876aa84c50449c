//! A χ² test of samples against their density, in cells of about equal probability.

use super::cells::Cell;
use super::random::Random;
use crate::Rgb;
use crate::brdf::Brdf;
use glam::DVec3;

/// Largest expected fraction of the samples in a cell, unless it is too small to divide.
const SHARE: f64 = 1.0 / 128.0;

/// Cells with fewer expected samples are merged.
const FEWEST: f64 = 10.0;

/// Largest number of successive divisions of a cell.
const DEPTH: u32 = 16;

/// Number of divisions before anything is integrated.
const FIRST: u32 = 3;

/// Pearson's test of samples against their density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChiSquare {
    /// Number of samples, lost ones included.
    pub samples: u32,
    /// The fraction of them that was lost below the surface.
    pub lost: f64,
    /// The fraction that the density predicts to be lost: 1 less its integral.
    pub lost_expected: f64,
    /// Σ (found − expected)²/expected.
    pub statistic: f64,
    /// Number of cells less one.
    pub degrees: u32,
    /// Probability of a larger statistic if density and samples agree; values below about 1e-4 mean
    /// that they do not.
    pub probability: f64,
}

/// A cell with its quarters, or with its counts.
enum CellTree {
    Divided(Cell, Box<[CellTree; 4]>),
    Count { expected: f64, found: u32 },
}

/// Compares samples of light along `wo` with their density.
pub fn chi_square(brdf: &Brdf, wo: DVec3, samples: u32) -> ChiSquare {
    let density = |wi: DVec3| Rgb::grey(brdf.pdf(wo, wi));
    let mass = |cell: &Cell| cell.integral(wo, &density).r;
    let mut tree = CellTree::new(Cell::HEMISPHERE, &mass, 0);
    let (mut random, mut lost) = (Random::new(3), 0);
    for _ in 0..samples {
        match brdf.sample(wo, random.numbers()) {
            Some(sample) => tree.count(sample.wi),
            None => lost += 1,
        }
    }
    let mut cells = Vec::new();
    tree.collect(&mut cells);
    let sum: f64 = cells.iter().map(|(expected, _)| expected).sum();
    let lost_expected = (1.0 - sum).max(0.0);
    cells.push((lost_expected, lost));
    let (statistic, degrees) = compare(&cells, f64::from(samples));
    ChiSquare {
        samples,
        lost: f64::from(lost) / f64::from(samples.max(1)),
        lost_expected,
        statistic,
        degrees,
        probability: exceeded(statistic, degrees),
    }
}

impl CellTree {
    fn new(cell: Cell, mass: &dyn Fn(&Cell) -> f64, depth: u32) -> CellTree {
        if depth >= FIRST {
            let expected = mass(&cell);
            if expected <= SHARE || depth == DEPTH {
                return CellTree::Count { expected, found: 0 };
            }
        }
        let node = |quarter: Cell| CellTree::new(quarter, mass, depth + 1);
        CellTree::Divided(cell, Box::new(cell.quarters().map(node)))
    }

    fn count(&mut self, wi: DVec3) {
        match self {
            CellTree::Divided(cell, quarters) => quarters[cell.quarter_of(wi)].count(wi),
            CellTree::Count { found, .. } => *found += 1,
        }
    }

    fn collect(&self, cells: &mut Vec<(f64, u32)>) {
        match self {
            CellTree::Divided(_, quarters) => quarters.iter().for_each(|q| q.collect(cells)),
            CellTree::Count { expected, found } => cells.push((*expected, *found)),
        }
    }
}

/// Statistic and degrees of freedom; cells with too few expected samples are merged.
fn compare(cells: &[(f64, u32)], samples: f64) -> (f64, u32) {
    let (mut statistic, mut count) = (0.0, 0u32);
    let mut add = |expected: f64, found: f64| {
        statistic += (found - expected).powi(2) / expected;
        count += 1;
    };
    let (mut rest, mut rest_found) = (0.0, 0.0);
    for &(share, found) in cells {
        let expected = share * samples;
        if expected >= FEWEST {
            add(expected, f64::from(found));
        } else {
            rest += expected;
            rest_found += f64::from(found);
        }
    }
    // The remaining cells may expect almost nothing, but samples found in them count.
    if rest >= FEWEST || rest_found > rest + FEWEST {
        add(rest.max(1.0), rest_found);
    }
    (statistic, count.saturating_sub(1))
}

/// Probability that χ² of that many degrees of freedom is larger: the regularized incomplete
/// gamma function Q(k/2, χ²/2), by its series or its continued fraction (Lentz).
fn exceeded(statistic: f64, degrees: u32) -> f64 {
    let (a, x) = (0.5 * f64::from(degrees), 0.5 * statistic);
    if degrees == 0 || x <= 0.0 {
        return 1.0;
    }
    let front = (a * x.ln() - x - libm::lgamma(a)).exp();
    if x < a + 1.0 {
        let (mut sum, mut term, mut k) = (1.0 / a, 1.0 / a, a);
        while term > 1e-16 * sum {
            k += 1.0;
            term *= x / k;
            sum += term;
        }
        return (1.0 - front * sum).clamp(0.0, 1.0);
    }
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (1e300, 1.0 / b);
    let mut fraction = d;
    for k in 1..10_000 {
        let k = f64::from(k);
        let a_k = -k * (k - a);
        b += 2.0;
        d = 1.0 / (a_k * d + b);
        c = b + a_k / c;
        fraction *= c * d;
        if (c * d - 1.0).abs() < 1e-15 {
            break;
        }
    }
    (front * fraction).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probabilities_are_those_of_the_tables() {
        let check = |statistic: f64, degrees: u32, expected: f64| {
            let probability = exceeded(statistic, degrees);
            assert!(
                (probability - expected).abs() < 1e-6,
                "{probability} {expected}"
            );
        };
        // For two degrees of freedom it is exp(−χ²/2), for four (1 + χ²/2) exp(−χ²/2).
        check(3.0, 2, (-1.5f64).exp());
        check(20.0, 4, 11.0 * (-10.0f64).exp());
        check(3.841_458_821, 1, 0.05);
        check(124.342_113, 100, 0.05);
        check(70.064_895, 100, 0.99);
    }

    #[test]
    fn a_wrong_density_is_found() {
        // A lobe sampled with another exponent.
        let made = |text: &str| Brdf::new(text.parse().unwrap()).unwrap();
        let (narrow, wide) = (made("lewis n = 22"), made("lewis n = 20"));
        let wo = super::super::direction(40.0, 20.0);
        assert!(chi_square(&narrow, wo, 50_000).probability > 1e-3);
        let density = |cell: &Cell| cell.integral(wo, &|wi| Rgb::grey(wide.pdf(wo, wi))).r;
        let mut tree = CellTree::new(Cell::HEMISPHERE, &density, 0);
        let mut random = Random::new(4);
        for _ in 0..50_000 {
            if let Some(sample) = narrow.sample(wo, random.numbers()) {
                tree.count(sample.wi);
            }
        }
        let mut cells = Vec::new();
        tree.collect(&mut cells);
        let (statistic, degrees) = compare(&cells, 50_000.0);
        assert!(exceeded(statistic, degrees) < 1e-6);
    }
}
