//! Adaptive integration over flat cells.
//!
//! Each cell is the bilinear image of the unit square. A tensor product of Kronrod rules gives its
//! integral; replacing Kronrod by Gauss in one direction gives the error of that direction. The
//! worst cell is halved across its worse direction until the sum of errors is small enough (as in
//! Genz and Malik 1980). Integrands that are singular along an edge therefore cost cells in one
//! direction only.

use super::Approximate;
use azulejo_scene::math::area_vector;
use azulejo_trace::lambert::ArrayPolygon;
use glam::DVec3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Kronrod nodes on 0..1 with their weights and the weights of the embedded Gauss rule.
type Rule = [(f64, f64, f64)];

/// Gauss 3 and Kronrod 7 points.
const COARSE: [(f64, f64, f64); 7] = mirrored([
    (0.960_491_268_708_020_3, 0.104_656_226_026_467_3, 0.0),
    (0.774_596_669_241_483_4, 0.268_488_089_868_333_4, 5.0 / 9.0),
    (0.434_243_749_346_802_6, 0.401_397_414_775_962_2, 0.0),
    (0.0, 0.450_916_538_658_474_1, 8.0 / 9.0),
]);

/// Gauss 7 and Kronrod 15 points.
const FINE: [(f64, f64, f64); 15] = mirrored([
    (0.991_455_371_120_812_6, 0.022_935_322_010_529_22, 0.0),
    (
        0.949_107_912_342_758_5,
        0.063_092_092_629_978_55,
        0.129_484_966_168_869_7,
    ),
    (0.864_864_423_359_769_1, 0.104_790_010_322_250_2, 0.0),
    (
        0.741_531_185_599_394_4,
        0.140_653_259_715_525_9,
        0.279_705_391_489_276_7,
    ),
    (0.586_087_235_467_691_1, 0.169_004_726_639_267_9, 0.0),
    (
        0.405_845_151_377_397_2,
        0.190_350_578_064_785_4,
        0.381_830_050_505_118_9,
    ),
    (0.207_784_955_007_898_5, 0.204_432_940_075_298_9, 0.0),
    (0.0, 0.209_482_141_084_727_8, 0.417_959_183_673_469_4),
]);

/// All nodes of a symmetric rule on −1..1, moved to 0..1, from half of them.
const fn mirrored<const HALF: usize, const ALL: usize>(
    half: [(f64, f64, f64); HALF],
) -> [(f64, f64, f64); ALL] {
    let mut nodes = [(0.0, 0.0, 0.0); ALL];
    let mut k = 0;
    while k < HALF {
        let (x, kronrod, gauss) = half[k];
        nodes[k] = (0.5 - 0.5 * x, 0.5 * kronrod, 0.5 * gauss);
        nodes[ALL - 1 - k] = (0.5 + 0.5 * x, 0.5 * kronrod, 0.5 * gauss);
        k += 1;
    }
    nodes
}

/// Accuracy, relative to the integral of the absolute values, from which the finer rule pays off.
const FINE_FROM: f64 = 1e-7;

/// Integral of `f` over polygons in one plane with unit `normal`. Clockwise polygons count
/// negative; concave ones are allowed: their fans then count folded parts twice with opposite
/// signs.
///
/// Ends when the estimated error is below `tolerance` or after `most` evaluations of `f`.
pub(crate) fn integrate(
    polygons: &[ArrayPolygon],
    normal: DVec3,
    tolerance: f64,
    most: usize,
    mut f: impl FnMut(DVec3) -> f64,
) -> Approximate {
    let areas = polygons.iter().map(|p| area_vector(p).dot(normal));
    let is_fine = tolerance < FINE_FROM * areas.sum::<f64>();
    let rule: &Rule = if is_fine { &FINE } else { &COARSE };
    let mut spent = 0;
    let mut cells = BinaryHeap::new();
    let mut error = 0.0;
    let mut add = |cells: &mut BinaryHeap<Cell>, error: &mut f64, corners: [DVec3; 4]| {
        let cell = Cell::measure(corners, normal, rule, &mut f);
        spent += rule.len() * rule.len();
        *error += cell.error;
        cells.push(cell);
        spent
    };
    for corners in polygons.iter().flat_map(|p| fan(p)) {
        add(&mut cells, &mut error, corners);
    }
    while let Some(worst) = cells.peek().filter(|_| error > tolerance) {
        let [first, second] = worst.halves();
        error -= worst.error;
        cells.pop();
        add(&mut cells, &mut error, first);
        if add(&mut cells, &mut error, second) > most {
            break;
        }
    }
    // The heap's internal order is a function of its history alone.
    let total = |part: fn(&Cell) -> f64| cells.iter().map(part).sum::<f64>();
    Approximate {
        value: total(|c| c.value),
        error: total(|c| c.error),
    }
}

/// Quadrilaterals, the last perhaps a triangle, that make up a polygon.
fn fan(polygon: &[DVec3]) -> impl Iterator<Item = [DVec3; 4]> {
    let last = polygon.len().saturating_sub(1);
    (1..last)
        .step_by(2)
        .map(move |k| [0, k, k + 1, (k + 2).min(last)].map(|k| polygon[k]))
}

struct Cell {
    corners: [DVec3; 4],
    value: f64,
    error: f64,
    /// Whether the error is larger in the direction from the first corner to the second.
    splits_first: bool,
}

impl Cell {
    fn measure(
        corners: [DVec3; 4],
        normal: DVec3,
        rule: &Rule,
        f: &mut impl FnMut(DVec3) -> f64,
    ) -> Cell {
        let [a, b, c, d] = corners;
        let (ab, ad, twist) = (b - a, d - a, a - b + c - d);
        // Kronrod in both directions, Gauss in one, and absolute values.
        let (mut value, mut first, mut second, mut size) = (0.0, 0.0, 0.0, 0.0);
        for &(u, kronrod_u, gauss_u) in rule {
            for &(v, kronrod_v, gauss_v) in rule {
                let jacobian = (ab + v * twist).cross(ad + u * twist).dot(normal);
                if jacobian == 0.0 {
                    continue;
                }
                let at = jacobian * f(a + u * ab + v * ad + u * v * twist);
                value += kronrod_u * kronrod_v * at;
                first += gauss_u * kronrod_v * at;
                second += kronrod_u * gauss_v * at;
                size += kronrod_u * kronrod_v * at.abs();
            }
        }
        let (first, second) = ((value - first).abs(), (value - second).abs());
        Cell {
            corners,
            value,
            error: believed(first, size) + believed(second, size),
            splits_first: first > second,
        }
    }

    fn halves(&self) -> [[DVec3; 4]; 2] {
        let [a, b, c, d] = self.corners;
        if self.splits_first {
            let (low, high) = (0.5 * (a + b), 0.5 * (d + c));
            [[a, low, high, d], [low, b, c, high]]
        } else {
            let (low, high) = (0.5 * (a + d), 0.5 * (b + c));
            [[a, b, high, low], [low, high, c, d]]
        }
    }
}

/// The error of Kronrod's rule estimated from its difference to Gauss's, as QUADPACK does (Piessens
/// et al. 1983); never below rounding.
fn believed(difference: f64, size: f64) -> f64 {
    if size == 0.0 {
        return 0.0;
    }
    let error = size * (200.0 * difference / size).powf(1.5).min(1.0);
    error.max(4.0 * f64::EPSILON * size)
}

impl PartialEq for Cell {
    fn eq(&self, other: &Cell) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Cell {}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Cell) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Cell {
    fn cmp(&self, other: &Cell) -> Ordering {
        self.error.total_cmp(&other.error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;

    fn check(f: impl Fn(f64, f64) -> f64, expected: f64, tolerance: f64) {
        let square = [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|(x, y)| dvec3(x, y, 0.));
        let square: ArrayPolygon = square.into_iter().collect();
        let integral = integrate(&[square], DVec3::Z, tolerance, 1_000_000, |p| f(p.x, p.y));
        let off = (integral.value - expected).abs();
        assert!(
            off <= integral.error && integral.error <= tolerance,
            "{integral:?}, off by {off}"
        );
    }

    #[test]
    fn smooth_kinked_and_singular_integrands() {
        check(
            |x, y| (x + 2.0 * y).exp(),
            1f64.exp_m1() * 2f64.exp_m1() / 2.0,
            1e-12,
        );
        check(|x, _| x.sqrt(), 2.0 / 3.0, 1e-10);
        check(|x, y| x * x.ln() + y, 0.25, 1e-11);
        check(|x, y| (x - 0.3 * y).max(0.0), 0.365, 1e-6);
        check(|_, _| 0.0, 0.0, 1e-12);
    }
}
