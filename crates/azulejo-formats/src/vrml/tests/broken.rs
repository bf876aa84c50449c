//! Damaged, unusual and hostile files.

use super::*;

const QUAD: &str = "IndexedFaceSet { coord Coordinate { point [ 0 0 0, 1 0 0, 1 1 0, 0 1 0 ] } coordIndex [ 0 1 2 3 ] }";

fn error(text: &str) -> String {
    let options = ReadOptions {
        most_elements: 100_000,
        ..ReadOptions::default()
    };
    let read = super::super::read(text.as_bytes(), "model.wrl", &Memory::new(), &options);
    read.unwrap_err().to_string()
}

#[test]
fn a_file_that_ends_too_soon_keeps_what_it_has() {
    let whole = format!(
        "{} Group {{ children [ {} ] }}",
        shape(QUAD),
        shape("Box { }")
    );
    let cut = &whole[..whole.len() - 7];
    let (scene, warnings) = load(cut);
    assert_eq!(scene.objects.len(), 2);
    let warning = "the file ends inside a node: what precedes the end is used";
    assert!(warnings.iter().any(|w| w.contains(warning)), "{warnings:?}");
    // Any truncation is handled.
    for end in 0..whole.len() {
        let text = format!("#VRML V2.0 utf8\n{}", &whole[..end]);
        let read = super::super::read(
            text.as_bytes(),
            "a",
            &Memory::new(),
            &ReadOptions::default(),
        );
        read.map(|loaded| loaded.scene.validate().unwrap()).ok();
    }
}

#[test]
fn an_error_costs_the_node_around_it() {
    let text = format!(
        "Group {{ children [ {} Transform {{ ] translation 1 2 3 }} {} ] }} ] {{ a }} {}",
        shape("Box { }"),
        shape("Sphere { } 4 \"x\""),
        shape(QUAD)
    );
    let objects = [
        ": Cuboid, -1 -1 -1 to 1 1 1",
        ": Sphere, -1 -1 -1 to 1 1 1",
        ": 4 vertices 1 faces, 0 0 0 to 1 1 0",
    ];
    let (scene, warnings) = load(&text);
    assert_eq!(described(&scene), objects, "{warnings:?}");
    assert!(
        warnings[0].contains("found \"]\", expected a field of Transform"),
        "{warnings:?}"
    );
}

#[test]
fn indices_beyond_the_coordinates_cost_their_faces() {
    let geometry = "IndexedFaceSet { coord Coordinate { point [ 0 0 0, 1 0 0, 1 1 0, x 1 0, 7 ] }
        coordIndex [ 0 1 2 -1 0 1 9 -1 0 1 -1 -1 0 2 3 ] }";
    let warnings = [
        ":2:131: word or string in a list of numbers",
        ":2:89: position that is not three finite numbers",
        ":2:66: face with fewer than three corners",
        ":2:66: face with a coordIndex out of range",
    ];
    check_lossy(
        &shape(geometry),
        &[": 4 vertices 2 faces, 0 0 0 to 1 1 0"],
        &warnings,
    );
}

#[test]
fn nothing_usable_is_an_error() {
    let check = |text: &str, expected: &str| {
        let message = error(text);
        assert!(message.contains(expected), "{message}");
    };
    check(
        "#VRML V2.0 utf8\n ]",
        "model.wrl:2:2: found \"]\", expected a node",
    );
    check("Group { }", "found \"Group\", expected \"#VRML V");
    check("<X3D><head/></X3D>", "found XML without a Scene element");
    check("<X3D>\n <Scene", "found malformed XML");
    check(
        "<!DOCTYPE X3D [<!ENTITY a 'b'>]><X3D/>",
        "declares entities",
    );
}

#[test]
fn no_geometry_is_said() {
    check_lossy("", &[], &[": the model contains no geometry"]);
    let warnings = [
        ":2:1: choice of Switch is not a node",
        ": the model contains no geometry",
    ];
    check_lossy("Switch { choice [ 0 ] }", &[], &warnings);
}

#[test]
fn xml_that_ends_too_soon_keeps_what_it_has() {
    let text = "<X3D version='3.3'><Scene>
        <Shape><Appearance><Material/></Appearance><Sphere/></Shape>
        <Group><Shape><Appearance><Material/></Appearance><Box/></Shape><Shape><IndexedFaceSet coordIndex='0 1 2";
    let objects = [": Sphere, -1 -1 -1 to 1 1 1", ": Cuboid, -1 -1 -1 to 1 1 1"];
    let (scene, warnings) = load(text);
    assert_eq!(described(&scene), objects);
    assert!(warnings[0].contains("malformed XML"), "{warnings:?}");
    assert!(warnings[0].starts_with("model.wrl:3:"), "{warnings:?}");
}

#[test]
fn nodes_may_not_be_too_deep() {
    let deep = |open: &str, close: &str| {
        format!(
            "{}{}{}",
            open.repeat(50_000),
            shape("Box { }"),
            close.repeat(50_000)
        )
    };
    let (_, warnings) = load(&deep("Group { children [ ", " ] }"));
    assert!(warnings[0].contains("more than 200 deep"), "{warnings:?}");
    let (_, warnings) = load(&deep("PROTO A [ ] { ", "}"));
    assert!(warnings[0].contains("more than 200 deep"), "{warnings:?}");
    let xml = format!(
        "<X3D><Scene>{}{}</Scene></X3D>",
        "<Group>".repeat(50_000),
        "</Group>".repeat(50_000)
    );
    let (_, warnings) = load(&xml);
    assert!(warnings[0].contains("more than 200 deep"), "{warnings:?}");
    // The same by names at one level.
    let chain: String = (0..1_000)
        .map(|i| format!("DEF g{} Group {{ children USE g{i} }}\n", i + 1))
        .collect();
    let (_, warnings) = load(&format!("DEF g0 Group {{ }} {chain}"));
    assert!(warnings[0].contains("more than 200 deep"), "{warnings:?}");
    let chain: String = (0..1_000)
        .map(|i| format!("PROTO P{} [ ] {{ P{i} {{ }} }}\n", i + 1))
        .collect();
    let (_, warnings) = load(&format!(
        "PROTO P0 [ ] {{ {} }} {chain} P150 {{ }}",
        shape("Box { }")
    ));
    assert!(warnings[0].contains("more than 200 deep"), "{warnings:?}");
}

#[test]
fn what_unfolds_without_end_is_refused() {
    let twice: String = (0..60)
        .map(|i| {
            format!(
                "DEF g{} Group {{ children [ USE g{i} USE g{i} ] }}\n",
                i + 1
            )
        })
        .collect();
    let bomb = format!("#VRML V2.0 utf8\nDEF g0 Group {{ }} {twice}");
    assert!(error(&bomb).contains("more than 100000"));
    let cross = "0 1 ".repeat(2000);
    let spine = "0 1 2 ".repeat(2000);
    let extrusion = format!(
        "#VRML V2.0 utf8\n{}",
        shape(&format!(
            "Extrusion {{ crossSection [ {cross} ] spine [ {spine} ] }}"
        ))
    );
    assert!(error(&extrusion).contains("more than 100000"));
    let grid =
        shape("ElevationGrid { xDimension 2000000000 zDimension 2000000000 height [ 1 2 3 ] }");
    check_lossy(
        &grid,
        &[],
        &[
            ":2:66: incomplete row of an ElevationGrid",
            ":2:66: node ElevationGrid: skipped",
            ": the model contains no geometry",
        ],
    );
}

#[test]
fn numbers_that_are_none_do_no_harm() {
    let text = format!(
        "Transform {{ translation nan 1 2 scale 1e308 1e308 1e308 children Transform {{ scale 1e308 1 1 children [ {} {} ] }} }}
         Transform {{ scale 0 1 1 children [ {} {} Viewpoint {{ orientation 0 1 0 1.5707963267948966 }} ] }}
         Fog {{ visibilityRange inf }} Background {{ skyColor -1.#IND 1 1 }}",
        shape("Box { }"),
        shape(QUAD),
        shape("Sphere { radius 0 }"),
        shape(QUAD)
    );
    let (scene, warnings) = load(&text);
    assert_eq!(described(&scene), [": 4 vertices 1 faces, 0 0 0 to 0 1 0"]);
    let lost = warnings
        .iter()
        .filter(|w| w.contains("with a singular or overflowing"));
    assert_eq!(lost.count(), 3, "{warnings:?}");
}

/// The parser of XML compares all attributes of an element, and looks prefixes up in a list.
#[test]
fn crowded_elements_are_refused() {
    let error = |text: &str| {
        let options = ReadOptions::default();
        let read = super::super::read(text.as_bytes(), "a.x3d", &Memory::new(), &options);
        read.unwrap_err().to_string()
    };
    let many = |kind: &str, count: usize| -> String {
        let names = (0..count).map(|k| format!(" {kind}{k}='u{k}'"));
        names.collect()
    };
    let shape = format!("<X3D>\n<Scene><Shape{}/></Scene></X3D>", many("a", 300_000));
    let message = error(&shape);
    assert!(message.starts_with("a.x3d:2:8"), "{message}");
    assert!(message.contains("more than 1000 attributes"), "{message}");
    let spaces = many("xmlns:a", 60_000);
    let groups = "<a59999:Group/>".repeat(300_000);
    let message = error(&format!("<X3D{spaces}><Scene>{groups}</Scene></X3D>"));
    assert!(message.contains("more than"), "{message}");
    let nested: String = (0..60_000)
        .map(|k| format!("<Group xmlns:a{k}='u{k}'>"))
        .collect();
    let message = error(&format!("<X3D><Scene>{nested}"));
    assert!(message.contains("more than 256 namespaces"), "{message}");
}

/// Children in fields of their own, and fields of a prototype that are connected one by one.
#[test]
fn very_many_fields_take_no_quadratic_time() {
    let groups: String = (0..200_000)
        .map(|k| format!("<Group containerField='c{k}'/>"))
        .collect();
    let text = format!("<X3D><Scene><Group>{groups}<Shape><Box/></Shape></Group></Scene></X3D>");
    let read = super::super::read(
        text.as_bytes(),
        "a.x3d",
        &Memory::new(),
        &ReadOptions::default(),
    );
    assert_eq!(read.unwrap().scene.objects.len(), 1);
    let list = |item: fn(usize) -> String| (0..150_000).map(item).collect::<String>();
    let interface = list(|k| format!("field SFInt32 f{k} 1 "));
    let connected = list(|k| format!("a{k} IS f{k} "));
    let given = list(|k| format!("f{k} 2 "));
    let (scene, _) = load(&format!(
        "PROTO P [ {interface} ] {{ Shape {{ {connected} geometry Box {{}} }} }} P {{ {given} }}"
    ));
    assert_eq!(scene.objects.len(), 1);
}
