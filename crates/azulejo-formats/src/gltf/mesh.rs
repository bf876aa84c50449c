//! Meshes: primitives over vertices that they share.

use super::accessor::Data;
use super::irradiance;
use super::material::{Surface, Surfaces};
use super::said::Said;
use super::skin::Joints;
use super::topology;
use super::vertices::{Vertices, finish};
use crate::options::{Budget, Exhausted};
use azulejo_scene::{Attribute, Mesh, Rgb};
use glam::{DVec2, DVec3};
use gltf_json::accessor::Accessor;
use gltf_json::mesh::{Mode, MorphTarget, Primitive, Semantic};
use gltf_json::validation::Checked;
use gltf_json::{Index, Root};
use std::collections::{BTreeMap, HashMap};

/// How messages about primitives begin whose numbers are not there.
pub(super) const LOST: &str = "primitive left out: ";

type Attributes = BTreeMap<Checked<Semantic>, Index<Accessor>>;

/// What a mesh is read with.
pub(super) struct Builder<'b, 'a> {
    /// The numbers.
    pub data: &'a Data<'a>,
    /// The materials so far.
    pub surfaces: &'b mut Surfaces<'a>,
    /// What the file may still unfold to.
    pub budget: &'b mut Budget,
    /// Where losses are counted.
    pub said: &'b mut Said,
}

/// How the node that places a mesh changes its vertices.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pose<'p> {
    /// Weights of the morph targets.
    pub weights: &'p [f32],
    /// The joints that carry the vertices, for a skin.
    pub joints: Option<&'p Joints>,
}

/// Everything on which the vertices of a primitive depend: primitives that agree in it share
/// them, as they share them in the file.
#[derive(PartialEq, Eq, Hash)]
struct Pool<'a> {
    attributes: &'a Attributes,
    targets: Vec<[Option<u32>; 2]>,
    set: u32,
    picture_from_uv: [u64; 6],
}

impl<'a> Pool<'a> {
    fn of(primitive: &'a Primitive, surface: &Surface) -> Pool<'a> {
        let number = |i: &Index<Accessor>| i.value() as u32;
        let target = |t: &MorphTarget| {
            [
                t.positions.as_ref().map(number),
                t.normals.as_ref().map(number),
            ]
        };
        let targets = primitive.targets.iter().flatten();
        Pool {
            attributes: &primitive.attributes,
            targets: targets.map(target).collect(),
            set: surface.set,
            picture_from_uv: surface.picture_from_uv.to_cols_array().map(f64::to_bits),
        }
    }
}

/// Why a primitive is not read: it alone, or the whole file.
enum Fault {
    Skipped(String),
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

impl<'a> Builder<'_, 'a> {
    fn root(&self) -> &'a Root {
        self.data.root
    }

    /// Reads a mesh in its own coordinates, or in the world's if it hangs on joints; `None` if
    /// nothing of it is left.
    ///
    /// # Errors
    /// More vertices and corners than the file may unfold to.
    pub fn mesh(&mut self, index: usize, pose: Pose) -> Result<Option<Mesh>, Exhausted> {
        let Some(json) = self.root().meshes.get(index) else {
            return Ok(None);
        };
        let mut mesh = Mesh::default();
        let mut vertices = Vertices::new(irradiance::of(json));
        let mut pools = HashMap::new();
        for (p, primitive) in json.primitives.iter().enumerate() {
            let place = || format!("meshes[{index}].primitives[{p}]");
            let read = self.primitive(primitive, pose, &mut vertices, &mut pools, &mut mesh);
            match read {
                Ok(outside) if outside > 0 => {
                    let message = "triangles without all of their vertices: left out";
                    self.said.of(message, place);
                }
                Ok(_) => {}
                Err(Fault::Skipped(message)) => self.said.of(&message, place),
                Err(Fault::Exhausted(exhausted)) => return Err(exhausted),
            }
        }
        if mesh.faces.is_empty() {
            return Ok(None);
        }
        let mended = finish(&mut mesh, vertices);
        if mended > 0 {
            let message = "mesh with vertices without a usable normal: their faces' own";
            self.said.of(message, || format!("meshes[{index}]"));
        }
        Ok(Some(mesh))
    }

    /// Reads a primitive, and says how many of its triangles had no vertices.
    fn primitive(
        &mut self,
        primitive: &'a Primitive,
        pose: Pose,
        vertices: &mut Vertices,
        pools: &mut HashMap<Pool<'a>, (u32, u32)>,
        mesh: &mut Mesh,
    ) -> Result<usize, Fault> {
        let mode = match primitive.mode {
            Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => {
                mode
            }
            Checked::Valid(Mode::Points) => return Err(skipped("points: skipped")),
            _ => return Err(skipped("lines: skipped")),
        };
        let surface = self.surfaces.of(primitive.material, self.said);
        let pool = Pool::of(primitive, &surface);
        let (first, count) = match pools.get(&pool) {
            Some(&known) => known,
            None => {
                let range = self.vertices(primitive, &surface, pose, vertices)?;
                pools.insert(pool, range);
                range
            }
        };
        let corners = self.corners(primitive, count)?;
        let triangles = topology::triangles(mode, &corners);
        if triangles.left_over > 0 {
            let message = "corners that make no whole triangle: left out";
            self.said.whole(message);
        }
        Ok(triangles.push_into(mesh, vertices, first, count, surface.id))
    }

    fn corners(&mut self, primitive: &Primitive, vertices: u32) -> Result<Vec<u32>, Fault> {
        let Some(index) = primitive.indices else {
            self.budget.spend(vertices.into())?;
            return Ok((0..vertices).collect());
        };
        let count = self.data.count(index).map_err(lost)?;
        self.budget.spend(count as u64)?;
        Ok(self.data.indices(index, count).map_err(lost)?)
    }

    /// Adds the vertices of a primitive, and says which they are: the first and how many.
    fn vertices(
        &mut self,
        primitive: &Primitive,
        surface: &Surface,
        pose: Pose,
        vertices: &mut Vertices,
    ) -> Result<(u32, u32), Fault> {
        let attribute = |s: Semantic| primitive.attributes.get(&Checked::Valid(s)).copied();
        let positions = attribute(Semantic::Positions);
        let positions = positions.ok_or_else(|| skipped("primitive without positions: skipped"))?;
        let count = self.data.count(positions).map_err(lost)?;
        self.budget.spend(count as u64)?;
        let end = vertices.len() as u64 + count as u64;
        if end >= u64::from(u32::MAX) {
            return Err(skipped("mesh of more than 4 billion vertices: skipped"));
        }
        let data = self.data;
        let mut added = Vertices::new(vertices.irradiance);
        added.positions = data.read(positions, count, DVec3::from).map_err(lost)?;
        if let Some(normals) = attribute(Semantic::Normals) {
            let read = data.read(normals, count, DVec3::from);
            added.normals = self.optional(read, "normals");
        }
        self.morph(primitive, pose.weights, &mut added)?;
        self.pose(primitive, pose.joints, &mut added);
        if let Some(uvs) = attribute(Semantic::TexCoords(surface.set)) {
            let read = data.read(uvs, count, |uv| uv_of(surface, uv));
            added.uvs = self.optional(read, "texture coordinates");
        } else if surface.is_textured {
            self.said
                .whole("textured primitive without texture coordinates");
        }
        for set in [0, 1] {
            if let Some(colors) = attribute(Semantic::Colors(set)) {
                let read = self.colors(colors, count);
                let values = self.optional(read, "colours");
                added.set_colors(set, values);
            }
        }
        added.make_usable();
        let first = vertices.len() as u32;
        vertices.append(added);
        Ok((first, count as u32))
    }

    /// An attribute that a mesh can do without.
    fn optional<T>(&mut self, read: Result<Vec<T>, String>, what: &str) -> Vec<T> {
        read.unwrap_or_else(|fault| {
            self.said.whole(&format!("{what} left out: {fault}"));
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
                    Err(fault) => self.said.whole(&format!("morph target left out: {fault}")),
                }
            }
        }
        Ok(())
    }

    /// Puts the vertices where their joints are.
    fn pose(&mut self, primitive: &Primitive, joints: Option<&Joints>, vertices: &mut Vertices) {
        let Some(joints) = joints else { return };
        let attribute = |s: Semantic| primitive.attributes.get(&Checked::Valid(s)).copied();
        let count = vertices.len();
        let mut influences = Vec::new();
        for set in 0..2 {
            let of_set = (
                attribute(Semantic::Joints(set)),
                attribute(Semantic::Weights(set)),
            );
            let (Some(indices), Some(weights)) = of_set else {
                continue;
            };
            let read = self
                .data
                .read(indices, count, |j: [f64; 4]| j)
                .and_then(|indices| {
                    let weights = self.data.read(weights, count, |w: [f64; 4]| w)?;
                    Ok((indices, weights))
                });
            match read {
                Ok(read) => influences.push(read),
                Err(fault) => self.said.whole(&format!("joints left out: {fault}")),
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
                *normal = azulejo_scene::math::normal_matrix(map.matrix3) * *normal;
            }
        }
    }
}

fn skipped(message: &str) -> Fault {
    Fault::Skipped(message.to_owned())
}

/// A primitive whose numbers are not there.
fn lost(fault: String) -> String {
    format!("{LOST}{fault}")
}

/// Texture coordinates as azulejo has them, with v upwards.
fn uv_of(surface: &Surface, uv: [f64; 2]) -> DVec2 {
    let uv = surface.picture_from_uv.transform_point2(uv.into());
    DVec2::new(uv.x, 1.0 - uv.y)
}

/// Values per vertex, if there are any.
pub(super) fn per_vertex<T: Copy>(values: Vec<T>) -> Option<Attribute<T>> {
    (!values.is_empty()).then(|| Attribute::per_vertex(values))
}
