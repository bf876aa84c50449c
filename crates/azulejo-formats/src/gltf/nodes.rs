//! The tree of nodes: their parents and their transforms.

use super::transforms::parent_from_nodes;
use crate::ReadError;
use glam::DAffine3;
use gltf_json::{Node, Root};

/// Most nodes from a root to a node, itself included.
pub(super) const MOST_LEVELS: usize = 256;

/// Largest number in the transform of a node. Positions are in single precision, so that
/// transformed positions stay finite.
const LARGEST_ENTRY: f64 = 1e100;

/// The nodes of a file, without cycles.
#[derive(Debug)]
pub(super) struct Tree {
    /// Transform of each node to its parent.
    local_transforms: Vec<DAffine3>,
    parents: Vec<Option<u32>>,
    /// World transform of each node; empty without skins, which alone need it.
    world_transforms: Vec<DAffine3>,
}

impl Tree {
    /// Finds the parent of every node; if there are several, which glTF forbids, the first. `json` is the text
    /// of the file.
    ///
    /// # Errors
    /// Nodes that are their own ancestors.
    pub fn of(root: &Root, json: &[u8], file: &str) -> Result<Tree, ReadError> {
        let nodes = root.nodes.as_slice();
        if let Some(node) = on_a_cycle(nodes) {
            return Err(ReadError::whole(
                file,
                format!("a node that is its own ancestor: nodes[{node}]"),
                "nodes that form a tree",
            ));
        }
        let mut parents = vec![None; nodes.len()];
        for (i, node) in nodes.iter().enumerate() {
            for child in children(node) {
                if let Some(parent) = parents.get_mut(child) {
                    parent.get_or_insert(i as u32);
                }
            }
        }
        let mut tree = Tree {
            local_transforms: parent_from_nodes(json, nodes),
            parents,
            world_transforms: Vec::new(),
        };
        if !root.skins.is_empty() {
            tree.world_transforms = (0..nodes.len())
                .map(|node| tree.world_from_node(node))
                .collect();
        }
        Ok(tree)
    }

    /// The nodes without a parent.
    pub fn roots(&self) -> impl Iterator<Item = usize> {
        let orphans = self.parents.iter().enumerate();
        orphans
            .filter(|(_, parent)| parent.is_none())
            .map(|(i, _)| i)
    }

    /// Transform of a node to its parent.
    pub fn parent_from_node(&self, node: usize) -> DAffine3 {
        self.local_transforms.get(node).copied().unwrap_or_default()
    }

    /// World transform of a node that is a joint of a skin.
    pub fn world_from_joint(&self, node: usize) -> DAffine3 {
        self.world_transforms.get(node).copied().unwrap_or_default()
    }

    /// World transform of a node, ancestors included.
    fn world_from_node(&self, node: usize) -> DAffine3 {
        let mut map = DAffine3::IDENTITY;
        let mut next = Some(node);
        for _ in 0..MOST_LEVELS {
            let Some(node) = next else { break };
            map = self.parent_from_node(node) * map;
            let parent = self.parents.get(node).copied().flatten();
            next = parent.map(|p| p as usize);
        }
        map
    }
}

/// Indices of a node's children.
pub(super) fn children(node: &Node) -> impl Iterator<Item = usize> {
    node.children.iter().flatten().map(|child| child.value())
}

/// A node that is its own ancestor, if there is one.
fn on_a_cycle(nodes: &[Node]) -> Option<usize> {
    #[derive(Clone, Copy, PartialEq)]
    enum Seen {
        Not,
        Above,
        Done,
    }
    let mut seen = vec![Seen::Not; nodes.len()];
    for start in 0..nodes.len() {
        if seen[start] == Seen::Done {
            continue;
        }
        seen[start] = Seen::Above;
        let mut path = vec![(start, children(&nodes[start]))];
        while let Some((node, below)) = path.last_mut() {
            let Some(child) = below.next() else {
                seen[*node] = Seen::Done;
                path.pop();
                continue;
            };
            match seen.get(child) {
                Some(Seen::Above) => return Some(child),
                Some(Seen::Not) => {
                    seen[child] = Seen::Above;
                    path.push((child, children(&nodes[child])));
                }
                Some(Seen::Done) | None => {}
            }
        }
    }
    None
}

/// Whether a transform is finite and within range.
pub(super) fn is_usable(map: &DAffine3) -> bool {
    // Comparisons with NaN are false.
    map.to_cols_array().iter().all(|v| v.abs() < LARGEST_ENTRY)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn json(nodes: &str) -> String {
        format!("{{\"asset\":{{\"version\":\"2.0\"}},\"nodes\":[{nodes}]}}")
    }

    fn root(json: &str) -> Root {
        Root::from_slice(json.as_bytes()).unwrap()
    }

    fn check(nodes: &str, expected: Option<usize>) {
        assert_eq!(on_a_cycle(&root(&json(nodes)).nodes), expected, "{nodes}");
    }

    #[test]
    fn cycles() {
        check("{},{}", None);
        check("{\"children\":[1]},{\"children\":[2]},{}", None);
        check("{\"children\":[1,2]},{\"children\":[2]},{}", None);
        check("{\"children\":[0]}", Some(0));
        check(
            "{\"children\":[1]},{\"children\":[2]},{\"children\":[1]}",
            Some(1),
        );
        check("{\"children\":[7]}", None);
    }

    #[test]
    fn world_transforms() {
        let json = json(
            "{\"translation\":[1,0,0],\"rotation\":[0,0,2,2],\"children\":[1]},\
             {\"matrix\":[2,0,0,0, 0,2,0,0, 0,0,2,0, 3,0,0,1]}",
        );
        let tree = Tree::of(&root(&json), json.as_bytes(), "a.gltf").unwrap();
        let placed = tree.world_from_node(1).transform_point3(DVec3::X);
        assert!(
            (placed - DVec3::new(1.0, 5.0, 0.0)).length() < 1e-12,
            "{placed}"
        );
        assert_eq!(tree.roots().collect::<Vec<_>>(), [0]);
    }
}
