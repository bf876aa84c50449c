//! Clusters of facets that are close to each other and face the same way.
//!
//! The formulas walk pairs of clusters ([`analytic_engine`](crate::analytic_engine)), and compressed
//! factors are blocks between them ([`hierarchy`](crate::hierarchy)).

use glam::DVec3;
use std::cmp::Ordering;
use std::ops::Range;

/// Weight of normals against positions: opposite normals count as far apart as this share of the
/// size of the scene.
const TURN: f64 = 0.5;

/// A binary tree over facets. It reorders them; nodes refer to positions in that order.
#[derive(Debug, Default)]
pub(crate) struct ClusterTree {
    /// The facet at each position.
    pub order: Vec<u32>,
    /// Parents before children; the root comes first.
    pub nodes: Vec<ClusterNode>,
}

#[derive(Clone, Debug)]
pub(crate) struct ClusterNode {
    pub range: Range<u32>,
    /// The second child; the first child is the next node. 0 in a leaf.
    pub second: u32,
}

impl ClusterNode {
    pub fn is_leaf(&self) -> bool {
        self.second == 0
    }

    /// Number of facets.
    pub fn len(&self) -> usize {
        self.range.len()
    }
}

impl ClusterTree {
    /// A tree over facets with these centres and unit normals, in a scene of this size, with at most
    /// `leaf` ≥ 1 facets per leaf.
    pub fn new(places: &[(DVec3, DVec3)], size: f64, leaf: usize) -> ClusterTree {
        let key = |&(centre, normal): &(DVec3, DVec3)| {
            let turn = 0.5 * TURN * size * normal;
            [centre.x, centre.y, centre.z, turn.x, turn.y, turn.z]
        };
        let keys: Vec<[f64; 6]> = places.iter().map(key).collect();
        let mut tree = ClusterTree {
            order: (0..places.len() as u32).collect(),
            nodes: Vec::new(),
        };
        if !places.is_empty() {
            tree.split(&keys, 0..places.len(), leaf);
        }
        tree
    }

    fn split(&mut self, keys: &[[f64; 6]], range: Range<usize>, leaf: usize) {
        let node = self.nodes.len();
        self.nodes.push(ClusterNode {
            range: range.start as u32..range.end as u32,
            second: 0,
        });
        if range.len() <= leaf {
            return;
        }
        let items = &mut self.order[range.clone()];
        let extent = |axis: usize| {
            let values = || items.iter().map(|&i| keys[i as usize][axis]);
            let low = values().fold(f64::INFINITY, f64::min);
            (low, values().fold(f64::NEG_INFINITY, f64::max) - low)
        };
        let axis = (0..6)
            .max_by(|&a, &b| extent(a).1.total_cmp(&extent(b).1))
            .unwrap_or(0);
        let (low, width) = extent(axis);
        let value = |i: u32| (keys[i as usize][axis], i);
        // Normals come in few directions: split between them, not through the middle of one.
        let middle = if axis < 3 {
            let half = items.len() / 2;
            items.select_nth_unstable_by(half, |&a, &b| {
                value(a).partial_cmp(&value(b)).unwrap_or(Ordering::Equal)
            });
            half
        } else {
            let bound = low + 0.5 * width;
            items.sort_unstable_by_key(|&i| (keys[i as usize][axis] > bound, i));
            items.partition_point(|&i| keys[i as usize][axis] <= bound)
        };
        let middle = range.start + middle.clamp(1, range.len() - 1);
        self.split(keys, range.start..middle, leaf);
        self.nodes[node].second = self.nodes.len() as u32;
        self.split(keys, middle..range.end, leaf);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_trace::sampling::uniform;

    #[test]
    fn every_facet_has_one_place() {
        let number = |i: u32, k: u32| f64::from(uniform(&[i, k]));
        let place = |i: u32| {
            let centre = DVec3::new(number(i, 0), number(i, 1), number(i, 2));
            (
                centre,
                if i.is_multiple_of(3) {
                    DVec3::X
                } else {
                    -DVec3::Z
                },
            )
        };
        let places: Vec<_> = (0..1000).map(place).collect();
        let tree = ClusterTree::new(&places, 1.0, 4);
        let mut order = tree.order.clone();
        order.sort_unstable();
        assert_eq!(order, (0..1000).collect::<Vec<u32>>());
        for (k, node) in tree.nodes.iter().enumerate().filter(|(_, n)| !n.is_leaf()) {
            let (first, second) = (
                &tree.nodes[k + 1].range,
                &tree.nodes[node.second as usize].range,
            );
            assert_eq!(
                (first.start, second.end),
                (node.range.start, node.range.end)
            );
            assert!(first.end == second.start && !first.is_empty() && !second.is_empty());
        }
        assert!(ClusterTree::new(&[], 1.0, 4).nodes.is_empty());
    }
}
