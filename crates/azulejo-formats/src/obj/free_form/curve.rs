//! Trimming curves in the parameter plane of a surface.

use super::basis::Basis;
use super::surface::{Lines, Refused, divided, whole_pieces};
use crate::reading::options::Budget;
use glam::{DVec2, DVec3};

/// Samples per span and degree from which the curvature is estimated.
const PARTS_PER_DEGREE: usize = 4;

/// A curve in two dimensions.
#[derive(Debug)]
pub(super) struct Curve {
    basis: Basis,
    /// Each with its weight, > 0.
    points: Vec<DVec3>,
}

impl Curve {
    /// A curve, if the number of control points matches its basis.
    pub fn new(basis: Basis, points: Vec<DVec3>) -> Result<Curve, String> {
        let (count, expected) = (points.len(), basis.count());
        if count != expected {
            return Err(format!("{count} control points, expected {expected}"));
        }
        Ok(Curve { basis, points })
    }

    fn at(&self, t: f64, rational: bool) -> DVec2 {
        let weights = self.basis.at(t);
        let mut sum = DVec3::ZERO;
        for (value, p) in weights.values.iter().zip(&self.points[weights.first..]) {
            sum += *value * p.z * DVec3::new(p.x, p.y, 1.0);
        }
        if rational {
            sum.truncate() / sum.z
        } else {
            // Not all families of functions sum to 1.
            sum.truncate()
        }
    }

    /// Points from parameter `from` to `to`, as far apart as the surface's tolerance allows.
    pub fn flatten(
        &self,
        from: f64,
        to: f64,
        lines: &Lines,
        budget: &mut Budget,
    ) -> Result<Vec<DVec2>, Refused> {
        let (first, last) = self.basis.range();
        let (low, high) = (from.min(to).max(first), from.max(to).min(last));
        if low >= high {
            return Ok(Vec::new());
        }
        let breaks = self.basis.breaks(low, high);
        let parts = PARTS_PER_DEGREE * self.basis.degree();
        let cost = 1 + self.basis.degree() as u64 / 4;
        budget.spend(parts as u64 * breaks.len() as u64 * cost)?;
        let rational = self.points.iter().any(|p| p.z != 1.0);
        let pieces = |span: usize| {
            let (a, b) = (breaks[span], breaks[span + 1]);
            let tick = |k: usize| self.at(a + (b - a) * (k as f64 / parts as f64), rational);
            // A line of degree 1 is straight, whatever rounding suggests.
            let seen = if self.basis.degree() == 1 {
                0
            } else {
                parts - 1
            };
            let second = (0..seen).map(|k| {
                let bend = tick(k) - 2.0 * tick(k + 1) + tick(k + 2);
                (bend * lines.speed).length()
            });
            let second = second.fold(0.0, f64::max);
            whole_pieces(parts as f64 * (second / (8.0 * lines.tolerance)).sqrt())
        };
        let ticks = divided(&breaks, pieces);
        budget.spend(ticks.len() as u64 * cost)?;
        let mut points: Vec<DVec2> = ticks.iter().map(|&t| self.at(t, rational)).collect();
        if from > to {
            points.reverse();
        }
        Ok(points)
    }
}
