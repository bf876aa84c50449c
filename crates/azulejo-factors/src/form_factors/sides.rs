//! Which sides of patches are rows and columns.

use super::boxes::{BoxTree, distance};
use crate::patch::Patches;
use crate::row::{Side, side};
use azulejo_scene::math::Aabb;
use azulejo_trace::Tracer;
use rayon::prelude::*;

/// Relative difference of corners up to which two patches back to back count as one wall.
const COVERS: f64 = 1e-5;

/// Least width of a patch, in steps of its rays off the surface.
const LEAST_WIDTH: f64 = 16.0;

/// Width of a patch, in steps of its rays off the surface, below which a note mentions it.
const NARROW: f64 = 100.0;

/// No patch covers the back of this one.
const NO_TWIN: u32 = u32::MAX;

/// The rows, which are also the columns.
pub(super) struct Sides<'a> {
    pub patches: &'a Patches,
    two_sided: bool,
    /// For each patch the one that coincides with it and faces the other way: rays cannot tell
    /// which of them they hit.
    twins: Vec<u32>,
}

impl<'a> Sides<'a> {
    pub fn new(patches: &'a Patches, two_sided: bool) -> Sides<'a> {
        let twins = if two_sided {
            Vec::new()
        } else {
            twins(patches)
        };
        Sides {
            patches,
            two_sided,
            twins,
        }
    }

    pub fn len(&self) -> usize {
        self.patches.len() * if self.two_sided { 2 } else { 1 }
    }

    pub fn patch(&self, row: usize) -> usize {
        if self.two_sided { row / 2 } else { row }
    }

    pub fn is_back(&self, row: usize) -> bool {
        self.two_sided && row % 2 == 1
    }

    /// The factor of the front's normal that gives the row's own.
    pub fn flip(&self, row: usize) -> f64 {
        if self.is_back(row) { -1.0 } else { 1.0 }
    }

    /// The side that the estimators know this row by.
    pub fn side(&self, row: usize) -> Side {
        side(self.patch(row) as u32, !self.is_back(row))
    }

    pub fn area(&self, row: usize) -> f64 {
        self.patches.area(self.patch(row))
    }

    /// The step that rays make off the surface of a row before they start, and how many of them go into the width
    /// of its patch. Curved patches have no step.
    pub fn leaving(&self, row: usize, tracer: &Tracer) -> (f64, f64) {
        let (patches, patch) = (self.patches, self.patch(row));
        let centre = patches.centre(patch);
        let step = tracer
            .leaving(centre, patches.normal(patch))
            .distance(centre);
        (step, patches.area(patch) / patches.diameter(patch) / step)
    }

    /// Whether a row is too narrow for rays: some start beside it, behind the walls that it touches.
    pub fn is_too_narrow(&self, row: usize, tracer: &Tracer) -> bool {
        self.leaving(row, tracer).1 < LEAST_WIDTH
    }

    /// A note of rows that are so narrow in their scene that it matters where rays and hemicubes start.
    pub fn narrow_note(&self, tracer: &Tracer) -> Option<String> {
        let rows = (0..self.len()).map(|row| self.leaving(row, tracer));
        let narrow: Vec<_> = rows.filter(|row| row.1 > 0.0 && row.1 < NARROW).collect();
        let step = narrow.iter().map(|row| row.0).fold(0.0, f64::max);
        (!narrow.is_empty()).then(|| {
            format!(
                "{} rows are less than {NARROW} times as wide as the distance of {step:.1e} at which rays start \
                 off surfaces in a scene of this size: they see what is close less exactly than their errors say",
                narrow.len()
            )
        })
    }

    /// The column of light that hits a patch, if it has one.
    pub fn column(&self, patch: u32, front: bool) -> Option<u32> {
        match (self.two_sided, front) {
            (true, _) => Some(side(patch, front)),
            (false, true) => Some(patch),
            (false, false) => Some(self.twins[patch as usize]).filter(|&twin| twin != NO_TWIN),
        }
    }
}

/// The patch that covers the back of each.
fn twins(patches: &Patches) -> Vec<u32> {
    let centres: Vec<_> = (0..patches.len()).map(|i| patches.centre(i)).collect();
    let points: Vec<Aabb> = centres.iter().map(|&c| Aabb::around([c])).collect();
    let tree = BoxTree::new(&points);
    let twin = |i: usize| {
        let reach = COVERS * patches.diameter(i);
        let mut twin = NO_TWIN;
        tree.any(
            |bounds| distance(bounds, centres[i]) <= reach,
            |j| {
                if covers(patches, i, j as usize, reach) {
                    twin = twin.min(j);
                }
                false
            },
        );
        twin
    };
    (0..patches.len()).into_par_iter().map(twin).collect()
}

/// Whether patch `j` has the corners of patch `i` in reverse order.
fn covers(patches: &Patches, i: usize, j: usize, reach: f64) -> bool {
    let (Some(a), Some(b)) = (patches.polygon(i), patches.polygon(j)) else {
        return false;
    };
    let meets = |p: &glam::DVec3| b.iter().any(|q| p.distance(*q) <= reach);
    a.len() == b.len() && patches.normal(i).dot(patches.normal(j)) < 0.0 && a.iter().all(meets)
}
