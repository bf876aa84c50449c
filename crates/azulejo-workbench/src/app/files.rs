//! Opening, saving, recovering.

use super::{App, Found, Level, State};
use crate::command::{Ask, Command};
use crate::document::{Branch, Document, Edit, Solution};
use crate::jobs::{Job, Kind};
use crate::words::Language;
use azulejo::formats::Warning;
use azulejo::models;
use azulejo::output::Output;
use azulejo::scene::Units;
use azulejo::trace::Progress;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// Something that must be answered before anything else.
#[derive(Clone, Debug, PartialEq)]
pub enum Question {
    /// There are changes that would be lost by what was asked for.
    Unsaved(Box<Command>),
    /// Somebody else wrote the file since it was read.
    ChangedOnDisk(PathBuf),
}

impl Question {
    /// Whether it still makes sense when a job failed: what waits for a save does not go on.
    pub(super) fn outlives_failure(&self) -> bool {
        matches!(self, Question::ChangedOnDisk(_))
    }
}

/// A file, as it was when it was read or written last.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OnDisk {
    /// Where.
    pub path: PathBuf,
    /// Its time and length.
    stamp: Stamp,
    /// The same of what others wrote and a person was told of. Saving over it is still asked about.
    told: Stamp,
}

/// When a file was written, and how long it is; `None` for one that is not there.
type Stamp = Option<(SystemTime, u64)>;

impl OnDisk {
    /// The file as it is now.
    pub fn now(path: &Path) -> OnDisk {
        let stamp = stamp(path);
        OnDisk {
            path: path.to_owned(),
            stamp,
            told: stamp,
        }
    }

    /// A file that was never read or written here.
    fn unread(path: PathBuf) -> OnDisk {
        OnDisk {
            path,
            stamp: None,
            told: None,
        }
    }

    /// Whether it was written or removed since, and nobody was told yet; now somebody is.
    fn is_news(&mut self) -> bool {
        let now = stamp(&self.path);
        std::mem::replace(&mut self.told, now) != now
    }

    /// Whether it was written or removed since.
    pub fn has_changed(&self) -> bool {
        stamp(&self.path) != self.stamp
    }
}

fn stamp(path: &Path) -> Stamp {
    let meta = std::fs::metadata(path).ok()?;
    Some((meta.modified().ok()?, meta.len()))
}

/// A model on its way into the document.
pub struct LoadedModel {
    path: PathBuf,
    on_disk: OnDisk,
    document: Document,
    warnings: Vec<Warning>,
    notes: Vec<String>,
}

/// A document that was written.
pub struct SavedModel {
    path: PathBuf,
    losses: Vec<String>,
    /// What was written, if the path is now the document's own; else it was an export.
    state: Option<State>,
    lit: bool,
}

/// Files on their way in.
pub(super) struct Loading {
    /// Whether the first of them takes the place of the document.
    replaces: bool,
    /// Whether it is what was written before a crash.
    recovered: bool,
    /// The edits that were made when it began, or whose loss was agreed to.
    edits: u64,
    /// What was asked for.
    command: Command,
    /// What is to be added when these are there.
    then: Vec<PathBuf>,
}

impl App {
    /// Reads files in the background. What is added waits for what is on its way.
    pub(super) fn load(&mut self, paths: Vec<PathBuf>, replaces: bool) {
        if paths.is_empty() {
            return;
        }
        match &mut self.loading {
            Some(loading) if !replaces => loading.then.extend(paths),
            _ => self.begin_loading(paths, replaces, false),
        }
    }

    fn begin_loading(&mut self, paths: Vec<PathBuf>, replaces: bool, recovered: bool) {
        if let Some(job) = self.jobs.of(Kind::Load) {
            // What is opened takes the place of what would have come.
            let text = format!("{}: {}", job.title, self.say("given up for another file"));
            self.tell(Level::Warning, text);
        }
        self.jobs.cancel_kind(Kind::Load);
        let command = match recovered {
            true => Command::Recover(paths[0].clone()),
            false => Command::Open(paths.clone()),
        };
        self.loading = Some(Loading {
            replaces,
            recovered,
            edits: self.edits,
            command,
            then: Vec::new(),
        });
        let keeps = !replaces && !self.document.is_empty();
        let units = keeps.then_some(self.document.units);
        let branches = self.document.branches.iter().map(|b| b.name.clone());
        let taken: Vec<String> = if keeps {
            branches.collect()
        } else {
            Vec::new()
        };
        let title = match &paths[..] {
            [one] => one.display().to_string(),
            several => format!("{} {}", several.len(), self.say("files")),
        };
        self.jobs.start(Kind::Load, title, move |progress, outbox| {
            let mut reader = Reader { units, taken };
            for path in paths {
                match reader.read(&path, progress) {
                    Ok(model) => outbox.send(Found::Model(Box::new(model))),
                    Err(models::ReadFailure::Cancelled) => return Ok(()),
                    Err(failure) => outbox.send(Found::NoModel(path, failure.to_string())),
                }
            }
            Ok(())
        });
    }

    pub(super) fn take_model(&mut self, job: &Job, model: LoadedModel) {
        let LoadedModel {
            path,
            on_disk,
            document,
            warnings,
            notes,
        } = model;
        let Some(loading) = &mut self.loading else {
            return;
        };
        let (replaces, recovered) = (loading.replaces, loading.recovered);
        if replaces && loading.edits != self.edits {
            // Nobody agreed to lose what was done while the file was read.
            let mut command = loading.command.clone();
            if let Command::Open(paths) = &mut command {
                paths.append(&mut loading.then);
            }
            self.question = Some(Question::Unsaved(Box::new(command)));
            self.jobs.cancel(job.id);
            return self.end_loading();
        }
        loading.replaces = false;
        let before = self.document.items.len();
        let summary = summary(
            &document,
            &path,
            job.started.elapsed(),
            self.preferences.language,
        );
        if replaces {
            let file = (!recovered).then_some(on_disk);
            self.replace(document, file);
            if recovered {
                self.adopt_recovered(&path);
            }
        } else {
            let was_empty = self.document.items.is_empty();
            self.edit(&Edit::Append(Box::new(document)), None);
            if was_empty {
                self.look_at_all();
            }
        }
        if !recovered {
            self.preferences.note_recent(&path);
            self.store_preferences();
        }
        let start = if replaces { 0 } else { before };
        let items = self.document.items.get(start..).unwrap_or_default();
        let ids: Vec<_> = items.iter().map(|i| i.id).collect();
        self.tell_warnings(&warnings, &ids);
        notes.into_iter().for_each(|n| self.tell(Level::Note, n));
        self.tell(Level::Note, summary);
    }

    pub(super) fn take_failure(&mut self, path: &Path, why: &str) {
        let named = why.contains(&*path.to_string_lossy());
        let text = match named {
            true => why.to_owned(),
            false => format!("{}: {why}", path.display()),
        };
        self.tell(Level::Error, text);
    }

    /// These files are there, or given up; those that wait are next.
    pub(super) fn end_loading(&mut self) {
        let then = self.loading.take().map(|loading| loading.then);
        self.load(then.unwrap_or_default(), false);
    }

    /// Saves where the document came from, if its format keeps light.
    pub(super) fn save(&mut self, anyway: bool) {
        let known = self.file.clone();
        let writable = known.filter(|f| {
            let format = models::by_extension(&f.path);
            format.is_some_and(|format| format.extension == "grf")
        });
        match writable {
            None => self.asking = Some(Ask::SaveAs),
            Some(file) if file.has_changed() && file.path.exists() && !anyway => {
                self.question = Some(Question::ChangedOnDisk(file.path));
            }
            Some(file) => self.save_as(file.path),
        }
    }

    /// Saves under a name, which becomes the document's.
    pub(super) fn save_as(&mut self, path: PathBuf) {
        if let Some(Question::ChangedOnDisk(_)) = self.question {
            self.question = None;
        }
        self.asking = None;
        let path = match path.extension() {
            Some(_) => path,
            None => path.with_extension("grf"),
        };
        // Other formats forget lights and solved light: what is written there is not saved.
        let keeps_all = models::by_extension(&path).is_some_and(|f| f.extension == "grf");
        let state = keeps_all.then(|| self.state());
        self.write(path, state);
    }

    /// Saves a copy; the document keeps its name.
    pub(super) fn export(&mut self, path: PathBuf) {
        self.asking = None;
        self.write(path, None);
    }

    fn write(&mut self, path: PathBuf, state: Option<State>) {
        let document = self.document.clone();
        let solution = self.lighting.solution.clone();
        let title = path.display().to_string();
        self.jobs.start(Kind::Save, title, move |progress, outbox| {
            let (scene, lit) = document.lit_scene(solution.as_deref());
            let losses = models::write(&scene, &path, progress).map_err(|e| e.to_string())?;
            outbox.send(Found::Saved(SavedModel {
                path,
                losses,
                state,
                lit,
            }));
            Ok(())
        });
    }

    pub(super) fn take_saved(&mut self, saved: SavedModel) {
        let name = saved.path.display();
        let said = match (saved.lit, &self.lighting.solution) {
            (true, _) => self.say("saved with its light"),
            (false, Some(_)) => {
                self.say("saved without light: what is solved is of an earlier state")
            }
            (false, None) => self.say("saved"),
        };
        self.tell(Level::Note, format!("{name}: {said}"));
        if !saved.losses.is_empty() {
            let losses = saved.losses.join(", ");
            self.tell(
                Level::Warning,
                format!(
                    "{name}: {}: {losses}",
                    self.say("this format does not keep all")
                ),
            );
        }
        self.preferences.note_recent(&saved.path);
        self.store_preferences();
        // What took this document's place meanwhile does not belong there.
        let own = saved.state.filter(|s| s.revision >= self.began);
        if let Some(state) = own {
            self.file = Some(OnDisk::now(&saved.path));
            self.saved = state;
            if !self.is_changed() {
                self.forget_copy();
                self.go_on_after_save();
            }
        }
    }

    /// What waited for the changes to be safe.
    fn go_on_after_save(&mut self) {
        if let Some(Question::Unsaved(command)) = self.question.take() {
            self.execute(*command);
        }
    }

    /// Does what was asked for although changes are lost.
    pub(super) fn discard(&mut self) {
        match self.question.take() {
            // As long as the other document is not there, this one is not lost.
            Some(Question::Unsaved(command)) => self.perform(*command),
            Some(Question::ChangedOnDisk(path)) => self.load(vec![path], true),
            None => {}
        }
    }

    pub(super) fn close(&mut self) {
        self.forget_copy();
        self.closing = true;
    }

    /// The document is safe, or given up: no copy of it is needed.
    pub(super) fn forget_copy(&mut self) {
        self.jobs.cancel_kind(Kind::Autosave);
        self.recovery.clear();
    }

    /// Opens what was written before a crash.
    pub(super) fn recover(&mut self, copy: PathBuf) {
        self.begin_loading(vec![copy], true, true);
    }

    /// What was recovered is not on the disk where it belongs.
    fn adopt_recovered(&mut self, copy: &Path) {
        let found = self.recovery.found().iter().find(|f| f.copy == copy);
        let original = found.and_then(|f| f.original.clone());
        self.recovery.adopt(copy);
        self.file = original.map(OnDisk::unread);
        match (&self.file, self.document.branches.first_mut()) {
            (Some(file), Some(branch)) => {
                branch.path.clone_from(&file.path);
                branch.name = models::branch_name(&file.path, |_| false);
            }
            // The copy's own name says nothing to anybody.
            _ => self.document.leave_files(),
        }
        self.revision = self.new_revision();
        self.changed_at = Some(Instant::now());
    }

    /// Writes a copy for recovery, if one is due.
    pub(super) fn autosave(&mut self) {
        let patience = Duration::from_secs(u64::from(self.preferences.autosave));
        let rests = self.changed_at.is_some_and(|t| t.elapsed() >= patience);
        let wanted = !patience.is_zero() && rests && self.is_changed();
        if !wanted || self.is_busy(Kind::Autosave) {
            return;
        }
        let original = self.file.as_ref().map(|f| f.path.as_path());
        let Some(path) = self.recovery.due(self.revision, original) else {
            return;
        };
        self.changed_at = None;
        let (document, revision) = (self.document.clone(), self.revision);
        let solution = self.lighting.solution.clone();
        let title = self.say("copy for recovery");
        self.jobs
            .start(Kind::Autosave, title, move |progress, outbox| {
                let (scene, _) = document.lit_scene(solution.as_deref());
                models::write(&scene, &path, progress).map_err(|e| e.to_string())?;
                outbox.send(Found::Autosaved(revision));
                Ok(())
            });
    }

    /// Writes a copy for recovery now, whatever time it is, and waits for it; returns where it is,
    /// `None` if there is nothing that is not on the disk.
    ///
    /// # Errors
    /// Why it cannot be written, in words.
    pub fn keep_for_next_start(&mut self) -> Result<Option<PathBuf>, String> {
        if !self.is_changed() {
            return Ok(None);
        }
        let original = self.file.as_ref().map(|f| f.path.as_path());
        let path = self.recovery.place(original).unwrap_or_else(|| {
            let name = format!("azulejo-kept-{}.grf", std::process::id());
            std::env::temp_dir().join(name)
        });
        let (scene, _) = self.document.lit_scene(self.lighting.solution.as_deref());
        models::write(&scene, &path, &Progress::new()).map_err(|e| e.to_string())?;
        self.recovery.done(self.revision);
        Ok(Some(path))
    }

    /// When the window should be drawn again although nothing happens: for a copy that is due.
    pub fn wakes_in(&self) -> Option<Duration> {
        let patience = Duration::from_secs(u64::from(self.preferences.autosave));
        let waits = !patience.is_zero() && self.is_changed() && !self.is_busy(Kind::Autosave);
        let since = self.changed_at.filter(|_| waits)?.elapsed();
        patience.checked_sub(since)
    }

    /// Asks what to do if somebody else wrote the file; called when the window is looked at again.
    pub fn check_disk(&mut self) {
        let is_occupied = self.question.is_some() || self.is_busy(Kind::Save);
        let Some(file) = &mut self.file else { return };
        // One that was never read here is asked about when it is written.
        let was_read = file.stamp.is_some();
        if is_occupied || !was_read || !file.is_news() {
            return;
        }
        let path = file.path.clone();
        if path.exists() {
            self.question = Some(Question::ChangedOnDisk(path.clone()));
        } else {
            let said = self.say("the file is gone; save to write it again");
            let text = format!("{}: {said}", path.display());
            self.tell(Level::Warning, text);
        }
    }

    pub(super) fn load_backdrop(&mut self, path: PathBuf) {
        self.asking = None;
        let title = path.display().to_string();
        self.jobs.start(Kind::Backdrop, title, move |_, outbox| {
            let bytes = models::read_bytes(&path).map_err(|e| e.to_string())?;
            let image = azulejo::formats::read_picture(&bytes).map_err(|e| e.to_string())?;
            outbox.send(Found::Backdrop(Box::new(image)));
            Ok(())
        });
    }

    /// Checks that a place can be written, and tells if not.
    pub(super) fn output(&mut self, path: &Path) -> Option<Output> {
        match Output::check(path) {
            Ok(output) => Some(output),
            Err(failure) => {
                self.tell(Level::Error, failure.to_string());
                None
            }
        }
    }
}

/// What was read, for the list of messages.
fn summary(document: &Document, path: &Path, time: Duration, language: Language) -> String {
    format!(
        "{}: {} {}, {} {}, {} {}, {} {}, {:.1} s",
        path.display(),
        document.items.len(),
        language.say("objects"),
        document.face_count(),
        language.say("faces"),
        document.materials.len(),
        language.say("materials"),
        document.lights.len(),
        language.say("lights"),
        time.as_secs_f64()
    )
}

/// Reads one file after the other into one set of units.
struct Reader {
    /// Those of the document that files join; the first file's, where there is none.
    units: Option<Units>,
    /// Names of branches that are taken.
    taken: Vec<String>,
}

impl Reader {
    fn read(
        &mut self,
        path: &Path,
        progress: &Progress,
    ) -> Result<LoadedModel, models::ReadFailure> {
        // As it is before it is read: what others write meanwhile is theirs.
        let on_disk = OnDisk::now(path);
        let model = models::read(path, &models::Reading::default(), progress)?;
        let mut scene = model.scene;
        let wanted = *self.units.get_or_insert(scene.units);
        let changes = models::changes(scene.units, wanted);
        scene = scene.adapted(wanted);
        let name = models::branch_name(path, |n| self.taken.iter().any(|t| t == n));
        if !self.taken.is_empty() {
            models::name_branch(&mut scene, &name);
        }
        self.taken.push(name.clone());
        let branch = Branch {
            name,
            path: path.to_owned(),
            format: Some(model.format),
        };
        let said = |change: &models::Change| format!("{}: {change}", path.display());
        Ok(LoadedModel {
            notes: changes.iter().map(said).collect(),
            path: path.to_owned(),
            on_disk,
            document: Document::of_scene(scene, Some(branch)),
            warnings: model.warnings,
        })
    }
}

/// The light that a file brought, so that it is shown and kept.
pub(super) fn light_of_file(document: &Document) -> Option<Solution> {
    Solution::of_file(document)
}
