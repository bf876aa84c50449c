//! Metallic-roughness and its extensions.

use super::{read, triangle};
use crate::picture::png;
use crate::surface::model::gltf_mr;
use azulejo_scene::{
    Dielectric, FinishMaps, Image, Material, NumberPicture, Opacity, OpacityChannel, OpacityMode,
    OpacityPicture, PictureChannel, Relief, ReliefKind, Rgb, Scene, Sidedness, WrapMode,
};
use glam::DVec2;

const PRIMITIVE: &str = "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":\
    {\"POSITION\":0,\"TEXCOORD_1\":0},\"material\":0}]}],";

fn scene(material: &str, rest: &str, warnings: &[&str]) -> Scene {
    let file = triangle(
        &[],
        "",
        &format!("{PRIMITIVE}\"materials\":[{{{material}}}]{rest}"),
    );
    // Positions have three numbers, texture coordinates two.
    let file = file.replace("\"TEXCOORD_1\":0", "\"TEXCOORD_1\":1");
    let uvs = ",{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC2\"}";
    let file = file.replace("\"max\":[1,1,0]}", &format!("\"max\":[1,1,0]}}{uvs}"));
    read(&file, warnings)
}

fn material(json: &str, warnings: &[&str]) -> Material {
    scene(json, "", warnings).materials.remove(0)
}

fn pbr(json: &str) -> String {
    format!("\"pbrMetallicRoughness\":{{{json}}}")
}

#[test]
fn diffuse_mirrored_and_glossy() {
    let colour = "\"baseColorFactor\":[0.5,0.25,0,1]";
    let base = Rgb::new(0.5, 0.25, 0.0);
    let matt = material(&pbr(&format!("{colour},\"metallicFactor\":0")), &[]);
    let expected = Material {
        sidedness: Sidedness::One,
        ..Material::diffuse("", base)
    };
    assert_eq!(matt, expected);
    let json = pbr(&format!(
        "{colour},\"metallicFactor\":0.75,\"roughnessFactor\":0"
    ));
    let mirror = material(&json, &[]);
    assert_eq!((mirror.diffuse, mirror.mirror), (base * 0.25, base * 0.75));
    let json = pbr(&format!("{colour},\"roughnessFactor\":0.5"));
    let metal = material(&json, &[]);
    assert_eq!((metal.diffuse, metal.mirror), (Rgb::BLACK, Rgb::BLACK));
    assert_eq!(gltf_mr(&metal), Some((base, 1.0, 0.5)));
    let json = "\"name\":\"default\",\"alphaMode\":\"BLEND\"";
    let default = material(json, &[]);
    assert_eq!(gltf_mr(&default), Some((Rgb::WHITE, 1.0, 1.0)));
    assert_eq!(default.name, "default");
}

#[test]
fn emission_is_in_candela_per_square_metre() {
    let matt = pbr("\"metallicFactor\":0");
    let lamp = format!(
        "{matt},\"doubleSided\":true,\"emissiveFactor\":[1,0.5,0],\
         \"extensions\":{{\"KHR_materials_emissive_strength\":{{\"emissiveStrength\":4}}}}"
    );
    let lamp = material(&lamp, &[]);
    assert_eq!(
        (lamp.emission, lamp.emits_back),
        (Rgb::new(4.0, 2.0, 0.0), true)
    );
    assert_eq!(lamp.sidedness, Sidedness::Two);
    assert_eq!(material(&matt, &[]).sidedness, Sidedness::One);
    let picture = format!("{matt},\"emissiveFactor\":[1,1,1],\"emissiveTexture\":{{\"index\":0}}");
    let half_black = picture_of(&[[255; 3], [0; 3]]);
    let without = "textured primitive without";
    let lit_scene = scene(&picture, &half_black, &[without]);
    let lamp = &lit_scene.materials[0];
    assert_eq!(
        (lamp.emission, lamp.emission_picture),
        (Rgb::WHITE, Some(0))
    );
    assert!((lit_scene.mean_emissions()[0].r - 0.5).abs() < 1e-6);
    let placed = picture.replace("\"index\":0", "\"index\":0,\"texCoord\":1");
    assert_eq!(
        scene(&placed, &half_black, &[]).materials,
        lit_scene.materials
    );
    let dark = scene(&picture, &picture_of(&[[0; 3]]), &[without]);
    assert!(!dark.materials[0].is_emitter());
    let missing = ",\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"x.png\"}]";
    let dark = scene(
        &picture,
        missing,
        &["no such file", "the surface does not emit light", without],
    );
    assert_eq!(dark.materials[0].emission, Rgb::BLACK);
}

fn glass(json: &str, warnings: &[&str]) -> (Option<Dielectric>, Rgb) {
    let material = material(
        &format!(
            "{},\"extensions\":{{{json}}}",
            pbr("\"baseColorFactor\":[1,0.5,1,1],\"metallicFactor\":0,\"roughnessFactor\":0")
        ),
        warnings,
    );
    (material.dielectric, material.mirror)
}

#[test]
fn panes_and_bodies_of_glass() {
    let transmits =
        |t: f64| format!("\"KHR_materials_transmission\":{{\"transmissionFactor\":{t}}}");
    let tint = Rgb::new(1.0, 0.5, 1.0);
    let pane = Dielectric {
        ior: 1.5,
        transmittance: tint,
        thin: true,
    };
    assert_eq!(glass(&transmits(1.0), &[]), (Some(pane), Rgb::WHITE));
    // A quarter of the light is left at the distance 2, half of it at the thickness 1; the
    // boundary has the square root of that, since a ray passes it twice.
    let volume = "\"KHR_materials_volume\":{\"thicknessFactor\":1,\"attenuationDistance\":2,\
        \"attenuationColor\":[0.0625,1,1]},\"KHR_materials_ior\":{\"ior\":1.25},\
        \"KHR_materials_specular\":{\"specularFactor\":0.5}";
    let body = Dielectric {
        ior: 1.25,
        transmittance: Rgb::new(0.5, 0.5, 1.0),
        thin: false,
    };
    let optics = glass(&format!("{},{volume}", transmits(1.0)), &[]);
    assert_eq!(optics, (Some(body), Rgb::grey(0.5)));
    let little = ["transmits less than half"];
    // Smooth plastic has Schlick's Fresnel reflectance from 4 %: 4 + 96/21 % for uniform light.
    let (glass, mirror) = glass(&transmits(0.25), &little);
    assert!(
        glass.is_none() && (mirror.r - 0.0857).abs() < 5e-3,
        "{mirror:?}"
    );
}

/// A texture of one row, as a data URI.
fn picture_of(pixels: &[[u8; 3]]) -> String {
    let mut file = Vec::new();
    png::write(pixels.len() as u32, 1, pixels.as_flattened(), &mut file).unwrap();
    picture_as("image/png", &file)
}

fn picture_as(kind: &str, file: &[u8]) -> String {
    let escaped: String = file.iter().map(|b| format!("%{b:02x}")).collect();
    format!(
        ",\"textures\":[{{\"source\":0}}],\
         \"images\":[{{\"name\":\"wood\",\"uri\":\"data:{kind},{escaped}\"}}]"
    )
}

#[test]
fn pictures_and_their_coordinates() {
    let json = pbr(
        "\"metallicFactor\":0,\"baseColorTexture\":{\"index\":0,\"texCoord\":0,\"extensions\":\
         {\"KHR_texture_transform\":{\"offset\":[0,1],\"rotation\":1.5707963267948966,\
         \"scale\":[0.5,0.5],\"texCoord\":1}}}",
    );
    let scene = scene(&json, &picture_of(&[[255; 3]]), &[]);
    assert_eq!(scene.materials[0].textures, [0]);
    assert_eq!(scene.textures[0].path, "wood");
    assert_eq!(scene.textures[0].image.as_ref().unwrap().pixels, [[1.0; 3]]);
    // The lower left quarter of the texture, rotated: (0, 0) is its lower left corner in azulejo,
    // the coordinates (0, 0), (0, 1) and (0, 0) of the file come from its lower edge.
    let uvs = &super::mesh_of(&scene, 0).uvs.as_ref().unwrap().values;
    let expected = [DVec2::ZERO, DVec2::new(0.5, 0.0), DVec2::ZERO];
    let near = |(a, b): (&DVec2, DVec2)| (*a - b).length() < 1e-6;
    assert!(uvs.iter().zip(expected).all(near), "{uvs:?}");
}

/// Factors times the blue and the green channel; the model is that of their means. Normals beside.
#[test]
fn pictures_of_metalness_roughness_and_normals() {
    let json = format!(
        "{},\"normalTexture\":{{\"index\":0,\"texCoord\":1,\"scale\":0.5}}",
        pbr("\"baseColorFactor\":[0.5,0.25,0,1],\"metallicFactor\":0.5,\
             \"metallicRoughnessTexture\":{\"index\":0,\"texCoord\":1}")
    );
    let scene = scene(&json, &picture_of(&[[0, 102, 255], [0, 102, 0]]), &[]);
    let base = Rgb::new(0.5, 0.25, 0.0);
    let picture = |channel| {
        Some(NumberPicture {
            texture: 0,
            channel,
        })
    };
    let material = &scene.materials[0];
    let expected = FinishMaps {
        base,
        metallic: 0.5,
        roughness: 1.0,
        metallic_picture: picture(PictureChannel::Blue),
        roughness_picture: picture(PictureChannel::Green),
    };
    assert_eq!(material.finish, Some(expected));
    let kind = ReliefKind::Normals { scale: 0.5 };
    assert_eq!(material.relief, Some(Relief { texture: 0, kind }));
    let (color, metallic, roughness) = gltf_mr(material).unwrap();
    assert_eq!(color, base);
    assert!((metallic - 0.25).abs() < 1e-6 && (roughness - 0.4).abs() < 1e-5);
    scene.validate().unwrap();
    let mut file = Vec::new();
    crate::gltf::write(&scene, &mut file).unwrap();
    let options = crate::ReadOptions::default();
    let loaded = crate::gltf::read(&file, "a.glb", &crate::Memory::new(), &options);
    let back = loaded.unwrap().scene;
    let back = &back.materials[0];
    assert_eq!(
        (back.finish, back.relief),
        (material.finish, material.relief)
    );
}

#[test]
fn unused_properties_are_reported() {
    let json = format!(
        "{},\"normalTexture\":{{\"index\":0}},\"occlusionTexture\":{{\"index\":0}},\
         \"alphaMode\":\"MASK\"",
        pbr(
            "\"baseColorFactor\":[1,1,1,0.5],\"metallicRoughnessTexture\":{\"index\":0},\
             \"baseColorTexture\":{\"index\":0}"
        )
    );
    let warnings = [
        "\"image 0\" is not used",
        "metallic-roughness texture",
        "normal map",
        "occlusion map",
        "textured primitive without",
    ];
    let rest = ",\"textures\":[{\"source\":0}],\"images\":[{}]";
    assert_eq!(
        scene(&json, rest, &warnings).materials[0].diffuse,
        Rgb::WHITE
    );
}

/// Of an unlit material only the colour counts, metalness and all else are for others.
#[test]
fn unlit_materials_are_diffuse() {
    let json = format!(
        "{},\"extensions\":{{\"KHR_materials_unlit\":{{}}}}",
        pbr("\"baseColorFactor\":[0.5,0.25,0,1]")
    );
    let unlit = material(&json, &["KHR_materials_unlit"]);
    let expected = Material {
        sidedness: Sidedness::One,
        ..Material::diffuse("", Rgb::new(0.5, 0.25, 0.0))
    };
    assert_eq!(unlit, expected);
}

/// By factor and picture, as masks and shares; a picture without an alpha channel is opaque.
#[test]
fn alpha_modes() {
    let of = |alpha: f32, more: &str, picture: &str| {
        let json = pbr(&format!(
            "\"metallicFactor\":0,\"baseColorFactor\":[1,1,1,{alpha}],\
             \"baseColorTexture\":{{\"index\":0,\"texCoord\":1}}"
        ));
        scene(&format!("{json}{more}"), picture, &[]).materials[0].opacity
    };
    let plain = picture_of(&[[255; 3]]);
    let mut file = Vec::new();
    let clear = Image::opaque(2, 1, vec![[1.0; 3]; 2]).with_alpha(vec![0.0, 1.0]);
    png::write_linear(&clear, &mut file).unwrap();
    let cut = picture_as("image/png", &file);
    let whole = Opacity::constant(1.0);
    let pictured = Opacity {
        picture: Some(OpacityPicture {
            texture: 0,
            channel: OpacityChannel::Alpha,
        }),
        ..whole
    };
    let mask = |cutoff: f64, of: Opacity| {
        Some(Opacity {
            mode: OpacityMode::Mask { cutoff },
            ..of
        })
    };
    assert_eq!(of(0.5, "", &cut), None);
    assert_eq!(of(0.5, ",\"alphaMode\":\"OPAQUE\"", &cut), None);
    let blend = ",\"alphaMode\":\"BLEND\"";
    assert_eq!(of(1.0, blend, &plain), None);
    assert_eq!(of(0.5, blend, &plain), Some(Opacity::constant(0.5)));
    assert_eq!(of(1.0, blend, &cut), Some(pictured));
    let masked = ",\"alphaMode\":\"MASK\"";
    assert_eq!(of(1.0, masked, &cut), mask(0.5, pictured));
    assert_eq!(of(1.0, masked, &plain), None);
    let cutoff = ",\"alphaMode\":\"MASK\",\"alphaCutoff\":0.75";
    assert_eq!(of(0.5, cutoff, &plain), mask(0.75, Opacity::constant(0.5)));
}

#[test]
fn samplers_say_how_pictures_go_on() {
    let json = pbr("\"metallicFactor\":0,\"baseColorTexture\":{\"index\":0,\"texCoord\":1}");
    let of = |sampler: &str| {
        let picture =
            picture_of(&[[255; 3]]).replace("{\"source\":0}", "{\"source\":0,\"sampler\":0}");
        let rest = format!("{picture},\"samplers\":[{{{sampler}}}]");
        scene(&json, &rest, &[]).textures[0].wrap
    };
    assert_eq!(of(""), [WrapMode::Repeat; 2]);
    let both = of("\"wrapS\":33071,\"wrapT\":33648");
    assert_eq!(both, [WrapMode::Clamp, WrapMode::Mirror]);
}

/// Pictures that extensions name, where glTF's own are missing.
#[test]
fn pictures_of_other_formats() {
    let json = pbr("\"metallicFactor\":0,\"baseColorTexture\":{\"index\":0,\"texCoord\":1}");
    let file = crate::picture::webp::tests::file(image_webp::ColorType::Rgb8, &[255; 6]);
    let picture = picture_as("image/webp", &file).replace(
        "{\"source\":0}",
        "{\"extensions\":{\"EXT_texture_webp\":{\"source\":0}}}",
    );
    let scene = scene(&json, &picture, &[]);
    let image = scene.textures[0].image.as_ref().unwrap();
    assert_eq!(image.pixels, [[1.0; 3]; 2]);
}
