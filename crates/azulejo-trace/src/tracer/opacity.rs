//! Surfaces through which light passes straight: which rays go on behind a hit.
//!
//! Whether a ray stops at a surface of opacity α is decided by a number in 0..1 that is keyed on the ray
//! and on the surface (stochastic transparency: Enderton, Sintorn, Shirley and Luebke, I3D 2010). So
//! what a ray hits does not depend on other rays, on the batch or on the thread; the mean over many
//! rays is right, and their spread shows in the standard errors that all estimates carry. A ray that
//! stops meets the surface with its whole weight: α of the light is taken, 1 − α passes.

use super::Tracer;
use crate::kernel::{KernelHit, KernelRay};
use crate::sampling::{hash, uniform};
use azulejo_scene::{Exact, Leaf, Mesh, Opacity, OpacityMap, OpacityPicture, Scene, Shape};
use glam::DVec2;
use std::collections::HashMap;

/// The opacities of a tracer's items. Takes 4 bytes per prototype, 80 more for each triangle that shows a
/// picture of its opacity, and 4 per pixel of these pictures.
#[derive(Clone, Debug)]
pub(crate) struct ItemOpacities {
    /// For each prototype 0 if it is opaque, else one more than the index of its opacity in `list`.
    of_prototypes: Vec<u32>,
    list: Vec<ItemOpacity>,
    maps: Vec<OpacityMap>,
}

/// The opacity of an item.
#[derive(Clone, Copy, Debug)]
enum ItemOpacity {
    /// The same everywhere.
    Even(f64),
    /// By a map, over a triangle with these texture coordinates.
    Mapped {
        opacity: Opacity,
        map: u32,
        uvs: [DVec2; 3],
    },
}

/// ItemOpacities while they are collected.
struct OpacityBuilder<'s> {
    scene: &'s Scene,
    opacities: ItemOpacities,
    /// Index of the map of each picture; `None` where it is opaque everywhere or not loaded.
    known: HashMap<(u32, u8), Option<u32>>,
    /// Index of the opacity of each material, where it does not depend on the triangle.
    even: HashMap<u32, u32>,
    /// The triangles of the last face: the items of a face follow each other.
    last: Option<FaceTriangles>,
}

/// The triangles of a face, as numbers of its corners.
struct FaceTriangles {
    object: u32,
    face: u32,
    triangles: Vec<[u32; 3]>,
}

impl ItemOpacities {
    /// The opacities of a tracer's items; `None` if all are opaque.
    pub fn new(scene: &Scene, tracer: &Tracer) -> Option<ItemOpacities> {
        let see_through: Vec<bool> = (scene.materials.iter())
            .map(|m| m.see_through().is_some())
            .collect();
        if !see_through.contains(&true) {
            return None;
        }
        let mut builder = OpacityBuilder {
            scene,
            opacities: ItemOpacities {
                of_prototypes: Vec::new(),
                list: Vec::new(),
                maps: Vec::new(),
            },
            known: HashMap::new(),
            even: HashMap::new(),
            last: None,
        };
        let leaves = scene.objects.iter().map(|object| match &object.shape {
            Shape::Exact(exact) => Exact::leaves(exact),
            _ => Vec::new(),
        });
        let leaves: Vec<Vec<Leaf>> = leaves.collect();
        for number in tracer.prototype_items() {
            let item = tracer.item(number);
            let shape = &scene.objects[item.object as usize].shape;
            let material = match shape {
                Shape::Mesh(mesh) => mesh.face_materials[item.face as usize],
                Shape::Instance(instance) => instance.mesh.face_materials[item.face as usize],
                Shape::Primitive(primitive) => primitive.material,
                Shape::Exact(_) => leaves[item.object as usize][item.face as usize].material(),
            };
            let index = match shape.mesh() {
                _ if !see_through[material as usize] => 0,
                Some(mesh) => {
                    builder.triangle(material, mesh, (item.object, item.face), item.triangle)
                }
                None => builder.even(material),
            };
            builder.opacities.of_prototypes.push(index);
        }
        let opacities = builder.opacities;
        let is_any = opacities.of_prototypes.iter().any(|&v| v > 0);
        is_any.then_some(opacities)
    }

    /// 0 for an opaque item, else one more than the index of its opacity.
    fn index(&self, tracer: &Tracer, item: u32) -> u32 {
        let prototype = tracer.prototype(item) as usize;
        self.of_prototypes.get(prototype).copied().unwrap_or(0)
    }

    /// The opacity of what a ray hits, 0..=1.
    fn opacity(&self, tracer: &Tracer, ray: &KernelRay, hit: &KernelHit) -> f64 {
        let index = self.index(tracer, hit.item);
        match index.checked_sub(1).map(|k| &self.list[k as usize]) {
            None => 1.0,
            Some(ItemOpacity::Even(opacity)) => *opacity,
            Some(ItemOpacity::Mapped { opacity, map, uvs }) => {
                let point = tracer.resolve(&tracer.world_ray(ray), hit);
                let [a, b, c] = *uvs;
                let uv = a + point.u * (b - a) + point.v * (c - a);
                opacity.at(self.maps[*map as usize].sample(uv))
            }
        }
    }

    /// Whether a ray goes on behind its hit.
    fn passes(&self, tracer: &Tracer, ray: &KernelRay, hit: &KernelHit) -> bool {
        if hit.item == KernelHit::MISS || self.index(tracer, hit.item) == 0 {
            return false;
        }
        let opacity = self.opacity(tracer, ray, hit);
        opacity < 1.0 && (opacity <= 0.0 || chance(ray, hit.item) >= opacity)
    }
}

/// A number in 0..1 for a ray and a surface.
fn chance(ray: &KernelRay, item: u32) -> f64 {
    let [x, y, z] = ray.origin.map(f32::to_bits);
    let [dx, dy, dz] = ray.direction.map(f32::to_bits);
    f64::from(uniform(&[hash(&[x, y, z, dx, dy, dz]), item]))
}

/// The ray from behind a hit on: no surface is hit twice at the same parameter.
fn behind(ray: &KernelRay, hit: &KernelHit) -> KernelRay {
    KernelRay {
        t_min: hit.t.next_up(),
        ..*ray
    }
}

impl OpacityBuilder<'_> {
    /// One more than the index of a new opacity.
    fn push(&mut self, opacity: ItemOpacity) -> u32 {
        self.opacities.list.push(opacity);
        self.opacities.list.len() as u32
    }

    /// The opacity of a surface without texture coordinates: its picture does not count.
    fn even(&mut self, material: u32) -> u32 {
        if let Some(&index) = self.even.get(&material) {
            return index;
        }
        let opacity = self.scene.materials[material as usize].see_through();
        let value = opacity.map_or(1.0, |o| o.at(1.0));
        let index = if value < 1.0 {
            self.push(ItemOpacity::Even(value))
        } else {
            0
        };
        self.even.insert(material, index);
        index
    }

    fn triangle(
        &mut self,
        material: u32,
        mesh: &Mesh,
        (object, face): (u32, u32),
        triangle: u32,
    ) -> u32 {
        let opacity = self.scene.materials[material as usize].see_through();
        let mapped = opacity.copied().and_then(|opacity| {
            let map = self.map(opacity.picture?)?;
            let uvs = mesh.uvs.as_ref()?;
            let start = mesh.faces.starts[face as usize] as usize;
            let is_last = |t: &FaceTriangles| (t.object, t.face) == (object, face);
            if !self.last.as_ref().is_some_and(is_last) {
                self.last = Some(FaceTriangles {
                    object,
                    face,
                    triangles: mesh.triangulate(face as usize),
                });
            }
            let triangles = &self.last.as_ref()?.triangles;
            let places = *triangles.get(triangle as usize)?;
            let uvs = places.map(|k| {
                let corner = start + k as usize;
                uvs.at(corner, mesh.faces.corners[corner])
            });
            Some(ItemOpacity::Mapped { opacity, map, uvs })
        });
        match mapped {
            Some(opacity) => self.push(opacity),
            None => self.even(material),
        }
    }

    /// Index of a picture's map.
    fn map(&mut self, picture: OpacityPicture) -> Option<u32> {
        let key = (picture.texture, picture.channel as u8);
        if let Some(known) = self.known.get(&key) {
            return *known;
        }
        let texture = self.scene.textures.get(picture.texture as usize);
        let map = texture.and_then(|texture| {
            OpacityMap::new(texture.image.as_ref()?, picture.channel, texture.wrap)
        });
        let index = map.map(|map| {
            self.opacities.maps.push(map);
            self.opacities.maps.len() as u32 - 1
        });
        self.known.insert(key, index);
        index
    }
}

impl Tracer {
    /// Whether light passes straight through any surface.
    pub fn has_see_through(&self) -> bool {
        self.opacities.is_some()
    }

    /// The share of the light that passes along each ray: the product of 1 − opacity over the surfaces in
    /// between, 0 behind an opaque one. `shares` is cleared and gets one entry per ray, in 0..=1.
    ///
    /// Runs on the calling thread; callers split their rays.
    pub fn transmittance(&self, rays: &[KernelRay], shares: &mut Vec<f32>) {
        let mut blocked = vec![false; rays.len()];
        self.kernel_any(rays, &mut blocked);
        shares.clear();
        shares.extend(blocked.iter().map(|&b| if b { 0.0 } else { 1.0 }));
        let Some(opacities) = &self.opacities else {
            return;
        };
        for ((ray, share), _) in rays.iter().zip(shares).zip(blocked).filter(|(_, b)| *b) {
            *share = self.passed(opacities, ray) as f32;
        }
    }

    /// The share of the light that passes along a ray.
    fn passed(&self, opacities: &ItemOpacities, ray: &KernelRay) -> f64 {
        let (mut share, mut rest) = (1.0, *ray);
        let mut hit = [KernelHit::NOTHING];
        loop {
            self.kernel_closest(&[rest], &mut hit);
            if !hit[0].is_hit() {
                return share;
            }
            share *= 1.0 - opacities.opacity(self, ray, &hit[0]);
            if share <= 0.0 {
                return 0.0;
            }
            rest = behind(&rest, &hit[0]);
        }
    }

    /// Replaces the hits of rays that go on by what they hit behind.
    pub(super) fn follow_through(
        &self,
        opacities: &ItemOpacities,
        rays: &[KernelRay],
        hits: &mut [KernelHit],
    ) {
        let mut waiting: Vec<usize> = (0..rays.len())
            .filter(|&k| opacities.passes(self, &rays[k], &hits[k]))
            .collect();
        let (mut rest, mut found) = (Vec::new(), Vec::new());
        while !waiting.is_empty() {
            rest.clear();
            rest.extend(waiting.iter().map(|&k| behind(&rays[k], &hits[k])));
            found.clear();
            found.resize(rest.len(), KernelHit::NOTHING);
            self.kernel_closest(&rest, &mut found);
            for (&k, hit) in waiting.iter().zip(&found) {
                hits[k] = *hit;
            }
            waiting.retain(|&k| opacities.passes(self, &rays[k], &hits[k]));
        }
    }

    /// Clears rays that pass everything in between.
    pub(super) fn clear_passed(
        &self,
        opacities: &ItemOpacities,
        rays: &[KernelRay],
        blocked: &mut [bool],
    ) {
        for (ray, blocked) in rays.iter().zip(blocked).filter(|(_, b)| **b) {
            let mut hit = [KernelHit::NOTHING];
            self.kernel_closest(&[*ray], &mut hit);
            self.follow_through(opacities, &[*ray], &mut hit);
            *blocked = hit[0].is_hit();
        }
    }
}
