//! Texture coordinates per corner as coordinates per vertex: a vertex in two charts is copied to the end.
//!
//! Primitives of one list of vertices share the copies. The first vertices stay in their order, so that
//! whatever else counts them still finds them.

use super::super::origin::FaceOrigin;
use super::super::topology;
use super::primitives::Primitive;
use super::source::Source;
use gltf_json::mesh::Mode;
use std::collections::{BTreeMap, HashMap};

/// A list of vertices that gets texture coordinates.
#[derive(Debug, Default)]
pub struct VertexGroup {
    /// The number of vertices before.
    pub count: usize,
    /// Coordinates of the vertices, as far as a face uses them, and then those of the copies.
    pub uvs: Vec<Option<[f32; 2]>>,
    /// Which vertex each copy is of.
    pub sources: Vec<u32>,
    /// Copies by their vertex and the bits of their coordinates.
    copies: HashMap<(u32, [u32; 2]), u32>,
}

/// A primitive whose corners have texture coordinates.
#[derive(Clone, Debug)]
pub struct SplitPrimitive {
    /// Its list of vertices.
    pub group: usize,
    /// The index of its picture.
    pub page: u32,
    /// Its corners, if they changed; then always as a list of triangles. [`MISSING`] for vertices that
    /// there never were.
    pub corners: Option<Vec<u32>>,
}

/// A corner whose vertex does not exist.
pub const MISSING: u32 = u32::MAX;

/// What one primitive of an object receives.
#[derive(Clone, Copy, Debug)]
pub struct PrimitiveFaces<'l> {
    /// Index of the primitive.
    pub primitive: usize,
    /// Its faces.
    pub faces: &'l [FaceOrigin],
    /// The coordinates of their corners.
    pub uvs: &'l [[[f32; 2]; 3]],
    /// The index of its picture.
    pub page: u32,
    /// Whether the faces have their corners in the other order.
    pub mirrored: bool,
}

/// All lists of vertices.
#[derive(Debug, Default)]
pub struct Splits {
    /// The lists.
    pub groups: Vec<VertexGroup>,
    /// The latest list of vertices that other meshes may use, too, by [`Primitive::vertices`].
    open: HashMap<usize, usize>,
}

/// A primitive with the triangles that receive something.
struct MappedFaces<'l> {
    faces: PrimitiveFaces<'l>,
    mode: Mode,
    corners: Vec<u32>,
    count: usize,
}

impl Splits {
    /// Gives the primitives of a mesh their coordinates. `is_shared` says whether they may share vertices
    /// with other meshes, where these use others of them.
    ///
    /// # Errors
    /// Faces that the mesh does not have.
    pub fn add(
        &mut self,
        source: &Source,
        mesh: &[Primitive],
        parts: &[PrimitiveFaces],
        is_shared: bool,
    ) -> Result<Vec<(usize, SplitPrimitive)>, String> {
        let mut users: BTreeMap<usize, Vec<MappedFaces>> = BTreeMap::new();
        for &part in parts {
            let primitive = mesh.get(part.primitive).ok_or("a primitive out of range")?;
            let own = MappedFaces::of(source, primitive, part)?;
            users.entry(primitive.vertices).or_default().push(own);
        }
        let mut list = Vec::new();
        for (vertices, users) in users {
            let open = self.open.get(&vertices).copied().filter(|_| is_shared);
            let is_free = |open: &usize| !users.iter().any(|own| own.meets(&self.groups[*open]));
            let group = open.filter(is_free).unwrap_or_else(|| {
                self.groups.push(VertexGroup::new(users[0].count));
                self.groups.len() - 1
            });
            if is_shared {
                self.open.insert(vertices, group);
            }
            for own in users {
                let split = SplitPrimitive {
                    group,
                    page: own.faces.page,
                    corners: self.groups[group].place(&own)?,
                };
                list.push((own.faces.primitive, split));
            }
        }
        list.sort_by_key(|(primitive, _)| *primitive);
        Ok(list)
    }
}

impl<'l> MappedFaces<'l> {
    fn of(
        source: &Source,
        primitive: &Primitive,
        faces: PrimitiveFaces<'l>,
    ) -> Result<MappedFaces<'l>, String> {
        let mode = primitive
            .mode
            .ok_or("faces of a primitive without triangles")?;
        let count = primitive.count(source)?;
        let corners = primitive.corners(source, count)?;
        let triangles = topology::triangles(mode, &corners).count();
        let is_there = |face: &FaceOrigin| (face.triangle as usize) < triangles;
        if !faces.faces.iter().all(is_there) {
            return Err("a triangle out of range".to_owned());
        }
        let mapped = MappedFaces {
            faces,
            mode,
            corners,
            count,
        };
        if mapped.triangles().flatten().any(|v| v as usize >= count) {
            return Err("a vertex out of range".to_owned());
        }
        Ok(mapped)
    }

    /// The vertices of the faces.
    fn triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        let triangles = topology::triangles(self.mode, &self.corners);
        let faces = self.faces.faces.iter();
        faces.map(move |face| triangles.get(face.triangle as usize))
    }

    /// Whether a list has coordinates for one of the vertices already.
    fn meets(&self, group: &VertexGroup) -> bool {
        let mut vertices = self.triangles().flatten();
        vertices.any(|v| group.uvs[v as usize].is_some())
    }
}

/// Corners in the order of the file, or those of the file in the order of a face.
pub fn turned<T>([a, b, c]: [T; 3], mirrored: bool) -> [T; 3] {
    if mirrored { [a, c, b] } else { [a, b, c] }
}

impl VertexGroup {
    /// A group of `count` vertices, without copies.
    pub fn new(count: usize) -> VertexGroup {
        VertexGroup {
            count,
            uvs: vec![None; count],
            ..VertexGroup::default()
        }
    }

    /// Gives the corners of faces their coordinates; the new corners of the primitive if some changed.
    fn place(&mut self, mapped: &MappedFaces) -> Result<Option<Vec<u32>>, String> {
        let mut changed: Vec<(usize, [u32; 3])> = Vec::new();
        let faces = mapped.faces.faces.iter().zip(mapped.faces.uvs);
        for ((face, uvs), vertices) in faces.zip(mapped.triangles()) {
            let mut placed = vertices;
            for (vertex, uv) in placed.iter_mut().zip(turned(*uvs, mapped.faces.mirrored)) {
                *vertex = self.vertex(*vertex, uv)?;
            }
            if placed != vertices {
                changed.push((face.triangle as usize, placed));
            }
        }
        if changed.is_empty() {
            return Ok(None);
        }
        let triangles = topology::triangles(mapped.mode, &mapped.corners);
        let is_there = |v: &u32| (*v as usize) < mapped.count;
        let there = |v: u32| Some(v).filter(is_there).unwrap_or(MISSING);
        let corners = (0..triangles.count()).flat_map(|i| triangles.get(i).map(there));
        let mut corners: Vec<u32> = corners.collect();
        for (triangle, placed) in changed {
            corners[3 * triangle..][..3].copy_from_slice(&placed);
        }
        Ok(Some(corners))
    }

    /// The vertex with these coordinates: itself, or a copy.
    fn vertex(&mut self, vertex: u32, uv: [f32; 2]) -> Result<u32, String> {
        let bits = uv.map(f32::to_bits);
        let own = self.uvs[vertex as usize].get_or_insert(uv);
        if own.map(f32::to_bits) == bits {
            return Ok(vertex);
        }
        if let Some(&copy) = self.copies.get(&(vertex, bits)) {
            return Ok(copy);
        }
        // The largest index restarts primitives.
        let next = u32::try_from(self.uvs.len()).ok();
        let copy = next
            .filter(|c| *c < u32::MAX - 1)
            .ok_or("too many vertices")?;
        self.sources.push(vertex);
        self.uvs.push(Some(uv));
        self.copies.insert((vertex, bits), copy);
        Ok(copy)
    }
}
