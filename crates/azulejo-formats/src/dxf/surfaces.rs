//! The surfaces of a block: one mesh per layer, in the block's coordinates.

use super::ids::{AppearanceId, LayerId};
use azulejo_scene::Mesh;
use azulejo_scene::math::area_vector;
use glam::DVec3;
use std::collections::HashMap;

/// The meshes of a block.
#[derive(Debug, Default)]
pub(super) struct Surfaces {
    /// In the order in which layers are first used.
    pub meshes: Vec<LayerMesh>,
    by_layer: HashMap<LayerId, usize>,
}

/// The surfaces on one layer.
#[derive(Debug)]
pub(super) struct LayerMesh {
    /// The layer.
    pub layer: LayerId,
    /// Its faces, with appearances in place of materials.
    pub mesh: Mesh,
    /// The last smoothing group given to a curved surface.
    last_group: u32,
}

impl Surfaces {
    /// The mesh of a layer.
    pub fn on(&mut self, layer: LayerId) -> &mut LayerMesh {
        // Consecutive entities mostly share a layer.
        let at = match self.meshes.last() {
            Some(last) if last.layer == layer => self.meshes.len() - 1,
            _ => self.index(layer),
        };
        &mut self.meshes[at]
    }

    fn index(&mut self, layer: LayerId) -> usize {
        let next = self.meshes.len();
        let at = *self.by_layer.entry(layer).or_insert(next);
        if at == next {
            self.meshes.push(LayerMesh {
                layer,
                mesh: Mesh::default(),
                last_group: 0,
            });
        }
        at
    }
}

impl LayerMesh {
    /// Adds vertices and returns the index of the first.
    pub fn vertices(&mut self, positions: impl IntoIterator<Item = DVec3>) -> u32 {
        let first = self.mesh.positions.len() as u32;
        self.mesh.positions.extend(positions);
        first
    }

    /// Adds a flat face.
    #[inline]
    pub fn face(&mut self, corners: &[u32], appearance: AppearanceId) {
        self.smooth_face(corners, appearance, 0);
    }

    /// Adds a face of a smooth surface; group 0 is flat.
    #[inline]
    pub fn smooth_face(&mut self, corners: &[u32], appearance: AppearanceId, group: u32) {
        let before = self.mesh.faces.len();
        self.mesh.push_face(corners, appearance);
        // Most meshes have no smooth faces and no groups.
        if group != 0 || !self.mesh.smoothing.is_empty() {
            self.mesh.smoothing.resize(before, 0);
            self.mesh.smoothing.push(group);
        }
    }

    /// A new smoothing group for a curved surface.
    pub fn new_group(&mut self) -> u32 {
        self.last_group += 1;
        self.last_group
    }

    /// Adds the surface that a polyline sweeps along `offset`. `groups` yields the smoothing group of
    /// the segment after each point. A closed line faces outside.
    pub fn wall(
        &mut self,
        line: &LineString,
        offset: DVec3,
        appearance: AppearanceId,
        groups: impl Fn(usize) -> u32,
    ) {
        let points = &line.points;
        let inside_out = line.is_closed && area_vector(points).dot(offset) < 0.0;
        let low = self.vertices(points.iter().flat_map(|&p| [p, p + offset]));
        let count = points.len() as u32;
        for part in 0..line.parts() as u32 {
            let (a, b) = (low + 2 * part, low + 2 * ((part + 1) % count));
            let corners = if inside_out {
                [b, a, a + 1, b + 1]
            } else {
                [a, b, b + 1, a + 1]
            };
            self.smooth_face(&corners, appearance, groups(part as usize));
        }
    }

    /// Adds a flat polygon that faces along `up`, as near as its plane allows.
    pub fn polygon(&mut self, points: &[DVec3], up: DVec3, appearance: AppearanceId) {
        let first = self.vertices(points.iter().copied());
        self.polygon_of(first, 1, points, up, appearance);
    }

    /// A polygon of existing vertices, each `step` after the previous one.
    fn polygon_of(
        &mut self,
        first: u32,
        step: u32,
        points: &[DVec3],
        up: DVec3,
        appearance: AppearanceId,
    ) {
        let mut corners: Vec<u32> = (0..points.len() as u32).map(|i| first + step * i).collect();
        if area_vector(points).dot(up) < 0.0 {
            corners.reverse();
        }
        self.face(&corners, appearance);
    }

    /// Adds the closed solid that a polygon sweeps along `offset`, with the smoothing group of
    /// its side.
    pub fn prism(
        &mut self,
        outline: &LineString,
        offset: DVec3,
        appearance: AppearanceId,
        group: u32,
    ) {
        let first = self.mesh.positions.len() as u32;
        self.wall(outline, offset, appearance, |_| group);
        self.polygon_of(first, 2, &outline.points, -offset, appearance);
        self.polygon_of(first + 1, 2, &outline.points, offset, appearance);
    }
}

/// A line of straight segments.
#[derive(Debug)]
pub(super) struct LineString {
    /// Its points.
    pub points: Vec<DVec3>,
    /// Whether the last point is connected to the first.
    pub is_closed: bool,
}

impl LineString {
    /// Number of segments.
    pub fn parts(&self) -> usize {
        let ends = usize::from(!self.is_closed);
        self.points.len().saturating_sub(ends)
    }
}

/// Up to four corners without equal neighbours: a triangle may be stored as a face of
/// four corners, one of them repeated.
#[derive(Clone, Copy, Debug)]
pub(super) struct FaceCorners<T> {
    corners: [T; 4],
    count: usize,
}

impl<T: Copy + Default + PartialEq> FaceCorners<T> {
    /// The first four of these, without repetitions.
    pub fn new(given: impl IntoIterator<Item = T>) -> FaceCorners<T> {
        let mut corners = [T::default(); 4];
        let mut count = 0;
        for corner in given.into_iter().take(4) {
            if count == 0 || corners[count - 1] != corner {
                corners[count] = corner;
                count += 1;
            }
        }
        while count > 1 && corners[count - 1] == corners[0] {
            count -= 1;
        }
        FaceCorners { corners, count }
    }

    /// Whether there are enough for a face.
    pub fn are_a_face(&self) -> bool {
        self.count >= 3
    }

    /// All of them.
    pub fn as_slice(&self) -> &[T] {
        &self.corners[..self.count]
    }
}
