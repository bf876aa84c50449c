//! Surface properties that light transport needs at every hit, kept per traced item.

use crate::back_to_back::{BACK_TO_BACK, BackToBack, back_to_back};
use crate::{Hit, Item, KernelHit, KernelRay, Tracer};
use azulejo_scene::brdf::Lobes;
use azulejo_scene::math::Frame;
use azulejo_scene::{
    Leaf, Material, MaterialId, Mesh, MeshInstance, Object, PrimitiveKind, Rgb, Scene, Shape,
    Texture,
};
use glam::{DVec2, DVec3};
use std::collections::HashMap;
use std::sync::Arc;

/// Cosine to the normal beyond which an axis does not determine the tangent.
const UPRIGHT: f64 = 0.999;

/// A scene with its tracer, and for every item the normal and material that hits look up.
///
/// Immutable; made once per pass. Takes 40 bytes per prototype of items, and 12 more per triangle of
/// meshes with texture coordinates.
pub struct Surfaces<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its tracer.
    pub tracer: &'a Tracer,
    /// By prototype: what all instances of a mesh share is stored once.
    items: Vec<ItemSurface>,
    /// What each prototype is: apart from `items`, which every ray reads, because few rays need it.
    names: Vec<Item>,
    /// Per object, the triangles of a mesh with texture coordinates: frames need them at every
    /// hit, and to triangulate the face each time would cost more than the rest of the hit.
    triangles: Vec<Option<Arc<MeshTriangles>>>,
    /// Mean radiance of the front of each material.
    emissions: Vec<Rgb>,
    /// Per prototype, whether it bounds a body of glass; empty if nothing does.
    bodies: Vec<bool>,
    back_to_back: BackToBack,
}

/// The triangles of all faces of a mesh, so that no face is triangulated twice.
///
/// Takes 12 bytes per triangle.
pub struct MeshTriangles {
    /// Positions in [`Faces::corners`](azulejo_scene::Faces::corners), face by face.
    corners: Vec<[u32; 3]>,
}

impl MeshTriangles {
    /// Triangulates every face of a mesh.
    pub fn new(mesh: &Mesh) -> MeshTriangles {
        let mut corners = Vec::with_capacity(mesh.faces.triangle_count());
        for face in 0..mesh.faces.len() {
            let (first, start) = (corners.len(), mesh.faces.starts[face]);
            mesh.triangulate_into(face, &mut corners);
            for triangle in &mut corners[first..] {
                *triangle = triangle.map(|k| start + k);
            }
        }
        MeshTriangles { corners }
    }

    /// For each object the triangles of its mesh, if it has one; instances of one mesh share them.
    pub fn of_objects(scene: &Scene) -> Vec<Option<Arc<MeshTriangles>>> {
        let mut shared: HashMap<*const Mesh, Arc<MeshTriangles>> = HashMap::new();
        let of_object = |object: &Object| match &object.shape {
            Shape::Mesh(mesh) => Some(Arc::new(MeshTriangles::new(mesh))),
            Shape::Instance(MeshInstance { mesh, .. }) => {
                let known = shared.entry(Arc::as_ptr(mesh));
                let triangles = known.or_insert_with(|| Arc::new(MeshTriangles::new(mesh)));
                Some(triangles.clone())
            }
            Shape::Primitive(_) | Shape::Exact(_) => None,
        };
        scene.objects.iter().map(of_object).collect()
    }

    /// Number of the first triangle of a face; triangles count over all faces.
    pub fn first_of(mesh: &Mesh, face: usize) -> usize {
        // A face of n corners has n − 2 triangles.
        mesh.faces.starts[face] as usize - 2 * face
    }

    /// The corners of a triangle by its number over all faces, as positions in
    /// [`Faces::corners`](azulejo_scene::Faces::corners).
    pub fn corners(&self, number: usize) -> [u32; 3] {
        self.corners[number]
    }

    /// The corners of a triangle of a face.
    pub fn corners_of(&self, mesh: &Mesh, face: u32, triangle: u32) -> [u32; 3] {
        self.corners(MeshTriangles::first_of(mesh, face as usize) + triangle as usize)
    }
}

/// What every hit needs of its item.
#[derive(Clone, Copy, Debug)]
struct ItemSurface {
    /// Unit normal of the front, in the coordinates of a shared mesh; zero where it changes over the item.
    normal: [f32; 3],
    material: MaterialId,
    is_specular: bool,
    is_emitter: bool,
}

impl<'a> Surfaces<'a> {
    /// Looks up every item of `tracer`, which must have been made from `scene`.
    pub fn new(scene: &'a Scene, tracer: &'a Tracer) -> Surfaces<'a> {
        let leaves = scene.objects.iter().map(|o| match &o.shape {
            Shape::Exact(exact) => exact.leaves(),
            _ => Vec::new(),
        });
        let leaves: Vec<Vec<Leaf>> = leaves.collect();
        let mut triangles = MeshTriangles::of_objects(scene);
        let emissions = scene.mean_emissions();
        let prototypes = tracer.prototype_items().into_iter();
        let names: Vec<Item> = prototypes.map(|item| tracer.item(item)).collect();
        let surface = |item: &Item| {
            let object = item.object as usize;
            let triangles = triangles[object].as_deref();
            ItemSurface::new(scene, &leaves[object], triangles, &emissions, item)
        };
        let items: Vec<ItemSurface> = names.iter().map(surface).collect();
        for (object, triangles) in scene.objects.iter().zip(&mut triangles) {
            if object.shape.mesh().is_none_or(|mesh| mesh.uvs.is_none()) {
                *triangles = None;
            }
        }
        let bodies = bodies(scene, &names, &items);
        Surfaces {
            scene,
            tracer,
            items,
            names,
            triangles,
            emissions,
            bodies,
            back_to_back: back_to_back(tracer),
        }
    }

    /// Whether the scene has closed bodies of glass.
    pub(crate) fn has_bodies(&self) -> bool {
        !self.bodies.is_empty()
    }

    /// Whether an item bounds a closed body of glass. Panes do not, nor a sheet whose far side is all glass.
    pub(crate) fn is_body(&self, item: u32) -> bool {
        let prototype = self.tracer.prototype(item) as usize;
        self.bodies.get(prototype).is_some_and(|is_body| *is_body)
    }

    /// What an item is.
    #[inline]
    pub fn item(&self, item: u32) -> Item {
        if self.tracer.is_instanced(item) {
            self.tracer.item(item)
        } else {
            self.names[item as usize]
        }
    }

    #[inline]
    fn surface(&self, item: u32) -> &ItemSurface {
        &self.items[self.tracer.prototype(item) as usize]
    }

    /// Whether light that arrives at an item can leave mirrored or refracted.
    pub fn is_specular(&self, item: u32) -> bool {
        self.surface(item).is_specular
    }

    /// Whether the front of an item emits.
    pub fn is_emitter(&self, item: u32) -> bool {
        self.surface(item).is_emitter
    }

    /// Radiance of the front of a material, W/(sr·m²); the mean where it emits a picture.
    pub fn mean_emission(&self, material: MaterialId) -> Rgb {
        self.emissions[material as usize]
    }

    /// The picture that surfaces of an object emit that have this material; `None` if they emit none, or
    /// evenly: without texture coordinates they emit the mean.
    pub fn emitted_picture(&self, object: u32, material: MaterialId) -> Option<&'a Texture> {
        let picture = self.scene.materials[material as usize].emission_picture?;
        let is_mapped = self.triangles[object as usize].is_some();
        let shines = is_mapped && !self.mean_emission(material).is_black();
        shines.then(|| &self.scene.textures[picture as usize])
    }

    /// The picture that an item emits, as [`emitted_picture`](Surfaces::emitted_picture).
    fn picture_of(&self, item: u32) -> Option<&'a Texture> {
        if !self.is_emitter(item) {
            return None;
        }
        self.emitted_picture(self.item(item).object, self.material_id(item))
    }

    /// Radiance that an item emits from one side at a hit, W/(sr·m²).
    pub fn emitted(&self, hit: &KernelHit, front: bool) -> Rgb {
        let material = self.material(hit.item);
        if !(self.is_emitter(hit.item) && (front || material.emits_back)) {
            return Rgb::BLACK;
        }
        let Some(picture) = self.picture_of(hit.item) else {
            return self.mean_emission(self.material_id(hit.item));
        };
        let color = self.picture_place(hit).and_then(|uv| picture.sample(uv));
        material.emission * Rgb::from(color.unwrap_or_default().map(f64::from))
    }

    /// Texture coordinates at a hit of a mesh that has some.
    pub fn picture_place(&self, hit: &KernelHit) -> Option<DVec2> {
        let item = self.item(hit.item);
        let (_, [a, b, c]) = self.triangle(item.object, item.face, item.triangle)?;
        let [u, v] = hit.uv().map(f64::from);
        Some(a + u * (b - a) + v * (c - a))
    }

    /// The directions in which the texture coordinates grow at a hit of a mesh that has some, of any
    /// length; `None` where they do not span the surface.
    pub fn picture_axes(&self, hit: &KernelHit) -> Option<[DVec3; 2]> {
        let item = self.item(hit.item);
        let ([a, b, c], [ta, tb, tc]) = self.triangle(item.object, item.face, item.triangle)?;
        let (d1, d2) = (tb - ta, tc - ta);
        let turn = d1.perp_dot(d2).signum();
        let along = (d2.y * (b - a) - d1.y * (c - a)) * turn;
        let across = (d1.x * (c - a) - d2.x * (b - a)) * turn;
        let spans = d1.perp_dot(d2) != 0.0 && along.is_finite() && across.is_finite();
        spans.then_some([along, across])
    }

    /// Corners and texture coordinates of a triangle of a mesh that has some.
    pub(crate) fn triangle(
        &self,
        object: u32,
        face: u32,
        triangle: u32,
    ) -> Option<([DVec3; 3], [DVec2; 3])> {
        let placed = self.scene.objects[object as usize].shape.placed_mesh()?;
        let mesh = placed.mesh;
        let uvs = mesh.uvs.as_ref()?;
        let triangles = self.triangles[object as usize].as_ref()?;
        let corners = triangles.corners_of(mesh, face, triangle);
        let vertex = |k: u32| mesh.faces.corners[k as usize];
        Some((
            corners.map(|k| placed.position(vertex(k))),
            corners.map(|k| uvs.at(k as usize, vertex(k))),
        ))
    }

    /// Index of the material of an item.
    pub fn material_id(&self, item: u32) -> MaterialId {
        self.surface(item).material
    }

    /// Material of an item.
    pub fn material(&self, item: u32) -> &'a Material {
        &self.scene.materials[self.material_id(item) as usize]
    }

    /// The glossy lobes of an item, if it has any: the part of its reflection that paths sample.
    pub fn glossy(&self, item: u32) -> Option<&'a Lobes> {
        if !self.is_specular(item) {
            return None;
        }
        self.material(item).glossy()
    }

    /// The frame in which reflection models are evaluated at a hit: `z` is `normal`, `x` the
    /// direction in which the first texture coordinate grows.
    ///
    /// Without texture coordinates `x` is the projection of the world's x axis onto the surface,
    /// or of y where x is nearly the normal: brushed metal is brushed along an axis.
    pub fn frame(&self, at: &Hit, normal: DVec3) -> Frame {
        let upright = |axis: DVec3| normal.dot(axis).abs() > UPRIGHT;
        let along = self.tangent(at).filter(|&t| !upright(t));
        let axis = if upright(DVec3::X) {
            DVec3::Y
        } else {
            DVec3::X
        };
        let x = along.unwrap_or(axis);
        let x = (x - x.dot(normal) * normal).normalize();
        Frame {
            x,
            y: normal.cross(x),
            z: normal,
        }
    }

    /// The unit direction in which the first texture coordinate grows on a triangle.
    fn tangent(&self, at: &Hit) -> Option<DVec3> {
        let ([a, b, c], [ta, tb, tc]) = self.triangle(at.object, at.face, at.triangle)?;
        let (d1, d2) = (tb - ta, tc - ta);
        let along = (d2.y * (b - a) - d1.y * (c - a)) * d1.perp_dot(d2).signum();
        along.try_normalize()
    }

    /// Unit normal of the front of a flat item; `None` where the item is curved.
    pub fn flat_normal(&self, item: u32) -> Option<DVec3> {
        let n = self.surface(item).normal;
        if n == [0.0; 3] {
            return None;
        }
        let n = DVec3::new(n[0].into(), n[1].into(), n[2].into());
        if self.tracer.is_instanced(item) {
            return Some(self.tracer.world_normal(item, n).normalize_or_zero());
        }
        Some(n)
    }

    /// Whether the ray that made `hit` arrives at the front.
    pub fn is_front(&self, ray: &KernelRay, hit: &KernelHit) -> bool {
        let (mut n, d) = (self.surface(hit.item).normal, ray.direction);
        if n == [0.0; 3] {
            return self
                .tracer
                .resolve(&self.tracer.world_ray(ray), hit)
                .entering;
        }
        if self.tracer.is_instanced(hit.item) {
            let normal = DVec3::from(n.map(f64::from));
            let normal = self.tracer.world_normal(hit.item, normal);
            n = normal.as_vec3().to_array();
        }
        n[0] * d[0] + n[1] * d[1] + n[2] * d[2] < 0.0
    }

    /// A hit of a ray and whether it is at the front: if it is at a back, and there is a front in the same place, that
    /// front. Which of two faces back to back a ray hits first is rounding, unless both are divided alike.
    pub fn facing(&self, ray: &KernelRay, hit: &KernelHit) -> (KernelHit, bool) {
        if self.is_front(ray, hit) {
            return (*hit, true);
        }
        if self.material(hit.item).dielectric.is_some() {
            return (*hit, false);
        }
        let mut others = self.back_to_back.hits(self.tracer, ray, hit);
        if let Some(front) = others.find(|other| self.is_front(ray, other)) {
            return (front, true);
        }
        if !self.back_to_back.is_unknown(hit.item) {
            return (*hit, false);
        }
        let length = |v: [f32; 3]| v.iter().map(|x| x * x).sum::<f32>().sqrt();
        let far = length(ray.origin) + hit.t * length(ray.direction) + 1.0;
        let beside = BACK_TO_BACK * f32::EPSILON * far / length(ray.direction);
        let mut next = KernelRay {
            t_min: hit.t - beside,
            t_max: hit.t + beside,
            ..*ray
        };
        let mut hits = [KernelHit::NOTHING];
        for _ in 0..MOST_SHEETS {
            self.tracer.closest_into(&[next], &mut hits);
            if !hits[0].is_hit() {
                break;
            }
            if self.is_front(ray, &hits[0]) {
                return (hits[0], true);
            }
            next = next.behind(&hits[0]);
        }
        (*hit, false)
    }
}

/// Which of the items are surfaces of closed bodies of glass; empty if none is. Those of an object follow one another.
fn bodies(scene: &Scene, names: &[Item], items: &[ItemSurface]) -> Vec<bool> {
    let is_glass = |material: MaterialId| {
        let glass = scene.materials[material as usize].dielectric;
        glass.is_some_and(|glass| !glass.thin)
    };
    if !items.iter().any(|item| is_glass(item.material)) {
        return Vec::new();
    }
    let is_closed = |object: u32| match &scene.objects[object as usize].shape {
        Shape::Mesh(mesh) => mesh.is_closed_by(is_glass),
        Shape::Instance(instance) => instance.mesh.is_closed_by(is_glass),
        Shape::Primitive(p) => {
            !matches!(p.kind, PrimitiveKind::Square | PrimitiveKind::Tube { .. })
        }
        Shape::Exact(exact) => exact.solids.iter().all(|s| s.open_part().is_none()),
    };
    let mut last = None;
    let mut is_closed_again = |object: u32| match last {
        Some((known, is_closed)) if known == object => is_closed,
        _ => last.insert((object, is_closed(object))).1,
    };
    let all = names.iter().zip(items);
    let bodies: Vec<bool> = all
        .map(|(name, item)| is_glass(item.material) && is_closed_again(name.object))
        .collect();
    if bodies.contains(&true) {
        bodies
    } else {
        Vec::new()
    }
}

/// Faces in one place that are looked at.
const MOST_SHEETS: usize = 4;

impl ItemSurface {
    fn new(
        scene: &Scene,
        leaves: &[Leaf],
        triangles: Option<&MeshTriangles>,
        emissions: &[Rgb],
        item: &Item,
    ) -> ItemSurface {
        let shape = &scene.objects[item.object as usize].shape;
        let (normal, material) = match shape {
            Shape::Mesh(mesh) => of_triangle(mesh, triangles, item),
            Shape::Instance(instance) => of_triangle(&instance.mesh, triangles, item),
            Shape::Primitive(p) => {
                let is_flat = matches!(p.kind, PrimitiveKind::Cuboid | PrimitiveKind::Square);
                let normal = if is_flat {
                    p.point(item.face as usize, 0.5, 0.5).normal
                } else {
                    DVec3::ZERO
                };
                (normal, p.material)
            }
            Shape::Exact(_) => (DVec3::ZERO, leaves[item.face as usize].material()),
        };
        let surface = &scene.materials[material as usize];
        ItemSurface {
            normal: normal.as_vec3().to_array(),
            material,
            is_specular: surface.is_specular(),
            is_emitter: !emissions[material as usize].is_black(),
        }
    }
}

/// Unit normal, in the coordinates of the mesh, and material of a triangle.
fn of_triangle(mesh: &Mesh, triangles: Option<&MeshTriangles>, item: &Item) -> (DVec3, MaterialId) {
    let corners = triangles.map(|t| t.corners_of(mesh, item.face, item.triangle));
    let normal = corners.map_or(DVec3::ZERO, |corners| {
        let vertices = corners.map(|k| mesh.faces.corners[k as usize]);
        let [a, b, c] = vertices.map(|v| mesh.positions[v as usize]);
        (b - a).cross(c - a).normalize_or_zero()
    });
    (normal, mesh.face_materials[item.face as usize])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_of_a_mesh_are_those_of_its_faces() {
        let corner = |k: u32| {
            let (sin, cos) = (0.7 * f64::from(k)).sin_cos();
            DVec3::new(cos, sin, 0.0)
        };
        let mut mesh = Mesh {
            positions: (0..9).map(corner).collect(),
            ..Mesh::default()
        };
        for face in [&[0, 1, 2, 3, 4][..], &[2, 4, 6], &[0, 5, 3, 7], &[8, 1, 5]] {
            mesh.push_face(face, 0);
        }
        let triangles = MeshTriangles::new(&mesh);
        for face in 0..mesh.faces.len() {
            let start = mesh.faces.starts[face];
            for (k, expected) in (0..).zip(mesh.triangulate(face)) {
                let corners = triangles.corners_of(&mesh, face as u32, k);
                assert_eq!(corners, expected.map(|c| start + c), "face {face}");
            }
        }
    }
}
