//! Receivers as the unwrapper takes them.

use crate::Receiver;
use crate::regions::{has_folds, regions};
use crate::seams::{EdgePair, Edges, seams_among};
use azulejo_scene::math::Aabb;
use azulejo_trace::Tracer;
use glam::DVec3;
use std::collections::HashMap;
use uvunwrap::MeshInput;

/// A receiver as the unwrapper takes it.
pub(crate) struct UnwrapMesh {
    /// Around the middle of the receiver, so that single precision suffices.
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    pub parts: Vec<u32>,
    /// Edges that charts must not cross.
    pub seams: Vec<[bool; 3]>,
    /// Triangles that meet at an edge.
    pairs: Vec<EdgePair>,
    /// Triangles that get no chart.
    pub ignored: Vec<bool>,
    /// Coordinates of the vertices, if their charts stay.
    uvs: Option<Vec<[f32; 2]>>,
}

impl UnwrapMesh {
    /// Of a receiver, with its seams.
    pub fn new(receiver: &Receiver, crease: f64, tracer: &Tracer) -> UnwrapMesh {
        let used = receiver.triangles.iter().flatten();
        let used = used.map(|&v| receiver.positions[v as usize]);
        let bounds = Aabb::around(used.filter(|p| p.is_finite()));
        let middle = if receiver.triangles.is_empty() {
            DVec3::ZERO
        } else {
            0.5 * (bounds.min + bounds.max)
        };
        let is_visible = receiver.visible_triangles();
        let place = |p: &DVec3| {
            let p = *p - middle;
            (if p.is_finite() { p } else { DVec3::ZERO })
                .as_vec3()
                .to_array()
        };
        let pairs = Edges::of(receiver, &is_visible).pairs();
        UnwrapMesh {
            positions: receiver.positions.iter().map(place).collect(),
            indices: receiver.triangles.iter().flatten().copied().collect(),
            parts: receiver.parts.clone(),
            seams: seams_among(&pairs, receiver, crease, Some(tracer)),
            pairs,
            ignored: is_visible.iter().map(|v| !v).collect(),
            uvs: None,
        }
    }

    /// With charts that stay: each vertex with several coordinates becomes several.
    pub fn with_uvs(mut self, uvs: &[[[f32; 2]; 3]]) -> UnwrapMesh {
        let mut known: HashMap<(u32, [u32; 2]), u32> = HashMap::new();
        let (mut positions, mut of_vertices) = (Vec::new(), Vec::new());
        let corners = self.indices.iter_mut().zip(uvs.iter().flatten());
        for (index, uv) in corners {
            // What is not a number is of a triangle without chart, or gets a new one.
            let uv = uv.map(|c| if c.is_finite() { c + 0.0 } else { 0.0 });
            let next = positions.len() as u32;
            let new = *known.entry((*index, uv.map(f32::to_bits))).or_insert(next);
            if new == next {
                positions.push(self.positions[*index as usize]);
                of_vertices.push(uv);
            }
            *index = new;
        }
        self.positions = positions;
        self.uvs = Some(of_vertices);
        self
    }

    /// Whether surfaces that seams do not cut in two have both sides of one.
    pub fn may_fold(&self) -> bool {
        let is_smooth = |pair: &&EdgePair| {
            let mut sides = pair.sides.into_iter();
            !sides.any(|(t, corner)| self.seams[t as usize][usize::from(corner)])
        };
        let smooth: Vec<EdgePair> = self.pairs.iter().filter(is_smooth).copied().collect();
        let whole = vec![0; self.parts.len()];
        let surfaces = regions(&smooth, &self.seams, &whole);
        self.uvs.is_none() && has_folds(&self.pairs, &self.seams, &surfaces)
    }

    /// Divides charts that fold over a seam: their parts become parts of the mesh.
    pub fn divide(&mut self, charts: &[u32]) {
        if has_folds(&self.pairs, &self.seams, charts) {
            self.parts = regions(&self.pairs, &self.seams, charts);
        }
    }

    /// For the unwrapper, at this density relative to others.
    pub fn input(&self, density: f64) -> MeshInput<'_> {
        MeshInput {
            face_materials: Some(&self.parts),
            ignored_faces: Some(&self.ignored),
            // Charts that stay are not cut.
            seams: self.uvs.is_none().then_some(&self.seams[..]),
            existing_uvs: self.uvs.as_deref(),
            scale: density as f32,
            ..MeshInput::new(&self.positions, &self.indices)
        }
    }
}
