//! The layers: which crate may use which, read from the manifests.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Each crate and the crates of ours that it may use. What is not here is forbidden; above all,
/// radiosity and render do not know each other: they meet in data, irradiance on vertices.
const ARROWS: [(&str, &[&str]); 15] = [
    ("azulejo-testing", &[]),
    ("azulejo-scene", &[]),
    ("azulejo-formats", &["azulejo-scene"]),
    ("azulejo-trace", &["azulejo-scene"]),
    ("azulejo-gpu", &["azulejo-scene", "azulejo-trace"]),
    ("azulejo-factors", &["azulejo-scene", "azulejo-trace"]),
    (
        "azulejo-exchange",
        &[
            "azulejo-scene",
            "azulejo-trace",
            "azulejo-factors",
            "azulejo-formats",
        ],
    ),
    (
        "azulejo-radiosity",
        &["azulejo-scene", "azulejo-trace", "azulejo-factors"],
    ),
    ("azulejo-render", &["azulejo-scene", "azulejo-trace"]),
    (
        "azulejo-bake",
        &["azulejo-scene", "azulejo-trace", "azulejo-radiosity"],
    ),
    (
        "azulejo",
        &[
            "azulejo-scene",
            "azulejo-formats",
            "azulejo-trace",
            "azulejo-gpu",
            "azulejo-factors",
            "azulejo-exchange",
            "azulejo-radiosity",
            "azulejo-render",
            "azulejo-bake",
        ],
    ),
    (
        "azulejo-cli",
        &[
            "azulejo",
            "azulejo-scene",
            "azulejo-formats",
            "azulejo-trace",
            "azulejo-gpu",
            "azulejo-factors",
            "azulejo-exchange",
            "azulejo-radiosity",
            "azulejo-render",
            "azulejo-bake",
        ],
    ),
    (
        "azulejo-python",
        &[
            "azulejo",
            "azulejo-scene",
            "azulejo-formats",
            "azulejo-trace",
            "azulejo-factors",
            "azulejo-exchange",
            "azulejo-radiosity",
            "azulejo-render",
        ],
    ),
    (
        "azulejo-workbench",
        &[
            "azulejo",
            "azulejo-scene",
            "azulejo-formats",
            "azulejo-trace",
            "azulejo-gpu",
            "azulejo-factors",
            "azulejo-exchange",
            "azulejo-radiosity",
            "azulejo-render",
            "azulejo-bake",
        ],
    ),
    ("azulejo-web", &["azulejo", "azulejo-workbench"]),
];

/// Names of our crates in every section of a manifest whose name passes `counts`.
fn used(manifest: &str, counts: impl Fn(&str) -> bool) -> BTreeSet<String> {
    let mut section = "";
    let mut names = BTreeSet::new();
    for line in manifest.lines().map(str::trim) {
        if let Some(name) = line.strip_prefix('[').and_then(|l| l.strip_suffix(']')) {
            section = name;
            // The long spelling: a section per dependency.
            if let Some((table, name)) = name.rsplit_once('.')
                && counts(table)
                && name.starts_with("azulejo")
            {
                names.insert(name.to_owned());
            }
        } else if counts(section) && line.starts_with("azulejo") {
            let name = line.split(['=', '.', ' ']).next().unwrap_or("");
            names.insert(name.to_owned());
        }
    }
    names
}

/// Sections whose arrows are part of what is shipped; tests may look where they like.
fn is_shipped(section: &str) -> bool {
    section.ends_with("dependencies") && !section.ends_with("dev-dependencies")
}

#[test]
fn no_crate_uses_what_is_above_or_beside_it() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for entry in fs::read_dir(&crates).unwrap() {
        let path = entry.unwrap().path();
        let Ok(manifest) = fs::read_to_string(path.join("Cargo.toml")) else {
            continue;
        };
        let name = path.file_name().unwrap().to_str().unwrap();
        let known = ARROWS.iter().find(|(n, _)| *n == name);
        let (_, allowed) =
            known.unwrap_or_else(|| panic!("{name} is new: say in ARROWS what it may use"));
        for other in used(&manifest, is_shipped) {
            assert!(
                allowed.contains(&other.as_str()),
                "{name} must not use {other}"
            );
        }
    }
}

#[test]
fn both_spellings_of_an_arrow_are_seen() {
    let manifest = "[package]\nname = \"azulejo-x\"\n[dependencies]\nazulejo-a.workspace = true\n\
        glam = \"1\"\n[target.'cfg(unix)'.dependencies.azulejo-b]\npath = \"b\"\n\
        [dev-dependencies]\nazulejo-c = { path = \"c\" }\n[build-dependencies]\nazulejo-d = \"1\"\n";
    let seen: Vec<String> = used(manifest, is_shipped).into_iter().collect();
    assert_eq!(seen, ["azulejo-a", "azulejo-b", "azulejo-d"]);
}
