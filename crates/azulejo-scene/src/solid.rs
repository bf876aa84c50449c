//! Exact solids: primitives, prisms, patches and constructive solid geometry.

use crate::figure::Rectangle;
use crate::math::Aabb;
use crate::{BicubicPatch, Figure, MaterialId, Mesh, Primitive, Prism};
use glam::DAffine3;
use std::collections::HashMap;
use std::sync::Arc;

/// Exact shapes that are one object: a line of text, a solid cut out of others.
///
/// Rays hit each solid separately: surfaces that lie inside another solid are not removed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exact {
    /// The solids.
    pub solids: Vec<Solid>,
    /// The proxy mesh: the polygons that replaced the solids in the first pass, with irradiance on
    /// their vertices; `None` before. The second pass traces the solids and reads the irradiance
    /// from here.
    pub proxy: Option<Box<Mesh>>,
}

/// One exact shape.
#[derive(Clone, Debug, PartialEq)]
pub enum Solid {
    /// A sphere, cylinder, cone, box or parallelogram. Its own light is not used.
    Primitive(Primitive),
    /// An extruded figure.
    Prism(Prism),
    /// A bicubic Bézier patch; open.
    Patch(BicubicPatch),
    /// Polygons, all of one material. In a box, because a text is a list of a million prisms.
    Mesh(Box<Mesh>),
    /// Open pieces that together close a volume, as a tube and two discs do.
    Shell(Vec<Solid>),
    /// The result of a set operation.
    Csg(Box<Csg>),
}

/// Constructive solid geometry: a set operation and its two operands. Several solids in one
/// operand count as their union. All of them must be closed.
///
/// Roth, *Ray Casting for Modeling Solids* (1982). Where the right operand cuts the left one, the
/// visible surface is the right operand's, reversed, with its own material.
#[derive(Clone, Debug, PartialEq)]
pub struct Csg {
    /// The set operation.
    pub operation: Operation,
    /// The left operand, not empty.
    pub left: Vec<Solid>,
    /// The right operand, not empty.
    pub right: Vec<Solid>,
}

/// A set operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// Points of either operand.
    Union,
    /// Points of the left operand that are not in the right one.
    Difference,
    /// Points of both operands.
    Intersection,
}

/// A solid that is not a compound of others.
#[derive(Clone, Copy, Debug)]
pub enum Leaf<'a> {
    /// See [`Solid::Primitive`].
    Primitive(&'a Primitive),
    /// See [`Solid::Prism`].
    Prism(&'a Prism),
    /// See [`Solid::Patch`].
    Patch(&'a BicubicPatch),
    /// See [`Solid::Mesh`].
    Mesh(&'a Mesh),
}

impl Exact {
    /// A shape of these solids, without irradiance.
    pub fn new(solids: Vec<Solid>) -> Exact {
        Exact {
            solids,
            proxy: None,
        }
    }

    /// All solids that are not compounds, depth first, the left operand before the right. Hits
    /// refer to them by their index in this order.
    pub fn leaves(&self) -> Vec<Leaf<'_>> {
        let mut leaves = Vec::new();
        self.solids.iter().for_each(|s| s.push_leaves(&mut leaves));
        leaves
    }

    /// The smallest box around all solids; around both operands where they are joined by a set
    /// operation, around the left one of a difference.
    pub fn bounds(&self) -> Aabb {
        // A line of text has many prisms of few figures, whose curves need not be searched again.
        let mut known: HashMap<*const Figure, Rectangle> = HashMap::new();
        bounds_of(&self.solids, &mut |figure| {
            let rectangle = known.entry(Arc::as_ptr(figure));
            *rectangle.or_insert_with(|| figure.bounds())
        })
    }

    /// Transforms the shape and its irradiance by an affine map.
    pub fn transform(&mut self, map: &DAffine3) {
        self.solids.iter_mut().for_each(|s| s.transform(map));
        if let Some(proxy) = &mut self.proxy {
            proxy.transform(map);
        }
    }

    /// Changes every leaf's material.
    pub fn map_materials(&mut self, change: &mut impl FnMut(MaterialId) -> MaterialId) {
        self.solids.iter_mut().for_each(|s| s.map_materials(change));
        if let Some(proxy) = &mut self.proxy {
            proxy
                .face_materials
                .iter_mut()
                .for_each(|m| *m = change(*m));
        }
    }
}

/// The rectangle around a figure.
pub type FigureBounds<'a> = dyn FnMut(&Arc<Figure>) -> Rectangle + 'a;

fn bounds_of(solids: &[Solid], figure: &mut FigureBounds) -> Aabb {
    let boxes = solids.iter().map(|s| s.bounds_by(figure));
    boxes.fold(Aabb::EMPTY, Aabb::union)
}

impl Solid {
    /// The leaves of one solid, as [`Exact::leaves`].
    pub fn leaves(&self) -> Vec<Leaf<'_>> {
        let mut leaves = Vec::new();
        self.push_leaves(&mut leaves);
        leaves
    }

    fn push_leaves<'a>(&'a self, leaves: &mut Vec<Leaf<'a>>) {
        match self {
            Solid::Primitive(p) => leaves.push(Leaf::Primitive(p)),
            Solid::Prism(p) => leaves.push(Leaf::Prism(p)),
            Solid::Patch(p) => leaves.push(Leaf::Patch(p)),
            Solid::Mesh(m) => leaves.push(Leaf::Mesh(m)),
            Solid::Shell(pieces) => pieces.iter().for_each(|s| s.push_leaves(leaves)),
            Solid::Csg(csg) => {
                let sides = csg.left.iter().chain(&csg.right);
                sides.for_each(|s| s.push_leaves(leaves));
            }
        }
    }

    /// A bounding box; not always the smallest.
    pub fn bounds(&self) -> Aabb {
        self.bounds_by(&mut |figure| figure.bounds())
    }

    /// [`bounds`](Solid::bounds) for callers that already know the rectangles of figures, which
    /// many prisms may share.
    pub fn bounds_by(&self, figure: &mut FigureBounds) -> Aabb {
        match self {
            Solid::Primitive(p) => p.bounds(),
            Solid::Prism(p) => p.bounds_over(figure(&p.figure)),
            Solid::Patch(p) => p.bounds(),
            Solid::Mesh(m) => m.bounds(),
            Solid::Shell(pieces) => bounds_of(pieces, figure),
            Solid::Csg(csg) => csg.bounds(figure),
        }
    }

    /// Transforms the solid by an affine map.
    pub fn transform(&mut self, map: &DAffine3) {
        match self {
            Solid::Primitive(p) => p.transform(map),
            Solid::Prism(p) => p.world_from_figure = *map * p.world_from_figure,
            Solid::Patch(p) => p.transform(map),
            Solid::Mesh(m) => m.transform(map),
            Solid::Shell(pieces) => pieces.iter_mut().for_each(|s| s.transform(map)),
            Solid::Csg(csg) => {
                let sides = csg.left.iter_mut().chain(&mut csg.right);
                sides.for_each(|s| s.transform(map));
            }
        }
    }

    /// Changes every leaf's material.
    pub fn map_materials(&mut self, change: &mut impl FnMut(MaterialId) -> MaterialId) {
        match self {
            Solid::Primitive(p) => p.material = change(p.material),
            Solid::Prism(p) => p.material = change(p.material),
            Solid::Patch(p) => p.material = change(p.material),
            Solid::Mesh(m) => m.face_materials.iter_mut().for_each(|m| *m = change(*m)),
            Solid::Shell(pieces) => pieces.iter_mut().for_each(|s| s.map_materials(change)),
            Solid::Csg(csg) => {
                let sides = csg.left.iter_mut().chain(&mut csg.right);
                sides.for_each(|s| s.map_materials(change));
            }
        }
    }
}

impl Csg {
    fn bounds(&self, figure: &mut FigureBounds) -> Aabb {
        let left = bounds_of(&self.left, figure);
        match self.operation {
            Operation::Union => left.union(bounds_of(&self.right, figure)),
            Operation::Difference => left,
            Operation::Intersection => {
                let right = bounds_of(&self.right, figure);
                let both = Aabb {
                    min: left.min.max(right.min),
                    max: left.max.min(right.max),
                };
                if both.min.cmple(both.max).all() {
                    both
                } else {
                    Aabb::EMPTY
                }
            }
        }
    }
}

impl Leaf<'_> {
    /// The material of the leaf; of a mesh that of its first face, 0 if it has none.
    pub fn material(&self) -> MaterialId {
        match self {
            Leaf::Primitive(p) => p.material,
            Leaf::Prism(p) => p.material,
            Leaf::Patch(p) => p.material,
            Leaf::Mesh(m) => m.face_materials.first().copied().unwrap_or(0),
        }
    }
}
