//! Light from all around, written and read back.

use super::round_trip::read_back;
use crate::gltf;
use crate::gltf::cube_map::unpacked;
use crate::gltf::image_based::harmonics;
use azulejo_scene::sky::Sky;
use azulejo_scene::{
    Environment, Image, Light, LightKind, Projection, Rgb, Scene, Texture, Units, Up,
};
use glam::DVec3;
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};

/// A room under the given lights.
fn scene(up: Up, kinds: Vec<LightKind>, picture: Option<Image>) -> Scene {
    let light = |kind| Light {
        name: "sky".into(),
        kind,
    };
    Scene {
        lights: kinds.into_iter().map(light).collect(),
        textures: Vec::from_iter(picture.map(|image| Texture {
            path: "sky.hdr".into(),
            image: Some(image),
            ..Texture::default()
        })),
        units: Units {
            metres_per_unit: Some(1.0),
            up,
            photometric: true,
        },
        ..azulejo_scene::synthetic::cube_room()
    }
}

/// Irradiance on an unoccluded surface, by directions that are spread evenly.
fn irradiance(scene: &Scene, normal: DVec3) -> Rgb {
    const COUNT: u32 = 200_000;
    let golden = PI * (3.0 - 5f64.sqrt());
    let direction = |k: u32| {
        let z = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(COUNT);
        let (sin, cos) = (golden * f64::from(k) % TAU).sin_cos();
        let across = (1.0 - z * z).sqrt();
        DVec3::new(across * cos, across * sin, z)
    };
    let directions = (0..COUNT).map(direction);
    let sum: Rgb = directions
        .filter(|d| d.dot(normal) > 0.0)
        .map(|d| radiance(scene, d) * d.dot(normal))
        .sum();
    sum * (4.0 * PI / f64::from(COUNT))
}

fn radiance(scene: &Scene, d: DVec3) -> Rgb {
    let of = |light: &Light| match light.kind {
        LightKind::Ambient { radiance } => radiance,
        LightKind::Environment(around) => {
            let texture = around.texture().map(|id| &scene.textures[id as usize]);
            around.radiance(d, texture.and_then(|t| t.image.as_ref()))
        }
        _ => Rgb::BLACK,
    };
    scene.lights.iter().map(of).sum()
}

/// A direction of the scene, with its up axis, where y is up.
fn y_up(up: Up, d: DVec3) -> DVec3 {
    match up {
        Up::Y => d,
        Up::Z => DVec3::new(d.x, d.z, -d.y),
    }
}

/// Floors, ceilings and walls in all directions receive what they did, by the cube map as it is read and by
/// the coefficients in the file.
fn check(given: &Scene, tolerance: f64) {
    given.validate().unwrap();
    let back = read_back(given);
    assert_eq!(back.lights.len(), 1);
    assert_eq!(back.lights[0].name, "sky");
    let described = described(given);
    let coefficients: [[f64; 3]; 9] =
        serde_json::from_value(described["irradianceCoefficients"].clone()).unwrap();
    let intensity = described["intensity"].as_f64().unwrap();
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let normals = axes.into_iter().flat_map(|axis| [axis, -axis]);
    let of_given: Vec<(DVec3, Rgb)> = normals.map(|n| (n, irradiance(given, n))).collect();
    let most = of_given.iter().map(|(_, e)| e.max_channel());
    let most = most.fold(0.0, f64::max);
    for (normal, expected) in of_given {
        let turned = y_up(given.units.up, normal);
        let irradiance = irradiance(&back, turned);
        let terms = coefficients.iter().zip(harmonics(turned));
        let smooth: Rgb = terms.map(|(c, y)| Rgb::from(*c) * (y * intensity)).sum();
        for k in 0..3 {
            // What is nearly black need not be exact beside the rest.
            let room = tolerance * expected[k].max(0.02 * most);
            assert!(
                (irradiance[k] - expected[k]).abs() <= room,
                "by the cube map, {normal}: {irradiance:?}, not {expected:?}"
            );
            // Nine coefficients cannot follow what is small and bright (Ramamoorthi and Hanrahan 2001).
            assert!(
                (smooth[k] - expected[k]).abs() <= 0.09 * most,
                "by coefficients, {normal}: {smooth:?}, not {expected:?}"
            );
        }
    }
}

/// What Babylon.js 9.35 shows in a scene of right-handed axes (seen in Chromium: mirrors that face the six axes,
/// and a floor): of a sky that is white above and black below, with red toward +x and green toward +z.
#[test]
fn babylon_shows_where_light_comes_from() {
    let mut image = Image::new(256, 128);
    for (k, pixel) in image.pixels.iter_mut().enumerate() {
        let (x, y) = ((k % 256) as f64, (k / 256) as f64);
        let d = Projection::Equirectangular.direction((x + 0.5) / 256.0, (y + 0.5) / 128.0);
        let d =
            Environment::picture(0, Projection::Equirectangular, Up::Y).world_from_environment * d;
        *pixel = [d.x, d.z, d.y].map(|c| f32::from(u8::from(c > 0.0)));
    }
    let around = Environment::picture(0, Projection::Equirectangular, Up::Y);
    let given = scene(Up::Y, vec![LightKind::Environment(around)], Some(image));
    let light = described(&given);
    // The basis of its shaders has −y, −z and −x: light from +x, +y and +z has negative coefficients.
    let coefficients: [[f64; 3]; 9] =
        serde_json::from_value(light["irradianceCoefficients"].clone()).unwrap();
    for (number, channel) in [(1, 2), (2, 1), (3, 0)] {
        let own = coefficients[number];
        assert!(own[channel] < -0.5, "{number}: {own:?}");
        assert!(
            (0..3).all(|c| c == channel || own[c].abs() < 0.05),
            "{own:?}"
        );
    }
    // Halves of the faces, right and lower, in which a channel is bright.
    let faces: [usize; 6] = serde_json::from_value(light["specularImages"][0].clone()).unwrap();
    let pictures = pictures_of(&given);
    let at = |face: usize, right: bool, lower: bool| {
        let image = &pictures[faces[face]];
        let place = |is_far: bool| if is_far { 100 } else { 20 };
        let pixel = image.pixel(place(right), place(lower));
        pixel.map(|c| c > 0.5)
    };
    for (right, lower) in [(false, false), (true, false), (false, true), (true, true)] {
        // [red, green, blue] is [x > 0, z > 0, y > 0].
        assert_eq!(at(0, right, lower), [true, right, lower], "+x");
        assert_eq!(at(1, right, lower), [false, !right, lower], "-x");
        assert_eq!(at(2, right, lower), [right, lower, true], "+y");
        assert_eq!(at(3, right, lower), [right, !lower, false], "-y");
        assert_eq!(at(4, right, lower), [right, false, lower], "-z");
        assert_eq!(at(5, right, lower), [!right, true, lower], "+z");
    }
}

/// Files that azulejo wrote before have the signs of the paper and the faces of OpenGL: read so.
#[test]
fn earlier_files_keep_their_sky() {
    let sky = |generator: &str, coefficient: f64| {
        let mut coefficients = [[0.0; 3]; 9];
        (coefficients[0], coefficients[1]) = ([9.0; 3], [coefficient; 3]);
        let root = json!({
            "asset": { "version": "2.0", "generator": generator },
            "extensionsUsed": ["EXT_lights_image_based"],
            "extensions": { "EXT_lights_image_based": {
                "lights": [{ "irradianceCoefficients": coefficients }] } },
            "scenes": [{ "nodes": [], "extensions": { "EXT_lights_image_based": { "light": 0 } } }],
        });
        let files = crate::Memory::new();
        let text = root.to_string();
        let loaded = gltf::read(
            text.as_bytes(),
            "a.gltf",
            &files,
            &crate::ReadOptions::default(),
        );
        let scene = loaded.unwrap().scene;
        radiance(&scene, DVec3::Y).g > radiance(&scene, DVec3::NEG_Y).g
    };
    assert!(sky("azulejo 0.1.0", 3.0) && !sky("azulejo 0.1.0", -3.0));
    assert!(sky("glTF-Transform v4.5.1", -3.0) && !sky("another", 3.0));
}

/// The pictures in a written file.
fn pictures_of(scene: &Scene) -> Vec<Image> {
    let (mut json, mut bin) = (Vec::new(), Vec::new());
    gltf::write_json(scene, "a.bin", &mut json, &mut bin).unwrap();
    let root: Value = serde_json::from_slice(&json).unwrap();
    let view = |image: &Value| {
        let view = &root["bufferViews"][image["bufferView"].as_u64().unwrap() as usize];
        let [at, length] =
            ["byteOffset", "byteLength"].map(|key| view[key].as_u64().unwrap_or(0) as usize);
        unpacked(crate::picture::decode(&bin[at..at + length]).unwrap())
    };
    root["images"]
        .as_array()
        .unwrap()
        .iter()
        .map(view)
        .collect()
}

/// The light in the JSON of a written file.
fn described(scene: &Scene) -> Value {
    let (mut json, mut bin) = (Vec::new(), Vec::new());
    gltf::write_json(scene, "a.bin", &mut json, &mut bin).unwrap();
    let root: Value = serde_json::from_slice(&json).unwrap();
    root["extensions"]["EXT_lights_image_based"]["lights"][0].clone()
}

#[test]
fn skies() {
    for (number, up) in [(3, Up::Z), (12, Up::Y), (12, Up::Z)] {
        let toward_sun = DVec3::new(0.5, 0.3, 0.6);
        let sky = Sky::cie(number, toward_sun, 9000.0).unwrap();
        let mut around = Environment::sky(sky.with_ground(0.2, 0.0), up, 0.4);
        around.scale = Rgb::new(0.9, 1.0, 1.2);
        check(&scene(up, vec![LightKind::Environment(around)], None), 0.02);
    }
}

#[test]
fn pictures_with_bright_windows_and_ambient_light_beside_them() {
    // A dark room with a window a hundred times as bright as the mean.
    let mut image = Image::new(256, 128);
    for (k, pixel) in image.pixels.iter_mut().enumerate() {
        let (x, y) = (k % 256, k / 256);
        let is_window = (40..52).contains(&x) && (40..56).contains(&y);
        *pixel = if is_window {
            [90.0, 100.0, 120.0]
        } else {
            [0.3, 0.2, 0.1]
        };
    }
    let around = Environment::picture(0, Projection::Equirectangular, Up::Z);
    let ambient = LightKind::Ambient {
        radiance: Rgb::grey(0.1),
    };
    let scene = scene(
        Up::Z,
        vec![LightKind::Environment(around), ambient],
        Some(image),
    );
    check(&scene, 0.03);
    let losses = gltf::losses(&scene).join(", ");
    assert!(losses.contains("become one"), "{losses}");
    assert!(!losses.contains("a sun or a lamp"), "{losses}");
}

#[test]
fn levels_of_the_cube_map() {
    let sky = Sky::cie(3, DVec3::Z, 1.0).unwrap();
    let around = Environment::sky(sky, Up::Y, 0.0);
    let light = described(&scene(Up::Y, vec![LightKind::Environment(around)], None));
    let levels = light["specularImages"].as_array().unwrap();
    // 128, 64, 32 and 16 pixels.
    assert_eq!(
        (levels.len(), &light["specularImageSize"]),
        (4, &Value::from(128))
    );
    assert!(
        levels
            .iter()
            .all(|level| level.as_array().unwrap().len() == 6)
    );
}

#[test]
fn a_sun_in_the_picture_is_said() {
    let mut image = Image::new(64, 32);
    image.pixels.fill([1.0; 3]);
    image.pixels[64 * 8] = [1e5; 3];
    let around = Environment::picture(0, Projection::Equirectangular, Up::Y);
    let scene = scene(Up::Y, vec![LightKind::Environment(around)], Some(image));
    let losses = gltf::losses(&scene).join(", ");
    assert!(losses.contains("a sun or a lamp"), "{losses}");
    // Nothing is cut off: its power stays.
    let back = read_back(&scene);
    let [irradiance, expected] = [&back, &scene].map(|s| irradiance(s, DVec3::Y).g);
    assert!(
        (irradiance / expected - 1.0).abs() < 0.1,
        "{irradiance} {expected}"
    );
}
