//! What holds for the sources as a whole: layers, module order, names, licences, and pages that quote code.

mod arrows;
mod budgets;
mod circles;
mod licences;
mod names;
mod pages;

use std::fs;
use std::path::{Path, PathBuf};

/// The root of the repository.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// All Rust files below a folder, with their text, sorted by path.
fn sources(folder: &Path) -> Vec<(PathBuf, String)> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).expect("a readable folder") {
        let path = entry.expect("a readable entry").path();
        if path.is_dir() && !path.ends_with("target") {
            files.extend(sources(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            let text = fs::read_to_string(&path).expect("Rust sources are UTF-8");
            files.push((path, text));
        }
    }
    files.sort();
    files
}
