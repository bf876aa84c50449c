//! Where the objects of a scene come from: the node, the mesh and the triangles of the file.
//!
//! The reader merges the primitives of a mesh and leaves out triangles without usable vertices, so this
//! is recorded while it reads. Edits of the file ([`patch`](super::patch)) start from it.

use super::animations::Targets;
use super::messages::GltfMessages;
use super::nodes::children;
use gltf_json::{Node, Root};
use std::sync::Arc;

/// Where an object of the scene comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ObjectOrigin {
    /// Index of the node.
    pub node: usize,
    /// Number of the instance at this node, from 0, if it has several (`EXT_mesh_gpu_instancing`).
    pub instance: Option<usize>,
    /// Index of the mesh.
    pub mesh: usize,
    /// Whether the node mirrors its mesh: then the corners of every face are the first, the third and
    /// the second of its triangle in the file, so that its front stays the front.
    pub mirrored: bool,
    /// Whether it stays where it is.
    pub stillness: Stillness,
    /// Level of detail by `MSFT_lod` of the node or one above it: 0 is the finest, or the only one. Only
    /// the finest is read, unless the nodes of others are in the scene themselves.
    pub level_of_detail: u32,
    /// The origin of each face of the object's mesh. Objects of one mesh share it.
    pub faces: Arc<[FaceOrigin]>,
}

/// The triangle of the file that a face was.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FaceOrigin {
    /// Index of the primitive in its mesh.
    pub primitive: u32,
    /// Number of the triangle in the primitive, in the order of its indices, from 0; of strips and fans as
    /// glTF 2.0 numbers them in section 3.7.2.1. Triangles that were left out are counted.
    pub triangle: u32,
}

/// Whether an object stays as it is read, and if not, what moves it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stillness {
    /// Nothing in the file moves it.
    Still,
    /// It has a skin.
    Skinned,
    /// It has morph targets, and weights that are animated or not 0.
    Morphed,
    /// An animation moves or hides its node or one above it.
    Animated,
}

/// Records origins while a file is read.
pub(super) struct OriginRecorder {
    /// Whether an animation moves each node, or one above it.
    is_moved: Vec<bool>,
    /// Level of detail of each node.
    levels: Vec<u32>,
    targets: Targets,
    list: Vec<ObjectOrigin>,
}

/// The place of an object that is being made.
#[derive(Clone, Copy, Debug)]
pub(super) struct ObjectPlace {
    /// Index of the node.
    pub node: usize,
    /// Number of the instance at this node.
    pub instance: Option<usize>,
    /// Index of the mesh.
    pub mesh: usize,
}

/// Origins of the faces of a mesh; `None` if they are not recorded.
pub(super) type Faces = Option<Arc<[FaceOrigin]>>;

impl OriginRecorder {
    /// No origins yet; `json` is the text of the file.
    pub fn new(root: &Root, json: &[u8]) -> OriginRecorder {
        let targets = Targets::of(json);
        let mut is_moved = vec![false; root.nodes.len()];
        for &node in &targets.moved_nodes {
            spread(&root.nodes, node, &mut is_moved, true);
        }
        let mut levels = vec![0; root.nodes.len()];
        for node in &root.nodes {
            for (k, id) in coarser(node).enumerate() {
                spread(&root.nodes, id, &mut levels, k as u32 + 1);
            }
        }
        OriginRecorder {
            is_moved,
            levels,
            targets,
            list: Vec::new(),
        }
    }

    /// Records the origin of the next object.
    pub fn push(&mut self, root: &Root, place: ObjectPlace, mirrored: bool, faces: &Faces) {
        self.list.push(ObjectOrigin {
            node: place.node,
            instance: place.instance,
            mesh: place.mesh,
            mirrored,
            stillness: self.stillness(root, place),
            level_of_detail: self.levels.get(place.node).copied().unwrap_or(0),
            faces: faces.clone().unwrap_or_default(),
        });
    }

    fn stillness(&self, root: &Root, place: ObjectPlace) -> Stillness {
        let (node, mesh) = (root.nodes.get(place.node), root.meshes.get(place.mesh));
        if node.is_some_and(|n| n.skin.is_some()) {
            return Stillness::Skinned;
        }
        let primitives = mesh.iter().flat_map(|m| &m.primitives);
        let has_targets = primitives
            .filter_map(|p| p.targets.as_ref())
            .any(|t| !t.is_empty());
        if has_targets {
            let weights = node.and_then(|n| n.weights.as_deref());
            let weights = weights.or(mesh.and_then(|m| m.weights.as_deref()));
            if weights.is_some_and(|w| w.iter().any(|w| *w != 0.0))
                || self.targets.morphed_nodes.contains(&place.node)
                || self.targets.morphed_meshes.contains(&place.mesh)
            {
                return Stillness::Morphed;
            }
        }
        match self.is_moved.get(place.node) {
            Some(true) => Stillness::Animated,
            _ => Stillness::Still,
        }
    }

    /// All that was recorded.
    pub fn finish(self) -> Vec<ObjectOrigin> {
        self.list
    }
}

/// Says which lamps are taken where they rest, although an animation moves them, and that of some nodes only the finest
/// level of detail is read. `json` is the text of the file.
pub(super) fn warn_of_rest(root: &Root, json: &[u8], messages: &mut GltfMessages) {
    let mut is_moved = vec![false; root.nodes.len()];
    for &node in &Targets::of(json).moved_nodes {
        spread(&root.nodes, node, &mut is_moved, true);
    }
    for (index, node) in root.nodes.iter().enumerate() {
        let extensions = node.extensions.as_ref();
        let is_lamp = extensions.is_some_and(|e| e.khr_lights_punctual.is_some());
        if is_lamp && is_moved[index] {
            messages.of(
                "lamp that an animation moves: shines from where it rests",
                || format!("nodes[{index}]"),
            );
        }
        if coarser(node).next().is_some() {
            messages.of("MSFT_lod: the finest level of detail is read", || {
                format!("nodes[{index}]")
            });
        }
    }
}

/// Nodes that show the content of another with less detail, the finest first (`MSFT_lod`).
fn coarser(node: &Node) -> impl Iterator<Item = usize> {
    let extensions = node.extensions.as_ref();
    let lod = extensions.and_then(|e| e.others.get("MSFT_lod"));
    let ids = lod.and_then(|lod| lod.get("ids")?.as_array());
    let ids = ids.into_iter().flatten();
    ids.filter_map(|id| usize::try_from(id.as_u64()?).ok())
}

/// Gives a node and all below it a value, where they have none yet: every node gets one once.
fn spread<T: Copy + Default + PartialEq>(nodes: &[Node], from: usize, values: &mut [T], value: T) {
    let mut left = vec![from];
    while let Some(index) = left.pop() {
        if let (Some(node), Some(own)) = (nodes.get(index), values.get_mut(index))
            && *own == T::default()
        {
            *own = value;
            left.extend(children(node));
        }
    }
}
