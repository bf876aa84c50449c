use super::read;
use crate::reader_tests::{check_warnings, mesh, names};
use crate::{Loaded, Memory, Position, ReadError, ReadOptions};
use flate2::{Compression, write::GzEncoder};
use glam::DVec3;
use proptest::prelude::*;
use std::io::Write;

fn try_of(name: &str, bytes: &[u8], files: &Memory) -> Result<Loaded, ReadError> {
    let loaded = read(bytes, name, files, &ReadOptions::default())?;
    loaded.scene.validate().unwrap();
    Ok(loaded)
}

const BANNER: &str = "/*--------*- C++ -*--------*\\\n| v 1 2 3 |\n\\*--------*/\n";

fn header(class: &str, format: &str) -> String {
    format!(
        "{BANNER}FoamFile\n{{\n    version 2.0;\n    format {format};\n    class {class};\n    meta {{ names 1(a); }}\n}}\n// * * //\n\n"
    )
}

fn text_of(class: &str, rest: &str) -> String {
    header(class, "ascii") + rest
}

/// Two cubes side by side along x, with the face between them first.
const POINTS: &str = "12
(
(0 0 0) (1 0 0) (2 0 0) (0 1 0) (1 1 0) (2 1 0)
(0 0 1) (1 0 1) (2 0 1) (0 1 1) (1 1 1) (2 1 1e0)
)
";

const FACES: [[u32; 4]; 11] = [
    [1, 4, 10, 7],
    [0, 6, 9, 3],
    [2, 5, 11, 8],
    [0, 3, 4, 1],
    [1, 4, 5, 2],
    [6, 7, 10, 9],
    [7, 8, 11, 10],
    [0, 1, 7, 6],
    [1, 2, 8, 7],
    [3, 9, 10, 4],
    [4, 10, 11, 5],
];

const BOUNDARY: &str = "5
(
    inlet
    {
        type patch; // one face
        nFaces 1;
        startFace 1;
    }
    outlet { type patch; nFaces 1; startFace 2; physical { a { b (1 2); } } }
    walls
    {
        type            wall;
        inGroups        List<word> 2(wall viewFactorWall);
        nFaces          4;
        startFace       3;
    }
    mirror { type symmetryPlane; inGroups 1(symmetryPlane); nFaces 2; startFace 7; }
    frontAndBack { type empty; nFaces 2; startFace 9; }
)
";

fn faces_text() -> String {
    let faces: String = FACES
        .iter()
        .map(|[a, b, c, d]| format!("4({a} {b} {c} {d})\n"))
        .collect();
    text_of("faceList", &format!("{}\n(\n{faces})\n", FACES.len()))
}

fn boundary_text() -> String {
    text_of("polyBoundaryMesh", BOUNDARY)
}

fn points_text() -> String {
    text_of("vectorField", POINTS)
}

fn folder() -> Memory {
    Memory::new()
        .with("boundary", boundary_text())
        .with("faces", faces_text())
        .with("points", points_text())
}

#[test]
fn patches_are_objects() {
    let loaded = try_of("a/boundary", boundary_text().as_bytes(), &folder()).unwrap();
    assert_eq!(names(&loaded), ["inlet", "outlet", "walls", "mirror"]);
    assert_eq!(loaded.scene.units.metres_per_unit, Some(1.0));
    // They look into the fluid, and so the inlet at x = 0 along x.
    assert_eq!(mesh(&loaded, 0).face_area_vector(0), DVec3::X);
    assert_eq!(mesh(&loaded, 1).face_area_vector(0), -DVec3::X);
    assert_eq!(mesh(&loaded, 0).positions[0], DVec3::ZERO);
    assert_eq!(mesh(&loaded, 2).faces.len(), 4);
    check_warnings(
        &loaded,
        &[
            "a/boundary:29:5: patch of type symmetryPlane: read as a surface like any other",
            "a/boundary:30:5: patch of type empty: skipped, so that light leaves; a flat case goes on with --periodic y",
        ],
    );
}

#[test]
fn any_file_of_the_mesh_will_do() {
    let files = folder().with("owner", "");
    let expected = try_of("boundary", boundary_text().as_bytes(), &files)
        .unwrap()
        .scene;
    for (name, text) in [
        ("faces", faces_text()),
        ("points", points_text()),
        ("owner", text_of("labelList", "1(0)")),
    ] {
        let loaded = try_of(name, text.as_bytes(), &files).unwrap();
        assert_eq!(loaded.scene, expected, "{name}");
    }
    let case = Memory::new()
        .with("constant/polyMesh/boundary", boundary_text())
        .with(
            "constant/polyMesh/faces.gz",
            packed(faces_text().as_bytes()),
        )
        .with("constant/polyMesh/points", points_text());
    let loaded = crate::read(b"", "case/case.foam", &case).unwrap();
    assert_eq!(loaded.scene.objects, expected.objects);
    let of_boundary = crate::read(&packed(boundary_text().as_bytes()), "boundary.gz", &files);
    assert_eq!(of_boundary.unwrap().scene.objects, expected.objects);
}

fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut packer = GzEncoder::new(Vec::new(), Compression::fast());
    packer.write_all(bytes).unwrap();
    packer.finish().unwrap()
}

/// How numbers are stored.
#[derive(Clone, Copy)]
struct Layout {
    label: usize,
    scalar: usize,
    is_big: bool,
}

impl Layout {
    fn header(self, class: &str) -> Vec<u8> {
        let order = if self.is_big { "MSB" } else { "LSB" };
        let (label, scalar) = (8 * self.label, 8 * self.scalar);
        let arch = format!("binary;\n    arch \"{order};label={label};scalar={scalar}\"");
        header(class, &arch).into_bytes()
    }

    fn put(self, out: &mut Vec<u8>, mut little: Vec<u8>) {
        if self.is_big {
            little.reverse();
        }
        out.extend(little);
    }

    fn put_label(self, out: &mut Vec<u8>, label: i64) {
        self.put(out, label.to_le_bytes()[..self.label].to_vec());
    }

    fn put_labels(self, out: &mut Vec<u8>, labels: &[i64]) {
        out.extend(format!("\n{}\n(", labels.len()).bytes());
        labels.iter().for_each(|&l| self.put_label(out, l));
        out.push(b')');
    }

    fn points(self) -> Vec<u8> {
        self.points_at(0.0)
    }

    /// The same, moved by `at` along each axis.
    fn points_at(self, at: f64) -> Vec<u8> {
        let mut out = self.header("vectorField");
        let numbers = POINTS.split(|c: char| c.is_whitespace() || "()".contains(c));
        let numbers: Vec<f64> = numbers.filter_map(|n| n.parse().ok()).collect();
        out.extend(b"12\n(");
        for number in numbers[1..].iter().map(|n| n + at) {
            match self.scalar {
                4 => self.put(&mut out, (number as f32).to_le_bytes().to_vec()),
                _ => self.put(&mut out, number.to_le_bytes().to_vec()),
            }
        }
        out.extend(b")\n\n// * * //\n");
        out
    }

    fn compact_faces(self) -> Vec<u8> {
        let mut out = self.header("faceCompactList");
        let starts: Vec<i64> = (0..=FACES.len() as i64).map(|k| 4 * k).collect();
        let labels: Vec<i64> = FACES.as_flattened().iter().map(|&l| l.into()).collect();
        self.put_labels(&mut out, &starts);
        self.put_labels(&mut out, &labels);
        out
    }

    fn faces(self) -> Vec<u8> {
        let mut out = self.header("faceList");
        out.extend(format!("{}\n(", FACES.len()).bytes());
        for face in FACES {
            self.put_labels(&mut out, &face.map(i64::from));
        }
        out.push(b')');
        out
    }
}

#[test]
fn singles_far_from_the_origin_are_coarse() {
    for (scalar, expected) in [(8, 0), (4, 1)] {
        let layout = Layout {
            label: 4,
            scalar,
            is_big: false,
        };
        let files = Memory::new()
            .with("faces", layout.faces())
            .with("points", layout.points_at(5_400_000.0));
        let boundary = [layout.header("polyBoundaryMesh"), BOUNDARY.into()].concat();
        let loaded = try_of("boundary", &boundary, &files).unwrap();
        let coarse = loaded.warnings.iter().filter(|w| {
            w.message
                .starts_with("coordinates as float32 at 5400000 m are 0.5 m apart")
        });
        assert_eq!(coarse.count(), expected, "{:?}", loaded.warnings);
    }
}

#[test]
fn binary_of_every_width() {
    let expected = try_of("boundary", boundary_text().as_bytes(), &folder())
        .unwrap()
        .scene;
    for (label, scalar, is_big) in [
        (4, 8, false),
        (8, 8, false),
        (4, 4, false),
        (8, 4, true),
        (4, 8, true),
    ] {
        let layout = Layout {
            label,
            scalar,
            is_big,
        };
        for faces in [layout.compact_faces(), layout.faces()] {
            let files = Memory::new()
                .with("faces", faces)
                .with("points", layout.points());
            let boundary = [layout.header("polyBoundaryMesh"), BOUNDARY.into()].concat();
            let loaded = try_of("boundary", &boundary, &files).unwrap();
            assert_eq!(loaded.scene, expected, "{label} {scalar} {is_big}");
        }
    }
    let labels: Vec<String> = FACES.as_flattened().iter().map(u32::to_string).collect();
    let starts: Vec<String> = (0..=11).map(|k| (4 * k).to_string()).collect();
    let compact = format!("12({})\n44({})", starts.join(" "), labels.join("\n"));
    let files = folder().with("faces", text_of("faceCompactList", &compact));
    let loaded = try_of("boundary", boundary_text().as_bytes(), &files).unwrap();
    assert_eq!(loaded.scene, expected);
}

fn check_error(name: &str, text: String, expected: &str) {
    let files = folder().with(name, text.clone());
    let error = try_of(name, text.as_bytes(), &files)
        .unwrap_err()
        .to_string();
    assert_eq!(error.lines().next(), Some(expected));
}

#[test]
fn errors_have_positions() {
    let boundary =
        |from: &str, to: &str| text_of("polyBoundaryMesh", &BOUNDARY.replacen(from, to, 1));
    check_error(
        "boundary",
        boundary("nFaces 1;", "nFaces one;"),
        "boundary:18:16: found \"one\", expected a whole number",
    );
    check_error(
        "boundary",
        boundary("startFace 2;", "startFace 1;"),
        "boundary:21:5: found patch \"outlet\" starting at face 1, expected one starting at face 2, right after the patch before it",
    );
    check_error(
        "boundary",
        boundary("nFaces 2; startFace 9;", "nFaces 3; startFace 9;"),
        "boundary:30:5: found patch \"frontAndBack\" up to face 12, expected at most the 11 faces of faces",
    );
    check_error(
        "boundary",
        boundary("startFace 1;", ""),
        "boundary:15:5: found patch \"inlet\" without its faces, expected nFaces and startFace",
    );
    check_error(
        "boundary",
        text_of("polyBoundaryMesh", "1 ( a { type wall;"),
        "boundary:13:19: found the end of the file, expected \"}\"",
    );
    check_error(
        "points",
        text_of("vectorField", "1((0 x 0))"),
        "points:13:6: found \"x\", expected a number",
    );
    check_error(
        "faces",
        text_of("faceList", "2(3(0 1 2) 3(0 1))"),
        "faces:13:17: found \")\", expected a whole number",
    );
    check_error(
        "faces",
        text_of("faceCompactList", "3(0 3 99) 3(0 1 2)"),
        "faces:13:10: found face 1, whose corners are not among the labels, expected 3 labels, in ascending order",
    );
    check_error(
        "U",
        text_of("volVectorField", ""),
        "U: found a file of OpenFOAM with the class \"volVectorField\", expected boundary, faces or points of a folder polyMesh",
    );
    let alone = try_of("boundary", boundary_text().as_bytes(), &Memory::new()).unwrap_err();
    assert_eq!(
        alone.to_string(),
        "faces: found no file (there is no such file), expected boundary, faces and points of OpenFOAM in one folder"
    );
    let layout = Layout {
        label: 4,
        scalar: 8,
        is_big: false,
    };
    let cut = layout.points();
    let files = folder().with("points", &cut[..cut.len() - 40]);
    let error = try_of("boundary", boundary_text().as_bytes(), &files).unwrap_err();
    assert!(
        matches!(error.position, Position::Byte(_)) && error.file == "points",
        "{error}"
    );
}

/// A count that the file has no bytes for, equal numbers without end, and points that do not exist.
#[test]
fn counts_reserve_nothing() {
    for faces in [
        "999999999999(",
        "999999999999{0} 1(0)",
        "99999999999999999999(",
    ] {
        let files = folder().with("faces", text_of("faceCompactList", faces));
        assert!(
            try_of("boundary", boundary_text().as_bytes(), &files).is_err(),
            "{faces}"
        );
    }
    let starts = "12(0 1000000000 2000000000 3000000000 4000000000 4 4 4 4 4 4 4)";
    let faces = text_of("faceCompactList", &format!("{starts} 5000000000{{1}}"));
    let files = folder().with("faces", faces);
    assert!(try_of("boundary", boundary_text().as_bytes(), &files).is_err());
    let layout = Layout {
        label: 8,
        scalar: 8,
        is_big: false,
    };
    let mut raw = layout.header("vectorField");
    raw.extend(b"9223372036854775807\n(");
    let files = folder().with("points", raw);
    assert!(try_of("boundary", boundary_text().as_bytes(), &files).is_err());
    let files = folder().with("faces", faces_text().replace("4(0 6 9 3)", "4(0 6 99 3)"));
    let loaded = try_of("boundary", boundary_text().as_bytes(), &files).unwrap();
    assert!(
        loaded
            .warnings
            .iter()
            .any(|w| w.message == "face with a corner that does not exist: skipped")
    );
}

#[test]
fn damaged_files_are_no_danger() {
    let layout = Layout {
        label: 4,
        scalar: 8,
        is_big: false,
    };
    let of = |name: &str, bytes: &[u8]| {
        for end in 0..bytes.len() {
            let files = folder().with(name, &bytes[..end]);
            let _ = read(
                boundary_text().as_bytes(),
                "boundary",
                &files,
                &ReadOptions::default(),
            );
        }
    };
    of("points", &layout.points());
    of("faces", &layout.compact_faces());
    of("faces", faces_text().as_bytes());
    let boundary = boundary_text();
    for end in 0..boundary.len() {
        let _ = read(
            &boundary.as_bytes()[..end],
            "boundary",
            &folder(),
            &ReadOptions::default(),
        );
    }
}

proptest! {
    /// A byte of a binary file that is another one.
    #[test]
    fn changed_bytes_are_read_or_refused(at in any::<prop::sample::Index>(), byte in any::<u8>(), of_points in any::<bool>()) {
        let layout = Layout { label: 4, scalar: 4, is_big: false };
        let (name, mut bytes) = if of_points {
            ("points", layout.points())
        } else {
            ("faces", layout.compact_faces())
        };
        let at = at.index(bytes.len());
        bytes[at] = byte;
        let files = folder().with(name, bytes);
        if let Ok(loaded) = read(boundary_text().as_bytes(), "boundary", &files, &ReadOptions::default()) {
            prop_assert!(loaded.scene.validate().is_ok());
        }
    }
}
