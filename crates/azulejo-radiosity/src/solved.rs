//! The light on patches, before it is gathered.

use crate::gather::Gathering;
use crate::light::PatchLight;
use crate::particles::{self, ParticleEffort};
use crate::refine::{RefinementWork, refine};
use crate::solve::{Estimate, FirstPass, Method, Report, SolveError};
use crate::stochastic;
use crate::system::{RadiositySolution, System};
use azulejo_factors::engine::Estimator;
use azulejo_factors::row::Columns;
use azulejo_factors::{Engine, EngineChoice, EngineUsed, Patches, ProxyScene, reflectances};
use azulejo_scene::{Rgb, Scene};
use azulejo_trace::sampling::hash;
use azulejo_trace::{Gathered, Gatherer, Measure, Progress, Surfaces, Tracer};
use std::f64::consts::PI;

/// The radiosity of every patch.
pub struct PatchRadiosity {
    /// The patches.
    pub patches: Patches,
    /// Radiosity of every [side](azulejo_factors::row::side) of a patch, emission included, W/m².
    pub sides: Vec<Estimate>,
    /// Statistics and error of the solution.
    pub report: Report,
}

/// Radiosity of the patches of a scene: the light that [`solve`](crate::solve()) gathers to the
/// vertices.
///
/// # Errors
/// As [`solve`](crate::solve()).
pub fn radiosity(
    scene: &Scene,
    tracer: &Tracer,
    pass: &FirstPass,
    progress: &Progress,
) -> Result<PatchRadiosity, SolveError> {
    let proxy = ProxyScene::new(scene, tracer, pass.size);
    let solved = SolvedPatches::new(&proxy, pass, progress, &mut |_, _| ())?;
    let nothing = Gathering {
        gathered: Vec::new(),
        spent: Vec::new(),
    };
    let mut report = solved.report(&nothing);
    report.error = report.patch_error;
    Ok(PatchRadiosity {
        sides: solved.radiosity(),
        report,
        patches: solved.patches,
    })
}

/// Patches with the light on them, before it is gathered.
pub(crate) struct SolvedPatches<'a> {
    pub gatherer: Gatherer<'a>,
    pub patches: Patches,
    reflectance: Vec<Rgb>,
    pub solution: RadiositySolution,
    spent: RefinementWork,
    method: Method,
    engine_used: EngineUsed,
}

/// Called with a solution that is about to be refined.
pub(crate) type CoarseCallback<'a> = &'a mut dyn FnMut(&Patches, &RadiositySolution);

impl<'a> SolvedPatches<'a> {
    pub fn new(
        proxy: &'a ProxyScene,
        pass: &FirstPass,
        progress: &Progress,
        watch: CoarseCallback,
    ) -> Result<SolvedPatches<'a>, SolveError> {
        let (scene, tracer) = (proxy.scene.as_ref(), proxy.tracer.as_ref());
        if !scene.has_light() {
            return Err(SolveError::NoLight);
        }
        let patches = Patches::new(scene, pass.size);
        if patches.is_empty() {
            return Err(SolveError::NoSurface);
        }
        let gatherer = Gatherer::new(Surfaces::new(scene, tracer));
        let reflectance = reflectances(scene, &patches);
        let (seed, rays) = (hash(&[pass.key(), 0]), pass.patch_rays());
        // Entries of eight bytes, hardly more of them than rays.
        let expected = patches.len() as u64 * u64::from(rays) * 8;
        let parts = SolverInputs {
            gatherer: &gatherer,
            patches: &patches,
            reflectance: &reflectance,
            rays,
            seed,
        };
        let (solution, spent, method, engine_used) = if pass.engine == Engine::Particles {
            let (solution, engine_used) = parts.particles(pass, progress)?;
            (
                solution,
                RefinementWork::default(),
                Method::Stochastic,
                engine_used,
            )
        } else if expected <= pass.memory {
            let (solution, spent, engine_used) = parts.matrix(pass, progress, watch)?;
            (solution, spent, Method::Matrix, engine_used)
        } else {
            let solution = stochastic::solve(
                &gatherer,
                &patches,
                &reflectance,
                rays,
                pass.bounces,
                seed,
                progress,
            )?;
            (
                solution,
                RefinementWork::default(),
                Method::Stochastic,
                parts.shot(pass, expected),
            )
        };
        progress.measured(Measure::PatchError(solution.error(&patches)));
        Ok(SolvedPatches {
            gatherer,
            patches,
            reflectance,
            solution,
            spent,
            method,
            engine_used,
        })
    }

    /// B of every side with its standard error.
    fn radiosity(&self) -> Vec<Estimate> {
        let materials = &self.gatherer.surfaces().scene.materials;
        let estimate = |s: usize| {
            let solutions = &self.solution.solutions;
            let of = |r: usize| solutions[r % solutions.len()][s];
            let reflected = Gathered {
                replicates: std::array::from_fn(of),
            };
            let material = &materials[self.patches.material(s / 2) as usize];
            let emitted = material.emission_from(s.is_multiple_of(2)) * PI;
            Estimate {
                value: emitted + reflected.mean(),
                error: reflected.standard_error(),
            }
        };
        (0..2 * self.patches.len()).map(estimate).collect()
    }

    pub fn light(&self, pass: &FirstPass) -> PatchLight<'_> {
        let light = PatchLight::new(
            self.gatherer.surfaces(),
            &self.patches,
            &self.reflectance,
            &self.solution.solutions,
        );
        if pass.bounces.is_some() {
            light.without_footprint()
        } else {
            light
        }
    }

    pub fn report(&self, gathering: &Gathering) -> Report {
        let scene = self.gatherer.surfaces().scene;
        let square_metres = scene.units.metres().powi(2);
        Report {
            method: self.method,
            engine_used: self.engine_used.clone(),
            patches: self.patches.len(),
            points: gathering.gathered.len(),
            patch_rays: self.solution.rays,
            refined_rows: self.spent.rows,
            patch_error: self.solution.error(&self.patches),
            point_rays: gathering.rays_per_point(),
            bytes: self.solution.bytes,
            iterations: self.solution.convergence.iterations,
            residual: self.solution.convergence.residual,
            balance: self.solution.balance.scaled(square_metres),
            error: gathering.relative_error(),
        }
    }
}

/// The inputs of a solution.
struct SolverInputs<'a> {
    gatherer: &'a Gatherer<'a>,
    patches: &'a Patches,
    reflectance: &'a [Rgb],
    rays: u32,
    seed: u32,
}

impl SolverInputs<'_> {
    /// The report where there is no matrix; `expected` is the size it would have.
    fn shot(&self, pass: &FirstPass, expected: u64) -> EngineUsed {
        let gibibytes = |bytes: u64| bytes as f64 / f64::from(1 << 30);
        let why = format!(
            "rays are shot without a matrix, because its rows may take {:.1} of {:.1} GiB",
            gibibytes(expected),
            gibibytes(pass.memory)
        );
        EngineUsed {
            name: "rays".to_owned(),
            device: self.gatherer.surfaces().tracer.kernel_name(),
            notes: vec![why],
        }
    }

    /// Particles from the lights.
    fn particles(
        &self,
        pass: &FirstPass,
        progress: &Progress,
    ) -> Result<(RadiositySolution, EngineUsed), SolveError> {
        let goal = pass.goal();
        let effort = ParticleEffort {
            first: self.rays,
            error: goal.map(|g| g.error),
            most: goal.map_or(self.rays, |g| g.rays),
        };
        let solution = particles::solve(
            self.gatherer,
            self.patches,
            self.reflectance,
            effort,
            pass.bounces,
            self.seed,
            progress,
        )?;
        let engine_used = EngineUsed {
            name: "particles".to_owned(),
            device: self.gatherer.surfaces().tracer.kernel_name(),
            notes: Vec::new(),
        };
        Ok((solution, engine_used))
    }

    /// Rows, their solution, and the refinement of both.
    fn matrix(
        &self,
        pass: &FirstPass,
        progress: &Progress,
        watch: CoarseCallback,
    ) -> Result<(RadiositySolution, RefinementWork, EngineUsed), SolveError> {
        let &SolverInputs {
            gatherer,
            patches,
            reflectance,
            rays,
            seed,
        } = self;
        let scene = gatherer.surfaces().scene;
        let (engine, why) = match &pass.engine {
            Engine::Auto => {
                let chosen =
                    EngineChoice::of(scene, patches, pass.memory).for_light(pass.aim(), rays);
                (chosen.0, Some(chosen.1))
            }
            asked => (asked.clone(), None),
        };
        let columns = Columns::Diffuse;
        let estimator = Estimator::new(&engine, gatherer, patches, rays, seed, columns);
        let mut system = System::trace(gatherer, patches, reflectance, &estimator, seed, progress)?;
        let engine_used = estimator.engine_used().because(why);
        let coarse = system.solve_all(pass.bounces, progress)?;
        // Hemicubes have the requested number of pixels: rays beside them would only add noise.
        let is_drawn = matches!(estimator, Estimator::Hemicube(_));
        let Some(goal) = pass.goal().filter(|_| !is_drawn) else {
            return Ok((coarse, RefinementWork::default(), engine_used));
        };
        if coarse.error(patches) <= goal.error || progress.out_of_time() {
            return Ok((coarse, RefinementWork::default(), engine_used));
        }
        watch(patches, &coarse);
        let spent = refine(
            &mut system,
            &coarse,
            gatherer,
            patches,
            estimator.rays(),
            goal,
            seed,
            progress,
        )?;
        let refined = system.solve_all(None, progress)?;
        Ok((refined, spent, engine_used))
    }
}
