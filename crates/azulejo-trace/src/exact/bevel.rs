//! Bevels of prisms along a line.
//!
//! Inside the prism without its bevel, the bevelled one is where f = s − δ ≥ 0: the distance from the border of
//! the figure is at least the setback of the bevel at this height. Along a line s is semiconcave:
//! s − C t² / 2 is concave, where C is the largest curvature with which parallel curves of the border bulge into the
//! inside ([`Rim`]), and −δ is concave. So the values and slopes of f at two points bound it between them from above
//! and from below, and a stretch is divided until each part has no zero of f, or a single one between
//! different signs, which Newton's method then finds. No polygon stands in for the surface.
//!
//! Cannarsa and Sinestrari, *Semiconcave Functions, Hamilton–Jacobi Equations, and Optimal Control*
//! (2004), proposition 2.2.2.

use super::leaf::LeafHit;
use super::line::Line3;
use super::prism::CURVES;
use azulejo_scene::rim::{Rim, RimPiece, RimPoint};
use azulejo_scene::{Bevel, BevelClimb};
use glam::{DVec2, DVec3};

/// Most evaluations of the distance on one stretch of a line: more than any but lines that lie in the surface need.
const MOST_SAMPLES: u32 = 256;

/// Parts of a stretch shorter than this share of it are not divided.
const THIN: f64 = 1e-9;

/// A Newton step shorter than this share of the bracket is the last: the next would be about its square.
const LAST_STEP: f64 = 1e-8;

/// A bevel about a figure, prepared for rays.
#[derive(Clone, Debug)]
pub(crate) struct ExactBevel {
    rim: Rim,
    bevel: Bevel,
}

/// f at a point of a line.
#[derive(Clone, Copy, Debug)]
struct BevelSample {
    t: f64,
    /// Distance from the border, at most the inset.
    distance: f64,
    setback: f64,
    /// f, and its derivative by t; zero at a root.
    value: f64,
    slope: f64,
    nearest: Option<RimPoint>,
}

impl BevelSample {
    fn is_inside(&self) -> bool {
        self.value >= 0.0
    }
}

/// Where a hit is on a bevel: `t`, the parameter of the curve, and the outward normal, in figure space.
pub(super) struct BevelPoint {
    pub t: f64,
    pub parameter: f64,
    pub normal: DVec3,
}

impl ExactBevel {
    pub fn new(rim: Rim, bevel: Bevel) -> ExactBevel {
        ExactBevel { rim, bevel }
    }

    /// Whether a point over the figure is part of the bevelled prism.
    pub fn keeps(&self, p: DVec3) -> bool {
        let setback = self.bevel.setback(p.z);
        let nearest = |reach| self.rim.nearest(p.truncate(), reach);
        setback == 0.0 || nearest(setback).is_none_or(|at| at.distance >= setback)
    }

    /// Visits the boundaries between two hits of a line with the prism without bevel, in order and in pairs: nothing
    /// at all, those hits themselves, or others between them.
    pub fn carve(&self, line: &Line3, [enter, leave]: [LeafHit; 2], out: &mut Vec<LeafHit>) {
        let first = out.len();
        let mut is_inside = false;
        let [low, high] = self
            .bevel
            .sides()
            .map(|z| (z - line.origin.z) / line.direction.z);
        let within = |t: f64| if t > enter.t { t.min(leave.t) } else { enter.t };
        let (near, far) = (within(low.min(high)), within(low.max(high)));
        let times = [enter.t, near, far, leave.t];
        for ends in times.windows(2).filter(|w| w[0] < w[1]) {
            let middle = line.origin.z + 0.5 * (ends[0] + ends[1]) * line.direction.z;
            let climb = self.bevel.climb(middle);
            let (starts_inside, roots) = match climb {
                Some(climb) => self.zeros(line, [ends[0], ends[1]], climb),
                None => (true, Vec::new()),
            };
            if starts_inside != is_inside {
                let seam = || self.hit_near(line, ends[0], starts_inside);
                out.push(if ends[0] == enter.t { enter } else { seam() });
            }
            is_inside = starts_inside;
            for root in &roots {
                is_inside = !is_inside;
                out.push(self.hit(root.t, root.nearest, is_inside, line));
            }
        }
        if is_inside {
            out.push(leave);
        }
        remove_slivers(out, first, THIN * (leave.t - enter.t));
    }

    /// Whether f is above 0 where a stretch of a line through one bevel starts, and the zeros of f on it.
    fn zeros(&self, line: &Line3, ends: [f64; 2], climb: BevelClimb) -> (bool, Vec<BevelSample>) {
        let mut search = BevelSearch::new(self, line, ends, climb);
        let [a, b] = ends.map(|t| search.sample(t));
        search.divide([a, b], [a.is_inside(), b.is_inside()]);
        (a.is_inside(), search.roots)
    }

    fn hit(&self, t: f64, at: Option<RimPoint>, enters: bool, line: &Line3) -> LeafHit {
        let Some(at) = at else {
            return self.hit_near(line, t, enters);
        };
        let piece = &self.rim.pieces[at.piece as usize];
        LeafHit {
            t,
            part: CURVES + piece.curve,
            parameter: piece.on_curve(at.parameter) as f32,
            enters,
        }
    }

    /// A hit on the curve that is nearest to a point of the line.
    #[cold]
    fn hit_near(&self, line: &Line3, t: f64, enters: bool) -> LeafHit {
        let p = (line.origin + t * line.direction).truncate();
        match self.rim.nearest(p, f64::INFINITY) {
            Some(at) => self.hit(t, Some(at), enters, line),
            None => LeafHit {
                t,
                part: CURVES,
                parameter: 0.0,
                enters,
            },
        }
    }

    /// The surface point near a hit on a curve's bevel, in double precision: Newton's method for both
    /// the parameter of the nearest point of the curve and the position on the line, which may move by `reach`. `None`
    /// for a hit between the bevels.
    pub fn resolve(&self, line: &Line3, hit: &LeafHit, reach: f64) -> Option<BevelPoint> {
        let (o, d) = (line.origin, line.direction);
        let climb = self.bevel.climb(o.z + hit.t * d.z)?;
        let Bevel { profile, inset, .. } = self.bevel;
        let piece = self.piece_at(hit.part - CURVES, f64::from(hit.parameter))?;
        let mut parameter = piece.parameter(f64::from(hit.parameter));
        let mut t = hit.t;
        let mut outward = DVec3::ZERO;
        for _ in 0..8 {
            let p = o + t * d;
            let (nearest, distance, inward) = distance_beside(piece, parameter, p.truncate());
            parameter = nearest;
            let (across, rise) = (distance / inset, climb.at(p.z));
            let [value, by_across, by_rise] = profile.equation(across, rise);
            outward = (-by_across / inset * inward).extend(-by_rise * climb.slope);
            let next = t + value / outward.dot(d);
            // Far from the start it would be another hit, or noise at a tangency.
            if next.is_nan() || (next - hit.t).abs() > reach {
                t = hit.t;
                break;
            }
            let step = (next - t).abs();
            t = next;
            if step <= f64::EPSILON * t.abs() {
                break;
            }
        }
        Some(BevelPoint {
            t,
            parameter: piece.on_curve(parameter),
            normal: outward,
        })
    }

    /// The piece of the border on a curve at a parameter, which rounding may have moved off it.
    fn piece_at(&self, curve: u32, parameter: f64) -> Option<&RimPiece> {
        let pieces = &self.rim.pieces;
        let first = pieces.partition_point(|p| p.curve < curve);
        let own = pieces[first..].iter().take_while(|p| p.curve == curve);
        let miss = |p: &RimPiece| (p.range[0] - parameter).max(parameter - p.range[1]);
        own.min_by(|a, b| miss(a).total_cmp(&miss(b)))
    }
}

/// Removes pairs of boundaries with nothing between them.
fn remove_slivers(out: &mut Vec<LeafHit>, first: usize, thin: f64) {
    let mut kept = first;
    for k in first..out.len() {
        if kept > first && out[k].t - out[kept - 1].t <= thin {
            kept -= 1;
        } else {
            out[kept] = out[k];
            kept += 1;
        }
    }
    out.truncate(kept);
}

/// The point of a piece that is nearest to `p`, by Newton's method from `parameter`: its parameter, and the distance of
/// `p` with the direction in which it grows. On the side of a curve the distance has a sign, so that it stays smooth
/// at 0.
fn distance_beside(piece: &RimPiece, parameter: f64, p: DVec2) -> (f64, f64, DVec2) {
    let (curve, mut t) = (&piece.segment, parameter);
    for _ in 0..2 {
        let (way, along) = (curve.at(t) - p, curve.derivative(t));
        let curved = way.dot(curve.second_derivative(t));
        let steepness = along.length_squared();
        let bend = if steepness + curved > 0.1 * steepness {
            curved
        } else {
            0.0
        };
        let next = t - way.dot(along) / (steepness + bend);
        if next.is_finite() {
            t = next.clamp(0.0, 1.0);
        }
    }
    let way = p - curve.at(t);
    let across = piece.inward(t);
    let beside = way.dot(across);
    let (distance, is_corner) = (way.length(), t == 0.0 || t == 1.0);
    if is_corner && beside < (1.0 - 1e-9) * distance && distance > 0.0 {
        return (t, distance, way / distance);
    }
    (t, beside, across)
}

/// The search for the zeros of f on a stretch of a line that passes through one bevel.
struct BevelSearch<'a> {
    whole: &'a ExactBevel,
    climb: BevelClimb,
    line: Line3,
    /// Length of the projection of one unit of t on the figure's plane.
    speed: f64,
    /// The pieces of the border that are near enough to matter.
    pieces: Vec<u32>,
    /// The largest curvature with which they bulge into the inside; infinite if a reflex corner is near.
    bulge: f64,
    /// Parts shorter than this are not divided.
    thin: f64,
    /// Evaluations that are left.
    left: u32,
    roots: Vec<BevelSample>,
}

impl<'a> BevelSearch<'a> {
    fn new(
        whole: &'a ExactBevel,
        line: &Line3,
        ends: [f64; 2],
        climb: BevelClimb,
    ) -> BevelSearch<'a> {
        let shadow = ends.map(|t| line.at(t).truncate());
        let reach = whole.bevel.inset * (1.0 + 1e-6);
        let (mut pieces, mut bulge) = (Vec::new(), 0.0f64);
        whole.rim.along(shadow, reach, |k| {
            let piece = &whole.rim.pieces[k as usize];
            pieces.push(k);
            bulge = bulge.max(piece.bulge);
            let corners = [piece.segment.start(), piece.segment.end()].into_iter();
            let near = corners
                .zip(piece.is_reflex)
                .filter(|(_, is_reflex)| *is_reflex);
            for (corner, _) in near {
                if is_within(shadow, corner, reach) {
                    bulge = f64::INFINITY;
                }
            }
        });
        BevelSearch {
            whole,
            climb,
            line: *line,
            speed: line.direction.truncate().length(),
            pieces,
            bulge,
            thin: THIN * (ends[1] - ends[0]),
            left: MOST_SAMPLES,
            roots: Vec::new(),
        }
    }

    fn sample(&mut self, t: f64) -> BevelSample {
        self.left = self.left.saturating_sub(1);
        let Bevel { profile, inset, .. } = self.whole.bevel;
        let (p, d) = (self.line.at(t), self.line.direction);
        let reach = inset * (1.0 + 1e-9);
        let nearest = self.whole.rim.nearest_of(&self.pieces, p.truncate(), reach);
        let distance = nearest.map_or(inset, |at| at.distance.min(inset));
        let growth = nearest.map_or(0.0, |at| at.inward.dot(d.truncate()));
        let rise = self.climb.at(p.z).clamp(0.0, 1.0);
        let setback = inset * profile.across(rise);
        // The slope of a round profile ends at infinity.
        let slope = profile.slope(rise.min(1.0 - 1e-12)) * self.climb.slope * d.z;
        BevelSample {
            t,
            distance,
            setback,
            value: distance - setback,
            slope: growth - inset * slope,
            nearest,
        }
    }

    /// Finds all roots between two samples on whose far and near side the line is inside or not.
    fn divide(&mut self, [a, b]: [BevelSample; 2], inside: [bool; 2]) {
        if inside[0] != inside[1] {
            let root = self.root([a, b], inside[1]);
            self.divide([a, root], [inside[0]; 2]);
            self.roots.push(root);
            self.divide([root, b], [inside[1]; 2]);
            return;
        }
        let is_small = b.t - a.t <= self.thin || self.left == 0;
        let stays = |search: &Self| {
            if inside[0] {
                search.stays_inside(&a, &b)
            } else {
                search.stays_outside(&a, &b)
            }
        };
        if is_small || stays(self) {
            return;
        }
        let middle = self.sample(0.5 * (a.t + b.t));
        self.divide([a, middle], [inside[0], middle.is_inside()]);
        self.divide([middle, b], [middle.is_inside(), inside[1]]);
    }

    /// Whether f < 0 between two points where it is not above 0.
    fn stays_outside(&self, a: &BevelSample, b: &BevelSample) -> bool {
        let length = b.t - a.t;
        let farthest = 0.5 * (a.distance + b.distance + self.speed * length);
        if farthest < a.setback.min(b.setback) {
            return true;
        }
        // f is below a parabola through each end, of positive curvature: below 0 up to the middle if it is so there.
        let half = 0.5 * length;
        let bend = 0.5 * self.curvature(a, b) * half * half;
        a.value + a.slope * half + bend < 0.0 && b.value - b.slope * half + bend < 0.0
    }

    /// Whether f ≥ 0 between two points where it is not below 0: f is above its chord less a parabola.
    fn stays_inside(&self, a: &BevelSample, b: &BevelSample) -> bool {
        let length = b.t - a.t;
        let bend = 0.5 * self.curvature(a, b) * length * length;
        a.value.min(b.value) >= 0.25 * bend || a.value.max(b.value) >= bend
    }

    /// The constant C between two points: parallel curves at a distance bulge less.
    fn curvature(&self, a: &BevelSample, b: &BevelSample) -> f64 {
        let nearest = 0.5 * (a.distance + b.distance - self.speed * (b.t - a.t));
        let radius = self.bulge.recip() + nearest.max(0.0);
        self.speed * self.speed / radius
    }

    /// The root between two samples: Newton's method within a shrinking bracket, where its steps shrink too.
    fn root(&mut self, [a, b]: [BevelSample; 2], rises: bool) -> BevelSample {
        let (mut low, mut high) = (a.t, b.t);
        let last_step = LAST_STEP * (high - low);
        let mut step = high - low;
        let share = a.value / (a.value - b.value);
        let share = if share > 0.0 && share < 1.0 {
            share
        } else {
            0.5
        };
        let mut at = self.sample(low + share * step);
        for _ in 0..64 {
            if at.is_inside() == rises {
                high = at.t;
            } else {
                low = at.t;
            }
            let newton = at.t - at.value / at.slope;
            let is_newton = newton > low && newton < high && 2.0 * (newton - at.t).abs() < step;
            let next = if is_newton {
                newton
            } else {
                0.5 * (low + high)
            };
            step = (next - at.t).abs();
            if step <= f64::EPSILON * next.abs() || is_newton && step <= last_step {
                return BevelSample {
                    t: next,
                    value: 0.0,
                    ..at
                };
            }
            at = self.sample(next);
        }
        BevelSample { value: 0.0, ..at }
    }
}

/// Whether a point is as near as `reach` to a straight line between two others.
fn is_within([a, b]: [DVec2; 2], point: DVec2, reach: f64) -> bool {
    let way = b - a;
    let share = way.dot(point - a) / way.length_squared();
    let share = if share > 0.0 { share.min(1.0) } else { 0.0 };
    (a + share * way).distance_squared(point) <= reach * reach
}
