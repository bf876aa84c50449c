//! Rays against bicubic patches.

use super::leaf::{Boundary, LeafHit, LeafPoint, facing};
use super::line::Line3;
use azulejo_scene::BicubicPatch;
use azulejo_scene::math::Frame;
use glam::{DVec2, DVec3};

/// A patch prepared for rays.
#[derive(Clone, Debug)]
pub(crate) struct ExactPatch {
    patch: BicubicPatch,
}

/// Number of halvings of one parameter after which a piece counts as a point.
const FINEST: u32 = 12;

/// Largest number of pieces examined for one line: enough for any smooth patch; without a limit, a
/// patch that folds onto the line would never finish.
const MOST_PIECES: usize = 2000;

/// Hits closer than this in both parameters are merged.
const SAME: f64 = 1e-7;

/// A Newton step shorter than this is the last.
const LAST_STEP: f64 = 1e-9;

/// Amount by which rounding may take a parameter outside of 0..=1.
const OVER: f64 = 1e-9;

/// Control points projected along a line, which becomes the origin.
type Net = [[DVec2; 4]; 4];

/// A piece of the patch: its control net and its range of parameters.
struct Piece {
    net: Net,
    corner: DVec2,
    size: DVec2,
    depth: u32,
}

impl ExactPatch {
    /// Prepares a patch in the tracer's own coordinates.
    pub(crate) fn new(patch: BicubicPatch) -> ExactPatch {
        ExactPatch { patch }
    }

    /// All hits, in no order.
    pub(crate) fn all(&self, line: &Line3, leaf: u32, out: &mut Vec<Boundary>) {
        let mut roots: Vec<DVec2> = Vec::new();
        self.search(line, &mut roots);
        let length2 = line.direction.length_squared();
        out.extend(roots.iter().map(|&at| {
            let (p, du, dv) = self.patch.at(at.x, at.y);
            let (part, parameter) = pack(at);
            let hit = LeafHit {
                t: (p - line.origin).dot(line.direction) / length2,
                part,
                parameter,
                enters: du.cross(dv).dot(line.direction) < 0.0,
            };
            Boundary { hit, leaf }
        }));
    }

    /// Halves pieces whose control net's box contains the line until Newton's method is safe.
    fn search(&self, line: &Line3, roots: &mut Vec<DVec2>) {
        let frame = Frame::from_normal(line.direction.normalize());
        let see = |p: DVec3| {
            let p = p - line.origin;
            DVec2::new(frame.x.dot(p), frame.y.dot(p))
        };
        let whole = self.patch.points.map(|row| row.map(see));
        let mut waiting = vec![Piece {
            net: whole,
            corner: DVec2::ZERO,
            size: DVec2::ONE,
            depth: 0,
        }];
        let mut pieces = 0;
        while let Some(piece) = waiting.pop() {
            pieces += 1;
            if pieces > MOST_PIECES || !piece.holds_origin() {
                continue;
            }
            if piece.depth == 2 * FINEST {
                add(roots, piece.corner + 0.5 * piece.size);
            } else if piece.is_one_to_one() {
                if let Some(at) = newton(&whole, piece.corner, piece.size) {
                    add(roots, at);
                }
            } else {
                waiting.extend(piece.halves());
            }
        }
    }

    /// The surface point of a hit.
    pub(crate) fn resolve(&self, line: &Line3, hit: &LeafHit) -> LeafPoint {
        let mut at = unpack(hit.part, hit.parameter);
        for _ in 0..4 {
            at = self.nearer(line, at);
        }
        let (position, du, dv) = self.patch.at(at.x, at.y);
        let t = (position - line.origin).dot(line.direction) / line.direction.length_squared();
        LeafPoint {
            t,
            u: at.x,
            v: at.y,
            position,
            normal: facing(self.normal(at, du, dv), line.direction, hit.enters),
        }
    }

    /// One Newton step toward the line; none if it is large or not finite.
    fn nearer(&self, line: &Line3, at: DVec2) -> DVec2 {
        let (p, du, dv) = self.patch.at(at.x, at.y);
        let d = line.direction;
        // p + a du + b dv = origin + t d.
        let normal = du.cross(dv);
        let (whole, away) = (normal.dot(d), line.origin - p);
        let a = away.cross(dv).dot(d) / whole;
        let b = du.cross(away).dot(d) / whole;
        let step = DVec2::new(a, b);
        if step.is_finite() && step.length() < 1e-3 {
            (at + step).clamp(DVec2::ZERO, DVec2::ONE)
        } else {
            at
        }
    }

    /// Unit normal, also at corners with coincident control points.
    fn normal(&self, at: DVec2, du: DVec3, dv: DVec3) -> DVec3 {
        let normal = du.cross(dv);
        let size = self.patch.bounds().diagonal();
        if normal.length() > 1e-12 * size * size {
            return normal.normalize_or_zero();
        }
        let inside = at.clamp(DVec2::splat(1e-3), DVec2::splat(1.0 - 1e-3));
        let (_, du, dv) = self.patch.at(inside.x, inside.y);
        du.cross(dv).normalize_or_zero()
    }
}

/// Parameters as stored in a hit: `u` in 30 bits, `v` unchanged.
fn pack(at: DVec2) -> (u32, f32) {
    ((at.x * UNIT).round() as u32, at.y as f32)
}

fn unpack(part: u32, parameter: f32) -> DVec2 {
    DVec2::new(f64::from(part) / UNIT, f64::from(parameter))
}

const UNIT: f64 = ((1u32 << 30) - 1) as f64;

fn add(roots: &mut Vec<DVec2>, at: DVec2) {
    if roots.iter().all(|f| (*f - at).abs().max_element() > SAME) {
        roots.push(at);
    }
}

impl Piece {
    fn holds_origin(&self) -> bool {
        let points = || self.net.iter().flatten().copied();
        let low = points().fold(DVec2::INFINITY, DVec2::min);
        let high = points().fold(DVec2::NEG_INFINITY, DVec2::max);
        low.cmple(DVec2::ZERO).all() && high.cmpge(DVec2::ZERO).all()
    }

    /// Whether the projected piece is injective, by the ranges of its derivatives: the Jacobian has
    /// the same sign for all values in these ranges.
    fn is_one_to_one(&self) -> bool {
        let n = &self.net;
        let across = |i: usize| (0..3).map(move |k| n[i][k + 1] - n[i][k]);
        let du = range((0..4).flat_map(across));
        let dv = range((0..3).flat_map(|i| (0..4).map(move |k| n[i + 1][k] - n[i][k])));
        let (a, b) = product((du.0.x, du.1.x), (dv.0.y, dv.1.y));
        let (c, d) = product((du.0.y, du.1.y), (dv.0.x, dv.1.x));
        a > d || b < c
    }

    /// The two halves along the parameter that is divided next.
    fn halves(&self) -> [Piece; 2] {
        let along_u = self.depth.is_multiple_of(2);
        let net = if along_u {
            self.net
        } else {
            transposed(&self.net)
        };
        let halves = net.map(halve);
        [0, 1].map(|side| {
            let half = [0, 1, 2, 3].map(|i| halves[i][side]);
            let step = if along_u {
                DVec2::new(0.5, 1.0)
            } else {
                DVec2::new(1.0, 0.5)
            };
            let size = self.size * step;
            Piece {
                net: if along_u { half } else { transposed(&half) },
                corner: self.corner + side as f64 * (self.size - size),
                size,
                depth: self.depth + 1,
            }
        })
    }
}

/// De Casteljau's halves of a curve.
fn halve([a, b, c, d]: [DVec2; 4]) -> [[DVec2; 4]; 2] {
    let middle = |p: DVec2, q: DVec2| 0.5 * (p + q);
    let (ab, bc, cd) = (middle(a, b), middle(b, c), middle(c, d));
    let (abc, bcd) = (middle(ab, bc), middle(bc, cd));
    let whole = middle(abc, bcd);
    [[a, ab, abc, whole], [whole, bcd, cd, d]]
}

fn transposed(net: &Net) -> Net {
    [0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|k| net[k][i]))
}

fn range(vectors: impl Iterator<Item = DVec2>) -> (DVec2, DVec2) {
    vectors.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), v| {
        (low.min(v), high.max(v))
    })
}

/// Range of the products of two ranges.
fn product(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    let all = [a.0 * b.0, a.0 * b.1, a.1 * b.0, a.1 * b.1];
    let low = all.iter().copied().fold(f64::INFINITY, f64::min);
    (low, all.iter().copied().fold(f64::NEG_INFINITY, f64::max))
}

/// The parameters at which the projected patch is zero, if they are within the piece or, by
/// rounding, just outside of it.
fn newton(net: &Net, corner: DVec2, size: DVec2) -> Option<DVec2> {
    let mut at = corner + 0.5 * size;
    let over = DVec2::splat(OVER);
    for _ in 0..30 {
        let (p, du, dv) = value(net, at);
        let whole = du.perp_dot(dv);
        let step = DVec2::new(dv.perp_dot(p), p.perp_dot(du)) / whole;
        if !step.is_finite() {
            return None;
        }
        if step.abs().max_element() < LAST_STEP {
            let at = at + step;
            let within = at.cmpge(corner - over).all() && at.cmple(corner + size + over).all();
            return within.then(|| at.clamp(DVec2::ZERO, DVec2::ONE));
        }
        // Not far beyond the piece, where it might converge to another part of the patch.
        at = (at + step).clamp(corner - size, corner + 2.0 * size);
    }
    None
}

/// The patch of a net and its derivatives.
fn value(net: &Net, at: DVec2) -> (DVec2, DVec2, DVec2) {
    let rows = net.map(|row| curve(row, at.x));
    let (p, dv) = curve(rows.map(|r| r.0), at.y);
    let (du, _) = curve(rows.map(|r| r.1), at.y);
    (p, du, dv)
}

fn curve([a, b, c, d]: [DVec2; 4], t: f64) -> (DVec2, DVec2) {
    let s = 1.0 - t;
    (
        s * s * s * a + 3.0 * s * s * t * b + 3.0 * s * t * t * c + t * t * t * d,
        3.0 * (s * s * (b - a) + 2.0 * s * t * (c - b) + t * t * (d - c)),
    )
}
