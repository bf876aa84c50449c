//! Meshes of triangles alone, for programs that read no polygons.

use crate::{Attribute, Faces, Mesh, Scene, Shape};

impl Scene {
    /// Divides the polygons of all meshes into triangles, as [`Mesh::triangulate`] does.
    pub fn divide_into_triangles(&mut self) {
        for object in &mut self.objects {
            if let Shape::Mesh(mesh) = &mut object.shape {
                mesh.divide_into_triangles();
            }
        }
        self.change_shared_meshes(Mesh::divide_into_triangles);
    }
}

impl Mesh {
    /// Divides all polygons into triangles; vertices and what belongs to them stay.
    pub fn divide_into_triangles(&mut self) {
        if self.faces.corners.len() == 3 * self.faces.len() {
            return;
        }
        let mut triangles = Vec::new();
        // For each new corner the old one, for each new face the old one.
        let (mut corners, mut parents) = (Vec::new(), Vec::new());
        for face in 0..self.faces.len() {
            triangles.clear();
            self.triangulate_into(face, &mut triangles);
            let first = self.faces.corner_range(face).start;
            corners.extend(triangles.iter().flatten().map(|&k| first + k as usize));
            parents.resize(parents.len() + triangles.len(), face);
        }
        let taken = |list: &[u32]| corners.iter().map(|&c| list[c]).collect::<Vec<u32>>();
        retake(&mut self.normals, taken);
        retake(&mut self.uvs, taken);
        retake(&mut self.lightmap_uvs, taken);
        self.faces = Faces {
            starts: (0..=parents.len() as u32).map(|k| 3 * k).collect(),
            corners: taken(&self.faces.corners),
        };
        let of_parents = |list: &[u32]| parents.iter().map(|&f| list[f]).collect();
        self.face_materials = of_parents(&self.face_materials);
        if !self.smoothing.is_empty() {
            self.smoothing = of_parents(&self.smoothing);
        }
    }
}

fn retake<T>(attribute: &mut Option<Attribute<T>>, taken: impl Fn(&[u32]) -> Vec<u32>) {
    let corners = attribute.as_mut().and_then(|a| a.corners.as_mut());
    if let Some(corners) = corners {
        *corners = taken(corners);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn polygons_become_triangles_with_their_attributes() {
        let corner = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let mut mesh = Mesh {
            positions: vec![
                corner(0.0, 0.0),
                corner(2.0, 0.0),
                corner(2.0, 1.0),
                corner(0.0, 1.0),
            ],
            normals: Some(Attribute {
                values: vec![DVec3::Z, DVec3::NEG_Z],
                corners: Some(vec![0, 0, 0, 0, 1, 1, 1]),
            }),
            ..Mesh::default()
        };
        mesh.push_face(&[0, 1, 2, 3], 5);
        mesh.push_face(&[2, 1, 0], 6);
        mesh.smoothing = vec![1, 2];
        let area = mesh.area();
        mesh.divide_into_triangles();
        assert_eq!(mesh.faces.len(), 3);
        assert_eq!(mesh.face_materials, [5, 5, 6]);
        assert_eq!(mesh.smoothing, [1, 1, 2]);
        assert!((mesh.area() - area).abs() < 1e-12);
        let normals = mesh.normals.as_ref().unwrap().corners.as_ref().unwrap();
        assert_eq!(normals[..], [0, 0, 0, 0, 0, 0, 1, 1, 1]);
        let before = mesh.clone();
        mesh.divide_into_triangles();
        assert_eq!(mesh, before);
    }
}
