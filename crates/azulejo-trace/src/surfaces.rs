//! What light transport asks of a surface at every hit, kept per traced item.

use crate::{Hit, Item, KernelHit, KernelRay, Tracer};
use azulejo_scene::brdf::Lobes;
use azulejo_scene::math::Frame;
use azulejo_scene::{Leaf, Material, MaterialId, PrimitiveKind, Scene, Shape};
use glam::DVec3;

/// Cosine to the normal beyond which a direction says nothing about the tangent.
const UPRIGHT: f64 = 0.999;

/// A scene with its tracer, and for every item the normal and material that hits look up.
///
/// Immutable; made once per pass.
pub struct Surfaces<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its tracer.
    pub tracer: &'a Tracer,
    items: Vec<ItemSurface>,
    /// What each item is: apart, because few look at it and all rays look at the rest.
    names: Vec<Item>,
}

/// What every hit asks of its item.
#[derive(Clone, Copy, Debug)]
struct ItemSurface {
    /// Unit normal of the front; zero where it changes over the item.
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
        let names: Vec<Item> = (0..tracer.item_count()).map(|i| tracer.item(i)).collect();
        let surface = |item: &Item| ItemSurface::new(scene, &leaves[item.object as usize], item);
        Surfaces {
            scene,
            tracer,
            items: names.iter().map(surface).collect(),
            names,
        }
    }

    /// What an item is.
    pub fn item(&self, item: u32) -> &Item {
        &self.names[item as usize]
    }

    /// Whether light that arrives at an item can leave mirrored or refracted.
    pub fn is_specular(&self, item: u32) -> bool {
        self.items[item as usize].is_specular
    }

    /// Whether the front of an item shines by itself.
    pub fn is_emitter(&self, item: u32) -> bool {
        self.items[item as usize].is_emitter
    }

    /// Material of an item.
    pub fn material_id(&self, item: u32) -> MaterialId {
        self.items[item as usize].material
    }

    /// Material of an item.
    pub fn material(&self, item: u32) -> &'a Material {
        &self.scene.materials[self.material_id(item) as usize]
    }

    /// The glossy lobes of an item, which light may leave by in chosen directions.
    pub fn glossy(&self, item: u32) -> Option<&'a Lobes> {
        if !self.is_specular(item) {
            return None;
        }
        self.material(item).glossy()
    }

    /// The frame in which reflection models are evaluated at a hit: `z` is `normal`, `x` the way
    /// in which the first texture coordinate grows.
    ///
    /// Where there are no texture coordinates, `x` is the world's x axis as far as it lies in the
    /// surface, or y where that stands nearly upright on it: brushes are drawn along an axis.
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
        let Shape::Mesh(mesh) = &self.scene.objects[at.object as usize].shape else {
            return None;
        };
        let uvs = mesh.uvs.as_ref()?;
        let face = at.face as usize;
        let start = mesh.faces.corner_range(face).start;
        let triangles = mesh.triangulate(face);
        let corners = triangles.get(at.triangle as usize)?;
        let corners = corners.map(|k| start + k as usize);
        let vertices = corners.map(|k| mesh.faces.corners[k]);
        let [a, b, c] = vertices.map(|v| mesh.positions[v as usize]);
        let [ta, tb, tc] = [0, 1, 2].map(|k| uvs.at(corners[k], vertices[k]));
        let (d1, d2) = (tb - ta, tc - ta);
        let along = (d2.y * (b - a) - d1.y * (c - a)) * d1.perp_dot(d2).signum();
        along.try_normalize()
    }

    /// Unit normal of the front of a flat item; `None` where the item is curved.
    pub fn flat_normal(&self, item: u32) -> Option<DVec3> {
        let n = self.items[item as usize].normal;
        (n != [0.0; 3]).then(|| DVec3::new(n[0].into(), n[1].into(), n[2].into()))
    }

    /// Whether the ray that made `hit` arrives at the front.
    pub fn is_front(&self, ray: &KernelRay, hit: &KernelHit) -> bool {
        let (n, d) = (self.items[hit.item as usize].normal, ray.direction);
        if n == [0.0; 3] {
            return self
                .tracer
                .resolve(&self.tracer.world_ray(ray), hit)
                .entering;
        }
        n[0] * d[0] + n[1] * d[1] + n[2] * d[2] < 0.0
    }
}

impl ItemSurface {
    fn new(scene: &Scene, leaves: &[Leaf], item: &Item) -> ItemSurface {
        let (normal, material) = match &scene.objects[item.object as usize].shape {
            Shape::Mesh(mesh) => {
                let face = item.face as usize;
                let corners = mesh
                    .triangulate(face)
                    .get(item.triangle as usize)
                    .copied()
                    .unwrap_or([0, 1, 2]);
                let vertices = mesh.faces.get(face);
                let [a, b, c] = corners.map(|k| mesh.positions[vertices[k as usize] as usize]);
                (
                    (b - a).cross(c - a).normalize_or_zero(),
                    mesh.face_materials[face],
                )
            }
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
            is_emitter: surface.is_emitter(),
        }
    }
}
