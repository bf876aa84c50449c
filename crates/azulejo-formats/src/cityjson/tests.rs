//! Small models, damaged ones, and the positions of errors.

use super::read;
use crate::{Loaded, Lod, Memory, Position, ReadError, ReadOptions};
use azulejo_scene::{Mesh, Rgb, Scene, Shape};
use glam::DVec3;
use proptest::prelude::*;

/// A cube of edge 2 in national coordinates whose roof has a hole, with a shed that has no semantics.
const CUBE: &str = r#"{
"type": "CityJSON", "version": "2.0",
"transform": {"scale": [0.001, 0.001, 0.001], "translate": [85000.0, 446000.0, -1.0]},
"CityObjects": {
 "b-7": {"type": "Building", "geometry": [
  {"type": "MultiSurface", "lod": "0", "boundaries": [[[0, 3, 2, 1]]]},
  {"type": "Solid", "lod": "2.2", "boundaries": [[
   [[0, 3, 2, 1]], [[4, 5, 6, 7], [8, 9, 10, 11]],
   [[0, 1, 5, 4]], [[1, 2, 6, 5]], [[2, 3, 7, 6]], [[3, 0, 4, 7]]]],
   "semantics": {"surfaces": [{"type": "WallSurface"}, {"type": "RoofSurface"}, {"type": "GroundSurface"}],
    "values": [[2, 1, 0, 0, 0, null]]}}]},
 "shed": {"type": "Building", "geometry": [
  {"type": "CompositeSurface", "lod": "1", "boundaries": [[[0, 1, 5, 4, 0]]]}]}
},
"vertices": [[0,0,0],[2000,0,0],[2000,2000,0],[0,2000,0],[0,0,2000],[2000,0,2000],[2000,2000,2000],[0,2000,2000],
 [500,500,2000],[500,1500,2000],[1500,1500,2000],[1500,500,2000]]
}"#;

fn load_with(text: &str, lod: Lod) -> Result<Loaded, ReadError> {
    let options = ReadOptions {
        lod,
        ..ReadOptions::default()
    };
    let loaded = read(text.as_bytes(), "a.json", &Memory::new(), &options);
    if let Ok(loaded) = &loaded {
        loaded.scene.validate().unwrap();
    }
    loaded
}

fn load(text: &str) -> Loaded {
    load_with(text, Lod::Finest).unwrap()
}

fn names(scene: &Scene) -> Vec<&str> {
    scene.objects.iter().map(|o| &*o.name).collect()
}

fn mesh<'s>(scene: &'s Scene, name: &str) -> &'s Mesh {
    let object = scene.objects.iter().find(|o| o.name == name);
    match &object.unwrap_or_else(|| panic!("no {name}")).shape {
        Shape::Mesh(mesh) => mesh,
        other => panic!("{other:?}"),
    }
}

fn messages(loaded: &Loaded) -> Vec<String> {
    loaded.warnings.iter().map(ToString::to_string).collect()
}

#[test]
fn surfaces_by_their_types() {
    let loaded = load(CUBE);
    let scene = &loaded.scene;
    let expected = [
        "b-7 GroundSurface",
        "b-7 RoofSurface",
        "b-7 WallSurface",
        "b-7",
        "shed",
    ];
    assert_eq!(names(scene), expected);
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let area = |name: &str| mesh(scene, name).area();
    let areas = expected.map(|name| (area(name) * 1e6).round() / 1e6);
    assert_eq!(areas, [4.0, 3.0, 12.0, 4.0, 4.0]);
    let wall = mesh(scene, "b-7 WallSurface");
    assert_eq!((wall.faces.len(), wall.positions.len()), (3, 8));
    // Outward, and where the file says it is.
    assert!(
        wall.face_area_vector(0)
            .distance(DVec3::new(0.0, -4.0, 0.0))
            < 1e-6
    );
    assert_eq!(scene.bounds().min, DVec3::new(85000.0, 446_000.0, -1.0));
    assert_eq!(scene.bounds().max, DVec3::new(85002.0, 446_002.0, 1.0));
    let materials: Vec<&str> = scene.materials.iter().map(|m| &*m.name).collect();
    let expected = ["GroundSurface", "RoofSurface", "WallSurface", "Building"];
    assert_eq!(materials, expected);
}

#[test]
fn a_hole_is_open() {
    let loaded = load(CUBE);
    let roof = mesh(&loaded.scene, "b-7 RoofSurface");
    let centre = DVec3::new(85001.0, 446_001.0, 1.0);
    let covers = |corners: [DVec3; 3]| {
        let [a, b, c] = corners;
        let side = |a: DVec3, b: DVec3| (b - a).cross(centre - a).z >= 0.0;
        side(a, b) && side(b, c) && side(c, a)
    };
    let corners = roof.face_positions(0);
    let triangles = roof.triangulate(0);
    let covered = triangles
        .iter()
        .filter(|t| covers(t.map(|k| corners[k as usize])));
    assert_eq!((triangles.len(), covered.count()), (8, 0));
}

/// A building with a square at each of these levels, one metre longer from one to the next.
fn levels(levels: &[&str]) -> String {
    let geometries: Vec<String> = levels
        .iter()
        .enumerate()
        .map(|(k, level)| {
            let (a, b) = (2 * k + 2, 2 * k + 3);
            format!(r#"{{"type":"MultiSurface","lod":{level},"boundaries":[[[0,{a},{b},1]]]}}"#)
        })
        .collect();
    let vertices: Vec<String> = (0..=levels.len())
        .map(|k| format!("[{k},0,0],[{k},1,0]"))
        .collect();
    format!(
        r#"{{"type":"CityJSON","version":"1.0","CityObjects":{{"a":{{"type":"Building","geometry":[{}]}}}},"vertices":[{}]}}"#,
        geometries.join(","),
        vertices.join(",")
    )
}

#[test]
fn one_level_of_detail() {
    let check = |given: &[&str], lod: Lod, area: f64| {
        let loaded = load_with(&levels(given), lod).unwrap();
        let actual = mesh(&loaded.scene, "a").area();
        assert!((actual - area).abs() < 1e-9, "{given:?} {lod:?}: {actual}");
    };
    let levels = ["\"0.1\"", "\"1.3\"", "\"2.2\"", "\"3\""];
    check(&levels, Lod::Finest, 3.0);
    check(&levels, Lod::Distance(100.0), 3.0);
    check(&levels, Lod::Coarsest, 1.0);
    check(&levels, Lod::All, 10.0);
    check(&levels, Lod::Numbered(1.3), 2.0);
    check(&levels, Lod::Numbered(3.3), 4.0);
    check(&levels, Lod::Numbered(2.0), 2.0);
    check(&levels, Lod::Numbered(0.0), 1.0);
    // Numbers, as in version 1.0; and level 3 rather than a footprint.
    check(&["2", "1", "2.1"], Lod::Finest, 3.0);
    check(&["0", "3.2", "3.1"], Lod::Finest, 3.0);
    check(&["\"none\"", "0"], Lod::Finest, 2.0);
}

#[test]
fn a_building_is_not_read_beside_its_parts() {
    let object = |id: &str, rest: &str, lod: &str| {
        format!(
            r#""{id}": {{{rest}, "geometry": [{{"type": "MultiSurface", "lod": "{lod}", "boundaries": [[[0,1,2]]]}}]}}"#
        )
    };
    let check = |objects: &[String], expected: &[&str], left_out: usize| {
        let text = format!(
            r#"{{"type":"CityJSON","version":"1.1","CityObjects":{{{}}},"vertices":[[0,0,0],[1,0,0],[0,1,0]]}}"#,
            objects.join(",")
        );
        let loaded = load(&text);
        assert_eq!(names(&loaded.scene), expected);
        let count: usize = loaded.warnings.iter().map(|w| w.count).sum();
        assert_eq!(count, left_out, "{:?}", loaded.warnings);
    };
    let parent = |lod: &str| object("a", r#""type": "Building", "children": ["a-1"]"#, lod);
    let part = |kind: &str, lod: &str| {
        object(
            "a-1",
            &format!(r#""type": "{kind}", "parents": ["a"]"#),
            lod,
        )
    };
    check(&[parent("0"), part("BuildingPart", "2.2")], &["a-1"], 1);
    check(&[parent("1.2"), part("BuildingPart", "2.2")], &["a-1"], 1);
    check(
        &[parent("2"), part("BuildingPart", "2.2")],
        &["a", "a-1"],
        0,
    );
    let kind = "BuildingInstallation";
    check(&[parent("1"), part(kind, "2.2")], &["a", "a-1"], 0);
    // Parents of each other.
    let cycle = |id: &str, parent: &str, lod: &str| {
        object(
            id,
            &format!(r#""type": "BuildingPart", "parents": ["{parent}"]"#),
            lod,
        )
    };
    check(&[cycle("x", "y", "1"), cycle("y", "x", "2")], &["y"], 1);
    check(&[cycle("x", "x", "1")], &["x"], 0);
}

#[test]
fn solids_in_solids() {
    let text = r#"{"type":"CityJSON","version":"1.1","CityObjects":{"a":{"type":"Bridge","geometry":[
        {"type":"MultiSolid","lod":"2","boundaries":[[[[[0,1,2]],[[0,2,3]]]],[[[[0,1,3]]]]],
         "semantics":{"surfaces":[{"type":"WallSurface"},{"type":"RoofSurface"}],"values":[[[0,1]],null]}},
        {"type":"MultiLineString","lod":"2","boundaries":[[0,1]]},
        {"type":"Blob","lod":"2","boundaries":[[0,1]]}]}},
        "vertices":[[0,0,0],[1,0,0],[0,1,0],[0,0,1]]}"#;
    let loaded = load(text);
    let expected = ["a WallSurface", "a RoofSurface", "a"];
    assert_eq!(names(&loaded.scene), expected);
    let expected = [
        "a.json:4:9: points and lines: skipped",
        "a.json:5:9: geometry of an unknown type: skipped",
    ];
    assert_eq!(messages(&loaded), expected);
}

#[test]
fn sequences_of_features() {
    let header = r#"{"type":"CityJSON","version":"2.0","transform":{"scale":[0.5,0.5,0.5],"translate":[10,0,0]},"CityObjects":{},"vertices":[]}"#;
    let feature = |id: &str, x: u32| {
        format!(
            r#"{{"type":"CityJSONFeature","id":"{id}","CityObjects":{{"{id}":{{"type":"Building","geometry":[{{"type":"MultiSurface","lod":"2","boundaries":[[[0,1,2]]]}}]}}}},"vertices":[[{x},0,0],[4,0,0],[0,2,0]]}}"#
        )
    };
    let text = format!("{header}\n{}\n{}\n", feature("a", 0), feature("b", 2));
    let loaded = load(&text);
    assert_eq!(names(&loaded.scene), ["a", "b"]);
    assert_eq!(mesh(&loaded.scene, "a").area(), 1.0);
    assert_eq!(
        mesh(&loaded.scene, "b").positions[0],
        DVec3::new(11.0, 0.0, 0.0)
    );
    let wrong = format!("{header}\n{header}");
    let error = load_with(&wrong, Lod::Finest).unwrap_err();
    assert_eq!(error.position, Position::Line(2, 1));
    assert!(error.expected.contains("CityJSONFeature"), "{error}");
}

fn trees(matrix: &str) -> String {
    format!(
        r#"{{"type":"CityJSON","version":"1.1","transform":{{"scale":[0.1,0.1,0.1],"translate":[0,0,0]}},
        "geometry-templates":{{"templates":[{{"type":"MultiSurface","lod":"2","boundaries":[[[0,1,2]]]}}],
         "vertices-templates":[[0,0,0],[2,0,0],[0,1,0]]}},
        "CityObjects":{{"t":{{"type":"SolitaryVegetationObject","geometry":[
         {{"type":"GeometryInstance","template":0,"boundaries":[1],"transformationMatrix":{matrix}}},
         {{"type":"GeometryInstance","template":0,"boundaries":[0]}}]}}}},
        "vertices":[[0,0,0],[100,0,50]]}}"#
    )
}

#[test]
fn templates_at_their_places() {
    let loaded = load(&trees("[2,0,0,1, 0,2,0,0, 0,0,2,0, 0,0,0,1]"));
    let tree = mesh(&loaded.scene, "t");
    let corners = tree.face_positions(0);
    let expected = [
        DVec3::new(11.0, 0.0, 5.0),
        DVec3::new(15.0, 0.0, 5.0),
        DVec3::new(11.0, 2.0, 5.0),
    ];
    assert_eq!(corners, expected);
    assert_eq!(tree.face_area_vector(1), DVec3::new(0.0, 0.0, 1.0));
    // A mirrored template keeps its front.
    let loaded = load(&trees("[-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]"));
    let tree = mesh(&loaded.scene, "t");
    assert_eq!(tree.face_area_vector(0), DVec3::new(0.0, 0.0, 1.0));
    let refuse = |matrix: &str| {
        let error = load_with(&trees(matrix), Lod::Finest).unwrap_err();
        assert!(error.expected.starts_with("16 numbers"), "{error}");
        assert_eq!(error.position, Position::Line(5, 90), "{error}");
    };
    refuse("[1,0,0]");
    refuse("[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,1,1]");
    let wrong = trees("[]").replace("\"template\":0", "\"template\":1");
    let error = load_with(&wrong, Lod::Finest).unwrap_err();
    assert!(error.expected.contains("1 templates"), "{error}");
    let wrong = trees("[]").replace("\"boundaries\":[1]", "\"boundaries\":[2]");
    let error = load_with(&wrong, Lod::Finest).unwrap_err();
    assert!(error.found.contains("without a place"), "{error}");
}

/// Many templates of many surfaces: counted before they are kept.
#[test]
fn instances_are_counted() {
    let rings = vec!["[[0,1,2]]"; 400].join(",");
    let places =
        vec![r#"{"type":"GeometryInstance","template":0,"boundaries":[0]}"#; 400].join(",");
    let text = format!(
        r#"{{"type":"CityJSON","version":"1.1","geometry-templates":{{"templates":[{{"type":"MultiSurface","lod":"2","boundaries":[{rings}]}}],"vertices-templates":[[0,0,0],[2,0,0],[0,1,0]]}},"CityObjects":{{"t":{{"type":"X","geometry":[{places}]}}}},"vertices":[[0,0,0]]}}"#
    );
    let options = ReadOptions::in_proportion(text.len());
    let error = read(text.as_bytes(), "a.json", &Memory::new(), &options).unwrap_err();
    assert!(error.found.contains("expand"), "{error}");
    let faces = mesh(&load(&text).scene, "t").faces.len();
    assert_eq!(faces, 160_000);
}

#[test]
fn colours_of_materials() {
    let text = r#"{"type":"CityJSON","version":"2.0","appearance":{"materials":[
        {"name":"brick","diffuseColor":[0.6,0.2,1.5]},{"name":"plain"}]},
        "CityObjects":{"a":{"type":"Building","geometry":[
         {"type":"MultiSurface","lod":"2","boundaries":[[[0,1,2]],[[0,1,2]],[[0,1,2]]],
          "material":{"winter":{"values":[0,1,null]},"summer":{"value":1}},
          "texture":{"winter":{"values":[]}}},
         {"type":"MultiSurface","lod":"2","boundaries":[[[0,1,2]]],"material":{"x":{"value":0}}}]}},
        "vertices":[[0,0,0],[1,0,0],[0,1,0]]}"#;
    let loaded = load(text);
    let scene = &loaded.scene;
    let names: Vec<&str> = scene.materials.iter().map(|m| &*m.name).collect();
    assert_eq!(names, ["brick", "Building"]);
    assert_eq!(scene.materials[0].diffuse, Rgb::from([0.6, 0.2, 1.0]));
    assert_eq!(mesh(scene, "a").face_materials, [0, 1, 1, 0]);
    assert_eq!(messages(&loaded), ["a.json:4:10: textures: skipped"]);
}

#[test]
fn what_is_skipped_and_what_is_refused() {
    let with = |boundaries: &str, vertices: &str| {
        format!(
            r#"{{"type":"CityJSON","version":"0.9","CityObjects":{{"a":{{"type":"Road","geometry":[{{"type":"MultiSurface","lod":"2","boundaries":{boundaries}}}]}}}},"vertices":{vertices}}}"#
        )
    };
    let square = "[[0,0,0],[4,0,0],[4,4,0],[0,4,0],[9,9,0],[10,9,0],[9,10,0]]";
    let text = with("[[[0,1,1,0]],[],[[0,1,2,3],[5,5,5],[4,5,6]]]", square);
    let actual: Vec<String> = load(&text)
        .warnings
        .into_iter()
        .map(|w| w.message)
        .collect();
    let expected = [
        "version that is not 1.0, 1.1 or 2.0: read as 2.0",
        "surface with fewer than three corners: skipped",
        "hole with fewer than three corners: filled",
        "hole outside of its surface: filled",
    ];
    assert_eq!(actual, expected);
    let refuse = |text: &str, column: usize, expected: &str| {
        let error = load_with(text, Lod::Finest).unwrap_err();
        assert!(error.expected.contains(expected), "{error}");
        assert_eq!(
            error.position,
            Position::Line(1, column as u32 + 1),
            "{error}"
        );
    };
    let text = with("[[[0,1,7]]]", square);
    refuse(&text, text.find("7]").unwrap(), "one of the 7 vertices");
    let text = with("[[[0,1,-1]]]", square);
    refuse(&text, text.find("-1").unwrap(), "one of the 7 vertices");
    let text = with("[]", "[[0,0,0],[1,2]]");
    refuse(&text, text.find("[1,2]").unwrap(), "three coordinates");
    let text = with("[]", "[[0,0,1e999]]");
    refuse(&text, text.find("[0,0,1e").unwrap(), "three coordinates");
    refuse("{\"type\":\"Feature\"}", 0, "CityJSON");
    let empty = load(r#"{"type":"CityJSON","version":"1.1","CityObjects":{},"vertices":[]}"#);
    assert_eq!(
        messages(&empty),
        ["a.json: no surfaces: the scene is empty"]
    );
}

#[test]
fn every_prefix() {
    for end in 0..CUBE.len() {
        assert!(load_with(&CUBE[..end], Lod::Finest).is_err(), "{end}");
    }
}

proptest! {
    /// Any change of a byte gives an error or a valid scene.
    #[test]
    fn damaged(at in 0..CUBE.len(), byte in any::<u8>()) {
        let mut bytes = CUBE.as_bytes().to_vec();
        bytes[at] = byte;
        if let Ok(loaded) = read(&bytes, "a.json", &Memory::new(), &ReadOptions::default()) {
            prop_assert!(loaded.scene.validate().is_ok());
        }
    }

    /// Boxes of any size and place have the surface of a box.
    #[test]
    fn boxes(size in [1u32..5000, 1u32..5000, 1u32..5000], at in [-1e6f64..1e6, -1e6f64..1e6, -1e6f64..1e6]) {
        let [x, y, z] = size;
        let text = CUBE
            .replace("[85000.0, 446000.0, -1.0]", &format!("{at:?}"))
            .replace("[1500,500,2000]]", &format!("[1500,500,2000],[0,0,0],[{x},0,0],[{x},{y},0],[0,{y},0],[0,0,{z}],[{x},0,{z}],[{x},{y},{z}],[0,{y},{z}]]"))
            .replace("[[[0, 1, 5, 4, 0]]]", "[[[12,15,14,13]],[[16,17,18,19]],[[12,13,17,16]],[[13,14,18,17]],[[14,15,19,18]],[[15,12,16,19]]]");
        let loaded = load(&text);
        let shed = mesh(&loaded.scene, "shed");
        let [x, y, z] = [x, y, z].map(|v| f64::from(v) / 1000.0);
        let area = 2.0 * (x * y + y * z + z * x);
        prop_assert!((shed.area() - area).abs() < 1e-5 * (1.0 + area));
        prop_assert!(shed.is_closed());
    }
}
