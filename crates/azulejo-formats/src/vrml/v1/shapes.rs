//! Face sets, and the common path of all shapes into the scene.

use super::materials;
use super::node::V1Node;
use super::walk::V1Traversal;
use crate::ReadError;
use crate::vrml::builder::ShapeOutcome;
use crate::vrml::faces::{self, Binding, BoundPool, BuiltFaceSet, FaceSet};
use azulejo_scene::{Attribute, Mesh, Rgb};
use glam::DVec3;
use std::borrow::Cow;

impl<'d> V1Traversal<'d, '_, '_> {
    /// An IndexedFaceSet over the current coordinates.
    pub fn face_set(&mut self, node: &'d V1Node<'d>) -> Result<(), ReadError> {
        let state = self.state;
        let palette = self.palette()?;
        let set = FaceSet {
            positions: state.points,
            coord_index: node.index("coordIndex").unwrap_or(&[]),
            colors: self.bound_colors(&palette, node),
            normals: self.bound_normals(node),
            uvs: (state.texture.is_some() && !state.uvs.is_empty()).then_some(BoundPool {
                values: state.uvs,
                index: node.index("textureCoordIndex"),
                binding: Binding::PerVertexIndexed,
            }),
            ccw: !state.hints.clockwise,
            crease_angle: state.hints.crease_angle,
            drop_unused: true,
        };
        self.builder.spend(set.cost())?;
        let mut built = self.build(node, set);
        for (message, count) in built.problems.messages() {
            self.builder.warn_many(self.source, node.at, message, count);
        }
        self.map_texture(&mut built.mesh);
        self.paint(node, &mut built);
        self.put(node, built.mesh);
        Ok(())
    }

    /// One colour for each of the current materials.
    fn palette(&mut self) -> Result<Cow<'d, [Rgb]>, ReadError> {
        let Some(material) = self.state.material else {
            return Ok(Cow::Borrowed(&[]));
        };
        let count = materials::count(material);
        match material.colors("diffuseColor") {
            Some(diffuse) if diffuse.len() == count => Ok(Cow::Borrowed(diffuse)),
            // Materials that differ in other fields still have to be distinguished.
            diffuse => {
                self.builder.spend(count as u64)?;
                let mut palette = diffuse.unwrap_or_default().to_vec();
                palette.resize(count, palette.last().copied().unwrap_or_default());
                Ok(Cow::Owned(palette))
            }
        }
    }

    /// The current materials bound to the faces or corners of a set; `None` if one holds for the
    /// whole set.
    fn bound_colors<'b>(&self, palette: &'b [Rgb], node: &'b V1Node) -> Option<BoundPool<'b, Rgb>> {
        let binding = self.state.material_binding.of_faces(Binding::Overall);
        (palette.len() > 1 && binding != Binding::Overall).then_some(BoundPool {
            values: palette,
            index: node.index("materialIndex"),
            binding,
        })
    }

    fn bound_normals(&self, node: &'d V1Node<'d>) -> Option<BoundPool<'d, DVec3>> {
        let binding = self
            .state
            .normal_binding
            .of_faces(Binding::PerVertexIndexed);
        (!self.state.normals.is_empty()).then_some(BoundPool {
            values: self.state.normals,
            index: node.index("normalIndex"),
            binding,
        })
    }

    /// Builds the mesh; if there are too few current normals, with computed ones.
    fn build(&mut self, node: &V1Node, set: FaceSet) -> BuiltFaceSet {
        let built = faces::build(&set);
        if built.problems.stray_normals == 0 {
            return built;
        }
        self.warn(
            node,
            "too few normals for a face set: computed from its faces",
        );
        faces::build(&FaceSet {
            normals: None,
            ..set
        })
    }

    /// Applies the current Texture2Transform to the texture coordinates, and generates them for a
    /// texture without any.
    pub fn map_texture(&mut self, mesh: &mut Mesh) {
        let Some(texture) = self.state.texture else {
            return;
        };
        if mesh.uvs.is_none() && self.builder.textures.is_loaded(texture) {
            mesh.uvs = Some(Attribute::per_vertex(faces::box_mapping(&mesh.positions)));
        }
        if let Some(uvs) = &mut mesh.uvs {
            for uv in &mut uvs.values {
                let mapped = self.state.uv_matrix.transform_point2(*uv);
                *uv = if mapped.is_finite() { mapped } else { *uv };
            }
        }
    }

    /// Assigns materials to the faces of a set.
    fn paint(&mut self, node: &V1Node, built: &mut BuiltFaceSet) {
        let mesh = &mut built.mesh;
        let is_open = !self.state.hints.has_inside;
        if built.face_values.is_empty() {
            let material = self.material(0, is_open, !mesh.colors.is_empty());
            mesh.face_materials.fill(material);
            let differ = self
                .state
                .material
                .is_some_and(materials::differ_beyond_diffuse);
            if !mesh.colors.is_empty() && differ {
                self.warn(node, "vertex materials that differ in more than diffuseColor: those of the first are used");
            }
        }
        for (material, &value) in mesh.face_materials.iter_mut().zip(&built.face_values) {
            *material = self.material(value as usize, is_open, false);
        }
    }

    /// Adds a mesh in node coordinates as an object.
    pub fn put(&mut self, node: &V1Node, mesh: Mesh) {
        let (frame, text) = (self.frame(), (self.source, node.at));
        let placed = self
            .builder
            .place_mesh(&frame, node.name.as_deref(), text, mesh);
        match placed {
            ShapeOutcome::Object => {}
            ShapeOutcome::NoFaces => self.warn(node, "shape without faces: skipped"),
            ShapeOutcome::Degenerate => self.warn(
                node,
                "shape with a singular or overflowing transformation: skipped",
            ),
        }
    }
}
