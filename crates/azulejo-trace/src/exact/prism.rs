//! Rays against extruded figures.
//!
//! Kajiya, *New Techniques for Ray Tracing Procedurally Defined Objects*, ACM TOG 2(3), 1983,
//! section 3. In figure space the prism is upright between z = 0 and z = 1 for any extrusion: a ray
//! lies between the two planes for one interval, over which its projection onto the figure's plane
//! crosses the contours.

use super::bevel::ExactBevel;
use super::leaf::{Boundary, LeafHit, LeafPoint, Span, outward};
use super::line::Line3;
use super::outline::{Crossing, Line2, Outline};
use azulejo_scene::Prism;
use azulejo_scene::figure::{Segment, bernstein, bernstein_slope};
use azulejo_scene::rim::Rim;
use glam::{DAffine3, DVec2, DVec3};
use std::sync::Arc;

/// A prism prepared for rays.
#[derive(Clone, Debug)]
pub(crate) struct ExactPrism {
    section: Arc<PrismSection>,
    figure_from_local: DAffine3,
    local_from_figure: DAffine3,
}

/// What prisms of one figure and one bevel share.
#[derive(Debug)]
pub(crate) struct PrismSection {
    outline: Outline,
    bevel: Option<ExactBevel>,
}

impl PrismSection {
    pub(crate) fn new(prism: &Prism) -> PrismSection {
        let bevel = prism.bevel.as_deref();
        PrismSection {
            outline: Outline::new(&prism.figure),
            bevel: bevel.map(|b| ExactBevel::new(Rim::new(&prism.figure), *b)),
        }
    }
}

/// Part numbers: the figure's plane, the parallel one, then the curves.
const FRONT: u32 = 0;
const BACK: u32 = 1;
pub(super) const CURVES: u32 = 2;

/// How far a hit moves at most when it is computed again, in the tracer's coordinates: many roundings of
/// rays to `f32`.
const REACH: f64 = 1e-5;

/// A line in figure space.
struct Passage {
    /// Its projection; the direction is arbitrary for a line along the extrusion.
    shadow: Line2,
    /// Length of the projection of one unit of `t`.
    speed: f64,
    /// The interval between the planes.
    between: Span,
    /// The parts where it enters and leaves.
    planes: [u32; 2],
}

/// What is known of the hits of a line within a span, without solving for crossings.
enum Cut {
    /// There are none: it starts outside and stays there.
    Nowhere,
    /// There are none: it starts inside and stays there.
    Stays,
    /// It enters, and is inside at this `t`.
    Inside(f64),
    /// It starts inside and leaves.
    Leaves,
    /// Crossings may be in one place.
    Unclear,
}

/// The first crossing of a line with the contours.
struct Nearest {
    /// The winding number of the point where the line starts.
    winding: i32,
    crossing: Option<Crossing>,
    /// Distance of the second crossing, if it is about as near as the first; else more.
    second: f64,
}

impl Passage {
    /// `None` for a line that is never between the planes.
    #[inline(always)]
    fn new(line: &Line3) -> Option<Passage> {
        let (o, d) = (line.origin, line.direction);
        let between = if d.z == 0.0 {
            (0.0..=1.0).contains(&o.z).then_some(Span::EVERYWHERE)?
        } else {
            let (front, back) = (-o.z / d.z, (1.0 - o.z) / d.z);
            Span {
                first: front.min(back),
                last: front.max(back),
            }
        };
        let across = d.truncate();
        let speed = across.length();
        let is_point = !(speed > 0.0 && speed.is_finite());
        let direction = if is_point { DVec2::X } else { across / speed };
        Some(Passage {
            shadow: Line2::new(o.truncate(), direction),
            speed: if is_point { 0.0 } else { speed },
            between,
            planes: if d.z > 0.0 {
                [FRONT, BACK]
            } else {
                [BACK, FRONT]
            },
        })
    }

    /// The range of distances along the projection. A projection that is a point has only one, 0.
    #[inline(always)]
    fn shadow_span(&self, span: Span) -> [f64; 2] {
        if self.speed == 0.0 {
            return [0.0; 2];
        }
        [span.first * self.speed, span.last * self.speed]
    }

    /// The parameter of a crossing on the line, clamped to `span`.
    #[inline(always)]
    fn t(&self, crossing: &Crossing, span: Span) -> f64 {
        if self.speed == 0.0 {
            return span.first;
        }
        (crossing.s / self.speed).max(span.first).min(span.last)
    }
}

fn at_curve(t: f64, crossing: &Crossing, enters: bool) -> LeafHit {
    LeafHit {
        t,
        part: CURVES + crossing.curve,
        parameter: crossing.parameter as f32,
        enters,
    }
}

fn at_plane(t: f64, part: u32, enters: bool) -> LeafHit {
    LeafHit {
        t,
        part,
        parameter: 0.0,
        enters,
    }
}

impl ExactPrism {
    /// `None` for a map that cannot be inverted in double precision.
    pub(crate) fn new(
        section: Arc<PrismSection>,
        local_from_figure: DAffine3,
    ) -> Option<ExactPrism> {
        let figure_from_local = local_from_figure.inverse();
        let usable = local_from_figure.is_finite() && figure_from_local.is_finite();
        usable.then_some(ExactPrism {
            section,
            figure_from_local,
            local_from_figure,
        })
    }

    /// The first hit within `span`.
    pub(crate) fn first(&self, line: &Line3, span: Span) -> Option<LeafHit> {
        let own = line.mapped(&self.figure_from_local);
        let passage = Passage::new(&own)?;
        let within = passage.between.and(span)?;
        let nearest = self.nearest(&passage, within);
        let starts_inside = self.section.outline.rule.is_inside(nearest.winding);
        let comes_in = starts_inside && span.first <= passage.between.first;
        if let Some(bevel) = &self.section.bevel {
            let entry = match &nearest.crossing {
                _ if comes_in => Some(within.first),
                Some(crossing) if !starts_inside => Some(passage.t(crossing, within)),
                // Nothing of the prism without its bevel.
                None if !starts_inside => return None,
                _ => None,
            };
            if !entry.is_some_and(|t| bevel.keeps(own.at(t))) {
                return self.first_of_all(&own, &passage, within, span);
            }
        }
        if comes_in {
            return Some(at_plane(within.first, passage.planes[0], true));
        }
        if let Some(crossing) = &nearest.crossing {
            let is_inside = |winding| self.section.outline.rule.is_inside(winding);
            let is_boundary = is_inside(nearest.winding - crossing.sense) != starts_inside;
            if !is_boundary || nearest.second - crossing.s <= self.section.outline.sliver {
                return self.first_of_all(&own, &passage, within, span);
            }
            let t = passage.t(crossing, within);
            return Some(at_curve(t, crossing, !starts_inside));
        }
        let leaves = starts_inside && passage.between.last <= span.last;
        leaves.then(|| at_plane(within.last, passage.planes[1], false))
    }

    /// Whether there is a hit within `span`, as [`first`](ExactPrism::first).
    pub(crate) fn any(&self, line: &Line3, span: Span) -> bool {
        let own = line.mapped(&self.figure_from_local);
        let Some(passage) = Passage::new(&own) else {
            return false;
        };
        let Some(within) = passage.between.and(span) else {
            return false;
        };
        let cut = self.cut(&passage, within, span);
        let Some(bevel) = &self.section.bevel else {
            return match cut {
                Cut::Nowhere | Cut::Stays => false,
                Cut::Inside(_) | Cut::Leaves => true,
                Cut::Unclear => self.first(line, span).is_some(),
            };
        };
        match cut {
            Cut::Nowhere => false,
            Cut::Inside(t) if bevel.keeps(own.at(t)) => true,
            _ => self.any_bevelled(bevel, &own, &passage, within, span),
        }
    }

    /// Whether there is a hit within `span` with the prism without its bevel, as far as that can be told without solving
    /// for where the line crosses curves: if where it may cross the nearest one is before all others.
    fn cut(&self, passage: &Passage, within: Span, span: Span) -> Cut {
        let outline = &self.section.outline;
        let [s0, s1] = passage.shadow_span(within);
        let mut nearest: Option<Crossing> = None;
        let (mut second, mut last) = (f64::INFINITY, s1);
        let winding = outline.cross_roughly(&passage.shadow, [s0, s1], |crossing| {
            last = last.min(crossing.s + crossing.spread + outline.sliver);
            match &mut nearest {
                Some(known) if known.s <= crossing.s => second = second.min(crossing.s),
                _ => second = nearest.replace(crossing).map_or(second, |known| known.s),
            }
            Some(last)
        });
        let starts_inside = outline.rule.is_inside(winding);
        if starts_inside && span.first <= passage.between.first {
            return Cut::Inside(within.first);
        }
        let Some(crossing) = nearest.filter(|_| passage.speed > 0.0) else {
            return if !starts_inside {
                Cut::Nowhere
            } else if passage.between.last <= span.last {
                Cut::Leaves
            } else {
                Cut::Stays
            };
        };
        let behind = crossing.s + crossing.spread;
        let is_apart = second - behind > outline.sliver;
        let changes = outline.rule.is_inside(winding - crossing.sense) != starts_inside;
        if !(is_apart && changes) {
            Cut::Unclear
        } else if starts_inside {
            Cut::Leaves
        } else {
            Cut::Inside((behind / passage.speed).min(within.last))
        }
    }

    /// Whether there is a hit within `span` of a prism with a bevel, of which there is one without it.
    #[inline(never)]
    fn any_bevelled(
        &self,
        bevel: &ExactBevel,
        own: &Line3,
        passage: &Passage,
        within: Span,
        span: Span,
    ) -> bool {
        // Most lines pass through what no bevel takes away: halfway between where they enter and leave.
        let comes_in = span.first <= passage.between.first;
        let (mut entry, mut is_hit) = (None, false);
        self.unbevelled(passage, within, |hit: LeafHit| match entry.take() {
            None => entry = Some(hit),
            Some(enter) => {
                let starts_outside = enter.part >= CURVES || comes_in;
                let middle = own.at(0.5 * (enter.t + hit.t));
                is_hit |= starts_outside && bevel.keeps(middle);
            }
        });
        is_hit || self.first_of_all(own, passage, within, span).is_some()
    }

    /// The first crossing, and the distance of the second one.
    #[inline(always)]
    fn nearest(&self, passage: &Passage, within: Span) -> Nearest {
        let [s0, s1] = passage.shadow_span(within);
        let mut nearest = Nearest {
            winding: 0,
            crossing: None,
            second: f64::INFINITY,
        };
        let mut first = f64::INFINITY;
        nearest.winding = self
            .section
            .outline
            .cross(&passage.shadow, [s0, s1], |crossing| {
                if crossing.s < first {
                    (nearest.second, first) = (first, crossing.s);
                    nearest.crossing = Some(crossing);
                } else {
                    nearest.second = nearest.second.min(crossing.s);
                }
                Some(s1.min(first + self.section.outline.sliver))
            });
        if passage.speed == 0.0 {
            nearest.crossing = None;
        }
        nearest
    }

    /// [`first`](ExactPrism::first) where not every crossing is a boundary because contours overlap
    /// or coincide, or because of the bevel.
    #[cold]
    fn first_of_all(
        &self,
        own: &Line3,
        passage: &Passage,
        within: Span,
        span: Span,
    ) -> Option<LeafHit> {
        let mut first = None;
        self.boundaries(own, passage, within, |hit| {
            // The ends of the range are hits only if they are on the planes.
            let is_plane = hit.part < CURVES;
            let comes_in = is_plane && hit.enters && span.first <= passage.between.first;
            let goes_out = is_plane && !hit.enters && passage.between.last <= span.last;
            if first.is_none() && (!is_plane || comes_in || goes_out) {
                first = Some(hit);
            }
        });
        first
    }

    /// All boundaries on the line, in order; an even number.
    pub(crate) fn all(&self, line: &Line3, leaf: u32, out: &mut Vec<Boundary>) {
        let own = line.mapped(&self.figure_from_local);
        if let Some(passage) = Passage::new(&own) {
            self.boundaries(&own, &passage, passage.between, |hit| {
                out.push(Boundary { hit, leaf });
            });
        }
    }

    /// The boundaries on the line within `within`, whose ends are boundaries if they are inside.
    fn boundaries(
        &self,
        own: &Line3,
        passage: &Passage,
        within: Span,
        mut visit: impl FnMut(LeafHit),
    ) {
        let Some(bevel) = &self.section.bevel else {
            return self.unbevelled(passage, within, visit);
        };
        let (mut entry, mut carved) = (None, Vec::new());
        self.unbevelled(passage, within, |hit| match entry.take() {
            None => entry = Some(hit),
            Some(enter) => bevel.carve(own, [enter, hit], &mut carved),
        });
        carved.into_iter().for_each(&mut visit);
    }

    /// [`boundaries`](ExactPrism::boundaries) of the prism without its bevel.
    fn unbevelled(&self, passage: &Passage, within: Span, mut visit: impl FnMut(LeafHit)) {
        let range = passage.shadow_span(within);
        let mut crossings = Vec::new();
        let winding = self
            .section
            .outline
            .cross(&passage.shadow, range, |crossing| {
                crossings.push(crossing);
                Some(range[1])
            });
        if passage.speed == 0.0 {
            crossings.clear();
        }
        crossings.sort_by(|a, b| a.s.total_cmp(&b.s));
        let mut inside = self.section.outline.rule.is_inside(winding);
        if inside {
            visit(at_plane(within.first, passage.planes[0], true));
        }
        for crossing in self.changes(winding, &crossings) {
            inside = !inside;
            visit(at_curve(passage.t(crossing, within), crossing, inside));
        }
        if inside {
            visit(at_plane(within.last, passage.planes[1], false));
        }
    }

    /// The crossings that enter or leave, except for pairs with nothing between them.
    fn changes<'a>(&self, mut winding: i32, crossings: &'a [Crossing]) -> Vec<&'a Crossing> {
        let rule = self.section.outline.rule;
        let mut changes: Vec<&Crossing> = Vec::with_capacity(crossings.len());
        for crossing in crossings {
            let was_inside = rule.is_inside(winding);
            winding -= crossing.sense;
            if rule.is_inside(winding) == was_inside {
                continue;
            }
            let last = changes.last();
            if last.is_some_and(|l| crossing.s - l.s <= self.section.outline.sliver) {
                changes.pop();
            } else {
                changes.push(crossing);
            }
        }
        changes
    }

    /// The surface point near a hit, in double precision, with the parameter on its curve and the
    /// height above the figure's plane.
    pub(crate) fn resolve(&self, line: &Line3, hit: &LeafHit) -> LeafPoint {
        let own = line.mapped(&self.figure_from_local);
        let (o, d) = (own.origin, own.direction);
        if hit.part < CURVES {
            let z = f64::from(hit.part);
            let t = (z - o.z) / d.z;
            let t = if t.is_finite() { t } else { hit.t };
            let p = o + t * d;
            let normal = DVec3::new(0.0, 0.0, 2.0 * z - 1.0);
            return self.resolved(t, p.with_z(z), normal, [p.x, p.y]);
        }
        if let Some(bevel) = &self.section.bevel {
            let reach = REACH / line.direction.length();
            if let Some(at) = bevel.resolve(&own, hit, reach) {
                let p = own.at(at.t);
                return self.resolved(at.t, p, at.normal, [at.parameter, p.z]);
            }
        }
        let points = *self.section.outline.curve(hit.part - CURVES);
        let across = d.truncate();
        let (t, parameter) = nearest_crossing(points, &own, hit);
        let curve = Segment::Cubic(points);
        let z = (o.z + t * d.z).clamp(0.0, 1.0);
        let tangent = curve.tangent(parameter);
        let normal = DVec2::new(tangent.y, -tangent.x);
        let outward = if (normal.dot(across) < 0.0) == hit.enters {
            normal
        } else {
            -normal
        };
        let p = curve.at(parameter).extend(z);
        self.resolved(t, p, outward.extend(0.0), [parameter, z])
    }

    fn resolved(&self, t: f64, p: DVec3, normal: DVec3, [u, v]: [f64; 2]) -> LeafPoint {
        LeafPoint {
            t,
            u,
            v,
            position: self.local_from_figure.transform_point3(p),
            normal: outward(self.local_from_figure.matrix3, normal),
        }
    }
}

/// Newton's method from the hit's own parameter for the crossing of line and curve, or the point of
/// the curve at which it ends; returns `t` and the parameter.
fn nearest_crossing(points: [DVec2; 4], line: &Line3, hit: &LeafHit) -> (f64, f64) {
    let (origin, across) = (line.origin.truncate(), line.direction.truncate());
    let normal = across.perp();
    let height = points.map(|p| normal.dot(p - origin));
    let start = f64::from(hit.parameter).clamp(0.0, 1.0);
    let mut t = start;
    for _ in 0..8 {
        let next = (t - bernstein(height, t) / bernstein_slope(height, t)).clamp(0.0, 1.0);
        // Far from the start it would be another crossing, or noise at a tangency.
        if !next.is_finite() || (next - start).abs() > 1e-2 {
            t = start;
            break;
        }
        let step = (next - t).abs();
        t = next;
        if step <= f64::EPSILON {
            break;
        }
    }
    let p = Segment::Cubic(points).at(t) - origin;
    let along = p.dot(across) / across.length_squared();
    (if along.is_finite() { along } else { hit.t }, t)
}
