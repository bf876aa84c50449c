//! A tree of boxes: which of many may touch a region?

use azulejo_scene::math::Aabb;
use glam::DVec3;

/// Items of a leaf.
const LEAF: usize = 4;

/// Boxes of items 0, 1, …, halved again and again by their centres.
pub(super) struct BoxTree {
    items: Vec<u32>,
    nodes: Vec<Node>,
}

struct Node {
    bounds: Aabb,
    /// Where its items start, and how many there are.
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

    /// Whether `found` says yes to any item in boxes that `enters` does not refuse; items in an
    /// order that depends on the boxes alone.
    pub fn any(&self, enters: impl Fn(&Aabb) -> bool, mut found: impl FnMut(u32) -> bool) -> bool {
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
            if self.items[items].iter().any(|&i| found(i)) {
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
