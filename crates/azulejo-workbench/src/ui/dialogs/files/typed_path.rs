//! Paths as they are typed.

use std::path::{Component, MAIN_SEPARATOR, Path, PathBuf};

/// The path that is meant by `text` in `folder`: an absolute or relative one, or one that begins
/// with `~`, which stands for `home`.
pub fn resolve(folder: &Path, home: Option<&Path>, text: &str) -> PathBuf {
    if let Some(home) = home
        && let Some(rest) = text.strip_prefix('~')
        && (rest.is_empty() || rest.starts_with(is_separator))
    {
        return tidy(&home.join(rest.trim_start_matches(is_separator)));
    }
    tidy(&folder.join(text))
}

/// Whether `text` is more than the name of a file in the folder.
pub fn has_folders(text: &str) -> bool {
    text.contains(is_separator) || text == "~" || text == ".."
}

/// Whether `text` can only mean a folder.
pub fn is_folder(text: &str) -> bool {
    text.ends_with(is_separator)
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

/// The folders above a path and itself, outermost first, with their names.
pub fn crumbs(folder: &Path) -> Vec<(String, PathBuf)> {
    let mut found: Vec<(String, PathBuf)> = folder
        .ancestors()
        .filter(|a| !a.as_os_str().is_empty())
        .map(|a| {
            let name = a.file_name().unwrap_or(a.as_os_str());
            (name.to_string_lossy().into_owned(), a.to_owned())
        })
        .collect();
    found.reverse();
    found
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
    fn folders_are_told_from_names() {
        assert!(has_folders("a/b") && has_folders("~") && has_folders("..") && !has_folders("a.b"));
        assert!(is_folder("a/") && !is_folder("a"));
    }

    #[test]
    fn every_folder_of_a_path_has_a_name() {
        let crumbs = crumbs(Path::new("/a/b"));
        let names: Vec<&str> = crumbs.iter().map(|(name, _)| &**name).collect();
        assert_eq!(names, ["/", "a", "b"]);
        assert_eq!(crumbs[1].1, Path::new("/a"));
    }

    #[test]
    fn extensions_are_not_part_of_the_stem() {
        assert_eq!(stem_length("größe.grf"), 5);
        assert_eq!(stem_length("name"), 4);
        assert_eq!(stem_length(".rc"), 3);
    }
}
