//! Meshes of triangles alone, for programs that read no polygons.

use crate::{Mesh, Scene};

impl Scene {
    /// Divides the polygons of all meshes into triangles, as [`Mesh::triangulate`] does.
    pub fn divide_into_triangles(&mut self) {
        self.for_each_mesh(Mesh::divide_into_triangles);
    }
}

impl Mesh {
    /// Divides all polygons into triangles; vertices and what belongs to them stay.
    pub fn divide_into_triangles(&mut self) {
        if self.faces.corners.len() == 3 * self.faces.len() {
            return;
        }
        self.keep_triangles(|_| true);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Attribute;
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
