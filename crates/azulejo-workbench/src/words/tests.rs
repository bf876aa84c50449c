//! The tables contain exactly the texts of the window.

use super::*;
use crate::ui::actions::ACTIONS;
use crate::view::COLORS;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The sources of the window, without the tables.
fn sources() -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    walk(&root, &mut found);
    assert!(
        found.len() > 40,
        "{} sources in {}",
        found.len(),
        root.display()
    );
    found
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
    let mut found = Vec::new();
    let (mut at, mut code) = (0, 0);
    while let Some(step) = source[at..].find(['"', '/', '\'']) {
        at += step;
        let rest = &source[at..];
        if rest.starts_with("//") {
            at += rest.find('\n').unwrap_or(rest.len());
        } else if rest.starts_with('"') {
            let (text, length) = literal(rest);
            found.push((source[code..at].trim_end(), text));
            at += length;
            code = at;
        } else {
            at += character(rest).unwrap_or(1);
        }
    }
    found
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

fn table() -> BTreeMap<&'static str, &'static Translation> {
    let entries = TABLES.iter().flat_map(|t| t.iter());
    entries.map(|e| (e[0], e)).collect()
}

#[test]
fn sources_are_understood() {
    let source = r#"tr("a\"b"); // "no"
        let c = '"'; let d: &'static str = cx.tr(
            "two \
             lines"); '\''; "end""#;
    let found = literals(source);
    let texts: Vec<&str> = found.iter().map(|(_, t)| t.as_str()).collect();
    assert_eq!(texts, ["a\"b", "two lines", "end"]);
    assert!(is_translated(found[1].0) && !is_translated("f.write_str("));
}

#[test]
fn every_text_of_the_window_is_in_a_table() {
    let table = table();
    let mut missing = BTreeSet::new();
    let mut count = 0;
    for (path, source) in sources() {
        for (code, text) in literals(&source) {
            if is_translated(code) {
                count += 1;
                if !table.contains_key(text.as_str()) {
                    missing.insert(format!("{}: {text}", path.display()));
                }
            }
        }
    }
    assert!(count > 200, "only {count} texts were found");
    let named = ACTIONS.iter().map(|a| a.label);
    let named = named.chain(COLORS.iter().map(|(name, _)| *name));
    missing.extend(named.filter(|n| !table.contains_key(n)).map(str::to_owned));
    assert!(missing.is_empty(), "without translation: {missing:#?}");
}

#[test]
fn every_type_of_sky_is_in_a_table() {
    let table = table();
    for sky in azulejo::scene::sky::CieSky::all() {
        assert!(table.contains_key(sky.name()), "{}", sky.name());
    }
}

#[test]
fn what_undo_takes_back_is_in_a_table() {
    let source = include_str!("../document/edit.rs");
    let body = source.split("pub fn label").nth(1).unwrap();
    let body = body.split("    }\n\n").next().unwrap();
    let labels = literals(body);
    assert!(labels.len() > 15, "{labels:?}");
    let table = table();
    for (_, label) in labels {
        assert!(table.contains_key(label.as_str()), "{label}");
    }
}

#[test]
fn nothing_in_the_tables_is_without_use() {
    let mut used = BTreeSet::new();
    let mut all = sources();
    // Reflection models contain their own names and those of their parameters, and so do skies.
    for models in ["brdf", "sky"] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../azulejo-scene/src");
        walk(&folder.join(models), &mut all);
    }
    for (_, source) in all {
        used.extend(literals(&source).into_iter().map(|(_, text)| text));
    }
    let unused: Vec<&str> = table().into_keys().filter(|t| !used.contains(*t)).collect();
    assert!(unused.is_empty(), "{unused:#?}");
}

#[test]
fn a_text_has_one_translation() {
    let mut known: BTreeMap<&str, &Translation> = BTreeMap::new();
    for entry in TABLES.iter().flat_map(|t| t.iter()) {
        for text in entry {
            assert!(!text.trim().is_empty(), "{entry:?}");
            assert_eq!(text.trim(), *text, "{entry:?}");
        }
        if let Some(other) = known.insert(entry[0], entry) {
            assert_eq!(other, entry);
        }
    }
}

/// An ellipsis announces a dialog and a colon a value, in every language.
#[test]
fn translations_end_as_their_texts_do() {
    for entry in TABLES.iter().flat_map(|t| t.iter()) {
        let end = |text: &str| {
            let last = text.chars().last();
            last.filter(|c| ['…', ':', '.', '°'].contains(c))
        };
        assert!(entry.iter().all(|t| end(t) == end(entry[0])), "{entry:?}");
    }
}

/// A sentence that is the same in two languages has not been translated.
#[test]
fn sentences_are_translated() {
    for entry in TABLES.iter().flat_map(|t| t.iter()) {
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
