//! Settings kept between sessions.

use crate::view::ColorMap;
use crate::words::Language;
use azulejo::output::Output;
use azulejo::trace::Progress;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use toml::Table;

/// Whether the window is light or dark.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Theme {
    /// As on the desktop.
    #[default]
    System,
    /// Dark text on a light background.
    Light,
    /// Light text on a dark background.
    Dark,
}

/// Settings kept between sessions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Preferences {
    /// The language of the window.
    pub language: Language,
    /// Whether the window is light or dark.
    pub theme: Theme,
    /// Scale of text and controls relative to the desktop's.
    pub scale: f32,
    /// The default colour map.
    pub color_map: ColorMap,
    /// Seconds from a change to its recovery copy; 0 for never.
    pub autosave: u32,
    /// Threads of solver and renderer; 0 leaves one to the window.
    pub threads: usize,
    /// Paths per pixel of a finished render.
    pub picture_samples: u32,
    /// Final gather rays at each path's first diffuse surface, which sharpen shadows and hide
    /// patches; 0 for the usual number, 8.
    pub picture_gather: u32,
    /// Whether the tree of the scene is shown.
    pub shows_tree: bool,
    /// Whether the properties are shown.
    pub shows_properties: bool,
    /// Width of the tree in points; 0 for a share of the window.
    pub tree_width: f32,
    /// Width of the properties in points; 0 for a share of the window.
    pub properties_width: f32,
    /// Width of the lab in points; 0 for a share of the window.
    pub lab_width: f32,
    /// Recently opened or saved files, the latest first.
    pub recent: Vec<PathBuf>,
    /// Where the window was at the end of the last session. As a table it is the last in the file.
    pub window: WindowPlace,
}

/// Where a window is on the desktop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct WindowPlace {
    /// Width and height of its inside, in points of the desktop, while it is not maximized.
    pub size: [f32; 2],
    /// Position of its upper left corner in points of the desktop, if that says it.
    pub position: Option<[i32; 2]>,
    /// Whether it is maximized.
    pub is_maximized: bool,
}

impl Default for WindowPlace {
    fn default() -> WindowPlace {
        WindowPlace {
            size: [1280.0, 800.0],
            position: None,
            is_maximized: false,
        }
    }
}

impl WindowPlace {
    /// Limits the values of a file that may have been edited by hand.
    fn limited(self) -> WindowPlace {
        let is_size = |(points, least): (f32, f32)| (least..=16_384.0).contains(&points);
        if self.size.into_iter().zip(SMALLEST_WINDOW).all(is_size) {
            self
        } else {
            WindowPlace::default()
        }
    }
}

impl Default for Preferences {
    fn default() -> Preferences {
        Preferences {
            language: Language::from_system(),
            theme: Theme::default(),
            scale: 1.0,
            color_map: ColorMap::default(),
            autosave: 20,
            threads: 0,
            picture_samples: 256,
            picture_gather: 0,
            shows_tree: true,
            shows_properties: true,
            tree_width: 0.0,
            properties_width: 0.0,
            lab_width: 0.0,
            recent: Vec::new(),
            window: WindowPlace::default(),
        }
    }
}

/// Maximum number of final gather rays.
pub const MAX_GATHER: u32 = 1024;
/// The smallest width and height of the window, points.
pub const SMALLEST_WINDOW: [f32; 2] = [480.0, 320.0];
/// No panel is wider, points.
const MAX_WIDTH: f32 = 4_096.0;
/// Limit on the number of recent files.
const MAX_RECENT: usize = 12;

impl Preferences {
    /// Loads preferences; returns the defaults with an error message if they cannot be read.
    pub fn load(path: &Path) -> (Preferences, Option<String>) {
        let text = match std::fs::read_to_string(path) {
            Ok(text) => text,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
                return (Preferences::default(), None);
            }
            Err(e) => return (Preferences::default(), Some(error_text(path, &e))),
        };
        match toml::from_str::<Preferences>(&text) {
            Ok(preferences) => (preferences.limited(), None),
            Err(e) => (Preferences::default(), Some(error_text(path, &e))),
        }
    }

    /// Stores the preferences atomically. Recent files whose paths are not UTF-8 are omitted, so
    /// that one of them does not prevent storing the rest.
    ///
    /// # Errors
    ///
    /// A message with the reason why they cannot be written.
    pub fn store(&self, path: &Path) -> Result<(), String> {
        let mut stored = self.clone();
        stored.recent.retain(|p| p.to_str().is_some());
        let text = toml::to_string(&stored).map_err(|e| error_text(path, &e))?;
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(|e| error_text(folder, &e))?;
        }
        let output = Output::check(path).map_err(|e| e.to_string())?;
        output
            .write(&Progress::new(), |out| out.write_all(text.as_bytes()))
            .map_err(|e| e.to_string())
    }

    /// These preferences with one changed, by its key in the file; `value` as it stands there, but
    /// text needs no quotes.
    ///
    /// # Errors
    ///
    /// A message, if there is no such key or its values are of another kind.
    pub fn with(&self, key: &str, value: &str) -> Result<Preferences, String> {
        // Recent files may have names that are not Unicode.
        let others = Preferences {
            recent: Vec::new(),
            ..self.clone()
        };
        let mut table = Table::try_from(others).map_err(|e| e.to_string())?;
        if !table.contains_key(key) {
            let keys: Vec<String> = table.keys().cloned().collect();
            return Err(format!(
                "no preference \"{key}\", expected one of {}",
                keys.join(", ")
            ));
        }
        let parsed: Option<Table> = toml::from_str(&format!("value = {value}")).ok();
        let parsed = parsed.and_then(|mut table| table.remove("value"));
        table.insert(key.to_owned(), parsed.unwrap_or_else(|| value.into()));
        let wrong = |e: toml::de::Error| format!("preference {key}: {}", e.message().trim_end());
        let changed: Preferences = table.try_into().map_err(wrong)?;
        Ok(Preferences {
            recent: self.recent.clone(),
            ..changed.limited()
        })
    }

    /// Limits the values of a file that may have been edited by hand.
    fn limited(mut self) -> Preferences {
        self.scale = if self.scale.is_finite() {
            self.scale.clamp(0.5, 3.0)
        } else {
            1.0
        };
        self.picture_samples = self.picture_samples.clamp(1, 1 << 16);
        self.picture_gather = self.picture_gather.min(MAX_GATHER);
        let widths = [
            &mut self.tree_width,
            &mut self.properties_width,
            &mut self.lab_width,
        ];
        for width in widths {
            *width = if width.is_finite() {
                width.clamp(0.0, MAX_WIDTH)
            } else {
                0.0
            };
        }
        self.window = self.window.limited();
        self.recent.truncate(MAX_RECENT);
        self
    }

    /// Moves a file to the front of the recent files.
    pub fn note_recent(&mut self, path: &Path) {
        self.recent.retain(|p| p != path);
        self.recent.insert(0, path.to_owned());
        self.recent.truncate(MAX_RECENT);
    }
}

fn error_text(path: &Path, error: &dyn std::fmt::Display) -> String {
    format!("{}: {error}", path.display())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn preferences_come_back_and_nonsense_is_said() {
        let folder = std::env::temp_dir().join(format!("azulejo-prefs-{}", std::process::id()));
        let path = folder.join("a/preferences.toml");
        assert_eq!(Preferences::load(&path), (Preferences::default(), None));
        let mut mine = Preferences {
            language: Language::Portuguese,
            theme: Theme::Dark,
            autosave: 7,
            window: WindowPlace {
                size: [900.0, 640.5],
                position: Some([-20, 40]),
                is_maximized: true,
            },
            ..Preferences::default()
        };
        mine.note_recent(Path::new("/a/b.3ds"));
        mine.store(&path).unwrap();
        assert_eq!(Preferences::load(&path), (mine.clone(), None));
        // Of an earlier version.
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, format!("file_dialogs = \"own\"\n{text}")).unwrap();
        assert_eq!(Preferences::load(&path), (mine, None));
        std::fs::write(&path, "scale = \"large\"").unwrap();
        let (preferences, why) = Preferences::load(&path);
        assert_eq!(preferences, Preferences::default());
        assert!(why.unwrap().contains("preferences.toml"));
        std::fs::write(
            &path,
            "scale = 1e9\npicture_samples = 0\npicture_gather = 2000\ntree_width = nan\n\
             properties_width = -3.0\n[window]\nsize = [3.0, 800.0]\nis_maximized = true",
        )
        .unwrap();
        let (preferences, _) = Preferences::load(&path);
        assert_eq!((preferences.scale, preferences.picture_samples), (3.0, 1));
        assert_eq!(preferences.picture_gather, MAX_GATHER);
        assert_eq!(
            (preferences.tree_width, preferences.properties_width),
            (0.0, 0.0)
        );
        assert_eq!(preferences.window, WindowPlace::default());
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn recent_files_are_named_once() {
        let mut p = Preferences::default();
        for k in 0..20 {
            p.note_recent(Path::new(&format!("/{}", k % 15)));
        }
        assert_eq!(p.recent.len(), MAX_RECENT);
        assert_eq!(p.recent[0], Path::new("/4"));
    }
}
