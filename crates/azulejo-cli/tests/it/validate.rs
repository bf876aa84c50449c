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

/// A stand-in for View3D, which says a quarter of every pair; what is missing is named, and decides nothing.
#[cfg(unix)]
#[test]
fn other_programs_answer_the_same_cases() {
    use std::os::unix::fs::PermissionsExt;
    let python = std::process::Command::new("python3")
        .arg("--version")
        .output();
    let python = python.map_err(|e| format!("python3: {e}"));
    if azulejo_testing::require(azulejo_testing::Need::Python, python).is_none() {
        return;
    }
    let folder = Folder::new();
    let stand_in = "#!/usr/bin/env python3\n\
        import struct, sys\n\
        n = sum(line.startswith('S ') for line in open(sys.argv[1]))\n\
        header = f'View3D 9.9 0 0 0 {n}'.ljust(32).encode()\n\
        open(sys.argv[2], 'wb').write(header + struct.pack(f'={n + n * n + n}f', *[0.25] * (n + n * n + n)))\n";
    folder.write("view3d", stand_in);
    let program = folder.path("view3d");
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
    let line = "validate -o report --only wedge --engine analytic --peers --json";
    let run = folder
        .command(line)
        .env("VIEW3D", &program)
        .output()
        .unwrap();
    assert!(
        run.status.success(),
        "{}",
        String::from_utf8_lossy(&run.stderr)
    );
    let numbers: serde_json::Value =
        serde_json::from_str(&text(&folder, "report/results.json")).unwrap();
    let answered = numbers["peers"]["answered"].as_array().unwrap();
    let view3d = &answered[0];
    assert_eq!(view3d["program"], "View3D 9.9");
    let answers = view3d["answers"].as_array().unwrap();
    assert!(
        answers.len() > 2 && answers.iter().all(|a| a["found"] == 0.25),
        "{view3d}"
    );
    let missing = numbers["peers"]["missing"].as_array().unwrap();
    assert_eq!(answered.len() + missing.len(), 3);
    let page = text(&folder, "report/index.html");
    assert!(page.contains("Other programs") && page.contains("View3D 9.9"));
}
