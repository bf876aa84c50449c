//! Form factors as a linear operator, whole or compressed.

use super::CompressedFactors;
use super::blocks::{self, BlockPart};
use crate::disjoint_sets::DisjointSets;
use crate::form_factors::{Exchange, ExchangeAreas, FormFactors};
use azulejo_trace::sampling::{hash, uniform};
use azulejo_trace::{Cancelled, Progress};
use std::fmt;

/// A symmetric matrix of exchange areas S = A X that can be multiplied by vectors: whole, in blocks, or
/// wherever else it is.
///
/// One number stands for both directions of a pair, so reciprocity holds to the last bit; products
/// have the same bits for any number of threads.
pub trait FactorOperator: fmt::Debug + Send + Sync {
    /// Area of each row, in square scene units.
    fn row_areas(&self) -> &[f64];

    /// S x for several vectors at once, since reading S is what takes the time. In `x` and in the
    /// result the numbers of a row stand side by side, one for each vector: `lanes` ≥ 1 for each row.
    /// A vector has the same bits whatever the others are.
    ///
    /// # Panics
    /// If `x` has another length than `lanes` numbers for each row.
    fn exchanged_lanes(&self, x: &[f64], lanes: usize) -> Vec<f64>;

    /// V x for several vectors at once, as [`exchanged_lanes`](FactorOperator::exchanged_lanes), with the
    /// variances V_ij of S_ij by rays, or upper estimates of them; those that are unknown count as 0.
    ///
    /// # Panics
    /// As there.
    fn variance_lanes(&self, x: &[f64], lanes: usize) -> Vec<f64>;

    /// Visits i, j and S_ij of each pair i ≤ j that is not 0, once, in any order. For n² pairs, whatever
    /// the operator stores: for small ones.
    fn for_each_pair(&self, visit: &mut dyn FnMut(usize, usize, f64));

    /// Numbers that a product reads, which is what it costs.
    fn numbers(&self) -> u64;

    /// Bytes of the matrix in memory.
    fn bytes(&self) -> usize;

    /// S_ii of each row.
    fn own(&self) -> Vec<f64> {
        let mut own = vec![0.0; self.row_areas().len()];
        self.for_each_pair(&mut |i, j, value| {
            if i == j {
                own[i] = value;
            }
        });
        own
    }

    /// For each row the first of those with which it exchanges light, directly or by way of others.
    fn connected(&self) -> Vec<u32> {
        let mut rows = DisjointSets::new(self.row_areas().len());
        self.for_each_pair(&mut |i, j, value| {
            if value > 0.0 {
                rows.join(i as u32, j as u32);
            }
        });
        rows.into_smallest()
    }

    /// Variance of Σ_ij r_i S_ij x_j from those of S, as if pairs erred by themselves; what rows see of
    /// themselves may count twice.
    ///
    /// # Panics
    /// If `r` or `x` has another length than there are rows.
    fn variance_between(&self, r: &[f64], x: &[f64]) -> f64 {
        // Half of Σ_ij V_ij (r_i x_j + r_j x_i)²: what rows see of themselves counts twice.
        let lanes: Vec<f64> = r.iter().zip(x).flat_map(|(r, x)| [x * x, r * x]).collect();
        let spread = self.variance_lanes(&lanes, 2);
        let rows = r.iter().zip(x).zip(spread.as_chunks::<2>().0);
        let sum = rows.map(|((r, x), spread)| r * r * spread[0] + r * x * spread[1]);
        sum.sum::<f64>().max(0.0)
    }

    /// S x.
    ///
    /// # Panics
    /// If `x` has another length than there are rows.
    fn exchanged(&self, x: &[f64]) -> Vec<f64> {
        self.exchanged_lanes(x, 1)
    }

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

    fn exchanged_lanes(&self, x: &[f64], lanes: usize) -> Vec<f64> {
        in_lanes(&self.exchange, x, lanes, |e| e.value)
    }

    fn variance_lanes(&self, x: &[f64], lanes: usize) -> Vec<f64> {
        in_lanes(&self.exchange, x, lanes, |e| {
            let variance = f64::from(e.error).powi(2);
            if variance.is_finite() { variance } else { 0.0 }
        })
    }

    fn for_each_pair(&self, visit: &mut dyn FnMut(usize, usize, f64)) {
        for i in 0..self.len() {
            let upper = self.exchange.upper(i).iter();
            upper.for_each(|e| visit(i, e.column as usize, e.value));
        }
    }

    fn numbers(&self) -> u64 {
        self.exchange.pairs() as u64
    }

    fn bytes(&self) -> usize {
        self.exchange.bytes()
    }

    fn own(&self) -> Vec<f64> {
        let first = |i: usize| self.exchange.upper(i).first();
        let own = |i: usize| first(i).filter(|e| e.column as usize == i);
        (0..self.len())
            .map(|i| own(i).map_or(0.0, |e| e.value))
            .collect()
    }

    fn variance_between(&self, r: &[f64], x: &[f64]) -> f64 {
        let mut variance = 0.0;
        for i in 0..self.len() {
            for e in self.exchange.upper(i) {
                let k = e.column as usize;
                let slope = if k == i {
                    r[i] * x[i]
                } else {
                    r[i] * x[k] + r[k] * x[i]
                };
                let error = f64::from(e.error);
                // Errors that are unknown are left out.
                if error.is_finite() {
                    variance += (error * slope).powi(2);
                }
            }
        }
        variance
    }
}

/// The matrix of `weight(S_ij)` times vectors, as many at a time as there are loops for.
fn in_lanes(
    exchange: &ExchangeAreas,
    x: &[f64],
    lanes: usize,
    weight: impl Fn(&Exchange) -> f64 + Sync,
) -> Vec<f64> {
    assert_eq!(x.len(), lanes * exchange.len(), "lanes for each row");
    match lanes {
        1 => flat_products::<1>(exchange, x, weight),
        2 => flat_products::<2>(exchange, x, weight),
        4 => flat_products::<4>(exchange, x, weight),
        8 => flat_products::<8>(exchange, x, weight),
        _ => {
            let mut products = vec![0.0; x.len()];
            for lane in 0..lanes {
                let own: Vec<[f64; 1]> = x.iter().skip(lane).step_by(lanes).map(|&x| [x]).collect();
                let product = exchange.products(&own, &weight);
                let places = products.iter_mut().skip(lane).step_by(lanes);
                places.zip(product).for_each(|(to, [value])| *to = value);
            }
            products
        }
    }
}

/// The products of `L` vectors whose numbers of one row stand side by side.
fn flat_products<const L: usize>(
    exchange: &ExchangeAreas,
    x: &[f64],
    weight: impl Fn(&Exchange) -> f64 + Sync,
) -> Vec<f64> {
    exchange
        .products(x.as_chunks::<L>().0, weight)
        .into_flattened()
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
    /// The error of `approximate` against `exact`, by `probes` ≥ 1 random vectors.
    ///
    /// # Panics
    /// If the two have different numbers of rows.
    pub fn of(
        approximate: &dyn FactorOperator,
        exact: &dyn FactorOperator,
        probes: u32,
        seed: u32,
    ) -> OperatorError {
        let areas = exact.row_areas();
        let probe = |k: u32| probe_vector(areas.len(), seed, k);
        let difference = |x: &[f64]| minus(&approximate.apply(x), &exact.apply(x));
        let mut product = 0.0;
        for k in 0..probes {
            let x = probe(k);
            let whole = norm(&exact.apply(&x), areas);
            product += (ratio(norm(&difference(&x), areas), whole)).powi(2);
        }
        let off = minus(&approximate.sums(), &exact.sums());
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

/// Independent numbers in 0..1.
pub(super) fn probe_vector(rows: usize, seed: u32, k: u32) -> Vec<f64> {
    let row = |i: usize| f64::from(uniform(&[hash(&[seed, k]), i as u32]));
    (0..rows).map(row).collect()
}

/// The largest ‖M x‖ / ‖x‖, by power iteration from x.
fn largest(times: &dyn Fn(&[f64]) -> Vec<f64>, mut x: Vec<f64>, areas: &[f64]) -> f64 {
    let mut gain = 0.0;
    for _ in 0..STEPS {
        let length = norm(&x, areas);
        x = times(&x);
        let next = norm(&x, areas);
        gain = ratio(next, length);
        if next == 0.0 {
            return 0.0;
        }
        x.iter_mut().for_each(|x| *x /= next);
    }
    gain
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
    let areas = factors.row_areas().iter();
    let areas: Vec<f64> = areas.map(|&a| if a > 0.0 { a } else { 1.0 }).collect();
    let roots: Vec<f64> = reflectances.iter().map(|r| r.sqrt()).collect();
    let lengths = [exitance.len(), roots.len()];
    assert_eq!(lengths, [areas.len(); 2], "one number for each row");
    let times = |x: &[f64]| {
        let own = x.iter().zip(&areas).map(|(x, a)| x * a);
        let reflected = scaled(&factors.exchanged(&scaled(x, &roots)), &roots);
        own.zip(reflected)
            .map(|(own, s)| own - s)
            .collect::<Vec<f64>>()
    };
    // Conjugate gradients, from y = 0.
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
    let reflected = exitance.iter().zip(scaled(&y, &roots));
    Ok((reflected.map(|(m, y)| m + y).collect(), iterations))
}

/// x / areas; 0 where there is no area.
fn over(x: &[f64], areas: &[f64]) -> Vec<f64> {
    x.iter().zip(areas).map(|(&x, &a)| ratio(x, a)).collect()
}

/// a / b; 0 unless b is positive.
pub(super) fn ratio(a: f64, b: f64) -> f64 {
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
    let squares = x.iter().zip(areas).map(|(x, a)| a * x * x);
    squares.sum::<f64>().sqrt()
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

    fn exchanged_lanes(&self, x: &[f64], lanes: usize) -> Vec<f64> {
        assert_eq!(x.len(), lanes * self.len(), "lanes for each row");
        // By position, one vector after the other, as blocks want them.
        let lane = |lane: usize| {
            let order = self.order.iter();
            order.map(move |&row| x[lanes * row as usize + lane])
        };
        let by_position: Vec<f64> = (0..lanes).flat_map(lane).collect();
        let products = blocks::product(&self.parts, &by_position, lanes);
        let mut by_row = vec![0.0; x.len()];
        for (lane, product) in products.chunks_exact(self.len().max(1)).enumerate() {
            for (&row, value) in self.order.iter().zip(product) {
                by_row[lanes * row as usize + lane] = *value;
            }
        }
        by_row
    }

    /// Of hits of rays, each 1/N of a row, X_ij has the variance X_ij / N; S_ij, for which the rays of
    /// both rows are pooled, S_ij a_i a_j / (a_i + a_j) with a = A / N. Here it is S_ij (a_i + a_j) / 4, which is as
    /// much for equal rows and otherwise more. Pairs of one block have errors in common that are not in it.
    fn variance_lanes(&self, x: &[f64], lanes: usize) -> Vec<f64> {
        let rows = self.areas.iter().zip(&self.entry_noise);
        let quarters: Vec<f64> = rows.map(|(area, noise)| 0.25 * area * noise).collect();
        let weigh = |x: &[f64]| -> Vec<f64> {
            let rows = x.chunks_exact(lanes).zip(&quarters);
            rows.flat_map(|(x, a)| x.iter().map(move |x| a * x))
                .collect()
        };
        let (before, after) = (
            self.exchanged_lanes(&weigh(x), lanes),
            weigh(&self.exchanged_lanes(x, lanes)),
        );
        before.iter().zip(after).map(|(a, b)| a + b).collect()
    }

    fn for_each_pair(&self, visit: &mut dyn FnMut(usize, usize, f64)) {
        for part in &self.parts {
            part.for_each(&mut |p, q, value| {
                let (i, j) = (self.order[p] as usize, self.order[q] as usize);
                visit(i.min(j), i.max(j), value);
            });
        }
    }

    fn numbers(&self) -> u64 {
        self.parts.iter().map(|part| part.values.len() as u64).sum()
    }

    fn bytes(&self) -> usize {
        4 * self.order.len() + self.parts.iter().map(BlockPart::bytes).sum::<usize>()
    }

    fn own(&self) -> Vec<f64> {
        let mut own = vec![0.0; self.len()];
        for part in &self.parts {
            part.for_each_own(&mut |p, value| own[self.order[p] as usize] = value);
        }
        own
    }

    fn connected(&self) -> Vec<u32> {
        let mut rows = DisjointSets::new(self.len());
        for part in &self.parts {
            part.for_each_link(&mut |p, q| rows.join(self.order[p], self.order[q]));
        }
        rows.into_smallest()
    }
}
