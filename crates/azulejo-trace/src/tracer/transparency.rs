//! Surfaces through which light passes straight: which rays go on behind a hit, and what reaches the
//! end of a shadow ray.
//!
//! Whether a ray stops at a surface of opacity α is decided by a number in 0..1 that is keyed on the ray
//! and on the surface (stochastic transparency: Enderton, Sintorn, Shirley and Luebke, I3D 2010). So
//! what a ray hits does not depend on other rays, on the batch or on the thread; the mean over many
//! rays is right, and their spread shows in the standard errors that all estimates carry. A ray that
//! stops meets the surface with its whole weight: α of the light is taken, 1 − α passes.
//!
//! Panes stop all rays but shadow rays: these take exactly the share that Fresnel's equations and the
//! tint of the glass let through. So a room behind windows has direct light from lamps, the sun and the
//! sky as one behind openings has.

use super::Tracer;
use crate::kernel::{KernelHit, KernelRay};
use crate::sampling::{hash, uniform};
use azulejo_scene::{
    Dielectric, Exact, Leaf, Material, Mesh, Opacity, OpacityMap, OpacityPicture, Rgb, Scene, Shape,
};
use glam::DVec2;
use std::collections::HashMap;

/// What passes through a tracer's items. Takes 4 bytes per prototype, 80 more for each triangle that shows a
/// picture of its opacity, and 4 per pixel of these pictures.
#[derive(Clone, Debug)]
pub(crate) struct ItemTransparencies {
    /// For each prototype 0 if nothing passes, else one more than an index in `list`.
    of_prototypes: Vec<u32>,
    list: Vec<ItemTransparency>,
    maps: Vec<OpacityMap>,
}

/// What passes straight through an item.
#[derive(Clone, Copy, Debug)]
struct ItemTransparency {
    /// The share of it that is there.
    opacity: ItemOpacity,
    /// Of what is there, the glass that lets light pass straight.
    pane: Option<Dielectric>,
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

/// [`ItemTransparencies`] while they are collected.
struct TransparencyBuilder<'s> {
    scene: &'s Scene,
    found: ItemTransparencies,
    /// Index of the map of each picture; `None` where it is opaque everywhere or not loaded.
    known: HashMap<(u32, u8), Option<u32>>,
    /// Index of the entry of each material, where it does not depend on the triangle.
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

/// The glass of a material through which light passes straight.
fn pane(material: &Material) -> Option<Dielectric> {
    material.dielectric.filter(Dielectric::is_straight)
}

impl ItemTransparencies {
    /// What passes through a tracer's items; `None` if all stop all light.
    pub fn new(scene: &Scene, tracer: &Tracer) -> Option<ItemTransparencies> {
        // Without a material through which light passes straight, there is nothing to store.
        let passes: Vec<bool> = (scene.materials.iter())
            .map(|m| m.see_through().is_some() || pane(m).is_some())
            .collect();
        if !passes.contains(&true) {
            return None;
        }
        let mut builder = TransparencyBuilder {
            scene,
            found: ItemTransparencies {
                of_prototypes: Vec::new(),
                list: Vec::new(),
                maps: Vec::new(),
            },
            known: HashMap::new(),
            even: HashMap::new(),
            last: None,
        };
        // List the parts of exact shapes once; items know them by number.
        let leaves = scene.objects.iter().map(|object| match &object.shape {
            Shape::Exact(exact) => Exact::leaves(exact),
            _ => Vec::new(),
        });
        let leaves: Vec<Vec<Leaf>> = leaves.collect();
        // Store one entry for each prototype, because all instances of a mesh share it.
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
                _ if !passes[material as usize] => 0,
                Some(mesh) => {
                    builder.triangle(material, mesh, (item.object, item.face), item.triangle)
                }
                None => builder.even(material),
            };
            builder.found.of_prototypes.push(index);
        }
        // Pictures of opacity may prove to be opaque everywhere.
        let transparencies = builder.found;
        let is_any = transparencies.of_prototypes.iter().any(|&v| v > 0);
        is_any.then_some(transparencies)
    }

    /// Whether any item is not opaque, beside panes.
    fn has_see_through(&self) -> bool {
        let is_opaque = |t: &ItemTransparency| matches!(t.opacity, ItemOpacity::Even(1.0));
        !self.list.iter().all(is_opaque)
    }

    /// 0 for an item through which nothing passes, else one more than an index in `list`.
    fn index(&self, tracer: &Tracer, item: u32) -> u32 {
        let prototype = tracer.prototype(item) as usize;
        self.of_prototypes.get(prototype).copied().unwrap_or(0)
    }

    /// The opacity of what a ray hits, 0..=1.
    fn opacity(&self, tracer: &Tracer, ray: &KernelRay, hit: &KernelHit) -> f64 {
        let index = self.index(tracer, hit.item);
        match index.checked_sub(1).map(|k| self.list[k as usize].opacity) {
            None => 1.0,
            Some(ItemOpacity::Even(opacity)) => opacity,
            Some(ItemOpacity::Mapped { opacity, map, uvs }) => {
                let point = tracer.resolve(&tracer.world_ray(ray), hit);
                let [a, b, c] = uvs;
                let uv = a + point.u * (b - a) + point.v * (c - a);
                opacity.at(self.maps[map as usize].sample(uv))
            }
        }
    }

    /// The share of the light that passes straight through what a ray hits, 0..=1 per channel.
    fn passed(&self, tracer: &Tracer, ray: &KernelRay, hit: &KernelHit) -> Rgb {
        let opacity = self.opacity(tracer, ray, hit);
        let free = Rgb::grey(1.0 - opacity);
        let index = self.index(tracer, hit.item);
        let pane = index.checked_sub(1).map(|k| self.list[k as usize].pane);
        let Some(pane) = pane.flatten().filter(|_| opacity > 0.0) else {
            return free;
        };
        let ray = tracer.world_ray(ray);
        let point = tracer.resolve(&ray, hit);
        let facing = if point.entering {
            point.normal
        } else {
            -point.normal
        };
        let direction = ray.direction.normalize();
        free + pane.straight_transmittance(direction, facing) * opacity
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

impl TransparencyBuilder<'_> {
    /// One more than the index of a new entry, of that material.
    fn push(&mut self, material: u32, opacity: ItemOpacity) -> u32 {
        let pane = pane(&self.scene.materials[material as usize]);
        self.found.list.push(ItemTransparency { opacity, pane });
        self.found.list.len() as u32
    }

    /// The entry of a surface without texture coordinates: its picture does not count.
    fn even(&mut self, material: u32) -> u32 {
        if let Some(&index) = self.even.get(&material) {
            return index;
        }
        let surface = &self.scene.materials[material as usize];
        let value = surface.see_through().map_or(1.0, |o| o.at(1.0));
        let index = if value < 1.0 || pane(surface).is_some() {
            self.push(material, ItemOpacity::Even(value))
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
            Some(opacity) => self.push(material, opacity),
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
            self.found.maps.push(map);
            self.found.maps.len() as u32 - 1
        });
        self.known.insert(key, index);
        index
    }
}

impl Tracer {
    /// Whether any surface is not opaque, so that light passes straight through it; panes of glass are
    /// not asked for.
    pub fn has_see_through(&self) -> bool {
        (self.transparencies.as_ref()).is_some_and(ItemTransparencies::has_see_through)
    }

    /// The share of the light that passes along each ray: the product over the surfaces in between of
    /// what passes straight through them, black behind one that stops it. That is 1 − opacity, and of
    /// panes what they transmit ([`Dielectric::is_straight`]). `shares` is cleared and gets one entry
    /// per ray, in 0..=1 per channel.
    ///
    /// Runs on the calling thread; callers split their rays.
    pub fn transmittance(&self, rays: &[KernelRay], shares: &mut Vec<Rgb>) {
        let mut blocked = vec![false; rays.len()];
        self.kernel_any(rays, &mut blocked);
        shares.clear();
        let unblocked = |&b: &bool| if b { Rgb::BLACK } else { Rgb::WHITE };
        shares.extend(blocked.iter().map(unblocked));
        let Some(transparencies) = &self.transparencies else {
            return;
        };
        for ((ray, share), _) in rays.iter().zip(shares).zip(blocked).filter(|(_, b)| *b) {
            *share = self.passed(transparencies, ray);
        }
    }

    /// The share of the light that passes along a ray.
    fn passed(&self, transparencies: &ItemTransparencies, ray: &KernelRay) -> Rgb {
        let (mut share, mut rest) = (Rgb::WHITE, *ray);
        let mut hit = [KernelHit::NOTHING];
        loop {
            self.kernel_closest(&[rest], &mut hit);
            if !hit[0].is_hit() {
                return share;
            }
            share *= transparencies.passed(self, ray, &hit[0]);
            if share.max_channel() <= 0.0 {
                return Rgb::BLACK;
            }
            rest = rest.behind(&hit[0]);
        }
    }

    /// Replaces the hits of rays that go on by what they hit behind.
    pub(super) fn follow_through(
        &self,
        transparencies: &ItemTransparencies,
        rays: &[KernelRay],
        hits: &mut [KernelHit],
    ) {
        let mut waiting: Vec<usize> = (0..rays.len())
            .filter(|&k| transparencies.passes(self, &rays[k], &hits[k]))
            .collect();
        let (mut rest, mut next_hits) = (Vec::new(), Vec::new());
        while !waiting.is_empty() {
            rest.clear();
            rest.extend(waiting.iter().map(|&k| rays[k].behind(&hits[k])));
            next_hits.clear();
            next_hits.resize(rest.len(), KernelHit::NOTHING);
            self.kernel_closest(&rest, &mut next_hits);
            for (&k, hit) in waiting.iter().zip(&next_hits) {
                hits[k] = *hit;
            }
            waiting.retain(|&k| transparencies.passes(self, &rays[k], &hits[k]));
        }
    }

    /// Clears rays that pass everything in between.
    pub(super) fn clear_passed(
        &self,
        transparencies: &ItemTransparencies,
        rays: &[KernelRay],
        blocked: &mut [bool],
    ) {
        for (ray, blocked) in rays.iter().zip(blocked).filter(|(_, b)| **b) {
            let mut hit = [KernelHit::NOTHING];
            self.kernel_closest(&[*ray], &mut hit);
            self.follow_through(transparencies, &[*ray], &mut hit);
            *blocked = hit[0].is_hit();
        }
    }
}
