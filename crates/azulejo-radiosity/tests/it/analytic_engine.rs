//! Light by the analytic engine.

use crate::rooms;
use azulejo_factors::Engine;
use azulejo_radiosity::FirstPass;
use glam::{DVec3, dvec3};

/// Solutions from rows by the analytic engine and by rays agree.
#[test]
fn solutions_by_formulas_and_rays_agree() {
    let grey = |exitance| rooms::surface(0.5, 0.0, exitance);
    let mirror = rooms::surface(0.0, 0.9, 0.0);
    let mut scene = rooms::cube([
        grey(1.0),
        grey(0.0),
        mirror,
        grey(0.0),
        grey(0.0),
        grey(0.0),
    ]);
    let plate = grey(0.0);
    let corner = dvec3(0.3, 0.3, 0.5);
    rooms::add_sheet(&mut scene, corner, 0.4 * DVec3::X, 0.4 * DVec3::Y, plate);
    let solve = |engine: Engine| {
        let pass = FirstPass {
            engine,
            ..rooms::rays(1 << 14)
        };
        rooms::Matrix::solve(&scene, &pass)
    };
    let (formulas, rays) = (solve(Engine::Analytic), solve(Engine::Rays));
    for patch in 0..formulas.patches.len() {
        for front in [true, false] {
            let ((a, e), (b, f)) = (
                formulas.radiosity(patch, front),
                rays.radiosity(patch, front),
            );
            let error = e.hypot(f).max(2e-3 * b);
            assert!(
                (a - b).abs() <= 5.0 * error,
                "{patch} {front}: {a} ± {e}, {b} ± {f}"
            );
        }
    }
}
