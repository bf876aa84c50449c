//! What an edit must leave as it is.

use super::super::super::origin::ObjectOrigin;
use super::super::glb::Parts;
use super::super::json::{Json, MOST_LEVELS};
use super::super::mark::MARK;
use super::super::{GltfFile, ObjectLayout, coordinates};
use azulejo_scene::{Attribute, Mesh, Scene};
use serde_json::Value;

/// Places of values that an edit may replace.
const REPLACED: [&str; 16] = [
    "meshes/*/primitives/*/attributes/*",
    "meshes/*/primitives/*/targets/*/*",
    "meshes/*/primitives/*/indices",
    "meshes/*/primitives/*/material",
    "meshes/*/primitives/*/mode",
    "meshes/*/primitives/*/extensions",
    "meshes/*/extras",
    "nodes/*/mesh",
    "nodes/*/extensions/KHR_lights_punctual",
    "extensions/KHR_lights_punctual/lights/*/intensity",
    "materials/*/extensions/MOZ_lightmap/*",
    "buffers/0/byteLength",
    "extensionsUsed",
    "extensionsUsed/*",
    "extensionsRequired",
    "extensionsRequired/*",
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
    let [mut before, mut after] = [before, after].map(Scene::clone);
    before.unfold();
    after.unfold();
    for (a, b) in before.objects.iter().zip(&after.objects) {
        assert_eq!(a.name, b.name);
        let [a, b] = [a, b].map(|object| object.shape.placed_mesh().expect("a mesh"));
        assert_eq!(a.mesh.faces.len(), b.mesh.faces.len());
        for (old, new) in a.mesh.face_materials.iter().zip(&b.mesh.face_materials) {
            let colours = |scene: &Scene, id: u32| {
                let m = &scene.materials[id as usize];
                (m.name.clone(), m.diffuse, m.mirror, m.emission)
            };
            assert_eq!(colours(&before, *old), colours(&after, *new));
        }
        for corner in 0..a.mesh.faces.corners.len() {
            let [old, new] = [&a, &b].map(|placed| {
                let mesh = placed.mesh;
                let v = mesh.faces.corners[corner];
                let normal = at_corner(mesh, mesh.normals.as_ref(), corner);
                (
                    placed.position(v).to_array().map(f64::to_bits),
                    normal.map(|n| n.to_array().map(f64::to_bits)),
                    mesh.colors.get(v as usize).copied(),
                    placed.irradiance.get(v as usize).copied(),
                )
            });
            assert_eq!(old, new);
            // Where there were none, but in another primitive of the mesh, they may be the lightmap's.
            let [old, new] = [&a, &b].map(|p| at_corner(p.mesh, p.mesh.uvs.as_ref(), corner));
            if old.is_some_and(|uv| uv.to_array() != [0.0; 2]) {
                assert_eq!(old, new);
            }
        }
    }
}

fn at_corner<T: Copy>(mesh: &Mesh, list: Option<&Attribute<T>>, corner: usize) -> Option<T> {
    let attribute = list?;
    let corners = attribute.corners.as_ref().unwrap_or(&mesh.faces.corners);
    Some(attribute.values[corners[corner] as usize])
}

/// The faces are the same triangles of the same nodes.
pub fn check_origins(old: &[ObjectOrigin], new: &[ObjectOrigin]) {
    assert_eq!(old.len(), new.len());
    for (a, b) in old.iter().zip(new) {
        let (mesh, b) = (a.mesh, b.clone());
        assert_eq!(*a, ObjectOrigin { mesh, ..b });
    }
}

/// The coordinates at every corner are those of the layouts.
pub fn check_coordinates(
    file: &GltfFile,
    origins: &[ObjectOrigin],
    layouts: &[Option<ObjectLayout>],
) {
    let parts = Parts::of(file.bytes, file.name).unwrap();
    let json = Json::parse(parts.text, 2 * MOST_LEVELS).unwrap();
    let set = json.find(&MARK).unwrap().get("texCoord").unwrap();
    let uv_set = coordinates(file, origins, set.index().unwrap() as u32).unwrap();
    let mut seen = std::collections::HashSet::new();
    for ((origin, layout), object) in origins.iter().zip(layouts).zip(&uv_set.objects) {
        let Some(layout) = layout.as_ref().filter(|layout| !layout.uvs.is_empty()) else {
            continue;
        };
        // A node that occurs twice has the coordinates of its first place.
        if seen.insert(origin.node) {
            let uvs = object.as_ref().map(|object| &object.uvs);
            assert_eq!(uvs, Some(&layout.uvs), "{}", file.name);
        }
    }
}
