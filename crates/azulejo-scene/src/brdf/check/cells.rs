//! Adaptive integrals over parts of the hemisphere.

use crate::Rgb;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// A range of the angle to the normal and of the azimuth, in radians.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    theta: [f64; 2],
    phi: [f64; 2],
}

/// Largest size of a cell, in radians: its ten points across, five to each half, resolve features
/// of a tenth of its width.
const LARGEST: f64 = 0.4;

/// Largest size of cells around the specular direction, where lobes are narrow.
const AT_MIRRORED: f64 = 1e-4;

/// Largest change of an integral by dividing its cell that is accepted.
const TOLERANCE: f64 = 1e-6;

/// Largest number of successive divisions of a cell.
const DEPTH: u32 = 24;

/// The five-point Gauss–Legendre rule for −1..1.
const POINTS: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
];

impl Cell {
    /// All directions above the surface.
    pub const HEMISPHERE: Cell = Cell {
        theta: [0.0, FRAC_PI_2],
        phi: [-PI, PI],
    };

    /// The four quarters.
    pub fn quarters(&self) -> [Cell; 4] {
        let [t, p] = [self.theta, self.phi].map(|[a, b]| 0.5 * (a + b));
        let cell = |theta, phi| Cell { theta, phi };
        let ([t0, t1], [p0, p1]) = (self.theta, self.phi);
        [
            cell([t0, t], [p0, p]),
            cell([t0, t], [p, p1]),
            cell([t, t1], [p0, p]),
            cell([t, t1], [p, p1]),
        ]
    }

    /// Which quarter holds a direction of the cell.
    pub fn quarter_of(&self, w: DVec3) -> usize {
        let [theta, phi] = angles(w);
        let beyond = |x: f64, [a, b]: [f64; 2]| usize::from(x >= 0.5 * (a + b));
        2 * beyond(theta, self.theta) + beyond(phi, self.phi)
    }

    fn holds(&self, [theta, phi]: [f64; 2]) -> bool {
        let within = |x: f64, [a, b]: [f64; 2]| (a..=b).contains(&x);
        within(theta, self.theta) && within(phi, self.phi)
    }

    /// The larger of its two sides.
    fn size(&self) -> f64 {
        let [t, p] = [self.theta, self.phi].map(|[a, b]| b - a);
        t.max(p * self.theta[1].sin())
    }

    /// ∫ `of` over solid angle, where `of` may have a lobe about the specular direction of `wo`.
    pub fn integral(&self, wo: DVec3, of: &dyn Fn(DVec3) -> Rgb) -> Rgb {
        let mirrored = angles(DVec3::new(-wo.x, -wo.y, wo.z));
        self.divided(self.once(of), mirrored, of, DEPTH)
    }

    fn divided(
        &self,
        whole: Rgb,
        mirrored: [f64; 2],
        of: &dyn Fn(DVec3) -> Rgb,
        depth: u32,
    ) -> Rgb {
        let quarters = self.quarters();
        let parts = quarters.map(|q| q.once(of));
        let sum: Rgb = parts.into_iter().sum();
        let change = (sum - whole).map(f64::abs).max_channel();
        let largest = if self.holds(mirrored) {
            AT_MIRRORED
        } else {
            LARGEST
        };
        if depth == 0 || (self.size() <= largest && change < TOLERANCE) {
            return sum;
        }
        let parts = quarters.iter().zip(parts);
        parts
            .map(|(quarter, part)| quarter.divided(part, mirrored, of, depth - 1))
            .sum()
    }

    fn once(&self, of: &dyn Fn(DVec3) -> Rgb) -> Rgb {
        let [half_theta, half_phi] = [self.theta, self.phi].map(|[a, b]| 0.5 * (b - a));
        let [theta, phi] = [self.theta, self.phi].map(|[a, b]| 0.5 * (a + b));
        let columns = POINTS.map(|(y, weight)| ((phi + y * half_phi).sin_cos(), weight));
        let mut sum = Rgb::BLACK;
        for (x, weight) in POINTS {
            let (sin, cos) = (theta + x * half_theta).sin_cos();
            let row = columns.map(|((sin_phi, cos_phi), weight)| {
                of(DVec3::new(sin * cos_phi, sin * sin_phi, cos)) * weight
            });
            sum += row.into_iter().sum::<Rgb>() * (weight * sin);
        }
        sum * (half_theta * half_phi)
    }
}

/// Angle to the normal and azimuth, -π..=π.
fn angles(w: DVec3) -> [f64; 2] {
    [w.x.hypot(w.y).atan2(w.z), w.y.atan2(w.x)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::check::direction;
    use std::f64::consts::TAU;

    #[test]
    fn integrals_are_those_in_closed_form() {
        let check = |of: &dyn Fn(DVec3) -> f64, expected: f64| {
            let wo = direction(30.0, 20.0);
            let integral = Cell::HEMISPHERE.integral(wo, &|w| Rgb::grey(of(w))).r;
            assert!((integral - expected).abs() < 1e-4, "{integral} {expected}");
        };
        check(&|_| 1.0, TAU);
        check(&|w| w.z, PI);
        check(&|w| if w.y > 0.3 { w.z } else { 0.0 }, PI - crossed(0.3));
        // A lobe of width 1/1000 about the specular direction.
        let axis = direction(30.0, 200.0);
        let n = 1e6;
        let lobe = |w: DVec3| (n + 1.0) / TAU * w.dot(axis).max(0.0).powf(n);
        check(&lobe, 1.0);
    }

    /// Area of the unit disc below a height.
    fn crossed(y: f64) -> f64 {
        FRAC_PI_2 + y.asin() + y * (1.0 - y * y).sqrt()
    }
}
