//! One closed surface as gmsh 4.15 and VTK 9.7 wrote it, in every encoding of their formats: all files are
//! the same scene.

use azulejo_formats::{Format, Memory, RecognizedModel, read};
use azulejo_scene::{Scene, Shape};
use std::fs;
use std::path::Path;

/// Every file, with its name.
fn files() -> Vec<(String, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/meshes");
    let mut files: Vec<(String, Vec<u8>)> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            (name, fs::read(path).unwrap())
        })
        .collect();
    files.sort();
    files
}

fn load(name: &str, bytes: &[u8]) -> RecognizedModel {
    let model = read(bytes, name, &Memory::new()).unwrap_or_else(|e| panic!("{e}"));
    model.scene.validate().unwrap();
    model
}

/// The flux through the whole surface of a field whose sources have the density 3: three times the volume
/// within, if all fronts look outwards.
fn volume(scene: &Scene) -> f64 {
    let meshes = scene.objects.iter().map(|o| match &o.shape {
        Shape::Mesh(mesh) => mesh,
        _ => panic!("a mesh"),
    });
    let of_mesh = |mesh: &azulejo_scene::Mesh| -> f64 {
        let faces = 0..mesh.faces.len();
        let flux = faces.map(|f| mesh.face_area_vector(f).dot(mesh.face_positions(f)[0]));
        flux.sum()
    };
    meshes.map(of_mesh).sum::<f64>() / 3.0
}

#[test]
fn every_encoding_is_the_same_scene() {
    let files = files();
    assert_eq!(files.len(), 22);
    let expected = load(&files[0].0, &files[0].1).scene;
    let names: Vec<&str> = expected.objects.iter().map(|o| o.name.as_str()).collect();
    assert_eq!(names, ["the ends", "sides"]);
    assert!((volume(&expected) - 3.0).abs() < 1e-12);
    for (name, bytes) in &files {
        let model = load(name, bytes);
        let is_gmsh = name.ends_with(".msh");
        assert_eq!(model.format == Format::Gmsh, is_gmsh, "{name}");
        assert_eq!(model.format == Format::Vtk, !is_gmsh, "{name}");
        assert_eq!(model.warnings, [], "{name}");
        assert_eq!(model.scene, expected, "{name}");
    }
}

/// Places in a file: all of a small one, of others some, in all parts and at even and odd distances.
fn places(length: usize) -> impl Iterator<Item = usize> {
    const MOST: usize = 400;
    let step = length.div_ceil(MOST) | 1;
    (0..length).step_by(step)
}

/// What is cut off is an error, unless whole sections or only a part of the last word are missing.
#[test]
fn cut_files_are_refused() {
    for (name, bytes) in files() {
        let expected = load(&name, &bytes).scene;
        let (mut refused, mut all) = (0, 0);
        for end in places(bytes.len()) {
            all += 1;
            match read(&bytes[..end], &name, &Memory::new()) {
                Err(_) => refused += 1,
                Ok(model) => {
                    model.scene.validate().unwrap();
                    let is_same = model.scene == expected;
                    // The names are the last section of legacy files, the elements that of gmsh's.
                    let lacks_names = model.scene.objects.len() < 2;
                    let lacks_letters = end + "sides\n\n".len() > bytes.len();
                    assert!(
                        is_same || lacks_names || lacks_letters,
                        "{name} up to {end}"
                    );
                }
            }
        }
        assert!(refused > all / 2, "{name}: {refused} of {all}");
    }
}

/// No byte makes a reader panic, or its scene invalid.
#[test]
fn changed_bytes_are_harmless() {
    for (name, bytes) in files() {
        for at in places(bytes.len()) {
            let mut bytes = bytes.clone();
            // A digit becomes another one, or a small number a large one.
            bytes[at] ^= if at % 2 == 0 { 0x01 } else { 0x80 };
            if let Ok(model) = read(&bytes, &name, &Memory::new()) {
                model.scene.validate().unwrap();
            }
        }
    }
}
