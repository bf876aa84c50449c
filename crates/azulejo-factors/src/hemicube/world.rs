//! The patches of a scene as geometry for item buffers.

use crate::patch::{PatchFacets, Patches};
use azulejo_scene::math::Aabb;
use azulejo_scene::{Material, Scene};
use azulejo_trace::item_buffer::{Facet, Mirror, NO_MIRROR, World};
use glam::DVec3;
use std::collections::HashMap;

/// Mirrors are coplanar if their planes differ by less than this, in normal and in offset relative
/// to the scene's size; they are rendered together.
const SAME_PLANE: f64 = 1e-8;

/// The geometry to render: flat patches as they are, curved ones as their facets.
pub(super) fn world(scene: &Scene, patches: &Patches, facets: &PatchFacets) -> World {
    let mut world = World {
        patches: patches.len() as u32,
        up: scene.units.up.axis(),
        ..World::default()
    };
    let mut mirrors = Mirrors::new(patches);
    for i in 0..patches.len() {
        let triangles = facets.of(i).into_iter();
        let facet = |corners| Facet {
            corners,
            patch: i as u32,
        };
        world.triangles.extend(triangles.map(facet));
        let material = &scene.materials[patches.material(i) as usize];
        let shows = SpecularKind::new(material, patches.polygon(i).is_some());
        world.is_bent.push(shows == SpecularKind::Bent);
        world.mirror_of.push(match shows {
            SpecularKind::Window => mirrors.number(patches, i, material),
            _ => NO_MIRROR,
        });
    }
    world.mirrors = mirrors.mirrors;
    world
}

/// How a patch reflects, besides diffusely.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SpecularKind {
    Nothing,
    /// A reflected world.
    Window,
    /// Curved, refracting or glossy: nothing that an item buffer can render.
    Bent,
}

impl SpecularKind {
    fn new(material: &Material, is_flat: bool) -> SpecularKind {
        match (material.is_specular(), material.dielectric.is_some()) {
            (false, _) => SpecularKind::Nothing,
            (true, false) if is_flat && material.glossy().is_none() => SpecularKind::Window,
            _ => SpecularKind::Bent,
        }
    }
}

/// Planes of mirrors, one for each reflectance.
struct Mirrors {
    bounds: Aabb,
    mirrors: Vec<Mirror>,
    known: HashMap<([i64; 4], [u64; 3]), u32>,
}

impl Mirrors {
    fn new(patches: &Patches) -> Mirrors {
        let positions = patches.vertices().iter().map(|v| v.position);
        Mirrors {
            bounds: Aabb::around(positions),
            mirrors: Vec::new(),
            known: HashMap::new(),
        }
    }

    /// The mirror that a flat patch belongs to.
    fn number(&mut self, patches: &Patches, i: usize, material: &Material) -> u32 {
        let (point, normal) = (patches.centre(i), one_way(patches.normal(i)));
        let away = (point - self.bounds.centre()) / self.bounds.diagonal();
        let step = |x: f64| (x / SAME_PLANE).round() as i64;
        let plane = [normal.x, normal.y, normal.z, normal.dot(away)].map(step);
        let reflectance = material.mirror;
        let key = (plane, reflectance.to_array().map(f64::to_bits));
        let next = self.mirrors.len() as u32;
        let number = *self.known.entry(key).or_insert(next);
        if number == next {
            self.mirrors.push(Mirror {
                point,
                normal,
                reflectance,
            });
        }
        number
    }
}

/// The normal or its opposite, the same for both, because mirrors reflect on both sides.
fn one_way(normal: DVec3) -> DVec3 {
    let first = normal.to_array().into_iter().find(|x| x.abs() > 1e-4);
    if first < Some(0.0) { -normal } else { normal }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PatchSize;
    use azulejo_scene::{Object, Primitive, Rgb, Shape};

    /// A scene of parallelograms and balls.
    fn scene(materials: Vec<Material>, shapes: Vec<Primitive>) -> Scene {
        let shapes = shapes.into_iter().map(Shape::Primitive);
        Scene {
            materials,
            objects: shapes.map(|s| Object::new("", s)).collect(),
            ..Scene::default()
        }
    }

    fn divided_world(scene: &Scene, edge: f64) -> World {
        let patches = Patches::new(scene, PatchSize::Edge(edge));
        world(scene, &patches, &PatchFacets::new(&patches))
    }

    #[test]
    fn mirrors_are_grouped_by_plane_and_reflectance() {
        let sheet = |at: DVec3, edge: DVec3, m| Primitive::parallelogram(at, edge, DVec3::Y, m);
        let mirrors = [0.5, 0.25].map(|r| Material::mirror("mirror", Rgb::grey(r)));
        let far = DVec3::new(1e4, 0.0, 0.0);
        let scene = scene(
            mirrors.to_vec(),
            vec![
                sheet(far, DVec3::X, 0),
                // The same plane, seen from behind; another reflectance; another plane.
                sheet(far + 3.0 * DVec3::X, -DVec3::X, 0),
                sheet(far + 5.0 * DVec3::X, DVec3::X, 1),
                sheet(far + DVec3::Z, DVec3::X, 0),
            ],
        );
        let world = divided_world(&scene, 0.5);
        assert_eq!(world.mirrors.len(), 3);
        let first_mirror = |object: usize| world.mirror_of[4 * object];
        assert_eq!([0, 1, 2, 3].map(first_mirror), [0, 0, 1, 2]);
        assert_eq!(world.mirror_of[..8], [0; 8]);
        assert!(!world.is_bent.contains(&true));
    }

    #[test]
    fn glass_and_curved_mirrors_are_bent() {
        let materials = vec![
            Material::mirror("mirror", Rgb::grey(0.5)),
            Material::dielectric("glass", 1.5),
            Material::diffuse("grey", Rgb::grey(0.5)),
        ];
        let sheet = |m| Primitive::parallelogram(DVec3::ZERO, DVec3::X, DVec3::Y, m);
        let ball = |m| Primitive::sphere(DVec3::ZERO, 1.0, m);
        for (shape, is_bent) in [
            (sheet(0), false),
            (sheet(1), true),
            (sheet(2), false),
            (ball(0), true),
            (ball(1), true),
            (ball(2), false),
        ] {
            let is_mirror = shape == sheet(0);
            let world = divided_world(&scene(materials.clone(), vec![shape]), 0.0);
            assert!(world.is_bent.iter().all(|&b| b == is_bent));
            assert_eq!(world.mirrors.len(), usize::from(is_mirror));
        }
    }
}
