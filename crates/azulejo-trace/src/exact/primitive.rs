//! Exact primitives: the interval of a line inside them.

use super::leaf::{LeafHit, LeafPoint, facing};
use super::line::Line3;
use azulejo_scene::{Primitive, PrimitiveKind, SurfacePoint};
use glam::DAffine3;

/// A primitive prepared for rays.
#[derive(Clone, Debug)]
pub(crate) struct ExactPrimitive {
    pub shape: Primitive,
    object_from_world: DAffine3,
    object_from_local: DAffine3,
}

/// A hit of a ray on a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PrimitiveHit {
    pub t: f64,
    pub part: usize,
    pub u: f64,
    pub v: f64,
}

impl ExactPrimitive {
    /// `None` for a map that cannot be inverted in double precision.
    pub(crate) fn new(shape: &Primitive, world_from_local: &DAffine3) -> Option<ExactPrimitive> {
        let object_from_world = object_from_world(shape)?;
        Some(ExactPrimitive {
            shape: Primitive {
                light: None,
                ..shape.clone()
            },
            object_from_world,
            object_from_local: object_from_world * *world_from_local,
        })
    }

    /// Transforms a line from kernel coordinates to object space; `t` is unchanged.
    #[inline(always)]
    pub(crate) fn object_line(&self, local: &Line3) -> Line3 {
        local.mapped(&self.object_from_local)
    }

    /// Transforms a line from the world to object space; `t` is unchanged.
    #[inline(always)]
    pub(crate) fn object_line_from_world(&self, world: &Line3) -> Line3 {
        world.mapped(&self.object_from_world)
    }

    /// The first hit with `t_min <= t <= t_max`.
    pub(crate) fn first(&self, line: &Line3, t_min: f64, t_max: f64) -> Option<PrimitiveHit> {
        let (enter, leave) = self.crossings(line)?;
        let within = |t: f64| t_min <= t && t <= t_max;
        let t = [enter, leave].into_iter().find(|&t| within(t))?;
        Some(self.hit_at(line, t))
    }

    /// The hit nearest to `t_guess`, anywhere on the line.
    pub(crate) fn nearest_to(&self, line: &Line3, t_guess: f64) -> Option<PrimitiveHit> {
        let (enter, leave) = self.crossings(line)?;
        let t = if (enter - t_guess).abs() <= (leave - t_guess).abs() {
            enter
        } else {
            leave
        };
        t.is_finite().then(|| self.hit_at(line, t))
    }

    /// All hits on the line, alternately entering and leaving for a closed shape.
    pub(crate) fn hits(&self, line: &Line3) -> [Option<LeafHit>; 2] {
        let own = self.object_line(line);
        let Some((enter, leave)) = self.crossings(&own) else {
            return [None; 2];
        };
        let hit = |t: f64, enters: bool| LeafHit {
            t,
            part: 0,
            parameter: 0.0,
            enters,
        };
        match self.shape.kind {
            PrimitiveKind::Square => {
                let enters = own.direction.z < 0.0;
                [Some(hit(enter, enters)), None]
            }
            // An open side may have a single crossing: then both are the same.
            PrimitiveKind::Tube { .. } if enter == leave => {
                let normal = self.at(&own, enter).normal;
                [Some(hit(enter, normal.dot(line.direction) < 0.0)), None]
            }
            _ => [Some(hit(enter, true)), Some(hit(leave, false))],
        }
    }

    /// The surface point of a hit.
    pub(crate) fn resolve(&self, line: &Line3, hit: &LeafHit) -> LeafPoint {
        let own = self.object_line(line);
        let (enter, leave) = self.crossings(&own).unwrap_or((hit.t, hit.t));
        let is_first = (enter - hit.t).abs() <= (leave - hit.t).abs();
        let nearest = if is_first { enter } else { leave };
        let t = if nearest.is_finite() { nearest } else { hit.t };
        let at = self.hit_at(&own, t);
        let point = self.shape.point(at.part, at.u, at.v);
        LeafPoint {
            t,
            u: at.u,
            v: at.v,
            position: point.position,
            normal: facing(point.normal, line.direction, hit.enters),
        }
    }

    fn at(&self, own: &Line3, t: f64) -> SurfacePoint {
        let hit = self.hit_at(own, t);
        self.shape.point(hit.part, hit.u, hit.v)
    }

    fn hit_at(&self, line: &Line3, t: f64) -> PrimitiveHit {
        let (part, u, v) = self.shape.kind.locate(line.origin + t * line.direction);
        PrimitiveHit { t, part, u, v }
    }

    /// The parameters at which the line enters and leaves.
    ///
    /// All closed primitives are convex, so the part of the line inside is one interval, the
    /// intersection of the intervals of the bounding surfaces: no ray slips through at the edge
    /// between two parts.
    fn crossings(&self, line: &Line3) -> Option<(f64, f64)> {
        let (o, d) = (line.origin, line.direction);
        let (enter, leave) = match self.shape.kind {
            PrimitiveKind::Sphere => quadric(d.dot(d), o.dot(d), sphere_constant(line), None)?,
            PrimitiveKind::Cylinder => tapered(line, 1.0)?,
            PrimitiveKind::Cone { top } => tapered(line, top)?,
            PrimitiveKind::Tube { top } => tube(line, top)?,
            PrimitiveKind::Cuboid => slab(o.x, d.x, slab(o.y, d.y, slab(o.z, d.z, EVERYWHERE)?)?)?,
            PrimitiveKind::Square => sheet(line)?,
        };
        (enter <= leave).then_some((enter, leave))
    }
}

fn object_from_world(shape: &Primitive) -> Option<DAffine3> {
    let mut map = shape.world_from_object;
    if shape.kind == PrimitiveKind::Square {
        // The third axis is not used; any independent direction serves.
        let m = map.matrix3;
        map.matrix3.z_axis = m.x_axis.cross(m.y_axis).normalize_or_zero();
    }
    let inverse = map.inverse();
    (map.is_finite() && inverse.is_finite()).then_some(inverse)
}

type Interval = (f64, f64);
const EVERYWHERE: Interval = (f64::NEG_INFINITY, f64::INFINITY);

/// The part of `inside` where 0 <= o + t d <= 1; `None` if it is empty.
fn slab(o: f64, d: f64, inside: Interval) -> Option<Interval> {
    if d == 0.0 {
        return (0.0..=1.0).contains(&o).then_some(inside);
    }
    let (a, b) = (-o / d, (1.0 - o) / d);
    let (enter, leave) = (a.min(b).max(inside.0), a.max(b).min(inside.1));
    (enter <= leave).then_some((enter, leave))
}

/// The crossing with the unit square in z = 0, as an interval of one point.
fn sheet(line: &Line3) -> Option<Interval> {
    let (o, d) = (line.origin, line.direction);
    let t = -o.z / d.z;
    let p = o + t * d;
    let inside = (0.0..=1.0).contains(&p.x) && (0.0..=1.0).contains(&p.y);
    (t.is_finite() && inside).then_some((t, t))
}

/// The cone with radius 1 at z = 0 and `top` at z = 1, between those two planes.
fn tapered(line: &Line3, top: f64) -> Option<Interval> {
    let (o, d) = (line.origin, line.direction);
    let slope = top - 1.0;
    let (radius, growth) = (1.0 + slope * o.z, slope * d.z);
    let a = d.x * d.x + d.y * d.y - growth * growth;
    let b = o.x * d.x + o.y * d.y - radius * growth;
    let c = o.x * o.x + o.y * o.y - radius * radius;
    quadric(a, b, c, Some(slab(o.z, d.z, EVERYWHERE)?))
}

/// The side of such a cone alone: the interval between the crossings of the line; a single crossing
/// is an interval of one point.
fn tube(line: &Line3, top: f64) -> Option<Interval> {
    let (enter, leave) = tapered(line, top)?;
    // An end that was not clipped by the planes is on the side.
    let planes = slab(line.origin.z, line.direction.z, EVERYWHERE)?;
    match (enter > planes.0, leave < planes.1) {
        (true, true) => Some((enter, leave)),
        (true, false) => Some((enter, enter)),
        (false, true) => Some((leave, leave)),
        (false, false) => None,
    }
}

/// |o|² − 1, from factors that do not cancel when the origin is on the sphere.
fn sphere_constant(line: &Line3) -> f64 {
    let r = line.origin.length();
    (r - 1.0) * (r + 1.0)
}

/// The interval of `bounds` where a t² + 2 b t + c <= 0, which must be connected.
fn quadric(a: f64, b: f64, c: f64, bounds: Option<Interval>) -> Option<Interval> {
    let bounds = bounds.unwrap_or(EVERYWHERE);
    let cut = |piece: Interval| {
        let (enter, leave) = (piece.0.max(bounds.0), piece.1.min(bounds.1));
        (enter <= leave).then_some((enter, leave))
    };
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        // No sign change: inside everywhere (a steep line in a cone) or nowhere.
        return if a < 0.0 { cut(EVERYWHERE) } else { None };
    }
    // Press et al., Numerical Recipes, eq. (5.6.4): the sum that does not cancel.
    let q = -(b + discriminant.sqrt().copysign(b));
    if q == 0.0 {
        // b = 0 and a c = 0: a double root at 0, or no dependence on t at all.
        return if a > 0.0 {
            cut((0.0, 0.0))
        } else if c <= 0.0 {
            cut(EVERYWHERE)
        } else {
            None
        };
    }
    let (r, s) = (c / q, q / a);
    if a == 0.0 {
        return if b > 0.0 {
            cut((f64::NEG_INFINITY, r))
        } else {
            cut((r, f64::INFINITY))
        };
    }
    let (low, high) = (r.min(s), r.max(s));
    if a > 0.0 {
        cut((low, high))
    } else {
        cut((f64::NEG_INFINITY, low)).or_else(|| cut((high, f64::INFINITY)))
    }
}
