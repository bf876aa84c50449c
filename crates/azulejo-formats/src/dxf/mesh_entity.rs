//! MESH: polygons over shared vertices, which AutoCAD can subdivide into a smooth surface.

use super::ids::AppearanceId;
use super::record::Record;
use super::surfaces::LayerMesh;
use glam::DVec3;

/// The control cage of a MESH, before any subdivision.
#[derive(Debug, Default)]
pub(super) struct ControlCage {
    /// Number of subdivisions.
    pub level: i64,
    points: Vec<DVec3>,
    /// Number of corners and the corners of each face, one face after the other.
    faces: Vec<i64>,
    /// Declared number of entries of `faces`.
    entries: i64,
}

/// The list that the groups belong to, since several lists use the same codes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum List {
    Head,
    Points,
    Faces,
    Rest,
}

impl ControlCage {
    /// Reads a record.
    pub fn read(record: &Record) -> ControlCage {
        let mut cage = ControlCage::default();
        let mut list = List::Head;
        for pair in &record.pairs {
            match (list, pair.code) {
                (List::Head, 91) => cage.level = record.whole(pair.value).unwrap_or(0),
                (List::Head, 92) => list = List::Points,
                (List::Points, 10) => {
                    let x = record.finite(pair.value).unwrap_or(0.0);
                    cage.points.push(DVec3::new(x, 0.0, 0.0));
                }
                (List::Points, 20 | 30) => {
                    if let Some(point) = cage.points.last_mut() {
                        let axis = usize::from(pair.code == 30) + 1;
                        point[axis] = record.finite(pair.value).unwrap_or(0.0);
                    }
                }
                (List::Head | List::Points, 93) => {
                    cage.entries = record.whole(pair.value).unwrap_or(0);
                    list = List::Faces;
                }
                (List::Faces, 90) => cage.faces.push(record.whole(pair.value).unwrap_or(-1)),
                (List::Faces, _) => list = List::Rest,
                _ => {}
            }
        }
        cage
    }

    /// Most vertices and corners that it adds.
    pub fn cost(&self) -> u64 {
        (self.points.len() + self.faces.len()) as u64
    }

    /// Adds its polygons to a mesh. Returns how many faces were skipped, because they have too few
    /// corners or an invalid one; a face list that ends early counts as one.
    pub fn draw(&self, mesh: &mut LayerMesh, appearance: AppearanceId) -> usize {
        let first = mesh.vertices(self.points.iter().copied());
        let is_vertex = |corner: &i64| (0..self.points.len() as i64).contains(corner);
        let mut lost = usize::from(self.entries != self.faces.len() as i64);
        let (mut rest, mut corners) = (&self.faces[..], Vec::new());
        while let [count, after @ ..] = rest {
            let count = usize::try_from(*count).unwrap_or(usize::MAX);
            let Some((face, next)) = after.split_at_checked(count) else {
                return lost.max(1);
            };
            rest = next;
            if count < 3 || !face.iter().all(is_vertex) {
                lost += 1;
                continue;
            }
            corners.clear();
            corners.extend(face.iter().map(|&corner| first + corner as u32));
            mesh.face(&corners, appearance);
        }
        lost
    }
}
