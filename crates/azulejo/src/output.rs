//! Files that appear whole or not at all.
//!
//! An [`Output`] is checked before the work begins and written after it: into a draft beside the
//! target, which takes the target's place in one step. Whatever goes wrong on the way, an old
//! file stays as it was and no half file is left behind.
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

use crate::files::Refused;
use azulejo_trace::{Cancelled, Progress};
use std::fmt;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};

/// The drafts that exist now, so that an interrupt can remove them. Whoever holds the lock is
/// the only one who may put drafts in their places.
static DRAFTS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// A place where a result can be written.
#[derive(Debug)]
pub struct Output {
    /// As the user named it.
    path: PathBuf,
    target: OutputTarget,
}

#[derive(Debug)]
enum OutputTarget {
    Stdout,
    /// A terminal, a pipe, `/dev/null`: must not be replaced by a file.
    Device,
    /// A regular file that is or will be there, behind symbolic links if there are any.
    File(PathBuf),
}

/// A file being written; removed when dropped before [`commit`].
#[derive(Debug)]
pub struct Draft {
    output: PathBuf,
    writer: Option<BufWriter<DraftSink>>,
    /// The draft and its target, for a regular file.
    rename: Option<(PathBuf, PathBuf)>,
}

#[derive(Debug)]
enum DraftSink {
    Stdout(io::Stdout),
    File(File),
}

/// Why nothing was written. `Display` says it to a person.
#[derive(Debug)]
#[non_exhaustive]
pub enum OutputError {
    /// The caller cancelled before the file took its place.
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
            // Making and dropping an empty draft shows what the folder's permissions do not.
            drop(output.draft()?);
        }
        Ok(output)
    }

    /// Whether this is standard output.
    pub fn is_stdout(&self) -> bool {
        matches!(self.target, OutputTarget::Stdout)
    }

    /// The regular file that is or will be there, behind symbolic links if there are any.
    pub fn file(&self) -> Option<&Path> {
        match &self.target {
            OutputTarget::File(path) => Some(path),
            OutputTarget::Stdout | OutputTarget::Device => None,
        }
    }

    /// As the user named it.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Begins to write; [`commit`] ends it.
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
        })
    }

    /// Writes the whole file through `write` and puts it in its place.
    ///
    /// # Errors
    /// [`OutputError`]; what was there before is then untouched.
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

/// A new file in the target's folder, under a name that nothing else has.
fn create_beside(target: &Path) -> io::Result<(File, PathBuf)> {
    static NUMBER: AtomicU32 = AtomicU32::new(0);
    let number = NUMBER.fetch_add(1, Ordering::Relaxed);
    let name = format!(".azulejo-{}-{number}.tmp", std::process::id());
    let draft = target.with_file_name(name);
    let mut drafts = lock_drafts();
    let file = OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(&draft)?;
    drafts.push(draft.clone());
    Ok((file, draft))
}

fn lock_drafts() -> std::sync::MutexGuard<'static, Vec<PathBuf>> {
    DRAFTS
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// Puts finished drafts in their places, all of them or none unless the disk itself fails
/// between two renames. Nothing is put in place once `progress` is cancelled.
///
/// # Errors
/// [`OutputError`].
pub fn commit(mut drafts: Vec<Draft>, progress: &Progress) -> Result<(), OutputError> {
    for draft in &mut drafts {
        let finished = draft.finish();
        finished.map_err(|e| draft.error(e))?;
    }
    // Whoever pauses the work must not be waited for with the lock in hand.
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
        open.retain(|d| *d != from);
        if let Err(e) = renamed {
            let _ = fs::remove_file(&from);
            return Err(draft.error(e));
        }
    }
    Ok(())
}

/// Removes every draft and never lets go of the lock, so that none can be put in place later:
/// for an interrupt that ends the process.
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

    /// Everything on the disk, with the permissions of the file that it will replace.
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
                file.sync_all()
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
            // What is still in the buffer belongs to a file that nobody will see.
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
        let said = result.unwrap_err().to_string();
        assert!(said.contains("a.grf: the writer gave up"), "{said}");
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
    fn places_that_cannot_be_written_are_found_at_once() {
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

    #[cfg(unix)]
    #[test]
    fn links_and_devices_stay_what_they_are() {
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
            let said = full.unwrap_err().to_string();
            assert!(said.contains("No space left on device"), "{said}");
        }
        fs::remove_dir_all(folder).unwrap();
    }
}
