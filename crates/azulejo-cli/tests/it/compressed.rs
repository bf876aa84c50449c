//! `form-factors --compress`: what is written, who reads it, and what is refused.

use crate::support::Folder;
use serde_json::Value;

fn number(report: &Value, key: &str) -> f64 {
    report[key].as_f64().unwrap_or(f64::NAN)
}

/// The number that a list gives for two names.
fn of_pair(folder: &Folder, file: &str, from: &str, to: &str) -> f64 {
    let list = String::from_utf8(folder.read(file)).unwrap();
    let start = format!("{from},{to},");
    let line = list.lines().find_map(|line| line.strip_prefix(&start));
    let value = line.and_then(|rest| rest.split(',').next());
    value.unwrap().parse().unwrap()
}

/// Blocks of formulas, and blocks by rays of which there was no whole matrix, against the whole.
#[test]
fn blocks_exchange_and_group_as_the_matrix_does() {
    let folder = Folder::with_room();
    folder.write("paint.csv", "name,eps\n*,0.6\n");
    let names: Vec<String> = {
        let report = folder.json("form-factors room.obj -o whole.npz --patches 900");
        assert_eq!(report["engine"], "analytic");
        let info = folder.json("info whole.npz");
        let objects = info["objects"].as_array().unwrap().iter();
        objects
            .map(|o| o["name"].as_str().unwrap().to_owned())
            .collect()
    };
    let pair = |file: &str| of_pair(&folder, file, &names[0], &names[1]);
    folder.ok("form-factors whole.npz -o by.csv --by object");
    folder.ok("exchange whole.npz --materials paint.csv -o gr.csv");
    let (factor, conductance) = (pair("by.csv"), pair("gr.csv"));
    for (options, tolerance) in [("--patches 900", 1e-4), ("--patches 900 --rays 4096", 2e-2)] {
        let line = format!("form-factors room.obj -o f.npz {options} --compress 1e-4");
        let report = folder.json(&line);
        let bytes = number(&report, "matrix_bytes");
        assert!(bytes < number(&report, "whole_bytes"), "{report}");
        let by_rays = options.contains("--rays");
        assert_eq!(report["traced_again"].as_u64().unwrap() > 0, by_rays);
        assert_eq!(number(&report, "product_error_error") > 0.0, by_rays);
        assert!(number(&report, "product_error") < tolerance, "{report}");
        assert!(number(&report, "unaccounted_max") < 1e-3, "{report}");
        let info = folder.json("info f.npz");
        for key in [
            "matrix_bytes",
            "blocks",
            "product_error",
            "tolerance",
            "row_sum_mean",
        ] {
            assert_eq!(info[key], report[key], "{key}");
        }
        assert!(
            info["arrays"]
                .as_array()
                .unwrap()
                .contains(&"block_rows".into())
        );
        folder.ok("form-factors f.npz -o by.csv --by object");
        folder.ok("exchange f.npz --materials paint.csv -o gr.csv");
        folder.ok("exchange f.npz --materials paint.csv --lump -o lumped.csv");
        folder.ok("form-factors f.npz -o by.npz --cluster 40 --closure");
        assert!(
            (pair("by.csv") / factor - 1.0).abs() < tolerance,
            "{options}"
        );
        assert!(
            (pair("gr.csv") / conductance - 1.0).abs() < tolerance,
            "{options}"
        );
        assert!(
            (pair("lumped.csv") / conductance - 1.0).abs() < 0.1,
            "{options}"
        );
    }
}

#[test]
fn blocks_do_not_depend_on_threads_and_say_what_they_are() {
    let folder = Folder::with_room();
    let line = "form-factors room.obj --patches 1200 --rays 256 --compress 1e-2";
    folder.ok(&format!("{line} -o one.npz --threads 1"));
    let run = folder.ok(&format!("{line} -o two.npz --threads 2 --closure"));
    assert!(folder.read("one.npz") == folder.read("two.npz"));
    assert!(run.err.contains("--closure has no effect"), "{}", run.err);
    let run = folder.ok("info two.npz");
    for words in [
        "in blocks",
        "of low rank",
        "rows traced again",
        "error of products",
    ] {
        assert!(run.out.contains(words), "{words}: {}", run.out);
    }
    assert!(!folder.names().iter().any(|name| name.contains("journal")));
}

#[test]
fn what_blocks_have_not_is_refused() {
    let folder = Folder::with_room();
    let line = "form-factors room.obj -o f.npz --compress 1e-3";
    for (options, expected) in [
        ("--shard 1/2", "--shard"),
        ("--separate", "--separate"),
        ("--truncate 0.1%", "no single entries"),
        ("--by object", "form-factors F.npz --by object"),
        ("--cluster 50", "--cluster"),
        ("--precision double", "--precision"),
        ("--format csv", "blocks are written as .npz"),
    ] {
        folder.fails(&format!("{line} {options}"), 2, expected);
    }
    folder.fails(
        "form-factors room.obj -o f.csv --compress 1e-3",
        2,
        "f.csv is not one",
    );
    folder.fails(
        "form-factors room.obj -o f.npz --compress 2",
        2,
        "1e-9 to 0.1",
    );
    let tight = "--engine analytic --patches 3000 --memory 8M";
    folder.fails(&format!("{line} {tight}"), 1, "of memory");
    let tight = "--rays 512 --patches 3000 --memory 8M";
    folder.fails(&format!("{line} {tight}"), 1, "of memory");
    folder.write(
        "room.vs3",
        "G 3\nV 1 0 0 0\nV 2 1 0 0\nV 3 1 1 0\nV 4 0 1 0\nS 1 1 2 3 4 0 0 0.5 a\n",
    );
    folder.fails(
        "form-factors room.vs3 -o f.npz --compress 1e-3",
        2,
        "View3D",
    );
    folder.ok(&format!("{line} --patches 600"));
    folder.fails(
        "form-factors f.npz -o g.npz",
        1,
        "expected --by or --cluster",
    );
    folder.fails(
        "form-factors f.npz -o g.npz --compress 1e-2",
        2,
        "no clusters of its rows",
    );
    folder.write("paint.csv", "name,eps\n*,0.6\n");
    let whole = folder.read("f.npz");
    folder.write("cut.npz", &whole[..whole.len() / 2]);
    for line in [
        "info cut.npz",
        "exchange cut.npz --materials paint.csv -o gr.csv",
    ] {
        folder.fails(line, 1, "cut.npz");
    }
}
