//! The first pass run in parts on scenes with known answers.

pub use crate::scenes::*;
use azulejo_factors::estimator::Estimator;
use azulejo_factors::reflectances;
use azulejo_factors::row::Columns;
use azulejo_radiosity::system::{RadiositySolution, System};
use azulejo_radiosity::{Estimate, FirstPass, PatchSize, Patches, PointNormal, probe};
use azulejo_scene::{Rgb, Scene};
use azulejo_trace::sampling::uniform;
use azulejo_trace::{Gatherer, Progress, Run, Surfaces, Tracer};
use glam::{DVec3, dvec3};

/// Works on this many threads of its own: those that all tests share may first do what others wait for.
pub fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("threads start").install(work)
}

/// `rays` per patch and point, whole faces as patches.
pub fn rays(rays: u32) -> FirstPass {
    FirstPass {
        rays: Some(rays),
        size: PatchSize::Edge(0.0),
        ..FirstPass::default()
    }
}

/// The patches of a scene and the light on them, by the matrix.
pub struct Matrix {
    pub patches: Patches,
    pub found: RadiositySolution,
    reflectance: Vec<Rgb>,
    exitance: Vec<f64>,
}

impl Matrix {
    pub fn solve(scene: &Scene, pass: &FirstPass) -> Matrix {
        let tracer = Tracer::new(scene);
        let patches = Patches::new(scene, pass.size);
        let gatherer = Gatherer::new(Surfaces::new(scene, &tracer));
        let reflectance = reflectances(scene, &patches);
        let (rays, seed) = (pass.rays.unwrap_or(256), pass.seed as u32);
        let progress = Progress::new();
        let engine = &pass.engine;
        let estimator = Estimator::new(engine, &gatherer, &patches, rays, seed, Columns::Diffuse);
        let system = System::trace(
            &gatherer,
            &patches,
            &reflectance,
            &estimator,
            seed,
            Run::alone(&progress),
        );
        let system = system.unwrap().expect("there is no deadline");
        let found = system.solve_all(pass.bounces).unwrap();
        let exitance = |p: usize| {
            scene.materials[patches.material(p) as usize]
                .exitance()
                .mean()
        };
        let exitance = (0..patches.len()).map(exitance).collect();
        Matrix {
            patches,
            found,
            reflectance,
            exitance,
        }
    }

    /// Radiosity of one side of a patch with its standard error.
    pub fn radiosity(&self, patch: usize, front: bool) -> (f64, f64) {
        let side = 2 * patch + usize::from(!front);
        let exitance = if front { self.exitance[patch] } else { 0.0 };
        let each: Vec<f64> = self
            .found
            .solutions
            .iter()
            .map(|x| exitance + x[side].mean())
            .collect();
        spread(&each)
    }

    /// Irradiance on one side of patches, averaged by area, with its standard error; the patches
    /// must reflect.
    pub fn irradiance(&self, patches: std::ops::Range<usize>, front: bool) -> (f64, f64) {
        let mean = |x: &Vec<Rgb>| {
            let of = |p: usize| {
                x[2 * p + usize::from(!front)].mean() / self.reflectance[p].mean()
                    * self.patches.area(p)
            };
            patches.clone().map(of).sum::<f64>()
                / patches.clone().map(|p| self.patches.area(p)).sum::<f64>()
        };
        spread(&self.found.solutions.iter().map(mean).collect::<Vec<f64>>())
    }
}

/// Radiosity of the fronts of `patches` over 256 seeds, each with its standard error: where whole
/// faces are patches, the few positions of direct light per seed dominate the noise.
pub fn radiosities(scene: &Scene, patches: &[usize], rays_per_patch: u32) -> Vec<(f64, f64)> {
    let solve = |seed| {
        Matrix::solve(
            scene,
            &FirstPass {
                seed,
                ..rays(rays_per_patch)
            },
        )
    };
    let solved: Vec<Matrix> = (0..256).map(solve).collect();
    let balance: Vec<f64> = solved.iter().map(|m| m.found.balance.error()).collect();
    assert!(balance.iter().all(|&e| e < 0.05), "balances: {balance:?}");
    let of = |&p: &usize| {
        spread(
            &solved
                .iter()
                .map(|m| m.radiosity(p, true).0)
                .collect::<Vec<f64>>(),
        )
    };
    patches.iter().map(of).collect()
}

/// Irradiance at points.
pub fn irradiance(scene: &Scene, points: &[PointNormal], pass: &FirstPass) -> Vec<Estimate> {
    probe(scene, &Tracer::new(scene), points, pass, &Progress::new())
        .unwrap()
        .estimates
}

/// The grey value of an estimate with its raw standard error.
pub fn grey(e: &Estimate) -> (f64, f64) {
    (e.value.mean(), e.error.mean())
}

/// A point with a normal.
pub fn at(x: f64, y: f64, z: f64, normal: DVec3) -> PointNormal {
    PointNormal {
        position: dvec3(x, y, z),
        normal,
    }
}

/// Points distributed over the six sides of the unit cube, away from its edges.
pub fn points_on_cube(count: u32) -> Vec<PointNormal> {
    let point = |k: u32| {
        let [a, b] = [0, 1].map(|d| 0.01 + 0.98 * f64::from(uniform(&[k, d])));
        match k % 6 {
            0 => at(a, b, 0.0, DVec3::Z),
            1 => at(a, b, 1.0, -DVec3::Z),
            2 => at(0.0, a, b, DVec3::X),
            3 => at(1.0, a, b, -DVec3::X),
            4 => at(a, 0.0, b, DVec3::Y),
            _ => at(a, 1.0, b, -DVec3::Y),
        }
    };
    (0..count).map(point).collect()
}
