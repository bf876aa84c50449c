//! Construction of a tracer from a scene: collects and transforms triangles and shapes, and builds
//! the tree.

use super::placed::{Placed, PlacedPrimitive, PlacedTracer, PlacedTriangle};
use super::transparency::ItemTransparencies;
use super::twins::drop_twins;
use super::{MeshPositions, Tracer, TriangleItem};
use crate::exact::{ExactPrimitive, Outlines, Preparation};
use crate::frame::{LocalFrame, double, single};
use crate::kernel::{
    Bvh, ExternalKernel, InstructionSet, Kernel, KernelTriangle, Reference, binary_tree,
};
use azulejo_scene::math::{Aabb, normal_matrix};
use azulejo_scene::{Mesh, Scene, Shape, Solid};
use glam::{DAffine3, DVec3};
use std::collections::HashMap;
use std::sync::Arc;

/// Builds a tracer.
///
/// Items are numbered consecutively: the meshes' triangles, then the primitives' parts, then the
/// exact shapes' leaves, then the triangles of the instances, each in the order of the scene.
pub(crate) fn assemble(scene: &Scene, kernel: &Kernel) -> Tracer {
    let mut outlines = Outlines::default();
    let boxes: Vec<Aabb> = scene
        .objects
        .iter()
        .map(|o| finite_bounds(&o.shape, &mut outlines))
        .collect();
    let bounds = boxes.iter().copied().fold(Aabb::EMPTY, Aabb::union);
    let mut parts = Parts::new(LocalFrame::of(&bounds, || part_boxes(scene, &boxes)));
    for (object, o) in (0..).zip(&scene.objects) {
        if let Shape::Mesh(mesh) = &o.shape {
            parts.add_mesh(object, mesh);
        }
    }
    for (object, o) in (0..).zip(&scene.objects) {
        if let Shape::Primitive(primitive) = &o.shape {
            parts.add_primitive(object, primitive);
        }
    }
    for (object, o) in (0..).zip(&scene.objects) {
        if let Shape::Exact(exact) = &o.shape {
            parts.add_exact(object, &exact.solids, &mut outlines);
        }
    }
    parts.prototypes = parts.items;
    parts.own_items = parts.items;
    let mut shared: HashMap<*const Mesh, SharedTracer> = HashMap::new();
    for (object, o) in (0..).zip(&scene.objects) {
        if let Shape::Instance(instance) = &o.shape {
            let shared = shared
                .entry(Arc::as_ptr(&instance.mesh))
                .or_insert_with(|| parts.share(&instance.mesh));
            let shared = shared.clone();
            parts.add_instance(object, &shared, instance.world_from_mesh);
        }
    }
    let mut tracer = parts.finish(bounds, kernel);
    tracer.transparencies = ItemTransparencies::new(scene, &tracer);
    tracer
}

/// The tracer of a shared mesh alone, in its coordinates.
fn mesh_tracer(mesh: &Mesh) -> Tracer {
    let bounds = mesh_bounds(mesh);
    let mut parts = Parts::new(LocalFrame::of(&bounds, || face_boxes(mesh)));
    parts.add_mesh(0, mesh);
    parts.prototypes = parts.items;
    parts.own_items = parts.items;
    parts.finish(bounds, &Kernel::Own)
}

/// The tracer of a shared mesh, and the first of the numbers under which its triangles are known.
#[derive(Clone)]
struct SharedTracer {
    tracer: Arc<Tracer>,
    first_prototype: u32,
}

/// The box around the finite vertices of a mesh's faces, or around another shape if it is finite.
fn finite_bounds(shape: &Shape, outlines: &mut Outlines) -> Aabb {
    match shape {
        Shape::Mesh(mesh) => mesh_bounds(mesh),
        Shape::Instance(instance) => finite(instance.bounds()),
        Shape::Primitive(primitive) => finite(primitive.bounds()),
        Shape::Exact(exact) => {
            let boxes = exact.solids.iter();
            let boxes = boxes.map(|s| finite(s.bounds_by(&mut |figure| outlines.bounds(figure))));
            boxes.fold(Aabb::EMPTY, Aabb::union)
        }
    }
}

/// The box around the finite vertices of a mesh's faces.
fn mesh_bounds(mesh: &Mesh) -> Aabb {
    let corners = mesh.faces.corners.iter();
    let positions = corners.map(|&v| mesh.positions[v as usize]);
    Aabb::around(positions.filter(|p| p.is_finite()))
}

/// The boxes around all faces of a mesh.
fn face_boxes(mesh: &Mesh) -> impl Iterator<Item = Aabb> {
    let face = |corners: &[u32]| {
        let positions = corners.iter().map(|&v| mesh.positions[v as usize]);
        Aabb::around(positions.filter(|p| p.is_finite()))
    };
    mesh.faces
        .iter()
        .map(face)
        .filter(|bounds| !bounds.is_empty())
}

/// The boxes around all faces of meshes and all other shapes, whose own are given by object.
fn part_boxes<'a>(scene: &'a Scene, boxes: &'a [Aabb]) -> impl Iterator<Item = Aabb> + 'a {
    let parts = |(object, own): (&'a azulejo_scene::Object, &Aabb)| {
        let (mesh, own) = match &object.shape {
            Shape::Mesh(mesh) => (Some(mesh), None),
            _ => (None, Some(*own).filter(|own| !own.is_empty())),
        };
        mesh.into_iter().flat_map(face_boxes).chain(own)
    };
    scene.objects.iter().zip(boxes).flat_map(parts)
}

fn finite(bounds: Aabb) -> Aabb {
    if bounds.min.is_finite() && bounds.max.is_finite() {
        bounds
    } else {
        Aabb::EMPTY
    }
}

/// The box around the placed corners of a tracer's box.
fn placed_bounds(tracer: &Tracer, world_from_mesh: &DAffine3) -> Aabb {
    let inner = tracer.bounds();
    if inner.is_empty() {
        return Aabb::EMPTY;
    }
    Aabb::around((0..8).map(|k| {
        let pick = |bit: u32| f64::from((k >> bit) & 1);
        let weights = DVec3::new(pick(0), pick(1), pick(2));
        let corner = inner.min + weights * inner.size();
        world_from_mesh.transform_point3(corner)
    }))
}

/// The parts of a tracer, while they are collected.
struct Parts {
    frame: LocalFrame,
    meshes: Vec<MeshPositions>,
    triangles: Vec<TriangleItem>,
    kernel_triangles: Vec<KernelTriangle>,
    others: Vec<Placed>,
    /// Boxes of `others` in kernel coordinates.
    other_bounds: Vec<Aabb>,
    items: u32,
    /// Items that are not instances'.
    own_items: u32,
    /// Numbers of prototypes so far.
    prototypes: u32,
    /// The largest distance that an instance extends from its own centre, in world units.
    reach: f64,
}

impl Parts {
    fn new(frame: LocalFrame) -> Parts {
        Parts {
            frame,
            meshes: Vec::new(),
            triangles: Vec::new(),
            kernel_triangles: Vec::new(),
            others: Vec::new(),
            other_bounds: Vec::new(),
            items: 0,
            own_items: 0,
            prototypes: 0,
            reach: 0.0,
        }
    }

    /// Reserves the next `count` item numbers; returns the first.
    fn number_items(&mut self, count: usize) -> u32 {
        let first = self.items;
        let after = u32::try_from(count).ok().and_then(|c| first.checked_add(c));
        self.items = after.expect("a tracer numbers at most 2^32 - 1 items");
        first
    }

    fn add_mesh(&mut self, object: u32, mesh: &Mesh) {
        let local: Vec<[f32; 3]> = mesh
            .positions
            .iter()
            .map(|&p| single(self.frame.point(p)))
            .collect();
        let first_item = self.number_items(mesh.faces.triangle_count());
        let start = self.kernel_triangles.len();
        let mut split = Vec::new();
        for (face, corners) in mesh.faces.iter().enumerate() {
            split.clear();
            mesh.triangulate_into(face, &mut split);
            for (triangle, places) in (0..).zip(&split) {
                let vertices = places.map(|k| corners[k as usize]);
                let item = self.triangles.len() as u32;
                self.triangles.push(TriangleItem {
                    vertices,
                    face: face as u32,
                    triangle,
                });
                let corners = vertices.map(|v| local[v as usize]);
                let world = vertices.map(|v| mesh.positions[v as usize]);
                if self.frame.is_large(&Aabb::around(world)) {
                    self.add_large(item, world);
                } else if has_area(&corners) {
                    self.kernel_triangles.push(KernelTriangle { corners, item });
                }
            }
        }
        let items = &self.triangles;
        drop_twins(&mut self.kernel_triangles, start, |item| {
            let face = items[item as usize].face as usize;
            mesh.face_materials.get(face).copied().unwrap_or(0)
        });
        self.meshes.push(MeshPositions {
            object,
            first_item,
            positions: mesh.positions.clone(),
        });
    }

    /// Adds a triangle that reaches so far that `f32` would move it.
    fn add_large(&mut self, item: u32, corners: [DVec3; 3]) {
        let [a, b, c] = corners;
        let area = (b - a).cross(c - a);
        if area == DVec3::ZERO || !area.is_finite() {
            return;
        }
        let corners = corners.map(|p| self.frame.point(p));
        let placed = PlacedTriangle { item, corners };
        self.others.push(Placed::Triangle(Box::new(placed)));
        self.push_other_bounds(&Aabb::around([a, b, c]));
    }

    fn add_primitive(&mut self, object: u32, primitive: &azulejo_scene::Primitive) {
        let first_item = self.number_items(primitive.kind.parts());
        let Some(shape) = ExactPrimitive::new(primitive, &self.frame.world_from_local()) else {
            return;
        };
        self.others
            .push(Placed::Primitive(Box::new(PlacedPrimitive {
                object,
                first_item,
                shape,
            })));
        self.push_other_bounds(&primitive.bounds());
    }

    fn add_exact(&mut self, object: u32, solids: &[Solid], outlines: &mut Outlines) {
        let mut prepared = Vec::with_capacity(solids.len());
        let frame = self.frame;
        let mut preparation = Preparation {
            outlines,
            frame: &frame,
        };
        let (first, mut leaf) = (self.items, 0);
        for solid in solids {
            let start = prepared.len();
            preparation.add(
                solid,
                [object, first.saturating_add(leaf), leaf],
                &mut prepared,
            );
            leaf += prepared[start..].iter().map(|p| p.leaves).sum::<u32>();
        }
        self.number_items(leaf as usize);
        for p in prepared {
            self.others.push(Placed::Exact(Box::new(p.placed)));
            self.push_other_bounds(&p.bounds);
        }
    }

    /// Prepares a shared mesh.
    fn share(&mut self, mesh: &Mesh) -> SharedTracer {
        let tracer = Arc::new(mesh_tracer(mesh));
        let first_prototype = self.prototypes;
        self.prototypes += tracer.item_count();
        SharedTracer {
            tracer,
            first_prototype,
        }
    }

    fn add_instance(&mut self, object: u32, shared: &SharedTracer, world_from_mesh: DAffine3) {
        let tracer = shared.tracer.clone();
        let bounds = placed_bounds(&tracer, &world_from_mesh);
        let first_item = self.number_items(tracer.item_count() as usize);
        let mesh_from_world = world_from_mesh.inverse();
        let world_from_local = self.frame.world_from_local();
        let inner_from_mesh = tracer.frame.local_from_world();
        let m = world_from_mesh.matrix3;
        let stretch =
            (m.x_axis.length_squared() + m.y_axis.length_squared() + m.z_axis.length_squared())
                .sqrt();
        self.reach = self.reach.max(tracer.reach * stretch);
        self.others.push(Placed::Instance(Box::new(PlacedTracer {
            object,
            first_item,
            first_prototype: shared.first_prototype,
            inner_from_local: inner_from_mesh * (mesh_from_world * world_from_local),
            tracer,
            world_from_mesh,
            mesh_from_world,
            world_normals: normal_matrix(m),
        })));
        self.push_other_bounds(&bounds);
    }

    fn push_other_bounds(&mut self, world: &Aabb) {
        self.other_bounds.push(Aabb {
            min: self.frame.point(world.min),
            max: self.frame.point(world.max),
        });
    }

    fn references(&self) -> Vec<Reference> {
        let triangles = (0..).zip(&self.kernel_triangles).map(|(id, t)| {
            let [a, b, c] = t.corners;
            let min = [0, 1, 2].map(|k| a[k].min(b[k]).min(c[k]));
            let max = [0, 1, 2].map(|k| a[k].max(b[k]).max(c[k]));
            padded(min, max, id)
        });
        let first_other = self.kernel_triangles.len() as u32;
        let others = (first_other..).zip(&self.other_bounds).map(|(id, b)| {
            // Outward, so that rounding does not clip the shape.
            let (min, max) = (single(b.min), single(b.max));
            padded(min.map(f32::next_down), max.map(f32::next_up), id)
        });
        let usable = others.filter(Reference::is_finite);
        let mut references = Vec::with_capacity(self.kernel_triangles.len() + self.others.len());
        references.extend(triangles);
        references.extend(usable);
        references
    }

    fn finish(mut self, bounds: Aabb, kernel: &Kernel) -> Tracer {
        let external = ExternalKernel::new(kernel, &self.kernel_triangles);
        if external.is_some() {
            self.kernel_triangles.clear();
        }
        let mut references = self.references();
        let first_other = self.kernel_triangles.len() as u32;
        let binary = binary_tree(&mut references, first_other);
        let bvh = Bvh::collapse(&binary, &references, &self.kernel_triangles);
        Tracer {
            bvh,
            external,
            instructions: InstructionSet::detect(),
            frame: self.frame,
            bounds,
            reach: self.reach.max(self.frame.reach()),
            meshes: self.meshes,
            triangles: self.triangles,
            others: self.others,
            items: self.items,
            own_items: self.own_items,
            prototypes: self.prototypes,
            transparencies: None,
            cell: None,
        }
    }
}

/// A box of the tree, with room for the rounding of tests of what lies beyond −1..=1, for which rays leave none.
fn padded(min: [f32; 3], max: [f32; 3], id: u32) -> Reference {
    let far = min
        .iter()
        .chain(&max)
        .fold(0.0f32, |far, c| far.max(c.abs()));
    let pad = if far > 1.0 {
        4.0 * f32::EPSILON * far
    } else {
        0.0
    };
    Reference::new(min.map(|c| c - pad), max.map(|c| c + pad), id)
}

/// Whether the kernel can hit a triangle: finite, and its three corners not on one line.
fn has_area(corners: &[[f32; 3]; 3]) -> bool {
    let [a, b, c] = corners.map(double);
    let area = (b - a).cross(c - a);
    area != DVec3::ZERO && area.is_finite()
}
