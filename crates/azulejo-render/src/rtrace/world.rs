//! Intersections of rays with a scene, in terms of what RTRACE counts as objects.

use azulejo_scene::math::{Ray, normal_matrix};
use azulejo_scene::rtrace::{Rtrace, RtraceMaterial, RtraceSurface};
use azulejo_scene::{Exact, Leaf, MaterialId, Mesh, PrimitiveKind, Rgb, Scene, Shape, Solid};
use azulejo_trace::{Hit, MeshTriangles, Tracer};
use glam::DVec3;

/// Hits whose distances differ by less, relatively, are at the same point.
const SAME: f64 = 1e-9;

/// What RTRACE counts as one object: a primitive, a polygon of a mesh, a glyph, a set operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Owner {
    object: u32,
    part: u32,
}

/// Which rays from an object are tested against the object itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Class {
    /// Polygons: never.
    Flat,
    /// Spheres, boxes and cones: rays within glass alone. The inside of an open tube does not
    /// shadow itself.
    Convex,
    /// All the rest: always.
    Any,
}

/// A scene, ready for intersection.
pub(super) struct World<'a> {
    scene: &'a Scene,
    rtrace: &'a Rtrace,
    /// Spheres, boxes, cones and triangles, which RTRACE tests at once.
    simple: Part,
    /// Polygons, patches, text and set operations, which have to be nearer than those.
    complex: Part,
    /// For each object that is [`Shape::Exact`]: its leaves.
    leaves: Vec<Vec<LeafOf<'a>>>,
    /// For each object that is a mesh with normals: its triangles.
    triangles: Vec<Option<MeshTriangles>>,
}

/// Some of a scene's objects, made ready for rays.
struct Part {
    tracer: Tracer,
    /// Their indices in the scene.
    objects: Vec<u32>,
}

/// A leaf, and the solid of its object that it belongs to.
struct LeafOf<'a> {
    leaf: Leaf<'a>,
    part: u32,
    class: Class,
    /// The triangles of a mesh with normals.
    triangles: Option<MeshTriangles>,
}

/// The intersection of a ray with a surface.
#[derive(Clone, Debug)]
pub(super) struct Intersection<'a> {
    /// Distance along the ray, whose direction is a unit vector.
    pub distance: f64,
    pub position: DVec3,
    /// Unit normal of the object, interpolated where it has vertex normals; not turned toward the
    /// ray.
    pub normal: DVec3,
    /// Unit normal of the geometry.
    pub face_normal: DVec3,
    pub owner: Owner,
    pub class: Class,
    pub material: &'a RtraceMaterial,
    /// Its surface before textures.
    pub surface: RtraceSurface,
}

impl Intersection<'_> {
    /// Whether a ray that leaves this surface passes by its object.
    pub fn is_passed_by(&self, is_inside: bool) -> bool {
        let is_opaque = !is_above(self.surface.transparency, super::shade::NOTHING);
        match self.class {
            Class::Flat => true,
            Class::Convex => is_opaque && !is_inside,
            Class::Any => false,
        }
    }
}

/// Whether a colour is above a value in any channel.
pub(super) fn is_above(color: Rgb, value: f64) -> bool {
    color.max_channel() > value
}

impl Part {
    fn new(scene: &Scene, belongs: impl Fn(&Shape) -> bool) -> Part {
        let mut part = Scene {
            materials: scene.materials.clone(),
            ..Scene::default()
        };
        // RTRACE's own transparency is that of surfaces: rays stop at all of them.
        part.materials.iter_mut().for_each(|m| m.opacity = None);
        let mut objects = Vec::new();
        for (i, object) in scene.objects.iter().enumerate() {
            if belongs(&object.shape) {
                part.objects.push(object.clone());
                objects.push(i as u32);
            }
        }
        Part {
            tracer: Tracer::new(&part),
            objects,
        }
    }

    fn hit(&self, ray: &Ray) -> Option<Hit> {
        let hit = self.tracer.hit(ray)?;
        let object = self.objects[hit.object as usize];
        Some(Hit { object, ..hit })
    }
}

impl<'a> World<'a> {
    pub fn new(scene: &'a Scene, rtrace: &'a Rtrace) -> World<'a> {
        let leaves = scene.objects.iter().map(|o| match &o.shape {
            Shape::Exact(exact) => leaves_of(exact),
            _ => Vec::new(),
        });
        let triangles = scene.objects.iter();
        let triangles = triangles.map(|o| o.shape.mesh().and_then(smooth_triangles));
        let known = |shape: &Shape| is_known(shape, rtrace.materials.len());
        World {
            scene,
            rtrace,
            simple: Part::new(scene, |s| known(s) && is_simple(s)),
            complex: Part::new(scene, |s| known(s) && !is_simple(s)),
            leaves: leaves.collect(),
            triangles: triangles.collect(),
        }
    }

    /// The scene's numbers.
    pub fn rtrace(&self) -> &'a Rtrace {
        self.rtrace
    }

    /// The first surface along a ray of unit direction whose owner counts.
    pub fn first(&self, ray: &Ray, counts: impl Fn(Owner) -> bool) -> Option<Intersection<'a>> {
        let mut ray = *ray;
        loop {
            let hit = self.found(&self.hit(&ray)?);
            if counts(hit.owner) {
                return Some(hit);
            }
            // Rounding may find the surface once more, a little nearer: never go back.
            ray.t_min = self.beyond(&ray, hit.distance.max(ray.t_min));
        }
    }

    /// The first hit. Of a simple and a complex object at the same distance it is the simple one:
    /// a box that stands on a polygon keeps its floor.
    fn hit(&self, ray: &Ray) -> Option<Hit> {
        match (self.simple.hit(ray), self.complex.hit(ray)) {
            (Some(simple), Some(complex)) => {
                let is_nearer = complex.t < simple.t - SAME * simple.t;
                Some(if is_nearer { complex } else { simple })
            }
            (simple, complex) => simple.or(complex),
        }
    }

    /// Just behind a surface that a ray of unit direction hits at `distance`.
    pub fn beyond(&self, ray: &Ray, distance: f64) -> f64 {
        let position = ray.at(distance);
        let step = self.moved(position, ray.direction).distance(position);
        distance + step.max(1e-6 * distance)
    }

    /// A ray that leaves a surface from `position`, which textures may have moved.
    pub fn leaving(&self, found: &Intersection, position: DVec3, direction: DVec3) -> Ray {
        let side = found.face_normal * found.face_normal.dot(direction).signum();
        Ray::new(self.moved(position, side), direction)
    }

    /// A position moved so far to a side that no surface through it is hit.
    fn moved(&self, position: DVec3, side: DVec3) -> DVec3 {
        let [a, b] = [&self.simple, &self.complex].map(|p| p.tracer.leaving(position, side));
        if a.distance_squared(position) > b.distance_squared(position) {
            a
        } else {
            b
        }
    }

    /// The part, the class, the material and the normal of a mesh at a hit, in its coordinates.
    fn on_triangle(&self, mesh: &Mesh, hit: &Hit) -> (u32, Class, MaterialId, Option<DVec3>) {
        let material = mesh.face_materials[hit.face as usize];
        let triangles = self.triangles[hit.object as usize].as_ref();
        let corners = triangles.map(|t| t.corners_of(mesh, hit.face, hit.triangle));
        let normal = corners.and_then(|corners| interpolated(mesh, corners, hit));
        (hit.face, Class::Flat, material, normal)
    }

    /// A hit with RTRACE's material.
    fn found(&self, hit: &Hit) -> Intersection<'a> {
        let scene: &'a Scene = self.scene;
        let (part, class, material, normal) = match &scene.objects[hit.object as usize].shape {
            Shape::Mesh(mesh) => self.on_triangle(mesh, hit),
            Shape::Instance(instance) => {
                let (face, class, material, normal) = self.on_triangle(&instance.mesh, hit);
                let matrix = normal_matrix(instance.world_from_mesh.matrix3);
                let placed = normal.and_then(|n| (matrix * n).try_normalize());
                (face, class, material, placed)
            }
            Shape::Primitive(p) => (0, class_of(p.kind), p.material, None),
            Shape::Exact(_) => {
                let of = &self.leaves[hit.object as usize][hit.face as usize];
                (of.part, of.class, of.leaf.material(), of.leaf_normal(hit))
            }
        };
        let material = &self.rtrace.materials[material as usize];
        let surface = match self.rtrace.corner_surfaces.get(&hit.object) {
            Some(faces) => self.blended(faces[hit.face as usize], hit),
            None => self.rtrace.surfaces[material.surface as usize],
        };
        Intersection {
            distance: hit.t,
            position: hit.position,
            normal: normal.unwrap_or(hit.normal),
            face_normal: hit.normal,
            owner: Owner {
                object: hit.object,
                part,
            },
            class,
            material,
            surface,
        }
    }

    /// The surface between those of a triangle's corners.
    fn blended(&self, corners: [u32; 3], hit: &Hit) -> RtraceSurface {
        let [a, b, c] = corners.map(|s| &self.rtrace.surfaces[s as usize]);
        let (u, v) = (hit.u, hit.v);
        let mix = |of: fn(&RtraceSurface) -> Rgb| (1.0 - u - v) * of(a) + u * of(b) + v * of(c);
        RtraceSurface {
            color: mix(|s| s.color),
            diffuse: mix(|s| s.diffuse),
            specular: mix(|s| s.specular),
            phong: (1.0 - u - v) * a.phong + u * b.phong + v * c.phong,
            metal: mix(|s| s.metal),
            transparency: mix(|s| s.transparency),
            diffuse_factor: mix(|s| s.diffuse_factor),
            is_emitter: false,
            is_unshadowed: false,
            source: a.source,
        }
    }
}

/// Whether RTRACE shows an object: not the bodies of lamps, whose materials come after its own.
fn is_known(shape: &Shape, materials: usize) -> bool {
    let is_known = |m: MaterialId| (m as usize) < materials;
    let of_faces = |mesh: &Mesh| mesh.face_materials.iter().all(|m| is_known(*m));
    match shape {
        Shape::Mesh(mesh) => of_faces(mesh),
        Shape::Instance(instance) => of_faces(&instance.mesh),
        Shape::Primitive(p) => is_known(p.material),
        Shape::Exact(exact) => exact.leaves().iter().all(|l| is_known(l.material())),
    }
}

fn is_simple(shape: &Shape) -> bool {
    match shape {
        Shape::Mesh(mesh) => mesh.normals.is_some(),
        Shape::Instance(instance) => instance.mesh.normals.is_some(),
        Shape::Primitive(p) => class_of(p.kind) == Class::Convex,
        Shape::Exact(_) => false,
    }
}

fn class_of(kind: PrimitiveKind) -> Class {
    match kind {
        PrimitiveKind::Square => Class::Flat,
        _ => Class::Convex,
    }
}

/// The leaves of an exact shape in their order.
fn leaves_of(exact: &Exact) -> Vec<LeafOf<'_>> {
    let of = |(part, solid): (usize, &Solid)| {
        let class = match solid {
            Solid::Primitive(p) => class_of(p.kind),
            _ => Class::Any,
        };
        let count = leaf_count(solid);
        std::iter::repeat_n((part as u32, class), count)
    };
    let parts = exact.solids.iter().enumerate().flat_map(of);
    let leaf = |(leaf, (part, class))| LeafOf {
        triangles: match leaf {
            Leaf::Mesh(mesh) => smooth_triangles(mesh),
            _ => None,
        },
        leaf,
        part,
        class,
    };
    exact.leaves().into_iter().zip(parts).map(leaf).collect()
}

fn leaf_count(solid: &Solid) -> usize {
    match solid {
        Solid::Shell(pieces) => pieces.iter().map(leaf_count).sum(),
        Solid::Csg(csg) => csg.left.iter().chain(&csg.right).map(leaf_count).sum(),
        _ => 1,
    }
}

impl LeafOf<'_> {
    /// The interpolated normal of a mesh that has normals; turned around with the surface where
    /// it was taken away from another.
    fn leaf_normal(&self, hit: &Hit) -> Option<DVec3> {
        let Leaf::Mesh(mesh) = self.leaf else {
            return None;
        };
        let corners = self.triangles.as_ref()?.corners(hit.triangle as usize);
        let normal = interpolated(mesh, corners, hit)?;
        // The last face whose triangles begin at this one or before.
        let (mut face, mut end) = (0, mesh.faces.len());
        while face + 1 < end {
            let middle = (face + end) / 2;
            if MeshTriangles::first_of(mesh, middle) <= hit.triangle as usize {
                face = middle;
            } else {
                end = middle;
            }
        }
        let is_turned = mesh.face_area_vector(face).dot(hit.normal) < 0.0;
        Some(if is_turned { -normal } else { normal })
    }
}

/// The triangles of a mesh that has normals to interpolate.
fn smooth_triangles(mesh: &Mesh) -> Option<MeshTriangles> {
    mesh.normals.as_ref().map(|_| MeshTriangles::new(mesh))
}

/// The normal between those of a triangle's corners, if the mesh has normals.
fn interpolated(mesh: &Mesh, corners: [u32; 3], hit: &Hit) -> Option<DVec3> {
    let normals = mesh.normals.as_ref()?;
    let [a, b, c] = corners.map(|k| normals.at(k as usize, mesh.faces.corners[k as usize]));
    ((1.0 - hit.u - hit.v) * a + hit.u * b + hit.v * c).try_normalize()
}
