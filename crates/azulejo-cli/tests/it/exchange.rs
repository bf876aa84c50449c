//! `exchange`: from models and from stored factors, in bands, with mirrors, and what is refused.

use crate::support::Folder;

/// A closed cube of six named squares.
const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                    o floor\nf 1 2 3 4\no lid\nf 8 7 6 5\no s0\nf 1 5 6 2\no s1\nf 2 6 7 3\n\
                    o s2\nf 3 7 8 4\no s3\nf 4 8 5 1\n";

/// F between opposite squares of a cube (Howell's C-11).
const OPPOSITE: f64 = 0.199_824_895_698;

fn cube() -> Folder {
    let folder = Folder::new();
    folder.write("cube.obj", CUBE);
    folder.write("black.csv", "name,eps\n*,1\n");
    folder.write("reradiating.csv", "name,T,q\nfloor,500,\nlid,400,\n*,,0\n");
    folder
}

fn text(folder: &Folder, name: &str) -> String {
    String::from_utf8_lossy(&folder.read(name)).into_owned()
}

/// The conductance between two nodes in a list.
fn conductance(list: &str, from: &str, to: &str) -> f64 {
    let start = format!("{from},{to},");
    let line = list.lines().find_map(|line| line.strip_prefix(&start));
    let value = line.and_then(|rest| rest.split(',').next());
    value.unwrap().parse().unwrap()
}

/// Black floor and ceiling between four walls that reradiate: GR/A = (1 + F₁₂) / 2, so that
/// Q = σ (1 + F₁₂)/2 (T₁⁴ − T₂⁴).
#[test]
fn reradiating_walls_by_model_and_by_stored_factors() {
    let folder = cube();
    let options = "--materials black.csv --boundary reradiating.csv";
    folder.ok(&format!(
        "exchange cube.obj --patch-size 0 {options} -o whole.csv -o whole.vtu"
    ));
    folder.ok("form-factors cube.obj -o f.npz --patch-size 0");
    let report = folder.json(&format!("exchange f.npz {options} -o stored.csv"));
    let whole = text(&folder, "whole.csv");
    assert_eq!(whole, text(&folder, "stored.csv"));
    let heat: f64 = whole
        .lines()
        .find_map(|line| line.strip_prefix("floor,"))
        .and_then(|line| line.split(',').nth(3))
        .unwrap()
        .parse()
        .unwrap();
    let sigma = 5.670_374_419e-8;
    let expected = sigma * (1.0 + OPPOSITE) / 2.0 * (500f64.powi(4) - 400f64.powi(4));
    assert!((heat / expected - 1.0).abs() < 1e-9, "{heat}, {expected}");
    assert!(report["imbalance"].as_f64().unwrap().abs() < 1e-6);
    assert!(report["closure"].as_f64().unwrap() < 1e-9);
    assert_eq!(report["heat"][0]["name"], "floor");
    assert!(text(&folder, "whole.vtu").contains("Name=\"T\""));
}

/// The ceiling of a cube is a mirror. From the floor to it the Gebhart factor is 0.0313 where every patch has a
/// radiosity of its own; of six walls that shine evenly it is 0.0329.
#[test]
fn nodes_are_solved_first_or_lumped_first() {
    let folder = cube();
    folder.write("mirror.csv", "name,eps,rho_s\nlid,0.1,0.9\n*,0.6,0\n");
    let gebhart = |options: &str| {
        folder.ok(&format!(
            "exchange cube.obj --patches 384 --materials mirror.csv --by object {options} -o gr.csv"
        ));
        conductance(&text(&folder, "gr.csv"), "floor", "lid") / 0.6
    };
    let (solved, lumped) = (gebhart(""), gebhart("--lump"));
    assert!((solved - 0.0313).abs() < 1e-4, "{solved}");
    assert!((lumped - 0.032_878_543_926).abs() < 1e-6, "{lumped}");
}

/// Bands with other mirrors have factors of their own; stored factors without them are refused.
#[test]
fn mirrors_per_band() {
    let folder = cube();
    folder.write(
        "bands.csv",
        "name,eps@0-4,rho_s@0-4,eps@4-inf\ns0,0,1,0.9\n*,0.5,0,0.9\n",
    );
    let run = folder.ok("exchange cube.obj --patch-size 0 --materials bands.csv -o gr.csv");
    assert!(run.err.contains("closure 0-4"), "{}", run.err);
    let list = text(&folder, "gr.csv");
    assert!(list.starts_with("band_um,from,to,gr_m2,std_error\n0-4,floor,lid,"));
    let bands = |band: &str| list.lines().filter(|l| l.starts_with(band)).count();
    // The mirror neither emits nor absorbs in its band.
    assert_eq!((bands("0-4,"), bands("4-inf,")), (10, 15));
    folder.ok("form-factors cube.obj -o f.npz --patch-size 0");
    folder.fails(
        "exchange f.npz --materials bands.csv -o gr.csv",
        1,
        "mirror reflectance 0 of \"s0",
    );
    folder.fails(
        "form-factors cube.obj -o g.npz --materials bands.csv",
        1,
        "differ from band to band",
    );
}

#[test]
fn factors_of_a_mirror_are_those_of_its_table() {
    let folder = cube();
    folder.write("mirror.csv", "name,eps,rho_s\ns0,0.1,0.9\n*,0.5,0\n");
    folder.ok("form-factors cube.obj -o f.npz --patch-size 0 --materials mirror.csv");
    folder.ok("exchange f.npz --materials mirror.csv -o stored.csv");
    folder.ok("exchange cube.obj --patch-size 0 --materials mirror.csv -o whole.csv");
    assert_eq!(text(&folder, "stored.csv"), text(&folder, "whole.csv"));
    let list = text(&folder, "whole.csv");
    let symmetric = conductance(&list, "floor", "s2") / conductance(&list, "lid", "s2");
    assert!((symmetric - 1.0).abs() < 1e-4, "{symmetric}");
}

#[test]
fn thermal_programs_get_their_lists() {
    let folder = cube();
    folder.ok(
        "exchange cube.obj --patch-size 0 --materials black.csv -o gr.esatan -o gr.sinda --model BOX \
         --truncate 0.01",
    );
    assert!(text(&folder, "gr.esatan").contains("$CONDUCTORS"));
    assert!(text(&folder, "gr.sinda").contains("BOX"));
}

#[test]
fn what_is_refused_says_why() {
    let folder = cube();
    folder.write("some.csv", "name,eps\nfloor,0.5\n");
    folder.write("off.csv", "name,eps\n*,1.5\n");
    folder.write("adiabatic.csv", "name,q\n*,0\n");
    folder.write("typo.csv", "name,T\nflor,300\n*,300\n");
    folder.ok("form-factors cube.obj -o f.npz --patch-size 0");
    let misuse = [
        ("cube.obj --materials black.csv -o a.vtu", "--boundary"),
        ("cube.obj --materials black.csv -o a.txt", "unknown format"),
        (
            "f.npz cube.obj --materials black.csv -o a.csv",
            "one or the other",
        ),
        ("f.npz --rays 5 --materials black.csv -o a.csv", "--rays"),
        (
            "f.npz --closure --materials black.csv -o a.csv",
            "--closure",
        ),
        (
            "f.npz --sun 180,30,1000 --materials black.csv -o a.csv",
            "a column \"solar\" of --boundary",
        ),
        (
            "f.npz --flip floor --materials black.csv -o a.csv",
            "--flip",
        ),
    ];
    let failures = [
        (
            "cube.obj --materials some.csv -o a.csv",
            "the emissivity of",
        ),
        ("cube.obj --materials off.csv -o a.csv", "0 to 1"),
        ("cube.obj --materials none.csv -o a.csv", "none.csv"),
        (
            "f.npz --materials black.csv --boundary adiabatic.csv -o a.csv",
            "none of them has a temperature",
        ),
    ];
    let codes = [(2, &misuse[..]), (1, &failures[..])];
    for (code, (arguments, expected)) in codes
        .into_iter()
        .flat_map(|(code, list)| list.iter().map(move |refused| (code, *refused)))
    {
        folder.fails(&format!("exchange {arguments}"), code, expected);
        assert!(!folder.path("a.csv").exists());
    }
    let run = folder.ok("exchange f.npz --materials black.csv --boundary typo.csv -o a.csv");
    assert!(
        run.err.contains("no row has the name \"flor\""),
        "{}",
        run.err
    );
}

/// A window that lies in the plane of the floor counts its light twice; a face without area is not a row.
#[test]
fn overlapping_faces_are_named_before_heat_is_wrong() {
    let folder = cube();
    let window = "o window\nv 0.2 0.2 0\nv 0.8 0.2 0\nv 0.8 0.8 0\nf 9 10 11\nf 9 10 9\n";
    folder.write("glazed.obj", format!("{CUBE}{window}"));
    let run = folder.ok("form-factors glazed.obj --patch-size 0 --closure=never -o f.npz");
    for words in [
        "face 0 of \"window\" on face 0 of \"floor\"",
        "without area have no row: face 1 of \"window\"",
    ] {
        assert!(run.err.contains(words), "{}", run.err);
    }
    let run = folder.ok("exchange f.npz --materials black.csv -o gr.csv");
    assert!(
        run.err.contains("exceed all of its light by"),
        "{}",
        run.err
    );
    for option in ["--zone X", "--vtu-rows floor", "--calculix 2.20"] {
        let line = format!("form-factors glazed.obj -o g.npz {option}");
        folder.fails(&line, 2, "g.npz is not one");
    }
}

/// Formulas reach the tolerance that is asked for.
#[test]
fn tolerance_reaches_rounding() {
    let folder = cube();
    folder.ok(
        "form-factors cube.obj -o f.csv --patches 200 --by object --tolerance 1e-12 --closure=never",
    );
    let list = text(&folder, "f.csv");
    let opposite = conductance(&list, "floor", "lid");
    assert!((opposite / OPPOSITE - 1.0).abs() < 2e-11, "{opposite}");
    let run = folder.ok("form-factors cube.obj -o f.csv --rays 64 --tolerance 1e-6");
    assert!(run.err.contains("--tolerance has no effect"), "{}", run.err);
    folder.fails(
        "form-factors cube.obj -o f.csv --tolerance 2",
        2,
        "1e-12 to 0.01",
    );
}
