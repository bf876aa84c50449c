//! Small scenes, and comparison with the original's translation of larger ones.

use super::{document, read};
use crate::reading::warnings::Warnings;
use crate::sff::document::{SffDocument, SffSources};
use crate::sff::print::print;
use crate::{Memory, ReadOptions};

fn translated(text: &[u8]) -> Result<SffDocument, String> {
    let mut sources = SffSources::default();
    sources.add("a.scn", text);
    let options = ReadOptions::default();
    let mut warnings = Warnings::default();
    let document = document(&mut sources, &Memory::new(), &options, &mut warnings);
    document.map_err(|e| e.to_string())
}

fn printed(text: &[u8]) -> Result<String, String> {
    let mut bytes = Vec::new();
    print(&translated(text)?, &mut bytes).expect("memory takes everything");
    Ok(String::from_utf8(bytes).expect("text"))
}

/// Whether two records are equal, with numbers to the six digits that the original wrote.
fn same_record(a: &str, b: &str) -> bool {
    let number = |w: &str| w.parse::<f64>().ok();
    let (a, b): (Vec<&str>, Vec<&str>) = (a.split(' ').collect(), b.split(' ').collect());
    let same = |(a, b): (&&str, &&str)| match (number(a), number(b)) {
        (Some(a), Some(b)) => (a - b).abs() <= 6e-6 * a.abs().max(1e-9),
        _ => a == b,
    };
    a.len() == b.len() && a.iter().zip(&b).all(same)
}

#[test]
fn as_the_original_translated() {
    let Some(data) = azulejo_testing::data() else {
        return;
    };
    let folder = data.join("corpus/sff");
    for name in ["example1", "csgdemo"] {
        let scene = std::fs::read(folder.join(format!("scenes/{name}.scn"))).expect("a scene");
        let expected = folder.join(format!("expected_sff/{name}.sff"));
        let expected = std::fs::read_to_string(expected).expect("its translation");
        let printed = printed(&scene).unwrap_or_else(|e| panic!("{e}"));
        // The first line holds limits for RTRACE. The signs of a texture's surface are an error of
        // the original.
        let expected = expected.replace("1 -0.3 -0.3 0.3", "1 0.3 0.3 0.3");
        let expected = expected.lines().skip(1).map(str::trim_end);
        let records = printed.lines().skip(1).map(str::trim_end);
        for (record, expected) in records.clone().zip(expected.clone()) {
            assert!(
                same_record(record, expected),
                "{name}: {record} for {expected}"
            );
        }
        assert_eq!(records.count(), expected.count());
    }
}

/// Checks the records of the objects, after a view and two surfaces.
fn check(scene: &str, expected: &str) {
    let printed = printed(scene.as_bytes()).unwrap_or_else(|e| panic!("{e}"));
    let objects = printed.split_once("objects\n").expect("a section").1;
    let records = objects.trim_end_matches("\n\nend\n");
    let same = records
        .lines()
        .zip(expected.lines())
        .all(|(a, b)| same_record(a, b));
    assert!(
        same && records.lines().count() == expected.lines().count(),
        "{records}"
    );
    let loaded = read(
        scene.as_bytes(),
        "a.scn",
        &Memory::new(),
        &ReadOptions::default(),
    );
    loaded.unwrap_or_else(|e| panic!("{e}"));
}

#[test]
fn arithmetic() {
    check(
        "sphere (1+2*3) (2^3^2 - 512) (7|4) (-2^2+5)",
        "1 1 1 7 0 3 1",
    );
    check(
        "sphere sin(0) cos(0) max(1, 2) rtod(dtor(3))",
        "1 1 1 0 1 2 3",
    );
    check(
        "sphere addvector(1 2 3, scalevector(1 0 -1, 2)) sqrt(4)",
        "1 1 1 3 2 1 2",
    );
    check(
        "sphere crossvector(1 0 0, 0 1 0) dotvector(1 2 3, 1 1 1)",
        "1 1 1 0 0 1 6",
    );
    check("#define R (1.5*2)\nsphere 0 0 0 R", "1 1 1 0 0 0 3");
}

#[test]
fn scopes_and_transforms() {
    let translate = |x: i32| format!("65 0 1 0 0 {x} 0 1 0 0 0 0 1 0 0 0 0 1");
    check(
        "group transform translate 1 0 0 ior 2
           group transform translate 2 0 0 transform translate 3 0 0 sphere 0 0 0 1 ungroup
           transform none sphere transform translate 4 0 0 data 0 0 0 1 ungroup sphere 0 0 0 1",
        &format!(
            "1 1 2 0 0 0 1\n{}\n{}\n{}\n1 1 2 0 0 0 1\n{}\n1 1 1 0 0 0 1",
            translate(2),
            translate(3),
            translate(1),
            translate(4)
        ),
    );
    check(
        "transform translate 1 0 0 csg union surface red data begin sphere 0 0 0 1 csg next
           cone 0 1 0 0 0 0 1 csg end",
        &format!(
            "66 0 1 0 0 - csg begin 0\n{}\n1 1 1 0 0 0 1\n66 1 - csg middle 0\n\
             67 0 0 0 - list begin 0\n4 1 1 0 0 0 1 0 1 0 1e-6\n4 1 1 0 0 0 1 0 -0.001 0 1e-6\n\
             67 1 - list end 0\n66 2 - csg end 0",
            translate(1)
        ),
    );
}

#[test]
fn textures_follow_their_object() {
    check(
        "transform scale 2 texture local texture bump 0.5 texture invariant wood scale 3 sphere 0 0 0 1",
        "1 1 1 0 0 0 1
65 0 2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1
64 0 0 2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1
64 3 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0.5
64 0 0 0.5 0 0 0 0 0.5 0 0 0 0 0.5 0 0 0 0 1
64 7 0 3 0 0 0 0 3 0 0 0 0 3 0 0 0 0 1 0.5 0.5 0.35",
    );
}

#[test]
fn surfaces_and_lights() {
    let check = |scene: &str, expected: &[&str]| {
        let printed = printed(scene.as_bytes()).unwrap_or_else(|e| panic!("{e}"));
        for line in expected {
            let is_printed = printed.lines().any(|l| same_record(l, line));
            assert!(is_printed, "{line} in {printed}");
        }
    };
    check(
        "surface red",
        &["1 1 0 0 0.9 0.9 0.9 0.1 0.1 0.1 3 0 0.1 0.1 0.1"],
    );
    check(
        "surface emitter noshadow matte black",
        &["1 -0.001 -0.001 0 0.999 0.999 0.999 0 0 0 0 0 0 0 0"],
    );
    check(
        "surface metal mono 1 mono 0.5 1",
        &["1 1 1 1 0.05 0.05 0.05 0.95 0.95 0.95 100 1 0 0 0"],
    );
    check(
        "surface strauss mono 1 mono .5 mono 0",
        &["2 1 1 1 0.5 0.5 0.5 0 0 0 0 0 0"],
    );
    check(
        "surface glass white mono 0.8 sphere 0 0 0 1",
        &[
            "1 1 1 1 0 0 0 0.2 0.2 0.2 100 0 0.8 0.8 0.8",
            "1 1 1.52 0 0 0 1",
        ],
    );
    check("light dir 0 -2 0", &["1 0 100000 0 -1 -1 -1"]);
    check(
        "light spot 1 2 3 0 0 -2 white",
        &["2 1 2 3 1 1 1 0 0 -1 45 1"],
    );
    check(
        "light linear 1 2 3 mono -1 1 0 0 5",
        &["4 1 2 3 -1 -1 -1 1 0 0 0 0 0 5 0"],
    );
}

#[test]
fn every_object_is_read() {
    for object in [
        "box 0 0 0 1 2 3 cube 0 0 0 1",
        "cylinder open 0 1 0 0 0 0 1 cone truncated 0 1 0 .5 0 0 0 1 disc 0 0 0 0 1 0 2",
        "ring 0 0 0 0 1 0 2 1 wedge 0 0 0 1 0 0 0 1 0 2 tetra 0 0 0 1 0 0 0 1 0 0 0 1",
        "prism 2 4 0 0 0 1 0 0 1 1 0 0 1 0 pyramid truncated 2 .5 3 0 0 0 1 0 0 0 1 0",
        "polygon 3 0 0 0 1 0 0 0 1 0 quadrangle 0 0 0 1 0 0 1 1 0 0 1 0 triangle 0 0 0 1 0 0 0 1 0",
        "triangle normal 0 0 0 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1",
        "triangle general 0 0 0 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1 surface red surface matte blue surface red",
        "torus 2 .5 torus open 2 .5 0 90 5 6",
        "csg intersection begin torus 2 .5 0 90 csg next wedge 0 0 0 1 0 0 0 1 0 2 cylinder 0 1 0 0 0 0 1 csg end",
        "list begin polygon 3 0 0 0 1 0 0 0 1 0 sphere 0 0 0 1 list end",
        "patch 1 0 0 2 0 0 0 1 0 1 1 0 2 1 0 3 1 0 0 2 0 1 2 0 2 2 0 3 2 0 1 3 0 2 3 0",
    ] {
        let loaded = read(
            object.as_bytes(),
            "a.scn",
            &Memory::new(),
            &ReadOptions::default(),
        );
        let loaded = loaded.unwrap_or_else(|e| panic!("{e}"));
        loaded
            .scene
            .validate()
            .expect("a reader gives valid scenes");
        assert!(!loaded.scene.objects.is_empty(), "{object}");
    }
}

#[test]
fn mistakes_are_named() {
    let check = |scene: &str, expected: &str| {
        let loaded = read(
            scene.as_bytes(),
            "a.scn",
            &Memory::new(),
            &ReadOptions::default(),
        );
        let error = loaded.map(|l| l.scene).expect_err(scene).to_string();
        assert!(error.starts_with(expected), "{error}");
    };
    check(
        "sphere 0 0 0",
        "a.scn:1:12: found the end of the file, expected a number",
    );
    check(
        "sphere 0 0 0 0",
        "a.scn:1:14: found radius 0, expected a positive number",
    );
    check("sphere 0 0 0 (1/0)", "a.scn:1:14: found the value inf");
    check(
        "sphere 0 0 0 (1",
        "a.scn:1:15: found the end of the file, expected \")\"",
    );
    check(
        "\nball 0 0 0 1",
        "a.scn:2:1: found \"ball\", expected an SCN command",
    );
    check(
        "surface pinkish",
        "a.scn:1:9: found \"pinkish\", expected a colour",
    );
    check(
        "sphere surface red transform none 0 0 0 1",
        "a.scn:1:35: found the number 0, expected data",
    );
    check(
        "transform scale 0",
        "a.scn:1:11: found a singular transform",
    );
    check("light area 0 0 0", "a.scn:1:7: found light \"area\"");
    check(
        "group sphere 0 0 0 1",
        "a.scn:1:1: found a beginning without its end",
    );
    check("ungroup", "a.scn:1:1: found an end without its beginning");
    check(
        "csg union begin group csg end",
        "a.scn:1:23: found an end without its beginning",
    );
    check("csg next", "a.scn:1:1: found csg next that does not follow");
    check(
        "csg union begin csg next sphere 0 0 0 1 csg end",
        "a.scn:1:17: found 66 1 with nothing before it",
    );
    check(
        "csg union begin disc 0 0 0 0 1 0 1 csg next sphere 0 0 0 1 csg end",
        "a.scn:1:17: found an open shape",
    );
    check(
        "cone 0 0 0 0 0 0 1",
        "a.scn:1:1: found a cone without height",
    );
    check(
        "prism 1 3 0 0 0 1 0 0 2 0 0",
        "a.scn:1:1: found a base without area",
    );
    check("polygon 2 0 0 0 1 1 1", "a.scn:1:1: found 2 points");
    check(
        "torus 1 .1 5 5",
        "a.scn:1:1: found a torus from 5 to 5 degrees",
    );
    check(
        "eye 0 0 0",
        "a.scn:1:1: found an eye, a target and an up vector",
    );
    check(
        "text3d file nothing",
        "a.scn:1:13: found \"nothing\", expected a file name",
    );
    check(
        "text3d file a.t3d",
        "a.scn:1:1: found \"a.t3d\", which cannot be read",
    );
    let deep = format!("sphere 0 0 0 {}1", "(".repeat(1000));
    check(&deep, "a.scn:1:46: found parentheses more than 64 deep");
    check(&"group ".repeat(1000), "a.scn:1:");
}

/// Any modified scene is read or rejected, and what is read is valid.
#[test]
fn damaged_scenes() {
    let text = "eye 5 2 (2+1) fov 20 background mono .2 light spot 1 2 3 0 0 -2 white 30
        #define R 2
        csg subtraction texture scale .2 checkers surface matte red translate 1 1 1 data begin
        box 0 0 0 1 csg next cylinder 0 1 0 0 -1 0 R csg end torus 2 .5 0 90 5 6";
    let options = ReadOptions::in_proportion(text.len());
    let check = |bytes: &[u8]| {
        if let Ok(loaded) = read(bytes, "a.scn", &Memory::new(), &options) {
            loaded
                .scene
                .validate()
                .expect("a reader gives valid scenes");
        }
    };
    let mut bytes = text.as_bytes().to_vec();
    for at in 0..bytes.len() {
        check(&bytes[..at]);
        let byte = bytes[at];
        for other in [b'0', b'9', b'-', b' ', b'(', 0xff] {
            bytes[at] = other;
            check(&bytes);
        }
        bytes[at] = byte;
    }
}
