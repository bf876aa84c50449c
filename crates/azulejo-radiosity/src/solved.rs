//! The light on patches, before it is gathered anywhere.

use crate::choice::Facts;
use crate::engine::{Engine, Estimator, Ran};
use crate::gather::Gathering;
use crate::light::{PatchLight, reflectances};
use crate::patch::Patches;
use crate::refine::{Spent, refine};
use crate::row::Columns;
use crate::solve::{Estimate, FirstPass, Method, Report, SolveError};
use crate::stand_in::StandIn;
use crate::stochastic;
use crate::system::{Found, System};
use azulejo_scene::{Rgb, Scene};
use azulejo_trace::sampling::hash;
use azulejo_trace::{Gathered, Gatherer, Measure, Progress, Surfaces, Tracer};
use std::f64::consts::PI;

/// The radiosity of every patch.
pub struct PatchRadiosity {
    /// The patches.
    pub patches: Patches,
    /// Radiosity of every [side](crate::row::side) of a patch, emission and reflected light, W/m².
    pub sides: Vec<Estimate>,
    /// How it was found.
    pub report: Report,
}

/// Radiosity of the patches of a scene: what [`solve`](crate::solve()) gathers to the vertices.
///
/// # Errors
/// As [`solve`](crate::solve()).
pub fn radiosity(
    scene: &Scene,
    tracer: &Tracer,
    pass: &FirstPass,
    progress: &Progress,
) -> Result<PatchRadiosity, SolveError> {
    let stand_in = StandIn::new(scene, tracer, pass.size);
    let solved = Solved::new(&stand_in, pass, progress, &mut |_, _| ())?;
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

/// Patches and the light on them, before it is gathered anywhere.
pub(crate) struct Solved<'a> {
    pub gatherer: Gatherer<'a>,
    pub patches: Patches,
    reflectance: Vec<Rgb>,
    pub found: Found,
    spent: Spent,
    method: Method,
    ran: Ran,
}

/// Is shown a solution that is going to be refined.
pub(crate) type Watch<'a> = &'a mut dyn FnMut(&Patches, &Found);

impl<'a> Solved<'a> {
    pub fn new(
        stand_in: &'a StandIn,
        pass: &FirstPass,
        progress: &Progress,
        watch: Watch,
    ) -> Result<Solved<'a>, SolveError> {
        let (scene, tracer) = (stand_in.scene.as_ref(), stand_in.tracer.as_ref());
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
        let parts = Parts {
            gatherer: &gatherer,
            patches: &patches,
            reflectance: &reflectance,
            rays,
            seed,
        };
        let (found, spent, method, ran) = if expected <= pass.memory {
            let (found, spent, ran) = parts.matrix(pass, progress, watch)?;
            (found, spent, Method::Matrix, ran)
        } else {
            let found = stochastic::solve(
                &gatherer,
                &patches,
                &reflectance,
                rays,
                pass.bounces,
                seed,
                progress,
            )?;
            (
                found,
                Spent::default(),
                Method::Stochastic,
                parts.shot(pass, expected),
            )
        };
        progress.measured(Measure::PatchError(found.error(&patches)));
        Ok(Solved {
            gatherer,
            patches,
            reflectance,
            found,
            spent,
            method,
            ran,
        })
    }

    /// B of every side with its standard error.
    fn radiosity(&self) -> Vec<Estimate> {
        let materials = &self.gatherer.surfaces().scene.materials;
        let estimate = |s: usize| {
            let solutions = &self.found.solutions;
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
            &self.found.solutions,
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
            ran: self.ran.clone(),
            patches: self.patches.len(),
            points: gathering.gathered.len(),
            patch_rays: self.found.rays,
            refined_rows: self.spent.rows,
            patch_error: self.found.error(&self.patches),
            point_rays: gathering.rays_per_point(),
            bytes: self.found.bytes,
            iterations: self.found.convergence.iterations,
            residual: self.found.convergence.residual,
            balance: self.found.balance.scaled(square_metres),
            error: gathering.relative_error(),
        }
    }
}

/// What a solution is made from.
struct Parts<'a> {
    gatherer: &'a Gatherer<'a>,
    patches: &'a Patches,
    reflectance: &'a [Rgb],
    rays: u32,
    seed: u32,
}

impl Parts<'_> {
    /// What is said where there is no matrix; `expected` is what it would take.
    fn shot(&self, pass: &FirstPass, expected: u64) -> Ran {
        let gibibytes = |bytes: u64| bytes as f64 / f64::from(1 << 30);
        let why = format!(
            "rays are shot without a matrix, because its rows may take {:.1} of {:.1} GiB",
            gibibytes(expected),
            gibibytes(pass.memory)
        );
        Ran {
            engine: "rays".to_owned(),
            device: self.gatherer.surfaces().tracer.kernel_name(),
            notes: vec![why],
        }
    }

    /// Rows, their solution, and the refinement of both.
    fn matrix(
        &self,
        pass: &FirstPass,
        progress: &Progress,
        watch: Watch,
    ) -> Result<(Found, Spent, Ran), SolveError> {
        let &Parts {
            gatherer,
            patches,
            reflectance,
            rays,
            seed,
        } = self;
        let scene = gatherer.surfaces().scene;
        let (engine, why) = match &pass.engine {
            Engine::Auto => {
                let chosen = Facts::of(scene, patches, pass.memory).for_light(pass.aim(), rays);
                (chosen.0, Some(chosen.1))
            }
            asked => (asked.clone(), None),
        };
        let columns = Columns::Diffuse;
        let estimator = Estimator::new(&engine, gatherer, patches, rays, seed, columns);
        let mut system = System::trace(gatherer, patches, reflectance, &estimator, seed, progress)?;
        let ran = estimator.ran().because(why);
        let coarse = system.solve_all(pass.bounces, progress)?;
        // Hemicubes have as many pixels as were asked for: rays beside them would be noise.
        let is_drawn = matches!(estimator, Estimator::Hemicube(_));
        let Some(goal) = pass.goal().filter(|_| !is_drawn) else {
            return Ok((coarse, Spent::default(), ran));
        };
        if coarse.error(patches) <= goal.error || progress.out_of_time() {
            return Ok((coarse, Spent::default(), ran));
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
        Ok((refined, spent, ran))
    }
}
