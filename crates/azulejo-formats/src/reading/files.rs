//! Access to the files that a model names.

use super::fonts::{FontFile, FontRequest};
use crate::disk as fs;
use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};
use std::{fmt, io};

/// Provides readers with the files that a model names, by the name used in the model.
///
/// Names are relative to the model's own folder, with `/` or `\` between folders. Many models come
/// from case-insensitive systems: if no file has exactly the given name, one whose name differs
/// only in case may be returned instead.
pub trait Files {
    /// The content of a file.
    ///
    /// # Errors
    /// [`FileError`]: missing, unreadable, larger than the limit, or outside the folder.
    fn read(&self, name: &str) -> Result<Vec<u8>, FileError>;

    /// The font that is most like what a text asks for, wherever fonts are; `None` if there is none, which is the
    /// default, or none with the requested characters.
    fn font(&self, _request: &FontRequest) -> Option<FontFile> {
        None
    }
}

/// The name of a file relative to the model's own folder, where `name` occurs in the file `of`,
/// itself given relative to that folder: `parts/a.flt` and `../b.flt` make `b.flt`.
///
/// A name that leads out of the model's folder keeps its leading `..`, and an absolute name is
/// returned unchanged; [`Files::read`] refuses both unless they are allowed.
pub(crate) fn beside(of: &str, name: &str) -> String {
    let name = name.replace('\\', "/");
    let of = of.replace('\\', "/");
    let (folder, _) = of.rsplit_once('/').unwrap_or_default();
    if name.starts_with('/') || name.as_bytes().get(1) == Some(&b':') {
        return name;
    }
    let mut path: Vec<&str> = Vec::new();
    for part in folder.split('/').chain(name.split('/')) {
        match part {
            "" | "." => {}
            ".." if path.last().is_some_and(|last| *last != "..") => {
                path.pop();
            }
            other => path.push(other),
        }
    }
    path.join("/")
}

/// The bytes of a file that is named in the file `of`, and its name relative to the model's folder.
/// It is searched beside `of`, beside the model, and in both places without the folders of its name.
pub(crate) fn open_beside(
    files: &dyn Files,
    of: &str,
    name: &str,
) -> Result<(String, Vec<u8>), FileError> {
    let path = beside(of, name);
    let plain = beside("", name);
    let base = plain.rsplit('/').next().unwrap_or_default().to_owned();
    let first = files.read(&path);
    if let Ok(bytes) = first {
        return Ok((path, bytes));
    }
    for other in [plain, base] {
        if other != path
            && let Ok(bytes) = files.read(&other)
        {
            return Ok((other, bytes));
        }
    }
    first.map(|bytes| (path, bytes))
}

/// Why a named file could not be read.
#[derive(Debug)]
pub enum FileError {
    /// There is no such file.
    Missing,
    /// The name leads out of the folder: absolute, by `..`, or by a symbolic link.
    Outside,
    /// More bytes than the limit.
    TooLarge {
        /// The limit in bytes.
        limit: u64,
    },
    /// The operating system reported an error.
    Io(io::Error),
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FileError::Missing => f.write_str("there is no such file"),
            FileError::Outside => f.write_str("the name leads out of the model's folder (if you trust the model, allow the folder that has it, as by --allow FOLDER)"),
            FileError::TooLarge { limit } => write!(f, "the file is larger than {limit} bytes"),
            FileError::Io(e) => write!(f, "{e}"),
        }
    }
}

impl std::error::Error for FileError {}

/// The files below one folder, and below other folders that the user allows.
#[derive(Clone, Debug)]
pub struct Folder {
    root: PathBuf,
    allowed: Vec<PathBuf>,
    limit: u64,
}

impl Folder {
    /// The files below `root`, each at most 4 GiB.
    pub fn new(root: impl Into<PathBuf>) -> Folder {
        let root: PathBuf = root.into();
        let root = if root.as_os_str().is_empty() {
            PathBuf::from(".")
        } else {
            root
        };
        Folder {
            root,
            allowed: Vec::new(),
            limit: 4 << 30,
        }
    }

    /// The folder that holds `model`.
    pub fn of_model(model: &Path) -> Folder {
        Folder::new(model.parent().unwrap_or(Path::new(".")))
    }

    /// Also provides files below another folder, if a model names them by `..` or absolutely.
    pub fn allow(mut self, folder: impl Into<PathBuf>) -> Folder {
        self.allowed.push(folder.into());
        self
    }

    fn resolve(&self, name: &str) -> Result<PathBuf, FileError> {
        let plain = name.replace('\\', "/");
        let path = Path::new(&plain);
        let wanders = path
            .components()
            .any(|c| !matches!(c, Component::Normal(_) | Component::CurDir));
        if wanders && self.allowed.is_empty() {
            return Err(FileError::Outside);
        }
        // Canonical paths also catch symbolic links that lead out.
        let real = fs::canonicalize(self.root.join(path))
            .or_else(|e| in_other_capitals(&self.root, path).ok_or(e))
            .map_err(not_found)?;
        let inside = std::iter::once(&self.root).chain(&self.allowed);
        let is_inside = inside
            .filter_map(|folder| fs::canonicalize(folder).ok())
            .any(|folder| real.starts_with(folder));
        if is_inside {
            Ok(real)
        } else {
            Err(FileError::Outside)
        }
    }
}

/// The canonical path below `root` that differs from `path` only in case.
fn in_other_capitals(root: &Path, path: &Path) -> Option<PathBuf> {
    let mut real = root.to_path_buf();
    for part in path.components() {
        let part_name = match part {
            Component::Normal(part_name) => part_name,
            Component::CurDir => continue,
            Component::ParentDir => {
                real.push("..");
                continue;
            }
            _ => return None,
        };
        let part_name = part_name.to_string_lossy().to_lowercase();
        let mut alike: Vec<_> = fs::read_dir(&real)
            .ok()?
            .filter_map(|entry| Some(entry.ok()?.file_name()))
            .filter(|name| name.to_string_lossy().to_lowercase() == part_name)
            .collect();
        // The order of directory entries depends on the file system; the choice must not.
        alike.sort();
        real.push(alike.first()?);
    }
    fs::canonicalize(real).ok()
}

fn not_found(e: io::Error) -> FileError {
    match e.kind() {
        io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => FileError::Missing,
        _ => FileError::Io(e),
    }
}

impl Files for Folder {
    fn read(&self, name: &str) -> Result<Vec<u8>, FileError> {
        let path = self.resolve(name)?;
        let meta = fs::metadata(&path).map_err(not_found)?;
        if !meta.is_file() {
            // Reading a pipe or a device would never end.
            return Err(FileError::Io(io::Error::new(
                io::ErrorKind::InvalidInput,
                "not a regular file",
            )));
        }
        if meta.len() > self.limit {
            return Err(FileError::TooLarge { limit: self.limit });
        }
        fs::read(path).map_err(FileError::Io)
    }
}

/// Files in memory, for tests and for models received over a network.
#[derive(Clone, Debug, Default)]
pub struct Memory {
    files: BTreeMap<String, Vec<u8>>,
    font: Option<FontFile>,
}

impl Memory {
    /// No files: every file that a model names is missing.
    pub fn new() -> Memory {
        Memory::default()
    }

    /// Adds a file.
    pub fn with(mut self, name: impl Into<String>, content: impl Into<Vec<u8>>) -> Memory {
        self.files.insert(name.into(), content.into());
        self
    }

    /// Adds the font of all texts.
    pub fn with_font(mut self, font: FontFile) -> Memory {
        self.font = Some(font);
        self
    }
}

impl Files for Memory {
    fn read(&self, name: &str) -> Result<Vec<u8>, FileError> {
        let alike = || {
            let mut files = self.files.iter();
            files.find(|(other, _)| other.to_lowercase() == name.to_lowercase())
        };
        let entry = self.files.get_key_value(name).or_else(alike);
        entry
            .map(|(_, content)| content.clone())
            .ok_or(FileError::Missing)
    }

    fn font(&self, _request: &FontRequest) -> Option<FontFile> {
        self.font.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_relative_to_the_file_that_holds_them() {
        let check = |of, name, expected: &str| assert_eq!(beside(of, name), expected);
        check("room.wrl", "lamp.wrl", "lamp.wrl");
        check("room.wrl", "./a/../lamp.wrl", "lamp.wrl");
        check("room.wrl", "./../lamp.wrl", "../lamp.wrl");
        check("parts/a.flt", "b.flt", "parts/b.flt");
        check("parts\\a.flt", "..\\b.flt", "b.flt");
        check("parts/a.flt", "../../b.flt", "../b.flt");
        check("../parts/a.flt", "../b.flt", "../b.flt");
        check("parts/a.flt", "/b.flt", "/b.flt");
        check("parts/a.flt", "C:\\b.flt", "C:/b.flt");
    }

    #[test]
    fn case_may_differ() {
        let files = Memory::new().with("Wood.PNG", "1").with("wood.png", "2");
        assert_eq!(files.read("wood.png").unwrap(), b"2");
        assert_eq!(files.read("WOOD.png").unwrap(), b"1");
        assert!(files.read("wool.png").is_err());
    }

    #[test]
    fn files_outside_the_folder_are_refused() {
        let folder = Folder::new(env!("CARGO_MANIFEST_DIR"))
            .allow(concat!(env!("CARGO_MANIFEST_DIR"), "/src"));
        assert!(folder.read("Cargo.toml").is_ok());
        assert!(folder.read("SRC\\Lib.RS").is_ok());
        assert!(folder.read(".\\src\\lib.rs").is_ok());
        assert!(matches!(
            folder.read("no such file"),
            Err(FileError::Missing)
        ));
        assert!(matches!(
            folder.read("../azulejo-scene/Cargo.toml"),
            Err(FileError::Outside)
        ));
        assert!(matches!(
            Folder::new("src").read("/etc/passwd"),
            Err(FileError::Outside)
        ));
    }
}
