//! Saving, and what others write meanwhile.

use super::files::absolute;
use super::{App, DocumentState, JobResult, Severity};
use crate::command::{Command, FileRequest};
use crate::jobs::{JobKind, JobSender};
use azulejo::models;
use azulejo::output::Output;
use azulejo::trace::Progress;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Something that must be answered before anything else.
#[derive(Clone, Debug, PartialEq)]
pub enum PendingQuestion {
    /// There are changes that would be lost by what was asked for.
    Unsaved(Box<Command>),
    /// Somebody else wrote the file since it was read.
    ChangedOnDisk(PathBuf),
}

impl PendingQuestion {
    /// Whether it still makes sense when a job failed: what waits for a save does not go on.
    pub(super) fn survives_job_failure(&self) -> bool {
        matches!(self, PendingQuestion::ChangedOnDisk(_))
    }
}

/// A file, as it was when it was read or written last.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OnDisk {
    /// Where.
    pub path: PathBuf,
    /// Its time and length.
    stamp: FileStamp,
    /// The same of what others wrote and a person was told of. Saving over it is still asked about.
    acknowledged: FileStamp,
}

/// When a file was written, and how long it is; `None` for one that is not there.
type FileStamp = Option<(SystemTime, u64)>;

impl OnDisk {
    /// The file as it is now.
    pub fn now(path: &Path) -> OnDisk {
        let stamp = stamp(path);
        OnDisk {
            path: path.to_owned(),
            stamp,
            acknowledged: stamp,
        }
    }

    /// A file that was never read or written here.
    pub(super) fn never_read(path: PathBuf) -> OnDisk {
        OnDisk {
            path,
            stamp: None,
            acknowledged: None,
        }
    }

    /// Whether it is the same file.
    fn is_at(&self, path: &Path) -> bool {
        is_same_file(&self.path, path)
    }

    /// Whether it was written or removed since, and nobody was told yet; now somebody is.
    fn is_newly_changed(&mut self) -> bool {
        let now = stamp(&self.path);
        std::mem::replace(&mut self.acknowledged, now) != now
    }

    /// Whether it was written or removed since.
    pub fn has_changed(&self) -> bool {
        stamp(&self.path) != self.stamp
    }
}

/// Whether two paths lead to one file, by whatever links.
fn is_same_file(a: &Path, b: &Path) -> bool {
    let real = |path: &Path| std::fs::canonicalize(path).ok();
    a == b || real(a).is_some_and(|a| Some(a) == real(b))
}

fn stamp(path: &Path) -> FileStamp {
    let meta = std::fs::metadata(path).ok()?;
    Some((meta.modified().ok()?, meta.len()))
}

/// A document that was written.
pub struct SavedModel {
    /// The file, as it was left.
    on_disk: OnDisk,
    losses: Vec<String>,
    /// What was written, if the path is now the document's own; else it was an export.
    state: Option<DocumentState>,
    lit: bool,
    /// Whether some surfaces came with light that is not written.
    drops_light: bool,
}

impl App {
    /// Saves where the document came from, if its format keeps light.
    pub(super) fn save(&mut self, anyway: bool) {
        let known = self.file.clone();
        let writable = known.filter(|f| {
            let format = models::by_extension(&f.path);
            format.is_some_and(|format| format.extension == "grf")
        });
        match writable {
            None => self.asking = Some(FileRequest::SaveAs),
            Some(file) if file.has_changed() && file.path.exists() && !anyway => {
                self.question = Some(PendingQuestion::ChangedOnDisk(file.path));
            }
            Some(file) => self.save_as(file.path),
        }
    }

    /// Saves under a name, which becomes the document's.
    pub(super) fn save_as(&mut self, path: PathBuf) {
        if let Some(PendingQuestion::ChangedOnDisk(_)) = self.question {
            self.question = None;
        }
        self.asking = None;
        let path = match path.extension() {
            Some(_) => absolute(path),
            None => absolute(path).with_extension("grf"),
        };
        // Other formats forget lights and solved light: what is written there is not saved.
        let keeps_all = models::by_extension(&path).is_some_and(|f| f.extension == "grf");
        let state = keeps_all.then(|| self.state());
        self.write(path, state);
    }

    /// Saves a copy; the document keeps its name.
    pub(super) fn export(&mut self, path: PathBuf) {
        self.asking = None;
        self.write(absolute(path), None);
    }

    fn write(&mut self, path: PathBuf, state: Option<DocumentState>) {
        let document = self.document.clone();
        let solution = self.lighting.solution.clone();
        self.start_saving(path.clone(), move |progress, outbox| {
            let (scene, lit) = document.lit_scene(solution.as_deref());
            let losses = models::write(&scene, &path, progress).map_err(|e| e.to_string())?;
            outbox.send(JobResult::Saved(SavedModel {
                // Now: what others write from here on is theirs.
                on_disk: OnDisk::now(&path),
                losses,
                state,
                lit,
                drops_light: !lit && solution.is_none() && document.brings_light(),
            }));
            Ok(())
        });
    }

    /// Writes `path` in the background. What is being written there yet is given up: the later is
    /// what a person wants there, however long either takes.
    pub(super) fn start_saving(
        &mut self,
        path: PathBuf,
        work: impl FnOnce(&Progress, &JobSender<JobResult>) -> Result<(), String> + Send + 'static,
    ) {
        let jobs = &mut self.jobs;
        self.saves.retain(|(id, other)| {
            let goes_on = jobs.running().iter().any(|job| job.id == *id);
            if goes_on && is_same_file(other, &path) {
                jobs.cancel(*id);
                return false;
            }
            goes_on
        });
        let id = jobs.start(JobKind::Save, path.display().to_string(), work);
        self.saves.push((id, path));
    }

    pub(super) fn take_saved(&mut self, saved: SavedModel) {
        let path = saved.on_disk.path.clone();
        self.report_saved(&saved);
        self.preferences.note_recent(&path);
        self.store_preferences();
        // What took this document's place meanwhile does not belong there.
        let own = saved.state.filter(|s| s.revision >= self.began);
        match (own, &self.file) {
            (Some(state), _) => {
                self.file = Some(saved.on_disk);
                self.saved = state;
                if !self.is_changed() {
                    self.forget_copy();
                    self.continue_after_save();
                }
            }
            // A copy over the document's own file was not written by others.
            (None, Some(file)) if file.is_at(&path) => self.file = Some(saved.on_disk),
            (None, _) => {}
        }
    }

    fn report_saved(&mut self, saved: &SavedModel) {
        let name = saved.on_disk.path.display();
        let said = match (saved.lit, &self.lighting.solution) {
            (true, _) => self.tr("saved with its light"),
            (false, Some(_)) => {
                self.tr("saved without light: what is solved is of an earlier state")
            }
            (false, None) if saved.drops_light => self.tr("saved without the light of the file"),
            (false, None) => self.tr("saved"),
        };
        self.report(Severity::Note, format!("{name}: {said}"));
        if !saved.losses.is_empty() {
            let losses = saved.losses.join(", ");
            let said = self.tr("this format does not keep all");
            self.report(Severity::Warning, format!("{name}: {said}: {losses}"));
        }
    }

    /// What waited for the changes to be safe.
    fn continue_after_save(&mut self) {
        if let Some(PendingQuestion::Unsaved(command)) = self.question.take() {
            self.execute(*command);
        }
    }

    /// Does what was asked for although changes are lost.
    pub(super) fn discard(&mut self) {
        match self.question.take() {
            // As long as the other document is not there, this one is not lost.
            Some(PendingQuestion::Unsaved(command)) => self.perform(*command),
            Some(PendingQuestion::ChangedOnDisk(path)) => self.load(vec![path], true),
            None => {}
        }
    }

    /// Asks what to do if somebody else wrote the file; called when the window is looked at again.
    pub fn check_disk(&mut self) {
        let is_occupied = self.question.is_some() || self.is_busy(JobKind::Save);
        let Some(file) = &mut self.file else { return };
        // One that was never read here is asked about when it is written.
        let was_read = file.stamp.is_some();
        if is_occupied || !was_read || !file.is_newly_changed() {
            return;
        }
        let path = file.path.clone();
        if path.exists() {
            self.question = Some(PendingQuestion::ChangedOnDisk(path.clone()));
        } else {
            let said = self.tr("the file is gone; save to write it again");
            let text = format!("{}: {said}", path.display());
            self.report(Severity::Warning, text);
        }
    }

    /// Checks that a place can be written, and tells if not.
    pub(super) fn output(&mut self, path: &Path) -> Option<Output> {
        match Output::check(path) {
            Ok(output) => Some(output),
            Err(failure) => {
                self.report(Severity::Error, failure.to_string());
                None
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_others_wrote_right_after_is_not_taken_for_ones_own() {
        let name = format!("azulejo-stamp-{}.grf", std::process::id());
        let path = std::env::temp_dir().join(name);
        std::fs::write(&path, "mine").unwrap();
        let mut app = App::quiet();
        let saved = SavedModel {
            on_disk: OnDisk::now(&path),
            losses: Vec::new(),
            state: Some(app.state()),
            lit: false,
            drops_light: false,
        };
        std::fs::write(&path, "of others").unwrap();
        app.take_saved(saved);
        assert!(app.file.as_ref().is_some_and(OnDisk::has_changed));
        std::fs::remove_file(path).unwrap();
    }
}
