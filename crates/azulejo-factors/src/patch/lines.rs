//! The contact lines of one region at one patch size.
//!
//! Contacts come as loose segments, in any number. Here their ends become nodes, segments are split
//! where they cross, and detail below the patch size is dropped: details below a hundredth of it,
//! loops smaller than a twentieth.

use super::contacts::{distance_to_segment, share_along};
use super::irregular::bounds;
use crate::disjoint_sets::DisjointSets;
use glam::DVec2;
use std::collections::{BTreeSet, HashMap};

/// Points closer than this share of the size are merged.
const SNAP: f64 = 0.02;
/// Tolerance of chain simplification, as a share of the size.
const DETAIL: f64 = 0.01;
/// Connected lines whose bounding box is smaller than this share of the size are dropped.
const SMALL: f64 = 0.05;
/// Rounds of splitting; nearly always the first one finds everything and the second nothing.
const SPLIT_ROUNDS: usize = 4;
/// Beyond this many nodes no more crossings are searched for.
const MOST_NODES: usize = 1 << 14;

/// A point of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum LinePoint {
    /// Among [`Lines::points`].
    Inside(u32),
    /// On the border, `share` of the way along a side of the region.
    Border { side: u32, share: f64 },
}

/// Lines through a region, cut into pieces of at most the patch size.
pub(super) struct Lines {
    pub points: Vec<DVec2>,
    pub edges: Vec<[LinePoint; 2]>,
}

/// Whether lines with a bounding box of this diameter are worth a division at a patch size.
pub(super) fn is_worth(diameter: f64, size: f64) -> bool {
    diameter >= SMALL * size
}

impl Lines {
    /// The lines of a polygon; `None` if all of them are too small for the size or too close to the
    /// border.
    pub fn new(corners: &[DVec2], segments: &[[DVec2; 2]], size: f64) -> Option<Lines> {
        let (low, high) = bounds(&segments.concat());
        if size.is_nan() || size <= 0.0 || !is_worth(low.distance(high), size) {
            return None;
        }
        let mut graph = Graph::new(corners, SNAP * size);
        let edges = graph.edges(segments);
        let chains: Vec<Vec<u32>> = graph
            .chains(&edges)
            .into_iter()
            .map(|chain| graph.simplified(chain, DETAIL * size))
            .collect();
        let chains = graph.without_small(chains, SMALL * size);
        (!chains.is_empty()).then(|| graph.pieces(&chains, size))
    }

    /// Where lines end on the border: side and share.
    pub fn ends(&self) -> impl Iterator<Item = (u32, f64)> + '_ {
        self.edges.iter().flatten().filter_map(|p| match *p {
            LinePoint::Border { side, share } => Some((side, share)),
            LinePoint::Inside(_) => None,
        })
    }
}

/// Nodes at least `snap` apart, and where on the border they are.
struct Graph<'a> {
    corners: &'a [DVec2],
    snap: f64,
    nodes: Vec<DVec2>,
    border: Vec<Option<(u32, f64)>>,
    cells: HashMap<[i64; 2], Vec<u32>>,
}

impl<'a> Graph<'a> {
    /// The first nodes are the corners of the region.
    fn new(corners: &'a [DVec2], snap: f64) -> Graph<'a> {
        let mut graph = Graph {
            corners,
            snap,
            nodes: Vec::new(),
            border: Vec::new(),
            cells: HashMap::new(),
        };
        for (side, &p) in (0..).zip(corners) {
            graph.push(p, Some((side, 0.0)));
        }
        graph
    }

    fn cell(&self, p: DVec2) -> [i64; 2] {
        (p / self.snap).to_array().map(|x| x.floor() as i64)
    }

    fn push(&mut self, p: DVec2, border: Option<(u32, f64)>) -> u32 {
        let (cell, node) = (self.cell(p), self.nodes.len() as u32);
        self.cells.entry(cell).or_default().push(node);
        self.nodes.push(p);
        self.border.push(border);
        node
    }

    fn side(&self, k: usize) -> (DVec2, DVec2) {
        (self.corners[k], self.corners[(k + 1) % self.corners.len()])
    }

    /// The nearest side within `reach`.
    fn side_near(&self, p: DVec2, reach: f64) -> Option<usize> {
        (0..self.corners.len())
            .map(|k| (distance_to_segment(p, self.side(k).0, self.side(k).1), k))
            .filter(|near| near.0 < reach)
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|near| near.1)
    }

    fn node_near(&self, p: DVec2) -> Option<u32> {
        let [x, y] = self.cell(p);
        let around = (-1..=1).flat_map(|j| (-1..=1).map(move |i| [x + i, y + j]));
        around
            .filter_map(|cell| self.cells.get(&cell))
            .flatten()
            .map(|&n| (self.nodes[n as usize].distance(p), n))
            .filter(|near| near.0 < self.snap)
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
            .map(|near| near.1)
    }

    /// The node at `p`: an existing or a new one, on the border if that is near.
    fn node(&mut self, p: DVec2) -> u32 {
        if let Some(node) = self.node_near(p) {
            return node;
        }
        let Some(k) = self.side_near(p, self.snap) else {
            return self.push(p, None);
        };
        let (a, b) = self.side(k);
        let share = share_along(p, a, b);
        let on_side = a + share * (b - a);
        match self.node_near(on_side) {
            Some(node) if self.border[node as usize].is_some() => node,
            _ => self.push(on_side, Some((k as u32, share))),
        }
    }

    /// The segments between nodes, split where they cross, each once, without those along the
    /// border.
    fn edges(&mut self, segments: &[[DVec2; 2]]) -> BTreeSet<[u32; 2]> {
        let spans = segments.iter().map(|s| s.map(|p| self.node(p)));
        let mut edges: BTreeSet<[u32; 2]> = spans.filter(|s| s[0] != s[1]).collect();
        for _ in 0..SPLIT_ROUNDS {
            let split = self.split(&edges);
            if split == edges {
                break;
            }
            edges = split;
        }
        edges
    }

    /// One round of splitting. A node may lie slightly off the span that it splits, which may then
    /// cross others.
    fn split(&mut self, edges: &BTreeSet<[u32; 2]>) -> BTreeSet<[u32; 2]> {
        let mut spans: Vec<[u32; 2]> = edges.iter().copied().collect();
        let x = |n: u32| self.nodes[n as usize].x;
        spans.sort_by(|a, b| x(a[0]).min(x(a[1])).total_cmp(&x(b[0]).min(x(b[1]))));
        self.add_crossings(&spans);
        let x = |n: u32| self.nodes[n as usize].x;
        let mut by_x: Vec<u32> = (0..self.nodes.len() as u32).collect();
        by_x.sort_by(|&a, &b| x(a).total_cmp(&x(b)));
        let mut split = BTreeSet::new();
        for span in spans {
            let stops = self.nodes_along(span, &by_x);
            split.extend(
                stops
                    .windows(2)
                    .map(|w| [w[0].min(w[1]), w[0].max(w[1])])
                    .filter(|&[a, b]| a != b && !self.is_on_border(a, b)),
            );
        }
        split
    }

    /// Creates nodes where spans, sorted by their left ends, cross.
    fn add_crossings(&mut self, spans: &[[u32; 2]]) {
        let ends = |nodes: &[DVec2], s: [u32; 2]| s.map(|n| nodes[n as usize]);
        for (i, &one) in spans.iter().enumerate() {
            let [a, b] = ends(&self.nodes, one);
            for &other in &spans[i + 1..] {
                let [c, d] = ends(&self.nodes, other);
                if c.x.min(d.x) > a.x.max(b.x) || self.nodes.len() > MOST_NODES {
                    break;
                }
                let (from, to) = ((b - a).perp_dot(c - a), (b - a).perp_dot(d - a));
                let (near, far) = ((d - c).perp_dot(a - c), (d - c).perp_dot(b - c));
                if from * to < 0.0 && near * far < 0.0 {
                    self.node(c + (d - c) * (from / (from - to)));
                }
            }
        }
    }

    /// The nodes on a span in order, including its ends.
    fn nodes_along(&self, [a, b]: [u32; 2], by_x: &[u32]) -> Vec<u32> {
        let (p, q) = (self.nodes[a as usize], self.nodes[b as usize]);
        let reach = self.snap;
        let x = |n: u32| self.nodes[n as usize].x;
        let first = by_x.partition_point(|&n| x(n) < p.x.min(q.x) - reach);
        let mut along: Vec<(f64, u32)> = by_x[first..]
            .iter()
            .take_while(|&&n| x(n) <= p.x.max(q.x) + reach)
            .filter(|&&n| n != a && n != b)
            .filter(|&&n| distance_to_segment(self.nodes[n as usize], p, q) < reach)
            .map(|&n| (share_along(self.nodes[n as usize], p, q), n))
            .filter(|stop| stop.0 > 0.0 && stop.0 < 1.0)
            .collect();
        along.extend([(0.0, a), (1.0, b)]);
        along.sort_by(|s, t| s.0.total_cmp(&t.0));
        along.into_iter().map(|stop| stop.1).collect()
    }

    fn is_on_border(&self, a: u32, b: u32) -> bool {
        let middle = 0.5 * (self.nodes[a as usize] + self.nodes[b as usize]);
        self.border[a as usize].is_some()
            && self.border[b as usize].is_some()
            && self.side_near(middle, self.snap).is_some()
    }

    /// The edges as chains between nodes where lines end, meet or branch, and as closed loops that
    /// start at an extreme point.
    fn chains(&self, edges: &BTreeSet<[u32; 2]>) -> Vec<Vec<u32>> {
        let mut beside: Vec<Vec<u32>> = vec![Vec::new(); self.nodes.len()];
        for &[a, b] in edges {
            beside[a as usize].push(b);
            beside[b as usize].push(a);
        }
        let joint = |n: u32| beside[n as usize].len() != 2 || self.border[n as usize].is_some();
        let mut left = edges.clone();
        let mut walk = |from: u32, to: u32| {
            let mut chain = vec![from];
            let (mut last, mut next) = (from, to);
            while left.remove(&[last.min(next), last.max(next)]) {
                chain.push(next);
                if joint(next) || next == from {
                    break;
                }
                let both = &beside[next as usize];
                (last, next) = (next, if both[0] == last { both[1] } else { both[0] });
            }
            chain
        };
        let nodes = 0..self.nodes.len() as u32;
        let mut chains: Vec<Vec<u32>> = nodes
            .clone()
            .filter(|&n| joint(n))
            .flat_map(|n| beside[n as usize].iter().map(move |&m| (n, m)))
            .map(|(n, m)| walk(n, m))
            .collect();
        // The remaining edges are loops without joints.
        for n in nodes.filter(|&n| !joint(n)) {
            let mut ring = walk(n, beside[n as usize][0]);
            if ring.len() > 3 {
                ring.pop();
                let extreme = farthest(&self.nodes, &ring, self.nodes[n as usize]);
                ring.rotate_left(extreme);
                ring.push(ring[0]);
                chains.push(ring);
            }
        }
        chains.retain(|c| c.len() > 1);
        chains
    }

    /// A chain without the nodes that lie within `detail` of the rest (Douglas and Peucker,
    /// 1973).
    fn simplified(&self, chain: Vec<u32>, detail: f64) -> Vec<u32> {
        let last = chain.len() - 1;
        let mut kept = vec![false; chain.len()];
        (kept[0], kept[last]) = (true, true);
        let mut open = vec![(0, last)];
        if chain[0] == chain[last] {
            let middle = farthest(&self.nodes, &chain, self.nodes[chain[0] as usize]);
            kept[middle] = true;
            open = vec![(0, middle), (middle, last)];
        }
        while let Some((i, j)) = open.pop() {
            let at = |k: usize| self.nodes[chain[k] as usize];
            let off = |k: usize| distance_to_segment(at(k), at(i), at(j));
            let worst = (i + 1..j).max_by(|&a, &b| off(a).total_cmp(&off(b)));
            if let Some(k) = worst.filter(|&k| off(k) > detail) {
                kept[k] = true;
                open.extend([(i, k), (k, j)]);
            }
        }
        let kept = chain.iter().zip(kept).filter(|k| k.1);
        kept.map(|k| *k.0).collect()
    }

    /// Drops the chains of connected components that are smaller than `least`.
    fn without_small(&self, chains: Vec<Vec<u32>>, least: f64) -> Vec<Vec<u32>> {
        let mut connected = DisjointSets::new(self.nodes.len());
        let pairs = chains.iter().flat_map(|chain| chain.windows(2));
        pairs.for_each(|pair| connected.join(pair[0], pair[1]));
        let mut boxes: HashMap<u32, (DVec2, DVec2)> = HashMap::new();
        for &n in chains.iter().flatten() {
            let p = self.nodes[n as usize];
            let entry = boxes.entry(connected.find(n)).or_insert((p, p));
            *entry = (entry.0.min(p), entry.1.max(p));
        }
        let is_large = |chain: &Vec<u32>| {
            let (low, high) = boxes[&connected.find(chain[0])];
            low.distance(high) >= least
        };
        chains.into_iter().filter(is_large).collect()
    }

    /// The chains in pieces of at most `size`.
    fn pieces(&self, chains: &[Vec<u32>], size: f64) -> Lines {
        let (mut points, mut edges) = (Vec::new(), Vec::new());
        let mut known: HashMap<u32, u32> = HashMap::new();
        for w in chains.iter().flat_map(|chain| chain.windows(2)) {
            let [from, to] = [w[0], w[1]].map(|n| match self.border[n as usize] {
                Some((side, share)) => LinePoint::Border { side, share },
                None => LinePoint::Inside(*known.entry(n).or_insert_with(|| {
                    points.push(self.nodes[n as usize]);
                    points.len() as u32 - 1
                })),
            });
            let (a, b) = (self.nodes[w[0] as usize], self.nodes[w[1] as usize]);
            let count = (a.distance(b) / size).ceil().max(1.0) as u32;
            let mut last = from;
            for k in 1..count {
                let next = LinePoint::Inside(points.len() as u32);
                points.push(a + (b - a) * (f64::from(k) / f64::from(count)));
                edges.push([last, next]);
                last = next;
            }
            edges.push([last, to]);
        }
        Lines { points, edges }
    }
}

/// Which of `chain` lies farthest from `p`.
fn farthest(nodes: &[DVec2], chain: &[u32], p: DVec2) -> usize {
    let distance = |k: usize| nodes[chain[k] as usize].distance_squared(p);
    (0..chain.len())
        .max_by(|&a, &b| distance(a).total_cmp(&distance(b)))
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [DVec2; 4] = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];

    /// Expects this many points inside, pieces and ends on the border.
    fn check(segments: &[[f64; 4]], size: f64, expected: Option<(usize, usize, usize)>) {
        let segments: Vec<[DVec2; 2]> = segments
            .iter()
            .map(|s| [DVec2::new(s[0], s[1]), DVec2::new(s[2], s[3])])
            .collect();
        let lines = Lines::new(&SQUARE, &segments, size);
        let counts = lines.map(|l| (l.points.len(), l.edges.len(), l.ends().count()));
        assert_eq!(counts, expected, "{segments:?} at {size}");
    }

    #[test]
    fn segments_become_pieces() {
        let fin = [0.2, 0.5, 0.8, 0.5];
        check(&[fin], 1.0, Some((2, 1, 0)));
        check(&[fin], 0.25, Some((4, 3, 0)));
        // Twice, in parts, backwards.
        check(
            &[fin, [0.8, 0.5, 0.4, 0.5], [0.2, 0.5, 0.5, 0.5]],
            1.0,
            Some((2, 1, 0)),
        );
        // From border to border, and a cross.
        check(&[[0.0, 0.5, 1.0, 0.5]], 1.0, Some((0, 1, 2)));
        check(
            &[[0.0, 0.5, 1.0, 0.5], [0.5, 0.1, 0.5, 0.9]],
            1.0,
            Some((3, 4, 2)),
        );
        // Closed loop.
        let side = |a: [f64; 2], b: [f64; 2]| [a[0], a[1], b[0], b[1]];
        let (a, b, c) = ([0.2, 0.2], [0.7, 0.3], [0.4, 0.6]);
        check(&[side(a, b), side(b, c), side(a, c)], 1.0, Some((3, 3, 0)));
    }

    #[test]
    fn what_the_size_cannot_show_is_left_out() {
        check(&[[0.5, 0.5, 0.51, 0.5]], 1.0, None);
        check(&[[0.2, 0.01, 0.8, 0.01]], 1.0, None);
        check(&[[0.2, 0.5, 0.8, 0.5]], f64::INFINITY, None);
        check(&[], 1.0, None);
        let arc = |k: u32| DVec2::from_angle(f64::from(k) * 0.01) * 0.3 + 0.5;
        let segments: Vec<[f64; 4]> = (0..628)
            .map(|k| [arc(k), arc((k + 1) % 628)])
            .map(|[a, b]| [a.x, a.y, b.x, b.y])
            .collect();
        let arcs: Vec<[DVec2; 2]> = segments
            .iter()
            .map(|s| [DVec2::new(s[0], s[1]), DVec2::new(s[2], s[3])])
            .collect();
        let lines = Lines::new(&SQUARE, &arcs, 1.0).expect("a circle");
        assert!(
            (6..24).contains(&lines.edges.len()),
            "{}",
            lines.edges.len()
        );
    }
}
