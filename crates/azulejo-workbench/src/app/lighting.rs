//! The solved light of the document: its solver, its progress, and which document state it belongs
//! to.

#[cfg(test)]
mod tests;

use super::{App, JobResult};
use crate::document::{SceneDocument, Solution, SurfacePick};
use crate::engine_comparison::{EngineRun, compare_engines};
use crate::first_pass::{LightSettings, PatchFormFactors, patch_form_factors, solve_document};
use crate::jobs::{Job, JobKind};
use crate::view::Shading;
use azulejo::scene::{Rgb, Shape};
use azulejo::trace::time::{Duration, Instant};
use azulejo::trace::{Measure, Measured};
use std::sync::Arc;

/// The solved light and the state of the solver.
#[derive(Clone, Debug, Default)]
pub struct Lighting {
    /// Settings for the next solve.
    pub settings: LightSettings,
    /// The latest solution.
    pub solution: Option<Arc<Solution>>,
    /// Whether the solution belongs to the document in its current state.
    pub is_current: bool,
    /// Measures of convergence since the solver started.
    pub measures: Vec<Measured>,
    /// When the solver started.
    pub began: Option<Instant>,
    /// Whether the solver is paused.
    pub is_paused: bool,
    /// Time spent solving.
    pub stopwatch: Stopwatch,
    /// The current stage, and the solving time at which it began.
    pub stage: Option<(String, Duration)>,
    /// Range of the displayed irradiance.
    pub range: Option<IrradianceRange>,
    /// Range of its relative standard errors, where they are known.
    pub error_range: Option<IrradianceRange>,
    /// Form factors of the picked patch.
    pub form_factors: Option<PatchFormFactors>,
    /// The engines compared on that patch.
    pub engine_runs: Vec<EngineRun>,
    /// A solution for another document state, which arrived while the displayed one was current.
    aside: Option<Arc<Solution>>,
}

/// Measures working time, pauses excluded.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stopwatch {
    runs_since: Option<Instant>,
    before: Duration,
}

impl Stopwatch {
    /// A stopwatch that counts from now on.
    pub fn start() -> Stopwatch {
        Stopwatch {
            runs_since: Some(Instant::now()),
            before: Duration::ZERO,
        }
    }

    /// Stops counting until it is resumed.
    pub fn pause(&mut self) {
        self.before = self.elapsed();
        self.runs_since = None;
    }

    /// Goes on counting; does nothing if it does already.
    pub fn resume(&mut self) {
        self.runs_since.get_or_insert_with(Instant::now);
    }

    /// The time measured so far.
    pub fn elapsed(&self) -> Duration {
        self.before + self.runs_since.map_or(Duration::ZERO, |t| t.elapsed())
    }
}

/// Luminance of the irradiance over all vertices, W/m² or lux.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IrradianceRange {
    /// The smallest.
    pub low: f64,
    /// The largest.
    pub high: f64,
    /// The 95th percentile, which a few bright vertices do not move.
    pub usual: f64,
}

impl Lighting {
    /// Updates the solution after an edit: it may have become outdated, or current again. Returns
    /// whether another solution, which had been set aside for this document state, is now
    /// displayed.
    pub(super) fn document_changed(&mut self, document: &SceneDocument) -> bool {
        self.is_current = self.solution.as_ref().is_some_and(|s| s.is_of(document));
        self.form_factors = None;
        self.engine_runs.clear();
        let aside = self
            .aside
            .take_if(|s| !self.is_current && s.is_of(document));
        let is_other = aside.is_some();
        if let Some(solution) = aside {
            self.aside = self.solution.take();
            self.show(solution, document);
        }
        is_other
    }

    /// Drops everything that belonged to the previous document.
    pub(super) fn replaced(&mut self, document: &SceneDocument) {
        *self = Lighting {
            settings: self.settings,
            ..Lighting::default()
        };
        if let Some(solution) = Solution::of_file(document) {
            self.set(solution, document);
        }
    }

    /// Estimated time until the current stage ends, from the time it has taken so far and the share
    /// that is done.
    pub fn time_left(&self, share: f64) -> Option<Duration> {
        const ENOUGH: f64 = 0.02;
        let (_, began) = self.stage.as_ref()?;
        let took = self.stopwatch.elapsed().saturating_sub(*began);
        let left = took.as_secs_f64() * (1.0 - share.min(1.0)) / share;
        (share >= ENOUGH).then(|| Duration::try_from_secs_f64(left).ok())?
    }

    /// The error that the running solver has reached, relative.
    pub fn reached_error(&self) -> Option<f64> {
        let errors = self.measures.iter().rev();
        let mut errors = errors.filter_map(|m| match m.measure {
            Measure::Error(error) => Some(error),
            _ => None,
        });
        errors.next().filter(|error| error.is_finite())
    }

    /// Estimated time until the target error is reached, at most until the time limit. The error of
    /// random estimates falls with the square root of the time.
    pub fn time_to_target(&self) -> Option<Duration> {
        let worked = self.stopwatch.elapsed();
        let limit = self.settings.time.map(|limit| {
            let limit = Duration::try_from_secs_f64(limit).unwrap_or(Duration::MAX);
            limit.saturating_sub(worked)
        });
        let error = self.reached_error().filter(|e| *e > self.settings.error);
        let to_target = error.and_then(|error| {
            let factor = (error / self.settings.error).powi(2) - 1.0;
            Duration::try_from_secs_f64(worked.as_secs_f64() * factor).ok()
        });
        match (to_target, limit) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        }
    }

    /// Takes a new solution; returns whether it is displayed. A solution for another state never
    /// replaces a current one: it is set aside until that state is restored by undo or redo.
    pub(super) fn set(&mut self, solution: Solution, document: &SceneDocument) -> bool {
        let solution = Arc::new(solution);
        if self.is_current && !solution.is_of(document) {
            self.aside = Some(solution);
            return false;
        }
        self.show(solution, document);
        true
    }

    fn show(&mut self, solution: Arc<Solution>, document: &SceneDocument) {
        self.is_current = solution.is_of(document);
        self.range = range(document, &solution);
        self.error_range = error_range(document, &solution);
        self.solution = Some(solution);
    }
}

/// Range of the irradiance on the front sides of surfaces.
fn range(document: &SceneDocument, solution: &Solution) -> Option<IrradianceRange> {
    let mut values: Vec<f64> = Vec::new();
    let mut push = |light: &[Rgb]| values.extend(light.iter().map(|e| e.luminance()));
    for item in &document.objects {
        match solution.shape(item.id).map(|s| &**s) {
            Some(Shape::Mesh(mesh)) => push(&mesh.irradiance),
            Some(Shape::Instance(i)) => i.light.iter().for_each(|l| push(&l.irradiance)),
            Some(Shape::Primitive(p)) => p.light.iter().for_each(|l| push(&l.irradiance)),
            Some(Shape::Exact(exact)) => exact.proxy.iter().for_each(|m| push(&m.irradiance)),
            None => {}
        }
    }
    range_of(values)
}

/// Range of the relative standard errors; black surfaces have none.
fn error_range(document: &SceneDocument, solution: &Solution) -> Option<IrradianceRange> {
    let mut values: Vec<f64> = Vec::new();
    let mut push = |light: &[Rgb], error: &[Rgb]| {
        let lit = light.iter().zip(error).filter(|(e, _)| e.luminance() > 0.0);
        values.extend(lit.map(|(e, error)| error.luminance() / e.luminance()));
    };
    for item in &document.objects {
        match solution.shape(item.id).map(|s| &**s) {
            Some(Shape::Mesh(mesh)) => push(&mesh.irradiance, &mesh.irradiance_error),
            Some(Shape::Exact(exact)) => {
                let proxies = exact.proxy.iter();
                proxies.for_each(|m| push(&m.irradiance, &m.irradiance_error));
            }
            _ => {}
        }
    }
    range_of(values)
}

/// Range of values; `None` if there are none.
pub(super) fn range_of(mut values: Vec<f64>) -> Option<IrradianceRange> {
    values.retain(|v| v.is_finite());
    let least = |a: f64, b: &f64| a.min(*b);
    let most = |a: f64, b: &f64| a.max(*b);
    let first = *values.first()?;
    let (low, high) = (
        values.iter().fold(first, least),
        values.iter().fold(first, most),
    );
    // Selecting one percentile does not require sorting all values.
    let at = values.len() * 19 / 20;
    let (_, usual, _) = values.select_nth_unstable_by(at, f64::total_cmp);
    Some(IrradianceRange {
        low,
        high,
        usual: *usual,
    })
}

impl App {
    /// Starts solving the document in its current state.
    pub(super) fn solve(&mut self) {
        if !self.document.has_light() {
            return self
                .fail(self.tr("there is no light source: add a light or an emissive material"));
        }
        if !self.view.shading.shows_light() {
            // Show the light that is about to be solved.
            self.view.shading = Shading::Irradiance;
        }
        // What is solved is to be seen, not a lightmap.
        self.show_lightmap(false);
        self.forget_measurements();
        self.lighting.measures.clear();
        self.lighting.began = Some(Instant::now());
        self.lighting.is_paused = false;
        self.lighting.stopwatch = Stopwatch::start();
        self.lighting.stage = None;
        let (document, settings) = (self.document.clone(), self.lighting.settings);
        let is_dark = !self.lighting.is_current;
        let title = self.tr("light");
        self.start_job(JobKind::Solve, title, move |progress, outbox| {
            let show = |solution| outbox.send(JobResult::Light(Box::new(solution)));
            solve_document(&document, &settings, is_dark, progress, &show)
        });
    }

    pub(super) fn pause(&mut self, rest: bool) {
        let Some(job) = self.jobs.of(JobKind::Solve) else {
            return;
        };
        if rest {
            job.progress.pause();
            self.lighting.stopwatch.pause();
        } else {
            job.progress.resume();
            self.lighting.stopwatch.resume();
        }
        self.lighting.is_paused = rest;
    }

    pub(super) fn stop_solving(&mut self) {
        self.jobs.cancel_kind(JobKind::Solve);
        self.end_solving();
    }

    pub(super) fn end_solving(&mut self) {
        self.lighting.is_paused = false;
        self.lighting.stopwatch.pause();
        self.lighting.stage = None;
    }

    /// Collects the measures that the solver has reported.
    pub(super) fn take_measures(&mut self) {
        const MAX_MEASURES: usize = 100_000;
        if let Some(job) = self.jobs.of(JobKind::Solve) {
            let new = job.progress.take_measures();
            let room = MAX_MEASURES.saturating_sub(self.lighting.measures.len());
            self.lighting.measures.extend(new.into_iter().take(room));
            let stage = job.progress.stage();
            if self.lighting.stage.as_ref().is_none_or(|s| s.0 != stage) {
                self.lighting.stage = Some((stage, self.lighting.stopwatch.elapsed()));
            }
        }
    }

    /// Takes a solution from the solver. The user who accepted losing its light has accepted this
    /// as well.
    pub(super) fn take_light_of(&mut self, job: &Job, solution: Solution) {
        let before = self.state();
        self.take_light(solution);
        let now = self.state();
        let loading = self.loading.as_mut().map(|l| &mut l.accepted);
        for accepted in loading.into_iter().chain(&mut self.left) {
            if accepted.solver == Some(job.id) && accepted.state == before {
                accepted.state = now;
            }
        }
    }

    pub(super) fn take_light(&mut self, solution: Solution) {
        if self.lighting.set(solution, &self.document) {
            self.refresh_probes();
            self.light_changed();
        }
    }

    /// Takes the light stored in files that were added to an empty document.
    pub(super) fn take_light_of_file(&mut self) {
        if let Some(solution) = Solution::of_file(&self.document) {
            self.take_light(solution);
            self.show_own_light();
        }
    }

    /// Called when the light changes: the document has unsaved changes and renders are outdated.
    pub(super) fn light_changed(&mut self) {
        self.revision = self.new_revision();
        self.light = self.revision;
        self.changed_at.get_or_insert_with(Instant::now);
        self.restart_render();
    }

    pub(super) fn clear_light(&mut self) {
        self.stop_solving();
        self.lighting.aside = None;
        if self.lighting.solution.take().is_some() {
            self.lighting.is_current = false;
            (self.lighting.range, self.lighting.error_range) = (None, None);
            self.lighting.measures.clear();
            self.refresh_probes();
            self.light_changed();
        }
    }

    /// Computes the form factors of the patch at a picked point, with the patches that the solver
    /// would use.
    pub(super) fn form_factors_from(&mut self, pick: SurfacePick) {
        let (document, settings) = (self.document.clone(), self.lighting.settings);
        let title = self.tr("form factors");
        self.start_job(JobKind::FormFactors, title, move |progress, outbox| {
            if let Some(factors) = patch_form_factors(&document, &settings, &pick, progress)? {
                outbox.send(JobResult::FormFactors(Box::new(factors)));
            }
            Ok(())
        });
    }

    /// Compares the engines on the patch whose form factors are shown.
    pub(super) fn compare_engines(&mut self) {
        let Some(pick) = self.lighting.form_factors.as_ref().map(|found| found.pick) else {
            return self.fail(self.tr("choose a patch first"));
        };
        self.lighting.engine_runs.clear();
        let (document, settings) = (self.document.clone(), self.lighting.settings);
        let title = self.tr("form factors");
        self.start_job(JobKind::FormFactors, title, move |progress, outbox| {
            let show = |run| outbox.send(JobResult::EngineRun(run));
            compare_engines(&document, &settings, &pick, progress, &show)
        });
    }
}
