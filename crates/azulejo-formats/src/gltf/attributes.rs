//! Vertices of one primitive: its attributes, deformed by morph targets and joints.

use super::material::{GltfCoordinates, GltfSurface};
use super::mesh::{Fault, GltfMeshBuilder, Pose, left_out, skipped};
use super::skin::Joints;
use super::vertices::Vertices;
use crate::reading::options::Exhausted;
use azulejo_scene::Rgb;
use azulejo_scene::math::normal_matrix;
use glam::{DVec2, DVec3};
use gltf_json::Index;
use gltf_json::accessor::Accessor;
use gltf_json::mesh::{Primitive, Semantic};
use gltf_json::validation::Checked;

/// For every vertex, four joints and their weights.
type Influences = (Vec<[f64; 4]>, Vec<[f64; 4]>);

/// Where the vertices of a primitive are.
#[derive(Clone, Copy, Debug)]
pub(super) struct VertexRange {
    /// Index of the first.
    pub first: u32,
    /// Their number.
    pub count: u32,
    /// Whether they have coordinates of a lightmap.
    pub has_lightmap: bool,
}

fn attribute(primitive: &Primitive, semantic: Semantic) -> Option<Index<Accessor>> {
    primitive.attributes.get(&Checked::Valid(semantic)).copied()
}

/// Attributes that vertices are read from.
pub(super) const USED_ATTRIBUTES: usize = 10;

/// The accessors of the attributes that vertices are read from, under this material.
pub(super) fn used_attributes(
    primitive: &Primitive,
    surface: &GltfSurface,
) -> [Option<Index<Accessor>>; USED_ATTRIBUTES] {
    use Semantic::{Colors, Joints, Normals, Positions, TexCoords, Weights};
    let lightmap = surface.lightmap.map(|l| TexCoords(l.set));
    [
        Positions,
        Normals,
        // Positions stand in for absent attributes.
        lightmap.unwrap_or(Positions),
        TexCoords(surface.set),
        Colors(0),
        Colors(1),
        Joints(0),
        Joints(1),
        Weights(0),
        Weights(1),
    ]
    .map(|semantic| attribute(primitive, semantic))
}

impl GltfMeshBuilder<'_, '_> {
    /// Adds the vertices of a primitive, and returns where they are.
    pub fn vertices(
        &mut self,
        primitive: &Primitive,
        surface: &GltfSurface,
        pose: Pose,
        vertices: &mut Vertices,
    ) -> Result<VertexRange, Fault> {
        let positions = attribute(primitive, Semantic::Positions);
        let positions = positions.ok_or_else(|| skipped("primitive without positions: skipped"))?;
        let count = self.data.count(positions).map_err(left_out)?;
        self.budget.spend(count as u64)?;
        let end = vertices.len() as u64 + count as u64;
        if end >= u64::from(u32::MAX) {
            return Err(skipped("mesh of more than 4 billion vertices: skipped"));
        }
        if !self.budget.keeps() {
            return Ok(VertexRange {
                first: 0,
                count: count as u32,
                has_lightmap: false,
            });
        }
        let mut added = Vertices::new(vertices.irradiance);
        let read = self.data.read(positions, count, DVec3::from);
        added.positions = read.map_err(left_out)?;
        if let Some(normals) = attribute(primitive, Semantic::Normals) {
            let read = self.data.read(normals, count, DVec3::from);
            added.normals = self.optional(read, "normals");
        }
        self.morph(primitive, pose.weights, &mut added)?;
        if let Some(joints) = pose.joints {
            self.apply_joints(primitive, joints, &mut added);
        }
        self.colours(primitive, surface, &mut added);
        added.make_usable();
        let range = VertexRange {
            first: vertices.len() as u32,
            count: count as u32,
            has_lightmap: !added.lightmap_uvs.is_empty(),
        };
        vertices.append(added);
        Ok(range)
    }

    /// Reads the attributes that colour vertices: texture coordinates, colours, irradiance.
    fn colours(&mut self, primitive: &Primitive, surface: &GltfSurface, vertices: &mut Vertices) {
        let count = vertices.len();
        if let Some(uvs) = attribute(primitive, Semantic::TexCoords(surface.set)) {
            let coordinates = GltfCoordinates {
                set: surface.set,
                picture_from_uv: surface.picture_from_uv,
            };
            let read = self.data.read(uvs, count, |uv| coordinates.uv_of(uv));
            vertices.uvs = self.optional(read, "texture coordinates");
        } else if surface.is_textured {
            self.warn("textured primitive without texture coordinates");
        }
        if let Some(lightmap) = surface.lightmap {
            vertices.lightmap_uvs = self.lightmap_uvs(primitive, lightmap, count);
        }
        for set in [0, 1] {
            if let Some(colors) = attribute(primitive, Semantic::Colors(set)) {
                let read = self.colors(colors, count);
                let values = self.optional(read, "colours");
                vertices.set_colors(set, values);
            }
        }
    }

    /// The coordinates of a lightmap; none, with a warning, if the primitive does not have them.
    fn lightmap_uvs(
        &mut self,
        primitive: &Primitive,
        lightmap: GltfCoordinates,
        count: usize,
    ) -> Vec<DVec2> {
        let set = lightmap.set;
        let Some(uvs) = attribute(primitive, Semantic::TexCoords(set)) else {
            self.warn(&format!(
                "lightmap of a primitive without TEXCOORD_{set}: not used"
            ));
            return Vec::new();
        };
        let read = self.data.read(uvs, count, |uv| lightmap.uv_of(uv));
        self.optional(read, "lightmap")
    }

    /// An optional attribute; a fault is a warning.
    fn optional<T>(&mut self, read: Result<Vec<T>, String>, what: &str) -> Vec<T> {
        read.unwrap_or_else(|fault| {
            self.warn(&format!("{what} left out: {fault}"));
            Vec::new()
        })
    }

    fn colors(&self, index: Index<Accessor>, count: usize) -> Result<Vec<Rgb>, String> {
        let data = self.data;
        match data.width(index)? {
            4 => data.read(index, count, |[r, g, b, _]: [f64; 4]| Rgb::new(r, g, b)),
            _ => data.read(index, count, Rgb::from),
        }
    }

    /// Adds the morph targets by their weights.
    fn morph(
        &mut self,
        primitive: &Primitive,
        weights: &[f32],
        vertices: &mut Vertices,
    ) -> Result<(), Exhausted> {
        let targets = primitive.targets.iter().flatten();
        for (target, &weight) in targets.zip(weights).filter(|(_, w)| **w != 0.0) {
            let lists = [
                (target.positions, &mut vertices.positions),
                (target.normals, &mut vertices.normals),
            ];
            for (index, list) in lists {
                let Some(index) = index.filter(|_| !list.is_empty()) else {
                    continue;
                };
                self.budget.spend(list.len() as u64)?;
                match self.data.read(index, list.len(), DVec3::from) {
                    Ok(deltas) => {
                        let moved = list.iter_mut().zip(deltas);
                        moved.for_each(|(v, d)| *v += f64::from(weight) * d);
                    }
                    Err(fault) => self.warn(&format!("morph target left out: {fault}")),
                }
            }
        }
        Ok(())
    }

    /// Transforms the vertices by their joints.
    fn apply_joints(&mut self, primitive: &Primitive, joints: &Joints, vertices: &mut Vertices) {
        let count = vertices.len();
        let mut influences = Vec::new();
        for set in 0..2 {
            let indices = attribute(primitive, Semantic::Joints(set));
            let weights = attribute(primitive, Semantic::Weights(set));
            let Some((indices, weights)) = indices.zip(weights) else {
                continue;
            };
            match self.influences(indices, weights, count) {
                Ok(read) => influences.push(read),
                Err(fault) => self.warn(&format!("joints left out: {fault}")),
            }
        }
        for vertex in 0..count {
            let each = influences
                .iter()
                .flat_map(|(indices, weights)| std::iter::zip(indices[vertex], weights[vertex]));
            let map = joints.blend(each);
            let position = &mut vertices.positions[vertex];
            *position = map.transform_point3(*position);
            if let Some(normal) = vertices.normals.get_mut(vertex) {
                *normal = normal_matrix(map.matrix3) * *normal;
            }
        }
    }

    fn influences(
        &self,
        indices: Index<Accessor>,
        weights: Index<Accessor>,
        count: usize,
    ) -> Result<Influences, String> {
        let same = |numbers: [f64; 4]| numbers;
        Ok((
            self.data.read(indices, count, same)?,
            self.data.read(weights, count, same)?,
        ))
    }
}
