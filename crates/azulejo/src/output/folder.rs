//! Folders that are written atomically, as files are.
//!
//! A draft beside the target is renamed once it is whole. Where a folder is replaced, it is put aside first,
//! because no system renames one folder over another; whatever happens in between, the old one or the
//! new one is there under its name, or under `NAME.before`, from where the next [`check`](FolderOutput::check)
//! puts it back.

use super::{DRAFTS_NUMBER, OutputError, failed, leftovers, lock_drafts};
use azulejo_trace::Progress;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

/// A folder that a program writes as a whole.
#[derive(Debug)]
pub struct FolderOutput {
    path: PathBuf,
    target: PathBuf,
}

/// A folder being written; removed when dropped before [`commit`](FolderDraft::commit).
#[derive(Debug)]
pub struct FolderDraft {
    output: PathBuf,
    target: PathBuf,
    draft: PathBuf,
    /// Tells other processes that somebody still writes here.
    _lock: Option<File>,
    is_in_place: bool,
}

impl FolderOutput {
    /// Checks that a folder can be written at `path`: where nothing is, or in the place of an empty folder or
    /// of one that has a file of the name `mark`, which is such a folder of before.
    ///
    /// # Errors
    /// [`OutputError::File`]: a file, a folder of other things, a place that may not be written to.
    pub fn check(path: &Path, mark: &str) -> Result<FolderOutput, OutputError> {
        let refused = |kind: io::ErrorKind, message: &str| {
            Err(failed(path, io::Error::new(kind, message.to_owned())))
        };
        if path.file_name().is_none() || path == Path::new("-") {
            return refused(io::ErrorKind::InvalidInput, "expected the name of a folder");
        }
        // With a slash at its end, the name is no name of a file.
        let target: PathBuf = path.components().collect();
        let before = before(&target);
        if before.is_dir() {
            if target.exists() {
                let _ = fs::remove_dir_all(&before);
            } else {
                fs::rename(&before, &target).map_err(|e| failed(path, e))?;
            }
        }
        let target = match fs::metadata(&target) {
            Ok(meta) if meta.is_dir() => {
                let mut entries = fs::read_dir(&target).map_err(|e| failed(path, e))?;
                if entries.next().is_some() && !target.join(mark).is_file() {
                    let message = format!(
                        "a folder with other things, expected nothing, an empty folder or one with {mark}, which \
                         is replaced"
                    );
                    return refused(io::ErrorKind::DirectoryNotEmpty, &message);
                }
                fs::canonicalize(&target).map_err(|e| failed(path, e))?
            }
            Ok(_) => return refused(io::ErrorKind::AlreadyExists, "a file, expected a folder"),
            Err(e) if e.kind() == io::ErrorKind::NotFound => target,
            Err(e) => return Err(failed(path, e)),
        };
        let output = FolderOutput {
            path: path.to_owned(),
            target,
        };
        // Permissions alone do not tell whether a folder can be created.
        drop(output.draft()?);
        Ok(output)
    }

    /// The path of the folder, existing or not.
    pub fn folder(&self) -> &Path {
        &self.target
    }

    /// The path as given by the user.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// An error of writing this folder.
    pub fn error(&self, error: io::Error) -> OutputError {
        failed(&self.path, error)
    }

    /// Starts writing, with an empty folder.
    ///
    /// # Errors
    /// As [`check`](FolderOutput::check).
    pub fn draft(&self) -> Result<FolderDraft, OutputError> {
        let number = DRAFTS_NUMBER.fetch_add(1, Ordering::Relaxed);
        let draft = self.target.with_file_name(leftovers::draft_name(number));
        let mut drafts = lock_drafts();
        leftovers::remove(&self.target);
        // One of a killed process that had the same number, which is nobody else's any more.
        let _ = fs::remove_dir_all(&draft);
        fs::create_dir(&draft).map_err(|e| self.error(e))?;
        drafts.push(draft.clone());
        // Some file systems have no locks, and some systems no open folders.
        let lock = File::open(&draft)
            .ok()
            .filter(|file| file.try_lock().is_ok());
        Ok(FolderDraft {
            output: self.path.clone(),
            target: self.target.clone(),
            draft,
            _lock: lock,
            is_in_place: false,
        })
    }
}

/// Where a folder is while another one takes its place.
fn before(target: &Path) -> PathBuf {
    let mut name = target.file_name().unwrap_or_default().to_owned();
    name.push(".before");
    target.with_file_name(name)
}

impl FolderDraft {
    /// Where to write.
    pub fn path(&self) -> &Path {
        &self.draft
    }

    /// Moves the folder into its place, unless `progress` is cancelled.
    ///
    /// # Errors
    /// [`OutputError`]; a folder of before is then unchanged.
    pub fn commit(mut self, progress: &Progress) -> Result<(), OutputError> {
        // A pause must not be waited for while holding the lock.
        progress.advance(0)?;
        let drafts = lock_drafts();
        if progress.is_cancelled() {
            drop(drafts);
            return Err(OutputError::Cancelled);
        }
        let before = before(&self.target);
        let renamed = if self.target.exists() {
            fs::rename(&self.target, &before).and_then(|()| {
                let renamed = fs::rename(&self.draft, &self.target);
                if renamed.is_err() {
                    let _ = fs::rename(&before, &self.target);
                }
                renamed
            })
        } else {
            fs::rename(&self.draft, &self.target)
        };
        self.is_in_place = renamed.is_ok();
        drop(drafts);
        let _ = fs::remove_dir_all(&before);
        renamed.map_err(|e| failed(&self.output, e))
    }
}

impl Drop for FolderDraft {
    fn drop(&mut self) {
        let mut drafts = lock_drafts();
        if !self.is_in_place {
            let _ = fs::remove_dir_all(&self.draft);
        }
        drafts.retain(|d| *d != self.draft);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("azulejo-f-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        folder
    }

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<String> = entries
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    fn write(path: &Path, content: &str) {
        let draft = FolderOutput::check(path, "mark").unwrap().draft().unwrap();
        fs::write(draft.path().join("mark"), content).unwrap();
        draft.commit(&Progress::new()).unwrap();
    }

    #[test]
    fn folders_appear_whole_and_replace_their_like() {
        let folder = folder("whole");
        let target = folder.join("store");
        let output = FolderOutput::check(&target, "mark").unwrap();
        assert!(names(&folder).is_empty());
        let draft = output.draft().unwrap();
        fs::write(draft.path().join("half"), "").unwrap();
        assert!(!target.exists());
        drop(draft);
        assert!(names(&folder).is_empty());
        write(&target, "one");
        write(&folder.join("store/"), "two");
        assert_eq!(fs::read_to_string(target.join("mark")).unwrap(), "two");
        assert_eq!(names(&folder), ["store"]);
        let progress = Progress::new();
        progress.cancel();
        let output = FolderOutput::check(&target, "mark").unwrap();
        let cancelled = output.draft().unwrap().commit(&progress);
        assert!(matches!(cancelled, Err(OutputError::Cancelled)));
        assert_eq!(fs::read_to_string(target.join("mark")).unwrap(), "two");
        assert_eq!(names(&folder), ["store"]);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn what_is_not_a_store_is_never_replaced() {
        let folder = folder("kept");
        fs::create_dir(folder.join("photos")).unwrap();
        fs::write(folder.join("photos/a.png"), "").unwrap();
        fs::write(folder.join("file"), "").unwrap();
        for (name, expected) in [
            ("photos", "a folder with other things"),
            ("file", "a file, expected a folder"),
            ("missing/store", "No such file"),
            ("..", "expected the name"),
        ] {
            let said = FolderOutput::check(&folder.join(name), "mark");
            let said = said.unwrap_err().to_string();
            assert!(said.contains(expected), "{name}: {said}");
        }
        assert_eq!(names(&folder), ["file", "photos"]);
        fs::remove_dir_all(folder).unwrap();
    }

    /// A process that ended between both renames, and one that ended before it removed the old folder.
    #[test]
    fn a_folder_put_aside_comes_back() {
        let folder = folder("aside");
        let target = folder.join("store");
        write(&target, "one");
        fs::rename(&target, folder.join("store.before")).unwrap();
        FolderOutput::check(&target, "mark").unwrap();
        assert_eq!(fs::read_to_string(target.join("mark")).unwrap(), "one");
        fs::create_dir(folder.join("store.before")).unwrap();
        FolderOutput::check(&target, "mark").unwrap();
        assert_eq!(names(&folder), ["store"]);
        fs::remove_dir_all(folder).unwrap();
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn drafts_of_killed_processes_are_removed() {
        let folder = folder("gone");
        let mut gone = std::process::Command::new("true").spawn().unwrap();
        gone.wait().unwrap();
        let gone = folder.join(format!(".azulejo-{}-0.tmp", gone.id()));
        fs::create_dir(&gone).unwrap();
        fs::write(gone.join("half"), "").unwrap();
        write(&folder.join("store"), "whole");
        assert_eq!(names(&folder), ["store"]);
        fs::remove_dir_all(folder).unwrap();
    }
}
