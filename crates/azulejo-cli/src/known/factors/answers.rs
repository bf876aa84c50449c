//! From the form factors of a scene to the answer of its question, with a standard error.

use super::{Case, EnclosureSurface, PatchGroup, Question};
use azulejo_factors::{FactorsError, FormFactorOptions, FormFactors, Patches, form_factors};
use azulejo_trace::{Progress, Tracer};
use std::f64::consts::TAU;

/// An engine's answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// The number.
    pub value: f64,
    /// Its standard error, from those of the form factors; 0 if the engine considers it exact.
    pub error: f64,
}

impl Answer {
    /// Absolute error of the answer.
    pub fn off(&self, case: &Case) -> f64 {
        (self.value - case.truth.value).abs()
    }

    /// Error of the answer in its own standard errors, beyond the uncertainty of the truth;
    /// infinite if an answer without error is wrong.
    pub fn standard_errors(&self, case: &Case) -> f64 {
        let off = (self.off(case) - case.truth.error).max(0.0);
        if off == 0.0 { 0.0 } else { off / self.error }
    }
}

impl Case {
    /// Whether the question involves backs of patches.
    pub fn is_two_sided(&self) -> bool {
        self.question.groups().iter().any(|g| g.inside)
    }

    /// Computes the form factors with `options`, except for division and sides, which the case
    /// decides, and answers from them. `tracer` is one of the case's scene.
    ///
    /// # Errors
    /// As [`form_factors`].
    pub fn ask(
        &self,
        tracer: &Tracer,
        options: &FormFactorOptions,
        progress: &Progress,
    ) -> Result<(Answer, FormFactors), FactorsError> {
        let options = FormFactorOptions {
            size: self.size,
            two_sided: self.is_two_sided(),
            ..options.clone()
        };
        let factors = form_factors(&self.scene, tracer, &options, progress)?;
        Ok((self.answer(&factors), factors))
    }

    /// The answer from form factors of the case's scene.
    ///
    /// # Panics
    /// If they are of another scene or division.
    pub fn answer(&self, factors: &FormFactors) -> Answer {
        let patches = Patches::new(&self.scene, self.size);
        let groups = self.question.groups();
        let exchange = GroupExchange::new(&groups, &patches, self.is_two_sided(), factors);
        match &self.question {
            Question::Factor { .. } => exchange.factor(0, groups.len() - 1),
            Question::Radiosity { groups, of } => exchange.radiosity(groups, *of),
            Question::Flux { groups, of } => {
                let b = exchange.radiosity(groups, *of);
                let enclosure_surface = &groups[*of];
                // H = (B − M)/ρ, and what leaves is B − H.
                let gain = 1.0 - 1.0 / enclosure_surface.reflectance;
                Answer {
                    value: b.value * gain
                        + enclosure_surface.exitance / enclosure_surface.reflectance,
                    error: b.error * gain.abs(),
                }
            }
        }
    }
}

impl Question {
    /// The groups of the question; for a factor from a group to itself only one.
    fn groups(&self) -> Vec<PatchGroup> {
        match self {
            Question::Factor { from, to } if from == to => vec![from.clone()],
            Question::Factor { from, to } => vec![from.clone(), to.clone()],
            Question::Radiosity { groups, .. } | Question::Flux { groups, .. } => {
                groups.iter().map(|g| g.group.clone()).collect()
            }
        }
    }
}

impl PatchGroup {
    /// The rows of the group.
    fn rows(&self, patches: &Patches, two_sided: bool) -> Vec<usize> {
        let row = |p: usize| {
            if two_sided {
                2 * p + usize::from(self.inside)
            } else {
                p
            }
        };
        let patches_of = patches.patches_of(self.object);
        let inside = patches_of.filter(|&p| self.holds(patches, p));
        inside.map(row).collect()
    }

    fn holds(&self, patches: &Patches, p: usize) -> bool {
        let turn = || {
            let centre = patches.centre(p);
            centre.y.atan2(centre.x).rem_euclid(TAU) / TAU
        };
        self.face.is_none_or(|f| patches.face(p).face == f)
            && self
                .turns
                .is_none_or(|[from, to]| (from..to).contains(&turn()))
    }
}

/// Exchange areas between groups, with the variances of their estimates.
struct GroupExchange {
    areas: Vec<f64>,
    values: Vec<Vec<f64>>,
    variances: Vec<Vec<f64>>,
}

impl GroupExchange {
    fn new(
        groups: &[PatchGroup],
        patches: &Patches,
        two_sided: bool,
        factors: &FormFactors,
    ) -> GroupExchange {
        let rows: Vec<Vec<usize>> = groups.iter().map(|g| g.rows(patches, two_sided)).collect();
        let area = |rows: &Vec<usize>| rows.iter().map(|&i| factors.areas[i]).sum();
        let between = |g: usize| {
            let pair =
                move |h: usize, rows: &[Vec<usize>]| sum(&rows[g], &rows[h], g == h, factors);
            (0..rows.len()).map(|h| pair(h, &rows)).unzip()
        };
        let (values, variances) = (0..rows.len()).map(between).unzip();
        GroupExchange {
            areas: rows.iter().map(area).collect(),
            values,
            variances,
        }
    }

    fn factor(&self, g: usize, h: usize) -> Answer {
        Answer {
            value: self.values[g][h] / self.areas[g],
            error: self.variances[g][h].sqrt() / self.areas[g],
        }
    }

    /// B = M + ρ X B over the groups. Its error is the first-order effect of errors of S,
    /// independent from pair to pair: dB = (1 − ρX)⁻¹ ρ dX B.
    fn radiosity(&self, groups: &[EnclosureSurface], of: usize) -> Answer {
        let n = groups.len();
        let system = |transposed: bool| -> Vec<Vec<f64>> {
            let entry = |i: usize, j: usize| {
                let (i, j) = if transposed { (j, i) } else { (i, j) };
                f64::from(i == j) - groups[i].reflectance * self.values[i][j] / self.areas[i]
            };
            (0..n)
                .map(|i| (0..n).map(|j| entry(i, j)).collect())
                .collect()
        };
        let b = solve(system(false), groups.iter().map(|g| g.exitance).collect());
        // One row of the inverse: how much each group's light contributes to the group in question.
        let importance = solve(system(true), (0..n).map(|i| f64::from(i == of)).collect());
        let gain =
            |g: usize, h: usize| importance[g] * groups[g].reflectance * b[h] / self.areas[g];
        let mut variance = 0.0;
        for g in 0..n {
            variance += gain(g, g).powi(2) * self.variances[g][g];
            for h in 0..g {
                variance += (gain(g, h) + gain(h, g)).powi(2) * self.variances[g][h];
            }
        }
        Answer {
            value: b[of],
            error: variance.sqrt(),
        }
    }
}

/// Exchange area between two lists of rows, and its variance. Within one list every pair occurs
/// twice, but was estimated once.
fn sum(from: &[usize], to: &[usize], same: bool, factors: &FormFactors) -> (f64, f64) {
    let (mut value, mut variance) = (0.0, 0.0);
    for &i in from {
        for &j in to {
            let (x, error) = factors.get(i, j as u32);
            let times = if same && i != j { 2.0 } else { 1.0 };
            value += factors.areas[i] * x;
            variance += times * (factors.areas[i] * f64::from(error)).powi(2);
        }
    }
    (value, variance)
}

/// Solves a small system by Gaussian elimination with pivoting.
fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for k in 0..n {
        let largest = (k..n).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs()));
        let pivot = largest.unwrap_or(k);
        a.swap(k, pivot);
        b.swap(k, pivot);
        let (row, right) = (a[k].clone(), b[k]);
        for i in k + 1..n {
            let factor = a[i][k] / row[k];
            a[i].iter_mut()
                .zip(&row)
                .for_each(|(x, r)| *x -= factor * r);
            b[i] -= factor * right;
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| a[k][j] * b[j]).sum();
        b[k] = (b[k] - known) / a[k][k];
    }
    b
}

#[cfg(test)]
mod tests {
    #[test]
    fn small_systems_are_solved() {
        let x = super::solve(vec![vec![0.0, 2.0], vec![4.0, 1.0]], vec![6.0, 11.0]);
        assert_eq!(x, [2.0, 3.0]);
    }
}
