//! Nodes in place of instances by `EXT_mesh_gpu_instancing`, which share one mesh and so could not have light of their
//! own.

use super::super::instances::{INSTANCING, InstanceLists, InstanceTransform};
use super::additions::Additions;
use super::error::PatchError;
use super::json::Json;
use super::mark;
use super::meshes::drop_extension;
use super::notes::Notes;
use super::source::{Source, with_source};
use super::types::GltfFile;
use serde_json::json;

/// The cost of a node in elements, of which a file may have [`ReadOptions::most_elements`](crate::ReadOptions).
const ELEMENTS_PER_NODE: u64 = 16;

/// The fact of the mark: how many nodes were added.
const INSTANCES: &str = "instances";

/// A file in which each instance by `EXT_mesh_gpu_instancing` is a node below that which had them, before its other
/// children; `None` if there are none. Meshes that the file poses (skins, morph targets) stay as they are. Numbers per
/// instance other than its place are lost. [`strip`](super::strip) undoes it, and edits after it.
///
/// # Errors
/// Files that cannot be read or are not UTF-8, and more instances than the options allow.
pub fn expanded(file: &GltfFile) -> Result<Option<Vec<u8>>, PatchError> {
    with_source(file, |source| {
        let nodes = source.data.root.nodes.len();
        let mut left = file.options.most_elements / ELEMENTS_PER_NODE;
        let mut instances = Vec::new();
        for node in 0..nodes {
            instances.extend(instances_of(source, node, &mut left)?);
        }
        if instances.is_empty() {
            return Ok(None);
        }
        let mut additions = Additions::new(source, "", "");
        let mut count = 0;
        for (node, mesh, places) in instances {
            let mut children = Vec::new();
            for node in places.iter().filter_map(|place| place.node(mesh)) {
                children.push(additions.append("nodes", node).into());
            }
            count += children.len();
            let entry = additions.json.key("nodes").at(node);
            children.extend_from_slice(entry.entries("children"));
            entry.key("children").set(Json::List(children));
            entry.remove("mesh");
            entry.prune(&["extensions", INSTANCING]);
        }
        let mut left = additions.json.entries("nodes").iter();
        if left.all(|node| node.find(&["extensions", INSTANCING]).is_none()) {
            for list in ["extensionsUsed", "extensionsRequired"] {
                drop_extension(&mut additions.json, list, INSTANCING);
            }
        }
        let facts = json!({ INSTANCES: count }).into();
        let expanded = mark::finished(additions, facts, Notes::default())?;
        Ok(Some(expanded.bytes))
    })
}

/// The mesh of a node, and the places of its instances. `left` is how many there may be.
fn instances_of(
    source: &Source,
    index: usize,
    left: &mut u64,
) -> Result<Option<(usize, usize, Vec<InstanceTransform>)>, PatchError> {
    let root = source.data.root;
    let node = &root.nodes[index];
    let (Some(mesh), Some(lists)) = (source.mesh_of(index), InstanceLists::of(node)) else {
        return Ok(None);
    };
    let has_poses = |mesh: &gltf_json::Mesh| {
        mesh.weights.is_some() || mesh.primitives.iter().any(|p| p.targets.is_some())
    };
    let is_posed = node.skin.is_some()
        || node.weights.is_some()
        || root.meshes.get(mesh).is_none_or(has_poses);
    // What cannot be read is not drawn by others either: the reader says so.
    let Ok(count) = lists.count(&source.data) else {
        return Ok(None);
    };
    if is_posed {
        return Ok(None);
    }
    *left = left.checked_sub(count as u64).ok_or_else(|| {
        source.refused(format!(
            "{count} instances at node {index}, more than are allowed (--most-elements)"
        ))
    })?;
    let places = lists.transforms(&source.data).ok();
    Ok(places.map(|places| (index, mesh, places)))
}

/// Whether a mark is that of an expansion, to which no light was added.
pub fn is_of_expansion(mark: &Json) -> bool {
    mark.get(INSTANCES).is_some() && mark.get("convention").is_none()
}
