//! Cube, Sphere, Cylinder and Cone: exact, unless they are open, painted in parts, flattened or
//! carry a picture.

use super::node::{Kind, Node};
use super::walk::Walk;
use crate::ReadError;
use crate::vrml::stage::Placed;
use azulejo_scene::{Attribute, MaterialId, Mesh, Primitive, PrimitiveKind};
use glam::{DAffine3, DMat3, DVec2, DVec3};
use std::f64::consts::TAU;

/// Chord error of solids that become polygons, relative to their size.
const CHORD_ERROR: f64 = 1e-3;

/// A solid as the exact primitive that it is.
struct Solid {
    kind: PrimitiveKind,
    /// Sizes it. The azimuth of round ones begins at the back, where VRML has the seam of
    /// pictures.
    object_from_unit: DAffine3,
    /// For each part of the primitive its number in VRML, which counts materials by it, and
    /// whether it is there.
    parts: Vec<(usize, bool)>,
}

impl Solid {
    fn of(node: &Node) -> Solid {
        let length = |field, default| node.number(field, default).abs();
        match node.kind {
            Kind::Sphere => {
                let r = length("radius", 1.0);
                Solid {
                    kind: PrimitiveKind::Sphere,
                    object_from_unit: upright(r, r, 0.0),
                    parts: vec![(0, true)],
                }
            }
            Kind::Cylinder => {
                let (r, h) = (length("radius", 1.0), length("height", 2.0));
                Solid {
                    kind: PrimitiveKind::Cylinder,
                    object_from_unit: upright(r, h, -0.5 * h),
                    parts: parts(node, &[("SIDES", 0), ("BOTTOM", 2), ("TOP", 1)]),
                }
            }
            Kind::Cone => {
                let (r, h) = (length("bottomRadius", 1.0), length("height", 2.0));
                Solid {
                    kind: PrimitiveKind::Cone { top: 0.0 },
                    object_from_unit: upright(r, h, -0.5 * h),
                    parts: parts(node, &[("SIDES", 0), ("BOTTOM", 1)]),
                }
            }
            _ => {
                let size = ["width", "height", "depth"].map(|side| length(side, 2.0));
                let size = DVec3::from_array(size);
                Solid {
                    kind: PrimitiveKind::Cuboid,
                    object_from_unit: DAffine3 {
                        matrix3: DMat3::from_diagonal(size),
                        translation: -0.5 * size,
                    },
                    // VRML counts front, back, left, right, top, bottom.
                    parts: [2, 3, 5, 4, 1, 0].map(|part| (part, true)).to_vec(),
                }
            }
        }
    }

    fn is_closed(&self) -> bool {
        self.parts.iter().all(|(_, is_shown)| *is_shown)
    }
}

/// The map that makes the z axis of a unit primitive the y axis of VRML, its azimuth 0 the back.
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

/// The parts of a primitive in its order, by their names and numbers in VRML.
fn parts(node: &Node, named: &[(&str, usize)]) -> Vec<(usize, bool)> {
    let words = node.words("parts");
    let is_shown = |name| words.is_empty() || words.iter().any(|w| w == name || w == "ALL");
    named
        .iter()
        .map(|&(name, part)| (part, is_shown(name)))
        .collect()
}

impl<'d> Walk<'d, '_, '_> {
    /// A Cube, Sphere, Cylinder or Cone.
    pub fn solid(&mut self, node: &'d Node<'d>) -> Result<(), ReadError> {
        let solid = Solid::of(node);
        let is_open = !solid.is_closed();
        let materials = self.part_materials(&solid, is_open);
        let is_one = materials.iter().all(|m| *m == materials[0]);
        let texture = self.state.texture;
        let is_textured = texture.is_some_and(|t| self.stage.textures.is_loaded(t));
        if !is_open && is_one && !is_textured {
            let (frame, name) = (self.frame(), node.name.as_deref());
            let (kind, map) = (solid.kind, solid.object_from_unit);
            let placed = self
                .stage
                .place_primitive(&frame, name, kind, map, materials[0]);
            if placed == Placed::Object {
                return Ok(());
            }
        }
        let mesh = polygons(&solid, &materials);
        self.stage.spend(mesh.positions.len() as u64)?;
        self.put_solid(node, mesh, is_textured);
        Ok(())
    }

    /// The material of each part.
    fn part_materials(&mut self, solid: &Solid, is_open: bool) -> Vec<MaterialId> {
        let per_part = self.state.material_binding.is_per_part();
        let number = |part: &(usize, bool)| if per_part { part.0 } else { 0 };
        let parts = solid.parts.iter();
        parts
            .map(|part| self.material(number(part), is_open, false))
            .collect()
    }

    fn put_solid(&mut self, node: &Node, mut mesh: Mesh, is_textured: bool) {
        if is_textured {
            self.map_texture(&mut mesh);
        } else {
            mesh.uvs = None;
        }
        self.put(node, mesh);
    }
}

/// The polygons of the parts that are there, each of its material, with texture coordinates.
fn polygons(solid: &Solid, materials: &[MaterialId]) -> Mesh {
    let primitive = Primitive::new(solid.kind, solid.object_from_unit, 0);
    let grids = primitive.grids(CHORD_ERROR * primitive.bounds().diagonal(), f64::INFINITY);
    let whole = primitive.tessellate(&grids);
    let (mut mesh, mut normals, mut uvs) = (Mesh::default(), Vec::new(), Vec::new());
    let (mut first_vertex, mut first_face) = (0, 0);
    for (part, grid) in grids.iter().enumerate() {
        let vertices = first_vertex..first_vertex + grid.vertices();
        let faces = first_face..first_face + grid.cells();
        (first_vertex, first_face) = (vertices.end, faces.end);
        if !solid.parts[part].1 {
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
            uvs.extend(row.map(|u| picture_point(solid.kind, part, u, v)));
        }
        for face in faces {
            let corners = whole.faces.get(face).iter();
            let corners: Vec<u32> = corners.map(|v| v - vertices.start as u32 + shift).collect();
            mesh.push_face(&corners, materials[part]);
        }
    }
    // Flat parts need no normals, and what has no size has none.
    let is_round = solid.kind != PrimitiveKind::Cuboid;
    let are_unit = normals.iter().all(|n: &DVec3| n.is_normalized());
    mesh.normals = (is_round && are_unit).then(|| Attribute::per_vertex(normals));
    mesh.uvs = Some(Attribute::per_vertex(uvs));
    mesh
}

/// The point of the picture that a point of a part shows: pictures go once around what is round,
/// once onto each side of a cube, and the disc in their middle onto the ends of what has ends.
fn picture_point(kind: PrimitiveKind, part: usize, u: f64, v: f64) -> DVec2 {
    let (sin, cos) = (TAU * u).sin_cos();
    let (x, y) = match (kind, part) {
        // The part's own u and v, turned to stand upright when seen from outside.
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
