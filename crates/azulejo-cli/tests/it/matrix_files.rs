//! `form-factors` for other programs: formats by name and extension, folders, and what is refused.

use crate::support::Folder;
use azulejo_exchange::files::FactorFormat;

const PLATES: &str = "o hot\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n\
                      o cold\nv 0 0 1\nv 0 1 1\nv 1 1 1\nv 1 0 1\nf 5 6 7 8\n";

const BOUNDARY: &str = "2(hot{inGroups (viewFactorWall); nFaces 1; startFace 0;}\n\
                        cold{inGroups (viewFactorWall); nFaces 1; startFace 1;})";

/// Two plates, and a case of OpenFOAM with them.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("plates.obj", PLATES);
    std::fs::create_dir_all(folder.path("case/constant/polyMesh")).unwrap();
    folder.write("case/constant/polyMesh/boundary", BOUNDARY);
    folder
}

const COMMAND: &str = "form-factors plates.obj --patch-size 0 --engine analytic";

#[test]
fn every_format_by_name() {
    let folder = folder();
    for entry in FactorFormat::table() {
        let output = match entry.format {
            FactorFormat::OpenFoam | FactorFormat::OpenFoamBinary => "case",
            FactorFormat::Udales => "vfsparse.inp.001",
            _ => "file",
        };
        let name = entry.name;
        folder.ok(&format!(
            "{COMMAND} -o {output} --format {name} --openfoam v1912"
        ));
    }
    for entry in FactorFormat::table()
        .iter()
        .filter(|e| !e.extensions.is_empty())
    {
        let extension = entry.extensions[0];
        folder.ok(&format!("{COMMAND} -o named.{extension}"));
    }
    let start = |name: &str, expected: &[u8]| {
        let found = folder.read(name);
        assert!(found.starts_with(expected), "{name}");
    };
    start("named.vtu", b"<?xml");
    start("named.idf", b"ZoneProperty:UserViewFactors:BySurfaceName,\n  Zone,\n  hot, hot, 0,\n  hot, cold, 0.1998");
    start("named.vwf", b"\x50\0\0\0Version 2.20 ");
    start("svf.inp.001", b"# sky view factors\n");
    start("case/constant/finalAgglom", b"FoamFile\n");
}

#[test]
fn cases_and_programs_are_known_before_the_work() {
    let folder = folder();
    let case = "-o case --format openfoam";
    folder.fails(&format!("{COMMAND} {case}"), 1, "v1912 (or earlier), v2312");
    folder.fails(
        &format!("{COMMAND} {case} --openfoam v2112"),
        2,
        "expected v1912",
    );
    folder.fails(&format!("{COMMAND} -o case"), 2, "--format openfoam");
    folder.fails(
        &format!("{COMMAND} -o . --format openfoam"),
        1,
        "no constant/polyMesh/boundary",
    );
    folder.fails(&format!("{COMMAND} -o f.xyz"), 2, "unknown matrix format");
    folder.fails(
        &format!("{COMMAND} -o f.vtu --vtu-rows x"),
        1,
        "found no row \"x\"",
    );
    let divided = "form-factors plates.obj --patches 20 --rays 16";
    folder.fails(
        &format!("{divided} {case} --openfoam org"),
        1,
        "several rows of face 0",
    );
    assert!(!folder.path("case/constant/F").exists());
    let run = folder.ok(&format!("{COMMAND} {case} --openfoam v1912 --threads 1"));
    assert!(
        run.err.contains("2 of 2 rows lose light to sky or ground"),
        "{}",
        run.err
    );
    let text = String::from_utf8(folder.read("case/constant/mapDist")).unwrap();
    assert!(
        text.ends_with("2\n1\n(\n2(0 1)\n)\n1\n(\n2(0 1)\n)\n0 0\n0()\n0()\n"),
        "{text}"
    );
}

/// A closed cube of six squares that face outward, as most programs export a room.
const OUTWARD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                       o floor\nf 4 3 2 1\no lid\nf 5 6 7 8\no s0\nf 2 6 5 1\no s1\nf 3 7 6 2\n\
                       o s2\nf 4 8 7 3\no s3\nf 1 5 8 4\n";

/// A small closed box inside of the cube, seen from outside of the box.
const BOX: &str = "v .4 .4 .4\nv .6 .4 .4\nv .6 .6 .4\nv .4 .6 .4\nv .4 .4 .6\nv .6 .4 .6\nv .6 .6 .6\n\
                   v .4 .6 .6\no box\nf -5 -6 -7 -8\nf -4 -3 -2 -1\nf -7 -3 -4 -8\nf -6 -2 -3 -7\n\
                   f -5 -1 -2 -6\nf -8 -4 -1 -5\n";

#[test]
fn rooms_turned_outward_are_told_and_turned() {
    let folder = Folder::new();
    folder.write("room.obj", OUTWARD);
    let told = folder
        .ok("form-factors room.obj -o f.csv --patch-size 0")
        .err;
    assert!(told.contains("--flip \"*\""), "{told}");
    let turned = folder.run("form-factors room.obj -o f.csv --patch-size 0 --flip *");
    assert!(
        turned.code == Some(0) && !turned.err.contains("flip"),
        "{}",
        turned.err
    );
    let found = folder.json("form-factors room.obj -o f.csv --patch-size 0 --flip floor,lid,s?");
    assert!(
        (found["row_sum_min"].as_f64().unwrap() - 1.0).abs() < 1e-9,
        "{found}"
    );
    folder.fails(
        "form-factors room.obj -o f.csv --flip roof",
        2,
        "no object has the name \"roof\"",
    );
}

#[test]
fn a_box_inside_out_is_named() {
    let folder = Folder::new();
    folder.write("both.obj", format!("{OUTWARD}{BOX}"));
    let room = "form-factors both.obj -o f.csv --patch-size 0 --flip floor,lid,s?";
    let right = folder.ok(room).err;
    assert!(!right.contains("inside out"), "{right}");
    let wrong = folder.ok(&format!("{room},box")).err;
    assert!(wrong.contains("the backs of \"box\" see"), "{wrong}");
}

#[test]
fn what_an_archive_holds_is_told() {
    let folder = Folder::new();
    folder.write("room.obj", OUTWARD);
    folder.ok("form-factors room.obj -o f.npz --patch-size 0 --flip *");
    let words = folder.ok("info f.npz").out;
    for part in ["64 bits", "mean 1.000000", "analytic", "floor", "indptr"] {
        assert!(words.contains(part), "{part}: {words}");
    }
    let found = folder.json("info f.npz");
    assert_eq!(found["patches"], 6);
    assert_eq!(found["objects"].as_array().unwrap().len(), 6);
    assert!((found["area"].as_f64().unwrap() - 6.0).abs() < 1e-12);
    folder.write("not.npz", "PK");
    folder.fails("info not.npz", 1, "not.npz");
}
