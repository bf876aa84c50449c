//! The texts of the window in its languages: English, Spanish, Portuguese.
//!
//! The English text is the key: the code stays readable, and a text without a translation is
//! displayed in English. Translations are in `words/es.toml` and `words/pt.toml` of this crate.

use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::str::FromStr;
use std::sync::OnceLock;

#[cfg(test)]
mod tests;

/// A language of the window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Language {
    /// English, in which all texts stand in the code.
    #[default]
    English,
    /// Spanish, from `words/es.toml`.
    Spanish,
    /// Portuguese, from `words/pt.toml`.
    Portuguese,
}

/// Translations by their English texts.
type Translations = HashMap<String, String>;

const SPANISH: &str = include_str!("../words/es.toml");
const PORTUGUESE: &str = include_str!("../words/pt.toml");

/// Characters of a name that is named in a text of one line.
const LONGEST_NAME: usize = 32;

impl Language {
    /// All languages, in the order of the preferences.
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

    /// Its code of two letters (ISO 639-1).
    pub fn code(self) -> &'static str {
        match self {
            Language::English => "en",
            Language::Spanish => "es",
            Language::Portuguese => "pt",
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
        static ES: OnceLock<Translations> = OnceLock::new();
        static PT: OnceLock<Translations> = OnceLock::new();
        let translations = match self {
            Language::English => return english,
            Language::Spanish => ES.get_or_init(|| translations(SPANISH)),
            Language::Portuguese => PT.get_or_init(|| translations(PORTUGUESE)),
        };
        translations.get(english).map_or(english, String::as_str)
    }
}

impl FromStr for Language {
    type Err = String;

    /// Reads the code of a language.
    fn from_str(text: &str) -> Result<Language, String> {
        let language = Language::ALL.into_iter().find(|l| l.code() == text);
        language.ok_or_else(|| format!("language \"{text}\", expected one of en, es, pt"))
    }
}

/// The translations of all parts of the window. A test reads the files: if one were damaged, a window in
/// English would be better than none.
fn translations(source: &str) -> Translations {
    let parts: HashMap<String, Translations> = toml::from_str(source).unwrap_or_default();
    parts.into_values().flatten().collect()
}
