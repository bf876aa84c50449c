//! Recovery after a crash.
//!
//! While a document has unsaved changes, a copy of it is written periodically to a per-user folder,
//! with a note about its original file. Each session holds a lock on its note while it runs; copies
//! whose lock is free belong to sessions that crashed, and are offered for recovery.

use azulejo::formats::disk::{self, File, OpenOptions};
use azulejo::trace::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::{Path, PathBuf};
// Files have the clock of the standard library also in a page.
use std::time::SystemTime as FileTime;

/// A copy left by a crashed session.
#[derive(Clone, Debug, PartialEq)]
pub struct Recoverable {
    /// The copy, in GRF.
    pub copy: PathBuf,
    /// The file of the document, if it had one.
    pub original: Option<PathBuf>,
    /// When it was written, in seconds since 1970.
    pub written: u64,
}

/// The note beside a copy.
#[derive(Debug, Default, Serialize, Deserialize)]
struct RecoveryNote {
    original: Option<PathBuf>,
    /// The path in the system's own encoding, if it is not UTF-8.
    original_units: Option<Vec<u16>>,
}

impl RecoveryNote {
    fn of(original: Option<&Path>) -> RecoveryNote {
        let text = original.filter(|p| p.to_str().is_some());
        RecoveryNote {
            original: text.map(Path::to_owned),
            original_units: original.filter(|_| text.is_none()).map(units),
        }
    }

    fn original(self) -> Option<PathBuf> {
        self.original.or_else(|| path_of(&self.original_units?))
    }
}

#[cfg(unix)]
fn units(path: &Path) -> Vec<u16> {
    use std::os::unix::ffi::OsStrExt;
    let bytes = path.as_os_str().as_bytes();
    bytes.iter().copied().map(u16::from).collect()
}

#[cfg(unix)]
fn path_of(units: &[u16]) -> Option<PathBuf> {
    use std::os::unix::ffi::OsStringExt;
    let bytes: Result<Vec<u8>, _> = units.iter().map(|&u| u8::try_from(u)).collect();
    Some(std::ffi::OsString::from_vec(bytes.ok()?).into())
}

#[cfg(not(any(unix, windows)))]
fn units(_: &Path) -> Vec<u16> {
    Vec::new()
}

#[cfg(not(any(unix, windows)))]
fn path_of(_: &[u16]) -> Option<PathBuf> {
    None
}

#[cfg(windows)]
fn units(path: &Path) -> Vec<u16> {
    use std::os::windows::ffi::OsStrExt;
    path.as_os_str().encode_wide().collect()
}

#[cfg(windows)]
fn path_of(units: &[u16]) -> Option<PathBuf> {
    use std::os::windows::ffi::OsStringExt;
    Some(std::ffi::OsString::from_wide(units).into())
}

/// The copies of this session and of crashed ones.
#[derive(Debug, Default)]
pub struct Recovery {
    folder: Option<PathBuf>,
    /// This session's files; created with its first copy.
    session: Option<RecoverySession>,
    found: Vec<Recoverable>,
    /// The recovery copy that was opened, until a newer one is written.
    adopted: Option<PathBuf>,
    /// The revision last copied.
    copied: Option<u64>,
    /// Earliest time of the next attempt after a failure.
    not_before: Option<Instant>,
    /// Whether the copy stays when the session ends.
    is_kept: bool,
}

#[derive(Debug)]
struct RecoverySession {
    copy: PathBuf,
    note: PathBuf,
    /// Locked while the session runs.
    _lock: File,
}

/// Delay after a failed copy.
const PATIENCE: Duration = Duration::from_secs(120);

impl Recovery {
    /// Writes copies to `folder`; finds those left by crashed sessions.
    pub fn new(folder: PathBuf) -> Recovery {
        let mut recovery = Recovery::default();
        recovery.found = orphaned_copies(&folder);
        recovery.folder = Some(folder);
        recovery
    }

    /// The copies left by crashed sessions.
    pub fn recoverable(&self) -> &[Recoverable] {
        &self.found
    }

    /// The path of the next copy of a document, if one is due.
    pub fn due(&mut self, revision: u64, original: Option<&Path>) -> Option<PathBuf> {
        let waits = self.not_before.is_some_and(|t| Instant::now() < t);
        if waits || self.copied == Some(revision) {
            return None;
        }
        let place = self.copy_path(original);
        if place.is_none() {
            self.failed();
        }
        place
    }

    /// Whether a copy of this revision remains to be written, now or later.
    pub fn is_pending(&self, revision: u64) -> bool {
        self.folder.is_some() && self.copied != Some(revision)
    }

    /// Remaining delay after a failed copy.
    pub fn retry_delay(&self) -> Duration {
        let rest = self
            .not_before
            .map(|t| t.saturating_duration_since(Instant::now()));
        rest.unwrap_or_default()
    }

    /// Path of this session's copy; `None` if no copies are kept.
    pub fn copy_path(&mut self, original: Option<&Path>) -> Option<PathBuf> {
        if self.session.is_none() {
            self.session = self.folder.as_deref().and_then(RecoverySession::begin);
        }
        let session = self.session.as_ref()?;
        session.write_note(original);
        Some(session.copy.clone())
    }

    /// Called when a copy has been written.
    pub fn done(&mut self, revision: u64) {
        self.copied = Some(revision);
        self.remove_adopted();
    }

    /// Called when a copy has been opened. It is deleted when there is a newer one or none is
    /// needed.
    pub fn adopt(&mut self, copy: &Path) {
        self.found.retain(|f| f.copy != copy);
        self.adopted = Some(copy.to_owned());
    }

    fn remove_adopted(&mut self) {
        if let Some(copy) = self.adopted.take() {
            remove(&copy);
        }
    }

    /// Called when a copy could not be written.
    pub fn failed(&mut self) {
        self.not_before = Some(Instant::now() + PATIENCE);
    }

    /// Deletes this session's copy, because the document is safe.
    pub fn clear(&mut self) {
        self.copied = None;
        self.remove_adopted();
        if let Some(session) = self.session.take() {
            remove(&session.copy);
        }
    }

    /// Leaves this session's copy for the next one.
    pub fn keep(&mut self) {
        self.is_kept = true;
    }

    /// Removes a copy from the list and from the disk.
    pub fn delete(&mut self, copy: &Path) {
        self.found.retain(|f| {
            let goes = f.copy == copy;
            if goes {
                remove(&f.copy);
            }
            !goes
        });
    }
}

impl Drop for Recovery {
    /// A session that ends at the user's wish leaves nothing behind.
    fn drop(&mut self) {
        if !std::thread::panicking() && !self.is_kept {
            self.clear();
        }
    }
}

impl RecoverySession {
    fn begin(folder: &Path) -> Option<RecoverySession> {
        disk::create_dir_all(folder).ok()?;
        let now = SystemTime::now().duration_since(UNIX_EPOCH).ok()?;
        let name = format!("{}-{}", azulejo::machine::process(), now.as_nanos());
        let note = folder.join(format!("{name}.toml"));
        let mut options = OpenOptions::new();
        let lock = options.write(true).create_new(true).open(&note).ok()?;
        lock.try_lock().ok()?;
        Some(RecoverySession {
            copy: folder.join(format!("{name}.grf")),
            note,
            _lock: lock,
        })
    }

    fn write_note(&self, original: Option<&Path>) {
        let note = RecoveryNote::of(original);
        // Without its note a copy is still found; only the original path is lost.
        if let Ok(text) = toml::to_string(&note) {
            let file = OpenOptions::new()
                .write(true)
                .truncate(true)
                .open(&self.note);
            let _ = file.and_then(|mut f| f.write_all(text.as_bytes()));
        }
    }
}

fn remove(copy: &Path) {
    for picture in pictures(copy) {
        let _ = disk::remove_file(picture);
    }
    let _ = disk::remove_file(copy);
    let _ = disk::remove_file(copy.with_extension("toml"));
}

/// Texture files beside a copy, whose names begin with its name.
fn pictures(copy: &Path) -> Vec<PathBuf> {
    let stem = copy.file_stem().unwrap_or_default().to_string_lossy();
    let begin = format!("{stem}-");
    let is_picture = |path: &PathBuf| {
        let kind = path.extension().is_some_and(|e| e == "png" || e == "hdr");
        let name = path.file_name().unwrap_or_default();
        kind && name.to_string_lossy().starts_with(&begin)
    };
    let entries = copy.parent().and_then(|f| disk::read_dir(f).ok());
    let paths = entries.into_iter().flatten().flatten().map(|e| e.path());
    paths.filter(is_picture).collect()
}

/// Copies in `folder` whose session is not running, the newest first. Notes without a copy are
/// deleted.
fn orphaned_copies(folder: &Path) -> Vec<Recoverable> {
    let Ok(entries) = disk::read_dir(folder) else {
        return Vec::new();
    };
    let paths = entries.flatten().map(|e| e.path());
    let notes = paths.filter(|p| p.extension().is_some_and(|e| e == "toml"));
    let mut recoverable: Vec<Recoverable> = notes.filter_map(|note| orphan(&note)).collect();
    recoverable.sort_by(|a, b| b.written.cmp(&a.written).then(a.copy.cmp(&b.copy)));
    recoverable
}

fn orphan(note: &Path) -> Option<Recoverable> {
    let file = File::open(note).ok()?;
    file.try_lock_shared().ok()?;
    let copy = note.with_extension("grf");
    let Ok(meta) = disk::metadata(&copy) else {
        let _ = disk::remove_file(note);
        return None;
    };
    let text = disk::read_to_string(note).unwrap_or_default();
    let note: RecoveryNote = toml::from_str(&text).unwrap_or_default();
    let written = meta
        .modified()
        .ok()?
        .duration_since(FileTime::UNIX_EPOCH)
        .ok()?;
    Some(Recoverable {
        copy,
        original: note.original(),
        written: written.as_secs(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_of_dead_sessions_are_found_and_those_of_the_living_are_not() {
        let folder = std::env::temp_dir().join(format!("azulejo-rec-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        let mut alive = Recovery::new(folder.clone());
        let copy = alive.due(1, Some(Path::new("/a/room.3ds"))).unwrap();
        std::fs::write(&copy, "GRF").unwrap();
        alive.done(1);
        assert_eq!(alive.due(1, None), None);
        assert_eq!(
            alive.due(2, Some(Path::new("/a/room.3ds"))),
            Some(copy.clone())
        );
        assert_eq!(Recovery::new(folder.clone()).recoverable(), []);

        // A crash releases the lock and leaves the files.
        alive.session = None;
        let mut next = Recovery::new(folder.clone());
        let copies = next.recoverable().to_vec();
        assert_eq!(copies.len(), 1);
        assert_eq!(
            copies[0].original.as_deref(),
            Some(Path::new("/a/room.3ds"))
        );
        next.delete(&copy);
        assert!(next.recoverable().is_empty() && !copy.exists());
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_copy_that_failed_is_not_tried_again_at_once() {
        let folder = std::env::temp_dir().join(format!("azulejo-rec2-{}", std::process::id()));
        let mut recovery = Recovery::new(folder.clone());
        assert!(recovery.due(1, None).is_some());
        recovery.failed();
        assert_eq!(recovery.due(1, None), None);
        drop(recovery);
        std::fs::remove_dir_all(folder).unwrap();
    }
}
