//! Poses: a fixed set in which each change and each command comes at least once.

// The machine of `cargo bench --bench poses`, of which tests need but a part.
#[allow(dead_code, unused_imports)]
#[path = "../../benches/pose/mod.rs"]
mod pose;

use crate::support::Folder;
use pose::{PoseChoice, PoseOutcome, PoseRecord};

const FACTORS: &[&str] = &[
    "cube:form-factors rays by row:motion+float32",
    "L room:form-factors rays by object:quarters+order",
    "sheet:form-factors rays by object two-sided:mirrored+format",
    "cube:form-factors hemicube by row:scale+unwelded",
    "open box:form-factors hemicube by object:triangles+welded",
    "squares:form-factors hemicube by object two-sided:double+unit",
    "cube:form-factors hybrid by row:motion",
    "mirror block:form-factors hybrid by object:scale",
    "squares:form-factors hybrid by object two-sided:empty",
    "prism:form-factors rays by object:threads",
];

const CLOSED_FORMS: &[&str] = &[
    "squares:form-factors analytic by row:motion+rounded",
    "cube:form-factors analytic by object:motion+rounded",
    "duct:form-factors analytic by object two-sided:mirrored+motion",
    "squares:form-factors auto by row:scale",
    "cube:form-factors auto by object:motion+float32",
    "squares:form-factors auto by object two-sided:double",
];

const LIGHT: &[&str] = &[
    "L room:solve auto:motion+format",
    "sheet:solve rays:quarters",
    "L room:solve hemicube:unit",
    "L room:solve hybrid:scale+unused",
    "L room:solve analytic:mirrored",
    "sheet:solve particles:motion+order",
    "L room:probe:motion+rounded+format",
    "sheet:bake:mirrored+motion",
    "L room:render:motion+mirrored",
    "examples/csg.grf:render reference:motion+scale",
];

const OTHERS: &[&str] = &[
    "ball:info:motion+scale+mirrored",
    "examples/title.grf:info:motion+unit",
    "cube as one:info:order+format",
    "prism:exchange:motion+empty+unused",
    "cube:exchange:triangles+scale",
];

/// Runs `count` poses, or those that are named.
fn run(seed: u64, count: u64, only: &str, named: &[&str]) -> Result<Vec<PoseRecord>, String> {
    let folder = Folder::new();
    let choice = PoseChoice {
        seed,
        count,
        only: Some(only.to_owned()),
        named: named.iter().map(|&name| name.to_owned()).collect(),
        folder: folder.path("runs"),
        has_corpus: false,
    };
    let mut records = Vec::new();
    pose::run(&choice, &mut |record| records.push(record))?;
    Ok(records)
}

fn stays(poses: &[&str]) {
    let records = run(0, 0, "", poses).unwrap();
    assert_eq!(records.len(), poses.len());
    for record in records {
        assert_eq!(record.outcome, PoseOutcome::Right, "{record:?}");
        assert!(record.quantities > 0, "{record:?}");
    }
}

#[test]
fn form_factors_stay() {
    stays(FACTORS);
}

/// Rotated rooms with rounded coordinates.
#[test]
fn closed_forms_stay() {
    stays(CLOSED_FORMS);
}

#[test]
fn light_stays() {
    stays(LIGHT);
}

#[test]
fn areas_and_exchange_stay() {
    stays(OTHERS);
}

/// The fixed set has every change and every command: those that are named when another is refused.
#[test]
fn each_comes_at_least_once() {
    let names = |pose: &str| -> Vec<String> {
        let refusal = run(0, 0, "", &[pose]).unwrap_err();
        let names = refusal.split_once("there are ").unwrap().1;
        names.split(", ").map(str::to_owned).collect()
    };
    let fixed = [FACTORS, CLOSED_FORMS, LIGHT, OTHERS].concat();
    let parts: Vec<Vec<&str>> = fixed.iter().map(|p| p.split(':').collect()).collect();
    for command in names("cube:nothing:motion") {
        assert!(parts.iter().any(|p| p[1] == command), "{command}");
    }
    for change in names("cube:info:nothing") {
        let has = |p: &Vec<&str>| p[2].split('+').any(|c| c == change);
        assert!(parts.iter().any(has), "{change}");
    }
}

/// The same number is the same pose, and what is unknown is refused with what there is.
#[test]
fn poses_are_drawn_by_their_numbers() {
    let words = |records: Vec<PoseRecord>| -> Vec<String> {
        let words = |r: &PoseRecord| format!("{} {} {} {}", r.key, r.scene, r.command, r.words);
        records.iter().map(words).collect()
    };
    let drawn = run(0, 3, ":info:", &[]).unwrap();
    let number = drawn[1].key.clone();
    let drawn = words(drawn);
    let same = words(run(0, 0, "", &[&number]).unwrap());
    assert_eq!(same, drawn[1..2]);
    let other = words(run(1, 0, "", &[&number]).unwrap());
    assert_ne!(other, drawn[1..2]);
    for (pose, expected) in [
        ("cube", "SCENE:COMMAND:CHANGE"),
        ("cube:info:nothing", "motion"),
        ("cube:nothing:motion", "probe"),
        ("nothing:info:motion", "squares"),
    ] {
        let refusal = run(0, 0, "", &[pose]).unwrap_err();
        assert!(refusal.contains(expected), "{refusal}");
    }
    run(0, 1, "nothing", &[]).unwrap_err();
}
