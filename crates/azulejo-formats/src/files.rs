//! Where the files come from that a model names.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};
use std::{fmt, fs, io};

/// Gives readers the files that a model names, by the name that stands in the model.
///
/// Names are relative to the model's own folder, with `/` or `\` between folders.
pub trait Files {
    /// The content of a file.
    ///
    /// # Errors
    /// [`FileError`]: missing, unreadable, larger than the limit, or outside the folder.
    fn read(&self, name: &str) -> Result<Vec<u8>, FileError>;
}

/// Why a named file could not be had.
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
    /// The operating system refused.
    Io(io::Error),
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FileError::Missing => f.write_str("there is no such file"),
            FileError::Outside => f.write_str("the name leads out of the model's folder (allow the folder explicitly if you trust the model)"),
            FileError::TooLarge { limit } => write!(f, "the file is larger than {limit} bytes"),
            FileError::Io(e) => write!(f, "{e}"),
        }
    }
}

impl std::error::Error for FileError {}

/// The files below one folder, and below folders that the user allows by name.
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

    /// Also gives files below another folder, when a model names them by `..` or absolutely.
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
        let real = fs::canonicalize(self.root.join(path)).map_err(not_found)?;
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
            // A pipe or a device would never end.
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

/// Files in memory, for tests and for models that come over a wire.
#[derive(Clone, Debug, Default)]
pub struct Memory {
    files: BTreeMap<String, Vec<u8>>,
}

impl Memory {
    /// No files: whatever a model names is missing.
    pub fn new() -> Memory {
        Memory::default()
    }

    /// Adds a file.
    pub fn with(mut self, name: impl Into<String>, content: impl Into<Vec<u8>>) -> Memory {
        self.files.insert(name.into(), content.into());
        self
    }
}

impl Files for Memory {
    fn read(&self, name: &str) -> Result<Vec<u8>, FileError> {
        self.files.get(name).cloned().ok_or(FileError::Missing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_keeps_its_readers_inside() {
        let folder = Folder::new(env!("CARGO_MANIFEST_DIR"))
            .allow(concat!(env!("CARGO_MANIFEST_DIR"), "/src"));
        assert!(folder.read("Cargo.toml").is_ok());
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
