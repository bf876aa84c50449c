//! Indirect light interpolated between thousands of points.

use crate::rooms::*;
use azulejo_radiosity::{FirstPass, PatchSize, PointNormal, Probed, probe};
use azulejo_scene::synthetic::{CornellVariant, cornell_box};
use azulejo_scene::{Material, Object, Primitive, Rgb, Scene, Shape};
use azulejo_trace::{Progress, Tracer};
use glam::{DVec3, dvec3};

/// 72 × 72 points on the floor and one wall of the Cornell box.
fn spots() -> Vec<PointNormal> {
    let at_spot = |k: u32| {
        let [u, v] = [k / 2 % 72, k / 144].map(|i| 5.0 + 7.5 * f64::from(i));
        if k.is_multiple_of(2) {
            at(u, 0.0, v, DVec3::Y)
        } else {
            at(u, v, 559.0, -DVec3::Z)
        }
    };
    (0..2 * 72 * 72).map(at_spot).collect()
}

fn probed(scene: &Scene, points: &[PointNormal], error: f64, interpolate: bool) -> Probed {
    let pass = FirstPass {
        size: PatchSize::Count(1_000),
        error: Some(error),
        interpolate,
        ..FirstPass::default()
    };
    let tracer = Tracer::new(scene);
    probe(scene, &tracer, points, &pass, &Progress::new()).unwrap()
}

#[test]
fn what_is_said_of_interpolated_light_is_what_is_found() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let points = spots();
    let all = probed(&scene, &points, 0.05, true);
    let report = &all.report;
    assert!(report.interpolated > 0.5, "{report:?}");
    assert!(report.error <= 0.05, "{report:?}");
    // A keyed part of the same points, too few to be interpolated, and far more accurate.
    let some: Vec<usize> = (0..points.len()).step_by(61).collect();
    let chosen: Vec<PointNormal> = some.iter().map(|&i| points[i]).collect();
    let truth = probed(&scene, &chosen, 0.01, false);
    assert!(truth.report.interpolated == 0.0);
    let (mut squares, mut inside, mut mean) = (0.0, 0, 0.0);
    for (&i, t) in some.iter().zip(&truth.estimates) {
        let found = &all.estimates[i];
        for k in 0..3 {
            let difference = found.value[k] - t.value[k];
            squares += difference * difference;
            mean += t.value[k];
            inside += u32::from(difference.abs() <= 2.0 * found.error[k].hypot(t.error[k]));
        }
    }
    let count = 3.0 * some.len() as f64;
    let error = (squares / count).sqrt() / (mean / count);
    assert!(error <= 1.25 * 0.05, "{error}");
    assert!(f64::from(inside) >= 0.88 * count, "{inside} of {count}");
}

/// A lit room beside a dark one, divided by a single sheet, on one floor.
#[test]
fn light_is_not_interpolated_through_walls() {
    let mut scene = Scene::default();
    let wall = scene.add_material(Material::diffuse("wall", Rgb::grey(0.7)));
    let mut glow = Material::diffuse("lamp", Rgb::BLACK);
    glow.emission = Rgb::grey(10.0);
    let glow = scene.add_material(glow);
    let mut sheet = |corner: DVec3, a: DVec3, b: DVec3, material: u32| {
        let sheet = Primitive::parallelogram(corner, a, b, material);
        let object = Object::new("sheet", Shape::Primitive(sheet));
        scene.objects.push(object);
    };
    let (x, y, z) = (DVec3::X * 2.0, DVec3::Y, DVec3::Z);
    sheet(DVec3::ZERO, z, x, wall);
    sheet(y, x, z, wall);
    sheet(DVec3::ZERO, y, z, wall);
    sheet(x, z, y, wall);
    sheet(DVec3::ZERO, x, y, wall);
    sheet(z, y, x, wall);
    sheet(DVec3::X, y, z, wall);
    sheet(dvec3(0.3, 0.99, 0.3), DVec3::X * 0.4, DVec3::Z * 0.4, glow);
    let at_floor = |k: u32| {
        let [u, v] = [k % 128, k / 128].map(f64::from);
        at(2.0 * (u + 0.5) / 128.0, 0.0, (v + 0.5) / 40.0, DVec3::Y)
    };
    let points: Vec<PointNormal> = (0..128 * 40).map(at_floor).collect();
    let found = probed(&scene, &points, 0.05, true);
    assert!(found.report.interpolated > 0.3, "{:?}", found.report);
    let (mut lit, mut dark, mut brightest) = (0.0, 0.0, 0.0_f64);
    for (p, e) in points.iter().zip(&found.estimates) {
        let light = e.value.mean();
        if p.position.x < 1.0 {
            assert!(light > 0.1, "{light} at {p:?}");
            lit += light;
        } else {
            dark += light;
            brightest = brightest.max(light);
        }
    }
    eprintln!("lit {lit}, dark {dark}, brightest of the dark {brightest}");
    // Gathered everywhere, too, a few rays in ten thousand read a patch that touches the wall from the
    // other side. Light interpolated across it would be half of
    // what is there.
    let mean = lit / (points.len() / 2) as f64;
    assert!(dark <= 1e-3 * lit, "{dark} beside {lit}");
    assert!(brightest < 0.01 * mean, "{brightest} beside {mean}");
}

#[test]
fn interpolated_light_does_not_depend_on_threads() {
    let scene = cornell_box(CornellVariant::MirrorBlock);
    let points = spots();
    let with =
        |threads: usize| on_threads(threads, || probed(&scene, &points, 0.15, true).estimates);
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(3));
}
