//! Triangulation of faces, the same for tracer, patches and renderer.

use crate::math::{Frame, area_vector};
use crate::proxy::FlatFigure;
use crate::{Figure, Mesh};
use earcut::Earcut;
use glam::{DVec2, DVec3};

/// A triangle of a face: three positions among the face's corners, counted from 0.
type FaceTriangle = [u32; 3];

/// Most corners of a face that is read from a file. Ear clipping takes quadratic time in the worst
/// case: seconds for this many, and an hour for a million.
pub const MOST_FACE_CORNERS: usize = 1 << 16;

/// Most corners of a polygon that touches itself: finding them again takes quadratic time.
pub(crate) const MOST_TOUCHING: usize = 1 << 12;

/// Up to this many corners every apex of a fan is tried; the trials are quadratic.
const BEST_FAN_CORNERS: usize = 32;

impl Mesh {
    /// The triangles of a face, as positions 0..n among its n corners, front kept.
    ///
    /// A convex quadrilateral is split along its shorter diagonal (the one from corner 0 when
    /// both are equal to 1e-9), any other convex polygon becomes a fan, a concave one loses its
    /// ears (Meisters 1975) in the plane of its area vector. Corners on a straight line are kept,
    /// so neighbours that share them leave no crack. Always n − 2 triangles.
    ///
    /// Weakly simple polygons, which touch themselves at corners or run along their own edges, as
    /// bridges to holes do, are filled where a line from outside crosses them an odd number of times;
    /// their triangles do not overlap, and some may have no area. No triangles of its corners fill a
    /// polygon that crosses itself between corners ([`Mesh::divide_crossing_faces`] gives it more): it gets
    /// what ear clipping leaves, or a fan from corner 0, as degenerate polygons do.
    ///
    /// # Panics
    /// If `face` or its vertices are out of range.
    pub fn triangulate(&self, face: usize) -> Vec<[u32; 3]> {
        let mut triangles = Vec::new();
        self.triangulate_into(face, &mut triangles);
        triangles
    }

    /// The mesh with the triangles of its faces as faces, in their order: those for whose number `is_kept` holds.
    pub fn in_triangles(&self, is_kept: impl Fn(usize) -> bool) -> Mesh {
        let mut mesh = self.clone();
        mesh.keep_triangles(is_kept);
        mesh
    }

    /// Replaces the faces by those of their triangles, in their order, for whose number `is_kept` holds; vertices and
    /// what belongs to them stay.
    pub(crate) fn keep_triangles(&mut self, is_kept: impl Fn(usize) -> bool) {
        // For each new corner and each new face the old one.
        let (mut old_corners, mut old_faces) = (Vec::new(), Vec::new());
        let (mut triangles, mut number) = (Vec::new(), 0);
        for face in 0..self.faces.len() {
            triangles.clear();
            self.triangulate_into(face, &mut triangles);
            let start = self.faces.corner_range(face).start;
            for triangle in &triangles {
                if is_kept(number) {
                    old_corners.extend(triangle.map(|k| start + k as usize));
                    old_faces.push(face);
                }
                number += 1;
            }
        }
        for corners in self.corner_indices() {
            *corners = old_corners.iter().map(|&c| corners[c]).collect();
        }
        self.faces.starts = (0..=old_faces.len() as u32).map(|k| 3 * k).collect();
        for values in [&mut self.face_materials, &mut self.smoothing] {
            let kept = old_faces.iter().filter_map(|&f| values.get(f));
            *values = kept.copied().collect();
        }
    }

    /// Appends what [`triangulate`](Mesh::triangulate) returns, for callers with many faces.
    ///
    /// # Panics
    /// If `face` or its vertices are out of range.
    pub fn triangulate_into(&self, face: usize, triangles: &mut Vec<[u32; 3]>) {
        let corner = |&v: &u32| self.positions[v as usize];
        match self.faces.get(face) {
            [_, _, _] => triangles.push([0, 1, 2]),
            [a, b, c, d] => {
                triangles.extend(quadrilateral(&[a, b, c, d].map(corner)));
            }
            corners => {
                let polygon: Vec<DVec3> = corners.iter().map(corner).collect();
                triangles.extend(general(&polygon));
            }
        }
    }
}

fn quadrilateral(p: &[DVec3; 4]) -> [FaceTriangle; 2] {
    const FROM_0: [FaceTriangle; 2] = [[0, 1, 2], [0, 2, 3]];
    const FROM_1: [FaceTriangle; 2] = [[0, 1, 3], [1, 2, 3]];
    let area = area_vector(p);
    // A diagonal is valid if both triangles face the same way as the whole.
    let serves = |split: &[FaceTriangle; 2]| {
        split
            .iter()
            .all(|t| area_vector(&t.map(|k| p[k as usize])).dot(area) > 0.0)
    };
    let shorter = (p[3] - p[1]).length_squared() < (1.0 - 1e-9) * (p[2] - p[0]).length_squared();
    match (serves(&FROM_0), serves(&FROM_1)) {
        (true, true) if shorter => FROM_1,
        (false, true) => FROM_1,
        _ => FROM_0,
    }
}

fn general(polygon: &[DVec3]) -> Vec<FaceTriangle> {
    let n = polygon.len() as u32;
    let normal = area_vector(polygon).normalize_or_zero();
    if n < 3 || normal == DVec3::ZERO || !normal.is_finite() {
        return fan(n, 0);
    }
    let frame = Frame::from_normal(normal);
    let flat: Vec<DVec2> = polygon
        .iter()
        .map(|&p| frame.to_local(p - polygon[0]).truncate())
        .collect();
    if let Some(triangles) = convex_fan(&flat) {
        return triangles;
    }
    let clipped = ears(&flat);
    let is_whole = clipped.as_ref().is_some_and(|t| is_partition(&flat, t));
    let repaired = if is_whole { None } else { touching(&flat) };
    repaired.or(clipped).unwrap_or_else(|| fan(n, 0))
}

/// Whether triangles, all of one orientation, have the area of the polygon together.
fn is_partition(flat: &[DVec2], triangles: &[FaceTriangle]) -> bool {
    let whole = whole_area(flat);
    let sum: f64 = triangles.iter().map(|&t| signed_area(flat, t).abs()).sum();
    (sum - whole.abs()).abs() <= 1e-9 * whole.abs()
}

/// Triangles of a polygon that touches itself; `None` if it crosses itself between corners.
///
/// What ear clipping cuts off is decided by corners alone, which fails where several are at one
/// place. So the inside is taken from a triangulation of the plane around the polygon's edges, and
/// each of its corners is replaced by one of the polygon's at the same place.
fn touching(flat: &[DVec2]) -> Option<Vec<FaceTriangle>> {
    let n = flat.len();
    if n > MOST_TOUCHING {
        return None;
    }
    let figure = Figure::polygon(flat.iter().copied());
    let size = figure.bounds().size().max_element();
    let inside = FlatFigure::new(&figure, size);
    let corner_at = |p: DVec2| {
        let distance = |k: &usize| flat[*k].distance_squared(p);
        let nearest = (0..n).min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        (distance(&nearest) <= (1e-9 * size).powi(2)).then_some(nearest as u32)
    };
    let corners = inside.points.iter().map(|&p| corner_at(p));
    let corners: Vec<u32> = corners.collect::<Option<_>>()?;
    let whole = inside.tiles.iter().flat_map(|tile| &tile.triangles);
    let mut triangles: Vec<FaceTriangle> = whole.map(|t| t.map(|k| corners[k as usize])).collect();
    if triangles.len() > n - 2 || !is_partition(flat, &triangles) {
        return None;
    }
    // Corners at one place make up for those that are missing, with triangles without area.
    let last = triangles.last().copied()?;
    triangles.resize(n - 2, [last[0], last[0], last[1]]);
    Some(triangles)
}

/// All triangles from one corner.
fn fan(n: u32, apex: u32) -> Vec<FaceTriangle> {
    (1..n.max(2) - 1)
        .map(|k| [apex, (apex + k) % n, (apex + k + 1) % n])
        .collect()
}

fn signed_area(flat: &[DVec2], [a, b, c]: FaceTriangle) -> f64 {
    let at = |k: u32| flat[k as usize];
    0.5 * (at(b) - at(a)).perp_dot(at(c) - at(a))
}

/// Area of a polygon, positive if it is counter-clockwise.
fn whole_area(flat: &[DVec2]) -> f64 {
    let fan = fan(flat.len() as u32, 0);
    fan.iter().map(|&t| signed_area(flat, t)).sum()
}

/// For a convex polygon the fan whose smallest triangle is largest; `None` for any other, or if
/// every fan has a triangle without area.
fn convex_fan(flat: &[DVec2]) -> Option<Vec<FaceTriangle>> {
    let n = flat.len() as u32;
    if !never_turns_right(flat) || turns(flat) > 1.5 {
        return None;
    }
    let smallest = |apex: u32| {
        fan(n, apex)
            .iter()
            .map(|&t| signed_area(flat, t))
            .fold(f64::INFINITY, f64::min)
    };
    let apexes = if flat.len() <= BEST_FAN_CORNERS { n } else { 1 };
    let whole = whole_area(flat);
    let (mut best, mut best_area) = (0, 0.0);
    for apex in 0..apexes {
        // Only a clearly better apex wins, so that rounding does not decide.
        let area = smallest(apex);
        if area > best_area * (1.0 + 1e-6) + 1e-12 * whole {
            (best, best_area) = (apex, area);
        }
    }
    (best_area > 0.0).then(|| fan(n, best))
}

/// Whether no corner of a polygon turns right.
pub(crate) fn never_turns_right(flat: &[DVec2]) -> bool {
    let n = flat.len() as u32;
    (0..n).all(|k| signed_area(flat, [k, (k + 1) % n, (k + 2) % n]) >= 0.0)
}

/// Turning number of the outline: 1 for a simple polygon, 2 for a pentagram.
pub(crate) fn turns(flat: &[DVec2]) -> f64 {
    let n = flat.len();
    let edge = |k: usize| flat[(k + 1) % n] - flat[k % n];
    let angle: f64 = (0..n).map(|k| edge(k).angle_to(edge(k + 1))).sum();
    angle / std::f64::consts::TAU
}

/// Ear clipping; `None` unless it covers the polygon with n − 2 triangles.
fn ears(flat: &[DVec2]) -> Option<Vec<FaceTriangle>> {
    let n = flat.len() as u32;
    let mut indices: Vec<u32> = Vec::new();
    Earcut::new().earcut(flat.iter().map(|p| [p.x, p.y]), &[], &mut indices);
    let mut triangles: Vec<FaceTriangle> = indices
        .chunks_exact(3)
        .map(|t| [t[0], t[1], t[2]])
        .map(|t| {
            if signed_area(flat, t) < 0.0 {
                [t[0], t[2], t[1]]
            } else {
                t
            }
        })
        .collect();
    restore_dropped(n, &mut triangles);
    (triangles.len() as u32 == n - 2).then_some(triangles)
}

/// Marks a side that no triangle has.
const NONE: u32 = u32::MAX;

/// Restores corners that ear clipping dropped because they lie on a straight line: the triangle on
/// whose edge they lie is divided.
fn restore_dropped(n: u32, triangles: &mut Vec<FaceTriangle>) {
    let mut used = vec![false; n as usize];
    for &k in triangles.iter().flatten() {
        used[k as usize] = true;
    }
    let Some(first) = used.iter().position(|&u| u) else {
        return;
    };
    if used.iter().all(|&u| u) {
        return;
    }
    let ring: Vec<u32> = (0..n).map(|k| (first as u32 + k) % n).collect();
    let kept: Vec<usize> = (0..ring.len())
        .filter(|&i| used[ring[i] as usize])
        .chain([ring.len()])
        .collect();
    let sides = || kept.windows(2).map(|w| [w[0], w[1]]);
    let mut next = vec![NONE; n as usize];
    for [from, to] in sides() {
        next[ring[from] as usize] = ring[to % ring.len()];
    }
    let mut outline = OutlineSides::new(next, triangles);
    for [from, to] in sides().filter(|[from, to]| to - from > 1) {
        outline.divide(triangles, ring[from], &ring[from + 1..to]);
    }
}

/// The triangle at each side of an outline. Looking for it among all triangles would be quadratic in
/// the corners, of which a face can have a million.
struct OutlineSides {
    /// The corner after each corner that has triangles.
    next: Vec<u32>,
    /// The triangle with the directed edge from a corner to the next.
    triangle: Vec<u32>,
}

impl OutlineSides {
    fn new(next: Vec<u32>, triangles: &[FaceTriangle]) -> OutlineSides {
        let mut sides = OutlineSides {
            triangle: vec![NONE; next.len()],
            next,
        };
        for (k, &[a, b, c]) in (0..).zip(triangles) {
            for (p, q) in [(a, b), (b, c), (c, a)] {
                let is_first = sides.triangle[p as usize] == NONE;
                if sides.next[p as usize] == q && is_first {
                    sides.triangle[p as usize] = k;
                }
            }
        }
        sides
    }

    /// Replaces the triangle at the side from `a` by a fan over `a`, `between` and the next corner.
    fn divide(&mut self, triangles: &mut Vec<FaceTriangle>, a: u32, between: &[u32]) {
        let (b, k) = (self.next[a as usize], self.triangle[a as usize]);
        let Some(old) = triangles.get(k as usize).copied() else {
            return;
        };
        let Some(apex) = old.into_iter().find(|&c| c != a && c != b) else {
            return;
        };
        let first = triangles.len() as u32;
        let mut last = a;
        for &m in between {
            triangles.push([last, m, apex]);
            last = m;
        }
        triangles[k as usize] = [last, b, apex];
        // The edge from the apex to `a` went to the first triangle of the fan.
        if self.next[apex as usize] == a && self.triangle[apex as usize] == k {
            self.triangle[apex as usize] = first;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn mesh(points: &[(f64, f64)]) -> Mesh {
        // A tilted, far plane: the polygon's own plane must be found.
        let place = |&(x, y): &(f64, f64)| {
            DVec3::new(4e5, 5e6, 10.0) + x * DVec3::new(0.6, 0.0, 0.8) + y * DVec3::Y
        };
        let mut mesh = Mesh {
            positions: points.iter().map(place).collect(),
            ..Mesh::default()
        };
        mesh.push_face(&(0..points.len() as u32).collect::<Vec<_>>(), 0);
        mesh
    }

    /// n − 2 triangles, none turned over, that add up to the polygon and use every corner.
    fn check(points: &[(f64, f64)]) -> Vec<FaceTriangle> {
        let mesh = mesh(points);
        let triangles = mesh.triangulate(0);
        let whole = mesh.face_area_vector(0);
        let areas: Vec<f64> = triangles
            .iter()
            .map(|t| area_vector(&t.map(|k| mesh.positions[k as usize])).dot(whole.normalize()))
            .collect();
        assert_eq!(triangles.len(), points.len() - 2, "{triangles:?}");
        assert!(areas.iter().all(|&a| a > -1e-9), "{triangles:?} {areas:?}");
        let sum: f64 = areas.iter().sum();
        assert!(
            (sum / whole.length() - 1.0).abs() < 1e-6,
            "{sum} of {}",
            whole.length()
        );
        for k in 0..points.len() as u32 {
            assert!(
                triangles.iter().flatten().any(|&c| c == k),
                "corner {k} unused"
            );
        }
        triangles
    }

    #[test]
    fn quadrilaterals_take_the_shorter_diagonal() {
        let square = [(0., 0.), (1., 0.), (1., 1.), (0., 1.)];
        assert_eq!(check(&square), [[0, 1, 2], [0, 2, 3]]);
        let kite = [(0., 0.), (2., -0.5), (4., 0.), (2., 0.5)];
        assert_eq!(check(&kite), [[0, 1, 3], [1, 2, 3]]);
    }

    #[test]
    fn concave_quadrilaterals_split_at_the_dent() {
        let dent_at = |k: usize| {
            let mut arrow = [(0., 0.), (2., -2.), (0.5, 0.), (2., 2.)];
            arrow.rotate_left(k);
            check(&arrow);
        };
        (0..4).for_each(dent_at);
    }

    #[test]
    fn corners_on_straight_lines_stay_in_use() {
        check(&[(0., 0.), (1., 0.), (2., 0.), (2., 2.), (0., 2.)]);
        let ring = [(0., 0.), (1., 0.), (2., 0.), (3., 0.), (3., 1.), (3., 2.)];
        let other = [(3., 3.), (2., 3.), (1., 3.), (0., 3.), (0., 2.), (0., 1.)];
        check(&[ring, other].concat());
    }

    /// Rounded coordinates put most corners of a fine circle on straight lines.
    #[test]
    fn faces_of_very_many_corners_take_no_quadratic_time() {
        let n = 100_000;
        let corner = |k: u32| {
            let angle = f64::from(k) / f64::from(n) * std::f64::consts::TAU;
            let coarse = |x: f64| (x * 1e6).round() * 1e-6;
            DVec3::new(coarse(angle.cos()), coarse(angle.sin()), 0.0)
        };
        let mut mesh = Mesh {
            positions: (0..n).map(corner).collect(),
            ..Mesh::default()
        };
        mesh.push_face(&(0..n).collect::<Vec<_>>(), 0);
        let triangles = mesh.triangulate(0);
        let mut used = vec![false; n as usize];
        triangles
            .iter()
            .flatten()
            .for_each(|&k| used[k as usize] = true);
        assert!(used.iter().all(|&u| u));
        assert_eq!(triangles.len() as u32, n - 2);
        let area = |t: &[u32; 3]| area_vector(&t.map(|k| mesh.positions[k as usize])).z;
        let sum: f64 = triangles.iter().map(area).sum();
        assert!((sum / mesh.face_area_vector(0).z - 1.0).abs() < 1e-9);
    }

    #[test]
    fn concave_polygons() {
        check(&[(0., 0.), (2., 0.), (2., 1.), (1., 1.), (1., 2.), (0., 2.)]);
        // A comb with collinear teeth tips.
        let mut comb: Vec<(f64, f64)> = vec![(10.0, 3.0), (0.0, 3.0)];
        for k in 0..10 {
            let x = f64::from(k);
            comb.extend([(x, 0.0), (x + 0.5, 0.0), (x + 0.5, 2.0), (x + 1.0, 2.0)]);
        }
        check(&comb);
        let star: Vec<(f64, f64)> = (0..100)
            .map(|k| {
                let (s, c) = (f64::from(k) * std::f64::consts::TAU / 100.0).sin_cos();
                let r = if k % 2 == 0 { 3.0 } else { 1.0 };
                (r * c, r * s)
            })
            .collect();
        check(&star);
    }

    /// n − 2 triangles that are not turned over, with the polygon's area together.
    fn check_area(points: &[(f64, f64)]) {
        let mesh = mesh(points);
        let whole = mesh.face_area_vector(0);
        let areas: Vec<f64> = mesh
            .triangulate(0)
            .iter()
            .map(|t| area_vector(&t.map(|k| mesh.positions[k as usize])).dot(whole.normalize()))
            .collect();
        assert_eq!(areas.len(), points.len() - 2);
        assert!(areas.iter().all(|&a| a > -1e-9), "{points:?}: {areas:?}");
        let sum: f64 = areas.iter().sum();
        let error = (sum / whole.length() - 1.0).abs();
        assert!(error < 1e-6, "{points:?}: {sum} of {}", whole.length());
    }

    #[test]
    fn polygons_that_touch_themselves_fill_no_area_twice() {
        // Two triangles at one corner, both counter-clockwise, from every start.
        let mut bow = [
            (0., 0.),
            (2., -1.),
            (2., 1.),
            (0., 0.),
            (-2., 1.),
            (-2., -1.),
        ];
        for _ in 0..bow.len() {
            bow.rotate_left(1);
            check_area(&bow);
        }
        // A square with a bridge to a square hole, and one with two holes at one corner.
        let outside = [(0., 0.), (9., 0.), (9., 9.), (0., 9.), (0., 0.)];
        let hole = |x: f64, y: f64| [(x, y), (x, y + 2.), (x + 2., y + 2.), (x + 2., y), (x, y)];
        let mut one = [&outside[..], &hole(1., 1.)].concat();
        let mut two = [&outside[..], &hole(1., 1.), &[(0., 0.)], &hole(4., 1.)].concat();
        for _ in 0..20 {
            one.rotate_left(1);
            two.rotate_left(1);
            check_area(&one);
            check_area(&two);
        }
        // There and back along one edge, outside and inside.
        check_area(&[
            (0., 0.),
            (4., 0.),
            (4., 2.),
            (6., 2.),
            (4., 2.),
            (4., 4.),
            (0., 4.),
        ]);
        check_area(&[
            (0., 0.),
            (4., 0.),
            (4., 2.),
            (2., 2.),
            (4., 2.),
            (4., 4.),
            (0., 4.),
        ]);
    }

    proptest! {
        /// Stars around a common corner, with bridges to holes in their arms, turned and scaled.
        #[test]
        fn weakly_simple_polygons_have_their_area(
            arms in proptest::collection::vec((0.5..3.0, 0.05..0.9, any::<bool>()), 1..6),
            start in 0usize..40,
            angle in 0.0..std::f64::consts::TAU,
        ) {
            let count = arms.len() as f64;
            let mut points = Vec::new();
            for (k, arm) in arms.into_iter().enumerate() {
                let (length, width, has_hole): (f64, f64, bool) = arm;
                let middle = angle + k as f64 / count * std::f64::consts::TAU;
                let half = 0.5 * width * (std::f64::consts::TAU / count).min(2.0);
                let at = |r: f64, a: f64| ((middle + a).cos() * r, (middle + a).sin() * r);
                points.extend([(0.0, 0.0), at(length, -half), at(length, half)]);
                if has_hole {
                    let (near, far) = (0.4 * length, 0.6 * length);
                    let hole = [at(near, 0.0), at(far, 0.3 * half), at(far, -0.3 * half)];
                    points.extend([(0.0, 0.0), hole[0], hole[1], hole[2], hole[0]]);
                }
            }
            let start = start % points.len();
            points.rotate_left(start);
            check_area(&points);
        }
    }

    #[test]
    fn hopeless_polygons_are_fans() {
        let count = |points: &[(f64, f64)], expected: usize| {
            let triangles = mesh(points).triangulate(0);
            assert_eq!(triangles.len(), expected);
            assert!(
                triangles
                    .iter()
                    .flatten()
                    .all(|&k| (k as usize) < points.len())
            );
        };
        count(&[(1., 1.); 6], 4);
        count(&[(0., 0.), (1., 0.), (2., 0.), (3., 0.), (4., 0.)], 3);
        count(&[(f64::NAN, 0.), (1., 0.), (2., 5.), (3., 0.), (4., 0.)], 3);
        count(&[(f64::INFINITY, 0.), (1., 0.), (2., 5.), (3., 0.)], 2);
        let pentagram: Vec<(f64, f64)> = (0..5)
            .map(|k| (f64::from(2 * k) * std::f64::consts::TAU / 5.0).sin_cos())
            .map(|(s, c)| (c, s))
            .collect();
        count(&pentagram, 3);
    }
}
