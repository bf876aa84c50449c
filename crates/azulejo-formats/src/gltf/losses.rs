//! What glTF cannot represent.

use super::write_image_based::{has_bright_spot, is_around};
use super::write_material::{bright_lightmaps, finish_texture, is_one_colour, only_around};
use crate::surface::gloss::is_repainted;
use crate::surface::losses::LossList;
use crate::surface::model::gltf_mr;
use crate::surface::tessellate::exact_counts;
use azulejo_scene::{FinishMaps, LightKind, Material, ReliefKind, Rgb, Scene};

/// What [`write()`](super::write()) would omit from a scene or change, as text: "2 lights".
///
/// The rounding of all numbers to single precision is not mentioned.
pub fn losses(scene: &Scene) -> Vec<String> {
    let lights =
        |lost: fn(&LightKind) -> bool| scene.lights.iter().filter(|l| lost(&l.kind)).count();
    let [primitives, solids] = exact_counts(scene);
    let shapes = LossList::empty(scene)
        .meshes(
            |m| m.mesh.faces.triangle_count() > m.mesh.faces.len(),
            "meshes whose polygons become triangles",
        )
        .count(primitives, "exact primitives that become polygons")
        .count(solids, "exact shapes that become polygons")
        .meshes(|m| m.mesh.faces.is_empty(), "objects without faces")
        .meshes(
            |m| m.mesh.is_grouped() && m.mesh.normals.is_none(),
            "meshes whose smoothing groups are left out",
        )
        .meshes(
            |m| !m.irradiance_error.is_empty(),
            "meshes whose errors of irradiance are left out",
        )
        .meshes(
            |m| m.back.is_some(),
            "meshes whose sheets are written twice, once with the light of each side",
        );
    let materials = shapes
        .materials(
            |m| m.textures.len() > 1,
            "materials of which only the first picture is kept",
        )
        .materials(
            |m| m.finish.is_none() && m.brdf.is_some() && (gltf_mr(m).is_none() || is_repainted(m)),
            "reflection models that become the nearest metal",
        )
        .materials(
            |m| m.finish.is_some_and(|f| is_split(&f)),
            "pictures of metalness and roughness, of which the factors are kept",
        )
        .materials(
            |m| matches!(m.relief.map(|r| r.kind), Some(ReliefKind::Heights { .. })),
            "pictures of heights",
        )
        .materials(
            |m| m.dielectric.is_none() && m.brdf.is_none() && !is_one_colour(m),
            "materials whose mirror and diffuse colours differ",
        )
        .materials(
            |m| m.opacity.is_some() && m.dielectric.is_some(),
            "opacities of glass, of which programs make other things",
        )
        .materials(
            is_odd_glass,
            "dielectrics that glTF cannot describe exactly",
        )
        .count(
            bright_lightmaps(scene).len(),
            "pictures of lightmaps that become PNG, with coarse steps in the dark",
        );
    materials
        .count(
            lights(|l| matches!(l, LightKind::Environment(_))),
            "environments that become cube maps of 128 rows and 8 bits, without sharp detail",
        )
        .count(
            bright_spots(scene),
            "environments with a sun or a lamp in the picture, which becomes larger and less bright",
        )
        .count(several_around(scene), "lights from all around that become one")
        .count(
            only_around(scene).len(),
            "pictures of the surroundings, of which a file is not written",
        )
        .count(
            lights(|l| matches!(l, LightKind::Directional { half_angle, .. } if *half_angle > 0.0)),
            "sizes of suns",
        )
        .count(
            lights(|l| matches!(l, LightKind::Spot { outer, .. } if *outer > MOST_CONE)),
            "spot lights wider than a half space",
        )
        .count(
            lights(|l| matches!(l, LightKind::Luminaire { .. })),
            "luminaires that become point lights of the same power",
        )
        .count(usize::from(scene.background.is_some()), "background")
        .count(usize::from(scene.fog.is_some()), "fog")
        .count(
            usize::from(!scene.units.photometric && scene.has_light()),
            "light unit (watts), whose values other programs take for lumens",
        )
        .finish()
}

fn bright_spots(scene: &Scene) -> usize {
    let lights = scene.lights.iter();
    let bright = lights.filter(
        |l| matches!(&l.kind, LightKind::Environment(around) if has_bright_spot(scene, around)),
    );
    bright.count()
}

/// The lights from all around, if there are several.
fn several_around(scene: &Scene) -> usize {
    let count = scene.lights.iter().filter(|l| is_around(&l.kind)).count();
    if count > 1 { count } else { 0 }
}

/// Largest half angle of a spot light in glTF.
const MOST_CONE: f64 = std::f64::consts::FRAC_PI_2;

/// glTF's glass is denser than its surroundings, and has no diffuse reflection.
fn is_odd_glass(m: &Material) -> bool {
    m.dielectric
        .is_some_and(|g| g.ior < 1.0 || m.diffuse != Rgb::BLACK)
}

/// Whether metalness and roughness are not two channels of one picture as glTF has them.
fn is_split(finish: &FinishMaps) -> bool {
    finish.pictures().next().is_some() && finish_texture(finish).is_none()
}
