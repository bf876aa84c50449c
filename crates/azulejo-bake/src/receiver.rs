//! The surfaces that receive a lightmap: triangles in the world.

use azulejo_scene::{MaterialId, Object, PlacedMesh};
use azulejo_trace::MeshTriangles;
use glam::DVec3;
use std::collections::HashMap;

/// Areas and normals of triangles smaller than this share of the squared size of their object are not
/// known in the single precision in which files have their vertices.
const NO_AREA: f64 = 1e-14;

/// The triangles of one object, in the world.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Receiver {
    /// The object's name, for messages.
    pub name: String,
    /// Vertices, scene units.
    pub positions: Vec<DVec3>,
    /// Three vertices of each triangle, counter-clockwise from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Unit shading normals at the three corners of each triangle, on its front's side; empty for flat faces.
    pub normals: Vec<[DVec3; 3]>,
    /// Which part each triangle belongs to, such as a primitive of a glTF mesh. All of a part lies on
    /// one page, and no chart has triangles of two.
    pub parts: Vec<u32>,
    /// How much denser than others its texels are, per length.
    pub density: f64,
    /// Triangles that get no texels; empty if all do.
    pub omitted: Vec<bool>,
}

impl Receiver {
    /// The triangles of an object with a mesh; its materials are its parts. `None` for other shapes.
    ///
    /// Triangles are in the order of the faces, those of a face in the order of
    /// [`Mesh::triangulate`](azulejo_scene::Mesh::triangulate).
    pub fn of_object(object: &Object) -> Option<Receiver> {
        let placed = object.shape.placed_mesh()?;
        let mesh = placed.mesh;
        let all = MeshTriangles::new(mesh);
        let mut receiver = Receiver {
            name: object.name.clone(),
            positions: (0..mesh.positions.len() as u32)
                .map(|v| placed.position(v))
                .collect(),
            density: 1.0,
            ..Receiver::default()
        };
        let mut parts = PartNumbers::default();
        for (face, corners) in mesh.faces.iter().enumerate() {
            let first = MeshTriangles::first_of(mesh, face);
            let part = parts.of(mesh.face_materials[face]);
            for number in first..first + corners.len() - 2 {
                let corners = all.corners(number);
                receiver
                    .triangles
                    .push(corners.map(|c| mesh.faces.corners[c as usize]));
                receiver.parts.push(part);
                receiver.normals.extend(shading(&placed, corners));
            }
        }
        Some(receiver)
    }

    /// World positions of the corners of a triangle.
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|v| self.positions[v as usize])
    }

    /// Area times the unit normal of the front.
    pub fn area_vector(&self, triangle: usize) -> DVec3 {
        let [a, b, c] = self.corners(triangle);
        0.5 * (b - a).cross(c - a)
    }

    /// The unit shading normal at barycentric coordinates; the geometric one where it has none, or where
    /// it would look from behind.
    pub fn shading_normal(&self, triangle: usize, weights: [f64; 3]) -> DVec3 {
        let flat = self.area_vector(triangle).normalize_or(DVec3::Z);
        let Some(normals) = self.normals.get(triangle) else {
            return flat;
        };
        let sum: DVec3 = normals.iter().zip(weights).map(|(&n, w)| w * n).sum();
        let smooth = sum.normalize_or(flat);
        if smooth.dot(flat) > 0.0 { smooth } else { flat }
    }

    /// Sum of the areas of the triangles that get texels, square scene units.
    pub fn area(&self) -> f64 {
        (0..self.triangles.len())
            .filter(|&t| !self.is_omitted(t))
            .map(|t| self.area_vector(t).length())
            .sum()
    }

    fn is_omitted(&self, triangle: usize) -> bool {
        self.omitted.get(triangle).copied().unwrap_or(false)
    }

    /// For each triangle whether it gets texels, and has an area that single precision can tell from none.
    pub fn visible_triangles(&self) -> Vec<bool> {
        let bounds = azulejo_scene::math::Aabb::around(self.positions.iter().copied());
        let least = NO_AREA * bounds.diagonal().powi(2);
        let is_visible = |t: usize| {
            let area = self.area_vector(t).length();
            area > least && area.is_finite() && !self.is_omitted(t)
        };
        (0..self.triangles.len()).map(is_visible).collect()
    }
}

/// Shading normals of three corners, if the mesh has any; on the side of the front, because some files have normals
/// to one side and corners in the order of the other.
fn shading(placed: &PlacedMesh, corners: [u32; 3]) -> Option<[DVec3; 3]> {
    placed.mesh.normals.as_ref()?;
    let vertices = corners.map(|c| placed.mesh.faces.corners[c as usize]);
    let normal = |k: usize| (placed.normal(corners[k] as usize, vertices[k])).unwrap_or(DVec3::Z);
    let normals = [0, 1, 2].map(normal);
    let [a, b, c] = vertices.map(|v| placed.position(v));
    let is_opposite = normals.iter().sum::<DVec3>().dot((b - a).cross(c - a)) < 0.0;
    Some(normals.map(|n| if is_opposite { -n } else { n }))
}

/// Numbers of materials in the order in which they first occur.
#[derive(Default)]
struct PartNumbers(HashMap<MaterialId, u32>);

impl PartNumbers {
    fn of(&mut self, material: MaterialId) -> u32 {
        let next = self.0.len() as u32;
        *self.0.entry(material).or_insert(next)
    }
}
