//! The translations are those of texts of the window.

use super::*;
use crate::ui::actions::ACTIONS;
use crate::view::COLORS;
use azulejo::scene::brdf::MODELS;
use azulejo::scene::sky::CieSky;
use std::collections::{BTreeMap, BTreeSet};
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// As many texts may wait for somebody who speaks the languages. With more, the window would be in two languages.
const UNTRANSLATED: usize = 20;

/// The sources of the window.
fn sources() -> Vec<(PathBuf, String)> {
    let mut paths = Vec::new();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    walk(&root, &mut paths);
    assert!(
        paths.len() > 40,
        "{} sources in {}",
        paths.len(),
        root.display()
    );
    paths
}

fn walk(folder: &Path, found: &mut Vec<(PathBuf, String)>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() && !path.ends_with("words") {
            walk(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            let text = std::fs::read_to_string(&path).unwrap();
            found.push((path, text));
        }
    }
}

/// The string literals of a source, each with the code between it and the previous literal.
fn literals(source: &str) -> Vec<(&str, String)> {
    let mut tokens = Vec::new();
    let (mut at, mut code) = (0, 0);
    while let Some(step) = source[at..].find(['"', '/', '\'']) {
        at += step;
        let rest = &source[at..];
        if rest.starts_with("//") {
            at += rest.find('\n').unwrap_or(rest.len());
        } else if rest.starts_with('"') {
            let (text, length) = literal(rest);
            tokens.push((source[code..at].trim_end(), text));
            at += length;
            code = at;
        } else {
            at += character(rest).unwrap_or(1);
        }
    }
    tokens
}

/// The text of the literal at the start of `source`, and its length with the quotes.
fn literal(source: &str) -> (String, usize) {
    let mut text = String::new();
    let mut rest = source[1..].chars();
    while let Some(c) = rest.next() {
        match c {
            '"' => break,
            '\\' => match rest.next() {
                // A continued line.
                Some('\n') => rest = rest.as_str().trim_start().chars(),
                Some('n') => text.push('\n'),
                Some(other) => text.push(other),
                None => break,
            },
            other => text.push(other),
        }
    }
    (text, source.len() - rest.as_str().len())
}

/// Length of the character literal at the start of `source`; `None` for a lifetime.
fn character(source: &str) -> Option<usize> {
    let inner = source.strip_prefix('\'')?;
    let end = match inner.strip_prefix('\\') {
        Some(escaped) => 2 + escaped[1..].find('\'')?,
        None => inner.chars().next()?.len_utf8(),
    };
    (inner.get(end..)?.starts_with('\'')).then_some(end + 2)
}

/// Whether the code before a literal passes it to `tr`, and not to a function such as `write_str`.
fn is_translated(code: &str) -> bool {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    code.strip_suffix("tr(")
        .is_some_and(|before| !before.ends_with(is_name))
}

/// The parts of the window in a file, each with its English texts.
fn keys(source: &str) -> BTreeSet<(String, String)> {
    let parts: BTreeMap<String, Translations> = toml::from_str(source).unwrap();
    let pairs = |(part, texts): (String, Translations)| {
        texts.into_keys().map(move |text| (part.clone(), text))
    };
    parts.into_iter().flat_map(pairs).collect()
}

/// Each text with its translations to Spanish and Portuguese.
fn entries() -> Vec<[String; 3]> {
    let mut portuguese = translations(PORTUGUESE);
    let spanish = translations(SPANISH).into_iter();
    spanish
        .filter_map(|(english, es)| portuguese.remove(&english).map(|pt| [english, es, pt]))
        .collect()
}

/// The texts of the window that are meant to be translated, each with where it stands.
fn texts() -> BTreeMap<String, String> {
    let mut texts = BTreeMap::new();
    for (path, source) in sources() {
        let literals = literals(&source).into_iter();
        let translated = literals.filter(|(code, _)| is_translated(code));
        texts.extend(translated.map(|(_, text)| (text, path.display().to_string())));
    }
    assert!(
        texts.len() > 200,
        "only {} texts in calls of tr",
        texts.len()
    );
    let mut note = |text: &str, place: &str| texts.insert(text.to_owned(), place.to_owned());
    for action in ACTIONS {
        note(action.label, "ACTIONS");
    }
    for (name, _) in COLORS {
        note(name, "COLORS");
    }
    for sky in CieSky::all() {
        note(sky.name(), "types of skies");
    }
    for label in undo_labels() {
        note(&label, "labels of undo");
    }
    for parameter in MODELS.iter().flat_map(|model| model.all_parameters()) {
        note(parameter.about, "parameters of reflection models");
        // The others are symbols.
        if ["degrees", "radii"].contains(&parameter.unit) {
            note(parameter.unit, "units of reflection models");
        }
    }
    texts
}

/// What undo takes back.
fn undo_labels() -> Vec<String> {
    let source = include_str!("../document/edit.rs");
    let body = source.split("pub fn label").nth(1).unwrap();
    let body = body.split("    }\n\n").next().unwrap();
    let labels: Vec<String> = literals(body).into_iter().map(|(_, text)| text).collect();
    assert!(labels.len() > 15, "{labels:?}");
    labels
}

#[test]
fn sources_are_understood() {
    let source = r#"tr("a\"b"); // "no"
        let c = '"'; let d: &'static str = cx.tr(
            "two \
             lines"); '\''; "end""#;
    let tokens = literals(source);
    let texts: Vec<&str> = tokens.iter().map(|(_, t)| t.as_str()).collect();
    assert_eq!(texts, ["a\"b", "two lines", "end"]);
    assert!(is_translated(tokens[1].0) && !is_translated("f.write_str("));
}

/// Whoever adds a text need not speak Spanish and Portuguese: it is displayed in English, and listed in the
/// output of this test, which does not fail on a few of them.
#[test]
fn texts_are_translated_but_for_a_few() {
    let translations = translations(SPANISH);
    let mut missing = texts();
    missing.retain(|text, _| !translations.contains_key(text));
    if !missing.is_empty() {
        // Tests that pass are silent where they print as usual.
        let mut out = std::io::stdout();
        writeln!(out, "texts without translation: {missing:#?}").unwrap();
    }
    let count = missing.len();
    assert!(
        count <= UNTRANSLATED,
        "{count} texts, listed above, have no translation"
    );
}

#[test]
fn both_languages_have_the_same_texts_and_each_once() {
    let [spanish, portuguese] = [SPANISH, PORTUGUESE].map(keys);
    let only = |a: &BTreeSet<_>, b: &BTreeSet<_>| a.difference(b).cloned().collect::<Vec<_>>();
    assert_eq!(only(&spanish, &portuguese), [], "in Spanish only");
    assert_eq!(only(&portuguese, &spanish), [], "in Portuguese only");
    assert_eq!(
        translations(SPANISH).len(),
        spanish.len(),
        "a text stands in two parts"
    );
}

#[test]
fn no_translation_is_without_use() {
    let mut used = BTreeSet::new();
    let mut paths = sources();
    // Reflection models contain their own names and those of their parameters, and so do skies.
    for models in ["brdf", "sky"] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../azulejo-scene/src");
        walk(&folder.join(models), &mut paths);
    }
    for (_, source) in paths {
        used.extend(literals(&source).into_iter().map(|(_, text)| text));
    }
    let translated = translations(SPANISH).into_keys();
    let unused: Vec<String> = translated.filter(|text| !used.contains(text)).collect();
    assert!(unused.is_empty(), "{unused:#?}");
}

#[test]
fn translations_say_something() {
    for text in entries().iter().flatten() {
        assert!(!text.is_empty() && text.trim() == text, "{text:?}");
    }
}

/// An ellipsis announces a dialog and a colon a value, in every language.
#[test]
fn translations_end_as_their_texts_do() {
    for entry in entries() {
        let end = |text: &str| {
            let last = text.chars().last();
            last.filter(|c| ['…', ':', '.', '°'].contains(c))
        };
        assert!(entry.iter().all(|t| end(t) == end(&entry[0])), "{entry:?}");
    }
}

/// A sentence that is the same in two languages has not been translated.
#[test]
fn sentences_are_translated() {
    for entry in entries() {
        let is_sentence = entry[0].split(' ').filter(|w| w.len() > 2).count() > 2;
        assert!(
            !is_sentence || (entry[0] != entry[1] && entry[0] != entry[2]),
            "{entry:?}"
        );
    }
}

/// Two entries of one menu must not have the same text.
#[test]
fn entries_of_a_menu_differ_in_every_language() {
    for language in Language::ALL {
        let mut seen = BTreeSet::new();
        for action in ACTIONS {
            let entry = (
                action.menu.label(Language::English),
                language.tr(action.label),
            );
            assert!(seen.insert(entry), "{entry:?} in {language:?}");
        }
    }
}

#[test]
fn an_unknown_text_stays_as_it_is() {
    assert_eq!(Language::Spanish.tr("no such text"), "no such text");
    assert_eq!(Language::Spanish.tr("Undo"), "Deshacer");
    assert_eq!(Language::Portuguese.tr("Undo"), "Anular");
    assert_eq!(Language::English.tr("Undo"), "Undo");
}
