//! Meshes of finite elements: shells, and the boundary of solids.

use super::boundary::{CellKind, VolumeBoundary};
use super::named::NamedSurfaces;
use crate::Position;
use crate::reading::warnings::Warnings;
use glam::DVec3;
use std::collections::HashMap;

/// The shape of an element, of whose nodes only the corners count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FiniteShape {
    /// Three corners.
    Triangle,
    /// Four corners.
    Quadrilateral,
    /// A volume.
    Cell(CellKind),
}

impl FiniteShape {
    /// Number of corners, at most eight.
    pub fn corner_count(self) -> usize {
        match self {
            FiniteShape::Triangle => 3,
            FiniteShape::Quadrilateral => 4,
            FiniteShape::Cell(kind) => kind.corner_count(),
        }
    }
}

/// A shell: its corners, of which a triangle repeats the last one, and its surface.
#[derive(Clone, Copy, Debug)]
struct ShellElement {
    corners: [u32; 4],
    surface: usize,
}

/// Collects elements that belong to surfaces.
///
/// A shell on the boundary of solids names that part of it and looks outwards as it does: there is one sheet,
/// not two.
#[derive(Debug, Default)]
pub(crate) struct FiniteMesh {
    names: Vec<String>,
    numbers: HashMap<String, usize>,
    shells: Vec<ShellElement>,
    solids: VolumeBoundary,
}

impl FiniteMesh {
    /// The number of the surface with a name, for [`FiniteMesh::add`].
    pub fn surface(&mut self, name: &str) -> usize {
        if let Some(&known) = self.numbers.get(name) {
            return known;
        }
        self.numbers.insert(name.to_owned(), self.names.len());
        self.names.push(name.to_owned());
        self.names.len() - 1
    }

    /// Adds an element to a surface; of its corners there are as many as its shape has.
    pub fn add(&mut self, shape: FiniteShape, corners: &[u32], surface: usize) {
        let corners = match (shape, corners) {
            (FiniteShape::Cell(kind), _) => {
                return self.solids.add_cell(kind, corners, surface as u32);
            }
            (FiniteShape::Triangle, &[a, b, c, ..]) => [a, b, c, c],
            (FiniteShape::Quadrilateral, &[a, b, c, d, ..]) => [a, b, c, d],
            _ => return,
        };
        self.shells.push(ShellElement { corners, surface });
    }

    /// Adds the shells and the boundary to surfaces, in the order in which these were named.
    pub fn finish(
        self,
        positions: &[DVec3],
        surfaces: &mut NamedSurfaces,
        file: &str,
        warnings: &mut Warnings,
    ) {
        // Register all names first: surfaces keep the order in which the file names them.
        let numbers: Vec<usize> = self.names.iter().map(|n| surfaces.number(n)).collect();
        // Without shells, the surfaces are the boundary of the solids.
        if self.shells.is_empty() {
            if !numbers.is_empty() {
                let name = |tag: u32| self.names[tag as usize].clone();
                surfaces.push_boundary(&self.solids, positions, name, file, warnings);
            }
            return;
        }
        // Turn the fronts of the boundary out of the solids, whatever the order of the nodes.
        let mut boundary = self.solids.faces();
        let turned = boundary.iter_mut().filter_map(|face| {
            let turned = face.turn_outwards(|c| positions[c as usize]);
            turned.then_some(())
        });
        let message = "face of a solid whose nodes are in inverse order: turned outwards";
        warnings.add_many(file, message.to_owned(), turned.count(), || Position::Whole);
        let faces = boundary.iter().enumerate();
        let on_boundary: HashMap<[u32; 4], usize> = faces
            .map(|(k, face)| (face_key(&face.corners), k))
            .collect();
        // A shell on the boundary only names that face; elsewhere it is a face of its own.
        let (mut is_named, mut again) = (vec![false; boundary.len()], 0);
        for shell in &self.shells {
            let number = numbers[shell.surface];
            match on_boundary.get(&face_key(&shell.corners)) {
                Some(&face) if is_named[face] => again += 1,
                Some(&face) => {
                    is_named[face] = true;
                    surfaces.push(number, &boundary[face].corners, positions);
                }
                None => surfaces.push(number, &shell.corners, positions),
            }
        }
        let message = "further shell on the same face of a solid: skipped";
        warnings.add_many(file, message.to_owned(), again, || Position::Whole);
        // What no shell names belongs to the surface of its solid.
        let rest = boundary.iter().zip(is_named).filter(|(_, named)| !named);
        let mut count = 0;
        for (face, _) in rest {
            surfaces.push(numbers[face.tag as usize], &face.corners, positions);
            count += 1;
        }
        let message = "face of the boundary of solids: read, with its front out of them (form-factors \
                       --two-sided has rows of the backs, too)";
        warnings.add_many(file, message.to_owned(), count, || Position::Whole);
    }
}

/// The different corners of a face in ascending order: the same from both sides.
pub(crate) fn face_key(corners: &[u32]) -> [u32; 4] {
    let mut sorted = [u32::MAX; 4];
    for (place, &corner) in sorted.iter_mut().zip(corners) {
        *place = corner;
    }
    sorted.sort_unstable();
    let (mut key, mut count) = ([u32::MAX; 4], 0);
    for corner in sorted {
        if !key[..count].contains(&corner) {
            key[count] = corner;
            count += 1;
        }
    }
    key
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::Shape;

    #[test]
    fn shells_name_parts_of_the_boundary() {
        let positions = [
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [5.0; 3],
        ];
        let positions = positions.map(DVec3::from);
        let (mut surfaces, mut warnings) = (NamedSurfaces::default(), Warnings::default());
        let mut mesh = FiniteMesh::default();
        let (solid, floor) = (mesh.surface("solid"), mesh.surface("floor"));
        mesh.add(
            FiniteShape::Cell(CellKind::Tetrahedron),
            &[0, 1, 2, 3],
            solid,
        );
        // Inside out, and then once more with a repeated corner.
        mesh.add(FiniteShape::Triangle, &[0, 1, 2], floor);
        mesh.add(FiniteShape::Quadrilateral, &[0, 0, 2, 1], floor);
        mesh.add(FiniteShape::Triangle, &[0, 1, 4], floor);
        mesh.finish(&positions, &mut surfaces, "a", &mut warnings);
        let scene = surfaces.scene(&positions, "a", &mut warnings);
        let faces = |k: usize| match &scene.objects[k].shape {
            Shape::Mesh(mesh) => mesh.faces.len(),
            _ => 0,
        };
        assert_eq!([faces(0), faces(1)], [3, 2]);
        let Shape::Mesh(floor) = &scene.objects[1].shape else {
            panic!("a mesh")
        };
        assert!(
            floor.face_area_vector(0).z < 0.0,
            "it looks out of the solid"
        );
        let messages = warnings.finish("a");
        let counts: Vec<usize> = messages.iter().map(|w| w.count).collect();
        assert_eq!(counts, [1, 3]);
    }

    #[test]
    fn faces_have_one_key() {
        assert_eq!(face_key(&[3, 1, 2]), face_key(&[2, 3, 1, 1]));
        assert_eq!(face_key(&[3, 1, 2, 3]), face_key(&[1, 2, 3]));
        assert_ne!(face_key(&[3, 1, 2, 0]), face_key(&[1, 2, 3]));
        assert_eq!(face_key(&[7, 7, 7, 7]), [7, u32::MAX, u32::MAX, u32::MAX]);
    }
}
