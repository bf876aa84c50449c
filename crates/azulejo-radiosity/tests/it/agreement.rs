//! Invariance: results do not depend on the method, the orientation of faces, or their division.
//! And errors are estimated correctly.

use crate::rooms::*;
use azulejo_radiosity::{
    Estimate, FirstPass, Method, PatchSize, PointNormal, Probed, probe, solve,
};
use azulejo_scene::synthetic::{CornellVariant, cornell_box};
use azulejo_scene::{Light, LightKind, ObjectIrradiance, Rgb, Scene, Shape};
use azulejo_trace::lambert::{clip_to_window, point_to_polygon};
use azulejo_trace::{Progress, Tracer};
use glam::{DVec3, dvec3};

fn probed(scene: &Scene, points: &[PointNormal], pass: &FirstPass) -> Probed {
    probe(scene, &Tracer::new(scene), points, pass, &Progress::new()).unwrap()
}

fn cornell_points() -> Vec<PointNormal> {
    let floor = |k: i32| {
        at(
            40.0 + 60.0 * f64::from(k % 8),
            0.0,
            30.0 + 60.0 * f64::from(k / 8),
            DVec3::Y,
        )
    };
    let back = |k: i32| {
        at(
            40.0 + 60.0 * f64::from(k % 8),
            60.0 * f64::from(1 + k / 8),
            559.2,
            -DVec3::Z,
        )
    };
    (0..16).map(floor).chain((0..16).map(back)).collect()
}

/// Mean over points of the ratio of two sets of estimates, and the worst deviation in their
/// common standard errors.
fn compare(a: &[Estimate], b: &[Estimate]) -> (f64, f64) {
    let sum = |x: &[Estimate]| x.iter().map(|e| e.value.mean()).sum::<f64>();
    let z = |(a, b): (&Estimate, &Estimate)| {
        let error = (a.error.mean().powi(2) + b.error.mean().powi(2)).sqrt();
        (a.value.mean() - b.value.mean()).abs() / error
    };
    (sum(a) / sum(b), a.iter().zip(b).map(z).fold(0.0, f64::max))
}

#[test]
fn shooting_agrees_with_the_matrix() {
    for (variant, lamp) in [
        (CornellVariant::Diffuse, true),
        (CornellVariant::MirrorBlock, true),
        (CornellVariant::Diffuse, false),
    ] {
        let mut scene = cornell_box(variant);
        if !lamp {
            scene
                .materials
                .iter_mut()
                .for_each(|m| m.emission = Rgb::BLACK);
            let kind = LightKind::Ambient {
                radiance: Rgb::WHITE,
            };
            scene.lights.push(Light {
                name: "sky".into(),
                kind,
            });
        }
        let pass = FirstPass {
            size: PatchSize::Count(600),
            ..rays(512)
        };
        let matrix = probed(&scene, &cornell_points(), &pass);
        let shot = probed(&scene, &cornell_points(), &FirstPass { memory: 0, ..pass });
        assert_eq!(
            (matrix.report.method, shot.report.method),
            (Method::Matrix, Method::Stochastic)
        );
        let (ratio, worst) = compare(&shot.estimates, &matrix.estimates);
        let balances = [matrix.report.balance.error(), shot.report.balance.error()];
        eprintln!(
            "{variant:?}, lamp {lamp}: shot / matrix {ratio:.4}, worst {worst:.1} SE, balances {balances:?}"
        );
        assert!(
            (ratio - 1.0).abs() < 5e-3 && worst < 5.0,
            "ratio {ratio}, worst {worst}"
        );
        assert!(balances[0] < 4e-3 && balances[1] < 1e-2, "{balances:?}");
        if lamp {
            let escaped = [&matrix, &shot].map(|p| p.report.balance.escaped.mean());
            assert!(
                (escaped[0] / escaped[1] - 1.0).abs() < 2e-2,
                "escaped {escaped:?} W"
            );
        }
    }
}

/// Faces with the wrong orientation are lit all the same.
#[test]
fn reversed_faces_receive_the_same_light() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let mut reversed = scene.clone();
    for object in &mut reversed.objects {
        let Shape::Mesh(mesh) = &mut object.shape else {
            continue;
        };
        if object.name != "light" {
            mesh.faces.corners.reverse();
        }
    }
    let pass = FirstPass {
        size: PatchSize::Count(400),
        ..rays(512)
    };
    let (a, b) = (
        probed(&scene, &cornell_points(), &pass),
        probed(&reversed, &cornell_points(), &pass),
    );
    let (ratio, worst) = compare(&a.estimates, &b.estimates);
    eprintln!("reversed: ratio {ratio:.4}, worst {worst:.1} SE");
    assert!(
        (ratio - 1.0).abs() < 5e-3 && worst < 5.0,
        "ratio {ratio}, worst {worst}"
    );
    let mean = |scene: &Scene| {
        let light = solve(scene, &Tracer::new(scene), &pass, &Progress::new())
            .unwrap()
            .irradiance;
        let floor = scene
            .objects
            .iter()
            .position(|o| o.name == "floor")
            .unwrap();
        let ObjectIrradiance::Refined(mesh) = &light.objects[floor] else {
            panic!("a divided mesh")
        };
        let brightest = |f: usize| {
            let values = mesh
                .faces
                .get(f)
                .iter()
                .map(|&v| mesh.irradiance[v as usize].mean());
            values.fold(0.0, f64::max)
        };
        let looks_down = |&f: &usize| mesh.face_area_vector(f).y < 0.0;
        let lit = (0..mesh.faces.len())
            .filter(looks_down)
            .map(brightest)
            .fold(0.0, f64::max);
        assert!(
            lit < 1e-2,
            "faces under the blocks may look down, lit ones look up: {lit}"
        );
        mesh.irradiance.iter().copied().sum::<Rgb>().mean() / mesh.irradiance.len() as f64
    };
    let (a, b) = (mean(&scene), mean(&reversed));
    assert!((a / b - 1.0).abs() < 1e-2, "floor {a}, reversed {b}");
}

/// Both sides of a sheet are lit, each by its own light.
#[test]
fn sheets_have_two_sides() {
    let mut scene = Scene::default();
    add_sheet(
        &mut scene,
        DVec3::ZERO,
        DVec3::X,
        DVec3::Y,
        surface(0.5, 0.0, 0.0),
    );
    for (z, intensity) in [(2.0, 3.0), (-1.0, 5.0)] {
        let kind = LightKind::Point {
            position: dvec3(0.5, 0.5, z),
            intensity: Rgb::grey(intensity),
        };
        scene.lights.push(Light {
            name: String::new(),
            kind,
        });
    }
    let points = [at(0.5, 0.5, 0.0, DVec3::Z), at(0.5, 0.5, 0.0, -DVec3::Z)];
    let found = irradiance(&scene, &points, &rays(16));
    assert!(
        (found[0].value.mean() - 0.75).abs() < 1e-12 && (found[1].value.mean() - 5.0).abs() < 1e-12,
        "{found:?}"
    );
}

/// A lamp of side 1 at height 1 over a floor, and a black plate of side 0.6 at half the height.
fn penumbra() -> Scene {
    let mut scene = Scene::default();
    add_sheet(
        &mut scene,
        dvec3(-1.0, -1.0, 0.0),
        2.0 * DVec3::X,
        2.0 * DVec3::Y,
        surface(0.5, 0.0, 0.0),
    );
    add_sheet(
        &mut scene,
        dvec3(-0.5, -0.5, 1.0),
        DVec3::Y,
        DVec3::X,
        surface(0.0, 0.0, 1.0),
    );
    add_sheet(
        &mut scene,
        dvec3(-0.2, -0.3, 0.5),
        0.6 * DVec3::X,
        0.6 * DVec3::Y,
        surface(0.0, 0.0, 0.0),
    );
    scene
}

/// Points over the floor, in light, shadow and penumbra.
fn penumbra_points(count: i32) -> Vec<PointNormal> {
    let along = |k: i32| f64::from(k) / f64::from(count);
    (0..count)
        .map(|k| {
            at(
                -0.93 + 1.9 * along(k),
                0.37 - 0.61 * along(k),
                0.0,
                DVec3::Z,
            )
        })
        .collect()
}

/// Lambert's formula for the lamp, minus the part that the plate covers.
fn penumbra_truth(p: &PointNormal) -> f64 {
    let corners = |x: f64, y: f64, side: f64, z: f64| {
        [
            dvec3(x, y, z),
            dvec3(x, y + side, z),
            dvec3(x + side, y + side, z),
            dvec3(x + side, y, z),
        ]
    };
    let lamp = corners(-0.5, -0.5, 1.0, 1.0);
    let covered = clip_to_window(&lamp, p.position, &corners(-0.2, -0.3, 0.6, 0.5));
    point_to_polygon(p.position, p.normal, &lamp) - point_to_polygon(p.position, p.normal, &covered)
}

/// RMS error over points and seeds, mean error over points, and share of errors within two
/// standard errors.
fn honesty(
    scene: &Scene,
    points: &[PointNormal],
    truth: &[f64],
    pass: &FirstPass,
    seeds: u64,
) -> (f64, f64, f64) {
    let (mut square, mut sum, mut inside, mut count) = (0.0, 0.0, 0, 0);
    for seed in 0..seeds {
        for (e, &truth) in irradiance(
            scene,
            points,
            &FirstPass {
                seed,
                ..pass.clone()
            },
        )
        .iter()
        .zip(truth)
        {
            let off = e.value.mean() - truth;
            square += off * off;
            sum += off;
            inside += i32::from(off.abs() <= 2.0 * e.error.mean() + 1e-12);
            count += 1;
        }
    }
    let n = f64::from(count);
    ((square / n).sqrt(), sum / n, f64::from(inside) / n)
}

/// The light of an occluded lamp is unbiased, and its error is estimated correctly.
#[test]
fn penumbras_are_honest() {
    let points = penumbra_points(40);
    let truth: Vec<f64> = points.iter().map(penumbra_truth).collect();
    let mut errors = Vec::new();
    // With 64 rays a replicate has four per lamp: too few to notice a hidden corner.
    for (most, least) in [(64, 0.84), (256, 0.91), (1024, 0.92)] {
        let pass = FirstPass {
            bounces: Some(0),
            ..rays(most)
        };
        let (rms, bias, inside) = honesty(&penumbra(), &points, &truth, &pass, 20);
        eprintln!(
            "penumbra, {most} rays: rms {rms:.2e}, bias {bias:+.1e}, {:.1}% within 2 SE",
            100.0 * inside
        );
        assert!((least..0.99).contains(&inside), "{inside} within 2 SE");
        assert!(
            bias.abs() < 4.0 * rms / 800f64.sqrt(),
            "bias {bias}, rms {rms}"
        );
        errors.push(rms);
    }
    assert!(errors[0] > 4.0 * errors[2], "16 times the rays: {errors:?}");
}

/// A room with a lamp in a corner: mostly indirect light.
fn room() -> Scene {
    let mut scene = cube([0; 6].map(|_| surface(0.6, 0.0, 0.0)));
    add_sheet(
        &mut scene,
        dvec3(0.1, 0.15, 0.9),
        0.2 * DVec3::X,
        0.2 * DVec3::Y,
        surface(0.0, 0.0, 30.0),
    );
    scene
}

#[test]
fn indirect_light_is_honest() {
    let points = points_on_cube(48);
    let pass = |most| FirstPass {
        size: PatchSize::Count(384),
        ..rays(most)
    };
    let reference = irradiance(
        &room(),
        &points,
        &FirstPass {
            seed: 77,
            ..pass(1 << 14)
        },
    );
    let truth: Vec<f64> = reference.iter().map(|e| e.value.mean()).collect();
    let mut errors = Vec::new();
    for (most, least) in [(64, 0.87), (1024, 0.93)] {
        let (rms, bias, inside) = honesty(&room(), &points, &truth, &pass(most), 20);
        eprintln!(
            "room, {most} rays: rms {rms:.2e}, bias {bias:+.1e}, {:.1}% within 2 SE",
            100.0 * inside
        );
        // The standard errors include the discretization, which is the same in the truth.
        assert!((least..=1.0).contains(&inside), "{inside} within 2 SE");
        errors.push(rms);
    }
    assert!(errors[0] > 4.0 * errors[1], "16 times the rays: {errors:?}");
}

/// The error of constant radiosity per patch falls with the patch size: the lamp is half a coarse
/// patch away from its wall.
#[test]
fn division_hardly_matters() {
    let points = points_on_cube(48);
    let of = |count| {
        irradiance(
            &room(),
            &points,
            &FirstPass {
                size: PatchSize::Count(count),
                ..rays(512)
            },
        )
    };
    let fine = of(2400);
    for (count, within) in [(150, 6e-2), (600, 2e-2)] {
        let (ratio, _) = compare(&of(count), &fine);
        eprintln!("{count} against 2,400 patches: {ratio:.4}");
        assert!((ratio - 1.0).abs() < within, "{count}: {ratio}");
    }
}
