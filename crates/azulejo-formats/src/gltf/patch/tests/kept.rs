//! What an edit must leave as it is.

use super::super::super::accessor::Data;
use super::super::super::origin::ObjectOrigin;
use super::super::glb::Parts;
use super::super::json::{Json, MOST_LEVELS};
use super::super::mark::MARK;
use super::super::source::{Source, parsed};
use super::super::splits::turned;
use super::super::{GltfFile, ObjectLayout};
use crate::gltf::topology;
use crate::{FileError, Files, Memory, ReadOptions};
use azulejo_scene::{Mesh, Scene};
use gltf_json::Index;
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::Checked;
use serde_json::Value;

/// The files beside a file before and after an edit.
pub struct Both<'a> {
    pub old: &'a dyn Files,
    pub new: Memory,
}

impl Files for Both<'_> {
    fn read(&self, name: &str) -> Result<Vec<u8>, FileError> {
        self.new.read(name).or_else(|_| self.old.read(name))
    }
}

/// Places of values that an edit may replace.
const REPLACED: [&str; 14] = [
    "meshes/*/primitives/*/attributes/*",
    "meshes/*/primitives/*/targets/*/*",
    "meshes/*/primitives/*/indices",
    "meshes/*/primitives/*/material",
    "meshes/*/primitives/*/mode",
    "meshes/*/primitives/*",
    "meshes/*/extras",
    "nodes/*/mesh",
    "nodes/*/extensions",
    "extensions/KHR_lights_punctual/lights/*/intensity",
    "materials/*/extensions/MOZ_lightmap/*",
    "buffers/0/byteLength",
    "extensionsUsed",
    "extensionsRequired",
];

/// What an edit gave is the file that it was, once its mark is undone: the same JSON, with its order and the spelling
/// of its numbers, and the same chunks.
pub fn check_same(name: &str, old: &[u8], new: &[u8]) {
    let [old, new] = [old, new].map(|bytes| Parts::of(bytes, name).unwrap());
    let [a, b] = [&old, &new].map(|parts| Json::parse(parts.text, MOST_LEVELS).unwrap());
    assert!(a == b, "{name}: {a}\n{b}");
    let sorted = |parts: &Parts| {
        let mut chunks = parts
            .chunks
            .iter()
            .flatten()
            .map(|(k, b)| (*k, b.to_vec()))
            .collect::<Vec<_>>();
        chunks.sort();
        chunks
    };
    assert_eq!(sorted(&old), sorted(&new));
}

/// What an edit says that it has replaced is nothing but what it may replace, and numbers of a GLB follow the old ones.
pub fn check_values(old: &[u8], new: &[u8]) {
    let [old, new] = [old, new].map(|bytes| Parts::of(bytes, "new").unwrap());
    let json: Value = serde_json::from_str(new.text).unwrap();
    let before = &json["asset"]["extras"]["azulejo"]["lightmap"]["before"];
    check_change("", before);
    if let Some(bin) = old.bin() {
        assert!(new.bin().unwrap().starts_with(bin));
    }
}

fn check_change(place: &str, change: &Value) {
    match change {
        Value::Object(members) => {
            for (key, change) in members.iter().filter(|(key, _)| *key != "length") {
                check_change(&format!("{place}/{key}"), change);
            }
        }
        change if change[0].is_null() => {}
        _ if place.starts_with("/asset/extras") => {}
        _ => assert!(REPLACED.iter().any(|p| matches(&place[1..], p)), "{place}"),
    }
}

fn matches(place: &str, pattern: &str) -> bool {
    let (place, pattern) = (place.split('/'), pattern.split('/'));
    place.clone().count() == pattern.clone().count()
        && place.zip(pattern).all(|(a, b)| a == b || b == "*")
}

/// The objects are the same, bit for bit, at every corner.
pub fn check_scene(before: &Scene, after: &Scene) {
    assert_eq!(before.objects.len(), after.objects.len());
    let mut unfolded = [before.clone(), after.clone()];
    unfolded.iter_mut().for_each(Scene::unfold);
    let [before, after] = &unfolded;
    for (a, b) in before.objects.iter().zip(&after.objects) {
        assert_eq!(a.name, b.name);
        let (Some(a), Some(b)) = (a.shape.placed_mesh(), b.shape.placed_mesh()) else {
            panic!("objects without meshes");
        };
        assert_eq!(a.mesh.faces.len(), b.mesh.faces.len());
        for (old, new) in a.mesh.face_materials.iter().zip(&b.mesh.face_materials) {
            let colours = |scene: &Scene, id: u32| {
                let material = &scene.materials[id as usize];
                (
                    material.name.clone(),
                    material.diffuse,
                    material.mirror,
                    material.emission,
                )
            };
            assert_eq!(colours(before, *old), colours(after, *new));
        }
        for face in 0..a.mesh.faces.len() {
            for k in 0..3 {
                let (v, w) = (a.mesh.faces.get(face)[k], b.mesh.faces.get(face)[k]);
                let bits = |p: glam::DVec3| p.to_array().map(f64::to_bits);
                assert_eq!(bits(a.position(v)), bits(b.position(w)));
                assert_eq!(normal(a.mesh, face, k), normal(b.mesh, face, k));
                // Where there were none, but in another primitive of the mesh, they may be the lightmap's.
                if uv(a.mesh, face, k).is_some_and(|uv| uv != [0; 2]) {
                    assert_eq!(uv(a.mesh, face, k), uv(b.mesh, face, k));
                }
                let colour = |m: &Mesh, v: u32| m.colors.get(v as usize).copied();
                assert_eq!(colour(a.mesh, v), colour(b.mesh, w));
                assert_eq!(
                    a.irradiance.get(v as usize).copied(),
                    b.irradiance.get(w as usize).copied()
                );
            }
        }
    }
}

fn corner<T: Copy>(
    mesh: &Mesh,
    list: Option<&azulejo_scene::Attribute<T>>,
    face: usize,
    k: usize,
) -> Option<T> {
    let attribute = list?;
    let corner = mesh.faces.corner_range(face).start + k;
    let corners = attribute.corners.as_ref().unwrap_or(&mesh.faces.corners);
    Some(attribute.values[corners[corner] as usize])
}

fn normal(mesh: &Mesh, face: usize, k: usize) -> Option<[u64; 3]> {
    let normal = corner(mesh, mesh.normals.as_ref(), face, k)?;
    Some(normal.to_array().map(f64::to_bits))
}

fn uv(mesh: &Mesh, face: usize, k: usize) -> Option<[u64; 2]> {
    let uv = corner(mesh, mesh.uvs.as_ref(), face, k)?;
    Some(uv.to_array().map(f64::to_bits))
}

/// The faces are the same triangles of the same nodes.
pub fn check_origins(old: &[ObjectOrigin], new: &[ObjectOrigin]) {
    assert_eq!(old.len(), new.len());
    for (a, b) in old.iter().zip(new) {
        assert_eq!(
            (a.node, a.instance, a.mirrored),
            (b.node, b.instance, b.mirrored)
        );
        assert_eq!(
            (a.stillness, a.level_of_detail),
            (b.stillness, b.level_of_detail)
        );
        assert_eq!(a.faces, b.faces);
    }
}

/// The coordinates at every corner are those of the layouts.
pub fn check_coordinates(
    name: &str,
    bytes: &[u8],
    files: &dyn Files,
    origins: &[ObjectOrigin],
    layouts: &[Option<ObjectLayout>],
) {
    let options = ReadOptions::default();
    let file = GltfFile {
        bytes,
        name,
        files,
        options: &options,
    };
    let parts = Parts::of(bytes, name).unwrap();
    let root = parsed(&parts, &file).unwrap();
    let source = Source::new(parts, &root, &file).unwrap();
    let mark = source.json.find(&MARK).unwrap();
    let set = mark.get("texCoord").unwrap().index().unwrap() as u32;
    let mut seen = std::collections::HashSet::new();
    for (origin, layout) in origins.iter().zip(layouts) {
        let Some(layout) = layout else { continue };
        // A node that occurs twice has the coordinates of its first place.
        if !seen.insert(origin.node) {
            continue;
        }
        let mesh = &root.meshes[origin.mesh];
        let read: Vec<(Vec<u32>, Vec<[f64; 2]>)> = mesh
            .primitives
            .iter()
            .map(|p| coordinates(&source.data, p, set).unwrap_or_default())
            .collect();
        for (face, uvs) in origin.faces.iter().zip(&layout.uvs) {
            let primitive = face.primitive as usize;
            let (corners, values) = &read[primitive];
            let Checked::Valid(mode) = mesh.primitives[primitive].mode else {
                panic!("a mode")
            };
            let [a, b, c] = topology::triangles(mode, corners).get(face.triangle as usize);
            let order = turned([a, b, c], origin.mirrored);
            for (vertex, uv) in order.iter().zip(uvs) {
                assert_eq!(values[*vertex as usize], uv.map(f64::from), "{name}");
            }
        }
    }
}

fn coordinates(data: &Data, primitive: &Primitive, set: u32) -> Option<(Vec<u32>, Vec<[f64; 2]>)> {
    if !matches!(
        primitive.mode,
        Checked::Valid(Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)
    ) {
        return None;
    }
    let uvs = *primitive
        .attributes
        .get(&Checked::Valid(Semantic::TexCoords(set)))?;
    let count = data.count(uvs).unwrap();
    let values = data.read(uvs, count, |uv: [f64; 2]| uv).unwrap();
    let corners = match primitive.indices {
        Some(indices) => {
            let indices: Index<gltf_json::Accessor> = indices;
            data.indices(indices, data.count(indices).unwrap()).unwrap()
        }
        None => (0..count as u32).collect(),
    };
    Some((corners, values))
}
