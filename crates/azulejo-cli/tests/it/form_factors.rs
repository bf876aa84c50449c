//! `form-factors`: groups, sums, what is refused, and work that goes on after it was killed.

use crate::support::Folder;
use azulejo_formats::numpy::npz::NpzReader;
use azulejo_testing::closed_forms::element_parallel;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use serde_json::json;
use std::collections::HashMap;
use std::io::Cursor;
use std::path::Path;
use std::process::Stdio;
use std::thread::sleep;
use std::time::Duration;

/// Six blocks of rows, each of which takes a while.
const LONG: &str = "form-factors room.obj --patches 700 --rays 4096 --two-sided";

/// Bytes of a journal before its first record, and where that says how long it is.
const JOURNAL_HEADER: usize = 60;
const RECORD_HEAD: usize = 28;
const RECORD_LENGTH: usize = 12;

/// Whether a whole block of rows is in a journal.
fn has_block(journal: &Path) -> bool {
    let bytes = std::fs::read(journal).unwrap_or_default();
    let length = bytes
        .get(JOURNAL_HEADER + RECORD_LENGTH..)
        .and_then(|b| b.first_chunk());
    length.is_some_and(|&length| {
        let end = JOURNAL_HEADER as u64 + RECORD_HEAD as u64 + u64::from_le_bytes(length);
        bytes.len() as u64 >= end
    })
}

/// Runs `LONG` until a block is in the journal, and ends it by `signal`.
fn interrupt(folder: &Folder, output: &str, signal: Signal) {
    let journal = folder.path(&format!("{output}.journal"));
    let mut child = folder
        .command(&format!("{LONG} -o {output}"))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    while !has_block(&journal) {
        assert!(
            child.try_wait().unwrap().is_none(),
            "it ended before it was interrupted"
        );
        sleep(Duration::from_millis(2));
    }
    kill(Pid::from_raw(child.id().try_into().unwrap()), signal).unwrap();
    assert!(!child.wait().unwrap().success());
    assert!(!folder.path(output).exists());
    assert!(has_block(&journal));
}

#[test]
fn killed_work_goes_on_to_the_same_bytes() {
    let folder = Folder::with_room();
    folder.ok(&format!("{LONG} -o whole.npz --threads 1"));
    assert!(!folder.path("whole.npz.journal").exists());
    let whole = folder.read("whole.npz");

    interrupt(&folder, "killed.npz", Signal::SIGKILL);
    let run = folder.ok(&format!("{LONG} -o killed.npz"));
    assert!(run.err.contains("resuming from"), "{}", run.err);
    assert!(folder.read("killed.npz") == whole);

    interrupt(&folder, "stopped.npz", Signal::SIGINT);
    // A byte changes on the disk: its block is computed again, and that is said.
    let mut journal = folder.read("stopped.npz.journal");
    journal[200] ^= 1;
    folder.write("stopped.npz.journal", journal);
    let run = folder.ok(&format!("{LONG} -o stopped.npz"));
    assert!(run.err.contains("damaged"), "{}", run.err);
    assert!(folder.read("stopped.npz") == whole);
    let left: Vec<_> = folder
        .names()
        .into_iter()
        .filter(|n| n.contains(".journal") || n.ends_with(".tmp"))
        .collect();
    // What SIGKILL leaves of the check of the output's place is not looked for: it came too late.
    assert_eq!(left, [""; 0]);
}

#[test]
fn a_journal_of_something_else() {
    let folder = Folder::with_room();
    interrupt(&folder, "f.npz", Signal::SIGKILL);
    let other = "form-factors room.obj -o f.npz --patches 50 --rays 64";
    let run = folder.ok(other);
    assert!(run.err.contains("restarted"), "{}", run.err);
    assert!(!folder.path("f.npz.journal").exists());
    folder.write("f.npz.journal", "my diary");
    folder.fails(other, 1, "is not a journal");
    folder.ok(&format!("{other} --no-journal"));
    assert_eq!(folder.read("f.npz.journal"), b"my diary");
}

/// The table's entries by name, and the areas.
fn table(text: &str) -> (HashMap<(String, String), f64>, HashMap<String, f64>) {
    let (mut entries, mut areas) = (HashMap::new(), HashMap::new());
    for line in text.lines().skip(1) {
        let words: Vec<&str> = line.split(',').collect();
        let [from, to] = [words[0], words[1]].map(str::to_owned);
        areas.insert(from.clone(), words[4].parse().unwrap());
        entries.insert((from, to), words[2].parse().unwrap());
    }
    (entries, areas)
}

#[test]
fn groups_keep_sums_and_reciprocity() {
    let folder = Folder::with_room();
    for by in ["object", "face", "material"] {
        let line = "form-factors room.obj -o f.csv --patches 200 --rays 256 --two-sided --by";
        let report = folder.json(&format!("{line} {by}"));
        assert!(report["groups"].as_u64().unwrap() >= 2 && report["patches"].is_null());
        let text = String::from_utf8(folder.read("f.csv")).unwrap();
        assert!(text.starts_with("from,to,f,std_error,area_from\n"));
        let (entries, areas) = table(&text);
        let mut sums: HashMap<&str, f64> = HashMap::new();
        for ((from, to), f) in &entries {
            *sums.entry(from).or_default() += f;
            if to != "sky" && to != "ground" {
                let there = areas[from] * f;
                let back = areas[to] * entries[&(to.clone(), from.clone())];
                assert!((there - back).abs() <= 1e-14 * there, "{from} {to}");
            }
        }
        // The backs of the walls see the sky and the ground; nothing is missing anywhere.
        assert!(
            sums.values().all(|s| (s - 1.0).abs() < 1e-6),
            "{by} {sums:?}"
        );
    }
}

/// Without formulas there is the engine alone, and no closure that was not requested.
#[test]
fn the_engine_alone_is_shown_on_request() {
    let folder = Folder::with_room();
    let line = "form-factors room.obj -o f.npz --patches 150 --rays 256 --two-sided";
    let error = |options: &str| {
        let report = folder.json(&format!("{line} --closure=never {options}"));
        report["row_error"].as_f64().unwrap()
    };
    assert!(error("--formulas=never") > 1.02 * error("--formulas=auto"));
    let alone = folder.json(&format!("{line} --formulas=never"));
    assert!(alone["closure"].is_null() && alone["engine"] == json!("rays"));
    let closed = folder.json(&format!("{line} --formulas=never --closure"));
    assert!(!closed["closure"].is_null());
    let rays = "form-factors room.obj -o f.npz --patches 50 --formulas=never";
    assert_eq!(folder.json(rays)["engine"], json!("rays"));
    let refused = format!("{rays} --engine analytic");
    folder.fails(&refused, 2, "--formulas=never does not apply");
}

#[test]
fn what_was_moved_is_said() {
    let folder = Folder::with_room();
    let line = "form-factors room.obj -o f.npz --patches 150 --rays 256 --two-sided";
    let plain = folder.json(&format!("{line} --closure=never"));
    assert!(plain["closure"].is_null() && plain["unaccounted_max"].as_f64().unwrap() > 1e-4);
    let closed = folder.json(&format!("{line} --closure"));
    assert!(closed["closure"]["moved"].as_f64().unwrap() > 0.0);
    assert!(closed["unaccounted_max"].as_f64().unwrap() < 1e-8);
    let cut = folder.json(&format!("{line} --truncate 0.2%"));
    let (before, after) = (
        &cut["truncation"]["entries_before"],
        &cut["truncation"]["entries_after"],
    );
    assert_eq!((before, after), (&closed["entries"], &cut["entries"]));
    assert!(after.as_u64() < before.as_u64());
    assert!(cut["truncation"]["moved"]["lacks_max"].as_f64().unwrap() < 1e-11);
    let words = folder.ok(&format!("{line} --truncate 0.2% --separate")).err;
    for expected in [
        "forecast",
        "closure",
        "truncation",
        "row sums",
        "unaccounted",
    ] {
        assert!(words.contains(expected), "{words}");
    }
}

#[test]
fn what_does_not_fit_is_not_begun() {
    let folder = Folder::with_room();
    let line = "form-factors room.obj -o f.npz --rays 256";
    folder.fails(
        &format!("{line} --patches 3000 --memory 2M"),
        1,
        "allow more memory",
    );
    folder.fails(
        &format!("{line} --patches 1000000000 --memory 8G"),
        1,
        "1000000000 patches",
    );
    let forecast = folder.json(&format!("{line} --patches 700"));
    assert!(forecast["forecast_bytes"].as_u64().unwrap() > 700_000);
    assert_eq!(folder.names(), ["f.npz", "room.mtl", "room.obj"]);
}

#[test]
fn nothing_to_see() {
    let folder = Folder::new();
    folder.write("empty.obj", "v 0 0 0\n");
    folder.fails("form-factors empty.obj -o f.csv", 1, "no surface");
    // A needle, a face twice in one place, and one that crosses it.
    folder.write(
        "bad.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 5 0 0\nv 5 1e-7 0\nv 0.5 -1 -1\nv 0.5 2 -1\nv 0.5 2 1\n\
         f 1 2 3 4\nf 1 2 3 4\nf 4 3 2 1\nf 1 5 6\nf 7 8 9\n",
    );
    let report = folder.json("form-factors bad.obj -o f.csv --patch-size 0 --rays 64 --closure");
    assert_eq!(report["closed"], json!(false));
    let text = String::from_utf8(folder.read("f.csv")).unwrap();
    assert!(!text.contains("NaN") && !text.contains("inf"));
}

/// A street two wide between walls 1.5 high, behind them roofs one wide: all of it three long, and
/// three wide, with Y up. Fronts face the street and the sky.
const STREET: &str = "\
v 0 0 0\nv 2 0 0\nv 2 0 -3\nv 0 0 -3\nv 2 1.5 0\nv 2 1.5 -3\nv 3 1.5 0\nv 3 1.5 -3\nv 3 0 0\nv 3 0 -3
o ground\nf 1 2 3 4\no east\nf 2 5 6 3\no roof\nf 5 7 8 6\no west\nf 9 10 8 7\n";

/// Streets without end, by the crossed strings of Hottel.
#[test]
fn one_period_of_a_street_stands_for_a_city() {
    let folder = Folder::new();
    folder.write("street.obj", STREET.as_bytes());
    let line =
        "form-factors street.obj --patch-size 0 --by object --rays 65536 -o f.csv --periodic";
    let report = folder.json(&format!("{line} x,z"));
    assert_eq!(report["engine"], "rays");
    // No ray slips through where cells meet.
    assert_eq!(report["hidden_mean"], 0.0);
    let (width, height) = (2.0f64, 1.5f64);
    let ground_to_sky = (1.0 + (height / width).powi(2)).sqrt() - height / width;
    let wall_to_wall = (1.0 + (width / height).powi(2)).sqrt() - width / height;
    let wall_to_sky = (1.0 - wall_to_wall) / 2.0;
    let expected = [
        ("ground", "sky", ground_to_sky),
        ("ground", "east", (1.0 - ground_to_sky) / 2.0),
        ("ground", "west", (1.0 - ground_to_sky) / 2.0),
        ("east", "west", wall_to_wall),
        ("west", "ground", wall_to_sky),
        ("west", "sky", wall_to_sky),
        ("roof", "sky", 1.0),
    ];
    let text = String::from_utf8(folder.read("f.csv")).unwrap();
    let (entries, _) = table(&text);
    for (from, to, factor) in expected {
        let found = entries[&(from.to_owned(), to.to_owned())];
        assert!(
            (found - factor).abs() < 1e-3,
            "{from} to {to}: {found}, not {factor}"
        );
    }
    // The same with lengths, and with streets farther apart.
    let first = folder.read("f.csv");
    folder.ok(&format!("{line} x=3,z=3"));
    assert_eq!(folder.read("f.csv"), first);
    folder.ok(&format!("{line} x=8,z"));
    let (wide, _) = table(&String::from_utf8(folder.read("f.csv")).unwrap());
    let west_sky = wide[&("west".to_owned(), "sky".to_owned())];
    assert!(west_sky > wall_to_sky + 0.05, "{west_sky}");
}

#[test]
fn what_cannot_repeat_itself_is_refused() {
    let folder = Folder::new();
    folder.write("street.obj", STREET.as_bytes());
    let line = "form-factors street.obj -o f.csv --periodic";
    for (periods, code, expected) in [
        (
            "x=2,y",
            1,
            "the period along x is 2, but the model is 3 long there",
        ),
        ("q", 2, "\"q\" is not an axis"),
        ("x,x", 2, "x is there twice"),
        ("x=-1", 2, "\"-1\" is not a length above 0"),
        ("x=nan", 2, "not a length"),
        ("x=", 2, "not a length"),
    ] {
        folder.fails(&format!("{line} {periods}"), code, expected);
    }
    folder.write("flat.obj", b"v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n");
    let flat = "form-factors flat.obj -o f.csv --periodic x,z";
    folder.fails(flat, 1, "the model has no size along z; give the distance");
    // Formulas see no copies: rays take their place, and say so.
    let report = folder.json("form-factors street.obj -o f.csv --engine analytic --periodic x");
    assert_eq!(report["engine"], "rays");
    let notes = report["engine_notes"].to_string();
    assert!(notes.contains("the model repeats itself"), "{notes}");
    folder.ok("form-factors street.obj -o f.npz");
    folder.fails("form-factors f.npz -o g.csv --periodic x", 2, "--periodic");
}

/// Rows of a CSV by name, with their area and sum.
fn sums(folder: &Folder, file: &str) -> HashMap<String, (f64, f64)> {
    let (entries, areas) = table(&String::from_utf8(folder.read(file)).unwrap());
    let mut sums: HashMap<String, (f64, f64)> = HashMap::new();
    for ((from, _), f) in &entries {
        let row = sums.entry(from.clone()).or_insert((areas[from], 0.0));
        row.1 += f;
    }
    sums
}

#[test]
fn clusters_of_models_and_of_stored_factors_are_the_same() {
    let folder = Folder::with_room();
    let line = "form-factors room.obj --patches 200 --rays 256";
    let report = folder.json(&format!("{line} -o direct.csv --cluster 40 --threads 1"));
    let left = report["groups"].as_u64().unwrap();
    assert!((30..=40).contains(&left), "{left}");
    let fine = folder.json(&format!("{line} -o f.npz"));
    assert!(fine["patches"].as_u64().unwrap() >= 100);
    folder.ok("form-factors f.npz -o stored.csv --cluster 40 --threads 2");
    folder.ok("form-factors f.npz -o again.csv --cluster 40 --threads 1");
    assert!(folder.read("stored.csv") == folder.read("again.csv"));
    let [direct, stored] = ["direct.csv", "stored.csv"].map(|file| {
        let (entries, _) = table(&String::from_utf8(folder.read(file)).unwrap());
        entries
    });
    // Stored factors are divided by areas, and so rounded.
    let is_same = |(pair, f): (&_, &f64)| (f - direct[pair]).abs() < 1e-14;
    assert!(direct.len() == stored.len() && stored.iter().all(is_same));
    let rows = sums(&folder, "direct.csv");
    assert_eq!(rows.len() as u64, left);
    assert!(rows.keys().all(|name| name.contains('/')));
    // Areas, and the light that arrives (some ends on the back of the lamp), are those of objects.
    folder.ok("form-factors f.npz -o whole.csv --by object");
    let objects = sums(&folder, "whole.csv");
    let totals = [&rows, &objects].map(|rows| {
        let area: f64 = rows.values().map(|(area, _)| area).sum();
        let light: f64 = rows.values().map(|(area, sum)| area * sum).sum();
        [area, light]
    });
    for (clusters, objects) in totals[0].iter().zip(totals[1]) {
        assert!((clusters - objects).abs() < 1e-9 * objects, "{totals:?}");
    }
}

#[test]
fn clusters_that_cannot_be_so_few_are_noted() {
    let folder = Folder::with_room();
    folder.ok("form-factors room.obj -o f.npz --patches 100 --rays 64");
    let run = folder.ok("form-factors f.npz -o g.npz --cluster 1 --cluster-angle 0");
    assert!(
        run.err.contains("--cluster 1: ") && run.err.contains("beyond 0°"),
        "{}",
        run.err
    );
    let run = folder.ok("form-factors f.npz -o g.csv --cluster 100000");
    assert!(!run.err.contains("--cluster"), "{}", run.err);
    folder.fails(
        "form-factors g.npz -o h.npz --cluster 1",
        2,
        "--cluster: the rows of this matrix are groups",
    );
    let line = "form-factors room.obj -o f.csv";
    folder.fails(&format!("{line} --cluster 0"), 2, "--cluster");
    folder.fails(
        &format!("{line} --cluster 9 --by face"),
        2,
        "cannot be used with",
    );
    folder.fails(&format!("{line} --cluster-angle 9"), 2, "--cluster <N>");
    for angle in ["181", "x", "=-1"] {
        let line = format!("{line} --cluster 9 --cluster-angle {angle}");
        folder.fails(&line.replace(" =", "="), 2, "--cluster-angle");
    }
}

/// Two plates of four faces each, as a model and as a case.
fn plates(folder: &Folder) {
    let (mut corners, mut faces) = (String::new(), String::new());
    for (k, name) in ["floor", "ceiling"].into_iter().enumerate() {
        for i in 0..10 {
            // The ceiling faces down.
            let (x, y) = (if k == 0 { i % 5 } else { 4 - i % 5 }, i / 5);
            corners += &format!("v {x} {y} {k}\n");
        }
        faces += &format!("o {name}\n");
        for i in 10 * k + 1..10 * k + 5 {
            faces += &format!("f {i} {} {} {}\n", i + 1, i + 6, i + 5);
        }
    }
    folder.write("plates.obj", corners + &faces);
    let patch = |name: &str, start| {
        format!("{name} {{ type wall; inGroups (viewFactorWall); nFaces 4; startFace {start}; }}\n")
    };
    let patches = [patch("ceiling", 0), patch("floor", 4)].concat();
    std::fs::create_dir_all(folder.path("case/constant/polyMesh")).unwrap();
    folder.write(
        "case/constant/polyMesh/boundary",
        format!("2\n(\n{patches})\n"),
    );
}

#[test]
fn clusters_for_openfoam_are_of_whole_faces() {
    let folder = Folder::new();
    plates(&folder);
    let line = "-o case --format openfoam --openfoam v1912 --cluster 4";
    let agglomeration = || {
        let text = String::from_utf8(folder.read("case/constant/finalAgglom")).unwrap();
        text.lines()
            .skip_while(|l| *l != "2")
            .collect::<Vec<_>>()
            .join(" ")
    };
    // Faces are divided for the computation.
    let report = folder.json(&format!(
        "form-factors plates.obj --patches 200 --rays 64 {line}"
    ));
    assert_eq!(report["groups"], json!(4));
    let expected = "2 ( 4(0 0 1 1) 4(0 0 1 1) )";
    assert_eq!(agglomeration(), expected);
    // So are clusters of stored factors, and factors between clusters that were stored.
    folder.ok("form-factors plates.obj --patches 200 --rays 64 -o fine.npz");
    folder.write("case/constant/finalAgglom", "");
    folder.ok(&format!("form-factors fine.npz {line}"));
    assert_eq!(agglomeration(), expected);
    folder.ok("form-factors plates.obj --patch-size 0 --rays 64 -o coarse.npz --cluster 4");
    folder.write("case/constant/finalAgglom", "");
    folder.ok("form-factors coarse.npz -o case --format openfoam --openfoam v1912");
    assert_eq!(agglomeration(), expected);
    // Clusters of patches may cut faces.
    folder.ok("form-factors fine.npz -o cut.npz --cluster 30");
    let line = "form-factors cut.npz -o case --format openfoam --openfoam v1912";
    folder.fails(line, 1, "found several rows of face");
}

/// A cube whose floor is warm: what globes, elements and the faces of a small cube see of it, and how warm it seems.
#[test]
fn points_see_groups_and_feel_their_temperatures() {
    let folder = Folder::new();
    let mut cube = String::new();
    for k in 0..8 {
        let [x, y, z] = [0, 1, 2].map(|axis| k >> axis & 1);
        cube += &format!("v {x} {z} {y}\n");
    }
    cube += "o floor\nf 1 3 4 2\no lid\nf 5 6 8 7\no walls\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    folder.write("cube.obj", cube.replace("o lid\nf 5 6 8 7\n", ""));
    folder.write("points.txt", "0.5 0.5 0.5\n");
    folder.write("table.csv", "name,T\nfloor,320\nwalls,300\n");
    let from = "form-factors cube.obj --from points.txt --rays 65536";
    let open = format!("{from} -o a.csv --temperatures table.csv");
    folder.fails(&open, 1, "points see the sky, and it has no temperature");
    folder.write("cube.obj", cube);
    folder.write("table.csv", "name,T\nfloor,320\nlid,300\nwalls,300\n");
    // Rows by their names: factor and standard error.
    let table = |name: &str| -> HashMap<String, [f64; 2]> {
        let text = String::from_utf8(folder.read(name)).unwrap();
        let lines = text.lines().skip(1).map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            let numbers = [2, 3].map(|k| cells[k].parse().unwrap());
            (format!("{} {}", cells[0], cells[1]), numbers)
        });
        lines.collect()
    };
    let check = |table: &HashMap<String, [f64; 2]>, row: &str, expected: f64| {
        let [value, error] = table[row];
        let off = (value - expected).abs();
        assert!(
            off <= 3.0 * error + 1e-9,
            "{row}: {value} ± {error}, not {expected}"
        );
        assert!(error < 0.01 * expected, "{row}: {value} ± {error}");
    };
    let said = folder.ok(&open).err;
    let globe = table("a.csv");
    check(&globe, "0 floor", 1.0 / 6.0);
    check(&globe, "0 lid", 1.0 / 6.0);
    let warm = |share: f64| (share * 320f64.powi(4) + (1.0 - share) * 300f64.powi(4)).powf(0.25);
    check(&globe, "0 radiant_temperature", warm(1.0 / 6.0));
    assert!(said.contains("point 0 "), "{said}");
    // A face of a small cube, and an element: B-3, four times a quarter.
    let opposite = |distance: f64| 4.0 * element_parallel(0.5, 0.5, distance);
    folder.ok(&format!("{open} --six-directions"));
    let faces = table("a.csv");
    check(&faces, "0:-y floor", opposite(0.5));
    check(&faces, "0:-y radiant_temperature", warm(opposite(0.5)));
    check(
        &faces,
        "0:+x radiant_temperature",
        warm((1.0 - opposite(0.5)) / 4.0),
    );
    assert!(!faces.contains_key("0:+y floor"));
    folder.write("points.txt", "0.5 0 0.5 0 3 0\n");
    folder.ok(&format!("{from} -o a.csv --by face"));
    check(&table("a.csv"), "0 lid/0", opposite(1.0));
    // As an archive.
    folder.ok(&format!("{from} -o a.npz --temperatures table.csv"));
    let mut archive = NpzReader::new(Cursor::new(folder.read("a.npz")), 1 << 20).unwrap();
    let temperature = archive.array("radiant_temperature").unwrap().unwrap();
    assert!((temperature.number(0) - 300.0).abs() < 1.0);
    // What does not go together.
    folder.fails(
        &format!("{from} -o a.csv --six-directions"),
        2,
        "have normals",
    );
    folder.fails(&format!("{from} -o a.vtu"), 2, "written as .csv or .npz");
    folder.fails(
        &format!("{from} -o a.csv --cluster 2"),
        2,
        "cannot be used with",
    );
    folder.write("points.txt", "0.5 0\n");
    folder.fails(
        &format!("{from} -o a.csv"),
        1,
        "line 1: found 2 numbers, expected 3",
    );
    folder.write("table.csv", "name,T,q\nfloor,,5\nlid,300,\nwalls,300,\n");
    folder.write("points.txt", "0.5 0.5 0.5\n");
    folder.fails(&open, 1, "\"floor\" has a flux");
}
