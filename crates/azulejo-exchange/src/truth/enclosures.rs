//! Enclosures that the solver is asked about, with factors from each row to those from it on.

use super::GreyPaint;
use crate::enclosure::{Enclosure, Groups, RowTable};
use crate::thermal::bands::SpectralRange;
use crate::thermal::network::{
    ExchangeError, ExchangeFactors, HeatBalance, HeatProblem, RowCondition, SurfaceBand,
    exchange_factors, heat_balance,
};
use azulejo_factors::FormFactors;
use azulejo_factors::analytic::form_factor;
use azulejo_factors::form_factors::{Exchange, RowRemainder};
use azulejo_factors::truth::formulas::coaxial_disks;
use azulejo_trace::Progress;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Shares below which a row counts as closed.
const CLOSED: f64 = 1e-12;

/// Surfaces in one grey band.
#[derive(Clone, Debug)]
pub struct GreyEnclosure {
    pub enclosure: Enclosure,
    pub emissivity: Vec<f64>,
}

/// Each row a node.
pub fn nodes(count: usize) -> Groups {
    Groups {
        of_rows: (0..count as u32).map(Some).collect(),
        names: (0..count).map(|i| i.to_string()).collect(),
    }
}

impl GreyEnclosure {
    /// Areas in square metres, and `upper(i, j)`, F^s for i ≤ j. What rows lack goes to the sky.
    pub fn new(
        areas: &[f64],
        paint: &GreyPaint,
        upper: impl Fn(usize, usize) -> f64,
    ) -> GreyEnclosure {
        let n = areas.len();
        let row = |i: usize| (i..n).map(|j| upper(i, j)).collect();
        let upper: Vec<Vec<f64>> = (0..n).map(row).collect();
        let row = |i: usize| {
            let entry = |j: usize| Exchange {
                column: j as u32,
                value: areas[i] * upper[i][j - i],
                error: 0.0,
            };
            (i..n).map(entry).collect::<Vec<Exchange>>()
        };
        let factors = FormFactors {
            exchange: (0..n).map(row).collect(),
            areas: areas.to_vec(),
            rest: remainders(areas, &upper, &paint.mirror),
            ends: paint.mirror.iter().map(|m| 1.0 - m).collect(),
            ..FormFactors::default()
        };
        GreyEnclosure {
            enclosure: Enclosure {
                factors,
                rows: RowTable {
                    names: (0..n).map(|i| i.to_string()).collect(),
                    ..RowTable::default()
                },
                outside: None,
                elsewhere: None,
            },
            emissivity: paint.emissivity.clone(),
        }
    }

    /// All of it in a band, with other emissivities if any are given.
    pub fn band(&self, range: SpectralRange, emissivity: Option<&[f64]>) -> SurfaceBand<'_> {
        SurfaceBand {
            enclosure: &self.enclosure,
            range,
            emissivity: emissivity.unwrap_or(&self.emissivity).to_vec(),
        }
    }

    /// All of it as a grey band.
    pub fn grey(&self) -> SurfaceBand<'_> {
        self.band(SpectralRange::Thermal, None)
    }

    /// The solver's exchange factors, the rows' and the sky's after them.
    pub fn exchange(&self) -> Result<ExchangeFactors, ExchangeError> {
        let count = self.emissivity.len();
        exchange_factors(&self.grey(), &nodes(count), &Progress::new())
    }

    /// GR between rows, m².
    pub fn conductance(&self, a: usize, b: usize) -> Result<f64, ExchangeError> {
        Ok(self.exchange()?.conductance(a, b).0)
    }

    /// F^s from a row to another.
    pub fn factor(&self, i: usize, j: usize) -> f64 {
        self.enclosure.factors.get(i, j as u32).0
    }

    /// The solver's temperatures and fluxes.
    pub fn heat(&self, conditions: &[RowCondition]) -> Result<HeatBalance, ExchangeError> {
        heat(&[self.grey()], conditions, &[])
    }
}

/// Temperatures and fluxes under a black sky of 0 K; `solar` is the sun's irradiation in W/m².
pub fn heat(
    bands: &[SurfaceBand],
    conditions: &[RowCondition],
    solar: &[f64],
) -> Result<HeatBalance, ExchangeError> {
    let problem = HeatProblem {
        bands,
        conditions,
        surroundings: [0.0, 0.0],
        solar,
    };
    heat_balance(&problem, &nodes(conditions.len()), &Progress::new())
}

/// What leaves the scene from each row.
fn remainders(areas: &[f64], upper: &[Vec<f64>], mirrors: &[f64]) -> Vec<RowRemainder> {
    let n = areas.len();
    let factor = |i: usize, j: usize| {
        let (low, high) = (i.min(j), i.max(j));
        upper[low][high - low] * areas[low] / areas[i]
    };
    let rest = |i: usize| {
        let ended: f64 = (0..n).map(|j| factor(i, j) * (1.0 - mirrors[j])).sum();
        let is_open = 1.0 - ended > CLOSED;
        RowRemainder {
            sky: if is_open { 1.0 - ended } else { 0.0 },
            ..RowRemainder::default()
        }
    };
    (0..n).map(rest).collect()
}

/// A convex body in another that it is seen from alike all over; areas alike for plates. Reflection by
/// reflection.
pub fn nested(areas: [f64; 2], paint: &GreyPaint) -> GreyEnclosure {
    let ratio = areas[0] / areas[1];
    let series = |first: f64, factor: f64| {
        let terms = std::iter::successors(Some(first), |term| Some(term * factor));
        terms.take_while(|term| *term > 1e-18).sum::<f64>()
    };
    let [m1, m2] = [paint.mirror[0], paint.mirror[1]];
    let (between, missing) = (m1 * m2, 1.0 - ratio);
    GreyEnclosure::new(&areas, paint, |i, j| match (i, j) {
        (0, 0) => series(m2, between),
        (0, _) => series(1.0, between),
        _ => series(missing, m2) + series(ratio * m1, between),
    })
}

/// The inside of a sphere of area 1 in parts; what is left of it is open.
pub fn parts_of_sphere(areas: &[f64], paint: &GreyPaint) -> GreyEnclosure {
    GreyEnclosure::new(areas, paint, |_, j| areas[j])
}

/// Crossed strings between two segments of the border of a convex cross section, each with its points in
/// the same sense of turning.
pub fn crossed_strings(from: [DVec2; 2], to: [DVec2; 2]) -> f64 {
    let crossed = from[0].distance(to[0]) + from[1].distance(to[1]);
    let uncrossed = from[0].distance(to[1]) + from[1].distance(to[0]);
    0.5 * (crossed - uncrossed) / from[0].distance(from[1])
}

/// An infinitely long duct with a convex cross section; of its sides, one for each row are there, from the
/// first point on, and the rest is open.
pub fn duct(points: &[[f64; 2]], paint: &GreyPaint) -> GreyEnclosure {
    let point = |i: usize| DVec2::from_array(points[i % points.len()]);
    let side = |i: usize| [point(i), point(i + 1)];
    let areas: Vec<f64> = (0..paint.rows())
        .map(|i| point(i).distance(point(i + 1)))
        .collect();
    GreyEnclosure::new(&areas, paint, |i, j| {
        if i == j {
            0.0
        } else {
            crossed_strings(side(i), side(j))
        }
    })
}

/// Two infinitely long strips of width 1 that meet at `angle` < 90°; the second may be a mirror.
pub fn strips(angle: f64, paint: &GreyPaint) -> GreyEnclosure {
    let end = DVec2::from_angle;
    let first = [DVec2::X, DVec2::ZERO];
    let (second, image) = ([DVec2::ZERO, end(angle)], [DVec2::ZERO, end(2.0 * angle)]);
    GreyEnclosure::new(&[1.0; 2], paint, |i, j| match (i, j) {
        (0, 0) => paint.mirror[1] * crossed_strings(first, image),
        (0, _) => crossed_strings(first, second),
        _ => 0.0,
    })
}

/// Base, top and wall between coaxial disks; without a third row the top is open, and the second row is
/// the wall.
pub fn frustum(r1: f64, r2: f64, h: f64, paint: &GreyPaint) -> GreyEnclosure {
    let [base, top] = [PI * r1 * r1, PI * r2 * r2];
    let wall = PI * (r1 + r2) * h.hypot(r2 - r1);
    let [f12, f21] = [coaxial_disks(r1, r2, h), coaxial_disks(r2, r1, h)];
    let own = 1.0 - (base * (1.0 - f12) + top * (1.0 - f21)) / wall;
    let factors = [
        [0.0, f12, 1.0 - f12],
        [0.0, 0.0, 1.0 - f21],
        [0.0, 0.0, own],
    ];
    let rows: &[usize] = if paint.rows() == 3 {
        &[0, 1, 2]
    } else {
        &[0, 2]
    };
    let areas: Vec<f64> = rows.iter().map(|&i| [base, top, wall][i]).collect();
    GreyEnclosure::new(&areas, paint, |i, j| factors[rows[i]][rows[j]])
}

/// A closed cylinder whose top may be a mirror, as one of twice the height: base, top, wall.
pub fn mirrored_cylinder(r: f64, h: f64, paint: &GreyPaint) -> GreyEnclosure {
    let m = paint.mirror[1];
    let disk = PI * r * r;
    let (near, far) = (coaxial_disks(r, r, h), coaxial_disks(r, r, 2.0 * h));
    // From a wall to itself; that of the double height has two halves, each of which sees both.
    let own = |h: f64| 1.0 - r * (1.0 - coaxial_disks(r, r, h)) / h;
    let to_image = own(2.0 * h) - own(h);
    let factors = [
        [m * far, near, (1.0 - near) + m * (near - far)],
        [0.0, 0.0, 1.0 - near],
        [0.0, 0.0, own(h) + m * to_image],
    ];
    GreyEnclosure::new(&[disk, disk, 2.0 * PI * r * h], paint, |i, j| factors[i][j])
}

/// A unit cube: floor, ceiling, four walls as one.
pub fn cube_of_three(paint: &GreyPaint) -> GreyEnclosure {
    let cube = super::images::mirrored_box([1.0; 3], &GreyPaint::matt(&[1.0; 6]));
    let (floor, walls) = (4, 0..4);
    let around = |i: usize| walls.clone().map(|j| cube.factor(i, j)).sum::<f64>();
    GreyEnclosure::new(&[1.0, 1.0, 4.0], paint, |i, j| match (i, j) {
        (0, 1) => cube.factor(floor, 5),
        (0 | 1, 2) => around(floor),
        (2, 2) => around(0),
        _ => 0.0,
    })
}

/// Unit squares on a common edge at an angle.
pub fn squares_at(angle: f64, paint: &GreyPaint) -> GreyEnclosure {
    let (sin, cos) = angle.sin_cos();
    let (out, up) = (DVec3::X, DVec3::new(cos, 0.0, sin));
    let first = [DVec3::ZERO, out, out + DVec3::Y, DVec3::Y];
    let second = [DVec3::ZERO, DVec3::Y, up + DVec3::Y, up];
    GreyEnclosure::new(&[1.0; 2], paint, |i, j| {
        if i == j {
            0.0
        } else {
            form_factor(&first, &second)
        }
    })
}
