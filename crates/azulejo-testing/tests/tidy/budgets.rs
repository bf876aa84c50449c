//! Lines of code that each crate may have: a budget is raised only with a reason, in the commit that raises it.

use crate::circles::shipped;
use std::fs;
use std::path::Path;

/// Most lines of each crate's shipped code: those that are neither blank nor comments, without tests, benches and
/// examples. A crate that is far below its budget gets a smaller one.
const BUDGETS: [(&str, usize); 15] = [
    ("azulejo", 5870),
    ("azulejo-bake", 5600),
    ("azulejo-cli", 25_070),
    ("azulejo-exchange", 8350),
    ("azulejo-factors", 18_410),
    ("azulejo-formats", 72_910),
    ("azulejo-gpu", 2200),
    ("azulejo-python", 3100),
    ("azulejo-radiosity", 7960),
    ("azulejo-render", 5560),
    ("azulejo-scene", 17_220),
    ("azulejo-testing", 540),
    ("azulejo-trace", 14_120),
    ("azulejo-web", 270),
    ("azulejo-workbench", 29_260),
];

/// Share of a budget that has to be used.
const USED: f64 = 0.95;

#[test]
fn crates_keep_within_their_budgets() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut wrong = Vec::new();
    for (name, budget) in BUDGETS {
        let lines = lines_of_code(&crates.join(name).join("src"));
        if lines > budget || (lines as f64) < USED * budget as f64 {
            wrong.push(format!(
                "{name} has {lines} lines of code, its budget is {budget}"
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let folders = fs::read_dir(&crates).expect("readable").count();
    assert_eq!(folders, BUDGETS.len(), "each crate has a budget");
}

/// Lines of the files of a folder that are neither blank nor comments nor tests.
fn lines_of_code(folder: &Path) -> usize {
    let entries = fs::read_dir(folder).expect("readable");
    let paths = entries.map(|entry| entry.expect("readable").path());
    let lines = |path: std::path::PathBuf| {
        let name = path.file_name().and_then(|n| n.to_str()).unwrap_or("");
        if path.is_dir() {
            return if name == "tests" {
                0
            } else {
                lines_of_code(&path)
            };
        }
        if !name.ends_with(".rs") || name.ends_with("tests.rs") {
            return 0;
        }
        let text = shipped(&fs::read_to_string(&path).expect("readable"));
        text.lines().filter(|line| !line.trim().is_empty()).count()
    };
    paths.map(lines).sum()
}
