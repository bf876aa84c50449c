//! Reflection models from file to picture: two passes against brute force.

use azulejo::radiosity::{self, FirstPass};
use azulejo::render::{self, ReferencePass, SecondPass};
use azulejo::scene::synthetic::{CornellVariant, cornell_box};
use azulejo::scene::{Image, Rgb, Scene};
use azulejo::trace::{Progress, Tracer};

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
        gather: Some(32),
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
