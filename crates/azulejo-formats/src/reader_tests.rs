//! What tests of readers have in common.

use crate::Loaded;
use azulejo_scene::{Mesh, Shape};

/// Checks all warnings, with their positions.
pub(crate) fn check_warnings(loaded: &Loaded, expected: &[&str]) {
    let warnings: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(warnings, expected);
}

/// An object that must be a mesh.
pub(crate) fn mesh(loaded: &Loaded, object: usize) -> &Mesh {
    match &loaded.scene.objects[object].shape {
        Shape::Mesh(mesh) => mesh,
        other => panic!("{other:?} instead of a mesh"),
    }
}

/// Names of all objects.
pub(crate) fn names(loaded: &Loaded) -> Vec<&str> {
    loaded.scene.objects.iter().map(|o| &*o.name).collect()
}
