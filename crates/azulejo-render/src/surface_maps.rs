//! What pictures say of a surface at a point beside its colour: its finish and its relief.

use azulejo_scene::brdf::{Brdf, Description, Lobes};
use azulejo_scene::math::reflect;
use azulejo_scene::{
    FinishMaps, Material, NumberMap, NumberPicture, Relief, Rgb, Scene, TextureId,
};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::collections::HashMap;

/// Roughnesses at which lobes are tabulated; between them two are blended, which makes peaks up to a
/// hundredth too high.
const LEVELS: u32 = 64;

/// Least roughness of a picture: below it a surface would be a perfect mirror, which lobes are not.
const SMOOTHEST: f64 = 0.03;

/// Reflectance of a dielectric of index 1.5 along the normal.
const DIELECTRIC: f64 = 0.04;

/// How often a tilt is halved where it leans too far.
const MOST_HALVINGS: u32 = 6;

/// The pictures of numbers of a scene, and the lobes of surfaces whose roughness they vary.
#[derive(Default)]
pub(crate) struct SurfaceMaps {
    maps: HashMap<TextureId, NumberMap>,
    finish: Option<FinishTable>,
}

/// Lobes of `gltf_mr` of all roughnesses.
struct FinishTable {
    /// The diffuse base of reflectance 1 below a dielectric surface.
    base: Brdf,
    levels: Vec<FinishLevel>,
}

/// Lobes of one roughness. Schlick's reflectance is linear in that along the normal, F₀: between these
/// two lies every metal and dielectric.
struct FinishLevel {
    roughness: f64,
    /// With F₀ = 1.
    white: Brdf,
    /// With F₀ = 0.
    grazing: Brdf,
}

/// The finish of a surface at a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Finish {
    /// Factor of the diffuse base: c (1 − m), less what the surface reflects.
    pub base: Rgb,
    /// Reflectance along the normal, F₀.
    normal: Rgb,
    roughness: f64,
}

/// Lobes and their factors: the diffuse base, then those at the surface.
pub(crate) type FinishLobes<'m> = [(&'m Lobes, Rgb); 5];

impl SurfaceMaps {
    /// Those of all materials.
    pub fn new(scene: &Scene) -> SurfaceMaps {
        let mut surface_maps = SurfaceMaps::default();
        for material in &scene.materials {
            let relief = material.relief.map(|r| r.texture);
            let finish = material.finish.iter().flat_map(FinishMaps::pictures);
            for id in finish.chain(relief) {
                let texture = &scene.textures[id as usize];
                if let Some(map) = NumberMap::new(texture) {
                    surface_maps.maps.entry(id).or_insert(map);
                }
            }
        }
        if scene.materials.iter().any(|m| m.finish.is_some()) {
            surface_maps.finish = FinishTable::new();
        }
        surface_maps
    }

    /// The finish of a material that has pictures of it, at a place where vertex colours and textures
    /// multiply its base by `pattern`; without a place that of its factors.
    pub fn finish(
        &self,
        material: &Material,
        uv: Option<DVec2>,
        pattern: Rgb,
    ) -> Option<(Finish, FinishLobes<'_>)> {
        let (maps, table) = (material.finish.as_ref()?, self.finish.as_ref()?);
        let factor = |picture: Option<NumberPicture>| {
            let value = picture.zip(uv).and_then(|(picture, uv)| {
                let values = self.maps.get(&picture.texture)?.sample(uv);
                Some(picture.channel.of(values))
            });
            value.unwrap_or(1.0)
        };
        let metallic = maps.metallic * factor(maps.metallic_picture);
        let base = maps.base * pattern;
        let normal = Rgb::grey(DIELECTRIC * (1.0 - metallic)) + base * metallic;
        // 1 − F is (1 − F₀)(1 − s) by Schlick, so F₀ is a factor, here beside that of the table's base.
        let through = (Rgb::WHITE - normal) / (1.0 - DIELECTRIC);
        let finish = Finish {
            base: base * through * (1.0 - metallic),
            normal,
            roughness: maps.roughness * factor(maps.roughness_picture),
        };
        Some((finish, table.lobes(&finish)))
    }

    /// Diffuse reflectance for uniform light of a base.
    pub fn diffuse(&self, finish: &Finish) -> Rgb {
        let table = self.finish.as_ref();
        finish.base * table.map_or(Rgb::WHITE, |t| t.base.mean_diffuse())
    }

    /// The shading normal `normal` tilted by a relief, for a ray of that unit direction that
    /// mirrors reflect or not; `facing` is the
    /// geometric normal of the side that is seen and `tangents` the directions in which the texture
    /// coordinates grow.
    ///
    /// A tilt away from the ray, or one that would mirror it into the surface, is halved until it is not.
    pub fn tilted(
        &self,
        relief: &Relief,
        (uv, [along, across]): (DVec2, [DVec3; 2]),
        (normal, facing): (DVec3, DVec3),
        (direction, mirrors): (DVec3, bool),
    ) -> DVec3 {
        let Some(map) = self.maps.get(&relief.texture) else {
            return normal;
        };
        let x = along - along.dot(normal) * normal;
        let Some(x) = x.try_normalize() else {
            return normal;
        };
        let y = normal.cross(x);
        let y = y * 1f64.copysign(y.dot(across));
        let mut local = relief.normal(map, uv);
        // From behind, the relief is the same: each side of a sheet has its own.
        for _ in 0..=MOST_HALVINGS {
            let n = (local.x * x + local.y * y + local.z * normal).normalize();
            let is_above = !mirrors || reflect(direction, n).dot(facing) > 0.0;
            if direction.dot(n) < 0.0 && is_above {
                return n;
            }
            local = DVec3::new(0.5 * local.x, 0.5 * local.y, local.z);
        }
        normal
    }
}

impl FinishTable {
    fn new() -> Option<FinishTable> {
        let model = |base: f64, metallic: f64, roughness: f64| {
            let parameters = [
                ("base", base.into()),
                ("metallic", metallic.into()),
                ("roughness", roughness.into()),
            ];
            Brdf::new(Description::model("gltf_mr", parameters)).ok()
        };
        let level = |k: u32| {
            let roughness = SMOOTHEST.powf(1.0 - f64::from(k) / f64::from(LEVELS - 1));
            Some(FinishLevel {
                roughness,
                white: model(1.0, 1.0, roughness)?,
                grazing: model(0.0, 1.0, roughness)?,
            })
        };
        Some(FinishTable {
            base: model(1.0, 0.0, 1.0)?,
            levels: (0..LEVELS)
                .into_par_iter()
                .map(level)
                .collect::<Option<_>>()?,
        })
    }

    /// The lobes of a finish and their factors: the diffuse base, and those of two roughnesses.
    fn lobes(&self, finish: &Finish) -> FinishLobes<'_> {
        let roughness = finish.roughness.clamp(SMOOTHEST, 1.0);
        let after = self.levels.partition_point(|l| l.roughness <= roughness);
        let high = after.clamp(1, self.levels.len() - 1);
        let (a, b) = (&self.levels[high - 1], &self.levels[high]);
        let t = (roughness - a.roughness) / (b.roughness - a.roughness);
        let t = t.clamp(0.0, 1.0);
        let (f0, rest) = (finish.normal, Rgb::WHITE - finish.normal);
        [
            (self.base.matt(), finish.base),
            (specular(&a.white), f0 * (1.0 - t)),
            (specular(&a.grazing), rest * (1.0 - t)),
            (specular(&b.white), f0 * t),
            (specular(&b.grazing), rest * t),
        ]
    }
}

/// The lobes of reflection at the surface, however narrow.
fn specular(brdf: &Brdf) -> &Lobes {
    if brdf.glossy().is_empty() {
        brdf.narrow()
    } else {
        brdf.glossy()
    }
}
