//! Properties of every image: orientation, repeatability, cancelling.

use crate::gallery::gallery;
use crate::{assert_close, camera, primitive, radiance_along};
use azulejo_render::{FinalGather, SecondPass, render, render_with_errors, render_within};
use azulejo_scene::{Fog, Image, Material, Primitive, Rgb, Scene};
use azulejo_trace::{Cancelled, Progress, Tracer};
use glam::DVec3;

#[test]
fn images_are_neither_mirrored_nor_upside_down() {
    let mut scene = Scene::default();
    let colours = [
        (-1.0, 1.0, Rgb::new(1.0, 0.0, 0.0)),
        (1.0, 1.0, Rgb::new(0.0, 1.0, 0.0)),
        (-1.0, -1.0, Rgb::new(0.0, 0.0, 1.0)),
    ];
    for (x, y, colour) in colours {
        let lamp = scene.add_material(Material::emitter("lamp", colour));
        let corner = DVec3::new(x - 0.5, y - 0.5, 0.0);
        primitive(
            &mut scene,
            Primitive::parallelogram(corner, DVec3::X, DVec3::Y, lamp),
        );
    }
    let eye = camera(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO, 53.13);
    let options = SecondPass {
        size: (16, 16),
        ..SecondPass::default()
    };
    let image = render(
        &scene,
        &Tracer::new(&scene),
        &eye,
        &options,
        &Progress::new(),
    )
    .expect("nobody cancels");
    let at = |x, y| Rgb::from(image.pixel(x, y).map(f64::from));
    assert_close(at(4, 4), Rgb::new(1.0, 0.0, 0.0), 1e-6);
    assert_close(at(11, 4), Rgb::new(0.0, 1.0, 0.0), 1e-6);
    assert_close(at(4, 11), Rgb::new(0.0, 0.0, 1.0), 1e-6);
    assert_close(at(11, 11), Rgb::BLACK, 0.0);
}

#[test]
fn background_and_fog_are_seen() {
    let mut scene = Scene::default();
    let lamp = scene.add_material(Material::emitter("lamp", Rgb::grey(2.0)));
    let corner = DVec3::new(-1.0, -1.0, 0.0);
    let plate = Primitive::parallelogram(corner, 2.0 * DVec3::X, 2.0 * DVec3::Y, lamp);
    primitive(&mut scene, plate);
    let mist = Rgb::new(0.2, 0.4, 0.6);
    scene.background = Some(Rgb::new(0.0, 0.5, 1.0).into());
    scene.fog = Some(Fog {
        color: mist,
        visibility: 4.0,
        exponential: false,
    });
    let eye = DVec3::Z;
    let rays = [(eye, DVec3::ZERO), (eye, 2.0 * DVec3::Z)];
    let found = radiance_along(&scene, &rays, &SecondPass::default());
    assert_close(found[0], 0.75 * Rgb::grey(2.0) + 0.25 * mist, 1e-6);
    assert_close(found[1], Rgb::new(0.0, 0.5, 1.0), 0.0);
    let exponential = scene.fog.as_mut().expect("fog");
    exponential.exponential = true;
    let clear = f64::exp(-1.0 / 3.0);
    let expected = clear * Rgb::grey(2.0) + (1.0 - clear) * mist;
    assert_close(
        radiance_along(&scene, &rays, &SecondPass::default())[0],
        expected,
        1e-6,
    );
}

#[test]
fn some_emitters_are_seen_from_both_sides() {
    let mut scene = Scene::default();
    let lamp = scene.add_material(Material {
        emits_back: true,
        ..Material::emitter("lamp", Rgb::grey(2.0))
    });
    primitive(
        &mut scene,
        Primitive::parallelogram(DVec3::ZERO, DVec3::X, DVec3::Y, lamp),
    );
    let middle = DVec3::new(0.5, 0.5, 0.0);
    let rays = [(middle + DVec3::Z, middle), (middle - DVec3::Z, middle)];
    for radiance in radiance_along(&scene, &rays, &SecondPass::default()) {
        assert_close(radiance, Rgb::grey(2.0), 0.0);
    }
}

/// The gallery in a pool of `threads`.
fn drawn_by(threads: usize, options: &SecondPass) -> Image {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let (scene, eye) = gallery(6);
    let tracer = Tracer::new(&scene);
    let draw = || render(&scene, &tracer, &eye, options, &Progress::new());
    pool.expect("a pool").install(draw).expect("nobody cancels")
}

#[test]
fn threads_do_not_change_a_bit() {
    for gather in [
        FinalGather::Unknown,
        FinalGather::Uneven(4),
        FinalGather::Everywhere(4),
    ] {
        let options = SecondPass {
            size: (45, 33),
            samples_per_pixel: 3,
            gather,
            ..SecondPass::default()
        };
        let one = drawn_by(1, &options);
        assert!(one == drawn_by(8, &options), "gather {gather:?}");
        let other = SecondPass {
            seed: 1 << 40,
            ..options
        };
        assert!(one != drawn_by(1, &other), "the seed changes nothing");
    }
}

/// A limit that suffices changes nothing; one that does not leaves fewer samples, the same for any number of threads.
#[test]
fn pictures_keep_to_a_number_of_rays() {
    let (scene, eye) = gallery(6);
    let tracer = Tracer::new(&scene);
    let whole = SecondPass {
        size: (45, 33),
        gather: FinalGather::Uneven(16),
        ..SecondPass::default()
    };
    let within = |rays: u64, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let progress = Progress::new();
        let draw = || render_within(rays, &scene, &tracer, &eye, &whole, &progress);
        pool.expect("a pool").install(draw).expect("nobody cancels")
    };
    let (image, taken) = within(u64::MAX, 1);
    assert_eq!(taken, whole);
    let plain = render_with_errors(&scene, &tracer, &eye, &whole, &Progress::new());
    assert_eq!(Ok(image), plain);
    let (image, taken) = within(1, 1);
    assert_eq!(taken.samples_per_pixel, 4);
    assert!((image.clone(), taken) == within(1, 2));
    // Each sample takes a ray at least, so that half of the samples fit where half of those rays do.
    let samples = 16 * 45 * 33;
    let (_, taken) = within(samples / 2 - 1, 1);
    assert!(taken.samples_per_pixel < 8);
}

/// Pixels that are even get few samples, and others are the same to the bit as with all of them.
#[test]
fn contrast_decides_on_samples() {
    let whole = SecondPass {
        size: (45, 33),
        ..SecondPass::default()
    };
    let with = |contrast, samples_per_pixel| {
        let options = SecondPass {
            contrast,
            samples_per_pixel,
            ..whole.clone()
        };
        drawn_by(2, &options).pixels
    };
    let (all, few, some) = (with(None, 16), with(None, 4), with(Some(0.05), 16));
    let like = |other: &[[f32; 3]]| some.iter().zip(other).filter(|(a, b)| a == b).count();
    assert!(
        some.iter()
            .enumerate()
            .all(|(k, p)| *p == all[k] || *p == few[k])
    );
    assert!(
        like(&few) > some.len() / 10,
        "{} pixels are even",
        like(&few)
    );
    assert!(like(&all) > some.len() / 10, "{} are not", like(&all));
    assert_eq!(with(Some(0.0), 16), all);
}

#[test]
fn odd_sizes_and_no_samples_are_drawn() {
    for size in [(0, 0), (0, 5), (1, 1), (17, 1)] {
        let options = SecondPass {
            size,
            samples_per_pixel: 0,
            ..SecondPass::default()
        };
        let image = drawn_by(1, &options);
        assert_eq!(image.pixels.len(), (size.0 * size.1) as usize);
        assert!(image.pixels.iter().flatten().all(|x| x.is_finite()));
    }
}

#[test]
fn a_cancelled_image_stops() {
    let (scene, eye) = gallery(6);
    let tracer = Tracer::new(&scene);
    let options = SecondPass {
        size: (4096, 4096),
        samples_per_pixel: 1024,
        ..SecondPass::default()
    };
    let progress = Progress::new();
    let drawn = std::thread::scope(|scope| {
        scope.spawn(|| {
            while progress.done() == 0 {
                std::thread::yield_now();
            }
            progress.cancel();
        });
        render(&scene, &tracer, &eye, &options, &progress)
    });
    assert_eq!(drawn, Err(Cancelled));
    assert!(
        progress.done() < progress.total() / 10,
        "{}",
        progress.done()
    );
}

#[test]
fn progress_counts_every_pixel() {
    let (scene, eye) = gallery(2);
    let options = SecondPass {
        size: (37, 21),
        samples_per_pixel: 1,
        ..SecondPass::default()
    };
    let progress = Progress::new();
    render(&scene, &Tracer::new(&scene), &eye, &options, &progress).expect("nobody cancels");
    assert_eq!((progress.done(), progress.total()), (37 * 21, 37 * 21));
    let empty = SecondPass {
        size: (0, 5),
        ..options
    };
    let (_, taken) = render_within(1, &scene, &Tracer::new(&scene), &eye, &empty, &progress)
        .expect("nobody cancels");
    assert_eq!(taken, empty);
}
