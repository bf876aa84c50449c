//! The texts of the window in its languages: English, Spanish, Portuguese.
//!
//! The English text is the key: the code stays readable, and a text without a translation is
//! displayed in English. A test checks that the tables contain every text of the window.

use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::sync::OnceLock;

mod app;
mod brdf;
mod cards;
mod dialogs;
mod failures;
mod files;
mod inspector;
mod library;
mod light;
mod lightmap;
mod menu;
mod panels;
mod surroundings;
#[cfg(test)]
mod tests;
mod tree;
mod view_tab;
mod viewport;
mod views;

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

/// A text in English, Spanish and Portuguese.
type Translation = [&'static str; 3];

/// The tables, one for each part of the window.
const TABLES: [&[Translation]; 17] = [
    app::TABLE,
    menu::TABLE,
    panels::TABLE,
    tree::TABLE,
    viewport::TABLE,
    inspector::TABLE,
    surroundings::TABLE,
    brdf::TABLE,
    cards::TABLE,
    failures::TABLE,
    light::TABLE,
    library::TABLE,
    lightmap::TABLE,
    view_tab::TABLE,
    views::TABLE,
    dialogs::TABLE,
    files::TABLE,
];

/// Characters of a name that is named in a text of one line.
const LONGEST_NAME: usize = 32;

impl Language {
    /// All languages.
    pub const ALL: [Language; 3] = [Language::English, Language::Spanish, Language::Portuguese];

    /// The system's language, if it is supported.
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

    /// Its name in the language itself.
    pub fn name(self) -> &'static str {
        match self {
            Language::English => "English",
            Language::Spanish => "Español",
            Language::Portuguese => "Português",
        }
    }

    /// A name in quotation marks; of a long one the beginning.
    pub fn quoted(self, name: &str) -> String {
        let mut short: String = name.chars().take(LONGEST_NAME).collect();
        if short.len() < name.len() {
            short.push('…');
        }
        match self {
            Language::Spanish => format!("«{short}»"),
            Language::English | Language::Portuguese => format!("“{short}”"),
        }
    }

    /// Translates `english`; returns it unchanged if there is no translation.
    pub fn tr(self, english: &str) -> &str {
        static INDEX: OnceLock<HashMap<&str, &Translation>> = OnceLock::new();
        let index = INDEX.get_or_init(|| {
            let entries = TABLES.iter().flat_map(|table| table.iter());
            entries.map(|entry| (entry[0], entry)).collect()
        });
        index.get(english).map_or(english, |e| e[self as usize])
    }
}
