//! The matrix of form factors: known entries, invariants, degenerate input.

use crate::polygons::{add, between, unit_square};
use azulejo_factors::analytic::form_factor;
use azulejo_factors::form_factors::Plan;
use azulejo_factors::{
    Engine, FaceId, FactorsError, FormFactorOptions, FormFactors, PatchSize, Patches, form_factors,
};
use azulejo_scene::synthetic::{CornellVariant, cornell_box, cube_room};
use azulejo_scene::{Material, Primitive, PrimitiveKind, Rgb, Scene, Shape};
use azulejo_trace::{Progress, Tracer};
use glam::{DAffine3, DVec3, dvec3};

/// Whole faces as patches.
const WHOLE: PatchSize = PatchSize::Edge(0.0);

fn factors(scene: &Scene, options: &FormFactorOptions) -> FormFactors {
    let matrix = form_factors(scene, &Tracer::new(scene), options, &Progress::new());
    let matrix = matrix.expect("the scene has surfaces");
    check_promises(&matrix, scene);
    matrix
}

fn by_rays(size: PatchSize, rays: u32) -> FormFactorOptions {
    FormFactorOptions {
        engine: Engine::Rays,
        size,
        rays,
        analytic: false,
        ..FormFactorOptions::default()
    }
}

fn by_formula(size: PatchSize, rays: u32) -> FormFactorOptions {
    FormFactorOptions {
        analytic: true,
        ..by_rays(size, rays)
    }
}

/// Invariants of every matrix: order, range, finite numbers, reciprocity.
fn check_promises(matrix: &FormFactors, scene: &Scene) {
    let is_specular = scene.materials.iter().any(Material::is_specular);
    assert_eq!(matrix.exchange.len(), matrix.len());
    for i in 0..matrix.len() {
        let row: Vec<_> = matrix.row(i).collect();
        assert!(
            row.windows(2).all(|w| w[0].0 < w[1].0),
            "columns of row {i} ascend"
        );
        for &(j, x, error) in &row {
            assert!(
                x > 0.0 && x.is_finite() && error > 0.0 && error.is_finite(),
                "{i} {j}: {x} ± {error}"
            );
            assert!(
                is_specular || x <= 1.0 + 4.0 * f64::from(error),
                "{i} {j}: {x} ± {error}"
            );
            let back = matrix.get(j as usize, i as u32).0;
            let (there, back) = (matrix.areas[i] * x, matrix.areas[j as usize] * back);
            assert!(
                (there - back).abs() <= 4.0 * f64::EPSILON * there,
                "{i} {j}: {there} {back}"
            );
        }
        let rest = matrix.rest[i];
        let shares = [rest.sky, rest.ground, rest.cut, rest.hidden, rest.lost];
        assert!(
            shares.iter().all(|s| (0.0..1.001).contains(s)),
            "{shares:?}"
        );
        assert!(matrix.row_errors[i].is_finite());
    }
}

/// Every entry of the divided cube, from the closed formula.
fn cube_truth(size: PatchSize) -> Vec<Vec<f64>> {
    let patches = Patches::new(&cube_room(), size);
    let polygon = |i| patches.polygon(i).expect("a cube is flat");
    let row = |i| {
        (0..patches.len())
            .map(|j| form_factor(&polygon(i), &polygon(j)))
            .collect()
    };
    (0..patches.len()).map(row).collect()
}

/// Mean over rows of Σ |error|.
fn row_error(matrix: &FormFactors, truth: &[Vec<f64>]) -> f64 {
    let error = |(i, row): (usize, &Vec<f64>)| -> f64 {
        row.iter()
            .enumerate()
            .map(|(j, exact)| (matrix.get(i, j as u32).0 - exact).abs())
            .sum()
    };
    truth.iter().enumerate().map(error).sum::<f64>() / truth.len() as f64
}

/// Share of the entries whose error is within `most` standard errors.
fn within(matrix: &FormFactors, truth: &[Vec<f64>], most: f64) -> f64 {
    let entries = (0..matrix.len()).flat_map(|i| matrix.row(i).map(move |(j, x, e)| (i, j, x, e)));
    let is_within = |&(i, j, x, e): &(usize, u32, f64, f32)| {
        (x - truth[i][j as usize]).abs() <= most * f64::from(e) + 1e-12
    };
    entries.filter(is_within).count() as f64 / matrix.exchange.entries() as f64
}

#[test]
fn standard_errors_are_honest() {
    for (rays, edge) in [
        (256, 0.25),
        (1 << 10, 0.2),
        (1 << 12, 0.2),
        (1 << 14, 0.25),
        (1 << 16, 0.5),
    ] {
        let size = PatchSize::Edge(edge);
        let (matrix, truth) = (
            factors(&cube_room(), &by_rays(size, rays)),
            cube_truth(size),
        );
        let (two, four) = (within(&matrix, &truth, 2.0), within(&matrix, &truth, 4.0));
        let stated = matrix.row_errors.iter().sum::<f64>() / matrix.len() as f64;
        let ratio = stated / row_error(&matrix, &truth);
        eprintln!(
            "{rays} rays, edge {edge}: {two:.3} in 2 SE, {four:.4} in 4 SE, row error stated/true {ratio:.2}"
        );
        assert!(
            (0.90..0.995).contains(&two) && four >= 0.995,
            "{two} {four}"
        );
        assert!((0.85..1.3).contains(&ratio), "{ratio}");
    }
}

/// With few rays most columns of a row are never found, and are off by their whole value.
#[test]
fn errors_single_error_include_what_no_ray_found() {
    let size = PatchSize::Edge(0.125);
    let truth = cube_truth(size);
    for rays in [16, 64, 256, 1 << 10, 1 << 12] {
        let matrix = factors(&cube_room(), &by_rays(size, rays));
        assert_eq!(matrix.len(), 384);
        let stated = matrix.row_errors.iter().sum::<f64>() / matrix.len() as f64;
        let ratio = stated / row_error(&matrix, &truth);
        assert!((0.85..1.3).contains(&ratio), "{rays} rays: {ratio}");
        let missed = |i: usize| {
            let seen: Vec<u32> = matrix.row(i).map(|(j, ..)| j).collect();
            let is_missed = |j: &usize| seen.binary_search(&(*j as u32)).is_err();
            let missed = (0..384).filter(is_missed).map(|j| truth[i][j]);
            missed.sum::<f64>()
        };
        let missed: f64 = (0..384).map(missed).sum();
        let expected: f64 = matrix.unseen.iter().sum();
        assert!(
            (expected - missed).abs() < 0.15 * missed + 0.2,
            "{rays} rays miss {missed}, not {expected}"
        );
    }
}

#[test]
fn sixteen_times_the_rays_divide_the_error_by_five() {
    let size = PatchSize::Edge(0.2);
    let truth = cube_truth(size);
    let few = row_error(&factors(&cube_room(), &by_rays(size, 1 << 10)), &truth);
    let many = row_error(&factors(&cube_room(), &by_rays(size, 1 << 14)), &truth);
    eprintln!("row error {few:.4} with 1,024 rays, {many:.4} with 16,384");
    assert!(few / many >= 5.0, "{few} {many}");
}

#[test]
fn formulas_make_rows_better() {
    let size = PatchSize::Edge(0.1);
    let truth = cube_truth(size);
    let rays = row_error(&factors(&cube_room(), &by_rays(size, 1 << 10)), &truth);
    let both = row_error(&factors(&cube_room(), &by_formula(size, 1 << 10)), &truth);
    eprintln!("row error {rays:.4} by rays, {both:.4} with formulas for near pairs");
    assert!(both < 0.9 * rays, "{rays} {both}");
}

#[test]
fn a_cube_of_six_faces() {
    let (opposite, adjacent) = (0.19982489569839, 0.20004377607540);
    let matrix = factors(&cube_room(), &by_formula(WHOLE, 256));
    for i in 0..6 {
        assert_eq!(matrix.row(i).count(), 5);
        for (j, x, error) in matrix.row(i) {
            let exact = if j as usize == i ^ 1 {
                opposite
            } else {
                adjacent
            };
            assert!(
                (x - exact).abs() < 1e-13 && f64::from(error) < 1e-7,
                "{i} {j}: {x}"
            );
        }
    }
}

#[test]
fn closed_rows_sum_to_one() {
    for options in [
        by_rays(PatchSize::Edge(0.2), 1 << 10),
        by_formula(PatchSize::Edge(0.2), 1 << 10),
    ] {
        let matrix = factors(&cube_room(), &options);
        assert!(
            matrix.is_closed
                && matrix
                    .closed
                    .is_some_and(|m| m.total > 0.0 && m.total < 0.2),
            "{:?}",
            matrix.closed
        );
        let sums = matrix.row_sums();
        assert!(sums.iter().all(|s| (s - 1.0).abs() <= 1e-6), "{sums:?}");
    }
}

/// Rays of both rows of a pair and the closure of all rows take a quarter or more off the error of rows that
/// know nothing of each other.
#[test]
fn closed_matrices_are_nearer_to_the_truth_than_their_rows() {
    let scene = cube_room();
    let tracer = Tracer::new(&scene);
    let size = PatchSize::Edge(0.25);
    let exact = FormFactorOptions {
        engine: Engine::Analytic,
        ..by_formula(size, 1)
    };
    let exact = factors(&scene, &exact);
    let (mut single_error, mut closed_error) = (0.0, 0.0);
    for seed in 0..4 {
        let options = FormFactorOptions {
            seed,
            ..by_rays(size, 1_000)
        };
        let closed = factors(&scene, &options);
        let plan = Plan::new(&scene, &tracer, &options).expect("the scene has surfaces");
        let prepared = plan.prepare();
        for i in 0..closed.len() {
            let row = prepared.row(i, &Progress::new()).expect("not cancelled");
            for (j, alone) in row.iter().enumerate() {
                let truth = exact.get(i, j as u32).0;
                single_error += (alone.value - truth).abs();
                closed_error += (closed.get(i, j as u32).0 - truth).abs();
            }
        }
    }
    assert!(
        closed_error < 0.75 * single_error,
        "{closed_error} {single_error}"
    );
}

#[test]
fn open_scenes_are_not_closed() {
    let matrix = factors(
        &cornell_box(CornellVariant::Diffuse),
        &by_formula(PatchSize::Count(300), 1 << 10),
    );
    assert!(!matrix.is_closed && matrix.closed.is_none());
    for (i, sum) in matrix.row_sums().iter().enumerate() {
        let sum = sum + matrix.rest[i].sum();
        assert!((sum - 1.0).abs() <= 2.0 * matrix.row_errors[i], "{sum}");
    }
}

/// The cube with mirrors: wall 0 a pure one of 0.9, wall 3 reflecting partly specularly.
fn mirror_room() -> (Scene, [f64; 6]) {
    let mut scene = cube_room();
    scene.materials[0].mirror = Rgb::grey(0.0);
    let pure = scene.add_material(Material::mirror("mirror", Rgb::grey(0.9)));
    let half = Material {
        diffuse: Rgb::grey(0.4),
        mirror: Rgb::grey(0.3),
        ..Material::default()
    };
    let half = scene.add_material(half);
    let Shape::Mesh(mesh) = &mut scene.objects[0].shape else {
        panic!("the cube is a mesh")
    };
    (mesh.face_materials[0], mesh.face_materials[3]) = (pure, half);
    (scene, [0.9, 0.0, 0.0, 0.3, 0.0, 0.0])
}

#[test]
fn mirrors_keep_the_sum_of_what_they_do_not_reflect() {
    let (scene, rho_s) = mirror_room();
    for options in [
        by_rays(PatchSize::Edge(0.25), 1 << 12),
        by_formula(PatchSize::Edge(0.25), 1 << 12),
    ] {
        let matrix = factors(&scene, &options);
        assert!(matrix.is_closed && matrix.closed.is_none());
        let kept = |j: u32| 1.0 - rho_s[matrix.faces[j as usize].face as usize];
        let sum = |i| matrix.row(i).map(|(j, x, _)| x * kept(j)).sum::<f64>();
        let error = |i| {
            matrix
                .row(i)
                .map(|(j, _, e)| (f64::from(e) * kept(j)).powi(2))
                .sum::<f64>()
                .sqrt()
        };
        let whole: f64 = matrix.areas.iter().sum();
        let mean: f64 = (0..matrix.len())
            .map(|i| matrix.areas[i] * sum(i))
            .sum::<f64>()
            / whole;
        for i in 0..matrix.len() {
            let missing = sum(i) + matrix.rest[i].sum() - 1.0;
            assert!(
                missing.abs() <= 4.0 * error(i),
                "row {i}: {missing} ± {}",
                error(i)
            );
        }
        assert!((mean - 1.0).abs() < 1e-3, "{mean}");
        assert!(matrix.row_sums().iter().all(|&sum| sum > 1.0));
    }
}

#[test]
fn shadow_rays_know_their_error() {
    // A plate between floor and ceiling, few rays: the visible fraction dominates the error.
    let mut scene = Scene::default();
    let (floor, ceiling) = (
        unit_square(0.0),
        unit_square(1.0).into_iter().rev().collect::<Vec<_>>(),
    );
    add(&mut scene, &floor, 0.0);
    add(&mut scene, &ceiling, 0.0);
    add(
        &mut scene,
        &unit_square(0.5)
            .iter()
            .map(|p| p * dvec3(0.5, 0.5, 1.0))
            .collect::<Vec<_>>(),
        0.0,
    );
    // The plate hides a quarter of all lines of sight.
    let exact = 0.75 * form_factor(&floor, &ceiling);
    let (mut two, mut four) = (0, 0);
    for seed in 0..200 {
        let options = FormFactorOptions {
            seed,
            ..by_formula(WHOLE, 32)
        };
        let (f, error) = between(&factors(&scene, &options));
        assert!(error < 0.03, "{error}");
        two += u32::from((f - exact).abs() <= 2.0 * error);
        four += u32::from((f - exact).abs() <= 4.0 * error);
    }
    assert!(two >= 180 && four >= 198, "{two} {four} of 200");
}

#[test]
fn emitters_have_exact_columns() {
    let mut scene = cube_room();
    let lamp = scene.add_material(Material::emitter("lamp", Rgb::WHITE));
    let corners = [(0.4, 0.4), (0.4, 0.6), (0.6, 0.6), (0.6, 0.4)].map(|(x, y)| dvec3(x, y, 0.999));
    add(&mut scene, &corners, 0.0);
    let Shape::Mesh(mesh) = &mut scene.objects[1].shape else {
        panic!("a mesh")
    };
    mesh.face_materials[0] = lamp;
    let size = PatchSize::Edge(0.07);
    let patches = Patches::new(&scene, size);
    let matrix = factors(&scene, &by_formula(size, 64));
    let floor = patches.patches_of_face(FaceId { object: 0, face: 4 });
    let lamp = patches.patches_of(1);
    assert!(floor.len() >= 225 && lamp.len() >= 9);
    for i in floor {
        for j in lamp.clone() {
            let exact = form_factor(&patches.polygon(i).unwrap(), &patches.polygon(j).unwrap());
            let (x, _) = matrix.get(i, j as u32);
            // Closure does not change exact entries.
            assert!((x / exact - 1.0).abs() < 1e-9, "{i} {j}: {x} {exact}");
        }
    }
    // The back of the lamp's plate occludes the piece of the ceiling above it.
    assert!(matrix.is_closed && matrix.rest.iter().any(|r| r.hidden > 0.01));
    for (sum, rest) in matrix.row_sums().iter().zip(&matrix.rest) {
        assert!((sum + rest.hidden - 1.0).abs() < 1e-6);
    }
}

#[test]
fn two_sides_are_two_rows() {
    let mut scene = Scene::default();
    add(&mut scene, &unit_square(0.0), 0.0);
    add(&mut scene, &unit_square(1.0), 0.0);
    let exact = form_factor(
        &unit_square(0.0),
        &unit_square(1.0).into_iter().rev().collect::<Vec<_>>(),
    );
    for analytic in [false, true] {
        let options = FormFactorOptions {
            two_sided: true,
            ..by_formula(WHOLE, 1 << 12)
        };
        let matrix = factors(
            &scene,
            &FormFactorOptions {
                analytic,
                ..options
            },
        );
        assert_eq!(
            (matrix.len(), &matrix.is_back[..]),
            (4, &[false, true, false, true][..])
        );
        // Front of the floor, 0, and back of the ceiling, 3, see each other; 1 and 2 see nothing.
        let (x, error) = matrix.get(0, 3);
        assert!((x - exact).abs() <= 4.0 * f64::from(error), "{x} ± {error}");
        assert_eq!(matrix.exchange.entries(), 2);
        assert_eq!([1, 2].map(|i| matrix.rest[i].escaped()), [1.0; 2]);
    }
    // One-sided, the same squares see nothing: the back of the ceiling only occludes.
    let matrix = factors(&scene, &by_formula(WHOLE, 1 << 12));
    assert!(matrix.exchange.pairs() == 0 && !matrix.is_closed);
    assert!(
        (matrix.rest[0].hidden - exact).abs() < 1e-2 && (matrix.rest[0].sum() - 1.0).abs() < 1e-6
    );
}

#[test]
fn two_sides_of_a_closed_room_are_closed() {
    let options = FormFactorOptions {
        two_sided: true,
        ..by_rays(PatchSize::Edge(0.5), 1 << 10)
    };
    let matrix = factors(&cube_room(), &options);
    assert!(matrix.is_closed);
    for (sum, &is_back) in matrix.row_sums().iter().zip(&matrix.is_back) {
        let expected = if is_back { 0.0 } else { 1.0 };
        assert!((sum - expected).abs() < 1e-6);
    }
}

#[test]
fn a_sphere_sees_itself_evenly() {
    // From inside, F_ij = A_j / A for every pair, also of a patch with itself.
    let mut scene = Scene::default();
    let grey = scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
    let sphere = Primitive::new(PrimitiveKind::Sphere, DAffine3::IDENTITY, grey);
    scene
        .objects
        .push(azulejo_scene::Object::new("", Shape::Primitive(sphere)));
    let options = FormFactorOptions {
        two_sided: true,
        ..by_formula(PatchSize::Count(24), 1 << 14)
    };
    let matrix = factors(&scene, &options);
    let whole: f64 = matrix.areas.iter().sum::<f64>() / 2.0;
    let (mut entries, mut inside) = (0, 0);
    for i in (0..matrix.len()).filter(|&i| matrix.is_back[i]) {
        assert!(matrix.get(i, i as u32).0 > 0.0);
        for (j, x, error) in matrix.row(i) {
            entries += 1;
            let off = (x - matrix.areas[j as usize] / whole).abs();
            inside += usize::from(off <= 3.0 * f64::from(error));
        }
    }
    assert!(
        entries > 100 && inside * 100 >= entries * 98,
        "{inside} of {entries}"
    );
}

#[test]
fn threads_do_not_matter() {
    let (scene, _) = mirror_room();
    let options = FormFactorOptions {
        two_sided: true,
        ..by_formula(PatchSize::Edge(0.2), 256)
    };
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let matrices = pool.install(|| {
            [
                factors(&scene, &options),
                factors(&cube_room(), &by_formula(PatchSize::Edge(0.2), 256)),
            ]
        });
        let bits = |f: &FormFactors| -> Vec<u64> {
            let values = (0..f.len()).flat_map(|i| f.exchange.upper(i));
            values.map(|e| e.value.to_bits()).collect()
        };
        matrices.map(|f| (bits(&f), f))
    };
    let one = run(1);
    for threads in [2, 3, 8] {
        assert!(run(threads) == one, "{threads} threads");
    }
}

#[test]
fn empty_scenes_and_cancellation() {
    let run = |scene: &Scene, progress: &Progress| {
        form_factors(scene, &Tracer::new(scene), &by_formula(WHOLE, 64), progress)
    };
    assert_eq!(
        run(&Scene::default(), &Progress::new()),
        Err(FactorsError::NoSurface)
    );
    let progress = Progress::new();
    progress.cancel();
    assert_eq!(run(&cube_room(), &progress), Err(FactorsError::Cancelled));
}

#[test]
fn few_rays_are_still_rows() {
    for rays in [0, 1, 5] {
        let matrix = factors(&cube_room(), &by_rays(WHOLE, rays));
        assert!(matrix.rays >= 6 * u64::from(rays) && matrix.exchange.pairs() > 0);
    }
}

fn scene_of(polygons: &[&[DVec3]]) -> Scene {
    let mut scene = Scene::default();
    polygons.iter().for_each(|p| add(&mut scene, p, 0.0));
    scene
}

/// Object 0 to object 1 of polygons that occlude each other, by rays and by formula.
fn check(polygons: &[&[DVec3]], expected: f64) {
    let scene = scene_of(polygons);
    for options in [by_rays(WHOLE, 1 << 14), by_formula(WHOLE, 1 << 14)] {
        let (f, error) = between(&factors(&scene, &options));
        assert!(
            (f - expected).abs() <= 4.0 * error + 1e-12,
            "{f} ± {error} is not {expected}"
        );
    }
}

#[test]
fn a_facet_that_crosses_the_plane_of_another() {
    let wall = [(-0.5, -1.0), (1.5, -1.0), (1.5, 1.0), (-0.5, 1.0)].map(|(y, z)| dvec3(-0.5, y, z));
    check(
        &[&unit_square(0.0), &wall],
        form_factor(&unit_square(0.0), &wall),
    );
    // Two squares through each other: each sees half of the other.
    let upright = [(0.0, -0.5), (1.0, -0.5), (1.0, 0.5), (0.0, 0.5)].map(|(y, z)| dvec3(0.5, y, z));
    check(
        &[&unit_square(0.0), &upright],
        form_factor(&unit_square(0.0), &upright),
    );
}

#[test]
fn an_occluder_that_touches_both_facets() {
    let (floor, ceiling) = (
        unit_square(0.0),
        unit_square(1.0).into_iter().rev().collect::<Vec<_>>(),
    );
    let wall = [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|(y, z)| dvec3(0.5, y, z));
    let half = |p: &[DVec3]| {
        p.iter()
            .map(|c| c * dvec3(0.5, 1.0, 1.0))
            .collect::<Vec<_>>()
    };
    check(
        &[&floor, &ceiling, &wall],
        form_factor(&half(&floor), &half(&ceiling)),
    );
}

#[test]
fn slivers() {
    let ceiling = unit_square(0.3).into_iter().rev().collect::<Vec<_>>();
    for width in [1e-2, 1e-4, 1e-6] {
        let strip = unit_square(0.0)
            .iter()
            .map(|c| c * dvec3(width, 1.0, 1.0))
            .collect::<Vec<_>>();
        let needle = [
            dvec3(0., 0., 0.),
            dvec3(1., width, 0.),
            dvec3(1., 2.0 * width, 0.),
        ];
        for sliver in [&strip[..], &needle] {
            let exact = form_factor(sliver, &ceiling);
            let scene = scene_of(&[sliver, &ceiling]);
            let (f, error) = between(&factors(&scene, &by_formula(WHOLE, 1 << 10)));
            assert!(
                (f - exact).abs() <= 4.0 * error,
                "{f} ± {error} is not {exact}"
            );
            // The tracer's single precision keeps few digits of a width of 1e-4 in a room of 1:
            // rays then hit the surface that they start from. The results stay in range.
            let (f, error) = between(&factors(&scene, &by_rays(WHOLE, 1 << 12)));
            let known = if width > 1e-3 { 4.0 * error } else { 0.2 };
            assert!((f - exact).abs() <= known, "{f} ± {error} is not {exact}");
        }
    }
}

#[test]
fn facets_in_one_plane_do_not_see_each_other() {
    let moved = |x: f64| {
        unit_square(0.0)
            .iter()
            .map(|c| c + x * DVec3::X)
            .collect::<Vec<_>>()
    };
    check(&[&moved(0.0), &moved(1.0)], 0.0);
    check(&[&moved(0.0), &moved(0.5)], 0.0);
}

#[test]
fn a_facet_without_area_is_not_there() {
    let ceiling = unit_square(1.0).into_iter().rev().collect::<Vec<_>>();
    let nothing = [dvec3(0., 0., 0.5), dvec3(1., 0., 0.5), dvec3(2., 0., 0.5)];
    check(
        &[&unit_square(0.0), &ceiling, &nothing],
        form_factor(&unit_square(0.0), &ceiling),
    );
}

#[test]
fn facets_back_to_back_in_one_place() {
    let (up, down) = (
        unit_square(1.0),
        unit_square(1.0).into_iter().rev().collect::<Vec<_>>(),
    );
    let roof = unit_square(2.0).into_iter().rev().collect::<Vec<_>>();
    let (floor, seen) = (unit_square(0.0), form_factor(&unit_square(0.0), &down));
    check(&[&floor, &down, &up, &roof], seen);
    check(&[&floor, &up, &down, &roof], 0.0);
    // Whichever of the two the tracer reports, the one that faces the light receives it.
    check(&[&roof, &down, &up, &floor], 0.0);
    check(&[&roof, &up, &down, &floor], seen);
}
