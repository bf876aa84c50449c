//! One room in three formats, of which other programs have written two.

use azulejo_formats::{Folder, Format, RecognizedModel, read};
use azulejo_scene::{Mesh, Shape};
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/solvers")
}

fn model(name: &str) -> RecognizedModel {
    let path = folder().join(name);
    let bytes = std::fs::read(&path).unwrap();
    read(&bytes, &path.to_string_lossy(), &Folder::of_model(&path)).unwrap()
}

/// Faces by their corners in order, beginning with the lowest, in eighths of the unit.
fn faces(mesh: &Mesh) -> Vec<Vec<[i64; 3]>> {
    let of_face = |face: usize| {
        let corners = mesh.face_positions(face);
        let mut corners: Vec<_> = corners
            .iter()
            .map(|p| (8.0 * *p).to_array().map(|x| x as i64))
            .collect();
        let first = (0..corners.len()).min_by_key(|&k| corners[k]).unwrap();
        corners.rotate_left(first);
        corners
    };
    let mut faces: Vec<_> = (0..mesh.faces.len()).map(of_face).collect();
    faces.sort();
    faces
}

fn surfaces(model: &RecognizedModel) -> Vec<(&str, Vec<Vec<[i64; 3]>>)> {
    let objects = model.scene.objects.iter();
    let of_object = objects.map(|object| match &object.shape {
        Shape::Mesh(mesh) => (&*object.name, faces(mesh)),
        _ => panic!("meshes only"),
    });
    of_object.collect()
}

#[test]
fn one_room_in_every_format() {
    let room = model("room.bdf");
    assert_eq!(room.format, Format::Nastran);
    let expected = surfaces(&room);
    let counts: Vec<_> = expected.iter().map(|(n, f)| (*n, f.len())).collect();
    assert_eq!(counts, [("floor", 4), ("lid", 4), ("walls", 16)]);
    for (name, format) in [
        ("room.inp", Format::Abaqus),
        ("room/constant/polyMesh/boundary", Format::OpenFoam),
        ("room/constant/polyMesh/points", Format::OpenFoam),
        ("room/room.foam", Format::OpenFoam),
    ] {
        let found = model(name);
        assert_eq!(found.format, format, "{name}");
        assert_eq!(surfaces(&found), expected, "{name}");
    }
}
