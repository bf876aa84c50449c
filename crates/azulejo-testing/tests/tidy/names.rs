//! Type names that grep can tell apart.

use crate::{root, sources};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Names that say nothing about what they name, or that only azulejo used. See `docs/glossary.md`.
const BANNED: [&str; 16] = [
    "Found", "Gaze", "Globe", "Glow", "Ground", "Kind", "Kinship", "Look", "Place", "Ran",
    "Reader", "Skin", "Stage", "StandIn", "Thing", "Wish",
];

/// Largest number of types of one name in the whole workspace, tests aside.
const MOST_OF_A_NAME: usize = 3;

/// The types that shipped sources define, by name, with the files that define them.
fn types() -> BTreeMap<String, Vec<PathBuf>> {
    let mut types = BTreeMap::<String, Vec<PathBuf>>::new();
    for (path, text) in sources(&root().join("crates")) {
        let is_shipped = path.components().any(|c| c.as_os_str() == "src");
        if !is_shipped
            || path.ends_with("tests.rs")
            || path.components().any(|c| c.as_os_str() == "tests")
        {
            continue;
        }
        let shipped = text
            .split("#[cfg(test)]\nmod tests {")
            .next()
            .unwrap_or(&text);
        for name in shipped.lines().filter_map(defined) {
            types.entry(name.to_owned()).or_default().push(path.clone());
        }
    }
    types
}

/// The type that a line defines.
fn defined(line: &str) -> Option<&str> {
    let mut words = line.split_whitespace().skip_while(|w| w.starts_with("pub"));
    let is_type = matches!(words.next()?, "struct" | "enum" | "trait" | "type");
    let name = words.next().filter(|_| is_type)?;
    let end = name.find(|c: char| !c.is_alphanumeric());
    // Associated types of traits belong to the trait.
    let is_indented_alias = line.starts_with(' ') && line.trim_start().starts_with("type ");
    (!is_indented_alias).then(|| &name[..end.unwrap_or(name.len())])
}

#[test]
fn a_line_defines_at_most_one_type() {
    for (line, name) in [
        ("pub struct Tracer<'a> {", Some("Tracer")),
        ("pub(crate) enum Via {", Some("Via")),
        ("    type Output = Rgb;", None),
        ("type Uses = BTreeMap<String, u32>;", Some("Uses")),
        ("let structure = 1;", None),
    ] {
        assert_eq!(defined(line), name, "{line}");
    }
}

#[test]
fn no_type_has_a_banned_name() {
    let types = types();
    assert!(types.len() > 1000, "the sources are not found");
    for name in BANNED {
        assert_eq!(types.get(name), None, "`{name}` says too little");
    }
}

#[test]
fn no_name_has_many_types() {
    for (name, files) in types() {
        assert!(
            files.len() <= MOST_OF_A_NAME,
            "{} types are named `{name}`, qualify some of them: {files:#?}",
            files.len()
        );
    }
}
