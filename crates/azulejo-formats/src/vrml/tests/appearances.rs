//! Materials, colours and textures.

use super::*;
use crate::surface::phong::{Angle, Highlight};
use azulejo_scene::{
    Attribute, Material, Opacity, OpacityChannel, OpacityMode, OpacityPicture, PictureChannel,
    ReliefKind, Rgb, Sidedness, WrapMode,
};
use glam::DVec2;

const QUAD: &str = "IndexedFaceSet { coord Coordinate { point [ 0 0 0, 2 0 0, 2 1 0, 0 1 0 ] } coordIndex [ 0 1 2 3 ] EXTRA }";

fn look(appearance: &str, extra: &str) -> (Scene, Vec<String>) {
    let geometry = QUAD.replace("EXTRA", extra);
    load(&format!(
        "Shape {{ appearance Appearance {{ {appearance} }} geometry {geometry} }}"
    ))
}

fn material(appearance: &str) -> Material {
    look(appearance, "").0.materials.remove(0)
}

#[test]
fn materials() {
    let shiny = material(
        "material DEF m Material { diffuseColor 0.1 0.2 0.3 specularColor 0.5 0.5 0.5 shininess 0.5 }",
    );
    assert_eq!(
        (shiny.name.as_str(), shiny.diffuse),
        ("m", Rgb::new(0.1, 0.2, 0.3))
    );
    let highlight = Highlight::of(&shiny).unwrap();
    assert_eq!((highlight.angle, highlight.n), (Angle::Half, 64.0));
    assert!((highlight.ks.r - 0.5).abs() < 1e-12);
    let (scene, _) = look("material Material { emissiveColor 1 2 0 }", "solid FALSE");
    let lamp = &scene.materials[0];
    assert_eq!(
        (lamp.emission, lamp.emits_back),
        (Rgb::new(1.0, 1.0, 0.0), true)
    );
    let sidedness = |geometry: &str| {
        let (scene, _) = look("material Material { }", geometry);
        scene.materials[0].sidedness
    };
    assert_eq!(sidedness("solid FALSE"), Sidedness::Two);
    assert_eq!(sidedness("solid TRUE"), Sidedness::One);
    assert_eq!(sidedness(""), Sidedness::Unsaid);
    assert_eq!(material("material Material { }").diffuse, Rgb::grey(0.8));
    assert_eq!(material("").diffuse, Rgb::grey(0.8));
    let mirror = material("material Material { diffuseColor 1 0.5 0 mirror 0.75 }");
    assert_eq!(
        (mirror.mirror, mirror.diffuse),
        (Rgb::grey(0.75), Rgb::new(0.25, 0.125, 0.0))
    );
    let metal = material("material PhysicalMaterial { baseColor 0.9 0.8 0.7 roughness 0 }");
    assert_eq!(
        (metal.mirror, metal.diffuse),
        (Rgb::new(0.9, 0.8, 0.7), Rgb::BLACK)
    );
    let rough = material("material PhysicalMaterial { baseColor 0.9 0.8 0.7 }");
    assert_eq!((rough.mirror, rough.diffuse), (Rgb::BLACK, Rgb::BLACK));
    let model = rough.brdf.map(|b| b.description().to_string());
    assert_eq!(
        model.as_deref(),
        Some("gltf_mr base = (0.9, 0.8, 0.7) metallic = 1 roughness = 1")
    );
    let unlit = material("material UnlitMaterial { emissiveColor 0.5 0 0 }");
    assert_eq!(
        (unlit.emission, unlit.diffuse),
        (Rgb::new(0.5, 0.0, 0.0), Rgb::BLACK)
    );
}

/// X3D 4: metalness and roughness are the blue and the green channel, and the factors alone say nothing.
#[test]
fn pictures_of_finish_and_relief() {
    let pixels = "PixelTexture { image 2 1 3 0x00ff00 0x0080ff }";
    let physical = format!(
        "material PhysicalMaterial {{ baseColor 0.9 0.8 0.7 roughness 0.5 metallicRoughnessTexture {pixels} \
         normalTexture {pixels} normalScale 2 }}"
    );
    let (scene, warnings) = look(&physical, "");
    assert!(warnings.is_empty(), "{warnings:?}");
    let material = &scene.materials[0];
    let finish = material.finish.expect("it varies");
    let channel = |p: Option<azulejo_scene::NumberPicture>| p.map(|p| p.channel);
    assert_eq!(channel(finish.metallic_picture), Some(PictureChannel::Blue));
    assert_eq!(
        channel(finish.roughness_picture),
        Some(PictureChannel::Green)
    );
    assert_eq!((finish.metallic, finish.roughness), (1.0, 0.5));
    let kind = ReliefKind::Normals { scale: 2.0 };
    assert_eq!(material.relief.map(|r| r.kind), Some(kind));
    // The model is that of the means: half a metal.
    let model = material.brdf.as_ref().map(|b| b.description().to_string());
    let model = model.expect("glossy");
    assert!(
        model.contains("metallic = 0.4999") && model.contains("roughness = 0.3754"),
        "{model}"
    );
    let Shape::Mesh(mesh) = &scene.objects[0].shape else {
        panic!("a mesh")
    };
    assert!(mesh.uvs.is_some(), "pictures need coordinates");

    // Without the picture it is no metal.
    let missing =
        "material PhysicalMaterial { metallicRoughnessTexture ImageTexture { url \"lost.png\" } }";
    let (scene, warnings) = look(missing, "");
    assert!(scene.materials[0].mirror.is_black() && !scene.materials[0].diffuse.is_black());
    let is_said = |w: &String| w.contains("metallicRoughnessTexture without a picture");
    assert!(warnings.iter().any(is_said), "{warnings:?}");
}

#[test]
fn what_materials_lose_is_said() {
    let (scene, warnings) = look(
        "material Material { transparency 0.5 glow 0.9 metadata MetadataString { } } shaders CommonSurfaceShader { }",
        "",
    );
    let expected = [
        ":2:42: glow of Material: skipped",
        ":2:30: shaders of Appearance: skipped",
    ];
    // The column of a field is that of its node.
    let places: Vec<String> = warnings
        .iter()
        .map(|w| w.rsplit(": ").next().unwrap_or_default().to_owned())
        .collect();
    assert_eq!(places.len(), expected.len(), "{warnings:?}");
    assert_eq!(scene.materials[0].opacity, Some(Opacity::constant(0.5)));
    for (message, expected) in warnings.iter().zip(expected) {
        let words = expected.splitn(4, ':').nth(3).unwrap_or_default();
        assert!(message.contains(words), "{message} is not {expected}");
    }
    let (scene, warnings) = look("material Material { transparency 1 }", "");
    assert!(
        scene.objects.is_empty() && warnings[0].contains("invisible"),
        "{warnings:?}"
    );
}

#[test]
fn colors_replace_the_reflectance() {
    let face = "material Material { diffuseColor 0 1 0 } ";
    let (scene, _) = look(face, "colorPerVertex FALSE color Color { color 1 0 0 }");
    assert_eq!(scene.materials[0].diffuse, Rgb::new(1.0, 0.0, 0.0));
    let (scene, warnings) = look(
        face,
        "color ColorRGBA { color [ 1 0 0 1, 0 0 2 1, 1 1 1 0.5, 0 0 0 0 ] }",
    );
    let Shape::Mesh(mesh) = &scene.objects[0].shape else {
        panic!("a mesh");
    };
    assert_eq!(
        mesh.colors[..2],
        [Rgb::new(1.0, 0.0, 0.0), Rgb::new(0.0, 0.0, 1.0)]
    );
    assert_eq!(scene.materials[0].diffuse, Rgb::WHITE);
    expect_warnings(&warnings, &[":2:190: colours with alpha"]);
}

#[test]
fn a_colour_that_is_none_is_black() {
    let color = "color Color { color [ 1 1 1, -1.#IND 1 1, nan nan nan, inf 0 0 ] }";
    let (scene, _) = look("material Material { }", color);
    let Shape::Mesh(mesh) = &scene.objects[0].shape else {
        panic!("a mesh");
    };
    assert_eq!(mesh.colors[1..3], [Rgb::new(0.0, 1.0, 1.0), Rgb::BLACK]);
}

fn uvs(scene: &Scene) -> Vec<DVec2> {
    match &scene.objects[0].shape {
        Shape::Mesh(Mesh {
            uvs: Some(Attribute { values, .. }),
            ..
        }) => values.clone(),
        _ => Vec::new(),
    }
}

/// The alpha channel of a texture replaces the transparency of the material.
#[test]
fn alpha_channels() {
    let of = |channels: u32, pixel: &str, more: &str| {
        let (scene, _) = look(
            &format!(
                "texture PixelTexture {{ image 1 1 {channels} {pixel} }} material Material {{ transparency 0.5 }} {more}"
            ),
            "",
        );
        (
            scene.materials[0].opacity,
            scene.textures[0].image.clone().unwrap().alpha,
        )
    };
    assert_eq!(of(3, "0xFF0000", ""), (Some(Opacity::constant(0.5)), None));
    let pictured = Opacity {
        picture: Some(OpacityPicture {
            texture: 0,
            channel: OpacityChannel::Alpha,
        }),
        ..Opacity::constant(1.0)
    };
    assert_eq!(of(4, "0xFF000033", ""), (Some(pictured), Some(vec![0.2])));
    assert_eq!(of(2, "0xFF33", ""), (Some(pictured), Some(vec![0.2])));
    // All pixels are opaque, so that it is not a channel.
    assert_eq!(of(2, "0xFFFF", ""), (Some(Opacity::constant(0.5)), None));
    assert_eq!(of(2, "0xFF33", "alphaMode \"OPAQUE\"").0, None);
    let (masked, _) = of(2, "0xFF33", "alphaMode \"MASK\" alphaCutoff 0.25");
    let cut = OpacityMode::Mask { cutoff: 0.25 };
    assert_eq!(
        masked,
        Some(Opacity {
            mode: cut,
            ..pictured
        })
    );
}

#[test]
fn pictures_of_numbers() {
    let picture = "texture DEF p PixelTexture { image 2 2 3 0xFF0000 0x00FF00 0x0000FF 0xFFFFFF } material Material { diffuseColor 0.5 0.5 0.5 }";
    let (scene, _) = look(picture, "");
    let image = scene.textures[0].image.as_ref().unwrap();
    // Rows are stored bottom up in the file, top down here.
    assert_eq!(image.pixels[..2], [[0.0, 0.0, 1.0], [1.0; 3]]);
    assert_eq!(image.pixels[2..], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(scene.materials[0].diffuse, Rgb::WHITE);
    // Without coordinates the texture is projected onto the bounding box: u is the longest side.
    assert_eq!(uvs(&scene)[2], DVec2::new(1.0, 0.5));
    let (scene, _) = look(
        "texture PixelTexture { image 1 1 1 0xFF } material Material { }",
        "",
    );
    assert_eq!(
        scene.materials[0].diffuse,
        Rgb::grey(0.8),
        "shades of grey multiply"
    );
    let (scene, warnings) = look(
        "material Material { } texture PixelTexture { image 70000 70000 3 1 }",
        "",
    );
    assert!(
        scene.textures.is_empty() && warnings[0].contains("fewer pixels"),
        "{warnings:?}"
    );
}

#[test]
fn pictures_in_files() {
    let picture = "material Material { diffuseColor 0.5 0.5 0.5 } texture ImageTexture { url [ \"a.png\" \"b.png\" ] repeatS FALSE }";
    let (scene, warnings) = look(
        picture,
        "texCoord TextureCoordinate { point [ 0 0, 1 0, 1 1, 0 1 ] } texCoordIndex [ 1 2 3 0 ]",
    );
    assert_eq!(scene.textures[0].path, "a.png");
    assert_eq!(scene.materials[0].textures, [0]);
    assert_eq!(
        scene.materials[0].diffuse,
        Rgb::grey(0.5),
        "what is not there replaces nothing"
    );
    let Shape::Mesh(mesh) = &scene.objects[0].shape else {
        panic!("a mesh");
    };
    assert_eq!(mesh.uvs.as_ref().unwrap().at(0, 0), DVec2::X);
    assert_eq!(scene.textures[0].wrap, [WrapMode::Clamp, WrapMode::Repeat]);
    assert!(warnings[0].contains("\"a.png\""), "{warnings:?}");
}

#[test]
fn texture_coordinates_are_transformed() {
    let check = |fields: &str, uv: DVec2, expected: DVec2| {
        let picture = format!(
            "material Material {{ }} texture ImageTexture {{ url \"a.png\" }} textureTransform TextureTransform {{ {fields} }}"
        );
        let coordinates = format!(
            "texCoord TextureCoordinate {{ point [ {} {}, 1 0, 1 1, 0 1 ] }}",
            uv.x, uv.y
        );
        let uv = uvs(&look(&picture, &coordinates).0)[0];
        assert!((uv - expected).length() < 1e-12, "{fields}: {uv}");
    };
    check("scale 2 3", DVec2::ONE, DVec2::new(2.0, 3.0));
    check("translation 1 2", DVec2::ONE, DVec2::new(2.0, 3.0));
    check("rotation 1.5707963267948966", DVec2::X, DVec2::Y);
    check("center 1 1 scale 2 2", DVec2::ONE, DVec2::splat(3.0));
}

#[test]
fn a_multi_texture_is_several_pictures() {
    let text = "material Material { } texture MultiTexture { texture [ ImageTexture { url \"a.png\" } ImageTexture { url \"b.png\" } MovieTexture { } ] }";
    let (scene, warnings) = look(text, "");
    assert_eq!(scene.materials[0].textures, [0, 1]);
    assert!(
        warnings.iter().any(|w| w.contains("node MovieTexture")),
        "{warnings:?}"
    );
}
