//! `validate`: a part of it, by some engines, and what is refused.

use crate::support::Folder;

fn text(folder: &Folder, name: &str) -> String {
    String::from_utf8_lossy(&folder.read(name)).into_owned()
}

#[test]
fn the_report_has_page_plots_and_numbers() {
    let folder = Folder::new();
    let found = folder.json("validate -o report --engine rays,analytic --only wedge");
    let (checks, failed) = (found["checks"].as_u64().unwrap(), found["failed"].as_u64());
    assert!(checks > 6 && failed == Some(0), "{found}");
    let page = text(&folder, "report/index.html");
    for part in [
        "Validation of azulejo",
        "closed-forms",
        "rays and closed forms",
        "<svg",
    ] {
        assert!(page.contains(part), "{part}");
    }
    let table = text(&folder, "report/results.csv");
    assert_eq!(table.lines().count() as u64, checks + 1);
    assert!(
        table
            .lines()
            .any(|l| l.starts_with("closed forms,analytic,wedge")),
        "{table}"
    );
    let numbers = text(&folder, "report/results.json");
    let numbers: serde_json::Value = serde_json::from_str(&numbers).unwrap();
    assert_eq!(numbers["checks"].as_array().unwrap().len() as u64, checks);
    assert!(text(&folder, "report/errors.svg").starts_with("<svg"));
}

/// Digests are those of any machine, whatever the seed and the threads. One scene will do: the other takes longer.
#[test]
fn digests_are_comparable() {
    let folder = Folder::new();
    let only = if azulejo_testing::is_thorough() {
        "repeatability"
    } else {
        "facets"
    };
    let digests = |options: &str| {
        folder.ok(&format!(
            "validate -o report --only {only} --engine rays,analytic {options}"
        ));
        let table = text(&folder, "report/results.csv");
        let lines = table.lines().filter(|l| l.starts_with("repeatability,"));
        // Without the time, which comes last.
        let lines: Vec<String> = lines
            .map(|l| l.rsplit_once(',').unwrap().0.to_owned())
            .collect();
        assert!(
            lines.len() >= 3 && lines.iter().all(|l| l.contains(",passed,")),
            "{lines:?}"
        );
        lines
    };
    assert_eq!(digests("--seed 1 --threads 1"), digests("--seed 2"));
}

#[test]
fn nothing_is_checked_by_mistake() {
    let folder = Folder::new();
    folder.fails("validate -o report --only nonsense", 2, "closed forms");
    folder.fails("validate -o report --engine particles", 2, "hemicube");
    folder.fails("validate", 2, "--output");
    folder.write("file", "");
    folder.fails("validate -o file --only wedge", 1, "file");
}
