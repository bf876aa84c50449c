//! The tracer: a scene prepared for rays.

mod assemble;
mod periodic;
mod placed;
mod transparency;
mod twins;

use crate::exact::point_on_triangle;
use crate::frame::{LocalFrame, double, single};
use crate::hit::{Hit, Item};
use crate::kernel::{
    Bvh, ExternalKernel, InstructionSet, Kernel, KernelHit, KernelRay, KernelScene,
};
use assemble::assemble;
use azulejo_scene::Scene;
use azulejo_scene::math::{Aabb, Ray};
use glam::DVec3;
pub use periodic::PeriodError;
use periodic::PeriodicCell;
use placed::Placed;
use transparency::ItemTransparencies;

/// The offset of [`Tracer::leaving`], in units of the rounding of local coordinates.
const LEAVING_ULPS: f64 = 16.0;

/// Rays per batch that are traced through our own kernel after another kernel's triangles.
const PIECE: usize = 64;

/// A ray that hits nothing.
const NO_RAY: KernelRay = KernelRay {
    origin: [0.0; 3],
    t_min: 0.0,
    direction: [0.0; 3],
    t_max: 0.0,
};

/// A scene prepared for ray queries: the first surface that a ray hits, and whether it hits any.
///
/// Immutable, with a copy of all required data, `Send` and `Sync`. It relies on the invariants of
/// [`Scene::validate`]; triangles with a coordinate that is not finite or without area are left
/// out.
///
/// The kernel works in `f32`, relative to the scene's centre and size, so distant and huge models
/// lose no precision: relative to those of most of it, if a few things lie far away from all others, or reach
/// far away, as the ground of a town.
/// [`resolve`](Tracer::resolve) computes the point again in `f64`. All surfaces
/// are hit from both sides. A mesh that many instances share is prepared once. The tests of boxes and triangles are watertight: no ray slips through
/// between two triangles that share an edge.
///
/// A ray passes a surface that is not opaque ([`Opacity`](azulejo_scene::Opacity)) by chance, with the
/// probability 1 − opacity: keyed on the ray and the surface, so that equal rays hit the same.
/// [`transmittance`](Tracer::transmittance) returns the share that passes, without chance. A scene
/// without such surfaces pays nothing for it.
#[derive(Clone, Debug)]
pub struct Tracer {
    pub(crate) bvh: Bvh,
    /// The other kernel with the triangles, if they are not in `bvh`.
    pub(crate) external: Option<ExternalKernel>,
    pub(crate) instructions: InstructionSet,
    pub(crate) frame: LocalFrame,
    pub(crate) bounds: Aabb,
    /// The largest of the frame's reach and its instances', in world units.
    pub(crate) reach: f64,
    pub(crate) meshes: Vec<MeshPositions>,
    pub(crate) triangles: Vec<TriangleItem>,
    /// Ordered by their first item.
    pub(crate) others: Vec<Placed>,
    pub(crate) items: u32,
    /// Items before those of instances.
    own_items: u32,
    prototypes: u32,
    /// What lets light pass; `None` if nothing does.
    transparencies: Option<ItemTransparencies>,
    /// What is repeated; `None` if the scene stands alone.
    cell: Option<PeriodicCell>,
}

#[derive(Clone, Debug)]
pub(crate) struct MeshPositions {
    pub object: u32,
    pub first_item: u32,
    pub positions: Vec<DVec3>,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct TriangleItem {
    pub vertices: [u32; 3],
    pub face: u32,
    pub triangle: u32,
}

impl Tracer {
    /// Prepares a scene.
    ///
    /// # Panics
    /// For more than 2^26 packets of up to four triangles.
    pub fn new(scene: &Scene) -> Tracer {
        assemble(scene, &Kernel::Own)
    }

    /// Prepares a scene for the given kernel. If that runs out of memory, our own is used;
    /// [`kernel`](Tracer::kernel) returns the one in use.
    ///
    /// # Panics
    /// As [`new`](Tracer::new).
    pub fn with_kernel(scene: &Scene, kernel: &Kernel) -> Tracer {
        assemble(scene, kernel)
    }

    /// The kernel that traces triangles.
    pub fn kernel(&self) -> Kernel {
        self.external
            .as_ref()
            .map_or(Kernel::Own, ExternalKernel::kernel)
    }

    /// Its name, for reports: `built-in kernel, AVX2` or `Embree 3.13.5`.
    pub fn kernel_name(&self) -> String {
        match &self.external {
            None => format!("built-in kernel, {}", self.instructions.name()),
            Some(external) => external.name(),
        }
    }

    /// The first surface that the ray hits.
    pub fn hit(&self, ray: &Ray) -> Option<Hit> {
        let mut hit = KernelHit::NOTHING;
        self.closest_into(&[self.kernel_ray(ray)], std::slice::from_mut(&mut hit));
        hit.is_hit().then(|| self.resolve(ray, &hit))
    }

    /// Whether the ray hits any surface.
    pub fn occluded(&self, ray: &Ray) -> bool {
        let mut blocked = false;
        self.any_into(&[self.kernel_ray(ray)], std::slice::from_mut(&mut blocked));
        blocked
    }

    /// The ray in the kernel's coordinates; `t` means the same on both.
    pub fn kernel_ray(&self, ray: &Ray) -> KernelRay {
        KernelRay {
            origin: single(self.frame.point(ray.origin)),
            t_min: ray.t_min as f32,
            direction: single(self.frame.vector(ray.direction)),
            t_max: ray.t_max as f32,
        }
    }

    /// The ray in world coordinates, as exact as `f32` allows.
    pub fn world_ray(&self, ray: &KernelRay) -> Ray {
        Ray {
            origin: self.frame.world_point(double(ray.origin)),
            direction: self.frame.world_vector(double(ray.direction)),
            t_min: f64::from(ray.t_min),
            t_max: f64::from(ray.t_max),
        }
    }

    /// The first hit of each ray; `hits` is cleared and gets one entry per ray.
    ///
    /// Runs on the calling thread; callers split their rays.
    pub fn closest(&self, rays: &[KernelRay], hits: &mut Vec<KernelHit>) {
        hits.clear();
        hits.resize(rays.len(), KernelHit::NOTHING);
        self.closest_into(rays, hits);
    }

    /// Whether each ray hits anything; `blocked` is cleared and gets one entry per ray.
    ///
    /// Runs on the calling thread; callers split their rays.
    pub fn any(&self, rays: &[KernelRay], blocked: &mut Vec<bool>) {
        blocked.clear();
        blocked.resize(rays.len(), false);
        self.any_into(rays, blocked);
    }

    /// The smallest box around all surfaces; around the boxes of instances.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Number of items: items are 0..this.
    pub fn item_count(&self) -> u32 {
        self.items
    }

    /// The surface that an item number stands for.
    ///
    /// # Panics
    /// If the tracer has no item with this number.
    pub fn item(&self, item: u32) -> Item {
        if let Some(t) = self.triangles.get(item as usize) {
            return Item {
                object: self.mesh_of(item).object,
                face: t.face,
                triangle: t.triangle,
                is_primitive: false,
            };
        }
        match self.other_of(item) {
            Placed::Triangle(t) => self.item(t.item),
            Placed::Primitive(p) => Item {
                object: p.object,
                face: item - p.first_item,
                triangle: 0,
                is_primitive: true,
            },
            Placed::Exact(e) => Item {
                object: e.object,
                face: item - e.first_item + e.first_leaf,
                triangle: 0,
                is_primitive: false,
            },
            Placed::Instance(i) => Item {
                object: i.object,
                ..i.tracer.item(item - i.first_item)
            },
        }
    }

    /// Number of prototypes: prototypes are 0..this.
    pub fn prototype_count(&self) -> u32 {
        self.prototypes
    }

    /// The prototype of an item: the number under which to keep what all instances of a triangle share.
    /// Items of no instance are their own.
    ///
    /// # Panics
    /// If the tracer has no item with this number.
    #[inline]
    pub fn prototype(&self, item: u32) -> u32 {
        if item < self.own_items {
            return item;
        }
        match self.other_of(item) {
            Placed::Instance(i) => item - i.first_item + i.first_prototype,
            Placed::Triangle(_) | Placed::Primitive(_) | Placed::Exact(_) => item,
        }
    }

    /// Whether an item belongs to an instance, so that it shares its prototype with others.
    #[inline]
    pub fn is_instanced(&self, item: u32) -> bool {
        item >= self.own_items
    }

    /// The items of prototypes, each once, in the order of prototypes: those of the first instance
    /// for shared meshes.
    pub fn prototype_items(&self) -> Vec<u32> {
        let mut items: Vec<u32> = (0..self.own_items).collect();
        for other in &self.others {
            if let Placed::Instance(i) = other
                && i.first_prototype as usize == items.len()
            {
                items.extend(i.first_item..i.first_item + i.tracer.item_count());
            }
        }
        items
    }

    /// A normal of an item's mesh in the world, of another length.
    #[inline]
    pub(crate) fn world_normal(&self, item: u32, normal: DVec3) -> DVec3 {
        if item < self.own_items {
            return normal;
        }
        match self.other_of(item) {
            Placed::Instance(i) => i.world_normals * normal,
            Placed::Triangle(_) | Placed::Primitive(_) | Placed::Exact(_) => normal,
        }
    }

    /// The surface point of a hit, computed again in double precision.
    ///
    /// The position lies on the surface to `f64` rounding; along the ray it agrees with the hit up
    /// to the kernel's rounding.
    ///
    /// # Panics
    /// For a miss, or a hit of another tracer.
    pub fn resolve(&self, ray: &Ray, hit: &KernelHit) -> Hit {
        let item = self.item(hit.item);
        let ray = &self.in_own_cell(ray, f64::from(hit.t));
        let point = if (hit.item as usize) < self.triangles.len() {
            point_on_triangle(self.triangle_corners(hit.item), ray, f64::from(hit.t))
        } else {
            self.other_of(hit.item).resolve(&self.frame, ray, hit)
        };
        Hit {
            t: point.t,
            object: item.object,
            face: item.face,
            triangle: item.triangle.max(point.part),
            u: point.u,
            v: point.v,
            position: point.position,
            normal: point.normal,
            entering: point.normal.dot(ray.direction) < 0.0,
            item: hit.item,
        }
    }

    /// Position and unit normal of the surface at a hit. The position lies on the surface to `f64` rounding, and within
    /// it where the kernel says, to `f32` rounding.
    ///
    /// # Panics
    /// As [`resolve`](Tracer::resolve).
    pub fn surface_point(&self, ray: &KernelRay, hit: &KernelHit) -> (DVec3, DVec3) {
        if self.cell.is_none() && (hit.item as usize) < self.triangles.len() {
            let [a, b, c] = self.triangle_corners(hit.item);
            let [u, v] = hit.uv().map(f64::from);
            let (ab, ac) = (b - a, c - a);
            let normal = ab.cross(ac).normalize_or_zero();
            return (a + u * ab + v * ac, normal);
        }
        let hit = self.resolve(&self.world_ray(ray), hit);
        (hit.position, hit.normal)
    }

    /// The origin for rays that leave the surface at `position` towards the side of the unit vector
    /// `normal`: no ray from there to that side hits the surface that it leaves.
    ///
    /// The offset is 16 · 2⁻²³ times the largest of: the position's distance from the scene's
    /// centre (along an axis), half the scene's largest extent, and that of each instance; without
    /// what lies or reaches far away from all others. In a room of 10 units: 1e-5 units.
    pub fn leaving(&self, position: DVec3, normal: DVec3) -> DVec3 {
        let away = self.frame.distance(position);
        let step = LEAVING_ULPS * f64::from(f32::EPSILON) * away.max(self.reach);
        position + step * normal
    }

    /// Whether it has triangles of meshes and nothing else.
    pub(crate) fn has_triangles_alone(&self) -> bool {
        let is_triangle = |other: &Placed| matches!(other, Placed::Triangle(_));
        self.cell.is_none() && self.others.iter().all(is_triangle)
    }

    /// Corners of a triangle of a mesh, by its item.
    pub(crate) fn triangle_corners(&self, item: u32) -> [DVec3; 3] {
        let positions = &self.mesh_of(item).positions;
        let vertices = self.triangles[item as usize].vertices;
        vertices.map(|v| positions[v as usize])
    }

    pub(crate) fn closest_into(&self, rays: &[KernelRay], hits: &mut [KernelHit]) {
        self.kernel_closest(rays, hits);
        if let Some(transparencies) = &self.transparencies {
            self.follow_through(transparencies, rays, hits);
        }
    }

    pub(crate) fn any_into(&self, rays: &[KernelRay], blocked: &mut [bool]) {
        self.kernel_any(rays, blocked);
        if let Some(transparencies) = &self.transparencies {
            self.clear_passed(transparencies, rays, blocked);
        }
    }

    /// The first surface on each ray, whether light passes through it or not.
    fn kernel_closest(&self, rays: &[KernelRay], hits: &mut [KernelHit]) {
        match &self.cell {
            None => self.own_closest(rays, hits),
            Some(cell) => self.closest_in_cells(cell, rays, hits),
        }
    }

    /// The same of the scene itself, without its copies.
    fn own_closest(&self, rays: &[KernelRay], hits: &mut [KernelHit]) {
        let Some(external) = &self.external else {
            return self.instructions.closest(&self.kernel_scene(), rays, hits);
        };
        external.closest(rays, hits);
        if self.others.is_empty() {
            return;
        }
        // Shapes that are nearer than the triangles, in batches that need no allocation.
        for (rays, hits) in rays.chunks(PIECE).zip(hits.chunks_mut(PIECE)) {
            let mut nearer = [NO_RAY; PIECE];
            for ((to, ray), hit) in nearer.iter_mut().zip(rays).zip(&*hits) {
                let t_max = if hit.is_hit() {
                    hit.t.next_up()
                } else {
                    ray.t_max
                };
                *to = KernelRay { t_max, ..*ray };
            }
            let mut other_hits = [KernelHit::NOTHING; PIECE];
            let (nearer, other_hits) = (&nearer[..rays.len()], &mut other_hits[..rays.len()]);
            self.instructions
                .closest(&self.kernel_scene(), nearer, other_hits);
            for (hit, other) in hits.iter_mut().zip(&*other_hits) {
                if other.is_hit() && hit.is_after(other.t, other.item) {
                    *hit = *other;
                }
            }
        }
    }

    /// Whether there is any surface on each ray, whether light passes through it or not.
    fn kernel_any(&self, rays: &[KernelRay], blocked: &mut [bool]) {
        if let Some(cell) = &self.cell {
            return self.any_in_cells(cell, rays, blocked);
        }
        let Some(external) = &self.external else {
            return self.instructions.any(&self.kernel_scene(), rays, blocked);
        };
        external.any(rays, blocked);
        if self.others.is_empty() {
            return;
        }
        for (rays, blocked) in rays.chunks(PIECE).zip(blocked.chunks_mut(PIECE)) {
            let mut shadows = [false; PIECE];
            let shadows = &mut shadows[..rays.len()];
            self.instructions.any(&self.kernel_scene(), rays, shadows);
            blocked.iter_mut().zip(&*shadows).for_each(|(b, f)| *b |= f);
        }
    }

    pub(crate) fn kernel_scene(&self) -> KernelScene<'_, [Placed]> {
        KernelScene {
            bvh: &self.bvh,
            others: &self.others,
        }
    }

    fn mesh_of(&self, item: u32) -> &MeshPositions {
        let after = self.meshes.partition_point(|m| m.first_item <= item);
        &self.meshes[after - 1]
    }

    fn other_of(&self, item: u32) -> &Placed {
        assert!(item < self.items, "item {item} of {}", self.items);
        // Shapes of one item each, of which most scenes consist, need no search.
        let alone = item.wrapping_sub(self.others[0].first_item()) as usize;
        if self
            .others
            .get(alone)
            .is_some_and(|o| o.first_item() == item)
        {
            return &self.others[alone];
        }
        let after = self.others.partition_point(|o| o.first_item() <= item);
        &self.others[after - 1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::{MeshInstance, Object, Primitive, PrimitiveKind, Rgb};
    use glam::DAffine3;
    use std::sync::Arc;

    fn scene(shapes: Vec<azulejo_scene::Shape>) -> Scene {
        let mut scene = Scene::default();
        scene.add_material(azulejo_scene::Material::diffuse("grey", Rgb::grey(0.5)));
        scene.objects = shapes.into_iter().map(|s| Object::new("", s)).collect();
        scene
    }

    fn box_at(corner: DVec3) -> Primitive {
        let map = DAffine3::from_translation(corner);
        Primitive::new(PrimitiveKind::Cuboid, map, 0)
    }

    #[test]
    fn empty_scene_is_never_hit() {
        let tracer = Tracer::new(&Scene::default());
        let ray = Ray::new(DVec3::ZERO, DVec3::X);
        assert_eq!(tracer.hit(&ray), None);
        assert!(!tracer.occluded(&ray) && tracer.bounds().is_empty());
        assert_eq!(tracer.item_count(), 0);
    }

    #[test]
    fn hits_of_mesh_primitive_and_instance_agree() {
        let far = DVec3::new(4e5, 5e6, 100.0);
        let shape = box_at(far);
        let mesh = shape.tessellate(&shape.grids(1.0, f64::INFINITY));
        let as_mesh = Tracer::new(&scene(vec![azulejo_scene::Shape::Mesh(mesh)]));
        let as_primitive = Tracer::new(&scene(vec![azulejo_scene::Shape::Primitive(shape)]));
        let unit = box_at(DVec3::ZERO);
        let unit = unit.tessellate(&unit.grids(1.0, f64::INFINITY));
        let placed = MeshInstance::new(Arc::new(unit), DAffine3::from_translation(far));
        let shape = azulejo_scene::Shape::Instance(placed.unwrap());
        let as_instance = Tracer::new(&scene(vec![shape]));
        let ray = Ray::new(far + DVec3::new(0.25, 0.5, 3.0), -DVec3::Z);
        for tracer in [&as_mesh, &as_primitive, &as_instance] {
            let hit = tracer.hit(&ray).unwrap();
            assert!((hit.t - 2.0).abs() < 1e-9, "{hit:?}");
            assert!(
                (hit.normal - DVec3::Z).length() < 1e-12 && hit.entering,
                "{hit:?}"
            );
            assert!((hit.position - ray.at(2.0)).length() < 1e-9, "{hit:?}");
            assert!(tracer.occluded(&ray));
            assert!(!tracer.occluded(&Ray { t_max: 2.0, ..ray }));
            assert!(tracer.occluded(&Ray { t_min: 2.5, ..ray }));
        }
        assert_eq!(as_primitive.hit(&ray).unwrap().face, 5);
    }
}
