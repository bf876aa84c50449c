//! Formats that are written for other programs, read back.

use azulejo_formats::{Memory, dxf, ply, read, stl, vrml};
use azulejo_scene::{Material, Mesh, Object, Primitive, Rgb, Scene, Shape, Texture, Units, Up};
use glam::{DVec2, DVec3};
use std::io::{self, Write};

type Writer = fn(&Scene, &mut dyn Write) -> io::Result<()>;

fn wrl(scene: &Scene, out: &mut dyn Write) -> io::Result<()> {
    let paths: Vec<String> = scene.textures.iter().map(|t| t.path.clone()).collect();
    vrml::write(scene, &paths, out)
}

fn x3d(scene: &Scene, out: &mut dyn Write) -> io::Result<()> {
    let paths: Vec<String> = scene.textures.iter().map(|t| t.path.clone()).collect();
    vrml::write_x3d(scene, &paths, out)
}

const WRITERS: [(&str, Writer); 5] = [
    ("a.wrl", wrl),
    ("a.x3d", x3d),
    ("a.dxf", dxf::write),
    ("a.stl", stl::write),
    ("a.ply", ply::write),
];

fn read_back(name: &str, scene: &Scene, write: Writer) -> Scene {
    let mut bytes = Vec::new();
    write(scene, &mut bytes).unwrap();
    let found = read(&bytes, name, &Memory::new());
    let found =
        found.unwrap_or_else(|e| panic!("{name}: {e}\n{}", String::from_utf8_lossy(&bytes)));
    found.scene.validate().unwrap();
    found.scene
}

/// A triangle, a quadrilateral and a pentagon on shared vertices, of two materials, and a lamp.
fn house() -> Scene {
    let mut scene = Scene {
        units: Units {
            up: Up::Y,
            ..Units::default()
        },
        ..Scene::default()
    };
    scene.add_material(Material::diffuse("red", Rgb::new(1.0, 0.0, 0.0)));
    scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
    scene.add_material(Material::emitter("lamp", Rgb::new(0.25, 0.5, 1.0)));
    let p = |x: f64, y: f64| DVec3::new(x, y, 0.1);
    let mut wall = Mesh {
        positions: vec![
            p(0.0, 0.0),
            p(1.0, 0.0),
            p(1.0, 1.0),
            p(0.5, 1.5),
            p(0.0, 1.0),
            p(2.0, 0.0),
            p(2.0, 1.0),
            p(3.0, 0.0),
        ],
        ..Mesh::default()
    };
    wall.push_face(&[0, 1, 2, 3, 4], 0);
    wall.push_face(&[1, 5, 6, 2], 0);
    wall.push_face(&[5, 7, 6], 0);
    let mut lamp = Mesh {
        positions: vec![p(0.0, 5.0), p(1.0, 5.0), p(1.0, 6.0)],
        ..Mesh::default()
    };
    lamp.push_face(&[0, 1, 2], 2);
    scene
        .objects
        .push(Object::new("house/wall", Shape::Mesh(wall)));
    scene
        .objects
        .push(Object::new("house/lamp", Shape::Mesh(lamp)));
    scene
}

fn meshes(scene: &Scene) -> Vec<&Mesh> {
    let mesh = |o: &'_ Object| matches!(o.shape, Shape::Mesh(_));
    assert!(scene.objects.iter().all(mesh));
    scene
        .objects
        .iter()
        .filter_map(|o| match &o.shape {
            Shape::Mesh(mesh) => Some(mesh),
            _ => None,
        })
        .collect()
}

fn names(scene: &Scene) -> Vec<&str> {
    scene.objects.iter().map(|o| &*o.name).collect()
}

#[test]
fn worlds_keep_names_faces_and_colours() {
    for (name, write) in &WRITERS[..2] {
        let house = house();
        let back = read_back(name, &house, *write);
        assert_eq!(names(&back), ["house/wall", "house/lamp"], "{name}");
        for (found, given) in meshes(&back).iter().zip(meshes(&house)) {
            assert_eq!(
                (&found.positions, &found.faces),
                (&given.positions, &given.faces),
                "{name}"
            );
        }
        let material =
            |mesh: usize| &back.materials[meshes(&back)[mesh].face_materials[0] as usize];
        assert_eq!(
            (material(0).diffuse, &*material(0).name),
            (Rgb::new(1.0, 0.0, 0.0), "red")
        );
        assert_eq!(material(1).emission, Rgb::new(0.25, 0.5, 1.0));
    }
    let expected: [&str; 0] = [];
    assert_eq!(vrml::losses(&house()), expected);
}

#[test]
fn worlds_keep_normals_pictures_and_several_materials() {
    let mut house = house();
    house.textures.push(Texture {
        path: "a \"b\" & 'c'.png".to_owned(),
        image: None,
        ..Texture::default()
    });
    house.materials[1].textures.push(0);
    house.objects[0].name = "7 walls".to_owned();
    house.objects[1].name = "7 walls".to_owned();
    let Shape::Mesh(wall) = &mut house.objects[0].shape else {
        panic!("a mesh")
    };
    wall.face_materials[2] = 1;
    let count = wall.positions.len();
    wall.normals = Some(azulejo_scene::Attribute::per_vertex(vec![DVec3::Z; count]));
    wall.uvs = Some(azulejo_scene::Attribute::per_vertex(
        (0..count).map(|k| DVec2::new(k as f64, 0.5)).collect(),
    ));
    for (name, write) in &WRITERS[..2] {
        let back = read_back(name, &house, *write);
        assert_eq!(
            names(&back),
            ["_7_walls", "_7_walls", "_7_walls_2"],
            "{name}"
        );
        let [first, second, _] = meshes(&back)[..] else {
            panic!("three")
        };
        assert_eq!((first.faces.len(), second.faces.len()), (2, 1));
        let normals = first.normals.as_ref().unwrap();
        assert!((0..9).all(|c| normals.at(c, first.faces.corners[c]) == DVec3::Z));
        let uvs = second.uvs.as_ref().unwrap();
        assert_eq!(uvs.at(1, second.faces.corners[1]), DVec2::new(7.0, 0.5));
        assert_eq!(back.textures[0].path, house.textures[0].path, "{name}");
    }
    let said = vrml::losses(&house).join(", ");
    for part in [
        "2 objects whose names change",
        "1 meshes that become several shapes",
        "1 textured materials",
    ] {
        assert!(said.contains(part), "{said}");
    }
}

#[test]
fn drawings_keep_layers_faces_and_near_colours() {
    let house = house();
    let back = read_back("a.dxf", &house, dxf::write);
    assert_eq!(names(&back), ["house_wall", "house_lamp"]);
    assert_eq!(back.units.up, Up::Z);
    let back = back.adapted(house.units);
    let [wall, lamp] = meshes(&back)[..] else {
        panic!("two")
    };
    // The pentagon is three triangles; vertices are still shared.
    assert_eq!((wall.faces.len(), wall.positions.len()), (5, 8));
    let positions = |m: &Mesh| {
        let mut all: Vec<[u64; 3]> = m
            .positions
            .iter()
            .map(|p| p.to_array().map(|x| (x + 0.0).to_bits()))
            .collect();
        all.sort_unstable();
        all
    };
    assert_eq!(positions(wall), positions(meshes(&house)[0]));
    assert_eq!(wall.area(), meshes(&house)[0].area());
    assert_eq!(lamp.faces.len(), 1);
    assert_eq!(
        back.materials[wall.face_materials[0] as usize].diffuse,
        Rgb::new(1.0, 0.0, 0.0)
    );
    let said = dxf::losses(&house).join(", ");
    assert!(
        said.contains("2 objects whose names change") && said.contains("1 meshes whose polygons"),
        "{said}"
    );
}

#[test]
fn large_meshes_are_several_polyfaces_on_one_layer() {
    let mut scene = Scene::default();
    let white = scene.add_material(Material::diffuse("white", Rgb::grey(0.5)));
    let mut mesh = Mesh::default();
    for k in 0..15_000u32 {
        let x = f64::from(k);
        mesh.positions.extend([
            DVec3::new(x, 0.0, 0.0),
            DVec3::new(x, 1.0, 0.0),
            DVec3::new(x, 0.0, 1.0),
        ]);
        mesh.push_face(&[3 * k, 3 * k + 1, 3 * k + 2], white);
    }
    scene.objects.push(Object::new("comb", Shape::Mesh(mesh)));
    let back = read_back("a.dxf", &scene, dxf::write);
    assert_eq!(back.objects.len(), 1);
    assert_eq!(meshes(&back)[0].faces.len(), 15_000);
}

#[test]
fn solids_keep_their_triangles() {
    let house = house();
    let back = read_back("a.stl", &house, stl::write).adapted(house.units);
    let [all] = meshes(&back)[..] else {
        panic!("one")
    };
    assert_eq!(all.faces.len(), 7);
    let area: f64 = meshes(&house).iter().map(|m| m.area()).sum();
    assert!((all.area() / area - 1.0).abs() < 1e-6);
    let said = stl::losses(&house).join(", ");
    assert!(
        said.contains("2 objects that become one") && said.contains("2 materials"),
        "{said}"
    );
    let mut far = house.clone();
    if let Shape::Mesh(mesh) = &mut far.objects[0].shape {
        mesh.positions[0].x = 1e300;
    }
    assert!(stl::write(&far, &mut Vec::new()).is_err());
}

#[test]
fn lists_keep_names_in_comments() {
    let mut bytes = Vec::new();
    ply::write(&house(), &mut bytes).unwrap();
    let head = String::from_utf8_lossy(&bytes[..400]).into_owned();
    assert!(
        head.contains("\ncomment azulejo object house/wall\n") && !head.contains("obj_info"),
        "{head}"
    );
    let back = read_back("a.ply", &house(), ply::write);
    assert_eq!(names(&back), ["house/wall", "house/lamp"]);
}

#[test]
fn nothing_is_written_and_read() {
    let mut hollow = Scene::default();
    hollow
        .objects
        .push(Object::new("hollow", Shape::Mesh(Mesh::default())));
    let mut ball = Scene::default();
    let white = ball.add_material(Material::diffuse("white", Rgb::grey(0.5)));
    let sphere = Primitive::sphere(DVec3::ZERO, 1.0, white);
    ball.objects
        .push(Object::new("ball", Shape::Primitive(sphere)));
    for (name, write) in WRITERS {
        for scene in [&Scene::default(), &hollow] {
            let back = read_back(name, scene, write);
            assert!(meshes(&back).iter().all(|m| m.faces.is_empty()), "{name}");
        }
        let area = meshes(&read_back(name, &ball, write))[0].area();
        assert!((area / 12.566 - 1.0).abs() < 0.01, "{name}: {area}");
    }
}

#[test]
fn a_full_disk_is_an_error() {
    struct Full;
    impl Write for Full {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(io::ErrorKind::StorageFull.into())
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    for (name, write) in WRITERS {
        assert!(write(&house(), &mut Full).is_err(), "{name}");
    }
}
