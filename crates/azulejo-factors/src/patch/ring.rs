//! Triangles between the border of a region, the lines through it and the squares inside.

use super::constrained_delaunay;
use super::irregular::bounds;
use super::lattice::Lattice;
use glam::DVec2;
use spade::handles::{FixedFaceHandle, InnerTag};
use spade::{
    AngleLimit, ConstrainedDelaunayTriangulation, Point2, RefinementParameters, Triangulation,
};
use std::collections::HashSet;

/// Edges longer than this share of the size are halved, in at most this many rounds.
const LONG_EDGE: f64 = 1.45;
const LONG_EDGE_ROUNDS: usize = 6;
/// Angles below this are refined away where the border allows it.
const ANGLE_DEGREES: f64 = 22.0;

pub(super) type Delaunay = ConstrainedDelaunayTriangulation<Point2<f64>>;
pub(super) type Face = FixedFaceHandle<InnerTag>;
type Flat = (Vec<DVec2>, Vec<[u32; 3]>);

/// Lines through a region: their points that are not on the border, and their pieces as pairs of
/// local points, with those of the border counted first.
#[derive(Default)]
pub(super) struct Pieces {
    pub points: Vec<DVec2>,
    pub edges: Vec<[u32; 2]>,
}

/// The constraints of a region's division.
pub(super) struct Ring<'a> {
    pub corners: &'a [DVec2],
    pub border: &'a [DVec2],
    pub lines: Option<Pieces>,
    pub size: f64,
}

/// A divided region: squares, and triangles around them.
pub(super) struct Divided {
    /// Of the border, of lines, of the lattice, and of the triangles alone.
    pub points: Vec<DVec2>,
    pub triangles: Vec<[u32; 3]>,
    pub lattice: Lattice,
    /// First of the lattice's points.
    pub base: u32,
    /// Edges along lines.
    pub contacts: Vec<[u32; 2]>,
}

impl Ring<'_> {
    /// Divides a region with these numbers of pieces on its `sides`; into its `own` triangles if they are
    /// good enough.
    pub fn divided(&self, sides: &[u32], own: &[[u32; 3]]) -> Divided {
        let whole =
            self.border.len() == sides.len() && diameter(self.corners) <= 2f64.sqrt() * self.size;
        let lines = self.lines.as_ref();
        let with_lines = lines.and_then(|lines| self.triangulated(lines));
        let triangulated = match with_lines {
            None if !whole => self.triangulated(&Pieces::default()),
            with_lines => with_lines,
        };
        triangulated.unwrap_or_else(|| {
            let (points, triangles) = if whole {
                (self.border.to_vec(), own.to_vec())
            } else {
                fans(sides, self.border, own)
            };
            Divided {
                base: points.len() as u32,
                points,
                triangles,
                lattice: Lattice::new(self.corners, &[], f64::INFINITY),
                contacts: Vec::new(),
            }
        })
    }

    /// By constrained Delaunay refinement. `None` if ring and lattice do not tile the region
    /// exactly between the given border points.
    fn triangulated(&self, lines: &Pieces) -> Option<Divided> {
        let net = Net::new(self, lines);
        let mut mesh = net.load()?;
        let outside = if lines.edges.is_empty() {
            refine(&mut mesh, self.size)
        } else {
            let walls = net.walls.iter().copied().collect();
            constrained_delaunay::refine(&mut mesh, &walls, self.size)
        };
        let divided = net.divided(&mesh, &outside, lines);
        let at = |k: u32| divided.points[k as usize];
        let triangles = divided.triangles.iter();
        let area: f64 = triangles.map(|t| signed_area(t.map(at))).sum();
        let whole = polygon_area(self.corners);
        let tiled = (area + divided.lattice.area() - whole).abs() <= 1e-9 * whole;
        tiled.then(|| without_strays(divided, self.border.len()))
    }
}

/// The input of the triangulation.
struct Net {
    /// Points of border, lines and lattice.
    points: Vec<DVec2>,
    lattice: Lattice,
    /// First of the lattice's points.
    base: u32,
    /// The vertices of the triangulation: distinct points of the border, those of lines, those on
    /// the lattice's outline.
    known: Vec<u32>,
    /// Pieces of the border and of the lattice's outline, as ascending pairs of vertices.
    walls: Vec<constrained_delaunay::Pair>,
    /// Pieces of lines.
    lines: Vec<constrained_delaunay::Pair>,
}

impl Net {
    fn new(ring: &Ring, lines: &Pieces) -> Net {
        let border = ring.border.len();
        let mut points = [ring.border, &lines.points].concat();
        let segment = |e: &[u32; 2]| e.map(|k| points[k as usize]);
        let segments: Vec<[DVec2; 2]> = lines.edges.iter().map(segment).collect();
        let lattice = Lattice::new(ring.corners, &segments, ring.size);
        let base = points.len() as u32;
        points.extend(&lattice.points);
        let (unique, mut known) = distinct(ring.border);
        let distinct = known.len();
        let vertex = |k: u32| match unique.get(k as usize) {
            Some(&v) => v as usize,
            None => k as usize - border + distinct,
        };
        known.extend(border as u32..base);
        let rim = known.len();
        let outline = lattice.outline();
        known.extend(outline.points.iter().map(|&k| base + k));
        let mut walls = constraints(&unique);
        let rims = outline.edges.iter().map(|e| e.map(|k| rim + k as usize));
        walls.extend(rims.map(|[a, b]| [a.min(b), a.max(b)]));
        Net {
            lines: lines.edges.iter().map(|e| e.map(vertex)).collect(),
            points,
            lattice,
            base,
            known,
            walls,
        }
    }

    /// The constrained Delaunay triangulation; `None` if it lacks a wall. A line that touches a
    /// wall or another line by rounding may be lost.
    fn load(&self) -> Option<Delaunay> {
        let point = |k: &u32| self.points[*k as usize];
        let vertices = self.known.iter().map(point).map(|p| Point2::new(p.x, p.y));
        let lines = self.lines.iter().filter(|e| e[0] != e[1]);
        let edges = self.walls.iter().chain(lines).copied().collect();
        let mesh = Delaunay::try_bulk_load_cdt(vertices.collect(), edges, |_| {}).ok()?;
        let has_walls = self
            .walls
            .iter()
            .all(|&w| constrained_delaunay::joined(&mesh, w));
        (mesh.num_vertices() == self.known.len() && has_walls).then_some(mesh)
    }

    fn divided(self, mesh: &Delaunay, outside: &HashSet<Face>, lines: &Pieces) -> Divided {
        let fixed = self.points.len();
        let local = |v: usize| match self.known.get(v) {
            Some(&k) => k,
            None => (v - self.known.len() + fixed) as u32,
        };
        let added = mesh.vertices().skip(self.known.len());
        let added = added.map(|v| DVec2::new(v.position().x, v.position().y));
        let points = self.points.iter().copied().chain(added).collect();
        let triangles = mesh
            .inner_faces()
            .filter(|f| !outside.contains(&f.fix()))
            .map(|f| f.vertices().map(|v| local(v.fix().index())))
            .collect();
        let pieces = lines.edges.iter().zip(&self.lines);
        let contacts = pieces
            .filter(|p| constrained_delaunay::joined(mesh, *p.1))
            .map(|p| *p.0)
            .collect();
        Divided {
            points,
            triangles,
            lattice: self.lattice,
            base: self.base,
            contacts,
        }
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
            // If a point cannot be inserted its edge stays long, which does no harm.
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
        let sides = [edge.as_directed(), edge.as_directed().rev()];
        let faces = sides
            .into_iter()
            .filter_map(|side| side.face().fix().as_inner());
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
        // Below this a triangle's circumcentre is rounding, and the angle is due to the border.
        .with_min_required_area(1e-4 * size * size)
        .with_max_additional_vertices(2 * vertices + 32);
    if fits {
        parameters.with_max_allowed_area(0.42 * size * size)
    } else {
        parameters
    }
}

/// For each point the first of those equal to it, numbered among the distinct ones; and the
/// distinct points. A border may visit a point twice (a hole joined to the outline by a cut).
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
/// A piece that the border runs along twice is a cut, which joins a hole to the outline: both its
/// sides are inside, so it bounds nothing.
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

/// Drops unused points inside: those of refinement beyond the border, and those of lines that stop
/// there.
fn without_strays(mut divided: Divided, border: usize) -> Divided {
    let mut used: Vec<bool> = (0..divided.points.len()).map(|i| i < border).collect();
    let lattice = divided.base as usize;
    used[lattice..lattice + divided.lattice.points.len()].fill(true);
    let corners = divided.triangles.iter().flatten();
    corners.for_each(|&k| used[k as usize] = true);
    let mut kept = Vec::with_capacity(used.len());
    let mut number = vec![0; used.len() + 1];
    for (i, p) in divided.points.iter().enumerate() {
        number[i] = kept.len() as u32;
        if used[i] {
            kept.push(*p);
        }
    }
    divided.points = kept;
    divided.base = number[lattice];
    for t in &mut divided.triangles {
        *t = t.map(|k| number[k as usize]);
    }
    divided
        .contacts
        .retain(|e| e.iter().all(|&k| used[k as usize]));
    for e in &mut divided.contacts {
        *e = e.map(|k| number[k as usize]);
    }
    divided
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
            let is_side = (c + 1) % n == next;
            let pieces = if is_side { sides[c as usize] } else { 1 };
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

pub(super) fn signed_area([a, b, c]: [DVec2; 3]) -> f64 {
    0.5 * (b - a).perp_dot(c - a)
}

fn diameter(points: &[DVec2]) -> f64 {
    let (low, high) = bounds(points);
    low.distance(high)
}
