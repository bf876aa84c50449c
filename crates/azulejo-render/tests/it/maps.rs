//! Pictures of metalness, roughness and relief, against surfaces without pictures.

use azulejo_render::{ReferencePass, SecondPass, radiance, reference_radiance};
use azulejo_scene::brdf::Description;
use azulejo_scene::math::Ray;
use azulejo_scene::{
    Attribute, Brdf, FinishMaps, Image, Light, LightKind, Material, Mesh, NumberPicture, Object,
    PictureChannel, Relief, ReliefKind, Rgb, Scene, Shape, Texture,
};
use azulejo_trace::{Progress, Tracer};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;
use std::sync::Arc;

/// A square of 2 × 2 about the origin, front up, whose picture has u along x and v along y.
fn sheet(material: Material, pictures: &[Image], light: LightKind) -> Scene {
    let mut scene = Scene::default();
    for image in pictures {
        scene.textures.push(Texture {
            image: Some(image.clone()),
            ..Texture::default()
        });
    }
    let id = scene.add_material(material);
    let places = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let at = |[u, v]: [f64; 2]| DVec3::new(2.0 * u - 1.0, 2.0 * v - 1.0, 0.0);
    let mut mesh = Mesh {
        positions: places.map(at).to_vec(),
        uvs: Some(Attribute::per_vertex(places.map(DVec2::from).to_vec())),
        ..Mesh::default()
    };
    mesh.push_face(&[0, 1, 2, 3], id);
    scene.objects.push(Object::new("sheet", Shape::Mesh(mesh)));
    scene.lights.push(Light {
        name: String::new(),
        kind: light,
    });
    scene.validate().unwrap();
    scene
}

/// What is seen of a point from obliquely above: by the second pass and by the reference.
fn seen(scene: &Scene, samples: u32) -> [Rgb; 2] {
    let tracer = Tracer::new(scene);
    let eye = DVec3::new(0.3, -1.0, 2.0);
    let ray = Ray::new(eye, (DVec3::new(0.31, 0.17, 0.0) - eye).normalize());
    let second = SecondPass {
        samples_per_pixel: samples,
        ..SecondPass::default()
    };
    let paths = ReferencePass {
        samples_per_pixel: samples,
        ..ReferencePass::default()
    };
    let progress = Progress::new();
    [
        radiance(scene, &tracer, &[ray], &second, &progress).unwrap()[0],
        reference_radiance(scene, &tracer, &[ray], &paths, &progress).unwrap()[0].0,
    ]
}

/// The light of a stored sRGB value.
fn linear(stored: f64) -> f32 {
    let light = if stored <= 0.040_45 {
        stored / 12.92
    } else {
        ((stored + 0.055) / 1.055).powf(2.4)
    };
    light as f32
}

/// A picture of one normal.
fn normals(n: DVec3) -> Image {
    let pixel = (0.5 * (n + DVec3::ONE)).to_array().map(linear);
    Image::opaque(2, 2, vec![pixel; 4])
}

fn sun(toward: DVec3) -> LightKind {
    LightKind::Directional {
        direction: -toward.normalize(),
        irradiance: Rgb::grey(PI),
        half_angle: 0.0,
    }
}

/// L = ρ cos θ to the tilted normal, whatever side the light comes from; none from below the surface.
#[test]
fn reliefs_tilt_what_lamps_light() {
    let tilted = DVec3::new(0.6, 0.0, 0.8);
    let material = Material {
        relief: Some(Relief {
            texture: 0,
            kind: ReliefKind::Normals { scale: 1.0 },
        }),
        ..Material::diffuse("plaster", Rgb::new(0.2, 0.5, 0.8))
    };
    for toward in [
        DVec3::new(0.6, 0.0, 0.8),
        DVec3::new(-0.6, 0.0, 0.8),
        DVec3::new(0.0, 0.6, 0.8),
        DVec3::new(-0.9, 0.0, 0.3),
        DVec3::new(0.9, 0.0, -0.1),
    ] {
        let scene = sheet(material.clone(), &[normals(tilted)], sun(toward));
        let is_above = toward.z > 0.0;
        let cos = toward.normalize().dot(tilted).max(0.0) * f64::from(u8::from(is_above));
        for found in seen(&scene, 64) {
            crate::assert_close(found, material.diffuse * cos, 2e-4);
        }
    }
}

/// v grows along y: green tilts that way.
#[test]
fn green_is_the_second_coordinate() {
    let n = DVec3::new(0.0, 0.6, 0.8);
    let material = Material {
        relief: Some(Relief {
            texture: 0,
            kind: ReliefKind::Normals { scale: 1.0 },
        }),
        ..Material::diffuse("plaster", Rgb::grey(0.5))
    };
    let scene = sheet(material, &[normals(n)], sun(n));
    for found in seen(&scene, 64) {
        crate::assert_close(found, Rgb::grey(0.5), 2e-4);
    }
}

/// Light from everywhere: no picture of normals or heights makes a surface reflect more than its
/// reflectance.
#[test]
fn reliefs_create_no_energy() {
    let rough = |k: u32| {
        let n =
            |seed: u32| f64::from(k.wrapping_mul(seed).wrapping_mul(2_654_435_761) >> 24) / 255.0;
        [n(3), n(7), 0.5 + 0.5 * n(11)].map(linear)
    };
    let picture = Image::opaque(16, 16, (0..256).map(rough).collect());
    for kind in [
        ReliefKind::Normals { scale: 1.0 },
        ReliefKind::Heights { slope: 4.0 },
    ] {
        let material = Material {
            relief: Some(Relief { texture: 0, kind }),
            ..Material::diffuse("rock", Rgb::WHITE)
        };
        let ambient = LightKind::Ambient {
            radiance: Rgb::WHITE,
        };
        let scene = sheet(material, std::slice::from_ref(&picture), ambient);
        for found in seen(&scene, 1024) {
            assert!(
                found.r <= 1.0 + 1e-9 && found.r > 0.4,
                "{kind:?}: {found:?}"
            );
        }
    }
}

/// Where pictures say metal or plastic of a roughness, it is that.
#[test]
fn pictured_finishes_are_those_of_the_model() {
    let base = Rgb::new(0.9, 0.6, 0.2);
    let sky = LightKind::Ambient {
        radiance: Rgb::WHITE,
    };
    let lamp = sun(DVec3::new(-0.2, 0.9, 1.8));
    for (metallic, roughness) in [(1.0, 0.5), (0.0, 0.4), (0.6, 0.8), (1.0, 0.2)] {
        // The picture has other numbers elsewhere, and the material has those of the means.
        let pixel = |k: u32| match k % 8 {
            4.. => [0.0, roughness, metallic].map(linear),
            _ => [0.0, 1.0, 0.5].map(linear),
        };
        let picture = Image::opaque(8, 8, (0..64).map(pixel).collect());
        let model = |metallic: f64, roughness: f64| {
            let text = format!(
                "gltf_mr base = (0.9, 0.6, 0.2) metallic = {metallic} roughness = {roughness}"
            );
            let text: Description = text.parse().unwrap();
            Material::with_brdf("m", Arc::new(Brdf::new(text).unwrap()))
        };
        let number = |channel| {
            Some(NumberPicture {
                texture: 0,
                channel,
            })
        };
        let pictured = Material {
            finish: Some(FinishMaps {
                base,
                metallic: 1.0,
                roughness: 1.0,
                metallic_picture: number(PictureChannel::Blue),
                roughness_picture: number(PictureChannel::Green),
            }),
            ..model(0.5 * (metallic + 0.5), 0.5 * (roughness + 1.0))
        };
        for light in [sky.clone(), lamp.clone()] {
            let found = seen(
                &sheet(
                    pictured.clone(),
                    std::slice::from_ref(&picture),
                    light.clone(),
                ),
                4096,
            );
            let expected = seen(&sheet(model(metallic, roughness), &[], light), 4096)[1];
            for (found, tolerance) in found.into_iter().zip([0.05, 0.03]) {
                let off = (found - expected).map(f64::abs).max_channel();
                assert!(
                    off < tolerance * expected.max_channel(),
                    "{metallic} {roughness}: {found:?}, {expected:?}"
                );
            }
        }
    }
}
