//! Normals of smooth surfaces, for formats that specify which faces are smooth and leave the
//! normals to the reader.

use azulejo_scene::math::area_vector;
use azulejo_scene::{Attribute, Mesh};
use glam::DVec3;
use std::collections::HashMap;

/// Around a point with more faces than this none are joined: every pair is tested, and a
/// hostile file could make their number too large.
const MOST_AROUND: usize = 256;

/// Normals of the corners of a mesh.
///
/// At a corner, the normals of its face and of the faces around the same position that
/// `are_joined` to it are summed, each weighted by its angle there (Thürmer and Wüthrich,
/// *Computing vertex normals from polygonal facets*, 1998). Vertices at equal positions count as
/// one, since texture seams separate vertices and not surfaces. Corners of faces without area
/// that are joined to nothing get +z.
pub(crate) fn corner_normals(
    mesh: &Mesh,
    are_joined: impl Fn(usize, usize) -> bool,
) -> Attribute<DVec3> {
    let flat: Vec<DVec3> = (0..mesh.faces.len())
        .map(|f| area_vector(&mesh.face_positions(f)).normalize_or_zero())
        .collect();
    let around = Around::new(mesh);
    let mut values = Values::default();
    let mut corners = Vec::with_capacity(mesh.faces.corners.len());
    for (face, &own) in flat.iter().enumerate() {
        for corner in mesh.faces.corner_range(face) {
            let vertex = mesh.faces.corners[corner];
            let neighbours = around.corners(vertex);
            let mut sum = DVec3::ZERO;
            if neighbours.len() <= MOST_AROUND {
                for &(f, angle) in neighbours {
                    if f as usize == face || are_joined(face, f as usize) {
                        sum += angle * flat[f as usize];
                    }
                }
            }
            let fallback = if own == DVec3::ZERO { DVec3::Z } else { own };
            corners.push(values.index(vertex, sum.try_normalize().unwrap_or(fallback)));
        }
    }
    Attribute {
        values: values.values,
        corners: Some(corners),
    }
}

/// Whether the angle between two unit normals is less than one, given by its cosine.
pub(crate) fn within(a: DVec3, b: DVec3, cos_angle: f64) -> bool {
    a.dot(b) >= cos_angle
}

/// Which faces meet at each position, and at what angle.
struct Around {
    /// Position of each vertex, as an index into `starts`.
    place: Vec<u32>,
    starts: Vec<u32>,
    corners: Vec<(u32, f64)>,
}

impl Around {
    fn new(mesh: &Mesh) -> Around {
        let mut known = HashMap::new();
        let place: Vec<u32> = mesh
            .positions
            .iter()
            .map(|p| {
                // Adding zero makes -0 and 0 one key.
                let key = p.to_array().map(|x| (x + 0.0).to_bits());
                let next = known.len() as u32;
                *known.entry(key).or_insert(next)
            })
            .collect();
        let mut starts = vec![0; known.len() + 1];
        for &vertex in &mesh.faces.corners {
            starts[place[vertex as usize] as usize + 1] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut next = starts.clone();
        let mut corners = vec![(0, 0.0); mesh.faces.corners.len()];
        for (face, polygon) in mesh.faces.iter().enumerate() {
            for (k, &vertex) in polygon.iter().enumerate() {
                let slot = &mut next[place[vertex as usize] as usize];
                corners[*slot as usize] = (face as u32, angle(mesh, polygon, k));
                *slot += 1;
            }
        }
        Around {
            place,
            starts,
            corners,
        }
    }

    fn corners(&self, vertex: u32) -> &[(u32, f64)] {
        let place = self.place[vertex as usize] as usize;
        &self.corners[self.starts[place] as usize..self.starts[place + 1] as usize]
    }
}

/// Angle of a polygon at its corner `k`; 0 if an edge has no length.
fn angle(mesh: &Mesh, polygon: &[u32], k: usize) -> f64 {
    let n = polygon.len();
    let at = |i: usize| mesh.positions[polygon[i % n] as usize];
    let (a, b) = (at(k + n - 1) - at(k), at(k + 1) - at(k));
    a.cross(b).length().atan2(a.dot(b))
}

/// Distinct normals of each vertex, so that smooth vertices store only one.
#[derive(Default)]
struct Values {
    values: Vec<DVec3>,
    /// Keyed by vertex and bits of the normal.
    known: HashMap<(u32, [u64; 3]), u32>,
}

impl Values {
    fn index(&mut self, vertex: u32, normal: DVec3) -> u32 {
        let key = (vertex, normal.to_array().map(f64::to_bits));
        *self.known.entry(key).or_insert_with(|| {
            self.values.push(normal);
            (self.values.len() - 1) as u32
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two unit squares that share the y axis as an edge at a right angle, with separate
    /// vertices.
    fn corner() -> Mesh {
        let mut mesh = Mesh {
            positions: [
                [0, 0, 0],
                [1, 0, 0],
                [1, 1, 0],
                [0, 1, 0],
                [0, 0, 0],
                [0, 1, 0],
                [0, 1, 1],
                [0, 0, 1],
            ]
            .map(|[x, y, z]: [i32; 3]| DVec3::new(x.into(), y.into(), z.into()))
            .to_vec(),
            ..Mesh::default()
        };
        mesh.push_face(&[0, 1, 2, 3], 0);
        mesh.push_face(&[4, 5, 6, 7], 0);
        mesh
    }

    #[test]
    fn joined_faces_share_normals_at_their_edge_alone() {
        let normals = corner_normals(&corner(), |_, _| true);
        let half = DVec3::new(1.0, 0.0, 1.0).normalize();
        assert!((normals.at(0, 0) - half).length() < 1e-15);
        assert!((normals.at(4, 4) - half).length() < 1e-15);
        assert_eq!(normals.at(1, 1), DVec3::Z);
        assert_eq!(normals.at(6, 6), DVec3::X);
        assert_eq!(normals.values.len(), 8);
    }

    #[test]
    fn faces_that_are_not_joined_stay_flat() {
        let mesh = corner();
        let cos = 60f64.to_radians().cos();
        let flat = [DVec3::Z, DVec3::X];
        let normals = corner_normals(&mesh, |f, g| within(flat[f], flat[g], cos));
        assert_eq!(normals.at(0, 0), DVec3::Z);
        assert_eq!(normals.at(4, 4), DVec3::X);
    }

    #[test]
    fn a_face_without_area_has_a_normal_too() {
        let mut mesh = corner();
        mesh.push_face(&[0, 0, 1], 0);
        let normals = corner_normals(&mesh, |_, _| false);
        assert_eq!(normals.at(8, 0), DVec3::Z);
    }
}
