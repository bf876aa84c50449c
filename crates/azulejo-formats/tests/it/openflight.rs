//! Real-world OpenFlight files, at all levels of detail, compared with OpenSceneGraph, which
//! imports all of them.

use azulejo_formats::{Folder, Lod, ReadOptions, openflight};
use azulejo_scene::Shape;
use azulejo_testing::data;
use std::path::Path;

/// Path and number of triangles of each OpenFlight file in the reference table.
fn rows(table: &str) -> Vec<(&str, usize)> {
    let mut lines = table
        .lines()
        .map(|line| line.split('\t').collect::<Vec<_>>());
    let header = lines.next().expect("a header");
    let column = |name| header.iter().position(|h| *h == name).expect("a column");
    let (path, triangles) = (column("path"), column("second_triangles"));
    lines
        .filter(|row| row[path].starts_with("flt/"))
        .map(|row| (row[path], row[triangles].parse().expect("a count")))
        .collect()
}

fn triangles(path: &Path, shared: &Path) -> usize {
    let bytes = std::fs::read(path).expect("a readable file");
    let files = Folder::of_model(path).allow(shared);
    let options = ReadOptions {
        lod: Lod::All,
        ..ReadOptions::default()
    };
    let loaded = openflight::read(&bytes, "a.flt", &files, &options).expect("a good file");
    let of = |shape: &Shape| match shape {
        Shape::Mesh(mesh) => mesh.faces.triangle_count(),
        _ => panic!("OpenFlight has meshes only"),
    };
    loaded.scene.objects.iter().map(|o| of(&o.shape)).sum()
}

#[test]
fn all_levels_of_detail_have_as_many_triangles_as_elsewhere() {
    let Some(data) = data() else { return };
    let corpus = data.join("corpus");
    let table = std::fs::read_to_string(corpus.join("TRUTH.tsv")).expect("a readable table");
    let rows = rows(&table);
    assert!(rows.len() >= 15);
    for (path, expected) in rows {
        let found = triangles(&corpus.join(path), &corpus.join("flt/nested_references"));
        assert_eq!(found, expected, "{path}");
    }
}
