//! Surfaces through which light passes: irradiance behind them in closed form, and no energy lost.

use crate::rooms::*;
use azulejo_factors::Engine;
use azulejo_radiosity::{Estimate, FirstPass, PatchSize, PointNormal, probe, solve};
use azulejo_scene::{
    Attribute, Image, Light, LightKind, Material, Object, Opacity, OpacityChannel, OpacityMode,
    OpacityPicture, Rgb, Scene, Shape, Texture,
};
use azulejo_trace::lambert::point_to_polygon;
use azulejo_trace::{Progress, Tracer};
use glam::{DVec2, DVec3, dvec3};
use std::f64::consts::PI;

/// A matt surface of an opacity.
fn gauze(diffuse: f64, opacity: f64) -> Material {
    Material {
        opacity: Some(Opacity::constant(opacity)),
        ..surface(diffuse, 0.0, 0.0)
    }
}

/// Adds a sheet at a height, over all that the points below see of the lamps.
fn add_roof(scene: &mut Scene, z: f64, material: Material) {
    let corner = dvec3(-20.0, -20.0, z);
    add_sheet(scene, corner, 40.0 * DVec3::X, 40.0 * DVec3::Y, material);
}

/// A board of 8 × 8 fields, half of them clear, 16 times along each side of the roof.
fn add_board(scene: &mut Scene, z: f64) {
    let is_clear = |k: u32| (k % 64 / 8 + k / 64 / 8).is_multiple_of(2);
    let alpha = (0..64 * 64).map(|k| if is_clear(k) { 0.0 } else { 1.0 });
    let image = Image::opaque(64, 64, vec![[1.0; 3]; 64 * 64]).with_alpha(alpha.collect());
    scene.textures.push(Texture {
        path: "board.png".into(),
        image: Some(image),
        ..Texture::default()
    });
    let board = Material {
        opacity: Some(Opacity {
            picture: Some(OpacityPicture {
                texture: 0,
                channel: OpacityChannel::Alpha,
            }),
            mode: OpacityMode::Mask { cutoff: 0.5 },
            ..Opacity::constant(1.0)
        }),
        ..surface(0.0, 0.0, 0.0)
    };
    add_roof(scene, z, board);
    let uvs = [[0.0, 0.0], [16.0, 0.0], [16.0, 16.0], [0.0, 16.0]];
    if let Some(Object {
        shape: Shape::Mesh(mesh),
        ..
    }) = scene.objects.last_mut()
    {
        mesh.uvs = Some(Attribute::per_vertex(uvs.map(DVec2::from).to_vec()));
    }
}

fn grid() -> Vec<PointNormal> {
    let point = |k: i32| {
        let (x, y) = (
            f64::from(k % 20) * 0.21 - 2.0,
            f64::from(k / 20) * 0.23 - 2.2,
        );
        at(x, y, 0.0, DVec3::Z)
    };
    (0..400).map(point).collect()
}

/// A black floor under a point light.
fn under_point_light() -> Scene {
    let mut scene = Scene::default();
    scene.lights.push(Light {
        name: String::new(),
        kind: LightKind::Point {
            position: dvec3(0.3, -0.2, 2.0),
            intensity: Rgb::grey(7.0),
        },
    });
    let edge = 8.0 * DVec3::X;
    add_sheet(
        &mut scene,
        dvec3(-4.0, -4.0, 0.0),
        edge,
        8.0 * DVec3::Y,
        surface(0.0, 0.0, 0.0),
    );
    scene
}

/// E = I cos θ / r².
fn from_point_light(p: DVec3) -> f64 {
    let d = dvec3(0.3, -0.2, 2.0) - p;
    7.0 * d.z / d.length().powi(3)
}

/// One ray per light and point multiplies what passes, so that the light is exact.
#[test]
fn point_lights_through_gauze_are_exact() {
    let check = |roofs: &[(f64, f64)], share: f64| {
        let mut scene = under_point_light();
        for &(z, opacity) in roofs {
            add_roof(&mut scene, z, gauze(0.0, opacity));
        }
        for (e, p) in irradiance(&scene, &grid(), &rays(16)).iter().zip(grid()) {
            let truth = share * from_point_light(p.position);
            let off = (e.value.mean() - truth).abs();
            assert!(
                off < 1e-6 * truth,
                "{p:?} {roofs:?} {} of {truth}",
                e.value.mean()
            );
            assert_eq!(e.error, Rgb::BLACK);
        }
    };
    check(&[(1.0, 0.3)], 0.7);
    check(&[(0.5, 0.5), (1.0, 0.5)], 0.25);
    check(&[(3.0, 0.5)], 1.0);
}

/// The mean over many points, and either all of the light or none at each.
#[test]
fn a_checkerboard_passes_half_of_a_point_light() {
    let mut scene = under_point_light();
    add_board(&mut scene, 1.0);
    let found = irradiance(&scene, &grid(), &rays(16));
    let mut seen = 0;
    for (e, p) in found.iter().zip(grid()) {
        let share = e.value.mean() / from_point_light(p.position);
        assert!(share < 1e-9 || (share - 1.0).abs() < 1e-6, "{share}");
        seen += usize::from(share > 0.5);
    }
    assert!((160..=240).contains(&seen), "{seen} of 400");
}

/// The mean of estimates over their truths, and its standard error.
fn mean_ratio(found: &[Estimate], truth: impl Fn(usize) -> f64) -> (f64, f64) {
    let n = found.len() as f64;
    let ratios = found.iter().enumerate();
    let ratios: Vec<f64> = ratios.map(|(k, e)| e.value.mean() / truth(k)).collect();
    let mean = ratios.iter().sum::<f64>() / n;
    let spread = ratios.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / n;
    (mean, (spread / n).sqrt())
}

#[test]
fn an_area_lamp_through_roofs() {
    let lamp = [
        dvec3(-0.5, -0.5, 2.0),
        dvec3(-0.5, 0.5, 2.0),
        dvec3(0.5, 0.5, 2.0),
        dvec3(0.5, -0.5, 2.0),
    ];
    let points = grid();
    let truth = |k: usize| PI * point_to_polygon(points[k].position, DVec3::Z, &lamp).abs();
    let check = |add: &dyn Fn(&mut Scene), share: f64| {
        let mut scene = Scene::default();
        let (x, y) = (lamp[1] - lamp[0], lamp[3] - lamp[0]);
        add_sheet(&mut scene, lamp[0], x, y, surface(0.0, 0.0, PI));
        add_roof(&mut scene, 0.0, surface(0.0, 0.0, 0.0));
        add(&mut scene);
        let found = irradiance(&scene, &points, &rays(256));
        let (mean, error) = mean_ratio(&found, truth);
        // Fields of the board leave spots, whose spread the error includes.
        assert!(
            (mean - share).abs() < 3.0 * error + 1e-5,
            "{mean} ± {error} of {share}"
        );
        // The stated errors are those that occur.
        let worst = found.iter().enumerate().filter(|(k, e)| {
            let off = (e.value.mean() - share * truth(*k)).abs();
            off > 4.0 * e.error.mean() + 1e-5 * truth(*k)
        });
        (mean, worst.count())
    };
    let (_, off) = check(&|scene| add_roof(scene, 1.0, gauze(0.0, 0.3)), 0.7);
    assert_eq!(off, 0);
    let twice = |scene: &mut Scene| {
        add_roof(scene, 0.5, gauze(0.0, 0.5));
        add_roof(scene, 1.0, gauze(0.0, 0.5));
    };
    assert_eq!(check(&twice, 0.25).1, 0);
    check(&|scene| add_board(scene, 1.0), 0.5);
}

/// White gauze in a room that glows alike changes nothing, however it is opaque: what it takes it
/// gives back, and the rest passes. Rows, direct light and balance of the first pass agree on that.
#[test]
fn white_gauze_in_a_furnace() {
    for opacity in [0.2, 0.7, 1.0] {
        let mut scene = cube([0; 6].map(|_| surface(0.5, 0.0, 1.0)));
        let (x, y) = (0.8 * DVec3::X, 0.8 * DVec3::Y);
        add_sheet(&mut scene, dvec3(0.1, 0.1, 0.5), x, y, gauze(1.0, opacity));
        let pass = FirstPass {
            size: PatchSize::Count(150),
            ..rays(512)
        };
        let solved = Matrix::solve(&scene, &pass);
        let radiosities = (0..solved.patches.len()).map(|p| solved.radiosity(p, true).0);
        let radiosities: Vec<f64> = radiosities.collect();
        // Direct light comes to a few positions of each patch, as behind opaque sheets.
        let worst = radiosities.iter().map(|b| (b - 2.0).abs());
        assert!(worst.fold(0.0, f64::max) < 0.07, "at {opacity}");
        let mean = radiosities.iter().sum::<f64>() / radiosities.len() as f64;
        assert!((mean - 2.0).abs() < 6e-3, "B is {mean} at {opacity}");
        assert!(
            solved.found.balance.error() < 0.01,
            "{:?}",
            solved.found.balance
        );
        // Of the gauze, whose area counts by its opacity.
        let gauze = (0..solved.patches.len()).filter(|&p| solved.patches.material(p) == 6);
        let area: f64 = gauze.map(|p| solved.patches.area(p)).sum();
        assert!((area - 0.64 * opacity).abs() < 1e-9, "{area}");
        let points = points_on_cube(60);
        let found = irradiance(&scene, &points, &pass);
        let (mean, error) = mean_ratio(&found, |_| 2.0);
        assert!((mean - 1.0).abs() < 3.0 * error + 0.005, "{mean} ± {error}");
    }
}

/// Black gauze absorbs its share: what walls send is what walls and gauze absorb.
#[test]
fn grey_gauze_keeps_the_balance() {
    let mut scene = cube([0; 6].map(|_| surface(0.5, 0.0, 1.0)));
    let (x, y) = (0.8 * DVec3::X, 0.8 * DVec3::Y);
    add_sheet(&mut scene, dvec3(0.1, 0.1, 0.5), x, y, gauze(0.3, 0.5));
    let pass = FirstPass {
        size: PatchSize::Count(150),
        ..rays(1024)
    };
    let solved = Matrix::solve(&scene, &pass);
    assert!(
        solved.found.balance.error() < 0.01,
        "{:?}",
        solved.found.balance
    );
    let patches = &solved.patches;
    // Walls: absorbed is half of E, and B = 1 + E/2. Gauze: both sides, of half its area.
    let mut absorbed = 0.0;
    for p in 0..patches.len() {
        if patches.material(p) == 6 {
            let both = solved.radiosity(p, true).0 + solved.radiosity(p, false).0;
            absorbed += 0.7 * both / 0.3 * patches.area(p);
        } else {
            absorbed += (solved.radiosity(p, true).0 - 1.0) * patches.area(p);
        }
    }
    assert!((absorbed / 6.0 - 1.0).abs() < 0.01, "{absorbed} of 6");
}

#[test]
fn threads_do_not_matter_to_opacity() {
    let mut scene = cube([0; 6].map(|_| surface(0.5, 0.2, 1.0)));
    let (x, y) = (0.8 * DVec3::X, 0.8 * DVec3::Y);
    add_sheet(&mut scene, dvec3(0.1, 0.1, 0.5), x, y, gauze(0.3, 0.5));
    let found = [1, 4].map(|threads| {
        let tracer = Tracer::new(&scene);
        let points = points_on_cube(20);
        on_threads(threads, || {
            probe(&scene, &tracer, &points, &rays(64), &Progress::new()).unwrap()
        })
    });
    assert!(found[0].estimates == found[1].estimates);
}

/// Formulas take gauze as opaque, so rays do their work.
#[test]
fn other_engines_give_way_to_rays() {
    let mut scene = cube([0; 6].map(|_| surface(0.5, 0.0, 1.0)));
    let pass = FirstPass {
        engine: Engine::Analytic,
        ..rays(64)
    };
    let used = |scene: &Scene| {
        let solved = solve(scene, &Tracer::new(scene), &pass, &Progress::new()).unwrap();
        solved.report.engine_used
    };
    assert_eq!(used(&scene).name, "analytic");
    let (x, y) = (0.8 * DVec3::X, 0.8 * DVec3::Y);
    add_sheet(&mut scene, dvec3(0.1, 0.1, 0.5), x, y, gauze(0.3, 0.5));
    let instead = used(&scene);
    assert_eq!(instead.name, "rays");
    assert!(
        instead.notes[0].contains("take as opaque"),
        "{:?}",
        instead.notes
    );
}
