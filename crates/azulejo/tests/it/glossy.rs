//! Reflection models from file to picture: two passes against brute force.

use azulejo::factors::PointNormal;
use azulejo::radiosity::{self, FirstPass};
use azulejo::render::{self, FinalGather, ReferencePass, SecondPass};
use azulejo::scene::brdf::Brdf;
use azulejo::scene::synthetic::{CornellVariant, cornell_box, cube_room};
use azulejo::scene::{Camera, Image, Material, Object, Primitive, Rgb, Scene, Shape};
use azulejo::trace::{Progress, Tracer};
use glam::{DVec3, dvec3};
use std::f64::consts::PI;
use std::sync::Arc;

const SIZE: (u32, u32) = (24, 24);

fn two_passes(scene: &Scene) -> Image {
    let mut lit = scene.clone();
    let progress = Progress::new();
    let first = FirstPass {
        size: azulejo::factors::PatchSize::Count(1_500),
        ..FirstPass::default()
    };
    let light = radiosity::solve(&lit, &Tracer::new(&lit), &first, &progress).unwrap();
    lit.set_irradiance(light.irradiance);
    let second = SecondPass {
        size: SIZE,
        samples_per_pixel: 64,
        gather: FinalGather::Everywhere(32),
        ..SecondPass::default()
    };
    let tracer = Tracer::new(&lit);
    render::render(&lit, &tracer, &lit.cameras[0], &second, &progress).unwrap()
}

fn mean(image: &Image) -> Rgb {
    let sum: Rgb = image
        .pixels
        .iter()
        .map(|p| Rgb::from(p.map(f64::from)))
        .sum();
    sum / image.pixels.len() as f64
}

/// A Ward floor, a block by He and Torrance, a ball of rough gold.
#[test]
fn two_passes_show_what_brute_force_shows() {
    let scene = cornell_box(CornellVariant::Glossy);
    scene.validate().unwrap();
    let options = ReferencePass {
        size: SIZE,
        samples_per_pixel: 512,
        ..ReferencePass::default()
    };
    let tracer = Tracer::new(&scene);
    let camera = &scene.cameras[0];
    let truth = render::reference(&scene, &tracer, camera, &options, &Progress::new()).unwrap();
    let found = two_passes(&scene);
    let (a, b) = (mean(&found), mean(&truth.image));
    for k in 0..3 {
        assert!((a[k] / b[k] - 1.0).abs() < 0.02, "{a:?}, expected {b:?}");
    }
    let rmse = render::relative_rmse(&found, &truth.image);
    let known = truth.relative_error();
    assert!(rmse < 0.1 + 2.0 * known, "{rmse}, known to {known}");
}

/// A closed cube whose walls reflect by a model, a lamp below its ceiling, and a matt tile in the
/// middle of its floor that a camera sees from above.
fn mirror_cube(model: &str) -> Scene {
    let mut scene = cube_room();
    let brdf = Brdf::new(model.parse().unwrap()).unwrap();
    scene.materials[0] = Material::with_brdf("wall", Arc::new(brdf));
    let tile = scene.add_material(Material::diffuse("tile", Rgb::grey(TILE)));
    let lamp = scene.add_material(Material {
        emission: Rgb::grey(10.0),
        ..Material::diffuse("lamp", Rgb::BLACK)
    });
    let mut sheet = |corner, edge1, edge2, material| {
        let sheet = Primitive::parallelogram(corner, edge1, edge2, material);
        scene
            .objects
            .push(Object::new("sheet", Shape::Primitive(sheet)));
    };
    sheet(
        dvec3(0.45, 0.45, 0.01),
        DVec3::X * 0.1,
        DVec3::Y * 0.1,
        tile,
    );
    sheet(dvec3(0.6, 0.6, 0.99), DVec3::Y * 0.3, DVec3::X * 0.3, lamp);
    scene.cameras.push(Camera {
        name: "tile".into(),
        eye: dvec3(0.5, 0.5, 0.06),
        target: dvec3(0.5, 0.5, 0.01),
        up: DVec3::Y,
        vertical_fov: 0.5,
        size: Some(SIZE),
    });
    scene
}

/// Reflectance of the tile.
const TILE: f64 = 0.5;

/// Among walls that both mirror and scatter, from the wave's optics, nearly all light on the tile has
/// met several of them.
#[test]
fn light_among_walls_by_he_and_torrance_is_that_of_brute_force() {
    for model in [
        "he_torrance ks = 0.8 sigma0 = 0.05 tau = 2 metal = aluminium",
        "he_torrance sigma0 = 0.4 tau = 2 metal = gold",
    ] {
        let scene = mirror_cube(model);
        let tracer = Tracer::new(&scene);
        let options = ReferencePass {
            size: (16, 16),
            samples_per_pixel: 256,
            ..ReferencePass::default()
        };
        let camera = &scene.cameras[0];
        let truth = render::reference(&scene, &tracer, camera, &options, &Progress::new()).unwrap();
        let first = FirstPass {
            rays: Some(4096),
            ..FirstPass::default()
        };
        let tile = [PointNormal {
            position: dvec3(0.5, 0.5, 0.01),
            normal: DVec3::Z,
        }];
        let found = radiosity::probe(&scene, &tracer, &tile, &first, &Progress::new()).unwrap();
        let (a, b) = (found.estimates[0], mean(&truth.image) * (PI / TILE));
        let own = mean(&truth.error) * (PI / TILE / 16.0);
        for k in 0..3 {
            let margin = 4.0 * a.error[k].hypot(own[k]) + 0.005 * b[k];
            // Four estimates say what a lone point's error is, with a margin for their own doubt.
            assert!(margin < 0.15 * b[k], "{model}: {a:?}, {own:?}");
            assert!(
                (a.value[k] - b[k]).abs() < margin,
                "{model}: {a:?}, expected {b:?}"
            );
        }
    }
}

/// Plastic walls around a ball of rough gold, which throws caustics on them.
fn plastic_box() -> Scene {
    let mut scene = cornell_box(CornellVariant::Glossy);
    let plastic = |base: Rgb| {
        let [r, g, b] = base.to_array();
        let model = format!("gltf_mr base = ({r}, {g}, {b}) metallic = 0 roughness = 0.5");
        Arc::new(Brdf::new(model.parse().unwrap()).unwrap())
    };
    for material in &mut scene.materials {
        if material.brdf.is_none() && !material.diffuse.is_black() {
            let base = material.diffuse;
            *material = Material::with_brdf(&material.name, plastic(base));
        }
    }
    scene
}

/// The base of plastics reads the irradiance of the vertices, as diffuse surfaces do: paths that
/// followed it found the caustics of the whole room, as bright dots.
#[test]
fn pictures_of_plastic_have_no_bright_dots() {
    let scene = plastic_box();
    let first = FirstPass {
        rays: Some(1024),
        ..FirstPass::default()
    };
    let progress = Progress::new();
    let tracer = Tracer::new(&scene);
    let light = radiosity::solve(&scene, &tracer, &first, &progress).unwrap();
    let mut lit = scene.clone();
    lit.set_irradiance(light.irradiance);
    let tracer = Tracer::new(&lit);
    let second = SecondPass {
        size: SIZE,
        samples_per_pixel: 128,
        ..SecondPass::default()
    };
    let camera = &lit.cameras[0];
    let found = render::render_measured(&lit, &tracer, camera, &second, &progress).unwrap();
    // Edges within pixels and the caustics of glossy surfaces included. Of sixteen samples: 0.17.
    let noise = found.relative_error();
    assert!(noise < 0.1, "{noise}");
    let paths = ReferencePass {
        size: (16, 16),
        samples_per_pixel: 512,
        ..ReferencePass::default()
    };
    let tracer = Tracer::new(&scene);
    let truth = render::reference(&scene, &tracer, camera, &paths, &progress).unwrap();
    let (a, b) = (mean(&found.image), mean(&truth.image));
    let error = mean(&truth.error) / 16.0;
    for k in 0..3 {
        let margin = 0.03 * b[k] + 4.0 * error[k];
        assert!(
            (a[k] - b[k]).abs() < margin,
            "{a:?}, expected {b:?} ± {error:?}"
        );
    }
}
