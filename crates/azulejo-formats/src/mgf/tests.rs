//! Tests with small files.

use super::read;
use crate::{Loaded, Memory, ReadOptions};
use azulejo_scene::{
    Light, LightKind, Material, Mesh, Object, Primitive, Rgb, Shape, Sidedness, Up,
};
use glam::DVec3;
use proptest::prelude::*;
use std::f64::consts::PI;

fn load_with(text: &str, files: &Memory) -> Loaded {
    let loaded = read(text.as_bytes(), "t.mgf", files, &ReadOptions::default()).unwrap();
    loaded.scene.validate().unwrap();
    loaded
}

fn load(text: &str) -> Loaded {
    load_with(text, &Memory::new())
}

fn warnings(loaded: &Loaded) -> Vec<String> {
    loaded.warnings.iter().map(ToString::to_string).collect()
}

fn mesh(object: &Object) -> &Mesh {
    match &object.shape {
        Shape::Mesh(mesh) => mesh,
        _ => panic!("a mesh is expected"),
    }
}

fn primitive(object: &Object) -> &Primitive {
    match &object.shape {
        Shape::Primitive(primitive) => primitive,
        _ => panic!("a primitive is expected"),
    }
}

/// Four vertices of the unit square, and a grey material.
const SQUARE: &str = "\
v a =\n p 0 0 0\nv b =\n p 1 0 0\nv c =\n p 1 1 0\nv d =\n p 0 1 0\n\
m grey =\n rd .5\n";

fn with_square(text: &str) -> Loaded {
    load(&format!("{SQUARE}{text}"))
}

/// Names and polygons of objects.
fn check_objects(loaded: &Loaded, expected: &[(&str, usize)]) {
    let objects: Vec<(&str, usize)> = loaded
        .scene
        .objects
        .iter()
        .map(|o| match &o.shape {
            Shape::Mesh(mesh) => (o.name.as_str(), mesh.faces.len()),
            _ => (o.name.as_str(), 0),
        })
        .collect();
    assert_eq!(objects, expected);
}

fn check_warnings(loaded: &Loaded, expected: &[&str]) {
    let messages = warnings(loaded);
    assert_eq!(messages.len(), expected.len(), "{messages:#?}");
    for (message, expected) in messages.iter().zip(expected) {
        assert!(message.contains(expected), "{message}, expected {expected}");
    }
}

#[test]
fn a_square_in_a_room() {
    let loaded = with_square("o room\no floor\nf a b c d\nf a c d\no\nsph a .5\no\n");
    check_objects(&loaded, &[("room/floor", 2), ("room", 0)]);
    check_warnings(&loaded, &[]);
    let units = loaded.scene.units;
    assert_eq!(
        (units.metres_per_unit, units.up, units.photometric),
        (Some(1.0), Up::Z, true)
    );
    let floor = mesh(&loaded.scene.objects[0]);
    assert_eq!((floor.positions.len(), floor.area()), (4, 1.5));
    assert_eq!(
        loaded.scene.materials,
        [Material::diffuse("grey", Rgb::grey(0.5))]
    );
}

#[test]
fn contexts_hold_until_they_change() {
    let loaded = load(
        "c red =\ncxy .6 .3\nm a =\nc red\nrd .1\nc\nrs .1 0\nm b = a\nrs 0 0\nc white =\nc mixed =\n\
         cmix 1 red 1 white\nm a\nv v =\np 1 2 3\nsph v 1\nc red\nrd .05\nsph v 1\nm b\nsph v 1\n\
         v v\np 0 0 0\nsph v 1\nc\nm\nrd .4\nsph v 1\nm\nsph v 1",
    );
    check_warnings(&loaded, &["surfaces before any material: black"]);
    let used: Vec<&Material> = loaded
        .scene
        .objects
        .iter()
        .map(|o| &loaded.scene.materials[primitive(o).material as usize])
        .collect();
    let names: Vec<&str> = used.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["a", "a", "b", "b", "", ""]);
    // Grey mirror over red: each component has the colour that was current when it was read.
    assert!(used[0].mirror.is_grey() && used[0].diffuse.r > 2.0 * used[0].diffuse.g);
    assert!((used[0].diffuse.luminance() - 0.1).abs() < 1e-12);
    assert!((used[1].diffuse.luminance() - 0.05).abs() < 1e-12);
    assert_eq!(
        (used[2].diffuse, used[2].mirror),
        (used[0].diffuse, Rgb::BLACK)
    );
    assert_eq!(
        (used[4].diffuse, used[5].diffuse),
        (Rgb::grey(0.4), Rgb::BLACK)
    );
    let centre = |i: usize| {
        primitive(&loaded.scene.objects[i])
            .world_from_object
            .translation
    };
    assert_eq!(
        (centre(2), centre(3)),
        (DVec3::new(1.0, 2.0, 3.0), DVec3::ZERO)
    );
}

#[test]
fn colours() {
    let rgb = |color: &str| {
        let loaded = load(&format!(
            "c x =\ncxy .6 .3\nc k =\n{color}\nm m =\nrd .05\nv v =\nsph v 1\n"
        ));
        check_warnings(&loaded, &[]);
        loaded.scene.materials[0].diffuse
    };
    let x = rgb("cxy .6 .3");
    assert_eq!(rgb("cmix 5 x"), x);
    assert_eq!(rgb("cspec 300 900 2 2"), Rgb::grey(0.05));
    assert!(rgb("cct 2000").r > rgb("cct 9000").r);
    assert!(rgb("cspec 380 480 1 1").b > 0.3);
}

#[test]
fn transforms_act_from_the_inside_out() {
    let loaded = with_square(
        "xf -t 10 0 0\nxf -rz 90 -s 2\nf a b c d\nsph b 1\nxf\nf a b c d\nxf\nf a b c d\n",
    );
    check_warnings(&loaded, &[]);
    // All faces are in the same group; transforms create separate vertices.
    check_objects(&loaded, &[("", 3), ("", 0)]);
    let faces = mesh(&loaded.scene.objects[0]);
    assert_eq!(faces.positions.len(), 12);
    assert!((faces.positions[1] - DVec3::new(10.0, 2.0, 0.0)).length() < 1e-12);
    assert_eq!(faces.positions[5], DVec3::new(11.0, 0.0, 0.0));
    assert_eq!(faces.positions[9], DVec3::new(1.0, 0.0, 0.0));
    let ball = primitive(&loaded.scene.objects[1]);
    assert!((ball.area() / (16.0 * PI) - 1.0).abs() < 1e-3);
    assert!((ball.world_from_object.translation - DVec3::new(10.0, 2.0, 0.0)).length() < 1e-12);
}

#[test]
fn mirrors_keep_fronts() {
    let loaded = with_square(
        "v t =\n p 0 0 1\n n 0 0 1\nxf -mz\nf a b c d\nring t 0 1\nring t .5 1\nprism a b c d 1\ncyl a .1 t\nxf\n",
    );
    check_warnings(&loaded, &[]);
    let down = |i: usize| mesh(&loaded.scene.objects[i]).face_area_vector(0).z;
    assert_eq!(down(0), -1.0);
    assert!(down(1) < -3.0 && down(2) < 0.0);
    let prism = mesh(&loaded.scene.objects[3]);
    assert_eq!((down(3), prism.bounds().max.z), (-1.0, 1.0));
    let middle = prism.bounds().centre();
    for f in 0..prism.faces.len() {
        assert!((prism.face_positions(f)[0] - middle).dot(prism.face_area_vector(f)) > 0.0);
    }
    let tube = mesh(&loaded.scene.objects[4]);
    let out = tube.positions[0].with_z(0.0);
    assert!(tube.face_area_vector(0).dot(out) > 0.0);
}

#[test]
fn arrays_read_their_content_for_each_instance() {
    let loaded = with_square(
        "xf -t 0 0 5 -a 2 -t 10 0 0 -a 2 -t 0 10 0\no o\nf a b c d\nxf -a 2 -mz\nf a b c\nxf\no\nxf\nf a b c\n",
    );
    check_warnings(&loaded, &[]);
    let names = [
        "a0.0/o",
        "a0.0/o/a0",
        "a0.0/o/a1",
        "a0.1/o",
        "a0.1/o/a0",
        "a0.1/o/a1",
    ];
    let object_names: Vec<&str> = loaded
        .scene
        .objects
        .iter()
        .map(|o| o.name.as_str())
        .collect();
    assert_eq!(object_names.len(), 13);
    assert_eq!(object_names[..6], names);
    assert_eq!(object_names[12], "");
    let first = |i: usize| mesh(&loaded.scene.objects[i]).positions[0];
    assert_eq!(first(9), DVec3::new(10.0, 10.0, 5.0));
    assert_eq!(mesh(&loaded.scene.objects[11]).face_area_vector(0).z, -0.5);
}

#[test]
fn includes() {
    let files = Memory::new()
        .with(
            "parts/leg.mgf",
            "i ../common/m.mgf\no leg\nv e =\np 0 0 0\nf a b c\no\n",
        )
        .with("common/m.mgf", "m wood =\nrd .3\no lost\n")
        .with("self.mgf", "sph a 1\ni self.mgf\n");
    let text = format!(
        "{SQUARE}i parts/leg.mgf\ni ./parts/leg.mgf -t 0 0 1 -a 2 -t 5 0 0\nf a b c\ni none.mgf\n\
         i none.mgf\ni self.mgf\ni t.mgf\nsph e 1\n"
    );
    let loaded = load_with(&text, &files);
    check_objects(
        &loaded,
        &[
            ("leg", 1),
            ("a0/leg", 1),
            ("a1/leg", 1),
            ("", 1),
            ("", 0),
            ("", 0),
        ],
    );
    check_warnings(
        &loaded,
        &[
            "common/m.mgf:3:1: \"o\" or \"xf\" without its end: ended with the file (3 times)",
            "t.mgf:14:1: file \"none.mgf\" skipped: there is no such file",
            "t.mgf:15:1: file \"none.mgf\" skipped, as before",
            "self.mgf:2:1: file \"self.mgf\" includes itself: skipped",
            "t.mgf:17:1: file \"t.mgf\" includes itself: skipped",
        ],
    );
    assert_eq!(
        mesh(&loaded.scene.objects[2]).positions[0],
        DVec3::new(5.0, 0.0, 1.0)
    );
    // Definitions of an included file persist.
    assert_eq!(loaded.scene.materials.len(), 1);
    assert_eq!(loaded.scene.materials[0].name, "wood");
}

#[test]
fn faces_with_holes_and_normals() {
    let loaded = load(
        "v a =\np 0 0 0\nn 0 0 2\nv b =\np 4 0 0\nn 0 0 1\nv c =\np 4 4 0\nn 0 1 1\nv d =\np 0 4 0\nn 0 0 1\n\
         v e =\np 1 1 0\nv f =\np 1 2 0\nv g =\np 2 2 0\nv h =\np 2 1 0\n\
         m m =\nrd .1\nfh a b c d - e f g h\nf a b c\nfh a b c - d\n",
    );
    let faces = mesh(&loaded.scene.objects[0]);
    let normals = faces.normals.as_ref().unwrap();
    assert_eq!(
        (faces.faces.len(), faces.area()),
        (3, 16.0 - 1.0 + 8.0 + 8.0)
    );
    assert_eq!(faces.faces.get(0).len(), 10);
    // The first face has corners without normals and is flat, the second is smooth.
    let slanted = DVec3::new(0.0, 1.0, 1.0).normalize();
    let corner = faces.faces.corner_range(0);
    assert!(
        corner
            .clone()
            .all(|c| normals.at(c, faces.faces.corners[c]) == DVec3::Z)
    );
    let third = corner.end + 2;
    let smooth = normals.at(third, faces.faces.corners[third]);
    assert!((smooth - slanted).length() < 1e-12);
    check_warnings(&loaded, &["hole outside of its face: filled"]);
}

#[test]
fn emission_by_sides() {
    let lamp = |sides: u32, surface: &str| {
        let loaded = with_square(&format!("m lamp =\nsides {sides}\ned 100\n{surface}\n"));
        let object = &loaded.scene.objects[0];
        let (id, is_mesh) = match &object.shape {
            Shape::Mesh(mesh) => (mesh.face_materials[0], true),
            Shape::Primitive(p) => (p.material, false),
            Shape::Exact(_) | Shape::Instance(_) => {
                unreachable!("MGF has primitives and meshes only")
            }
        };
        let material = &loaded.scene.materials[id as usize];
        assert_eq!(material.emission, Rgb::grey(100.0 / PI));
        (material.emits_back, is_mesh)
    };
    let sidedness = |text: &str| {
        let loaded = with_square(&format!("m wall =\n{text}\nf a b c\n"));
        loaded.scene.materials[0].sidedness
    };
    assert_eq!(sidedness("sides 1"), Sidedness::One);
    assert_eq!(sidedness("sides 2"), Sidedness::Two);
    assert_eq!(sidedness(""), Sidedness::Unsaid);
    assert_eq!(lamp(2, "f a b c"), (true, true));
    assert_eq!(lamp(1, "f a b c"), (false, true));
    assert_eq!(lamp(2, "cyl a .1 b"), (true, true));
    // The inside of a ball or a prism is not visible.
    assert_eq!(lamp(2, "sph a 1"), (false, false));
    assert_eq!(lamp(2, "prism a b c .1"), (false, true));
    // A dome emits into its interior; one that emits inwards only cannot be an exact sphere.
    assert_eq!(lamp(2, "sph a -1"), (true, false));
    assert_eq!(lamp(1, "sph a -1"), (false, true));
    let loaded = with_square("m lamp =\nsides 1\ned 100\nsph a -1\n");
    let dome = mesh(&loaded.scene.objects[0]);
    assert!(dome.face_area_vector(200).dot(dome.face_positions(200)[0]) < 0.0);
    let normals = &dome.normals.as_ref().unwrap().values;
    assert!(normals[200].dot(dome.positions[200]) < 0.0);
}

#[test]
fn what_is_skipped_is_said() {
    let check = |text: &str, expected: &[&str]| {
        let loaded = with_square(&format!("{text}\nsph a 1\n"));
        check_warnings(&loaded, expected);
    };
    check(
        "0 thing\n0 thing",
        &["t.mgf:11:1: unknown entity \"0\": skipped (2 times)"],
    );
    check(
        "m none",
        &["undefined material \"none\": taken as grey with reflectance 0.5"],
    );
    check("m x = none", &["undefined material \"none\""]);
    check("c none", &["undefined colour \"none\": taken as white"]);
    check(
        "v none",
        &["undefined vertex \"none\": taken as at the origin"],
    );
    check("m a b", &["neither \"id\""]);
    check("f a b", &["fewer than 3 corners"]);
    check(
        "f a b nobody",
        &["undefined vertex \"nobody\": its surface is skipped"],
    );
    check("rd x", &["\"x\" is not a number"]);
    check("rd .1 .2", &["2 arguments, expected 1"]);
    check("rd 1.5", &["rd outside 0..1: clamped"]);
    check("rd .9\nrs .3 .2", &["more than it receives"]);
    check("ed -1", &["ed below 0"]);
    check("sides 3", &["sides must be 1 or 2"]);
    check("sides 1", &["one-sided"]);
    check("td .2", &["(td)"]);
    check("c k =\ncxy .9 .9", &["cxy without visible colour"]);
    check("c k =\ncspec 1 2 3", &["cspec without visible colour"]);
    check("c k =\ncmix 1", &["pairs of weight and colour"]);
    check("c k =\ncmix x k", &["\"x\" is not a weight"]);
    check("c k =\ncmix 1 x", &["undefined colour \"x\""]);
    check(
        "o\nxf",
        &[
            "\"o\" without a matching begin",
            "\"xf\" without a matching begin",
        ],
    );
    check("o x\nxf -t 0 0 1\no", &["overlap"]);
    check(
        "xf -q 3\nxf",
        &["unknown transform option: it and the following options"],
    );
    check("sph a 0", &["sph without size"]);
    check("sph a", &["sph without \"vertex radius\""]);
    check("cyl a 1 a", &["cyl or cone without length"]);
    check("cyl a 1", &["cyl without"]);
    check("cone a 1 b", &["cone without"]);
    check("ring a 0 1", &["without normal"]);
    check("ring a 0", &["ring or torus without"]);
    check("prism a b c 0", &["prism without area or length"]);
    check("prism a a a 1", &["prism without area or length"]);
    check("prism", &["prism without"]);
    check(
        "v n =\nn 0 0 1\nring n 2 1\ntorus n 1 1",
        &["ring whose radii", "torus whose radii"],
    );
    check("i", &["\"i\" without a file"]);
    check("ies", &["\"ies\" without a file"]);
    check(
        "v far =\np 1e308 0 0\nxf -s 1e10\nf a b far\nsph far 1\nxf",
        &[
            "surface that overflows",
            "sph without size, or that overflows",
        ],
    );
}

#[test]
fn a_library_has_materials_and_no_geometry() {
    let loaded = load("m wood =\nrd .2\nm steel =\nrs .6 0\n");
    check_warnings(&loaded, &["the file contains no geometry"]);
    let names: Vec<&str> = loaded
        .scene
        .materials
        .iter()
        .map(|m| m.name.as_str())
        .collect();
    assert_eq!(names, ["wood", "steel"]);
    assert!(loaded.scene.objects.is_empty());
    check_warnings(&load(""), &["the file contains no geometry"]);
}

#[test]
fn small_files_stay_small() {
    let check = |text: &str, files: &Memory| {
        let options = ReadOptions {
            most_elements: 100_000,
            ..ReadOptions::default()
        };
        let error = read(text.as_bytes(), "t.mgf", files, &options).unwrap_err();
        assert!(
            error.to_string().contains("expand to more than 100000"),
            "{error}"
        );
    };
    let none = Memory::new();
    check(
        &format!("{SQUARE}xf -a 1000000 -t 1 0 0\nf a b c d\nxf"),
        &none,
    );
    check("xf -a 1000000000000 -t 1 0 0\nxf", &none);
    check(
        "v a =\nn 0 0 1\nxf -a 1000 -t 1 0 0\ntorus a 1 2\nxf",
        &none,
    );
    check(&("xf -a 100 -mx\n".repeat(20) + &"xf\n".repeat(20)), &none);
    let bomb = (0..40).fold(Memory::new(), |files, i| {
        let next = i + 1;
        files.with(format!("{i}.mgf"), format!("i {next}.mgf\ni {next}.mgf\n"))
    });
    check("i 0.mgf", &bomb);
    let deep = (0..100).fold(Memory::new(), |files, i| {
        files.with(format!("{i}.mgf"), format!("i {}.mgf\n", i + 1))
    });
    check_warnings(
        &load_with("i 0.mgf", &deep),
        &["more than 64 deep", "no geometry"],
    );
}

/// A photometric file of type C in metres with the given sizes, vertical angles and candelas.
fn photometric(sizes: &str, vertical: &str, candelas: &str) -> String {
    let n = vertical.split_whitespace().count();
    format!(
        "IESNA91\n[MORE]\nTILT=NONE\n1 1 1 {n} 1 1 2 {sizes}\n1 1 1\n{vertical}\n0\n{candelas}\n"
    )
}

/// Radiant intensity of some lights together.
fn intensity_toward(lights: &[Light], w: DVec3) -> f64 {
    lights.iter().map(|l| l.kind.intensity_toward(w).r).sum()
}

#[test]
fn luminaires_keep_their_distribution() {
    // 100 cd over the lower hemisphere, half as much above, from an opening of 0.5 by 2.
    let files = Memory::new().with(
        "a/l.ies",
        photometric("2 .5 .1", "0 89.999 90.001 180", "100 100 50 50"),
    );
    let loaded = load_with("ies a/l.ies -m 2 -rx 180 -t 0 0 3 -a 2 -t 5 0 0\n", &files);
    check_warnings(&loaded, &[]);
    check_objects(&loaded, &[]);
    let lights = &loaded.scene.lights;
    assert_eq!(lights.len(), 2 * (2 * 7));
    // Upside down, most of the light goes up; two of them, each twice as bright.
    for (w, expected) in [(DVec3::Z, 400.0), (DVec3::NEG_Z, 200.0)] {
        let found = intensity_toward(lights, w);
        assert!((found - expected).abs() < 1e-9, "{w}: {found}");
    }
    let places: Vec<DVec3> = lights.iter().filter_map(|l| l.kind.position()).collect();
    let mean = places.iter().sum::<DVec3>() / places.len() as f64;
    assert!(
        (mean - DVec3::new(2.5, 0.0, 3.0)).length() < 1e-12,
        "{mean}"
    );
    let wide = places.iter().map(|p| p.y).fold(0.0, f64::max);
    assert!((wide - (1.0 - 1.0 / 7.0)).abs() < 1e-12, "{wide}");
}

/// Arrays of large openings, each of 64 points: a small file, whose lights are counted and share their distribution.
#[test]
fn points_of_luminaires_are_counted() {
    let wide = photometric("9 9 0", "0 90", "1 1");
    let files = Memory::new().with("l.ies", wide);
    let load = |text: &str| {
        let options = ReadOptions::in_proportion(text.len());
        read(text.as_bytes(), "a.mgf", &files, &options)
    };
    let few = load("ies l.ies -a 3 -t 5 0 0\n").unwrap().scene.lights;
    let webs = few.iter().filter_map(|l| match &l.kind {
        LightKind::Luminaire { web, .. } => Some(std::sync::Arc::as_ptr(web)),
        _ => None,
    });
    let webs: Vec<_> = webs.collect();
    assert!(webs.len() == 3 * 64 && webs.iter().all(|web| *web == webs[0]));
    let error = load("ies l.ies -a 100000 -t 5 0 0\n").unwrap_err();
    assert!(error.found.contains("expand to more than"), "{error}");
}

#[test]
fn luminaires_without_area_are_points() {
    let load = |sizes: &str, angles: &str, candelas: &str| {
        let files = Memory::new().with("l.ies", photometric(sizes, angles, candelas));
        load_with("xf -t 1 2 3 -s 2\nies l.ies\nxf\n", &files)
            .scene
            .lights
    };
    let bulb = load("0 0 0", "0 180", "10 10");
    assert_eq!((bulb.len(), bulb[0].name.as_str()), (1, "l.ies"));
    assert_eq!(bulb[0].kind.position(), Some(DVec3::new(2.0, 4.0, 6.0)));
    // Twice as large, four times as bright.
    assert!((intensity_toward(&bulb, DVec3::X) - 40.0).abs() < 1e-9);
    let beam = load("-.2 -.2 0", "0 10 10.001 180", "1000 1000 0 0");
    let aside = DVec3::new(0.2, 0.0, -1.0).normalize();
    let found = [DVec3::NEG_Z, aside].map(|w| intensity_toward(&beam, w));
    assert!(
        (found[0] - 4000.0).abs() < 1e-6 && found[1] == 0.0,
        "{found:?}"
    );
}

#[test]
fn luminaires_with_a_body() {
    let with_body = photometric("0 0 0", "0 90", "1 1")
        .replace("[MORE]", "[LUMINOUSGEOMETRY] lamp.mgf")
        .replace("1 1 1 2 1", "1 1 3 2 1");
    let files = Memory::new()
        .with("a/l.ies", with_body.clone())
        .with(
            "a/lamp.mgf",
            "v v =\nm lamp =\ned 3.14159265\nsph v .1\nies l.ies\n",
        )
        .with("b/l.ies", with_body);
    let loaded = load_with(
        "ies a/l.ies -m 2 -t 1 0 0\nm lamp\nsph v 1\nies b/l.ies\n",
        &files,
    );
    check_objects(&loaded, &[("", 0), ("", 0)]);
    assert!((loaded.scene.materials[0].emission.r - 6.0).abs() < 1e-6);
    check_warnings(
        &loaded,
        &[
            "a/lamp.mgf:5:1: the geometry of \"a/l.ies\" includes it again",
            "b/lamp.mgf\" skipped",
        ],
    );
    assert_eq!(loaded.scene.lights.len(), 1);
    let broken = Memory::new().with("l.ies", "IESNA91\nnothing\n");
    let loaded = load_with("ies l.ies\nies l.ies\nies l.ies -m x\n", &broken);
    check_warnings(
        &loaded,
        &[
            "not a valid photometric file",
            "as before",
            "multiplier",
            "no geometry",
        ],
    );
}

/// Keywords and arguments, in any order.
fn any_word() -> impl Strategy<Value = &'static str> {
    prop::sample::select(
        "a b c - -1 0 .5 2 1e308 -3 = -t -rx -s -mx -i -a -m 1e-300 400 700 a.mgf t.mgf l.ies x"
            .split(' ')
            .collect::<Vec<_>>(),
    )
}

fn any_keyword() -> impl Strategy<Value = &'static str> {
    prop::sample::select(
        "v p n c cxy cspec cct cmix m sides rd td ed rs ts ir f fh sph cyl cone ring torus prism o \
         xf i ies 0"
            .split_ascii_whitespace()
            .collect::<Vec<_>>(),
    )
}

proptest! {
    /// Arbitrary statements cause warnings only.
    #[test]
    fn any_statements(
        statements in prop::collection::vec(
            (any_keyword(), prop::collection::vec(any_word(), 0..8)),
            0..60,
        ),
        photometric in prop::collection::vec(any_word(), 0..40),
    ) {
        let lines = statements.iter().map(|(word, rest)| format!("{word} {}\n", rest.join(" ")));
        let text = format!(
            "{SQUARE}n 0 0 1\nm lamp =\ned 5\n{}",
            lines.collect::<String>()
        );
        let head = "GEOM=a.mgf\nTILT=NONE\n1 1 1 2 1 1 2 1 1 0\n1 1 1\n0 90\n0\n9 9\n";
        let (head, _) = head.split_at(head.len() - photometric.len());
        let files = Memory::new()
            .with("a.mgf", "sph a .1\nf a b c\ncyl a .1 b\nies l.ies\n")
            .with("l.ies", format!("{head}{}", photometric.join(" ")));
        let options = ReadOptions {
            most_elements: 20_000,
            ..ReadOptions::default()
        };
        if let Ok(loaded) = read(text.as_bytes(), "t.mgf", &files, &options) {
            prop_assert_eq!(loaded.scene.validate(), Ok(()));
        }
    }

    /// Arbitrary bytes cause warnings only.
    #[test]
    fn any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let loaded = read(&bytes, "t.mgf", &Memory::new(), &ReadOptions::default()).unwrap();
        prop_assert_eq!(loaded.scene.validate(), Ok(()));
    }
}
