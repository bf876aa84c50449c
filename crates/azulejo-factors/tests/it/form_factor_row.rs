//! A single row of form factors against the same row of the matrix.

use azulejo_factors::form_factors::{Factor, Plan};
use azulejo_factors::{
    Closure, Engine, FormFactorOptions, Hemicube, PatchSize, form_factors, form_factors_from,
};
use azulejo_scene::math::Ray;
use azulejo_scene::synthetic::{CornellVariant, cornell_box, cube_room};
use azulejo_scene::{Material, Object, Primitive, PrimitiveKind, Rgb, Scene, Shape};
use azulejo_trace::{Progress, Tracer};
use glam::{DAffine3, DVec3};

fn options(engine: Engine, analytic: bool) -> FormFactorOptions {
    FormFactorOptions {
        engine,
        analytic,
        size: PatchSize::Count(120),
        rays: 1 << 13,
        closure: Closure::Never,
        ..FormFactorOptions::default()
    }
}

/// The rows of a few patches, each entry within its error of the matrix's.
#[track_caller]
fn check(scene: &Scene, options: &FormFactorOptions) {
    let (tracer, progress) = (Tracer::new(scene), Progress::new());
    let matrix = form_factors(scene, &tracer, options, &progress).unwrap();
    let plan = Plan::new(scene, &tracer, options).unwrap();
    let prepared = plan.prepare();
    let (mut outside, mut count) = (0, 0);
    for i in (0..matrix.len()).step_by(17) {
        let row = prepared.row(i, &progress).unwrap();
        assert_eq!(row.len(), matrix.len());
        let (mut sum, mut whole) = (0.0, 0.0);
        for (j, factor) in row.iter().enumerate() {
            let (value, error) = matrix.get(i.min(j), i.max(j) as u32);
            let ratio = matrix.areas[i.min(j)] / matrix.areas[i];
            let (value, error) = (value * ratio, f64::from(error) * ratio);
            assert!(
                factor.value >= 0.0 && factor.error.is_finite(),
                "{factor:?}"
            );
            // The value of a single ray is the smallest difference that can be resolved.
            let one_ray = 1.0 / f64::from(options.rays);
            let allowed = 3.0 * factor.error.hypot(error) + one_ray;
            outside += usize::from((factor.value - value).abs() > allowed);
            count += 1;
            sum += factor.value;
            whole += value;
        }
        assert!(
            (sum - whole).abs() < 0.02,
            "row {i}: {sum}, in the matrix {whole}"
        );
    }
    assert!(
        outside * 100 <= count,
        "{outside} of {count} entries are off"
    );
}

/// A ball in a room without flat patches.
fn ball_room() -> Scene {
    let mut scene = cube_room();
    let material = scene.add_material(Material::diffuse("ball", Rgb::grey(0.5)));
    let map =
        DAffine3::from_translation(DVec3::splat(0.5)) * DAffine3::from_scale(DVec3::splat(0.2));
    let ball = Primitive::new(PrimitiveKind::Sphere, map, material);
    let ball = Object::new("ball", Shape::Primitive(ball));
    scene.objects.push(ball);
    scene
}

#[test]
fn a_row_is_the_matrix_s() {
    let scene = cornell_box(CornellVariant::Diffuse);
    check(&scene, &options(Engine::Rays, false));
    check(&scene, &options(Engine::Rays, true));
    check(&scene, &options(Engine::Analytic, true));
    check(
        &cornell_box(CornellVariant::MirrorBlock),
        &options(Engine::Rays, true),
    );
    check(&ball_room(), &options(Engine::Rays, true));
    let two_sided = FormFactorOptions {
        two_sided: true,
        ..options(Engine::Rays, true)
    };
    check(&scene, &two_sided);
}

#[test]
fn formulas_leave_no_noise_in_a_row() {
    let scene = cube_room();
    let tracer = Tracer::new(&scene);
    let options = options(Engine::Rays, true);
    let from = form_factors_from(&scene, &tracer, 3, &options, &Progress::new()).unwrap();
    let sum: f64 = from.factors.iter().map(|f| f.value).sum();
    assert!((sum - 1.0).abs() < 1e-6, "{sum}");
    let worst = from.factors.iter().map(|f| f.error).fold(0.0, f64::max);
    assert!(worst < 1e-6, "{worst}");
}

#[test]
fn picking_finds_the_patch() {
    let scene = ball_room();
    let tracer = Tracer::new(&scene);
    let options = options(Engine::Rays, true);
    let plan = Plan::new(&scene, &tracer, &options).unwrap();
    let patches = plan.patches();
    let mut areas = vec![0.0; patches.len()];
    for (patch, [a, b, c]) in patches.triangles() {
        let cross = (b - a).cross(c - a);
        areas[patch as usize] += 0.5 * cross.length();
        let middle = (a + b + c) / 3.0;
        let eye = middle + 0.01 * cross.normalize_or_zero();
        if let Some(picked) = plan.patch_at(&Ray::new(eye, middle - eye)) {
            let off = patches.centre(picked).distance(middle);
            assert!(
                off < patches.diameter(picked),
                "{patch}: {picked} is picked"
            );
        }
    }
    for (i, &drawn) in areas.iter().enumerate() {
        assert!((drawn / patches.area(i) - 1.0).abs() < 0.01, "{i}: {drawn}");
    }
    let outwards = Ray::new(DVec3::splat(2.0), DVec3::X);
    assert_eq!(plan.patch_at(&outwards), None);
}

#[test]
fn a_cancelled_row_is_none() {
    let (scene, progress) = (cube_room(), Progress::new());
    progress.cancel();
    let options = options(Engine::Rays, true);
    let row = form_factors_from(&scene, &Tracer::new(&scene), 0, &options, &progress);
    assert!(row.is_err());
}

/// Sums over walls have the estimates of their own; with formulas there are none.
#[test]
fn a_row_is_summed_over_groups_with_its_estimates() {
    let scene = cube_room();
    let tracer = Tracer::new(&scene);
    for (engine, analytic) in [
        (Engine::Rays, false),
        (Engine::Hemicube(Hemicube::default()), false),
        (Engine::Rays, true),
        (Engine::Analytic, false),
    ] {
        let options = options(engine, analytic);
        let plan = Plan::new(&scene, &tracer, &options).unwrap();
        let patches = plan.patches();
        // The last patch is in no group.
        let group = |patch: usize| {
            let face = patches.face(patch).face;
            (patch + 1 < patches.len()).then_some(face)
        };
        let groups: Vec<Option<u32>> = (0..patches.len()).map(group).collect();
        let row = plan.prepare().grouped_row(0, &groups, 7, &Progress::new());
        let row = row.unwrap();
        assert_eq!(row.groups.len(), 7);
        // The room has six faces.
        assert_eq!(row.groups[6].factor, Factor::default());
        for (k, group) in row.groups.iter().enumerate().take(6) {
            let own = row.factors.iter().zip(&groups);
            let own = own.filter(|(_, g)| **g == Some(k as u32));
            let sum: f64 = own.map(|(factor, _)| factor.value).sum();
            assert!(
                (group.factor.value - sum).abs() < 1e-6,
                "{k}: {group:?} {sum}"
            );
            let Some(estimates) = group.estimates else {
                continue;
            };
            let mean = estimates.iter().sum::<f64>() / 4.0;
            assert!(
                (mean - group.factor.value).abs() < 1e-6,
                "{estimates:?} {group:?}"
            );
            let spread: f64 = estimates.iter().map(|e| (e - mean).powi(2)).sum();
            let naive = (spread / 12.0).sqrt();
            assert!(group.factor.error >= 0.7 * naive, "{group:?} {naive}");
        }
        let has_estimates = row.groups[0].estimates.is_some();
        assert_eq!(
            has_estimates,
            !analytic && options.engine != Engine::Analytic
        );
    }
}
