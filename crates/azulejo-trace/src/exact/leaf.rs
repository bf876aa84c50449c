//! A leaf of an exact shape: a solid that is not a compound.

use super::line::Line3;
use super::mesh::ExactMesh;
use super::patch::ExactPatch;
use super::primitive::ExactPrimitive;
use super::prism::ExactPrism;
use azulejo_scene::math::normal_matrix;
use glam::{DMat3, DVec3};

/// A closed range of parameters along a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Span {
    pub first: f64,
    pub last: f64,
}

impl Span {
    pub(crate) const EVERYWHERE: Span = Span {
        first: f64::NEG_INFINITY,
        last: f64::INFINITY,
    };

    /// The intersection; `None` if it is empty.
    #[inline(always)]
    pub(crate) fn and(self, other: Span) -> Option<Span> {
        let both = Span {
            first: self.first.max(other.first),
            last: self.last.min(other.last),
        };
        (both.first <= both.last).then_some(both)
    }

    pub(crate) fn holds(self, t: f64) -> bool {
        self.first <= t && t <= self.last
    }
}

/// A hit of a line on the surface of a leaf.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LeafHit {
    pub t: f64,
    /// Which part of the surface: a plane or curve of a prism, a triangle, the part of a
    /// primitive. Less than 2^30.
    pub part: u32,
    /// Position on the part, as far as it is needed to compute the point again.
    pub parameter: f32,
    /// Whether the line enters here; for an open surface, whether it hits the front.
    pub enters: bool,
}

/// A hit with one of several leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Boundary {
    pub hit: LeafHit,
    pub leaf: u32,
}

/// The surface point of a [`LeafHit`], computed again.
pub(crate) struct LeafPoint {
    pub t: f64,
    pub u: f64,
    pub v: f64,
    /// In the coordinates of the line.
    pub position: DVec3,
    /// Unit normal of the outside.
    pub normal: DVec3,
}

/// A shape prepared for rays in the tracer's own coordinates.
#[derive(Clone, Debug)]
pub(crate) enum ExactLeaf {
    Primitive(Box<ExactPrimitive>),
    Prism(ExactPrism),
    Patch(ExactPatch),
    Mesh(ExactMesh),
    /// A shape that no ray can hit, because its map cannot be inverted in double precision.
    Nothing,
}

impl ExactLeaf {
    /// The first hit within `span`.
    #[inline]
    pub(crate) fn first(&self, line: &Line3, span: Span) -> Option<LeafHit> {
        match self {
            ExactLeaf::Prism(prism) => prism.first(line, span),
            _ => self.first_of_all(line, span),
        }
    }

    /// Whether there is any hit within `span`.
    #[inline]
    pub(crate) fn any(&self, line: &Line3, span: Span) -> bool {
        match self {
            ExactLeaf::Prism(prism) => prism.any(line, span),
            _ => self.first_of_all(line, span).is_some(),
        }
    }

    fn first_of_all(&self, line: &Line3, span: Span) -> Option<LeafHit> {
        let mut all = Vec::new();
        self.all(line, 0, &mut all);
        let hits = all.iter().map(|b| b.hit);
        hits.filter(|m| span.holds(m.t))
            .reduce(|a, b| if b.t < a.t { b } else { a })
    }

    /// All hits on the line. Those with a closed shape are in order, alternately entering and
    /// leaving.
    pub(crate) fn all(&self, line: &Line3, leaf: u32, out: &mut Vec<Boundary>) {
        match self {
            ExactLeaf::Primitive(p) => {
                let hits = p.hits(line).into_iter().flatten();
                out.extend(hits.map(|hit| Boundary { hit, leaf }));
            }
            ExactLeaf::Prism(prism) => prism.all(line, leaf, out),
            ExactLeaf::Patch(patch) => patch.all(line, leaf, out),
            ExactLeaf::Mesh(mesh) => mesh.all(line, leaf, out),
            ExactLeaf::Nothing => {}
        }
    }

    /// The part that is reported for a hit.
    pub(crate) fn part(&self, hit: &LeafHit) -> u32 {
        match self {
            ExactLeaf::Prism(_) | ExactLeaf::Mesh(_) => hit.part,
            ExactLeaf::Primitive(_) | ExactLeaf::Patch(_) | ExactLeaf::Nothing => 0,
        }
    }

    /// The surface point of a hit on or, by rounding, near the line.
    pub(crate) fn resolve(&self, line: &Line3, hit: &LeafHit) -> LeafPoint {
        match self {
            ExactLeaf::Primitive(p) => p.resolve(line, hit),
            ExactLeaf::Prism(prism) => prism.resolve(line, hit),
            ExactLeaf::Patch(patch) => patch.resolve(line, hit),
            ExactLeaf::Mesh(mesh) => mesh.resolve(line, hit),
            ExactLeaf::Nothing => LeafPoint {
                t: hit.t,
                u: 0.0,
                v: 0.0,
                position: line.origin + hit.t * line.direction,
                normal: DVec3::ZERO,
            },
        }
    }
}

/// An outward normal, transformed by a map.
pub(crate) fn outward(map: DMat3, normal: DVec3) -> DVec3 {
    (normal_matrix(map) * normal).normalize_or_zero()
}

/// `normal` or its opposite: the side from which a line in `direction` arrives if it `enters`.
pub(crate) fn facing(normal: DVec3, direction: DVec3, enters: bool) -> DVec3 {
    if (normal.dot(direction) < 0.0) == enters {
        normal
    } else {
        -normal
    }
}
