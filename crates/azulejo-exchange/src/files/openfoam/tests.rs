//! Files of a case, and patches of a boundary.

use super::*;
use crate::files::FactorFormat;
use crate::files::tests::{cube, files, rows};
use proptest::prelude::*;

const BOUNDARY: &str = "\
/*---------*- C++ -*----------*\\
|  \\\\    /   O peration     | Version:  v1912                                 |
\\*--------------*/
FoamFile
{
    version     2.0;
    format      ascii;
    class       polyBoundaryMesh;
    location    \"constant/polyMesh\";
    object      boundary;
}
// * * * //

3
(
    cold
    {
        type            wall;
        inGroups        2(wall viewFactorWall);
        nFaces          1;
        startFace       4;
    }
    hot
    {
        type            wall;
        inGroups        List<word> 1(viewFactorWall);
        nFaces          1;
        startFace       5;
        extra { deep { a 1; } b (1 2); }
    }
    sides
    {
        type            patch;
        nFaces          4;
        startFace       6;
    }
)
";

fn patch(name: &str, faces: usize, groups: &[&str]) -> BoundaryPatch {
    BoundaryPatch {
        name: name.into(),
        faces,
        start_face: 0,
        groups: groups.iter().map(|g| (*g).to_owned()).collect(),
    }
}

fn case(version: OpenFoamVersion) -> FileOptions {
    let mut patches = read_boundary(BOUNDARY.as_bytes(), "boundary").unwrap();
    patches.iter_mut().for_each(|p| p.start_face = 0);
    FileOptions {
        case: Some(OpenFoamCase {
            folder: "room/constant".into(),
            patches,
            version,
        }),
        ..FileOptions::default()
    }
}

#[test]
fn patches_are_read() {
    let patches = read_boundary(BOUNDARY.as_bytes(), "boundary").unwrap();
    let mut expected = [
        patch("cold", 1, &["wall", "viewFactorWall"]),
        patch("hot", 1, &["viewFactorWall"]),
        patch("sides", 4, &[]),
    ];
    (4..).zip(&mut expected).for_each(|(k, p)| p.start_face = k);
    assert_eq!(patches, expected);
    assert_eq!(read_boundary(b"()", "b").unwrap(), []);
    let quoted = read_boundary(b"1(\"a b\"{nFaces 2;})", "b").unwrap();
    assert_eq!(quoted, [patch("a b", 2, &[])]);
}

#[test]
fn damage_is_reported_with_its_place() {
    for (text, expected) in [
        (
            "",
            "b:1:1: found the end of the file, expected a list of patches",
        ),
        (
            "3 {",
            "b:1:3: found {, expected ( at the begin of the patches",
        ),
        (
            "1(\na\n{ nFaces x; })",
            "b:3:10: found x;, expected a number",
        ),
        (
            "1(a { type wall; })",
            "b:1:18: found }), expected nFaces in the patch before",
        ),
        (
            "1(a { nFaces 1; )",
            "b:1:17: found ), expected an entry or }",
        ),
        ("1(a { x 1 } )", "b:1:11: found }, expected ;"),
        ("1(;", "b:1:3: found ;, expected the name of a patch"),
    ] {
        let error = read_boundary(text.as_bytes(), "b").unwrap_err().to_string();
        assert!(error.starts_with(expected), "{error}\nexpected {expected}");
    }
    let error = read_boundary(&[0x1f, 0x8b], "b").unwrap_err().to_string();
    assert!(error.contains("unpack .gz"), "{error}");
}

#[test]
fn no_part_of_a_file_is_one() {
    let end = BOUNDARY.rfind(')').unwrap();
    for length in 0..=end {
        assert!(
            read_boundary(&BOUNDARY.as_bytes()[..length], "b").is_err(),
            "{length}"
        );
    }
}

proptest! {
    #[test]
    fn nothing_panics(text in "[ a-z0-9{}();\"/*\n\\\\é]{0,60}") {
        let _ = read_boundary(text.as_bytes(), "b");
        let _ = read_boundary(format!("1(a {{nFaces 1; {text}").as_bytes(), "b");
    }
}

#[test]
fn versions() {
    for (word, expected) in [
        ("v1912", Some(OpenFoamVersion::V1912)),
        ("1912.200506", Some(OpenFoamVersion::V1912)),
        ("v2312", Some(OpenFoamVersion::V2312)),
        ("v2412", Some(OpenFoamVersion::V2312)),
        ("10", Some(OpenFoamVersion::Org)),
        ("org", Some(OpenFoamVersion::Org)),
        ("v2112", None),
        ("new", None),
    ] {
        assert_eq!(OpenFoamVersion::from_word(word), expected, "{word}");
    }
}

#[test]
fn cases_are_opened_with_their_version() {
    let folder = std::env::temp_dir().join(format!("azulejo-case-{}", std::process::id()));
    let mesh = folder.join("constant/polyMesh");
    std::fs::create_dir_all(&mesh).unwrap();
    let none = OpenFoamCase::open(&folder, None).unwrap_err().to_string();
    assert!(
        none.contains("found no constant/polyMesh/boundary"),
        "{none}"
    );
    std::fs::write(mesh.join("boundary"), BOUNDARY).unwrap();
    for place in [folder.clone(), folder.join("constant")] {
        let case = OpenFoamCase::open(&place, None).unwrap();
        assert_eq!(case.folder, folder.join("constant"));
        assert_eq!(
            (case.patches.len(), case.version),
            (3, OpenFoamVersion::V1912)
        );
        assert_eq!(case.location(), "constant");
    }
    std::fs::write(mesh.join("boundary"), "1(a{nFaces 1;})").unwrap();
    let unknown = OpenFoamCase::open(&folder, None).unwrap_err().to_string();
    assert!(unknown.contains("v1912 (or earlier), v2312"), "{unknown}");
    let case = OpenFoamCase::open(&folder, Some(OpenFoamVersion::Org)).unwrap();
    assert_eq!(case.version, OpenFoamVersion::Org);
    std::fs::remove_dir_all(folder).unwrap();
}

/// Two plates; the first row is the case's second.
fn plates() -> Enclosure {
    rows(&[1.0, 2.0], &["hot", "cold"], &[(0, 1, 0.2)])
}

fn check(version: OpenFoamVersion, expected: &[(&str, &str, &str)]) {
    let plates = plates();
    let options = case(version);
    let (written, _) = files(&plates, FactorFormat::OpenFoam, &options);
    assert_eq!(written.len(), expected.len());
    for ((name, content), (expected_name, class, body)) in written.iter().zip(expected) {
        let whole = format!(
            "FoamFile\n{{\n    version     2.0;\n    format      ascii;\n    class       {class};\n    \
             location    \"constant\";\n    object      {name};\n}}\n\n{body}\n"
        );
        assert_eq!(name, expected_name);
        assert_eq!(std::str::from_utf8(content).unwrap(), whole);
    }
}

const F: (&str, &str, &str) = ("F", "scalarListList", "2\n(\n1(0.1)\n1(0.2)\n)");
const FACES: (&str, &str, &str) = ("globalFaceFaces", "labelListList", "2\n(\n1(1)\n1(0)\n)");
const AGGLOM: (&str, &str, &str) = (
    "finalAgglom",
    "labelListList",
    "3\n(\n1(0)\n1(0)\n4(0 1 2 3)\n)",
);
const MAP: &str = "1\n(\n2(0 1)\n)";

#[test]
fn files_of_both_companies() {
    let map = format!("2\n{MAP}\n{MAP}\n0 0\n0()\n0()");
    check(
        OpenFoamVersion::V1912,
        &[F, FACES, AGGLOM, ("mapDist", "mapDistribute", &map)],
    );
    let map = format!("2\n{MAP}\n{MAP}\n0 0 0\n0()\n0()");
    check(
        OpenFoamVersion::V2312,
        &[F, FACES, AGGLOM, ("mapDist", "mapDistribute", &map)],
    );
    check(
        OpenFoamVersion::Org,
        &[
            F,
            FACES,
            AGGLOM,
            ("subMap", "labelListList", MAP),
            ("constructMap", "labelListList", MAP),
            ("constructMapDim", "labelList", "1(2)"),
        ],
    );
}

#[test]
fn binary_files_byte_by_byte() {
    // The second row sees nothing.
    let lonely = rows(&[1.0, 2.0], &["hot", "cold"], &[(0, 0, 0.25)]);
    let options = case(OpenFoamVersion::V1912);
    let (written, _) = files(&lonely, FactorFormat::OpenFoamBinary, &options);
    let body = |k: usize| {
        let content = &written[k].1;
        let start = content.windows(3).position(|w| w == b"}\n\n").unwrap() + 3;
        let header = std::str::from_utf8(&content[..start]).unwrap();
        (
            header.contains("binary;\n    arch        \"LSB;label=32;scalar=64\";"),
            &content[start..],
        )
    };
    let expected = [b"2\n(\n0\n1\n(", &0.25f64.to_le_bytes()[..], b")\n)\n"].concat();
    assert_eq!(body(0), (true, &expected[..]));
    assert_eq!(body(1), (true, &b"2\n(\n0\n1\n(\x01\0\0\0)\n)\n"[..]));
    let expected =
        b"3\n(\n1\n(\0\0\0\0)\n1\n(\0\0\0\0)\n4\n(\0\0\0\0\x01\0\0\0\x02\0\0\0\x03\0\0\0)\n)\n";
    assert_eq!(body(2), (true, &expected[..]));
    assert!(!body(3).0, "the map is text");
}

#[test]
fn rows_may_be_whole_patches_of_many_faces() {
    let mut enclosure = plates();
    enclosure.rows.are_groups = true;
    enclosure.rows.names = vec!["hot".into(), "cold".into()];
    let mut options = case(OpenFoamVersion::V1912);
    let case = options.case.as_mut().unwrap();
    case.patches[0].faces = 3;
    let (written, _) = files(&enclosure, FactorFormat::OpenFoam, &options);
    let text = String::from_utf8_lossy(&written[2].1).into_owned();
    assert!(
        text.ends_with("3\n(\n3(0 0 0)\n1(0)\n4(0 1 2 3)\n)\n"),
        "{text}"
    );
}

#[test]
fn faces_of_patches_are_rows_in_any_order() {
    let mut enclosure = cube();
    // Four faces of one patch and two of another, the last face first.
    enclosure.rows.objects = vec!["walls".into(), "ends".into()];
    for (k, face) in enclosure.factors.faces.iter_mut().enumerate() {
        face.object = u32::from(k < 2);
        face.face = (if k < 2 { 1 - k } else { 5 - k }) as u32;
    }
    let patches = vec![
        patch("ends", 2, &["viewFactorWall"]),
        patch("walls", 4, &["viewFactorWall"]),
    ];
    let case = OpenFoamCase {
        folder: "constant/air".into(),
        patches,
        version: OpenFoamVersion::V2312,
    };
    assert_eq!(case.location(), "constant/air");
    let rows = CaseRows::new(&enclosure, &case).unwrap();
    assert_eq!(rows.rows, [1, 0, 5, 4, 3, 2]);
    assert_eq!(rows.agglomeration, [vec![0, 1], vec![0, 1, 2, 3]]);
    assert_eq!(rows.taking_part, ["ends", "walls"]);
}

fn refusal(enclosure: &Enclosure, options: &FileOptions) -> String {
    let prepared = FactorFormat::OpenFoam.prepare(enclosure, options);
    prepared.err().expect("is refused").to_string()
}

#[test]
fn rows_that_are_not_the_faces_are_refused_with_both_counts() {
    let options = case(OpenFoamVersion::V1912);
    let three = rows(&[1.0; 3], &["hot", "cold", "lamp"], &[]);
    let message = refusal(&three, &options);
    assert!(
        message.contains("found 3 rows, 2 of them faces"),
        "{message}"
    );
    assert!(
        message.contains("(cold, hot), expected all 2 faces"),
        "{message}"
    );
    let one = rows(&[1.0], &["hot"], &[]);
    let message = refusal(&one, &options);
    assert!(
        message.contains("found 1 rows, 1 of them faces"),
        "{message}"
    );
    let mut twice = plates();
    twice.factors.faces[1] = twice.factors.faces[0];
    let message = refusal(&twice, &options);
    assert!(
        message.contains("several rows of face 0 of hot"),
        "{message}"
    );
    let mut back = plates();
    back.factors.is_back[0] = true;
    let message = refusal(&back, &options);
    assert!(message.contains("back sides"), "{message}");
    let mut none = options.clone();
    none.case
        .as_mut()
        .unwrap()
        .patches
        .iter_mut()
        .for_each(|p| p.groups.clear());
    let message = refusal(&plates(), &none);
    assert!(
        message.contains("found no patch with inGroups (viewFactorWall)"),
        "{message}"
    );
    let message = refusal(&plates(), &FileOptions::default());
    assert!(message.contains("no case"), "{message}");
}

#[test]
fn patches_that_take_no_part_have_no_rows() {
    let pairs = [(0, 1, 0.5), (0, 2, 0.25), (1, 2, 0.25)];
    let three = rows(&[1.0; 3], &["sides", "hot", "cold"], &pairs);
    let options = case(OpenFoamVersion::V1912);
    let (written, notes) = files(&three, FactorFormat::OpenFoam, &options);
    let f = String::from_utf8_lossy(&written[0].1).into_owned();
    assert!(f.ends_with("2\n(\n1(0.25)\n1(0.25)\n)\n"), "{f}");
    let expected = "without rows, as they take no part: sides; row sums are down to 0.25";
    assert!(notes.iter().any(|n| n == expected), "{notes:?}");
}

#[test]
fn bent_rows_and_openings() {
    let bent = rows(&[1.0, 2.0], &["hot", "cold"], &[(0, 0, 0.25)]);
    let message = refusal(&bent, &case(OpenFoamVersion::V2312));
    assert!(
        message.contains("found 1 of 2 rows that see themselves, with a factor of up to 0.25"),
        "{message}"
    );
    let mut open = bent;
    open.factors.rest[1].sky = 1.0;
    let (_, notes) = files(&open, FactorFormat::OpenFoam, &case(OpenFoamVersion::V1912));
    assert!(notes[0].starts_with("1 of 2 rows lose light to sky or ground, at most 100% (cold/0)"));
    assert!(notes[1].starts_with("for serial runs"));
}

/// A cube whose faces are two patches, and three rows: one of a whole patch, two of the other.
fn clusters() -> (Enclosure, OpenFoamCase) {
    let mut enclosure = cube();
    enclosure.rows.objects = vec!["walls".into(), "ends".into()];
    for (k, face) in enclosure.factors.faces.iter_mut().enumerate() {
        face.object = u32::from(k < 2);
        face.face = (if k < 2 { 1 - k } else { k - 2 }) as u32;
    }
    let groups = crate::Groups {
        of_rows: [0, 0, 1, 2, 2, 1].map(Some).to_vec(),
        names: ["ends/0", "walls/0", "walls/1"].map(str::to_owned).to_vec(),
    };
    let patches = vec![
        patch("walls", 4, &["viewFactorWall"]),
        patch("ends", 2, &["viewFactorWall"]),
    ];
    let case = OpenFoamCase {
        folder: "constant".into(),
        patches,
        version: OpenFoamVersion::V1912,
    };
    (enclosure.grouped(&groups), case)
}

#[test]
fn clusters_are_numbered_by_first_appearance() {
    let (mut enclosure, case) = clusters();
    let rows = CaseRows::new(&enclosure, &case).unwrap();
    assert_eq!(rows.rows, [1, 2, 0]);
    assert_eq!(rows.agglomeration, [vec![0, 1, 1, 0], vec![0, 0]]);
    // The same whatever the order of rows.
    enclosure.rows.grouped_faces.reverse();
    for (_, row) in &mut enclosure.rows.grouped_faces {
        *row = 2 - *row;
    }
    enclosure.factors.faces.reverse();
    let rows = CaseRows::new(&enclosure, &case).unwrap();
    assert_eq!(rows.rows, [1, 0, 2]);
    assert_eq!(rows.agglomeration, [vec![0, 1, 1, 0], vec![0, 0]]);
}

#[test]
fn clusters_of_other_faces_are_refused() {
    let (enclosure, case) = clusters();
    let check = |change: &dyn Fn(&mut Enclosure), expected: &str| {
        let mut other = enclosure.clone();
        change(&mut other);
        let error = CaseRows::new(&other, &case).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    };
    let faces = |e: &mut Enclosure, k: usize| e.rows.grouped_faces[k];
    check(
        &|e| e.rows.grouped_faces.truncate(5),
        "found 5 faces in rows, 5 of them faces of the patches that take part (walls, ends), expected all 6",
    );
    check(
        &|e| {
            let (face, row) = faces(e, 0);
            e.rows.grouped_faces.push((face, 3 - row));
        },
        "found several rows of face 0 of walls",
    );
    check(
        &|e| e.rows.grouped_faces[0].1 = 0,
        "found faces of walls and ends in row ends/0, expected rows of one patch",
    );
}
