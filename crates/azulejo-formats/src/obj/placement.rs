//! Texture placement: the options `-s` and `-o`, applied to texture coordinates.

use azulejo_scene::{Attribute, MaterialId, Mesh};
use glam::DVec2;
use std::collections::HashMap;

/// Maps texture coordinates of the model to those of the texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PicturePlacement {
    pub scale: DVec2,
    pub offset: DVec2,
}

impl Default for PicturePlacement {
    fn default() -> PicturePlacement {
        PicturePlacement {
            scale: DVec2::ONE,
            offset: DVec2::ZERO,
        }
    }
}

impl PicturePlacement {
    /// Scaled about the origin, then translated, as most programs do it. Coordinates that overflow
    /// stay unchanged.
    fn apply(self, uv: DVec2) -> DVec2 {
        let placed = uv * self.scale + self.offset;
        if placed.is_finite() { placed } else { uv }
    }
}

/// Transforms the texture coordinates of faces whose material has a placement.
pub(super) fn apply_placement(
    mesh: &mut Mesh,
    find_placement: impl Fn(MaterialId) -> Option<PicturePlacement>,
) {
    let placement = |m: &MaterialId| find_placement(*m);
    let mut materials = mesh.face_materials.iter();
    if !materials.any(|m| placement(m).is_some()) {
        return;
    }
    let Some(uvs) = mesh.uvs.take() else { return };
    let mut values = Vec::new();
    let mut corners = Vec::with_capacity(mesh.faces.corners.len());
    // Faces of differently placed materials may share a coordinate.
    let mut known: HashMap<(u32, Option<MaterialId>), u32> = HashMap::new();
    for (face, material) in mesh.face_materials.iter().enumerate() {
        let placed = placement(material);
        let key = placed.map(|_| *material);
        for corner in mesh.faces.corner_range(face) {
            let vertex = mesh.faces.corners[corner];
            let old = uvs.corners.as_ref().map_or(vertex, |index| index[corner]);
            corners.push(*known.entry((old, key)).or_insert_with(|| {
                let uv = uvs.values[old as usize];
                values.push(placed.map_or(uv, |p| p.apply(uv)));
                (values.len() - 1) as u32
            }));
        }
    }
    mesh.uvs = Some(per_vertex_if_possible(mesh, values, corners));
}

/// Values per vertex if every vertex has only one of them, else per corner.
pub(super) fn per_vertex_if_possible<T: Copy>(
    mesh: &Mesh,
    values: Vec<T>,
    corners: Vec<u32>,
) -> Attribute<T> {
    const UNKNOWN: u32 = u32::MAX;
    let mut value_indices = vec![UNKNOWN; mesh.positions.len()];
    let unique = mesh.faces.corners.iter().zip(&corners).all(|(&v, &k)| {
        let known = &mut value_indices[v as usize];
        let agrees = *known == UNKNOWN || *known == k;
        *known = k;
        agrees
    });
    if unique {
        // Every vertex has a value, because a mesh holds only vertices that its faces use.
        Attribute::per_vertex(value_indices.iter().map(|&k| values[k as usize]).collect())
    } else {
        Attribute {
            values,
            corners: Some(corners),
        }
    }
}
