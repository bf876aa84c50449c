//! The windows of a view that are drawn, where mirrors show more of them than are worth while.
//!
//! In a closed body of mirrors every pixel ends up in a window of its own, level after level. So
//! the weak windows of a level are drawn by chance, in proportion to the light that they carry, and
//! those that are drawn stand for the others: the Russian roulette of Arvo and Kirk (*Particle
//! transport and image synthesis*, SIGGRAPH 1990), by systematic sampling (Madow and Madow, *On the
//! theory of systematic sampling*, Annals of Mathematical Statistics 15, 1944). A comb of equal
//! steps is laid over the running sum of their weights, so that all of them together keep their
//! light to within one step, and each keeps its own on average.

use super::view::HemicubeView;
use crate::sampling::{hash, uniform};

/// Windows that any level may draw, however many were drawn before it.
const FEWEST: usize = 8;

/// Decides which windows of a view are drawn, level by level.
///
/// A level draws at most half of what is left of the budget, or `FEWEST`, so that a view draws
/// no more than the budget and `FEWEST` for each level of mirrors.
#[derive(Clone, Debug)]
pub struct WindowBudget {
    /// Weight below which windows are drawn by chance.
    cut: f64,
    /// Windows that are left.
    rest: usize,
    /// Keys the random numbers: the viewpoint and its rotation.
    key: u32,
    level: u32,
}

impl WindowBudget {
    /// The budget of a view: `windows` in all, and weights below `cut` by chance.
    pub fn new(view: &HemicubeView, cut: f32, windows: u32) -> WindowBudget {
        let numbers = [view.eye, view.axes[0], view.axes[2]].map(|v| v.to_array());
        let bits = numbers.as_flattened().iter().map(|x| x.to_bits());
        let words: Vec<u32> = bits.flat_map(|b| [b as u32, (b >> 32) as u32]).collect();
        WindowBudget {
            cut: f64::from(cut),
            rest: windows as usize,
            key: hash(&words),
            level: 0,
        }
    }

    /// For each window of the next level the factor by which its light is to be multiplied: 1 where
    /// it is drawn in any case, 0 where it is not drawn, more than 1 where it stands for others.
    /// `weights` are the shares of the hemicube that the windows show, times what the mirrors on
    /// the way reflect of it.
    pub fn factors(&mut self, weights: &[f64]) -> Vec<f64> {
        let room = (self.rest / 2).max(FEWEST);
        let step = self.cut.max(step(weights, room));
        self.level += 1;
        let mut sum = f64::from(uniform(&[self.key, self.level]));
        let factor = |&weight: &f64| {
            if weight >= step {
                return if weight > 0.0 { 1.0 } else { 0.0 };
            }
            let before = sum.floor();
            sum += weight / step;
            if sum.floor() > before {
                step / weight
            } else {
                0.0
            }
        };
        let factors: Vec<f64> = weights.iter().map(factor).collect();
        let drawn = factors.iter().filter(|&&f| f > 0.0).count();
        self.rest = self.rest.saturating_sub(drawn);
        factors
    }
}

/// The step of a comb that draws `room` of the windows on average, those above it in any case; 0 if
/// there is room for all.
fn step(weights: &[f64], room: usize) -> f64 {
    if weights.len() <= room {
        return 0.0;
    }
    let mut sorted = weights.to_vec();
    sorted.sort_unstable_by(|a, b| b.total_cmp(a));
    let mut rest: f64 = sorted.iter().sum();
    for (certain, &weight) in sorted.iter().enumerate().take(room) {
        let step = rest / (room - certain) as f64;
        if weight <= step {
            return step;
        }
        rest -= weight;
    }
    sorted[room - 1]
}

#[cfg(test)]
mod tests {
    use super::super::view::{DepthPrecision, UnitCube};
    use super::super::{View, WindowBudget};
    use super::*;
    use glam::DVec3;

    fn budget(turn: f64, cut: f32, windows: u32) -> WindowBudget {
        let view = View {
            eye: DVec3::ZERO,
            normal: DVec3::Z,
            turn,
        };
        let local = UnitCube {
            centre: DVec3::ZERO,
            reach: 1.0,
        };
        let view = HemicubeView::new(&view, &local, DepthPrecision::Double);
        WindowBudget::new(&view, cut, windows)
    }

    /// Weights of very different size.
    fn weights(count: u32) -> Vec<f64> {
        let weight = |k| 1e-3 * f64::from(uniform(&[k])).powi(4) + 1e-7;
        (0..count).map(weight).collect()
    }

    #[test]
    fn within_the_budget_all_are_drawn() {
        let weights = weights(50);
        let factors = budget(0.0, 0.0, 100).factors(&weights);
        assert_eq!(factors, vec![1.0; 50]);
        assert_eq!(budget(0.0, 0.5, 100).factors(&[0.0, 0.7]), [0.0, 1.0]);
    }

    #[test]
    fn the_number_of_windows_is_bounded() {
        let (mut budget, weights) = (budget(0.0, 0.0, 200), weights(3000));
        let mut drawn = 0;
        for level in 0..40 {
            let factors = budget.factors(&weights);
            let here = factors.iter().filter(|&&f| f > 0.0).count();
            // The comb may catch one more than its mean.
            assert!(
                here <= (200 - drawn.min(200)).max(2 * FEWEST) / 2 + 1,
                "{level}: {here}"
            );
            drawn += here;
        }
        assert!(drawn <= 200 + 40 * (FEWEST + 1), "{drawn}");
    }

    #[test]
    fn light_is_kept_together_and_by_each_on_average() {
        let weights = weights(400);
        let whole: f64 = weights.iter().sum();
        let step = step(&weights, 50);
        let rounds = 4000;
        let mut means = vec![0.0; weights.len()];
        for round in 0..rounds {
            let factors = budget(f64::from(round), 0.0, 100).factors(&weights);
            let kept: f64 = weights.iter().zip(&factors).map(|(w, f)| w * f).sum();
            assert!((kept - whole).abs() <= step * 1.000_001, "{kept} {whole}");
            for (mean, factor) in means.iter_mut().zip(&factors) {
                *mean += factor / f64::from(rounds);
            }
        }
        for (weight, mean) in weights.iter().zip(&means) {
            // Drawn with the chance p, a factor of 1/p has the variance 1/p − 1.
            let chance = (weight / step).min(1.0);
            let error = ((1.0 / chance - 1.0) / f64::from(rounds)).sqrt();
            assert!((mean - 1.0).abs() <= 5.0 * error + 1e-9, "{weight} {mean}");
        }
    }

    #[test]
    fn a_cut_thins_what_is_weaker() {
        let factors = budget(1.0, 1e-2, 1000).factors(&[1e-3; 100]);
        let drawn: Vec<f64> = factors.into_iter().filter(|&f| f > 0.0).collect();
        assert!((9..=11).contains(&drawn.len()), "{drawn:?}");
        assert!(drawn.iter().all(|f| (f - 10.0).abs() < 1e-4), "{drawn:?}");
    }
}
