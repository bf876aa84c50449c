//! Tests of OpenFlight's rules with small files.

mod damage;
mod hierarchy;
mod references;
mod surfaces;
mod writer;

use super::read;
use crate::reader_tests::mesh;
use crate::{Loaded, Memory, ReadOptions};
use azulejo_scene::Mesh;
use glam::DVec3;
use writer::Flt;

fn load(flt: Flt) -> Loaded {
    load_with(flt, &Memory::new(), &ReadOptions::default())
}

fn load_with(flt: Flt, files: &Memory, options: &ReadOptions) -> Loaded {
    let loaded = read(&flt.0, "a.flt", files, options).unwrap_or_else(|e| panic!("{e}"));
    loaded.scene.validate().unwrap_or_else(|e| panic!("{e}"));
    loaded
}

/// The single mesh of a file, which must be read without warnings.
fn only_mesh(flt: Flt) -> Mesh {
    let loaded = load(flt);
    assert_eq!(loaded.warnings, []);
    mesh(&loaded, 0).clone()
}

/// Names of the objects, each with the first corner of each face.
fn drawn(loaded: &Loaded) -> Vec<(&str, Vec<[f64; 3]>)> {
    let of = |k: usize| {
        let mesh = mesh(loaded, k);
        let corner = |f: &[u32]| mesh.positions[f[0] as usize].to_array();
        let faces = mesh.faces.iter().map(corner).collect();
        (loaded.scene.objects[k].name.as_str(), faces)
    };
    (0..loaded.scene.objects.len()).map(of).collect()
}

/// Messages and counts of the warnings.
fn said(loaded: &Loaded) -> Vec<(&str, usize)> {
    let warnings = loaded.warnings.iter();
    warnings.map(|w| (w.message.as_str(), w.count)).collect()
}

/// Checks the objects of a file without warnings.
fn check(flt: Flt, expected: &[(&str, &[[f64; 3]])]) {
    check_warned(flt, expected, &[]);
}

/// Checks the objects and the warnings of a file.
fn check_warned(flt: Flt, expected: &[(&str, &[[f64; 3]])], warnings: &[(&str, usize)]) {
    check_loaded(&load(flt), expected, warnings);
}

fn check_loaded(loaded: &Loaded, expected: &[(&str, &[[f64; 3]])], warnings: &[(&str, usize)]) {
    let expected: Vec<(&str, Vec<[f64; 3]>)> = expected
        .iter()
        .map(|(name, faces)| (*name, faces.to_vec()))
        .collect();
    let objects = drawn(loaded);
    assert_eq!(objects.len(), expected.len(), "{objects:?}");
    for (object, expected) in objects.iter().zip(&expected) {
        let near = |a: &[f64; 3], b: &[f64; 3]| DVec3::from(*a).abs_diff_eq(DVec3::from(*b), 1e-6);
        let pairs = object.1.iter().zip(&expected.1);
        let is_same = object.0 == expected.0
            && object.1.len() == expected.1.len()
            && pairs.into_iter().all(|(a, b)| near(a, b));
        assert!(is_same, "{object:?}, expected {expected:?}");
    }
    assert_eq!(said(loaded), warnings);
}
