//! Skins: vertices bound to joints, in the rest pose.

use super::accessor::Data;
use super::nodes::{Tree, is_usable};
use super::transforms::affine;
use glam::{DAffine3, DMat3, DVec3};
use gltf_json::Index;
use gltf_json::skin::Skin;

/// The transforms of the joints of a skin.
#[derive(Debug)]
pub(super) struct Joints {
    world_from_mesh: Vec<DAffine3>,
}

impl Joints {
    /// The joints of a skin with the current transforms of the nodes.
    ///
    /// # Errors
    /// The reason, for missing matrices.
    pub fn of(index: Index<Skin>, data: &Data, tree: &Tree) -> Result<Joints, String> {
        let skin = data.root.get(index).ok_or("a skin out of range")?;
        let mut world_from_mesh: Vec<DAffine3> = skin
            .joints
            .iter()
            .map(|joint| tree.world_from_joint(joint.value()))
            .collect();
        if let Some(matrices) = skin.inverse_bind_matrices {
            let count = data.count(matrices)?;
            if count > world_from_mesh.len() {
                return Err("more matrices than joints".to_owned());
            }
            let inverse = data.read(matrices, count, affine)?;
            for (map, inverse) in world_from_mesh.iter_mut().zip(inverse) {
                *map *= inverse;
            }
        }
        // Vertices bound to a joint with an unusable transform become NaN.
        for map in world_from_mesh.iter_mut().filter(|m| !is_usable(m)) {
            *map = DAffine3::NAN;
        }
        Ok(Joints { world_from_mesh })
    }

    /// The blended transform of a vertex, given its joints' indices and weights.
    pub fn blend(&self, influences: impl Iterator<Item = (f64, f64)>) -> DAffine3 {
        let (mut sum, mut total) = (ZERO, 0.0);
        for (joint, weight) in influences {
            if let Some(map) = self.world_from_mesh.get(joint as usize)
                && weight > 0.0
            {
                sum.matrix3 += map.matrix3 * weight;
                sum.translation += map.translation * weight;
                total += weight;
            }
        }
        if total > 0.0 {
            sum.matrix3 *= 1.0 / total;
            sum.translation /= total;
            sum
        } else {
            DAffine3::IDENTITY
        }
    }
}

const ZERO: DAffine3 = DAffine3 {
    matrix3: DMat3::ZERO,
    translation: DVec3::ZERO,
};
