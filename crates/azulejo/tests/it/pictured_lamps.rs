//! Surfaces that emit pictures: both passes, by every engine that shoots or gathers, against the
//! reference.

use azulejo::factors::PatchSize;
use azulejo::radiosity::{Engine, FirstPass, solve};
use azulejo::render::{FinalGather, ReferencePass, SecondPass, radiance, reference_radiance};
use azulejo::scene::brdf::Description;
use azulejo::scene::math::Ray;
use azulejo::scene::{
    Attribute, Brdf, Image, Material, Mesh, Object, Primitive, Rgb, Scene, Shape, Texture,
};
use azulejo::trace::{Progress, Tracer};
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// A quadrilateral that shows a picture once.
fn pictured(scene: &mut Scene, corners: [DVec3; 4], material: u32) {
    let places = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mut mesh = Mesh {
        positions: corners.to_vec(),
        uvs: Some(Attribute::per_vertex(
            places.map(|[u, v]| DVec2::new(u, v)).to_vec(),
        )),
        ..Mesh::default()
    };
    mesh.push_face(&[0, 1, 2, 3], material);
    scene.objects.push(Object::new("sheet", Shape::Mesh(mesh)));
}

/// Black, with one bright window and one dim one.
fn windows() -> Image {
    let pixel = |k: u32| match (k % 64, k / 64) {
        (8..16, 12..20) => [40.0, 30.0, 10.0],
        (40..56, 30..50) => [1.0, 2.0, 4.0],
        _ => [0.0; 3],
    };
    Image::opaque(64, 64, (0..64 * 64).map(pixel).collect())
}

/// A room of 4 × 4 × 3 with a lamp that covers a part of its ceiling, a ball, and a glossy table.
fn room(picture: Image) -> Scene {
    let mut scene = Scene::default();
    scene.textures.push(Texture {
        path: "lamp.hdr".into(),
        image: Some(picture),
        ..Texture::default()
    });
    let white = scene.add_material(Material::diffuse("white", Rgb::grey(0.6)));
    let red = scene.add_material(Material::diffuse("red", Rgb::new(0.7, 0.2, 0.1)));
    let gloss: Description = "ward_gmd ks = 0.4 ax = 0.1 ay = 0.1".parse().unwrap();
    let table = Material::with_brdf("table", Arc::new(Brdf::new(gloss).unwrap()));
    let table = scene.add_material(table);
    let lamp = scene.add_material(Material {
        emission_picture: Some(0),
        ..Material::emitter("lamp", Rgb::grey(2.0))
    });
    let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let walls = [
        [p(0., 0., 0.), p(4., 0., 0.), p(4., 4., 0.), p(0., 4., 0.)],
        [p(0., 0., 3.), p(0., 4., 3.), p(4., 4., 3.), p(4., 0., 3.)],
        [p(0., 0., 0.), p(0., 0., 3.), p(4., 0., 3.), p(4., 0., 0.)],
        [p(0., 4., 0.), p(4., 4., 0.), p(4., 4., 3.), p(0., 4., 3.)],
        [p(0., 0., 0.), p(0., 4., 0.), p(0., 4., 3.), p(0., 0., 3.)],
        [p(4., 0., 0.), p(4., 0., 3.), p(4., 4., 3.), p(4., 4., 0.)],
    ];
    for (k, wall) in walls.into_iter().enumerate() {
        pictured(&mut scene, wall, if k == 4 { red } else { white });
    }
    let z = 2.95;
    let corners = [p(0.5, 1., z), p(0.5, 3., z), p(3.5, 3., z), p(3.5, 1., z)];
    pictured(&mut scene, corners, lamp);
    let z = 0.6;
    let corners = [p(2., 2., z), p(3.5, 2., z), p(3.5, 3.5, z), p(2., 3.5, z)];
    pictured(&mut scene, corners, table);
    let ball = Primitive::sphere(p(1.0, 2.6, 0.7), 0.6, white);
    scene
        .objects
        .push(Object::new("ball", Shape::Primitive(ball)));
    scene.validate().unwrap();
    scene
}

/// To the floor, walls, ball, the shadow, the table that reflects the lamp, the lamp's windows.
fn rays() -> Vec<Ray> {
    let eye = DVec3::new(2.0, 0.3, 1.6);
    let targets = [
        [2.0, 1.5, 0.0],
        [0.0, 2.0, 1.0],
        [3.0, 4.0, 2.0],
        [1.0, 2.2, 1.2],
        [1.2, 3.6, 0.0],
        [2.6, 2.6, 0.6],
        [2.9, 2.4, 0.6],
        [2.75, 1.375, 2.95],
    ];
    let targets = targets.map(DVec3::from_array);
    targets
        .map(|to| Ray::new(eye, (to - eye).normalize()))
        .to_vec()
}

fn seen(given: &Scene, engine: Engine) -> Vec<Rgb> {
    let tracer = Tracer::new(given);
    let progress = Progress::new();
    let first = FirstPass {
        error: Some(0.02),
        engine,
        ..FirstPass::default()
    };
    let solved = solve(given, &tracer, &first, &progress).unwrap();
    let mut scene = given.clone();
    scene.set_irradiance(solved.irradiance);
    let second = SecondPass {
        samples_per_pixel: 64,
        gather: FinalGather::Everywhere(64),
        ..SecondPass::default()
    };
    let again = Tracer::new(&scene);
    radiance(&scene, &again, &rays(), &second, &progress).unwrap()
}

#[test]
fn passes_and_reference_agree_under_pictured_lamps() {
    let given = room(windows());
    let options = ReferencePass {
        samples_per_pixel: 1024,
        ..ReferencePass::default()
    };
    let tracer = Tracer::new(&given);
    let truth = reference_radiance(&given, &tracer, &rays(), &options, &Progress::new()).unwrap();
    for engine in [Engine::default(), Engine::Particles] {
        for ((seen, (truth, error)), ray) in
            seen(&given, engine.clone()).iter().zip(&truth).zip(rays())
        {
            for k in 0..3 {
                let margin = 4.0 * error[k] + 0.02 * truth[k];
                assert!(
                    (seen[k] - truth[k]).abs() <= margin,
                    "{engine:?} {ray:?}: {seen:?}, {truth:?} ± {error:?}"
                );
            }
        }
    }
}

/// An even picture is a lamp without one.
#[test]
fn an_even_picture_is_an_even_lamp() {
    let color = [0.5, 1.0, 2.0];
    let pictured = room(Image::opaque(7, 5, vec![color; 35]));
    let mut plain = pictured.clone();
    let lamp = plain.materials.last_mut().unwrap();
    lamp.emission_picture = None;
    lamp.emission *= Rgb::from(color.map(f64::from));
    let [a, b] = [pictured, plain].map(|scene| seen(&scene, Engine::default()));
    for (a, b) in a.iter().zip(&b) {
        let off = (*a - *b).map(f64::abs).max_channel();
        assert!(off < 0.02 * b.max_channel(), "{a:?} {b:?}");
    }
}

/// What arrives in a closed black room is what the picture emits, and does not depend on threads.
#[test]
fn power_is_the_integral_of_the_picture() {
    let mut scene = room(windows());
    let mean = scene.textures[0].mean();
    let progress = Progress::new();
    let power = mean * (2.0 * std::f64::consts::PI * 2.0 * 3.0);
    let tracer = Tracer::new(&scene);
    for engine in [Engine::default(), Engine::Particles] {
        let pass = FirstPass {
            engine,
            size: PatchSize::Count(500),
            ..FirstPass::default()
        };
        let solved = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let pool = pool.build().unwrap();
            pool.install(|| solve(&scene, &tracer, &pass, &progress).unwrap())
        };
        let (one, four) = (solved(1), solved(4));
        assert_eq!(one.irradiance, four.irradiance);
        let emitted = one.report.balance.emitted;
        let off = (emitted - power).map(f64::abs).max_channel();
        assert!(off < 0.01 * power.max_channel(), "{emitted:?} {power:?}");
    }
    // Without its picture's pixels it is dark.
    scene.textures[0].image = None;
    assert!(scene.mean_emissions().iter().all(|e| e.is_black()));
}
