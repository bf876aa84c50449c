//! What each command promises, on a small room.

use crate::support::{Folder, project};
use serde_json::json;

#[test]
fn info_counts() {
    let folder = Folder::with_room();
    let info = folder.json("info room.obj");
    for (key, expected) in [
        ("objects", json!(2)),
        ("faces", json!(7)),
        ("triangles", json!(14)),
        ("materials", json!(2)),
        ("cameras", json!([])),
        ("solved", json!(false)),
        (
            "bounds",
            json!({ "min": [0.0, 0.0, 0.0], "max": [4.0, 3.0, 4.0] }),
        ),
        ("warnings", json!([])),
    ] {
        assert_eq!(info[key], expected, "{key}");
    }
    assert_eq!(info["lights"]["area"], json!(1));
    assert!((info["area"].as_f64().unwrap() - 81.0).abs() < 1e-9);
    // The room is seen from inside, the lamp is open.
    let volumes = [0, 1].map(|i| info["object_list"][i]["volume"].as_f64());
    assert_eq!(volumes.iter().flatten().count(), 1, "{volumes:?}");
    assert!(
        (volumes.iter().flatten().sum::<f64>() + 48.0).abs() < 1e-9,
        "{volumes:?}"
    );
    let per_object: u64 = (0..2)
        .map(|i| info["object_list"][i]["vertices"].as_u64().unwrap())
        .sum();
    assert_eq!(info["vertices"], json!(per_object));
    let words = folder.ok("info room.obj").out;
    assert!(words.contains("lamp") && words.contains("triangles"));
}

#[test]
fn convert_keeps_what_is_there() {
    let folder = Folder::with_room();
    folder.ok("convert room.obj -o room.grf");
    folder.ok("convert room.grf -o again.obj");
    assert!(folder.names().contains(&"again.mtl".to_owned()));
    let counts = |file: &str| {
        let info = folder.json(&format!("info {file}"));
        [
            &info["objects"],
            &info["faces"],
            &info["area"],
            &info["lights"],
        ]
        .map(ToString::to_string)
    };
    assert_eq!(counts("room.obj"), counts("room.grf"));
    assert_eq!(counts("room.obj"), counts("again.obj"));
    let merged = folder.json("convert room.grf again.obj -o both.grf");
    assert_eq!(merged["objects"], json!(4));
    let printed = folder.ok("convert room.obj -o - --quiet");
    assert_eq!(printed.out.as_bytes(), folder.read("room.grf"));
    assert_eq!(printed.err, "");
}

#[test]
fn solve_writes_light_that_render_reads() {
    let folder = Folder::with_room();
    let solved = folder.json("solve room.obj -o lit.grf --patches 200 --rays 64");
    assert!(solved["patches"].as_u64().unwrap() >= 100);
    assert!(solved["error"].as_f64().unwrap() < 0.5);
    let power = |key: &str| solved[key][0].as_f64().unwrap();
    // The lamp is 1 × 1 and shines with π · 10 W/m²; nothing can leave a closed room.
    assert!((power("emitted") / 31.4159 - 1.0).abs() < 0.01);
    assert!(power("escaped").abs() < 0.05);
    let info = folder.json("info lit.grf");
    assert_eq!(info["solved"], json!(true));
    let picture = folder.json("render lit.grf -o lit.png --size 40x30 --spp 1 --rays 64");
    assert_eq!(picture["solved_before"], json!(true));
    assert!(folder.read("lit.png").starts_with(b"\x89PNG\r\n\x1a\n"));
}

#[test]
fn render_solves_when_it_must_and_writes_by_extension() {
    let folder = Folder::with_room();
    for (name, magic) in [
        ("a.png", &b"\x89PNG"[..]),
        ("a.exr", &b"\x76\x2f\x31\x01"[..]),
        ("a.hdr", &b"#?RADIANCE"[..]),
    ] {
        let line = format!(
            "render room.obj -o {name} --size 16x12 --spp 1 --rays 32 --patches 100 \
             --from 2,1,3.9 --at 2,1,0"
        );
        let report = folder.json(&line);
        assert_eq!(report["solved_before"], json!(false));
        assert_eq!(
            (&report["width"], &report["height"]),
            (&json!(16), &json!(12))
        );
        assert!(folder.read(name).starts_with(magic), "{name}");
    }
    let names = folder.names();
    assert_eq!(names, ["a.exr", "a.hdr", "a.png", "room.mtl", "room.obj"]);
}

#[test]
fn results_do_not_depend_on_the_threads() {
    let folder = Folder::with_room();
    for threads in [1, 3] {
        folder.ok(&format!(
            "solve room.obj -o {threads}.grf --patches 100 --rays 32 --threads {threads}"
        ));
        folder.ok(&format!(
            "render {threads}.grf -o {threads}.png --size 20x20 --spp 2 --threads {threads}"
        ));
    }
    assert_eq!(folder.read("1.grf"), folder.read("3.grf"));
    assert_eq!(folder.read("1.png"), folder.read("3.png"));
}

#[test]
fn probe_measures_irradiance() {
    let folder = Folder::with_room();
    folder.write(
        "p.txt",
        "# floor, then ceiling\n2 0 2  0 1 0\n2 3 2  0 -2 0\n",
    );
    let report = folder.json("probe room.obj --points p.txt -o e.txt --patches 200 --rays 256");
    assert!(report["trace_seconds"].as_f64().unwrap() > 0.0);
    let text = String::from_utf8(folder.read("e.txt")).unwrap();
    let rows: Vec<Vec<f64>> = text
        .lines()
        .map(|l| l.split(' ').map(|w| w.parse().unwrap()).collect())
        .collect();
    assert_eq!(rows.iter().map(Vec::len).collect::<Vec<_>>(), [6, 6]);
    // Under the lamp: its unit square 2.9 above gives 10 · 0.1164 · … of direct light alone.
    let direct = 10.0 * square_above(0.5, 2.9);
    assert!(
        rows[0][0] > direct && rows[0][0] < 10.0 * direct,
        "{rows:?}"
    );
    assert!(
        rows[0][3] > 0.0 && rows[0][3] < 0.2 * rows[0][0],
        "{rows:?}"
    );
    // Grey light on walls that are redder than blue comes back redder.
    assert!(rows[1][0] > rows[1][2], "{rows:?}");
}

/// Irradiance over radiance below the middle of a square of half side `a` at height `h`:
/// π times the form factor, four times that of a quarter seen from its corner.
fn square_above(a: f64, h: f64) -> f64 {
    let x = a / h;
    let quarter = x / (1.0 + x * x).sqrt() * (x / (1.0 + x * x).sqrt()).atan();
    4.0 * quarter
}

#[test]
fn probe_traces_rays() {
    let folder = Folder::with_room();
    let down: [f32; 8] = [2.0, 2.0, 2.0, 0.0, 0.0, -2.0, 0.0, f32::INFINITY];
    let short: [f32; 8] = [2.0, 2.0, 2.0, 0.0, 0.0, -2.0, 0.0, 0.5];
    let bytes = |r: [f32; 8]| r.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    folder.write("r.f32", [bytes(down), bytes(short)].concat());
    let report = folder.json("probe room.obj --hits r.f32 -o h.txt");
    assert_eq!((&report["rays"], &report["hits"]), (&json!(2), &json!(1)));
    assert!(report["build_seconds"].is_number() && report["trace_seconds"].is_number());
    let text = String::from_utf8(folder.read("h.txt")).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert!(
        lines[0].starts_with("1 0 0 ") || lines[0].starts_with("1 0 1 "),
        "{text}"
    );
    assert_eq!(lines[1], "inf -1 -1 0 0");
    let radiance = folder.ok("probe room.obj --radiance r.f32 --patches 100 --rays 32");
    assert_eq!(radiance.out.lines().count(), 2);
    assert!(
        radiance
            .out
            .split(' ')
            .next()
            .unwrap()
            .parse::<f64>()
            .unwrap()
            > 0.0
    );
}

#[test]
fn probe_reads_and_writes_npy() {
    let folder = Folder::with_room();
    let npy = |values: [f32; 3]| {
        let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 3), }\n";
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(values.iter().flat_map(|x| x.to_le_bytes()));
        bytes
    };
    folder.write("p.npy", npy([2.0, 0.0, 2.0]));
    folder.write("n.npy", npy([0.0, 1.0, 0.0]));
    let options = "--patches 100 --rays 64";
    folder.ok(&format!(
        "probe room.obj --points p.npy --normals n.npy -o e.npy {options}"
    ));
    let bytes = folder.read("e.npy");
    assert!(bytes.starts_with(b"\x93NUMPY\x01\x00"));
    let head = String::from_utf8_lossy(&bytes[10..128]).into_owned();
    assert!(head.contains("'<f8'") && head.contains("(1, 6)"), "{head}");
    let first = f64::from_le_bytes(bytes[128..136].try_into().unwrap());
    folder.write("p.txt", "2 0 2 0 1 0");
    let text = folder.ok(&format!("probe room.obj --points p.txt {options}"));
    assert_eq!(text.out.split(' ').next().unwrap(), first.to_string());
}

#[test]
fn form_factors_of_a_closed_room_sum_to_one() {
    let folder = Folder::with_room();
    // The lamp hangs free: its back also receives, and counts only when asked for.
    let report = folder.json("form-factors room.obj -o f.csv --patches 60 --rays 256 --two-sided");
    assert_eq!(report["closed"], json!(true));
    let patches = report["patches"].as_u64().unwrap() as usize;
    let text = String::from_utf8(folder.read("f.csv")).unwrap();
    let (mut sums, mut blind_rows) = (vec![0.0; patches], 0);
    for line in text
        .lines()
        .filter(|l| l.starts_with(|c: char| c.is_ascii_digit()))
    {
        let words: Vec<&str> = line.split(',').collect();
        let row: usize = words[0].parse().unwrap();
        sums[row] += words[2].parse::<f64>().unwrap();
    }
    for (i, sum) in sums.iter().enumerate() {
        // The backs of the walls see nothing at all.
        let blind = *sum == 0.0;
        blind_rows += usize::from(blind);
        assert!(blind || (sum - 1.0).abs() < 0.01, "row {i} sums to {sum}");
    }
    assert!(blind_rows < patches / 2, "{blind_rows} of {patches}");
    folder.ok("form-factors room.obj -o f.npz --patches 60 --rays 64");
    let archive = folder.read("f.npz");
    let contains = |name: &str| archive.windows(name.len()).any(|w| w == name.as_bytes());
    for name in [
        "data.npy",
        "indices.npy",
        "indptr.npy",
        "shape.npy",
        "format.npy",
        "areas.npy",
        "patch_face.npy",
        "std_error.npy",
    ] {
        assert!(contains(name), "{name}");
    }
}

#[test]
fn the_program_explains_itself() {
    let folder = Folder::new();
    for command in [
        "info",
        "convert",
        "solve",
        "render",
        "probe",
        "form-factors",
        "merge",
        "exchange",
        "experiment",
        "validate",
        "bake",
        "text",
        "font",
        "font convert",
        "font sheet",
        "extrude",
        "brdf",
        "brdf list",
        "brdf eval",
        "brdf plot",
        "brdf check",
        "brdf fit",
        "grf",
        "grf fmt",
        "grf lint",
        "grf diff",
        "completions",
        "man",
        "view",
    ] {
        let help = folder.ok(&format!("{command} --help")).out;
        assert!(help.contains("Examples:"), "{command}");
    }
    assert!(folder.ok("--version").out.starts_with("azulejo "));
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = folder.ok(&format!("completions {shell}")).out;
        assert!(script.contains("form-factors"), "{shell}");
    }
    folder.ok("man .");
    let page = String::from_utf8(folder.read("azulejo-render.1")).unwrap();
    assert!(page.contains(".TH") && page.contains("exposure"));
    assert_eq!(folder.names().len(), 30);
}

#[test]
fn the_examples_are_whole() {
    let folder = Folder::new();
    let examples = project().join("examples");
    let mut seen = 0;
    for entry in std::fs::read_dir(examples).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "grf") {
            let info = folder.json(&format!("info {}", path.display()));
            assert_eq!(info["warnings"], json!([]), "{path:?}");
            seen += 1;
        }
    }
    assert!(seen >= 3, "{seen} examples");
}

/// What will not be reached is said before the work is done, with what it would take.
#[test]
fn goals_out_of_reach_are_said_at_once() {
    let folder = Folder::with_room();
    let line = "solve room.obj --patches 300 --error 0.2% --rays 64 -o room.grf";
    let words = folder.ok(line).err;
    let (early, late) = (
        words.find("will not be reached"),
        words.find("estimated error"),
    );
    assert!(early.is_some() && early < late, "{words}");
    assert!(
        words.contains("0.2% will not be reached with 64 rays per point: about")
            && words.contains("rays per point would be needed"),
        "{words}"
    );
    let timed = folder.ok("solve room.obj --patches 300 --error 0.01% --time 4s -o room.grf");
    let expected = "0.01% will not be reached in 4 s: about";
    assert!(timed.err.contains(expected), "{}", timed.err);
    for line in [
        format!("{line} --quiet"),
        "solve room.obj --patches 300 --error 20% -o room.grf".to_owned(),
        "solve room.obj --patches 300 --rays 64 -o room.grf".to_owned(),
    ] {
        let words = folder.ok(&line).err;
        assert!(!words.contains("will not be reached"), "{line}: {words}");
    }
}

/// Light that the last of the requested bounces left is not an imbalance; the discretization is stated.
#[test]
fn limited_bounces_are_no_imbalance() {
    let folder = Folder::with_room();
    for bounces in [0, 1, 2] {
        let line = format!("solve room.obj --patches 300 --bounces {bounces} -o room.grf");
        let found = folder.json(&line);
        let number = |key: &str| found[key].as_f64().unwrap();
        assert!(number("energy_error") > 0.1, "{found}");
        assert!(number("error") < 0.1, "{found}");
        assert_eq!(bounces > 0, number("error_discretization") > 0.0, "{found}");
        let words = folder.ok(&line).err;
        assert!(words.contains("reflected once more"), "{words}");
    }
}

/// Output that is lost is a failure, whatever it is; one that nobody reads is none.
#[cfg(unix)]
#[test]
fn a_full_disk_is_a_failure() {
    let folder = Folder::with_room();
    if !std::path::Path::new("/dev/full").exists() {
        return;
    }
    for line in [
        "--version",
        "--help",
        "help solve",
        "completions bash",
        "info room.obj",
        "info room.obj --json",
    ] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full");
        let run = folder.command(line).stdout(full.unwrap()).output();
        let run = crate::support::Run::of(run.unwrap());
        assert_eq!(run.code, Some(1), "{line}: {}", run.err);
        assert!(run.err.contains("No space left"), "{line}: {}", run.err);
    }
}

/// A cube as other programs write it, and the same turned inside out; a room is not a mistake.
#[test]
fn closed_meshes_that_are_inverted_are_named() {
    let folder = Folder::with_room();
    let points = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n";
    let outward = "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    let inward = "f 1 2 3 4\nf 8 7 6 5\nf 5 6 2 1\nf 6 7 3 2\nf 7 8 4 3\nf 8 5 1 4\n";
    let inverted = |name: &str, faces: &str| {
        folder.write(name, format!("o cube\n{points}{faces}"));
        folder.json(&format!("info {name}"))["inverted"].clone()
    };
    assert_eq!(inverted("good.obj", outward), json!([]));
    assert_eq!(inverted("bad.obj", inward), json!(["cube"]));
    let open = inward.replace("f 1 2 3 4\n", "");
    assert_eq!(inverted("open.obj", &open), json!([]));
    assert_eq!(folder.json("info room.obj")["inverted"], json!([]));
    let said = folder.ok("info bad.obj").out;
    assert!(said.contains("turned inside out"), "{said}");
}

/// Light that no number holds is an error, and nothing is written.
#[test]
fn results_that_are_not_finite_are_refused() {
    let folder = Folder::with_room();
    let materials = String::from_utf8(folder.read("room.mtl")).unwrap();
    folder.write(
        "room.mtl",
        materials.replace("Ke 10 10 10", "Ke 1e300 1e300 1e300"),
    );
    folder.write("points.txt", "2 1 2 0 1 0\n");
    let before = folder.names();
    for output in ["a.grf", "a.glb", "a.ply"] {
        let line = format!("solve room.obj -o {output} --patches 50 --rays 64");
        folder.fails(&line, 1, "finite");
    }
    folder.fails("convert room.obj -o a.glb", 1, "32 bits");
    assert_eq!(folder.names(), before);
    folder.ok("convert room.obj -o a.grf");
    folder.ok("info a.grf");
}

/// What a run that was killed left beside its output.
#[cfg(target_os = "linux")]
#[test]
fn drafts_of_killed_runs_are_removed() {
    let folder = Folder::with_room();
    let mut gone = std::process::Command::new("true").spawn().unwrap();
    gone.wait().unwrap();
    folder.write(&format!(".azulejo-{}-0.tmp", gone.id()), "half");
    folder.write(".azulejo-1-0.tmp", "of a process that lives");
    folder.ok("convert room.obj -o a.grf");
    let expected = [".azulejo-1-0.tmp", "a.grf", "room.mtl", "room.obj"];
    assert_eq!(folder.names(), expected);
}
