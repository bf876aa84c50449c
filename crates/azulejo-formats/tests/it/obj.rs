//! OBJ files that people have made, against counts taken by other programs.

use azulejo_formats::{Folder, Loaded, obj};
use azulejo_scene::{Mesh, Shape};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Where the shared models are, if this machine has them.
fn data() -> Option<PathBuf> {
    let folder = std::env::var_os("AZULEJO_DATA").map(PathBuf::from);
    if folder.is_none() {
        eprintln!("skipped: AZULEJO_DATA is not set");
    }
    folder
}

fn read(path: &Path) -> Result<Loaded, azulejo_formats::ReadError> {
    let bytes = std::fs::read(path).expect("a readable file");
    let name = path.file_name().expect("a file name").to_string_lossy();
    obj::read(&bytes, &name, &Folder::of_model(path))
}

fn meshes(loaded: &Loaded) -> impl Iterator<Item = &Mesh> {
    loaded.scene.objects.iter().map(|o| match &o.shape {
        Shape::Mesh(mesh) => mesh,
        Shape::Primitive(_) => panic!("OBJ has meshes only"),
    })
}

/// Rows of a table with a header, by path, each by column name.
fn table(path: &Path) -> BTreeMap<String, BTreeMap<String, String>> {
    let text = std::fs::read_to_string(path).expect("a readable table");
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().expect("a header").split('\t').collect();
    let row = |line: &str| -> BTreeMap<String, String> {
        let cells = line.split('\t').map(str::to_owned);
        header.iter().map(|h| (*h).to_owned()).zip(cells).collect()
    };
    lines.map(row).map(|r| (r["path"].clone(), r)).collect()
}

/// Vertices as assimp counts them: distinct positions per object and material.
fn distinct_positions(mesh: &Mesh) -> usize {
    let mut seen = BTreeSet::new();
    for face in 0..mesh.faces.len() {
        for p in mesh.face_positions(face) {
            seen.insert((
                mesh.face_materials[face],
                p.to_array().map(|x| (x as f32 + 0.0).to_bits()),
            ));
        }
    }
    seen.len()
}

fn vector(text: &str) -> Option<[f64; 3]> {
    let numbers: Vec<f64> = text.split(' ').filter_map(|w| w.parse().ok()).collect();
    numbers.try_into().ok()
}

#[test]
fn corpus_counts() {
    let Some(data) = data() else { return };
    let truth = table(&data.join("corpus/TRUTH.tsv"));
    for (path, row) in truth.iter().filter(|(p, _)| p.ends_with(".obj")) {
        let number = |column: &str| row.get(column).and_then(|c| c.parse::<usize>().ok());
        match read(&data.join("corpus").join(path)) {
            Err(e) => println!("{path}: {e}"),
            Ok(loaded) => {
                loaded.scene.validate().expect("a valid scene");
                let faces: usize = meshes(&loaded).map(|m| m.faces.len()).sum();
                let triangles: usize = meshes(&loaded).map(|m| m.faces.triangle_count()).sum();
                let vertices: usize = meshes(&loaded).map(|m| m.positions.len()).sum();
                let distinct: usize = meshes(&loaded).map(distinct_positions).sum();
                let b = loaded.scene.bounds();
                println!(
                    "{path}: objects {} faces {faces} {:?} triangles {triangles} {:?} {:?} vertices {vertices} raw {:?} distinct {distinct} {:?} meshes {:?} bounds {:?} {:?} {:?}",
                    loaded.scene.objects.len(),
                    number("raw_faces"),
                    number("raw_triangles"),
                    number("assimp_triangles"),
                    number("raw_vertices"),
                    number("assimp_distinct_positions_per_mesh"),
                    number("assimp_meshes"),
                    b.min,
                    b.max,
                    (
                        vector(&row["assimp_bbox_min"]),
                        vector(&row["assimp_bbox_max"])
                    )
                );
                for w in &loaded.warnings {
                    println!("      {w}");
                }
            }
        }
    }
}
