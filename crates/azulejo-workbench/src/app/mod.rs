//! The state of the workbench, and the effect of each command on it.
//!
//! This module is independent of the window: a test or a script executes [`Command`]s and calls
//! [`App::poll`] until the jobs are done.

mod adding;
mod autosave;
mod bake;
mod editing;
mod exposure;
mod failures;
mod files;
mod lab;
pub(crate) mod light_unit;
mod lighting;
mod materials;
#[cfg(any(test, target_arch = "wasm32"))]
mod parcel;
mod probes;
mod recipes;
mod render;
mod saving;
mod table;
mod task_plane;
#[cfg(test)]
mod tests;
mod thumbnails;

pub use bake::{LightmapState, ViewportLightmap};
pub use lighting::{IrradianceRange, Lighting, Stopwatch};
pub use probes::{Probe, ProbeMeasurement, ProbeSurface};
pub use render::{RenderedImage, shown};
pub use saving::{FinerMesh, OnDisk, PendingQuestion};
pub use task_plane::{Measured, TaskPlane, TaskPlaneFigures, TaskPlaneState};
pub use thumbnails::{THUMBNAIL, Thumbnails};

use crate::command::{Command, FileRequest, Selection};
use crate::document::{ItemId, SceneDocument};
use crate::history::History;
use crate::jobs::{Job, JobKind, JobMessage, JobSender, Jobs, RepaintRequest, in_thread_pool};
use crate::lab::LabState;
use crate::preferences::{Preferences, WindowPlace};
use crate::recovery::Recovery;
use crate::view::{ModelView, Shading, camera_around, sees_all, sees_most};
use azulejo::formats::Warning;
use azulejo::scene::{Camera, Image, LightKind, Texture};
use azulejo::trace::time::Instant;
use azulejo::trace::{Progress, Tracer};
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

/// A result sent by a job.
pub enum JobResult {
    /// A model read from a file.
    Model(Box<files::LoadedModel>),
    /// Why a file could not be read; others may follow.
    NoModel(String),
    /// The document has been saved.
    Saved(saving::SavedModel),
    /// A recovery copy of this revision has been written.
    Autosaved(u64),
    /// A light solution; more accurate ones may follow.
    Light(Box<crate::document::Solution>),
    /// A rendered image with its number of paths per pixel.
    Render(Box<Image>, u32),
    /// A lightmap.
    Baked(Box<crate::bake::BakedDocument>),
    /// An image for the background.
    Backplate(Arc<Texture>),
    /// A picture of the surroundings, with warnings.
    Environment(files::LoadedEnvironment),
    /// Form factors of a patch.
    FormFactors(Box<crate::first_pass::PatchFormFactors>),
    /// One engine with one number of samples, of several that are compared.
    EngineRun(crate::engine_comparison::EngineRun),
    /// Irradiance measured at probes.
    Measured(Box<ProbeMeasurement>),
    /// A measured task plane.
    TaskPlane(Box<TaskPlane>),
    /// A message for the user.
    Note(String),
    /// One of these from a worker of a page, as bytes.
    #[cfg(target_arch = "wasm32")]
    Parcel(Vec<u8>),
}

/// Severity of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Information.
    Note,
    /// Something was skipped or repaired.
    Warning,
    /// An operation failed.
    Error,
}

/// An entry of the message list.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// Whether it is a note, a warning or an error.
    pub level: Severity,
    /// Its text in the language of the window.
    pub text: String,
    /// The object that it concerns.
    pub about: Option<ItemId>,
}

/// Per-user files and folders; all are `None` in tests.
#[derive(Clone, Debug, Default)]
pub struct UserDirs {
    /// The file of the preferences, `workbench.toml`.
    pub preferences: Option<PathBuf>,
    /// The folder for recovery copies.
    pub recovery: Option<PathBuf>,
    /// The folder for small pictures of recent files.
    pub thumbnails: Option<PathBuf>,
}

impl UserDirs {
    /// The standard locations on this system.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn of_system() -> UserDirs {
        let dirs = directories::ProjectDirs::from("", "", "azulejo");
        UserDirs {
            preferences: (dirs.as_ref()).map(|p| p.config_dir().join("workbench.toml")),
            thumbnails: dirs.as_ref().map(|p| p.cache_dir().join("thumbnails")),
            recovery: dirs.map(|p| p.data_local_dir().join("recovery")),
        }
    }
}

/// The complete state of the workbench.
#[derive(Default)]
pub struct App {
    /// The document being edited.
    pub document: SceneDocument,
    /// The objects, faces or material that commands apply to.
    pub selection: Selection,
    /// The camera and display settings of the viewport.
    pub view: ModelView,
    /// The light solution and its solver.
    pub lighting: Lighting,
    /// The last lightmap, and the settings for the next.
    pub lightmap: LightmapState,
    /// The lab.
    pub lab: LabState,
    /// Pinned probes in the order of their numbers.
    pub probes: Vec<Probe>,
    /// Where the task plane lies, and what was measured on it.
    pub task_plane: TaskPlaneState,
    /// The image being rendered, if there is one.
    pub render: Option<RenderedImage>,
    /// The file of the document.
    pub file: Option<OnDisk>,
    /// The message list, oldest first.
    pub messages: Vec<Message>,
    /// Number of errors reported so far.
    pub errors: u64,
    /// The last error, until the user has seen it.
    pub failure: Option<String>,
    /// The rendered image that was closed last, with what it shows.
    closed_render: Option<(render::RenderSubject, RenderedImage)>,
    /// A question that the user must answer first.
    pub question: Option<PendingQuestion>,
    /// The purpose of the open file dialog, if there is one.
    pub asking: Option<FileRequest>,
    /// Settings kept between sessions.
    pub preferences: Preferences,
    /// Whether the window should close.
    pub closing: bool,
    /// The file last saved, if light made its mesh finer than the model.
    pub finer_mesh: Option<FinerMesh>,
    /// The file to save once the light is solved.
    save_when_solved: Option<PathBuf>,
    /// Small pictures of recent files.
    pub thumbnails: Thumbnails,
    /// The file whose thumbnail the viewport makes once it has drawn the model.
    pub thumbnail_wanted: Option<PathBuf>,
    /// Revision of the document: a new number for every change, restored by undo. Cached data
    /// stores it as its key.
    revision: u64,
    /// Number of the light solution on the document.
    light: u64,
    /// The state last saved.
    saved: DocumentState,
    /// The first revision of this document.
    began: u64,
    history: History<editing::UndoSnapshot>,
    /// Memory limit of the undo history in bytes; larger documents get more.
    undo_bytes: u64,
    /// The highest revision assigned so far.
    latest: u64,
    jobs: Jobs<JobResult>,
    recovery: Recovery,
    preferences_file: Option<PathBuf>,
    loading: Option<files::Loading>,
    /// The recipes that are noted beside each model on disk.
    noted_recipes: HashMap<PathBuf, Vec<PathBuf>>,
    /// A recovery copy, and the files to add once the user has decided whether to open it.
    after_recovery: Option<(PathBuf, Vec<PathBuf>)>,
    /// Files being written, with the numbers of their jobs.
    saves: Vec<(u64, PathBuf)>,
    /// What the user agreed to lose when the window closes.
    left: Option<AcceptedLoss>,
    /// Number of the last probe.
    pinned: u64,
    /// The document in which the probes were measured.
    measured_in: Option<SceneDocument>,
    changed_at: Option<Instant>,
    /// The documents of jobs that run in workers, by their numbers.
    #[cfg(target_arch = "wasm32")]
    sent: Vec<(u64, SceneDocument)>,
    /// All commands and edits so far.
    #[cfg(test)]
    pub(crate) executed: (Vec<Command>, Vec<crate::document::Edit>),
}

/// Revision of the document and number of its light solution. Undo restores a revision, but never
/// an earlier solution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct DocumentState {
    revision: u64,
    light: u64,
}

/// A state that is saved or whose loss was accepted, and the solver job whose light may be lost
/// with it.
#[derive(Clone, Copy, Debug)]
struct AcceptedLoss {
    state: DocumentState,
    solver: Option<u64>,
}

impl App {
    /// Creates an empty document. `repaint` requests a repaint of the window.
    pub fn new(preferences: Preferences, dirs: UserDirs, repaint: RepaintRequest) -> App {
        let mut app = App {
            preferences,
            thumbnails: Thumbnails::new(dirs.thumbnails),
            undo_bytes: editing::UNDO_BYTES,
            jobs: Jobs::new(repaint),
            recovery: dirs.recovery.map(Recovery::new).unwrap_or_default(),
            preferences_file: dirs.preferences,
            ..App::default()
        };
        app.view.false_color.map = app.preferences.color_map;
        app
    }

    /// Creates an app for tests: in English, without files on disk.
    pub fn quiet() -> App {
        let preferences = Preferences {
            language: crate::words::Language::English,
            autosave: 0,
            ..Preferences::default()
        };
        App::new(preferences, UserDirs::default(), Arc::new(|| ()))
    }

    /// Replaces the function that requests a repaint.
    pub fn set_repaint(&mut self, repaint: RepaintRequest) {
        self.jobs.set_repaint(repaint);
    }

    /// Executes a command. Failures are reported in [`App::messages`].
    pub fn execute(&mut self, command: Command) {
        // What is done next is the answer to a failure, unless it only looks around.
        if !matches!(command, Command::SetView(_) | Command::Select(_)) {
            self.failure = None;
        }
        #[cfg(test)]
        self.executed.0.push(command.clone());
        match command {
            Command::New
            | Command::Open(_)
            | Command::OpenExample(_)
            | Command::OpenLesson
            | Command::Quit
            | Command::Recover(_)
                if self.is_changed() =>
            {
                self.question = Some(PendingQuestion::Unsaved(Box::new(command)));
            }
            command => self.perform(command),
        }
    }

    /// Executes a command without asking about unsaved changes.
    fn perform(&mut self, command: Command) {
        match command {
            Command::New => self.clear(),
            Command::Open(paths) => self.load(paths, true),
            Command::OpenExample(example) => {
                self.clear();
                match example.document() {
                    Ok(document) => self.replace(document, None),
                    Err(refused) => self.report(Severity::Error, refused.0),
                }
            }
            Command::ShowLab(lesson) => self.show_lab(lesson),
            Command::OpenLesson => self.open_lesson(),
            Command::Add(paths) => self.load(paths, false),
            Command::Save => self.save(false),
            Command::SaveAnyway => self.save(true),
            Command::KeepFaces => self.keep_faces(),
            Command::DismissFinerMesh => self.finer_mesh = None,
            Command::SaveAs(path) => self.save_as(path),
            Command::Export(path) => self.export(path),
            Command::SaveRender(path) => self.save_render(path),
            Command::RequestFile(FileRequest::SaveRender) if self.is_busy(JobKind::Render) => {
                self.question = Some(PendingQuestion::UnfinishedRender);
            }
            Command::RequestFile(what) => self.asking = Some(what),
            Command::DialogClosed => self.asking = None,
            Command::Quit => self.allow_close(),
            Command::Discard => self.discard(),
            Command::CancelPending => (self.question, self.asking) = (None, None),
            Command::Recover(path) => self.recover(path),
            Command::DeleteRecovery(path) => self.recovery.delete(&path),
            Command::Edit(edit, gesture) => self.edit(&edit, gesture),
            Command::AddShape(kind) => self.add_shape(kind),
            Command::AddLight(kind) => self.add_light(kind),
            Command::ApplyRecipe(path) => self.apply_recipe(path),
            Command::LoadEnvironment(path, into) => self.load_environment(path, into),
            Command::AddText {
                text,
                size,
                depth,
                font,
            } => self.add_text(&text, size, depth, font),
            Command::AddPrism { base, size, height } => self.add_prism(&base, size, height),
            Command::Undo => self.undo(),
            Command::Redo => self.redo(),
            Command::Select(selection) => self.select(selection),
            Command::SelectAll => self.select_all(),
            Command::SetView(view) => self.set_view(*view),
            Command::LoadBackplate(path) => self.load_backplate(path),
            Command::SetLight(settings) => self.lighting.settings = settings,
            Command::Solve => self.solve(),
            Command::Pause => self.pause(true),
            Command::Resume => self.pause(false),
            Command::StopSolving => self.stop_solving(),
            Command::ClearLight => self.clear_light(),
            Command::FormFactorsFrom(place) => self.form_factors_from(place),
            Command::CompareEngines => self.compare_engines(),
            Command::AddProbe(place) => self.add_probe(place),
            Command::RemoveProbe(number) => self.remove_probe(number),
            Command::MeasureProbes => self.measure_probes(),
            Command::SaveProbes(path) => self.save_probes(path),
            Command::SetTaskPlane(settings) => self.task_plane.settings = settings,
            Command::AddTaskPlane => self.add_task_plane(),
            Command::MeasureTaskPlane => self.measure_task_plane(),
            Command::RemoveTaskPlane => self.remove_task_plane(),
            Command::SaveTaskPlane(path) => self.save_task_plane(path),
            Command::Render {
                width,
                height,
                paths,
            } => {
                let most = paths.unwrap_or(self.preferences.picture_samples);
                self.start_render((width, height), most);
            }
            Command::StopRender => self.stop_render(),
            Command::ResumeRender => self.resume_render(),
            Command::CloseRender => self.close_render(),
            Command::SaveUnfinishedRender => {
                (self.question, self.asking) = (None, Some(FileRequest::SaveRender));
            }
            Command::SetBake(settings) => self.lightmap.settings = settings,
            Command::Bake => self.bake(),
            Command::ShowLightmap(is_shown) => self.show_lightmap(is_shown),
            Command::SaveLightmap(what, path) => self.save_lightmap(what, path),
            Command::Cancel(job) => self.cancel(job),
            Command::SetPreferences(preferences) => self.set_preferences(*preferences),
            Command::ClearMessages => self.messages.clear(),
            Command::DismissFailure => self.failure = None,
        }
    }

    /// Processes the results of jobs since the last call; returns whether there were any. Called in
    /// every frame.
    pub fn poll(&mut self) -> bool {
        let mut any = false;
        self.take_measures();
        while let Some((job, message)) = self.jobs.next_message() {
            any = true;
            match message {
                JobMessage::Output(result) => self.take(&job, result),
                JobMessage::Ended(failure) => self.end(&job, failure),
            }
        }
        self.autosave();
        any
    }

    fn take(&mut self, job: &Job, result: JobResult) {
        match result {
            JobResult::Model(model) => self.take_model(job, *model),
            JobResult::NoModel(why) => self.report(Severity::Error, why),
            JobResult::Saved(saved) => self.take_saved(saved),
            JobResult::Autosaved(revision) => self.recovery.done(revision),
            JobResult::Light(solution) => self.take_light_of(job, *solution),
            JobResult::Render(image, samples) => self.take_render(*image, samples),
            JobResult::Baked(baked) => self.take_baked(*baked),
            JobResult::Backplate(texture) => self.take_backplate(texture),
            JobResult::Environment(loaded) => self.take_environment(loaded),
            JobResult::FormFactors(factors) => {
                self.lighting.form_factors = Some(*factors);
                self.lighting.engine_runs.clear();
            }
            JobResult::EngineRun(run) => self.lighting.engine_runs.push(run),
            JobResult::Measured(measurement) => self.take_measurement(*measurement),
            JobResult::TaskPlane(plane) => self.take_task_plane(*plane),
            JobResult::Note(text) => self.report(Severity::Note, text),
            #[cfg(target_arch = "wasm32")]
            JobResult::Parcel(bytes) => match self.open_parcel(job.id, &bytes) {
                Some(result) => self.take(job, result),
                None => self.report(
                    Severity::Error,
                    format!("{}: internal error: damaged result", job.title),
                ),
            },
        }
    }

    fn end(&mut self, job: &Job, failure: Option<String>) {
        if let Some(why) = failure {
            match job.kind {
                // Repeating the same message every few seconds would not help.
                JobKind::Autosave => self.recovery.failed(),
                JobKind::Load | JobKind::Save => {
                    // Keep the window open so that the user sees the error.
                    self.closing = false;
                    self.question = self
                        .question
                        .take()
                        .filter(PendingQuestion::survives_job_failure);
                }
                _ => {}
            }
            self.report(Severity::Error, format!("{}: {why}", job.title));
        }
        match job.kind {
            JobKind::Load => self.end_loading(),
            JobKind::Solve => {
                self.end_solving();
                self.save_solved();
            }
            JobKind::Render => self.end_render(),
            // Whatever happened to this copy, remaining changes are written by the next one.
            JobKind::Autosave if self.is_changed() => {
                self.changed_at.get_or_insert_with(Instant::now);
            }
            _ => {}
        }
    }

    /// Translates `english` to the language of the window.
    pub(crate) fn tr<'s>(&self, english: &'s str) -> &'s str {
        self.preferences.language.tr(english)
    }

    /// Reports that a command cannot be executed, and why.
    fn fail(&mut self, why: &str) {
        self.report(Severity::Error, why);
    }

    /// Starts a job of which there is only one at a time, in a thread pool of its own.
    fn start_job(
        &mut self,
        kind: JobKind,
        title: &str,
        work: impl FnOnce(&Progress, &JobSender<JobResult>) -> Result<(), String> + Send + 'static,
    ) {
        self.jobs.cancel_kind(kind);
        let threads = self.preferences.threads;
        let _id = self.jobs.start(kind, title, move |progress, outbox| {
            in_thread_pool(threads, || work(progress, outbox))
        });
        #[cfg(target_arch = "wasm32")]
        {
            let jobs = &self.jobs;
            let runs = |id: u64| jobs.running().iter().any(|job| job.id == id);
            self.sent.retain(|(id, _)| runs(*id));
            self.sent.push((_id, self.document.clone()));
        }
    }

    /// Adds an entry to the message list.
    pub fn report(&mut self, level: Severity, text: impl Into<String>) {
        const MAX_MESSAGES: usize = 1_000;
        self.errors += u64::from(level == Severity::Error);
        if self.messages.len() >= MAX_MESSAGES {
            self.messages.remove(0);
        }
        let text = text.into();
        if level == Severity::Error {
            self.failure = Some(text.clone());
        }
        self.messages.push(Message {
            level,
            text,
            about: None,
        });
    }

    /// Reports the warnings of a file that created `items`. A warning links to the first object
    /// that it names in quotes, and otherwise to the whole content of the file.
    fn report_warnings(&mut self, warnings: &[Warning], items: &[ItemId]) {
        let mut named: HashMap<String, ItemId> = HashMap::new();
        for &id in items.iter().filter(|_| !warnings.is_empty()) {
            let name = self.document.name(id).unwrap_or_default();
            let last = name.rsplit('/').next().unwrap_or_default();
            named.entry(last.to_owned()).or_insert(id);
        }
        named.remove("");
        for warning in warnings {
            self.report(Severity::Warning, warning.to_string());
            let mut quoted = warning.message.split('"').skip(1).step_by(2);
            let about = quoted.find_map(|name| named.get(name).copied());
            if let Some(message) = self.messages.last_mut() {
                message.about = about.or(items.first().copied());
            }
        }
    }

    /// Whether there are unsaved changes.
    pub fn is_changed(&self) -> bool {
        self.state() != self.saved
    }

    /// Revision of the document: changes with every edit and is restored by undo.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Whether there is nothing yet, and nothing being loaded.
    pub fn is_blank(&self) -> bool {
        self.document.is_empty() && !self.is_busy(JobKind::Load) && self.render.is_none()
    }

    /// The running jobs.
    pub fn jobs(&self) -> &[Job] {
        self.jobs.running()
    }

    /// Whether a job of this kind is running.
    pub fn is_busy(&self, kind: JobKind) -> bool {
        self.jobs.of(kind).is_some()
    }

    /// Labels of the edits that undo and redo would apply.
    pub fn undo_labels(&self) -> (Option<&'static str>, Option<&'static str>) {
        (self.history.undo_label(), self.history.redo_label())
    }

    /// What undo and redo would apply, in the language of the window: the edit, and the name of the
    /// one thing that it concerns.
    pub fn undo_texts(&self) -> (Option<String>, Option<String>) {
        let language = self.preferences.language;
        let text = |label: Option<&'static str>, about: Option<&str>| {
            let label = language.tr(label?);
            Some(match about {
                Some(name) => format!("{label} {}", language.quoted(name)),
                None => label.to_owned(),
            })
        };
        let history = &self.history;
        (
            text(history.undo_label(), history.undo_about()),
            text(history.redo_label(), history.redo_about()),
        )
    }

    /// Recovery copies about which the user has not decided yet.
    pub fn recoverable(&self) -> &[crate::recovery::Recoverable] {
        self.recovery.recoverable()
    }

    fn state(&self) -> DocumentState {
        DocumentState {
            revision: self.revision,
            light: self.light,
        }
    }

    /// Accepts the loss of the current state.
    fn accept_loss(&self) -> AcceptedLoss {
        let solver = self.jobs.of(JobKind::Solve).filter(|_| self.is_changed());
        AcceptedLoss {
            state: self.state(),
            solver: solver.map(|job| job.id),
        }
    }

    /// Whether more would be lost than the user has accepted.
    fn loses_unaccepted(&self, accepted: AcceptedLoss) -> bool {
        self.is_changed() && self.state() != accepted.state
    }

    /// Whether closing the window would lose changes without the user's consent.
    pub fn close_loses_changes(&self) -> bool {
        let left = self.left.filter(|_| self.closing);
        left.map_or(self.is_changed(), |accepted| {
            self.loses_unaccepted(accepted)
        })
    }

    fn set_view(&mut self, view: ModelView) {
        let moved = view.camera != self.view.camera;
        let finite = {
            let (x, y, z) = view.camera.axes();
            x.is_finite() && y.is_finite() && z.is_finite() && view.camera.eye.is_finite()
        };
        // A view without a direction would leave the viewport empty for good.
        if finite {
            self.view = view;
        }
        if moved {
            self.restart_render();
        }
    }

    /// Shows the whole model: from the file's own camera if it sees most of the model, otherwise
    /// from a default one.
    fn frame_all(&mut self) {
        let bounds = self.document.model_bounds();
        let own = self.document.cameras.first().map(|c| c.camera.clone());
        let own = own.filter(|camera| sees_most(camera, bounds) || self.is_within(camera));
        let framing = || camera_around(bounds, self.view.aspect, self.document.units.up);
        self.view.camera = own.unwrap_or_else(framing);
    }

    /// Whether a camera stands within the model and looks at some of it: the view of a room that
    /// its author has chosen.
    fn is_within(&self, camera: &Camera) -> bool {
        let (eye, bounds) = (camera.eye, self.document.bounds(None));
        if !(bounds.min.cmple(eye) & eye.cmple(bounds.max)).all() {
            return false;
        }
        let tracer = Tracer::new(&self.document.scene());
        let places = [(0.5, 0.5), (0.2, 0.3), (0.8, 0.3), (0.2, 0.8), (0.8, 0.8)];
        let seen = places.iter().filter(|(x, y)| {
            let ray = camera.ray(*x, *y, 1.0);
            tracer.hit(&ray).is_some_and(|hit| hit.entering)
        });
        seen.count() >= 3
    }

    /// Moves a view from outside of the model so that it shows all of it in the shape of the
    /// viewport.
    fn frame_from_outside(&mut self) {
        let (eye, bounds) = (self.view.camera.eye, self.document.model_bounds());
        let is_within = (bounds.min.cmple(eye) & eye.cmple(bounds.max)).all();
        if !is_within && !sees_all(&self.view.camera, self.view.aspect, bounds) {
            self.view.frame(bounds);
        }
    }

    /// Moves the view back until it shows these items, if some of them is not in it.
    fn reveal(&mut self, ids: &[ItemId]) {
        // Light from everywhere has a marker, but no place.
        let has_place = |id: &&ItemId| {
            let light = self.document.light(**id);
            !light.is_some_and(|l| {
                matches!(
                    l.light.kind,
                    LightKind::Directional { .. }
                        | LightKind::Ambient { .. }
                        | LightKind::Environment(_)
                )
            })
        };
        let ids: Vec<ItemId> = ids.iter().filter(has_place).copied().collect();
        let bounds = self.document.frame_of(&ids);
        if bounds.is_empty() || sees_all(&self.view.camera, self.view.aspect, bounds) {
            return;
        }
        let bounds = self.document.model_bounds().union(bounds);
        self.view.frame(bounds);
    }

    fn cancel(&mut self, id: u64) {
        let kind = self
            .jobs
            .running()
            .iter()
            .find(|j| j.id == id)
            .map(|j| j.kind);
        self.jobs.cancel(id);
        match kind {
            Some(JobKind::Load) => self.end_loading(),
            Some(JobKind::Solve) => self.end_solving(),
            Some(JobKind::Render) => self.stop_render(),
            _ => {}
        }
    }

    fn set_preferences(&mut self, preferences: Preferences) {
        if preferences.color_map != self.preferences.color_map {
            self.view.false_color.map = preferences.color_map;
        }
        let gathers = preferences.picture_gather != self.preferences.picture_gather;
        self.preferences = preferences;
        self.store_preferences();
        if gathers {
            self.restart_render();
        }
    }

    /// Keeps the place of the window, at the end of a session. Another window may have changed other
    /// preferences since this one read them: those stay.
    pub fn keep_window(&mut self, place: WindowPlace) {
        if place == self.preferences.window {
            return;
        }
        self.preferences.window = place;
        let Some(path) = &self.preferences_file else {
            return;
        };
        let (mut latest, trouble) = Preferences::load(path);
        latest.window = place;
        if trouble.is_none() {
            // Nobody is left to read why it failed.
            let _ = latest.store(path);
        }
    }

    fn store_preferences(&mut self) {
        let Some(path) = &self.preferences_file else {
            return;
        };
        if let Err(why) = self.preferences.store(path) {
            self.report(Severity::Warning, why);
        }
    }

    fn clear(&mut self) {
        self.jobs.cancel_kind(JobKind::Load);
        (self.loading, self.after_recovery) = (None, None);
        self.replace(SceneDocument::default(), None);
    }

    /// Replaces the document together with its history and light.
    fn replace(&mut self, document: SceneDocument, file: Option<OnDisk>) {
        self.stop_solving();
        self.close_render();
        self.jobs.cancel_kind(JobKind::FormFactors);
        self.drop_probes();
        self.remove_task_plane();
        self.document = document;
        self.file = file;
        self.history = History::default();
        self.selection = Selection::default();
        self.revision = self.new_revision();
        self.began = self.revision;
        self.saved = self.state();
        self.changed_at = None;
        self.forget_copy();
        self.lighting.replaced(&self.document);
        self.drop_lightmap();
        (self.finer_mesh, self.save_when_solved) = (None, None);
        self.frame_all();
        // What was set for the light of another model does not suit this one.
        self.view.exposure = None;
        if self.lighting.solution.is_none() && self.view.shading.shows_light() {
            self.view.shading = ModelView::default().shading;
        }
        self.show_own_light();
    }

    /// Shows the light that came with a file.
    fn show_own_light(&mut self) {
        if self.lighting.solution.is_some() && !self.view.shading.shows_light() {
            self.view.shading = Shading::Irradiance;
        }
    }
}
