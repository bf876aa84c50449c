//! Files that are written atomically.
//!
//! An [`Output`] is checked before the work begins and written after it: to a draft next to the
//! target, which is then renamed over the target. If anything fails, an existing file is left
//! unchanged and no partial file remains. The drafts of a process that was killed are removed by the
//! next one that writes to their folder.
//!
//! ```
//! use azulejo::{output::Output, trace::Progress};
//! use std::io::Write;
//!
//! let path = std::env::temp_dir().join(format!("azulejo-doc-{}.txt", std::process::id()));
//! let output = Output::check(&path)?; // before the work begins
//! output.write(&Progress::new(), |file| file.write_all(b"whole"))?;
//! assert_eq!(std::fs::read(&path)?, b"whole");
//! std::fs::remove_file(path)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod leftovers;

use crate::files::Refused;
use azulejo_formats::disk::{self as fs, File, OpenOptions};
use azulejo_trace::{Cancelled, Progress};
use std::fmt;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};

/// The existing drafts, so that an interrupt can remove them. Only the holder of the lock may rename
/// drafts.
static DRAFTS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// An output file, standard output, or a device.
#[derive(Debug)]
pub struct Output {
    /// As given by the user.
    path: PathBuf,
    target: OutputTarget,
}

#[derive(Debug)]
enum OutputTarget {
    Stdout,
    /// A terminal, a pipe or `/dev/null`, which must not be replaced by a file.
    Device,
    /// A regular file, existing or not, with symbolic links resolved.
    File(PathBuf),
}

/// A file being written; removed when dropped before [`commit`].
#[derive(Debug)]
pub struct Draft {
    output: PathBuf,
    writer: Option<BufWriter<DraftSink>>,
    /// The draft and its target, for a regular file.
    rename: Option<(PathBuf, PathBuf)>,
    /// The finished draft, which stays locked until it is in place.
    finished: Option<File>,
}

#[derive(Debug)]
enum DraftSink {
    Stdout(io::Stdout),
    File(File),
}

/// Why nothing was written.
#[derive(Debug)]
#[non_exhaustive]
pub enum OutputError {
    /// Cancelled before the file was in place.
    Cancelled,
    /// The file could not be written: no room, no permission, no such folder.
    File(Refused),
}

impl fmt::Display for OutputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            OutputError::Cancelled => Cancelled.fmt(f),
            OutputError::File(refused) => refused.fmt(f),
        }
    }
}

impl std::error::Error for OutputError {}

impl From<Cancelled> for OutputError {
    fn from(_: Cancelled) -> OutputError {
        OutputError::Cancelled
    }
}

fn failed(path: &Path, error: io::Error) -> OutputError {
    OutputError::File(Refused {
        deed: "write",
        path: path.to_owned(),
        error,
    })
}

impl Output {
    /// Checks that `path` can be written, without touching what is there; `-` is standard output.
    ///
    /// # Errors
    /// [`OutputError::File`]: a directory, a folder that is not there or may not be written.
    pub fn check(path: &Path) -> Result<Output, OutputError> {
        let target = if path == Path::new("-") {
            OutputTarget::Stdout
        } else {
            target_of(path).map_err(|e| failed(path, e))?
        };
        let output = Output {
            path: path.to_owned(),
            target,
        };
        if let OutputTarget::File(_) = output.target {
            // Permissions alone do not tell whether a file can be created.
            drop(output.draft()?);
        }
        Ok(output)
    }

    /// Whether this is standard output.
    pub fn is_stdout(&self) -> bool {
        matches!(self.target, OutputTarget::Stdout)
    }

    /// The path of the regular file, existing or not, with symbolic links resolved.
    pub fn file(&self) -> Option<&Path> {
        match &self.target {
            OutputTarget::File(path) => Some(path),
            OutputTarget::Stdout | OutputTarget::Device => None,
        }
    }

    /// The path as given by the user.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// An error of writing this file.
    pub fn error(&self, error: io::Error) -> OutputError {
        failed(&self.path, error)
    }

    /// Starts writing; [`commit`] completes it.
    ///
    /// # Errors
    /// As [`check`](Output::check).
    pub fn draft(&self) -> Result<Draft, OutputError> {
        let failed = |e: io::Error| failed(&self.path, e);
        let (sink, rename) = match &self.target {
            OutputTarget::Stdout => (DraftSink::Stdout(io::stdout()), None),
            OutputTarget::Device => {
                let file = OpenOptions::new().write(true).open(&self.path);
                (DraftSink::File(file.map_err(failed)?), None)
            }
            OutputTarget::File(target) => {
                let (file, draft) = create_beside(target).map_err(failed)?;
                (DraftSink::File(file), Some((draft, target.clone())))
            }
        };
        Ok(Draft {
            output: self.path.clone(),
            writer: Some(BufWriter::with_capacity(1 << 16, sink)),
            rename,
            finished: None,
        })
    }

    /// Writes the file through `write` and moves it into place.
    ///
    /// # Errors
    /// [`OutputError`]; an existing file is then unchanged.
    pub fn write(
        &self,
        progress: &Progress,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), OutputError> {
        let mut draft = self.draft()?;
        write(&mut draft).map_err(|e| draft.error(e))?;
        commit(vec![draft], progress)
    }
}

fn target_of(path: &Path) -> io::Result<OutputTarget> {
    if path.file_name().is_none() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    match fs::metadata(path) {
        Ok(meta) if meta.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
        Ok(meta) if !meta.is_file() => Ok(OutputTarget::Device),
        Ok(meta) if meta.permissions().readonly() => Err(io::Error::new(
            io::ErrorKind::PermissionDenied,
            "the file is read-only",
        )),
        Ok(_) => Ok(OutputTarget::File(fs::canonicalize(path)?)),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(OutputTarget::File(path.to_owned())),
        Err(e) => Err(e),
    }
}

/// Creates a file with a unique name in the target's folder, locked as long as it is open, so that
/// other processes know that somebody still writes it.
fn create_beside(target: &Path) -> io::Result<(File, PathBuf)> {
    static NUMBER: AtomicU32 = AtomicU32::new(0);
    let number = NUMBER.fetch_add(1, Ordering::Relaxed);
    let draft = target.with_file_name(leftovers::draft_name(number));
    let mut drafts = lock_drafts();
    leftovers::remove(target);
    // One of a killed process that had the same number, which is nobody else's any more.
    let _ = fs::remove_file(&draft);
    let file = OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(&draft)?;
    // Some file systems have no locks.
    let _ = file.try_lock();
    drafts.push(draft.clone());
    Ok((file, draft))
}

fn lock_drafts() -> std::sync::MutexGuard<'static, Vec<PathBuf>> {
    DRAFTS
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// Moves finished drafts into place: all of them or none, unless the disk fails between two renames.
/// Nothing is moved once `progress` is cancelled.
///
/// # Errors
/// [`OutputError`].
pub fn commit(mut drafts: Vec<Draft>, progress: &Progress) -> Result<(), OutputError> {
    for draft in &mut drafts {
        let finished = draft.finish();
        finished.map_err(|e| draft.error(e))?;
    }
    // A pause must not be waited for while holding the lock.
    progress.advance(0)?;
    let mut open = lock_drafts();
    if progress.is_cancelled() {
        return Err(OutputError::Cancelled);
    }
    for draft in &mut drafts {
        let Some((from, to)) = draft.rename.take() else {
            continue;
        };
        let renamed = fs::rename(&from, &to);
        draft.finished = None;
        open.retain(|d| *d != from);
        if let Err(e) = renamed {
            let _ = fs::remove_file(&from);
            return Err(draft.error(e));
        }
    }
    Ok(())
}

/// Removes all drafts and keeps the lock, so that none can be moved into place later: for an
/// interrupt that exits the process.
pub fn abandon_all() {
    let drafts = lock_drafts();
    for draft in drafts.iter() {
        let _ = fs::remove_file(draft);
    }
    std::mem::forget(drafts);
}

impl Draft {
    /// An error of writing this file.
    pub fn error(&self, error: io::Error) -> OutputError {
        failed(&self.output, error)
    }

    /// Flushes to disk, with the permissions of the file to be replaced.
    fn finish(&mut self) -> io::Result<()> {
        let Some(writer) = self.writer.take() else {
            return Ok(());
        };
        match writer
            .into_inner()
            .map_err(io::IntoInnerError::into_error)?
        {
            DraftSink::Stdout(mut stdout) => stdout.flush(),
            DraftSink::File(file) => {
                let Some((_, target)) = &self.rename else {
                    return Ok(());
                };
                if let Ok(old) = fs::metadata(target) {
                    file.set_permissions(old.permissions())?;
                }
                file.sync_all()?;
                self.finished = Some(file);
                Ok(())
            }
        }
    }
}

impl Write for Draft {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.writer {
            Some(writer) => writer.write(bytes),
            None => Err(io::ErrorKind::NotConnected.into()),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.as_mut().map_or(Ok(()), BufWriter::flush)
    }
}

impl Write for DraftSink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            DraftSink::Stdout(out) => out.write(bytes),
            DraftSink::File(file) => file.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            DraftSink::Stdout(out) => out.flush(),
            DraftSink::File(file) => file.flush(),
        }
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        if let Some(writer) = self.writer.take() {
            // The buffered rest belongs to a file that is removed.
            drop(writer.into_parts());
        }
        if let Some((draft, _)) = self.rename.take() {
            let mut open = lock_drafts();
            let _ = fs::remove_file(&draft);
            open.retain(|d| *d != draft);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("azulejo-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        folder
    }

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        entries
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect()
    }

    #[test]
    fn an_error_leaves_the_old_file_and_nothing_else() {
        let folder = folder("error");
        let path = folder.join("a.grf");
        fs::write(&path, "old").unwrap();
        let output = Output::check(&path).unwrap();
        let result = output.write(&Progress::new(), |w| {
            w.write_all(b"half of it")?;
            Err(io::Error::other("the writer gave up"))
        });
        let message = result.unwrap_err().to_string();
        assert!(message.contains("a.grf: the writer gave up"), "{message}");
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names(&folder), ["a.grf"]);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_cancelled_commit_changes_nothing() {
        let folder = folder("cancelled");
        let output = Output::check(&folder.join("a.grf")).unwrap();
        let progress = Progress::new();
        progress.cancel();
        let result = output.write(&progress, |w| w.write_all(b"whole"));
        assert!(matches!(result, Err(OutputError::Cancelled)));
        assert!(names(&folder).is_empty());
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn paths_that_cannot_be_written_are_refused_at_once() {
        let folder = folder("places");
        for bad in [
            folder.clone(),
            folder.join("missing/a.grf"),
            folder.join(".."),
        ] {
            assert!(
                matches!(Output::check(&bad), Err(OutputError::File(_))),
                "{bad:?}"
            );
        }
        fs::remove_dir_all(folder).unwrap();
    }

    /// Drafts of processes that are gone, of one that lives, of this one, and files of other names.
    #[cfg(target_os = "linux")]
    #[test]
    fn drafts_of_killed_processes_are_removed() {
        let folder = folder("leftovers");
        let mut gone = std::process::Command::new("true").spawn().unwrap();
        gone.wait().unwrap();
        let (gone, init) = (gone.id(), 1);
        let kept = [
            format!(".azulejo-{init}-0.tmp"),
            format!(".azulejo-{gone}-3.txt"),
            format!(".azulejo-{gone}-.tmp"),
            format!(".azulejo-{gone}-2.tmp"),
            "a.tmp".to_owned(),
        ];
        for name in &kept {
            fs::write(folder.join(name), "").unwrap();
        }
        let locked = File::open(folder.join(&kept[3])).unwrap();
        locked.lock().unwrap();
        fs::write(folder.join(format!(".azulejo-{gone}-0.tmp")), "").unwrap();
        fs::write(folder.join(format!(".azulejo-{gone}-17.tmp")), "").unwrap();
        let own = Output::check(&folder.join("b.grf")).unwrap();
        let draft = own.draft().unwrap();
        let output = Output::check(&folder.join("a.grf")).unwrap();
        output
            .write(&Progress::new(), |w| w.write_all(b"whole"))
            .unwrap();
        commit(vec![draft], &Progress::new()).unwrap();
        let mut expected = kept.to_vec();
        expected.extend(["a.grf".to_owned(), "b.grf".to_owned()]);
        let mut names = names(&folder);
        expected.sort();
        names.sort();
        assert_eq!(names, expected);
        fs::remove_dir_all(folder).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn links_and_devices_are_preserved() {
        let folder = folder("links");
        let (real, link) = (folder.join("real"), folder.join("link"));
        fs::write(&real, "old").unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        let write = |path: &Path| {
            Output::check(path)
                .unwrap()
                .write(&Progress::new(), |w| w.write_all(b"new"))
        };
        write(&link).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read_to_string(&real).unwrap(), "new");
        write(Path::new("/dev/null")).unwrap();
        let full = write(Path::new("/dev/full"));
        if Path::new("/dev/full").exists() {
            let message = full.unwrap_err().to_string();
            assert!(message.contains("No space left on device"), "{message}");
        }
        fs::remove_dir_all(folder).unwrap();
    }
}
