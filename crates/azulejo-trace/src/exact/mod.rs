//! Exact shapes: prisms, patches, meshes as solids, and the results of set operations on them.
//!
//! Everything here works in double precision in the tracer's own coordinates, in which the scene
//! lies in −1..=1; [`resolve`](PlacedExact::resolve) repeats it along the ray before rounding to
//! `f32`.

mod bevel;
mod csg;
mod leaf;
mod line;
mod mesh;
mod outline;
mod patch;
mod primitive;
mod prism;
mod triangle;

pub(crate) use line::Line3;
pub(crate) use primitive::ExactPrimitive;
pub(crate) use triangle::{crossing, point_on_triangle};

use crate::frame::LocalFrame;
use crate::hit::ResolvedPoint;
use crate::kernel::{KernelHit, KernelRay, SolidPart};
use azulejo_scene::figure::Rectangle;
use azulejo_scene::math::{Aabb, Ray};
use azulejo_scene::{Bevel, BicubicPatch, Figure, Mesh, Operation, Primitive, Prism, Solid};
use csg::{CsgNode, CsgNodeKind, Tree, TreeLeaf};
use glam::DAffine3;
use leaf::{Boundary, ExactLeaf, LeafHit, Span};
use prism::PrismSection;
use std::collections::HashMap;
use std::sync::Arc;

/// One solid of an exact shape, in the tracer.
#[derive(Clone, Debug)]
pub(crate) struct PlacedExact {
    pub object: u32,
    pub first_item: u32,
    /// The index of its first leaf among those of the object.
    pub first_leaf: u32,
    solid: ExactSolid,
}

#[derive(Clone, Debug)]
#[allow(
    clippy::large_enum_variant,
    reason = "nearly all are leaves, and the whole stands in a box of its own"
)]
enum ExactSolid {
    Leaf(ExactLeaf),
    Tree(Tree),
}

impl PlacedExact {
    pub(crate) fn closest(&self, ray: &KernelRay, hit: &mut KernelHit) {
        let line = Line3::of(ray);
        let span = Span {
            first: f64::from(ray.t_min.max(0.0)),
            last: f64::from(hit.t),
        };
        let Some(Boundary { hit: first, leaf }) = self.solid.first(&line, span) else {
            return;
        };
        let (t, item) = (first.t as f32, self.first_item + leaf);
        if hit.is_after(t, item) {
            let at = SolidPart {
                part: first.part,
                parameter: first.parameter,
                enters: first.enters,
            };
            *hit = KernelHit::on_solid(t, item, at);
        }
    }

    pub(crate) fn any(&self, ray: &KernelRay, t_max: f32) -> bool {
        let span = Span {
            first: f64::from(ray.t_min.max(0.0)),
            last: f64::from(t_max),
        };
        self.solid.any(&Line3::of(ray), span)
    }

    pub(crate) fn resolve(&self, frame: &LocalFrame, ray: &Ray, hit: &KernelHit) -> ResolvedPoint {
        let line = Line3 {
            origin: frame.point(ray.origin),
            direction: frame.vector(ray.direction),
        };
        let SolidPart {
            part,
            parameter,
            enters,
        } = hit.solid_part();
        let on_leaf = LeafHit {
            t: f64::from(hit.t),
            part,
            parameter,
            enters,
        };
        let (leaf, is_turned) = self.solid.leaf(hit.item - self.first_item);
        let at = leaf.resolve(&line, &on_leaf);
        ResolvedPoint {
            t: at.t,
            u: at.u,
            v: at.v,
            part: leaf.part(&on_leaf),
            position: frame.world_point(at.position),
            normal: if is_turned { -at.normal } else { at.normal },
        }
    }
}

impl ExactSolid {
    fn first(&self, line: &Line3, span: Span) -> Option<Boundary> {
        match self {
            ExactSolid::Leaf(leaf) => {
                let hit = leaf.first(line, span)?;
                Some(Boundary { hit, leaf: 0 })
            }
            ExactSolid::Tree(tree) => {
                let boundaries = tree.boundaries(line);
                boundaries.into_iter().find(|b| span.holds(b.hit.t))
            }
        }
    }

    fn any(&self, line: &Line3, span: Span) -> bool {
        match self {
            ExactSolid::Leaf(leaf) => leaf.any(line, span),
            ExactSolid::Tree(_) => self.first(line, span).is_some(),
        }
    }

    /// A leaf, and whether it is reversed.
    fn leaf(&self, leaf: u32) -> (&ExactLeaf, bool) {
        match self {
            ExactSolid::Leaf(leaf) => (leaf, false),
            ExactSolid::Tree(tree) => {
                let leaf = &tree.leaves[leaf as usize];
                (&leaf.shape, leaf.is_turned)
            }
        }
    }
}

/// Figures prepared for rays, each once with each of its bevels, shared by its prisms.
#[derive(Default)]
pub(crate) struct Outlines {
    bounds: HashMap<*const Figure, Rectangle>,
    sections: HashMap<SectionKey, Arc<PrismSection>>,
}

/// A figure, and the bevel of a prism over it.
type SectionKey = (*const Figure, Option<*const Bevel>);

impl Outlines {
    fn of(&mut self, prism: &Prism) -> Arc<PrismSection> {
        let bevel = prism.bevel.as_ref();
        let key = (Arc::as_ptr(&prism.figure), bevel.map(Arc::as_ptr));
        let prepare = || Arc::new(PrismSection::new(prism));
        Arc::clone(self.sections.entry(key).or_insert_with(prepare))
    }

    /// The rectangle around a figure.
    pub(crate) fn bounds(&mut self, figure: &Arc<Figure>) -> Rectangle {
        let known = self.bounds.entry(Arc::as_ptr(figure));
        *known.or_insert_with(|| figure.bounds())
    }
}

/// Prepares solids for rays.
pub(crate) struct Preparation<'a> {
    pub outlines: &'a mut Outlines,
    pub frame: &'a LocalFrame,
}

/// A prepared solid for the tracer, with its bounding box in the world.
pub(crate) struct Prepared {
    pub placed: PlacedExact,
    pub bounds: Aabb,
    pub leaves: u32,
}

impl Preparation<'_> {
    /// Appends the prepared form of `solid`, whose first leaf has the given numbers: one shape, or
    /// one for each of the open pieces outside of set operations.
    pub(crate) fn add(
        &mut self,
        solid: &Solid,
        [object, item, leaf]: [u32; 3],
        out: &mut Vec<Prepared>,
    ) {
        if let Solid::Shell(pieces) = solid {
            let mut taken = 0;
            for piece in pieces {
                let first = out.len();
                self.add(piece, [object, item + taken, leaf + taken], out);
                taken += out[first..].iter().map(|p| p.leaves).sum::<u32>();
            }
            return;
        }
        let bounds = solid.bounds_by(&mut |figure| self.outlines.bounds(figure));
        let (solid, leaves) = match self.leaf(solid) {
            Some(leaf) => (ExactSolid::Leaf(leaf), 1),
            None => {
                let mut leaves = Vec::new();
                let root = self.node(solid, false, &mut leaves);
                let count = leaves.len() as u32;
                (ExactSolid::Tree(Tree { leaves, root }), count)
            }
        };
        out.push(Prepared {
            placed: PlacedExact {
                object,
                first_item: item,
                first_leaf: leaf,
                solid,
            },
            bounds,
            leaves,
        });
    }

    /// `None` for a compound.
    fn leaf(&mut self, solid: &Solid) -> Option<ExactLeaf> {
        match solid {
            Solid::Primitive(p) => Some(self.primitive(p)),
            Solid::Prism(p) => Some(self.prism(p)),
            Solid::Patch(p) => Some(self.patch(p)),
            Solid::Mesh(m) => Some(self.mesh(m)),
            Solid::Shell(_) | Solid::Csg(_) => None,
        }
    }

    fn primitive(&self, primitive: &Primitive) -> ExactLeaf {
        let local = Primitive::new(
            primitive.kind,
            self.frame.local_from_world() * primitive.world_from_object,
            primitive.material,
        );
        ExactPrimitive::new(&local, &DAffine3::IDENTITY)
            .map_or(ExactLeaf::Nothing, |p| ExactLeaf::Primitive(Box::new(p)))
    }

    fn prism(&mut self, prism: &Prism) -> ExactLeaf {
        let section = self.outlines.of(prism);
        let local_from_figure = self.frame.local_from_world() * prism.world_from_figure;
        prism::ExactPrism::new(section, local_from_figure)
            .map_or(ExactLeaf::Nothing, ExactLeaf::Prism)
    }

    fn patch(&self, patch: &BicubicPatch) -> ExactLeaf {
        let points = patch.points.map(|row| row.map(|p| self.frame.point(p)));
        ExactLeaf::Patch(patch::ExactPatch::new(BicubicPatch {
            points: Box::new(points),
            material: patch.material,
        }))
    }

    fn mesh(&self, mesh: &Mesh) -> ExactLeaf {
        ExactLeaf::Mesh(mesh::ExactMesh::new(mesh, |p| self.frame.point(p)))
    }

    fn node(&mut self, solid: &Solid, is_turned: bool, leaves: &mut Vec<TreeLeaf>) -> CsgNode {
        let world = solid.bounds_by(&mut |figure| self.outlines.bounds(figure));
        let bounds = Aabb {
            min: self.frame.point(world.min),
            max: self.frame.point(world.max),
        };
        if let Some(shape) = self.leaf(solid) {
            leaves.push(TreeLeaf { shape, is_turned });
            let kind = CsgNodeKind::Leaf(leaves.len() as u32 - 1);
            return CsgNode { bounds, kind };
        }
        let mut nodes = |solids: &[Solid], is_turned: bool| -> Vec<CsgNode> {
            let node = |s: &Solid| self.node(s, is_turned, leaves);
            solids.iter().map(node).collect()
        };
        let kind = match solid {
            Solid::Shell(pieces) => CsgNodeKind::Shell(nodes(pieces, is_turned)),
            Solid::Csg(csg) => CsgNodeKind::Csg {
                operation: csg.operation,
                left: Box::new(CsgNode::union(nodes(&csg.left, is_turned))),
                right: Box::new(CsgNode::union(nodes(
                    &csg.right,
                    is_turned ^ (csg.operation == Operation::Difference),
                ))),
            },
            _ => CsgNodeKind::Shell(Vec::new()),
        };
        CsgNode { bounds, kind }
    }
}
