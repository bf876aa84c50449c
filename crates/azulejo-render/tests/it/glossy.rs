//! Reflection models in the second pass and the reference, against furnaces, sums over lamps, and
//! each other.

use crate::{camera, primitive};
use azulejo_render::{
    MeasuredImage, ReferencePass, SecondPass, radiance, reference, reference_radiance, render,
};
use azulejo_scene::brdf::{Brdf, Description, MODELS};
use azulejo_scene::math::Ray;
use azulejo_scene::{Light, LightKind, Material, Primitive, Rgb, Scene};
use azulejo_trace::{Progress, Tracer};
use glam::DVec3;
use std::f64::consts::PI;
use std::sync::Arc;

fn brdf(text: &str) -> Arc<Brdf> {
    let description: Description = text.parse().unwrap_or_else(|e| panic!("{text}: {e}"));
    Arc::new(Brdf::new(description).unwrap_or_else(|e| panic!("{text}: {e}")))
}

/// A floor of that model in z = 0, 6 × 6.
fn floor(scene: &mut Scene, model: &str) {
    let material = scene.add_material(Material::with_brdf("floor", brdf(model)));
    let (corner, a, b) = (DVec3::new(-3.0, -3.0, 0.0), DVec3::X * 6.0, DVec3::Y * 6.0);
    primitive(scene, Primitive::parallelogram(corner, a, b, material));
}

/// A lamp over the floor that shines down.
const LAMP: [DVec3; 3] = [
    DVec3::new(0.3, -0.5, 1.0),
    DVec3::new(0.0, 1.0, 0.0),
    DVec3::new(0.7, 0.0, 0.4),
];

fn lamp(scene: &mut Scene) {
    let material = scene.add_material(Material::emitter("lamp", Rgb::new(2.0, 3.0, 4.0)));
    let [corner, a, b] = LAMP;
    primitive(scene, Primitive::parallelogram(corner, a, b, material));
}

/// A ray from the side toward the origin of the floor, under that angle to the normal.
fn ray(degrees: f64) -> Ray {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let way = DVec3::new(sin, 0.1, -cos).normalize();
    Ray::new(-4.0 * way, way)
}

/// What the second pass and the reference see along a ray; the reference with its error.
fn both(scene: &Scene, ray: Ray) -> (Rgb, Rgb, Rgb) {
    scene.validate().expect("the test's scene is valid");
    let tracer = Tracer::new(scene);
    let second = SecondPass {
        samples_per_pixel: 8192,
        ..SecondPass::default()
    };
    let first = ReferencePass {
        samples_per_pixel: 8192,
        ..ReferencePass::default()
    };
    let progress = Progress::new();
    let seen = radiance(scene, &tracer, &[ray], &second, &progress).unwrap();
    let truth = reference_radiance(scene, &tracer, &[ray], &first, &progress).unwrap();
    (seen[0], truth[0].0, truth[0].1)
}

fn assert_within(found: Rgb, expected: Rgb, margin: Rgb, what: &str) {
    for k in 0..3 {
        assert!(
            (found[k] - expected[k]).abs() <= margin[k],
            "{what}: {found:?}, expected {expected:?} within {margin:?}"
        );
    }
}

/// Radiance from the origin of the floor back along a ray: sum over the lamp.
fn lit_by_lamp(model: &str, ray: &Ray) -> Rgb {
    let brdf = brdf(model);
    let [corner, a, b] = LAMP;
    let across = a.cross(b);
    let n = 400;
    let mut sum = Rgb::BLACK;
    for k in 0..n * n {
        let at = |k: i32| (f64::from(k) + 0.5) / f64::from(n);
        let y = corner + at(k % n) * a + at(k / n) * b;
        let wi = y.normalize();
        let solid = -wi.dot(across) / (y.length_squared() * f64::from(n * n));
        sum += brdf.eval(-ray.direction, wi) * (wi.z * solid);
    }
    sum * Rgb::new(2.0, 3.0, 4.0)
}

#[test]
fn a_lamp_in_a_glossy_floor() {
    for (model, degrees) in [
        ("lewis n = 40 ks = (0.9, 0.5, 0.2)", 40.0),
        ("lewis n = 2000", 35.0),
        ("lewis n = 1 ks = 0.4", 70.0),
    ] {
        let mut scene = Scene::default();
        floor(&mut scene, model);
        lamp(&mut scene);
        let ray = ray(degrees);
        let expected = lit_by_lamp(model, &ray);
        let (seen, truth, error) = both(&scene, ray);
        let margin = error * 4.0 + expected * 2e-3;
        assert!(
            error.max_channel() < 0.02 * expected.max_channel(),
            "{error:?}"
        );
        assert_within(truth, expected, margin, model);
        assert_within(seen, expected, margin, model);
    }
}

#[test]
fn lights_without_area_in_a_glossy_floor() {
    let model = "lewis n = 12 ks = 0.7";
    let mut scene = Scene::default();
    floor(&mut scene, model);
    // More than one sample takes: each must count once on average.
    let position = |k: i32| DVec3::new(0.4 + 0.05 * f64::from(k), 0.3, 1.0 + 0.1 * f64::from(k));
    let intensity = Rgb::grey(0.5);
    for k in 0..19 {
        let position = position(k);
        let kind = LightKind::Point {
            position,
            intensity,
        };
        scene.lights.push(Light {
            name: String::new(),
            kind,
        });
    }
    let ray = ray(45.0);
    let brdf = brdf(model);
    let of = |k| {
        let p = position(k);
        let wi = p.normalize();
        brdf.eval(-ray.direction, wi) * (0.5 * wi.z / p.length_squared())
    };
    let expected: Rgb = (0..19).map(of).sum();
    let (seen, truth, error) = both(&scene, ray);
    assert_within(truth, expected, error * 4.0 + expected * 1e-3, "reference");
    assert_within(seen, expected, error * 4.0 + expected * 1e-3, "second pass");
}

/// Under a constant sky a surface shows its albedo.
#[test]
fn an_even_sky_shows_the_albedo() {
    for model in [
        "lewis n = 25 ks = 0.6",
        "diffuse kd = 0.4",
        "fresnel_dielectric eta = 1.5",
        "combination weight = 0.3 diffuse kd = 0.8 weight = 0.5 lewis n = 60 weight = 0.2 specular ks = 0.5",
    ] {
        let mut scene = Scene::default();
        floor(&mut scene, model);
        scene.lights.push(Light {
            name: "sky".into(),
            kind: LightKind::Ambient {
                radiance: Rgb::WHITE,
            },
        });
        // The irradiance that a first pass would compute.
        if let azulejo_scene::Shape::Primitive(p) = &mut scene.objects[0].shape {
            let grids = p.grids(1.0, f64::INFINITY);
            let count: usize = grids.iter().map(|g| g.vertices()).sum();
            p.light = Some(Box::new(azulejo_scene::SurfaceLight {
                grids,
                irradiance: vec![Rgb::grey(PI); count],
                error: Vec::new(),
            }));
        }
        let ray = ray(55.0);
        let expected = brdf(model).albedo(-ray.direction);
        let (seen, truth, error) = both(&scene, ray);
        let margin = error * 4.0 + Rgb::grey(2e-3);
        assert_within(truth, expected, margin, model);
        assert_within(seen, expected, margin, model);
    }
}

#[test]
fn images_carry_their_errors() {
    let mut scene = Scene::default();
    floor(&mut scene, "lewis n = 20 kd = 0.3 ks = 0.5");
    lamp(&mut scene);
    let tracer = Tracer::new(&scene);
    let eye = camera(DVec3::new(-2.0, -2.0, 1.5), DVec3::ZERO, 60.0);
    let estimate = |samples, seed| -> MeasuredImage {
        let options = ReferencePass {
            size: (24, 16),
            samples_per_pixel: samples,
            seed,
            ..ReferencePass::default()
        };
        reference(&scene, &tracer, &eye, &options, &Progress::new()).unwrap()
    };
    let (rough, fine) = (estimate(64, 1), estimate(4096, 2));
    let pairs = rough.image.pixels.iter().zip(&fine.image.pixels);
    let squares = pairs.zip(&rough.error.pixels).flat_map(|((a, b), e)| {
        let known = (0..3).filter(|&k| e[k] > 0.0);
        known.map(|k| ((a[k] - b[k]) / e[k]).powi(2))
    });
    let squares: Vec<f32> = squares.collect();
    let mean = squares.iter().sum::<f32>() / squares.len() as f32;
    // Stratified samples have a smaller error than the independent ones that the estimate assumes.
    assert!((0.05..1.3).contains(&mean), "{mean}");
    assert!(fine.relative_error() < 0.25 * rough.relative_error());
    // The second pass agrees without irradiance, as the floor reflects nothing diffusely.
    let options = SecondPass {
        size: (24, 16),
        samples_per_pixel: 256,
        gather: azulejo_render::FinalGather::Everywhere(256),
        ..SecondPass::default()
    };
    let seen = render(&scene, &tracer, &eye, &options, &Progress::new()).unwrap();
    let worst = seen
        .pixels
        .iter()
        .zip(&fine.image.pixels)
        .flat_map(|(a, b)| (0..3).map(move |k| (a[k] - b[k]).abs() / (0.05 + b[k])));
    let worst = worst.fold(0.0, f32::max);
    assert!(worst < 0.1, "{worst}");
}

/// The white furnace of every model: under a constant sky of radiance 1 a convex body shows its
/// albedo from all sides in the reference, and never more than 1 if the model conserves energy.
#[test]
fn every_model_in_the_furnace() {
    for info in MODELS {
        for model in info.examples {
            let brdf = brdf(model);
            let mut scene = Scene::default();
            let material = Material::with_brdf("model", brdf.clone());
            let used = material.brdf.clone().expect("a model was given");
            let material = scene.add_material(material);
            primitive(&mut scene, Primitive::sphere(DVec3::ZERO, 1.0, material));
            scene.lights.push(Light {
                name: "sky".into(),
                kind: LightKind::Ambient {
                    radiance: Rgb::WHITE,
                },
            });
            for degrees in [0.0, 45.0, 80.0] {
                let (sin, cos) = f64::to_radians(degrees).sin_cos();
                // The sphere's side that faces −x: the ray comes along x, the normal turns in y.
                let ray = Ray::new(DVec3::new(-4.0, sin, 0.0), DVec3::X);
                let (found, error) = furnace(&scene, ray);
                let normal = DVec3::new(-cos, sin, 0.0);
                let expected = used.albedo(in_frame(normal));
                let what = format!("{model} at {degrees}°");
                assert_within(found, expected, error * 4.5 + Rgb::grey(4e-3), &what);
                if info.is_energy_safe {
                    let excess = found - error * 4.5;
                    assert!(excess.max_channel() < 1.0 + 1e-4, "{what}: {found:?}");
                }
            }
        }
    }
}

/// The direction −x in the frame that surfaces without texture coordinates have.
fn in_frame(normal: DVec3) -> DVec3 {
    let axis = if normal.x.abs() > 0.999 {
        DVec3::Y
    } else {
        DVec3::X
    };
    let x = (axis - axis.dot(normal) * normal).normalize();
    let wo = DVec3::NEG_X;
    DVec3::new(wo.dot(x), wo.dot(normal.cross(x)), wo.dot(normal))
}

fn furnace(scene: &Scene, ray: Ray) -> (Rgb, Rgb) {
    let options = ReferencePass {
        samples_per_pixel: 4096,
        ..ReferencePass::default()
    };
    let tracer = Tracer::new(scene);
    let progress = Progress::new();
    reference_radiance(scene, &tracer, &[ray], &options, &progress).unwrap()[0]
}
