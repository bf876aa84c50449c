//! Small files that expand to more than any machine holds: refused before they take the memory.

use crate::support::{Folder, Run};
use std::fmt::Write;
use std::process::Command;

/// Address space of the program, kilobytes: libraries, stacks and a hundred megabytes of data.
const MEMORY: u32 = 700_000;

/// Each is refused, by `info`, within the memory.
fn check(name: &str, content: impl AsRef<[u8]>, expected: &str) {
    let folder = Folder::new();
    folder.write(name, content);
    let program = env!("CARGO_BIN_EXE_azulejo");
    let line = format!("ulimit -v {MEMORY}; exec '{program}' info {name}");
    let run = Command::new("sh")
        .args(["-c", &line])
        .env("RAYON_NUM_THREADS", "1")
        .current_dir(folder.path(""))
        .output();
    let run = Run::of(run.unwrap());
    assert_eq!(run.code, Some(1), "{name}: {}", run.err);
    assert!(run.err.contains(expected), "{name}: {}", run.err);
}

const TOO_MUCH: &str = "expand to more than";

/// `first`, and sixty times twice what is before it.
fn doubled(first: &str, next: impl Fn(usize) -> String) -> String {
    (0..60).fold(first.to_owned(), |text, k| text + &next(k))
}

#[test]
fn solids_of_grf() {
    let sphere = "primitive begin kind = sphere map = 1 0 0 0 1 0 0 0 1 0 0 0 end primitive";
    let first = format!("ext define begin name = d0 {sphere} end ext\n");
    let copy = |k: usize| format!("instance begin of = d{k} end instance ");
    let plain = doubled(&first, |k| {
        let copies = copy(k).repeat(2);
        format!("ext define begin name = d{} {copies} end ext\n", k + 1)
    });
    check(
        "plain.grf",
        plain + "ext instance begin of = d60 end ext\n",
        TOO_MUCH,
    );
    let united = doubled(&first, |k| {
        let side = copy(k);
        format!(
            "ext define begin name = d{} csg begin operation = union left begin {side} end left \
             right begin {side} end right end csg end ext\n",
            k + 1
        )
    });
    check("united.grf", united, TOO_MUCH);
}

#[test]
fn arrays_of_mgf() {
    let corners = "v a =\n p 0 0 0\nv b =\n p 1 0 0\nv c =\n p 0 1 0\n";
    // Arrays in arrays have to be counted, which takes seconds; of a large one it is known at once.
    let nested = "xf -a 1000 -t 1 0 0\nxf -a 1000 -t 0 1 0\nxf -a 1000 -t 0 0 1";
    let large = "xf -a 1000 -t 1 0 0 -a 1000 -t 0 1 0 -a 1000 -t 0 0 1";
    let (face, ball) = ("f a b c", "sph a 1");
    let mut cases = vec![
        ("face.mgf", large, face, 1),
        ("ball.mgf", large, ball, 1),
        ("faces.mgf", nested, face, 3),
    ];
    if azulejo_testing::is_thorough() {
        cases.push(("balls.mgf", nested, ball, 3));
    }
    for (name, array, surface, depth) in cases {
        let ends = "xf\n".repeat(depth);
        check(
            name,
            format!("{corners}{array}\n{surface}\n{ends}"),
            TOO_MUCH,
        );
    }
}

#[test]
fn reused_nodes_of_vrml_and_x3d() {
    let group = |k: usize| {
        format!(
            "DEF g{} Group {{ children [ USE g{k} USE g{k} ] }}\n",
            k + 1
        )
    };
    let texture = "PixelTexture { image 1 1 1 9 }";
    for (name, shape) in [
        ("box.wrl", "Shape { geometry Box {} }".to_owned()),
        (
            "ball.wrl",
            format!(
                "Shape {{ geometry Sphere {{}} appearance Appearance {{ texture {texture} }} }}"
            ),
        ),
        ("light.wrl", "PointLight {}".to_owned()),
    ] {
        let first = format!("#VRML V2.0 utf8\nDEF g0 Group {{ children [ {shape} ] }}\n");
        check(name, doubled(&first, group), TOO_MUCH);
    }
    let mut old_shapes = vec![("old-ball.wrl", "Texture2 { image 1 1 1 9 } Sphere {}")];
    if azulejo_testing::is_thorough() {
        old_shapes.push(("old-cube.wrl", "Cube {}"));
    }
    for (name, shape) in old_shapes {
        let first = format!("#VRML V1.0 ascii\nSeparator {{ DEF g0 Separator {{ {shape} }}\n");
        let old = doubled(&first, |k| {
            format!("DEF g{} Separator {{ USE g{k} USE g{k} }}\n", k + 1)
        });
        check(name, old + "}", TOO_MUCH);
    }
    let first = "<X3D><Scene><Group DEF='g0'><Shape><Box/></Shape></Group>\n";
    let x3d = doubled(first, |k| {
        format!(
            "<Group DEF='g{}'><Group USE='g{k}'/><Group USE='g{k}'/></Group>\n",
            k + 1
        )
    });
    check("new.x3d", x3d + "</Scene></X3D>", TOO_MUCH);
}

/// A file of a triangle with these parts of JSON, after a buffer of `floats` zeros.
fn gltf(floats: usize, parts: &str) -> Vec<u8> {
    let bytes = 4 * floats;
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"buffers":[{{"byteLength":{bytes}}}],
        "bufferViews":[{{"buffer":0,"byteLength":{bytes}}}],{parts}}}"#
    );
    let json = format!("{json:<width$}", width = json.len().next_multiple_of(4));
    let mut file = b"glTF\x02\0\0\0".to_vec();
    let chunk = |kind: &[u8; 4], content: &[u8]| {
        let length = (content.len() as u32).to_le_bytes();
        [&length, &kind[..], content].concat()
    };
    let chunks = [
        chunk(b"JSON", json.as_bytes()),
        chunk(b"BIN\0", &vec![0; bytes]),
    ];
    let length = 12 + chunks.iter().map(Vec::len).sum::<usize>();
    file.extend((length as u32).to_le_bytes());
    file.extend(chunks.concat());
    file
}

#[test]
fn instances_of_gltf() {
    let mesh = r#""meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}]"#;
    let list = |count: usize| {
        format!(r#"{{"bufferView":0,"componentType":5126,"type":"VEC3","count":{count}}}"#)
    };
    // 60,000 vertices in 20,000 places; then in a node for each.
    let many = format!(
        r#""accessors":[{}],"extensionsUsed":["EXT_mesh_gpu_instancing"],{mesh},"nodes":[{{"mesh":0,
        "extensions":{{"EXT_mesh_gpu_instancing":{{"attributes":{{"TRANSLATION":0}}}}}}}}]"#,
        list(60_000)
    );
    check("places.glb", gltf(180_000, &many), TOO_MUCH);
    let mut children = String::new();
    for k in 1..3000 {
        let _ = write!(children, "{}{k}", if k > 1 { "," } else { "" });
    }
    let each = r#",{"mesh":0}"#.repeat(2999);
    let nodes = format!(
        r#""accessors":[{}],{mesh},"nodes":[{{"children":[{children}]}}{each}]"#,
        list(60_000)
    );
    check("nodes.glb", gltf(180_000, &nodes), TOO_MUCH);
    // Numbers that are nowhere in the file.
    let sparse =
        r#"{"count":1,"indices":{"bufferView":0,"componentType":5121},"values":{"bufferView":0}}"#;
    let zeros = format!(
        r#""accessors":[{{"componentType":5126,"type":"VEC3","count":60000000,"sparse":{sparse}}}],
        {mesh},"nodes":[{{"mesh":0}}]"#
    );
    check(
        "zeros.glb",
        gltf(9, &zeros),
        "of which the file has no bytes",
    );
}

#[test]
fn blocks_of_dxf() {
    let face: String = [10, 20, 30, 11, 21, 31, 12, 22, 32]
        .iter()
        .map(|code| format!("{code}\n{}\n", i32::from(matches!(code, 11 | 22))))
        .collect();
    let first =
        format!("0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n2\nb0\n0\n3DFACE\n8\nx\n{face}0\nENDBLK\n");
    let blocks = doubled(&first, |k| {
        let inserts = format!("0\nINSERT\n2\nb{k}\n").repeat(2);
        format!("0\nBLOCK\n2\nb{}\n{inserts}0\nENDBLK\n", k + 1)
    });
    let end = "0\nENDSEC\n0\nSECTION\n2\nENTITIES\n0\nINSERT\n2\nb60\n0\nENDSEC\n0\nEOF\n";
    check("blocks.dxf", blocks + end, TOO_MUCH);
}

/// A colour profile of PNG that decompresses to gigabytes, and pictures of the largest size in many
/// copies.
#[test]
fn pictures_of_obj() {
    let folder = Folder::new();
    let mut materials = String::new();
    let header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8192 +X 16384\n";
    for k in 0..20 {
        let _ = write!(materials, "newmtl m{k}\nmap_Kd p{k}.hdr\n");
        let mut picture = header.to_vec();
        picture.resize(1 << 15, 0);
        folder.write(&format!("p{k}.hdr"), picture);
    }
    folder.write("a.mtl", materials);
    let faces: String = (0..20).map(|k| format!("usemtl m{k}\nf 1 2 3\n")).collect();
    folder.write(
        "a.obj",
        format!("mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n{faces}"),
    );
    let info = folder.json("info a.obj");
    assert_eq!(info["warnings"].as_array().unwrap().len(), 20);
}
