//! The triangles of one solid.

use super::{coarseness, height, single};
use azulejo_scene::{MaterialId, Mesh};
use glam::DVec3;
use std::collections::{BTreeMap, HashMap};

/// Longest border of a gap that is filled.
const LONGEST_GAP: usize = 1 << 12;
/// How often all needles are looked at: what a flip leaves may be a needle as well.
const PASSES: u32 = 4;

/// Triangles over shared positions of single precision, counter-clockwise from outside.
#[derive(Default)]
pub(super) struct Shell {
    pub positions: Vec<DVec3>,
    pub triangles: Vec<([u32; 3], MaterialId)>,
}

impl Shell {
    /// Rounds a mesh; equal positions are one. Triangles whose corners coincide are left out, and so are pairs of
    /// opposite ones.
    pub fn new(mesh: &Mesh) -> Shell {
        let mut shell = Shell::default();
        let mut known = HashMap::new();
        let mut number = |p: DVec3| {
            let p = single(p);
            *known
                .entry(p.to_array().map(f64::to_bits))
                .or_insert_with(|| {
                    shell.positions.push(p);
                    shell.positions.len() as u32 - 1
                })
        };
        let numbers: Vec<u32> = mesh.positions.iter().map(|&p| number(p)).collect();
        let mut pieces = Vec::new();
        for face in 0..mesh.faces.len() {
            pieces.clear();
            mesh.triangulate_into(face, &mut pieces);
            let ring = mesh.faces.get(face);
            let corners = pieces
                .iter()
                .map(|t| t.map(|k| numbers[ring[k as usize] as usize]));
            let material = mesh.face_materials[face];
            let whole = corners.filter(|[a, b, c]| a != b && b != c && c != a);
            shell.triangles.extend(whole.map(|t| (t, material)));
        }
        shell.cancel();
        shell
    }

    fn points(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|v| self.positions[v as usize])
    }

    /// Removes pairs of triangles with the same corners in opposite orders.
    fn cancel(&mut self) {
        let key = |t: [u32; 3]| {
            let mut sorted = t;
            sorted.sort_unstable();
            let first = t.iter().position(|v| *v == sorted[0]).unwrap_or(0);
            (sorted, t[(first + 1) % 3] == sorted[1])
        };
        let mut surplus: HashMap<[u32; 3], [usize; 2]> = HashMap::new();
        for (t, _) in &self.triangles {
            let (corners, is_even) = key(*t);
            surplus.entry(corners).or_default()[usize::from(is_even)] += 1;
        }
        for counts in surplus.values_mut() {
            *counts = [counts[0].min(counts[1]); 2];
        }
        self.triangles.retain(|(t, _)| {
            let (corners, is_even) = key(*t);
            let left = surplus.get_mut(&corners);
            let left = left.map(|counts| &mut counts[usize::from(is_even)]);
            match left.filter(|left| **left > 0) {
                Some(left) => {
                    *left -= 1;
                    false
                }
                None => true,
            }
        });
    }

    /// Fills gaps that are at most that wide; returns the number of edges that remain open.
    pub fn close(&mut self, gap: f64) -> usize {
        let mut missing = self.missing();
        let material = self.triangles.first().map_or(0, |t| t.1);
        while let Some((&start, _)) = missing.first_key_value() {
            let border = next_loop(&mut missing, start);
            self.fill(border, gap, material);
        }
        self.cancel();
        self.missing().values().map(Vec::len).sum()
    }

    /// The edges that lack a triangle, by the vertex where they start.
    fn missing(&self) -> BTreeMap<u32, Vec<u32>> {
        let mut surplus: HashMap<[u32; 2], i64> = HashMap::new();
        for (t, _) in &self.triangles {
            for k in 0..3 {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                *surplus.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
            }
        }
        let mut missing: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for ([a, b], count) in surplus {
            let (from, to) = if count > 0 { (b, a) } else { (a, b) };
            for _ in 0..count.unsigned_abs() {
                missing.entry(from).or_default().push(to);
            }
        }
        // In an order that does not depend on that of the map.
        missing.values_mut().for_each(|to| to.sort_unstable());
        missing
    }

    /// Adds triangles over a border, the flattest ears first, while they are no higher than `gap`.
    fn fill(&mut self, mut border: Vec<u32>, gap: f64, material: MaterialId) {
        if border.len() > LONGEST_GAP {
            return;
        }
        let known = self.triangles.len();
        while border.len() > 2 {
            let n = border.len();
            let ear = |k: usize| [border[(k + n - 1) % n], border[k], border[(k + 1) % n]];
            let rise = |k: usize| {
                let [a, p, b] = self.points(ear(k));
                let share = (p - a).dot(b - a) / a.distance_squared(b);
                p.distance(a + share.clamp(0.0, 1.0) * (b - a))
            };
            let flattest = (0..n).map(|k| (rise(k), k));
            let Some((rise, k)) = flattest.min_by(|a, b| a.0.total_cmp(&b.0)) else {
                break;
            };
            if rise.is_nan() || rise > gap {
                // Rather as it was than half filled.
                self.triangles.truncate(known);
                return;
            }
            self.triangles.push((ear(k), material));
            border.remove(k);
        }
    }

    /// Replaces triangles that are as good as lines: with the neighbour across the longest side, the other diagonal.
    pub fn flip_needles(&mut self) {
        for _ in 0..PASSES {
            let needles: Vec<usize> = (0..self.triangles.len())
                .filter(|&t| self.is_needle(t))
                .collect();
            if needles.is_empty() {
                return;
            }
            let mut across = EdgeUses::new(self);
            needles.iter().for_each(|&t| self.flip(t, &mut across));
        }
    }

    fn is_needle(&self, triangle: usize) -> bool {
        let points = self.points(self.triangles[triangle].0);
        height(points).1 <= 0.25 * coarseness(points)
    }

    fn flip(&mut self, needle: usize, across: &mut EdgeUses) {
        if !self.is_needle(needle) {
            return;
        }
        let t = self.triangles[needle].0;
        let (k, _) = height(self.points(t));
        // The longest side goes from c to a.
        let [b, c, a] = [t[k], t[(k + 1) % 3], t[(k + 2) % 3]];
        let (Some(_), Some(beyond)) = (across.only([c, a]), across.only([a, c])) else {
            return;
        };
        let (other, material) = self.triangles[beyond];
        let Some(d) = other.into_iter().find(|&v| v != a && v != c) else {
            return;
        };
        if d == b || across.is_used([b, d]) {
            return;
        }
        for t in [needle, beyond] {
            across.remove(t, self.triangles[t].0);
        }
        self.triangles[needle] = ([a, b, d], material);
        self.triangles[beyond] = ([b, c, d], material);
        for t in [needle, beyond] {
            across.add(t, self.triangles[t].0);
        }
    }

    /// Gives every umbrella of triangles around a vertex a vertex of its own, so that edges have two triangles: those
    /// between which the inside is.
    pub fn split_vertices(&mut self) {
        let mut corners = Corners::new(3 * self.triangles.len());
        let mut edges: Vec<(u32, u32, u32)> = Vec::with_capacity(corners.0.len());
        for (n, (t, _)) in (0..).zip(&self.triangles) {
            for k in 0..3 {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                edges.push((a.min(b), a.max(b), 3 * n + k as u32));
            }
        }
        edges.sort_unstable();
        for uses in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            for [one, other] in self.pairs(uses) {
                corners.join(one, next(other));
                corners.join(next(one), other);
            }
        }
        let mut numbers = HashMap::new();
        let mut positions = Vec::new();
        for n in 0..self.triangles.len() {
            for k in 0..3 {
                let old = self.triangles[n].0[k];
                let root = corners.root((3 * n + k) as u32);
                let number = *numbers.entry(root).or_insert_with(|| {
                    positions.push(self.positions[old as usize]);
                    positions.len() as u32 - 1
                });
                self.triangles[n].0[k] = number;
            }
        }
        self.positions = positions;
    }

    /// The uses of one edge in pairs.
    fn pairs(&self, uses: &[(u32, u32, u32)]) -> Vec<[u32; 2]> {
        let &[(low, high, first), ref others @ ..] = uses else {
            return Vec::new();
        };
        if let [(_, _, second)] = others {
            return vec![[first, *second]];
        }
        let [from, to] = [low, high].map(|v| self.positions[v as usize]);
        let axis = (to - from).normalize_or(DVec3::X);
        let (x, y) = axis.any_orthonormal_pair();
        // By angle around the edge, counter-clockwise: the inside lies after a triangle that uses the edge backwards.
        let mut around: Vec<(f64, u32, bool)> = Vec::with_capacity(uses.len());
        for &(_, _, half) in uses {
            let (t, k) = (self.triangles[half as usize / 3].0, half as usize % 3);
            let apex = self.positions[t[(k + 2) % 3] as usize] - from;
            around.push((apex.dot(y).atan2(apex.dot(x)), half, t[k] == low));
        }
        around.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let (mut open, mut pairs) = (Vec::new(), Vec::new());
        let mut paired = vec![false; around.len()];
        for k in (0..around.len()).chain(0..around.len()) {
            let (_, half, is_forward) = around[k];
            if paired[k] {
                continue;
            }
            if !is_forward {
                if !open.contains(&k) {
                    open.push(k);
                }
            } else if let Some(partner) = open.pop() {
                (paired[k], paired[partner]) = (true, true);
                pairs.push([around[partner].1, half]);
            }
        }
        pairs
    }
}

/// A closed chain of edges from a vertex, which are removed.
fn next_loop(missing: &mut BTreeMap<u32, Vec<u32>>, start: u32) -> Vec<u32> {
    let mut border = vec![start];
    while let Some(to) = missing.get_mut(&border[border.len() - 1]) {
        let Some(v) = to.pop() else { break };
        if to.is_empty() {
            missing.remove(&border[border.len() - 1]);
        }
        if let Some(at) = border.iter().position(|known| *known == v) {
            // What went before has to wait for another turn.
            for pair in border[..=at].windows(2) {
                missing.entry(pair[0]).or_default().push(pair[1]);
            }
            return border.split_off(at);
        }
        border.push(v);
    }
    // Not closed, which a cycle cannot be.
    Vec::new()
}

/// The next corner of a triangle, of all corners counted.
fn next(corner: u32) -> u32 {
    corner - corner % 3 + (corner % 3 + 1) % 3
}

/// The triangles at directed edges.
struct EdgeUses(HashMap<[u32; 2], Vec<usize>>);

impl EdgeUses {
    fn new(shell: &Shell) -> EdgeUses {
        let mut uses = EdgeUses(HashMap::with_capacity(3 * shell.triangles.len()));
        for (t, (corners, _)) in shell.triangles.iter().enumerate() {
            uses.add(t, *corners);
        }
        uses
    }

    fn add(&mut self, t: usize, corners: [u32; 3]) {
        for k in 0..3 {
            let edge = [corners[k], corners[(k + 1) % 3]];
            self.0.entry(edge).or_default().push(t);
        }
    }

    fn remove(&mut self, t: usize, corners: [u32; 3]) {
        for k in 0..3 {
            let edge = [corners[k], corners[(k + 1) % 3]];
            if let Some(uses) = self.0.get_mut(&edge) {
                uses.retain(|&other| other != t);
            }
        }
    }

    /// The triangle of an edge that has one.
    fn only(&self, edge: [u32; 2]) -> Option<usize> {
        match self.0.get(&edge)?.as_slice() {
            [one] => Some(*one),
            _ => None,
        }
    }

    fn is_used(&self, [a, b]: [u32; 2]) -> bool {
        let some = |edge: [u32; 2]| self.0.get(&edge).is_some_and(|uses| !uses.is_empty());
        some([a, b]) || some([b, a])
    }
}

/// Corners of triangles in sets that are one vertex each.
struct Corners(Vec<u32>);

impl Corners {
    fn new(count: usize) -> Corners {
        Corners((0..count as u32).collect())
    }

    fn root(&mut self, mut corner: u32) -> u32 {
        while self.0[corner as usize] != corner {
            let above = self.0[self.0[corner as usize] as usize];
            self.0[corner as usize] = above;
            corner = above;
        }
        corner
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}
