//! The tracer: a scene made ready for rays.

use crate::assemble::{LocalFrame, assemble, double, single};
use crate::bvh::Bvh;
use crate::kernel::{Others, Surroundings, is_better};
use crate::primitive::ExactPrimitive;
use crate::ray::{Hit, Item, KernelHit, KernelRay};
use crate::simd::Level;
use crate::triangle;
use azulejo_scene::Scene;
use azulejo_scene::math::{Aabb, Ray, normal_matrix};
use glam::{DAffine3, DVec3};
use std::sync::Arc;

/// How far [`Tracer::leaving`] moves, in units of the local coordinates' rounding.
const LEAVING_ULPS: f64 = 16.0;

/// A scene made ready for rays: which surface does a ray meet first, and is it blocked?
///
/// Immutable, a copy of all it needs, `Send` and `Sync`. It relies on the promises of
/// [`Scene::validate`]; triangles with a coordinate that is not finite are left out, so are those
/// without area.
///
/// The kernel works in `f32`, relative to the scene's centre and size, so far-away and huge models
/// keep their digits; [`resolve`](Tracer::resolve) computes the point again in `f64`. All
/// surfaces are met from both sides. The tests of boxes and triangles are watertight: no ray
/// slips through between two triangles that share an edge.
#[derive(Clone, Debug)]
pub struct Tracer {
    pub(crate) bvh: Bvh,
    pub(crate) level: Level,
    pub(crate) frame: LocalFrame,
    pub(crate) bounds: Aabb,
    /// The largest of half the scene's size and its instances' reaches, in world units.
    pub(crate) reach: f64,
    pub(crate) meshes: Vec<MeshPositions>,
    pub(crate) triangles: Vec<TriangleItem>,
    /// Ordered by their first item.
    pub(crate) others: Vec<Other>,
    pub(crate) items: u32,
}

/// A tracer placed in another tracer's world.
#[derive(Clone, Debug)]
pub struct Instance {
    /// What is placed.
    pub tracer: Arc<Tracer>,
    /// Where; invertible, or the instance is left out.
    pub world_from_instance: DAffine3,
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

#[derive(Clone, Debug)]
pub(crate) enum Other {
    Primitive {
        object: u32,
        first_item: u32,
        shape: Box<ExactPrimitive>,
    },
    Instance {
        index: u32,
        first_item: u32,
        tracer: Arc<Tracer>,
        world_from_instance: DAffine3,
        instance_from_world: DAffine3,
        /// From this tracer's kernel coordinates to the instance's.
        inner_from_local: DAffine3,
    },
}

impl Other {
    fn first_item(&self) -> u32 {
        match self {
            Other::Primitive { first_item, .. } | Other::Instance { first_item, .. } => *first_item,
        }
    }
}

impl Tracer {
    /// Prepares a scene.
    ///
    /// # Panics
    /// For more than 2^26 packets of up to four triangles.
    pub fn new(scene: &Scene) -> Tracer {
        Tracer::with_instances(scene, Vec::new())
    }

    /// Prepares a scene with other tracers placed in it; their triangles are not copied.
    ///
    /// # Panics
    /// If the scene and all its instances have more than 2^32 − 1 items together, or the scene
    /// itself more than 2^26 packets of up to four triangles.
    pub fn with_instances(scene: &Scene, instances: Vec<Instance>) -> Tracer {
        assemble(scene, instances)
    }

    /// The first surface that the ray meets.
    pub fn hit(&self, ray: &Ray) -> Option<Hit> {
        let mut hit = [KernelHit::NOTHING];
        let rays = [self.kernel_ray(ray)];
        self.level.closest(&self.surroundings(), &rays, &mut hit);
        hit[0].is_hit().then(|| self.resolve(ray, &hit[0]))
    }

    /// Whether the ray meets any surface.
    pub fn occluded(&self, ray: &Ray) -> bool {
        let mut blocked = [false];
        let rays = [self.kernel_ray(ray)];
        self.level.any(&self.surroundings(), &rays, &mut blocked);
        blocked[0]
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

    /// The ray in the world again, as exact as `f32` kept it.
    pub fn world_ray(&self, ray: &KernelRay) -> Ray {
        let double = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        Ray {
            origin: self.frame.world_point(double(ray.origin)),
            direction: self.frame.world_vector(double(ray.direction)),
            t_min: f64::from(ray.t_min),
            t_max: f64::from(ray.t_max),
        }
    }

    /// First meeting of each ray; `hits` is cleared and gets one entry per ray.
    ///
    /// Runs on the calling thread; callers split their rays.
    pub fn closest(&self, rays: &[KernelRay], hits: &mut Vec<KernelHit>) {
        hits.clear();
        hits.resize(rays.len(), KernelHit::NOTHING);
        self.level.closest(&self.surroundings(), rays, hits);
    }

    /// Whether each ray meets anything; `blocked` is cleared and gets one entry per ray.
    ///
    /// Runs on the calling thread; callers split their rays.
    pub fn any(&self, rays: &[KernelRay], blocked: &mut Vec<bool>) {
        blocked.clear();
        blocked.resize(rays.len(), false);
        self.level.any(&self.surroundings(), rays, blocked);
    }

    /// The smallest box around all surfaces; around the boxes of instances.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Number of items: items are 0..this.
    pub fn item_count(&self) -> u32 {
        self.items
    }

    /// What an item's number means.
    ///
    /// # Panics
    /// For a number that no hit of this tracer has.
    pub fn item(&self, item: u32) -> Item {
        if let Some(t) = self.triangles.get(item as usize) {
            return Item {
                object: self.mesh_of(item).object,
                face: t.face,
                triangle: t.triangle,
                is_primitive: false,
                instance: None,
            };
        }
        match self.other_of(item) {
            Other::Primitive {
                object, first_item, ..
            } => Item {
                object: *object,
                face: item - first_item,
                triangle: 0,
                is_primitive: true,
                instance: None,
            },
            Other::Instance {
                index,
                first_item,
                tracer,
                ..
            } => Item {
                instance: Some(*index),
                ..tracer.item(item - first_item)
            },
        }
    }

    /// The surface point of a hit, computed again in double precision.
    ///
    /// The position lies on the surface to `f64` rounding; it is the ray's point up to the
    /// kernel's rounding.
    ///
    /// # Panics
    /// For a miss, or a hit of another tracer.
    pub fn resolve(&self, ray: &Ray, hit: &KernelHit) -> Hit {
        let item = self.item(hit.item);
        let (t, u, v, position, normal) = match self.triangles.get(hit.item as usize) {
            Some(triangle) => {
                let mesh = self.mesh_of(hit.item);
                let corners = triangle.vertices.map(|v| mesh.positions[v as usize]);
                let p = triangle::meet(corners, ray, f64::from(hit.t));
                (p.t, p.u, p.v, p.position, p.normal)
            }
            None => match self.other_of(hit.item) {
                Other::Primitive { shape, .. } => {
                    resolve_primitive(shape, item.face as usize, ray, hit)
                }
                Other::Instance {
                    first_item,
                    tracer,
                    world_from_instance,
                    instance_from_world,
                    ..
                } => {
                    let inner_ray = Ray {
                        origin: instance_from_world.transform_point3(ray.origin),
                        direction: instance_from_world.transform_vector3(ray.direction),
                        ..*ray
                    };
                    let inner_hit = KernelHit {
                        item: hit.item - first_item,
                        ..*hit
                    };
                    let h = tracer.resolve(&inner_ray, &inner_hit);
                    let normal = normal_matrix(world_from_instance.matrix3) * h.normal;
                    let position = world_from_instance.transform_point3(h.position);
                    (h.t, h.u, h.v, position, normal.normalize_or_zero())
                }
            },
        };
        Hit {
            t,
            object: item.object,
            face: item.face,
            triangle: item.triangle,
            u,
            v,
            position,
            normal,
            entering: normal.dot(ray.direction) < 0.0,
            item: hit.item,
            instance: item.instance,
        }
    }

    /// Where a ray may start that leaves the surface at `position` to the side of the unit vector
    /// `normal`: no ray from there toward that side meets the surface it leaves.
    ///
    /// It moves by 16 · 2⁻²³ times the largest of: the position's distance from the scene's
    /// centre (along an axis), half the scene's largest extent, and that of each instance. In a
    /// room of 10 units: 1e-5 units.
    pub fn leaving(&self, position: DVec3, normal: DVec3) -> DVec3 {
        let away = self.frame.distance(position);
        let step = LEAVING_ULPS * f64::from(f32::EPSILON) * away.max(self.reach);
        position + step * normal
    }

    fn surroundings(&self) -> Surroundings<'_, Tracer> {
        Surroundings {
            bvh: &self.bvh,
            others: self,
        }
    }

    fn mesh_of(&self, item: u32) -> &MeshPositions {
        let after = self.meshes.partition_point(|m| m.first_item <= item);
        &self.meshes[after - 1]
    }

    fn other_of(&self, item: u32) -> &Other {
        assert!(item < self.items, "item {item} of {}", self.items);
        let after = self.others.partition_point(|o| o.first_item() <= item);
        &self.others[after - 1]
    }
}

fn resolve_primitive(
    shape: &ExactPrimitive,
    part: usize,
    ray: &Ray,
    hit: &KernelHit,
) -> (f64, f64, f64, DVec3, DVec3) {
    let line = shape.world_line(ray.origin, ray.direction);
    let (t, u, v) = match shape.nearest_to(&line, f64::from(hit.t)) {
        // By rounding another part may be met; then the kernel's own answer stands.
        Some(p) if p.part == part => (p.t, p.u, p.v),
        _ => (f64::from(hit.t), f64::from(hit.u), f64::from(hit.v)),
    };
    let point = shape.shape.point(part, u, v);
    (t, u, v, point.position, point.normal)
}

impl Others for Tracer {
    fn closest(&self, shape: u32, ray: &KernelRay, hit: &mut KernelHit) {
        match &self.others[shape as usize] {
            Other::Primitive {
                first_item, shape, ..
            } => {
                let line = shape.local_line(double(ray.origin), double(ray.direction));
                let t_min = f64::from(ray.t_min.max(0.0));
                if let Some(p) = shape.first(&line, t_min, f64::from(hit.t)) {
                    let (t, item) = (p.t as f32, first_item + p.part as u32);
                    if is_better(t, item, hit) {
                        *hit = KernelHit {
                            t,
                            item,
                            u: p.u as f32,
                            v: p.v as f32,
                        };
                    }
                }
            }
            Other::Instance {
                first_item,
                tracer,
                inner_from_local,
                ..
            } => {
                let inner = [inner_ray(inner_from_local, ray, hit.t)];
                let mut found = [KernelHit::NOTHING];
                tracer
                    .level
                    .closest(&tracer.surroundings(), &inner, &mut found);
                let [mut found] = found;
                if found.is_hit() {
                    found.item += first_item;
                    if is_better(found.t, found.item, hit) {
                        *hit = found;
                    }
                }
            }
        }
    }

    fn any(&self, shape: u32, ray: &KernelRay, t_max: f32) -> bool {
        match &self.others[shape as usize] {
            Other::Primitive { shape, .. } => {
                let line = shape.local_line(double(ray.origin), double(ray.direction));
                let t_min = f64::from(ray.t_min.max(0.0));
                shape.first(&line, t_min, f64::from(t_max)).is_some()
            }
            Other::Instance {
                tracer,
                inner_from_local,
                ..
            } => {
                let mut blocked = [false];
                let inner = [inner_ray(inner_from_local, ray, t_max)];
                tracer
                    .level
                    .any(&tracer.surroundings(), &inner, &mut blocked);
                blocked[0]
            }
        }
    }
}

/// The ray in an instance, up to and including `last`.
fn inner_ray(inner_from_local: &DAffine3, ray: &KernelRay, last: f32) -> KernelRay {
    KernelRay {
        t_max: last.next_up(),
        origin: single(inner_from_local.transform_point3(double(ray.origin))),
        direction: single(inner_from_local.transform_vector3(double(ray.direction))),
        ..*ray
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::{Object, Primitive, PrimitiveKind, Rgb};

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
        let unit = Tracer::new(&scene(vec![azulejo_scene::Shape::Primitive(box_at(
            DVec3::ZERO,
        ))]));
        let as_instance = Tracer::with_instances(
            &Scene::default(),
            vec![Instance {
                tracer: Arc::new(unit),
                world_from_instance: DAffine3::from_translation(far),
            }],
        );
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
        assert_eq!(as_instance.hit(&ray).unwrap().instance, Some(0));
    }
}
