//! Files in memory, with the interface of [`std::fs`] as far as it is used.

use std::collections::BTreeMap;
use std::ffi::{OsStr, OsString};
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

/// All files. A page has one disk, as a machine has; this is the only global state of the libraries.
static DISK: Mutex<Tree> = Mutex::new(Tree {
    files: BTreeMap::new(),
    written: Vec::new(),
});

struct Tree {
    files: BTreeMap<PathBuf, Arc<Vec<u8>>>,
    /// Files that were put into place since they were last asked for.
    written: Vec<PathBuf>,
}

fn tree() -> MutexGuard<'static, Tree> {
    DISK.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The absolute path without `.` and `..`.
fn tidy(path: &Path) -> PathBuf {
    let mut tidied = PathBuf::from("/");
    for part in path.components() {
        match part {
            Component::Normal(name) => tidied.push(name),
            Component::ParentDir => {
                tidied.pop();
            }
            _ => {}
        }
    }
    tidied
}

impl Tree {
    fn is_folder(&self, path: &Path) -> bool {
        path.parent().is_none() || self.files.keys().any(|file| file.starts_with(path))
    }

    fn file(&self, path: &Path) -> io::Result<&Arc<Vec<u8>>> {
        let path = tidy(path);
        self.files.get(&path).ok_or_else(|| {
            let is_folder = self.is_folder(&path);
            io::Error::from(if is_folder {
                ErrorKind::IsADirectory
            } else {
                ErrorKind::NotFound
            })
        })
    }
}

/// The files that were [renamed](rename), and so finished, since the last call, in that order: what a page
/// offers as downloads.
pub fn take_written() -> Vec<PathBuf> {
    let mut tree = tree();
    let mut written = std::mem::take(&mut tree.written);
    written.retain(|path| tree.files.contains_key(path));
    written
}

/// As [`std::fs::read`].
///
/// # Errors
/// There is no such file, or it is a folder.
pub fn read(path: impl AsRef<Path>) -> io::Result<Vec<u8>> {
    Ok(tree().file(path.as_ref())?.to_vec())
}

/// As [`std::fs::read_to_string`].
///
/// # Errors
/// There is no such file, or it is not text.
pub fn read_to_string(path: impl AsRef<Path>) -> io::Result<String> {
    String::from_utf8(read(path)?).map_err(|e| io::Error::new(ErrorKind::InvalidData, e))
}

/// As [`std::fs::write`].
///
/// # Errors
/// None.
pub fn write(path: impl AsRef<Path>, bytes: impl AsRef<[u8]>) -> io::Result<()> {
    let (path, mut tree) = (tidy(path.as_ref()), tree());
    tree.files.insert(path, Arc::new(bytes.as_ref().to_vec()));
    Ok(())
}

/// As [`std::fs::rename`].
///
/// # Errors
/// There is no such file.
pub fn rename(from: impl AsRef<Path>, to: impl AsRef<Path>) -> io::Result<()> {
    let (from, to, mut tree) = (tidy(from.as_ref()), tidy(to.as_ref()), tree());
    let file = tree.files.remove(&from).ok_or(ErrorKind::NotFound)?;
    tree.files.insert(to.clone(), file);
    tree.written.retain(|other| *other != to && *other != from);
    tree.written.push(to);
    Ok(())
}

/// As [`std::fs::remove_file`].
///
/// # Errors
/// There is no such file.
pub fn remove_file(path: impl AsRef<Path>) -> io::Result<()> {
    let gone = tree().files.remove(&tidy(path.as_ref()));
    gone.map(drop).ok_or_else(|| ErrorKind::NotFound.into())
}

/// Does nothing: folders are where files are.
///
/// # Errors
/// None.
pub fn create_dir_all(_path: impl AsRef<Path>) -> io::Result<()> {
    Ok(())
}

/// The absolute path of a file or folder.
///
/// # Errors
/// There is none.
pub fn canonicalize(path: impl AsRef<Path>) -> io::Result<PathBuf> {
    metadata(path.as_ref())?;
    Ok(tidy(path.as_ref()))
}

/// As [`std::fs::exists`].
///
/// # Errors
/// None.
pub fn exists(path: impl AsRef<Path>) -> io::Result<bool> {
    Ok(metadata(path).is_ok())
}

/// What is known of a file or folder.
#[derive(Clone, Debug)]
pub struct Metadata {
    /// Bytes of a file.
    length: Option<u64>,
}

/// As [`std::fs::metadata`].
///
/// # Errors
/// There is no such file or folder.
pub fn metadata(path: impl AsRef<Path>) -> io::Result<Metadata> {
    let (path, tree) = (tidy(path.as_ref()), tree());
    let length = tree.files.get(&path).map(|file| file.len() as u64);
    if length.is_none() && !tree.is_folder(&path) {
        return Err(ErrorKind::NotFound.into());
    }
    Ok(Metadata { length })
}

/// Permissions, of which there are none.
#[derive(Clone, Copy, Debug)]
pub struct Permissions;

impl Permissions {
    /// Every file may be written.
    pub fn readonly(&self) -> bool {
        false
    }
}

impl Metadata {
    /// Whether it is a file.
    pub fn is_file(&self) -> bool {
        self.length.is_some()
    }

    /// Whether it is a folder.
    pub fn is_dir(&self) -> bool {
        self.length.is_none()
    }

    /// Its bytes; 0 of a folder.
    pub fn len(&self) -> u64 {
        self.length.unwrap_or_default()
    }

    /// Whether it has no bytes.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Its permissions.
    pub fn permissions(&self) -> Permissions {
        Permissions
    }

    /// Not known: nobody else changes these files.
    ///
    /// # Errors
    /// Always.
    pub fn modified(&self) -> io::Result<SystemTime> {
        Err(ErrorKind::Unsupported.into())
    }
}

/// A file of a folder.
#[derive(Clone, Debug)]
pub struct DirEntry {
    path: PathBuf,
}

impl DirEntry {
    /// Its name.
    pub fn file_name(&self) -> OsString {
        self.path
            .file_name()
            .map(OsStr::to_owned)
            .unwrap_or_default()
    }

    /// Its path.
    pub fn path(&self) -> PathBuf {
        self.path.clone()
    }

    /// What is known of it.
    ///
    /// # Errors
    /// It was removed.
    pub fn metadata(&self) -> io::Result<Metadata> {
        metadata(&self.path)
    }

    /// Whether it is a file or a folder.
    ///
    /// # Errors
    /// It was removed.
    pub fn file_type(&self) -> io::Result<Metadata> {
        metadata(&self.path)
    }
}

/// The files and folders of a folder, by name.
///
/// # Errors
/// There is no such folder.
pub fn read_dir(path: impl AsRef<Path>) -> io::Result<impl Iterator<Item = io::Result<DirEntry>>> {
    let (path, tree) = (tidy(path.as_ref()), tree());
    if !tree.is_folder(&path) {
        return Err(ErrorKind::NotFound.into());
    }
    let below = tree.files.keys().filter_map(|f| f.strip_prefix(&path).ok());
    let mut names: Vec<PathBuf> = below
        .filter_map(|rest| Some(path.join(rest.components().next()?)))
        .collect();
    names.dedup();
    Ok(names.into_iter().map(|path| Ok(DirEntry { path })))
}

/// How a file is opened.
#[derive(Clone, Copy, Debug, Default)]
pub struct OpenOptions {
    is_new: bool,
}

impl OpenOptions {
    /// For reading or writing.
    pub fn new() -> OpenOptions {
        OpenOptions::default()
    }

    /// For writing.
    pub fn write(&mut self, _writes: bool) -> &mut OpenOptions {
        self
    }

    /// Nothing of an older content remains, as always.
    pub fn truncate(&mut self, _truncates: bool) -> &mut OpenOptions {
        self
    }

    /// Only if there is no such file.
    pub fn create_new(&mut self, is_new: bool) -> &mut OpenOptions {
        self.is_new = is_new;
        self
    }

    /// Opens a file for writing.
    ///
    /// # Errors
    /// It exists already, and must not.
    pub fn open(&self, path: impl AsRef<Path>) -> io::Result<File> {
        let path = tidy(path.as_ref());
        if self.is_new && tree().files.contains_key(&path) {
            return Err(ErrorKind::AlreadyExists.into());
        }
        write(&path, b"")?;
        Ok(File {
            path,
            content: Arc::default(),
            at: 0,
        })
    }
}

/// An open file. What is written is in it after [`flush`](Write::flush) or [`sync_all`](File::sync_all).
#[derive(Debug)]
pub struct File {
    path: PathBuf,
    content: Arc<Vec<u8>>,
    at: usize,
}

impl File {
    /// Opens a file for reading.
    ///
    /// # Errors
    /// There is no such file.
    pub fn open(path: impl AsRef<Path>) -> io::Result<File> {
        Ok(File {
            path: tidy(path.as_ref()),
            content: Arc::clone(tree().file(path.as_ref())?),
            at: 0,
        })
    }

    /// Does nothing.
    ///
    /// # Errors
    /// None.
    pub fn set_permissions(&self, _permissions: Permissions) -> io::Result<()> {
        Ok(())
    }

    /// Puts what was written into the file.
    ///
    /// # Errors
    /// None.
    pub fn sync_all(&self) -> io::Result<()> {
        let mut tree = tree();
        tree.files
            .insert(self.path.clone(), Arc::clone(&self.content));
        Ok(())
    }

    /// Does nothing: there are no other processes.
    ///
    /// # Errors
    /// None.
    pub fn try_lock(&self) -> io::Result<()> {
        Ok(())
    }

    /// Does nothing, either.
    ///
    /// # Errors
    /// None.
    pub fn try_lock_shared(&self) -> io::Result<()> {
        Ok(())
    }
}

impl Read for File {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let mut rest = &self.content[self.at..];
        let count = rest.read(into)?;
        self.at += count;
        Ok(count)
    }
}

impl Write for File {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        Arc::make_mut(&mut self.content).extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.sync_all()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_in_memory_are_written_found_renamed_and_removed() {
        write("/a/sub/b.txt", "two").unwrap();
        write("a/./x/../c.txt", "three").unwrap();
        assert_eq!(read("/a/sub/../c.txt").unwrap(), b"three");
        assert_eq!(read("/a").unwrap_err().kind(), ErrorKind::IsADirectory);
        assert_eq!(read("/a/d").unwrap_err().kind(), ErrorKind::NotFound);
        assert!(metadata("/a/sub").unwrap().is_dir() && !exists("/nowhere").unwrap());
        let names: Vec<_> = read_dir("/a").unwrap().flatten().collect();
        let names: Vec<_> = names.iter().map(DirEntry::file_name).collect();
        assert_eq!(names, ["c.txt", "sub"]);

        let mut draft = OpenOptions::new()
            .write(true)
            .create_new(true)
            .open("/a/draft")
            .unwrap();
        draft.write_all(b"whole").unwrap();
        assert_eq!(metadata("/a/draft").unwrap().len(), 0, "not yet there");
        draft.sync_all().unwrap();
        rename("/a/draft", "/a/c.txt").unwrap();
        let mut text = String::new();
        File::open("/a/c.txt")
            .unwrap()
            .read_to_string(&mut text)
            .unwrap();
        assert_eq!(text, "whole");
        let written = take_written();
        assert_eq!(written, [Path::new("/a/c.txt")]);
        assert!(take_written().is_empty());
        remove_file("/a/c.txt").unwrap();
        assert!(remove_file("/a/c.txt").is_err());
    }
}
