//! `EXT_mesh_gpu_instancing`: several places of the mesh of a node.

use super::accessor::Data;
use super::transforms::placed;
use glam::{DAffine3, DVec3};
use gltf_json::{Accessor, Index, Node};
use serde_json::json;

/// The extension.
pub(super) const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// Translations, rotations and scales of the instances of a node; each may be missing.
#[derive(Clone, Copy, Debug)]
pub(super) struct InstanceLists([Option<Index<Accessor>>; 3]);

/// The place of an instance at its node.
#[derive(Clone, Copy, Debug)]
pub(super) struct InstanceTransform {
    translation: DVec3,
    /// A quaternion of any length.
    rotation: [f64; 4],
    scale: DVec3,
}

impl InstanceLists {
    /// Those of a node that has instances.
    pub fn of(node: &Node) -> Option<InstanceLists> {
        let extension = node.extensions.as_ref()?.others.get(INSTANCING)?;
        let attribute = |name: &str| {
            let index = extension.get("attributes")?.get(name)?.as_u64()?;
            u32::try_from(index).ok().map(Index::new)
        };
        Some(InstanceLists(
            ["TRANSLATION", "ROTATION", "SCALE"].map(attribute),
        ))
    }

    /// The number of instances.
    ///
    /// # Errors
    /// No list, or one that is not in the file.
    pub fn count(self, data: &Data) -> Result<usize, String> {
        let given = self.0.iter().flatten().next().copied();
        data.count(given.ok_or_else(|| "no attributes".to_owned())?)
    }

    /// The instances in their order.
    ///
    /// # Errors
    /// Lists that cannot be read, or of different lengths.
    pub fn transforms(self, data: &Data) -> Result<Vec<InstanceTransform>, String> {
        let count = self.count(data)?;
        let [translation, rotation, scale] = self.0;
        let vectors = |list: Option<Index<Accessor>>, rest| match list {
            Some(list) => data.read(list, count, DVec3::from),
            None => Ok(vec![rest; count]),
        };
        let translations = vectors(translation, DVec3::ZERO)?;
        let scales = vectors(scale, DVec3::ONE)?;
        let rotations = match rotation {
            Some(list) => data.read(list, count, |q: [f64; 4]| q)?,
            None => vec![[0.0, 0.0, 0.0, 1.0]; count],
        };
        let parts = translations.into_iter().zip(rotations).zip(scales);
        let transform = |((translation, rotation), scale)| InstanceTransform {
            translation,
            rotation,
            scale,
        };
        Ok(parts.map(transform).collect())
    }
}

impl InstanceTransform {
    /// Node from mesh.
    pub fn map(&self) -> DAffine3 {
        placed(self.translation, self.rotation, self.scale)
    }

    /// A node with this place and a mesh; `None` if numbers of it are not finite, as then there is nothing at its place.
    pub fn node(&self, mesh: usize) -> Option<serde_json::Value> {
        let InstanceTransform {
            translation,
            rotation,
            scale,
        } = self;
        let single = |values: &[f64]| -> Vec<f32> { values.iter().map(|v| *v as f32).collect() };
        let is_number = |values: DVec3| values.as_vec3().is_finite();
        if !(is_number(*translation) && is_number(*scale)) {
            return None;
        }
        let length = rotation.iter().map(|x| x * x).sum::<f64>().sqrt();
        let mut node = json!({ "mesh": mesh });
        if *translation != DVec3::ZERO {
            node["translation"] = single(&translation.to_array()).into();
        }
        if length > 0.0 && length.is_finite() && rotation[..3] != [0.0; 3] {
            node["rotation"] = single(&rotation.map(|x| x / length)).into();
        }
        if *scale != DVec3::ONE {
            node["scale"] = single(&scale.to_array()).into();
        }
        Some(node)
    }
}
