//! Correlation of the errors of entries from shared viewpoints.
//!
//! A hemicube shows all pieces of a wall from one point: if that sees more of the wall, it sees
//! more of every piece. Adding the errors of such entries as if they were independent would
//! underestimate the error of the sum. Their correlation is estimated from the replicates: the
//! variance of the sum over a face or object divided by the sum of the variances of its pieces is
//! the design effect of survey statistics (Kish, *Survey Sampling*, 1965, chapter 5). The variances
//! of the pieces are multiplied by it before they are added up.

use super::rows::Column;
use super::sides::Sides;
use super::spread::mean_and_variance;
use crate::patch::FaceId;
use azulejo_trace::REPLICATES;
use azulejo_trace::run::{Record, RecordReader};
use std::collections::HashMap;
use std::hash::Hash;

/// Correlation of one row's entries to the pieces of a face or object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ErrorGroup {
    /// One of its columns.
    column: u32,
    /// Whether these are the columns of a whole object, not of one of its faces.
    is_object: bool,
    /// Variance of the sum.
    variance_of_sum: f64,
    /// Sum of the variances.
    sum_of_variances: f64,
}

/// The groups of more than one column among the entries of a row.
pub(super) fn groups(columns: &[Column], sides: &Sides) -> Vec<ErrorGroup> {
    let face = |&(column, _): &Column| column_face(sides, column);
    let mut groups = Vec::new();
    for object in columns.chunk_by(|a, b| face(a).object == face(b).object) {
        let faces = object.chunk_by(|a, b| face(a) == face(b));
        let faces = faces.filter(|face| face.len() < object.len());
        let candidates = std::iter::once(object).chain(faces);
        let several = candidates.filter(|group| group.len() > 1);
        groups.extend(several.map(|group| ErrorGroup::new(group, group.len() == object.len())));
    }
    groups
}

fn column_face(sides: &Sides, column: u32) -> FaceId {
    sides.patches.face(sides.patch(column as usize))
}

impl ErrorGroup {
    fn new(columns: &[Column], is_object: bool) -> ErrorGroup {
        let (mut sums, mut sum_of_variances) = ([0.0; REPLICATES], 0.0);
        for &(_, values) in columns {
            sum_of_variances += mean_and_variance(values).1;
            (0..REPLICATES).for_each(|r| sums[r] += values[r]);
        }
        ErrorGroup {
            column: columns[0].0,
            is_object,
            variance_of_sum: mean_and_variance(sums).1,
            sum_of_variances,
        }
    }
}

impl Record for ErrorGroup {
    fn write(&self, bytes: &mut Vec<u8>) {
        (self.column, u32::from(self.is_object)).write(bytes);
        (self.variance_of_sum, self.sum_of_variances).write(bytes);
    }

    fn read(bytes: &mut RecordReader) -> Option<ErrorGroup> {
        Some(ErrorGroup {
            column: bytes.u32()?,
            is_object: bytes.u32()? != 0,
            variance_of_sum: bytes.f64()?,
            sum_of_variances: bytes.f64()?,
        })
    }
}

/// Design effects of sums of entries between two faces, or between two objects.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DesignEffect {
    faces: EffectSums<FaceId>,
    objects: EffectSums<u32>,
}

/// Variance of the sum and sum of the variances by pair, the smaller key first.
type EffectSums<T> = HashMap<(T, T), [f64; 2]>;

impl DesignEffect {
    /// Whether errors are independent.
    pub(super) fn is_empty(&self) -> bool {
        self.faces.is_empty() && self.objects.is_empty()
    }

    /// Adds the groups of row `i`.
    pub(super) fn add(&mut self, sides: &Sides, i: usize, groups: &[ErrorGroup]) {
        let own = column_face(sides, i as u32);
        let weight = sides.area(i).powi(2);
        for g in groups {
            let other = column_face(sides, g.column);
            let sums = if g.is_object {
                entry(&mut self.objects, own.object, other.object)
            } else {
                entry(&mut self.faces, own, other)
            };
            sums[0] += weight * g.variance_of_sum;
            sums[1] += weight * g.sum_of_variances;
        }
    }

    /// The factor, at least 1, for the variance of an entry between two faces in a sum.
    pub(super) fn effect(&self, a: FaceId, b: FaceId) -> f64 {
        let faces = effect(self.faces.get(&ordered(a, b)));
        let objects = effect(self.objects.get(&ordered(a.object, b.object)));
        faces.max(objects)
    }
}

fn entry<T: Ord + Hash>(effects: &mut EffectSums<T>, a: T, b: T) -> &mut [f64; 2] {
    effects.entry(ordered(a, b)).or_default()
}

fn ordered<T: Ord>(a: T, b: T) -> (T, T) {
    if a <= b { (a, b) } else { (b, a) }
}

fn effect(sums: Option<&[f64; 2]>) -> f64 {
    match sums {
        Some(&[variance_of_sum, sum_of_variances])
            if variance_of_sum > sum_of_variances && sum_of_variances > 0.0 =>
        {
            variance_of_sum / sum_of_variances
        }
        _ => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(groups: &[&[Column]], expected: f64) {
        let mut sums = [0.0; 2];
        for group in groups.iter().map(|group| ErrorGroup::new(group, true)) {
            sums[0] += group.variance_of_sum;
            sums[1] += group.sum_of_variances;
        }
        let factor = effect(Some(&sums));
        assert!((factor - expected).abs() < 1e-12, "{factor} {expected}");
    }

    #[test]
    fn errors_in_step_are_told_from_independent_ones() {
        let up = [1.0, -1.0, 1.0, -1.0];
        let across = [1.0, 1.0, -1.0, -1.0];
        check(&[&[(0, up), (1, up)]], 2.0);
        check(&[&[(0, up), (1, across)]], 1.0);
        check(&[&[(0, up), (1, up)], &[(2, up), (3, across)]], 1.5);
        // Anticorrelated: added up as independent, the error is overestimated.
        check(&[&[(0, up), (1, up.map(|x| -x))]], 1.0);
        check(&[], 1.0);
    }
}
