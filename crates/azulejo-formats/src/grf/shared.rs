//! `ext shared`: vertices that GRF has several times because their corners differ, made one again.

use azulejo_scene::{Attribute, Mesh};

/// Removes the last vertices of a mesh, the copies of `originals`, whose normals and texture
/// coordinates become those of corners. `false`, without a change, if a copy differs in anything
/// else.
pub(super) fn share_vertices(mesh: &mut Mesh, originals: &[u32]) -> bool {
    let total = mesh.positions.len();
    let count = total.saturating_sub(originals.len());
    let mut copies = (count..total).zip(originals.iter().map(|&v| v as usize));
    if !copies.all(|(copy, original)| original < count && is_copy(mesh, copy, original)) {
        return false;
    }
    let corners = &mut mesh.faces.corners;
    give_to_corners(&mut mesh.normals, corners);
    give_to_corners(&mut mesh.uvs, corners);
    for corner in corners {
        if let Some(copy) = (*corner as usize).checked_sub(count) {
            *corner = originals[copy];
        }
    }
    mesh.positions.truncate(count);
    mesh.colors.truncate(count);
    mesh.irradiance.truncate(count);
    mesh.irradiance_error.truncate(count);
    if let Some(back) = mesh.back.as_deref_mut() {
        back.irradiance.truncate(count);
        back.error.truncate(count);
    }
    true
}

/// Whether two vertices differ in normal and texture coordinate at most.
fn is_copy(mesh: &Mesh, copy: usize, original: usize) -> bool {
    let same = |list: &[azulejo_scene::Rgb]| list.get(copy) == list.get(original);
    mesh.positions[copy] == mesh.positions[original]
        && same(&mesh.colors)
        && same(&mesh.irradiance)
        && same(&mesh.irradiance_error)
        && mesh.back.as_deref().is_none_or(|back| {
            back.irradiance[copy] == back.irradiance[original] && same(&back.error)
        })
}

/// Makes the values of vertices those of corners.
fn give_to_corners<T>(attribute: &mut Option<Attribute<T>>, corners: &[u32]) {
    if let Some(attribute) = attribute {
        attribute.corners.get_or_insert_with(|| corners.to_vec());
    }
}
