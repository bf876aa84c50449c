//! Paths as they are typed.

use crate::platform;
use azulejo::formats::disk;
use std::path::{Component, MAIN_SEPARATOR, Path, PathBuf};

/// Why a typed path is not a file that can be opened or written.
#[derive(Clone, Debug, PartialEq)]
pub enum PathProblem {
    /// There is no such file.
    NoFile(PathBuf),
    /// There is no such folder.
    NoFolder(PathBuf),
    /// A folder stands there.
    IsFolder(PathBuf),
}

/// The file that is meant by `text`, which is relative to `folder` unless it begins with `/` or `~`.
///
/// # Errors
///
/// The reason why it cannot be opened, or, if it `saves`, written: then it need not exist, but its
/// folder must.
pub fn check(saves: bool, folder: &Path, text: &str) -> Result<PathBuf, PathProblem> {
    let text = text.trim();
    let path = resolve(folder, platform::home().as_deref(), text);
    if is_folder(&path) {
        return Err(PathProblem::IsFolder(path));
    }
    if text.ends_with(is_separator) {
        return Err(PathProblem::NoFolder(path));
    }
    match path.parent().filter(|above| !is_folder(above)) {
        Some(above) => Err(PathProblem::NoFolder(above.to_owned())),
        None if saves || disk::exists(&path).unwrap_or_default() => Ok(path),
        None => Err(PathProblem::NoFile(path)),
    }
}

fn is_folder(path: &Path) -> bool {
    disk::metadata(path).is_ok_and(|meta| meta.is_dir())
}

/// The path that is meant by `text` in `folder`: an absolute or relative one, or one that begins
/// with `~`, which stands for `home`.
fn resolve(folder: &Path, home: Option<&Path>, text: &str) -> PathBuf {
    if let Some(home) = home
        && let Some(rest) = text.strip_prefix('~')
        && (rest.is_empty() || rest.starts_with(is_separator))
    {
        return tidy(&home.join(rest.trim_start_matches(is_separator)));
    }
    tidy(&folder.join(text))
}

fn is_separator(c: char) -> bool {
    c == '/' || c == MAIN_SEPARATOR
}

/// The path without `.` and `..`, as shells display it.
fn tidy(path: &Path) -> PathBuf {
    let mut tidied = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => (),
            Component::ParentDir if tidied.file_name().is_some() => {
                tidied.pop();
            }
            // There is nothing above the root.
            Component::ParentDir if tidied.has_root() => (),
            other => tidied.push(other),
        }
    }
    tidied
}

/// The number of characters before the extension of a name.
pub fn stem_length(name: &str) -> usize {
    let stem = Path::new(name).file_stem().unwrap_or_default();
    stem.to_string_lossy().chars().count()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn paths_are_absolute_relative_or_at_home() {
        let (folder, home) = (Path::new("/a/b"), Some(Path::new("/home/me")));
        for (text, path) in [
            ("c.obj", "/a/b/c.obj"),
            ("sub/c.obj", "/a/b/sub/c.obj"),
            ("./c.obj", "/a/b/c.obj"),
            ("../c.obj", "/a/c.obj"),
            ("../../../..", "/"),
            ("/x/y.grf", "/x/y.grf"),
            ("~", "/home/me"),
            ("~/", "/home/me"),
            ("~/m/../y.grf", "/home/me/y.grf"),
            ("~backup.grf", "/a/b/~backup.grf"),
        ] {
            assert_eq!(resolve(folder, home, text), Path::new(path), "{text}");
        }
        assert_eq!(resolve(folder, None, "~/x"), Path::new("/a/b/~/x"));
    }

    #[test]
    fn what_is_not_there_is_told() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
        let path = |name: &str| folder.join(name);
        let (file, none) = (path("src/lib.rs"), path("src/none.rs"));
        let no_folder = || Err(PathProblem::NoFolder(path("zoo")));
        for (text, opened, saved) in [
            (" src/lib.rs ", Ok(file.clone()), Ok(file)),
            (
                "src/none.rs",
                Err(PathProblem::NoFile(none.clone())),
                Ok(none),
            ),
            ("zoo/a.obj", no_folder(), no_folder()),
            ("zoo/", no_folder(), no_folder()),
            (
                "src",
                Err(PathProblem::IsFolder(path("src"))),
                Err(PathProblem::IsFolder(path("src"))),
            ),
        ] {
            assert_eq!(check(false, folder, text), opened, "{text}");
            assert_eq!(check(true, folder, text), saved, "{text}");
        }
    }

    #[test]
    fn extensions_are_not_part_of_the_stem() {
        assert_eq!(stem_length("größe.grf"), 5);
        assert_eq!(stem_length("name"), 4);
        assert_eq!(stem_length(".rc"), 3);
    }
}
