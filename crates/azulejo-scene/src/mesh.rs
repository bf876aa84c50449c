//! Polygon meshes.

use crate::coordinates::reach;
use crate::math::{Aabb, area_vector};
use crate::{CoordinateRounding, MaterialId, PositionHistory, Rgb};
use glam::{DAffine3, DVec2, DVec3};
use std::collections::HashMap;

/// Polygons over shared positions, placed in the world.
///
/// Positions, colours and irradiance belong to vertices; normals and texture coordinates belong to
/// vertices or, where the file has it so, to the corners of faces ([`Attribute`]).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// World position of each vertex.
    pub positions: Vec<DVec3>,
    /// Unit shading normals, if any.
    pub normals: Option<Attribute<DVec3>>,
    /// Texture coordinates, if any.
    pub uvs: Option<Attribute<DVec2>>,
    /// Texture coordinates of the lightmaps of its materials, with v upwards, if any.
    pub lightmap_uvs: Option<Attribute<DVec2>>,
    /// Colour of each vertex, which multiplies the diffuse reflectance; empty when absent.
    pub colors: Vec<Rgb>,
    /// Irradiance of each vertex on the front side, W/m²; empty until the scene is solved.
    pub irradiance: Vec<Rgb>,
    /// Standard error of each vertex's irradiance; empty when absent.
    pub irradiance_error: Vec<Rgb>,
    /// Irradiance of the back; `None` where only that of the front is known, and in exact shapes.
    pub back: Option<Box<BackIrradiance>>,
    /// The polygons.
    pub faces: Faces,
    /// Material of each face.
    pub face_materials: Vec<MaterialId>,
    /// Smoothing group of each face, 0 for flat ones; empty when the file does not say what is smooth. Faces
    /// of one group that meet at an edge are one smooth surface there.
    pub smoothing: Vec<u32>,
    /// How exactly the positions are known, where they were mapped:
    /// [`coordinate_rounding`](Mesh::coordinate_rounding) tells.
    pub history: PositionHistory,
}

/// Irradiance on the backs of a mesh's faces, which is stored beside that of the fronts where both
/// sides of a sheet are seen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BackIrradiance {
    /// W/m², one per vertex; `None` where no face needs it.
    pub irradiance: Vec<Option<Rgb>>,
    /// Standard error, one per vertex, black where there is no irradiance; or empty.
    pub error: Vec<Rgb>,
}

/// Irradiance on the vertices of one placed mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VertexLight {
    /// Irradiance of each vertex on the front side, W/m².
    pub irradiance: Vec<Rgb>,
    /// Standard error of each vertex's irradiance, or empty.
    pub error: Vec<Rgb>,
    /// Irradiance of the back, where it is known.
    pub back: Option<Box<BackIrradiance>>,
}

/// Values per vertex, or per corner of a face through an index.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Attribute<T> {
    /// The values.
    pub values: Vec<T>,
    /// One index into `values` per corner, in the order of [`Faces::corners`]; `None` when the
    /// values belong to the vertices in their order.
    pub corners: Option<Vec<u32>>,
}

impl<T: Copy> Attribute<T> {
    /// One value per vertex.
    pub fn per_vertex(values: Vec<T>) -> Attribute<T> {
        Attribute {
            values,
            corners: None,
        }
    }

    /// The value at a corner: `corner` counts all corners of the mesh, `vertex` is its vertex.
    pub fn at(&self, corner: usize, vertex: u32) -> T {
        match &self.corners {
            Some(index) => self.values[index[corner] as usize],
            None => self.values[vertex as usize],
        }
    }
}

/// Polygons of three or more corners, stored one after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Faces {
    /// Index of each face's first corner, followed by the number of corners: one more entry than
    /// there are faces, the first of them 0.
    pub starts: Vec<u32>,
    /// Vertex index of each corner, counter-clockwise from the front.
    pub corners: Vec<u32>,
}

impl Default for Faces {
    fn default() -> Faces {
        Faces {
            starts: vec![0],
            corners: Vec::new(),
        }
    }
}

impl Faces {
    /// Number of polygons.
    pub fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Whether there is no polygon.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Appends a polygon.
    pub fn push(&mut self, corners: &[u32]) {
        self.corners.extend_from_slice(corners);
        self.starts.push(self.corners.len() as u32);
    }

    /// Vertex indices of face `face`.
    pub fn get(&self, face: usize) -> &[u32] {
        &self.corners[self.corner_range(face)]
    }

    /// The range of the corners of face `face` in `corners`.
    pub fn corner_range(&self, face: usize) -> std::ops::Range<usize> {
        self.starts[face] as usize..self.starts[face + 1] as usize
    }

    /// All polygons in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        (0..self.len()).map(|f| self.get(f))
    }

    /// Number of triangles that the polygons make: corners − 2 each.
    pub fn triangle_count(&self) -> usize {
        self.corners.len() - 2 * self.len()
    }
}

impl Mesh {
    /// Appends a polygon of one material.
    pub fn push_face(&mut self, corners: &[u32], material: MaterialId) {
        self.faces.push(corners);
        self.face_materials.push(material);
    }

    /// Stores irradiance on the vertices as they are.
    ///
    /// # Panics
    /// If `light` belongs to another mesh.
    pub(crate) fn set_light(&mut self, light: VertexLight) {
        let count = self.positions.len();
        assert_eq!(light.irradiance.len(), count, "irradiance of another mesh");
        self.irradiance = light.irradiance;
        self.irradiance_error = light.error;
        self.back = light.back;
    }

    /// The indices of the corners of faces and of their attributes: lists as long as the corners.
    pub(crate) fn corner_indices(&mut self) -> impl Iterator<Item = &mut Vec<u32>> {
        let normals = self.normals.iter_mut().flat_map(|a| &mut a.corners);
        let uvs = [&mut self.uvs, &mut self.lightmap_uvs];
        let uvs = uvs.into_iter().flatten().flat_map(|a| &mut a.corners);
        normals.chain(uvs).chain([&mut self.faces.corners])
    }

    /// How exactly the positions are known: by the digits of the file that they come from, also after
    /// [`transform`](Mesh::transform).
    pub fn coordinate_rounding(&self) -> CoordinateRounding {
        let noted = self.history.0;
        noted.unwrap_or_else(|| CoordinateRounding::of(&self.positions))
    }

    /// Notes that positions which had this rounding were mapped.
    pub(crate) fn note_map(&mut self, before: CoordinateRounding, map: &DAffine3) {
        let mapped = before.mapped(map, reach(&self.positions));
        self.history = PositionHistory(Some(mapped));
    }

    /// World positions of the corners of a face.
    pub fn face_positions(&self, face: usize) -> Vec<DVec3> {
        self.faces
            .get(face)
            .iter()
            .map(|&v| self.positions[v as usize])
            .collect()
    }

    /// Area vector of a face: area times the unit normal of its front.
    pub fn face_area_vector(&self, face: usize) -> DVec3 {
        area_vector(&self.face_positions(face))
    }

    /// Smoothing group of a face, 0 for none.
    pub fn smoothing_group(&self, face: usize) -> u32 {
        self.smoothing.get(face).copied().unwrap_or(0)
    }

    /// Makes all faces flat: without groups, but said.
    pub fn be_flat(&mut self) {
        self.smoothing = vec![0; self.faces.len()];
    }

    /// Whether any face has a smoothing group.
    pub fn is_grouped(&self) -> bool {
        self.smoothing.iter().any(|&group| group != 0)
    }

    /// Sets the normals of corners by the smoothing groups, if there are groups and no normals.
    pub fn take_group_normals(&mut self) {
        if self.normals.is_none() {
            self.normals = self.group_normals();
        }
    }

    /// Unit normals of corners by the smoothing groups: the mean of the faces of one group around a
    /// vertex, weighted by their angles there. `None` without groups.
    ///
    /// Thürmer and Wüthrich, *Computing vertex normals from polygonal facets*, Journal of Graphics Tools
    /// 3(1), 1998.
    pub fn group_normals(&self) -> Option<Attribute<DVec3>> {
        if !self.is_grouped() {
            return None;
        }
        let mut normals = Attribute {
            values: Vec::new(),
            corners: Some(Vec::with_capacity(self.faces.corners.len())),
        };
        let mut known: HashMap<(u32, u32), u32> = HashMap::new();
        for (face, corners) in self.faces.iter().enumerate() {
            let positions = self.face_positions(face);
            let normal = area_vector(&positions).normalize_or_zero();
            let (group, count) = (self.smoothing_group(face), positions.len());
            for (k, &vertex) in corners.iter().enumerate() {
                let next = positions[(k + 1) % count] - positions[k];
                let last = positions[(k + count - 1) % count] - positions[k];
                let new = normals.values.len() as u32;
                let index = match group {
                    0 => new,
                    _ => *known.entry((vertex, group)).or_insert(new),
                };
                if index == new {
                    normals.values.push(DVec3::ZERO);
                }
                let angle = next.cross(last).length().atan2(next.dot(last));
                normals.values[index as usize] += angle * normal;
                normals.corners.get_or_insert_default().push(index);
            }
        }
        for value in &mut normals.values {
            *value = value.normalize_or(DVec3::Z);
        }
        Some(normals)
    }

    /// The smallest box around the vertices that faces use.
    pub fn bounds(&self) -> Aabb {
        Aabb::around(
            self.faces
                .corners
                .iter()
                .map(|&v| self.positions[v as usize]),
        )
    }

    /// Whether every edge, by the positions of its ends, has an even number of faces. Which way
    /// they are oriented does not matter: a ray that enters leaves again.
    pub fn is_closed(&self) -> bool {
        self.is_closed_by(|_| true)
    }

    /// The number of edges, by the positions of their ends, with an odd number of faces.
    pub fn open_edges(&self) -> usize {
        let uses = self.edge_uses(|_| true);
        uses.values().filter(|n| *n % 2 == 1).count()
    }

    /// The same as [`is_closed`](Mesh::is_closed) of the faces alone whose material `counts`.
    pub fn is_closed_by(&self, counts: impl Fn(MaterialId) -> bool) -> bool {
        self.edge_uses(counts).values().all(|n| n % 2 == 0)
    }

    /// The number of faces at each edge, by the positions of its ends.
    fn edge_uses(
        &self,
        counts: impl Fn(MaterialId) -> bool,
    ) -> HashMap<([u64; 3], [u64; 3]), usize> {
        let key = |v: u32| {
            self.positions[v as usize]
                .to_array()
                .map(|x| (x + 0.0).to_bits())
        };
        let mut uses = HashMap::new();
        for (corners, &material) in self.faces.iter().zip(&self.face_materials) {
            if !counts(material) {
                continue;
            }
            let next = corners.iter().cycle().skip(1);
            for (&a, &b) in corners.iter().zip(next) {
                let (a, b) = (key(a), key(b));
                if a != b {
                    *uses.entry((a.min(b), a.max(b))).or_default() += 1;
                }
            }
        }
        uses
    }

    /// Sum of the faces' areas.
    pub fn area(&self) -> f64 {
        (0..self.faces.len())
            .map(|f| self.face_area_vector(f).length())
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A roof of two slopes: smooth along its ridge in one group, not in two, nor in none.
    #[test]
    fn groups_make_normals() {
        let roof = |smoothing: Vec<u32>| {
            let mut mesh = Mesh {
                positions: vec![
                    DVec3::new(-1.0, 0.0, 0.0),
                    DVec3::new(0.0, 0.0, 1.0),
                    DVec3::new(0.0, 1.0, 1.0),
                    DVec3::new(1.0, 0.0, 0.0),
                ],
                smoothing,
                ..Mesh::default()
            };
            mesh.push_face(&[0, 1, 2], 0);
            mesh.push_face(&[1, 3, 2], 0);
            mesh
        };
        assert!(roof(Vec::new()).group_normals().is_none());
        assert!(roof(vec![0, 0]).group_normals().is_none());
        let at = |mesh: &Mesh, corner: usize| {
            let normals = mesh.group_normals().unwrap();
            normals.at(corner, mesh.faces.corners[corner])
        };
        let one = roof(vec![3, 3]);
        assert_eq!(at(&one, 1), at(&one, 3));
        assert!(at(&one, 1).x.abs() < 1e-12, "{}", at(&one, 1));
        for apart in [roof(vec![1, 2]), roof(vec![0, 2])] {
            for (corner, face) in [(0, 0), (1, 0), (3, 1), (5, 1)] {
                let normal = apart.face_area_vector(face).normalize();
                assert!(at(&apart, corner).distance(normal) < 1e-12);
            }
        }
    }
}
