//! Small scenes: conversion, and error messages.

use crate::{Loaded, Memory, ReadOptions, sff};
use azulejo_scene::rtrace::RtraceTextureKind;
use azulejo_scene::{LightKind, PrimitiveKind, Scene, Shape, Solid};
use glam::DVec3;

/// Everything up to the objects: two surfaces, and a light of each type.
const HEAD: &str = "view\n0 0 10\n0 0 0\n0 1 0\n30 20\ncolors\n.1 .2 .3\n.1 .1 .1\nlights
1 0 9 0 1 1 1
2 0 9 0 -1 1 1 0 -2 0 33 2
3 5 9 0 1 1 1 .5 4
4 5 9 2 1 1 1 1 0 0 0 0 1 4 4
4 5 9 3 1 1 1 1 0 0 0 0 0 3 0

surfaces
1 1 .5 .2 .8 .8 .8 .1 .1 .1 30 0 0 0 0
2 1 1 1 .5 .5 .5 0 0 0 0 0 0
1 -.5 -.5 .5 .1 .1 .1 0 0 0 3 0 .9 .9 .9

objects
";

/// Two glyphs: a square, and one with a curve.
const FONT: &str = "/box 1 4 l 0 0 l 1 0 l 1 1 l 0 1\n/bow 1 2 c 0 0 .3 1 .6 1 l .7 0\n";

fn files() -> Memory {
    let map: String = (0..256).map(|k| format!("{k} {k} 0\n")).collect();
    let picture = [&[2, 0, 2, 0][..], &[7; 12]].concat();
    Memory::new()
        .with("f.ppf", FONT)
        .with("f.ppe", "65/box\n66/bow\n")
        .with("m.map", map)
        .with("p.pic", picture)
}

fn load(objects: &str) -> Result<Loaded, String> {
    let text = format!("{HEAD}{objects}");
    let loaded = sff::read(text.as_bytes(), "a.sff", &files(), &ReadOptions::default());
    let loaded = loaded.map_err(|e| e.to_string())?;
    loaded
        .scene
        .validate()
        .expect("a reader gives valid scenes");
    Ok(loaded)
}

fn read(objects: &str) -> Scene {
    load(objects).unwrap_or_else(|e| panic!("{e}")).scene
}

/// The scene after writing and reading it.
fn again(scene: &Scene) -> Scene {
    let mut text = Vec::new();
    let beside = sff::write(scene, "b c", &mut text).expect("memory takes everything");
    let files = beside
        .into_iter()
        .fold(files(), |f, (name, bytes)| f.with(name, bytes));
    let loaded = sff::read(&text, "again.sff", &files, &ReadOptions::default());
    loaded
        .unwrap_or_else(|e| panic!("{e}\n{}", String::from_utf8_lossy(&text)))
        .scene
}

/// Prisms and patches are preserved up to rounding, everything else bit by bit.
fn assert_same(mut a: Scene, mut b: Scene) {
    let exact = |scene: &mut Scene| {
        let mut points = Vec::new();
        for object in &mut scene.objects {
            let Shape::Exact(exact) = &mut object.shape else {
                continue;
            };
            for solid in &mut exact.solids {
                match solid {
                    Solid::Prism(p) => {
                        let map = &mut p.world_from_figure;
                        points.extend([map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis]);
                        points.push(map.translation);
                        *map = glam::DAffine3::IDENTITY;
                    }
                    Solid::Patch(p) => {
                        points.extend(p.points.iter().flatten());
                        p.points.iter_mut().flatten().for_each(|p| *p = DVec3::ZERO);
                    }
                    _ => {}
                }
            }
        }
        points
    };
    let (p, q) = (exact(&mut a), exact(&mut b));
    assert_eq!(p.len(), q.len());
    let far = p
        .iter()
        .zip(&q)
        .map(|(p, q)| p.distance(*q))
        .fold(0.0, f64::max);
    assert!(far < 1e-12, "{far}");
    assert_eq!(a, b);
}

fn round_trip(objects: &str) {
    let scene = read(objects);
    assert_eq!(sff::losses(&scene), Vec::<String>::new());
    assert_same(again(&scene), scene);
}

#[test]
fn what_is_written_is_read_again() {
    round_trip("1 1 1 0 .1 0 1\n65 0 2 0 0 1 0 1 0 0 0 .3 1 0 0 0 0 1\n");
    round_trip(
        "2 1 1.5 0 .1 0 1 .7 .3\n2 2 1 0 0 0 .1 .1 .1\n65 2 0 -1 0 0 1 0 0 0 0 0 1 0 0 0 0 1\n",
    );
    round_trip(
        "4 1 1 0 .1 0 .3 1 2 3 .1\n4 2 1 0 0 0 1 0 0 2 1\n65 0 1 .1 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n",
    );
    round_trip(
        "5 1 1 1 2 3 .1 .1 .1 -\n4 1 2 3 4\n3 1 2 5\n\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n\n1 1 1 0 0 0 1\n",
    );
    let triangle = "0 0 0 0 .1 1 1 0 0 0 0 1\n0 1 0 0 0 1";
    round_trip(&format!("6 1 1 1 2 3 .1 .1 .1 -\n{triangle}\n\n"));
    round_trip(&format!(
        "6 0 1 0 0 0 1 1 1 -\n{triangle} 1 2 1\n\n65 0 -1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n"
    ));
    round_trip(
        "7 1 1 -\nSPACING .1 SCALE 2 3 .5 ORIENTATION 1 1 0 0 0 1 -1 1 .2\nFONT f.ppf ENCODING f.ppe\nAT 1 2 3 \"AB /bow/A\"\n\n",
    );
    round_trip(&format!(
        "{PATCH}64 4 0 2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1 m.map\n"
    ));
    round_trip(CSG);
    round_trip(TEXTURES);
}

const PATCH: &str = "3 1 1 0 0 0 1 1 2 -\n1 2 3 4 5 6 7 8 9 10 11 12\n
1 0 0\n2 0 0\n0 1 0\n1 1 .3\n2 1 .2\n3 1 0\n0 2 0\n1 2 .1\n2 2 .5\n3 2 0\n1 3 0\n2 3 0\n\n";

/// A ball with a cylinder cut out, and the corner of a pyramid.
const CSG: &str = "66 0 2 0 1\n65 0 1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1\n64 3 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 .4
1 1 1 0 0 0 1\n66 1
67 0 0 0\n4 1 1 0 -2 0 .5 0 2 0 .5\n4 1 1 0 -2 0 .5 0 -2.001 0 5e-07\n4 1 1 0 2 0 .5 0 2.001 0 5e-7\n67 1
66 0 1 1.5 2\n5 1 1 0 0 0 1 1 1 -\n3 1 3 2\n3 1 2 4\n3 2 3 4\n3 3 1 4\n
0 0 0\n1 0 0\n0 1 0\n0 0 1\n
66 1\n2 1 1 0 0 0 .5 .5 .5\n66 2\n66 2\n";

const TEXTURES: &str =
    "1 1 1 0 0 0 1\n64 1 0 1 0 0 .1 0 1 0 0 0 0 1 0 0 0 0 1 2\n1 2 1 0 0 0 1\n1 3 1.5 3 0 0 1\n
textures
2 1 2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1 0.4 2 - Blotch
5 2 10 0 0 0 1 10 0 0 1 1 10 0 0 0 0 1 0 0.6 0.5 2 0.1 6 - no map
6 2 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 1 2 3 4
18 2 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 0 1 3 1 p.pic
17 2 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 .5 1 2 3 m.map
";

#[test]
fn textures_of_both_modes() {
    let scene = read(TEXTURES);
    let rtrace = scene.rtrace.unwrap();
    let counts = |m: &azulejo_scene::rtrace::RtraceMaterial| {
        (m.inline_textures.len(), m.section_textures.len())
    };
    let counts: Vec<_> = rtrace.materials.iter().map(counts).collect();
    assert_eq!(counts, [(1, 1), (0, 4), (0, 0)]);
    let fbm_bump = RtraceTextureKind::FbmBump {
        offset: 1.0,
        k: 2.0,
        omega: 0.5,
        lambda: 3.0,
        octaves: 4.0,
    };
    assert_eq!(rtrace.materials[1].section_textures[1].kind, fbm_bump);
    let moved = rtrace.materials[0].inline_textures[0].texture_from_point;
    assert_eq!(moved.transform_point3(DVec3::X).x, 0.9);
}

#[test]
fn lights_with_area_are_bodies_behind_all_objects() {
    let scene = read("1 1 1 0 0 0 1\n");
    let names: Vec<&str> = scene.objects.iter().map(|o| &*o.name).collect();
    assert_eq!(names, ["sphere 1", "light 3", "light 4"]);
    assert_eq!(scene.rtrace.as_ref().unwrap().materials.len(), 1);
    let kinds = scene.lights.iter().map(|l| match l.kind {
        LightKind::Point { .. } => 'p',
        LightKind::Spot { .. } => 's',
        LightKind::Directional { .. } => 'd',
        LightKind::Ambient { .. } => 'a',
        LightKind::Environment(_) => 'e',
        LightKind::Luminaire { .. } => 'l',
    });
    assert_eq!(kinds.collect::<String>(), "pspppa");
}

#[test]
fn lists_are_several_objects_but_a_closed_cone_is_one() {
    let check = |objects: &str, expected: &[PrimitiveKind]| {
        let scene = read(objects);
        let kinds = scene.objects.iter().filter_map(|o| match &o.shape {
            Shape::Primitive(p) if !o.name.starts_with("light") => Some(p.kind),
            _ => None,
        });
        assert_eq!(kinds.collect::<Vec<_>>(), expected);
    };
    let side = "4 1 1 0 0 0 1 0 2 0 .5\n";
    let caps = "4 1 1 0 0 0 1 0 -.001 0 1e-6\n4 1 1 0 2 0 .5 0 2.001 0 5e-7\n";
    check(side, &[PrimitiveKind::Tube { top: 0.5 }]);
    check(
        &format!("67 0 2 0\n{side}{caps}67 1\n"),
        &[PrimitiveKind::Cone { top: 0.5 }],
    );
    check(
        &format!("67 0 2 0\n{side}1 1 1 0 0 0 1\n67 1\n"),
        &[PrimitiveKind::Tube { top: 0.5 }, PrimitiveKind::Sphere],
    );
}

#[test]
fn the_outermost_surface_counts() {
    let scene = read(CSG);
    let Shape::Exact(csg) = &scene.objects[0].shape else {
        panic!("a set operation is exact");
    };
    // The inner operation has a surface, but the outer one takes precedence; only the inner one has
    // an index of refraction.
    let materials: Vec<u32> = csg.leaves().iter().map(|l| l.material()).collect();
    assert_eq!(materials, [0, 0, 1, 1]);
    let rtrace = scene.rtrace.unwrap();
    let looks: Vec<_> = rtrace
        .materials
        .iter()
        .map(|m| (m.surface, m.ior))
        .collect();
    assert_eq!(looks, [(1, 1.0), (1, 1.5)]);
}

#[test]
fn mistakes_are_named_with_their_lines() {
    let lines = HEAD.lines().count();
    let check = |objects: &str, line: usize, expected: &str| {
        let error = load(objects).expect_err(objects);
        let place = format!("a.sff:{}:", lines + line);
        assert!(
            error.starts_with(&place) && error.contains(expected),
            "{error}"
        );
    };
    check("9 1 1 0 0 0 1", 1, "found a record of type 9");
    check("1 1 1 0 0 0", 1, "found the end of the file");
    check(
        "1 1 1 0 0\n\n0 1",
        1,
        "found the end of the section, expected a number",
    );
    check("1 1 1 0 0 0 -1", 1, "a positive number");
    check("1 1 1 0 x 0 1", 1, "found \"x\", expected a number");
    check(
        "1 4 1 0 0 0 1",
        1,
        "found surface 4, expected one of the surfaces, 1 to 3",
    );
    check("1 0 1 0 0 0 1", 1, "found surface 0");
    check("4 1 1 0 0 0 1 0 0 0 1", 1, "a cone without height");
    check(
        "1 1 1 0 0 0 1\n65 3 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1",
        2,
        "object 3, which does not exist",
    );
    check(
        "65 0 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1",
        1,
        "before the first",
    );
    check(
        "1 1 1 0 0 0 1\n65 1 1 0 0 0 0 1 0 0 0 0 0 0 0 0 0 1",
        2,
        "singular",
    );
    check("5 1 1 0 0 0 1 1 1 -\n3 1 2 9\n\n0 0 0\n", 2, "vertex 9");
    check(
        "5 1 1 0 0 0 1 1 1 -\n2 1 2\n\n0 0 0\n",
        2,
        "a polygon with 2 vertices",
    );
    check(
        "5 1 1 0 0 0 1 1 1 -\n3 1 2 3\n\n0 0 0\n1 0 0\n\n",
        6,
        "found 2 vertices, expected 3",
    );
    check(
        "5 1 1 0 0 0 1 1 1 -\n3 1 2 1\n\n0 0 0\n1 0 0\n2 2 2\n",
        6,
        "an empty line after the 2",
    );
    check(
        "5 1 1 0 0 0 1 1 1 no.dat\n",
        1,
        "\"no.dat\", which cannot be read",
    );
    check("66 0 0 0 1\n1 1 1 0 0 0 1\n66 2\n", 3, "66 2 out of order");
    check("66 0 0 0 1\n66 1\n", 2, "66 1 with nothing before it");
    check("66 1\n", 1, "66 1 outside");
    check(
        "66 0 0 0 1\n1 1 1 0 0 0 1\n",
        1,
        "a beginning without its end",
    );
    check("66 0 0 0 7\n", 1, "set operation 7");
    check("67 0 0 0\n1 1 1 0 0 0 1\n66 2\n", 3, "out of order");
    check(
        &"66 0 0 0 1\n".repeat(300),
        257,
        "nested more than 256 deep",
    );
    check(
        "66 0 0 0 1\n4 1 1 0 0 0 1 0 1 0 1\n66 1\n1 1 1 0 0 0 1\n66 2\n",
        2,
        "an open shape",
    );
    let open = "5 1 1 0 0 0 1 1 1 -\n3 1 2 3\n\n0 0 0\n1 0 0\n0 1 0\n\n";
    check(
        &format!("66 0 0 0 1\n{open}66 1\n1 1 1 0 0 0 1\n66 2\n"),
        2,
        "an open shape",
    );
    check("1 1 1 0 0 0 1\n64 99 0 1", 2, "a texture of type 99");
    check(
        "1 1 1 0 0 0 1\n64 1 0 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 7",
        2,
        "surface 7",
    );
    check(
        "1 1 1 0 0 0 1\n64 0 0 1 0 0 0 0 1 0 0 0 0 0 0 0 0 0 1",
        2,
        "singular",
    );
}

#[test]
fn mistakes_in_text_are_named_with_their_lines() {
    let lines = HEAD.lines().count();
    let check = |block: &str, line: usize, expected: &str| {
        let error = load(&format!("7 1 1 -\n{block}\n\n")).expect_err(block);
        let place = format!("a.sff:{}:", lines + line + 1);
        assert!(
            error.starts_with(&place) && error.contains(expected),
            "{error}"
        );
    };
    let set =
        "SPACING .1\nSCALE 1 1 1\nORIENTATION 1 0 0 0 1 0 0 0 1\nFONT f.ppf\nENCODING f.ppe\n";
    check("AT 0 0 0 \"A\"", 1, "AT before any SPACING");
    check(
        "SPACING 1\nSCALE 1 1 1\nORIENTATION 1 0 0 0 1 0 0 0 1\nAT 0 0 0 \"A\"",
        4,
        "any FONT",
    );
    check(
        "SCALE 1 0 1",
        1,
        "found SCALE 1 0 1, expected three positive numbers",
    );
    check("ORIENTATION 1 0 0 2 0 0 0 0 1", 1, "parallel");
    check("ORIENTATION 1 0 0 0 1 0 1 1 0", 1, "in one plane");
    check("SCALE 1 1\nFONT f.ppf", 1, "found SCALE with 2 numbers");
    check(
        "BOLD",
        1,
        "expected SPACING, SCALE, ORIENTATION, FONT, ENCODING or AT",
    );
    check("FONT g.ppf", 1, "\"g.ppf\", which cannot be read");
    check(&format!("{set}AT 0 0 0 \"C\""), 6, "names no glyph for `C`");
    check(&format!("{set}AT 0 0 0 \"A/no/\""), 6, "no glyph `no`");
    check(
        &format!("{set}AT 0 0 0 \"A"),
        6,
        "a string without its closing quote",
    );
    check(&format!("{set}AT 0 0 0 A"), 6, "AT without a string");
}

/// The two scenes of the paper, including misprints.
#[test]
fn the_papers_scenes() {
    let head = "SPACING 0.1  # espaco\nSCALE 3 3 3\n";
    let check = |block: &str, expected: Result<usize, &str>| {
        let result = load(&format!("7 1 1 -\n{block}\n")).map(|l| l.scene);
        match (result, expected) {
            (Ok(scene), Ok(count)) => {
                let Shape::Exact(text) = &scene.objects[0].shape else {
                    panic!("text is exact");
                };
                assert_eq!(text.solids.len(), count);
            }
            (Err(error), Err(expected)) => assert!(error.contains(expected), "{error}"),
            (result, _) => panic!("{result:?}"),
        }
    };
    let line = "ORIENTATION 1 0 0 0 1 0 0 0";
    let first = format!("{head}{line}\nFONT f.ppf\nENCODING-f.ppe\nAT .8 0 -3 \"AB\"\n");
    check(&first, Err("found ORIENTATION with 8 numbers, expected 9"));
    check(&first, Err(line));
    let mended = first.replace("0 0 0\nFONT", "0 0 0 -1\nFONT");
    check(
        &mended,
        Err("found \"ENCODING-f.ppe\", expected a blank: ENCODING f.ppe"),
    );
    let mended = mended.replace("ENCODING-", "ENCODING ");
    check(&mended, Ok(2));
    check(
        &mended.replace("\nAT", "\n[...]\nAT"),
        Err("found \"[...]\", expected SPACING"),
    );
    let second = "spacing 0.2\nscale 2 2 1\norientation 1 1 0  0 0 1  -1 1 0\nfont f.ppf\n\
        encoding f.ppe\nat 0 0 0 \"A B\"\nat 0 0 -2 \"/bow/A\"\n";
    check(second, Ok(4));
}

#[test]
fn liberties() {
    let check = |objects: &str, count: usize, warnings: &[&str]| {
        let loaded = load(objects).unwrap_or_else(|e| panic!("{e}"));
        let add_lights = 2;
        assert_eq!(loaded.scene.objects.len(), count + add_lights, "{objects}");
        let messages: Vec<&str> = loaded.warnings.iter().map(|w| &*w.message).collect();
        assert_eq!(messages, warnings);
    };
    check(
        "1 1 1 0 0 0 1 - a remark\r\n# another\r\n1 1 1\r\n0 0 0 1\r\n \t\r\nend",
        2,
        &[],
    );
    check(
        "1 1 .5 0 0 0 1",
        1,
        &["index of refraction below 1: taken as 1"],
    );
    let moved = "65 0 1 0 0 0 0 1 0 0 0 0 1 0 .1 0 0 1";
    let perspective = "transform with perspective: only its affine part is used";
    check(&format!("1 1 1 0 0 0 1\n{moved}"), 1, &[perspective]);
    check("1 1 1 0 0 0 1\n\nend\nDemo / 11-OCT-1989", 1, &[]);
    check(
        "5 1 1 0 0 0 1 1 1 -\n\n\n",
        0,
        &["object without any shape: skipped"],
    );
}

#[test]
fn any_scene_is_written_as_far_as_it_goes() {
    let scene = azulejo_scene::synthetic::cornell_box(
        azulejo_scene::synthetic::CornellVariant::MirrorBlock,
    );
    let read = again(&scene);
    assert_eq!(read.objects.len(), scene.objects.len());
    assert!(!sff::losses(&scene).is_empty());
}

/// Operations at the maximum depth, on the stack of a test thread.
#[test]
fn deep_nests_are_read_and_written() {
    let mut objects = "66 0 0 0 1\n".repeat(255);
    objects += "1 1 1 0 0 0 1\n";
    objects += &"66 1\n2 1 1 0 0 0 .5 .5 .5\n66 2\n".repeat(255);
    round_trip(&objects);
}

/// Any modified file is read or rejected, and what is read is valid.
#[test]
fn damaged_files() {
    let set = "7 1 1 -\nSPACING .1 SCALE 2 3 .5 ORIENTATION 1 1 0 0 0 1 -1 1 .2\nFONT f.ppf ENCODING f.ppe\nAT 1 2 3 \"AB\"\n\n";
    let text = format!("{HEAD}{set}{PATCH}{CSG}{TEXTURES}");
    let options = ReadOptions::in_proportion(text.len());
    let files = files();
    let check = |bytes: &[u8]| {
        if let Ok(loaded) = sff::read(bytes, "a.sff", &files, &options) {
            loaded
                .scene
                .validate()
                .expect("a reader gives valid scenes");
            let mut text = Vec::new();
            sff::write(&loaded.scene, "a", &mut text).expect("memory takes everything");
        }
    };
    let mut bytes = text.into_bytes();
    // Steps coprime to the lengths of lines reach every type of field.
    for at in (0..bytes.len()).step_by(13) {
        check(&bytes[..at]);
        let byte = bytes[at];
        for other in [b'0', b'9', b'-', b'\n', b'e', 0xff] {
            bytes[at] = other;
            check(&bytes);
        }
        bytes[at] = byte;
    }
}
