//! The state of the workbench, and what each command does to it.
//!
//! Nothing here knows windows: a test or a script executes [`Command`]s and calls
//! [`App::poll`] until the jobs are done.

mod adding;
mod autosave;
mod editing;
mod files;
mod lighting;
mod materials;
mod probes;
mod render;
mod saving;
#[cfg(test)]
mod tests;

pub use lighting::{Lighting, Stopwatch};
pub use probes::{Probe, ProbeMeasurement, ProbeSurface};
pub use render::{RenderedImage, shown};
pub use saving::{OnDisk, PendingQuestion};

use crate::command::{Command, FileRequest, Selection};
use crate::document::{ItemId, SceneDocument};
use crate::history::History;
use crate::jobs::{Job, JobKind, JobMessage, Jobs, RepaintRequest};
use crate::preferences::Preferences;
use crate::recovery::Recovery;
use crate::view::{Backdrop, ModelView, sees_most, whole};
use azulejo::formats::Warning;
use azulejo::scene::Image;
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

/// What jobs find.
pub enum JobResult {
    /// A model from a file.
    Model(Box<files::LoadedModel>),
    /// A file that could not be read; others may follow.
    NoModel(PathBuf, String),
    /// The document is on the disk.
    Saved(saving::SavedModel),
    /// A copy for recovery is on the disk.
    Autosaved(u64),
    /// Light, with more to come perhaps.
    Light(Box<crate::document::Solution>),
    /// A picture with so many paths per pixel.
    Render(Box<Image>, u32),
    /// A picture for the background.
    Backdrop(Box<Image>),
    /// What a patch sees.
    FormFactors(Box<crate::first_pass::PatchFormFactors>),
    /// Irradiance at probes.
    Measured(Box<ProbeMeasurement>),
    /// Something to tell.
    Note(String),
}

/// How serious a message is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Good to know.
    Note,
    /// Something was skipped or mended.
    Warning,
    /// Something was not done.
    Error,
}

/// Something told.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// How serious.
    pub level: Severity,
    /// What.
    pub text: String,
    /// The object it is about.
    pub about: Option<ItemId>,
}

/// Where a person's things are kept; nowhere in tests.
#[derive(Clone, Debug, Default)]
pub struct UserDirs {
    /// The file of preferences.
    pub preferences: Option<PathBuf>,
    /// The folder of copies for recovery.
    pub recovery: Option<PathBuf>,
}

impl UserDirs {
    /// Where this system keeps such things.
    pub fn of_system() -> UserDirs {
        let dirs = directories::ProjectDirs::from("", "", "azulejo");
        UserDirs {
            preferences: (dirs.as_ref()).map(|p| p.config_dir().join("workbench.toml")),
            recovery: dirs.map(|p| p.data_local_dir().join("recovery")),
        }
    }
}

/// Everything there is.
pub struct App {
    /// What is being worked on.
    pub document: SceneDocument,
    /// What further commands are about.
    pub selection: Selection,
    /// How it is looked at.
    pub view: ModelView,
    /// The light, its solver and how it settles.
    pub lighting: Lighting,
    /// Places whose light is watched, in the order of their numbers.
    pub probes: Vec<Probe>,
    /// The picture that is being refined, if there is one.
    pub render: Option<RenderedImage>,
    /// Where the document is kept.
    pub file: Option<OnDisk>,
    /// What was told, the last at the end.
    pub messages: Vec<Message>,
    /// How many errors were told so far.
    pub errors: u64,
    /// A question that must be answered first.
    pub question: Option<PendingQuestion>,
    /// A file that a dialog is asked for.
    pub asking: Option<FileRequest>,
    /// Choices that outlive the session.
    pub preferences: Preferences,
    /// Whether the window should close.
    pub closing: bool,
    /// Counts documents: whoever keeps something made from one keeps the number too.
    revision: u64,
    /// The number of the light that is on it.
    light: u64,
    /// What is on the disk.
    saved: DocumentState,
    /// The revision with which this document began.
    began: u64,
    history: History<editing::UndoSnapshot>,
    /// Bytes that undo may hold; of a large document, more.
    undo_bytes: u64,
    /// The number that a document got last.
    latest: u64,
    jobs: Jobs<JobResult>,
    recovery: Recovery,
    preferences_file: Option<PathBuf>,
    loading: Option<files::Loading>,
    /// What is to be added to a copy for recovery, once it may be opened.
    after_recovery: Option<(PathBuf, Vec<PathBuf>)>,
    /// What is being written, by the numbers of the jobs.
    saves: Vec<(u64, PathBuf)>,
    /// What may be lost when the window closes.
    left: Option<AcceptedLoss>,
    /// Number of the last probe.
    pinned: u64,
    /// The document that probes were measured in.
    measured_in: Option<SceneDocument>,
    changed_at: Option<Instant>,
}

/// A revision of the document, and which light is on it: undo brings a revision back, but never
/// an earlier light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct DocumentState {
    revision: u64,
    light: u64,
}

/// A state whose loss was agreed to, or that is safe; and the solver whose light may be lost with
/// it.
#[derive(Clone, Copy, Debug)]
struct AcceptedLoss {
    state: DocumentState,
    solver: Option<u64>,
}

impl App {
    /// Begins with nothing. `repaint` asks for the window to be drawn.
    pub fn new(preferences: Preferences, dirs: UserDirs, repaint: RepaintRequest) -> App {
        let mut app = App {
            document: SceneDocument::default(),
            selection: Selection::default(),
            view: ModelView::default(),
            lighting: Lighting::default(),
            probes: Vec::new(),
            render: None,
            file: None,
            messages: Vec::new(),
            errors: 0,
            question: None,
            asking: None,
            preferences,
            closing: false,
            revision: 0,
            light: 0,
            saved: DocumentState::default(),
            began: 0,
            history: History::default(),
            undo_bytes: editing::UNDO_BYTES,
            latest: 0,
            jobs: Jobs::new(repaint),
            recovery: dirs.recovery.map_or_else(Recovery::disabled, Recovery::new),
            preferences_file: dirs.preferences,
            loading: None,
            after_recovery: None,
            saves: Vec::new(),
            left: None,
            pinned: 0,
            measured_in: None,
            changed_at: None,
        };
        app.view.false_color.map = app.preferences.color_map;
        app
    }

    /// An app for tests: English, nothing on the disk.
    pub fn quiet() -> App {
        let preferences = Preferences {
            language: crate::words::Language::English,
            autosave: 0,
            ..Preferences::default()
        };
        App::new(preferences, UserDirs::default(), Arc::new(|| ()))
    }

    /// Another way of asking for the window to be drawn.
    pub fn set_repaint(&mut self, repaint: RepaintRequest) {
        self.jobs.set_repaint(repaint);
    }

    /// Does what is asked for. What cannot be done is told in [`App::messages`].
    pub fn execute(&mut self, command: Command) {
        match command {
            Command::New | Command::Open(_) | Command::Quit | Command::Recover(_)
                if self.is_changed() =>
            {
                self.question = Some(PendingQuestion::Unsaved(Box::new(command)));
            }
            command => self.perform(command),
        }
    }

    /// Does it, whatever is lost by it.
    fn perform(&mut self, command: Command) {
        match command {
            Command::New => self.clear(),
            Command::Open(paths) => self.load(paths, true),
            Command::Add(paths) => self.load(paths, false),
            Command::Save => self.save(false),
            Command::SaveAnyway => self.save(true),
            Command::SaveAs(path) => self.save_as(path),
            Command::Export(path) => self.export(path),
            Command::SaveRender(path) => self.save_render(path),
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
            Command::LoadBackdrop(path) => self.load_backdrop(path),
            Command::SetLight(settings) => self.lighting.settings = settings,
            Command::Solve => self.solve(),
            Command::Pause => self.pause(true),
            Command::Resume => self.pause(false),
            Command::StopSolving => self.stop_solving(),
            Command::ClearLight => self.drop_light(),
            Command::FormFactorsFrom(place) => self.form_factors_from(place),
            Command::AddProbe(place) => self.pin(place),
            Command::RemoveProbe(number) => self.unpin(number),
            Command::MeasureProbes => self.measure_probes(),
            Command::Render {
                width,
                height,
                paths,
            } => {
                let most = paths.unwrap_or(self.preferences.picture_samples);
                self.start_render((width, height), most);
            }
            Command::StopRender => self.stop_render(),
            Command::Cancel(job) => self.cancel(job),
            Command::SetPreferences(preferences) => self.set_preferences(*preferences),
            Command::ClearMessages => self.messages.clear(),
        }
    }

    /// Takes in what jobs found since the last time; whether there was anything. Called whenever
    /// the window is drawn.
    pub fn poll(&mut self) -> bool {
        let mut any = false;
        self.take_measures();
        while let Some((job, news)) = self.jobs.next_message() {
            any = true;
            match news {
                JobMessage::Output(found) => self.take(&job, found),
                JobMessage::Ended(failure) => self.end(&job, failure),
            }
        }
        self.autosave();
        any
    }

    fn take(&mut self, job: &Job, found: JobResult) {
        match found {
            JobResult::Model(model) => self.take_model(job, *model),
            JobResult::NoModel(path, why) => self.take_failure(&path, &why),
            JobResult::Saved(saved) => self.take_saved(saved),
            JobResult::Autosaved(revision) => self.recovery.done(revision),
            JobResult::Light(solution) => self.take_light_of(job, *solution),
            JobResult::Render(image, samples) => self.take_render(*image, samples),
            JobResult::Backdrop(image) => self.take_backdrop(*image),
            JobResult::FormFactors(seen) => self.lighting.seen = Some(*seen),
            JobResult::Measured(measurement) => self.take_measurement(*measurement),
            JobResult::Note(text) => self.report(Severity::Note, text),
        }
    }

    fn end(&mut self, job: &Job, failure: Option<String>) {
        if let Some(why) = failure {
            match job.kind {
                // The same words every few seconds help nobody.
                JobKind::Autosave => self.recovery.failed(),
                JobKind::Load | JobKind::Save => {
                    // Who wanted to leave wants to know this first.
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
            JobKind::Solve => self.end_solving(),
            // Whatever became of it, what is changed waits for the next one.
            JobKind::Autosave if self.is_changed() => {
                self.changed_at.get_or_insert_with(Instant::now);
            }
            _ => {}
        }
    }

    /// `english` in the language of the window.
    pub(crate) fn tr<'s>(&self, english: &'s str) -> &'s str {
        self.preferences.language.tr(english)
    }

    /// Adds a message.
    pub fn report(&mut self, level: Severity, text: impl Into<String>) {
        const MAX_MESSAGES: usize = 1_000;
        self.errors += u64::from(level == Severity::Error);
        if self.messages.len() >= MAX_MESSAGES {
            self.messages.remove(0);
        }
        self.messages.push(Message {
            level,
            text: text.into(),
            about: None,
        });
    }

    /// Tells what was odd about a file that brought `items`: each warning leads to the first object
    /// that it names in quotes. Most are about a file as a whole: those lead to its content.
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

    /// Whether there is something that is not on the disk.
    pub fn is_changed(&self) -> bool {
        self.state() != self.saved
    }

    /// Counts documents: changes whenever the document does, and back with undo.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// The jobs that go on.
    pub fn jobs(&self) -> &[Job] {
        self.jobs.running()
    }

    /// Whether a job of this kind goes on.
    pub fn is_busy(&self, kind: JobKind) -> bool {
        self.jobs.of(kind).is_some()
    }

    /// What undo and redo would do.
    pub fn undo_labels(&self) -> (Option<&'static str>, Option<&'static str>) {
        (self.history.undo_label(), self.history.redo_label())
    }

    /// What was written before a crash and waits for an answer.
    pub fn recoverable(&self) -> &[crate::recovery::Recoverable] {
        self.recovery.recoverable()
    }

    fn state(&self) -> DocumentState {
        DocumentState {
            revision: self.revision,
            light: self.light,
        }
    }

    /// What is there may be lost, whatever it is.
    fn accept_loss(&self) -> AcceptedLoss {
        let solver = self.jobs.of(JobKind::Solve).filter(|_| self.is_changed());
        AcceptedLoss {
            state: self.state(),
            solver: solver.map(|job| job.id),
        }
    }

    /// Whether there is more to lose than what was agreed to.
    fn loses_unaccepted(&self, accepted: AcceptedLoss) -> bool {
        self.is_changed() && self.state() != accepted.state
    }

    /// Whether closing the window would lose what nobody agreed to lose.
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
        // A view without direction would show nothing ever after.
        if finite {
            self.view = view;
        }
        if moved {
            self.restart_render();
        }
    }

    /// Looks at all there is: by the file's own camera, if it shows the model, else by one that does.
    fn frame_all(&mut self) {
        let bounds = self.document.bounds(None);
        let own = self.document.cameras.first().map(|c| c.camera.clone());
        let own = own.filter(|camera| sees_most(camera, bounds) || self.is_room());
        let framing = || whole(bounds, self.document.units.up);
        self.view.camera = own.unwrap_or_else(framing);
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
            Some(JobKind::Render) => self.render = None,
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

    fn store_preferences(&mut self) {
        let Some(path) = &self.preferences_file else {
            return;
        };
        if let Err(why) = self.preferences.store(path) {
            self.report(Severity::Warning, why);
        }
    }

    fn take_backdrop(&mut self, image: Image) {
        let fit = match &self.view.backdrop {
            Backdrop::Image(_, fit) => *fit,
            _ => Default::default(),
        };
        self.view.backdrop = Backdrop::Image(Arc::new(image), fit);
    }

    fn clear(&mut self) {
        self.jobs.cancel_kind(JobKind::Load);
        (self.loading, self.after_recovery) = (None, None);
        self.replace(SceneDocument::default(), None);
    }

    /// Another document takes the place of this one, history and light included.
    fn replace(&mut self, document: SceneDocument, file: Option<OnDisk>) {
        self.stop_solving();
        self.stop_render();
        self.jobs.cancel_kind(JobKind::FormFactors);
        self.drop_probes();
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
        self.frame_all();
    }
}
