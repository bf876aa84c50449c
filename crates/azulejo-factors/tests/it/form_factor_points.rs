//! Form factors from points against closed forms.

use azulejo_factors::form_factors::{FactorPoint, Plan, PointFactors};
use azulejo_factors::{FormFactorOptions, PatchSize};
use azulejo_scene::synthetic::cube_room;
use azulejo_scene::{Faces, Material, Mesh, Object, Primitive, PrimitiveKind, Rgb, Scene, Shape};
use azulejo_testing::closed_forms::{element_parallel, element_to_unit_sphere};
use azulejo_trace::{Progress, Tracer};
use glam::{DAffine3, DVec3};

fn factors(scene: &Scene, points: &[FactorPoint], rays: u32, seed: u64) -> Vec<PointFactors> {
    let options = FormFactorOptions {
        size: PatchSize::Edge(0.0),
        rays,
        seed,
        ..FormFactorOptions::default()
    };
    let tracer = Tracer::new(scene);
    let plan = Plan::new(scene, &tracer, &options).unwrap();
    let prepared = plan.prepare();
    // The six sides of a cube; else one group.
    let sides = prepared.rows();
    let group = |row: usize| if sides == 6 { row as u32 } else { 0 };
    let groups: Vec<Option<u32>> = (0..sides).map(|row| Some(group(row))).collect();
    prepared
        .factors_from_points(points, (&groups, 6), &Progress::new())
        .unwrap()
}

fn facing(position: DVec3, normal: DVec3) -> FactorPoint {
    FactorPoint {
        position,
        normal: Some(normal),
    }
}

fn sphere(position: DVec3) -> FactorPoint {
    FactorPoint {
        position,
        normal: None,
    }
}

fn scene_of(shape: Shape) -> Scene {
    let mut scene = Scene::default();
    scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
    scene.objects.push(Object::new("it".to_owned(), shape));
    scene
}

fn ball() -> Scene {
    let sphere = Primitive::new(PrimitiveKind::Sphere, DAffine3::IDENTITY, 0);
    scene_of(Shape::Primitive(sphere))
}

/// A rectangle a × b at height c, whose front is below.
fn lid(a: f64, b: f64, c: f64) -> Scene {
    scene_of(Shape::Mesh(Mesh {
        positions: vec![
            DVec3::new(0.0, 0.0, c),
            DVec3::new(0.0, b, c),
            DVec3::new(a, b, c),
            DVec3::new(a, 0.0, c),
        ],
        faces: Faces {
            starts: vec![0, 4],
            corners: vec![0, 1, 2, 3],
        },
        face_materials: vec![0],
        ..Mesh::default()
    }))
}

/// Whether truth is within the stated errors over many seeds, as often as they promise.
#[track_caller]
fn check(scene: &Scene, point: FactorPoint, truth: f64) {
    let (mut outside, mut total) = (0, 0.0);
    for seed in 0..100 {
        let seen = factors(scene, &[point], 256, seed);
        let factor = seen[0].factors[0].1;
        outside += usize::from((factor.value - truth).abs() > 2.0 * factor.error);
        total += factor.value / 100.0;
        assert!(factor.error < 0.05, "{factor:?}");
    }
    assert!(outside <= 10, "{outside} of 100 beyond two standard errors");
    assert!((total - truth).abs() < 2e-3, "{total}, expected {truth}");
}

#[test]
fn an_element_sees_rectangles_and_spheres_as_formulas_say() {
    let truth = element_parallel(1.0, 2.0, 0.5);
    check(&lid(1.0, 2.0, 0.5), facing(DVec3::ZERO, DVec3::Z), truth);
    for (height, tilt) in [(2.0, 0.0_f64), (1.5, 0.8), (1.2, 1.7)] {
        let normal = DVec3::new(tilt.sin(), 0.0, -tilt.cos());
        let truth = element_to_unit_sphere(height, tilt.cos());
        check(&ball(), facing(DVec3::new(0.0, 0.0, height), normal), truth);
    }
}

#[test]
fn a_globe_sees_solid_angles() {
    // The share of a cap.
    let cap = |h: f64| 0.5 * (1.0 - (1.0 - 1.0 / (h * h)).sqrt());
    for h in [1.1, 2.0] {
        check(&ball(), sphere(DVec3::new(0.0, h, 0.0)), cap(h));
    }
    let middle = factors(
        &cube_room(),
        &[sphere(cube_room().bounds().centre())],
        1 << 14,
        0,
    );
    assert_eq!(middle[0].factors.len(), 6);
    for (_, side) in &middle[0].factors {
        assert!((side.value - 1.0 / 6.0).abs() < 1e-3, "{side:?}");
    }
}

#[test]
fn shares_add_up_with_mirrors_backs_and_openings() {
    let mut scene = lid(1.0, 1.0, 1.0);
    scene.materials[0].mirror = Rgb::grey(0.4);
    let points = [
        facing(DVec3::new(0.5, 0.5, 0.0), DVec3::Z),
        facing(DVec3::new(0.5, 0.5, 2.0), -DVec3::Z),
        sphere(DVec3::new(0.5, 0.5, 0.0)),
    ];
    for (k, point) in factors(&scene, &points, 4096, 0).iter().enumerate() {
        let seen: f64 = point.factors.iter().map(|(_, f)| 0.6 * f.value).sum();
        let sum = seen + point.rest.sum();
        assert!((sum - 1.0).abs() < 1e-9, "point {k}: {sum}");
        assert_eq!(point.factors.is_empty(), k == 1, "the back is not a column");
        assert_eq!(point.rest.hidden > 0.0, k == 1);
    }
}

#[test]
fn threads_do_not_matter_and_seeds_do() {
    let scene = cube_room();
    let bounds = scene.bounds();
    let at = |k: u32| sphere(bounds.min + bounds.size() * (f64::from(k) + 0.5) / 40.0);
    let points: Vec<FactorPoint> = (0..40).map(at).collect();
    let with = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap()
            .install(|| factors(&scene, &points, 512, seed))
    };
    assert_eq!(with(1, 0), with(3, 0));
    assert_ne!(with(1, 0), with(1, 1));
}

#[test]
fn cancelled_work_ends() {
    let scene = cube_room();
    let (tracer, progress) = (Tracer::new(&scene), Progress::new());
    let options = FormFactorOptions::default();
    let plan = Plan::new(&scene, &tracer, &options).unwrap();
    let prepared = plan.prepare();
    let groups = vec![Some(0); prepared.rows()];
    progress.cancel();
    let points = [sphere(DVec3::ZERO)];
    assert!(
        prepared
            .factors_from_points(&points, (&groups, 1), &progress)
            .is_err()
    );
}
