//! View3D's requirements on surfaces.

use super::document::{SurfaceKind, View3dDocument, View3dSurface};
use super::lines::View3dLines;
use crate::ReadError;
use crate::surface::mean_plane::{MeanPlane, edges, is_convex};
use glam::DVec3;

/// Maximum distance of corners from their mean plane, relative to the radius; beyond it, the
/// surface is rejected.
const LARGEST_BEND: f64 = 3e-5;
/// The distance beyond which a warning is given.
const NOTED_BEND: f64 = 3e-6;
/// Maximum distance of a surface from its base's plane and outline, relative to the base's size.
const TOLERANCE: f64 = 1e-5;
/// The cosine of the largest angle between a surface and its base.
const PARALLEL: f64 = 0.999;

/// Positions of the fields that can only be checked at the end.
#[derive(Default)]
pub(super) struct View3dChecker {
    /// Base and combination of each surface with these fields: all but obstructions, which come
    /// last.
    pub fields: Vec<[usize; 2]>,
}

type CheckResult = Result<(), ReadError>;

impl View3dChecker {
    /// Checks that an outline is flat, convex, and has an area.
    pub fn outline(
        &self,
        document: &View3dDocument,
        index: usize,
        at: usize,
        lines: &View3dLines,
    ) -> CheckResult {
        let corners = document.corners(&document.surfaces[index]);
        let number = index + 1;
        let refuse = |found: &str, expected: &str| {
            let found = format!("surface {number}, {found}");
            Err(lines.error(at, found, expected))
        };
        let plane = MeanPlane::of(&corners);
        if !corners.iter().all(|p| p.is_finite()) || !plane.radius.is_finite() {
            return refuse("which is too large", "coordinates below 1e150");
        }
        let has_area = plane.area > 1e-12 * plane.radius * plane.radius;
        if !has_area {
            return refuse("which has no area", "corners that are not collinear");
        }
        if plane.bend(&corners) > LARGEST_BEND {
            return refuse("which is not flat", "four coplanar corners, or triangles");
        }
        if !is_convex(&corners, plane.normal) {
            return refuse(
                "which is not convex",
                "convex surfaces: divide it and combine the parts",
            );
        }
        Ok(())
    }

    /// The warning about a surface that is not quite flat.
    pub fn bend(&self, document: &View3dDocument, index: usize) -> Option<&'static str> {
        let corners = document.corners(&document.surfaces[index]);
        let is_bent = MeanPlane::of(&corners).bend(&corners) > NOTED_BEND;
        is_bent.then_some("surfaces that are not quite flat")
    }

    /// Checks bases and combinations of all surfaces.
    pub fn all(&self, document: &View3dDocument, lines: &View3dLines) -> CheckResult {
        for (index, &[at_base, at_combined]) in self.fields.iter().enumerate() {
            let surface = &document.surfaces[index];
            base(document, index, surface)
                .and_then(|()| within(document, surface))
                .map_err(|(found, expected)| lines.error(at_base, found, expected))?;
            combination(document, index, surface)
                .map_err(|(found, expected)| lines.error(at_combined, found, expected))?;
        }
        Ok(())
    }
}

/// What was found and what was expected.
type Mismatch = (String, String);

fn refused(found: impl Into<String>, expected: impl Into<String>) -> Result<(), Mismatch> {
    Err((found.into(), expected.into()))
}

fn base(document: &View3dDocument, index: usize, surface: &View3dSurface) -> Result<(), Mismatch> {
    use SurfaceKind::*;
    let base = surface.base as usize;
    if base == 0 {
        return match surface.kind {
            Mask | Null => refused("no base", "the number of the surface that it covers"),
            Radiating | Obstruction => Ok(()),
        };
    }
    let Some(held_by) = document.surfaces.get(base - 1) else {
        let last = document.surfaces.len();
        return refused(
            format!("base {base}"),
            format!("one of the {last} surfaces"),
        );
    };
    match (surface.kind, held_by.kind) {
        (Radiating, Obstruction) => Ok(()),
        (_, Radiating) if base <= index => Ok(()),
        (_, Radiating) => refused(
            format!("base {base} of surface {}", index + 1),
            "a base with a smaller number",
        ),
        (Radiating, _) => refused("a mask for a base", "a radiating surface or an obstruction"),
        _ => refused(
            "a base that does not radiate",
            "the number of a radiating surface",
        ),
    }
}

/// Whether a surface lies in its base, and faces the right way.
fn within(document: &View3dDocument, surface: &View3dSurface) -> Result<(), Mismatch> {
    if surface.base == 0 {
        return Ok(());
    }
    // Distances are measured relative to the size of the base.
    let number = surface.base;
    let outer = document.corners(&document.surfaces[number as usize - 1]);
    let inner = document.corners(surface);
    let (plane, own) = (MeanPlane::of(&outer), MeanPlane::of(&inner));
    let size = 2.0 * plane.radius;
    // A part of a wall faces as the wall does; a mask faces the surface that it covers.
    let same_way = surface.kind == SurfaceKind::Radiating;
    let cosine = plane.normal.dot(own.normal) * if same_way { 1.0 } else { -1.0 };
    if cosine < PARALLEL {
        let found = format!("a surface that does not face like base {number}");
        let expected = if same_way {
            "one that faces the same way: reverse its vertices"
        } else {
            "one that faces its base: reverse its vertices"
        };
        return refused(found, expected);
    }
    if inner
        .iter()
        .any(|&p| plane.height(p).abs() > TOLERANCE * size)
    {
        return refused(
            format!("a surface outside the plane of base {number}"),
            "one in that plane",
        );
    }
    // Bases are convex: a point is inside if it is on the inner side of every edge.
    let is_inside = |&p: &DVec3| {
        edges(&outer).all(|(a, b)| {
            let inward = plane.normal.cross(b - a).normalize_or_zero();
            inward.dot(p - a) > -TOLERANCE * size
        })
    };
    if inner.iter().all(is_inside) {
        Ok(())
    } else {
        refused(
            format!("a surface that extends beyond base {number}"),
            "one that lies within it",
        )
    }
}

fn combination(
    document: &View3dDocument,
    index: usize,
    surface: &View3dSurface,
) -> Result<(), Mismatch> {
    let first = surface.combined as usize;
    if first == 0 {
        return Ok(());
    }
    if surface.kind != SurfaceKind::Radiating {
        return refused("a mask that is combined", "0: only radiating surfaces are");
    }
    let Some(other) = document.surfaces[..index].get(first - 1) else {
        return refused(
            format!("surface {first}"),
            "an earlier surface to combine with",
        );
    };
    match (other.kind, other.combined) {
        (SurfaceKind::Radiating, 0) => Ok(()),
        (SurfaceKind::Radiating, root) => refused(
            format!("surface {first}, which itself is part of {root}"),
            format!("{root}: all parts refer to the first one"),
        ),
        _ => refused(
            format!("surface {first}, which does not radiate"),
            "one that radiates",
        ),
    }
}
