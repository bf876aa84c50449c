//! An object under construction.

use super::transform::InheritedState;
use super::vertices::FltVertex;
use azulejo_scene::math::area_vector;
use azulejo_scene::{Attribute, Faces, MaterialId, Mesh, Rgb};
use glam::{DAffine3, DVec2, DVec3};

/// The faces directly below one node.
#[derive(Debug, Default)]
pub(super) struct FltPart {
    positions: Vec<DVec3>,
    /// Unit length, or zero if the file has none.
    normals: Vec<DVec3>,
    uvs: Vec<DVec2>,
    pub colors: Vec<Rgb>,
    faces: Faces,
    materials: Vec<MaterialId>,
    pub has_uvs: bool,
    /// Unique among parts, and among transforms within a part: see [`VertexSlot`].
    pub stamp: u32,
    place: Option<DAffine3>,
}

/// The vertex of a part that a vertex of the file was converted to, valid if `stamp` is that of the
/// part.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct VertexSlot {
    pub stamp: u32,
    pub vertex: u32,
}

impl FltPart {
    /// Starts a new transform `place`; vertices added with another one are not reused.
    pub fn enter(&mut self, place: &InheritedState, stamps: &mut u32) {
        if self.place != Some(place.world) {
            self.place = Some(place.world);
            *stamps += 1;
            self.stamp = *stamps;
        }
    }

    /// Adds a vertex; `None` if its world position is not finite.
    pub fn add_vertex(
        &mut self,
        vertex: &FltVertex,
        color: Rgb,
        place: &InheritedState,
    ) -> Option<u32> {
        let position = place.world.transform_point3(vertex.position);
        if !position.is_finite() {
            return None;
        }
        let normal = vertex
            .normal
            .and_then(|n| (place.normals * n).try_normalize());
        self.positions.push(position);
        self.normals.push(normal.unwrap_or_default());
        self.uvs.push(vertex.uv.unwrap_or_default());
        self.colors.push(color);
        self.has_uvs |= vertex.uv.is_some();
        Some((self.positions.len() - 1) as u32)
    }

    /// Adds a face of three or more corners.
    pub fn add_face(&mut self, corners: &mut [u32], material: MaterialId, place: &InheritedState) {
        if place.mirrored {
            corners[1..].reverse();
        }
        self.faces.push(corners);
        self.materials.push(material);
    }

    /// The mesh, if there are faces.
    pub fn finish(self) -> Option<Mesh> {
        if self.faces.is_empty() {
            return None;
        }
        let is_white = self.colors.iter().all(|c| *c == Rgb::WHITE);
        let mut mesh = Mesh {
            positions: self.positions,
            uvs: self.has_uvs.then(|| Attribute::per_vertex(self.uvs)),
            colors: if is_white { Vec::new() } else { self.colors },
            faces: self.faces,
            face_materials: self.materials,
            ..Mesh::default()
        };
        mesh.normals = normals(&mesh, self.normals);
        Some(mesh)
    }
}

/// The normals of vertices; the face normal for vertices without one.
fn normals(mesh: &Mesh, mut values: Vec<DVec3>) -> Option<Attribute<DVec3>> {
    let missing = values.iter().filter(|n| **n == DVec3::ZERO).count();
    if missing == 0 {
        return Some(Attribute::per_vertex(values));
    }
    if missing == values.len() {
        return None;
    }
    let mut corners = mesh.faces.corners.clone();
    for face in 0..mesh.faces.len() {
        let own = &mut corners[mesh.faces.corner_range(face)];
        if own.iter().all(|&v| values[v as usize] != DVec3::ZERO) {
            continue;
        }
        // A face without area is not visible; any unit vector will do.
        let flat = area_vector(&mesh.face_positions(face)).normalize_or(DVec3::Z);
        values.push(flat);
        let last = (values.len() - 1) as u32;
        let bare = own
            .iter_mut()
            .filter(|v| values[**v as usize] == DVec3::ZERO);
        bare.for_each(|v| *v = last);
    }
    // Unused normals must be unit vectors, too.
    let unused = values.iter_mut().filter(|n| **n == DVec3::ZERO);
    unused.for_each(|n| *n = DVec3::Z);
    Some(Attribute {
        values,
        corners: Some(corners),
    })
}
