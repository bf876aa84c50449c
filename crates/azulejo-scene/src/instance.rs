//! Shared meshes: one shape in many places.

use crate::coordinates::{CoordinateRounding, reach};
use crate::math::{Aabb, normal_matrix};
use crate::mesh::{BackIrradiance, Mesh, VertexLight};
use crate::rgb::Rgb;
use glam::{DAffine3, DMat3, DVec3};
use std::sync::Arc;

/// A mesh that several objects may share, placed in the world by a map of its own.
///
/// A million triangles that stand a thousand times in a scene are stored, traced and written once; what
/// each place has for itself is its map and its light.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshInstance {
    /// The mesh in its own coordinates, without irradiance.
    pub mesh: Arc<Mesh>,
    /// Its place: invertible, and without mirroring, so that the order of corners is that of the mesh.
    /// [`SharedMesh::placed`] makes a mirrored mesh where a map mirrors.
    pub world_from_mesh: DAffine3,
    /// Irradiance on its vertices, once the scene is solved.
    pub light: Option<Box<VertexLight>>,
}

impl MeshInstance {
    /// A mesh at a place, or `None` if the map is not finite and invertible or mirrors.
    pub fn new(mesh: Arc<Mesh>, world_from_mesh: DAffine3) -> Option<MeshInstance> {
        let size = world_from_mesh.matrix3.determinant();
        let usable = world_from_mesh.is_finite() && size > 0.0 && size.is_finite();
        usable.then_some(MeshInstance {
            mesh,
            world_from_mesh,
            light: None,
        })
    }

    /// The smallest box around the placed vertices that faces use.
    pub fn bounds(&self) -> Aabb {
        let corners = self.mesh.faces.corners.iter();
        Aabb::around(corners.map(|&v| self.position(v)))
    }

    /// World position of a vertex.
    pub fn position(&self, vertex: u32) -> DVec3 {
        let position = self.mesh.positions[vertex as usize];
        self.world_from_mesh.transform_point3(position)
    }

    /// Whether its map can take no point of the mesh's box beyond the largest number.
    pub fn is_finite(&self) -> bool {
        let reach = self.mesh.positions.iter().map(|p| p.abs().max_element());
        let reach = reach.fold(0.0, f64::max);
        let m = self.world_from_mesh.matrix3;
        let stretch = m.x_axis.abs() + m.y_axis.abs() + m.z_axis.abs();
        let farthest = reach * stretch + self.world_from_mesh.translation.abs();
        farthest.is_finite()
    }

    /// How exactly the world positions are known.
    pub(crate) fn coordinate_rounding(&self) -> CoordinateRounding {
        let bounds = self.mesh.bounds();
        let map = &self.world_from_mesh;
        let ends = [bounds.min, bounds.max].map(|p| map.transform_point3(p));
        let reach = if bounds.is_empty() { 0.0 } else { reach(&ends) };
        self.mesh.coordinate_rounding().mapped(map, reach)
    }

    /// The same as a mesh of its own, in the world, with its irradiance.
    pub fn to_mesh(&self) -> Mesh {
        self.clone().take_mesh()
    }

    /// As [`to_mesh`](MeshInstance::to_mesh), without a copy where no other instance has the mesh; leaves
    /// an empty one.
    pub(crate) fn take_mesh(&mut self) -> Mesh {
        let mut mesh = Arc::unwrap_or_clone(std::mem::take(&mut self.mesh));
        mesh.transform(&self.world_from_mesh);
        if let Some(light) = self.light.take() {
            mesh.set_light(*light);
        }
        mesh
    }
}

/// Makes instances of one mesh, also where a map mirrors: then they share a second, mirrored mesh.
#[derive(Clone, Debug)]
pub struct SharedMesh {
    mesh: Arc<Mesh>,
    mirrored: Option<Arc<Mesh>>,
}

impl SharedMesh {
    /// A mesh to share, in its own coordinates, without irradiance.
    pub fn new(mesh: Mesh) -> SharedMesh {
        SharedMesh::of(Arc::new(mesh))
    }

    /// A mesh that others may have already.
    pub fn of(mesh: Arc<Mesh>) -> SharedMesh {
        SharedMesh {
            mesh,
            mirrored: None,
        }
    }

    /// The mesh as it is.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// The mesh at a place; `None` if the map is not finite and invertible. Fronts stay fronts.
    pub fn placed(&mut self, world_from_mesh: DAffine3) -> Option<MeshInstance> {
        if world_from_mesh.matrix3.determinant() >= 0.0 {
            return MeshInstance::new(self.mesh.clone(), world_from_mesh);
        }
        let mirror = DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)));
        let mirrored = self.mirrored.get_or_insert_with(|| {
            let mut mesh = Mesh::clone(&self.mesh);
            mesh.transform(&mirror);
            Arc::new(mesh)
        });
        MeshInstance::new(mirrored.clone(), world_from_mesh * mirror)
    }
}

/// A mesh in the world, whether it is shared or not: the parts that do not depend on the place, and
/// those that do.
#[derive(Clone, Copy, Debug)]
pub struct PlacedMesh<'a> {
    /// Faces, materials, colours and texture coordinates. Its positions and normals are in the
    /// coordinates of the mesh: [`PlacedMesh::position`] and [`PlacedMesh::normal`] are in the world.
    pub mesh: &'a Mesh,
    /// Irradiance of each vertex, W/m²; empty until the scene is solved.
    pub irradiance: &'a [Rgb],
    /// Its standard error; empty when absent.
    pub irradiance_error: &'a [Rgb],
    /// Irradiance of the back.
    pub back: Option<&'a BackIrradiance>,
    pub(crate) world_from_mesh: Option<&'a DAffine3>,
}

impl<'a> PlacedMesh<'a> {
    /// The map to the world, if it has one.
    pub fn world_from_mesh(&self) -> Option<&'a DAffine3> {
        self.world_from_mesh
    }

    /// World position of a vertex.
    pub fn position(&self, vertex: u32) -> DVec3 {
        let position = self.mesh.positions[vertex as usize];
        self.world_from_mesh
            .map_or(position, |map| map.transform_point3(position))
    }

    /// Unit shading normal in the world at a corner, counted over all corners; `None` without normals.
    pub fn normal(&self, corner: usize, vertex: u32) -> Option<DVec3> {
        let normal = self.mesh.normals.as_ref()?.at(corner, vertex);
        Some(self.to_world(normal))
    }

    /// A unit normal of the mesh as one of the world.
    pub fn to_world(&self, normal: DVec3) -> DVec3 {
        let Some(map) = self.world_from_mesh else {
            return normal;
        };
        let turned = normal_matrix(map.matrix3) * normal;
        turned.try_normalize().unwrap_or(normal)
    }

    /// World positions of the corners of a face.
    pub fn face_positions(&self, face: usize) -> Vec<DVec3> {
        let corners = self.mesh.faces.get(face).iter();
        corners.map(|&v| self.position(v)).collect()
    }

    /// Area vector of a face in the world: area times the unit normal of its front.
    pub fn face_area_vector(&self, face: usize) -> DVec3 {
        let vector = self.mesh.face_area_vector(face);
        // The cofactors, by which area vectors change, are those of normals.
        self.world_from_mesh
            .map_or(vector, |map| normal_matrix(map.matrix3) * vector)
    }

    /// Sum of the areas of its faces, in the world.
    pub fn area(&self) -> f64 {
        (0..self.mesh.faces.len())
            .map(|face| self.face_area_vector(face).length())
            .sum()
    }
}
