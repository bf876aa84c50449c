//! Form factors as a linear operator, whole or compressed.

use super::CompressedFactors;
use crate::form_factors::FormFactors;
use azulejo_trace::sampling::{hash, uniform};
use azulejo_trace::{Cancelled, Progress};

/// A symmetric matrix of exchange areas S = A X that can be multiplied by a vector.
///
/// One number stands for both directions of a pair, so reciprocity holds to the last bit; products
/// have the same bits for any number of threads.
pub trait FactorOperator: Sync {
    /// Area of each row, in square scene units.
    fn row_areas(&self) -> &[f64];

    /// S x.
    ///
    /// # Panics
    /// If `x` has another length than there are rows.
    fn exchanged(&self, x: &[f64]) -> Vec<f64>;

    /// Bytes of the matrix in memory.
    fn bytes(&self) -> usize;

    /// X x: the irradiance of each row by radiosities `x`. 0 for groups without rows.
    ///
    /// # Panics
    /// As [`exchanged`](FactorOperator::exchanged).
    fn apply(&self, x: &[f64]) -> Vec<f64> {
        over(&self.exchanged(x), self.row_areas())
    }

    /// Xᵀ x: the power that arrives at each row, from powers `x` that leave.
    ///
    /// # Panics
    /// As [`exchanged`](FactorOperator::exchanged).
    fn apply_transposed(&self, x: &[f64]) -> Vec<f64> {
        self.exchanged(&over(x, self.row_areas()))
    }

    /// Σ_j X_ij of every row.
    fn sums(&self) -> Vec<f64> {
        self.apply(&vec![1.0; self.row_areas().len()])
    }
}

impl FactorOperator for FormFactors {
    fn row_areas(&self) -> &[f64] {
        &self.areas
    }

    fn exchanged(&self, x: &[f64]) -> Vec<f64> {
        assert_eq!(x.len(), self.len(), "one number for each row");
        self.exchange
            .sums(|i, e| [e.value * x[e.column as usize], e.value * x[i]])
    }

    fn bytes(&self) -> usize {
        self.exchange.bytes()
    }
}

/// How far an operator is off another. Vectors have the norm ‖x‖² = Σ A_i x_i², the energy of a
/// radiosity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OperatorError {
    /// ‖ΔX x‖ / ‖X x‖, root mean square over vectors of independent numbers in 0..1: what a product
    /// with radiosities has.
    pub product: f64,
    /// The largest ‖ΔX x‖ / ‖x‖ of any x over the largest ‖X x‖ / ‖x‖, by power iteration: from
    /// below, by a few percent.
    pub worst: f64,
    /// Largest |Σ_j ΔX_ij|.
    pub most_of_sum: f64,
    /// Root mean square of Σ_j ΔX_ij over the rows.
    pub mean_of_sum: f64,
}

/// Steps of power iteration.
const STEPS: usize = 20;

impl OperatorError {
    /// The error of `found` against `exact`, by `probes` ≥ 1 random vectors.
    ///
    /// # Panics
    /// If the two have different numbers of rows.
    pub fn of(
        found: &dyn FactorOperator,
        exact: &dyn FactorOperator,
        probes: u32,
        seed: u32,
    ) -> OperatorError {
        let areas = exact.row_areas();
        let probe = |k: u32| -> Vec<f64> {
            let row = |i: usize| f64::from(uniform(&[hash(&[seed, k]), i as u32]));
            (0..areas.len()).map(row).collect()
        };
        let difference = |x: &[f64]| minus(&found.apply(x), &exact.apply(x));
        let mut product = 0.0;
        for k in 0..probes {
            let x = probe(k);
            let whole = norm(&exact.apply(&x), areas);
            product += (ratio(norm(&difference(&x), areas), whole)).powi(2);
        }
        let off = minus(&found.sums(), &exact.sums());
        let squares: f64 = off.iter().map(|s| s * s).sum();
        let start = minus(&probe(probes), &vec![0.5; areas.len()]);
        OperatorError {
            product: (product / f64::from(probes.max(1))).sqrt(),
            worst: ratio(
                largest(&difference, start, areas),
                largest(&|x: &[f64]| exact.apply(x), probe(probes), areas),
            ),
            most_of_sum: off.iter().fold(0.0, |most, s| most.max(s.abs())),
            mean_of_sum: (squares / areas.len().max(1) as f64).sqrt(),
        }
    }
}

/// The largest ‖M x‖ / ‖x‖, by power iteration from x.
fn largest(times: &dyn Fn(&[f64]) -> Vec<f64>, mut x: Vec<f64>, areas: &[f64]) -> f64 {
    let mut found = 0.0;
    for _ in 0..STEPS {
        let length = norm(&x, areas);
        let next = times(&x);
        found = ratio(norm(&next, areas), length);
        x = next;
        let length = norm(&x, areas);
        if length == 0.0 {
            return 0.0;
        }
        x.iter_mut().for_each(|x| *x /= length);
    }
    found
}

/// Residual, relative to the right side, at which iterations end where no smaller one is possible.
const ROUNDING: f64 = 1e-15;

/// Radiosities B = `exitance` + ρ X B for reflectances ρ of 0..1, until the residual is `tolerance` of
/// the right side or after `most` iterations; and the number of iterations.
///
/// Conjugate gradients for the symmetric form (A − √ρ S √ρ) y = √ρ S M, B = M + √ρ y (Neumann, *New
/// efficient algorithms with positive definite radiosity matrix*, 1994), preconditioned with A. It
/// converges while the rows sum to less than 1/ρ.
///
/// # Errors
/// [`Cancelled`].
///
/// # Panics
/// If the vectors have another length than there are rows.
pub fn radiosities(
    factors: &dyn FactorOperator,
    exitance: &[f64],
    reflectances: &[f64],
    (tolerance, most): (f64, usize),
    progress: &Progress,
) -> Result<(Vec<f64>, usize), Cancelled> {
    let areas: Vec<f64> = factors
        .row_areas()
        .iter()
        .map(|&a| if a > 0.0 { a } else { 1.0 })
        .collect();
    let roots: Vec<f64> = reflectances.iter().map(|r| r.sqrt()).collect();
    assert_eq!(
        (exitance.len(), roots.len()),
        (areas.len(), areas.len()),
        "one number for each row"
    );
    let times = |x: &[f64]| {
        let own = x.iter().zip(&areas).map(|(x, a)| x * a);
        let reflected = scaled(&factors.exchanged(&scaled(x, &roots)), &roots);
        own.zip(reflected)
            .map(|(own, s)| own - s)
            .collect::<Vec<f64>>()
    };
    let mut rest = scaled(&factors.exchanged(exitance), &roots);
    let end = tolerance.max(ROUNDING) * dot(&rest, &rest).sqrt();
    let mut y = vec![0.0; areas.len()];
    let mut direction = over(&rest, &areas);
    let mut power = dot(&rest, &direction);
    let mut iterations = 0;
    while iterations < most && dot(&rest, &rest).sqrt() > end {
        progress.advance(0)?;
        let image = times(&direction);
        let step = ratio(power, dot(&direction, &image));
        add(&mut y, step, &direction);
        add(&mut rest, -step, &image);
        let next = over(&rest, &areas);
        let grown = dot(&rest, &next);
        let turn = ratio(grown, power);
        for (d, z) in direction.iter_mut().zip(&next) {
            *d = z + turn * *d;
        }
        power = grown;
        iterations += 1;
    }
    let found = exitance.iter().zip(scaled(&y, &roots));
    Ok((found.map(|(m, y)| m + y).collect(), iterations))
}

/// x / areas; 0 where there is no area.
fn over(x: &[f64], areas: &[f64]) -> Vec<f64> {
    x.iter().zip(areas).map(|(&x, &a)| ratio(x, a)).collect()
}

/// a / b; 0 unless b is positive.
fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 0.0 }
}

fn scaled(x: &[f64], factors: &[f64]) -> Vec<f64> {
    x.iter().zip(factors).map(|(x, f)| x * f).collect()
}

fn minus(a: &[f64], b: &[f64]) -> Vec<f64> {
    assert_eq!(a.len(), b.len(), "operators with equal rows");
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

fn norm(x: &[f64], areas: &[f64]) -> f64 {
    x.iter()
        .zip(areas)
        .map(|(x, a)| a * x * x)
        .sum::<f64>()
        .sqrt()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn add(to: &mut [f64], share: f64, x: &[f64]) {
    to.iter_mut().zip(x).for_each(|(to, x)| *to += share * x);
}

impl FactorOperator for CompressedFactors {
    fn row_areas(&self) -> &[f64] {
        &self.areas
    }

    fn exchanged(&self, x: &[f64]) -> Vec<f64> {
        self.times(x)
    }

    fn bytes(&self) -> usize {
        self.matrix_bytes()
    }
}
