//! Recovery copies: written periodically, opened after a crash, deleted when no longer needed.

use super::saving::OnDisk;
use super::{App, JobResult};
use crate::jobs::JobKind;
use azulejo::models;
use azulejo::trace::Progress;
use azulejo::trace::time::{Duration, Instant};
use std::path::{Path, PathBuf};

impl App {
    /// Lets the window close, whatever changes are lost.
    pub fn allow_close(&mut self) {
        self.forget_copy();
        self.left = Some(self.accept_loss());
        self.closing = true;
    }

    /// Deletes the recovery copy of a document that is saved or discarded.
    pub(super) fn forget_copy(&mut self) {
        self.jobs.cancel_kind(JobKind::Autosave);
        self.recovery.clear();
    }

    /// Opens a recovery copy.
    pub(super) fn recover(&mut self, copy: PathBuf) {
        self.begin_loading(vec![copy], true, true);
    }

    /// Marks a recovered document as changed, since it differs from the file on disk.
    pub(super) fn adopt_recovered(&mut self, copy: &Path) {
        let recoverable = self.recovery.recoverable().iter().find(|f| f.copy == copy);
        let original = recoverable.and_then(|f| f.original.clone());
        self.recovery.adopt(copy);
        self.file = original.map(OnDisk::never_read);
        match (&self.file, self.document.source_files.first_mut()) {
            (Some(file), Some(source_file)) => {
                source_file.path.clone_from(&file.path);
                source_file.name = models::branch_name(&file.path, |_| false);
            }
            // The name of the copy itself means nothing to the user.
            _ => self.document.detach_files(),
        }
        self.revision = self.new_revision();
        self.changed_at = Some(Instant::now());
    }

    /// Writes a recovery copy in the background if one is due.
    pub(super) fn autosave(&mut self) {
        let patience = Duration::from_secs(u64::from(self.preferences.autosave));
        let rests = self.changed_at.is_some_and(|t| t.elapsed() >= patience);
        let is_due = !patience.is_zero() && rests && self.is_changed();
        if !is_due || self.is_busy(JobKind::Autosave) {
            return;
        }
        let original = self.file.as_ref().map(|f| f.path.as_path());
        let Some(path) = self.recovery.due(self.revision, original) else {
            return;
        };
        self.changed_at = None;
        let home = self.home();
        let (document, revision) = (self.document.clone(), self.revision);
        let solution = self.lighting.solution.clone();
        let title = self.tr("recovery copy");
        self.jobs
            .start(JobKind::Autosave, title, move |progress, outbox| {
                let (scene, _) = document.lit_scene(solution.as_deref());
                let kept = models::write_copy(&scene, &path, home.as_deref(), progress);
                kept.map_err(|e| e.to_string())?;
                outbox.send(JobResult::Autosaved(revision));
                Ok(())
            });
    }

    /// Writes a recovery copy now and waits for it; returns its path, or `None` if there are no
    /// unsaved changes.
    ///
    /// # Errors
    ///
    /// A message with the reason why it cannot be written.
    pub fn save_recovery_now(&mut self) -> Result<Option<PathBuf>, String> {
        if !self.is_changed() {
            return Ok(None);
        }
        let original = self.file.as_ref().map(|f| f.path.as_path());
        let path = self.recovery.copy_path(original).unwrap_or_else(|| {
            let name = format!("azulejo-kept-{}.grf", std::process::id());
            std::env::temp_dir().join(name)
        });
        let (scene, _) = self.document.lit_scene(self.lighting.solution.as_deref());
        let home = self.home();
        let kept = models::write_copy(&scene, &path, home.as_deref(), &Progress::new());
        kept.map_err(|e| e.to_string())?;
        self.recovery.done(self.revision);
        Ok(Some(path))
    }

    /// Writes a recovery copy of unsaved changes that stays when the program ends; returns its path,
    /// or `None` if there are no changes.
    ///
    /// # Errors
    ///
    /// A message with the reason why it cannot be written.
    pub fn leave_recovery(&mut self) -> Result<Option<PathBuf>, String> {
        // It would write to the same file.
        self.jobs.cancel_kind(JobKind::Autosave);
        let kept = self.save_recovery_now();
        if !matches!(kept, Ok(None)) {
            // Even if there is no new copy, there may be an earlier one.
            self.recovery.keep();
        }
        kept
    }

    /// The folder in which a recovery copy looks for its textures: that of the original file.
    fn home(&self) -> Option<PathBuf> {
        let folder = self.file.as_ref()?.path.parent()?;
        Some(folder.to_owned())
    }

    /// Time until the window must be redrawn even without input, because a recovery copy is due.
    pub fn repaint_after(&self) -> Option<Duration> {
        let patience = Duration::from_secs(u64::from(self.preferences.autosave));
        let waits = !patience.is_zero() && self.is_changed() && !self.is_busy(JobKind::Autosave);
        let waits = waits && self.recovery.is_pending(self.revision);
        let since = self.changed_at.filter(|_| waits)?.elapsed();
        // After a failed copy the next one is due later. A copy that is due now starts in the next
        // frame; that must not turn into continuous repainting.
        let rest = patience
            .saturating_sub(since)
            .max(self.recovery.retry_delay());
        Some(rest.max(SOON))
    }
}

/// Repainting at this rate costs next to nothing.
const SOON: Duration = Duration::from_millis(100);
