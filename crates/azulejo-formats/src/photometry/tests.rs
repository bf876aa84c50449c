use super::*;
use crate::Memory;
use azulejo_scene::WebType;
use proptest::prelude::*;
use std::f64::consts::PI;

/// A file of type C in feet with the given sizes, angles and candelas.
fn ies(sizes: &str, vertical: &str, horizontal: &str, candelas: &str) -> String {
    let count = |list: &str| list.split_whitespace().count();
    format!(
        "IESNA91\n[TEST] x\nTILT=NONE\n1 1000 2.0 {} {} 1 1 {sizes}\n0.5 1.0 60\n{vertical}\n{horizontal}\n{candelas}\n",
        count(vertical),
        count(horizontal)
    )
}

fn parsed(text: &str) -> PhotometricFile {
    PhotometricFile::read(text.as_bytes(), "lamp.ies", None).unwrap()
}

#[test]
fn light_the_same_everywhere() {
    let lamp = parsed(&ies("0 0 0", "0 180", "0", "100 100"));
    assert!((lamp.lumens() - 400.0 * PI).abs() < 1e-9);
    assert_eq!((lamp.opening, lamp.factor), (LuminousOpening::Point, 1.0));
    // The same over a quarter of the horizon, and over all of it.
    for horizontal in ["0 90", "0 90 180 270 360"] {
        let candelas = "100 100 ".repeat(horizontal.split(' ').count());
        let lamp = parsed(&ies("0 0 0", "0 180", horizontal, &candelas));
        assert!((lamp.lumens() - 400.0 * PI).abs() < 1e-9);
    }
}

/// The flux is that of the intensities between the angles, not of rectangles around them.
#[test]
fn lumens_are_exact() {
    // I = 1000 (1 − γ/90°) cd below: 2π ∫ I sin γ dγ = 2000 π (1 − 2/π).
    let lamp = parsed(&ies("0 0 0", "0 90", "0", "1000 0"));
    assert!((lamp.lumens() - 2000.0 * (PI - 2.0)).abs() < 1e-9);
}

#[test]
fn openings_become_points_of_equal_power() {
    let angles: Vec<String> = (0..=90).map(|a| a.to_string()).collect();
    let candelas: Vec<String> = (0..=90)
        .map(|a| (100.0 * f64::from(a).to_radians().cos()).to_string())
        .collect();
    // Feet, width before length.
    let lamp = parsed(&ies("1 4 0", &angles.join(" "), "0", &candelas.join(",")));
    let LuminousOpening::Rectangle { length, width } = lamp.opening else {
        panic!("{:?}", lamp.opening)
    };
    assert!((length - 1.2192).abs() < 1e-12 && (width - 0.3048).abs() < 1e-12);
    let lights = lamp.lights(&DAffine3::IDENTITY, Rgb::WHITE);
    assert_eq!(lights.len(), 5 * 2);
    let below: f64 = lights
        .iter()
        .map(|light| light.intensity_toward(DVec3::NEG_Z).g)
        .sum();
    assert!((below - 100.0).abs() < 1e-9);
    let sum: DVec3 = lights.iter().filter_map(LightKind::position).sum();
    assert!(sum.length() < 1e-12);
    let disc = LuminousOpening::Disc { diameter: 1.0 };
    assert!(disc.points().iter().all(|p| p.length() < 0.5) && disc.points().len() == 12);
}

#[test]
fn types_a_and_b() {
    // 100 cd within 10 degrees up and across; type B gives both halves across, and has a table for tilted lamps.
    for (number, kind, horizontal, rows) in
        [("3", WebType::A, "0 10", 2), ("2", WebType::B, "-10 10", 2)]
    {
        let text = format!(
            "TILT=INCLUDE\n1\n2\n0 90\n1 0.5\n1 1 1 2 2 {number} 2 -0.2 0 0 1 1 1 -10 10 {horizontal} {}",
            "100 100 ".repeat(rows)
        );
        let lamp = parsed(&text);
        assert_eq!(lamp.web.kind(), kind);
        let side = 20f64.to_radians();
        let expected = 100.0 * side * 2.0 * 10f64.to_radians().sin();
        assert!((lamp.lumens() / expected - 1.0).abs() < 1e-12);
        let factors = [-90.0, 0.0, 45.0, 90.0, 120.0].map(|angle| lamp.tilt_factor(angle));
        assert_eq!(factors, [0.5, 1.0, 0.75, 0.5, 0.5]);
        let disc = LuminousOpening::Disc { diameter: 0.2 };
        assert_eq!(lamp.opening, disc);
    }
}

#[test]
fn tilt_tables_beside_the_file() {
    let text = ies("0 0 0", "0 180", "0", "100 100");
    assert_eq!(parsed(&text).tilt_file, None);
    let mut lamp = parsed(&text.replace("TILT=NONE", "TILT= hid.tlt "));
    assert_eq!(lamp.tilt_file.as_deref(), Some("hid.tlt"));
    let beside = |table: &str| Memory::new().with("hid.tlt", table);
    let error = |lamp: &PhotometricFile, files: &Memory| {
        let error = lamp.clone().read_tilt(files).unwrap_err();
        error.to_string()
    };
    let missing = error(&lamp, &Memory::new());
    assert!(missing.starts_with("hid.tlt: "), "{missing}");
    assert!(missing.contains("expected the tilt table"), "{missing}");
    let damaged = error(&lamp, &beside("1\n3\n0 45 90\n1 0.9"));
    assert!(damaged.starts_with("hid.tlt:4:"), "{damaged}");
    lamp.read_tilt(&beside("1\n3\n0 45 90\n1 0.9 0.8\n"))
        .unwrap();
    assert_eq!(
        [0.0, 45.0, -90.0].map(|angle| lamp.tilt_factor(angle)),
        [1.0, 0.9, 0.8]
    );
    // There is nothing more to read.
    lamp.read_tilt(&Memory::new()).unwrap();
}

#[test]
fn the_third_factor_is_one_in_old_files_only() {
    let check = |first: &str, expected: f64| {
        let text = ies("0 0 0", "0 180", "0", "100 100");
        let text = text.replace("0.5 1.0 60", "0.5 1.101 60");
        let lamp = parsed(&text.replace("IESNA91", first));
        assert!((lamp.factor / expected - 1.0).abs() < 1e-12, "{first}");
        assert!((lamp.lumens() / (400.0 * PI * expected) - 1.0).abs() < 1e-9);
    };
    for old in [
        "IESNA91",
        "iesna91",
        "A lamp of 1986",
        "",
        "IESNA:LM-63-1991",
    ] {
        check(old, 1.101);
    }
    for new in [
        "IESNA:LM-63-1995",
        "IESNA: LM-63-2002",
        "IES:LM-63-2019",
        "ies:lm-63-2019",
        "IESNA:LM-63 - 2002",
    ] {
        check(new, 1.0);
    }
}

#[test]
fn headers() {
    let with = |line: &str| parsed(&ies("0 0 0", "0 90", "0", "1 1").replace("[TEST] x", line));
    let body = |line: &str| with(line).body;
    assert_eq!(
        body("[LUMINOUSGEOMETRY]  lamp.mgf").as_deref(),
        Some("lamp.mgf")
    );
    assert_eq!(body("GEOM=lamp.mgf").as_deref(), Some("lamp.mgf"));
    assert_eq!(body("[LUMINOUSGEOMETRY]"), None);
    assert_eq!(with("[LUMCAT] DL 20").name, "DL 20");
    // −1 lumens: the luminaire was measured, not its lamps.
    let relative = ies("0 0 0", "0 90", "0", "1 1");
    let absolute = relative.replace("1 1000", "1 -1");
    assert_eq!(parsed(&absolute).lumens(), parsed(&relative).lumens());
}

#[test]
fn what_is_wrong_is_said_with_its_line() {
    let check = |text: &str, expected: &str| {
        let error = PhotometricFile::read(text.as_bytes(), "lamp.ies", None).unwrap_err();
        assert!(error.to_string().starts_with(expected), "{error}");
    };
    let good = ies("0 0 0", "0 90", "0", "1 1");
    check("", "lamp.ies:1:1: found no line that begins with TILT=");
    check(
        "TILT=NONE\n1 2 3",
        "lamp.ies:2:5: found the end of the file",
    );
    check(
        &good.replace("1000", "many"),
        "lamp.ies:4:3: found \"many\", expected a number",
    );
    check(
        &good.replace("2.0 2 1", "2.0 9e9 1"),
        "lamp.ies:5:9: found 9000000000 vertical angles",
    );
    check(
        &good.replace("2.0 2 1", "2.0 0 1"),
        "lamp.ies:5:9: found 0 vertical angles",
    );
    check(
        &good.replace("0 90", "90 0"),
        "lamp.ies:6:1: found vertical angles that decrease",
    );
    check(
        &good.replace("2.0 2 1", "-2.0 2 1"),
        "lamp.ies:5:9: found negative factors",
    );
    check(
        &good.replace("\n1 1\n", "\n1 -1\n"),
        "lamp.ies:8:1: found an intensity of -1",
    );
    check(
        &good
            .replace("\n1 1\n", "\n1e308 1e308\n")
            .replace("2.0 2 1", "9.0 2 1"),
        "lamp.ies:8:1: found an",
    );
    let tilted = good.replace("TILT=NONE", "TILT=INCLUDE\n1\n2\n90 0\n1 0.5");
    check(
        &tilted,
        "lamp.ies:7:3: found a tilt table with decreasing angles",
    );
    // A little below 0 is noise.
    let noisy = parsed(&good.replace("\n1 1\n", "\n1 -0.0005\n"));
    assert_eq!(noisy.web.values()[1], 0.0);
}

/// A file in EULUMDAT of this symmetry, whose planes are 90 degrees apart and have the given values at 0, 90 and 180 degrees
/// from the aim.
fn eulumdat(symmetry: u32, planes: u32, values: &[f64]) -> String {
    let mut lines: Vec<String> = vec!["Company".into(), "1".into()];
    let step = if planes > 1 { 360 / planes } else { 0 };
    lines.extend([symmetry, planes, step, 3, 90].map(|n| n.to_string()));
    lines.extend(["report", "Street lamp", "7", "file.ldt", "today"].map(str::to_owned));
    // Luminaire and luminous area, mm; heights; shares; factor; tilt.
    lines.extend(["1300", "300", "80", "1200", "200", "0", "0", "0", "0"].map(str::to_owned));
    lines.extend(["100", "80", "1", "0", "2"].map(str::to_owned));
    for (kind, lumens) in [("LED", "2000"), ("tube", "500")] {
        lines.extend(["1", kind, lumens, "4000", "80", "20"].map(str::to_owned));
    }
    lines.extend((0..10).map(|k| format!("0.{k}")));
    lines.extend((0..planes).map(|k| (k * step).to_string()));
    lines.extend(["0", "90", "180"].map(str::to_owned));
    lines.extend(values.iter().map(f64::to_string));
    lines.join("\r\n")
}

fn from_eulumdat(text: &str, set: Option<usize>) -> PhotometricFile {
    PhotometricFile::read(text.as_bytes(), "lamp.ldt", set).unwrap()
}

#[test]
fn eulumdat_by_its_symmetries() {
    // In the plane across the aim, at 0, 90, 180 and 270 degrees, of 1000 lm.
    let check = |symmetry: u32, planes: u32, across: &[f64], expected: [f64; 4]| {
        let values: Vec<f64> = across.iter().flat_map(|v| [5.0, *v, 0.0]).collect();
        let lamp = from_eulumdat(&eulumdat(symmetry, planes, &values), None);
        let found = [DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y].map(|w| lamp.web.toward(w));
        let expected = expected.map(|v| 2.0 * v);
        assert!(
            found
                .iter()
                .zip(expected)
                .all(|(a, b)| (a - b).abs() < 1e-9),
            "{symmetry}: {found:?} {expected:?}"
        );
        assert!((lamp.web.toward(DVec3::NEG_Z) - 10.0).abs() < 1e-9);
    };
    check(0, 4, &[1.0, 2.0, 3.0, 4.0], [1.0, 2.0, 3.0, 4.0]);
    check(1, 1, &[7.0], [7.0; 4]);
    check(2, 4, &[1.0, 2.0, 3.0], [1.0, 2.0, 3.0, 2.0]);
    // From 270 over 0 to 90 degrees.
    check(3, 4, &[4.0, 1.0, 2.0], [1.0, 2.0, 1.0, 4.0]);
    check(4, 4, &[1.0, 2.0], [1.0, 2.0, 1.0, 2.0]);
}

#[test]
fn eulumdat_has_sets_of_lamps() {
    let text = eulumdat(1, 1, &[100.0, 100.0, 100.0]);
    let first = from_eulumdat(&text, None);
    assert_eq!(first.name, "Street lamp");
    assert!((first.lumens() - 4.0 * PI * 200.0).abs() < 1e-9);
    // Along the lamps, across the plane of 0 degrees.
    let opening = LuminousOpening::Rectangle {
        length: 0.2,
        width: 1.2,
    };
    assert_eq!(first.opening, opening);
    let second = from_eulumdat(&text, Some(2));
    assert!((second.lumens() - 4.0 * PI * 50.0).abs() < 1e-9);
    let loaded = read(
        text.as_bytes(),
        "lamp.ldt",
        &Memory::new(),
        &ReadOptions::default(),
    )
    .unwrap();
    let sets = &loaded.warnings[0].message;
    assert!(
        sets.contains("1 × LED, 2000 lm; 1 × tube, 500 lm"),
        "{sets}"
    );
    assert_eq!(loaded.scene.lights.len(), 4);
    let check = |text: &str, set: Option<usize>, expected: &str| {
        let error = PhotometricFile::read(text.as_bytes(), "lamp.ldt", set).unwrap_err();
        assert!(error.to_string().starts_with(expected), "{error}");
    };
    check(
        &text,
        Some(3),
        "lamp.ldt:26:1: found set 3 of the lamps, of which the file has 2",
    );
    check(
        &text.replace("2000", "many"),
        None,
        "lamp.ldt:29:1: found \"many\", expected a number",
    );
    check(&text[..200], None, "lamp.ldt:");
    check("", None, "lamp.ldt:");
    // A comma for the point.
    let comma = from_eulumdat(
        &text.replace("100\r\n80\r\n1\r\n0", "100\r\n80\r\n0,5\r\n0"),
        None,
    );
    assert!((comma.lumens() - 2.0 * PI * 200.0).abs() < 1e-9);
}

proptest! {
    #[test]
    fn any_text_is_read_or_refused(text in "((TILT=(NONE|INCLUDE))?[0-9. ,\n-]{0,40}\n){0,12}", set in 0..3usize) {
        for name in ["a.ies", "a.ldt", "a"] {
            let _ = PhotometricFile::read(text.as_bytes(), name, Some(set));
        }
    }

    /// Numbers of a file that are changed, left out or repeated.
    #[test]
    fn damaged_files_are_no_danger(at in 0..400usize, with in "[-0-9.e\n ]{0,4}") {
        for text in [
            ies("1 4 0", "0 45 90", "0 90", "100 50 0 80 40 0"),
            eulumdat(2, 4, &[9.0, 5.0, 1.0, 9.0, 5.0, 1.0, 9.0, 5.0, 1.0]),
        ] {
            let at = at.min(text.len());
            let end = (at + 2).min(text.len());
            let damaged = [&text[..at], &with, &text[end..]].concat();
            for name in ["a.ies", "a.ldt"] {
                let options = ReadOptions::default();
                if let Ok(loaded) = read(damaged.as_bytes(), name, &Memory::new(), &options) {
                    prop_assert!(loaded.scene.validate().is_ok());
                }
            }
        }
    }
}
