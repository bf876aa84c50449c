//! Unreadable files and their errors.

use super::{accessor, json, one_mesh, triangle};
use crate::{Memory, ReadOptions, gltf};

fn check_with(file: &[u8], options: &ReadOptions, part: &str) {
    let read = gltf::read(file, "a.gltf", &Memory::new(), options);
    let message = read.map(|loaded| loaded.warnings).unwrap_err().to_string();
    assert!(message.contains(part), "{message}, expected {part}");
}

fn check(file: &str, part: &str) {
    check_with(file.as_bytes(), &ReadOptions::default(), part);
}

#[test]
fn files_without_a_readable_mesh() {
    let primitive = |p: &str| one_mesh(&format!("{{\"attributes\":{{{p}}}}}"));
    let missing = json(&format!(
        "\"buffers\":[{{\"byteLength\":36,\"uri\":\"x.bin\"}}],\
         \"bufferViews\":[{{\"buffer\":0,\"byteLength\":36}}],\
         \"accessors\":[{{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\
         \"min\":[0,0,0],\"max\":[1,1,0]}}],{}",
        primitive("\"POSITION\":0")
    ));
    check(&missing, "buffer \"x.bin\": there is no such file");
    let short = triangle(&[], "", &primitive("\"POSITION\":0"));
    check(
        &short.replace("\"count\":3", "\"count\":4"),
        "4 elements reach beyond the 36 bytes",
    );
    check(
        &short.replace("\"VEC3\"", "\"VEC2\""),
        "does not have 3 components per element",
    );
    let beyond = short.replace("\"byteLength\":36}", "\"byteLength\":37}");
    check(&beyond, "beyond the 36 bytes of its buffer");
    let lost = "{\"attributes\":{\"POSITION\":0},\"indices\":1}";
    let floats = triangle(&[1.0; 3], &accessor(5126, 3, "SCALAR"), &one_mesh(lost));
    check(&floats, "that are not integers");
    let wide = short.replace("\"byteLength\":36}", "\"byteLength\":36,\"byteStride\":4}");
    check(&wide, "elements of 12 bytes every 4 bytes");
}

#[test]
fn bombs() {
    // A billion vertices in no bytes at all.
    let sparse = json(&format!(
        "\"buffers\":[{{\"byteLength\":16,\"uri\":\"data:,%00%00%00%00\"}}],\
         \"bufferViews\":[{{\"buffer\":0,\"byteLength\":4}}],\
         \"accessors\":[{{\"componentType\":5126,\"count\":1000000000,\"type\":\"VEC3\",\
         \"sparse\":{{\"count\":1,\"indices\":{{\"bufferView\":0,\"componentType\":5121}},\
         \"values\":{{\"bufferView\":0}}}},\"min\":[0,0,0],\"max\":[1,1,0]}}],{}",
        one_mesh("{\"attributes\":{\"POSITION\":0}}")
    ));
    check(&sparse, "of which the file has no bytes");
    // Each of thirty nodes has the next as a child twice.
    let nodes: String = (1..30)
        .map(|i| format!("{{\"children\":[{i},{i}]}},"))
        .collect();
    let rest = format!(
        "\"nodes\":[{nodes}{{\"mesh\":0}}],\
         \"meshes\":[{{\"primitives\":[{{\"attributes\":{{\"POSITION\":0}}}}]}}]"
    );
    let few = ReadOptions {
        most_elements: 10_000,
        ..ReadOptions::default()
    };
    check_with(
        triangle(&[], "", &rest).as_bytes(),
        &few,
        "expand to more than 10000",
    );
    // A mesh of nothing but points, in thousands of instances.
    let points = "{\"attributes\":{},\"mode\":0},".repeat(900);
    let nodes = "{\"mesh\":0},".repeat(900);
    let rest = format!(
        "\"nodes\":[{nodes}{{}}],\"meshes\":[{{\"primitives\":[{points}{{\"attributes\":{{}}}}]}}]"
    );
    check_with(json(&rest).as_bytes(), &few, "expand to more than 10000");
    let chain: String = (1..400)
        .map(|i| format!("{{\"children\":[{i}]}},"))
        .collect();
    check(
        &json(&format!("\"nodes\":[{chain}{{}}]")),
        "nested more than 256 deep",
    );
    check(
        &json("\"nodes\":[{\"children\":[0]}]"),
        "a node that is its own ancestor: nodes[0]",
    );
}
