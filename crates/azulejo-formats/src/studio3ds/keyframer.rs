//! The keyframer: transforms of nodes at the first frame.

use super::chunk::{Chunk, ChunkWalker, name, vector};
use crate::reading::bytes::Bytes;
use crate::reading::options::{Budget, Exhausted};
use glam::{DAffine3, DMat3, DQuat, DVec3};
use std::collections::HashMap;

/// Name of nodes without a mesh, which are identified by their instance name.
const DUMMY: &str = "$$$DUMMY";

/// The type of object that a node refers to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum NodeTarget {
    Mesh,
    Camera,
    CameraTarget,
    Light,
    SpotTarget,
}

/// A node as in the file, with each track at its first key.
#[derive(Debug)]
pub(super) struct KeyframerNode {
    pub kind: NodeTarget,
    pub at: u64,
    id: u16,
    /// Name of the mesh, light or camera.
    pub name: String,
    instance: String,
    parent: i16,
    pub is_hidden: bool,
    pivot: DVec3,
    position: Option<DVec3>,
    /// Angle in radians, clockwise, and axis.
    rotation: Option<[f64; 4]>,
    scale: DVec3,
    /// Horizontal field of view of a camera, degrees.
    pub field_of_view: Option<f64>,
    /// Roll of a camera, degrees.
    pub roll: Option<f64>,
}

/// A node in world coordinates.
#[derive(Debug)]
pub(super) struct PlacedNode {
    pub world_from_node: DAffine3,
    /// The mesh's origin in node coordinates.
    pub pivot: DVec3,
    /// Whether the node has a position.
    pub has_position: bool,
    /// Names from the root to the node.
    pub path: String,
}

impl NodeTarget {
    fn of(id: u16) -> Option<NodeTarget> {
        Some(match id {
            0xb002 => NodeTarget::Mesh,
            0xb003 => NodeTarget::Camera,
            0xb004 => NodeTarget::CameraTarget,
            0xb005 | 0xb007 => NodeTarget::Light,
            0xb006 => NodeTarget::SpotTarget,
            _ => return None,
        })
    }
}

/// The nodes of chunk B000.
pub(super) fn read(walker: &mut ChunkWalker<'_>, chunk: &Chunk<'_>) -> Vec<KeyframerNode> {
    let mut nodes = Vec::new();
    let mut count = 0;
    let mut body = chunk.body;
    while let Some(child) = walker.next(&mut body) {
        match (NodeTarget::of(child.id), child.id) {
            (Some(kind), _) => {
                let node = node(walker, child, kind, count);
                count = count.wrapping_add(1);
                nodes.extend(node);
            }
            // The header, the frame range and the current frame; the ambient light node, which is
            // not used.
            (None, 0xb00a | 0xb008 | 0xb009 | 0xb001) => {}
            (None, 0x7001) => {}
            _ => walker.skipped(&child, ""),
        }
    }
    nodes
}

/// Reads a node; `None` without the header that names its object. `number` is its sequence number,
/// which serves as the id in files of old programs.
fn node(
    walker: &mut ChunkWalker<'_>,
    chunk: Chunk<'_>,
    kind: NodeTarget,
    number: u16,
) -> Option<KeyframerNode> {
    let mut node = KeyframerNode {
        kind,
        at: chunk.at,
        id: number,
        name: String::new(),
        instance: String::new(),
        parent: -1,
        is_hidden: false,
        pivot: DVec3::ZERO,
        position: None,
        rotation: None,
        scale: DVec3::ONE,
        field_of_view: None,
        roll: None,
    };
    let mut body = chunk.body;
    while let Some(child) = walker.next(&mut body) {
        node.entry(walker, child);
    }
    if node.name.is_empty() {
        walker.warn(chunk.at, "keyframer node without a name: skipped");
        return None;
    }
    Some(node)
}

impl KeyframerNode {
    fn entry<'a>(&mut self, walker: &mut ChunkWalker<'_>, mut chunk: Chunk<'a>) {
        match chunk.id {
            0xb030 => self.id = walker.data(&mut chunk, Bytes::u16_le).unwrap_or(self.id),
            0xb010 => self.header(walker, chunk),
            0xb011 => self.instance = name(&mut chunk.body),
            0xb013 => self.pivot = walker.data(&mut chunk, vector).map_or(DVec3::ZERO, finite),
            0xb020 => self.position = first_key(walker, chunk).map(finite),
            0xb021 => self.rotation = first_key(walker, chunk),
            0xb022 => self.scale = first_key(walker, chunk).map_or(DVec3::ONE, finite),
            0xb023 => self.field_of_view = first_key(walker, chunk).map(|[v]| v),
            0xb024 => self.roll = first_key(walker, chunk).map(|[v]| v),
            // Bounding boxes and morph angles are redundant; colours, hot spots and fall-offs of
            // lights repeat those of the lights.
            0xb014 | 0xb015 | 0xb025 | 0xb027 | 0xb028 => {}
            0xb026 => walker.skipped(&chunk, "morphing"),
            0xb029 => walker.skipped(&chunk, "hide track"),
            _ => walker.skipped(&chunk, ""),
        }
    }

    fn header(&mut self, walker: &mut ChunkWalker<'_>, mut chunk: Chunk<'_>) {
        self.name = name(&mut chunk.body);
        let numbers = |b: &mut Bytes<'_>| Some((b.u16_le()?, b.u16_le()?, b.i16_le()?));
        if let Some((flags, _, parent)) = walker.data(&mut chunk, numbers) {
            self.is_hidden = flags & 0x0800 != 0;
            self.parent = parent;
        }
    }

    /// The displayed name.
    fn label(&self) -> &str {
        match (self.instance.as_str(), self.name.as_str()) {
            ("", DUMMY) => "",
            ("", name) => name,
            (instance, _) => instance,
        }
    }

    /// Position, rotation and scale, relative to the parent.
    fn parent_from_node(&self) -> DAffine3 {
        let [angle, axis @ ..] = self.rotation.unwrap_or([0.0; 4]);
        let rotation = match DVec3::from(axis).try_normalize() {
            Some(axis) if angle.is_finite() => DQuat::from_axis_angle(axis, -angle),
            _ => DQuat::IDENTITY,
        };
        let position = self.position.unwrap_or(DVec3::ZERO);
        DAffine3::from_scale_rotation_translation(self.scale, rotation, position)
    }
}

fn finite(v: [f64; 3]) -> DVec3 {
    DVec3::from(v.map(|x| if x.is_finite() { x } else { 0.0 }))
}

/// The value of a track at its first key.
fn first_key<'a, const N: usize>(
    walker: &mut ChunkWalker<'_>,
    mut chunk: Chunk<'a>,
) -> Option<[f64; N]> {
    let keys = walker.data(&mut chunk, |b| {
        b.skip(10)?;
        b.u32_le()
    })?;
    if keys > 1 {
        walker.warn(chunk.at, "animation: the first key is used");
    }
    if keys == 0 {
        return None;
    }
    walker.data(&mut chunk, |b| {
        b.skip(4)?;
        // One number for each flag of tension, continuity, bias and the two easings.
        let splines = b.u16_le()? & 0b1_1111;
        b.skip(4 * splines.count_ones() as usize)?;
        vector(b)
    })
}

/// Places all nodes.
///
/// # Errors
/// Names of nested nodes that take more memory than the file justifies.
pub(super) fn place(
    nodes: &[KeyframerNode],
    walker: &mut ChunkWalker<'_>,
    budget: &mut Budget,
) -> Result<Vec<PlacedNode>, Exhausted> {
    let parents = parents(nodes, walker);
    let mut placed: Vec<Option<PlacedNode>> = nodes.iter().map(|_| None).collect();
    let mut chain = Vec::new();
    for node in 0..nodes.len() {
        // From the node up to the first ancestor that is placed, then down again.
        let mut next = Some(node);
        while let Some(n) = next.filter(|&n| placed[n].is_none()) {
            chain.push(n);
            next = parents[n];
        }
        while let Some(n) = chain.pop() {
            let parent = parents[n].and_then(|p| placed[p].as_ref());
            placed[n] = Some(child(&nodes[n], parent, budget)?);
        }
    }
    Ok(placed.into_iter().flatten().collect())
}

fn child(
    node: &KeyframerNode,
    parent: Option<&PlacedNode>,
    budget: &mut Budget,
) -> Result<PlacedNode, Exhausted> {
    let (world_from_parent, above) = match parent {
        Some(parent) => (parent.world_from_node, parent.path.as_str()),
        None => (DAffine3::IDENTITY, ""),
    };
    budget.spend(1 + above.len() as u64 / 16)?;
    let world_from_node = world_from_parent * node.parent_from_node();
    let both = !above.is_empty() && !node.label().is_empty();
    Ok(PlacedNode {
        world_from_node,
        pivot: node.pivot,
        has_position: node.position.is_some(),
        path: [above, if both { "/" } else { "" }, node.label()].concat(),
    })
}

/// The parent of each node, by node id or, in files without ids, by sequence number. Nodes that are
/// their own ancestors become roots.
fn parents(nodes: &[KeyframerNode], walker: &mut ChunkWalker<'_>) -> Vec<Option<usize>> {
    let by_id: HashMap<u16, usize> = nodes
        .iter()
        .enumerate()
        .rev()
        .map(|(i, n)| (n.id, i))
        .collect();
    let mut parent = |n: &KeyframerNode| {
        let parent = by_id.get(&(n.parent as u16)).copied();
        if n.parent != -1 && parent.is_none() {
            let message = "keyframer node whose parent is missing: placed at the root";
            walker.warn(n.at, message);
        }
        parent.filter(|_| n.parent != -1)
    };
    let mut parents: Vec<Option<usize>> = nodes.iter().map(&mut parent).collect();
    for node in break_cycles(&mut parents) {
        let message = "keyframer node that is its own ancestor: placed at the root";
        walker.warn(nodes[node].at, message);
    }
    parents
}

/// Makes one node of each cycle a root, and returns these nodes.
fn break_cycles(parents: &mut [Option<usize>]) -> Vec<usize> {
    let mut broken = Vec::new();
    // The first traversal that reached each node.
    let mut walks = vec![usize::MAX; parents.len()];
    for start in 0..parents.len() {
        let mut node = start;
        while walks[node] == usize::MAX {
            walks[node] = start;
            let Some(parent) = parents[node] else { break };
            if walks[parent] == start {
                parents[node] = None;
                broken.push(node);
            }
            node = parent;
        }
    }
    broken
}

/// The local frame of a mesh, chunk 4160: three axes and the origin.
pub(super) fn world_from_mesh(frame: [f64; 12]) -> Option<DAffine3> {
    let axis = |i: usize| DVec3::from_slice(&frame[3 * i..]);
    let mut matrix = DMat3::from_cols(axis(0), axis(1), axis(2));
    if matrix.determinant() < 0.0 {
        // 3D Studio mirrors such meshes in x before it places them.
        matrix.x_axis = -matrix.x_axis;
    }
    let map = DAffine3::from_mat3_translation(matrix, axis(3));
    (map.is_finite() && map.inverse().is_finite()).then_some(map)
}
