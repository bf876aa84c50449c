//! Triangles of lists, strips and fans.

use super::vertices::Vertices;
use azulejo_scene::{MaterialId, Mesh};
use gltf_json::mesh::Mode;

/// The triangles of a primitive.
#[derive(Debug)]
pub(super) struct Triangles<'a> {
    mode: Mode,
    corners: &'a [u32],
    /// Number of corners that form no triangle.
    pub left_over: usize,
}

/// The triangles that `corners` form.
pub(super) fn triangles(mode: Mode, corners: &[u32]) -> Triangles<'_> {
    let left_over = match mode {
        Mode::Triangles => corners.len() % 3,
        _ if corners.len() < 3 => corners.len(),
        _ => 0,
    };
    Triangles {
        mode,
        corners,
        left_over,
    }
}

impl Triangles<'_> {
    /// Number of triangles.
    pub fn count(&self) -> usize {
        match self.mode {
            Mode::Triangles => self.corners.len() / 3,
            _ => self.corners.len().saturating_sub(2),
        }
    }

    /// The corners of a triangle below [`Triangles::count`].
    pub fn get(&self, i: usize) -> [u32; 3] {
        let c = self.corners;
        match self.mode {
            Mode::TriangleStrip => [c[i], c[i + 1 + i % 2], c[i + 2 - i % 2]],
            Mode::TriangleFan => [c[i + 1], c[i + 2], c[0]],
            _ => [c[3 * i], c[3 * i + 1], c[3 * i + 2]],
        }
    }

    /// Adds the triangles to a mesh; their vertices are the `count` that start at `first`. Calls `kept` with the
    /// number of each, and returns how many were not added: those with missing or non-finite vertices.
    pub fn push_into(
        &self,
        mesh: &mut Mesh,
        vertices: &Vertices,
        first: u32,
        count: u32,
        material: MaterialId,
        mut kept: impl FnMut(u32),
    ) -> usize {
        let mut outside = 0;
        let triangles = self.count();
        mesh.faces.starts.reserve(triangles);
        mesh.faces.corners.reserve(3 * triangles);
        mesh.face_materials.reserve(triangles);
        for i in 0..triangles {
            let triangle = self.get(i);
            let usable = |&v: &u32| v < count && vertices.is_usable(first + v);
            if triangle.iter().all(usable) {
                mesh.push_face(&triangle.map(|v| first + v), material);
                kept(i as u32);
            } else {
                outside += 1;
            }
        }
        outside
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(mode: Mode, corners: &[u32], expected: &[[u32; 3]], left_over: usize) {
        let triangles = triangles(mode, corners);
        let list: Vec<[u32; 3]> = (0..triangles.count()).map(|i| triangles.get(i)).collect();
        assert_eq!(
            (list.as_slice(), triangles.left_over),
            (expected, left_over)
        );
    }

    #[test]
    fn fronts_are_kept() {
        check(Mode::Triangles, &[5, 6, 7, 8], &[[5, 6, 7]], 1);
        let strip = [[0, 1, 2], [1, 3, 2], [2, 3, 4]];
        check(Mode::TriangleStrip, &[0, 1, 2, 3, 4], &strip, 0);
        let fan = [[1, 2, 0], [2, 3, 0]];
        check(Mode::TriangleFan, &[0, 1, 2, 3], &fan, 0);
        check(Mode::TriangleFan, &[0, 1], &[], 2);
    }
}
