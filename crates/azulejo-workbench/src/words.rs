//! What the window says, in the languages of its sources: English, Spanish, Portuguese.
//!
//! The English text is the key: the code stays readable, and a text without translation is still
//! a text. A test holds every text of the window to the tables.

use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::sync::OnceLock;

mod app;
mod brdf;
mod dialogs;
mod inspector;
mod light;
mod menu;
#[cfg(test)]
mod tests;
mod tree;
mod view_tab;
mod viewport;

/// A language of the window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Language {
    /// English.
    #[default]
    English,
    /// Spanish.
    Spanish,
    /// Portuguese.
    Portuguese,
}

/// One text: English, Spanish, Portuguese.
type Translation = [&'static str; 3];

/// The tables, one for each part of the window.
const TABLES: [&[Translation]; 9] = [
    app::TABLE,
    menu::TABLE,
    tree::TABLE,
    viewport::TABLE,
    inspector::TABLE,
    brdf::TABLE,
    light::TABLE,
    view_tab::TABLE,
    dialogs::TABLE,
];

impl Language {
    /// All of them.
    pub const ALL: [Language; 3] = [Language::English, Language::Spanish, Language::Portuguese];

    /// The desktop's language, if it is one of these.
    pub fn from_system() -> Language {
        let set = |name: &&str| std::env::var(name).is_ok_and(|v| !v.is_empty());
        let variable = ["LC_ALL", "LC_MESSAGES", "LANG"].into_iter().find(set);
        let value = variable.and_then(|name| std::env::var(name).ok());
        match value.as_deref().and_then(|v| v.get(..2)) {
            Some("es") => Language::Spanish,
            Some("pt") => Language::Portuguese,
            _ => Language::English,
        }
    }

    /// Its own name.
    pub fn name(self) -> &'static str {
        match self {
            Language::English => "English",
            Language::Spanish => "Español",
            Language::Portuguese => "Português",
        }
    }

    /// `english` in this language; itself where there is no translation.
    pub fn tr(self, english: &str) -> &str {
        static INDEX: OnceLock<HashMap<&str, &Translation>> = OnceLock::new();
        let index = INDEX.get_or_init(|| {
            let entries = TABLES.iter().flat_map(|table| table.iter());
            entries.map(|entry| (entry[0], entry)).collect()
        });
        index.get(english).map_or(english, |e| e[self as usize])
    }
}
