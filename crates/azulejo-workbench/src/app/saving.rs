//! Saving, and detecting changes of the file by other programs.

use super::files::{absolute, with_default_extension};
use super::{App, DocumentState, JobResult, Severity};
use crate::command::{Command, FileRequest};
use crate::document::SceneDocument;
use crate::jobs::{JobKind, JobSender};
use azulejo::formats::disk;
use azulejo::models;
use azulejo::output::Output;
use azulejo::trace::Progress;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// A question that must be answered before anything else happens.
#[derive(Clone, Debug, PartialEq)]
pub enum PendingQuestion {
    /// The command would lose unsaved changes.
    Unsaved(Box<Command>),
    /// Another program has changed the file since it was read.
    ChangedOnDisk(PathBuf),
    /// The image to save is still being rendered.
    UnfinishedRender,
}

impl PendingQuestion {
    /// Whether the question still makes sense after a job failed: a command that waits for a save
    /// is dropped if the save fails.
    pub(super) fn survives_job_failure(&self) -> bool {
        !matches!(self, PendingQuestion::Unsaved(_))
    }
}

/// A file and its state when it was last read or written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OnDisk {
    /// Where it was read or written last.
    pub path: PathBuf,
    /// Its modification time and length.
    stamp: FileStamp,
    /// The state after another program's change that the user has been told about. Overwriting it
    /// still needs confirmation.
    acknowledged: FileStamp,
}

/// Modification time and length of a file; `None` if it does not exist.
type FileStamp = Option<(SystemTime, u64)>;

impl OnDisk {
    /// The file in its current state on disk.
    pub fn now(path: &Path) -> OnDisk {
        let stamp = stamp(path);
        OnDisk {
            path: path.to_owned(),
            stamp,
            acknowledged: stamp,
        }
    }

    /// A file that was never read or written in this session.
    pub(super) fn never_read(path: PathBuf) -> OnDisk {
        OnDisk {
            path,
            stamp: None,
            acknowledged: None,
        }
    }

    /// Whether `path` is the same file.
    fn is_at(&self, path: &Path) -> bool {
        is_same_file(&self.path, path)
    }

    /// Whether the file was changed or deleted since and the user has not been told; marks it as
    /// told.
    fn is_newly_changed(&mut self) -> bool {
        let now = stamp(&self.path);
        std::mem::replace(&mut self.acknowledged, now) != now
    }

    /// Whether the file was changed or deleted since.
    pub fn has_changed(&self) -> bool {
        stamp(&self.path) != self.stamp
    }
}

/// Whether two paths refer to the same file, symbolic links included.
fn is_same_file(a: &Path, b: &Path) -> bool {
    let real = |path: &Path| disk::canonicalize(path).ok();
    a == b || real(a).is_some_and(|a| Some(a) == real(b))
}

fn stamp(path: &Path) -> FileStamp {
    let meta = disk::metadata(path).ok()?;
    Some((meta.modified().ok()?, meta.len()))
}

/// A document that was written.
pub struct SavedModel {
    /// The file as it was written.
    on_disk: OnDisk,
    losses: Vec<String>,
    /// The state that was written, if the file is now the document's own; `None` for an export.
    state: Option<DocumentState>,
    lit: bool,
    /// Whether light that was loaded on some surfaces was not written.
    drops_light: bool,
    /// Faces that were written, and those of the model.
    faces: [usize; 2],
}

/// A saved file whose mesh is finer than the model, because it carries light.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FinerMesh {
    /// The file that was written.
    pub path: PathBuf,
    /// Number of faces in the file.
    pub saved: usize,
    /// Number of faces of the model, which is smaller.
    pub model: usize,
}

impl App {
    /// Saves to the document's own file, if its format stores light.
    pub(super) fn save(&mut self, anyway: bool) {
        let known = self.file.clone();
        let writable = known.filter(|f| {
            let format = models::by_extension(&f.path);
            format.is_some_and(|format| format.extension == "grf")
        });
        match writable {
            None => self.asking = Some(FileRequest::SaveAs),
            Some(file)
                if file.has_changed()
                    && disk::exists(&file.path).unwrap_or_default()
                    && !anyway =>
            {
                self.question = Some(PendingQuestion::ChangedOnDisk(file.path));
            }
            Some(file) => self.save_as(file.path),
        }
    }

    /// Saves under a name, which becomes the document's own.
    pub(super) fn save_as(&mut self, path: PathBuf) {
        if let Some(PendingQuestion::ChangedOnDisk(_)) = self.question {
            self.question = None;
        }
        self.asking = None;
        let path = with_default_extension(path, "grf");
        // Other formats store neither light sources nor solved light, so the document is not saved
        // by writing them.
        let keeps_all = models::by_extension(&path).is_some_and(|f| f.extension == "grf");
        let state = keeps_all.then(|| self.state());
        self.write(path, state);
    }

    /// Exports a copy; the document keeps its file.
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
                // Taken now, so that later changes by other programs are detected.
                on_disk: OnDisk::now(&path),
                losses,
                state,
                lit,
                drops_light: !lit && solution.is_none() && document.brings_light(),
                faces: [
                    SceneDocument::of_scene(scene, None).face_count(),
                    document.face_count(),
                ],
            }));
            Ok(())
        });
    }

    /// Writes `path` in the background. A write to the same path that is still running is
    /// cancelled: the later one wins, however long either takes.
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
        let [written, model] = saved.faces;
        let is_finer = saved.lit && saved.state.is_some() && written > model;
        self.finer_mesh = is_finer.then(|| FinerMesh {
            path: path.clone(),
            saved: written,
            model,
        });
        self.thumbnail_wanted = saved.state.is_some().then(|| path.clone());
        self.preferences.note_recent(&path);
        self.store_preferences();
        // A document that was opened meanwhile does not belong to this file.
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
            // An export over the document's own file is not a change by another program.
            (None, Some(file)) if file.is_at(&path) => self.file = Some(saved.on_disk),
            (None, _) => {}
        }
    }

    /// Solves the light again on the vertices of the model, and saves it to the file that has a
    /// finer mesh.
    pub(super) fn keep_faces(&mut self) {
        let Some(finer) = self.finer_mesh.take() else {
            return;
        };
        self.lighting.settings.keep_mesh = true;
        self.solve();
        self.save_when_solved = Some(finer.path);
    }

    /// Saves the light that was solved for it.
    pub(super) fn save_solved(&mut self) {
        let is_done = self.lighting.is_current
            && (self.lighting.solution.as_ref()).is_some_and(|s| s.report.is_some());
        if let Some(path) = self.save_when_solved.take().filter(|_| is_done) {
            self.save_as(path);
        }
    }

    fn report_saved(&mut self, saved: &SavedModel) {
        let name = saved.on_disk.path.display();
        let message = match (saved.lit, &self.lighting.solution) {
            (true, _) => self.tr("saved with its light"),
            (false, Some(_)) => {
                self.tr("saved without light: the solution is for an earlier state")
            }
            (false, None) if saved.drops_light => {
                self.tr("saved without the light stored in the file")
            }
            (false, None) => self.tr("saved"),
        };
        self.report(Severity::Note, format!("{name}: {message}"));
        if !saved.losses.is_empty() {
            let losses = saved.losses.join(", ");
            let message = self.tr("this format does not store everything");
            self.report(Severity::Warning, format!("{name}: {message}: {losses}"));
        }
    }

    /// Executes the command that was waiting for the save.
    fn continue_after_save(&mut self) {
        if let Some(PendingQuestion::Unsaved(command)) = self.question.take() {
            self.execute(*command);
        }
    }

    /// Executes the pending command although changes are lost.
    pub(super) fn discard(&mut self) {
        match self.question.take() {
            // The current document is not lost until the other one is loaded.
            Some(PendingQuestion::Unsaved(command)) => self.perform(*command),
            Some(PendingQuestion::ChangedOnDisk(path)) => self.load(vec![path], true),
            Some(PendingQuestion::UnfinishedRender) | None => {}
        }
    }

    /// Asks what to do if another program has changed the file; called when the window gets the
    /// focus.
    pub fn check_disk(&mut self) {
        let is_occupied = self.question.is_some() || self.is_busy(JobKind::Save);
        let Some(file) = &mut self.file else { return };
        // A file that was never read here is checked when it is written.
        let was_read = file.stamp.is_some();
        if is_occupied || !was_read || !file.is_newly_changed() {
            return;
        }
        let path = file.path.clone();
        if disk::exists(&path).unwrap_or_default() {
            self.question = Some(PendingQuestion::ChangedOnDisk(path.clone()));
        } else {
            let message = self.tr("the file no longer exists; save to write it again");
            let text = format!("{}: {message}", path.display());
            self.report(Severity::Warning, text);
        }
    }

    /// Opens the output file for writing; reports an error if it cannot be written.
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
            faces: [0, 0],
        };
        std::fs::write(&path, "of others").unwrap();
        app.take_saved(saved);
        assert!(app.file.as_ref().is_some_and(OnDisk::has_changed));
        std::fs::remove_file(path).unwrap();
    }
}
