//! One mesh, from the bytes of its lists.

use super::chunk::ChunkWalker;
use super::parse::{MaterialFaces, RawMesh};
use crate::surface::smooth;
use azulejo_scene::{Attribute, Faces, MaterialId, Mesh};
use glam::{DAffine2, DVec2, DVec3};
use std::collections::HashMap;

/// Material properties needed for faces.
#[derive(Debug, Default)]
pub(super) struct MaterialTable {
    pub by_name: HashMap<String, MaterialId>,
    /// The map of texture coordinates, by material.
    pub transforms: Vec<Option<DAffine2>>,
    /// Whether faces are flat-shaded, by material.
    pub are_flat: Vec<bool>,
    /// The material of faces without one.
    pub default: MaterialId,
}

/// Builds a mesh as stored, in world coordinates.
pub(super) fn mesh(raw: &RawMesh<'_>, table: &MaterialTable, walker: &mut ChunkWalker<'_>) -> Mesh {
    let mut mesh = Mesh {
        positions: positions(raw, walker),
        ..Mesh::default()
    };
    let face_materials = face_materials(raw, table, walker);
    let kept = faces(raw, &mut mesh.faces, mesh.positions.len(), walker);
    mesh.face_materials = kept.iter().map(|&f| face_materials[f as usize]).collect();
    mesh.uvs = uvs(raw, &mesh, table, walker);
    smooth(raw, &kept, &mut mesh, table);
    mesh
}

/// The little-endian numbers of a list, `N` per entry.
fn floats<const N: usize>(bytes: &[u8]) -> impl Iterator<Item = [f64; N]> {
    let (numbers, _) = bytes.as_chunks::<4>();
    numbers.chunks_exact(N).map(|entry| {
        let mut values = [0.0; N];
        for (value, number) in values.iter_mut().zip(entry) {
            *value = f64::from(f32::from_le_bytes(*number));
        }
        values
    })
}

fn indices(bytes: &[u8]) -> impl Iterator<Item = u16> {
    let (numbers, _) = bytes.as_chunks::<2>();
    numbers.iter().map(|n| u16::from_le_bytes(*n))
}

fn positions(raw: &RawMesh<'_>, walker: &mut ChunkWalker<'_>) -> Vec<DVec3> {
    let mut positions: Vec<DVec3> = floats::<3>(raw.vertices).map(DVec3::from).collect();
    for position in positions.iter_mut().filter(|p| !p.is_finite()) {
        walker.warn(raw.at, "vertex that is not finite: placed at the origin");
        *position = DVec3::ZERO;
    }
    positions
}

/// Appends the valid triangles and returns their numbers in the file.
fn faces(
    raw: &RawMesh<'_>,
    faces: &mut Faces,
    vertices: usize,
    walker: &mut ChunkWalker<'_>,
) -> Vec<u32> {
    let (entries, _) = raw.faces.as_chunks::<8>();
    let mut kept = Vec::with_capacity(entries.len());
    faces.starts.reserve(entries.len());
    faces.corners.reserve(3 * entries.len());
    for (number, entry) in entries.iter().enumerate() {
        let corner = |i: usize| u32::from(u16::from_le_bytes([entry[2 * i], entry[2 * i + 1]]));
        let corners = [corner(0), corner(1), corner(2)];
        if corners.iter().all(|&c| (c as usize) < vertices) {
            faces.push(&corners);
            kept.push(number as u32);
        }
    }
    let lost = entries.len() - kept.len();
    walker.warn_many(
        raw.at,
        "face with a vertex index out of range: skipped",
        lost,
    );
    kept
}

/// The material of every face of the file.
fn face_materials(
    raw: &RawMesh<'_>,
    table: &MaterialTable,
    walker: &mut ChunkWalker<'_>,
) -> Vec<MaterialId> {
    let mut materials = vec![table.default; raw.faces.len() / 8];
    for list in &raw.face_materials {
        let material = table.by_name.get(&list.material).copied();
        let material = material.unwrap_or(table.default);
        assign(list, material, &mut materials, walker);
    }
    materials
}

fn assign(
    list: &MaterialFaces<'_>,
    material: MaterialId,
    materials: &mut [MaterialId],
    walker: &mut ChunkWalker<'_>,
) {
    let mut lost = 0;
    for face in indices(list.faces) {
        match materials.get_mut(usize::from(face)) {
            Some(entry) => *entry = material,
            None => lost += 1,
        }
    }
    walker.warn_many(
        list.at,
        "material assigned to a face index out of range: skipped",
        lost,
    );
}

/// Texture coordinates, transformed by the textures of the faces' materials.
fn uvs(
    raw: &RawMesh<'_>,
    mesh: &Mesh,
    table: &MaterialTable,
    walker: &mut ChunkWalker<'_>,
) -> Option<Attribute<DVec2>> {
    let mut uvs: Vec<DVec2> = floats::<2>(raw.uvs).map(DVec2::from).collect();
    if uvs.is_empty() {
        return None;
    }
    if uvs.len() != mesh.positions.len() {
        walker.warn(
            raw.at,
            "mesh with more or fewer texture coordinates than vertices: truncated, or (0, 0) used",
        );
        uvs.resize(mesh.positions.len(), DVec2::ZERO);
    }
    for uv in uvs.iter_mut().filter(|uv| !uv.is_finite()) {
        walker.warn(
            raw.at,
            "texture coordinate that is not finite: taken as (0, 0)",
        );
        *uv = DVec2::ZERO;
    }
    let of = |m: &MaterialId| table.transforms.get(*m as usize).copied().flatten();
    let mut used = mesh.face_materials.iter().map(of);
    let first = used.next().flatten();
    if used.any(|other| other != first) {
        return Some(moved_by_corner(&uvs, mesh, of));
    }
    if let Some(map) = first {
        uvs.iter_mut()
            .for_each(|uv| *uv = map.transform_point2(*uv));
    }
    Some(Attribute::per_vertex(uvs))
}

/// If materials transform texture coordinates differently, a vertex gets one for each of them.
fn moved_by_corner(
    uvs: &[DVec2],
    mesh: &Mesh,
    of: impl Fn(&MaterialId) -> Option<DAffine2>,
) -> Attribute<DVec2> {
    let mut values = Vec::new();
    let mut known = HashMap::new();
    let mut corners = Vec::with_capacity(mesh.faces.corners.len());
    for (face, material) in mesh.faces.iter().zip(&mesh.face_materials) {
        let map = of(material).unwrap_or(DAffine2::IDENTITY);
        for &vertex in face {
            corners.push(*known.entry((vertex, *material)).or_insert_with(|| {
                values.push(map.transform_point2(uvs[vertex as usize]));
                (values.len() - 1) as u32
            }));
        }
    }
    Attribute {
        values,
        corners: Some(corners),
    }
}

/// Smoothing groups if a single number per face can represent them, as both passes smooth by
/// groups; otherwise the equivalent normals. Nothing where the file says nothing.
fn smooth(raw: &RawMesh<'_>, kept: &[u32], mesh: &mut Mesh, table: &MaterialTable) {
    let (numbers, _) = raw.smoothing.as_chunks::<4>();
    let given = |face: u32| {
        numbers
            .get(face as usize)
            .map_or(0, |n| u32::from_le_bytes(*n))
    };
    let is_flat = |m: MaterialId| table.are_flat.get(m as usize).copied().unwrap_or(false);
    let masks: Vec<u32> = std::iter::zip(kept, &mesh.face_materials)
        .map(|(&face, &material)| if is_flat(material) { 0 } else { given(face) })
        .collect();
    if raw.smoothing.is_empty() && !mesh.face_materials.iter().any(|&m| is_flat(m)) {
        return;
    }
    // Faces of group 0 are flat.
    if are_groups(&masks) {
        mesh.smoothing = masks;
    } else {
        let are_joined = |a: usize, b: usize| masks[a] & masks[b] != 0;
        mesh.normals = Some(smooth::corner_normals(mesh, are_joined));
    }
}

/// Whether faces that share a bit share all of them: then the masks are equivalent to numbers.
/// Otherwise one face can be smooth with two that are not smooth with each other.
fn are_groups(masks: &[u32]) -> bool {
    let mut owners = [0; 32];
    masks.iter().all(|&mask| {
        (0..32).filter(|bit| mask >> bit & 1 == 1).all(|bit| {
            let owner = &mut owners[bit];
            let is_first = *owner == 0;
            if is_first {
                *owner = mask;
            }
            is_first || *owner == mask
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masks_that_overlap_are_no_groups() {
        assert!(are_groups(&[0, 1, 2, 1, 12, 0, 12]));
        assert!(!are_groups(&[1, 2, 3]));
        assert!(!are_groups(&[3, 1]));
    }
}
