//! Cube, Sphere, Cylinder and Cone: exact, unless they are open, have several materials, are
//! flattened or textured.

use super::node::{V1Node, V1NodeKind};
use super::walk::V1Traversal;
use crate::ReadError;
use crate::vrml::builder::ShapeOutcome;
use crate::vrml::solid::PlacedPrimitive;
use azulejo_scene::MaterialId;

/// The primitive of a node, and for each of its parts the index in VRML, which orders materials.
fn solid_of(node: &V1Node) -> (PlacedPrimitive, &'static [usize]) {
    let length = |field, default| node.number(field, default).abs();
    let words = node.words("parts");
    let has = |name: &str| words.is_empty() || words.iter().any(|w| w == name || w == "ALL");
    match node.kind {
        V1NodeKind::Sphere => (PlacedPrimitive::sphere(length("radius", 1.0)), &[0]),
        V1NodeKind::Cylinder => {
            let (radius, height) = (length("radius", 1.0), length("height", 2.0));
            let solid =
                PlacedPrimitive::cylinder(radius, height, has("SIDES"), has("BOTTOM"), has("TOP"));
            (solid, &[0, 2, 1])
        }
        V1NodeKind::Cone => {
            let (radius, height) = (length("bottomRadius", 1.0), length("height", 2.0));
            let solid = PlacedPrimitive::cone(radius, height, has("SIDES"), has("BOTTOM"));
            (solid, &[0, 1])
        }
        _ => {
            let size = ["width", "height", "depth"].map(|side| length(side, 2.0));
            // VRML's order is front, back, left, right, top, bottom.
            (PlacedPrimitive::cuboid(size.into()), &[2, 3, 5, 4, 1, 0])
        }
    }
}

impl<'d> V1Traversal<'d, '_, '_> {
    /// A Cube, Sphere, Cylinder or Cone.
    pub fn solid(&mut self, node: &'d V1Node<'d>) -> Result<(), ReadError> {
        let (solid, numbers) = solid_of(node);
        let is_open = !solid.is_closed();
        let materials = self.part_materials(numbers, is_open);
        let is_one = materials.iter().all(|m| *m == materials[0]);
        let texture = self.state.texture;
        let is_textured = texture.is_some_and(|t| self.builder.textures.is_loaded(t));
        if !is_open && is_one && !is_textured {
            let (frame, name) = (self.frame(), node.name.as_deref());
            let (kind, map) = (solid.kind, solid.object_from_unit);
            let placed = self
                .builder
                .place_primitive(&frame, name, kind, map, materials[0]);
            if placed == ShapeOutcome::Object {
                return Ok(());
            }
        }
        let Some(mut mesh) = self.builder.polygons(&solid, &materials)? else {
            return Ok(());
        };
        if is_textured {
            self.map_texture(&mut mesh)
        } else {
            mesh.uvs = None
        }
        self.put(node, mesh);
        Ok(())
    }

    /// The material of each part.
    fn part_materials(&mut self, numbers: &[usize], is_open: bool) -> Vec<MaterialId> {
        let per_part = self.state.material_binding.is_per_part();
        let number = |&number: &usize| if per_part { number } else { 0 };
        let numbers = numbers.iter().map(number);
        numbers
            .map(|number| self.material(number, is_open, false))
            .collect()
    }
}
