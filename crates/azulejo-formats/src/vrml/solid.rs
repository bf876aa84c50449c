//! Spheres, boxes, cylinders and cones, as exact primitives or as polygons.

use azulejo_scene::{Attribute, MaterialId, Mesh, Primitive, PrimitiveKind, SurfaceGrid};
use glam::{DAffine3, DMat3, DVec2, DVec3};
use std::f64::consts::TAU;

/// Chord error of tessellated primitives, relative to their size.
const CHORD_ERROR: f64 = 1e-3;

/// An exact primitive.
pub(super) struct PlacedPrimitive {
    pub kind: PrimitiveKind,
    /// Scales the unit primitive. The azimuth of round ones starts at the back, where VRML has the
    /// texture seam.
    pub object_from_unit: DAffine3,
    /// Whether each part of the primitive is present.
    pub parts: Vec<bool>,
}

impl PlacedPrimitive {
    /// A sphere.
    pub fn sphere(radius: f64) -> PlacedPrimitive {
        PlacedPrimitive {
            kind: PrimitiveKind::Sphere,
            object_from_unit: upright(radius, radius, 0.0),
            parts: vec![true],
        }
    }

    /// A box around the origin.
    pub fn cuboid(size: DVec3) -> PlacedPrimitive {
        PlacedPrimitive {
            kind: PrimitiveKind::Cuboid,
            object_from_unit: DAffine3 {
                matrix3: DMat3::from_diagonal(size),
                translation: -0.5 * size,
            },
            parts: vec![true; 6],
        }
    }

    /// A cylinder around the y axis.
    pub fn cylinder(
        radius: f64,
        height: f64,
        side: bool,
        bottom: bool,
        top: bool,
    ) -> PlacedPrimitive {
        PlacedPrimitive {
            kind: PrimitiveKind::Cylinder,
            object_from_unit: upright(radius, height, -0.5 * height),
            parts: vec![side, bottom, top],
        }
    }

    /// A cone around the y axis.
    pub fn cone(radius: f64, height: f64, side: bool, bottom: bool) -> PlacedPrimitive {
        PlacedPrimitive {
            kind: PrimitiveKind::Cone { top: 0.0 },
            object_from_unit: upright(radius, height, -0.5 * height),
            parts: vec![side, bottom],
        }
    }

    /// Whether all of its parts are present.
    pub fn is_closed(&self) -> bool {
        self.parts.iter().all(|is_there| *is_there)
    }

    /// The primitive, and the grids of its parts.
    fn grids(&self) -> (Primitive, Vec<SurfaceGrid>) {
        let primitive = Primitive::new(self.kind, self.object_from_unit, 0);
        let grids = primitive.grids(CHORD_ERROR * primitive.bounds().diagonal(), f64::INFINITY);
        (primitive, grids)
    }

    /// The number of vertices of its polygons.
    pub fn vertex_count(&self) -> u64 {
        let grids = self.grids().1;
        let parts = grids.iter().zip(&self.parts).filter(|part| *part.1);
        parts.map(|(grid, _)| grid.vertices() as u64).sum()
    }

    /// The polygons of the parts that are present, each with its material, with texture
    /// coordinates.
    pub fn polygons(&self, materials: &[MaterialId]) -> Mesh {
        let (primitive, grids) = self.grids();
        let whole = primitive.tessellate(&grids);
        let (mut mesh, mut normals, mut uvs) = (Mesh::default(), Vec::new(), Vec::new());
        let (mut first_vertex, mut first_face) = (0, 0);
        for (part, grid) in grids.iter().enumerate() {
            let vertices = first_vertex..first_vertex + grid.vertices();
            let faces = first_face..first_face + grid.cells();
            (first_vertex, first_face) = (vertices.end, faces.end);
            if !self.parts[part] {
                continue;
            }
            let shift = mesh.positions.len() as u32;
            mesh.positions
                .extend_from_slice(&whole.positions[vertices.clone()]);
            normals.extend(
                whole
                    .normals
                    .iter()
                    .flat_map(|n| &n.values[vertices.clone()]),
            );
            for j in 0..=grid.nv {
                let v = f64::from(j) / f64::from(grid.nv);
                let row = (0..=grid.nu).map(|i| f64::from(i) / f64::from(grid.nu));
                uvs.extend(row.map(|u| texture_point(self.kind, part, u, v)));
            }
            for face in faces {
                let corners = whole.faces.get(face).iter();
                let corners: Vec<u32> =
                    corners.map(|v| v - vertices.start as u32 + shift).collect();
                mesh.push_face(&corners, materials[part]);
            }
        }
        // Flat parts need no normals, and degenerate ones have none.
        let is_round = self.kind != PrimitiveKind::Cuboid;
        let are_unit = normals.iter().all(|n: &DVec3| n.is_normalized());
        mesh.normals = (is_round && are_unit).then(|| Attribute::per_vertex(normals));
        mesh.uvs = Some(Attribute::per_vertex(uvs));
        mesh
    }
}

/// The map from the z axis of a unit primitive to the y axis of VRML, with azimuth 0 at the back.
fn upright(radius: f64, height: f64, bottom: f64) -> DAffine3 {
    DAffine3 {
        matrix3: DMat3::from_cols(
            radius * DVec3::NEG_Z,
            radius * DVec3::NEG_X,
            height * DVec3::Y,
        ),
        translation: bottom * DVec3::Y,
    }
}

/// The texture coordinates of a point of a part: textures wrap once around round parts, cover each
/// side of a cube, and show their central disc on end caps.
fn texture_point(kind: PrimitiveKind, part: usize, u: f64, v: f64) -> DVec2 {
    let (sin, cos) = (TAU * u).sin_cos();
    let (x, y) = match (kind, part) {
        // The part's own u and v, oriented upright as seen from outside.
        (PrimitiveKind::Cuboid, 1) => (1.0 - v, u),
        (PrimitiveKind::Cuboid, 3) => (v, 1.0 - u),
        (PrimitiveKind::Cuboid, 4) => (1.0 - v, u),
        (PrimitiveKind::Cylinder | PrimitiveKind::Cone { .. }, 1) => {
            (0.5 - 0.5 * v * sin, 0.5 - 0.5 * v * cos)
        }
        (PrimitiveKind::Cylinder, 2) => (0.5 - 0.5 * v * sin, 0.5 + 0.5 * v * cos),
        _ => (u, v),
    };
    DVec2::new(x, y)
}
