//! Writes scenes as SFF, with a font of the figures that they extrude.

use super::from_scene::{self, is_light_emitter};
use super::print::print;
use crate::outline::{ppe, ppf};
use crate::surface::model::model_of;
use azulejo_scene::{
    Encoding, FillRule, Leaf, LightKind, Material, Mesh, Object, PrimitiveKind, Prism, Scene, Shape,
};
use std::io::{self, BufWriter, Write};

/// Writes a scene, and returns the files that it refers to, by name: if anything is extruded, the
/// font `stem.ppf` and its encoding `stem.ppe`.
///
/// A scene that was read from SFF or SCN keeps RTRACE's parameters; for any other scene, materials
/// become surfaces, and lights are scaled to the same irradiance at the camera's target. Numbers
/// are the shortest that read back to the same value. [`losses`] describes what the format cannot
/// represent.
///
/// # Errors
/// Those of `out`.
///
/// # Panics
/// If the scene is not valid in the sense of [`Scene::validate`].
pub fn write(scene: &Scene, stem: &str, out: &mut dyn Write) -> io::Result<Vec<(String, Vec<u8>)>> {
    // File names end at a blank.
    let stem = stem.replace(char::is_whitespace, "_");
    let (document, font) = from_scene::document(scene, &stem);
    let mut out = BufWriter::new(out);
    print(&document, &mut out)?;
    out.flush()?;
    let Some(first) = font.glyphs.keys().next() else {
        return Ok(Vec::new());
    };
    let (mut outlines, mut names) = (Vec::new(), Vec::new());
    ppf::write(&font, &mut outlines)?;
    // Glyphs are named where they are used, but RTRACE requires an encoding.
    let mut encoding = Encoding::default();
    encoding.names.insert(u32::from('A'), first.clone());
    ppe::write(&encoding, &mut names)?;
    Ok(vec![
        (format!("{stem}.ppf"), outlines),
        (format!("{stem}.ppe"), names),
    ])
}

/// Descriptions of what [`write()`] would omit from a scene, or change: "2 cameras".
pub fn losses(scene: &Scene) -> Vec<String> {
    let shapes = || {
        scene
            .objects
            .iter()
            .filter(|o| !is_light_emitter(scene, &o.shape))
    };
    let objects = |lost: &dyn Fn(&Object) -> bool| shapes().filter(|o| lost(o)).count();
    let meshes = |lost: fn(&Mesh) -> bool| objects(&|o| o.shape.mesh().is_some_and(lost));
    let is_mixed = |k: usize| {
        let rtrace = scene.rtrace.as_ref();
        rtrace.is_some_and(|r| r.corner_surfaces.contains_key(&(k as u32)))
    };
    let colored = |(k, o): &(usize, &Object)| {
        o.shape.mesh().is_some_and(|m| !m.colors.is_empty()) && !is_mixed(*k)
    };
    let mut counts = vec![
        (objects(&is_lit), "objects whose irradiance is omitted"),
        (objects(&is_square), "parallelograms that become polygons"),
        (
            objects(&|o| has_prism(o, |p| p.figure.rule != FillRule::EvenOdd)),
            "shapes whose figures may be filled differently",
        ),
        (
            objects(&|o| has_prism(o, |p| p.bevel.is_some())),
            "shapes whose bevels are omitted",
        ),
        (
            meshes(|m| m.uvs.is_some()),
            "meshes with texture coordinates",
        ),
        (
            scene.objects.iter().enumerate().filter(colored).count(),
            "meshes with vertex colours",
        ),
        (scene.cameras.len().saturating_sub(1), "further cameras"),
        (usize::from(scene.fog.is_some()), "fog"),
        (scene.environments().count(), "environments"),
    ];
    if scene.rtrace.is_none() {
        let materials =
            |lost: fn(&Material) -> bool| scene.materials.iter().filter(|m| lost(m)).count();
        let lights = scene.lights.iter();
        let falling = lights.filter(|l| !matches!(l.kind, LightKind::Ambient { .. }));
        counts.extend([
            (
                materials(|m| m.opacity.is_some()),
                "materials with an opacity, which become opaque",
            ),
            (falling.count(), "lights with a different falloff"),
            (
                materials(Material::is_emitter),
                "emitters, which do not illuminate anything in RTRACE",
            ),
            (
                materials(|m| m.dielectric.is_some()),
                "dielectrics, whose reflection follows Fresnel",
            ),
            (
                materials(|m| !m.textures.is_empty()),
                "materials with textures",
            ),
            (
                materials(|m| m.brdf.is_some() && !is_of_the_format(m)),
                "reflection models that become a lobe of similar width",
            ),
        ]);
    }
    let described = |&(count, what): &(usize, &str)| (count > 0).then(|| format!("{count} {what}"));
    counts.iter().filter_map(described).collect()
}

/// Whether the reflection model is that of one of the format's surfaces.
fn is_of_the_format(material: &Material) -> bool {
    let name = model_of(material).map(|m| m.name.as_str());
    name == Some("strauss") || name == Some("lewis") && material.mirror.is_black()
}

fn is_lit(object: &Object) -> bool {
    match &object.shape {
        Shape::Mesh(mesh) => !mesh.irradiance.is_empty(),
        Shape::Instance(instance) => instance.light.is_some(),
        Shape::Primitive(p) => p.light.is_some(),
        Shape::Exact(exact) => exact.proxy.is_some(),
    }
}

fn is_square(object: &Object) -> bool {
    matches!(&object.shape, Shape::Primitive(p) if p.kind == PrimitiveKind::Square)
}

/// Whether a shape has a prism like that.
fn has_prism(object: &Object, like: impl Fn(&Prism) -> bool) -> bool {
    let Shape::Exact(exact) = &object.shape else {
        return false;
    };
    let is_like = |leaf: Leaf| matches!(leaf, Leaf::Prism(p) if like(p));
    exact.leaves().into_iter().any(is_like)
}
