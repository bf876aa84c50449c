//! Texture coordinates per corner as coordinates per vertex: a vertex in two charts is copied to the end.
//!
//! Primitives of one list of vertices share the copies. The first vertices stay in their order, so that
//! whatever else counts them still finds them.

use super::super::origin::FaceOrigin;
use super::super::topology;
use super::primitives::PrimitiveJson;
use super::source::Source;
use gltf_json::mesh::Mode;
use std::collections::HashMap;

/// A list of vertices that gets texture coordinates.
#[derive(Debug, Default)]
pub struct VertexGroup {
    /// Coordinates of the vertices, as far as a face uses them.
    pub uvs: Vec<[f32; 2]>,
    has_uv: Vec<bool>,
    /// Which vertex each copy is of.
    pub sources: Vec<u32>,
    /// The coordinates of the copies.
    pub more_uvs: Vec<[f32; 2]>,
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
pub struct Splits<'t> {
    /// The lists.
    pub groups: Vec<VertexGroup>,
    /// The latest list of the vertices of these attributes that other meshes may use, too.
    open: HashMap<(&'t str, &'t str), usize>,
}

/// A primitive with the triangles that receive something.
struct Wanted<'l> {
    faces: PrimitiveFaces<'l>,
    mode: Mode,
    corners: Vec<u32>,
    count: usize,
}

impl<'t> Splits<'t> {
    /// Gives the primitives of a mesh their coordinates. `is_shared` says whether they may share vertices
    /// with other meshes, where these use others of them.
    ///
    /// # Errors
    /// Faces that the mesh does not have.
    pub fn add(
        &mut self,
        source: &Source,
        mesh: &[PrimitiveJson<'t>],
        parts: &[PrimitiveFaces],
        is_shared: bool,
    ) -> Result<Vec<(usize, SplitPrimitive)>, String> {
        let mut wanted = Vec::new();
        let mut users: HashMap<(&str, &str), Vec<usize>> = HashMap::new();
        for &part in parts {
            let primitive = mesh.get(part.primitive).ok_or("a primitive out of range")?;
            users.entry(primitive.key).or_default().push(wanted.len());
            wanted.push((primitive.key, Wanted::of(source, primitive, part)?));
        }
        let mut chosen: HashMap<(&str, &str), usize> = HashMap::new();
        let mut list = Vec::new();
        for (key, own) in &wanted {
            let group = match chosen.get(key) {
                Some(&group) => group,
                None => {
                    let users = users.get(key).into_iter().flatten();
                    let users = users.filter_map(|user| Some(&wanted.get(*user)?.1));
                    let group = self.group(*key, own.count, users, is_shared);
                    chosen.insert(*key, group);
                    group
                }
            };
            let split = SplitPrimitive {
                group,
                page: own.faces.page,
                corners: self.groups[group].place(own)?,
            };
            list.push((own.faces.primitive, split));
        }
        Ok(list)
    }

    /// The list for vertices of these attributes, of which some are used.
    fn group<'w, 'l: 'w>(
        &mut self,
        key: (&'t str, &'t str),
        count: usize,
        mut users: impl Iterator<Item = &'w Wanted<'l>>,
        is_shared: bool,
    ) -> usize {
        let open = self.open.get(&key).copied().filter(|_| is_shared);
        if let Some(open) = open
            && users.all(|wanted| !wanted.meets(&self.groups[open]))
        {
            return open;
        }
        self.groups.push(VertexGroup::new(count));
        let new = self.groups.len() - 1;
        if is_shared {
            self.open.insert(key, new);
        }
        new
    }
}

impl<'l> Wanted<'l> {
    fn of(
        source: &Source,
        primitive: &PrimitiveJson,
        faces: PrimitiveFaces<'l>,
    ) -> Result<Wanted<'l>, String> {
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
        let wanted = Wanted {
            faces,
            mode,
            corners,
            count,
        };
        if wanted.triangles().flatten().any(|v| v as usize >= count) {
            return Err("a vertex out of range".to_owned());
        }
        Ok(wanted)
    }

    /// The vertices of the faces.
    fn triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        let all = topology::triangles(self.mode, &self.corners);
        let faces = self.faces.faces.iter();
        faces.map(move |face| all.get(face.triangle as usize))
    }

    /// Whether a list has coordinates for one of the vertices already.
    fn meets(&self, group: &VertexGroup) -> bool {
        self.triangles().flatten().any(|v| group.has_uv[v as usize])
    }
}

impl VertexGroup {
    /// So many vertices, without copies.
    pub fn new(count: usize) -> VertexGroup {
        VertexGroup {
            uvs: vec![[0.0; 2]; count],
            has_uv: vec![false; count],
            ..VertexGroup::default()
        }
    }

    /// The number of vertices before and after.
    pub fn counts(&self) -> [usize; 2] {
        [self.uvs.len(), self.uvs.len() + self.sources.len()]
    }

    /// Gives the corners of faces their coordinates; the new corners of the primitive if some changed.
    fn place(&mut self, wanted: &Wanted) -> Result<Option<Vec<u32>>, String> {
        let mut changed: Vec<(usize, [u32; 3])> = Vec::new();
        let faces = wanted.faces.faces.iter().zip(wanted.faces.uvs);
        for ((face, uvs), vertices) in faces.zip(wanted.triangles()) {
            let [a, b, c] = *uvs;
            let uvs = if wanted.faces.mirrored {
                [a, c, b]
            } else {
                [a, b, c]
            };
            let mut placed = vertices;
            for (vertex, uv) in placed.iter_mut().zip(uvs) {
                *vertex = self.vertex(*vertex, uv)?;
            }
            if placed != vertices {
                changed.push((face.triangle as usize, placed));
            }
        }
        if changed.is_empty() {
            return Ok(None);
        }
        let all = topology::triangles(wanted.mode, &wanted.corners);
        let there = |v: u32| {
            if (v as usize) < wanted.count {
                v
            } else {
                MISSING
            }
        };
        let corners = (0..all.count()).flat_map(|i| all.get(i).map(there));
        let mut corners: Vec<u32> = corners.collect();
        for (triangle, placed) in changed {
            corners[3 * triangle..][..3].copy_from_slice(&placed);
        }
        Ok(Some(corners))
    }

    /// The vertex with these coordinates: itself, or a copy.
    fn vertex(&mut self, vertex: u32, uv: [f32; 2]) -> Result<u32, String> {
        let own = vertex as usize;
        if !self.has_uv[own] {
            self.has_uv[own] = true;
            self.uvs[own] = uv;
        }
        let bits = uv.map(f32::to_bits);
        if self.uvs[own].map(f32::to_bits) == bits {
            return Ok(vertex);
        }
        if let Some(&copy) = self.copies.get(&(vertex, bits)) {
            return Ok(copy);
        }
        let copy = u32::try_from(self.uvs.len() + self.sources.len());
        // The largest index restarts primitives.
        let copy = copy
            .ok()
            .filter(|c| *c < u32::MAX - 1)
            .ok_or("too many vertices")?;
        self.sources.push(vertex);
        self.more_uvs.push(uv);
        self.copies.insert((vertex, bits), copy);
        Ok(copy)
    }
}
