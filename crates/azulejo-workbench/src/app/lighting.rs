//! The light: its solver, its moments, and whose light it is.

#[cfg(test)]
mod tests;

use super::{App, Found, Level};
use crate::command::PatchAt;
use crate::document::{Document, Solution};
use crate::jobs::{Job, Kind, on_own_threads};
use crate::light::{LightSettings, SeenFromPatch, seen_from, solve_document};
use crate::view::Shading;
use azulejo::scene::{Rgb, Shape};
use azulejo::trace::Measured;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The light of the document.
#[derive(Clone, Debug, Default)]
pub struct Lighting {
    /// How it is to be solved.
    pub settings: LightSettings,
    /// What was found last.
    pub solution: Option<Arc<Solution>>,
    /// Whether that is the light of the document as it is now.
    pub is_current: bool,
    /// What the solver measured since it began.
    pub measures: Vec<Measured>,
    /// When it began.
    pub began: Option<Instant>,
    /// Whether the solver rests.
    pub is_paused: bool,
    /// How long it worked.
    pub watch: Stopwatch,
    /// What it is at, and how long it had worked when it began that.
    pub stage: Option<(String, Duration)>,
    /// Irradiance that is shown: least, most, and what nearly all is below.
    pub range: Option<Range>,
    /// What a picked patch sees.
    pub seen: Option<SeenFromPatch>,
    /// Light of another state than that which is shown, found while the shown one was true.
    aside: Option<Arc<Solution>>,
}

/// The time that work took, without its rests.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stopwatch {
    runs_since: Option<Instant>,
    before: Duration,
}

impl Stopwatch {
    /// Runs from now on.
    pub fn begin() -> Stopwatch {
        Stopwatch {
            runs_since: Some(Instant::now()),
            before: Duration::ZERO,
        }
    }

    /// Stands still.
    pub fn hold(&mut self) {
        self.before = self.elapsed();
        self.runs_since = None;
    }

    /// Runs again.
    pub fn go_on(&mut self) {
        self.runs_since.get_or_insert_with(Instant::now);
    }

    /// What it shows.
    pub fn elapsed(&self) -> Duration {
        self.before + self.runs_since.map_or(Duration::ZERO, |t| t.elapsed())
    }
}

/// Luminances of irradiance, W/m² or lux.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The least.
    pub low: f64,
    /// The most.
    pub high: f64,
    /// What 19 of 20 vertices are below.
    pub usual: f64,
}

impl Lighting {
    /// The document was edited: the light may be old now, or true again. Whether it is another
    /// light now: the one that was found for this document while it was not there.
    pub(super) fn document_changed(&mut self, document: &Document) -> bool {
        self.is_current = self.solution.as_ref().is_some_and(|s| s.is_of(document));
        self.seen = None;
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

    /// There is another document.
    pub(super) fn replaced(&mut self, document: &Document) {
        *self = Lighting {
            settings: self.settings,
            ..Lighting::default()
        };
        if let Some(solution) = Solution::of_file(document) {
            self.set(solution, document);
        }
    }

    /// How long the stage will go on, if so much of it is done; a guess from the time it took.
    pub fn time_left(&self, share: f64) -> Option<Duration> {
        const ENOUGH: f64 = 0.02;
        let (_, began) = self.stage.as_ref()?;
        let took = self.watch.elapsed().saturating_sub(*began);
        let left = took.as_secs_f64() * (1.0 - share.min(1.0)) / share;
        (share >= ENOUGH).then(|| Duration::try_from_secs_f64(left).ok())?
    }

    /// Takes light in; whether it is shown. True light does not make room for that of another
    /// state, which waits until that state is back.
    pub(super) fn set(&mut self, solution: Solution, document: &Document) -> bool {
        let solution = Arc::new(solution);
        if self.is_current && !solution.is_of(document) {
            self.aside = Some(solution);
            return false;
        }
        self.show(solution, document);
        true
    }

    fn show(&mut self, solution: Arc<Solution>, document: &Document) {
        self.is_current = solution.is_of(document);
        self.range = range(document, &solution);
        self.solution = Some(solution);
    }
}

/// What irradiance there is on the front of things.
fn range(document: &Document, solution: &Solution) -> Option<Range> {
    let mut values: Vec<f64> = Vec::new();
    let mut push = |light: &[Rgb]| values.extend(light.iter().map(|e| e.luminance()));
    for item in &document.items {
        match solution.shape(item.id).map(|s| &**s) {
            Some(Shape::Mesh(mesh)) => push(&mesh.irradiance),
            Some(Shape::Primitive(p)) => p.light.iter().for_each(|l| push(&l.irradiance)),
            Some(Shape::Exact(exact)) => exact.proxy.iter().for_each(|m| push(&m.irradiance)),
            None => {}
        }
    }
    values.retain(|v| v.is_finite());
    let least = |a: f64, b: &f64| a.min(*b);
    let most = |a: f64, b: &f64| a.max(*b);
    let first = *values.first()?;
    let (low, high) = (
        values.iter().fold(first, least),
        values.iter().fold(first, most),
    );
    // Not all of them need be in order for one of them.
    let at = values.len() * 19 / 20;
    let (_, usual, _) = values.select_nth_unstable_by(at, f64::total_cmp);
    Some(Range {
        low,
        high,
        usual: *usual,
    })
}

impl App {
    /// Begins to solve the light of the document as it is.
    pub(super) fn solve(&mut self) {
        if !self.document.has_light() {
            let text = self.say("nothing shines: add a light, or give a material emission");
            self.tell(Level::Error, text);
            return;
        }
        if !self.view.shading.shows_light() {
            // Whoever solves light wants to see it.
            self.view.shading = Shading::Irradiance;
        }
        self.jobs.cancel_kind(Kind::Solve);
        self.lighting.measures.clear();
        self.lighting.began = Some(Instant::now());
        self.lighting.is_paused = false;
        self.lighting.watch = Stopwatch::begin();
        self.lighting.stage = None;
        let (document, settings) = (self.document.clone(), self.lighting.settings);
        let threads = self.preferences.threads;
        let title = self.say("light");
        self.jobs
            .start(Kind::Solve, title, move |progress, outbox| {
                on_own_threads(threads, || {
                    solve_document(&document, &settings, progress, outbox)
                })
            });
    }

    pub(super) fn pause(&mut self, rest: bool) {
        let Some(job) = self.jobs.of(Kind::Solve) else {
            return;
        };
        match rest {
            true => {
                job.progress.pause();
                self.lighting.watch.hold();
            }
            false => {
                job.progress.resume();
                self.lighting.watch.go_on();
            }
        }
        self.lighting.is_paused = rest;
    }

    pub(super) fn stop_solving(&mut self) {
        self.jobs.cancel_kind(Kind::Solve);
        self.end_solving();
    }

    pub(super) fn end_solving(&mut self) {
        self.lighting.is_paused = false;
        self.lighting.watch.hold();
        self.lighting.stage = None;
    }

    /// Takes in what the solver measured meanwhile.
    pub(super) fn take_measures(&mut self) {
        const MOST: usize = 100_000;
        if let Some(job) = self.jobs.of(Kind::Solve) {
            let new = job.progress.take_measures();
            let room = MOST.saturating_sub(self.lighting.measures.len());
            self.lighting.measures.extend(new.into_iter().take(room));
            let stage = job.progress.stage();
            if self.lighting.stage.as_ref().is_none_or(|s| s.0 != stage) {
                self.lighting.stage = Some((stage, self.lighting.watch.elapsed()));
            }
        }
    }

    /// Takes in what a solver found. Who agreed to lose it has agreed to this too.
    pub(super) fn take_light_of(&mut self, job: &Job, solution: Solution) {
        let before = self.state();
        self.take_light(solution);
        let now = self.state();
        let loading = self.loading.as_mut().map(|l| &mut l.agreed);
        for agreed in loading.into_iter().chain(&mut self.left) {
            if agreed.solver == Some(job.id) && agreed.state == before {
                agreed.state = now;
            }
        }
    }

    pub(super) fn take_light(&mut self, solution: Solution) {
        if self.lighting.set(solution, &self.document) {
            self.refresh_probes();
            self.lit();
        }
    }

    /// The light that came with files which were added to nothing.
    pub(super) fn take_light_of_file(&mut self) {
        if let Some(solution) = Solution::of_file(&self.document) {
            self.take_light(solution);
        }
    }

    /// The light is another one: what is on the disk is not all there is, and pictures are old.
    pub(super) fn lit(&mut self) {
        self.revision = self.new_revision();
        self.light = self.revision;
        self.changed_at.get_or_insert_with(Instant::now);
        self.redraw_picture();
    }

    pub(super) fn drop_light(&mut self) {
        self.stop_solving();
        self.lighting.aside = None;
        if self.lighting.solution.take().is_some() {
            self.lighting.is_current = false;
            self.lighting.range = None;
            self.lighting.measures.clear();
            self.refresh_probes();
            self.lit();
        }
    }

    /// Finds what the patch at a place sees, with the patches that the solver would make.
    pub(super) fn form_factors_from(&mut self, place: PatchAt) {
        self.jobs.cancel_kind(Kind::FormFactors);
        let (document, settings) = (self.document.clone(), self.lighting.settings);
        let threads = self.preferences.threads;
        let title = self.say("form factors");
        self.jobs
            .start(Kind::FormFactors, title, move |progress, outbox| {
                let seen = on_own_threads(threads, || {
                    seen_from(&document, &settings, &place, progress)
                })?;
                if let Some(seen) = seen {
                    outbox.send(Found::FormFactors(Box::new(seen)));
                }
                Ok(())
            });
    }
}
