//! Matrices by the analytic engine.

use crate::cases::{CaseKind, cases};
use crate::poses::{Digits, pose, posed};
use crate::scenes;
use azulejo_factors::analytic::form_factor;
use azulejo_factors::form_factors::Closure;
use azulejo_factors::{Engine, FormFactorOptions, FormFactors, PatchSize, form_factors};
use azulejo_scene::synthetic::{
    CornellVariant, cornell_box, cube_array, cube_room, room_with_table,
};
use azulejo_scene::{Mesh, Object, Scene, Shape};
use azulejo_testing::closed_forms::{on_common_edge, opposed};
use azulejo_trace::sampling::uniform;
use azulejo_trace::{Progress, Tracer};
use glam::{DAffine3, DVec3, dvec3};
use proptest::prelude::*;

fn options() -> FormFactorOptions {
    FormFactorOptions {
        engine: Engine::Analytic,
        size: PatchSize::Edge(0.0),
        closure: Closure::Never,
        ..FormFactorOptions::default()
    }
}

fn compute(scene: &Scene, options: &FormFactorOptions) -> FormFactors {
    form_factors(scene, &Tracer::new(scene), options, &Progress::new()).unwrap()
}

/// Polygons and flat mirrors: 1e-10 without mirrors, also with occluders, and 1e-8 with mirrors.
#[test]
fn polygons_and_mirrors_are_exact() {
    for case in cases() {
        let tolerance = match case.kind {
            CaseKind::Polygons | CaseKind::Shadow => 1e-10,
            CaseKind::Mirrors => 1e-8,
            CaseKind::Curved | CaseKind::Glass => continue,
        };

        let tracer = Tracer::new(&case.scene);
        let (answer, factors) = case.ask(&tracer, &options(), &Progress::new()).unwrap();
        let off = answer.off(&case);
        eprintln!(
            "{:16} {:.13} ± {:.1e}, off {off:.1e}",
            case.id, answer.value, answer.error
        );
        // Plates between four perfect mirrors have too many images.
        if factors.engine_used.notes.iter().any(|n| n.contains("rays")) {
            assert_eq!(case.id, "plates");
            assert!(
                answer.standard_errors(&case) < 4.0,
                "{}: {answer:?}",
                case.id
            );
            continue;
        }
        assert!(
            off < tolerance * case.truth.value.max(1.0) + case.truth.error,
            "{}: {answer:?} is {off:e} off {:?}",
            case.id,
            case.truth
        );
        assert!(answer.error < 1e-6, "{}: {answer:?}", case.id);
    }
}

fn worst_sum(matrix: &FormFactors) -> f64 {
    let ended = matrix.ended();
    let sums = ended.iter().zip(&matrix.rest).map(|(e, r)| e + r.sum());
    sums.map(|sum| (sum - 1.0).abs()).fold(0.0, f64::max)
}

#[test]
fn rows_of_closed_rooms_sum_to_one() {
    let matrix = compute(&cube_room(), &options());
    assert!(worst_sum(&matrix) < 1e-12 && matrix.is_closed);
    let scene = room_with_table(500);
    let matrix = compute(&scene, &options());
    let sums = matrix.row_sums();
    let squares: f64 = sums.iter().map(|s| (s - 1.0).powi(2)).sum();
    let rms = (squares / sums.len() as f64).sqrt();
    assert!(rms < 5e-5, "{rms:e}");
    assert!(matrix.is_closed);
}

/// A small closed box whose fronts are inside: light does not pass its walls, whose backs the room sees.
#[test]
fn boxes_inside_out_block_light() {
    let mut scene = cube_room();
    let smaller = DAffine3::from_translation(DVec3::splat(0.4));
    let smaller = smaller * DAffine3::from_scale(DVec3::splat(0.2));
    scene.merge(cube_room().transformed(&smaller));
    let matrix = compute(&scene, &options());
    for (i, j) in (0..6).flat_map(|i| (6..12).map(move |j| (i, j))) {
        assert!(
            matrix.get(i, j).0 < 1e-12,
            "{i} {j}: {:?}",
            matrix.get(i, j)
        );
    }
    assert!(worst_sum(&matrix) < 1e-5, "{:e}", worst_sum(&matrix));
    // The walls see the box: six squares of side 0.2, of which each sends the walls all its light.
    let hidden: f64 = (0..6).map(|i| matrix.rest[i].hidden).sum();
    assert!((hidden - 6.0 * 0.04).abs() < 1e-5, "{hidden}");
    assert!(matrix.is_closed);
}

/// Σ X (1 − ρ_s) = 1, whatever the mirrors.
#[test]
fn mirrors_lose_nothing() {
    for rho_s in [0.3, 0.8] {
        let mirror = scenes::surface(0.1, rho_s, 0.0);
        let grey = scenes::surface(0.5, 0.0, 0.0);
        let walls = [&grey, &grey, &mirror, &grey, &grey, &grey].map(|m| m.clone());
        let one = compute(&scenes::cube(walls), &options());
        assert!(worst_sum(&one) < 1e-10, "{:e}", worst_sum(&one));
        let walls = [&grey, &grey, &mirror, &mirror, &grey, &grey].map(|m| m.clone());
        let two = compute(&scenes::cube(walls), &options());
        let cut = two.rest.iter().map(|r| r.cut).fold(0.0, f64::max);
        assert!(
            worst_sum(&two) < 1e-9 && cut < 1e-7,
            "{:e}, cut {cut:e}",
            worst_sum(&two)
        );
    }
}

/// A strip across the side of a cylinder of 128 polygons, whose planes all cut the strip.
#[test]
fn a_round_body_is_not_in_its_own_way() {
    let mut scene = Scene::default();
    let grey = scenes::surface(0.5, 0.0, 0.0);
    let corner = |k: i32| {
        let angle = f64::from(k) * std::f64::consts::PI / 64.0;
        dvec3(angle.sin(), -1.0, angle.cos())
    };
    let along = dvec3(0.0, 2.0, 0.0);
    for k in 0..128 {
        let edge = corner(k + 1) - corner(k);
        scenes::add_sheet(&mut scene, corner(k), along, -edge, grey.clone());
    }
    let (place, across) = (dvec3(-2.0, -1.0, 2.0), dvec3(4.0, 0.0, 0.0));
    scenes::add_sheet(&mut scene, place, along, across, grey);
    let matrix = compute(&scene, &options());
    let notes = &matrix.engine_used.notes;
    assert!(!notes.iter().any(|n| n.contains("rays")), "{notes:?}");
    let (strip, mut sum, mut variance) = (128, 0.0, 0.0);
    for (_, value, error) in matrix.row(strip) {
        sum += value;
        variance += f64::from(error).powi(2);
    }
    let by_rays = FormFactorOptions {
        engine: Engine::Rays,
        analytic: false,
        rays: 1 << 15,
        ..options()
    };
    let (mut by_rays_sum, mut by_rays_variance) = (0.0, 0.0);
    for (_, value, error) in compute(&scene, &by_rays).row(strip) {
        by_rays_sum += value;
        by_rays_variance += f64::from(error).powi(2);
    }
    let error = by_rays_variance.sqrt();
    assert!(error < 1.2e-4, "{error}");
    let off = (sum - by_rays_sum).abs();
    assert!(off < 4.0 * error, "{sum} and {by_rays_sum} ± {error}");
    assert!(variance.sqrt() < 3e-5, "{}", variance.sqrt());
}

/// A lone facet sees (1 + cos β) / 2 of the sky.
#[test]
fn the_unobstructed_sky_is_exact() {
    for degrees in [0.0f64, 17.0, 90.0, 135.0, 180.0] {
        let mut scene = Scene::default();
        let up = scene.units.up.axis();
        let (sin, cos) = degrees.to_radians().sin_cos();
        let across = up.any_orthonormal_vector();
        let along = across.cross(up) * cos + up * sin;
        let grey = scenes::surface(0.5, 0.0, 0.0);
        scenes::add_sheet(&mut scene, DVec3::ONE, along, across, grey);
        let matrix = compute(&scene, &options());
        let truth = 0.5 * (1.0 + along.cross(across).dot(up));
        let rest = matrix.rest[0];
        assert!((rest.sky - truth).abs() < 1e-15, "{degrees}: {rest:?}");
        assert!((rest.ground - (1.0 - truth)).abs() < 1e-15, "{rest:?}");
        assert!(matrix.rays == 0 && matrix.row_errors[0] == 0.0);
    }
}

/// Two walls that face each other at different heights, with a sheet between them, whose back has
/// no column: compared with a million rays per row.
#[test]
fn the_sky_between_walls() {
    let mut scene = Scene::default();
    let up = scene.units.up.axis();
    let (out, across) = (
        up.any_orthonormal_vector(),
        up.cross(up.any_orthonormal_vector()),
    );
    let grey = || scenes::surface(0.5, 0.0, 0.0);
    let far = 1.2 * out + 0.37 * up;
    scenes::add_sheet(&mut scene, DVec3::ZERO, across, up, grey());
    scenes::add_sheet(&mut scene, far, up, across, grey());
    let sheet = 0.5 * out + 0.2 * across + 0.5 * up;
    scenes::add_sheet(&mut scene, sheet, 0.5 * across, 0.4 * up, grey());
    for accuracy in [None, Some(1e-5)] {
        let matrix = compute(
            &scene,
            &FormFactorOptions {
                accuracy,
                ..options()
            },
        );
        let by_rays = FormFactorOptions {
            engine: Engine::Rays,
            analytic: false,
            rays: 1 << 20,
            ..options()
        };
        let by_rays = compute(&scene, &by_rays);
        for (i, (exact, rays)) in matrix.rest.iter().zip(&by_rays.rest).enumerate() {
            let error = 3.0 * (rays.sky_error + rays.ground_error);
            for (a, b) in [
                (exact.sky, rays.sky),
                (exact.ground, rays.ground),
                (exact.hidden, rays.hidden),
            ] {
                assert!((a - b).abs() < error, "{i}: {exact:?} {rays:?}");
            }
            assert!(error < 1e-3 && exact.sky_error < 1e-4, "{exact:?}");
        }
    }
}

/// In a box without a lid nothing leaves downwards, whatever its walls are divided into. The parts of walls
/// that touch each other above and below their horizons are not alike, if they are triangles.
#[test]
fn no_light_leaves_an_open_box_downwards() {
    for height in [0.3, 1.0, 3.0] {
        let scene = open_box(height);
        check_no_ground(&scene, &[None, Some(1e-5), Some(1e-8)]);
    }
}

/// A house in the box stands between walls and the floor that they touch, so that these are partly hidden from
/// each other. Still nothing leaves downwards.
#[test]
fn no_light_leaves_a_court_with_a_house_downwards() {
    for height in [0.4, 0.95] {
        let mut scene = open_box(1.0);
        let turned = |[x, y]: [f64; 2]| [0.3 + 0.45 * x - 0.1 * y, 0.2 + 0.1 * x + 0.45 * y];
        add_prism(&mut scene, turned, height, true);
        check_no_ground(&scene, &[None, Some(1e-6)]);
    }
}

/// Nothing leaves the scene downwards, within the errors of the rows.
fn check_no_ground(scene: &Scene, accuracies: &[Option<f64>]) {
    for &accuracy in accuracies {
        let options = FormFactorOptions {
            accuracy,
            ..options()
        };
        let matrix = compute(scene, &options);
        for (i, rest) in matrix.rest.iter().enumerate() {
            let most = 4.0 * rest.ground_error + 1e-9;
            assert!(rest.ground <= most, "{accuracy:?} {i}: {rest:?}");
            assert!(rest.ground_error < 1e-4, "{rest:?}");
        }
    }
}

/// A floor of one unit by one, and four walls of two triangles each.
fn open_box(height: f64) -> Scene {
    let mut scene = Scene::default();
    add_prism(&mut scene, |corner| corner, height, false);
    scene
}

/// Four walls of two triangles each over a square that has been moved by `place`: a room with a floor, or a house
/// with a roof, which is seen from outside.
fn add_prism(scene: &mut Scene, place: impl Fn([f64; 2]) -> [f64; 2], height: f64, is_house: bool) {
    let up = scene.units.up.axis();
    let along = up.any_orthonormal_vector();
    let grey = scene.add_material(scenes::surface(0.5, 0.0, 0.0));
    let mut mesh = Mesh::default();
    for h in [0.0, height] {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(&place);
        let corner = |[x, y]: [f64; 2]| x * along + y * up.cross(along) + h * up;
        mesh.positions.extend(corners.map(corner));
    }
    mesh.push_face(
        if is_house {
            &[4, 5, 6, 7]
        } else {
            &[0, 1, 2, 3]
        },
        grey,
    );
    for k in 0..4 {
        let next = (k + 1) % 4;
        for mut triangle in [[k, k + 4, next + 4], [k, next + 4, next]] {
            if is_house {
                triangle.reverse();
            }
            mesh.push_face(&triangle, grey);
        }
    }
    let name = if is_house { "house" } else { "box" };
    scene.objects.push(Object::new(name, Shape::Mesh(mesh)));
}

/// Sky and ground beside an open Cornell box, compared with rays.
#[test]
fn open_rooms_agree_with_rays() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let divided = FormFactorOptions {
        size: PatchSize::Count(200),
        ..options()
    };
    let exact = compute(&scene, &divided);
    let by_rays = FormFactorOptions {
        engine: Engine::Rays,
        analytic: false,
        rays: 1 << 14,
        ..divided
    };
    let by_rays = compute(&scene, &by_rays);
    let (mut squares, mut errors) = (0.0, 0.0);
    for (i, (formulas, rays)) in exact.rest.iter().zip(&by_rays.rest).enumerate() {
        for (a, b, error) in [
            (formulas.sky, rays.sky, rays.sky_error),
            (formulas.ground, rays.ground, rays.ground_error),
        ] {
            assert!(
                (a - b).abs() < 5.0 * error + 2e-4,
                "{i}: {formulas:?} {rays:?}"
            );
            squares += (a - b).powi(2);
            errors += error.powi(2);
        }
        let expected = 0.79 * (formulas.sky_error + formulas.ground_error);
        assert!(exact.row_errors[i] >= expected, "{i}: {formulas:?}");
    }
    assert!(squares < 1.3 * errors, "{squares:e} {errors:e}");
    assert!(exact.rays == 0);
}

#[test]
fn threads_change_no_bit() {
    let scene = room_with_table(300);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| compute(&scene, &options()))
    };
    assert!(with(1) == with(3));
}

/// A few boxes and sheets at random positions.
fn clutter(seed: u32, mirror: f64) -> Scene {
    let mut scene = cube_room();
    let number = |k: u32| f64::from(uniform(&[seed, k]));
    for k in 0..5 {
        let at = |k: u32| dvec3(number(k), number(k + 1), number(k + 2));
        let (corner, first, second) = (at(10 * k), at(10 * k + 3), at(10 * k + 6));
        let corner = DVec3::splat(0.2) + 0.4 * corner;
        let (first, second) = (0.3 * first, 0.3 * (second - DVec3::splat(0.5)));
        let reflects = if k == 0 { mirror } else { 0.0 };
        let material = scenes::surface(0.5 * (1.0 - reflects), reflects, 0.0);
        scenes::add_sheet(&mut scene, corner, first, second, material);
    }
    scene
}

/// Both engines' form factors agree within the rays' errors.
fn check_against_rays(scene: &Scene) {
    let exact = compute(
        scene,
        &FormFactorOptions {
            two_sided: true,
            accuracy: Some(1e-4),
            ..options()
        },
    );
    let rays = FormFactorOptions {
        engine: Engine::Rays,
        rays: 4_096,
        analytic: false,
        two_sided: true,
        ..options()
    };
    let rays = compute(scene, &rays);
    let (mut chi, mut count) = (0.0, 0.0);
    for i in 0..exact.len() {
        for j in i..exact.len() {
            let ((a, e), (b, f)) = (exact.get(i, j as u32), rays.get(i, j as u32));
            if a.max(b) > 1e-9 {
                // A pair that no ray found has no error: that of a single ray counts then.
                let one = 1.0 / 4_096.0;
                let error = f64::from(e)
                    .hypot(f64::from(f))
                    .max((a.max(one) * one).sqrt());
                chi += ((a - b) / error).powi(2);
                count += 1.0;
                assert!(
                    (a - b).abs() < 6.0 * error,
                    "{i} {j}: {a} ± {e} and {b} ± {f}"
                );
            }
        }
    }
    assert!(chi < 1.5 * count, "χ² {chi} of {count}");
}

/// A block without bottom in the middle of a larger square, which its walls touch: from inside, the block's faces and
/// the floor below see each other as in a closed box, and from outside each wall sees half of the floor, however
/// the scene stands.
#[test]
fn faces_that_touch_within_a_face_are_within_their_errors() {
    let (wide, size) = (4.0, dvec3(1.2, 0.9, 1.5));
    let mut scene = Scene::default();
    let grey = || scenes::surface(0.5, 0.0, 0.0);
    let across = [wide * DVec3::X, wide * DVec3::Y];
    scenes::add_sheet(&mut scene, DVec3::ZERO, across[0], across[1], grey());
    let low = dvec3(1.3, 1.7, 0.0);
    let [x, y, z] = [size.x * DVec3::X, size.y * DVec3::Y, size.z * DVec3::Z];
    for (corner, first, second) in [
        (low + z, x, y),
        (low, x, z),
        (low + x, y, z),
        (low + x + y, -x, z),
        (low + y, -y, z),
    ] {
        scenes::add_sheet(&mut scene, corner, first, second, grey());
    }
    let floor = [[0., 0.], [wide, 0.], [wide, wide], [0., wide]].map(|[x, y]| dvec3(x, y, 0.0));
    let wall = |corner: DVec3, along: DVec3| {
        let corners = [corner, corner + along, corner + along + z, corner + z];
        form_factor(&corners, &floor)
    };
    let narrow = on_common_edge(size.x, size.z, size.y);
    let broad = on_common_edge(size.y, size.z, size.x);
    let expected = [
        [0.0, opposed(size.x, size.y, size.z)],
        [wall(low, x), narrow],
        [wall(low + x, y), broad],
        [wall(low + x + y, -x), narrow],
        [wall(low + y, -y), broad],
    ];
    let options = FormFactorOptions {
        two_sided: true,
        accuracy: Some(5e-5),
        ..options()
    };
    let turned = posed(&scene, &pose(3, 10.0), Digits::Decimals(6));
    for (scene, slack) in [(&scene, 1e-9), (&turned, 1e-5)] {
        let matrix = compute(scene, &options);
        let (floor_front, mut below) = (0, 0.0);
        for (k, sides) in expected.iter().enumerate() {
            for (side, truth) in sides.iter().enumerate() {
                let row = 2 * (k + 1) + side;
                let (value, error) = matrix.get(row, floor_front);
                let most = 5.0 * f64::from(error) + slack;
                assert!((value - truth).abs() < most, "{row}: {value}, not {truth}");
                assert!(error < 1e-4, "{row}: {error:e}");
                below += side as f64 * matrix.get(floor_front as usize, row as u32).0;
            }
        }
        let share = size.x * size.y / (wide * wide);
        assert!((below / share - 1.0).abs() < 1e-4, "{below}, not {share}");
    }
}

/// Where a larger error is allowed, shadow rays find most pairs with something between them: within that error, without
/// bias, and with errors that say so, for rows and for the sky.
#[test]
fn shadow_rays_of_pairs_are_within_the_error() {
    const ERROR: f64 = 1e-3;
    const SEEDS: u64 = 8;
    let scene = cube_array(3, 1);
    let truth = compute(&scene, &options());
    let sums = truth.row_sums();
    let seeing: Vec<usize> = (0..truth.len()).filter(|&i| sums[i] > 0.0).collect();
    let (mut squares, mut mean, mut stated, mut sky, mut near) = (0.0, 0.0, 0.0, 0.0, 0);
    for seed in 0..SEEDS {
        let options = FormFactorOptions {
            accuracy: Some(ERROR),
            seed,
            ..options()
        };
        let found = compute(&scene, &options);
        let notes = found.engine_used.notes.join("; ");
        assert!(notes.contains("shadow rays estimated"), "{notes}");
        let all = found.row_sums();
        for (&i, sum) in seeing.iter().map(|i| (i, all[*i])) {
            squares += (sum - sums[i]).powi(2);
            mean += sum - sums[i];
            let variances = found.row(i).map(|(_, _, error)| f64::from(error).powi(2));
            stated += variances.sum::<f64>();
            let off = found.rest[i].sky - truth.rest[i].sky;
            sky += off * off;
            let most = 2.0 * found.rest[i].sky_error + 2.0 * truth.rest[i].sky_error;
            near += u32::from(off.abs() <= most);
        }
    }
    let count = SEEDS as f64 * seeing.len() as f64;
    let [actual, stated, sky] = [squares, stated, sky].map(|sum| (sum / count).sqrt());
    let (mean, near) = (mean / count, f64::from(near) / count);
    let found = format!("{actual:e}, stated {stated:e}, mean {mean:e}, sky {sky:e}, {near}");
    assert!(actual < 1.25 * ERROR && sky < 1.25 * ERROR, "{found}");
    assert!(actual > 0.01 * ERROR, "{found}");
    assert!((0.5..=2.0).contains(&(stated / actual)), "{found}");
    assert!(mean.abs() < 0.1 * ERROR && near > 0.9, "{found}");
}

/// Sums over patches, which have no faces that touch them within, are the factors of whole faces, however the box
/// stands: entries were off by up to 4%.
#[test]
fn whole_faces_see_what_their_patches_see() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let two_sided = FormFactorOptions {
        two_sided: true,
        ..options()
    };
    let divided = FormFactorOptions {
        size: PatchSize::Count(200),
        ..two_sided.clone()
    };
    let truth = by_side(&compute(&scene, &divided));
    let turned = posed(&scene, &pose(3, 1_000.0), Digits::Decimals(3));
    let straight = azulejo_testing::is_thorough().then_some(&scene);
    for scene in straight.into_iter().chain([&turned]) {
        let whole = by_side(&compute(scene, &two_sided));
        assert_eq!(whole.len(), truth.len());
        for i in 0..whole.len() {
            for j in 0..whole.len() as u32 {
                let ((a, e), (b, f)) = (whole.get(i, j), truth.get(i, j));
                let most = 5.0 * f64::from(e).hypot(f64::from(f)) + 1e-4;
                assert!((a - b).abs() < most, "{i} {j}: {a} ± {e:e}, not {b}");
            }
        }
    }
}

/// The matrix between the sides of faces, from a two-sided one between those of their patches.
fn by_side(matrix: &FormFactors) -> FormFactors {
    let place = |i: usize| {
        (
            matrix.faces[i].object,
            matrix.faces[i].face,
            matrix.is_back[i],
        )
    };
    let mut sides: Vec<(u32, u32, bool)> = (0..matrix.len()).map(place).collect();
    let own = sides.clone();
    sides.sort_unstable();
    sides.dedup();
    let group = |side: &(u32, u32, bool)| sides.binary_search(side).ok().map(|k| k as u32);
    let groups: Vec<Option<u32>> = own.iter().map(group).collect();
    matrix.grouped(&groups, sides.len())
}

/// Outside of the notch of an L-shaped room, the backs of two walls see each other, and nothing in the room sees them.
#[test]
fn backs_of_a_room_with_a_notch_are_hidden_from_inside() {
    let mut scene = Scene::default();
    let outline = [[0, 0], [4, 0], [4, 2], [2, 2], [2, 5], [0, 5]].map(|p| p.map(f64::from));
    let mut mesh = Mesh::default();
    for height in [0.0, 2.5] {
        mesh.positions
            .extend(outline.map(|[x, y]| dvec3(x, y, height)));
    }
    let grey = scene.add_material(scenes::surface(0.5, 0.0, 0.0));
    mesh.push_face(&[0, 1, 2, 3, 4, 5], grey);
    mesh.push_face(&[11, 10, 9, 8, 7, 6], grey);
    for p in 0..6 {
        let q = (p + 1) % 6;
        mesh.push_face(&[q, p, p + 6, q + 6], grey);
    }
    scene.objects.push(Object::new("room", Shape::Mesh(mesh)));
    let (along, across) = (DVec3::Y, DVec3::X);
    scenes::add_sheet(
        &mut scene,
        dvec3(0.5, 3.5, 2.4),
        along,
        across,
        scenes::surface(0.0, 0.0, 1.0),
    );
    check_against_rays(&scene);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if azulejo_testing::is_thorough() { 4 } else { 2 }))]
    #[test]
    fn agrees_with_rays(seed in 0u32..1_000_000) {
        check_against_rays(&clutter(seed, 0.0));
    }

    #[test]
    fn agrees_with_rays_by_mirrors(seed in 0u32..1_000_000) {
        check_against_rays(&clutter(seed, 0.7));
    }
}

/// The matrix between faces, from that between their patches.
fn by_face(matrix: &FormFactors) -> FormFactors {
    let mut faces: Vec<(u32, u32)> = matrix.faces.iter().map(|f| (f.object, f.face)).collect();
    let own = faces.clone();
    faces.sort_unstable();
    faces.dedup();
    let group = |face: &(u32, u32)| faces.binary_search(face).ok().map(|k| k as u32);
    let groups: Vec<Option<u32>> = own.iter().map(group).collect();
    matrix.grouped(&groups, faces.len())
}

/// Images in divided mirrors between divided faces, compared with those between whole faces, which
/// are exact, and with rays.
fn check_divided(scene: &Scene, count: usize) -> FormFactors {
    let with = |options: FormFactorOptions| {
        let options = FormFactorOptions {
            separate: true,
            ..options
        };
        compute(scene, &options)
    };
    let whole = with(FormFactorOptions {
        accuracy: Some(9e-7),
        ..options()
    });
    let divided = FormFactorOptions {
        size: PatchSize::Count(count),
        ..options()
    };
    let rays = with(FormFactorOptions {
        engine: Engine::Rays,
        analytic: false,
        ..divided.clone()
    });
    let divided = with(divided);
    assert!(divided.len() > 32);
    let [whole, rays, divided] = [&whole, &rays, &divided].map(by_face);
    let areas = divided.areas.clone();
    for order in 0..2 {
        let [whole, rays, divided] = [&whole, &rays, &divided].map(|f| &f.orders[order]);
        for (i, &area) in areas.iter().enumerate() {
            for j in i..divided.len() {
                let [exact, rays, divided] = [whole, rays, divided].map(|o| o.get(i, j));
                let off = divided.value - rays.value;
                let noise = f64::from(rays.error).hypot(f64::from(divided.error));
                let limit = 1e-4 * area;
                assert!(
                    (divided.value - exact.value).abs() < limit,
                    "order {order}, {i} {j}: {divided:?} is not {exact:?}"
                );
                assert!(
                    off.abs() < 5.0 * noise + limit,
                    "order {order}, {i} {j}: {divided:?} and rays {rays:?}"
                );
            }
        }
    }
    divided
}

/// A room with a sheet in it and mirrors on some of its walls.
fn mirrored_room(mirrors: [bool; 6]) -> Scene {
    let wall = |is_mirror| {
        if is_mirror {
            scenes::surface(0.0, 0.3, 0.0)
        } else {
            scenes::surface(0.5, 0.0, 0.0)
        }
    };
    let mut scene = scenes::cube(mirrors.map(wall));
    let corner = dvec3(0.3, 0.2, 0.4);
    let edges = [dvec3(0.4, 0.0, 0.1), dvec3(0.0, 0.5, 0.0)];
    scenes::add_sheet(&mut scene, corner, edges[0], edges[1], wall(false));
    scene
}

#[test]
fn divided_mirrors_are_one_mirror_each() {
    let one = mirrored_room([false, false, true, false, false, false]);
    let matrix = check_divided(&one, 150);
    assert!(!matrix.engine_used.notes.iter().any(|n| n.contains("rays")));
    check_divided(&cornell_box(CornellVariant::MirrorBlock), 150);
    if azulejo_testing::is_thorough() {
        for mirrors in [
            [false, false, true, true, false, false],
            [true, false, true, false, false, false],
        ] {
            check_divided(&mirrored_room(mirrors), 150);
        }
    }
}

/// Light that hits both mirrors may hit either first.
#[test]
fn mirrors_at_right_angles_are_seen_in_either_order() {
    let scene = mirrored_room([true, false, true, false, false, false]);
    let matrix = compute(&scene, &options());
    assert!(!matrix.engine_used.notes.iter().any(|n| n.contains("rays")));
    assert!(worst_sum(&matrix) < 1e-8, "{:e}", worst_sum(&matrix));
    check_against_rays(&scene);
}
