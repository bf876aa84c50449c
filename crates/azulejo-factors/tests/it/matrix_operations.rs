//! Operations on matrices of form factors: closure, truncation, groups, separate orders, and
//! resumption after an interruption.

use azulejo_factors::form_factors::{Exchange, ExchangeAreas, Plan, RowRemainder};
use azulejo_factors::{
    Closure, Engine, FaceId, FactorsError, FormFactorOptions, FormFactors, PatchSize, form_factors,
};
use azulejo_scene::synthetic::{CornellVariant, cornell_box, cube_room};
use azulejo_scene::{Material, Rgb, Scene, Shape};
use azulejo_trace::{Blocks, Progress, Run, RunRole, RunStage, Tracer};
use proptest::prelude::*;
use std::collections::HashMap;
use std::sync::Mutex;

const FACE: FaceId = FaceId { object: 0, face: 0 };

/// A matrix of these pairs (i ≤ j, S, relative error) and rows (area, sky, error of the sky).
fn matrix(pairs: &HashMap<(usize, usize), (f64, f64)>, rows: &[(f64, f64, f64)]) -> FormFactors {
    let upper = |i: usize| {
        let pair = |j: usize| {
            let &(value, error) = pairs.get(&(i, j))?;
            Some(Exchange {
                column: j as u32,
                value,
                error: (error * value) as f32,
            })
        };
        (i..rows.len()).filter_map(pair).collect::<Vec<_>>()
    };
    let rest = |&(_, sky, sky_error): &(f64, f64, f64)| RowRemainder {
        sky,
        sky_error,
        ..RowRemainder::default()
    };
    FormFactors {
        exchange: (0..rows.len()).map(upper).collect(),
        areas: rows.iter().map(|r| r.0).collect(),
        faces: vec![FACE; rows.len()],
        materials: vec![0; rows.len()],
        is_back: vec![false; rows.len()],
        rest: rows.iter().map(rest).collect(),
        ends: vec![1.0; rows.len()],
        ..FormFactors::default()
    }
}

/// Random sparse symmetric matrices.
fn any_matrix() -> impl Strategy<Value = FormFactors> {
    let rows = prop::collection::vec((0.1..10.0f64, 0.01..0.5f64, 1e-3..0.05f64), 2..25);
    rows.prop_flat_map(|rows| {
        let n = rows.len();
        // Sizes over four decades: some pairs are small compared with others.
        let size = (-4.0..0.0f64).prop_map(|x| 10f64.powf(x));
        let pair = ((0..n, 0..n), (size, 1e-3..0.3f64));
        let pairs = prop::collection::vec(pair, 1..n * n);
        (pairs, Just(rows)).prop_map(|(pairs, rows)| {
            let upper = pairs
                .into_iter()
                .map(|((i, j), s)| ((i.min(j), i.max(j)), s));
            matrix(&upper.collect(), &rows)
        })
    })
}

fn close_to(a: &[f64], b: &[f64], tolerance: f64) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= tolerance)
}

/// Whether the two halves of the matrix agree, to the rounding of a division.
fn is_reciprocal(m: &FormFactors) -> bool {
    let rows = m.rows(0..m.len());
    let mut entries = rows
        .iter()
        .enumerate()
        .flat_map(|(i, row)| row.iter().map(move |e| (i, e)));
    entries.all(|(i, &(j, x, _))| {
        let there = x * m.areas[i];
        let back = m.get(j as usize, i as u32).0 * m.areas[j as usize];
        x > 0.0 && (there - back).abs() <= 4.0 * f64::EPSILON * there
    })
}

proptest! {
    #[test]
    fn truncation_keeps_sums_and_reciprocity(mut m in any_matrix(), share in 1e-4..0.3f64) {
        let (before, sums) = (m.clone(), m.row_sums());
        m.truncate(share, &Progress::new()).unwrap();
        prop_assert!(is_reciprocal(&m));
        let scale = sums.iter().fold(1.0, |a: f64, &b| a.max(b));
        prop_assert!(close_to(&m.row_sums(), &sums, 3e-12 * scale), "{:?}", m.truncated);
        let done = m.truncated.unwrap();
        prop_assert_eq!((done.before, done.after), (before.exchange.entries(), m.exchange.entries()));
        prop_assert!(done.after <= done.before);
        prop_assert_eq!(done.dropped > 0.0, done.after < done.before);
        // What is dropped is small, and nothing large is dropped.
        for i in 0..m.len() {
            for e in before.exchange.upper(i) {
                let j = e.column as usize;
                let is_small = e.value < share * m.areas[i].min(m.areas[j]);
                let is_there = m.exchange.get(i, j).value > 0.0;
                prop_assert!(is_there || is_small, "{i} {j}");
            }
        }
    }

    #[test]
    fn closure_completes_rows(mut m in any_matrix()) {
        // Rows that sum to about 1, so that little has to change.
        let sums = m.row_sums();
        for (i, sum) in sums.iter().enumerate() {
            m.rest[i].sky = (1.01 - sum).max(0.0);
        }
        let before = m.clone();
        m.close(&Progress::new()).unwrap();
        // No entry falls below a tenth of its value, even if its row stays incomplete.
        let is_cut = |(i, e): (usize, &Exchange)| {
            m.exchange.get(i, e.column as usize).value < 0.1001 * e.value
        };
        let mut upper = (0..m.len()).flat_map(|i| before.exchange.upper(i).iter().map(move |e| (i, e)));
        let is_possible = sums.iter().all(|&s| s < 1.0) && !upper.any(is_cut);
        prop_assert!(is_reciprocal(&m));
        let lacks = |i: usize, sum: f64| (sum + m.rest[i].sum() - 1.0).abs();
        let worst = m.row_sums().iter().enumerate().map(|(i, &s)| lacks(i, s)).fold(0.0, f64::max);
        let closed = m.closed.unwrap();
        let seen = m.row_sums().iter().enumerate().filter(|(_, s)| **s > 0.0)
            .map(|(i, &s)| lacks(i, s)).fold(0.0, f64::max);
        prop_assert!((seen - closed.deficit).abs() <= 1e-12, "{seen} {closed:?}");
        prop_assert!(!is_possible || worst <= 1e-8, "{worst} {closed:?}");
    }

    #[test]
    fn groups_are_sums(m in any_matrix(), seed in 0..1000usize) {
        let count = 1 + seed % 5;
        let group = |i: usize| match (i * 7 + seed) % (count + 1) {
            g if g == count => None,
            g => Some(g as u32),
        };
        let groups: Vec<_> = (0..m.len()).map(group).collect();
        let g = m.grouped(&groups, count);
        prop_assert!(is_reciprocal(&g));
        let (mut sums, mut variances) = (vec![vec![0.0; count]; count], vec![vec![0.0; count]; count]);
        for (i, row) in m.exchange.rows(0..m.len()).into_iter().enumerate() {
            for e in row {
                if let (Some(a), Some(b)) = (groups[i], groups[e.column as usize]) {
                    let (a, b) = (a as usize, b as usize);
                    sums[a][b] += e.value;
                    let once = if a == b && i != e.column as usize { 2.0 } else { 1.0 };
                    variances[a][b] += once * f64::from(e.error).powi(2);
                }
            }
        }
        for a in 0..count {
            for b in 0..count {
                let entry = g.exchange.get(a, b);
                prop_assert!((entry.value - sums[a][b]).abs() <= 1e-12 * (1.0 + sums[a][b]));
                let error = variances[a][b].sqrt();
                prop_assert!((f64::from(entry.error) - error).abs() <= 1e-5 * error);
            }
        }
        // What arrives at rows without a group is hidden, and nothing is missing.
        let rows = m.ended().into_iter().zip(&m.rest).map(|(e, r)| e + r.sum());
        let whole: Vec<f64> = rows.collect();
        for (a, ended) in g.ended().into_iter().enumerate() {
            let members = (0..m.len()).filter(|&i| groups[i] == Some(a as u32));
            let total: f64 = members.map(|i| whole[i] * m.areas[i]).sum();
            let group = (ended + g.rest[a].sum()) * g.areas[a];
            prop_assert!((group - total).abs() <= 1e-10 * (1.0 + total), "{group} {total}");
        }
    }
}

fn options(edge: f64, rays: u32) -> FormFactorOptions {
    FormFactorOptions {
        engine: Engine::Rays,
        size: PatchSize::Edge(edge),
        rays,
        ..FormFactorOptions::default()
    }
}

fn compute(scene: &Scene, options: &FormFactorOptions) -> FormFactors {
    form_factors(scene, &Tracer::new(scene), options, &Progress::new()).unwrap()
}

/// The cube with a grey mirror on one wall, which also reflects diffusely.
fn mirror_room(mirror: Rgb) -> Scene {
    let mut scene = cube_room();
    let wall = scene.add_material(Material {
        diffuse: Rgb::grey(0.3),
        mirror,
        ..Material::default()
    });
    let Shape::Mesh(mesh) = &mut scene.objects[0].shape else {
        panic!("the cube is a mesh")
    };
    mesh.face_materials[0] = wall;
    mesh.face_materials[1] = wall;
    scene
}

#[test]
fn orders_add_up_to_the_whole() {
    let scene = mirror_room(Rgb::grey(0.5));
    let separate = FormFactorOptions {
        separate: true,
        ..options(0.25, 1 << 12)
    };
    let (apart, whole) = (
        compute(&scene, &separate),
        compute(&scene, &options(0.25, 1 << 12)),
    );
    assert_eq!(apart.orders.len(), 3);
    assert_eq!(ExchangeAreas::sum_of(&apart.orders), apart.exchange);
    for i in 0..whole.len() {
        for (j, x, error) in whole.row(i) {
            let (sum, _) = apart.get(i, j);
            assert!(
                (sum - x).abs() <= 0.01 * f64::from(error) + 1e-9,
                "{i} {j}: {sum} {x}"
            );
        }
    }
    // Light by one mirror is half as strong between the mirrors, and comes from farther away.
    let total = |order: usize| apart.orders[order].row_sums().iter().sum::<f64>();
    assert!(total(0) > total(1) && total(1) > total(2) && total(2) > 0.0);
    // The orders change with closure and truncation.
    let mut closed = apart.clone();
    closed.close(&Progress::new()).unwrap();
    closed.truncate(2e-3, &Progress::new()).unwrap();
    assert_eq!(ExchangeAreas::sum_of(&closed.orders), closed.exchange);
    let truncated = closed.truncated.unwrap();
    assert!(truncated.after < truncated.before && truncated.moved.deficit < 1e-12);
    for (i, ended) in closed.ended().iter().enumerate() {
        let sum = ended + closed.rest[i].sum();
        assert!((sum - 1.0).abs() < 1e-8, "{sum}");
    }
}

/// As matrices of other programs, whose errors nobody knows.
#[test]
fn without_any_error_all_entries_may_change() {
    let pairs = HashMap::from([
        ((0, 1), (0.97, 0.0)),
        ((0, 2), (1.05, 0.0)),
        ((1, 2), (0.2, 0.0)),
    ]);
    let mut m = matrix(&pairs, &[(2.0, 0.0, 0.0), (1.2, 0.0, 0.0), (1.2, 0.0, 0.0)]);
    m.close(&Progress::new()).unwrap();
    for ended in m.ended() {
        assert!((ended - 1.0).abs() < 1e-8, "{ended}");
    }
    assert!(is_reciprocal(&m));
    // One that has an error takes all of the change.
    let mut one: HashMap<_, _> = pairs.clone();
    one.insert((0, 1), (0.97, 0.01));
    let mut m = matrix(&one, &[(2.0, 0.0, 0.0), (1.15, 0.0, 0.0), (1.25, 0.0, 0.0)]);
    m.close(&Progress::new()).unwrap();
    assert_eq!(m.exchange.get(0, 2).value, 1.05);
    assert!((m.exchange.get(0, 1).value - 0.95).abs() < 1e-9);
}

/// Materials that nothing is made of, as editors leave them in files, change nothing.
#[test]
fn unused_materials_do_not_prevent_closure() {
    let plain = cube_room();
    let mut listed = plain.clone();
    listed.add_material(Material::mirror("unused", Rgb::new(0.9, 0.5, 0.1)));
    listed.add_material(Material::dielectric("unused too", 1.5));
    for closure in [Closure::Closed, Closure::Always] {
        let options = FormFactorOptions {
            closure,
            size: PatchSize::Count(60),
            ..options(0.0, 1 << 8)
        };
        let [plain, listed] = [&plain, &listed].map(|scene| compute(scene, &options));
        assert!(plain.closed.is_some() && plain == listed);
    }
}

#[test]
fn closure_never_silently() {
    let always = |closure| FormFactorOptions {
        closure,
        size: PatchSize::Count(100),
        ..options(0.0, 1 << 10)
    };
    let check = |scene: &Scene, closure, expected: bool| {
        let factors = compute(scene, &always(closure));
        let rows = factors.ended().into_iter().zip(&factors.rest);
        let off = rows
            .filter(|(ended, _)| *ended > 0.0)
            .map(|(ended, rest)| (ended + rest.sum() - 1.0).abs())
            .fold(0.0, f64::max);
        assert_eq!(factors.closed.is_some(), expected);
        assert_eq!(off < 1e-8, expected, "{off}");
        if let Some(moved) = factors.closed {
            assert!(moved.total > 0.0 && moved.mean <= moved.most && moved.most < 0.5);
            assert!(moved.deficit < 1e-8);
        }
        factors
    };
    check(&cube_room(), Closure::Closed, true);
    check(&cube_room(), Closure::Never, false);
    let open = cornell_box(CornellVariant::Diffuse);
    check(&open, Closure::Closed, false);
    let factors = check(&open, Closure::Always, true);
    assert!(!factors.is_closed && factors.rest.iter().any(|r| r.sky > 0.01 && r.ground > 0.01));
    let mirrors = mirror_room(Rgb::grey(0.5));
    check(&mirrors, Closure::Closed, false);
    check(&mirrors, Closure::Always, true);
    let coloured = mirror_room(Rgb::new(0.5, 0.4, 0.3));
    let factors = compute(&coloured, &always(Closure::Always));
    assert!(
        factors.closed.is_none()
            && factors
                .engine_used
                .notes
                .iter()
                .any(|n| n.contains("coloured"))
    );
}

#[test]
fn the_sky_above_a_wall() {
    // A floor with a square wall on each of two opposite sides: sky above, ground beside.
    let scene = {
        let mut scene = cube_room();
        let Shape::Mesh(mesh) = &mut scene.objects[0].shape else {
            panic!("the cube is a mesh")
        };
        let kept: Vec<Vec<u32>> = (0..mesh.faces.len())
            .filter(|&f| mesh.face_area_vector(f).dot(scene.units.up.axis()) >= -0.5)
            .map(|f| mesh.faces.get(f).to_vec())
            .collect();
        mesh.faces = Default::default();
        mesh.face_materials.clear();
        kept.iter().for_each(|f| mesh.push_face(f, 0));
        scene
    };
    let whole = FormFactorOptions {
        two_sided: true,
        ..options(0.0, 1 << 12)
    };
    let factors = compute(&scene, &whole);
    assert_eq!(factors.len(), 10);
    // From the floor the open top is the facing square, 0.1998; walls see it as a neighbour.
    let (opposite, adjacent) = (0.19982489569839, 0.20004377607540);
    let floor = (0..10).find(|&i| {
        !factors.is_back[i] && factors.rest[i].sky > 0.0 && {
            (factors.rest[i].sky - opposite).abs() < 4.0 * factors.rest[i].sky_error
                && factors.row(i).count() == 4
        }
    });
    assert!(floor.is_some(), "{:?}", factors.rest);
    for i in (0..10).filter(|&i| !factors.is_back[i]) {
        let rest = factors.rest[i];
        let known = [opposite, adjacent].map(|x| (rest.sky - x).abs() <= 4.0 * rest.sky_error);
        assert!(known.contains(&true) && rest.sky_error < 8e-3, "{rest:?}");
        assert_eq!((rest.ground, rest.ground_error), (0.0, 0.0));
    }
    // From outside, walls see half sky, half ground, and the floor's back the ground alone.
    for i in (0..10).filter(|&i| factors.is_back[i]) {
        let rest = factors.rest[i];
        let half = (rest.sky - 0.5).abs() <= 4.0 * rest.sky_error;
        assert!(
            half || (rest.sky, rest.ground, rest.ground_error) == (0.0, 1.0, 0.0),
            "{rest:?}"
        );
    }
}

/// Stores blocks in memory, and cancels the work after this many.
struct Interrupting<'a> {
    blocks: Mutex<HashMap<(RunStage, usize), Vec<u8>>>,
    progress: &'a Progress,
    at: usize,
}

impl Blocks for Interrupting<'_> {
    fn role(&self) -> RunRole {
        RunRole {
            is_kept: true,
            ..RunRole::default()
        }
    }

    fn load(&self, stage: RunStage, block: usize) -> Option<Vec<u8>> {
        self.blocks.lock().unwrap().get(&(stage, block)).cloned()
    }

    fn save(&self, stage: RunStage, block: usize, bytes: &[u8]) {
        let mut blocks = self.blocks.lock().unwrap();
        blocks.insert((stage, block), bytes.to_vec());
        if blocks.len() >= self.at {
            self.progress.cancel();
        }
    }
}

#[test]
fn interrupted_work_resumes_to_the_same_bits() {
    let mirrors = FormFactorOptions {
        separate: true,
        ..options(0.09, 64)
    };
    check_interrupted(&mirror_room(Rgb::grey(0.5)), &mirrors, &[1, 2, 3]);
    let formulas = FormFactorOptions {
        engine: Engine::Analytic,
        ..options(0.05, 64)
    };
    check_interrupted(&cube_room(), &formulas, &[1, 2]);
}

/// Work that is cancelled when it has some numbers of blocks, and resumed each time.
fn check_interrupted(scene: &Scene, options: &FormFactorOptions, cuts: &[usize]) {
    let tracer = Tracer::new(scene);
    let plan = Plan::new(scene, &tracer, options).unwrap();
    let prepared = plan.prepare();
    let whole = prepared.compute(&Progress::new()).unwrap();
    let mut blocks = HashMap::new();
    for &at in cuts.iter().chain(&[usize::MAX]) {
        let progress = Progress::new();
        let kept = Interrupting {
            blocks: Mutex::new(blocks),
            progress: &progress,
            at,
        };
        let result = prepared.compute(Run::new(&kept, &progress));
        blocks = kept.blocks.into_inner().unwrap();
        if at < usize::MAX {
            assert_eq!(result, Err(FactorsError::Cancelled));
            assert!(blocks.len() >= at, "what was computed at once is kept");
        } else {
            assert!(result.unwrap() == whole && blocks.len() > cuts.len());
        }
    }
}

#[test]
fn what_does_not_fit_is_refused_before_it_begins() {
    let scene = cube_room();
    let tracer = Tracer::new(&scene);
    let refused = |size, memory| {
        let options = FormFactorOptions {
            size,
            memory,
            ..options(0.0, 256)
        };
        form_factors(&scene, &tracer, &options, &Progress::new()).unwrap_err()
    };
    // Not even the patches fit, and they are not created.
    let message = refused(PatchSize::Count(1_000_000_000), 1 << 30).to_string();
    assert!(
        message.contains("1000000000 patches") && message.contains("1.0 GiB"),
        "{message}"
    );
    let few = refused(PatchSize::Count(2_000), 2 << 20);
    assert!(matches!(few, FactorsError::TooLarge { bytes, .. } if bytes > 2 << 20));
}

#[test]
fn forecasts_are_near_what_comes() {
    let by_rays = Engine::Rays;
    for (scene, rays, engine) in [
        (cube_room(), 256, &by_rays),
        (cube_room(), 4_096, &by_rays),
        (cornell_box(CornellVariant::Diffuse), 1_024, &by_rays),
        (cornell_box(CornellVariant::Diffuse), 64, &Engine::Analytic),
        (mirror_room(Rgb::grey(0.5)), 1_024, &by_rays),
    ] {
        let tracer = Tracer::new(&scene);
        let options = FormFactorOptions {
            engine: engine.clone(),
            size: PatchSize::Count(1_500),
            analytic: false,
            ..options(0.0, rays)
        };
        let plan = Plan::new(&scene, &tracer, &options).unwrap();
        let prepared = plan.prepare();
        let forecast = prepared.forecast(&Progress::new()).unwrap();
        let factors = prepared.compute(&Progress::new()).unwrap();
        let ratio = forecast.pairs as f64 / factors.exchange.pairs() as f64;
        eprintln!(
            "{} rows, {rays} rays: pairs stated/true {ratio:.2}",
            factors.len()
        );
        assert_eq!(forecast.rows, factors.len());
        assert!((0.8..2.5).contains(&ratio), "{ratio}");
    }
}
