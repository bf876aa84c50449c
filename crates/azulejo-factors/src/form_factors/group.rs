//! The matrix between groups of rows.

use super::matrix::{FormFactors, RowRemainder};
use crate::exchange_areas::{Exchange, ExchangeAreas, union};
use crate::patch::FaceId;
use rayon::prelude::*;

impl FormFactors {
    /// The matrix between groups of rows: row i belongs to group `groups[i]`, a number below
    /// `count`, or to none. X_ab = Σ_i∈a Σ_j∈b A_i X_ij / Σ_i∈a A_i, so that reciprocity holds as
    /// between patches. Rows without a group are dropped, and what they receive counts as
    /// [`hidden`](RowRemainder::hidden).
    ///
    /// Standard errors are added as of independent estimates, times the [design
    /// effect](FormFactors::design_effect) of hemicubes. Entries of one row of rays are
    /// anticorrelated, so these errors are overestimated. `ends` is an average by area, which is
    /// exact where a group has one material. Groups without rows have no area and see nothing.
    ///
    /// # Panics
    /// If `groups` has another length than the matrix, or numbers from `count` on.
    pub fn grouped(&self, groups: &[Option<u32>], count: usize) -> FormFactors {
        assert_eq!(groups.len(), self.len(), "one group for each row");
        let grouping = Grouping::new(self, groups, count);
        let orders: Vec<ExchangeAreas> = self.orders.iter().map(|o| grouping.exchange(o)).collect();
        let exchange = if orders.is_empty() {
            grouping.exchange(&self.exchange)
        } else {
            ExchangeAreas::sum_of(&orders)
        };
        FormFactors {
            orders,
            ..grouping.finish(exchange, &grouping.to_nobody())
        }
    }

    /// The same where the matrix is elsewhere: `exchange` is that between groups, and `to_nobody` Σ_j S_ij
    /// `ends`_j of each row i over the rows j without a group.
    pub(crate) fn grouped_as(
        &self,
        groups: &[Option<u32>],
        exchange: ExchangeAreas,
        to_nobody: &[f64],
    ) -> FormFactors {
        Grouping::new(self, groups, exchange.len()).finish(exchange, to_nobody)
    }
}

/// The face of a group without rows.
const NO_FACE: FaceId = FaceId { object: 0, face: 0 };

/// The group of each row, and the rows of each group.
struct Grouping<'a> {
    factors: &'a FormFactors,
    groups: &'a [Option<u32>],
    /// The rows of each group, ascending.
    members: Vec<Vec<usize>>,
}

/// A row of sums over groups, reused to save allocations.
struct GroupSums {
    /// S and variance by group.
    sums: Vec<[f64; 2]>,
    /// Groups with a sum.
    touched: Vec<u32>,
}

impl<'a> Grouping<'a> {
    fn new(factors: &'a FormFactors, groups: &'a [Option<u32>], count: usize) -> Grouping<'a> {
        let mut members = vec![Vec::new(); count];
        for (i, group) in groups.iter().enumerate() {
            if let Some(group) = group {
                members[*group as usize].push(i);
            }
        }
        Grouping {
            factors,
            groups,
            members,
        }
    }

    /// A value of each group from its rows.
    fn each<T>(&self, value: impl Fn(&[usize]) -> T) -> Vec<T> {
        self.members.iter().map(|m| value(m)).collect()
    }

    /// The area of some rows.
    fn area(&self, members: &[usize]) -> f64 {
        members.iter().map(|&i| self.factors.areas[i]).sum()
    }

    /// Mean over rows, weighted by area; 0 without rows.
    fn mean(&self, members: &[usize], value: impl Fn(usize) -> f64) -> f64 {
        let areas = &self.factors.areas;
        let sum: f64 = members.iter().map(|&i| areas[i] * value(i)).sum();
        let whole = self.area(members);
        if whole > 0.0 { sum / whole } else { 0.0 }
    }

    /// Standard error of that mean.
    fn error(&self, members: &[usize], error: impl Fn(usize) -> f64) -> f64 {
        let areas = &self.factors.areas;
        let squares = members.iter().map(|&i| (areas[i] * error(i)).powi(2));
        let (sum, whole) = (squares.sum::<f64>().sqrt(), self.area(members));
        if whole > 0.0 { sum / whole } else { 0.0 }
    }

    /// All that is known of groups with these exchange areas.
    fn finish(&self, exchange: ExchangeAreas, to_nobody: &[f64]) -> FormFactors {
        let (rows, count) = (self.factors, self.members.len());
        let mut grouped = FormFactors {
            exchange,
            areas: self.each(|m| self.area(m)),
            faces: self.each(|m| m.first().map_or(NO_FACE, |&i| rows.faces[i])),
            materials: self.each(|m| m.first().map_or(0, |&i| rows.materials[i])),
            is_back: self.each(|m| m.first().is_some_and(|&i| rows.is_back[i])),
            rest: self.rest(to_nobody),
            ends: self.each(|m| self.mean(m, |i| rows.ends[i])),
            // Sums over many pairs miss little, and no more than their errors.
            unseen: vec![0.0; if rows.unseen.is_empty() { 0 } else { count }],
            is_closed: rows.is_closed,
            closed: rows.closed,
            truncated: rows.truncated,
            rays: rows.rays,
            engine_used: rows.engine_used.clone(),
            ..FormFactors::default()
        };
        grouped.update_row_errors();
        grouped
    }

    /// What each row sends to rows without a group, times its area.
    fn to_nobody(&self) -> Vec<f64> {
        let ends = &self.factors.ends;
        self.factors.exchange.sums(|i, e| {
            let j = e.column as usize;
            let received = |by: usize| match self.groups[by] {
                None => e.value * ends[by],
                Some(_) => 0.0,
            };
            [received(j), received(i)]
        })
    }

    fn rest(&self, to_nobody: &[f64]) -> Vec<RowRemainder> {
        let rest = &self.factors.rest;
        self.each(|m| RowRemainder {
            sky: self.mean(m, |i| rest[i].sky),
            sky_error: self.error(m, |i| rest[i].sky_error),
            ground: self.mean(m, |i| rest[i].ground),
            ground_error: self.error(m, |i| rest[i].ground_error),
            hidden: self.mean(m, |i| rest[i].hidden + to_nobody[i] / self.factors.areas[i]),
            hidden_error: self.error(m, |i| rest[i].hidden_error),
            cut: self.mean(m, |i| rest[i].cut),
            lost: self.mean(m, |i| rest[i].lost),
        })
    }

    /// Exchange areas between groups.
    ///
    /// Each pair of patches is added in the group of its first patch; the pairs between two groups
    /// are therefore split over both.
    fn exchange(&self, areas: &ExchangeAreas) -> ExchangeAreas {
        let count = self.members.len();
        let new = || GroupSums {
            sums: vec![[0.0; 2]; count],
            touched: Vec::new(),
        };
        let sums: Vec<Vec<(u32, [f64; 2])>> = (0..count)
            .into_par_iter()
            .map_init(new, |sums, group| {
                self.add_up(areas, group as u32, sums);
                sums.take()
            })
            .collect();
        let mut below = vec![Vec::new(); count];
        for (a, row) in sums.iter().enumerate() {
            for &(b, sum) in row.iter().take_while(|(b, _)| (*b as usize) < a) {
                below[b as usize].push((a as u32, sum));
            }
        }
        let row = |a: usize| {
            let mut row = Vec::new();
            let above = sums[a].partition_point(|&(b, _)| (b as usize) < a);
            union(&sums[a][above..], &below[a], key, key, |column, x, y| {
                let [x, y] = [x, y].map(|sum| sum.map_or([0.0; 2], |s| s.1));
                row.push(Exchange {
                    column,
                    value: x[0] + y[0],
                    error: (x[1] + y[1]).sqrt() as f32,
                });
            });
            row
        };
        (0..count).map(row).collect()
    }

    /// Adds up the pairs whose first patch belongs to `group`.
    fn add_up(&self, areas: &ExchangeAreas, group: u32, sums: &mut GroupSums) {
        for &i in &self.members[group as usize] {
            for e in areas.upper(i) {
                let j = e.column as usize;
                let Some(other) = self.groups[j] else {
                    continue;
                };
                // Within a group the light of such a pair counts in both directions.
                let ways = if other == group && i != j { 2.0 } else { 1.0 };
                let error = ways * f64::from(e.error) * self.widening(i, j);
                sums.add(other, ways * e.value, error);
            }
        }
    }

    /// The factor for the error of an entry in a sum.
    fn widening(&self, i: usize, j: usize) -> f64 {
        let (faces, design_effect) = (&self.factors.faces, &self.factors.design_effect);
        if design_effect.is_empty() {
            return 1.0;
        }
        design_effect.effect(faces[i], faces[j]).sqrt()
    }
}

fn key<T>(&(column, _): &(u32, T)) -> u32 {
    column
}

impl GroupSums {
    fn add(&mut self, group: u32, value: f64, error: f64) {
        let [sum, variance] = &mut self.sums[group as usize];
        // An entry without value and error does not count.
        if *sum == 0.0 && *variance == 0.0 {
            self.touched.push(group);
        }
        *sum += value;
        *variance += error * error;
    }

    /// The sums by group, ascending; resets them to zero.
    fn take(&mut self) -> Vec<(u32, [f64; 2])> {
        self.touched.sort_unstable();
        self.touched.dedup();
        let sums = &mut self.sums;
        let take = |group: u32| (group, std::mem::take(&mut sums[group as usize]));
        self.touched.drain(..).map(take).collect()
    }
}
