//! Evaluation of free-form surfaces, and how finely they are divided.

use super::basis::{Basis, Weights};
use crate::reading::options::{Budget, Exhausted};
use azulejo_scene::math::Aabb;
use glam::{DVec2, DVec3, DVec4};

/// Distance of a surface from its polygons, relative to its size: the same as for tessellated
/// exact primitives.
const CHORD_ERROR: f64 = 1e-3;

/// Most pieces that one span is divided into.
const MOST_PIECES: f64 = 256.0;

/// Control points, u varying fastest.
#[derive(Debug, Default)]
pub(super) struct Net {
    pub points: Vec<DVec3>,
    /// As many weights, > 0; empty if the surface is not rational.
    pub weights: Vec<f64>,
    /// As many texture coordinates, or empty: then the parameters serve as texture coordinates.
    pub uvs: Vec<DVec2>,
}

/// A surface over the rectangle of its parameters.
#[derive(Debug)]
pub(super) struct FreeFormSurface {
    pub u: Basis,
    pub v: Basis,
    net: Net,
}

/// How finely `stech` requires surfaces to be divided.
#[derive(Clone, Copy, Debug, Default)]
pub(super) enum Technique {
    /// By the default chord error.
    #[default]
    Chord,
    /// Into as many pieces per span as the degree times these.
    Parametric(f64, f64),
    /// Into edges no longer than this.
    Spatial(f64),
    /// By the largest distance from the true surface and the largest angle in radians.
    Curvature(f64, f64),
}

/// A point of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub position: DVec3,
    pub du: DVec3,
    pub dv: DVec3,
    pub uv: DVec2,
}

/// Why there are no polygons.
#[derive(Debug)]
pub(super) enum Refused {
    Budget(Exhausted),
    Reason(String),
}

impl From<Exhausted> for Refused {
    fn from(e: Exhausted) -> Refused {
        Refused::Budget(e)
    }
}

impl From<String> for Refused {
    fn from(reason: String) -> Refused {
        Refused::Reason(reason)
    }
}

impl From<&str> for Refused {
    fn from(reason: &str) -> Refused {
        reason.to_owned().into()
    }
}

impl FreeFormSurface {
    /// A surface, if the number of control points matches its bases.
    pub fn new(u: Basis, v: Basis, net: Net) -> Result<FreeFormSurface, String> {
        let (count, columns, rows) = (net.points.len(), u.count(), v.count());
        if columns.checked_mul(rows) == Some(count) {
            return Ok(FreeFormSurface { u, v, net });
        }
        Err(format!(
            "{count} control points, expected {columns} × {rows}"
        ))
    }

    /// The part of a rectangle `[u0, u1, v0, v1]` within the range of the surface; `None` if
    /// there is none.
    pub fn within(&self, [u0, u1, v0, v1]: [f64; 4]) -> Option<[f64; 4]> {
        let ((a, b), (c, d)) = (self.u.range(), self.v.range());
        let both = [u0.max(a), u1.min(b), v0.max(c), v1.min(d)];
        (both[0] < both[1] && both[2] < both[3]).then_some(both)
    }

    /// The surface at parameters in its range.
    pub fn at(&self, u: f64, v: f64) -> Sample {
        self.sample(&self.u.at(u), &self.v.at(v), DVec2::new(u, v))
    }

    /// The surface where the functions of u are `a` and those of v are `b`.
    pub fn sample(&self, a: &Weights, b: &Weights, parameters: DVec2) -> Sample {
        let width = self.u.count();
        let (mut p, mut pu, mut pv) = (DVec4::ZERO, DVec4::ZERO, DVec4::ZERO);
        let mut uv = DVec2::ZERO;
        for (j, (&nv, &sv)) in b.values.iter().zip(&b.slopes).enumerate() {
            let row = (b.first + j) * width + a.first;
            for (i, (&nu, &su)) in a.values.iter().zip(&a.slopes).enumerate() {
                let weight = self.net.weights.get(row + i).copied().unwrap_or(1.0);
                let point = weight * self.net.points[row + i].extend(1.0);
                p += nu * nv * point;
                pu += su * nv * point;
                pv += nu * sv * point;
                if let Some(&t) = self.net.uvs.get(row + i) {
                    uv += nu * nv * weight * t;
                }
            }
        }
        if self.net.weights.is_empty() {
            // Not all families of functions sum to 1.
            (p.w, pu.w, pv.w) = (1.0, 0.0, 0.0);
        }
        let position = p.truncate() / p.w;
        Sample {
            position,
            du: (pu.truncate() - position * pu.w) / p.w,
            dv: (pv.truncate() - position * pv.w) / p.w,
            uv: if self.net.uvs.is_empty() {
                parameters
            } else {
                uv / p.w
            },
        }
    }

    /// The cost of a sample, in elements of the budget.
    pub fn cost(&self) -> u64 {
        1 + ((self.u.degree() + 1) * (self.v.degree() + 1) / 16) as u64
    }

    /// Parameters of u and of v between which the surface is nearly flat, and the chord error
    /// for which they were chosen.
    pub fn lines(
        &self,
        range: [f64; 4],
        technique: Technique,
        budget: &mut Budget,
    ) -> Result<Lines, Refused> {
        let breaks = [
            self.u.breaks(range[0], range[1]),
            self.v.breaks(range[2], range[3]),
        ];
        let parts = [parts(self.u.degree()), parts(self.v.degree())];
        let coarse = SampleGrid::new(self, &breaks, parts, budget)?;
        let size = Aabb::around(coarse.points.iter().copied()).diagonal();
        if !size.is_finite() {
            return Err("points that are not finite".into());
        }
        let tolerance = CHORD_ERROR * size;
        let along = |axis: usize| -> Vec<f64> {
            let degree = [self.u.degree(), self.v.degree()][axis] as f64;
            let pieces = |span| coarse.pieces(axis, span, degree, technique, tolerance);
            divided(&breaks[axis], pieces)
        };
        Ok(Lines {
            u: along(0),
            v: along(1),
            tolerance,
            speed: coarse.speed(&breaks),
        })
    }
}

/// A grid over a surface.
#[derive(Debug)]
pub(super) struct Lines {
    pub u: Vec<f64>,
    pub v: Vec<f64>,
    /// Accepted distance from the true surface.
    pub tolerance: f64,
    /// Largest distance that the surface covers per unit of u and of v.
    pub speed: DVec2,
}

/// Samples per span from which the curvature is estimated.
fn parts(degree: usize) -> usize {
    (2 * degree).max(4)
}

/// `breaks`, with the spans between them divided evenly.
pub(super) fn divided(breaks: &[f64], pieces: impl Fn(usize) -> usize) -> Vec<f64> {
    let mut lines = Vec::new();
    for (span, ends) in breaks.windows(2).enumerate() {
        let n = pieces(span);
        lines.extend((0..n).map(|k| ends[0] + (ends[1] - ends[0]) * (k as f64 / n as f64)));
    }
    lines.extend(breaks.last());
    // Spans may be as short as the spacing of floating-point numbers.
    lines.dedup();
    lines
}

/// The number of pieces for an estimate, which may be any number.
pub(super) fn whole_pieces(estimate: f64) -> usize {
    // The margin for rounding keeps straight spans in one piece. NaN becomes 0.
    ((estimate - 1e-9).ceil().clamp(1.0, MOST_PIECES) as usize).max(1)
}

/// A regular grid of samples from which the curvature of a surface is estimated.
struct SampleGrid {
    /// Parts of each span of u and of v.
    parts: [usize; 2],
    columns: usize,
    rows: usize,
    points: Vec<DVec3>,
}

impl SampleGrid {
    fn new(
        surface: &FreeFormSurface,
        breaks: &[Vec<f64>; 2],
        parts: [usize; 2],
        budget: &mut Budget,
    ) -> Result<SampleGrid, Exhausted> {
        let [columns, rows] = [0, 1].map(|k| parts[k] * (breaks[k].len() - 1) + 1);
        let count = (columns as u64).saturating_mul(rows as u64);
        budget.spend(count.saturating_mul(surface.cost()))?;
        let ticks = |k: usize| even(&breaks[k], parts[k]);
        let us: Vec<Weights> = ticks(0).iter().map(|&u| surface.u.at(u)).collect();
        let mut points = Vec::with_capacity(columns * rows);
        for v in ticks(1) {
            let b = surface.v.at(v);
            points.extend(
                us.iter()
                    .map(|a| surface.sample(a, &b, DVec2::ZERO).position),
            );
        }
        Ok(SampleGrid {
            parts,
            columns,
            rows,
            points,
        })
    }

    /// The point at `i` along an axis and `j` across it.
    fn at(&self, axis: usize, i: usize, j: usize) -> DVec3 {
        let (column, row) = if axis == 0 { (i, j) } else { (j, i) };
        self.points[row * self.columns + column]
    }

    /// The number of pieces that a span of an axis needs.
    ///
    /// A chord over an n-th of the span is |P″|/8n² away from the curve at most (de Boor, *A
    /// Practical Guide to Splines*, II.9), a bilinear patch up to |P_uv|/4 from its two
    /// triangles; differences of the grid approximate the derivatives.
    fn pieces(
        &self,
        axis: usize,
        span: usize,
        degree: f64,
        technique: Technique,
        tolerance: f64,
    ) -> usize {
        let bends = self.bends(axis, span);
        let by_distance = |tolerance: f64| {
            let chord = self.parts[axis] as f64 * (bends.second / (8.0 * tolerance)).sqrt();
            let cells = (self.parts[0] * self.parts[1]) as f64;
            chord.max((cells * bends.twist / (4.0 * tolerance)).sqrt())
        };
        whole_pieces(match technique {
            Technique::Chord => by_distance(tolerance),
            Technique::Parametric(u, v) => degree * [u, v][axis],
            Technique::Spatial(longest) => bends.length / longest,
            Technique::Curvature(distance, angle) => by_distance(distance).max(bends.angle / angle),
        })
    }

    fn bends(&self, axis: usize, span: usize) -> RowBends {
        let across = if axis == 0 { self.rows } else { self.columns };
        let ends = span * self.parts[axis]..(span + 1) * self.parts[axis];
        let mut most = RowBends::default();
        for j in 0..across {
            let step = |i: usize| self.at(axis, i + 1, j) - self.at(axis, i, j);
            let (mut length, mut angle) = (0.0, 0.0);
            for i in ends.clone() {
                length += step(i).length();
                if i + 1 < ends.end {
                    most.second = most.second.max((step(i + 1) - step(i)).length());
                    angle += step(i).angle_between(step(i + 1));
                }
                if j + 1 < across {
                    let beside = self.at(axis, i + 1, j + 1) - self.at(axis, i, j + 1);
                    most.twist = most.twist.max((beside - step(i)).length());
                }
            }
            most.length = most.length.max(length);
            // n steps have n − 1 angles between them; each end turns as much as half a step.
            let steps = self.parts[axis] as f64;
            most.angle = most.angle.max(angle * steps / (steps - 1.0));
        }
        most
    }

    /// Largest distance between neighbours per unit of each parameter.
    fn speed(&self, breaks: &[Vec<f64>; 2]) -> DVec2 {
        let along = |axis: usize| {
            let span =
                |(span, ends): (usize, &[f64])| self.bends(axis, span).length / (ends[1] - ends[0]);
            let spans = breaks[axis].windows(2).enumerate();
            spans.map(span).fold(0.0, f64::max)
        };
        DVec2::new(along(0), along(1))
    }
}

/// Largest values along the rows of a span.
#[derive(Default)]
struct RowBends {
    /// Second difference along the row.
    second: f64,
    /// Mixed difference with the next row.
    twist: f64,
    length: f64,
    /// Sum of the angles between steps.
    angle: f64,
}

/// Every span divided into the same number of parts; parts are never merged, so that the grid is
/// regular.
fn even(breaks: &[f64], parts: usize) -> Vec<f64> {
    let span = |ends: &[f64]| {
        let (from, to) = (ends[0], ends[1]);
        (0..parts).map(move |k| from + (to - from) * (k as f64 / parts as f64))
    };
    let inner = breaks.windows(2).flat_map(span);
    inner.chain(breaks.last().copied()).collect()
}
