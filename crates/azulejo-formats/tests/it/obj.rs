//! OBJ files that people have made, against counts taken by other programs.

use crate::data;
use azulejo_formats::{Folder, Loaded, ReadError, camera_json};
use azulejo_scene::math::Aabb;
use azulejo_scene::{LightKind, Mesh, Object, Rgb, Shape};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Rows of a table by the path they are about, cells by the name of their column.
type Table = BTreeMap<String, BTreeMap<String, String>>;

fn table(path: &Path) -> Table {
    let text = std::fs::read_to_string(path).expect("a readable table");
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().expect("a header").split('\t').collect();
    let row = |line: &str| -> BTreeMap<String, String> {
        let cells = line.split('\t').map(str::to_owned);
        header.iter().map(|h| (*h).to_owned()).zip(cells).collect()
    };
    lines.map(row).map(|r| (r["path"].clone(), r)).collect()
}

fn read(path: &Path) -> Result<Loaded, ReadError> {
    let bytes = std::fs::read(path).expect("a readable file");
    let name = path.file_name().expect("a file name").to_string_lossy();
    let loaded = azulejo_formats::read(&bytes, &name, &Folder::of_model(path))?;
    loaded.scene.validate().expect("a valid scene");
    Ok(loaded)
}

fn mesh(object: &Object) -> &Mesh {
    match &object.shape {
        Shape::Mesh(mesh) => mesh,
        Shape::Primitive(_) => panic!("OBJ has meshes only"),
    }
}

/// What can be counted in a scene.
struct Counts {
    objects: usize,
    vertices: usize,
    faces: usize,
    triangles: usize,
    /// Pairs of an object and a material in it: assimp's meshes.
    parts: usize,
    /// Distinct positions of each such part.
    positions: usize,
    bounds: Aabb,
}

fn count(loaded: &Loaded) -> Counts {
    let objects = &loaded.scene.objects;
    let meshes = || objects.iter().map(mesh);
    let (mut parts, mut positions) = (BTreeSet::new(), BTreeSet::new());
    for (o, mesh) in meshes().enumerate() {
        for face in 0..mesh.faces.len() {
            let part = (o, mesh.face_materials[face]);
            parts.insert(part);
            for p in mesh.face_positions(face) {
                // As floats, because that is how assimp tells them apart; and -0 is 0.
                let bits = p.to_array().map(|x| (x as f32 + 0.0).to_bits());
                positions.insert((part, bits));
            }
        }
    }
    Counts {
        objects: objects.len(),
        vertices: meshes().map(|m| m.positions.len()).sum(),
        faces: meshes().map(|m| m.faces.len()).sum(),
        triangles: meshes().map(|m| m.faces.triangle_count()).sum(),
        parts: parts.len(),
        positions: positions.len(),
        bounds: loaded.scene.bounds(),
    }
}

/// Corner of a box as the table has it: six digits.
fn vector(text: &str) -> Option<[f64; 3]> {
    let numbers: Vec<f64> = text.split(' ').filter_map(|w| w.parse().ok()).collect();
    numbers.try_into().ok()
}

fn check_counts(path: &str, found: &Counts, row: &BTreeMap<String, String>) {
    let number = |column: &str| row.get(column).and_then(|c| c.parse::<usize>().ok());
    // The plain count knows lines that end in LF only, and no faces by their name of 1991.
    if path != "obj/jdk/dinasaur.obj" {
        assert_eq!(Some(found.faces), number("raw_faces"), "{path}: faces");
        assert_eq!(
            Some(found.triangles),
            number("raw_triangles"),
            "{path}: triangles"
        );
    }
    if row["assimp_status"] != "ok" || number("assimp_triangles") == Some(0) {
        return;
    }
    assert_eq!(
        Some(found.triangles),
        number("assimp_triangles"),
        "{path}: triangles"
    );
    // Where both divide a file alike, both must find the same vertices.
    if Some(found.parts) == number("assimp_meshes") {
        let expected = number("assimp_distinct_positions_per_mesh");
        assert_eq!(Some(found.positions), expected, "{path}: positions");
    }
    let bounds = [
        (found.bounds.min, "assimp_bbox_min"),
        (found.bounds.max, "assimp_bbox_max"),
    ];
    for (corner, column) in bounds {
        let expected = vector(&row[column]).expect("a corner");
        let size = found.bounds.diagonal() + corner.abs().max_element();
        for (a, b) in corner.to_array().into_iter().zip(expected) {
            assert!((a - b).abs() <= 1e-5 * size, "{path}: {column} {corner}");
        }
    }
}

#[test]
fn corpus() {
    let Some(data) = data() else { return };
    let truth = table(&data.join("corpus/TRUTH.tsv"));
    let manifest = table(&data.join("corpus/MANIFEST.tsv"));
    let mut refused = Vec::new();
    println!("objects vertices  faces triangles warnings file");
    for (path, row) in truth.iter().filter(|(p, _)| p.ends_with(".obj")) {
        let invalid = manifest[path]["note"].contains("INVALID");
        match read(&data.join("corpus").join(path)) {
            Err(e) => {
                refused.push(path.as_str());
                println!("{path}: {e}");
            }
            Ok(loaded) => {
                assert!(!invalid || !loaded.warnings.is_empty(), "{path}: accepted");
                let c = count(&loaded);
                println!(
                    "{:7} {:8} {:6} {:9} {:8} {path}",
                    c.objects,
                    c.vertices,
                    c.faces,
                    c.triangles,
                    loaded.warnings.len()
                );
                check_counts(path, &c, row);
            }
        }
    }
    let expected = [
        "obj/assimp-invalid/empty.obj",
        "obj/assimp-invalid/malformed.obj",
        "obj/tinyobjloader/invalid-relative-vertex-index.obj",
        "obj/tinyobjloader/issue-140-zero-face-idx.obj",
        "obj/tinyobjloader/test-nan.obj",
    ];
    assert_eq!(refused, expected);
}

/// The counts that *Wannabe Amazing* (Montes, Ureña, Revelles, Lastra, 2001) prints for a model
/// that can still be had.
#[test]
fn the_galleon_of_table_1() {
    let Some(data) = data() else { return };
    let loaded = read(&data.join("corpus/obj/java3d-examples/galleon.obj")).expect("a model");
    let c = count(&loaded);
    assert_eq!((c.objects, c.vertices, c.faces), (133, 3459, 2384));
    assert_eq!(loaded.warnings, []);
}

#[test]
fn cornell_boxes() {
    let Some(data) = data() else { return };
    for (name, triangles, mirrors, glasses) in
        [("s1", 38, 0, 0), ("s2", 38, 1, 0), ("s2g", 40, 1, 1)]
    {
        let loaded = read(&data.join(format!("scenes/{name}.obj"))).expect("a scene");
        assert_eq!(loaded.warnings, [], "{name}");
        assert_eq!(count(&loaded).triangles, triangles, "{name}");
        let materials = &loaded.scene.materials;
        let light = materials
            .iter()
            .find(|m| m.name == "light")
            .expect("a light");
        assert_eq!(light.emission, Rgb::new(17.0, 12.0, 4.0));
        let glass = |m: &&azulejo_scene::Material| m.dielectric.is_some();
        assert_eq!(materials.iter().filter(glass).count(), glasses, "{name}");
        let mirror = |m: &&azulejo_scene::Material| m.mirror == Rgb::grey(0.9);
        assert_eq!(materials.iter().filter(mirror).count(), mirrors, "{name}");
        let json = std::fs::read(data.join(format!("scenes/{name}.json"))).expect("a file");
        let camera = camera_json::read(&json, name).expect("a camera");
        assert_eq!((camera.eye.z, camera.size), (-800.0, Some((512, 512))));
    }
}

#[test]
fn a_page_of_text_and_its_light() {
    let Some(data) = data() else { return };
    let loaded = read(&data.join("scenes/s4.obj")).expect("a scene");
    assert_eq!(loaded.warnings, []);
    assert_eq!(count(&loaded).triangles, 6578);
    let json = std::fs::read(data.join("scenes/s4.json")).expect("a file");
    let lights = camera_json::read_lights(&json, "s4.json").expect("lights");
    let [light] = lights.as_slice() else {
        panic!("one light")
    };
    assert!(matches!(light.kind, LightKind::Point { intensity, .. } if intensity.b == 100.0));
}
