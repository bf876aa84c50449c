//! The geometry of all meshes as one piece.
//!
//! In this order, each list over all meshes: x, y, z of positions (32-bit floats), x, y, z of
//! normals (8-bit integers), then over the meshes that have them u, v of texture coordinates
//! (floats), u, v of places in lightmaps (floats), r, g, b of colours (16-bit integers); at the end
//! the indices, which count from the first vertex of their mesh. Each list is differences with
//! their bytes apart; see [`planes`](super::planes).

use super::planes::push_differences;
use super::{PageMesh, PageModel};

/// Places in lightmaps are rounded to multiples of this part of the map, 1/64 of a texel in the
/// largest: the last bits of a float would say nothing and do not compress.
const LIGHTMAP_STEPS: f32 = 1_048_576.0;

/// The bytes before their compression.
pub(super) fn bytes(model: &PageModel) -> Vec<u8> {
    let mut bytes = Vec::new();
    let meshes = &model.meshes;
    for axis in 0..3 {
        let words = vertices(meshes, |mesh| &mesh.positions);
        // −0 and 0 are the same place, and differ in the highest bit.
        push_differences(words.map(|p| (p[axis] + 0.0).to_bits()), &mut bytes);
    }
    for axis in 0..3 {
        let words = meshes.iter().flat_map(|mesh| {
            let missing = mesh.positions.len() - mesh.normals.len();
            let given = mesh.normals.iter().copied();
            given.chain(std::iter::repeat_n([0.0; 3], missing))
        });
        push_bytes(words.map(|n| integer(n[axis], 127.0) as u8), &mut bytes);
    }
    for axis in 0..2 {
        let words = vertices(meshes, |mesh| &mesh.uvs);
        push_differences(words.map(|uv| (uv[axis] + 0.0).to_bits()), &mut bytes);
    }
    for axis in 0..2 {
        let words = vertices(meshes, |mesh| &mesh.lightmap_uvs);
        let rounded = |x: f32| (x * LIGHTMAP_STEPS).round() / LIGHTMAP_STEPS + 0.0;
        push_differences(words.map(|uv| rounded(uv[axis]).to_bits()), &mut bytes);
    }
    for channel in 0..3 {
        let words = vertices(meshes, |mesh| &mesh.colors);
        let integers = words.map(|c| integer(c[channel], 65_535.0).clamp(0, 65_535) as u32);
        push_differences(integers, &mut bytes);
    }
    let indices = meshes.iter().flat_map(|mesh| mesh.indices.iter().copied());
    push_differences(indices, &mut bytes);
    bytes
}

/// A list of all meshes as one.
fn vertices<'a, T: Copy + 'a>(
    meshes: &'a [PageMesh],
    list: impl Fn(&PageMesh) -> &Vec<T> + Clone,
) -> impl Iterator<Item = T> + Clone {
    meshes
        .iter()
        .flat_map(move |mesh| list(mesh).iter().copied())
}

/// `x`, −1..=1, in steps of 1/`steps`.
fn integer(x: f32, steps: f32) -> i32 {
    (x.clamp(-1.0, 1.0) * steps).round() as i32
}

/// Adds the differences of successive bytes.
fn push_bytes(values: impl Iterator<Item = u8>, bytes: &mut Vec<u8>) {
    let mut last = 0u8;
    bytes.extend(values.map(|value| {
        let difference = value.wrapping_sub(last);
        last = value;
        difference
    }));
}
