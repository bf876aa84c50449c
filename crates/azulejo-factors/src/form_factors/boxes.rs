//! A tree of boxes, to find items that may touch a region.

use azulejo_scene::math::Aabb;
use glam::DVec3;

/// Items per leaf.
const LEAF: usize = 4;

/// Boxes of items 0, 1, …, halved recursively by their centres.
pub(super) struct BoxTree {
    items: Vec<u32>,
    nodes: Vec<Node>,
}

struct Node {
    bounds: Aabb,
    /// The first of its items, and their number.
    first: u32,
    count: u32,
    /// Index of the second child (the first is the next node); 0 in a leaf.
    second: u32,
}

impl BoxTree {
    pub fn new(boxes: &[Aabb]) -> BoxTree {
        let mut tree = BoxTree {
            items: (0..boxes.len() as u32).collect(),
            nodes: Vec::new(),
        };
        if !boxes.is_empty() {
            tree.split(boxes, 0, boxes.len());
        }
        tree
    }

    fn split(&mut self, boxes: &[Aabb], start: usize, end: usize) {
        let items = &mut self.items[start..end];
        let bounds = items
            .iter()
            .fold(Aabb::EMPTY, |b, &i| b.union(boxes[i as usize]));
        let node = self.nodes.len();
        self.nodes.push(Node {
            bounds,
            first: start as u32,
            count: (end - start) as u32,
            second: 0,
        });
        if end - start <= LEAF {
            return;
        }
        let centres = Aabb::around(items.iter().map(|&i| boxes[i as usize].centre()));
        let size = centres.size();
        let axis = (0..3)
            .max_by(|&a, &b| size[a].total_cmp(&size[b]))
            .unwrap_or(0);
        let middle = items.len() / 2;
        let key = |i: u32| boxes[i as usize].centre()[axis];
        items.select_nth_unstable_by(middle, |&a, &b| key(a).total_cmp(&key(b)).then(a.cmp(&b)));
        self.split(boxes, start, start + middle);
        self.nodes[node].second = self.nodes.len() as u32;
        self.split(boxes, start + middle, end);
    }

    /// Whether `is_match` returns true for any item in boxes that `enters` accepts; items come in an
    /// order that depends on the boxes alone.
    pub fn any(
        &self,
        enters: impl Fn(&Aabb) -> bool,
        mut is_match: impl FnMut(u32) -> bool,
    ) -> bool {
        let mut stack = vec![0_u32];
        while let Some(index) = stack.pop() {
            let Some(node) = self.nodes.get(index as usize).filter(|n| enters(&n.bounds)) else {
                continue;
            };
            if node.second != 0 {
                stack.extend([node.second, index + 1]);
                continue;
            }
            let items = node.first as usize..(node.first + node.count) as usize;
            if self.items[items].iter().any(|&i| is_match(i)) {
                return true;
            }
        }
        false
    }
}

/// Distance of a point from a box; infinite for the empty box.
pub(super) fn distance(bounds: &Aabb, p: DVec3) -> f64 {
    if bounds.is_empty() {
        f64::INFINITY
    } else {
        p.distance(p.clamp(bounds.min, bounds.max))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_trace::sampling::uniform;

    #[test]
    fn finds_what_a_search_of_all_finds() {
        let number = |i: u32, k: u32| f64::from(uniform(&[i, k]));
        let low = |i: u32| DVec3::new(number(i, 0), number(i, 1), number(i, 2));
        let mut boxes: Vec<Aabb> = (0..300)
            .map(|i| Aabb::around([low(i), low(i) + 0.1 * number(i, 3)]))
            .collect();
        boxes[17] = Aabb::EMPTY;
        let tree = BoxTree::new(&boxes);
        for trial in 1_000..1_050 {
            let is_near = |b: &Aabb| distance(b, low(trial)) < 0.2;
            let mut near = Vec::new();
            let stopped = tree.any(is_near, |i| {
                near.extend(is_near(&boxes[i as usize]).then_some(i));
                false
            });
            near.sort_unstable();
            let expected: Vec<u32> = (0..300).filter(|&i| is_near(&boxes[i as usize])).collect();
            assert!(near == expected && !stopped);
            assert_eq!(
                tree.any(is_near, |i| expected.contains(&i)),
                !expected.is_empty()
            );
        }
        assert!(!BoxTree::new(&[]).any(|_| true, |_| true));
    }
}
