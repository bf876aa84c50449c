//! Form factors in blocks between clusters: against the whole matrix, and by themselves.

use crate::scenes::{add_tiles, cube, surface};
use azulejo_factors::form_factors::{Exchange, ExchangeAreas, Plan, RowRemainder};
use azulejo_factors::hierarchy::{
    self, CompressionError, OperatorError, StatedFactors, radiosities,
};
use azulejo_factors::{
    Closure, CompressedFactors, CompressionOptions, Engine, FactorOperator, FactorsError,
    FormFactorOptions, FormFactors, PatchSize, PointNormal, form_factors,
};
use azulejo_scene::synthetic::{CornellVariant, cornell_box, displaced_sphere};
use azulejo_scene::{Material, Scene};
use azulejo_trace::{Progress, Tracer};
use glam::DVec3;
use proptest::prelude::*;

/// The whole matrix of a scene, with the places of its rows.
fn whole(scene: &Scene, options: &FormFactorOptions) -> (FormFactors, Vec<PointNormal>) {
    let tracer = Tracer::new(scene);
    let plan = Plan::new(scene, &tracer, options).unwrap();
    let places = plan.prepare().places();
    let factors = form_factors(scene, &tracer, options, &Progress::new()).unwrap();
    (factors, places)
}

fn by_rays(scene: &Scene, options: &FormFactorOptions, tolerance: f64) -> CompressedFactors {
    let tracer = Tracer::new(scene);
    let plan = Plan::new(scene, &tracer, options).unwrap();
    let options = with(tolerance, true);
    CompressedFactors::from_rays(&plan.prepare(), &options, &Progress::new()).unwrap()
}

fn with(tolerance: f64, keep_sums: bool) -> CompressionOptions {
    CompressionOptions {
        tolerance,
        keep_sums,
    }
}

fn compressed(
    (factors, places): &(FormFactors, Vec<PointNormal>),
    options: &CompressionOptions,
) -> CompressedFactors {
    CompressedFactors::new(factors, places, options, &Progress::new()).unwrap()
}

fn rays(count: usize, rays: u32) -> FormFactorOptions {
    FormFactorOptions {
        engine: Engine::Rays,
        size: PatchSize::Count(count),
        rays,
        ..FormFactorOptions::default()
    }
}

fn exact(count: usize) -> FormFactorOptions {
    FormFactorOptions {
        engine: Engine::Analytic,
        ..rays(count, 64)
    }
}

/// Two plates of 16 × 16 fields, one above the other.
fn plates() -> Scene {
    let mut scene = Scene::default();
    let grey = || surface(0.5, 0.0, 0.0);
    add_tiles(&mut scene, DVec3::ZERO, DVec3::X, DVec3::Y, 16, grey());
    add_tiles(&mut scene, DVec3::Z, DVec3::Y, DVec3::X, 16, grey());
    scene
}

/// A ball with hills in a cube that is twice its size.
fn ball_in_cube() -> Scene {
    let mut scene = cube([(); 6].map(|()| surface(0.5, 0.0, 0.0)));
    let mut ball = displaced_sphere(400);
    let material = scene.add_material(Material::default());
    for mut object in ball.objects.drain(..) {
        if let azulejo_scene::Shape::Mesh(mesh) = &mut object.shape {
            let half = |p: &mut DVec3| *p = 0.25 * *p + DVec3::splat(0.5);
            mesh.positions.iter_mut().for_each(half);
            mesh.face_materials.fill(material);
        }
        scene.objects.push(object);
    }
    scene
}

/// S, column by column.
fn dense(operator: &dyn FactorOperator) -> Vec<Vec<f64>> {
    let n = operator.row_areas().len();
    let column = |j: usize| {
        let mut unit = vec![0.0; n];
        unit[j] = 1.0;
        operator.exchanged(&unit)
    };
    (0..n).map(column).collect()
}

/// Frobenius norm of A^−½ (S − S') A^−½ over the mean row sum, which tolerances refer to.
fn error(approximate: &dyn FactorOperator, exact: &dyn FactorOperator) -> f64 {
    let areas = exact.row_areas();
    let (a, b) = (dense(approximate), dense(exact));
    let mut squares = 0.0;
    for i in 0..areas.len() {
        for j in 0..areas.len() {
            squares += (a[i][j] - b[i][j]).powi(2) / (areas[i] * areas[j]);
        }
    }
    let light: f64 = exact.exchanged(&vec![1.0; areas.len()]).iter().sum();
    squares.sqrt() / (light / areas.iter().sum::<f64>())
}

fn check_compression(name: &str, matrix: &(FormFactors, Vec<PointNormal>)) {
    let mut bytes = usize::MAX;
    for tolerance in [0.0, 1e-4, 1e-3, 1e-2, 1e-1] {
        let approximate = compressed(matrix, &with(tolerance, false));
        let off = error(&approximate, &matrix.0);
        eprintln!(
            "{name} {tolerance:e}: {off:.1e}, stated {:.1e}",
            approximate.bound
        );
        // Numbers are stored with 24 bits.
        assert!(
            off <= approximate.bound + 1e-6,
            "{name} {tolerance}: {off} {}",
            approximate.bound
        );
        assert!(
            approximate.bound <= tolerance,
            "{name} {tolerance}: {}",
            approximate.bound
        );
        assert!(
            approximate.bytes() <= bytes,
            "{name} {tolerance}: {bytes}, then {}",
            approximate.bytes()
        );
        bytes = approximate.bytes();
        let columns = dense(&approximate);
        for (i, column) in columns.iter().enumerate() {
            for (j, value) in column.iter().enumerate() {
                assert_eq!(value.to_bits(), columns[j][i].to_bits(), "{name}: {i} {j}");
            }
        }
    }
    assert!(
        2 * bytes < matrix.0.bytes(),
        "{name}: {bytes} of {}",
        matrix.0.bytes()
    );
}

#[test]
fn two_plates_are_a_few_products() {
    let matrix = whole(
        &plates(),
        &FormFactorOptions {
            size: PatchSize::Edge(0.0),
            ..exact(0)
        },
    );
    check_compression("plates", &matrix);
    let approximate = compressed(&matrix, &with(1e-3, true));
    assert!(approximate.kinds()[2] > 0, "{:?}", approximate.kinds());
    // A few entries, by themselves.
    for (i, j) in [(0, 300), (300, 0), (17, 511), (3, 5)] {
        let truth = matrix.0.exchange.get(i, j).value;
        let value = approximate.exchange_area(i, j);
        assert!(
            (value - truth).abs() < 1e-3 * matrix.0.areas[i],
            "{i} {j}: {value} {truth}"
        );
        assert_eq!(value.to_bits(), approximate.exchange_area(j, i).to_bits());
    }
}

#[test]
fn a_ball_in_a_cube_keeps_its_error() {
    check_compression("ball in cube", &whole(&ball_in_cube(), &rays(400, 1_024)));
}

#[test]
fn mirrors_are_compressed_too() {
    let scene = cornell_box(CornellVariant::MirrorBlock);
    let matrix = whole(&scene, &rays(600, 2_048));
    check_compression("mirror", &matrix);
    let approximate = compressed(&matrix, &with(1e-2, true));
    let ended = |operator: &dyn FactorOperator| operator.apply(&matrix.0.ends);
    for (a, b) in ended(&approximate).iter().zip(ended(&matrix.0)) {
        assert!((a - b).abs() < 1e-6, "{a} {b}");
    }
}

#[test]
fn sums_of_an_enclosure_are_kept() {
    let scene = cube([(); 6].map(|()| surface(0.5, 0.0, 0.0)));
    let matrix = whole(&scene, &exact(600));
    let loose = OperatorError::of(&compressed(&matrix, &with(1e-2, false)), &matrix.0, 3, 1);
    let kept = OperatorError::of(&compressed(&matrix, &with(1e-2, true)), &matrix.0, 3, 1);
    eprintln!("{loose:?}\n{kept:?}");
    assert!(kept.most_of_sum < 1e-6 && loose.most_of_sum > 1e-5);
    assert!(kept.product <= loose.product && kept.worst < 1e-2);
    // An operator is not off itself.
    assert_eq!(
        OperatorError::of(&matrix.0, &matrix.0, 2, 1),
        OperatorError::default()
    );
}

#[test]
fn threads_change_no_bit() {
    let scene = cornell_box(CornellVariant::MirrorBlock);
    let run = |threads: usize| {
        let pool = rayon_pool(threads);
        pool.install(|| {
            let options = rays(500, 256);
            let from_matrix = compressed(&whole(&scene, &options), &with(1e-2, true));
            let from_rays = by_rays(&scene, &options, 1e-2);
            let x: Vec<f64> = (0..from_rays.len()).map(|i| (i % 7) as f64).collect();
            (
                from_matrix.apply(&x),
                from_rays.apply_transposed(&x),
                from_matrix,
                bits(&from_rays),
            )
        })
    };
    assert!(run(1) == run(3));
}

/// What can be compared: a bound that is not known is not equal to itself.
fn bits(approximate: &CompressedFactors) -> CompressedFactors {
    assert!(approximate.bound.is_nan());
    CompressedFactors {
        bound: 0.0,
        ..approximate.clone()
    }
}

fn rayon_pool(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap()
}

#[test]
fn one_patch_none_and_all_in_one_point() {
    let place = PointNormal {
        position: DVec3::ZERO,
        normal: DVec3::Z,
    };
    let none = (FormFactors::default(), Vec::new());
    let approximate = compressed(&none, &CompressionOptions::default());
    assert!(
        approximate.is_empty() && approximate.apply(&[]).is_empty() && approximate.bound == 0.0
    );
    for n in [1usize, 300] {
        let row = |i: usize| {
            let entry = |j: usize| Exchange {
                column: j as u32,
                value: 1.0 / n as f64,
                error: 0.0,
            };
            (i..n).map(entry).collect::<Vec<_>>()
        };
        let factors = FormFactors {
            exchange: (0..n).map(row).collect(),
            areas: vec![1.0; n],
            ends: vec![1.0; n],
            rest: vec![RowRemainder::default(); n],
            ..FormFactors::default()
        };
        let matrix = (factors, vec![place; n]);
        for tolerance in [0.0, 1e-3] {
            let approximate = compressed(&matrix, &with(tolerance, true));
            assert!(
                approximate.sums().iter().all(|s| (s - 1.0).abs() < 1e-6),
                "{n}"
            );
        }
    }
    // Nothing sees anything.
    let dark = FormFactors {
        exchange: (0..200).map(|_| Vec::new()).collect(),
        areas: vec![1.0; 200],
        ends: vec![1.0; 200],
        rest: vec![RowRemainder::default(); 200],
        ..FormFactors::default()
    };
    let approximate = compressed(&(dark, vec![place; 200]), &CompressionOptions::default());
    assert!(approximate.sums().iter().all(|&s| s == 0.0) && approximate.kinds() == [0; 3]);
}

#[test]
fn a_tolerance_must_be_one() {
    for wrong in [-1e-3, 1.0, f64::NAN, f64::INFINITY] {
        let none = FormFactors::default();
        let new = CompressedFactors::new(&none, &[], &with(wrong, true), &Progress::new());
        let error = new.unwrap_err();
        let text = error.to_string();
        assert!(
            text.contains(&wrong.to_string()) && text.contains("less than 1"),
            "{text}"
        );
    }
}

#[test]
fn compression_can_be_cancelled() {
    let scene = plates();
    let matrix = whole(&scene, &exact(200));
    let progress = Progress::new();
    progress.cancel();
    let options = CompressionOptions::default();
    let cancelled = Err(CompressionError::Factors(FactorsError::Cancelled));
    let new = CompressedFactors::new(&matrix.0, &matrix.1, &options, &progress);
    assert_eq!(new.map(|_| ()), cancelled);
    let (tracer, given) = (Tracer::new(&scene), rays(200, 64));
    let plan = Plan::new(&scene, &tracer, &given).unwrap();
    let new = CompressedFactors::from_rays(&plan.prepare(), &options, &progress);
    assert_eq!(new.map(|_| ()), cancelled);
}

#[test]
fn rays_build_what_formulas_say() {
    let scene = cube([(); 6].map(|()| surface(0.5, 0.0, 0.0)));
    let (truth, _) = whole(&scene, &exact(1_350));
    for tolerance in [0.0, 1e-2] {
        let approximate = by_rays(&scene, &rays(1_350, 4_096), tolerance);
        let links = approximate.kinds()[2];
        assert_eq!(links > 0, tolerance > 0.0, "{links} links");
        let off = OperatorError::of(&approximate, &truth, 3, 1);
        eprintln!(
            "{tolerance:e}: {off:?}, {} bytes of {}",
            approximate.bytes(),
            truth.bytes()
        );
        assert!(off.product < 8e-3 && off.worst < 4e-2, "{off:?}");
        // Rays of a closed room arrive, all but one or two of some rows along its edges.
        assert!(off.most_of_sum < 1e-3 && off.mean_of_sum < 1e-4, "{off:?}");
        check_stated(&approximate, &truth);
        let values = approximate.parts.iter().flat_map(|p| &p.values);
        assert!(values.clone().all(|&v| v >= 0.0 && v.is_finite()));
    }
}

/// Nine in ten products lie within two stated errors of the truth, and errors are not stated to be
/// many times too large.
fn check_stated(approximate: &CompressedFactors, truth: &FormFactors) {
    let n = approximate.len();
    let x: Vec<f64> = (0..n).map(|i| ((i / 50) % 7) as f64).collect();
    let ((y, errors), truth) = (approximate.apply_with_errors(&x), truth.apply(&x));
    let off = |i: usize| (y[i] - truth[i]).abs();
    let within = (0..n).filter(|&i| off(i) <= 2.0 * errors[i]).count();
    let stated: f64 = errors.iter().map(|e| e * e).sum();
    let actual: f64 = (0..n).map(|i| off(i).powi(2)).sum();
    let ratio = (stated / actual).sqrt();
    eprintln!("{within} of {n} within two errors, {ratio:.2} times the actual");
    assert!(
        within * 10 >= 9 * n && ratio < 4.0,
        "{within} of {n}, {ratio}"
    );
}

#[test]
fn rays_by_mirrors_end_somewhere() {
    let scene = cornell_box(CornellVariant::MirrorBlock);
    let options = FormFactorOptions {
        closure: Closure::Never,
        ..rays(1_200, 8_192)
    };
    let (truth, _) = whole(&scene, &options);
    let approximate = by_rays(&scene, &rays(1_200, 2_048), 1e-2);
    let ended = approximate.apply(&approximate.ends);
    for (i, ended) in ended.iter().enumerate() {
        let sum = ended + approximate.rest[i].sum();
        assert!((sum - 1.0).abs() < 1e-4 || *ended == 0.0, "row {i}: {sum}");
    }
    let off = OperatorError::of(&approximate, &truth, 3, 1);
    eprintln!("{off:?}, {:?}", approximate.kinds());
    assert!(off.product < 2e-2, "{off:?}");
    check_stated(&approximate, &truth);
}

#[test]
fn light_in_a_furnace_is_the_same_everywhere() {
    let scene = cube([(); 6].map(|()| surface(0.5, 0.0, 0.0)));
    let matrix = whole(&scene, &exact(600));
    let approximate = compressed(&matrix, &with(1e-2, true));
    let n = approximate.len();
    for operator in [&matrix.0 as &dyn FactorOperator, &approximate] {
        let solve = |exitance: &[f64]| {
            let ends = (1e-12, 100);
            radiosities(operator, exitance, &vec![0.75; n], ends, &Progress::new()).unwrap()
        };
        // B = M / (1 − ρ).
        let (b, iterations) = solve(&vec![2.0; n]);
        assert!(
            iterations < 20 && b.iter().all(|b| (b - 8.0).abs() < 1e-5),
            "{iterations}"
        );
        // Any solution satisfies B = M + ρ X B.
        let exitance: Vec<f64> = (0..n).map(|i| (i % 3) as f64).collect();
        let (b, _) = solve(&exitance);
        for (i, arriving) in operator.apply(&b).iter().enumerate() {
            assert!(
                (b[i] - exitance[i] - 0.75 * arriving).abs() < 1e-9,
                "row {i}"
            );
        }
        assert_eq!(solve(&vec![0.0; n]).0, vec![0.0; n]);
    }
}

#[test]
fn products_go_both_ways() {
    let matrix = whole(&plates(), &exact(400));
    let approximate = compressed(&matrix, &with(1e-3, false));
    let n = approximate.len();
    let (x, y): (Vec<f64>, Vec<f64>) = (0..n).map(|i| ((i % 5) as f64, (i % 3) as f64)).unzip();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (there, back) = (
        dot(&y, &approximate.apply(&x)),
        dot(&approximate.apply_transposed(&y), &x),
    );
    assert!((there - back).abs() < 1e-12 * there.abs(), "{there} {back}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn any_matrix_stays_within_its_tolerance(
        n in 1usize..280,
        seed in 0u32..1000,
        exponent in 0.5f64..5.0,
        share in 0.05f64..1.0,
    ) {
        let number = |k: u32, i: usize| f64::from(azulejo_trace::sampling::uniform(&[seed, k, i as u32]));
        let place = |i: usize| PointNormal {
            position: DVec3::new(number(0, i), number(1, i), number(2, i)),
            normal: if number(3, i) < 0.5 { DVec3::X } else { DVec3::Y },
        };
        let places: Vec<PointNormal> = (0..n).map(place).collect();
        let areas: Vec<f64> = (0..n).map(|i| 0.1 + number(4, i)).collect();
        let row = |i: usize| {
            let entry = |j: usize| Exchange {
                column: j as u32,
                value: areas[i] * areas[j] / (0.3 + places[i].position.distance(places[j].position)).powi(2),
                error: 0.0,
            };
            let is_there = |&j: &usize| number(5 + i as u32, j) < share;
            (i..n).filter(is_there).map(entry).collect::<Vec<_>>()
        };
        let exchange: ExchangeAreas = (0..n).map(row).collect();
        let factors = FormFactors {
            exchange,
            ends: vec![1.0; n],
            rest: vec![RowRemainder::default(); n],
            areas,
            ..FormFactors::default()
        };
        let tolerance = 10f64.powf(-exponent);
        let approximate = compressed(&(factors.clone(), places), &with(tolerance, false));
        let off = error(&approximate, &factors);
        prop_assert!(approximate.bound <= tolerance, "{} {tolerance}", approximate.bound);
        prop_assert!(off <= approximate.bound + 1e-6 || off.is_nan(), "{off} {}", approximate.bound);
    }
}

/// All that an operator says of its pairs is what its products say.
fn check_operator(name: &str, operator: &dyn FactorOperator) {
    let n = operator.row_areas().len();
    let columns = dense(operator);
    let mut pairs = vec![vec![0.0; n]; n];
    operator.for_each_pair(&mut |i, j, value| {
        assert!(i <= j && pairs[i][j] == 0.0, "{name}: {i} {j} twice");
        pairs[i][j] = value;
    });
    let own = operator.own();
    for i in 0..n {
        for j in i..n {
            let (pair, product) = (pairs[i][j], columns[j][i]);
            let close = (pair - product).abs() <= 1e-15 + 1e-12 * product.abs();
            assert!(close, "{name}: {i} {j}: {pair} {product}");
        }
        assert!((own[i] - columns[i][i]).abs() <= 1e-15, "{name}: {i}");
    }
    for lanes in [1, 2, 3, 4, 8, 9] {
        let x: Vec<f64> = (0..n * lanes).map(|k| ((k * 7) % 11) as f64).collect();
        let together = operator.exchanged_lanes(&x, lanes);
        for lane in 0..lanes {
            let numbers = |x: &[f64]| x.iter().skip(lane).step_by(lanes).copied().collect();
            let (one, product): (Vec<f64>, Vec<f64>) = (numbers(&x), numbers(&together));
            assert_eq!(
                operator.exchanged(&one),
                product,
                "{name}: {lane} of {lanes}"
            );
        }
    }
}

#[test]
fn operators_are_what_their_products_are() {
    let scene = cornell_box(CornellVariant::MirrorBlock);
    let matrix = whole(&scene, &rays(300, 512));
    check_operator("whole", &matrix.0);
    for tolerance in [0.0, 1e-2] {
        check_operator("compressed", &compressed(&matrix, &with(tolerance, false)));
        check_operator("by rays", &by_rays(&scene, &rays(300, 512), tolerance));
    }
}

#[test]
fn groups_of_blocks_are_those_of_the_matrix() {
    let scene = cornell_box(CornellVariant::MirrorBlock);
    let matrix = whole(&scene, &rays(400, 1_024));
    let approximate = compressed(&matrix, &with(0.0, false));
    // Every fifth row belongs to no group.
    let group = |i: usize| (!i.is_multiple_of(5)).then_some((i % 11) as u32);
    let groups: Vec<Option<u32>> = (0..approximate.len()).map(group).collect();
    let truth = matrix.0.grouped(&groups, 11);
    let mut rows = matrix.0.clone();
    rows.exchange = ExchangeAreas::new();
    let grouped = hierarchy::grouped(&approximate, &rows, &groups, 11, &Progress::new()).unwrap();
    assert_eq!(grouped.areas, truth.areas);
    for a in 0..11 {
        assert!((grouped.rest[a].hidden - truth.rest[a].hidden).abs() < 1e-6);
        for b in 0..11 {
            let (x, y) = (grouped.get(a, b), truth.get(a, b));
            assert!((x.0 - y.0).abs() < 1e-6 * y.0, "{a} {b}: {x:?} {y:?}");
            // Blocks know the noise of rows, not that of pairs.
            let ratio = x.1 / y.1;
            assert!((0.5..2.0).contains(&ratio), "{a} {b}: {ratio}");
        }
    }
}

#[test]
fn rows_that_see_each_other_are_connected() {
    // Two rooms, one in the other's outside.
    let mut scene = cube([(); 6].map(|()| surface(0.5, 0.0, 0.0)));
    let mut other = cube([(); 6].map(|()| surface(0.5, 0.0, 0.0)));
    for mut object in other.objects.drain(..) {
        if let azulejo_scene::Shape::Mesh(mesh) = &mut object.shape {
            mesh.positions.iter_mut().for_each(|p| *p += 3.0 * DVec3::X);
        }
        scene.objects.push(object);
    }
    let matrix = whole(&scene, &exact(600));
    let truth = matrix.0.connected();
    let mut kinds = truth.clone();
    kinds.sort_unstable();
    kinds.dedup();
    assert_eq!(kinds.len(), 2);
    for tolerance in [0.0, 1e-2] {
        let approximate = compressed(&matrix, &with(tolerance, true));
        assert_eq!(approximate.connected(), truth, "{tolerance}");
    }
    assert_eq!(by_rays(&scene, &exact(600), 1e-2).connected(), truth);
}

/// Errors that rays estimate are those against formulas, which rays do not know.
#[test]
fn stated_errors_are_the_errors() {
    let scene = cube([(); 6].map(|()| surface(0.5, 0.0, 0.0)));
    let (truth, _) = whole(&scene, &exact(2_400));
    let tracer = Tracer::new(&scene);
    for count in [256, 2_048] {
        let options = rays(2_400, count);
        let plan = Plan::new(&scene, &tracer, &options).unwrap();
        let compression = with(1e-2, true);
        let progress = Progress::new();
        let computed = StatedFactors::of(&plan.prepare(), &compression, &progress).unwrap();
        assert!(computed.stated.rows == 1_024 && computed.factors.kinds()[2] > 0);
        assert!(computed.whole_bytes as usize > computed.factors.bytes());
        let off = OperatorError::of(&computed.factors, &truth, 4, 0);
        let stated = computed.stated.product;
        eprintln!("{count}: {off:?}, {:?}", computed.stated);
        assert!(
            (stated.value - off.product).abs() <= 3.0 * stated.error,
            "{stated:?} {off:?}"
        );
        assert!(stated.error < 0.2 * stated.value, "{stated:?}");
        assert!(computed.stated.sums.value < 1e-3);
    }
    // Formulas are compressed as a whole, with errors against the whole.
    let options = exact(600);
    let plan = Plan::new(&scene, &tracer, &options).unwrap();
    let computed = StatedFactors::of(&plan.prepare(), &with(1e-3, true), &Progress::new()).unwrap();
    assert!(computed.stated.rows == 0 && computed.stated.product.value < 1e-3);
    assert!(computed.rows.exchange.is_empty() && computed.rows.len() == computed.factors.len());
}

#[test]
fn what_does_not_fit_is_by_rays_or_refused() {
    let scene = cube([(); 6].map(|()| surface(0.5, 0.0, 0.0)));
    let tracer = Tracer::new(&scene);
    let compute = |engine: Engine, memory: u64| {
        let options = FormFactorOptions {
            engine,
            memory,
            ..rays(1_500, 256)
        };
        let plan = Plan::new(&scene, &tracer, &options).unwrap();
        StatedFactors::of(&plan.prepare(), &with(1e-2, true), &Progress::new())
    };
    // The matrix alone would fit.
    let options = exact(1_500);
    let plan = Plan::new(&scene, &tracer, &options).unwrap();
    let whole = plan.prepare().forecast(&Progress::new()).unwrap();
    let computed = compute(Engine::Auto, whole.bytes + 6 * whole.pairs).unwrap();
    assert!(computed.stated.rows > 0);
    let notes = computed.rows.engine_used.notes.concat();
    assert!(notes.contains("more than the memory"), "{notes}");
    for (engine, memory) in [(Engine::Analytic, 12 << 20), (Engine::Rays, 2 << 20)] {
        let refused = compute(engine, memory).unwrap_err();
        let is_too_large = matches!(
            refused,
            CompressionError::Factors(FactorsError::TooLarge { .. })
        );
        assert!(is_too_large, "{refused}");
    }
}
