//! What a person chose once, kept between sessions.

use crate::view::ColorMap;
use crate::words::Language;
use azulejo::output::Output;
use azulejo::trace::Progress;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Bright or dark.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Theme {
    /// As the desktop has it.
    #[default]
    System,
    /// Dark on bright.
    Light,
    /// Bright on dark.
    Dark,
}

/// Choices that outlive a session.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Preferences {
    /// The language of the window.
    pub language: Language,
    /// Bright or dark.
    pub theme: Theme,
    /// Size of the window's texts and controls; 1 is the desktop's.
    pub scale: f32,
    /// The colour map of false colours.
    pub color_map: ColorMap,
    /// Seconds after a change until it is written for recovery; 0 for never.
    pub autosave: u32,
    /// Threads of solver and pictures; 0 leaves one to the window.
    pub threads: usize,
    /// Paths per pixel at which a picture rests.
    pub picture_samples: u32,
    /// Rays of a picture's final gather at each path's first matt surface, which sharpens shadows
    /// and hides patches; 0 for none, where light is solved.
    pub picture_gather: u32,
    /// Files that were opened or saved, the last first.
    pub recent: Vec<PathBuf>,
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
            recent: Vec::new(),
        }
    }
}

/// The most rays of a final gather.
pub const MAX_GATHER: u32 = 1024;
/// More recent files than this are forgotten.
const MAX_RECENT: usize = 12;

impl Preferences {
    /// Reads them; what cannot be read is default, with the reason why.
    pub fn load(path: &Path) -> (Preferences, Option<String>) {
        let text = match std::fs::read_to_string(path) {
            Ok(text) => text,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
                return (Preferences::default(), None);
            }
            Err(e) => return (Preferences::default(), Some(said(path, &e))),
        };
        match toml::from_str::<Preferences>(&text) {
            Ok(preferences) => (preferences.limited(), None),
            Err(e) => (Preferences::default(), Some(said(path, &e))),
        }
    }

    /// Writes them, whole or not at all. Files whose names are no text are left out: one of them
    /// must not keep everything else away.
    ///
    /// # Errors
    /// Why they cannot be written, for people.
    pub fn store(&self, path: &Path) -> Result<(), String> {
        let mut stored = self.clone();
        stored.recent.retain(|p| p.to_str().is_some());
        let text = toml::to_string(&stored).map_err(|e| said(path, &e))?;
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(|e| said(folder, &e))?;
        }
        let output = Output::check(path).map_err(|e| e.to_string())?;
        output
            .write(&Progress::new(), |out| out.write_all(text.as_bytes()))
            .map_err(|e| e.to_string())
    }

    /// Numbers from a file that a person may have written.
    fn limited(mut self) -> Preferences {
        self.scale = if self.scale.is_finite() {
            self.scale.clamp(0.5, 3.0)
        } else {
            1.0
        };
        self.picture_samples = self.picture_samples.clamp(1, 1 << 16);
        self.picture_gather = self.picture_gather.min(MAX_GATHER);
        self.recent.truncate(MAX_RECENT);
        self
    }

    /// Puts a file in front of the recent ones.
    pub fn note_recent(&mut self, path: &Path) {
        self.recent.retain(|p| p != path);
        self.recent.insert(0, path.to_owned());
        self.recent.truncate(MAX_RECENT);
    }
}

fn said(path: &Path, error: &dyn std::fmt::Display) -> String {
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
            ..Preferences::default()
        };
        mine.note_recent(Path::new("/a/b.3ds"));
        mine.store(&path).unwrap();
        assert_eq!(Preferences::load(&path), (mine, None));
        std::fs::write(&path, "scale = \"large\"").unwrap();
        let (found, why) = Preferences::load(&path);
        assert_eq!(found, Preferences::default());
        assert!(why.unwrap().contains("preferences.toml"));
        std::fs::write(
            &path,
            "scale = 1e9\npicture_samples = 0\npicture_gather = 2000",
        )
        .unwrap();
        let (found, _) = Preferences::load(&path);
        assert_eq!((found.scale, found.picture_samples), (3.0, 1));
        assert_eq!(found.picture_gather, MAX_GATHER);
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
