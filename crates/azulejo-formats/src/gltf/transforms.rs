//! The transforms of nodes, in double precision.
//!
//! `gltf-json` keeps them in single precision, but the numbers of JSON have more digits, and files of large
//! coordinates need them: there the offset from the origin is the translation of a node, beside which
//! single precision would be half a metre.

use glam::{DAffine3, DQuat, DVec3};
use gltf_json::Node;
use serde_json::value::RawValue;
use std::collections::HashMap;

/// The members of a JSON object, as text.
type Members<'t> = HashMap<String, &'t RawValue>;

/// The local transform of every node of a file, which is valid glTF.
pub(super) fn parent_from_nodes(json: &[u8], nodes: &[Node]) -> Vec<DAffine3> {
    let texts = texts(json).unwrap_or_default();
    let exact = |(index, node): (usize, &Node)| {
        let single = parent_from_singles(node);
        // What is beyond single precision makes the node unusable, as it does in other programs.
        if single == DAffine3::IDENTITY || !single.is_finite() {
            return single;
        }
        let members = texts.get(index).map(|text| text.get());
        let members = members.and_then(|text| serde_json::from_str::<Members>(text).ok());
        let map = members.and_then(|members| parent_from_members(&members));
        map.unwrap_or(single)
    };
    nodes.iter().enumerate().map(exact).collect()
}

/// The texts of all nodes.
fn texts(json: &[u8]) -> Option<Vec<&RawValue>> {
    let root: Members = serde_json::from_slice(json).ok()?;
    serde_json::from_str(root.get("nodes")?.get()).ok()
}

/// The transform of a node: its matrix, or translation, rotation and scale; `None` if that is not a list of
/// numbers.
fn parent_from_members(members: &Members) -> Option<DAffine3> {
    if let Some(matrix) = numbers::<16>(members, "matrix")? {
        return Some(affine(matrix));
    }
    let translation = numbers(members, "translation")?.unwrap_or([0.0; 3]);
    let rotation = numbers(members, "rotation")?.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let scale = numbers(members, "scale")?.unwrap_or([1.0; 3]);
    Some(placed(translation.into(), rotation, scale.into()))
}

/// The numbers of a member, if there is one that is not null; `None` if it is something else.
fn numbers<const N: usize>(members: &Members, name: &str) -> Option<Option<[f64; N]>> {
    let Some(text) = members.get(name).filter(|text| text.get() != "null") else {
        return Some(None);
    };
    let list: Vec<f64> = serde_json::from_str(text.get()).ok()?;
    list.try_into().ok().map(Some)
}

/// The transform of a node as `gltf-json` has it.
fn parent_from_singles(node: &Node) -> DAffine3 {
    if let Some(matrix) = node.matrix {
        return affine(matrix.map(f64::from));
    }
    let vector = |v: Option<[f32; 3]>, rest| v.map_or(rest, |v| DVec3::from(v.map(f64::from)));
    let rotation = node.rotation.unwrap_or_default().0;
    placed(
        vector(node.translation, DVec3::ZERO),
        rotation.map(f64::from),
        vector(node.scale, DVec3::ONE),
    )
}

/// The transform of a translation, a quaternion of any length and a scale.
pub(super) fn placed(translation: DVec3, rotation: [f64; 4], scale: DVec3) -> DAffine3 {
    let [x, y, z, w] = rotation;
    let length = (x * x + y * y + z * z + w * w).sqrt();
    let rotation = if length > 0.0 && length.is_finite() {
        DQuat::from_xyzw(x, y, z, w) / length
    } else {
        DQuat::IDENTITY
    };
    DAffine3::from_scale_rotation_translation(scale, rotation, translation)
}

/// The affine transform of a matrix of four columns; its last row is ignored.
pub(super) fn affine(m: [f64; 16]) -> DAffine3 {
    let column = |k: usize| DVec3::new(m[4 * k], m[4 * k + 1], m[4 * k + 2]);
    DAffine3::from_cols(column(0), column(1), column(2), column(3))
}

#[cfg(test)]
mod tests {
    use super::*;
    use gltf_json::Root;

    /// The transforms of some nodes.
    fn of(nodes: &str) -> Vec<DAffine3> {
        let json = format!("{{\"nodes\":[{nodes}],\"asset\":{{\"version\":\"2.0\"}}}}");
        let root = Root::from_slice(json.as_bytes()).unwrap();
        parent_from_nodes(json.as_bytes(), &root.nodes)
    }

    #[test]
    fn digits_beyond_single_precision_count() {
        let maps = of("{\"translation\":[500000.123,1,5400000.456]},\
             {\"matrix\":[1,0,0,0, 0,1,0,0, 0,0,1,0, 500000.123,0,5400000.456,1]},\
             {\"scale\":[0.001,0.001,0.001],\"translation\":null},{}");
        let place = DVec3::new(500_000.123, 1.0, 5_400_000.456);
        assert_eq!(maps[0].translation, place);
        assert_eq!(maps[1].translation, place.with_y(0.0));
        assert_eq!(maps[2].matrix3.x_axis, DVec3::new(0.001, 0.0, 0.0));
        assert_eq!(maps[3], DAffine3::IDENTITY);
    }

    #[test]
    fn a_file_without_its_text_has_singles() {
        let json = b"{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"translation\":[0.1,0,0]}]}";
        let root = Root::from_slice(json).unwrap();
        let maps = parent_from_nodes(b"{}", &root.nodes);
        assert_eq!(maps[0].translation.x, f64::from(0.1_f32));
    }
}
