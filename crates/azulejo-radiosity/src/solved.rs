//! The light on patches, before it is gathered.

use crate::deadline::affordable_patch_rays;
use crate::error::SolveError;
use crate::first_pass::{DEFAULT_RAYS, FirstPass, PatchPurpose};
use crate::gathering::{CHUNK, GatherEffort, GatherTargets, Gathering, HASTY_RAYS};
use crate::light::PatchLight;
use crate::particles::{self, ParticleEffort};
use crate::plan::{GatherForecast, GatherGoal, Pilot};
use crate::records::RecordCells;
use crate::refine::{RefinementGoal, RefinementWork, refine};
use crate::report::{Estimate, Method, Report};
use crate::stochastic;
use crate::system::{RadiositySolution, System};
use crate::vertices::vertex_area;
use azulejo_factors::estimator::Estimator;
use azulejo_factors::patch::DisplayVertex;
use azulejo_factors::row::Columns;
use azulejo_factors::{Engine, EngineChoice, EngineUsed, Patches, ProxyScene, reflectances};
use azulejo_scene::{Rgb, Scene};
use azulejo_trace::sampling::hash;
use azulejo_trace::{
    DirectionTables, GatherOptions, GatherPoint, Gathered, Gatherer, Measure, Progress, Run,
    SplitIrradiance, Surfaces, Termination, Tracer, run,
};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Share of the time until a deadline that a first solution for the patches may take. Without one,
/// paths are traced, which takes about ten times as long for the same noise (measured).
const PATCH_SHARE: f64 = 0.6;

/// The same where points are not known yet: they are texels, which are many and have looks of their own.
const PATCH_SHARE_OF_TEXELS: f64 = 0.25;

/// Share of the time that is left then for its refinement: a point reads hundreds of patches, which
/// leaves little of their noise.
const REFINEMENT_SHARE: f64 = 0.05;

/// What surfaces reflect at most where the light between some of them does not die out: so white paint
/// and ceramics do. Models have cavities that reflect all, of which little is seen.
const MOST_REFLECTED: f64 = 0.98;

/// Most of the emitted light that may be absorbed so: where it is more, the brightness of the scene would
/// be that of the limit.
const MOST_ABSORBED: f64 = 0.1;

/// Paths from the middle of each side of a patch, where patches have no radiosity: sides are chosen
/// for whole surfaces.
const SIDE_RAYS: u32 = 4;

/// Most of them, from the sides that stand for those around them.
const MOST_SIDES: usize = 1 << 16;

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
    let purpose = PatchPurpose::Result;
    let run = Run::alone(progress);
    let solved = SolvedPatches::new(&proxy, pass, purpose, run, &mut |_, _| ())?;
    let nothing = Gathering::new(GatherTargets {
        points: &[],
        areas: &[],
    });
    if solved.method == Method::Paths {
        return Err(SolveError::OutOfTime);
    }
    let mut report = solved.report(&nothing);
    report.error = report.patch_error.max(solved.unexplained());
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
    pub method: Method,
    engine_used: EngineUsed,
    /// Whether bounces are limited.
    has_light_left: bool,
    /// Share of the emitted light that is absorbed because reflectances were limited.
    absorbed_by_limit: f64,
    /// What is asked, within its budget.
    pass: FirstPass,
}

/// Called with a solution that is about to be refined.
pub(crate) type CoarseCallback<'a> = &'a mut dyn FnMut(&Patches, &RadiositySolution);

impl<'a> SolvedPatches<'a> {
    pub fn new(
        proxy: &'a ProxyScene,
        pass: &FirstPass,
        purpose: PatchPurpose,
        run: Run,
        watch: CoarseCallback,
    ) -> Result<SolvedPatches<'a>, SolveError> {
        let progress = run.progress;
        let (scene, tracer) = (proxy.scene.as_ref(), proxy.tracer.as_ref());
        if !scene.has_light() {
            return Err(SolveError::NoLight);
        }
        let patches = Patches::new(scene, pass.size);
        // Points are sensors, which need nothing around them.
        if patches.is_empty() && !matches!(purpose, PatchPurpose::Points(_)) {
            return Err(SolveError::NoSurface);
        }
        let gatherer = Gatherer::new(Surfaces::new(scene, tracer));
        let mut reflectance = reflectances(scene, &patches);
        let seed = hash(&[pass.key(), 0]);
        // Where needed, a few paths show what a budget of rays affords, and whether paths or patches cost less.
        let light = PatchLight::unknown(gatherer.surfaces(), &patches, &reflectance);
        let pilot = pilot(&gatherer, &light, (&patches, pass), purpose, seed, progress);
        let pass = match &pilot {
            Some(pilot) => {
                &pass.within_budget(|budget| pilot.affordable_paths(budget, DEFAULT_RAYS))
            }
            None => pass,
        };
        let enough = pass.patch_rays(purpose, patches.len());
        let rays = if progress.has_deadline() {
            enough.min(HASTY_RAYS)
        } else {
            enough
        };
        let mut solve = |reflectance: &[Rgb]| {
            let inputs = SolverInputs {
                gatherer: &gatherer,
                patches: &patches,
                reflectance,
                rays,
                goal: pass.goal(purpose, patches.len()),
                seed,
            };
            inputs.solution(pass, pilot.as_ref(), purpose, run, watch)
        };
        let mut radiosity = solve(&reflectance)?;
        let mut absorbed_by_limit = 0.0;
        // If light does not die out, solve again with limited reflectances, unless these absorb too much.
        if pass.bounces.is_none() && !radiosity.solution.convergence.is_reached {
            let endless = SolveError::Endless(radiosity.solution.convergence.iterations);
            let limited = limited_reflectances(scene, &patches, &reflectance);
            radiosity = solve(&limited)?;
            absorbed_by_limit = radiosity.absorbed_by_limit(&patches, &reflectance, &limited);
            if !radiosity.solution.convergence.is_reached || absorbed_by_limit > MOST_ABSORBED {
                return Err(endless);
            }
            let note = limit_note(absorbed_by_limit);
            radiosity.engine_used.notes.push(note);
            reflectance = limited;
        }
        // Paths leave no radiosity on patches whose error could be stated.
        if radiosity.method != Method::Paths {
            progress.measured(Measure::PatchError(radiosity.solution.error(&patches)));
        }
        let PatchSolution {
            solution,
            spent,
            method,
            engine_used,
        } = radiosity;
        Ok(SolvedPatches {
            gatherer,
            patches,
            reflectance,
            solution,
            spent,
            method,
            engine_used,
            has_light_left: pass.bounces.is_some(),
            absorbed_by_limit,
            pass: pass.clone(),
        })
    }

    /// A digest of the light on patches, for those who share the work on what is gathered from it.
    pub fn digest(&self) -> u64 {
        self.digest_at(&[])
    }

    /// The same with the places of points that were computed, too.
    pub fn digest_at(&self, points: &[GatherPoint]) -> u64 {
        let all = self.solution.solutions.iter().flatten();
        let light = all.flat_map(|light| light.to_array());
        let places = points.iter().flat_map(|p| [p.position, p.normal]);
        run::digest(light.chain(places.flat_map(|v| v.to_array())))
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
            let emitted = self.patches.emission(s / 2, material, s.is_multiple_of(2)) * PI;
            Estimate {
                value: emitted + reflected.mean(),
                error: reflected.standard_error(),
            }
        };
        (0..2 * self.patches.len()).map(estimate).collect()
    }

    /// What random numbers depend on.
    pub fn key(&self) -> u32 {
        self.pass.key()
    }

    /// How the light is gathered.
    pub fn effort(&self) -> GatherEffort {
        self.pass.effort(self.method)
    }

    /// The same within a budget of rays, by what paths take from all points that are gathered at. The pilot before the
    /// sides were chosen knows fronts alone, and paths inside of shells are many times as long.
    pub fn effort_at(
        &self,
        light: &PatchLight,
        targets: GatherTargets,
        budget: Option<f64>,
        seed: u32,
    ) -> GatherEffort {
        let effort = self.effort();
        let Some(budget) = budget.filter(|_| self.method == Method::Paths) else {
            return effort;
        };
        let pilot = Pilot::new(&self.gatherer, light, targets, seed);
        GatherEffort {
            rays: pilot.affordable_paths(budget, effort.rays),
            ..effort
        }
    }

    pub fn light(&self) -> PatchLight<'_> {
        if self.method == Method::Paths {
            return self.unknown_light();
        }
        let light = PatchLight::new(
            self.gatherer.surfaces(),
            &self.patches,
            &self.reflectance,
            &self.solution.solutions,
        );
        if self.pass.bounces.is_some() {
            light.without_footprint()
        } else {
            light
        }
    }

    /// Black light for the paths of a gather, if bounces are limited.
    pub fn black_light(&self) -> Option<(PatchLight<'_>, u32)> {
        self.pass
            .bounces
            .map(|bounces| (self.unknown_light(), bounces))
    }

    fn unknown_light(&self) -> PatchLight<'_> {
        PatchLight::unknown(self.gatherer.surfaces(), &self.patches, &self.reflectance)
    }

    /// The share of the emitted power that is missing beyond its standard error, or that limits of
    /// reflectances absorb: as much at least is wrong with the light. Nothing, where light is on its way because bounces are limited.
    fn unexplained(&self) -> f64 {
        if self.has_light_left {
            return 0.0;
        }
        let lost = self.solution.balance.lost(self.solution.balance_error);
        lost.max(self.absorbed_by_limit)
    }

    pub fn report(&self, gathering: &Gathering) -> Report {
        let scene = self.gatherer.surfaces().scene;
        let square_metres = scene.units.metres().powi(2);
        let mut engine_used = self.engine_used.clone();
        engine_used.notes.extend(gathering.records.map(|records| {
            format!(
                "the time did not suffice for all {} points: each has the light of one of {records}",
                gathering.gathered.len()
            )
        }));
        Report {
            method: self.method,
            engine_used,
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
            balance_error: self.solution.balance_error,
            error: gathering.relative_error().max(self.unexplained()),
            error_each: gathering.error_of_each(),
            error_parts: gathering.parts(),
            quarters: gathering.quarters(),
            path_traced: gathering.path_traced(),
            rays_needed: gathering.rays_needed,
            interpolated: gathering.interpolated(),
        }
    }
}

/// The light on patches, and how it was found.
struct PatchSolution {
    solution: RadiositySolution,
    spent: RefinementWork,
    method: Method,
    engine_used: EngineUsed,
}

impl PatchSolution {
    /// The share of the emitted light that surfaces absorb because their reflectance was limited.
    fn absorbed_by_limit(&self, patches: &Patches, given: &[Rgb], limited: &[Rgb]) -> f64 {
        let incident = self.solution.incident.iter().enumerate();
        let absorbed = incident.fold(Rgb::BLACK, |sum, (side, h)| {
            let patch = side / 2;
            sum + (given[patch] - limited[patch]) * *h * patches.area(patch)
        });
        let emitted = self.solution.balance.emitted.max_channel();
        absorbed.max_channel() / emitted.max(f64::MIN_POSITIVE)
    }
}

/// Why there is no light between patches before a deadline.
const TOO_LITTLE_TIME: &str =
    "paths are traced from the points, because the time does not suffice for patches";

/// Why there is none without.
fn paths_are_cheaper(forecast: &GatherForecast) -> String {
    let times = forecast.by_patches / forecast.by_paths;
    let cost = if times.is_finite() {
        format!("{times:.1} times as much")
    } else {
        "more".to_owned()
    };
    format!(
        "paths are traced from the points, about {:.0} from each: rows of patches, and what is gathered with them, \
         would cost {cost}",
        forecast.paths_per_point,
    )
}

/// A pilot where it is needed: to keep to a budget, or where paths or patches may be taken. That is not where the engine,
/// the number of rays or of bounces was chosen, before a deadline, or where points are not known.
fn pilot(
    gatherer: &Gatherer,
    light: &PatchLight,
    (patches, pass): (&Patches, &FirstPass),
    purpose: PatchPurpose,
    seed: u32,
    progress: &Progress,
) -> Option<Pilot> {
    let is_free = pass.engine == Engine::Auto && pass.bounces.is_none();
    let is_chosen = pass.effort(Method::Paths).error.is_none();
    let is_forecast = is_free && !is_chosen && !progress.has_deadline();
    if !is_forecast && pass.ray_budget.is_none() {
        return None;
    }
    let (vertices, vertex_areas);
    let (points, areas): (&[GatherPoint], &[f64]) = match purpose {
        PatchPurpose::Points(points) => (points, &[]),
        PatchPurpose::Result => (&[], &[]),
        PatchPurpose::Vertices => {
            let all = 0..patches.vertices().len();
            vertices = vertex_points(patches);
            vertex_areas = all.map(|v| vertex_area(patches, v)).collect::<Vec<f64>>();
            (&vertices, &vertex_areas)
        }
    };
    // Where each point is to reach an error, all count alike.
    let areas = if pass.error_each { &[] } else { areas };
    let targets = GatherTargets { points, areas };
    (!points.is_empty()).then(|| Pilot::new(gatherer, light, targets, seed))
}

/// The vertices of patches as points, to know what light at them costs.
fn vertex_points(patches: &Patches) -> Vec<GatherPoint> {
    let point = |(key, vertex): (usize, &DisplayVertex)| GatherPoint {
        position: vertex.gather,
        normal: vertex.normal,
        key: key as u32,
    };
    patches.vertices().iter().enumerate().map(point).collect()
}

/// What is said of limited reflectances.
fn limit_note(absorbed: f64) -> String {
    format!(
        "surfaces that reflect more than {:.0}% were taken to reflect that much, because the light between some of \
         them did not die out; they absorb {:.2}% of all light",
        100.0 * MOST_REFLECTED,
        100.0 * absorbed
    )
}

/// The reflectances of patches with which light dies out.
fn limited_reflectances(scene: &Scene, patches: &Patches, reflectance: &[Rgb]) -> Vec<Rgb> {
    let of_patch = |(p, &r): (usize, &Rgb)| {
        let material = &scene.materials[patches.material(p) as usize];
        limited(r, material.mirror + material.mean_glossy())
    };
    reflectance.iter().enumerate().map(of_patch).collect()
}

/// A diffuse reflectance, or the most of [`MOST_REFLECTED`] of what a surface does not reflect in a mirror.
fn limited(diffuse: Rgb, specular: Rgb) -> Rgb {
    let most = |k: usize| MOST_REFLECTED * (1.0 - specular[k]).max(0.0);
    Rgb::new(
        diffuse[0].min(most(0)),
        diffuse[1].min(most(1)),
        diffuse[2].min(most(2)),
    )
}

/// The inputs of a solution.
struct SolverInputs<'a> {
    gatherer: &'a Gatherer<'a>,
    patches: &'a Patches,
    reflectance: &'a [Rgb],
    rays: u32,
    goal: Option<RefinementGoal>,
    seed: u32,
}

impl SolverInputs<'_> {
    /// The light on patches as `pass` asks for it, or none where paths from the points are cheaper or sooner.
    fn solution(
        &self,
        pass: &FirstPass,
        pilot: Option<&Pilot>,
        purpose: PatchPurpose,
        run: Run,
        watch: CoarseCallback,
    ) -> Result<PatchSolution, SolveError> {
        let progress = run.progress;
        if let Some(pilot) = pilot
            && let Some(forecast) = self.forecast(pass, pilot)
            && forecast.prefers_paths()
        {
            return self.without_patches(purpose, progress, paths_are_cheaper(&forecast));
        }
        // Entries of eight bytes, hardly more of them than rays.
        let expected = self.patches.len() as u64 * u64::from(self.rays) * 8;
        progress.limit_phase(match purpose {
            PatchPurpose::Points([]) => PATCH_SHARE_OF_TEXELS,
            _ => PATCH_SHARE,
        });
        let solution = if pass.engine == Engine::Particles {
            Some(self.particles(pass, progress)?)
        } else if expected <= pass.memory {
            self.matrix(pass, run, watch)?
        } else {
            self.shoot(pass, expected, progress)?
        };
        match solution {
            Some(solution) => Ok(solution),
            None => self.without_patches(purpose, progress, TOO_LITTLE_TIME.to_owned()),
        }
    }

    /// What paths and patches would cost, where either may be taken: not where the engine or the number of bounces was
    /// chosen, or where surfaces reflect so much that paths hardly end.
    fn forecast(&self, pass: &FirstPass, pilot: &Pilot) -> Option<GatherForecast> {
        let brightest = self.reflectance.iter().map(|r| r.max_channel());
        let is_dim = brightest.fold(0.0, f64::max) <= MOST_REFLECTED;
        if pass.engine != Engine::Auto || pass.bounces.is_some() || !is_dim {
            return None;
        }
        let effort = pass.effort(Method::Paths);
        let goal = GatherGoal {
            error: effort.error?,
            is_each: effort.is_each,
        };
        pilot.forecast((self.patches, pass.size, self.rays), goal)
    }

    /// What traced the rays, where no engine computed rows, and why.
    fn rays_alone(&self, why: String) -> EngineUsed {
        EngineUsed {
            name: "rays".to_owned(),
            device: self.gatherer.surfaces().tracer.kernel_name(),
            notes: vec![why],
        }
    }

    /// Stochastic Jacobi; `expected` is the size that a matrix would have.
    fn shoot(
        &self,
        pass: &FirstPass,
        expected: u64,
        progress: &Progress,
    ) -> Result<Option<PatchSolution>, SolveError> {
        let gibibytes = |bytes: u64| bytes as f64 / f64::from(1 << 30);
        let why = format!(
            "rays are shot without a matrix, because its rows may take {:.1} of {:.1} GiB",
            gibibytes(expected),
            gibibytes(pass.memory)
        );
        let solution = stochastic::solve(
            self.gatherer,
            self.patches,
            self.reflectance,
            self.rays,
            pass.bounces,
            self.seed,
            progress,
        )?;
        Ok(solution.map(|solution| PatchSolution {
            solution,
            spent: RefinementWork::default(),
            method: Method::Stochastic,
            engine_used: self.rays_alone(why),
        }))
    }

    /// No radiosity: every point will be path traced. What arrives at the sides of patches, which
    /// tells fronts from backs, is estimated by a few paths each, or of very many at some.
    fn without_patches(
        &self,
        purpose: PatchPurpose,
        progress: &Progress,
        why: String,
    ) -> Result<PatchSolution, SolveError> {
        let patches = self.patches;
        let mut solution = RadiositySolution::dark(2 * patches.len());
        let light = PatchLight::unknown(self.gatherer.surfaces(), patches, self.reflectance);
        let options = GatherOptions {
            rays: SIDE_RAYS,
            spent: 0,
            seed: self.seed,
            termination: Termination::Roulette,
        };
        let directions = DirectionTables::new(&options);
        let point = |s: usize| {
            let (position, normal) = (patches.centre(s / 2), patches.normal(s / 2));
            GatherPoint {
                position,
                normal: if s.is_multiple_of(2) { normal } else { -normal },
                key: s as u32,
            }
        };
        // Only vertices need to know which side is lit: the side of points is given.
        let count = match purpose {
            PatchPurpose::Vertices => 2 * patches.len(),
            PatchPurpose::Points(_) | PatchPurpose::Result => 0,
        };
        let sides: Vec<GatherPoint> = (0..count).map(point).collect();
        // If there are too many sides, some stand for those around them.
        let cells = RecordCells::at_most(&sides, self.seed, MOST_SIDES);
        let records: Vec<GatherPoint> = cells.records().map(|k| sides[k as usize]).collect();
        progress.begin("irradiance of patches", records.len() as u64);
        let irradiance: Vec<Vec<SplitIrradiance>> = records
            .par_chunks(CHUNK)
            .map(|points| {
                progress.advance(points.len() as u64)?;
                if progress.is_overdue() {
                    return Err(SolveError::OutOfTime);
                }
                let gatherer = self.gatherer;
                Ok(gatherer.gather_with(points, &options, &directions, &light))
            })
            .collect::<Result<_, SolveError>>()?;
        // Give all sides of a cell the light of its record.
        let means = irradiance.iter().flatten().map(|e| e.whole().mean());
        for (mean, inside) in means.zip(cells.points()) {
            for &k in inside {
                solution.incident[k as usize] = mean;
            }
        }
        Ok(PatchSolution {
            solution,
            spent: RefinementWork::default(),
            method: Method::Paths,
            engine_used: self.rays_alone(why),
        })
    }

    /// Particles from the lights.
    fn particles(
        &self,
        pass: &FirstPass,
        progress: &Progress,
    ) -> Result<PatchSolution, SolveError> {
        let goal = self.goal;
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
        Ok(PatchSolution {
            solution,
            spent: RefinementWork::default(),
            method: Method::Stochastic,
            engine_used,
        })
    }

    /// Rows, their solution, and the refinement of both.
    fn matrix(
        &self,
        pass: &FirstPass,
        run: Run,
        watch: CoarseCallback,
    ) -> Result<Option<PatchSolution>, SolveError> {
        let progress = run.progress;
        let &SolverInputs {
            gatherer,
            patches,
            reflectance,
            rays,
            goal,
            seed,
        } = self;
        let (engine, why) = match &pass.engine {
            Engine::Auto => {
                let choice = EngineChoice::of(gatherer.surfaces(), patches, None, pass.memory, 0);
                let chosen = choice.for_light(pass.aim(), rays);
                (chosen.0, Some(chosen.1))
            }
            engine => (engine.clone(), None),
        };
        let (engine, instead) = engine.for_tracer(gatherer.surfaces().tracer);
        let why = instead.or(why);
        let rays = if engine == Engine::Rays {
            match affordable_patch_rays(gatherer, patches, seed, progress)? {
                Some(affordable) => affordable.min(rays),
                None => return Ok(None),
            }
        } else {
            rays
        };
        let columns = Columns::Diffuse;
        let estimator = Estimator::new(&engine, gatherer, patches, rays, seed, columns);
        let system = System::trace(gatherer, patches, reflectance, &estimator, seed, run)?;
        let Some(mut system) = system else {
            return Ok(None);
        };
        let mut radiosity = PatchSolution {
            solution: system.solve_all(pass.bounces)?,
            spent: RefinementWork::default(),
            method: Method::Matrix,
            engine_used: estimator.engine_used().because(why),
        };
        // Hemicubes have the requested number of pixels: rays beside them would only add noise.
        let is_drawn = matches!(estimator, Estimator::Hemicube(_));
        let Some(goal) = goal.filter(|_| !is_drawn) else {
            return Ok(Some(radiosity));
        };
        progress.limit_phase(REFINEMENT_SHARE);
        let coarse = &radiosity.solution;
        // Light that does not die out may exceed what numbers of rays hold.
        if pass.bounces.is_none() && !coarse.convergence.is_reached {
            return Ok(Some(radiosity));
        }
        if coarse.error(patches) <= goal.error || progress.phase_is_over() {
            return Ok(Some(radiosity));
        }
        watch(patches, coarse);
        radiosity.spent = refine(
            &mut system,
            coarse,
            gatherer,
            patches,
            estimator.rays(),
            goal,
            seed,
        )?;
        radiosity.solution = system.solve_all(None)?;
        Ok(Some(radiosity))
    }
}
