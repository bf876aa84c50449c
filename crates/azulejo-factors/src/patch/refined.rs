//! The divided mesh, with all attributes of the given one.

use super::{Cells, Patches};
use azulejo_scene::{Attribute, Mesh, Rgb, Scene, Shape, SurfaceGrid};
use glam::{DVec2, DVec3};
use std::ops::{Add, Mul};

/// The geometry that carries an object's irradiance after division.
#[allow(
    clippy::large_enum_variant,
    reason = "there is one per object, so its size does not matter"
)]
#[derive(Clone, Debug, PartialEq)]
pub enum RefinedShape {
    /// A mesh whose faces are the object's patches and whose vertices are its display vertices,
    /// both in order.
    Mesh(Mesh),
    /// The grids of an exact primitive's parts, whose vertices are its display vertices.
    Surface(Vec<SurfaceGrid>),
}

impl Patches {
    /// Object `object` of the divided scene, as patches.
    ///
    /// Texture coordinates and colours are interpolated; materials and smoothing groups are kept.
    /// The mesh has normals if the given one has normals or smoothing groups. An object that does
    /// not exist gives an empty mesh.
    pub fn refined(&self, object: u32, scene: &Scene) -> RefinedShape {
        match scene.objects.get(object as usize).map(|o| &o.shape) {
            Some(Shape::Mesh(mesh)) => RefinedShape::Mesh(self.refined_mesh(object, mesh)),
            Some(Shape::Instance(instance)) => {
                RefinedShape::Mesh(self.refined_mesh(object, &instance.mesh))
            }
            Some(Shape::Primitive(_)) => RefinedShape::Surface(self.part_grids(object)),
            Some(Shape::Exact(_)) | None => RefinedShape::Mesh(Mesh::default()),
        }
    }

    fn part_grids(&self, object: u32) -> Vec<SurfaceGrid> {
        self.object_regions(object)
            .filter_map(|r| match self.cells[r] {
                Cells::Part { nu, nv } => Some(SurfaceGrid { nu, nv }),
                _ => None,
            })
            .collect()
    }

    fn object_regions(&self, object: u32) -> std::ops::Range<usize> {
        let faces = super::between(&self.face_base, object as usize);
        if faces.is_empty() {
            return 0..0;
        }
        self.face_regions[faces.start] as usize..self.face_regions[faces.end] as usize
    }

    fn refined_mesh(&self, object: u32, given: &Mesh) -> Mesh {
        let vertices = self.vertices_of(object);
        let mut mesh = Mesh {
            positions: self.vertices[vertices.clone()]
                .iter()
                .map(|v| v.position)
                .collect(),
            ..Mesh::default()
        };
        for i in self.patches_of(object) {
            let mut corners = [0; 4];
            let ids = self.corner_vertices(i);
            for (c, &v) in corners.iter_mut().zip(ids) {
                *c = v - vertices.start as u32;
            }
            mesh.push_face(&corners[..ids.len()], self.material(i));
            if !given.smoothing.is_empty() {
                mesh.smoothing
                    .push(given.smoothing_group(self.face(i).face as usize));
            }
        }
        if given.normals.is_some() || given.smoothing.iter().any(|&g| g != 0) {
            let normals: Vec<DVec3> = self.vertices[vertices].iter().map(|v| v.normal).collect();
            mesh.normals = Some(Attribute::per_vertex(normals));
        }
        if !given.colors.is_empty() {
            mesh.colors =
                self.per_vertex(object, given, Rgb::BLACK, |_, v| given.colors[v as usize]);
        }
        mesh.uvs = given
            .uvs
            .as_ref()
            .map(|uvs| self.refined_uvs(object, given, uvs));
        mesh
    }

    fn refined_uvs(&self, object: u32, given: &Mesh, uvs: &Attribute<DVec2>) -> Attribute<DVec2> {
        let value = |corner, vertex| uvs.at(corner, vertex);
        if uvs.corners.is_none() {
            return Attribute::per_vertex(self.per_vertex(object, given, DVec2::ZERO, value));
        }
        let (mut values, mut corners) = (Vec::new(), Vec::new());
        for region in self.object_regions(object) {
            let base = values.len() as u32;
            values.extend(self.interpolated(region, given, value));
            self.cells[region].for_each(|ring| {
                let used = ring.iter().filter(|&&k| k != super::NO_CORNER);
                corners.extend(used.map(|&k| base + k));
            });
        }
        Attribute {
            values,
            corners: Some(corners),
        }
    }

    /// Interpolates vertex attributes. Regions agree on the vertices they share.
    fn per_vertex<T>(
        &self,
        object: u32,
        given: &Mesh,
        filler: T,
        value: impl Fn(usize, u32) -> T + Copy,
    ) -> Vec<T>
    where
        T: Copy + Add<Output = T> + Mul<f64, Output = T>,
    {
        let vertices = self.vertices_of(object);
        let mut values = vec![filler; vertices.len()];
        for region in self.object_regions(object) {
            let points = self.interpolated(region, given, value);
            let mut patch = self.region_patches[region] as usize;
            self.cells[region].for_each(|ring| {
                for (&local, &v) in ring.iter().zip(self.corner_vertices(patch)) {
                    values[v as usize - vertices.start] = points[local as usize];
                }
                patch += 1;
            });
        }
        values
    }

    /// A value at each local point of a region from its values at the mesh's corners.
    fn interpolated<T>(
        &self,
        region: usize,
        given: &Mesh,
        value: impl Fn(usize, u32) -> T,
    ) -> Vec<T>
    where
        T: Copy + Add<Output = T> + Mul<f64, Output = T>,
    {
        let corners = &self.regions[region].corners;
        let ring = &self.region_corners[corners.start as usize..corners.end as usize];
        let at = |k: u32| {
            let corner = ring[k as usize] as usize;
            value(corner, given.faces.corners[corner])
        };
        let mut points = Vec::new();
        self.cells[region].for_each_weight(|weights| {
            let terms = weights.iter().map(|&(k, w)| at(k) * w);
            points.extend(terms.reduce(|a, b| a + b));
        });
        points
    }
}
