//! The equations of textbooks for grey enclosures, and Gaussian elimination.
//!
//! With E = σT⁴, extended factors F^s and the net flux q that leaves a row (Sarofim and Hottel 1966;
//! Modest, *Radiative Heat Transfer*, on enclosures with partly specular surfaces), radiosities eliminated:
//!
//! ```text
//! E_i − Σ_j (1 − ρ_s,j) F^s_ij E_j = q_i/ε_i − Σ_j (ρ_d,j/ε_j) F^s_ij q_j
//! ```
//!
//! and for absorption factors (Gebhart, *Surface temperature calculations in radiant surroundings of
//! arbitrary complexity*, Int. J. Heat Mass Transfer 3, 1961; with F^s for F):
//!
//! ```text
//! B_ij = F^s_ij ε_j + Σ_k F^s_ik ρ_d,k B_kj
//! ```
//!
//! The crate's solver uses neither: it has one symmetric system in radiosities, for Cholesky's method.

use crate::expected::SIGMA;
use azulejo_exchange::RowCondition;

/// Shares below which a row counts as closed.
const CLOSED: f64 = 1e-12;

/// Emissivities and mirror reflectances of rows, 0..1; what is left of 1 is reflected diffusely.
#[derive(Clone, Debug, PartialEq)]
pub struct GreyPaint {
    pub emissivity: Vec<f64>,
    pub mirror: Vec<f64>,
}

impl GreyPaint {
    /// Without mirrors.
    pub fn matt(emissivity: &[f64]) -> GreyPaint {
        GreyPaint {
            emissivity: emissivity.to_vec(),
            mirror: vec![0.0; emissivity.len()],
        }
    }
}

/// A grey enclosure as textbooks have it; what rows lack goes to black space of 0 K.
#[derive(Clone, Debug)]
pub struct NetRadiation {
    areas: Vec<f64>,
    factors: Vec<Vec<f64>>,
    paint: GreyPaint,
}

/// Temperatures, K, and net fluxes that leave rows, W/m².
#[derive(Clone, Debug)]
pub struct KnownBalance {
    pub temperatures: Vec<f64>,
    pub fluxes: Vec<f64>,
}

impl NetRadiation {
    /// Areas in square metres, and `factor(i, j)`, F^s from each row to each.
    pub fn new(
        areas: &[f64],
        paint: &GreyPaint,
        factor: impl Fn(usize, usize) -> f64,
    ) -> NetRadiation {
        let n = areas.len();
        let row = |i: usize| (0..n).map(|j| factor(i, j)).collect();
        NetRadiation {
            areas: areas.to_vec(),
            factors: (0..n).map(row).collect(),
            paint: paint.clone(),
        }
    }

    /// The same with `upper(i, j)` for i ≤ j alone, the rest by reciprocity.
    pub fn reciprocal(
        areas: &[f64],
        paint: &GreyPaint,
        upper: impl Fn(usize, usize) -> f64,
    ) -> NetRadiation {
        NetRadiation::new(areas, paint, |i, j| {
            if i <= j {
                upper(i, j)
            } else {
                upper(j, i) * areas[j] / areas[i]
            }
        })
    }

    /// F^s from a row to another.
    pub fn factor(&self, i: usize, j: usize) -> f64 {
        self.factors[i][j]
    }

    fn diffuse(&self, i: usize) -> f64 {
        1.0 - self.paint.emissivity[i] - self.paint.mirror[i]
    }

    /// F^s from a row to space.
    pub fn to_space(&self, i: usize) -> f64 {
        let ended = |(f, m): (&f64, &f64)| f * (1.0 - m);
        let ended: f64 = self.factors[i]
            .iter()
            .zip(&self.paint.mirror)
            .map(ended)
            .sum();
        if 1.0 - ended > CLOSED {
            1.0 - ended
        } else {
            0.0
        }
    }

    /// B from a row to another, or to space, which follows the last row.
    pub fn gebhart(&self, i: usize, j: usize) -> f64 {
        let n = self.areas.len();
        let right = (0..n).map(|i| match self.paint.emissivity.get(j) {
            Some(emissivity) => self.factors[i][j] * emissivity,
            None => self.to_space(i),
        });
        let left = |i: usize, k: usize| unit(i, k) - self.factors[i][k] * self.diffuse(k);
        eliminate(matrix(n, left), right.collect())[i]
    }

    /// GR between a row and another, or space, m².
    pub fn conductance(&self, i: usize, j: usize) -> f64 {
        self.areas[i] * self.script_f(i, j)
    }

    /// GR over the area of the first.
    pub fn script_f(&self, i: usize, j: usize) -> f64 {
        self.paint.emissivity[i] * self.gebhart(i, j)
    }

    /// Temperatures and fluxes, where either is known of each row. No emissivity is 0.
    pub fn balance(&self, conditions: &[RowCondition]) -> KnownBalance {
        let n = self.areas.len();
        let ends = |j: usize| 1.0 - self.paint.mirror[j];
        let emission_factor = |i: usize, j: usize| unit(i, j) - ends(j) * self.factors[i][j];
        let flux_factor = |i: usize, j: usize| {
            (unit(i, j) - self.diffuse(j) * self.factors[i][j]) / self.paint.emissivity[j]
        };
        // Unknown fluxes and emissions on the left, known ones on the right.
        let left = |i: usize, j: usize| match conditions[j] {
            RowCondition::Temperature(_) => -flux_factor(i, j),
            RowCondition::Flux(_) => emission_factor(i, j),
        };
        let known = |i: usize, j: usize| match conditions[j] {
            RowCondition::Temperature(t) => -emission_factor(i, j) * SIGMA * t.powi(4),
            RowCondition::Flux(q) => flux_factor(i, j) * q,
        };
        let right = (0..n).map(|i| (0..n).map(|j| known(i, j)).sum()).collect();
        let solution = eliminate(matrix(n, left), right);
        let temperature = |(condition, x): (&RowCondition, &f64)| match condition {
            RowCondition::Temperature(t) => *t,
            RowCondition::Flux(_) => (x / SIGMA).powf(0.25),
        };
        let flux = |(condition, x): (&RowCondition, &f64)| match condition {
            RowCondition::Temperature(_) => *x,
            RowCondition::Flux(q) => *q,
        };
        KnownBalance {
            temperatures: conditions.iter().zip(&solution).map(temperature).collect(),
            fluxes: conditions.iter().zip(&solution).map(flux).collect(),
        }
    }
}

fn unit(i: usize, j: usize) -> f64 {
    f64::from(u8::from(i == j))
}

fn matrix(n: usize, entry: impl Fn(usize, usize) -> f64) -> Vec<Vec<f64>> {
    let row = |i: usize| (0..n).map(|j| entry(i, j)).collect();
    (0..n).map(row).collect()
}

/// Solves a dense system by Gaussian elimination, with the largest pivot of each column.
pub fn eliminate(mut matrix: Vec<Vec<f64>>, mut right: Vec<f64>) -> Vec<f64> {
    let n = right.len();
    for k in 0..n {
        let size = |&i: &usize| matrix[i][k].abs();
        let pivot = (k..n)
            .max_by(|a, b| size(a).total_cmp(&size(b)))
            .unwrap_or(k);
        matrix.swap(k, pivot);
        right.swap(k, pivot);
        let (above, below) = matrix.split_at_mut(k + 1);
        for (row, i) in below.iter_mut().zip(k + 1..) {
            let factor = row[k] / above[k][k];
            for (entry, pivot) in row.iter_mut().zip(&above[k]) {
                *entry -= factor * pivot;
            }
            right[i] -= factor * right[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| matrix[k][j] * right[j]).sum();
        right[k] = (right[k] - known) / matrix[k][k];
    }
    right
}
