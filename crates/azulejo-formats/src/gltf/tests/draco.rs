//! Primitives compressed with Draco.

use super::{json, loaded, mesh_of};
use crate::{Memory, ReadOptions, gltf};
use azulejo_scene::{Mesh, Rgb};
use draco_core as draco;
use glam::DVec3;

/// The heights (x − 1)(y − 1)/2 over a grid of 3 × 3 points, two triangles in each of its squares, and
/// the colours (28 i, 255 − 28 i, 7) of point i: compressed by Google's Draco 1.5.7 with 11 bits at levels 0
/// (sequential) and 7 (EdgeBreaker). Attribute 0 is the colours, attribute 1 the positions.
pub const BY_GOOGLE: [&str; 2] = [
    "445241434f0202010000000809010001040004030102050105040304070307060405080408070102020203010000090300010102000101\
     010139511561022f61029ff912f912095a43bb0599808a608300000000ff000000000101000c2b014001000000c0ffff0f80fff91f00ff\
     13c0ff01f87f0000c0ff00008000fcffbfff030080fe0700000100000000ff0700000000000000000000000000bf000000400b",
    "445241434f02020101000000090801080200037fda07ff0111ff02884002000000ff000001020203010001010009030001020101010009\
     03ad2a0f1d0703390e04764bad81e0e10e370e9ca20200000000000000ff000000010101000c27711c9123044cf04880ffff3f00ff0f00\
     0000e0ff00040080ff010000000200c0ff000000000100e07f0000f81f00000000ff0700000000000000000000000000bf000000400b",
];

/// The bytes of hexadecimal digits.
pub fn bytes_of(hex: &str) -> Vec<u8> {
    let digits: Vec<u8> = hex.bytes().filter(u8::is_ascii_hexdigit).collect();
    let value = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).unwrap(), 16).unwrap();
    digits.chunks(2).map(value).collect()
}

/// A file of one compressed primitive with positions and colours.
pub fn file(data: &[u8], points: usize, corners: usize, positions: u32, more: &str) -> String {
    let escaped: String = data.iter().map(|b| format!("%{b:02x}")).collect();
    json(&format!(
        "\"extensionsUsed\":[\"KHR_draco_mesh_compression\"],\
         \"extensionsRequired\":[\"KHR_draco_mesh_compression\"],\
         \"buffers\":[{{\"byteLength\":{length},\"uri\":\"data:,{escaped}\"}}],\
         \"bufferViews\":[{{\"buffer\":0,\"byteLength\":{length}}}],\
         \"accessors\":[\
         {{\"componentType\":5126,\"count\":{points},\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[2,2,2]}},\
         {{\"componentType\":5121,\"normalized\":true,\"count\":{points},\"type\":\"VEC3\"}},\
         {{\"componentType\":5123,\"count\":{corners},\"type\":\"SCALAR\"}}],\
         \"nodes\":[{{\"mesh\":0}}],\"meshes\":[{{\"primitives\":[\
         {{\"attributes\":{{\"POSITION\":0,\"COLOR_0\":1}},\"indices\":2{more},\"extensions\":\
         {{\"KHR_draco_mesh_compression\":{{\"bufferView\":0,\
         \"attributes\":{{\"POSITION\":{positions},\"COLOR_0\":{colours}}}}}}}}}]}}]",
        length = data.len(),
        colours = 1 - positions,
    ))
}

fn grid_of(file: &str) -> Mesh {
    let loaded = loaded(file.as_bytes());
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    mesh_of(&loaded.scene, 0).clone()
}

fn check_grid(mesh: &Mesh) {
    assert_eq!((mesh.positions.len(), mesh.faces.len()), (9, 8));
    for (p, c) in mesh.positions.iter().zip(&mesh.colors) {
        let (x, y) = (p.x.round(), p.y.round());
        let exact = DVec3::new(x, y, 0.5 * (x - 1.0) * (y - 1.0));
        assert!(p.distance(exact) < 2.0 / 2047.0, "{p}");
        let i = 28.0 * (3.0 * y + x);
        let colour = Rgb::new(i, 255.0 - i, 7.0).map(|c| c / 255.0);
        assert!((*c - colour).max_channel().abs() < 1e-6, "{c:?} {colour:?}");
    }
    // Seen from above, all triangles face upwards, half a square each.
    for face in 0..8 {
        assert!((mesh.face_area_vector(face).z - 0.5).abs() < 1e-3);
    }
}

#[test]
fn meshes_of_googles_encoder() {
    for hex in BY_GOOGLE {
        check_grid(&grid_of(&file(&bytes_of(hex), 9, 24, 1, "")));
    }
}

/// Encoders divide points at seams; what the accessors then say about their number does not matter.
#[test]
fn counts_are_those_of_the_compressed_data() {
    check_grid(&grid_of(&file(&bytes_of(BY_GOOGLE[1]), 7, 3, 1, "")));
}

fn attribute(
    kind: draco::GeometryAttributeType,
    values: &[[f32; 3]],
    id: u32,
) -> draco::PointAttribute {
    let mut attribute = draco::PointAttribute::new();
    attribute.init(kind, 3, draco::DataType::Float32, false, values.len());
    let bytes: Vec<u8> = values
        .iter()
        .flatten()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    attribute.buffer_mut().write(0, &bytes);
    attribute.set_unique_id(id);
    attribute
}

/// A flat grid of `n` × `n` points by draco-core's own encoder at this level.
fn encoded(n: u32, level: i32) -> Vec<u8> {
    let mut mesh = draco::Mesh::new();
    let at = |k: u32| [(k % n) as f32, (k / n) as f32, 0.0];
    let positions: Vec<[f32; 3]> = (0..n * n).map(at).collect();
    let colours = vec![[0.25, 0.5, 0.75]; positions.len()];
    let kind = draco::GeometryAttributeType::Position;
    mesh.add_attribute(attribute(kind, &positions, 0));
    let kind = draco::GeometryAttributeType::Color;
    mesh.add_attribute(attribute(kind, &colours, 1));
    for k in (0..n * n).filter(|k| k % n + 1 < n && k / n + 1 < n) {
        for face in [[k, k + 1, k + n + 1], [k, k + n + 1, k + n]] {
            mesh.add_face(face.map(draco::PointIndex));
        }
    }
    let mut encoder = draco::MeshEncoder::new();
    encoder.set_mesh(mesh);
    let mut options = draco::EncoderOptions::new();
    options.set_compression_level(level);
    options.set_attribute_quantization(0, 12);
    let mut out = draco::EncoderBuffer::new();
    encoder.encode(&options, &mut out).unwrap();
    out.data().to_vec()
}

/// Every level, with the valence traversal of the highest.
#[test]
fn larger_meshes_of_every_level() {
    for level in [0, 3, 5, 7, 10] {
        let mesh = grid_of(&file(&encoded(20, level), 400, 2166, 0, ""));
        assert_eq!(mesh.faces.len(), 722);
        let area: f64 = (0..722).map(|f| mesh.face_area_vector(f).z).sum();
        assert!((area - 361.0).abs() < 0.1, "level {level}: {area}");
    }
}

fn refused(file: &str, options: &ReadOptions, part: &str) {
    let read = gltf::read(file.as_bytes(), "a.gltf", &Memory::new(), options);
    let message = read.map(|l| l.warnings).unwrap_err().to_string();
    assert!(message.contains(part), "{message}");
}

#[test]
fn damaged_data() {
    let options = ReadOptions::default();
    let whole = bytes_of(BY_GOOGLE[1]);
    refused(
        &file(&whole[..90], 9, 24, 1, ""),
        &options,
        "damaged Draco data",
    );
    let strip = file(&whole, 9, 24, 1, ",\"mode\":5");
    refused(&strip, &options, "not a list of triangles");
    let other =
        file(&whole, 9, 24, 1, "").replace("\"POSITION\":1,\"COLOR_0\":0", "\"POSITION\":7");
    refused(&other, &options, "do not contain");
    let little = ReadOptions {
        most_unpacked: 300,
        ..options
    };
    refused(&file(&whole, 9, 24, 1, ""), &little, "more than is allowed");
    // No byte that is changed makes the reader panic, nor take long.
    for k in 0..whole.len() {
        for flip in [1, 0x40, 0xff] {
            let mut damaged = whole.clone();
            damaged[k] ^= flip;
            let file = file(&damaged, 9, 24, 1, "");
            let options = ReadOptions::in_proportion(file.len());
            drop(gltf::read(
                file.as_bytes(),
                "a.gltf",
                &Memory::new(),
                &options,
            ));
        }
    }
}

/// Where the extension is only used, the data are there without it, too, and are read from there.
#[test]
fn uncompressed_data_have_priority() {
    let plain = super::triangle(
        &[],
        "",
        &super::one_mesh(
            "{\"attributes\":{\"POSITION\":0},\"extensions\":{\"KHR_draco_mesh_compression\":\
         {\"bufferView\":1,\"attributes\":{\"POSITION\":0}}}}",
        ),
    );
    let file = plain.replace(
        "\"buffers\"",
        "\"extensionsUsed\":[\"KHR_draco_mesh_compression\"],\"buffers\"",
    );
    let scene = super::read(&file, &[]);
    assert_eq!(mesh_of(&scene, 0).faces.len(), 1);
}
