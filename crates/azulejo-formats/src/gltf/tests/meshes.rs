//! Attributes, indices and deformation of vertices.

use super::{accessor, mesh_of, one_mesh, read, triangle};
use azulejo_scene::Rgb;
use glam::{DVec2, DVec3};

/// Bits as a float, to put other data into the buffer.
fn bits(bytes: [u8; 4]) -> f32 {
    f32::from_le_bytes(bytes)
}

const PLAIN: &str = "{\"attributes\":{\"POSITION\":0}}";

/// The default grey of primitives without a material causes no warning.
#[test]
fn a_triangle_without_indices() {
    let scene = read(&triangle(&[], "", &one_mesh(PLAIN)), &[]);
    let mesh = mesh_of(&scene, 0);
    assert_eq!(mesh.positions, [DVec3::ZERO, DVec3::X, DVec3::Y]);
    assert_eq!(mesh.faces.corners, [0, 1, 2]);
    assert_eq!(scene.materials[0].diffuse, Rgb::grey(0.5));
    assert_eq!((&mesh.normals, &mesh.uvs), (&None, &None));
    assert_eq!(scene.units.metres_per_unit, Some(1.0));
    assert!(scene.units.photometric);
}

#[test]
fn indices_of_every_size() {
    let primitive = one_mesh("{\"attributes\":{\"POSITION\":0},\"indices\":1}");
    let check = |packed: &[f32], component| {
        let file = triangle(packed, &accessor(component, 3, "SCALAR"), &primitive);
        let scene = read(&file, &[]);
        assert_eq!(mesh_of(&scene, 0).faces.corners, [2, 0, 1]);
    };
    check(&[bits([2, 0, 1, 0])], 5121);
    check(&[bits([2, 0, 0, 0]), bits([1, 0, 0, 0])], 5123);
    check(&[bits([2, 0, 0, 0]), 0.0, bits([1, 0, 0, 0])], 5125);
}

#[test]
fn triangles_out_of_range_are_left_out() {
    let two = bits([2, 0, 1, 7]);
    let file = triangle(
        &[two, bits([0, 1, 9, 9])],
        &accessor(5121, 8, "SCALAR"),
        &one_mesh("{\"attributes\":{\"POSITION\":0},\"indices\":1}"),
    );
    let warnings = ["not form a complete triangle", "with missing vertices"];
    let scene = read(&file, &warnings);
    assert_eq!(mesh_of(&scene, 0).faces.len(), 1);
}

#[test]
fn positions_that_are_not_finite() {
    let (nan, one) = (f32::NAN, 1.0);
    let more = [0.0, 0.0, nan, 0.0, 0.0, one, 0.0, one, 0.0, one, 0.0, 0.0];
    let file = triangle(
        &more,
        &accessor(5126, 4, "VEC3"),
        &one_mesh("{\"attributes\":{\"POSITION\":1},\"mode\":5}"),
    );
    let warnings = ["without min and max", "with missing vertices"];
    let scene = read(&file, &warnings);
    let mesh = mesh_of(&scene, 0);
    assert_eq!((mesh.faces.len(), mesh.positions[0]), (1, DVec3::ZERO));
}

#[test]
fn normals_and_texture_coordinates() {
    let more = [0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let normals = accessor(5126, 3, "VEC3");
    let file = triangle(
        &more,
        &(normals + &accessor(5126, 3, "VEC2")),
        &one_mesh("{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TEXCOORD_0\":2}}"),
    );
    let scene = read(&file, &["without a usable normal"]);
    let mesh = mesh_of(&scene, 0);
    let normals = mesh.normals.as_ref().unwrap();
    for corner in 0..3 {
        assert_eq!(normals.at(corner, corner as u32), DVec3::Z);
    }
    let uvs = mesh.uvs.as_ref().unwrap();
    assert_eq!(uvs.values[1], DVec2::new(2.0, 1.0));
}

/// Two primitives over the same attributes share the vertices; a third has others.
#[test]
fn primitives_share_vertices_as_in_the_file() {
    let more = [0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 1.0, 0.0, 1.0];
    let file = triangle(
        &more,
        &accessor(5126, 3, "VEC3"),
        &(one_mesh(&format!(
            "{PLAIN},{{\"attributes\":{{\"POSITION\":0}},\"material\":0}},\
             {{\"attributes\":{{\"POSITION\":1,\"NORMAL\":1}}}}"
        )) + ",\"materials\":[{\"pbrMetallicRoughness\":{\"metallicFactor\":0}}]"),
    );
    let warnings = ["without min and max", "without a usable normal"];
    let scene = read(&file, &warnings);
    let mesh = mesh_of(&scene, 0);
    assert_eq!((mesh.positions.len(), mesh.faces.len()), (6, 3));
    assert_eq!(mesh.face_materials, [0, 1, 0]);
    assert_eq!(mesh.faces.corners, [0, 1, 2, 0, 1, 2, 3, 4, 5]);
}

/// `KHR_mesh_quantization`: normalized bytes, four for each vector.
#[test]
fn quantised_positions() {
    let more = [[0u8, 0, 0, 0], [127, 0, 0, 0], [0, 0x81, 0x80, 0]].map(bits);
    let file = triangle(
        &more,
        ",{\"bufferView\":1,\"componentType\":5120,\"normalized\":true,\"count\":3,\
          \"type\":\"VEC3\",\"min\":[0,-1,-1],\"max\":[1,0,0]}",
        &one_mesh("{\"attributes\":{\"POSITION\":1}}"),
    );
    let file = file.replace("\"byteOffset\":36,", "\"byteOffset\":36,\"byteStride\":4,");
    let scene = read(&file, &[]);
    let expected = [DVec3::ZERO, DVec3::X, DVec3::new(0.0, -1.0, -1.0)];
    assert_eq!(mesh_of(&scene, 0).positions, expected);
}

#[test]
fn sparse_positions() {
    let more = [bits([2, 0, 0, 0]), 5.0, 6.0, 7.0];
    let sparse = "\"sparse\":{\"count\":1,\
        \"indices\":{\"bufferView\":1,\"componentType\":5121},\
        \"values\":{\"bufferView\":1,\"byteOffset\":4}}";
    let check = |base: &str, expected: [DVec3; 3]| {
        let accessor = format!(
            ",{{{base}\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",{sparse},\
             \"min\":[0,0,0],\"max\":[5,6,7]}}"
        );
        let primitive = one_mesh("{\"attributes\":{\"POSITION\":1}}");
        let scene = read(&triangle(&more, &accessor, &primitive), &[]);
        assert_eq!(mesh_of(&scene, 0).positions, expected);
    };
    let changed = DVec3::new(5.0, 6.0, 7.0);
    check("\"bufferView\":0,", [DVec3::ZERO, DVec3::X, changed]);
    check("", [DVec3::ZERO, DVec3::ZERO, changed]);
}

#[test]
fn colours_are_linear_and_clamped() {
    let more = [0.25, 0.5, 2.0, 1.0, -1.0, 0.0, 0.0, 1.0, 0.5, 0.5, 0.5, 0.0];
    let file = triangle(
        &more,
        &accessor(5126, 3, "VEC4"),
        &one_mesh("{\"attributes\":{\"POSITION\":0,\"COLOR_0\":1}}"),
    );
    let scene = read(&file, &[]);
    let expected = [Rgb::new(0.25, 0.5, 1.0), Rgb::BLACK, Rgb::grey(0.5)];
    assert_eq!(mesh_of(&scene, 0).colors, expected);
}

#[test]
fn unused_vertices_are_dropped_if_they_are_the_majority() {
    let more = [bits([0, 0, 0, 0]), bits([0, 0, 0, 0])];
    let positions = ",{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}";
    let file = triangle(
        &more,
        &(accessor(5121, 3, "SCALAR") + positions),
        &one_mesh("{\"attributes\":{\"POSITION\":0},\"indices\":1}"),
    );
    let scene = read(&file, &[]);
    let mesh = mesh_of(&scene, 0);
    assert_eq!(
        (mesh.positions.len(), mesh.faces.corners.as_slice()),
        (1, &[0, 0, 0][..])
    );
}

#[test]
fn points_and_lines_have_no_surface() {
    let points = "{\"attributes\":{\"POSITION\":0},\"mode\":0}";
    let lines = "{\"attributes\":{\"POSITION\":0},\"mode\":3}";
    let file = triangle(&[], "", &one_mesh(&format!("{points},{lines},{PLAIN}")));
    let scene = read(&file, &["points: skipped", "lines: skipped"]);
    assert_eq!(scene.objects.len(), 1);
    let warnings = ["points: skipped", "the scene is empty"];
    let scene = read(&triangle(&[], "", &one_mesh(points)), &warnings);
    assert!(scene.objects.is_empty());
}

#[test]
fn morph_targets_by_their_weights() {
    let more = [0.0, 0.0, 4.0, 0.0, 0.0, 4.0, 0.0, 0.0, 4.0];
    let target = "{\"attributes\":{\"POSITION\":0},\"targets\":[{\"POSITION\":1}]}";
    let check = |mesh: &str, node: &str, height: f64| {
        let rest = format!(
            "\"nodes\":[{{\"mesh\":0{node}}}],\"meshes\":[{{\"primitives\":[{target}]{mesh}}}]"
        );
        let scene = read(&triangle(&more, &accessor(5126, 3, "VEC3"), &rest), &[]);
        assert_eq!(
            mesh_of(&scene, 0).positions[1],
            DVec3::new(1.0, 0.0, height)
        );
    };
    check("", "", 0.0);
    check(",\"weights\":[0.5]", "", 2.0);
    check(",\"weights\":[0.5]", ",\"weights\":[0.25]", 1.0);
}

/// The node of a skinned mesh does not affect its position: its joints do.
#[test]
fn skins_at_rest() {
    let joints = [bits([0, 1, 0, 0]); 3];
    let weights = [1.0, 0.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0];
    let more: Vec<f32> = joints.into_iter().chain(weights).collect();
    let accessors = accessor(5121, 3, "VEC4")
        + &accessor(5126, 3, "VEC4").replace("\"count\"", "\"byteOffset\":12,\"count\"");
    let rest = "\"nodes\":[{\"mesh\":0,\"skin\":0,\"translation\":[99,0,0]},\
         {\"children\":[2],\"translation\":[0,0,1]},{\"translation\":[0,0,2]}],\
         \"skins\":[{\"joints\":[1,2]}],\
         \"meshes\":[{\"primitives\":[{\"attributes\":\
         {\"POSITION\":0,\"JOINTS_0\":1,\"WEIGHTS_0\":2}}]}]";
    let scene = read(&triangle(&more, &accessors, rest), &[]);
    let heights = mesh_of(&scene, 0).positions.iter().map(|p| p.z);
    assert_eq!(heights.collect::<Vec<_>>(), [1.0, 2.0, 3.0]);
    assert_eq!(mesh_of(&scene, 0).positions[0].x, 0.0);
}

#[test]
fn meshopt_views() {
    // Indices 2, 0, 1 as meshoptimizer's sequence: a header, three differences, a tail.
    let packed = [bits([0xd1, 8, 6, 4]), 0.0, 0.0];
    let primitive = one_mesh("{\"attributes\":{\"POSITION\":0},\"indices\":1}");
    let file = triangle(&packed, &accessor(5123, 3, "SCALAR"), &primitive);
    let view = "{\"buffer\":0,\"byteOffset\":36,\"byteLength\":12}";
    assert!(file.contains(view));
    let compressed = "{\"buffer\":0,\"byteLength\":6,\"extensions\":{\"EXT_meshopt_compression\":\
         {\"buffer\":0,\"byteOffset\":36,\"byteLength\":8,\"byteStride\":2,\"count\":3,\
         \"mode\":\"INDICES\"}}}";
    let file = file.replace(view, compressed);
    assert_eq!(mesh_of(&read(&file, &[]), 0).faces.corners, [2, 0, 1]);
    let khronos = file.replace("EXT_meshopt", "KHR_meshopt");
    assert_eq!(mesh_of(&read(&khronos, &[]), 0).faces.corners, [2, 0, 1]);
    let damaged = file.replace("\"byteLength\":8,", "\"byteLength\":6,");
    let error = crate::gltf::read(
        damaged.as_bytes(),
        "a.gltf",
        &crate::Memory::new(),
        &crate::ReadOptions::default(),
    );
    let message = error.unwrap_err().to_string();
    assert!(message.contains("damaged compressed data"), "{message}");
}

/// A hundred thousand attributes of one mesh in ten thousand nodes: hashed for each, they took minutes.
#[test]
fn attributes_that_are_not_read_cost_nothing_per_instance() {
    let many: String = (0..100_000).map(|i| format!("\"_A{i}\":0,")).collect();
    let nodes = "{\"mesh\":0},".repeat(10_000);
    let rest = format!(
        "\"nodes\":[{nodes}{{\"mesh\":0}}],\
         \"meshes\":[{{\"primitives\":[{{\"attributes\":{{{many}\"POSITION\":0}}}}]}}]"
    );
    let started = std::time::Instant::now();
    assert_eq!(read(&triangle(&[], "", &rest), &[]).objects.len(), 10_001);
    assert!(started.elapsed().as_secs() < 100, "{:?}", started.elapsed());
}

/// Bounds are computed, not read.
#[test]
fn positions_without_bounds() {
    let file = triangle(&[], "", &one_mesh(PLAIN)).replace(",\"min\":[0,0,0],\"max\":[1,1,0]", "");
    let scene = read(&file, &["positions without min and max"]);
    assert_eq!(mesh_of(&scene, 0).positions[2], DVec3::Y);
}
