//! Points that are the same but for rounding, and corners on the edges of neighbours.

use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Points within edges, as a multiple of the edges: many edges with many corners of others on each of
/// them are not a surface.
const MOST: usize = 16;

/// Points with those that lie in one place made one.
pub(super) struct PointWeld {
    /// For each point, the first one in its place.
    same: Vec<u32>,
    /// Distance up to which points are in one place.
    pub(super) tolerance: f64,
}

impl PointWeld {
    /// Points closer than a share of the extent of all are one.
    pub(super) fn new(points: &[DVec3], share: f64) -> PointWeld {
        let low = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        let extent = (high - low).max_element();
        // Also for a single point, and none.
        let is_sized = extent.is_finite() && extent > 0.0;
        let tolerance = share * if is_sized { extent } else { 1.0 };
        let mut weld = PointWeld {
            same: Vec::with_capacity(points.len()),
            tolerance,
        };
        let mut boxes: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
        for (i, &point) in (0..).zip(points) {
            let place = (point - low) / (2.0 * tolerance);
            let is_same = |&&k: &&u32| points[k as usize].distance(point) <= tolerance;
            let earlier = corners_of(place).find_map(|b| boxes.get(&b)?.iter().find(is_same));
            let first = earlier.copied().unwrap_or(i);
            if first == i {
                boxes.entry(in_whole(place)).or_default().push(i);
            }
            weld.same.push(first);
        }
        weld
    }

    /// A polygon without corners that are the same as the one before.
    pub(super) fn outline(&self, corners: &[u32]) -> Vec<u32> {
        let mut outline: Vec<u32> = corners.iter().map(|&c| self.same[c as usize]).collect();
        outline.dedup();
        while outline.len() > 1 && outline.first() == outline.last() {
            outline.pop();
        }
        outline
    }
}

fn in_whole(place: DVec3) -> [i64; 3] {
    place.floor().to_array().map(|x| x as i64)
}

/// The eight boxes within half a box of a place.
fn corners_of(place: DVec3) -> impl Iterator<Item = [i64; 3]> {
    let low = in_whole(place - 0.5);
    (0..8).map(move |k| [low[0] + (k & 1), low[1] + (k >> 1 & 1), low[2] + (k >> 2)])
}

/// Adds to outlines of rows the corners of others that lie on their edges, so that edges of neighbours
/// have the same ends.
pub(super) fn split_edges(outlines: &mut [(u32, Vec<u32>)], points: &[DVec3], tolerance: f64) {
    let mut uses: BTreeMap<(u32, u32), usize> = BTreeMap::new();
    for (_, outline) in outlines.iter() {
        edges(outline).for_each(|(a, b)| *uses.entry((a.min(b), a.max(b))).or_default() += 1);
    }
    let is_loose = |(a, b): (u32, u32)| uses[&(a.min(b), a.max(b))] == 1;
    let loose = uses.iter().filter(|&(_, &count)| count == 1);
    let ends: BTreeSet<u32> = loose.flat_map(|(&(a, b), _)| [a, b]).collect();
    let mut candidates: Vec<u32> = ends.into_iter().collect();
    let tree = PointTree::new(&mut candidates, points, tolerance);
    let mut budget = MOST * uses.len();
    for (_, outline) in outlines.iter_mut() {
        let mut divided = Vec::with_capacity(outline.len());
        for (a, b) in edges(outline) {
            divided.push(a);
            if is_loose((a, b)) {
                let on_edge = tree.within(a, b, budget);
                budget -= on_edge.len();
                divided.extend(on_edge.into_iter().filter(|p| !outline.contains(p)));
            }
        }
        *outline = divided;
    }
}

fn edges(outline: &[u32]) -> impl Iterator<Item = (u32, u32)> {
    let next = outline.iter().cycle().skip(1);
    outline.iter().copied().zip(next.copied())
}

/// Points sorted so that those in the middle divide the others: a k-d tree without nodes.
struct PointTree<'a> {
    order: &'a [u32],
    points: &'a [DVec3],
    tolerance: f64,
}

impl<'a> PointTree<'a> {
    fn new(order: &'a mut [u32], points: &'a [DVec3], tolerance: f64) -> PointTree<'a> {
        sort(order, points, 0);
        PointTree {
            order,
            points,
            tolerance,
        }
    }

    /// The points strictly within an edge, in its direction; none if there are more than `most`.
    fn within(&self, from: u32, to: u32, most: usize) -> Vec<u32> {
        let [start, end] = [from, to].map(|p| self.points[p as usize]);
        let edge = SplitEdge {
            start,
            way: end - start,
            tolerance: self.tolerance,
            most: most + 2,
        };
        let mut points = Vec::new();
        self.search(self.order, 0, &edge, (0.0, 1.0), &mut points);
        points.retain(|&(_, p)| p != from && p != to);
        if points.len() > most {
            return Vec::new();
        }
        points.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        points.into_iter().map(|(_, p)| p).collect()
    }

    /// Searches the part of the edge between two parameters.
    fn search(
        &self,
        order: &[u32],
        axis: usize,
        edge: &SplitEdge,
        part: (f64, f64),
        points: &mut Vec<(f64, u32)>,
    ) {
        let middle = order.len() / 2;
        let Some(&point) = order.get(middle).filter(|_| points.len() <= edge.most) else {
            return;
        };
        let position = self.points[point as usize];
        points.extend(edge.parameter(position).map(|t| (t, point)));
        let next = (axis + 1) % 3;
        let halves = [&order[..middle], &order[middle + 1..]];
        for (half, sign) in halves.into_iter().zip([1.0, -1.0]) {
            if let Some(part) = edge.part_below(sign, axis, position[axis], part) {
                self.search(half, next, edge, part, points);
            }
        }
    }
}

fn sort(order: &mut [u32], points: &[DVec3], axis: usize) {
    if order.len() < 2 {
        return;
    }
    let at = |p: u32| points[p as usize][axis];
    let middle = order.len() / 2;
    order.select_nth_unstable_by(middle, |&p, &q| at(p).total_cmp(&at(q)).then(p.cmp(&q)));
    let (low, high) = order.split_at_mut(middle);
    sort(low, points, (axis + 1) % 3);
    sort(&mut high[1..], points, (axis + 1) % 3);
}

/// An edge that may have points on it.
struct SplitEdge {
    start: DVec3,
    way: DVec3,
    tolerance: f64,
    /// Points after which the search ends.
    most: usize,
}

impl SplitEdge {
    /// Where a point lies on the edge, 0..1; `None` beside it, and at its ends.
    fn parameter(&self, point: DVec3) -> Option<f64> {
        let t = (point - self.start).dot(self.way) / self.way.length_squared();
        let nearest = self.start + t * self.way;
        let is_on = t > 0.0 && t < 1.0 && nearest.distance(point) <= self.tolerance;
        is_on.then_some(t)
    }

    /// The part of the part of the edge that is below a coordinate (above it for sign −1), or not farther
    /// above than the tolerance; `None` if there is none.
    fn part_below(
        &self,
        sign: f64,
        axis: usize,
        limit: f64,
        (low, high): (f64, f64),
    ) -> Option<(f64, f64)> {
        let (start, way) = (sign * self.start[axis], sign * self.way[axis]);
        // Twice the tolerance leaves room for rounding.
        let room = sign * limit + 2.0 * self.tolerance - start;
        let part = if way > 0.0 {
            (low, high.min(room / way))
        } else if way < 0.0 {
            (low.max(room / way), high)
        } else if room >= 0.0 {
            (low, high)
        } else {
            return None;
        };
        (part.0 <= part.1).then_some(part)
    }
}
