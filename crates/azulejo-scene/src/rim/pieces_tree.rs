//! A tree of rectangles, in the order in which they come: neighbours on a contour are near each other.

use crate::figure::Rectangle;
use glam::DVec2;

/// Rectangles of one leaf.
const LEAF: usize = 4;

/// Rectangles by halves of their list.
#[derive(Clone, Debug, Default)]
pub(crate) struct PiecesTree {
    /// The root first; the first child of a node is the next one.
    nodes: Vec<PiecesNode>,
}

#[derive(Clone, Copy, Debug)]
struct PiecesNode {
    bounds: Rectangle,
    /// The range of rectangles.
    first: u32,
    end: u32,
    /// The second child; 0 for a leaf.
    second: u32,
}

impl PiecesTree {
    pub fn new(rectangles: &[Rectangle]) -> PiecesTree {
        let mut tree = PiecesTree::default();
        if !rectangles.is_empty() {
            tree.add(rectangles, 0, rectangles.len());
        }
        tree
    }

    fn add(&mut self, rectangles: &[Rectangle], first: usize, end: usize) -> u32 {
        let own = self.nodes.len();
        let all = rectangles[first..end].iter();
        self.nodes.push(PiecesNode {
            bounds: all.fold(Rectangle::EMPTY, |b, r| b.union(*r)),
            first: first as u32,
            end: end as u32,
            second: 0,
        });
        if end - first > LEAF {
            let middle = (first + end) / 2;
            self.add(rectangles, first, middle);
            self.nodes[own].second = self.add(rectangles, middle, end);
        }
        own as u32
    }

    /// Visits the leaves within `reach` of a point, which the visitor may shorten.
    pub fn around(&self, point: DVec2, mut reach: f64, mut visit: impl FnMut(u32, &mut f64)) {
        self.walk(|node| {
            let is_near = node.bounds.distance_squared(point) <= reach * reach;
            if is_near && node.is_leaf() {
                (node.first..node.end).for_each(|k| visit(k, &mut reach));
            }
            is_near
        });
    }

    /// Visits the leaves whose rectangle, enlarged by `reach`, meets a straight line.
    pub fn along(&self, line: [DVec2; 2], reach: f64, mut visit: impl FnMut(u32)) {
        self.walk(|node| {
            let is_met = node.bounds.is_met(line, reach);
            if is_met && node.is_leaf() {
                (node.first..node.end).for_each(&mut visit);
            }
            is_met
        });
    }

    /// Goes from the root into the children of all nodes that are entered.
    fn walk(&self, mut enters: impl FnMut(&PiecesNode) -> bool) {
        let mut node = 0;
        let mut waiting = [0; 40];
        let mut count = 0;
        while let Some(here) = self.nodes.get(node) {
            if enters(here) && !here.is_leaf() {
                waiting[count] = here.second as usize;
                count += 1;
                node += 1;
                continue;
            }
            if count == 0 {
                return;
            }
            count -= 1;
            node = waiting[count];
        }
    }
}

impl PiecesNode {
    fn is_leaf(&self) -> bool {
        self.second == 0
    }
}
