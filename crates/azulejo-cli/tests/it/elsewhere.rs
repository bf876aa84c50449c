//! Models as other programs write and want them.

use crate::support::Folder;
use azulejo_formats::Memory;
use azulejo_scene::{Mesh, Scene, Shape};
use serde_json::Value;

fn scene(folder: &Folder, name: &str) -> Scene {
    let loaded = azulejo_formats::read(&folder.read(name), name, &Memory::new());
    loaded.unwrap().scene
}

fn mesh(scene: &Scene, object: usize) -> &Mesh {
    let Shape::Mesh(mesh) = &scene.objects[object].shape else {
        panic!("a mesh")
    };
    mesh
}

/// The JSON of a GLB.
fn json(folder: &Folder, name: &str) -> Value {
    let bytes = folder.read(name);
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&bytes[20..20 + length]).unwrap()
}

/// Two squares at a right angle over the x axis, of one smoothing group, and a third that is flat, apart.
const ROOF: &str = "v -1 0 1\nv 1 0 1\nv 1 1 0\nv -1 1 0\nv 1 0 -1\nv -1 0 -1\nv 5 0 0\nv 6 0 0\nv 6 0 1\nv 5 0 1\n\
                    o roof\ns 1\nf 1 2 3 4\nf 4 3 5 6\no floor\ns off\nf 7 10 9 8\n";

/// Nothing becomes faceted on the way: a ridge of one group has one normal, upwards.
#[test]
fn smoothing_groups_become_normals() {
    let folder = Folder::new();
    folder.write("roof.obj", ROOF);
    for name in ["a.glb", "a.ply", "a.x3d", "a.wrl", "a.obj"] {
        let said = folder.ok(&format!("convert roof.obj -o {name}")).err;
        assert!(!said.contains("smoothing"), "{name}: {said}");
        let scene = scene(&folder, name);
        let roof = mesh(&scene, 0);
        let normals = roof.normals.as_ref().expect(name);
        let mut ridge = 0;
        for (corner, &vertex) in roof.faces.corners.iter().enumerate() {
            let normal = normals.at(corner, vertex);
            if roof.positions[vertex as usize].y == 1.0 {
                ridge += 1;
                assert!(normal.y > 1.0 - 1e-6, "{name}: {normal}");
            } else {
                assert!((normal.y - 0.5f64.sqrt()).abs() < 1e-6, "{name}: {normal}");
            }
        }
        assert!(ridge >= 4, "{name}");
    }
    folder.ok("solve roof.obj --studio -o lit.glb --rays 16 --patches 40");
    let scene = scene(&folder, "lit.glb");
    assert!(mesh(&scene, 0).normals.is_some());
}

/// What a file says is flat stays apart at its edges; where it says nothing, edges below 30° share vertices.
#[test]
fn flat_is_flat() {
    let folder = Folder::new();
    let vertices = "v -1 0 1\nv 1 0 1\nv 1 0.2 0\nv -1 0.2 0\nv 1 0 -1\nv -1 0 -1\n";
    let model = |smooth: &str| format!("{vertices}{smooth}f 1 2 3 4\nf 4 3 5 6\n");
    folder.write("off.obj", model("s off\n"));
    folder.write("none.obj", model(""));
    folder.write("group.obj", model("s 2\n"));
    folder.ok("convert none.obj -o none.glb");
    let crease = "#VRML V2.0 utf8\nShape { geometry IndexedFaceSet { coord Coordinate { point [ -1 0 1, 1 0 1, \
                  1 0.2 0, -1 0.2 0, 1 0 -1, -1 0 -1 ] } coordIndex [ 0 1 2 3 -1 3 2 4 5 -1 ] } }\n";
    folder.write("crease.wrl", crease);
    for (name, vertices) in [
        ("off.obj", 8),
        ("none.obj", 6),
        ("group.obj", 6),
        ("none.glb", 8),
        ("crease.wrl", 8),
    ] {
        let options = "--sun 150,30,1 --sky 0.05 --ground none --rays 16 --patches 2 --sides front";
        folder.ok(&format!("solve {name} -o lit.grf {options}"));
        let scene = scene(&folder, "lit.grf");
        assert_eq!(mesh(&scene, 0).positions.len(), vertices, "{name}");
    }
}

/// PLY is of triangles unless polygons are wished, also where spheres become polygons.
#[test]
fn ply_is_of_triangles() {
    let folder = Folder::new();
    folder.write("roof.obj", ROOF);
    folder.write(
        "ball.wrl",
        "#VRML V2.0 utf8\nShape { geometry Sphere { radius 1 } }\n",
    );
    let corners = |line: &str, name: &str| {
        folder.ok(line);
        let scene = scene(&folder, name);
        let faces = &mesh(&scene, 0).faces;
        faces.iter().map(<[u32]>::len).max().unwrap()
    };
    assert_eq!(corners("convert roof.obj -o a.ply", "a.ply"), 3);
    assert_eq!(
        corners("convert roof.obj -o b.ply --triangles=no", "b.ply"),
        4
    );
    assert_eq!(corners("convert ball.wrl -o c.ply", "c.ply"), 3);
    assert_eq!(corners("convert roof.obj -o d.obj", "d.obj"), 4);
    assert_eq!(corners("convert ball.wrl -o e.obj --triangles", "e.obj"), 3);
    let solve = "solve roof.obj --studio --rays 16 --patches 40 -o";
    assert_eq!(corners(&format!("{solve} f.ply"), "f.ply"), 3);
    assert_eq!(
        corners(&format!("{solve} g.ply --triangles=no"), "g.ply"),
        4
    );
}

/// Files by Blender have colours in sRGB, with a note; an option decides otherwise.
#[test]
fn vertex_colours_are_what_is_said() {
    let folder = Folder::new();
    let faces = "v 0 0 0 0.7353 0.7353 0.7353\nv 1 0 0 0.7353 0.7353 0.7353\nv 0 1 0 0.7353 0.7353 0.7353\nf 1 2 3\n";
    folder.write("blender.obj", format!("# Blender 5.3.0\n{faces}"));
    folder.write("plain.obj", faces);
    for (line, expected, noted) in [
        ("blender.obj", 0.5, true),
        ("blender.obj --vertex-colors linear", 0.7353, false),
        ("plain.obj", 0.7353, false),
        ("plain.obj --vertex-colors srgb", 0.5, false),
    ] {
        let said = folder.ok(&format!("convert {line} -o a.grf")).err;
        assert_eq!(said.contains("sRGB"), noted, "{line}: {said}");
        let color = mesh(&scene(&folder, "a.grf"), 0).colors[0];
        assert!((color.g - expected).abs() < 1e-3, "{line}: {color:?}");
    }
    assert_eq!(
        folder.run("info plain.obj --vertex-colors gamma").code,
        Some(2)
    );
}

/// `--check` says what a packer has removed from a baked file, and light on vertices survives one that drops the extras
/// of meshes.
#[test]
fn what_packers_remove_is_said() {
    let folder = Folder::new();
    folder.write("roof.obj", ROOF);
    folder.ok("bake roof.obj --studio -o baked.glb --size 32 --error 20%");
    let packed = |name: &str, change: &dyn Fn(&mut Value)| {
        let bytes = folder.read(name);
        let mut root = json(&folder, name);
        change(&mut root);
        root["asset"]["generator"] = "gltfpack 1.3".into();
        let mut text = root.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let old = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        let rest = &bytes[20 + old..];
        let mut file = b"glTF\x02\0\0\0".to_vec();
        file.extend(((20 + text.len() + rest.len()) as u32).to_le_bytes());
        file.extend((text.len() as u32).to_le_bytes());
        file.extend(b"JSON");
        file.extend(&text);
        file.extend(rest);
        folder.write("packed.glb", file);
    };
    packed("baked.glb", &|root| {
        for material in root["materials"].as_array_mut().unwrap() {
            material["extensions"] = serde_json::json!({});
        }
        for mesh in root["meshes"].as_array_mut().unwrap() {
            for primitive in mesh["primitives"].as_array_mut().unwrap() {
                let attributes = primitive["attributes"].as_object_mut().unwrap();
                attributes.remove("TEXCOORD_1");
            }
        }
    });
    let run = folder.run("bake packed.glb --check");
    assert_eq!(run.code, Some(1));
    let said = "gltfpack 1.3 has written the file since it was baked, and lost MOZ_lightmap of materials and TEXCOORD_1";
    assert!(run.err.contains(said), "{}", run.err);
    folder.ok("convert roof.obj -o flat.glb");
    folder.ok("solve flat.glb --studio -o lit.glb --rays 16 --patches 40");
    packed("lit.glb", &|root| {
        for mesh in root["meshes"].as_array_mut().unwrap() {
            mesh.as_object_mut().unwrap().remove("extras");
        }
    });
    let irradiance = |name: &str| mesh(&scene(&folder, name), 0).irradiance.clone();
    assert!(!irradiance("lit.glb").is_empty());
    assert_eq!(irradiance("packed.glb"), irradiance("lit.glb"));
}
