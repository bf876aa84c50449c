//! A function on the visible half of a sphere, from few of its values where it is smooth.
//!
//! A patch is a range of the angle from the middle and of the azimuth, in which functions are smooth up to the edge, unlike
//! in the picture. It is interpolated if a few other values agree; otherwise its quarters are tried.
//!
//! What is narrower than the space between nodes can be missed where a border of patches cuts it: a spot of 13° near the
//! edge was, in part. The reflection of the lamp, which is the only one as narrow, is far from borders.

use azulejo_scene::Rgb;
use glam::DVec2;
use std::array::from_fn;
use std::f64::consts::TAU;

/// Nodes of a patch in each direction.
const COUNT: usize = 7;

/// Where they are, from −1 to 1: Chebyshev's points.
const NODES: [f64; COUNT] = [
    -0.974_927_912_181_824,
    -0.781_831_482_468_030,
    -0.433_883_739_117_558,
    0.0,
    0.433_883_739_117_558,
    0.781_831_482_468_029,
    0.974_927_912_181_824,
];

/// Where values are compared: there the polynomial of the nodes, Chebyshev's, is largest.
const CHECKS: [[f64; 2]; 8] = [
    [0.901, 0.623],
    [-0.623, 0.901],
    [-0.901, -0.623],
    [0.623, -0.901],
    [0.623, 0.901],
    [-0.901, 0.623],
    [-0.623, -0.901],
    [0.901, -0.623],
];

/// Patches with fewer pixels are not worth their values.
const LEAST_PIXELS: f64 = 60.0;

/// Patches around the middle that are tried first, ring by ring: about as long as wide, and with nodes near enough to each
/// other for reflections of the lamp, 26° wide.
const SECTORS: [usize; 2] = [6, 10];

/// The sine of the largest angle.
pub const EDGE: f64 = 0.9995;

/// A function with values of light, to the precision of `is_near`.
pub trait SphereFunction: Sync {
    /// Its value at a place of the unit disk.
    fn at(&self, place: DVec2) -> Rgb;

    /// Whether an interpolated value is near enough to the true one.
    fn is_near(&self, interpolated: Rgb, value: Rgb) -> bool;
}

/// The interpolation of a function: its [`part`](SpherePatches::part)s in order.
pub struct SpherePatches(pub Vec<SpherePatch>);

/// A patch or its parts.
pub enum SpherePatch {
    /// Values at the nodes, rows of equal angle.
    Smooth(Box<[[Rgb; COUNT]; COUNT]>),
    /// The quarters.
    Divided(Box<[SpherePatch; 4]>),
    /// To be evaluated point by point.
    Rough,
}

/// Ranges of the angle from the middle and of the azimuth, radians.
#[derive(Clone, Copy)]
struct PolarRange {
    theta: [f64; 2],
    phi: [f64; 2],
}

impl SpherePatches {
    /// Number of its parts.
    pub const COUNT: usize = SECTORS[0] + SECTORS[1];

    /// A part, for a function that is shown at `density` pixels per unit of area.
    pub fn part(part: usize, function: &impl SphereFunction, density: f64) -> SpherePatch {
        let inside = |ring: usize| SECTORS[..ring].iter().sum::<usize>();
        let ring = (1..SECTORS.len()).filter(|r| part >= inside(*r)).count();
        let range = PolarRange::of(ring, part - inside(ring));
        SpherePatch::new(range, function, density)
    }

    /// The value at a place of the unit disk, unless the function is too rough there.
    pub fn at(&self, place: DVec2) -> Option<Rgb> {
        let theta = place.length().min(EDGE).asin();
        let phi = place.y.atan2(place.x).rem_euclid(TAU);
        let within = |share: f64, count: usize| ((share * count as f64) as usize).min(count - 1);
        let ring = within(theta / EDGE.asin(), SECTORS.len());
        let sector = within(phi / TAU, SECTORS[ring]);
        let part = SECTORS[..ring].iter().sum::<usize>() + sector;
        self.0[part].at(PolarRange::of(ring, sector), [theta, phi])
    }
}

impl SpherePatch {
    fn new(range: PolarRange, function: &impl SphereFunction, density: f64) -> SpherePatch {
        if range.area() * density < LEAST_PIXELS {
            return SpherePatch::Rough;
        }
        let value = |x: f64, y: f64| function.at(range.place(x, y));
        let values = NODES.map(|x| NODES.map(|y| value(x, y)));
        let agrees =
            |&[x, y]: &[f64; 2]| function.is_near(interpolated(&values, x, y), value(x, y));
        if CHECKS.iter().all(agrees) {
            return SpherePatch::Smooth(Box::new(values));
        }
        let quarter = |k: usize| SpherePatch::new(range.quarter(k), function, density);
        let ((a, b), (c, d)) = rayon::join(
            || rayon::join(|| quarter(0), || quarter(1)),
            || rayon::join(|| quarter(2), || quarter(3)),
        );
        SpherePatch::Divided(Box::new([a, b, c, d]))
    }

    fn at(&self, range: PolarRange, polar: [f64; 2]) -> Option<Rgb> {
        let [x, y] = range.coordinates(polar);
        match self {
            SpherePatch::Smooth(values) => Some(interpolated(values, x, y)),
            SpherePatch::Divided(quarters) => {
                let k = 2 * usize::from(x >= 0.0) + usize::from(y >= 0.0);
                quarters[k].at(range.quarter(k), polar)
            }
            SpherePatch::Rough => None,
        }
    }
}

impl PolarRange {
    fn of(ring: usize, sector: usize) -> PolarRange {
        let [width, turn] = [
            EDGE.asin() / SECTORS.len() as f64,
            TAU / SECTORS[ring] as f64,
        ];
        let range = |k: usize, step: f64| [k as f64 * step, (k + 1) as f64 * step];
        PolarRange {
            theta: range(ring, width),
            phi: range(sector, turn),
        }
    }

    fn quarter(&self, k: usize) -> PolarRange {
        let half = |[a, b]: [f64; 2], upper: bool| {
            let middle = 0.5 * (a + b);
            if upper { [middle, b] } else { [a, middle] }
        };
        PolarRange {
            theta: half(self.theta, k >= 2),
            phi: half(self.phi, k % 2 == 1),
        }
    }

    /// In the unit disk.
    fn area(&self) -> f64 {
        let [inner, outer] = self.theta.map(|t| t.sin().powi(2));
        0.5 * (outer - inner) * (self.phi[1] - self.phi[0])
    }

    /// The place in the unit disk for coordinates from −1 to 1 in both ranges.
    fn place(&self, x: f64, y: f64) -> DVec2 {
        let at = |[a, b]: [f64; 2], t: f64| 0.5 * ((a + b) + t * (b - a));
        at(self.theta, x).sin() * DVec2::from_angle(at(self.phi, y))
    }

    fn coordinates(&self, [theta, phi]: [f64; 2]) -> [f64; 2] {
        let of = |[a, b]: [f64; 2], t: f64| (2.0 * t - (a + b)) / (b - a);
        [of(self.theta, theta), of(self.phi, phi)]
    }
}

fn interpolated(values: &[[Rgb; COUNT]; COUNT], x: f64, y: f64) -> Rgb {
    let (rows, columns) = (weights(x), weights(y));
    let row = |(row, weight): (&[Rgb; COUNT], f64)| {
        let terms = row.iter().zip(columns).map(|(v, w)| *v * w);
        terms.sum::<Rgb>() * weight
    };
    values.iter().zip(rows).map(row).sum()
}

/// Weights of the nodes in the polynomial through their values, at `x` (Lagrange).
fn weights(x: f64) -> [f64; COUNT] {
    from_fn(|k| {
        let others = NODES.iter().filter(|node| **node != NODES[k]);
        others.map(|node| (x - node) / (NODES[k] - node)).product()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// A function of the normal, and how often it was evaluated.
    struct CountedFunction<F> {
        of: F,
        count: AtomicUsize,
    }

    impl<F: Fn(DVec2, f64) -> f64 + Sync> SphereFunction for CountedFunction<F> {
        fn at(&self, place: DVec2) -> Rgb {
            self.count.fetch_add(1, Ordering::Relaxed);
            Rgb::grey((self.of)(place, (1.0 - place.length_squared()).sqrt()))
        }

        fn is_near(&self, interpolated: Rgb, value: Rgb) -> bool {
            (interpolated - value).map(f64::abs).max_channel() < 1e-3
        }
    }

    /// Largest error at all pixels of a picture, and numbers of values and of pixels to be evaluated.
    fn measured(of: impl Fn(DVec2, f64) -> f64 + Sync) -> (f64, usize, usize) {
        let (side, count) = (200, AtomicUsize::new(0));
        let function = CountedFunction { of, count };
        let density = f64::from(side * side) / 4.0;
        let part = |k| SpherePatches::part(k, &function, density);
        let patches = SpherePatches((0..SpherePatches::COUNT).map(part).collect());
        let values = function.count.load(Ordering::Relaxed);
        let (mut worst, mut rough) = (0.0f64, 0);
        for k in 0..side * side {
            let at = |k: i32| (f64::from(k) + 0.5) / f64::from(side) * 2.0 - 1.0;
            let place = DVec2::new(at(k % side), at(k / side));
            if place.length() > EDGE {
                continue;
            }
            match patches.at(place) {
                Some(value) => {
                    worst = worst.max((value - function.at(place)).map(f64::abs).max_channel())
                }
                None => rough += 1,
            }
        }
        (worst, values, rough)
    }

    #[test]
    fn smooth_functions_need_few_values() {
        let (worst, values, rough) = measured(|p, z| 0.3 + 0.2 * p.x * p.y + 0.4 * z);
        assert!(
            worst < 2e-3 && values < 3000 && rough == 0,
            "{worst} {values} {rough}"
        );
    }

    /// Features as small as reflections of the lamp are found, and edges left to the caller.
    #[test]
    fn rough_functions_are_evaluated_at_pixels() {
        for center in [DVec2::ZERO, DVec2::new(-0.5, 0.4)] {
            let (worst, values, rough) = measured(|p, z| {
                let middle = center.extend((1.0 - center.length_squared()).sqrt());
                f64::from(u8::from(
                    p.extend(z).dot(middle) > 6.5f64.to_radians().cos(),
                ))
            });
            assert!(
                worst < 0.05 && rough > 50,
                "{center}: {worst} {values} {rough}"
            );
            assert!(values + rough < 12_000, "{center}: {values} {rough}");
        }
    }
}
