//! How much the errors of entries that belong together have in common.
//!
//! A hemicube shows all of a wall's pieces from one point: where that sees more of the wall, it
//! sees more of every piece. Errors of such entries must not be added up as if they were
//! independent, or the sum is believed too much. How far they go together is learned from the
//! replicates: the variance of the sum over a face or object, over the sum of the variances of
//! its pieces, is the design effect of survey statistics (Kish, *Survey Sampling*, 1965, chapter
//! 5), by which the variances of the pieces are multiplied before they are added up.

use super::journal::{Reader, write_list};
use super::rows::Column;
use super::sides::Sides;
use super::spread::mean_and_variance;
use crate::patch::FaceId;
use azulejo_trace::REPLICATES;
use std::collections::HashMap;
use std::hash::Hash;

/// What one row's entries to the pieces of a face or object have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Group {
    /// One of its columns.
    column: u32,
    /// Whether these are all columns of an object, not of one of its faces.
    is_object: bool,
    /// Variance of the sum.
    together: f64,
    /// Sum of the variances.
    alone: f64,
}

/// The groups of more than one column among some entries of a row.
pub(super) fn groups(columns: &[Column], sides: &Sides) -> Vec<Group> {
    let face = |&(column, _): &Column| face_of(sides, column);
    let mut groups = Vec::new();
    for object in columns.chunk_by(|a, b| face(a).object == face(b).object) {
        let faces = object.chunk_by(|a, b| face(a) == face(b));
        let faces = faces.filter(|face| face.len() < object.len());
        let all = std::iter::once(object).chain(faces);
        let several = all.filter(|group| group.len() > 1);
        groups.extend(several.map(|group| Group::new(group, group.len() == object.len())));
    }
    groups
}

fn face_of(sides: &Sides, column: u32) -> FaceId {
    sides.patches.face(sides.patch(column as usize))
}

impl Group {
    fn new(columns: &[Column], is_object: bool) -> Group {
        let (mut sums, mut alone) = ([0.0; REPLICATES], 0.0);
        for &(_, values) in columns {
            alone += mean_and_variance(values).1;
            (0..REPLICATES).for_each(|r| sums[r] += values[r]);
        }
        Group {
            column: columns[0].0,
            is_object,
            together: mean_and_variance(sums).1,
            alone,
        }
    }
}

/// Appends the bytes of groups, for the journal.
pub(super) fn write(groups: &[Group], bytes: &mut Vec<u8>) {
    write_list(groups, bytes, |g, bytes| {
        bytes.extend(g.column.to_le_bytes());
        bytes.extend(u32::from(g.is_object).to_le_bytes());
        bytes.extend(g.together.to_le_bytes());
        bytes.extend(g.alone.to_le_bytes());
    });
}

/// Reads back what [`write`] wrote.
pub(super) fn read(bytes: &mut Reader) -> Option<Vec<Group>> {
    bytes.list(|b| {
        Some(Group {
            column: b.u32()?,
            is_object: b.u32()? != 0,
            together: b.f64()?,
            alone: b.f64()?,
        })
    })
}

/// By how much the errors of entries between the pieces of two faces, or of two objects, are to
/// be widened where they are added up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Kinship {
    faces: Effects<FaceId>,
    objects: Effects<u32>,
}

/// Variances together and alone, by pair, the smaller first.
type Effects<T> = HashMap<(T, T), [f64; 2]>;

impl Kinship {
    /// Whether errors are as good as independent.
    pub(super) fn is_empty(&self) -> bool {
        self.faces.is_empty() && self.objects.is_empty()
    }

    /// Adds what row `i` tells.
    pub(super) fn add(&mut self, sides: &Sides, i: usize, groups: &[Group]) {
        let own = face_of(sides, i as u32);
        let weight = sides.area(i).powi(2);
        for g in groups {
            let other = face_of(sides, g.column);
            let sums = match g.is_object {
                true => entry(&mut self.objects, own.object, other.object),
                false => entry(&mut self.faces, own, other),
            };
            sums[0] += weight * g.together;
            sums[1] += weight * g.alone;
        }
    }

    /// What multiplies the variance of an entry between two faces in a sum, 1 or more.
    pub(super) fn effect(&self, a: FaceId, b: FaceId) -> f64 {
        let faces = effect(self.faces.get(&ordered(a, b)));
        let objects = effect(self.objects.get(&ordered(a.object, b.object)));
        faces.max(objects)
    }
}

fn entry<T: Ord + Hash>(effects: &mut Effects<T>, a: T, b: T) -> &mut [f64; 2] {
    effects.entry(ordered(a, b)).or_default()
}

fn ordered<T: Ord>(a: T, b: T) -> (T, T) {
    if a <= b { (a, b) } else { (b, a) }
}

fn effect(sums: Option<&[f64; 2]>) -> f64 {
    match sums {
        Some(&[together, alone]) if together > alone && alone > 0.0 => together / alone,
        _ => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(groups: &[&[Column]], expected: f64) {
        let mut sums = [0.0; 2];
        for group in groups.iter().map(|group| Group::new(group, true)) {
            sums[0] += group.together;
            sums[1] += group.alone;
        }
        let found = effect(Some(&sums));
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }

    #[test]
    fn errors_in_step_are_told_from_independent_ones() {
        let up = [1.0, -1.0, 1.0, -1.0];
        let across = [1.0, 1.0, -1.0, -1.0];
        check(&[&[(0, up), (1, up)]], 2.0);
        check(&[&[(0, up), (1, across)]], 1.0);
        check(&[&[(0, up), (1, up)], &[(2, up), (3, across)]], 1.5);
        // Against each other: added up as independent they are rather too large.
        check(&[&[(0, up), (1, up.map(|x| -x))]], 1.0);
        check(&[], 1.0);
    }
}
