//! Patches that are too coarse for what a point sees, and what is said of them.

use crate::rooms::*;
use azulejo_radiosity::{
    FirstPass, Method, PatchSize, PointNormal, Probed, Report, SolveError, probe, solve,
};
use azulejo_scene::synthetic::{CornellVariant, cornell_box};
use azulejo_scene::{Material, Object, Primitive, Rgb, Scene, Shape};
use azulejo_trace::{
    DiffuseHit, DiffuseLight, GatherOptions, GatherPoint, Gatherer, OutgoingRadiosity, Progress,
    Surfaces, Termination, Tracer,
};
use glam::{DVec3, dvec3};
use std::time::{Duration, Instant};

const GREY: f64 = 0.7;

/// Surfaces of one reflectance whose radiosity nobody knows.
struct Unknown;

impl DiffuseLight for Unknown {
    fn outgoing(&self, _: &DiffuseHit, _: usize) -> OutgoingRadiosity {
        OutgoingRadiosity::default()
    }

    fn reflectance(&self, _: &DiffuseHit) -> Rgb {
        Rgb::grey(GREY)
    }
}

/// Irradiance and its standard error by path tracing, which no patch can mislead.
fn path_traced(scene: &Scene, points: &[PointNormal], rays: u32) -> Vec<(f64, f64)> {
    path_traced_to(Termination::Roulette, scene, points, rays)
}

/// The same with another end of paths.
fn path_traced_to(
    termination: Termination,
    scene: &Scene,
    points: &[PointNormal],
    rays: u32,
) -> Vec<(f64, f64)> {
    let tracer = Tracer::new(scene);
    let gatherer = Gatherer::new(Surfaces::new(scene, &tracer));
    let point = |(k, p): (usize, &PointNormal)| GatherPoint {
        position: p.position,
        normal: p.normal,
        key: 1_000 + k as u32,
    };
    let points: Vec<GatherPoint> = points.iter().enumerate().map(point).collect();
    let options = GatherOptions {
        rays,
        spent: 0,
        seed: 99,
        termination,
    };
    let found = gatherer.gather(&points, &options, &Unknown);
    let both = |g: &azulejo_trace::Gathered| (g.mean().mean(), g.standard_error().mean());
    found.iter().map(both).collect()
}

fn sheet(scene: &mut Scene, corner: DVec3, a: DVec3, b: DVec3, material: u32) {
    let sheet = Primitive::parallelogram(corner, a, b, material);
    scene
        .objects
        .push(Object::new("sheet", Shape::Primitive(sheet)));
}

/// A closed box, length × 1 × 1, with a square lamp below its ceiling, facing down.
fn lit_box(length: f64, lamp: DVec3, size: f64) -> Scene {
    let mut scene = Scene::default();
    let wall = scene.add_material(Material::diffuse("wall", Rgb::grey(GREY)));
    let mut glow = Material::diffuse("lamp", Rgb::grey(GREY));
    glow.emission = Rgb::grey(10.0);
    let glow = scene.add_material(glow);
    let (x, y, z) = (DVec3::X * length, DVec3::Y, DVec3::Z);
    sheet(&mut scene, DVec3::ZERO, z, x, wall);
    sheet(&mut scene, y, x, z, wall);
    sheet(&mut scene, DVec3::ZERO, y, z, wall);
    sheet(&mut scene, x, z, y, wall);
    sheet(&mut scene, DVec3::ZERO, x, y, wall);
    sheet(&mut scene, z, y, x, wall);
    sheet(&mut scene, lamp, DVec3::X * size, DVec3::Z * size, glow);
    scene
}

/// Two rooms, one of them lit, and between them a wall with a slit below and above.
fn two_rooms() -> Scene {
    let mut scene = lit_box(2.0, dvec3(0.3, 0.9, 0.3), 0.4);
    let corner = dvec3(1.0, 0.01, 0.0);
    sheet(&mut scene, corner, DVec3::Y * 0.98, DVec3::Z, 0);
    scene
}

fn probed(
    scene: &Scene,
    points: &[PointNormal],
    patches: usize,
    error: f64,
) -> (Vec<(f64, f64)>, Report) {
    let pass = FirstPass {
        size: PatchSize::Count(patches),
        error: Some(error),
        ..FirstPass::default()
    };
    let tracer = Tracer::new(scene);
    let found = probe(scene, &tracer, points, &pass, &Progress::new()).unwrap();
    (found.estimates.iter().map(grey).collect(), found.report)
}

/// Points on the floor of both rooms.
fn floor() -> Vec<PointNormal> {
    let at_floor = |k: u32| {
        let x = 0.06 + 0.96 * f64::from(k % 2) + 0.11 * f64::from(k / 2 % 9);
        at(x, 0.0, 0.08 + 0.1 * f64::from(k / 18), DVec3::Y)
    };
    (0..144).map(at_floor).collect()
}

/// In one room hardly any light arrives, and its points are asked for their own tenth, not for one of all.
#[test]
fn each_point_reaches_an_error_of_its_own_light() {
    let (scene, points) = (two_rooms(), floor());
    let truth = path_traced(&scene, &points, 1 << 13);
    let tracer = Tracer::new(&scene);
    let probed = |error_each: bool| {
        let pass = FirstPass {
            size: PatchSize::Count(100),
            error: Some(0.1),
            error_each,
            ..FirstPass::default()
        };
        probe(&scene, &tracer, &points, &pass, &Progress::new()).unwrap()
    };
    let (all, each) = (probed(false), probed(true));
    let relative = |found: &Probed| {
        let pairs = found.estimates.iter().map(grey).zip(&truth);
        let squares = pairs.map(|(f, t)| (f.0 - t.0).powi(2) / t.0.powi(2) - (t.1 / t.0).powi(2));
        (squares.sum::<f64>() / truth.len() as f64).max(0.0).sqrt()
    };
    assert!(relative(&each) < 0.13, "{}", relative(&each));
    assert!(each.report.error_each < 0.13, "{:?}", each.report);
    assert!(
        relative(&all) > 0.15 && all.report.error_each > 0.15,
        "{:?}",
        all.report
    );
    let within = each.estimates.iter().map(grey).zip(&truth);
    let within = within.filter(|(f, t)| (f.0 - t.0).abs() <= 2.0 * f.1.hypot(t.1));
    assert!(within.count() > 125);
}

/// Coarse floors reach under the wall: read from the dark room, they leak the light of the other one.
#[test]
fn light_does_not_leak_below_walls() {
    let (scene, points) = (two_rooms(), floor());
    let truth = path_traced(&scene, &points, 1 << 14);
    let (found, report) = probed(&scene, &points, 100, 0.03);
    let mean = truth.iter().map(|t| t.0).sum::<f64>() / truth.len() as f64;
    let error = |is_dark: bool| {
        let chosen = || {
            truth
                .iter()
                .zip(&found)
                .filter(|(t, _)| (t.0 < 0.1 * mean) == is_dark)
        };
        let square: f64 = chosen()
            .map(|(t, f)| (f.0 - t.0).powi(2) - t.1.powi(2))
            .sum();
        let dark_mean = chosen().map(|(t, _)| t.0).sum::<f64>() / chosen().count() as f64;
        let bias: f64 = chosen().map(|(t, f)| f.0 - t.0).sum::<f64>() / chosen().count() as f64;
        let rms = (square.max(0.0) / chosen().count() as f64).sqrt();
        (rms / mean, rms / dark_mean, bias / dark_mean)
    };
    let (dark, lit) = (error(true), error(false));
    eprintln!("rms over all, own mean, bias: dark {dark:.3?}, lit {lit:.3?}, {report:?}");
    assert!(
        lit.0 < 1.25 * 0.03 * 2.0 && dark.1 < 0.4,
        "{lit:?}, {dark:?}"
    );
    // The truth of a dark room is itself known to a few percent only; leaks made it several times too
    // bright.
    assert!(dark.2.abs() < 0.3, "a bias of {:.1}%", 100.0 * dark.2);
    assert!(report.path_traced > 0.2, "{}", report.path_traced);
    let inside = |(t, f): &(&(f64, f64), &(f64, f64))| (t.0 - f.0).abs() <= 2.0 * t.1.hypot(f.1);
    let inside = truth.iter().zip(&found).filter(inside).count();
    assert!(
        10 * inside >= 9 * truth.len(),
        "{inside} of {}",
        truth.len()
    );
}

/// A lamp just below the ceiling: coarse patches of the ceiling do not know how little light passes
/// beside it.
#[test]
fn a_lamp_close_to_the_ceiling() {
    let scene = lit_box(1.0, dvec3(0.35, 0.99, 0.35), 0.3);
    let points = [
        at(0.5, 0.0, 0.5, DVec3::Y),
        at(0.2, 1.0, 0.2, -DVec3::Y),
        at(0.5, 0.995, 0.5, DVec3::Y),
    ];
    let truth = path_traced(&scene, &points, 1 << 16);
    let (found, report) = probed(&scene, &points, 200, 0.02);
    eprintln!("{truth:?} {found:?} {report:?}");
    for (t, f) in truth.iter().zip(&found) {
        assert!(
            (t.0 - f.0).abs() <= 3.0 * t.1.hypot(f.1) + 1e-2,
            "{t:?} {f:?}"
        );
    }
}

/// Boxes keep reading their patches, whose discretization is small, where enough is asked for patches to pay; for less,
/// paths alone are cheaper.
#[test]
fn boxes_read_their_patches() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let spots = (0..256).map(|k: u32| {
        let [x, z] = [k % 16, k / 16].map(|i| 20.0 + 32.0 * f64::from(i));
        at(x, 0.0, z, DVec3::Y)
    });
    let spots: Vec<_> = spots.collect();
    let (_, report) = probed(&scene, &spots, 2_000, 0.1);
    assert_eq!(report.method, Method::Paths, "{report:?}");
    let (_, report) = probed(&scene, &spots, 2_000, 0.02);
    assert_eq!(report.method, Method::Matrix, "{report:?}");
    assert!(report.path_traced < 0.5, "{report:?}");
    assert!(
        report.error <= 0.02 && report.error_parts.discretization < 0.012,
        "{report:?}"
    );
}

/// No time at all: nothing, rather than darkness.
#[test]
fn a_deadline_leaves_light_everywhere_or_nothing() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let tracer = Tracer::new(&scene);
    for (allowed, patches) in [(Duration::ZERO, 300), (Duration::from_millis(1), 200_000)] {
        let progress = Progress::new();
        progress.set_deadline(Instant::now() + allowed);
        let pass = FirstPass {
            size: PatchSize::Count(patches),
            ..FirstPass::default()
        };
        match solve(&scene, &tracer, &pass, &progress) {
            Err(SolveError::OutOfTime) => {}
            Ok(light) => assert!(light.report.error < 1.0, "{:?}", light.report),
            Err(other) => panic!("{other}"),
        }
    }
}

/// Patches tell how often their light was reflected, and paths can be as long: the discretization of
/// a limited number of bounces is measured, too, and paths take the place of patches that are bad.
#[test]
fn limited_bounces_state_their_discretization() {
    let (scene, points) = (two_rooms(), floor());
    let probed = |bounces: u32, patches: usize, error: Option<f64>| {
        let pass = FirstPass {
            size: PatchSize::Count(patches),
            error,
            rays: error.is_none().then_some(256),
            bounces: Some(bounces),
            ..FirstPass::default()
        };
        let tracer = Tracer::new(&scene);
        let found = probe(&scene, &tracer, &points, &pass, &Progress::new()).unwrap();
        let values: Vec<(f64, f64)> = found.estimates.iter().map(grey).collect();
        (values, found.report)
    };
    for bounces in [0, 1, 3] {
        let termination = Termination::Bounces(bounces);
        let truth = path_traced_to(termination, &scene, &points, 1 << 13);
        let mean = truth.iter().map(|t| t.0).sum::<f64>() / truth.len() as f64;
        let error = |found: &[(f64, f64)]| {
            let square = |(t, f): (&(f64, f64), &(f64, f64))| (f.0 - t.0).powi(2) - t.1.powi(2);
            let sum: f64 = truth.iter().zip(found).map(square).sum();
            (sum.max(0.0) / truth.len() as f64).sqrt() / mean
        };
        for goal in [None, Some(0.03)] {
            let (found, report) = probed(bounces, 60, goal);
            let actual = error(&found);
            eprintln!(
                "{bounces} bounces, {goal:?}: {actual:.4}, said {:.4}, {:?}, traced {}",
                report.error, report.error_parts, report.path_traced
            );
            assert!(actual < 1.6 * report.error + 0.01, "{actual} {report:?}");
            assert!(report.error < 4.0 * actual + 0.02, "{actual} {report:?}");
            if bounces > 0 && goal.is_none() {
                assert!(report.error_parts.discretization > 0.01, "{report:?}");
            }
            if let Some(goal) = goal {
                assert!(report.error <= goal, "{report:?}");
            }
        }
    }
}
