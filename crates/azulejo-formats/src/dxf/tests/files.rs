//! Files: header, encodings, damage, external references, views.

use super::*;
use azulejo_scene::{Up, math};

const FACE: &str = "0 3DFACE; 8 walls; @10 0 0 0; @11 1 0 0; @12 0 1 0;";

#[test]
fn units() {
    let text = file(&[
        ("HEADER", "9 $ACADVER; 1 AC1032; 9 $INSUNITS; 70 4"),
        ("ENTITIES", FACE),
    ]);
    let units = load(text).scene.units;
    assert_eq!((units.metres_per_unit, units.up), (Some(1e-3), Up::Z));
    assert_eq!(load(entities(FACE)).scene.units.metres_per_unit, None);
}

/// Text groups in a binary file, with codes of one byte or two.
fn binary(groups: &[(i16, &[u8])], wide: bool) -> Vec<u8> {
    let mut bytes = b"AutoCAD Binary DXF\r\n\x1a\0".to_vec();
    for (code, value) in groups {
        if wide {
            bytes.extend(code.to_le_bytes())
        } else {
            bytes.push(*code as u8)
        }
        bytes.extend(*value);
    }
    bytes
}

#[test]
fn binary_files() {
    let real = |x: f64| x.to_le_bytes();
    let (zero, one) = (real(0.0), real(1.0));
    let groups: [(i16, &[u8]); 14] = [
        (0, b"SECTION\0"),
        (2, b"ENTITIES\0"),
        (0, b"3DFACE\0"),
        (8, b"walls\0"),
        (62, b"\x01\0"),
        (10, &zero),
        (20, &zero),
        (11, &one),
        (21, &zero),
        (12, &zero),
        (22, &one),
        (32, &one),
        (0, b"ENDSEC\0"),
        (0, b"EOF\0"),
    ];
    for wide in [false, true] {
        let bytes = binary(&groups, wide);
        let loaded = load(&bytes);
        assert_eq!((names(&loaded), warnings(&loaded)), (vec!["walls"], vec![]));
        assert_eq!(materials(&loaded), ["walls/1"]);
        check_polygons(
            mesh(&loaded, 0),
            &[&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 1.0]]],
        );
        // Truncated anywhere, it is read as far as it goes, or rejected.
        for end in 0..bytes.len() {
            if let Ok(loaded) = try_load(&bytes[..end], &Memory::new()) {
                assert!(!loaded.warnings.is_empty(), "{end}");
            }
        }
    }
    let bytes = binary(&[groups[0], groups[1], (88, b"?")], true);
    check_warnings(
        &bytes,
        &[
            ": byte 46 (0x2e): the file ends without an EOF: what precedes the end is used",
            ": byte 43 (0x2b): unknown group code: the rest is not read",
            ": the drawing contains no surfaces",
        ],
    );
}

#[test]
fn names_in_all_encodings() {
    let check = |layer: &[u8], expected: &str| {
        let text = entities(FACE);
        let (before, after) = text.split_once("walls").unwrap();
        let bytes = [before.as_bytes(), layer, after.as_bytes()].concat();
        assert_eq!(names(&load(bytes)), [expected]);
    };
    check("Wände".as_bytes(), "Wände");
    check(b"W\xe4nde", "Wände");
    check(b"W\\U+00E4nde", "Wände");
    let utf16: Vec<u8> = entities(FACE)
        .encode_utf16()
        .flat_map(u16::to_le_bytes)
        .collect();
    assert_eq!(names(&load([b"\xff\xfe", &utf16[..]].concat())), ["walls"]);
}

#[test]
fn damage_is_skipped() {
    let whole = entities(&format!("{FACE}{FACE}"));
    // A value is lost: the file gets back into step, and one corner of the face moves.
    let lost = whole.replacen("11\n1\n", "11\n", 1);
    let loaded = load(&lost);
    assert_eq!(mesh(&loaded, 0).faces.len(), 2);
    assert_eq!(warnings(&loaded).len(), 1, "{:?}", loaded.warnings);
    let passed = "line that should be a group code but is not: skipped";
    let loaded = load(whole.replacen("8\nwalls", "8\nwalls\nrubbish", 1));
    assert_eq!(mesh(&loaded, 0).faces.len(), 2);
    assert_eq!(warnings(&loaded), [format!(":9:1: {passed}")]);
    // A section without its end, a file without EOF, an entity outside sections.
    check_warnings(whole.replace("0\nENDSEC\n", ""), &[]);
    check_warnings(
        whole.replace("0\nEOF\n", ""),
        &[":51:1: the file ends without an EOF: what precedes the end is used"],
    );
    for section in ["ENTITIES", "BLOCKS"] {
        let empty = format!("2\n{section}\n0\nENDSEC\n");
        let outside = load(whole.replace("2\nENTITIES\n", &empty));
        assert_eq!(mesh(&outside, 0).faces.len(), 2, "{section}");
    }
    check_warnings(
        whole + "\nrubbish\n",
        &[":53:1: data after the EOF is not read"],
    );
}

#[test]
fn malformed_numbers_are_reported() {
    let text = entities(&FACE.replace("@11 1 0 0", "@11 1,5 0 1e999"));
    check_warnings(
        text,
        &[
            ":5:1: 3DFACE with fewer than three different corners: skipped",
            ":5:1: 3DFACE with a number that is malformed or out of range: taken as missing (2 times)",
            ": the drawing contains no surfaces",
        ],
    );
}

#[test]
fn every_beginning_of_a_file_is_read_or_refused() {
    let text = file(&[
        ("HEADER", "9 $INSUNITS; 70 6"),
        ("TABLES", "0 LAYER; 2 walls; 62 1"),
        ("BLOCKS", &format!("0 BLOCK; 2 a; {FACE} 0 ENDBLK")),
        (
            "ENTITIES",
            "0 INSERT; 2 a; 0 POLYLINE; 39 1; 0 VERTEX; @10 0 0; 0 VERTEX; @10 1 0; 42 1; 0 SEQEND",
        ),
    ]);
    for end in 0..text.len() {
        let _ = try_load(&text[..end], &Memory::new());
    }
}

#[test]
fn no_drawing_at_all() {
    let error = |text: &str| try_load(text, &Memory::new()).unwrap_err().to_string();
    assert!(
        error("Dear diary,\n")
            .starts_with("a.dxf:1:1: found a file without any section, expected a section")
    );
    assert!(error("").starts_with("a.dxf:1:1: found a file without any section"));
    assert!(error("AutoCAD Binary DXF").starts_with("a.dxf: byte 0 (0x0): found"));
    check_warnings(
        "0\nSECTION\n2\nENTITIES\n0\nENDSEC\n0\nEOF\n",
        &[": the drawing contains no surfaces"],
    );
}

/// A drawing with a block that refers to a file.
fn referring(path: &str) -> String {
    file(&[
        (
            "BLOCKS",
            &format!("0 BLOCK; 2 part; 70 4; @10 1 0 0; 1 {path}; 0 ENDBLK"),
        ),
        (
            "ENTITIES",
            "0 INSERT; 2 part; 8 walls; @10 5 0 0; 0 INSERT; 2 part; 8 walls",
        ),
    ])
}

#[test]
fn external_references() {
    let part = entities(&format!("{FACE}{}", FACE.replace("walls", "0")));
    for path in ["part.dxf", "PART.DWG", "C:\\\\work\\part.dwg", "x/part.dxf"] {
        let loaded = load_with(
            referring(path),
            &Memory::new().with("part.dxf", part.as_str()),
        );
        assert_eq!(warnings(&loaded), [""; 0], "{path}");
        assert_eq!(names(&loaded), ["part/walls"; 4], "{path}");
        let first = loaded.scene.objects[0].shape.placed_mesh().unwrap();
        assert_eq!(first.position(0), DVec3::new(4.0, 0.0, 0.0), "{path}");
    }
    // A reference within a reference is searched beside it; a cycle is cut.
    let files = Memory::new()
        .with("x/b.dxf", referring("../a.dxf"))
        .with("a.dxf", referring("x/b.dxf"));
    let loaded = load_with(referring("x/b.dxf"), &files);
    let messages: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
    assert!(
        messages[0].starts_with("a.dxf:27:1: INSERT of block \"part\", which contains itself"),
        "{messages:?}"
    );
}

#[test]
fn external_references_that_fail() {
    let check = |content: Option<&str>, expected: &str| {
        let files = content.map_or(Memory::new(), |c| Memory::new().with("p.dxf", c));
        let loaded = load_with(referring("p.dxf"), &files);
        let expected = format!(
            ":27:1: INSERT of block \"part\", which is the external file \"p.dxf\": {expected}: left out (2 times)"
        );
        assert_eq!(warnings(&loaded)[0], expected);
    };
    check(None, "there is no such file");
    check(Some("AC1032"), "a DWG drawing; export it as DXF");
    check(Some("v 0 0 0"), "Wavefront OBJ, not DXF");
    check(
        Some("AutoCAD Binary DXF\r\n\x1a\0"),
        "found a file without any section, expected a section: a line 0 and a line SECTION",
    );
}

#[test]
fn views_in_perspective() {
    let view = "0 VIEW; 2 door; 40 3; 41 4; @11 0 -5 0; @12 1 2 3; 42 50; 50 0; 71 1";
    let other = "0 VPORT; 2 *Active; @16 0 0 1; @17 0 0 0; 42 18; 41 1; 51 90; 71 1";
    let plan = "0 VIEW; 2 plan; 40 3; 41 4; @11 0 0 1; @12 0 0 0; 42 50; 71 0";
    let loaded = load(file(&[
        ("TABLES", &format!("{view}; {other}; {plan}")),
        ("ENTITIES", FACE),
    ]));
    let [door, active] = &loaded.scene.cameras[..] else {
        panic!("{:?}", loaded.scene.cameras);
    };
    assert_eq!(
        (door.name.as_str(), active.name.as_str()),
        ("door", "Active")
    );
    assert_eq!(
        (door.eye, door.target),
        (DVec3::new(1.0, -3.0, 3.0), DVec3::new(1.0, 2.0, 3.0))
    );
    assert!((door.up - DVec3::Z).length() < 1e-12);
    // 36 mm of film at 50 mm are 39.6° wide; three quarters of that high.
    let expected = 2.0 * (0.75 * 18.0 / 50.0f64).atan();
    assert!((door.vertical_fov - expected).abs() < 1e-12);
    // The image is rotated counter-clockwise, so what was right is up.
    assert!((active.up - DVec3::X).length() < 1e-12, "{}", active.up);
    assert!((active.vertical_fov - 90f64.to_radians()).abs() < 1e-12);
    let ray: math::Ray = door.ray(0.5, 0.5, 1.0);
    assert!((ray.direction - DVec3::Y).length() < 1e-12);
}
