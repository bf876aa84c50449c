//! Partially occluded pairs.
//!
//! What a point of one facet sees of the other is known exactly: the other is clipped at the planes
//! through the point and the edges that separate visible from hidden. The first facet is cut along
//! discontinuities, where corners and edges pass each other, so that the view is smooth in each
//! cell and a few Gauss points per cell are enough. Where blockers or the other facet are too close
//! for that, the facet is quartered first and the obstructions are tested again; where they touch,
//! cells are halved until their errors are small ([`exchange_area_past`]).

use super::horizon::{Elevation, Horizon};
use super::slabs::exchange_above;
use super::work::{PairWork, WorkKind};
use super::{Facet, MOST_CORNERS};
use crate::analytic::{
    Approximate, Blocker, Effect, PLANE, edge_bit, exchange_area, exchange_area_fast,
    exchange_area_past, gauss, integrate_cells,
};
use azulejo_scene::math::area_vector;
use azulejo_trace::lambert::{ArrayPolygon, polygon_vector};
use glam::DVec3;

/// Most levels of quartering of a pair.
const MOST_DEPTH: u32 = 5;
/// Size of either facet over its distance from what it sees, above which adaptive cells are cheaper than
/// quarters: measured, on a town and in rooms.
const CLOSE: f64 = 1.0;
/// Most views of a pair by adaptive cells: before quarters are tried, and of the last quarters.
const MOST_VIEWS: [usize; 2] = [1 << 15, 1 << 13];
/// Most cells of one facet.
const MOST_CELLS: usize = 32;
/// Relative error of Gauss points, m² per cell for m from 1, over (radius/distance)^2m: measured.
const SHARES: [f64; 3] = [1.5, 0.1, 0.1];

/// The same for replacing a piece by its centroid.
const FAR: f64 = 0.1;

/// Relative error of cells with discontinuities inside, once there are too many to cut along all of them:
/// measured.
const UNCUT: f64 = 0.01;

/// A blocker or window, with the edges that matter.
#[derive(Clone, Copy)]
struct Obstruction<'a> {
    blocker: &'a Blocker,
    edges: u64,
    is_window: bool,
}

/// Reusable working memory.
#[derive(Default)]
pub(super) struct PartialVisibility {
    cells: Vec<ClippedPolygon>,
    pieces: Vec<ClippedPolygon>,
    next: Vec<ClippedPolygon>,
    planes: Vec<(DVec3, f64)>,
    rest: [ClippedPolygon; 2],
    /// Whether there are more cells than are cut.
    is_uncut: bool,
    /// Error of the present pair beyond its goal.
    doubt: f64,
    /// What was done.
    pub work: PairWork,
}

/// Most corners of a piece: a quadrilateral clipped eight times.
const MOST_PIECE: usize = 12;

/// A convex polygon without allocation.
#[derive(Clone, Copy)]
struct ClippedPolygon {
    points: [DVec3; MOST_PIECE],
    count: usize,
}

impl ClippedPolygon {
    fn set(&mut self, points: impl IntoIterator<Item = DVec3>) {
        self.count = 0;
        points.into_iter().for_each(|p| self.push(p));
    }

    fn push(&mut self, p: DVec3) {
        // More would take half a dozen blockers whose shadows share a corner.
        if self.count < MOST_PIECE {
            self.points[self.count] = p;
            self.count += 1;
        }
    }

    fn all(&self) -> &[DVec3] {
        &self.points[..self.count]
    }

    /// Heights over the plane normal · p = offset, with the lowest and the highest.
    fn heights(&self, normal: DVec3, offset: f64) -> ([f64; MOST_PIECE], f64, f64) {
        let mut heights = [0.0; MOST_PIECE];
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for (h, p) in heights.iter_mut().zip(self.all()) {
            *h = p.dot(normal) - offset;
            (low, high) = (low.min(*h), high.max(*h));
        }
        (heights, low, high)
    }

    /// Clips to where `sign` times the height is positive.
    fn clip(&self, heights: &[f64; MOST_PIECE], sign: f64, into: &mut ClippedPolygon) {
        into.count = 0;
        let Some(last) = self.count.checked_sub(1) else {
            return;
        };
        let (mut a, mut height_a) = (self.points[last], sign * heights[last]);
        for (&b, h) in self.all().iter().zip(heights) {
            let height_b = sign * h;
            // Always from the inner end, so that neighbours with a common edge agree.
            if height_a > 0.0 && height_b < 0.0 {
                into.push(a.lerp(b, height_a / (height_a - height_b)));
            } else if height_a < 0.0 && height_b > 0.0 {
                into.push(b.lerp(a, height_b / (height_b - height_a)));
            }
            if height_b >= 0.0 {
                into.push(b);
            }
            (a, height_a) = (b, height_b);
        }
    }
}

impl Default for ClippedPolygon {
    fn default() -> ClippedPolygon {
        ClippedPolygon {
            points: [DVec3::ZERO; MOST_PIECE],
            count: 0,
        }
    }
}

/// What is computed of a pair, and its accuracy.
#[derive(Clone, Copy)]
pub(super) struct PairGoal {
    /// With an up direction, only light that leaves the first facet upwards counts: what each of
    /// its points sees above the horizon.
    pub up: Option<DVec3>,
    /// Absolute error of the exchange area.
    pub error: f64,
    /// Relative error of formulas.
    pub whole: f64,
    pub graze: f64,
}

/// A pair, or a part of one after quartering.
#[derive(Clone, Copy)]
struct PairPart<'a> {
    a: &'a Facet,
    b: &'a Facet,
    depth: u32,
    /// Whether the visible part is computed, rather than minus the hidden part.
    wants_seen: bool,
}

impl PartialVisibility {
    /// Exchange area of two facets fully in front of each other, with obstructions, each with the
    /// edges that matter to the whole pair and whether it is a window.
    pub fn exchange<'a>(
        &mut self,
        [a, b]: [&Facet; 2],
        obstructions: impl Iterator<Item = (&'a Blocker, u64, bool)>,
        goal: PairGoal,
    ) -> Approximate {
        let all = obstructions.map(|(blocker, edges, is_window)| Obstruction {
            blocker,
            edges,
            is_window,
        });
        let obstructions: Vec<Obstruction> = all.collect();
        let wants_seen = goal.up.is_some() || obstructions.iter().any(|s| s.is_window);
        let pair = PairPart {
            a,
            b,
            depth: 0,
            wants_seen,
        };
        self.doubt = 0.0;
        self.work.count(WorkKind::Contour, 1);
        let base = if wants_seen { 0.0 } else { whole(a, b, goal) };
        let value = base
            + if goal.up.is_some() {
                self.part(pair, &obstructions, goal)
            } else {
                self.culled(pair, &obstructions, goal)
            };
        Approximate {
            value: value.max(0.0),
            error: goal.error + self.doubt,
        }
    }

    /// As [`culled`](PartialVisibility::culled), after testing which obstructions and edges matter
    /// to the pair.
    fn part(&mut self, pair: PairPart, obstructions: &[Obstruction], goal: PairGoal) -> f64 {
        let PairPart { a, b, .. } = pair;
        let goal = match goal.up.map(|up| {
            Horizon::new(a, up, goal.graze).elevation_of_part(&Horizon::new(b, up, goal.graze))
        }) {
            None | Some(Elevation::Mixed) => goal,
            Some(Elevation::Below) => return 0.0,
            Some(Elevation::Above) => PairGoal { up: None, ..goal },
        };
        self.work.count(WorkKind::Effect, obstructions.len());
        let mut kept: Vec<Obstruction> = Vec::with_capacity(obstructions.len());
        for obstruction in obstructions {
            let effect = obstruction
                .blocker
                .effect(a.polygon(), b.polygon(), goal.graze);
            match (effect, obstruction.is_window) {
                (Effect::None, true) | (Effect::Hides, false) => {
                    return if pair.wants_seen {
                        0.0
                    } else {
                        -whole(a, b, goal)
                    };
                }
                (Effect::None, false) | (Effect::Hides, true) => {}
                (Effect::Partial(edges), _) => kept.push(Obstruction {
                    edges,
                    ..*obstruction
                }),
            }
        }
        if kept.is_empty() && goal.up.is_none() {
            return if pair.wants_seen {
                whole(a, b, goal)
            } else {
                0.0
            };
        }
        self.culled(pair, &kept, goal)
    }

    /// The visible part of a pair behind obstructions that all matter, or minus the hidden part.
    fn culled(&mut self, pair: PairPart, kept: &[Obstruction], goal: PairGoal) -> f64 {
        let PairPart { a, b, .. } = pair;
        let (ratio_a, ratio_b) = (ratio(a, b, kept), ratio(b, a, kept));
        let size = rough(a, b);
        let fits = |points: usize| {
            SHARES[points - 1] * ratio_a.min(ratio_b).powi(2 * points as i32) * size < goal.error
        };
        // From afar, a piece is as visible as its centroid.
        let is_far = |ratio: f64| FAR * ratio * ratio * size < goal.error;
        let points = (1..3).find(|&m| fits(m)).unwrap_or(3);
        if let Some(up) = goal.up.filter(|_| kept.is_empty() && !fits(points)) {
            let (seen, slabs) = exchange_above([a, b], up, goal);
            // A slab against what is above it, and against the part of the other in it.
            self.work.count(WorkKind::Contour, 2 * slabs);
            if seen.error > goal.error {
                self.doubt = self.doubt.hypot(seen.error);
            }
            return seen.value;
        }
        if points == 3 && !fits(3) {
            let is_close = ratio_a.min(ratio_b) > CLOSE || pair.depth == MOST_DEPTH;
            if is_close && let Some(value) = self.adaptively(pair, kept, goal) {
                return value;
            }
            if pair.depth < MOST_DEPTH {
                return self.quartered(pair, ratio_a >= ratio_b, kept, goal);
            }
        }
        let (from_to, way, is_far) = if ratio_a <= ratio_b {
            ([a, b], 1.0, is_far(ratio_b))
        } else {
            ([b, a], -1.0, is_far(ratio_a))
        };
        self.cut_cells(from_to, kept, goal);
        if self.is_uncut && UNCUT * size > goal.error {
            if pair.depth < MOST_DEPTH {
                return self.quartered(pair, way > 0.0, kept, goal);
            }
            if let Some(value) = self.adaptively(pair, kept, goal) {
                return value;
            }
        }
        let seen = self.integrate(from_to, way, kept, points, is_far, goal);
        let sees_part = goal.up.is_some() || kept.iter().any(|s| s.is_window);
        if pair.wants_seen && !sees_part {
            seen + whole(a, b, goal)
        } else {
            seen
        }
    }

    /// As [`culled`](PartialVisibility::culled), by cells that get finer towards where facets and blockers
    /// touch, as many as it takes; `None` where that takes too many and quarters may do.
    fn adaptively(&mut self, pair: PairPart, kept: &[Obstruction], goal: PairGoal) -> Option<f64> {
        let (a, b) = (pair.a.polygon(), pair.b.polygon());
        let (seen, base) = if goal.up.is_some() || kept.iter().any(|s| s.is_window) {
            (self.by_views(pair, kept, goal), 0.0)
        } else {
            let blockers = kept.iter().map(|s| (s.blocker, false));
            let (seen, views) = exchange_area_past(a, b, blockers, goal.error);
            self.work.count(WorkKind::ExactView, views);
            let base = if pair.wants_seen {
                0.0
            } else {
                exchange_area(a, b)
            };
            (seen, base)
        };
        if seen.error > goal.error {
            if pair.depth < MOST_DEPTH {
                return None;
            }
            self.doubt = self.doubt.hypot(seen.error);
        }
        Some(seen.value - base)
    }

    /// What is seen through windows or above the horizon, by views from cells that get finer where these change
    /// abruptly.
    fn by_views(&mut self, pair: PairPart, kept: &[Obstruction], goal: PairGoal) -> Approximate {
        let PairPart { a, b, depth, .. } = pair;
        let ([from, to], way) = if ratio(a, b, kept) <= ratio(b, a, kept) {
            ([a, b], 1.0)
        } else {
            ([b, a], -1.0)
        };
        self.cut_cells([from, to], kept, goal);
        let polygon = |cell: &ClippedPolygon| cell.all().iter().copied().collect();
        let cells: Vec<ArrayPolygon> = self.cells.iter().map(polygon).collect();
        let horizon = goal.up.map(|up| way * up);
        let most = MOST_VIEWS[usize::from(depth == MOST_DEPTH)];
        integrate_cells(&cells, from.normal, goal.error, most, |point| {
            self.view(point, [from, to], way, kept, false, horizon)
        })
    }

    fn quartered(
        &mut self,
        pair: PairPart,
        splits_a: bool,
        obstructions: &[Obstruction],
        goal: PairGoal,
    ) -> f64 {
        let goal = PairGoal {
            error: 0.5 * goal.error,
            ..goal
        };
        let depth = pair.depth + 1;
        let quarters = if splits_a {
            quarters(pair.a)
        } else {
            quarters(pair.b)
        };
        let parts = quarters.iter().map(|quarter| {
            if splits_a {
                self.part(
                    PairPart {
                        a: quarter,
                        depth,
                        ..pair
                    },
                    obstructions,
                    goal,
                )
            } else {
                self.part(
                    PairPart {
                        b: quarter,
                        depth,
                        ..pair
                    },
                    obstructions,
                    goal,
                )
            }
        });
        parts.sum()
    }

    /// The visible part, or minus the hidden part, summed over points of the cells of one facet; `way` is −1
    /// from the second facet of the pair to the first.
    fn integrate(
        &mut self,
        [from, to]: [&Facet; 2],
        way: f64,
        obstructions: &[Obstruction],
        points: usize,
        is_far: bool,
        goal: PairGoal,
    ) -> f64 {
        // What a point of the second facet sees below its horizon, it is seen from above.
        let horizon = goal.up.map(|up| way * up);
        let rule = gauss(points);
        let mut sum = 0.0;
        let cells = std::mem::take(&mut self.cells);
        for cell in &cells {
            let p = cell.all();
            for k in (1..p.len().saturating_sub(1)).step_by(2) {
                let [a, b, c, d] = [0, k, k + 1, (k + 2).min(p.len() - 1)].map(|k| p[k]);
                let (ab, ad, twist) = (b - a, d - a, a - b + c - d);
                for &(u, weight_u) in rule {
                    for &(v, weight_v) in rule {
                        let jacobian = (ab + v * twist).cross(ad + u * twist).dot(from.normal);
                        let place = a + u * ab + v * ad + u * v * twist;
                        let pair = [from, to];
                        let view = self.view(place, pair, way, obstructions, is_far, horizon);
                        sum += weight_u * weight_v * jacobian * view;
                    }
                }
            }
        }
        self.cells = cells;
        sum
    }

    /// Cuts a facet along the discontinuities of the view of another.
    fn cut_cells(
        &mut self,
        [from, to]: [&Facet; 2],
        obstructions: &[Obstruction],
        PairGoal { up, graze, .. }: PairGoal,
    ) {
        self.is_uncut = false;
        self.cells.clear();
        let mut whole = ClippedPolygon::default();
        whole.set(from.polygon().iter().copied());
        self.cells.push(whole);
        if let Some(up) = up {
            // The horizon passes a corner at the corner's height.
            to.polygon()
                .iter()
                .for_each(|&corner| self.cut(up, up.dot(corner), graze));
        }
        for obstruction in obstructions {
            let p = &obstruction.blocker.polygon;
            if obstruction.edges & PLANE != 0 {
                self.cut(
                    obstruction.blocker.normal,
                    obstruction.blocker.offset,
                    graze,
                );
            }
            for k in (0..p.len()).filter(|&k| obstruction.edges & edge_bit(k) != 0) {
                let (start, end) = (p[k], p[(k + 1) % p.len()]);
                for &corner in to.polygon() {
                    let normal = (start - corner).cross(end - corner);
                    // Most planes pass the facet by.
                    let height = normal.dot(from.centre - corner);
                    let reach = from.radius * from.radius * normal.length_squared();
                    if height * height < reach {
                        let normal = normal.normalize_or_zero();
                        self.cut(normal, normal.dot(corner), graze);
                    }
                }
            }
        }
    }

    /// Cuts all cells at a plane.
    fn cut(&mut self, normal: DVec3, offset: f64, graze: f64) {
        for k in 0..self.cells.len() {
            let (heights, low, high) = self.cells[k].heights(normal, offset);
            if low < -graze && high > graze {
                if self.cells.len() >= MOST_CELLS {
                    self.is_uncut = true;
                    return;
                }
                let mut halves = [ClippedPolygon::default(); 2];
                self.cells[k].clip(&heights, 1.0, &mut halves[0]);
                self.cells[k].clip(&heights, -1.0, &mut halves[1]);
                self.cells[k] = halves[0];
                self.cells.push(halves[1]);
            }
        }
    }

    /// Form factor density of what a point sees through windows, or minus the hidden part; with a
    /// `horizon` of what it sees on that side of its height.
    fn view(
        &mut self,
        eye: DVec3,
        pair: [&Facet; 2],
        way: f64,
        obstructions: &[Obstruction],
        is_far: bool,
        horizon: Option<DVec3>,
    ) -> f64 {
        self.work.count(WorkKind::View, 1);
        // Put the target relative to the eye, the apex of all cones.
        let to = pair[1];
        let mut target = ClippedPolygon::default();
        target.set(to.polygon().iter().map(|&p| p - eye));
        let measure = |piece: &ClippedPolygon| measure(piece, pair, is_far);
        let mut sum = 0.0;
        if let Some(horizon) = horizon {
            match inside(&target, &[(horizon, 0.0)], &mut self.rest, None) {
                Some(part) => target = *part,
                None => return 0.0,
            }
        }
        // Through windows, or on one side of a horizon, count what is seen.
        let has_window = obstructions.first().is_some_and(|s| s.is_window);
        if has_window || horizon.is_some() {
            for obstruction in obstructions.iter().take_while(|s| s.is_window) {
                if !self.cone(eye, obstruction, to, way) {
                    return 0.0;
                }
                match inside(&target, &self.planes, &mut self.rest, None) {
                    Some(part) => target = *part,
                    None => return 0.0,
                }
            }
            sum = measure(&target);
        }
        // Subtract what blockers hide: each is tested against what those before leave, so that nothing counts twice.
        let mut blockers = obstructions.iter().skip_while(|s| s.is_window).peekable();
        self.pieces.clear();
        self.pieces.push(target);
        while let Some(obstruction) = blockers.next() {
            if !self.cone(eye, obstruction, to, way) {
                continue;
            }
            self.work.count(WorkKind::Cut, self.pieces.len());
            self.next.clear();
            for piece in &self.pieces {
                // What the last blocker leaves is not needed.
                let outside = blockers.peek().map(|_| &mut self.next);
                if let Some(part) = inside(piece, &self.planes, &mut self.rest, outside) {
                    sum -= measure(part);
                }
            }
            std::mem::swap(&mut self.pieces, &mut self.next);
        }
        sum
    }

    /// The planes, relative to the viewpoint, inside which an obstruction covers the target; false
    /// if it covers nothing.
    fn cone(&mut self, eye: DVec3, obstruction: &Obstruction, to: &Facet, way: f64) -> bool {
        let p = &obstruction.blocker.polygon;
        let height = obstruction.blocker.height(eye);
        self.planes.clear();
        let sign = height.signum();
        if obstruction.blocker.is_one_sided && sign != way {
            return false;
        }
        if obstruction.edges & PLANE != 0 {
            // The covered part lies beyond the plane.
            let is_beyond = |&q: &DVec3| sign * obstruction.blocker.height(q) < 0.0;
            if !to.polygon().iter().any(is_beyond) {
                return false;
            }
            self.planes
                .push((-sign * obstruction.blocker.normal, sign * height));
        }
        for k in (0..p.len()).filter(|&k| obstruction.edges & edge_bit(k) != 0) {
            let (a, b) = (p[k], p[(k + 1) % p.len()]);
            self.planes.push((sign * (b - a).cross(a - eye), 0.0));
        }
        true
    }
}

/// The part of `piece` inside all planes, if any; the parts outside go to `outside`, cut apart so
/// that none counts twice.
fn inside<'a>(
    piece: &'a ClippedPolygon,
    planes: &[(DVec3, f64)],
    scratch: &'a mut [ClippedPolygon; 2],
    mut outside: Option<&mut Vec<ClippedPolygon>>,
) -> Option<&'a ClippedPolygon> {
    let before = outside.as_ref().map_or(0, |o| o.len());
    let [first, second] = scratch;
    // Which of the two buffers holds the remainder; none at first.
    let mut rest = 0;
    for &(normal, offset) in planes {
        let now = [piece, &*first, &*second][rest];
        let (heights, low, high) = now.heights(normal, offset);
        if high <= 0.0 {
            // All of it is outside: kept in one piece rather than in several.
            if let Some(outside) = outside {
                outside.truncate(before);
                outside.push(*piece);
            }
            return None;
        }
        if low >= 0.0 {
            continue;
        }
        if let Some(outside) = outside.as_mut() {
            let mut part = ClippedPolygon::default();
            now.clip(&heights, -1.0, &mut part);
            if part.count > 2 {
                outside.push(part);
            }
        }
        rest = match rest {
            0 => {
                piece.clip(&heights, 1.0, first);
                1
            }
            1 => {
                first.clip(&heights, 1.0, second);
                2
            }
            _ => {
                second.clip(&heights, 1.0, first);
                1
            }
        };
    }
    let now = [piece, &*first, &*second][rest];
    (now.count > 2).then_some(now)
}

/// Form factor density from the origin, on the first facet of a pair, to a piece of the second.
fn measure(piece: &ClippedPolygon, [from, to]: [&Facet; 2], is_far: bool) -> f64 {
    if !is_far {
        return polygon_vector(DVec3::ZERO, piece.all()).dot(from.normal);
    }
    let p = piece.all();
    let (mut area, mut moment) = (0.0, DVec3::ZERO);
    for w in p[1..].windows(2) {
        let (u, v) = (w[0] - p[0], w[1] - p[0]);
        let twice = u.cross(v).dot(to.normal);
        area += twice;
        moment += twice * (u + v);
    }
    // Negative values are rounding on slivers.
    if area <= 0.0 {
        return 0.0;
    }
    let centre = p[0] + moment / (3.0 * area);
    let squared = centre.length_squared();
    let cosines = -from.normal.dot(centre) * to.normal.dot(centre);
    0.5 * area * cosines / (std::f64::consts::PI * squared * squared)
}

/// Exchange area of an unoccluded pair.
fn whole(a: &Facet, b: &Facet, goal: PairGoal) -> f64 {
    exchange_area_fast(a.polygon(), b.polygon(), goal.whole)
}

/// An upper estimate of the same.
pub(super) fn rough(a: &Facet, b: &Facet) -> f64 {
    let area = |f: &Facet| area_vector(f.polygon()).length();
    let (first, second) = (area(a), area(b));
    let squared = a.centre.distance_squared(b.centre);
    (first * second / (std::f64::consts::PI * squared)).min(first.min(second))
}

/// Size of `from` over the distance of what it sees: how far the view is from smooth.
fn ratio(from: &Facet, to: &Facet, obstructions: &[Obstruction]) -> f64 {
    let mut nearest = to.centre.distance(from.centre) - to.radius;
    for obstruction in obstructions {
        let p = &obstruction.blocker.polygon;
        for k in (0..p.len()).filter(|&k| obstruction.edges & edge_bit(k) != 0) {
            nearest = nearest.min(distance(from.centre, p[k], p[(k + 1) % p.len()]));
        }
    }
    from.radius / nearest.max(1e-300)
}

/// Distance of a point from a segment.
fn distance(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let along = (p - a).dot(b - a) / (b - a).length_squared();
    p.distance(a.lerp(b, along.clamp(0.0, 1.0)))
}

/// The quarters of a facet, by the midpoints of its sides.
fn quarters(facet: &Facet) -> Vec<Facet> {
    let p = facet.polygon();
    let piece = |corners: &[DVec3]| Facet::new(facet.id, corners, facet.normal);
    let middle = |i: usize, j: usize| 0.5 * (p[i] + p[j]);
    match p.len() {
        3 => {
            let [d, e, f] = [middle(0, 1), middle(1, 2), middle(2, 0)];
            vec![
                piece(&[p[0], d, f]),
                piece(&[d, p[1], e]),
                piece(&[f, e, p[2]]),
                piece(&[d, e, f]),
            ]
        }
        4 => {
            let [e, f, g, h] = [middle(0, 1), middle(1, 2), middle(2, 3), middle(3, 0)];
            let m = 0.5 * (e + g);
            vec![
                piece(&[p[0], e, m, h]),
                piece(&[e, p[1], f, m]),
                piece(&[m, f, p[2], g]),
                piece(&[h, m, g, p[3]]),
            ]
        }
        n => (1..n - 1).map(|k| piece(&[p[0], p[k], p[k + 1]])).collect(),
    }
}

const _: () = assert!(MOST_CORNERS <= MOST_PIECE);
