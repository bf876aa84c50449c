//! Plane figures as polygons.

use super::builder::Weld;
use super::uncrossed::{add_edges, add_whole_edges};
use crate::figure::{Rectangle, Segment};
use crate::{Figure, FillRule};
use glam::DVec2;
use spade::handles::{FixedFaceHandle, InnerTag};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};
use std::collections::HashMap;

/// Corners are rounded to this fraction of the figure's size, so that equal ones coincide.
pub(super) const GRID: f64 = 1.0 / (1u64 << 32) as f64;
/// Ends of lines nearer than this fraction of the figure's size are one.
const SAME: f64 = 1e-8;
/// Curves join smoothly if the direction turns by less than 30° between them.
const SMOOTH_COSINE: f64 = 0.866_025_403_784_438_6;
/// Contours with more corners are simplified within the tolerance.
const MANY_CORNERS: usize = 1 << 12;

pub(super) type Delaunay = ConstrainedDelaunayTriangulation<Point2<f64>>;

/// A figure as polygons.
#[derive(Default)]
pub(crate) struct FlatFigure {
    /// The corners on the border.
    pub points: Vec<DVec2>,
    /// Simple polygons that tile the inside; none of them has a hole.
    pub tiles: Vec<Tile>,
    /// Every edge of the border once, with the inside on its left.
    pub border: Vec<[u32; 2]>,
    /// Whether the border is smooth at each point.
    pub is_smooth: Vec<bool>,
}

/// A plane figure as polygons.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tiling {
    /// Corners, all on the border of the figure.
    pub points: Vec<DVec2>,
    /// Simple polygons without holes that tile the inside, counter-clockwise, as indices of `points`.
    pub rings: Vec<Vec<u32>>,
}

impl Figure {
    /// The inside as polygons whose edges deviate from the curves by at most `tolerance`, > 0, in the units of the
    /// figure, or twice that where a contour has thousands of curves. Contours may cross and overlap.
    pub fn tiling(&self, tolerance: f64) -> Tiling {
        let flat = FlatFigure::new(self, tolerance);
        Tiling {
            points: flat.points,
            rings: flat.tiles.into_iter().map(|tile| tile.ring).collect(),
        }
    }
}

/// A simple polygon.
pub(crate) struct Tile {
    /// Its corners, counter-clockwise.
    pub ring: Vec<u32>,
    /// The triangles that were merged into it.
    pub triangles: Vec<[u32; 3]>,
}

impl FlatFigure {
    /// Flattens a figure; chords deviate from the curves by at most `tolerance`, > 0, or twice that
    /// where a contour has thousands of curves.
    ///
    /// Contours may cross, overlap and repeat each other: the inside by the figure's rule, applied
    /// to the polygons, is triangulated, and the border is the border of that triangulation. Where
    /// thousands of curves cross, crossings beyond a limit remain inexact, but inside and border
    /// stay consistent.
    pub fn new(figure: &Figure, tolerance: f64) -> FlatFigure {
        let (origin, size) = extent(figure);
        if !(size > 0.0 && size.is_finite()) {
            return FlatFigure::default();
        }
        let round = |p: DVec2| ((p - origin) / (size * GRID)).round() * GRID;
        let mut outline = FlattenedContours::new(figure, tolerance, round);
        outline.simplify(tolerance / size);
        outline.filled(figure.rule, &[], (origin, size))
    }

    /// The same figure with more points, so that these lines inside are edges too.
    pub fn divided(&self, lines: &[[DVec2; 2]]) -> FlatFigure {
        let bounds = Rectangle::around(self.points.iter().copied());
        let (origin, size) = (bounds.min, bounds.size().max_element());
        if !(size > 0.0 && size.is_finite()) {
            return FlatFigure::default();
        }
        let round = |p: DVec2| ((p - origin) / (size * GRID)).round() * GRID;
        let points: Vec<DVec2> = self.points.iter().map(|&p| round(p)).collect();
        // Lines that end in one place would cross if rounding separated their ends.
        let mut weld = Weld::new(SAME);
        for p in &points {
            weld.number(p.extend(0.0));
        }
        let mut welded = |p: DVec2| {
            let number = weld.number(round(p).extend(0.0));
            weld.positions[number as usize].truncate()
        };
        let lines: Vec<[DVec2; 2]> = lines.iter().map(|line| line.map(&mut welded)).collect();
        let loops = self.loops().into_iter();
        let contours = loops.map(|ring| ring.into_iter().map(|k| points[k as usize]).collect());
        let outline = FlattenedContours {
            contours: contours.collect(),
            smooth: points
                .iter()
                .map(|p| key(*p))
                .zip(self.is_smooth.iter().copied())
                .collect(),
        };
        outline.filled(FillRule::NonZero, &lines, (origin, size))
    }

    /// The border as closed chains of points.
    fn loops(&self) -> Vec<Vec<u32>> {
        let mut next: HashMap<u32, Vec<u32>> = HashMap::new();
        for &[a, b] in &self.border {
            next.entry(a).or_default().push(b);
        }
        let mut loops = Vec::new();
        for &[start, _] in &self.border {
            let mut ring = Vec::new();
            let mut at = start;
            while let Some(on) = next.get_mut(&at).and_then(Vec::pop) {
                ring.push(at);
                at = on;
            }
            if !ring.is_empty() {
                loops.push(ring);
            }
        }
        loops
    }

    /// Adds the border of the faces that are inside, and their corners. Returns them as triangles.
    pub fn collect(&mut self, mesh: &Delaunay, inside: &[bool]) -> Vec<[u32; 3]> {
        let mut number = HashMap::new();
        let mut triangles = Vec::new();
        for face in mesh.inner_faces().filter(|f| inside[f.fix().index()]) {
            let corners = face.vertices().map(|v| {
                *number.entry(v.fix().index()).or_insert_with(|| {
                    self.points.push(point(v.position()));
                    self.points.len() as u32 - 1
                })
            });
            triangles.push(corners);
            for (k, edge) in face.adjacent_edges().into_iter().enumerate() {
                let beyond = edge.rev().face().as_inner();
                if !beyond.is_some_and(|f| inside[f.fix().index()]) {
                    self.border.push([corners[k], corners[(k + 1) % 3]]);
                }
            }
        }
        triangles
    }
}

/// Lower corner and larger side of the rectangle around a figure.
fn extent(figure: &Figure) -> (DVec2, f64) {
    let bounds = figure.bounds();
    (bounds.min, bounds.size().max_element())
}

/// Flattened contours, rounded, in units of the figure's size.
struct FlattenedContours {
    contours: Vec<Vec<DVec2>>,
    /// Whether the curves are smooth at a corner.
    smooth: HashMap<[u64; 2], bool>,
}

/// Positions as keys.
pub(super) fn key(p: DVec2) -> [u64; 2] {
    // Adding zero turns −0 into 0.
    [p.x + 0.0, p.y + 0.0].map(f64::to_bits)
}

pub(super) fn point(p: Point2<f64>) -> DVec2 {
    DVec2::new(p.x, p.y)
}

impl FlattenedContours {
    fn new(figure: &Figure, tolerance: f64, round: impl Fn(DVec2) -> DVec2) -> FlattenedContours {
        let mut outline = FlattenedContours {
            contours: Vec::new(),
            smooth: HashMap::new(),
        };
        for contour in &figure.contours {
            let segments: Vec<Segment> = contour.segments().collect();
            let mut corners = Vec::new();
            for (k, segment) in segments.iter().enumerate() {
                let before = &segments[(k + segments.len() - 1) % segments.len()];
                let is_smooth = is_smooth(before, segment);
                let count = segment.chords(tolerance);
                for step in 0..count {
                    let p = round(segment.at(f64::from(step) / f64::from(count)));
                    let known = outline.smooth.entry(key(p)).or_insert(true);
                    *known &= is_smooth || step > 0;
                    corners.push(p);
                }
            }
            corners.dedup();
            outline.contours.push(corners);
        }
        outline
    }

    /// Simplifies large contours; the result passes all removed corners within `tolerance`.
    fn simplify(&mut self, tolerance: f64) {
        let long = |c: &&mut Vec<DVec2>| c.len() > MANY_CORNERS;
        for contour in self.contours.iter_mut().filter(long) {
            *contour = simplified(contour, tolerance);
        }
    }

    /// The inside, divided along further lines; `place` is the origin and the size of the figure.
    fn filled(&self, rule: FillRule, lines: &[[DVec2; 2]], place: (DVec2, f64)) -> FlatFigure {
        let mesh = self.triangulated(lines);
        let inside = self.inside(&mesh, rule);
        let mut flat = FlatFigure::default();
        let triangles = flat.collect(&mesh, &inside);
        flat.is_smooth = flat.points.iter().map(|p| self.is_smooth(*p)).collect();
        flat.tiles = tiles(&triangles);
        for p in &mut flat.points {
            *p = place.0 + place.1 * *p;
        }
        flat
    }

    /// Points that are not on the curves come from crossings.
    fn is_smooth(&self, p: DVec2) -> bool {
        self.smooth.get(&key(p)) == Some(&true)
    }

    fn edges(&self) -> impl Iterator<Item = [DVec2; 2]> + '_ {
        let around = |c: &'_ Vec<DVec2>| {
            let n = c.len();
            let c = c.clone();
            (0..n).map(move |k| [c[k], c[(k + 1) % n]])
        };
        self.contours.iter().flat_map(around)
    }

    /// The Delaunay triangulation of all corners and of the ends of `lines`. It has all contours as edges, divided where
    /// they cross, and those lines that cross no others.
    fn triangulated(&self, lines: &[[DVec2; 2]]) -> Delaunay {
        let mut mesh = self.delaunay(lines);
        add_edges(&mut mesh, self.edges().collect(), GRID);
        // Lines that cross others come from rounding: their ends are points of the mesh in any case.
        add_whole_edges(&mut mesh, lines);
        mesh
    }

    /// The Delaunay triangulation of all corners.
    fn delaunay(&self, lines: &[[DVec2; 2]]) -> Delaunay {
        let points = self.contours.iter().flatten().chain(lines.as_flattened());
        let corners: Vec<_> = points.map(|p| Point2::new(p.x, p.y)).collect();
        if corners.len() > MANY_CORNERS {
            // Inserting many corners in their order along a contour is the slowest order.
            return Delaunay::bulk_load(corners).unwrap_or_default();
        }
        let mut mesh = Delaunay::new();
        for corner in corners {
            // Only points that are not finite would be left out, and there are none.
            let _ = mesh.insert(corner);
        }
        mesh
    }

    /// Whether each face of the triangulation is inside. Connected faces that no contour separates
    /// are tested once.
    fn inside(&self, mesh: &Delaunay, rule: FillRule) -> Vec<bool> {
        let strips = Strips::new(self.edges().collect());
        // Faces number from 0, the outer one included.
        let mut inside = vec![false; mesh.num_all_faces()];
        let mut seen = inside.clone();
        let mut part: Vec<FixedFaceHandle<InnerTag>> = Vec::new();
        for face in mesh.inner_faces() {
            if std::mem::replace(&mut seen[face.fix().index()], true) {
                continue;
            }
            part.clear();
            part.push(face.fix());
            let mut next = 0;
            let mut widest = (0.0, face.center());
            while next < part.len() {
                let face = mesh.face(part[next]);
                next += 1;
                if face.area() > widest.0 {
                    widest = (face.area(), face.center());
                }
                let crossed = face.adjacent_edges().into_iter();
                for edge in crossed.filter(|e| !e.is_constraint_edge()) {
                    let Some(beyond) = edge.rev().face().as_inner() else {
                        continue;
                    };
                    if !std::mem::replace(&mut seen[beyond.fix().index()], true) {
                        part.push(beyond.fix());
                    }
                }
            }
            let is_inside = rule.is_inside(strips.winding(point(widest.1)));
            part.iter().for_each(|f| inside[f.index()] = is_inside);
        }
        inside
    }
}

/// A polygon through some corners of another, which passes all of them within `tolerance`.
///
/// Sklansky and Gonzalez, *Fast polygonal approximation of digitized curves*, Pattern Recognition
/// 12, 1980: from each corner that is kept, the wedge of directions that pass all since.
fn simplified(corners: &[DVec2], tolerance: f64) -> Vec<DVec2> {
    let mut kept = vec![corners[0]];
    let mut wedge: Option<[DVec2; 2]> = None;
    let (mut last, mut reach) = (corners[0], 0.0_f64);
    for &p in &corners[1..] {
        let goes_on = |[right, left]: [DVec2; 2], way: DVec2| {
            right.perp_dot(way) >= 0.0 && left.perp_dot(way) <= 0.0
        };
        let way = p - kept[kept.len() - 1];
        let turns_back = way.length() < reach - tolerance;
        if turns_back || wedge.is_some_and(|w| !goes_on(w, way)) {
            kept.push(last);
            (wedge, reach) = (None, 0.0);
        }
        let way = p - kept[kept.len() - 1];
        let length = way.length();
        reach = reach.max(length);
        if length > tolerance {
            let sine = tolerance / length;
            let turn = DVec2::new((1.0 - sine * sine).sqrt(), sine);
            let (right, left) = (DVec2::new(turn.x, -turn.y).rotate(way), turn.rotate(way));
            wedge = Some(match wedge {
                Some([r, l]) => [
                    if r.perp_dot(right) > 0.0 { right } else { r },
                    if l.perp_dot(left) < 0.0 { left } else { l },
                ],
                None => [right, left],
            });
        }
        last = p;
    }
    kept.push(last);
    kept
}

/// Whether one curve continues into the next without a corner.
fn is_smooth(before: &Segment, after: &Segment) -> bool {
    let (arrival, departure) = (-before.reversed().departure(), after.departure());
    let cosine = arrival
        .normalize_or_zero()
        .dot(departure.normalize_or_zero());
    cosine > SMOOTH_COSINE
}

/// Edges sorted into horizontal strips, for winding numbers.
pub(super) struct Strips {
    edges: Vec<[DVec2; 2]>,
    low: f64,
    height: f64,
    lists: Vec<Vec<u32>>,
}

impl Strips {
    /// Sorts edges.
    pub fn new(edges: Vec<[DVec2; 2]>) -> Strips {
        let heights = || edges.iter().map(|e| e[0].y);
        let low = heights().fold(f64::INFINITY, f64::min);
        let high = heights().fold(f64::NEG_INFINITY, f64::max);
        let mut count = (edges.len() / 8).max(1);
        let mut strips = Strips {
            low,
            height: (high - low).max(f64::MIN_POSITIVE),
            lists: Vec::new(),
            edges,
        };
        // Tall edges are listed in many strips: the number of strips is reduced until the lists are
        // in proportion.
        while count > 1 && strips.entries(count) > 8 * strips.edges.len() {
            count /= 2;
        }
        strips.lists = vec![Vec::new(); count];
        for (k, edge) in (0..).zip(&strips.edges) {
            let (first, last) = (
                strips.strip(edge[0].y, count),
                strips.strip(edge[1].y, count),
            );
            let reach = first.min(last)..=first.max(last);
            strips.lists[reach].iter_mut().for_each(|list| list.push(k));
        }
        strips
    }

    fn strip(&self, y: f64, count: usize) -> usize {
        let share = (y - self.low) / self.height;
        ((share * count as f64) as usize).min(count - 1)
    }

    fn entries(&self, count: usize) -> usize {
        let reach = |e: &[DVec2; 2]| {
            let [a, b] = e.map(|p| self.strip(p.y, count));
            a.abs_diff(b) + 1
        };
        self.edges.iter().map(reach).sum()
    }

    /// Numbers of edges that are at similar heights.
    pub fn lists(&self) -> &[Vec<u32>] {
        &self.lists
    }

    /// The edges near a height, by their numbers.
    pub fn at(&self, y: f64) -> &[u32] {
        &self.lists[self.strip(y, self.lists.len())]
    }

    /// The winding number of the edges about a point.
    pub fn winding(&self, p: DVec2) -> i32 {
        let list = self.at(p.y);
        let turn = |&k: &u32| {
            let [a, b] = self.edges[k as usize];
            let up = i32::from(b.y > p.y) - i32::from(a.y > p.y);
            let ahead = f64::from(up) * (b - a).perp_dot(p - a) > 0.0;
            if ahead { up } else { 0 }
        };
        list.iter().map(turn).sum()
    }
}

/// Merges triangles into simple polygons, which have each corner once.
///
/// A large polygon can be divided into better patches than thin triangles.
pub(super) fn tiles(triangles: &[[u32; 3]]) -> Vec<Tile> {
    let mut across = HashMap::new();
    for (t, corners) in triangles.iter().enumerate() {
        for k in 0..3 {
            across.insert([corners[k], corners[(k + 1) % 3]], t);
        }
    }
    let mut taken = vec![false; triangles.len()];
    let mut tiles = Vec::new();
    for first in 0..triangles.len() {
        if !taken[first] {
            taken[first] = true;
            tiles.push(grown(triangles, first, &across, &mut taken));
        }
    }
    tiles
}

/// The largest simple polygon that results from adding neighbours to a triangle.
fn grown(
    triangles: &[[u32; 3]],
    first: usize,
    across: &HashMap<[u32; 2], usize>,
    taken: &mut [bool],
) -> Tile {
    let [a, b, c] = triangles[first];
    let mut members = vec![triangles[first]];
    // The ring as a map from each corner to the next.
    let mut next = HashMap::from([(a, b), (b, c), (c, a)]);
    let mut open = vec![[a, b], [b, c], [c, a]];
    let mut waiting = 0;
    while waiting < open.len() {
        let [a, b] = open[waiting];
        waiting += 1;
        let Some(&t) = across.get(&[b, a]).filter(|&&t| !taken[t]) else {
            continue;
        };
        let apex = triangles[t].into_iter().find(|&v| v != a && v != b);
        let Some(apex) = apex.filter(|_| next.get(&a) == Some(&b)) else {
            continue;
        };
        if next.get(&apex) == Some(&a) {
            next.remove(&a);
            next.insert(apex, b);
            open.push([apex, b]);
        } else if next.get(&b) == Some(&apex) {
            next.remove(&b);
            next.insert(a, apex);
            open.push([a, apex]);
        } else if !next.contains_key(&apex) {
            next.extend([(a, apex), (apex, b)]);
            open.extend([[a, apex], [apex, b]]);
        } else {
            continue;
        }
        taken[t] = true;
        members.push(triangles[t]);
    }
    let start = next.keys().copied().min().unwrap_or(a);
    let mut ring = vec![start];
    while let Some(&v) = next.get(&ring[ring.len() - 1]).filter(|&&v| v != start) {
        ring.push(v);
    }
    Tile {
        ring,
        triangles: members,
    }
}
