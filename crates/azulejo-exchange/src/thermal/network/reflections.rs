//! The system of diffuse reflections, J = g + c ∘ F^s J, in its symmetric form.
//!
//! With A the areas and S = A F^s, and J = g + √c ∘ y:
//!
//! ```text
//! (D(A) − D(√c) S D(√c)) y = √c ∘ (S g)
//! ```
//!
//! Small systems are factored once; large ones are solved by conjugate gradients with the diagonal as
//! preconditioner, up to eight right sides at a time, because reading S is what takes the time.

use super::ExchangeError;
use crate::enclosure::Enclosure;
use azulejo_factors::cholesky::Cholesky;
use azulejo_factors::hierarchy::FactorOperator;
use azulejo_trace::Progress;
use rayon::prelude::*;

/// Up to this number of rows the system is factored: 32 MB.
const FEW: usize = 2_000;

/// Most right sides that are solved together.
pub(super) const LANES: usize = 8;

/// Residual at which iterations end, relative to the right side.
const TOLERANCE: f64 = 1e-13;

/// Residual that counts as solved where rounding prevents the one above.
const ENOUGH: f64 = 1e-10;

/// Most iterations.
const MOST: usize = 2_000;

/// Numbers of each row, one for each right side.
type Lanes<const L: usize> = Vec<[f64; L]>;

/// J = g + c ∘ F^s J for one c and any number of g.
pub(crate) struct Reflections<'a> {
    factors: &'a dyn FactorOperator,
    /// √c of each row.
    root: Vec<f64>,
    /// Areas, 1 for rows without.
    weights: Vec<f64>,
    factored: Option<Cholesky>,
}

impl<'a> Reflections<'a> {
    /// Prepares the system for c, 0..1 of each row.
    pub fn new(
        enclosure: &'a Enclosure,
        c: &[f64],
        progress: &Progress,
    ) -> Result<Reflections<'a>, ExchangeError> {
        let weight = |&area: &f64| if area > 0.0 { area } else { 1.0 };
        let mut reflections = Reflections {
            factors: enclosure.operator(),
            root: c.iter().map(|c| c.sqrt()).collect(),
            weights: enclosure.factors.areas.iter().map(weight).collect(),
            factored: None,
        };
        let n = enclosure.len();
        if n <= FEW {
            let factored = Cholesky::new(reflections.dense(), n, progress)?;
            let factored = factored.map_err(|row| ExchangeError::Grows {
                row: enclosure.rows.names[row].clone(),
            })?;
            reflections.factored = Some(factored);
        }
        Ok(reflections)
    }

    /// The matrix, row by row.
    fn dense(&self) -> Vec<f64> {
        let n = self.root.len();
        let mut matrix = vec![0.0; n * n];
        for (i, weight) in self.weights.iter().enumerate() {
            matrix[i * n + i] = *weight;
        }
        self.factors.for_each_pair(&mut |i, j, value| {
            let value = self.root[i] * value * self.root[j];
            matrix[i * n + j] -= value;
            if i != j {
                matrix[j * n + i] -= value;
            }
        });
        matrix
    }

    /// J for each g.
    pub fn solve(
        &self,
        sources: &[Vec<f64>],
        progress: &Progress,
    ) -> Result<Vec<Vec<f64>>, ExchangeError> {
        let mut solutions = Vec::with_capacity(sources.len());
        for few in sources.chunks(LANES) {
            solutions.extend(match few.len() {
                1 => self.solve_few::<1>(few, progress)?,
                2 => self.solve_few::<2>(few, progress)?,
                3 | 4 => self.solve_few::<4>(few, progress)?,
                _ => self.solve_few::<LANES>(few, progress)?,
            });
        }
        Ok(solutions)
    }

    /// J for each of at most `L` g.
    fn solve_few<const L: usize>(
        &self,
        few: &[Vec<f64>],
        progress: &Progress,
    ) -> Result<Vec<Vec<f64>>, ExchangeError> {
        let right: Lanes<L> = scaled(&self.exchanged(&lanes(few)), &self.root);
        let y: Lanes<L> = match &self.factored {
            Some(system) => {
                let solve = |lane: usize| system.solve(&column(&right, lane));
                let columns: Vec<Vec<f64>> = (0..few.len()).into_par_iter().map(solve).collect();
                progress.advance(few.len() as u64)?;
                lanes(&columns)
            }
            None => self.iterate(&right, few.len(), progress)?,
        };
        let y = scaled(&y, &self.root);
        let solution = |(lane, source): (usize, &Vec<f64>)| {
            let rows = source.iter().zip(&y);
            rows.map(|(g, y)| g + y[lane]).collect()
        };
        Ok(few.iter().enumerate().map(solution).collect())
    }

    /// Σ_j S_ij J_j of each row: what arrives on its area.
    pub fn arriving(&self, radiosities: &[Vec<f64>]) -> Vec<Vec<f64>> {
        arriving(self.factors, radiosities)
    }

    /// S x.
    fn exchanged<const L: usize>(&self, x: &Lanes<L>) -> Lanes<L> {
        from_flat(self.factors.exchanged_lanes(x.as_flattened(), L))
    }

    /// Conjugate gradients for several right sides, each for itself.
    fn iterate<const L: usize>(
        &self,
        right: &Lanes<L>,
        count: usize,
        progress: &Progress,
    ) -> Result<Lanes<L>, ExchangeError> {
        let n = right.len();
        let diagonal = self.inverse_diagonal();
        // Start from 0, where the residual is the right side itself.
        let mut y: Lanes<L> = vec![[0.0; L]; n];
        let mut rest = right.clone();
        let mut next = scaled(&rest, &diagonal);
        let mut direction = next.clone();
        let mut product = dots(&rest, &next);
        let size = dots(right, right);
        for iteration in 0..MOST {
            progress.advance(0)?;
            let left = dots(&rest, &rest);
            let is_done = |lane: usize, t: f64| left[lane] <= t * t * size[lane];
            if (0..L).all(|lane| is_done(lane, TOLERANCE)) {
                progress.advance(count as u64)?;
                return Ok(y);
            }
            // Rounding may keep the residual above the tolerance: after many iterations a larger one will do.
            if iteration > MOST / 2 && (0..L).all(|lane| is_done(lane, ENOUGH)) {
                progress.advance(count as u64)?;
                return Ok(y);
            }
            // Step to the minimum along the direction; lanes that are done stay where they are.
            let image = self.times(&direction);
            let curvature = dots(&direction, &image);
            let step: [f64; L] = std::array::from_fn(|lane| {
                if is_done(lane, TOLERANCE) || curvature[lane] <= 0.0 {
                    0.0
                } else {
                    product[lane] / curvature[lane]
                }
            });
            add(&mut y, &step, &direction);
            add(&mut rest, &step.map(|s| -s), &image);
            // Make the next direction conjugate to those before, from the preconditioned residual.
            next = scaled(&rest, &diagonal);
            let grown = dots(&rest, &next);
            let turn: [f64; L] = std::array::from_fn(|lane| {
                if product[lane] > 0.0 {
                    grown[lane] / product[lane]
                } else {
                    0.0
                }
            });
            for (d, z) in direction.iter_mut().zip(&next) {
                (0..L).for_each(|lane| d[lane] = z[lane] + turn[lane] * d[lane]);
            }
            product = grown;
        }
        Err(ExchangeError::Diverges { iterations: MOST })
    }

    /// The matrix times x.
    fn times<const L: usize>(&self, x: &Lanes<L>) -> Lanes<L> {
        let mut product = scaled(&self.exchanged(&scaled(x, &self.root)), &self.root);
        for ((p, x), weight) in product.iter_mut().zip(x).zip(&self.weights) {
            (0..L).for_each(|lane| p[lane] = weight * x[lane] - p[lane]);
        }
        product
    }

    fn inverse_diagonal(&self) -> Vec<f64> {
        let own = self.factors.own();
        let row = |i: usize| {
            let diagonal = self.weights[i] - self.root[i] * own[i] * self.root[i];
            // A row that sees itself alone is left to its own devices.
            diagonal.max(1e-12 * self.weights[i]).recip()
        };
        (0..self.root.len()).map(row).collect()
    }
}

/// Σ_j S_ij x_j of each row, for each x.
pub(super) fn arriving(factors: &dyn FactorOperator, vectors: &[Vec<f64>]) -> Vec<Vec<f64>> {
    fn exchanged_few<const L: usize>(
        factors: &dyn FactorOperator,
        few: &[Vec<f64>],
    ) -> Vec<Vec<f64>> {
        let x: Lanes<L> = lanes(few);
        let sums: Lanes<L> = from_flat(factors.exchanged_lanes(x.as_flattened(), L));
        (0..few.len()).map(|lane| column(&sums, lane)).collect()
    }
    let few = |few: &[Vec<f64>]| match few.len() {
        1 => exchanged_few::<1>(factors, few),
        2 => exchanged_few::<2>(factors, few),
        3 | 4 => exchanged_few::<4>(factors, few),
        _ => exchanged_few::<LANES>(factors, few),
    };
    vectors.chunks(LANES).flat_map(few).collect()
}

/// Numbers of rows side by side as lanes.
pub(super) fn from_flat<const L: usize>(numbers: Vec<f64>) -> Lanes<L> {
    numbers.as_chunks::<L>().0.to_vec()
}

/// At most `L` vectors as one of lanes.
pub(super) fn lanes<const L: usize>(vectors: &[Vec<f64>]) -> Lanes<L> {
    let rows = vectors.first().map_or(0, Vec::len);
    let row = |i: usize| std::array::from_fn(|lane| vectors.get(lane).map_or(0.0, |v| v[i]));
    (0..rows).map(row).collect()
}

/// One of the vectors.
fn column<const L: usize>(lanes: &Lanes<L>, lane: usize) -> Vec<f64> {
    lanes.iter().map(|row| row[lane]).collect()
}

/// x times one factor for each row.
fn scaled<const L: usize>(x: &Lanes<L>, factors: &[f64]) -> Lanes<L> {
    let rows = x.iter().zip(factors);
    rows.map(|(x, factor)| x.map(|x| x * factor)).collect()
}

fn dots<const L: usize>(a: &Lanes<L>, b: &Lanes<L>) -> [f64; L] {
    let mut sums = [0.0; L];
    for (a, b) in a.iter().zip(b) {
        (0..L).for_each(|lane| sums[lane] += a[lane] * b[lane]);
    }
    sums
}

fn add<const L: usize>(to: &mut Lanes<L>, shares: &[f64; L], x: &Lanes<L>) {
    for (to, x) in to.iter_mut().zip(x) {
        (0..L).for_each(|lane| to[lane] += shares[lane] * x[lane]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thermal::network::tests::random_enclosure;

    #[test]
    fn iterations_and_factors_agree() {
        let enclosure = random_enclosure(37, 5);
        let c: Vec<f64> = (0..37).map(|i| 0.02 * f64::from(i)).collect();
        let factored = Reflections::new(&enclosure, &c, &Progress::new()).unwrap();
        let source = |k: i32| (0..37).map(|i| f64::from((i * k) % 11)).collect();
        let sources: Vec<Vec<f64>> = (1..=11).map(source).collect();
        let direct = factored.solve(&sources, &Progress::new()).unwrap();
        let iterative = Reflections {
            factored: None,
            ..factored
        };
        let iterated = iterative.solve(&sources, &Progress::new()).unwrap();
        let arriving = iterative.arriving(&direct);
        for k in 0..sources.len() {
            for i in 0..37 {
                let (a, b) = (direct[k][i], iterated[k][i]);
                assert!((a - b).abs() < 1e-11 * (1.0 + a.abs()), "{k} {i}: {a} {b}");
                let expected = sources[k][i] + c[i] * arriving[k][i] / enclosure.factors.areas[i];
                assert!((a - expected).abs() < 1e-11 * (1.0 + a.abs()));
            }
        }
    }

    #[test]
    fn solving_can_be_cancelled() {
        let enclosure = random_enclosure(9, 5);
        let progress = Progress::new();
        progress.cancel();
        let refused = Reflections::new(&enclosure, &[0.5; 9], &progress).err();
        assert_eq!(refused, Some(ExchangeError::Cancelled));
    }
}
