//! Models far from the origin, written and read back in every format: nothing is lost that the format can
//! hold, and where it cannot, that is said.

use azulejo_formats::{Memory, dxf, gltf, grf, obj, ply, read, sff, stl, three_mf, view3d, vrml};
use azulejo_scene::{
    Camera, Light, LightKind, Material, Mesh, MeshInstance, Object, Primitive, Rgb, Scene, Shape,
    Units, Up,
};
use glam::{DAffine3, DVec3};
use std::io::{self, Write};
use std::sync::Arc;

type Writer = fn(&Scene, &mut dyn Write) -> io::Result<Memory>;

/// A format, how it is written, what it says that it loses, and whether it has single precision alone.
struct Written {
    name: &'static str,
    write: Writer,
    losses: fn(&Scene) -> Vec<String>,
    is_single: bool,
}

/// All formats that are written and read again.
const WRITTEN: [Written; 11] = [
    Written {
        name: "a.grf",
        write: |scene, out| grf::write(scene, out).map(|()| Memory::new()),
        losses: grf::losses,
        is_single: false,
    },
    Written {
        name: "a.obj",
        write: |scene, out| {
            let mut mtl = Vec::new();
            obj::write(scene, "a.mtl", out, &mut mtl)?;
            Ok(Memory::new().with("a.mtl", mtl))
        },
        losses: obj::losses,
        is_single: false,
    },
    Written {
        name: "a.glb",
        write: |scene, out| gltf::write(scene, out).map(|()| Memory::new()),
        losses: gltf::losses,
        is_single: false,
    },
    Written {
        name: "a.gltf",
        write: |scene, out| {
            let mut bin = Vec::new();
            gltf::write_json(scene, "a.bin", out, &mut bin)?;
            Ok(Memory::new().with("a.bin", bin))
        },
        losses: gltf::losses,
        is_single: false,
    },
    Written {
        name: "a.ply",
        write: |scene, out| ply::write(scene, out).map(|()| Memory::new()),
        losses: ply::losses,
        is_single: false,
    },
    Written {
        name: "a.sff",
        write: |scene, out| {
            let mut files = Memory::new();
            for (name, bytes) in sff::write(scene, "a", out)? {
                files = files.with(&name, bytes);
            }
            Ok(files)
        },
        losses: sff::losses,
        is_single: false,
    },
    Written {
        name: "a.vs3",
        write: |scene, out| view3d::write(scene, out).map(|()| Memory::new()),
        losses: view3d::losses,
        is_single: false,
    },
    Written {
        name: "a.wrl",
        write: |scene, out| vrml::write(scene, &[], out).map(|()| Memory::new()),
        losses: vrml::losses,
        is_single: false,
    },
    Written {
        name: "a.x3d",
        write: |scene, out| vrml::write_x3d(scene, &[], out).map(|()| Memory::new()),
        losses: vrml::losses,
        is_single: false,
    },
    Written {
        name: "a.stl",
        write: |scene, out| stl::write(scene, out).map(|()| Memory::new()),
        losses: stl::losses,
        is_single: true,
    },
    Written {
        name: "a.dxf",
        write: |scene, out| dxf::write(scene, out).map(|()| Memory::new()),
        losses: dxf::losses,
        is_single: false,
    },
];

/// A closed box with a corner at `at`, turned by some radians about its own x axis.
fn slab(at: DVec3, size: DVec3, turn: f64) -> Mesh {
    let map = DAffine3::from_translation(at) * DAffine3::from_rotation_x(turn);
    let corner = |k: u32| {
        let step = |axis: u32| f64::from(k >> axis & 1);
        map.transform_point3(size * DVec3::new(step(0), step(1), step(2)))
    };
    let mut mesh = Mesh {
        positions: (0..8).map(corner).collect(),
        ..Mesh::default()
    };
    const FACES: [[u32; 4]; 6] = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    FACES.iter().for_each(|face| mesh.push_face(face, 0));
    mesh
}

fn scene(meshes: Vec<Mesh>, metres_per_unit: f64) -> Scene {
    let mut scene = Scene {
        units: Units {
            up: Up::Z,
            metres_per_unit: Some(metres_per_unit),
            ..Units::default()
        },
        ..Scene::default()
    };
    scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
    for (k, mesh) in meshes.into_iter().enumerate() {
        scene
            .objects
            .push(Object::new(format!("slab {k}"), Shape::Mesh(mesh)));
    }
    scene
}

/// The volume of all meshes, in the cube of the scene's unit: that of tetrahedra from a corner of each mesh, because those
/// from the origin would cancel out.
fn volume(scene: &Scene) -> f64 {
    let of_mesh = |object: &Object| {
        let mesh = match &object.shape {
            Shape::Mesh(mesh) => mesh.clone(),
            Shape::Instance(instance) => instance.to_mesh(),
            other => panic!("a mesh: {other:?}"),
        };
        let start = mesh.positions[mesh.faces.corners[0] as usize];
        let mut sum = 0.0;
        for face in 0..mesh.faces.len() {
            let ring = mesh.face_positions(face);
            let ring: Vec<DVec3> = ring.into_iter().map(|p| p - start).collect();
            for k in 1..ring.len() - 1 {
                sum += ring[0].dot(ring[k].cross(ring[k + 1])) / 6.0;
            }
        }
        sum
    };
    scene.objects.iter().map(of_mesh).sum()
}

/// Reads what was written, and returns its volume in the unit of the scene that was written.
fn volume_again(written: &Written, given: &Scene) -> (f64, Vec<String>) {
    let mut bytes = Vec::new();
    let files = (written.write)(given, &mut bytes).unwrap();
    let found = read(&bytes, written.name, &files);
    let found = found.unwrap_or_else(|e| panic!("{}: {e}", written.name));
    found.scene.validate().unwrap();
    let unit = found.scene.units.metres_per_unit;
    let scale = unit.map_or(1.0, |metres| metres / given.units.metres());
    let said = found.warnings.iter().map(ToString::to_string).collect();
    (volume(&found.scene) * scale.powi(3), said)
}

/// Writes and reads a scene in all formats. Where numbers have all digits, its volume stays within `exact`, a part
/// of it; formats of single precision say that they lose it, and what is read of them, too.
fn check(given: &Scene, exact: f64) {
    let expected = volume(given);
    for written in &WRITTEN {
        let name = written.name;
        let says = |list: &[String]| list.iter().any(|said| said.contains("as float32 at"));
        let losses = (written.losses)(given);
        let is_read_as_single = written.is_single || matches!(name, "a.wrl" | "a.x3d");
        assert_eq!(says(&losses), is_read_as_single, "{name}: {losses:?}");
        let (found, warnings) = volume_again(written, given);
        let off = (found / expected - 1.0).abs();
        assert_eq!(
            off > exact,
            written.is_single,
            "{name}: {found}, expected {expected}"
        );
        assert_eq!(says(&warnings), written.is_single, "{name}: {warnings:?}");
    }
}

#[test]
fn sheets_of_a_millimetre_ten_kilometres_away() {
    let at = DVec3::new(10_000.123_4, -10_000.432_1, 12.3456);
    let size = DVec3::new(10.0, 8.0, 0.001);
    check(
        &scene(
            vec![slab(at, size, 0.0), slab(at + DVec3::Z, size, 0.7)],
            1.0,
        ),
        1e-4,
    );
}

#[test]
fn parts_in_millimetres_a_kilometre_away() {
    let at = DVec3::new(1e6 + 0.0313, 2e6 + 0.017, -1e6 - 0.011);
    let size = DVec3::new(200.0, 100.0, 1.0);
    check(&scene(vec![slab(at, size, 0.3)], 1e-3), 1e-6);
}

/// Five boxes around a room of 10 m by 8 m, at coordinates of a national grid.
fn house() -> Scene {
    let origin = DVec3::new(500_000.25, 5_400_000.5, 300.125);
    let boxes = [
        ([0.0, 0.0, 0.0], [10.0, 0.3, 3.0]),
        ([0.0, 7.7, 0.0], [10.0, 0.3, 3.0]),
        ([0.0, 0.3, 0.0], [0.3, 7.4, 3.0]),
        ([9.7, 0.3, 0.0], [0.3, 7.4, 3.0]),
        ([0.0, 0.0, 3.0], [10.0, 8.0, 0.2]),
    ];
    let meshes = boxes.map(|(at, size)| slab(origin + DVec3::from(at), size.into(), 0.0));
    scene(meshes.to_vec(), 1.0)
}

#[test]
fn a_house_in_a_national_grid() {
    let house = house();
    assert!((volume(&house) - 47.32).abs() < 1e-6);
    check(&house, 1e-5);
}

fn glb(scene: &Scene) -> Vec<u8> {
    let mut bytes = Vec::new();
    gltf::write(scene, &mut bytes).unwrap();
    bytes
}

/// The JSON of a GLB.
fn json(glb: &[u8]) -> String {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    String::from_utf8(glb[20..20 + length].to_vec()).unwrap()
}

#[test]
fn gltf_has_one_translation_for_all_of_a_house() {
    let text = json(&glb(&house()));
    let root = "\"translation\":[500005.0,302.0,-5400005.0]";
    assert!(text.contains(root), "{text}");
    assert_eq!(text.matches("\"translation\"").count(), 1, "{text}");
    // The lowest corner is the rounded one that is stored.
    let least = f64::from((5_400_000.5_f64 - 5_400_005.0) as f32);
    assert!(
        text.contains(&format!("\"min\":[-4.75,{least},-1.875]")),
        "{text}"
    );
}

/// Whole numbers that single precision holds: nothing is lost, and nothing is said.
#[test]
fn what_loses_nothing_says_nothing() {
    let whole = scene(
        vec![slab(DVec3::new(5e5, 5.4e6, 300.0), DVec3::ONE, 0.0)],
        1.0,
    );
    for written in WRITTEN
        .iter()
        .filter(|w| matches!(w.name, "a.ply" | "a.obj" | "a.wrl"))
    {
        let losses = (written.losses)(&whole);
        assert!(
            losses.iter().all(|said| !said.contains("float32")),
            "{losses:?}"
        );
        let (found, warnings) = volume_again(written, &whole);
        assert!((found - 1.0).abs() < 1e-12, "{}: {found}", written.name);
        assert!(warnings.is_empty(), "{}: {warnings:?}", written.name);
    }
}

#[test]
fn what_single_precision_holds_is_written_as_ever() {
    let near = scene(
        vec![slab(
            DVec3::new(3.1, 0.2, 7.3),
            DVec3::new(1.1, 0.7, 0.01),
            0.4,
        )],
        1.0,
    );
    let text = json(&glb(&near));
    assert!(!text.contains("\"translation\""), "{text}");
    // Far away, but at whole numbers.
    let whole = scene(
        vec![slab(DVec3::new(5e5, 5.4e6, 300.0), DVec3::ONE, 0.0)],
        1.0,
    );
    assert!(!json(&glb(&whole)).contains("\"translation\""));
    assert!(
        stl::losses(&whole)
            .iter()
            .all(|said| !said.contains("float32"))
    );
}

/// What is far from most of a scene has an origin of its own.
#[test]
fn a_sheet_far_from_everything_else_keeps_its_thickness() {
    let ground = slab(
        DVec3::new(-20_000.0, -20_000.0, -1.0),
        DVec3::new(40_000.0, 40_000.0, 1.0),
        0.0,
    );
    let sheet = slab(
        DVec3::new(10_000.123_4, -10_000.432_1, 12.3456),
        DVec3::new(10.0, 8.0, 0.001),
        0.7,
    );
    let only_sheet = volume(&scene(vec![sheet.clone()], 1.0));
    let given = scene(vec![ground, sheet], 1.0);
    let again = read(&glb(&given), "a.glb", &Memory::new()).unwrap();
    assert!(again.warnings.is_empty(), "{:?}", again.warnings);
    let mut found = again.scene;
    found.objects.remove(0);
    let off = volume(&found) / only_sheet - 1.0;
    assert!(off.abs() < 1e-4, "{off}");
    let said = stl::losses(&given).join(", ");
    assert!(
        said.contains("details of 1 objects (coordinates as float32 at 10000 m"),
        "{said}"
    );
    assert!(!said.contains("--place"), "no place helps all: {said}");
}

/// All else that has a place: instances, exact shapes, lights and cameras.
#[test]
fn everything_is_where_it_was() {
    let mut given = house();
    let place = DVec3::new(500_003.123, 5_400_004.456, 301.789);
    // A mesh that is far away in its own coordinates, too.
    let shared = Arc::new(slab(
        DVec3::new(40_000.1, 0.2, 0.3),
        DVec3::new(0.5, 0.5, 0.001),
        0.0,
    ));
    for k in 0..2 {
        let back = DAffine3::from_translation(place + f64::from(k) * DVec3::X)
            * DAffine3::from_rotation_z(0.5)
            * DAffine3::from_translation(DVec3::new(-40_000.1, -0.2, -0.3));
        let instance = MeshInstance::new(shared.clone(), back).unwrap();
        given
            .objects
            .push(Object::new("leaf", Shape::Instance(instance)));
    }
    let ball = Primitive::sphere(place, 0.25, 0);
    given
        .objects
        .push(Object::new("ball", Shape::Primitive(ball)));
    given.lights.push(Light {
        name: "lamp".into(),
        kind: LightKind::Point {
            position: place + DVec3::Z,
            intensity: Rgb::WHITE,
        },
    });
    given.cameras.push(Camera {
        name: "view".into(),
        eye: place,
        target: place + DVec3::X,
        up: DVec3::Z,
        vertical_fov: 1.0,
        size: None,
    });
    let again = read(&glb(&given), "a.glb", &Memory::new()).unwrap();
    let units = given.units;
    let found = again.scene.adapted(units);
    assert_eq!(found.objects.len(), given.objects.len());
    for (found, given) in found.objects.iter().zip(&given.objects) {
        let [a, b] = [found.bounds(), given.bounds()];
        let off = (a.min - b.min)
            .abs()
            .max((a.max - b.max).abs())
            .max_element();
        // A tessellated ball reaches its box at its poles alone.
        let most = if given.name == "ball" { 0.01 } else { 1e-6 };
        assert!(off < most, "{}: {off}", given.name);
    }
    let leaf = |scene: &Scene| {
        volume(&Scene {
            objects: scene.objects[5..6].to_vec(),
            ..Scene::default()
        })
    };
    assert!((leaf(&found) / leaf(&given) - 1.0).abs() < 1e-4);
    assert!((found.cameras[0].eye - place).length() < 1e-8);
    let LightKind::Point { position, .. } = found.lights[0].kind else {
        panic!("a point light")
    };
    assert!((position - place - DVec3::Z).length() < 1e-8, "{position}");
}

/// Not read again here: the text has all digits, and other programs round them.
#[test]
fn packages_for_printers_say_what_their_readers_lose() {
    let said = three_mf::losses(&house()).join(", ");
    let expected = "details of 4 objects (coordinates as float32 at 5400000 m are 0.5 m apart, in programs \
                    that read them; move the model to its origin with --place FILE:translate=-500005,-5400005,-302)";
    assert!(said.contains(expected), "{said}");
}

/// Four corners of a tile of 1 m in a national grid, as text, moved by some metres.
fn tile(by: f64) -> String {
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let line =
        |(x, y): &(f64, f64)| format!("{} {} 300.5\n", 500_000.25 + x + by, 5_400_000.5 + y + by);
    corners.iter().map(line).collect()
}

fn check_read(name: &str, text: &str, files: &Memory, expected: &[&str]) {
    let found =
        read(text.as_bytes(), name, files).unwrap_or_else(|e| panic!("{name}: {e}\n{text}"));
    let said: Vec<&str> = found.warnings.iter().map(|w| w.message.as_str()).collect();
    assert_eq!(said.len(), expected.len(), "{name}: {said:?}");
    for (said, expected) in said.iter().zip(expected) {
        assert!(said.starts_with(expected), "{name}: {said}");
    }
}

const COARSE: &str = "coordinates as float32 at 5400000 are 0.5 apart";

#[test]
fn files_in_single_precision_say_so_far_from_the_origin() {
    let none = Memory::new();
    let ply = |kind: &str, by: f64| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty {kind} x\nproperty {kind} y\nproperty {kind} z\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n{}4 0 1 2 3\n",
            tile(by)
        )
    };
    check_read("a.ply", &ply("float", 0.0), &none, &[COARSE]);
    check_read("a.ply", &ply("double", 0.0), &none, &[]);
    // Text that has more digits than its declaration is read with all of them.
    check_read("a.ply", &ply("float", 0.123), &none, &[]);
    let vtk = |kind: &str| {
        format!(
            "# vtk DataFile Version 3.0\ntile\nASCII\nDATASET POLYDATA\nPOINTS 4 {kind}\n{}POLYGONS 1 5\n4 0 1 2 3\n",
            tile(0.0)
        )
    };
    check_read("a.vtk", &vtk("float"), &none, &[COARSE]);
    check_read("a.vtk", &vtk("double"), &none, &[]);
    let vtp = |kind: &str| {
        format!(
            "<VTKFile type=\"PolyData\" version=\"1.0\"><PolyData><Piece NumberOfPoints=\"4\" NumberOfPolys=\"1\">\
             <Points><DataArray type=\"{kind}\" NumberOfComponents=\"3\" format=\"ascii\">{}</DataArray></Points>\
             <Polys><DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1 2 3</DataArray>\
             <DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">4</DataArray></Polys>\
             </Piece></PolyData></VTKFile>",
            tile(0.0)
        )
    };
    check_read("a.vtp", &vtp("Float32"), &none, &[COARSE]);
    check_read("a.vtp", &vtp("Float64"), &none, &[]);
}

/// A triangle of 1 m as glTF, with this corner and this translation of its node.
fn gltf_triangle(corner: [f32; 3], translation: [f64; 3]) -> (String, Memory) {
    let [x, y, z] = corner;
    let positions = [corner, [x + 1.0, y, z], [x, y, z + 1.0]];
    let bytes = positions
        .as_flattened()
        .iter()
        .flat_map(|v| v.to_le_bytes());
    let text = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"scenes\":[{{\"nodes\":[0]}}],\
         \"nodes\":[{{\"mesh\":0,\"translation\":{translation:?}}}],\
         \"meshes\":[{{\"primitives\":[{{\"attributes\":{{\"POSITION\":0}}}}]}}],\
         \"accessors\":[{{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\
         \"min\":[0,0,0],\"max\":[1,1,1]}}],\"bufferViews\":[{{\"buffer\":0,\"byteLength\":36}}],\
         \"buffers\":[{{\"byteLength\":36,\"uri\":\"a.bin\"}}]}}"
    );
    (
        text,
        Memory::new().with("a.bin", bytes.collect::<Vec<u8>>()),
    )
}

#[test]
fn gltf_is_exact_where_its_nodes_are() {
    let place = [500_000.123, 300.456, -5_400_000.789];
    let (text, files) = gltf_triangle([0.0; 3], place);
    check_read("a.gltf", &text, &files, &[]);
    let found = read(text.as_bytes(), "a.gltf", &files).unwrap().scene;
    let bounds = found.bounds();
    assert_eq!(bounds.min, DVec3::from(place));
    assert!((bounds.size() - DVec3::new(1.0, 0.0, 1.0)).length() < 1e-8);
    let (text, files) = gltf_triangle([500_000.0, 300.0, -5_400_000.0], [0.0; 3]);
    check_read("a.gltf", &text, &files, &[COARSE]);
}
