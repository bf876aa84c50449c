//! `validate --poses`: a fixed set in which each change and each command comes at least once.

use crate::support::{Folder, Run, project};
use serde_json::Value;

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

/// Runs poses in the project's folder, where the examples are.
fn poses(folder: &Folder, arguments: &[&str]) -> Run {
    let mut command = folder.command("validate --json -o");
    command.arg(folder.path("report")).args(arguments);
    command.current_dir(project()).env_remove("AZULEJO_DATA");
    Run::of(command.output().unwrap())
}

fn named(poses_of: &[&str]) {
    let folder = Folder::new();
    let pairs = poses_of.iter().flat_map(|name| ["--pose", name]);
    let run = poses(&folder, &pairs.collect::<Vec<_>>());
    let table = String::from_utf8(folder.read("report/poses.csv")).unwrap();
    assert_eq!(run.code, Some(0), "{}\n{table}", run.err);
    let report: Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(report["right"].as_u64(), Some(poses_of.len() as u64));
    assert_eq!(table.lines().count(), poses_of.len() + 1);
}

#[test]
fn form_factors_stay() {
    named(FACTORS);
}

/// Rotated rooms with rounded coordinates.
#[test]
fn closed_forms_stay() {
    named(CLOSED_FORMS);
}

#[test]
fn light_stays() {
    named(LIGHT);
}

#[test]
fn areas_and_exchange_stay() {
    named(OTHERS);
}

/// The fixed set has every change and every command: those that the program names when it refuses another.
#[test]
fn each_comes_at_least_once() {
    let folder = Folder::new();
    let names = |pose: &str| -> Vec<String> {
        let refused = poses(&folder, &["--pose", pose]).err;
        let names = refused.lines().next().unwrap_or_default().to_owned();
        let names = names.split_once("there are ").unwrap().1;
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
    let folder = Folder::new();
    let keys = |arguments: &[&str]| {
        poses(&folder, arguments);
        let table = folder.read("report/poses.json");
        let records: Vec<Value> = serde_json::from_slice(&table).unwrap();
        let words = |r: &Value| {
            format!(
                "{} {} {} {}",
                r["key"], r["scene"], r["command"], r["words"]
            )
        };
        records.iter().map(words).collect::<Vec<_>>()
    };
    let drawn = keys(&["--poses", "3", "--only", ":info:"]);
    let number = drawn[1].split('"').nth(1).unwrap().to_owned();
    assert_eq!(keys(&["--pose", &number]), drawn[1..2]);
    assert_ne!(keys(&["--pose", &number, "--seed", "1"]), drawn[1..2]);
    for (pose, expected) in [
        ("cube", "SCENE:COMMAND:CHANGE"),
        ("cube:info:nothing", "motion"),
        ("cube:nothing:motion", "probe"),
        ("nothing:info:motion", "squares"),
    ] {
        let run = poses(&folder, &["--pose", pose]);
        assert_eq!(run.code, Some(2));
        assert!(run.err.contains(expected), "{}", run.err);
    }
    let run = poses(&folder, &["--poses", "1", "--only", "nothing"]);
    assert_eq!(run.code, Some(2));
}
