//! Point-in-solid tests.

use crate::tree::TriangleTree;
use crate::{Exact, Operation, PrimitiveKind, Solid};
use glam::DVec3;

/// Chord error of the polygons that approximate the pieces of a shell, relative to its size.
const SHELL_ERROR: f64 = 1e-4;

impl Solid {
    /// Whether a point is inside.
    ///
    /// Exact for primitives and prisms; for meshes by parity; shells are approximated by polygons
    /// that deviate by 1e-4 of their size. Open surfaces have no inside. Search structures for
    /// meshes and shells are rebuilt for each point.
    pub fn contains(&self, point: DVec3) -> bool {
        let in_any = |side: &[Solid]| side.iter().any(|s| s.contains(point));
        match self {
            Solid::Primitive(p) => {
                let local = p.world_from_object.inverse().transform_point3(point);
                p.kind.contains(local)
            }
            Solid::Prism(p) => p.contains(point),
            Solid::Patch(_) => false,
            Solid::Mesh(mesh) => TriangleTree::new(mesh).contains(point),
            Solid::Shell(pieces) => {
                let pieces = Exact::new(pieces.clone());
                let error = SHELL_ERROR * pieces.bounds().diagonal();
                TriangleTree::new(&pieces.tessellate(error)).contains(point)
            }
            Solid::Csg(csg) => csg
                .operation
                .is_inside(in_any(&csg.left), || in_any(&csg.right)),
        }
    }
}

impl Operation {
    /// Whether a point is inside the result, given whether it is inside each operand.
    pub(crate) fn is_inside(self, left: bool, right: impl FnOnce() -> bool) -> bool {
        match self {
            Operation::Union => left || right(),
            Operation::Difference => left && !right(),
            Operation::Intersection => left && right(),
        }
    }
}

impl PrimitiveKind {
    /// Whether an object-space point is inside; never for the open kinds.
    fn contains(self, p: DVec3) -> bool {
        let within = |x: f64| (0.0..=1.0).contains(&x);
        let radius2 = p.x * p.x + p.y * p.y;
        match self {
            PrimitiveKind::Sphere => p.length_squared() <= 1.0,
            PrimitiveKind::Cylinder => within(p.z) && radius2 <= 1.0,
            PrimitiveKind::Cone { top } => {
                let radius = 1.0 + (top - 1.0) * p.z;
                within(p.z) && radius2 <= radius * radius
            }
            PrimitiveKind::Cuboid => within(p.x) && within(p.y) && within(p.z),
            PrimitiveKind::Square | PrimitiveKind::Tube { .. } => false,
        }
    }
}
