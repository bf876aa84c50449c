//! View3D's files through the command line. Numbers are those that View3D 4.0.0 printed.

use crate::support::{Folder, project};

/// Two unit squares that face each other, the upper one in two parts.
const SQUARES: &str = "\
T two facing unit squares, upper one split and recombined
C eps=1e-5 out=0
F 3
V 1 0 0 0
V 2 1 0 0
V 3 1 1 0
V 4 0 1 0
V 5 0 0 1
V 6 1 0 1
V 7 1 1 1
V 8 0 1 1
V 9 .5 0 1
V 10 .5 1 1
S 1 1 2 3 4  0 0 0.5 low
S 2 5 8 10 9 0 0 0.8 upA
S 3 9 10 7 6 0 2 0.8 upB
End of data
";

/// The same with something of 0.5 × 0.5 in the middle of the lower square.
fn with_middle(kind: &str, corners: &str) -> String {
    format!(
        "F 3\nV 1 0 0 0\nV 2 1 0 0\nV 3 1 1 0\nV 4 0 1 0\n\
         V 5 0 0 1\nV 6 1 0 1\nV 7 1 1 1\nV 8 0 1 1\n\
         V 9 .25 .25 0\nV 10 .75 .25 0\nV 11 .75 .75 0\nV 12 .25 .75 0\n\
         S 1 1 2 3 4 0 0 .5 low\nS 2 5 8 7 6 0 0 .5 up\n\
         {kind} 3 {corners} 1 0 .5 middle\nEnd\n"
    )
}

/// The lines of a matrix in text behind its header.
fn matrix(folder: &Folder, line: &str) -> Vec<String> {
    folder.ok(line);
    let text = String::from_utf8(folder.read("f.txt")).unwrap();
    let lines = text.lines().skip(1);
    lines.map(str::to_owned).collect()
}

fn check(input: &str, expected: &[&str]) {
    let folder = Folder::new();
    folder.write("a.vs3", input);
    assert_eq!(matrix(&folder, "form-factors a.vs3 -o f.txt"), expected);
}

#[test]
fn combined_parts_are_one_row_to_the_printed_digits() {
    let folder = Folder::new();
    folder.write("a.vs3", SQUARES);
    folder.ok("form-factors a.vs3 -o f.txt");
    let expected = "View3D 4.0.0 0 0 0 2          \n1 1\n0.000000 0.199825\n\
                    0.199825 0.000000\n0.500 0.800\n";
    assert_eq!(String::from_utf8(folder.read("f.txt")).unwrap(), expected);
    // `.vf` is what the file says; `-` and any name are what --format says.
    folder.ok("form-factors a.vs3 -o f.vf");
    assert_eq!(folder.read("f.vf"), expected.as_bytes());
    let run = folder.ok("form-factors a.vs3 -o - --format view3d");
    assert_eq!(run.out, expected);
}

#[test]
fn binary_is_that_of_view3d() {
    let folder = Folder::new();
    folder.write("a.vs3", SQUARES.replace("out=0", "out=1"));
    folder.ok("form-factors a.vs3 -o f.vf");
    let bytes = folder.read("f.vf");
    assert_eq!(bytes.len(), 64);
    assert_eq!(&bytes[..32], b"View3D 4.0.0 1 0 0 2          \r\n");
    let number = |k: usize| f32::from_le_bytes(bytes[32 + 4 * k..][..4].try_into().unwrap());
    let numbers: Vec<f32> = (0..8).map(number).collect();
    assert_eq!((&numbers[..3], numbers[5]), (&[1.0, 1.0, 0.0][..], 0.0));
    assert!((numbers[3] - 0.199_824_9).abs() < 2e-7 && numbers[3] == numbers[4]);
    assert_eq!(numbers[6..], [0.5, 0.8]);
    folder.ok("form-factors a.vs3 -o f.bin --format view3d-binary");
    assert_eq!(folder.read("f.bin"), bytes);
}

#[test]
fn a_base_is_what_its_subsurfaces_leave() {
    check(
        &with_middle("S", "9 10 11 12"),
        &[
            "0.75 1 0.25",
            "0.000000 0.190280 0.000000",
            "0.142710 0.000000 0.057115",
            "0.000000 0.228461 0.000000",
            "0.500 0.500 0.500",
        ],
    );
}

#[test]
fn a_mask_sees_its_base_alone() {
    check(
        &with_middle("M", "12 11 10 9"),
        &[
            "1 1 0.25",
            "0.000000 0.142710 0.250000",
            "0.142710 0.000000 0.000000",
            "1.000000 0.000000 0.000000",
            "0.500 0.500 0.500",
        ],
    );
}

#[test]
fn a_null_surface_takes_its_area_away() {
    let expected = [
        "0.75 1",
        "0.000000 0.190280",
        "0.142710 0.000000",
        "0.500 0.500",
    ];
    let input = with_middle("N", "12 11 10 9");
    check(&input, &expected);
}

#[test]
fn obstructions_block_from_both_sides_and_are_no_rows() {
    // A screen half-way that covers all: nothing is seen, whichever way it looks.
    for screen in ["13 14 15 16", "16 15 14 13"] {
        let input = SQUARES.replace(
            "S 1",
            "V 11 -9 -9 .5\nV 12 9 -9 .5\nV 13 9 9 .5\nV 14 -9 9 .5\nS 1",
        );
        let corners: Vec<String> = screen
            .split(' ')
            .map(|n| (n.parse::<u32>().unwrap() - 2).to_string())
            .collect();
        let input = input.replace("End", &format!("O 4 {}\nEnd", corners.join(" ")));
        check(
            &input,
            &[
                "1 1",
                "0.000000 0.000000",
                "0.000000 0.000000",
                "0.500 0.800",
            ],
        );
    }
}

#[test]
fn backs_do_not_radiate() {
    let turned = SQUARES.replace("S 1 1 2 3 4", "S 1 4 3 2 1");
    check(
        &turned,
        &[
            "1 1",
            "0.000000 0.000000",
            "0.000000 0.000000",
            "0.500 0.800",
        ],
    );
}

#[test]
fn enclosures_are_scaled_and_grey_factors_sum_to_emissivities() {
    let folder = Folder::new();
    std::fs::copy(project().join("examples/box.vs3"), folder.path("box.vs3")).unwrap();
    let report = folder.json("form-factors box.vs3 -o f.txt");
    assert!(
        report["enclosure_sweeps"].as_u64().unwrap() < 100,
        "{report}"
    );
    assert!(report["enclosure_error"].as_f64().unwrap() <= 1e-7);
    assert!(report["enclosure_moved"].as_f64().unwrap() < 0.01);
    let text = String::from_utf8(folder.read("f.txt")).unwrap();
    assert!(text.starts_with("View3D 4.0.0 0 1 0 10 "), "{text}");
    let rows = |text: &str| -> Vec<Vec<f64>> {
        let numbers = |line: &str| line.split(' ').map(|w| w.parse().unwrap()).collect();
        text.lines().skip(1).map(numbers).collect()
    };
    let numbers = rows(&text);
    assert_eq!(
        numbers[0],
        [11.4, 12.0, 7.6, 2.4, 8.0, 7.5, 6.3, 3.8, 1.3, 1.3]
    );
    let sum = |row: &[f64]| row.iter().sum::<f64>();
    assert!(
        numbers[1..11]
            .iter()
            .all(|row| (sum(row) - 1.0).abs() < 2e-5)
    );
    let grey = String::from_utf8(folder.read("box.vs3")).unwrap();
    folder.write("grey.vs3", grey.replace("encl=1", "encl=1 emit=1"));
    let report = folder.json("form-factors grey.vs3 -o f.txt");
    assert!(
        report["grey_enclosure_sweeps"].as_u64().unwrap() <= 30,
        "{report}"
    );
    let text = String::from_utf8(folder.read("f.txt")).unwrap();
    assert!(text.starts_with("View3D 4.0.0 0 1 1 10 "), "{text}");
    let numbers = rows(&text);
    for (row, emissivity) in numbers[1..11].iter().zip(&numbers[11]) {
        assert!((sum(row) - emissivity).abs() < 2e-5, "{row:?}");
    }
}

#[test]
fn one_row_or_entry_is_said() {
    let folder = Folder::new();
    folder.write("a.vs3", SQUARES.replace("out=0", "row=2 col=1"));
    let run = folder.ok("form-factors a.vs3 -o f.csv");
    assert!(run.err.contains("F from 2 to 1"), "{}", run.err);
    assert!(run.err.contains("0.199825"), "{}", run.err);
    folder.write("a.vs3", SQUARES.replace("out=0", "row=3"));
    folder.fails(
        "form-factors a.vs3 -o f.csv",
        1,
        "row=3 on a control line: expected a number up to 2",
    );
}

#[test]
fn rows_keep_their_names_in_other_files() {
    let folder = Folder::new();
    folder.write(
        "a.vs3",
        SQUARES.replace("eps=1e-5", "eps=1e-5 maxU=6, list=2"),
    );
    let run = folder.ok("form-factors a.vs3 -o f.csv");
    assert!(run.err.contains("without effect here"), "{}", run.err);
    assert!(run.err.contains("maxU=6, list=2"), "{}", run.err);
    let table = String::from_utf8(folder.read("f.csv")).unwrap();
    assert!(
        table.contains("low") && table.contains("upA") && !table.contains("upB"),
        "{table}"
    );
    folder.ok("form-factors a.vs3 -o f.npz");
    assert!(folder.read("f.npz").starts_with(b"PK"));
}

#[test]
fn any_model_goes_to_view3d_and_comes_back() {
    let folder = Folder::with_room();
    folder.ok("convert room.obj -o room.vs3");
    let report = folder.json("info room.vs3");
    assert_eq!(report["format"], "View3D", "{report}");
    folder.ok("form-factors room.vs3 -o f.txt --rays 1024");
    let direct = matrix(
        &folder,
        "form-factors room.obj -o f.txt --patch-size 0 --rays 1024",
    );
    assert_eq!(direct.len(), 9);
    let emissivities = "0.400 0.400 0.400 0.400 0.400 0.400 0.999";
    folder.ok("form-factors room.vs3 -o f.txt --rays 1024");
    let again = String::from_utf8(folder.read("f.txt")).unwrap();
    assert_eq!(again.lines().last(), Some(emissivities));
    assert_eq!(again.lines().nth(1), direct.first().map(String::as_str));
}

#[test]
fn what_makes_no_sense_is_said() {
    let folder = Folder::new();
    folder.write("a.vs3", SQUARES);
    folder.fails("form-factors a.vs3 -o f.txt --two-sided", 2, "one-sided");
    folder.fails("form-factors a.vs3 -o f.txt --by object", 2, "cmb");
    folder.fails("form-factors a.vs3 -o f.txt --cluster 2", 2, "cmb");
    folder.fails("form-factors a.vs3 -o f.xyz", 2, ".txt");
    let run = folder.ok("form-factors a.vs3 -o - --patches 4 --rays 16");
    assert!(run.err.contains("rows are patches"), "{}", run.err);
    folder.write("b.vs3", SQUARES.replace("S 2 5 8", "S 2 5 99"));
    folder.fails("form-factors b.vs3 -o f.txt", 1, "b.vs3:15:7: found \"99\"");
    assert_eq!(folder.names(), ["a.vs3", "b.vs3"]);
}
