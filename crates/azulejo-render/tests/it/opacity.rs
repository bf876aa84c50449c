//! Pictures through surfaces that are not opaque.

use crate::{camera, polygon};
use azulejo_render::{ReferencePass, SecondPass, reference, render};
use azulejo_scene::{Image, Light, LightKind, Material, Opacity, Rgb, Scene};
use azulejo_trace::{Progress, Tracer};
use glam::DVec3;

/// A square of half an edge at height `z`, front up.
fn square(scene: &mut Scene, z: f64, half: f64, material: u32) {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let corners = corners.map(|[x, y]| DVec3::new(half * x, half * y, z));
    polygon(scene, &corners, material);
}

fn gauze(scene: &mut Scene, diffuse: f64, opacity: f64) -> u32 {
    scene.add_material(Material {
        opacity: Some(Opacity::constant(opacity)),
        ..Material::diffuse("gauze", Rgb::grey(diffuse))
    })
}

/// Mean of an image and the standard error of this mean by its pixels.
fn mean(image: &Image) -> (f64, f64) {
    let values = image.pixels.iter().map(|p| f64::from(p[1]));
    let n = image.pixels.len() as f64;
    let mean = values.clone().sum::<f64>() / n;
    let spread = values.map(|v| (v - mean).powi(2)).sum::<f64>() / n;
    (mean, (spread / n).sqrt())
}

fn seen(scene: &Scene, threads: usize) -> [Image; 2] {
    scene.validate().unwrap();
    let tracer = Tracer::new(scene);
    let mut eye = camera(DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO, 20.0);
    eye.up = DVec3::Y;
    let (size, progress) = ((64, 64), Progress::new());
    let paths = ReferencePass {
        size,
        samples_per_pixel: 16,
        ..ReferencePass::default()
    };
    let second = SecondPass {
        size,
        samples_per_pixel: 16,
        ..SecondPass::default()
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    pool.build().unwrap().install(|| {
        [
            reference(scene, &tracer, &eye, &paths, &progress)
                .unwrap()
                .image,
            render(scene, &tracer, &eye, &second, &progress).unwrap(),
        ]
    })
}

/// A lamp behind gauze of 0.3, and behind two sheets of 0.5, one of which reflects nothing of it.
#[test]
fn lamps_shine_through_gauze() {
    for (sheets, share) in [(vec![0.3], 0.7), (vec![0.5, 0.5], 0.25), (vec![1.0], 0.0)] {
        let mut scene = Scene::default();
        let lamp = scene.add_material(Material::emitter("lamp", Rgb::grey(2.0)));
        square(&mut scene, 0.0, 2.0, lamp);
        for (k, &opacity) in sheets.iter().enumerate() {
            let black = gauze(&mut scene, 0.0, opacity);
            square(&mut scene, 1.0 + 0.5 * k as f64, 2.0, black);
        }
        for image in seen(&scene, 1) {
            let (mean, error) = mean(&image);
            let off = (mean - 2.0 * share).abs();
            assert!(off <= 4.0 * error + 1e-6, "{mean} ± {error} of {share}");
        }
    }
}

/// A floor under a sun behind gauze: E = (1 − α) E₀, of which the camera sees (1 − α) ρ E / π, and the
/// gauze shows α ρ E₀ / π itself.
#[test]
fn the_sun_through_gauze() {
    let mut scene = Scene::default();
    scene.lights.push(Light {
        name: "sun".into(),
        kind: LightKind::Directional {
            direction: -DVec3::Z,
            irradiance: Rgb::grey(std::f64::consts::PI),
            half_angle: 0.0,
        },
    });
    let floor = scene.add_material(Material::diffuse("floor", Rgb::grey(0.8)));
    square(&mut scene, 0.0, 0.8, floor);
    let white = gauze(&mut scene, 0.5, 0.4);
    square(&mut scene, 1.0, 5.0, white);
    let [image, _] = seen(&scene, 1);
    let (mean, error) = mean(&image);
    // Beside direct light, what gauze and floor send to each other: less than a fifth.
    let direct = 0.6 * 0.8 * 0.6 + 0.4 * 0.5;
    assert!(
        mean > direct - 4.0 * error && mean < 1.2 * direct,
        "{mean} ± {error}, {direct} by direct light"
    );
    let [one, four] = [1, 4].map(|threads| seen(&scene, threads));
    assert_eq!(one, four);
}
