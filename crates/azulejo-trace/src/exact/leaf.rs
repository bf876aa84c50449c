//! One exact shape that is not made of others, whatever its kind.

use super::mesh::ExactMesh;
use super::patch::ExactPatch;
use super::prism::ExactPrism;
use crate::primitive::{ExactPrimitive, Line};
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

    /// What is in both; `None` for nothing.
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

/// Where a line meets the surface of a leaf.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Meeting {
    pub t: f64,
    /// Which part of the surface: a plane or curve of a prism, a triangle, the part of a
    /// primitive. Less than 2^30.
    pub part: u32,
    /// Where on the part, as far as that must be known to find the place again.
    pub parameter: f32,
    /// Whether the line comes in here; for an open surface, whether it meets the front.
    pub enters: bool,
}

/// A meeting with one of several leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Boundary {
    pub meeting: Meeting,
    pub leaf: u32,
}

/// The surface point of a meeting, computed again.
pub(crate) struct ResolvedLeaf {
    pub t: f64,
    pub u: f64,
    pub v: f64,
    /// In the coordinates of the line that was asked about.
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
    /// What no ray can meet: a shape whose map does not invert in double precision.
    Nothing,
}

impl ExactLeaf {
    /// The first meeting within `span`.
    #[inline]
    pub(crate) fn first(&self, line: &Line, span: Span) -> Option<Meeting> {
        match self {
            ExactLeaf::Prism(prism) => prism.first(line, span),
            _ => self.first_of_all(line, span),
        }
    }

    /// Whether there is any meeting within `span`.
    #[inline]
    pub(crate) fn any(&self, line: &Line, span: Span) -> bool {
        self.first(line, span).is_some()
    }

    fn first_of_all(&self, line: &Line, span: Span) -> Option<Meeting> {
        let mut all = Vec::new();
        self.all(line, 0, &mut all);
        let meetings = all.iter().map(|b| b.meeting);
        meetings
            .filter(|m| span.holds(m.t))
            .reduce(|a, b| if b.t < a.t { b } else { a })
    }

    /// All meetings on the line. Those with a closed shape come in order, in and out by turns.
    pub(crate) fn all(&self, line: &Line, leaf: u32, out: &mut Vec<Boundary>) {
        match self {
            ExactLeaf::Primitive(p) => {
                let meetings = p.meetings(line).into_iter().flatten();
                out.extend(meetings.map(|meeting| Boundary { meeting, leaf }));
            }
            ExactLeaf::Prism(prism) => prism.all(line, leaf, out),
            ExactLeaf::Patch(patch) => patch.all(line, leaf, out),
            ExactLeaf::Mesh(mesh) => mesh.all(line, leaf, out),
            ExactLeaf::Nothing => {}
        }
    }

    /// The part that a meeting names, for whoever asks about the hit.
    pub(crate) fn part(&self, meeting: &Meeting) -> u32 {
        match self {
            ExactLeaf::Prism(_) | ExactLeaf::Mesh(_) => meeting.part,
            ExactLeaf::Primitive(_) | ExactLeaf::Patch(_) | ExactLeaf::Nothing => 0,
        }
    }

    /// The surface point of a meeting on or, by rounding, near the line.
    pub(crate) fn resolve(&self, line: &Line, meeting: &Meeting) -> ResolvedLeaf {
        match self {
            ExactLeaf::Primitive(p) => p.resolve_meeting(line, meeting),
            ExactLeaf::Prism(prism) => prism.resolve(line, meeting),
            ExactLeaf::Patch(patch) => patch.resolve(line, meeting),
            ExactLeaf::Mesh(mesh) => mesh.resolve(line, meeting),
            ExactLeaf::Nothing => ResolvedLeaf {
                t: meeting.t,
                u: 0.0,
                v: 0.0,
                position: line.origin + meeting.t * line.direction,
                normal: DVec3::ZERO,
            },
        }
    }
}

/// A normal of the outside, taken along by a map.
pub(crate) fn outward(map: DMat3, normal: DVec3) -> DVec3 {
    (normal_matrix(map) * normal).normalize_or_zero()
}

/// A normal or its opposite: the one that a line in `direction` meets from before if it `enters`.
pub(crate) fn facing(normal: DVec3, direction: DVec3, enters: bool) -> DVec3 {
    if (normal.dot(direction) < 0.0) == enters {
        normal
    } else {
        -normal
    }
}
