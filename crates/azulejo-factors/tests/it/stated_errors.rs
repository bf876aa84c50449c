//! Whether the truth lies within the stated errors: of what comes by mirrors and through glass, of what ends on
//! backs, and of what leaves the scene past other surfaces.

use crate::cases::cases;
use crate::scenes::{add_sheet, surface};
use azulejo_factors::form_factors::RowRemainder;
use azulejo_factors::{Closure, Engine, FormFactorOptions, FormFactors, PatchSize, form_factors};
use azulejo_scene::{Material, Scene, Up};
use azulejo_testing::closed_forms::opposed;
use azulejo_trace::{Progress, Tracer};
use glam::{DVec3, dvec3};

/// Whole faces by this many rays, without formulas and closure.
fn by_rays(rays: u32, seed: u64) -> FormFactorOptions {
    FormFactorOptions {
        engine: Engine::Rays,
        size: PatchSize::Edge(0.0),
        closure: Closure::Never,
        analytic: false,
        rays,
        seed,
        ..FormFactorOptions::default()
    }
}

fn compute(scene: &Scene, options: &FormFactorOptions) -> FormFactors {
    form_factors(scene, &Tracer::new(scene), options, &Progress::new()).expect("nobody cancels")
}

/// A floor of one unit by one, a lid half as high that looks up, and walls that look inwards.
fn lidded_box(walls: Material, lid: Material) -> Scene {
    let mut scene = Scene::default();
    let up = 0.5 * DVec3::Z;
    let floor = surface(0.5, 0.0, 0.0);
    add_sheet(&mut scene, DVec3::ZERO, DVec3::X, DVec3::Y, floor);
    add_sheet(&mut scene, up, DVec3::X, DVec3::Y, lid);
    let around = [DVec3::X, DVec3::Y, -DVec3::X, -DVec3::Y];
    let mut corner = DVec3::ZERO;
    for along in around {
        add_sheet(&mut scene, corner, up, along, walls.clone());
        corner += along;
    }
    scene
}

/// What rays find of the light on the back of a lid is uncertain, and what formulas know of the rest is not. Closure
/// moved the latter by 3%, stated 1e-7.
#[test]
fn closure_leaves_formulas_alone_where_light_ends_on_backs() {
    let grey = || surface(0.5, 0.0, 0.0);
    let scene = lidded_box(grey(), grey());
    let to_lid = opposed(1.0, 1.0, 0.5);
    for seed in 0..4 {
        let options = FormFactorOptions {
            closure: Closure::Closed,
            analytic: true,
            ..by_rays(256, seed)
        };
        let factors = compute(&scene, &options);
        assert!(factors.closed.is_some());
        for wall in 2..6 {
            let (value, error) = factors.get(0, wall);
            let off = (value - 0.25 * (1.0 - to_lid)).abs();
            assert!(off < 1e-6 && error < 1e-6, "{seed}: {value} ± {error}");
        }
        let RowRemainder {
            hidden,
            hidden_error,
            ..
        } = factors.rest[0];
        assert!((hidden - to_lid).abs() < 1e-6, "{seed}: {hidden}");
        assert!(hidden_error > 1e-3 && hidden_error < 0.05, "{hidden_error}");
    }
}

/// Share of the entries of some seeds that lie within two standard errors of those by many rays.
fn share_within_two(scene: &Scene, rays: u32, seeds: u64) -> f64 {
    let truth = compute(scene, &by_rays(1 << 17, 1_000));
    let (mut within, mut count) = (0, 0);
    for seed in 0..seeds {
        let factors = compute(scene, &by_rays(rays, seed));
        for i in 0..factors.len() {
            for e in factors.exchange.upper(i) {
                let known = truth.exchange.get(i, e.column as usize);
                let error = f64::from(e.error.hypot(known.error));
                within += usize::from((e.value - known.value).abs() <= 2.0 * error + 1e-9);
                count += 1;
            }
        }
    }
    within as f64 / count as f64
}

/// Between facing mirrors paths return to a side many times, and glass gives them more weight, so that a thousand
/// rays are fewer than a thousand hits. Errors as of this many hits had the truth in 87 to 90 of 100.
#[test]
fn mirrors_and_glass_state_their_errors() {
    let ids = ["fresnel_int_1.5", "pane_1.5", "prism_mir_12", "mir_corner"];
    for case in cases().iter().filter(|case| ids.contains(&&case.id[..])) {
        let share = share_within_two(&case.scene, 1024, 16);
        eprintln!("{}: {:.1}% within two", case.id, 100.0 * share);
        assert!(share >= 0.92, "{}: {share}", case.id);
    }
}

/// Nor are errors by mirrors much larger than needed.
#[test]
fn errors_of_mirrors_are_no_larger_than_needed() {
    let scene = lidded_box(surface(0.0, 0.9, 0.0), surface(0.5, 0.0, 0.0));
    let truth = compute(&scene, &by_rays(1 << 17, 1_000));
    let (mut squares, mut stated) = (0.0, 0.0);
    for seed in 0..16 {
        let factors = compute(&scene, &by_rays(1024, seed));
        for i in 0..factors.len() {
            for e in factors.exchange.upper(i) {
                let off = e.value - truth.exchange.get(i, e.column as usize).value;
                squares += off * off;
                stated += f64::from(e.error).powi(2);
            }
        }
    }
    let ratio = (squares / stated).sqrt();
    assert!((0.4..1.0).contains(&ratio), "{ratio}");
}

#[test]
fn what_mirrors_add_to_errors_is_the_same_for_any_threads() {
    let scene = lidded_box(surface(0.0, 1.0, 0.0), Material::pane("pane", 1.5));
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads start")
            .install(|| compute(&scene, &by_rays(512, 3)))
    };
    assert!(with(1) == with(3));
}

/// Two walls in a corner, a screen that touches both of its neighbours, and a sheet below it that cuts what they see
/// of each other: half of the sky and half of the ground, less what is in front. The part above the horizon of what
/// is partly hidden was 0.0003 instead of 0.0007, stated 0.00004.
#[test]
fn the_sky_past_screens_that_touch_walls() {
    let mut scene = Scene::default();
    scene.units.up = Up::Z;
    let grey = || surface(0.5, 0.0, 0.0);
    add_sheet(&mut scene, DVec3::ZERO, DVec3::Y, DVec3::Z, grey());
    add_sheet(&mut scene, DVec3::ZERO, DVec3::Z, DVec3::X, grey());
    let screen = dvec3(0.5, 0.0, 0.0);
    add_sheet(&mut scene, screen, 0.5 * DVec3::Y, DVec3::Z, grey());
    let sheet = dvec3(0.2, 0.2, 0.5);
    let edge = dvec3(0.0, 0.6, 0.1);
    add_sheet(&mut scene, sheet, 0.6 * DVec3::X, edge, grey());
    let formulas = FormFactorOptions {
        engine: Engine::Analytic,
        ..by_rays(1 << 10, 0)
    };
    let exact = compute(&scene, &formulas);
    let rays = compute(&scene, &by_rays(1 << 20, 0));
    assert_eq!(exact.rays, 0);
    for (i, (exact, rays)) in exact.rest.iter().zip(&rays.rest).enumerate() {
        for (a, b) in [
            ((exact.sky, exact.sky_error), (rays.sky, rays.sky_error)),
            (
                (exact.ground, exact.ground_error),
                (rays.ground, rays.ground_error),
            ),
        ] {
            let bound = 3.0 * a.1.hypot(b.1) + 1e-9;
            assert!((a.0 - b.0).abs() < bound, "{i}: {exact:?} {rays:?}");
            assert!(a.1 < 2e-4 && b.1 < 3e-4, "{i}: {exact:?} {rays:?}");
        }
    }
}
