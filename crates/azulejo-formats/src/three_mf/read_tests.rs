//! Packages made of their parts, and packages that azulejo writes.

use super::{read, write};
use crate::reader_tests::check_warnings;
use crate::{Loaded, Memory, ReadError, ReadOptions, detect, picture::png};
use azulejo_scene::synthetic::cube_room;
use azulejo_scene::{Mesh, Rgb, Shape, Up, WrapMode};
use glam::{DVec2, DVec3};
use std::io::{Cursor, Write};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

const RELATIONS: &str = r#"<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Target="/3D/a.model" Id="r0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>"#;

const HEAD: &str = r#"<model unit="inch" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
 xmlns:m="http://schemas.microsoft.com/3dmanufacturing/material/2015/02"
 xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06">"#;

/// A triangle in the plane z = 0; `of_group` are attributes of the triangle.
fn triangle(of_group: &str) -> String {
    format!(
        r#"<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/><vertex x="0" y="1" z="0"/></vertices>
<triangles><triangle v1="0" v2="1" v3="2" {of_group}/></triangles></mesh>"#
    )
}

fn package(parts: &[(&str, &[u8])]) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in parts {
        zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// A package of one model with these resources and this build.
fn model(resources: &str, build: &str) -> Vec<u8> {
    let text = format!("{HEAD}<resources>{resources}</resources><build>{build}</build></model>");
    package(&[
        ("_rels/.rels", RELATIONS.as_bytes()),
        ("3D/a.model", text.as_bytes()),
    ])
}

fn read_package(bytes: &[u8]) -> Result<Loaded, ReadError> {
    read(bytes, "a.3mf", &Memory::new(), &ReadOptions::default())
}

fn load(bytes: &[u8]) -> Loaded {
    let loaded = read_package(bytes).unwrap();
    loaded.scene.validate().unwrap();
    loaded
}

fn check_error(bytes: &[u8], expected: &str) {
    assert_eq!(read_package(bytes).unwrap_err().to_string(), expected);
}

fn mesh(loaded: &Loaded, k: usize) -> &Mesh {
    match &loaded.scene.objects[k].shape {
        Shape::Mesh(mesh) => mesh,
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_is_written_reads_again() {
    let mut room = cube_room();
    room.units.metres_per_unit = Some(0.01);
    let mut bytes = Vec::new();
    write(&room, &mut bytes).unwrap();
    assert_eq!(detect(&bytes).map(|f| f.name()), Ok("3MF"));
    let loaded = load(&bytes);
    check_warnings(&loaded, &[]);
    let back = loaded.scene.clone().adapted(room.units);
    assert_eq!(loaded.scene.units.metres_per_unit, Some(0.01));
    assert_eq!(back.objects.len(), room.objects.len());
    for (a, b) in room.objects.iter().zip(&back.objects) {
        assert_eq!(a.name, b.name);
        let area = |shape: &Shape| shape.placed_mesh().unwrap().area();
        assert!((area(&a.shape) - area(&b.shape)).abs() < 1e-9);
    }
    for (a, b) in room.materials.iter().zip(&back.materials) {
        assert_eq!(a.name, b.name);
        // By the steps of 8 bits of sRGB.
        let off = (a.diffuse.mean() - b.diffuse.mean()).abs();
        assert!(off < 5e-3, "{off}");
    }
}

#[test]
fn components_are_placed_and_units_are_kept() {
    let resources = format!(
        r#"<object id="1" name="leaf">{}</object>
<object id="2" name="pair"><components><component objectid="1"/>
<component objectid="1" transform="0 1 0 -1 0 0 0 0 1 10 20 30"/></components></object>"#,
        triangle("")
    );
    let build = r#"<item objectid="2" transform="2 0 0 0 2 0 0 0 2 1 1 1"/><item objectid="1"/>"#;
    let loaded = load(&model(&resources, build));
    check_warnings(&loaded, &[]);
    let scene = &loaded.scene;
    assert_eq!(
        (scene.units.metres_per_unit, scene.units.up),
        (Some(0.0254), Up::Z)
    );
    let names: Vec<&str> = scene.objects.iter().map(|o| o.name.as_str()).collect();
    assert_eq!(names, ["pair/leaf", "pair/leaf", "leaf"]);
    // x becomes y, y becomes −x, then twice as large.
    let expected = [(21.0, 41.0, 61.0), (21.0, 43.0, 61.0), (19.0, 41.0, 61.0)];
    for (p, e) in mesh(&loaded, 1).positions.iter().zip(expected) {
        assert!(p.distance(DVec3::from(e)) < 1e-12, "{p}");
    }
    assert_eq!(scene.materials[0].diffuse, Rgb::grey(0.5));
}

#[test]
fn mirrored_objects_keep_their_front() {
    let resources = format!(r#"<object id="1">{}</object>"#, triangle(""));
    let build = r#"<item objectid="1" transform="-1 0 0 0 1 0 0 0 1 0 0 0"/>"#;
    let loaded = load(&model(&resources, build));
    let normal = mesh(&loaded, 0).face_area_vector(0);
    assert!(normal.z > 0.0, "{normal}");
}

#[test]
fn triangles_have_materials_and_colors() {
    let groups = r##"<basematerials id="7"><base name="wood" displaycolor="#FF0000"/><base name="gold" displaycolor="#00FF0080"/></basematerials>
<m:colorgroup id="8"><m:color color="#FFFFFF"/><m:color color="#0000FF"/></m:colorgroup>
<m:compositematerials id="9" matid="7" matindices="0 1"><m:composite values="1 3"/></m:compositematerials>"##;
    let object = |id: u32, of_object: &str, of_triangle: &str| {
        format!(
            r#"<object id="{id}" {of_object}>{}</object>"#,
            triangle(of_triangle)
        )
    };
    let resources = [
        groups.to_owned(),
        object(1, r#"pid="7" pindex="1""#, ""),
        object(2, r#"pid="7" pindex="1""#, r#"p1="0""#),
        object(3, "", r#"pid="8" p1="1""#),
        object(4, "", r#"pid="8" p1="0" p2="1" p3="1""#),
        object(5, "", r#"pid="9" p1="0""#),
        object(6, "", r#"pid="7" p1="5""#),
    ]
    .concat();
    let build: String = (1..=6)
        .map(|k| format!(r#"<item objectid="{k}"/>"#))
        .collect();
    let loaded = load(&model(&resources, &build));
    check_warnings(
        &loaded,
        &[
            "a.3mf/3D/a.model:11:12: property 5 of group 7 does not exist: grey",
            "a.3mf/3D/a.model: translucent colours: opaque",
        ],
    );
    let material = |k: usize| &loaded.scene.materials[mesh(&loaded, k).face_materials[0] as usize];
    assert_eq!(
        (material(0).name.as_str(), material(0).diffuse),
        ("gold", Rgb::new(0.0, 1.0, 0.0))
    );
    assert_eq!(material(1).name, "wood");
    assert_eq!(material(2).diffuse, Rgb::new(0.0, 0.0, 1.0));
    assert_eq!(
        mesh(&loaded, 3).colors,
        [Rgb::WHITE, Rgb::new(0.0, 0.0, 1.0), Rgb::new(0.0, 0.0, 1.0)]
    );
    assert_eq!(material(4).diffuse, Rgb::new(0.25, 0.75, 0.0));
    assert_eq!(material(5).name, "default");
}

#[test]
fn pictures_are_inside_the_package() {
    let mut picture = Vec::new();
    png::write(1, 1, &[255, 0, 0], &mut picture).unwrap();
    let resources = format!(
        r#"<m:texture2d id="1" path="/3D/Textures/a.png" contenttype="image/png" tilestyleu="mirror"/>
<m:texture2dgroup id="2" texid="1"><m:tex2coord u="0" v="0"/><m:tex2coord u="1" v="0.5"/></m:texture2dgroup>
<object id="3">{}</object>"#,
        triangle(r#"pid="2" p1="0" p2="1" p3="0""#)
    );
    let text = format!(
        r#"{HEAD}<resources>{resources}</resources><build><item objectid="3"/></build></model>"#
    );
    let parts = [
        ("_rels/.rels", RELATIONS.as_bytes()),
        ("3D/a.model", text.as_bytes()),
        ("3d/textures/A.png", &picture),
    ];
    let loaded = load(&package(&parts));
    check_warnings(&loaded, &[]);
    let texture = &loaded.scene.textures[0];
    assert!(texture.image.is_some());
    assert_eq!(texture.wrap, [WrapMode::Mirror, WrapMode::Repeat]);
    let uvs = mesh(&loaded, 0).uvs.as_ref().unwrap();
    assert_eq!(uvs.at(1, 1), DVec2::new(1.0, 0.5));
    // Without its picture, a texture is named, and grey.
    let loaded = load(&package(&parts[..2]));
    check_warnings(
        &loaded,
        &[
            "a.3mf/3D/a.model:3:87: picture \"/3D/Textures/a.png\" is not used: there is no such part",
        ],
    );
    assert_eq!(loaded.scene.materials[0].diffuse, Rgb::grey(0.5));
}

/// As slicers write projects: the objects are in parts of their own.
#[test]
fn objects_may_be_in_other_parts() {
    let other = format!(
        r#"{HEAD}<resources><object id="1" name="inside">{}</object></resources><build/></model>"#,
        triangle("")
    );
    let root = format!(
        r#"{HEAD}<resources><object id="5"><components><component p:path="/3D/Objects/o.model" objectid="1"/></components></object></resources>
<build><item objectid="5"/></build></model>"#
    );
    let parts = [
        ("_rels/.rels", RELATIONS.as_bytes()),
        ("3D/a.model", root.as_bytes()),
        ("3D/Objects/o.model", other.as_bytes()),
    ];
    let loaded = load(&package(&parts));
    assert_eq!(loaded.scene.objects[0].name, "object 5/inside");
    check_error(
        &package(&parts[..2]),
        "a.3mf: found no part \"/3D/Objects/o.model\", expected the part that the model refers to",
    );
}

#[test]
fn what_is_not_read_is_named() {
    let resources = format!(
        r#"<s:slicestack id="1" xmlns:s="slices"/><object id="2">{}</object>"#,
        triangle("").replace("</mesh>", "<b:beamlattice xmlns:b=\"beams\"/></mesh>")
    );
    let text = format!(
        r#"{HEAD}<resources>{resources}</resources><build><item objectid="2"/></build></model>"#
    );
    let text = text.replacen(
        "<model ",
        r#"<model xmlns:v="volumes" requiredextensions="m p v" "#,
        1,
    );
    let loaded = load(&package(&[("3D/x.model", text.as_bytes())]));
    check_warnings(
        &loaded,
        &[
            "a.3mf/3D/x.model:1:1: the extension volumes, which the model requires, is not read",
            "a.3mf/3D/x.model:3:87: resource \"slicestack\" is not read: skipped",
            "a.3mf/3D/x.model:4:57: \"beamlattice\" of a mesh is not read: skipped",
        ],
    );
}

#[test]
fn damage_says_where() {
    check_error(
        &package(&[("a.txt", b"hello")]),
        "a.3mf: found a ZIP archive without a 3D model, expected a 3MF package; unpack other archives first",
    );
    let with = |resources: &str, build: &str, expected: &str| {
        check_error(&model(resources, build), expected);
    };
    with(
        "",
        r#"<item objectid="4"/>"#,
        "a.3mf:3:106: found object 4, which does not exist, expected the id of an object",
    );
    let object = format!(r#"<object id="1">{}</object>"#, triangle(""));
    let far = object.replace(r#"v3="2""#, r#"v3="3""#);
    with(
        &far,
        "",
        "a.3mf/3D/a.model:4:12: found v3=\"3\", expected the number of one of 3 vertices",
    );
    let word = object.replace(r#"x="1""#, r#"x="one""#);
    with(
        &word,
        "",
        "a.3mf/3D/a.model:3:145: found x=\"one\", expected a number",
    );
    let circle = r#"<object id="1"><components><component objectid="2"/></components></object>
<object id="2"><components><component objectid="1"/></components></object>"#;
    let error = read_package(&model(circle, r#"<item objectid="1"/>"#)).unwrap_err();
    let message = error.to_string();
    assert!(
        message.contains("found object 1, which is a component of itself"),
        "{message}"
    );
    let cut = model(&object, r#"<item objectid="1"/>"#);
    for length in 0..cut.len() {
        assert!(read_package(&cut[..length]).is_err(), "{length}");
    }
}

/// Parts that are small when packed, and components that double at each level.
#[test]
fn bombs_do_not_explode() {
    let blank = vec![b' '; 1 << 20];
    let bytes = package(&[("3D/a.model", &blank)]);
    let options = ReadOptions::in_proportion(bytes.len());
    let error = read(&bytes, "a.3mf", &Memory::new(), &options).unwrap_err();
    assert!(
        error.to_string().contains("decompress to more than"),
        "{error}"
    );
    let mut resources = format!(r#"<object id="1">{}</object>"#, triangle(""));
    for k in 2..=60 {
        let twice = format!(r#"<component objectid="{}"/>"#, k - 1).repeat(2);
        resources += &format!(r#"<object id="{k}"><components>{twice}</components></object>"#);
    }
    let bytes = model(&resources, r#"<item objectid="60"/>"#);
    let options = ReadOptions {
        most_elements: 100_000,
        ..ReadOptions::default()
    };
    let error = read(&bytes, "a.3mf", &Memory::new(), &options).unwrap_err();
    assert!(error.to_string().contains("expand to more than"), "{error}");
}
