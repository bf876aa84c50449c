//! Light by hemicubes.

use crate::rooms::*;
use azulejo_factors::{Engine, FaceId, Hemicube, PatchSize};
use azulejo_radiosity::FirstPass;

/// Both engines that render item buffers.
fn both(resolution: u32, points: u32) -> [Engine; 2] {
    let hemicube = || Hemicube {
        resolution,
        points,
        ..Hemicube::default()
    };
    [Engine::Hemicube(hemicube()), Engine::Hybrid(hemicube())]
}

/// The same radiosity by both engines, with direct light by formula, also through mirrors.
#[test]
fn solutions_agree() {
    let rho = [0.5, 0.7, 0.0, 0.3, 0.6, 0.6];
    let mirror = |k| if k == 2 { 0.9 } else { 0.0 };
    let scene = cube(std::array::from_fn(|k| {
        surface(rho[k], mirror(k), f64::from(k == 0))
    }));
    // One unknown per side: the limit of the mean over many seeds.
    let truth = [
        1.126177557827,
        0.330986588078,
        0.0,
        0.1403257871934,
        0.2713020253403,
    ];
    for engine in both(48, 16) {
        let solve = |seed| {
            let pass = FirstPass {
                engine: engine.clone(),
                seed,
                ..rays(64)
            };
            Matrix::solve(&scene, &pass)
        };
        let solved: Vec<Matrix> = (0..32).map(solve).collect();
        for k in [0, 1, 3, 4] {
            let patch = cube_face(k) as usize;
            let each: Vec<f64> = solved.iter().map(|m| m.radiosity(patch, true).0).collect();
            check(
                &format!("B of side {k}"),
                spread(&each),
                truth[k],
                4e-3,
                3e-4,
            );
        }
    }
}

/// A lamp too far down a chain of mirrors for formulas is found by pixels, once.
#[test]
fn light_of_lamps_is_counted_once() {
    for walls in [vec![], vec![2], vec![2, 3, 4]] {
        let mut scene = cube(std::array::from_fn(|k| {
            if walls.contains(&k) {
                surface(0.0, 0.8, 0.0)
            } else {
                surface(0.5, 0.0, 0.0)
            }
        }));
        scene.materials[1] = surface(0.5, 0.0, 1.0);
        let h = |engine: &Engine| {
            let pass = FirstPass {
                engine: engine.clone(),
                size: PatchSize::Count(24),
                ..rays(1024)
            };
            let solved = Matrix::solve(&scene, &pass);
            let face = FaceId {
                object: 0,
                face: cube_face(0),
            };
            solved.irradiance(solved.patches.patches_of_face(face), true)
        };
        let truth = h(&Engine::Rays);
        for engine in both(32, 32) {
            let found = h(&engine);
            eprintln!("{walls:?}: {found:?}, rays {truth:?}");
            assert!((found.0 - truth.0).abs() < 6e-3 * truth.0);
        }
    }
}
