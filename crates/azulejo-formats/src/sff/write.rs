//! Scenes to SFF, with a font of the figures that they extrude.

use super::from_scene::{self, is_lamp};
use super::print::print;
use crate::gloss::model_of;
use crate::{ppe, ppf};
use azulejo_scene::{
    Encoding, FillRule, LightKind, Material, Mesh, Object, PrimitiveKind, Scene, Shape, Solid,
};
use std::io::{self, BufWriter, Write};

/// Writes a scene, and returns the files that it names beside it, by name: if anything is extruded,
/// the font `stem.ppf` and the encoding `stem.ppe` that goes with it.
///
/// A scene that was read from SFF or SCN keeps the numbers that RTRACE understands; of any other,
/// materials become surfaces and lights are as bright where the camera looks. Numbers are the
/// shortest that read back to the same value. [`losses`] says what does not fit into the format.
///
/// # Errors
/// What `out` says.
///
/// # Panics
/// If the scene is not valid in the sense of [`Scene::validate`].
pub fn write(scene: &Scene, stem: &str, out: &mut dyn Write) -> io::Result<Vec<(String, Vec<u8>)>> {
    // Names end at a blank.
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
    // Glyphs are named where they are used: RTRACE wants an encoding all the same.
    let mut encoding = Encoding::default();
    encoding.names.insert(u32::from('A'), first.clone());
    ppe::write(&encoding, &mut names)?;
    Ok(vec![
        (format!("{stem}.ppf"), outlines),
        (format!("{stem}.ppe"), names),
    ])
}

/// What [`write()`] would leave out of a scene, or change, in words: "2 cameras".
pub fn losses(scene: &Scene) -> Vec<String> {
    let shapes = || scene.objects.iter().filter(|o| !is_lamp(scene, &o.shape));
    let objects = |lost: &dyn Fn(&Object) -> bool| shapes().filter(|o| lost(o)).count();
    let meshes =
        |lost: fn(&Mesh) -> bool| objects(&|o| matches!(&o.shape, Shape::Mesh(mesh) if lost(mesh)));
    let is_mixed = |k: usize| {
        let rtrace = scene.rtrace.as_ref();
        rtrace.is_some_and(|r| r.corner_surfaces.contains_key(&(k as u32)))
    };
    let colored = |(k, o): &(usize, &Object)| {
        matches!(&o.shape, Shape::Mesh(m) if !m.colors.is_empty()) && !is_mixed(*k)
    };
    let mut counts = vec![
        (objects(&is_lit), "objects whose irradiance is left out"),
        (objects(&is_square), "parallelograms that become polygons"),
        (
            objects(&overlaps),
            "shapes whose figures may fill otherwise",
        ),
        (
            meshes(|m| m.uvs.is_some()),
            "meshes with texture coordinates",
        ),
        (
            scene.objects.iter().enumerate().filter(colored).count(),
            "meshes with colors",
        ),
        (scene.cameras.len().saturating_sub(1), "further cameras"),
        (usize::from(scene.fog.is_some()), "fog"),
    ];
    if scene.rtrace.is_none() {
        let materials =
            |lost: fn(&Material) -> bool| scene.materials.iter().filter(|m| lost(m)).count();
        let lights = scene.lights.iter();
        let falling = lights.filter(|l| !matches!(l.kind, LightKind::Ambient { .. }));
        counts.extend([
            (
                falling.count(),
                "lights that fall with the distance otherwise",
            ),
            (
                materials(Material::is_emitter),
                "emitters, which light nothing in RTRACE",
            ),
            (
                materials(|m| m.dielectric.is_some()),
                "dielectrics, which follow Fresnel",
            ),
            (
                materials(|m| !m.textures.is_empty()),
                "materials with pictures",
            ),
            (
                materials(|m| m.brdf.is_some() && !is_of_the_format(m)),
                "reflection models that become a lobe about as wide",
            ),
        ]);
    }
    let said = |&(count, what): &(usize, &str)| (count > 0).then(|| format!("{count} {what}"));
    counts.iter().filter_map(said).collect()
}

/// Whether the reflection model is that of one of the format's surfaces.
fn is_of_the_format(material: &Material) -> bool {
    let name = model_of(material).map(|m| m.name.as_str());
    name == Some("strauss") || name == Some("lewis") && material.mirror.is_black()
}

fn is_lit(object: &Object) -> bool {
    match &object.shape {
        Shape::Mesh(mesh) => !mesh.irradiance.is_empty(),
        Shape::Primitive(p) => p.light.is_some(),
        Shape::Exact(exact) => exact.proxy.is_some(),
    }
}

fn is_square(object: &Object) -> bool {
    matches!(&object.shape, Shape::Primitive(p) if p.kind == PrimitiveKind::Square)
}

/// Whether a figure is filled by a rule that the format does not have.
fn overlaps(object: &Object) -> bool {
    let Shape::Exact(exact) = &object.shape else {
        return false;
    };
    let other = |s: &Solid| matches!(s, Solid::Prism(p) if p.figure.rule != FillRule::EvenOdd);
    exact.solids.iter().any(other)
}
