//! Standard errors of single points.
//!
//! The spread of a point's four replicates says little about its variance: it has three degrees of
//! freedom, and says zero where no path met a rare light. Points of one stratum with as many rays are
//! alike, so that each point's variance is moved toward theirs, by as much as they are alike: an
//! empirical Bayes estimate under an inverse gamma prior (Robbins 1956; in this form Smyth, *Linear
//! models and empirical Bayes methods*, Stat. Appl. Genet. Mol. Biol. 3, 2004). The mean variance of
//! the points, and with it the error of the whole, stays what it is.

use crate::gathered_values::PointKind;
use crate::gathering::Gathering;
use crate::strata::{OWN, coverage};
use azulejo_scene::Rgb;
use azulejo_trace::Gathered;

/// Points of a class, at least.
const LEAST: usize = 24;

/// Most degrees of freedom of what a class says of a point: no prior is right.
const MOST: f64 = 12.0;

/// Square of the mean root of a variance over the mean variance, for three degrees of freedom: what
/// equal points show, 8/(3π).
const EQUAL: f64 = 0.848_826_363_156_775_1;

impl Gathering {
    /// Standard error of every point, discretization included: the truth lies within two of them
    /// 95.4 times in 100.
    pub fn standard_errors(&self) -> Vec<Rgb> {
        let mut errors = vec![Rgb::BLACK; self.gathered.len()];
        for (stratum, error) in self.errors().iter().enumerate() {
            let points = self.strata.points(stratum);
            // The error of interpolation is a mean over all points, of which some have none.
            let is_interpolated = |i: u32| self.values.kind(i as usize) == PointKind::Interpolated;
            let interpolated = points.iter().filter(|&&i| is_interpolated(i)).count();
            let theirs = error.interpolation * points.len() as f64 / interpolated.max(1) as f64;
            for class in classes(points, &self.spent) {
                for (&i, noise) in class.iter().zip(noise_of(&class, self, error.gain)) {
                    let interpolation = if is_interpolated(i) { theirs } else { 0.0 };
                    let fixed = error.discretization + interpolation;
                    errors[i as usize] = (noise + Rgb::grey(fixed)).map(f64::sqrt);
                }
            }
        }
        errors
    }

    /// Root mean square over the points of the standard error of each relative to its irradiance, where there is any.
    pub fn error_of_each(&self) -> f64 {
        let errors = self.standard_errors();
        let relative = |(g, error): (&Gathered, &Rgb)| {
            let mean = self.strata.mean_of(g.mean());
            (mean > 0.0).then(|| self.strata.mean_of(*error * *error) / (mean * mean))
        };
        let squares: Vec<f64> = self
            .gathered
            .iter()
            .zip(&errors)
            .filter_map(relative)
            .collect();
        (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
    }
}

/// Divides points by the rays they took, those with as many together, at least [`LEAST`] if there
/// are as many points.
fn classes(points: &[u32], spent: &[u32]) -> Vec<Vec<u32>> {
    let rays = |i: u32| spent[i as usize];
    let mut order = points.to_vec();
    order.sort_by_key(|&i| rays(i));
    let mut classes: Vec<Vec<u32>> = Vec::new();
    for alike in order.chunk_by(|&a, &b| rays(a) == rays(b)) {
        match classes.last_mut() {
            Some(last) if last.len() < LEAST => last.extend(alike),
            _ => classes.push(alike.to_vec()),
        }
    }
    let rest = classes.pop_if(|last| last.len() < LEAST);
    match (classes.last_mut(), rest) {
        (Some(last), Some(rest)) => last.extend(rest),
        (None, Some(rest)) => classes.push(rest),
        _ => {}
    }
    classes
}

/// Variance of each point of a class by noise, (W/m²)², times the square of the factor by which two
/// standard errors cover 95.4%. `gain` is that of the stratum.
fn noise_of(class: &[u32], gathering: &Gathering, gain: f64) -> Vec<Rgb> {
    let of = |&i: &u32| {
        let gathered = &gathering.gathered[i as usize];
        (gathered.mean(), gathered.variance() * gain)
    };
    let points: Vec<(Rgb, Rgb)> = class.iter().map(of).collect();
    let count = points.len() as f64;
    let bright = points.iter().map(|p| p.0).sum::<Rgb>() / count;
    // The noise of a channel grows with its light: half of that is the point's own, half the
    // class's, so that dark points have a scale, too.
    let scale = |mean: Rgb| {
        let own = mean.map(|e| e.max(0.0));
        (own * own + bright * bright) * 0.5
    };
    let scales: Vec<Rgb> = points.iter().map(|&(mean, _)| scale(mean)).collect();
    let sum = |of: &dyn Fn(usize) -> f64| (0..points.len()).map(of).sum::<f64>();
    let whole = sum(&|k| scales[k].mean());
    if whole <= 0.0 {
        return points.iter().map(|p| p.1).collect();
    }
    let typical = sum(&|k| points[k].1.mean()) / whole;
    let relative = |k: usize| points[k].1.mean() / scales[k].mean().max(f64::MIN_POSITIVE);
    // A point says nothing of itself but what its own variance says.
    let shared = likeness(sum(&|k| relative(k).sqrt()) / count, sum(&relative) / count);
    let shared = shared.min(OWN * (count - 1.0));
    let factor = coverage(OWN + shared).powi(2);
    let shrunk = |(&(_, own), &scale): (&(Rgb, Rgb), &Rgb)| {
        (scale * (typical * shared) + own * OWN) * (factor / (OWN + shared))
    };
    points.iter().zip(&scales).map(shrunk).collect()
}

/// Degrees of freedom of what points say of another's variance, from the means of their standard
/// deviations and of their variances.
///
/// If the true variances have an inverse gamma distribution of d + 2 degrees of freedom, the ratio
/// f of the square of the mean root to the mean is Γ²((d+1)/2)/Γ²(d/2+1) d/2, which is
/// d/(d + 0.56) within 0.02; the best linear estimate of a point's variance then weights the mean of
/// all by d beside the point's own by 3. Unlike moments of higher order, few wild points do not upset
/// it, and neither do points without spread.
fn likeness(root: f64, mean: f64) -> f64 {
    if mean <= 0.0 {
        return MOST;
    }
    let f = (root * root / mean / EQUAL).min(1.0);
    let left = 1.0 - f;
    if 0.56 * f >= MOST * left {
        MOST
    } else {
        0.56 * f / left
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gathering::GatherTargets;
    use azulejo_trace::sampling::{hash, uniform};
    use azulejo_trace::{GatherPoint, Gathered};
    use glam::DVec3;
    use std::f64::consts::TAU;

    /// A number from the normal distribution.
    fn normal(key: &[u32]) -> f64 {
        let [u, v] = [0, 1].map(|d| f64::from(uniform(&[hash(key), d])));
        (-2.0 * (1.0 - u).ln()).sqrt() * (TAU * v).cos()
    }

    /// Points of irradiance (2, 1, 0) whose replicates have these standard deviations.
    fn gathering(deviation: impl Fn(u32) -> f64, count: u32) -> Gathering {
        let point = |key: u32| GatherPoint {
            position: DVec3::ZERO,
            normal: DVec3::Z,
            key,
        };
        let points: Vec<GatherPoint> = (0..count).map(point).collect();
        let mut all = Gathering::new(GatherTargets {
            points: &points,
            areas: &[],
        });
        for i in 0..count {
            let of = |r: usize| {
                let off = 1.0 + deviation(i) * normal(&[i, r as u32]);
                Rgb::new(2.0 * off, off, 0.0)
            };
            all.gathered[i as usize] = Gathered {
                replicates: std::array::from_fn(of),
            };
        }
        all
    }

    fn covered(all: &Gathering) -> f64 {
        let within = |(g, e): (&Gathered, &Rgb)| (g.mean().r - 2.0).abs() <= 2.0 * e.r;
        let errors = all.standard_errors();
        let count = all
            .gathered
            .iter()
            .zip(&errors)
            .filter(|&p| within(p))
            .count();
        count as f64 / errors.len() as f64
    }

    #[test]
    fn alike_points_share_what_they_know() {
        let all = gathering(|_| 0.1, 4000);
        let share = covered(&all);
        // Some more than 95.4%, as the class is believed to a limit.
        assert!((0.945..0.98).contains(&share), "{share}");
        let errors = all.standard_errors();
        // Four replicates of deviation 0.1 relative to the mean.
        let rms = (errors.iter().map(|e| e.r * e.r).sum::<f64>() / 4000.0).sqrt();
        assert!((rms / 0.1 - 1.0).abs() < 0.12, "{rms}");
        assert!(
            errors
                .iter()
                .all(|e| (e.r - 2.0 * e.g).abs() < 1e-9 && e.b == 0.0)
        );
    }

    #[test]
    fn points_of_many_kinds_keep_their_own() {
        let all = gathering(|i| 0.1 * f64::from(i % 7 + 1).exp2() / 128.0, 4000);
        let share = covered(&all);
        assert!((0.92..0.99).contains(&share), "{share}");
    }

    /// One path in a hundred meets a light: most points found nothing that varies.
    #[test]
    fn points_without_spread_have_an_error() {
        let all = gathering(|i| if i % 10 == 0 { 0.1 } else { 0.0 }, 1000);
        let errors = all.standard_errors();
        assert!(errors.iter().all(|e| e.r > 1e-3), "{:?}", errors[1]);
        assert!(errors[1].r < 0.5 * errors[10].r);
        let dark = gathering(|_| 0.0, 100);
        assert!(dark.standard_errors().iter().all(|e| e.r == 0.0));
    }

    #[test]
    fn classes_hold_alike_points() {
        let spent: Vec<u32> = (0..100)
            .map(|i| [64, 128, 256][usize::from(i >= 30) + usize::from(i >= 90)])
            .collect();
        let points: Vec<u32> = (0..100).collect();
        let sizes: Vec<usize> = classes(&points, &spent).iter().map(Vec::len).collect();
        assert_eq!(sizes, [30, 70]);
        assert_eq!(classes(&points[..5], &spent).len(), 1);
        assert!(classes(&[], &spent).is_empty());
    }

    #[test]
    fn coverage_is_that_of_student() {
        for (freedom, t) in [(3.0, 3.307), (5.0, 2.649), (15.0, 2.181), (1e9, 2.0)] {
            assert!(
                (2.0 * coverage(freedom) / t - 1.0).abs() < 0.01,
                "{freedom}"
            );
        }
        assert!((likeness(EQUAL.sqrt(), 1.0) - MOST).abs() < 1e-9);
        assert!(likeness(0.0, 1.0) == 0.0);
    }
}
