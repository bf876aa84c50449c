//! What is written, read by another parser of XML.

use super::*;
use azulejo_scene::synthetic::cube_room;
use azulejo_scene::{Material, Mesh, Object, Primitive, Rgb, Scene, Shape, Units, Up};
use flate2::read::DeflateDecoder;
use glam::DVec3;
use roxmltree::{Document, Node};
use std::io::Read;

/// The parts of a package by name, as its local headers give them.
fn parts(package: &[u8]) -> Vec<(String, String)> {
    let number = |at: usize, n: usize| {
        package[at..at + n]
            .iter()
            .rev()
            .fold(0, |sum, b| sum << 8 | usize::from(*b))
    };
    let (mut at, mut parts) = (0, Vec::new());
    while number(at, 4) == 0x0403_4b50 {
        let (size, length, name) = (number(at + 18, 4), number(at + 22, 4), number(at + 26, 2));
        let data = at + 30 + name;
        let mut text = String::new();
        DeflateDecoder::new(&package[data..data + size])
            .read_to_string(&mut text)
            .unwrap();
        assert_eq!(text.len(), length);
        let mut crc = flate2::Crc::new();
        crc.update(text.as_bytes());
        assert_eq!(crc.sum() as usize, number(at + 14, 4));
        let name = String::from_utf8(package[at + 30..data].to_vec()).unwrap();
        parts.push((name, text));
        at = data + size;
    }
    let end = package.len() - 22;
    assert_eq!(
        (number(end, 4), number(end + 8, 2)),
        (0x0605_4b50, parts.len())
    );
    assert_eq!(number(end + 16, 4), at, "where the directory begins");
    assert_eq!(number(end + 12, 4), end - at);
    parts
}

fn model_of(scene: &Scene) -> String {
    let mut package = Vec::new();
    write(scene, &mut package).unwrap();
    let mut parts = parts(&package);
    let names: Vec<&str> = parts.iter().map(|p| p.0.as_str()).collect();
    assert_eq!(
        names,
        ["[Content_Types].xml", "_rels/.rels", "3D/3dmodel.model"]
    );
    for (_, text) in &parts {
        Document::parse(text).unwrap();
    }
    parts.pop().unwrap().1
}

/// The triangles of an object, and its area and volume.
fn measured(object: Node) -> (usize, f64, f64) {
    let all = |name: &'static str| object.descendants().filter(move |n| n.has_tag_name(name));
    let number = |node: Node, name: &str| node.attribute(name).unwrap().parse::<f64>().unwrap();
    let vertices: Vec<DVec3> = all("vertex")
        .map(|v| DVec3::new(number(v, "x"), number(v, "y"), number(v, "z")))
        .collect();
    let (mut count, mut area, mut volume) = (0, 0.0, 0.0);
    for t in all("triangle") {
        let [a, b, c] = ["v1", "v2", "v3"].map(|k| vertices[number(t, k) as usize]);
        count += 1;
        area += 0.5 * (b - a).cross(c - a).length();
        volume += a.dot(b.cross(c)) / 6.0;
    }
    (count, area, volume)
}

/// A box of quadrilaterals, each of its faces in one of two materials.
fn crate_scene() -> Scene {
    let mut scene = Scene::default();
    let materials = [
        Material::diffuse("red \"wood\" & <more>", Rgb::new(1.0, 0.0, 0.0)),
        Material::diffuse("", Rgb::grey(0.5)),
    ];
    let ids = materials.map(|m| scene.add_material(m));
    let corner = |k: u32| {
        let bit = |b: u32| f64::from(k >> b & 1);
        DVec3::new(2.0 * bit(0), 3.0 * bit(1), 0.1 * bit(2))
    };
    let mut mesh = Mesh {
        positions: (0..8).map(corner).collect(),
        ..Mesh::default()
    };
    let faces = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    for (k, face) in faces.iter().enumerate() {
        mesh.push_face(face, ids[k % 2]);
    }
    mesh.positions.push(DVec3::splat(1e9));
    scene
        .objects
        .push(Object::new("a\u{1}b/crate", Shape::Mesh(mesh)));
    scene.units = Units {
        metres_per_unit: Some(0.01),
        up: Up::Z,
        photometric: false,
    };
    scene.validate().unwrap();
    scene
}

#[test]
fn triangles_area_and_volume_are_those_of_the_scene() {
    let scene = crate_scene();
    let text = model_of(&scene);
    let xml = Document::parse(&text).unwrap();
    assert_eq!(xml.root_element().attribute("unit"), Some("centimeter"));
    let object = xml
        .descendants()
        .find(|n| n.has_tag_name("object"))
        .unwrap();
    assert_eq!(object.attribute("type"), Some("model"));
    assert_eq!(object.attribute("name"), Some("a?b/crate"));
    let (count, area, volume) = measured(object);
    assert_eq!(count, 12);
    assert!((area - 13.0).abs() < 1e-12, "{area}");
    assert!((volume - 0.6).abs() < 1e-12, "{volume}");
    // Half of the faces have the other material; the unused vertex is not there.
    let own = |n: &Node| n.attribute("p1") == Some("1") && n.attribute("pid") == Some("1");
    assert_eq!(object.descendants().filter(own).count(), 6);
    assert_eq!(
        object
            .descendants()
            .filter(|n| n.has_tag_name("vertex"))
            .count(),
        8
    );
    let bases: Vec<Node> = xml
        .descendants()
        .filter(|n| n.has_tag_name("base"))
        .collect();
    assert_eq!(bases[0].attribute("name"), Some("red \"wood\" & <more>"));
    assert_eq!(bases[0].attribute("displaycolor"), Some("#FF0000"));
    assert_eq!(bases[1].attribute("displaycolor"), Some("#BCBCBC"));
    let item = xml.descendants().find(|n| n.has_tag_name("item")).unwrap();
    assert_eq!(item.attribute("objectid"), object.attribute("id"));
    assert_eq!(losses(&scene), ["1 meshes whose polygons become triangles"]);
}

#[test]
fn y_up_is_turned_and_odd_units_are_converted() {
    let mut scene = crate_scene();
    scene.units = Units {
        metres_per_unit: Some(0.5),
        up: Up::Y,
        photometric: false,
    };
    let text = model_of(&scene);
    let xml = Document::parse(&text).unwrap();
    assert_eq!(xml.root_element().attribute("unit"), Some("meter"));
    let (_, area, volume) = measured(xml.root_element());
    assert!((area - 13.0 / 4.0).abs() < 1e-12 && (volume - 0.6 / 8.0).abs() < 1e-12);
    let highest = xml
        .descendants()
        .filter_map(|n| n.attribute("z")?.parse().ok());
    assert_eq!(highest.fold(0.0, f64::max), 1.5, "y has become z");
    assert!(losses(&scene).contains(&"the unit, converted to metres".to_owned()));
    scene.units.metres_per_unit = None;
    assert!(losses(&scene).contains(&"an unknown unit, written as millimetres".to_owned()));
}

#[test]
fn every_object_is_an_item_of_the_build() {
    let mut scene = cube_room();
    let sheet = Primitive::sphere(DVec3::new(0.0, 0.0, 9.0), 1.0, 0);
    scene
        .objects
        .push(Object::new("ball", Shape::Primitive(sheet)));
    scene
        .objects
        .push(Object::new("nothing", Shape::Mesh(Mesh::default())));
    let text = model_of(&scene);
    let xml = Document::parse(&text).unwrap();
    let ids = |tag: &'static str, name: &'static str| -> Vec<&str> {
        let all = xml.descendants().filter(move |n| n.has_tag_name(tag));
        all.filter_map(|n| n.attribute(name)).collect()
    };
    assert_eq!(ids("item", "objectid"), ids("object", "id"));
    assert_eq!(ids("item", "objectid").len(), scene.objects.len() - 1);
    let ball = xml
        .descendants()
        .find(|n| n.attribute("name") == Some("ball"))
        .unwrap();
    let (_, _, volume) = measured(ball);
    let exact = 4.0 / 3.0 * std::f64::consts::PI;
    assert!((volume / exact - 1.0).abs() < 0.02, "{volume}");
    assert!(losses(&scene).contains(&"1 objects without area".to_owned()));
}

#[test]
fn an_empty_scene_is_an_empty_build() {
    let text = model_of(&Scene::default());
    assert!(text.contains("<build>\n</build>"));
}
