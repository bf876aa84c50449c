//! The places at the left of the file dialog.

use crate::ui::panel_context::PanelContext;
use std::path::{Path, PathBuf};

/// A folder that can be gone to at once.
pub struct FolderPlace {
    /// Its name in the language of the window.
    pub label: String,
    /// The folder.
    pub folder: PathBuf,
}

/// Limit on the number of recent folders.
const MAX_RECENT: usize = 6;

/// The user's folders where they exist, the current one, and those of recent files.
pub struct Places {
    /// The folders of the user and the current one.
    pub standard: Vec<FolderPlace>,
    /// The folders of recent files, the latest first. Whether they still exist is not asked here: a
    /// disk of the network may take long to answer.
    pub recent: Vec<FolderPlace>,
}

impl Places {
    /// Finds the places.
    pub fn find(cx: &PanelContext) -> Places {
        let standard = standard(cx);
        let recent = recent_folders(&cx.app.preferences.recent);
        let is_new = |folder: &PathBuf| standard.iter().all(|p| p.folder != *folder);
        let recent = recent.into_iter().filter(is_new).take(MAX_RECENT);
        let recent = recent.map(|folder| FolderPlace {
            label: name(&folder),
            folder,
        });
        Places {
            recent: recent.collect(),
            standard,
        }
    }
}

fn standard(cx: &PanelContext) -> Vec<FolderPlace> {
    let dirs = directories::UserDirs::new();
    let dirs = dirs.as_ref();
    let owned = |folder: Option<&Path>| folder.map(Path::to_owned);
    let known = [
        (cx.tr("Home"), owned(dirs.map(|d| d.home_dir()))),
        (cx.tr("Desktop"), owned(dirs.and_then(|d| d.desktop_dir()))),
        (
            cx.tr("Documents"),
            owned(dirs.and_then(|d| d.document_dir())),
        ),
        (
            cx.tr("Downloads"),
            owned(dirs.and_then(|d| d.download_dir())),
        ),
        (cx.tr("Current folder"), std::env::current_dir().ok()),
    ];
    let mut places: Vec<FolderPlace> = Vec::new();
    for (label, folder) in known {
        let Some(folder) = folder.filter(|f| f.is_dir()) else {
            continue;
        };
        // Without a desktop these are often the same.
        if places.iter().all(|p| p.folder != folder) {
            let label = label.to_owned();
            places.push(FolderPlace { label, folder });
        }
    }
    places
}

/// The folders of files, each once.
fn recent_folders(files: &[PathBuf]) -> Vec<PathBuf> {
    let mut folders: Vec<PathBuf> = Vec::new();
    for folder in files.iter().filter_map(|f| f.parent()) {
        if !folder.as_os_str().is_empty() && folders.iter().all(|f| f != folder) {
            folders.push(folder.to_owned());
        }
    }
    folders
}

fn name(folder: &Path) -> String {
    let name = folder.file_name().unwrap_or(folder.as_os_str());
    name.to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recent_folders_are_named_once() {
        let files = ["/a/x.obj", "/b/y.obj", "/a/z.obj", "loose.obj"].map(PathBuf::from);
        assert_eq!(recent_folders(&files), ["/a", "/b"].map(PathBuf::from));
        assert_eq!(name(Path::new("/a/models")), "models");
        assert_eq!(name(Path::new("/")), "/");
    }
}
