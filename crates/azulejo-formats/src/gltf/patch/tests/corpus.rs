//! Files of others.

use super::{Case, Charts, check};
use crate::Folder;
use std::path::{Path, PathBuf};

pub fn files_in(folder: &Path, list: &mut Vec<PathBuf>) {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut paths: Vec<PathBuf> = entries.map(|e| e.unwrap().path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            files_in(&path, list);
        } else if path.extension().is_some_and(|e| e == "gltf" || e == "glb") {
            list.push(path);
        }
    }
}

/// Calls a function with every file of the corpus.
pub fn each(data: &Path, mut check: impl FnMut(&Case)) {
    let mut list = Vec::new();
    files_in(&data.join("corpus/gltf"), &mut list);
    for path in list {
        let bytes = std::fs::read(&path).unwrap();
        let name = path.file_name().unwrap().to_string_lossy();
        let files = Folder::new(path.parent().unwrap());
        check(&Case {
            bytes: &bytes,
            name: &name,
            files: &files,
        });
    }
}

#[test]
fn files_of_others() {
    let Some(data) = azulejo_testing::data() else {
        return;
    };
    let mut edited = 0;
    each(&data, |case| {
        for charts in [Charts::One, Charts::Faces, Charts::Random(7)] {
            edited += usize::from(check(case, charts, |_| {}).is_some());
        }
    });
    assert!(edited > 30, "{edited}");
}
