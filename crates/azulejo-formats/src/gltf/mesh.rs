//! Meshes: primitives over shared vertices.

use super::accessor::Data;
use super::attributes::{USED_ATTRIBUTES, VertexRange, used_attributes};
use super::irradiance::StoredIrradiance;
use super::material::{GltfLightmap, GltfSurface, Surfaces};
use super::messages::GltfMessages;
use super::origin::FaceOrigin;
use super::skin::Joints;
use super::topology;
use super::vertices::{Vertices, finish};
use crate::reading::options::{Budget, Exhausted};
use azulejo_scene::Mesh;
use glam::DAffine2;
use gltf_json::Index;
use gltf_json::accessor::Accessor;
use gltf_json::mesh::{Mode, MorphTarget, Primitive};
use gltf_json::validation::Checked;
use std::collections::HashMap;

/// Start of messages about primitives whose data is missing.
pub(super) const LEFT_OUT: &str = "primitive left out: ";

/// Cost of a primitive in elements, for the time it takes, even if it is left out.
const ELEMENTS_PER_PRIMITIVE: u64 = 16;

/// What is needed to read a mesh.
pub(super) struct GltfMeshBuilder<'b, 'a> {
    /// The buffers.
    pub data: &'a Data<'a>,
    /// The materials so far.
    pub surfaces: &'b mut Surfaces<'a>,
    /// How many more elements the file may expand to.
    pub budget: &'b mut Budget,
    /// Collects the warnings.
    pub messages: &'b mut GltfMessages,
    /// How the mesh stores its irradiance, if it has any.
    pub irradiance: Option<StoredIrradiance>,
    /// The lightmap of its node, which comes before those of its materials.
    pub lightmap: Option<GltfLightmap>,
    /// Index of the mesh.
    pub mesh: usize,
    /// Index of the primitive in it.
    pub primitive: usize,
    /// The origin of each face so far, if it is wanted.
    pub origins: Option<Vec<FaceOrigin>>,
}

/// How the node that instantiates a mesh deforms its vertices.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pose<'p> {
    /// Weights of the morph targets.
    pub weights: &'p [f32],
    /// The joints of a skin.
    pub joints: Option<&'p Joints>,
}

/// Everything that the vertices of a primitive depend on: primitives with the same key share
/// their vertices, as in the file.
///
/// Attributes that are not read are not part of it: a hundred thousand of them, in thousands of
/// instances, would otherwise be hashed for each.
#[derive(PartialEq, Eq, Hash)]
struct VertexKey {
    attributes: [Option<u32>; USED_ATTRIBUTES],
    targets: Vec<[Option<u32>; 2]>,
    set: u32,
    picture_from_uv: [u64; 6],
    lightmap: Option<(u32, [u64; 6])>,
}

impl VertexKey {
    fn of(primitive: &Primitive, surface: &GltfSurface) -> VertexKey {
        let number = |i: &Index<Accessor>| i.value() as u32;
        let target = |t: &MorphTarget| {
            [
                t.positions.as_ref().map(number),
                t.normals.as_ref().map(number),
            ]
        };
        let targets = primitive.targets.iter().flatten();
        let bits = |map: DAffine2| map.to_cols_array().map(f64::to_bits);
        VertexKey {
            attributes: used_attributes(primitive, surface).map(|i| i.as_ref().map(number)),
            targets: targets.map(target).collect(),
            set: surface.set,
            picture_from_uv: bits(surface.picture_from_uv),
            lightmap: surface.lightmap.map(|l| (l.set, bits(l.picture_from_uv))),
        }
    }
}

/// Why a primitive is not read.
pub(super) enum Fault {
    /// Only this primitive is left out, for this reason.
    Skipped(String),
    /// The file expands to more vertices and corners than allowed.
    Exhausted(Exhausted),
}

impl From<String> for Fault {
    fn from(fault: String) -> Fault {
        Fault::Skipped(fault)
    }
}

impl From<Exhausted> for Fault {
    fn from(fault: Exhausted) -> Fault {
        Fault::Exhausted(fault)
    }
}

impl GltfMeshBuilder<'_, '_> {
    /// Counts a warning about the current primitive.
    pub fn warn(&mut self, message: &str) {
        let (mesh, primitive) = (self.mesh, self.primitive);
        let place = || format!("meshes[{mesh}].primitives[{primitive}]");
        self.messages.of(message, place);
    }

    /// Reads the mesh in its own coordinates, or in those of the world if it is skinned; `None` if
    /// nothing of it is left.
    ///
    /// # Errors
    /// The file expands to more vertices and corners than allowed.
    pub fn mesh(&mut self, pose: Pose) -> Result<Option<Mesh>, Exhausted> {
        let Some(json) = self.data.root.meshes.get(self.mesh) else {
            return Ok(None);
        };
        let mut mesh = Mesh::default();
        let mut vertices = Vertices::new(self.irradiance);
        let mut vertex_ranges = HashMap::new();
        for (p, primitive) in json.primitives.iter().enumerate() {
            self.primitive = p;
            match self.primitive(
                primitive,
                pose,
                &mut vertices,
                &mut vertex_ranges,
                &mut mesh,
            ) {
                Ok(()) => {}
                Err(Fault::Skipped(message)) => self.warn(&message),
                Err(Fault::Exhausted(exhausted)) => return Err(exhausted),
            }
        }
        if mesh.faces.is_empty() {
            return Ok(None);
        }
        if finish(&mut mesh, vertices) > 0 {
            let index = self.mesh;
            let message = "mesh with vertices without a usable normal: face normals used";
            self.messages.of(message, || format!("meshes[{index}]"));
        }
        if mesh.normals.is_none() {
            mesh.be_flat();
        }
        Ok(Some(mesh))
    }

    /// Adds a primitive to a mesh and its vertices.
    fn primitive(
        &mut self,
        primitive: &Primitive,
        pose: Pose,
        vertices: &mut Vertices,
        vertex_ranges: &mut HashMap<VertexKey, VertexRange>,
        mesh: &mut Mesh,
    ) -> Result<(), Fault> {
        let targets = primitive.targets.as_ref().map_or(0, Vec::len);
        self.budget.spend(ELEMENTS_PER_PRIMITIVE + targets as u64)?;
        // Points and lines have no area.
        let mode = match primitive.mode {
            Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => {
                mode
            }
            Checked::Valid(Mode::Points) => return Err(skipped("points: skipped")),
            _ => return Err(skipped("lines: skipped")),
        };
        // Primitives that refer to the same attributes share their vertices, as in the file.
        let mut surface = (self.surfaces).of(primitive.material, self.lightmap, self.messages);
        let key = VertexKey::of(primitive, &surface);
        let range = match vertex_ranges.get(&key) {
            Some(&known) => known,
            None => {
                let range = self.vertices(primitive, &surface, pose, vertices)?;
                vertex_ranges.insert(key, range);
                range
            }
        };
        // Without its texture coordinates a lightmap cannot be placed.
        if surface.lightmap.is_some() && !range.has_lightmap {
            surface = self.surfaces.without_lightmap(surface);
        }
        // Corners count against the budget even where nothing is kept.
        let VertexRange { first, count, .. } = range;
        let corners = self.corners(primitive, count)?;
        if !self.budget.keeps() {
            return Ok(());
        }
        let triangles = topology::triangles(mode, &corners);
        if triangles.left_over > 0 {
            self.warn("corners that do not form a complete triangle: left out");
        }
        // A face remembers its primitive and triangle if origins are recorded.
        let (origins, number) = (&mut self.origins, self.primitive as u32);
        let outside = triangles.push_into(mesh, vertices, first, count, surface.id, |triangle| {
            if let Some(origins) = origins {
                origins.push(FaceOrigin {
                    primitive: number,
                    triangle,
                });
            }
        });
        if outside > 0 {
            self.warn("triangles with missing vertices: left out");
        }
        Ok(())
    }

    fn corners(&mut self, primitive: &Primitive, vertices: u32) -> Result<Vec<u32>, Fault> {
        let Some(index) = primitive.indices else {
            self.budget.spend(vertices.into())?;
            let kept = if self.budget.keeps() { vertices } else { 0 };
            return Ok((0..kept).collect());
        };
        let count = self.data.count(index).map_err(left_out)?;
        self.budget.spend(count as u64)?;
        if !self.budget.keeps() {
            return Ok(Vec::new());
        }
        Ok(self.data.indices(index, count).map_err(left_out)?)
    }
}

/// The fault of a primitive that is skipped with this message.
pub(super) fn skipped(message: &str) -> Fault {
    Fault::Skipped(message.to_owned())
}

/// The message about a primitive whose data is missing.
pub(super) fn left_out(fault: String) -> String {
    format!("{LEFT_OUT}{fault}")
}
