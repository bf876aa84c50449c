//! Contact lines: where faces touch or cross, and irradiance is discontinuous.
//!
//! Where a box stands on a floor, irradiance drops from its outside value to zero. A patch across
//! that line averages both: light leaks under the box, and its shadow leaks out. Such D⁰
//! discontinuities are the worst for a radiosity mesh, so it is cut along them (Heckbert,
//! "Discontinuity meshing for radiosity", 1992; Lischinski, Tampieri and Greenberg, same title,
//! 1992). Only contacts are detected, not the borders of shadows.

use super::Lists;
use super::box_pairs::{for_each_pair, grown};
use super::outline::{Form, Outline, Region};
use azulejo_scene::math::{Aabb, area_vector};
use azulejo_scene::{CoordinateDigits, CoordinateRounding, Primitive, Shape};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::cmp::Ordering;
use std::collections::HashMap;

/// Tolerance of contacts, as a share of both diameters and of the coordinates.
const TOUCH: f64 = 1e-6;
const TOUCH_COORDINATES: f64 = 1e-12;
/// Largest errors of coordinates within which faces touch as well, and how much of a diameter that may be:
/// of single precision, and of decimals, of which there may be few because no more are needed.
const TOUCH_ROUNDING: f64 = 2.0;
const MOST_SINGLE: f64 = 1e-3;
const MOST_DECIMALS: f64 = 2e-5;
/// A line on a face's border matters only if the other face rises from it: the cosine of the angle
/// between the planes is at most this.
const STANDING_COSINE: f64 = 0.866_025_403_784_438_6;
/// Triangles of one face that turn by less than 0.1° cannot cross.
const SAME_PLANE_COSINE: f64 = 0.999_998_5;
/// Most lines per face, the longest first.
const LINES_PER_FACE: usize = 4096;
/// Most triangles of exact shapes; further shapes make no lines.
const EXACT_TRIANGLES: usize = 1 << 18;
/// Most contacts that faces take over from faces that they coincide with.
const MOST_COPIED: usize = 1 << 21;
/// Chord error of these triangles, as a share of the shape's diameter.
const EXACT_ERROR: f64 = 0.002;

/// A straight piece of a contact, on the face that it divides.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Contact {
    pub ends: [DVec3; 2],
    /// Whether it runs through the face rather than along its border.
    pub inside: bool,
}

impl Contact {
    pub fn length(&self) -> f64 {
        self.ends[0].distance(self.ends[1])
    }
}

/// Distance within which rounding may have moved a face of this diameter that touches another.
fn touching(rounding: &CoordinateRounding, diameter: f64) -> f64 {
    let most = match rounding.digits {
        CoordinateDigits::Single => MOST_SINGLE,
        CoordinateDigits::Decimals(_) | CoordinateDigits::Double => MOST_DECIMALS,
    };
    (TOUCH_ROUNDING * rounding.error).min(most * diameter)
}

/// The contacts of every region.
pub(super) struct Contacts {
    lists: Lists<Contact>,
}

impl Contacts {
    /// Finds the contacts of all flat regions of meshes, with each other and with exact shapes.
    pub fn new(outline: &Outline) -> Contacts {
        let facets = ContactFacets::new(outline);
        let groups = facets.coincident();
        let firsts: Vec<u32> = groups.chunk_by(|a, b| a.0 == b.0).map(|g| g[0].1).collect();
        let boxes: Vec<Aabb> = (firsts.iter()).map(|&f| facets.boxes[f as usize]).collect();
        let mut contacts = for_each_pair(&boxes, |pair, contacts| {
            facets.meet(pair.map(|k| firsts[k as usize]), contacts);
        });
        facets.copy_to_coincident(&groups, &mut contacts);
        contacts.extend(seams_below_walls(outline));
        let key = |c: &(u32, Contact)| (c.0, c.1.ends.map(|p| p.to_array()), c.1.inside);
        contacts
            .par_sort_unstable_by(|a, b| key(a).partial_cmp(&key(b)).unwrap_or(Ordering::Equal));
        contacts.dedup();
        // A stable sort, so that equal lengths keep the order of their ends.
        contacts.sort_by(|a, b| {
            let lengths = b.1.length().total_cmp(&a.1.length());
            a.0.cmp(&b.0).then(lengths)
        });
        let longest = contacts.chunk_by(|a, b| a.0 == b.0);
        let longest = longest.flat_map(|region| region.iter().take(LINES_PER_FACE).copied());
        Contacts {
            lists: Lists::new(outline.regions.len(), longest),
        }
    }

    /// The contacts of a region, longest first.
    pub fn of(&self, region: usize) -> &[Contact] {
        self.lists.get(region)
    }

    /// Whether any contact runs through a region, not only along its border.
    pub fn run_through(&self, region: usize) -> bool {
        self.of(region).iter().any(|c| c.inside)
    }

    /// Total length of the lines through a region, and the diameter of their bounding box.
    pub fn extent(&self, region: usize) -> (f64, f64) {
        let inside = || self.of(region).iter().filter(|c| c.inside);
        let bounds = Aabb::around(inside().flat_map(|c| c.ends));
        (inside().map(Contact::length).sum(), bounds.diagonal())
    }
}

/// Flat polygons: the regions, and triangles of exact shapes, which only make lines on others.
struct ContactFacets<'a> {
    outline: &'a Outline<'a>,
    /// Region of each of the first facets.
    regions: Vec<u32>,
    /// The others.
    exact: Vec<[DVec3; 3]>,
    /// The first edges of each region; the last one repeated where there are three.
    edges: Vec<[u32; 4]>,
    /// Enlarged by the tolerance.
    boxes: Vec<Aabb>,
    /// The tolerance of each.
    margins: Vec<f64>,
}

impl<'a> ContactFacets<'a> {
    fn new(outline: &'a Outline) -> ContactFacets<'a> {
        let flat = |r: &Region| r.form != Form::Empty && r.form != Form::Part;
        let regions = (0..).zip(&outline.regions).filter(|r| flat(r.1));
        let mut facets = ContactFacets {
            outline,
            regions: regions.map(|r| r.0).collect(),
            exact: Vec::new(),
            edges: Vec::new(),
            boxes: Vec::new(),
            margins: Vec::new(),
        };
        for object in &outline.scene.objects {
            if let Shape::Primitive(primitive) = &object.shape {
                facets.add_exact(primitive);
            }
        }
        let first_edges = |&r: &u32| {
            let slots = outline.slots_of(&outline.regions[r as usize]);
            [0, 1, 2, 3].map(|k| slots[k.min(slots.len() - 1)].edge)
        };
        facets.edges = facets.regions.par_iter().map(first_edges).collect();
        let count = (facets.regions.len() + facets.exact.len()) as u32;
        let objects = outline.scene.objects.iter();
        let roundings = objects.map(|o| o.shape.coordinate_rounding());
        let roundings: Vec<CoordinateRounding> = roundings.collect();
        let margined = |f| {
            let b = Aabb::around((0..facets.count(f)).map(|k| facets.point(f, k)));
            let reach = b.min.abs().max(b.max.abs()).max_element();
            let diameter = b.min.distance(b.max);
            let object = facets.region(f).map(|region| region.object as usize);
            let rounding = object.map_or(0.0, |o| touching(&roundings[o], diameter));
            let margin = (TOUCH * diameter + TOUCH_COORDINATES * reach).max(rounding);
            (grown(b, margin), margin)
        };
        (facets.boxes, facets.margins) = (0..count).into_par_iter().map(margined).unzip();
        facets
    }

    fn add_exact(&mut self, primitive: &Primitive) {
        let size = primitive.bounds().diagonal();
        let grids = primitive.grids(EXACT_ERROR * size, f64::INFINITY);
        let cells: usize = grids.iter().map(|g| g.nu as usize * g.nv as usize).sum();
        if !size.is_finite() || self.exact.len() + 2 * cells > EXACT_TRIANGLES {
            return;
        }
        let mesh = primitive.tessellate(&grids);
        for face in 0..mesh.faces.len() {
            let points = mesh.face_positions(face);
            let fan = (2..points.len()).map(|k| [points[0], points[k - 1], points[k]]);
            self.exact
                .extend(fan.filter(|t| area_vector(t) != DVec3::ZERO));
        }
    }

    /// All facets, each after the first facet of the same edges, with which it coincides: pairs
    /// `(first, facet)` in ascending order. A million coincident triangles are half a billion
    /// pairs, which have no lines on each other and the same lines on everything else.
    fn coincident(&self) -> Vec<(u32, u32)> {
        let key = |f: u32| -> Option<[u32; 4]> {
            let mut edges = *self.edges.get(f as usize)?;
            edges.sort_unstable();
            (self.count(f) <= 4).then_some(edges)
        };
        let mut first = HashMap::new();
        let group = |f: u32| match key(f) {
            Some(key) => (*first.entry(key).or_insert(f), f),
            None => (f, f),
        };
        let mut groups: Vec<(u32, u32)> = (0..self.boxes.len() as u32).map(group).collect();
        groups.sort_unstable();
        groups
    }

    /// Gives every facet the contacts of the first that coincides with it.
    fn copy_to_coincident(&self, groups: &[(u32, u32)], contacts: &mut Vec<(u32, Contact)>) {
        let region = |f: u32| self.regions.get(f as usize).copied();
        let mut others: HashMap<u32, Vec<u32>> = HashMap::new();
        for &(first, facet) in groups.iter().filter(|g| g.0 != g.1) {
            if let (Some(first), Some(other)) = (region(first), region(facet)) {
                others.entry(first).or_default().push(other);
            }
        }
        let copies = |&(first, contact): &(u32, Contact)| {
            let others = others.get(&first).map_or(&[][..], |o| o);
            others.iter().map(move |&o| (o, contact))
        };
        let copied = contacts.iter().flat_map(copies).take(MOST_COPIED);
        contacts.extend(copied.collect::<Vec<_>>());
    }

    fn region(&self, facet: u32) -> Option<&Region> {
        let region = *self.regions.get(facet as usize)?;
        Some(&self.outline.regions[region as usize])
    }

    fn triangle(&self, facet: u32) -> &[DVec3; 3] {
        &self.exact[facet as usize - self.regions.len()]
    }

    fn count(&self, facet: u32) -> u32 {
        self.region(facet).map_or(3, |r| r.slots.len() as u32)
    }

    fn point(&self, facet: u32, k: u32) -> DVec3 {
        match self.region(facet) {
            Some(r) => self.outline.slots[(r.slots.start + k) as usize].position,
            None => self.triangle(facet)[k as usize],
        }
    }

    fn normal(&self, facet: u32) -> DVec3 {
        match self.region(facet) {
            Some(r) => r.normal,
            None => area_vector(self.triangle(facet)).normalize_or_zero(),
        }
    }

    /// Appends the lines that two facets make on each other.
    fn meet(&self, [a, b]: [u32; 2], contacts: &mut Vec<(u32, Contact)>) {
        let [p, q] = [a, b].map(|f| &self.boxes[f as usize]);
        let tolerance = self.margins[a as usize] + self.margins[b as usize];
        let common = (p.max.min(q.max) - p.min.max(q.min)).max_element();
        // Neighbours that share a corner or an edge are the most frequent.
        if common <= 4.0 * tolerance || self.share_an_edge(a, b) || self.are_one_face(a, b) {
            return;
        }
        let b_reach = Reach::new(self, &FacetPlane::new(self, a), b, tolerance);
        if !b_reach.meets() {
            return;
        }
        let a_reach = Reach::new(self, &FacetPlane::new(self, b), a, tolerance);
        if a_reach.meets() {
            self.lines_on([a, b], b_reach.lies_in(), tolerance, contacts);
            self.lines_on([b, a], a_reach.lies_in(), tolerance, contacts);
        }
    }

    /// The triangles of one flat face tile it, however many corners it has.
    fn are_one_face(&self, a: u32, b: u32) -> bool {
        let (Some(a), Some(b)) = (self.region(a), self.region(b)) else {
            return false;
        };
        (a.object, a.face) == (b.object, b.face) && a.normal.dot(b.normal) > SAME_PLANE_COSINE
    }

    fn share_an_edge(&self, a: u32, b: u32) -> bool {
        let (Some(p), Some(q)) = (self.edges.get(a as usize), self.edges.get(b as usize)) else {
            return false;
        };
        let is_shared = p.iter().any(|e| q.contains(e));
        is_shared || self.count(a).max(self.count(b)) > 4 && self.polygons_share_an_edge(a, b)
    }

    fn polygons_share_an_edge(&self, a: u32, b: u32) -> bool {
        let (Some(a), Some(b)) = (self.region(a), self.region(b)) else {
            return false;
        };
        let b = self.outline.slots_of(b);
        let mut edges = self.outline.slots_of(a).iter().map(|s| s.edge);
        edges.any(|e| b.iter().any(|s| s.edge == e))
    }

    /// Appends the lines that `b` makes on `a`, if `a` is a region.
    fn lines_on(
        &self,
        [a, b]: [u32; 2],
        in_plane: bool,
        tolerance: f64,
        contacts: &mut Vec<(u32, Contact)>,
    ) {
        let Some(region) = self.region(a) else { return };
        let lines = self.lines_in_plane(a, b, in_plane, tolerance);
        if lines.is_empty() {
            return;
        }
        let stands = region.normal.dot(self.normal(b)).abs() <= STANDING_COSINE;
        let face = Face::new(self.outline, region, tolerance);
        for line in lines {
            face.clip(line, |[p, q], inside| {
                if inside || stands {
                    let is_ascending = p.to_array() < q.to_array();
                    let ends = if is_ascending { [p, q] } else { [q, p] };
                    contacts.push((self.regions[a as usize], Contact { ends, inside }));
                }
            });
        }
    }

    /// Where `b` meets the plane of `a`.
    fn lines_in_plane(&self, a: u32, b: u32, in_plane: bool, tolerance: f64) -> Vec<[DVec3; 2]> {
        let plane = FacetPlane::new(self, a);
        match self.region(b) {
            Some(other) if in_plane => {
                let n = other.slots.len() as u32;
                let side = |k| [self.point(b, k), self.point(b, (k + 1) % n)];
                (0..n).map(side).collect()
            }
            // The parts of an exact shape that stand on the plane make the same lines.
            None if in_plane => Vec::new(),
            Some(other) => (self.outline.triangles_of(other).iter())
                .filter_map(|t| plane.cut(t.map(|k| self.point(b, k)), tolerance))
                .collect(),
            None => Vec::from_iter(plane.cut(*self.triangle(b), tolerance)),
        }
    }
}

/// The plane of a facet.
struct FacetPlane {
    point: DVec3,
    normal: DVec3,
}

impl FacetPlane {
    fn new(facets: &ContactFacets, facet: u32) -> FacetPlane {
        FacetPlane {
            point: facets.point(facet, 0),
            normal: facets.normal(facet),
        }
    }

    fn distance(&self, p: DVec3) -> f64 {
        (p - self.point).dot(self.normal)
    }

    /// The intersection of a triangle with the plane, if that is a line.
    fn cut(&self, t: [DVec3; 3], tolerance: f64) -> Option<[DVec3; 2]> {
        let d = t.map(|p| self.distance(p));
        let d = d.map(|d| if d.abs() <= tolerance { 0.0 } else { d });
        let mut points = [DVec3::ZERO; 3];
        let mut count = 0;
        for k in 0..3 {
            let (next, p, q) = ((k + 1) % 3, t[k], t[(k + 1) % 3]);
            let point = if d[k] == 0.0 {
                p
            } else if d[k] * d[next] < 0.0 {
                // From the same end for both triangles at an edge, so that they agree.
                let (p, q, a, b) = if p.to_array() < q.to_array() {
                    (p, q, d[k], d[next])
                } else {
                    (q, p, d[next], d[k])
                };
                p + (q - p) * (a / (a - b))
            } else {
                continue;
            };
            points[count] = point;
            count += 1;
        }
        let is_line = count == 2 && points[0].distance(points[1]) > 4.0 * tolerance;
        is_line.then_some([points[0], points[1]])
    }
}

/// How many corners of a facet are in front of a plane, behind it, and in it.
#[derive(Default)]
struct Reach {
    front: u32,
    back: u32,
    within: u32,
}

impl Reach {
    fn new(facets: &ContactFacets, plane: &FacetPlane, facet: u32, tolerance: f64) -> Reach {
        let mut reach = Reach::default();
        for k in 0..facets.count(facet) {
            let d = plane.distance(facets.point(facet, k));
            if d > tolerance {
                reach.front += 1;
            } else if d < -tolerance {
                reach.back += 1;
            } else {
                reach.within += 1;
            }
        }
        reach
    }

    /// Whether the facet may intersect the plane in more than a point.
    fn meets(&self) -> bool {
        self.within > 1 || self.front > 0 && self.back > 0
    }

    fn lies_in(&self) -> bool {
        self.front + self.back == 0
    }
}

/// A region in coordinates of its plane.
struct Face {
    origin: DVec3,
    axes: [DVec3; 2],
    corners: Vec<DVec2>,
    tolerance: f64,
}

impl Face {
    fn new(outline: &Outline, region: &Region, tolerance: f64) -> Face {
        let slots = outline.slots_of(region);
        let x = region.normal.any_orthonormal_vector();
        let mut face = Face {
            origin: slots[0].position,
            axes: [x, region.normal.cross(x)],
            corners: Vec::with_capacity(slots.len()),
            tolerance,
        };
        face.corners = slots.iter().map(|s| face.flat(s.position)).collect();
        face
    }

    fn flat(&self, p: DVec3) -> DVec2 {
        let d = p - self.origin;
        DVec2::new(d.dot(self.axes[0]), d.dot(self.axes[1]))
    }

    /// Calls `f` with each piece of a line in the plane that lies inside the face (true) or along
    /// its border (false).
    fn clip(&self, line: [DVec3; 2], mut f: impl FnMut([DVec3; 2], bool)) {
        let [p, q] = line.map(|p| self.flat(p));
        let length = p.distance(q);
        let least = 4.0 * self.tolerance;
        if length.is_nan() || length <= least {
            return;
        }
        let mut stops = self.stops(p, q);
        stops.retain(|&t| t * length > least && (1.0 - t) * length > least);
        stops.extend([0.0, 1.0]);
        stops.sort_by(f64::total_cmp);
        let at = |t: f64| match t {
            0.0 => line[0],
            1.0 => line[1],
            _ => line[0] + t * (line[1] - line[0]),
        };
        // Consecutive pieces of the same kind are one.
        let mut run: Option<([f64; 2], bool)> = None;
        for w in stops.windows(2) {
            if (w[1] - w[0]) * length <= least && w[1] < 1.0 {
                continue;
            }
            let kind = self.holds(p + 0.5 * (w[0] + w[1]) * (q - p));
            match (&mut run, kind) {
                (Some((span, inside)), Some(kind)) if *inside == kind => span[1] = w[1],
                _ => {
                    if let Some((span, inside)) = run.take() {
                        f(span.map(at), inside);
                    }
                    run = kind.map(|inside| ([w[0], w[1]], inside));
                }
            }
        }
        if let Some((span, inside)) = run {
            f(span.map(at), inside);
        }
    }

    /// Where the line from `p` to `q` may enter, leave or join the border, as shares of it.
    fn stops(&self, p: DVec2, q: DVec2) -> Vec<f64> {
        let (d, n) = (q - p, self.corners.len());
        let mut stops = Vec::new();
        for k in 0..n {
            let (a, b) = (self.corners[k], self.corners[(k + 1) % n]);
            let (side_a, side_b) = (d.perp_dot(a - p), d.perp_dot(b - p));
            if side_a * side_b < 0.0 {
                let hit = a + (b - a) * (side_a / (side_a - side_b));
                stops.push((hit - p).dot(d) / d.length_squared());
            }
            if side_a.abs() <= 2.0 * self.tolerance * d.length() {
                stops.push((a - p).dot(d) / d.length_squared());
            }
        }
        stops
    }

    /// Whether a point is inside, on the border (false), or neither.
    fn holds(&self, p: DVec2) -> Option<bool> {
        let n = self.corners.len();
        let sides = || (0..n).map(|k| (self.corners[k], self.corners[(k + 1) % n]));
        if sides().any(|(a, b)| distance_to_segment(p, a, b) <= 2.0 * self.tolerance) {
            return Some(false);
        }
        is_inside(&self.corners, p).then_some(true)
    }
}

/// Whether a polygon contains a point, by the even-odd rule.
pub(super) fn is_inside(corners: &[DVec2], p: DVec2) -> bool {
    let n = corners.len();
    let crossed = (0..n)
        .map(|k| (corners[k], corners[(k + 1) % n]))
        .filter(|(a, b)| (a.y <= p.y) != (b.y <= p.y))
        .filter(|(a, b)| a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y) > p.x)
        .count();
    crossed % 2 == 1
}

/// Distance of `p` from the straight line between `a` and `b`.
pub(super) fn distance_to_segment(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    p.distance(a + share_along(p, a, b) * (b - a))
}

/// The parameter of the point nearest to `p` on the segment from `a` to `b`, 0..=1.
pub(super) fn share_along(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let d = b - a;
    ((p - a).dot(d) / d.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0)
}

/// Edges at which a face stands on the seam of others, all sharing the edge's ends.
fn seams_below_walls(outline: &Outline) -> Vec<(u32, Contact)> {
    let mut uses = vec![0u32; outline.edges.len()];
    let regions = || (0u32..).zip(&outline.regions);
    for (_, region) in regions() {
        let slots = outline.slots_of(region);
        slots.iter().for_each(|s| uses[s.edge as usize] += 1);
    }
    let mut crowded: Vec<(u32, u32)> = regions()
        .flat_map(|(r, region)| outline.slots_of(region).iter().map(move |s| (s.edge, r)))
        .filter(|&(edge, _)| uses[edge as usize] > 2)
        .collect();
    crowded.sort_unstable();
    let mut contacts = Vec::new();
    for at_edge in crowded.chunk_by(|a, b| a.0 == b.0) {
        let edge = outline.edges[at_edge[0].0 as usize];
        let normal = |r: u32| outline.regions[r as usize].normal;
        // Comparing all with all would be quadratic; walls come among the first.
        let others = &at_edge[..at_edge.len().min(8)];
        for &(_, r) in at_edge {
            let stands = |o: u32| normal(o).dot(normal(r)).abs() <= STANDING_COSINE;
            if others.iter().any(|o| stands(o.1)) {
                let ends = [edge.from, edge.to];
                let inside = false;
                contacts.push((r, Contact { ends, inside }));
            }
        }
    }
    contacts
}
