//! The volume that a mesh encloses.

use crate::Mesh;
use crate::random::mixed;
use glam::DVec3;

impl Mesh {
    /// The volume inside a closed mesh, scene units cubed: positive if its front is outside, negative
    /// if its front is inside, as that of a room is, or of a body turned inside out. `None` for a mesh
    /// that is open, or whose neighbours do not face the same side.
    ///
    /// A mesh is closed if every edge is walked equally often in both directions; vertices at the same
    /// position are one. Edges are told apart by hashes of 64 bits. Sheets of two faces, and what
    /// overlaps so that it cancels, have no volume, to rounding.
    pub fn enclosed_volume(&self) -> Option<f64> {
        let origin = self.bounds().centre();
        let (mut volume, mut area, mut walks) = (0.0, 0.0, 0u64);
        for face in 0..self.faces.len() {
            let polygon = self.faces.get(face);
            for (k, &a) in polygon.iter().enumerate() {
                let b = polygon[(k + 1) % polygon.len()];
                walks = walks.wrapping_add(self.walk(a, b));
            }
            let front = self.face_area_vector(face);
            volume += front.dot(self.positions[polygon[0] as usize] - origin) / 3.0;
            area += front.length();
        }
        let is_closed = walks == 0 && volume.abs() > 1e-9 * area.powf(1.5);
        is_closed.then_some(volume)
    }

    /// A number for the edge from `a` to `b`; its negative for the same edge in the other direction.
    fn walk(&self, a: u32, b: u32) -> u64 {
        let [a, b] = [a, b].map(|v| place(self.positions[v as usize]));
        let edge = mixed(mixed(a.min(b)).wrapping_add(a.max(b)));
        match a.cmp(&b) {
            std::cmp::Ordering::Less => edge,
            std::cmp::Ordering::Equal => 0,
            std::cmp::Ordering::Greater => edge.wrapping_neg(),
        }
    }
}

/// A hash of a position.
fn place(p: DVec3) -> u64 {
    // Adding zero makes -0 and 0 the same.
    let bits = p.to_array().map(|x| (x + 0.0).to_bits());
    bits.into_iter()
        .fold(1, |hash, x| mixed(hash ^ mixed(x.wrapping_add(1))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Primitive, PrimitiveKind};
    use glam::DAffine3;

    fn cube(mirror: f64) -> Mesh {
        let map = DAffine3::from_scale(DVec3::new(2.0 * mirror, 3.0, 4.0));
        let cube = Primitive::new(PrimitiveKind::Cuboid, DAffine3::IDENTITY, 0);
        let mut mesh = cube.tessellate(&cube.grids(1.0, 1.0));
        // The map of positions alone turns the faces of a mirrored cube around.
        for p in &mut mesh.positions {
            *p = map.transform_point3(*p) + DVec3::new(100.0, -0.0, 0.0);
        }
        mesh
    }

    #[test]
    fn closed_meshes_have_a_volume_and_a_side() {
        let near = |found: Option<f64>, expected: f64| {
            assert!((found.unwrap() - expected).abs() < 1e-9, "{found:?}");
        };
        near(cube(1.0).enclosed_volume(), 24.0);
        near(cube(-1.0).enclosed_volume(), -24.0);
    }

    #[test]
    fn open_ones_have_none() {
        let mut open = Mesh {
            positions: cube(1.0).positions,
            ..Mesh::default()
        };
        let whole = cube(1.0);
        for face in 1..whole.faces.len() {
            open.push_face(whole.faces.get(face), 0);
        }
        assert_eq!(open.enclosed_volume(), None);
        // The missing face, turned around.
        let mut last = whole.faces.get(0).to_vec();
        last.reverse();
        open.push_face(&last, 0);
        assert_eq!(open.enclosed_volume(), None);
        let mut sheet = Mesh {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            ..Mesh::default()
        };
        sheet.push_face(&[0, 1, 2], 0);
        sheet.push_face(&[2, 1, 0], 0);
        assert_eq!(sheet.enclosed_volume(), None);
        assert_eq!(Mesh::default().enclosed_volume(), None);
    }
}
