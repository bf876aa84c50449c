//! The surface of volume meshes: the faces of cells that no other cell shares.
//!
//! Programs that compute in volumes write cells, and often no surfaces at all. Radiation is exchanged
//! where the volume ends, so that readers take the boundary of the cells for the missing surfaces.

use azulejo_scene::Faces;
use glam::DVec3;

/// The shape of a volume cell.
///
/// The first corners of a cell of higher order are those of the linear one in gmsh, VTK, Abaqus and
/// Nastran alike, and all four list them in the same order but for VTK's wedges, which is why
/// [`BoundaryFace::turn_outwards`] looks at positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CellKind {
    /// Four corners; the first three are counter-clockwise seen from the fourth.
    Tetrahedron,
    /// Five corners; the first four are counter-clockwise seen from the fifth.
    Pyramid,
    /// Six corners; the first three are counter-clockwise seen from the other three, each behind its own.
    Prism,
    /// Eight corners; the first four are counter-clockwise seen from the other four, each behind its own.
    Hexahedron,
}

impl CellKind {
    /// Number of corners.
    pub fn corner_count(self) -> usize {
        match self {
            CellKind::Tetrahedron => 4,
            CellKind::Pyramid => 5,
            CellKind::Prism => 6,
            CellKind::Hexahedron => 8,
        }
    }

    /// The corners of each face, counter-clockwise from outside, with a corner of the cell beyond it.
    fn faces(self) -> &'static [(&'static [usize], usize)] {
        match self {
            CellKind::Tetrahedron => &[
                (&[0, 2, 1], 3),
                (&[0, 1, 3], 2),
                (&[1, 2, 3], 0),
                (&[2, 0, 3], 1),
            ],
            CellKind::Pyramid => &[
                (&[0, 3, 2, 1], 4),
                (&[0, 1, 4], 2),
                (&[1, 2, 4], 3),
                (&[2, 3, 4], 0),
                (&[3, 0, 4], 1),
            ],
            CellKind::Prism => &[
                (&[0, 2, 1], 3),
                (&[3, 4, 5], 0),
                (&[0, 1, 4, 3], 2),
                (&[1, 2, 5, 4], 0),
                (&[2, 0, 3, 5], 1),
            ],
            CellKind::Hexahedron => &[
                (&[0, 3, 2, 1], 6),
                (&[4, 5, 6, 7], 0),
                (&[0, 1, 5, 4], 6),
                (&[1, 2, 6, 5], 7),
                (&[2, 3, 7, 6], 4),
                (&[3, 0, 4, 7], 5),
            ],
        }
    }
}

/// A face of one cell that no other cell has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct BoundaryFace {
    /// Three or more corners, counter-clockwise from outside of the volume.
    pub corners: Vec<u32>,
    /// The tag of its cell.
    pub tag: u32,
    /// A corner of its cell that is not one of the face.
    pub inner: u32,
}

impl BoundaryFace {
    /// Reverses the face if its front looks into its cell, whose corners are then not in the order of
    /// [`CellKind`]; says whether it did. `position` gives the place of a corner.
    pub fn turn_outwards(&mut self, position: impl Fn(u32) -> DVec3) -> bool {
        let first = position(self.corners[0]);
        let mut area = DVec3::ZERO;
        for pair in self.corners[1..].windows(2) {
            area += (position(pair[0]) - first).cross(position(pair[1]) - first);
        }
        // The mean, as four corners need not lie in a plane.
        let sum: DVec3 = self.corners.iter().map(|&c| position(c)).sum();
        let centre = sum / self.corners.len() as f64;
        let is_inverted = area.dot(position(self.inner) - centre) > 0.0;
        if is_inverted {
            self.corners.reverse();
        }
        is_inverted
    }
}

/// Collects the cells of a volume mesh.
///
/// Memory is in proportion to the corners of the cells; nothing is hashed, so that no file can be slow.
#[derive(Debug, Default)]
pub(crate) struct VolumeBoundary {
    /// All faces of all cells.
    faces: Faces,
    /// The corners of the same faces, in ascending order within each: what identifies a face.
    sorted: Vec<u32>,
    tags: Vec<u32>,
    inner: Vec<u32>,
}

impl VolumeBoundary {
    /// No cells.
    pub fn new() -> VolumeBoundary {
        VolumeBoundary::default()
    }

    /// Adds a cell, of whose corners the first [`CellKind::corner_count`] are used; one with fewer is
    /// left out. Its faces get the tag.
    ///
    /// Corners may be equal: hexahedra whose corners coincide are common wherever a program has no other
    /// cells. Faces with fewer than three different corners are then none.
    pub fn add_cell(&mut self, kind: CellKind, corners: &[u32], tag: u32) {
        let Some(corners) = corners.get(..kind.corner_count()) else {
            return;
        };
        for (face, inner) in kind.faces() {
            let mut outline = [0; 4];
            for (place, &k) in std::iter::zip(&mut outline, *face) {
                *place = corners[k];
            }
            let outline = &outline[..face.len()];
            let beyond = std::iter::once(&corners[*inner]).chain(corners);
            let inner = beyond.copied().find(|c| !outline.contains(c));
            self.add_face(outline, inner, tag);
        }
    }

    /// Adds one face of a cell with any number of faces, counter-clockwise from outside; `inner` is a
    /// corner of the cell that the face has not, without which the cell is flat and the face is none.
    pub fn add_face(&mut self, corners: &[u32], inner: Option<u32>, tag: u32) {
        let Some(inner) = inner else { return };
        let start = self.faces.corners.len();
        for (k, &corner) in corners.iter().enumerate() {
            let next = corners[(k + 1) % corners.len()];
            if corner != next {
                self.faces.corners.push(corner);
            }
        }
        if self.faces.corners.len() < start + 3 {
            self.faces.corners.truncate(start);
            return;
        }
        self.sorted.extend_from_slice(&self.faces.corners[start..]);
        self.sorted[start..].sort_unstable();
        self.faces.starts.push(self.faces.corners.len() as u32);
        self.tags.push(tag);
        self.inner.push(inner);
    }

    /// The faces that occur once, in the order of their cells.
    pub fn faces(&self) -> Vec<BoundaryFace> {
        let key = |face: &u32| &self.sorted[self.faces.corner_range(*face as usize)];
        let mut order: Vec<u32> = (0..self.faces.len() as u32).collect();
        order.sort_unstable_by(|a, b| key(a).cmp(key(b)));
        let alike = order.chunk_by(|a, b| key(a) == key(b));
        let mut single: Vec<u32> = alike.filter(|c| c.len() == 1).map(|c| c[0]).collect();
        single.sort_unstable();
        let face = |face: u32| BoundaryFace {
            corners: self.faces.get(face as usize).to_vec(),
            tag: self.tags[face as usize],
            inner: self.inner[face as usize],
        };
        single.into_iter().map(face).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use CellKind::{Hexahedron, Prism, Pyramid, Tetrahedron};
    use azulejo_scene::math::area_vector;

    /// Corners of a box, those of the top behind those of the bottom.
    fn cube() -> Vec<DVec3> {
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let at = |z: f64| square.map(|(x, y)| DVec3::new(x, y, z));
        [at(0.0), at(1.0)].concat()
    }

    fn positions_of(face: &BoundaryFace, positions: &[DVec3]) -> Vec<DVec3> {
        let corners = face.corners.iter();
        corners.map(|&c| positions[c as usize]).collect()
    }

    /// The volume within faces, by the divergence theorem: positive if they look outwards.
    fn volume(faces: &[BoundaryFace], positions: &[DVec3]) -> f64 {
        let share = |face: &BoundaryFace| {
            let corners = positions_of(face, positions);
            area_vector(&corners).dot(corners[0]) / 3.0
        };
        faces.iter().map(share).sum()
    }

    fn check(cells: &[(CellKind, &[u32])], faces: usize, expected: f64) {
        let (positions, mut boundary) = (cube(), VolumeBoundary::new());
        for (tag, (kind, corners)) in cells.iter().enumerate() {
            boundary.add_cell(*kind, corners, tag as u32);
        }
        let mut actual = boundary.faces();
        assert_eq!(actual.len(), faces, "{cells:?}");
        let is = volume(&actual, &positions);
        assert!((is - expected).abs() < 1e-12, "{is} in {cells:?}");
        for face in &mut actual {
            assert!(!face.turn_outwards(|c| positions[c as usize]), "{face:?}");
        }
    }

    #[test]
    fn every_kind_faces_outwards() {
        check(&[(Tetrahedron, &[0, 1, 3, 4])], 4, 1.0 / 6.0);
        check(&[(Pyramid, &[0, 1, 2, 3, 4])], 5, 1.0 / 3.0);
        check(&[(Prism, &[0, 1, 3, 4, 5, 7])], 5, 0.5);
        check(&[(Hexahedron, &[0, 1, 2, 3, 4, 5, 6, 7])], 6, 1.0);
    }

    #[test]
    fn shared_faces_are_inside() {
        let (one, other) = ([0, 1, 3, 4, 5, 7], [1, 2, 3, 5, 6, 7]);
        check(&[(Prism, &one), (Prism, &other)], 8, 1.0);
        // A pyramid and two tetrahedra below the diagonal plane of two of its edges.
        let [a, b] = [[1, 2, 6, 4], [2, 3, 6, 4]];
        let cells: [(CellKind, &[u32]); 3] = [
            (Pyramid, &[0, 1, 2, 3, 4]),
            (Tetrahedron, &a),
            (Tetrahedron, &b),
        ];
        let mut boundary = VolumeBoundary::new();
        for (tag, (kind, corners)) in cells.into_iter().enumerate() {
            boundary.add_cell(kind, corners, tag as u32 + 7);
        }
        let faces = boundary.faces();
        // Thirteen faces, of which two pairs and the one between the tetrahedra coincide.
        assert_eq!(faces.len(), 13 - 6);
        assert_eq!(faces.iter().filter(|f| f.tag == 7).count(), 3);
        assert_eq!(faces.iter().filter(|f| f.tag == 9).count(), 2);
    }

    #[test]
    fn corners_that_coincide_make_other_cells() {
        // A hexahedron as a prism, as a pyramid and as a tetrahedron.
        check(&[(Hexahedron, &[0, 1, 3, 3, 4, 5, 7, 7])], 5, 0.5);
        check(&[(Hexahedron, &[0, 1, 2, 3, 4, 4, 4, 4])], 5, 1.0 / 3.0);
        check(&[(Hexahedron, &[0, 1, 3, 3, 4, 4, 4, 4])], 4, 1.0 / 6.0);
        // Flat cells, and too few corners.
        check(&[(Tetrahedron, &[0, 1, 2, 2])], 0, 0.0);
        check(&[(Tetrahedron, &[5; 4]), (Prism, &[0, 1, 2, 3, 4])], 0, 0.0);
    }

    #[test]
    fn inverted_cells_are_turned() {
        let (positions, mut boundary) = (cube(), VolumeBoundary::new());
        boundary.add_cell(Prism, &[4, 5, 7, 0, 1, 3], 0);
        let mut faces = boundary.faces();
        assert!(volume(&faces, &positions) < 0.0);
        for face in &mut faces {
            assert!(face.turn_outwards(|c| positions[c as usize]));
        }
        assert!((volume(&faces, &positions) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn a_block_of_cells_has_the_surface_of_the_block() {
        const N: u32 = 5;
        let at = |x: u32, y: u32, z: u32| x + (N + 1) * (y + (N + 1) * z);
        let mut boundary = VolumeBoundary::new();
        for cell in 0..N * N * N {
            let (x, y, z) = (cell % N, cell / N % N, cell / N / N);
            let square = |z| {
                [
                    at(x, y, z),
                    at(x + 1, y, z),
                    at(x + 1, y + 1, z),
                    at(x, y + 1, z),
                ]
            };
            let corners = [square(z), square(z + 1)].concat();
            boundary.add_cell(Hexahedron, &corners, 0);
        }
        assert_eq!(boundary.faces().len() as u32, 6 * N * N);
    }
}
