//! Regions that no regular pattern fits: squares inside, triangles between them and the border.
//!
//! The points on the sides are given, since the neighbours have them too. A square lattice fills
//! the inside; a constrained Delaunay triangulation joins its outline to the border, and Chew's
//! refinement ("Guaranteed-quality mesh generation for curved surfaces", SoCG 1993; here
//! `spade`'s, with border and lattice kept) adds points where angles are still small, as beside
//! short sides. Lines through the region, where other faces touch it, become edges of patches.

use super::cells::NO_CORNER;
use super::contacts::Contact;
use super::keep;
use super::lattice::Lattice;
use super::lines::{LinePoint, Lines};
use super::marks::Marks;
use super::outline::{Outline, Region, Slot};
use glam::{DVec2, DVec3};
use spade::handles::{FixedFaceHandle, InnerTag};
use spade::{
    AngleLimit, ConstrainedDelaunayTriangulation, Point2, RefinementParameters, Triangulation,
};
use std::collections::{HashMap, HashSet};

/// Edges longer than this share of the size are halved, in so many rounds.
const LONG_EDGE: f64 = 1.45;
const LONG_EDGE_ROUNDS: usize = 6;
/// How far from the border, as a share of the size, a line stops that may not cut it.
const STOP: f64 = 0.1;
/// Angles below this are refined away where the border allows it.
const ANGLE_DEGREES: f64 = 22.0;

/// An irregular division of one region.
pub(super) struct Irregular {
    /// Pieces of each side.
    pub sides: Vec<u32>,
    /// The region's corners in its plane, about 1 across.
    pub corners: Vec<DVec2>,
    /// Points in the same plane: those of the border in order, then those inside.
    pub points: Vec<DVec2>,
    /// Local points of each patch, counter-clockwise: `squares` of the lattice, then triangles,
    /// whose fourth corner is `NO_CORNER`.
    pub cells: Vec<[u32; 4]>,
    /// How many patches are squares.
    pub squares: usize,
    /// Lattice spacing, or about 1 where there is no lattice.
    pub spacing: f64,
    /// A point of the lattice.
    pub origin: DVec2,
    /// Edges along which other faces touch or cross the region, as pairs of points.
    pub contacts: Vec<[u32; 2]>,
    /// Each point as a mean of three corners of the region.
    pub weights: Vec<[(u32, f64); 3]>,
}

impl Irregular {
    /// Divides a region whose sides are divided by `marks` into patches of about `size` (scene
    /// units; infinity for as large as the border allows), none of them across one of `lines`.
    ///
    /// A region that is no longer than √2 `size`, has whole sides and no lines becomes its own
    /// triangles. Where the triangulation fails (a border that touches itself within rounding)
    /// each of the region's triangles is divided about its centre: thin, but without cracks.
    pub fn new(
        outline: &Outline,
        region: &Region,
        marks: &Marks,
        lines: Option<&Lines>,
        size: f64,
    ) -> Irregular {
        let (corners, scale) = flatten(outline, region);
        let (slots, own) = (outline.slots_of(region), outline.triangles_of(region));
        let border = Border::new(&corners, slots, marks);
        let ring = Ring {
            corners: &corners,
            border: &border.points,
            lines: lines.map(|lines| line_edges(lines, &border, size * scale)),
            size: size * scale,
        };
        let sides: Vec<u32> = slots
            .iter()
            .map(|s| marks.pieces[s.edge as usize])
            .collect();
        let mesh = ring.divided(&sides, own);
        let mut irregular = Irregular {
            weights: Vec::new(),
            sides,
            points: mesh.points,
            cells: mesh.lattice.squares(mesh.base),
            squares: mesh.lattice.len(),
            spacing: mesh.lattice.spacing,
            origin: mesh.lattice.origin,
            contacts: mesh.contacts,
            corners,
        };
        irregular.add_triangles(mesh.triangles);
        irregular.weights = irregular.corner_weights(slots, marks, own);
        irregular
    }

    /// Number of points on the border, which come first.
    pub fn border(&self) -> usize {
        self.sides.iter().map(|&k| k as usize).sum()
    }

    /// Appends the triangles that have an area, neighbours near each other in the numbering:
    /// whoever looks up many finds them in the cache.
    fn add_triangles(&mut self, mut triangles: Vec<[u32; 3]>) {
        let at = |k: u32| self.points[k as usize];
        triangles.retain(|t| signed_area(t.map(at)) > 0.0);
        let (low, high) = bounds(&self.points);
        let tiles = (triangles.len() as f64 / 32.0).sqrt().ceil();
        let scale = tiles / (high - low).max_element();
        triangles.sort_by_cached_key(|t| {
            let sum: DVec2 = t.iter().map(|&k| at(k)).sum();
            let tile = (sum / 3.0 - low) * scale;
            (tile.y as u32, tile.x as u32)
        });
        let cells = triangles.into_iter().map(|[a, b, c]| [a, b, c, NO_CORNER]);
        self.cells.extend(cells);
    }

    fn corner_weights(
        &self,
        slots: &[Slot],
        marks: &Marks,
        own: &[[u32; 3]],
    ) -> Vec<[(u32, f64); 3]> {
        let n = self.corners.len() as u32;
        let mut weights = Vec::with_capacity(self.points.len());
        for (c, slot) in (0..).zip(slots) {
            weights.extend((0..self.sides[c as usize]).map(|i| {
                let share = marks.share_on(slot, i);
                let t = if slot.forward { share } else { 1.0 - share };
                [(c, 1.0 - t), ((c + 1) % n, t), (c, 0.0)]
            }));
        }
        let inside = &self.points[self.border()..];
        weights.extend(inside.iter().map(|&p| self.weights_at(p, own)));
        weights
    }

    /// Barycentric weights in the triangle that holds `p`, or, by rounding, nearly does.
    fn weights_at(&self, p: DVec2, own: &[[u32; 3]]) -> [(u32, f64); 3] {
        let mut best = ([0; 3], [1.0, 0.0, 0.0], f64::NEG_INFINITY);
        for &t in own {
            let b = barycentric(t.map(|k| self.corners[k as usize]), p);
            let least = b[0].min(b[1]).min(b[2]);
            if least > best.2 {
                best = (t, b, least);
            }
            if least >= 0.0 {
                break;
            }
        }
        let positive = best.1.map(|w| w.max(0.0));
        let sum: f64 = positive.iter().sum();
        [0, 1, 2].map(|i| (best.0[i], positive[i] / sum))
    }
}

/// About how many patches [`Irregular::new`] makes, from the region's area and the lengths and
/// piece counts of its sides: squares inside, triangles in a ring as wide as one and a bit.
pub(super) fn expected_patches(area: f64, sides: &[(f64, u32)], size: f64) -> f64 {
    let border: f64 = sides.iter().map(|s| f64::from(s.1)).sum();
    let perimeter: f64 = sides.iter().map(|s| s.0).sum();
    let square = size * size;
    let inside = (area - 1.1 * size * perimeter + 4.0 * square).clamp(0.0, area);
    let ring = (area - inside) / (0.36 * square);
    inside / square + ring.max(border - 2.0)
}

/// The corners in the region's plane, the longest side along x, scaled to about 1; and the scale.
pub(super) fn flatten(outline: &Outline, region: &Region) -> (Vec<DVec2>, f64) {
    let frame = Frame::new(outline, region);
    let slots = outline.slots_of(region);
    let corners = slots.iter().map(|s| frame.flat(s.position)).collect();
    (corners, frame.scale)
}

/// The lines through the region in the same coordinates as [`flatten`].
pub(super) fn flatten_contacts(
    outline: &Outline,
    region: &Region,
    contacts: &[Contact],
) -> Vec<[DVec2; 2]> {
    let frame = Frame::new(outline, region);
    let inside = contacts.iter().filter(|c| c.inside);
    inside.map(|c| c.ends.map(|p| frame.flat(p))).collect()
}

/// Coordinates in a region's plane.
struct Frame {
    origin: DVec3,
    x: DVec3,
    y: DVec3,
    scale: f64,
}

impl Frame {
    fn new(outline: &Outline, region: &Region) -> Frame {
        let slots = outline.slots_of(region);
        let n = slots.len();
        let side = |k: usize| slots[(k + 1) % n].position - slots[k].position;
        let longest = (0..n).fold(0, |best, k| {
            if side(k).length_squared() > side(best).length_squared() {
                k
            } else {
                best
            }
        });
        let x = side(longest).normalize_or_zero();
        Frame {
            origin: slots[0].position,
            x,
            y: region.normal.cross(x),
            scale: 1.0 / side(longest).length(),
        }
    }

    fn flat(&self, p: DVec3) -> DVec2 {
        let d = p - self.origin;
        DVec2::new(d.dot(self.x), d.dot(self.y)) * self.scale
    }
}

fn diameter(points: &[DVec2]) -> f64 {
    let (low, high) = bounds(points);
    low.distance(high)
}

pub(super) fn bounds(points: &[DVec2]) -> (DVec2, DVec2) {
    points
        .iter()
        .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), &p| {
            (low.min(p), high.max(p))
        })
}

/// Point `i` of the side from `a` to `b`, with the same bits for the two sides of an edge: where a
/// cut joins a hole to the outline they must meet.
fn side_point(a: DVec2, b: DVec2, slot: &Slot, marks: &Marks, i: u32) -> DVec2 {
    let (from, to) = if slot.forward { (a, b) } else { (b, a) };
    if i == 0 {
        a
    } else {
        from + (to - from) * marks.share_on(slot, i)
    }
}

/// The points of lines that are not on the border, and the pieces as pairs of local points: those
/// of the border, then these.
///
/// A line that ends between two points of the border, where no face but this one has lines and
/// the border may not be cut, goes to a point near by, or stops short of the border.
fn line_edges(lines: &Lines, border: &Border, size: f64) -> LineEdges {
    let mut points = lines.points.clone();
    let mut stops: HashMap<(u32, u64), u32> = HashMap::new();
    let base = border.points.len() as u32;
    let mut local = |p: LinePoint| match p {
        LinePoint::Inside(k) => base + k,
        LinePoint::Border { side, share } => {
            let (point, inward) = border.at(side as usize, share);
            let nearest = border.nearest(side as usize, share);
            if border.points[nearest as usize].distance(point) <= STOP * size {
                return nearest;
            }
            *stops.entry((side, share.to_bits())).or_insert_with(|| {
                points.push(point + STOP * size * inward);
                base + points.len() as u32 - 1
            })
        }
    };
    let edges = lines.edges.iter().map(|e| e.map(&mut local)).collect();
    (points, edges)
}

/// The divided border of a region.
struct Border<'a> {
    corners: &'a [DVec2],
    slots: &'a [Slot],
    marks: &'a Marks,
    points: Vec<DVec2>,
}

impl<'a> Border<'a> {
    fn new(corners: &'a [DVec2], slots: &'a [Slot], marks: &'a Marks) -> Border<'a> {
        let n = corners.len();
        let side = |c: usize| {
            let (a, b, slot) = (corners[c], corners[(c + 1) % n], &slots[c]);
            (0..marks.pieces[slot.edge as usize]).map(move |i| side_point(a, b, slot, marks, i))
        };
        Border {
            corners,
            slots,
            marks,
            points: (0..n).flat_map(side).collect(),
        }
    }

    /// The point `share` of the way along a side, and the direction from there to the inside.
    fn at(&self, side: usize, share: f64) -> (DVec2, DVec2) {
        let (a, b) = (
            self.corners[side],
            self.corners[(side + 1) % self.corners.len()],
        );
        (a + share * (b - a), (b - a).perp().normalize_or_zero())
    }

    /// The division point of a side that is nearest to `share` of it.
    fn nearest(&self, side: usize, share: f64) -> u32 {
        let pieces = |slot: &Slot| self.marks.pieces[slot.edge as usize];
        let before: u32 = self.slots[..side].iter().map(pieces).sum();
        let step = self.marks.nearest(&self.slots[side], share);
        (before + step) % self.points.len() as u32
    }
}

fn signed_area([a, b, c]: [DVec2; 3]) -> f64 {
    0.5 * (b - a).perp_dot(c - a)
}

fn barycentric([a, b, c]: [DVec2; 3], p: DVec2) -> [f64; 3] {
    let whole = (b - a).perp_dot(c - a);
    let (u, v) = (
        (p - a).perp_dot(c - a) / whole,
        (b - a).perp_dot(p - a) / whole,
    );
    [1.0 - u - v, u, v]
}

pub(super) type Delaunay = ConstrainedDelaunayTriangulation<Point2<f64>>;
pub(super) type Face = FixedFaceHandle<InnerTag>;
type Flat = (Vec<DVec2>, Vec<[u32; 3]>);
type LineEdges = (Vec<DVec2>, Vec<[u32; 2]>);

/// What a region is divided between.
struct Ring<'a> {
    corners: &'a [DVec2],
    border: &'a [DVec2],
    lines: Option<LineEdges>,
    size: f64,
}

/// A divided region: squares, and triangles around them.
struct Divided {
    points: Vec<DVec2>,
    triangles: Vec<[u32; 3]>,
    lattice: Lattice,
    /// First of the lattice's points.
    base: u32,
    contacts: Vec<[u32; 2]>,
}

impl Ring<'_> {
    /// Divides the region; see [`Irregular::new`].
    fn divided(&self, sides: &[u32], own: &[[u32; 3]]) -> Divided {
        let whole =
            self.border.len() == sides.len() && diameter(self.corners) <= 2f64.sqrt() * self.size;
        if let Some(lines) = &self.lines {
            if let Some(divided) = self.triangulated(lines) {
                return divided;
            }
        }
        if !whole {
            if let Some(divided) = self.triangulated(&(Vec::new(), Vec::new())) {
                return divided;
            }
        }
        let (points, triangles) = if whole {
            (self.border.to_vec(), own.to_vec())
        } else {
            fans(sides, self.border, own)
        };
        Divided {
            points,
            triangles,
            lattice: Lattice::new(self.corners, &[], f64::INFINITY),
            base: 0,
            contacts: Vec::new(),
        }
    }

    /// The ring between border and lattice by constrained Delaunay refinement: the points of
    /// border, lines, lattice and ring, and the ring's triangles. `None` if ring and lattice do
    /// not tile the region exactly between the given border points.
    fn triangulated(&self, lines: &LineEdges) -> Option<Divided> {
        let border = self.border.len();
        let mut points = [self.border, &lines.0].concat();
        let pieces: Vec<[DVec2; 2]> = (lines.1.iter())
            .map(|e| e.map(|k| points[k as usize]))
            .collect();
        let lattice = Lattice::new(self.corners, &pieces, self.size);
        let (unique, first) = distinct(self.border);
        let outline = lattice.outline();
        // Vertices of the triangulation: distinct border points, points of lines, points on the
        // lattice's outline, then those of the refinement; `known` are the local points of all
        // but the last.
        let mut known = first.clone();
        known.extend(border as u32..points.len() as u32);
        let rim = known.len();
        known.extend(outline.points.iter().map(|&k| k + points.len() as u32));
        points.extend(&lattice.points);
        let vertices: Vec<Point2<f64>> = known
            .iter()
            .map(|&k| points[k as usize])
            .map(|p| Point2::new(p.x, p.y))
            .collect();
        let mut walls = constraints(&unique);
        let rims = outline.edges.iter().map(|e| e.map(|k| rim + k as usize));
        walls.extend(rims);
        let vertex = |k: u32| match unique.get(k as usize) {
            Some(&v) => v as usize,
            None => k as usize - border + first.len(),
        };
        let mut edges = walls.clone();
        edges.extend(
            lines
                .1
                .iter()
                .map(|e| e.map(vertex))
                .filter(|e| e[0] != e[1]),
        );
        let walls: HashSet<keep::Pair> = walls
            .into_iter()
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        let mut mesh = Delaunay::try_bulk_load_cdt(vertices, edges, |_| {}).ok()?;
        // A line that crosses the border by rounding may be lost, but no wall.
        if mesh.num_vertices() != known.len() || !walls.iter().all(|&w| keep::joined(&mesh, w)) {
            return None;
        }
        let outside = if lines.1.is_empty() {
            refine(&mut mesh, self.size)
        } else {
            keep::refine(&mut mesh, &walls, self.size)
        };
        let fixed = points.len();
        let local = |v: usize| match known.get(v) {
            Some(&k) => k,
            None => (v - known.len() + fixed) as u32,
        };
        points.extend(
            mesh.vertices()
                .skip(known.len())
                .map(|v| DVec2::new(v.position().x, v.position().y)),
        );
        let triangles: Vec<[u32; 3]> = mesh
            .inner_faces()
            .filter(|f| !outside.contains(&f.fix()))
            .map(|f| f.vertices().map(|v| local(v.fix().index())))
            .collect();
        let area: f64 = triangles
            .iter()
            .map(|t| signed_area(t.map(|k| points[k as usize])))
            .sum();
        let whole = polygon_area(self.corners);
        if (area + lattice.area() - whole).abs() > 1e-9 * whole {
            return None;
        }
        let contacts = (lines.1.iter())
            .filter(|e| keep::joined(&mesh, e.map(vertex)))
            .copied()
            .collect();
        let (points, triangles) = without_strays(points, triangles, fixed);
        Some(Divided {
            points,
            triangles,
            lattice,
            base: (border + lines.0.len()) as u32,
            contacts,
        })
    }
}

/// Adds points until angles and sizes are good, and returns the faces outside the region.
fn refine(mesh: &mut Delaunay, size: f64) -> HashSet<Face> {
    let mut rounds = 0..LONG_EDGE_ROUNDS;
    loop {
        let parameters = refinement(size, mesh.num_vertices());
        let outside = mesh.refine(parameters).excluded_faces.into_iter().collect();
        let middles = middles_of_long_edges(mesh, &outside, size);
        if middles.is_empty() || rounds.next().is_none() {
            return outside;
        }
        for p in middles {
            // A point that cannot be inserted leaves its edge long, which is all it was for.
            let _ = mesh.insert(p);
        }
    }
}

/// The middles of edges that are much too long, at most one per triangle, longest first.
pub(super) fn middles_of_long_edges(
    mesh: &Delaunay,
    outside: &HashSet<Face>,
    size: f64,
) -> Vec<Point2<f64>> {
    let limit = (LONG_EDGE * size) * (LONG_EDGE * size);
    let mut long: Vec<_> = mesh
        .undirected_edges()
        .filter(|e| !e.is_constraint_edge() && e.length_2() > limit)
        .collect();
    long.sort_by(|a, b| b.length_2().total_cmp(&a.length_2()));
    let mut used = outside.clone();
    let mut middles = Vec::new();
    for edge in long {
        let faces = edge
            .as_directed()
            .face()
            .fix()
            .as_inner()
            .into_iter()
            .chain(edge.as_directed().rev().face().fix().as_inner());
        let faces: Vec<Face> = faces.collect();
        if faces.len() == 2 && faces.iter().all(|f| !used.contains(f)) {
            used.extend(faces);
            let [a, b] = edge.positions();
            middles.push(Point2::new(0.5 * (a.x + b.x), 0.5 * (a.y + b.y)));
        }
    }
    middles
}

fn refinement(size: f64, vertices: usize) -> RefinementParameters<f64> {
    let fits = size.is_finite() && size < 1.0;
    let size = if fits { size } else { 1.0 };
    let parameters = RefinementParameters::new()
        .exclude_outer_faces(true)
        .keep_constraint_edges()
        .with_angle_limit(AngleLimit::from_deg(ANGLE_DEGREES))
        // Below this a triangle's circumcentre is rounding, and the angle is the border's fault.
        .with_min_required_area(1e-4 * size * size)
        .with_max_additional_vertices(2 * vertices + 32);
    if fits {
        parameters.with_max_allowed_area(0.42 * size * size)
    } else {
        parameters
    }
}

/// For each point the first of those equal to it, numbered among the distinct ones; and which
/// points those are. A border may visit a point twice (a hole joined to the outline by a cut).
fn distinct(points: &[DVec2]) -> (Vec<u32>, Vec<u32>) {
    let key = |&i: &u32| points[i as usize].to_array().map(|x| (x + 0.0).to_bits());
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    order.sort_by_key(key);
    let mut leader = vec![0; points.len()];
    for run in order.chunk_by(|a, b| key(a) == key(b)) {
        run.iter().for_each(|&i| leader[i as usize] = run[0]);
    }
    let mut first = Vec::new();
    let mut number = vec![0; points.len()];
    for i in 0..points.len() {
        if leader[i] as usize == i {
            number[i] = first.len() as u32;
            first.push(i as u32);
        } else {
            number[i] = number[leader[i] as usize];
        }
    }
    (number, first)
}

/// The pieces of the border as pairs of distinct points.
///
/// A piece that the border runs along twice is a cut, which joins a hole to the outline: both
/// its sides are inside, so it bounds nothing.
fn constraints(ring: &[u32]) -> Vec<[usize; 2]> {
    let n = ring.len();
    let mut pairs: Vec<[usize; 2]> = (0..n)
        .map(|i| [ring[i] as usize, ring[(i + 1) % n] as usize])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .filter(|[a, b]| a != b)
        .collect();
    pairs.sort_unstable();
    pairs
        .chunk_by(|a, b| a == b)
        .filter(|run| run.len() % 2 == 1)
        .map(|run| run[0])
        .collect()
}

fn polygon_area(corners: &[DVec2]) -> f64 {
    let n = corners.len();
    (1..n - 1)
        .map(|k| signed_area([corners[0], corners[k], corners[k + 1]]))
        .sum()
}

/// Drops points after the first `fixed` that no triangle uses.
fn without_strays(points: Vec<DVec2>, mut triangles: Vec<[u32; 3]>, fixed: usize) -> Flat {
    let mut used: Vec<bool> = (0..points.len()).map(|i| i < fixed).collect();
    triangles
        .iter()
        .flatten()
        .for_each(|&k| used[k as usize] = true);
    let mut kept = Vec::with_capacity(points.len());
    let mut number = vec![0; points.len()];
    for (i, p) in points.into_iter().enumerate() {
        number[i] = kept.len() as u32;
        if used[i] {
            kept.push(p);
        }
    }
    for t in &mut triangles {
        *t = t.map(|k| number[k as usize]);
    }
    (kept, triangles)
}

/// Each of the region's own triangles as it is, or about its centre where sides are divided.
fn fans(sides: &[u32], border: &[DVec2], own: &[[u32; 3]]) -> Flat {
    let n = sides.len() as u32;
    let starts: Vec<u32> = sides
        .iter()
        .scan(0, |sum, &k| {
            let start = *sum;
            *sum += k;
            Some(start)
        })
        .collect();
    let mut flat = (border.to_vec(), Vec::new());
    for t in own {
        let mut ring = Vec::new();
        for i in 0..3 {
            let (c, next) = (t[i], t[(i + 1) % 3]);
            let pieces = if (c + 1) % n == next {
                sides[c as usize]
            } else {
                1
            };
            ring.extend((0..pieces).map(|step| starts[c as usize] + step));
        }
        match ring[..] {
            [a, b, c] => flat.1.push([a, b, c]),
            _ => {
                let centre: DVec2 = t.iter().map(|&c| border[starts[c as usize] as usize]).sum();
                let apex = flat.0.len() as u32;
                flat.0.push(centre / 3.0);
                let next = |i: usize| ring[(i + 1) % ring.len()];
                flat.1
                    .extend((0..ring.len()).map(|i| [ring[i], next(i), apex]));
            }
        }
    }
    flat
}
