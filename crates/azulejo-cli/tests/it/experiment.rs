//! `experiment`: suites good and bad, and going on where it stopped.

use crate::support::{Folder, project};
use serde_json::Value;

/// The project's small suite, run once; what was done is not done again.
#[test]
fn the_small_suite() {
    let folder = Folder::new();
    let suite = project().join("examples/experiments/smoke.toml");
    let line = format!("experiment {} -o report", suite.display());
    let listed = folder.json(&format!("experiment {} --list", suite.display()));
    let tasks = listed["task_count"].as_u64().unwrap();
    let first = folder.json(&line);
    assert_eq!(
        (&first["tasks"], &first["tasks_failed"]),
        (&tasks.into(), &0.into())
    );
    let journal = folder.read("report/results.jsonl");
    let again = folder.json(&line);
    assert_eq!(again["tasks_before"], tasks);
    assert_eq!(folder.read("report/results.jsonl"), journal);
    let page = String::from_utf8(folder.read("report/report.html")).unwrap();
    for part in [
        "<h1>Smoke</h1>",
        "Measured on",
        "<svg",
        "box, 16 mirrors",
        "row error",
    ] {
        assert!(page.contains(part), "no {part}");
    }
    assert!(
        !page.contains("http://") || page.contains("www.w3.org"),
        "nothing from elsewhere"
    );
    let results: Value = serde_json::from_slice(&folder.read("report/results.json")).unwrap();
    let results = results["results"].as_array().unwrap();
    let runs: Vec<&Value> = results
        .iter()
        .filter_map(|r| r["found"].get("run"))
        .collect();
    assert!(runs.len() > 10);
    for run in &runs {
        let number = |name: &str| run[name].as_f64().unwrap_or(f64::NAN);
        let words = run.to_string();
        assert!(
            number("facets") >= 7.0 && number("seconds") > 0.0,
            "{words}"
        );
        assert!(
            number("row_error_mean") < 2.0 && number("closure_rms") < 0.5,
            "{words}"
        );
        assert!(
            number("reciprocity") < 1e-9 && number("peak_bytes") > 1e6,
            "{words}"
        );
    }
    // More rays, less error.
    let error = |rays: u32| {
        let with = |r: &&&Value| {
            r["scene"] == "box, 16 mirrors" && r["setting"] == format!("rays, {rays} rays")
        };
        runs.iter().find(with).unwrap()["row_error_mean"]
            .as_f64()
            .unwrap()
    };
    assert!(error(256) < 0.8 * error(64), "{} {}", error(256), error(64));
    for plot in [
        "box-16-mirrors-row-error-samples.svg",
        "box-time-mirrors.svg",
    ] {
        assert!(
            folder.read(&format!("report/{plot}")).starts_with(b"<svg"),
            "{plot}"
        );
    }
    let csv = String::from_utf8(folder.read("report/results.csv")).unwrap();
    assert_eq!(csv.lines().count() as u64, 1 + tasks, "{csv}");
}

/// Every suite of the project means something.
#[test]
fn the_suites() {
    let folder = Folder::new();
    let suites = std::fs::read_dir(project().join("examples/experiments")).unwrap();
    let mut count = 0;
    for suite in suites {
        let path = suite.unwrap().path();
        let listed = folder.json(&format!("experiment {} --list", path.display()));
        assert!(!listed["tasks"].as_array().unwrap().is_empty(), "{path:?}");
        count += 1;
    }
    assert_eq!(count, 8);
}

#[test]
fn known_answers() {
    let folder = Folder::new();
    let suite = "title = 'Truths'\ntruths = true\n[[engine]]\nengine = 'rays'\nrays = 256\n";
    folder.write("t.toml", suite);
    let found = folder.json("experiment t.toml -o report");
    assert!(found["truths_within_4"].as_f64().unwrap() > 0.9, "{found}");
    let csv = String::from_utf8(folder.read("report/truths.csv")).unwrap();
    assert_eq!(csv.lines().count(), 69);
    let page = String::from_utf8(folder.read("report/report.html")).unwrap();
    assert!(page.contains("Known solutions") && page.contains("cube_mirror_B"));
}

#[test]
fn parts_of_a_suite() {
    let folder = Folder::new();
    let suite = "title = 't'\n[[scene]]\nname = 'cube'\ngenerator = 'cube'\n\
                 [[engine]]\nengine = 'rays'\nrays = [16, 64]\n";
    folder.write("t.toml", suite);
    let listed = folder.ok("experiment t.toml --list");
    let lines: Vec<&str> = listed.out.lines().collect();
    assert_eq!(
        lines,
        ["cube, rays, 16 rays, seed 0", "cube, rays, 64 rays, seed 0"]
    );
    let done = folder.json("experiment t.toml -o a --only 64");
    assert_eq!(done["tasks"], 1);
    let done = folder.json("experiment t.toml -o b --quick");
    assert_eq!(done["tasks"], 1);
    let done = folder.json("experiment t.toml -o a");
    assert_eq!(
        (&done["tasks"], &done["tasks_before"]),
        (&2.into(), &1.into())
    );
    folder.fails(
        "experiment t.toml -o a --only nothing",
        2,
        "no task has \"nothing\"",
    );
}

/// Any number of repetitions is a plan, and the first of them are done at once.
#[test]
fn repetitions_are_made_one_by_one() {
    let folder = Folder::new();
    let suite = "title = 't'\n[run]\nrepetitions = 4000000000\n[[scene]]\nname = 'cube'\n\
                 generator = 'cube'\n[[engine]]\nengine = 'rays'\nrays = [16, 2000000]\n";
    folder.write("t.toml", suite);
    let listed = folder.json("experiment t.toml --list");
    assert_eq!(listed["task_count"], 8_000_000_000u64);
    assert_eq!(
        listed["tasks"][1],
        "cube, rays, 2000000 rays, seeds 0 to 3999999999"
    );
    let done = folder.json("experiment t.toml -o a --quick --only 16");
    assert_eq!(
        (&done["tasks"], &done["tasks_failed"]),
        (&1.into(), &0.into())
    );
}

/// Repetitions have bars and deviations, lines have slopes, and what is optional and missing is said
/// without a failure.
#[test]
fn spread_slopes_and_optional_engines() {
    let folder = Folder::new();
    let suite = "title = 't'\n[run]\nrepetitions = 3\n[reference]\nengine = 'rays'\nrays = 4096\n\
                 [[scene]]\nname = 'cube'\ngenerator = 'cube'\npatches = 54\n\
                 [[engine]]\nengine = 'hemicube'\ngpu = 'off'\nresolution = [8, 16, 32]\n\
                 patch_points = [1, 4]\nformulas = false\n\
                 [[engine]]\nengine = 'hybrid'\ngpu = 'off'\noptional = true\n\
                 embree = 'nowhere.so'\nresolution = 8\n";
    folder.write("t.toml", suite);
    let done = folder.json("experiment t.toml -o a");
    assert_eq!(
        (&done["tasks_failed"], &done["tasks_skipped"]),
        (&0.into(), &3.into()),
        "{done}"
    );
    let page = String::from_utf8(folder.read("a/report.html")).unwrap();
    for part in [
        "Not available here",
        "Embree",
        "hemicube, 1 point",
        "hemicube, 4 points",
        "Fitted slopes",
        "Bars: standard deviation",
        "CPU time of all threads, s",
        " ± ",
    ] {
        assert!(page.contains(part), "no {part}");
    }
    let results: Value = serde_json::from_slice(&folder.read("a/results.json")).unwrap();
    let runs = results["results"].as_array().unwrap();
    let stated = |points: u64| {
        let mut runs = runs.iter().filter_map(|r| r["found"].get("run"));
        let run = runs.find(|r| r["patch_points"] == points).unwrap();
        run["row_error_stated"].clone()
    };
    assert!(stated(1).is_null() && stated(4).as_f64().is_some_and(|e| e > 0.0));
    // It is tried again.
    let again = folder.json("experiment t.toml -o a");
    assert_eq!(again["tasks_skipped"], 3);
}

/// What fails is said in the report and tried again; the rest is done.
#[test]
fn failures_are_reported() {
    let folder = Folder::new();
    let suite = "title = 't'\n[run]\ntimeout = '1ms'\n[[scene]]\nname = 'cube'\ngenerator = 'cube'\n\
                 patches = 2000\n[[engine]]\nengine = 'rays'\n";
    folder.write("t.toml", suite);
    let done = folder.json("experiment t.toml -o a");
    assert_eq!(done["tasks_failed"], 1);
    let page = String::from_utf8(folder.read("a/report.html")).unwrap();
    assert!(page.contains("Failed tasks") && page.contains("took longer than"));
    folder.write("t.toml", suite.replace("timeout = '1ms'\n", ""));
    let done = folder.json("experiment t.toml -o a");
    assert_eq!(
        (&done["tasks_failed"], &done["tasks_before"]),
        (&0.into(), &0.into())
    );
}

#[test]
fn bad_suites() {
    let folder = Folder::new();
    folder.write("broken.obj", "f 1 2 3\n");
    let scene = "[[scene]]\nname = 'a'\ngenerator = 'cube'\n";
    let rays = "[[engine]]\nengine = 'rays'\n";
    for (suite, words) in [
        ("", "t.toml:1:1: missing field `title`"),
        ("title = 't'\n", "t.toml:1:1: nothing to do"),
        (
            &format!("title = 't'\nscenes = 1\n{rays}"),
            "t.toml:2:1: unknown field `scenes`, did you mean `scene`?",
        ),
        (
            &format!("title = 't'\n{scene}[[engine]]\nengine = 'ray'\n"),
            "t.toml:6:10: unknown engine \"ray\", did you mean \"rays\"?",
        ),
        (
            &format!("title = 't'\n{scene}{rays}rays = 0\n"),
            "rays is 0, expected at least 1",
        ),
        (
            &format!("title = 't'\n{scene}{rays}resolution = 64\n"),
            "--resolution applies only to --engine hemicube",
        ),
        (
            &format!("title = 't'\n{scene}{rays}scenes = ['b']\n"),
            "t.toml:7:11: unknown scene \"b\"",
        ),
        (
            &format!("title = 't'\n{scene}{scene}{rays}"),
            "t.toml:6:8: there is another scene \"a\"",
        ),
        (
            &format!("title = 't'\n{scene}mirrors = 4\n{rays}"),
            "t.toml:3:8: \"a\" does not have a parameter `mirrors`",
        ),
        (
            &format!("title = 't'\n[[scene]]\nname = 'a'\ngenerator = 'cornel'\n{rays}"),
            "t.toml:4:13: unknown generator \"cornel\"",
        ),
        (
            &format!("title = 't'\n[[scene]]\nname = 'a'\nfile = 'none.obj'\n{rays}"),
            "t.toml:4:8: cannot read none.obj",
        ),
        (
            &format!("title = 't'\n[[scene]]\nname = 'a'\n{rays}"),
            "t.toml:3:8: expected either file or generator",
        ),
        (
            &format!(
                "title = 't'\n[[scene]]\nname = 'a'\ngenerator = 'street'\ndetail = -1.0\n{rays}"
            ),
            "detail is -1",
        ),
        (
            &format!("title = 't'\n{scene}patches = 'many'\n{rays}"),
            "t.toml:5:11: invalid type: string \"many\"",
        ),
    ] {
        folder.write("t.toml", suite);
        folder.fails("experiment t.toml -o a", 1, words);
        assert!(
            !folder.names().contains(&"a".to_owned()),
            "{suite}: nothing is written"
        );
    }
    folder.fails("experiment none.toml -o a", 1, "cannot read none.toml");
    folder.fails("experiment t.toml", 2, "--output");
    let suite = format!("title = 't'\n[[scene]]\nname = 'a'\nfile = 'broken.obj'\n{rays}");
    folder.write("t.toml", suite);
    assert_eq!(folder.json("experiment t.toml -o a")["tasks_failed"], 1);
}
