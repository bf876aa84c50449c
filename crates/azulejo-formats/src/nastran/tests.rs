use super::read;
use crate::reader_tests::{check_warnings, mesh, names};
use crate::{Loaded, Memory, ReadError, ReadOptions};
use azulejo_scene::Up;
use glam::DVec3;
use proptest::prelude::*;

fn try_with(text: &str, files: &Memory) -> Result<Loaded, ReadError> {
    let loaded = read(text.as_bytes(), "a.bdf", files, &ReadOptions::default())?;
    loaded.scene.validate().unwrap();
    Ok(loaded)
}

fn load(text: &str) -> Loaded {
    try_with(text, &Memory::new()).unwrap()
}

fn check_error(text: &str, expected: &str) {
    let error = try_with(text, &Memory::new()).unwrap_err().to_string();
    assert_eq!(error.lines().next(), Some(expected), "{text}");
}

/// Grid points 1 to 8 at the corners of a unit cube, the lower four first.
fn cube() -> String {
    let square = [(0, 0), (1, 0), (1, 1), (0, 1)];
    let corners = [0, 1].map(|z| square.map(|(x, y)| [x, y, z]));
    let lines = corners.as_flattened().iter().zip(1..);
    lines
        .map(|([x, y, z], k)| format!("GRID,{k},,{x}.,{y}.,{z}.\n"))
        .collect()
}

const PLATES: &str = "SOL 101
CEND
TITLE = GRID,1,,x
BEGIN BULK
$ Elements and Element Properties for region : low plate
PSHELL         1       1      .1
CQUAD4         1       1       1       2       3       4
$HMNAME COMP                   2\"lid\"
CTRIA3*                2               2               1               2*A
*A                     3
CTRIA6  3       2       1       3       4       +
+
GRID           1              0.      0.      0.
GRID           2           1.0+0      0.      0.
GRID*                  3                             1.0             1.0
*                    0.0
GRID,4,,0.,1.,
ENDDATA
GRID,4,,x
";

#[test]
fn shells_by_property() {
    let loaded = load(PLATES);
    check_warnings(
        &loaded,
        &["a.bdf:6:1: card without geometry (the first is PSHELL): skipped"],
    );
    assert_eq!(names(&loaded), ["low plate", "lid"]);
    assert_eq!(loaded.scene.units.up, Up::Z);
    let (plate, lid) = (mesh(&loaded, 0), mesh(&loaded, 1));
    assert_eq!(plate.faces.corners, [0, 1, 2, 3]);
    assert_eq!(plate.face_area_vector(0), DVec3::Z);
    assert_eq!(lid.faces.corners, [0, 1, 2, 0, 2, 3]);
    assert_eq!(lid.positions, plate.positions);
    let spelled = PLATES.replace('\n', "\r\n").to_ascii_lowercase();
    assert_eq!(
        load(&spelled).scene.objects[1].shape,
        loaded.scene.objects[1].shape
    );
    let without_control = PLATES.split_once("BEGIN BULK\n").unwrap().1;
    assert_eq!(load(without_control).scene, loaded.scene);
}

#[test]
fn names_by_every_program() {
    let check = |comment: &str, name: &str| {
        let text = [comment, "\nCTRIA3,1,7,1,2,3\n", &cube()].concat();
        assert_eq!(names(&load(&text)), [name], "{comment}");
    };
    check("", "PID 7");
    let without = "CTRIA3,1,,1,2,3\nCTRIA3,2,,1,3,4\n";
    assert_eq!(names(&load(&[without, &cube()].concat())), ["elements"]);
    check("$HMNAME COMP                   7\"auto part\"", "auto part");
    check(
        "$HMNAME COMP                   1\"plate\" 7 \"shell\" 4",
        "plate",
    );
    check(
        "$HMNAME PROP                   7\"shell\"4\n$HMNAME COMP  7\"plate\"",
        "shell",
    );
    check(
        "$ANSA_NAME_COMMENT;7;PSHELL;top plate;;NO;NO;NO;NO;",
        "top plate",
    );
    check("$ANSA_NAME_COMMENT;7;GRID;corner;;NO;", "PID 7");
    check("$ANSA_NAME;7;PSHELL;~\n$older plate", "older plate");
    check("$ Femap Property 7 : wall", "wall");
    check(
        "$ Femap with NX Nastran Property 7 : wall: inner",
        "wall: inner",
    );
    check("$ Femap Material 7 : steel", "PID 7");
    check("$ Elements and Element Properties for region : r.1", "r.1");
    check("$*  Property: skin", "skin");
    // A name goes to the next property, and no further.
    let others = "$*  Property: bar\nPBAR,3,1\nPARAM,7,1";
    check(others, "PID 7");
    check("$*  Property: skin\nPARAM,3,1\nPSHELL,7,1", "skin");
}

#[test]
fn properties_of_one_name_are_one_object() {
    let text =
        "$ Femap Property 1 : a\n$ Femap Property 2 : a\nCTRIA3,1,1,1,2,3\nCTRIA3,2,2,1,3,4\n";
    let loaded = load(&[text, &cube()].concat());
    assert_eq!(
        (names(&loaded), mesh(&loaded, 0).faces.len()),
        (vec!["a"], 2)
    );
}

#[test]
fn solids_have_a_boundary() {
    let text = "CHEXA,1,1,1,2,3,4,5,6,+A\n+A,7,8\nCTETRA,2,2,1,3,2,9\nGRID,9,,.5,.5,-1.\n";
    let loaded = load(&[text, &cube()].concat());
    assert_eq!(names(&loaded), ["PID 1", "PID 2"]);
    assert_eq!(loaded.warnings.len(), 1);
    assert!(
        loaded.warnings[0]
            .message
            .contains("the 10 faces of their boundary")
    );
    let volume: f64 = [0, 1]
        .map(|k| {
            let mesh = mesh(&loaded, k);
            let faces = (0..mesh.faces.len())
                .map(|f| mesh.face_area_vector(f).dot(mesh.face_positions(f)[0]) / 3.0);
            faces.sum::<f64>()
        })
        .iter()
        .sum();
    assert!((volume - (1.0 + 1.0 / 6.0)).abs() < 1e-12, "{volume}");
    // The tetrahedron has no face in common with the hexahedron: three corners are not four.
    assert_eq!(
        mesh(&loaded, 0).faces.len() + mesh(&loaded, 1).faces.len(),
        10
    );
}

#[test]
fn shells_on_solids_name_their_faces() {
    let text = "CHEXA,1,1,1,2,3,4,5,6,+A\n+A,7,8\nCQUAD4,2,2,5,8,7,6\n$ Femap Property 2 : lid\n";
    let loaded = load(&[text, &cube()].concat());
    assert_eq!(names(&loaded), ["PID 1", "lid"]);
    assert_eq!(mesh(&loaded, 0).faces.len(), 5);
    assert_eq!(mesh(&loaded, 1).face_area_vector(0), DVec3::Z);
}

/// A point of each kind of system, in one that is defined in another, of which the grid points are given in
/// a third.
#[test]
fn coordinate_systems() {
    let text = "CORD2C,1,,1.,0.,0.,1.,0.,1.,+
+,2.,0.,0.
CORD2S,2,1,1.,90.,0.,1.,90.,1.,+
+,2.,90.,0.
CORD1R,3,10,11,12
GRDSET,,1
GRID,10,2,0.,0.,0.
GRID,11,2,1.,0.,0.
GRID,12,2,1.,90.,0.
GRID,1,3,0.,0.,2.
GRID,2,,1.,180.,5.
GRID,3,0,0.,0.,0.
CTRIA3,1,1,1,2,3
";
    let loaded = load(text);
    // System 1 is at (1, 0, 0), system 2 at (1, 1, 0) with x along y; grid point 12 is there one along y.
    let expected = [[1.0, 1.0, 2.0], [0.0, 0.0, 5.0], [0.0; 3]].map(DVec3::from);
    let positions = &mesh(&loaded, 0).positions;
    for (position, expected) in positions.iter().zip(expected) {
        assert!(position.distance(expected) < 1e-12, "{position} {expected}");
    }
}

#[test]
fn systems_without_a_place_are_refused() {
    let grid = "GRID,1,1,0.,0.,0.\n";
    let system = |rest: &str| format!("{grid}CORD2R,1,{rest}\n");
    check_error(
        &system("2,0.,0.,0.,0.,0.,1.\n+,1.,0.,0.\nCORD2R,2,1,0.,0.,0.,0.,0.,1.\n+,1.,0.,0."),
        "a.bdf:2:1: found coordinate system 1, which is defined by itself, expected one that the basic system leads to",
    );
    check_error(
        &[grid, "CORD1R,1,1,2,3\nGRID,2,0,1.\nGRID,3,0,2."].concat(),
        "a.bdf:2:1: found coordinate system 1, which is defined by itself, expected one that the basic system leads to",
    );
    check_error(
        &system("3,0.,0.,0.,0.,0.,1.\n+,1.,0.,0."),
        "a.bdf:2:1: found coordinate system 3, which does not exist, expected one of CORD1R, CORD1C, CORD1S, CORD2R, CORD2C, CORD2S",
    );
    check_error(
        &system(",0.,0.,0.,0.,0.,1.\n+,0.,0.,2."),
        "a.bdf:2:1: found coordinate system 1, whose three points are on one line, expected an origin, a point on its z axis, and one beside that",
    );
    check_error(
        &[grid, "CORD1R,1,4,5,6\n"].concat(),
        "a.bdf:2:1: found coordinate system 1 at grid point 4, which does not exist, expected three grid points",
    );
}

#[test]
fn long_chains_of_systems() {
    let system = |k: u32| {
        let of = if k == 3000 { 0 } else { k + 1 };
        format!("CORD2R,{k},{of},1.,0.,0.,1.,0.,1.\n+,2.,0.,0.\n")
    };
    let systems: String = (1..=3000).map(system).collect();
    let loaded = load(
        &[
            &systems,
            "GRID,1,1\nGRID,2,0\nGRID,3,,,1.\nCTRIA3,1,1,1,2,3\n",
        ]
        .concat(),
    );
    assert_eq!(mesh(&loaded, 0).positions[0], DVec3::new(3000.0, 0.0, 0.0));
}

#[test]
fn surface_elements_for_radiation() {
    let text = "CHEXA,1,1,1,2,3,4,5,6,+A
+A,7,8
CHBDYE,11,1,1,4
CHBDYE,12,1,6,5
CHBDYE,13,1,7,5
CHBDYG,14,,AREA3,4,6
+,1,2,7
CHBDYG,15,,REV,4
CHBDYP,16,1,LINE
CHBDYG,17,,AREA4,,7
+,1,2,3,4
VIEW,4,1,KSHD
VIEW,5,1
VIEW,6,2
RADSET,1,3
";
    let loaded = load(&[text, &cube()].concat());
    assert_eq!(
        names(&loaded),
        ["cavity 1/view 4", "cavity 1/view 5", "view 7"]
    );
    assert_eq!(mesh(&loaded, 0).faces.len(), 2);
    assert_eq!(mesh(&loaded, 0).face_area_vector(0), -DVec3::Z);
    assert_eq!(mesh(&loaded, 1).face_area_vector(0), DVec3::Z);
    assert_eq!(mesh(&loaded, 2).face_area_vector(0), -DVec3::Z);
    check_warnings(
        &loaded,
        &[
            "a.bdf:8:1: CHBDYG that is not a polygon: skipped",
            "a.bdf:9:1: CHBDYP, which is a point, a line or a tube: skipped",
            "a.bdf:12:1: VIEW of surfaces that do not shade, or are not shaded: they do and are",
            "a.bdf: element without radiation, beside elements that have it (CHBDY): skipped",
            "a.bdf:5:1: CHBDYE on a side that is not a face of an element: skipped",
            "a.bdf:6:1: surface element of a cavity that RADSET does not list: skipped",
        ],
    );
}

/// Views of a card for all, and the backs of shells.
#[test]
fn views_may_be_defaults() {
    let text = "BDYOR,,4\nCQUAD4,1,1,1,2,3,4\nCHBDYE,11,1,1\nCHBDYE,12,1,6,5\nCHBDYE,13,1,2\n";
    let loaded = load(&[text, &cube()].concat());
    assert_eq!(names(&loaded), ["view 4", "view 5"]);
    assert_eq!(mesh(&loaded, 0).face_area_vector(0), DVec3::Z);
    assert_eq!(mesh(&loaded, 1).face_area_vector(0), -DVec3::Z);
}

/// Every side of every solid looks outwards.
#[test]
fn sides_of_solids() {
    use super::elements::side;
    use crate::surface::boundary::CellKind::{Hexahedron, Prism, Tetrahedron};
    use crate::surface::finite::FiniteShape;
    let at = [
        [0, 0, 0],
        [1, 0, 0],
        [1, 1, 0],
        [0, 1, 0],
        [0, 0, 1],
        [1, 0, 1],
        [1, 1, 1],
        [0, 1, 1],
    ];
    let cube = at.map(|p| DVec3::from(p.map(f64::from)));
    for (kind, corners, sides) in [
        (Tetrahedron, &[0, 1, 3, 4][..], 4),
        (Prism, &[0, 1, 3, 4, 5, 7], 5),
        (Hexahedron, &[0, 1, 2, 3, 4, 5, 6, 7], 6),
    ] {
        let centre = corners.iter().map(|&c: &usize| cube[c]).sum::<DVec3>() / corners.len() as f64;
        for number in 1..=sides {
            let face = side(FiniteShape::Cell(kind), number).unwrap();
            let face: Vec<DVec3> = face.iter().map(|&k| cube[corners[k]]).collect();
            let area = azulejo_scene::math::area_vector(&face);
            assert!(area.dot(face[0] - centre) > 0.0, "{kind:?} {number}");
        }
        assert_eq!(side(FiniteShape::Cell(kind), sides + 1), None);
    }
}

#[test]
fn files_include_others() {
    let text = "$\nINCLUDE 'parts/\n  grid.bdf'\nINCLUDE \"none.bdf\"\nCTRIA3,1,1,1,2,3\n";
    let files = Memory::new()
        .with(
            "parts/grid.bdf",
            ["include points.bdf $ here\n", "INCLUDE 'points.bdf'\n"].concat(),
        )
        .with("parts/points.bdf", cube());
    let loaded = try_with(text, &files).unwrap();
    assert_eq!(mesh(&loaded, 0).area(), 0.5);
    check_warnings(
        &loaded,
        &[
            "parts/grid.bdf:2:1: file \"points.bdf\", included again: skipped",
            "a.bdf:4:1: included file \"none.bdf\": there is no such file; skipped",
        ],
    );
    let circle = Memory::new()
        .with("b.bdf", "\nINCLUDE 'a.bdf'\n")
        .with("a.bdf", "");
    let error = try_with("INCLUDE 'b.bdf'\n", &circle)
        .unwrap_err()
        .to_string();
    let expected = "b.bdf:2:1: found file \"a.bdf\", which includes itself, expected files that do not include each other";
    assert!(error.starts_with(expected), "{error}");
    assert!(error.ends_with("included from a.bdf:1"), "{error}");
}

#[test]
fn files_are_included_to_some_depth() {
    let file = |k: u32| format!("INCLUDE 'f{}.bdf'\n", k + 1);
    let files = (0..50).fold(Memory::new(), |files, k| {
        files.with(format!("f{k}.bdf"), file(k))
    });
    let error = try_with("INCLUDE 'f0.bdf'\n", &files).unwrap_err();
    assert_eq!(&*error.found, "files included more than 20 deep");
    assert_eq!(error.included_from.len(), 19);
}

#[test]
fn fields_are_checked() {
    check_error(
        "GRID           1            1.x0",
        "a.bdf:1:29: found \"1.x0\", expected a real number",
    );
    check_error(
        "GRID,1,, 0.,zero",
        "a.bdf:1:13: found \"zero\", expected a real number",
    );
    check_error(
        "CQUAD4,1,1,1,2,3",
        "a.bdf:1:1: found CQUAD4 without one, expected the number of a grid point",
    );
    check_error(
        "CHEXA,1,1,1,2,3,4,5,6,+\n+,-7,8",
        "a.bdf:2:3: found \"-7\", expected the number of a grid point",
    );
    check_error(
        "\nGRID,1.,",
        "a.bdf:2:6: found \"1.\", expected the number of a grid point",
    );
}

#[test]
fn what_is_skipped_is_counted() {
    let text = "  ,1,2
CBAR,1,1,1,2
CBAR,2,1,2,3
CTRIA3,1,1,1,2,99
CTRIA3,2,1,1,2,2
GRID,1,,7.
GRID,1,,0.,0.,0.
MAT1,1,2.+9,,.3
=,*(1),=
FORCE,1,1
CTRIA3,3,1,1,2,3,,,,,5
CTETRA,4,1,1,2,3,4,,,+A
+B,,,
";
    let loaded = load(&[text, &cube()].concat());
    check_warnings(
        &loaded,
        &[
            "a.bdf:1:1: continuation without a card: skipped",
            "a.bdf:2:1: element CBAR: skipped (2 times)",
            "a.bdf:7:1: grid point of a number that another one has: skipped (2 times)",
            "a.bdf:8:1: card without geometry (the first is MAT1): skipped (2 times)",
            "a.bdf:9:1: card that repeats others (=): skipped",
            "a.bdf:11:1: fields after the ninth of a line: skipped",
            "a.bdf:13:1: continuation of another name than the line before it expects: taken as its continuation",
            "a.bdf:4:1: element with a grid point that does not exist: skipped",
            "a.bdf: face of the boundary of solids: read, with its front out of them (form-factors --two-sided has rows of the backs, too) (3 times)",
            "a.bdf: face with fewer than three different corners: skipped",
        ],
    );
}

#[test]
fn damaged_files_are_no_danger() {
    let text = [
        PLATES.replace("ENDDATA", "$"),
        cube(),
        "CORD1R,3,1,2,4\nINCLUDE 'b\n".to_owned(),
    ]
    .concat();
    for end in 0..text.len() {
        let _ = read(
            &text.as_bytes()[..end],
            "a.bdf",
            &Memory::new(),
            &ReadOptions::default(),
        );
    }
}

proptest! {
    #[test]
    fn any_text_is_read_or_refused(text in "((GRID|CTRIA3|CORD1R|CORD2S|CHBDYG|CHEXA|VIEW|\\+|\\*|INCLUDE|\\$HMNAME COMP)[*, ]{0,3}([0-9.+\\-\"',* ]{0,40})\n){0,12}") {
        if let Ok(loaded) = read(text.as_bytes(), "a.bdf", &Memory::new(), &ReadOptions::default()) {
            prop_assert!(loaded.scene.validate().is_ok());
        }
    }

    /// The same grid point in fields of every width.
    #[test]
    fn fields_of_every_width_are_the_same(x in -999.0f64..9999.0, y in -9.0f64..9.0) {
        let rest = "GRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nCTRIA3,1,1,1,2,3\n";
        let (x, y) = (format!("{x:.3}"), format!("{y:.5}"));
        let small = format!("GRID    {:>8}{:>8}{x:>8.8}{y:>8.8}\n", 1, "");
        let large = format!("GRID*   {:>16}{:>16}{:>16}{:>16}\n*\n", 1, "", &x[..x.len().min(8)], &y[..y.len().min(8)]);
        let free = format!("GRID,1,,{},{}\n", &x[..x.len().min(8)], &y[..y.len().min(8)]);
        let [small, large, free] = [small, large, free].map(|first| load(&[&first, rest].concat()).scene);
        prop_assert_eq!(&small, &large);
        prop_assert_eq!(&small, &free);
    }
}
