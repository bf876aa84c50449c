//! Sums of form factors by side.

use azulejo_scene::Rgb;
use azulejo_trace::item_buffer::{Hemicube, Share};

/// Sums by side, in `f64`, in the order in which they are added.
pub struct Tally {
    sums: Vec<f64>,
    /// Sides with a sum.
    sides: Vec<u32>,
}

impl Tally {
    pub fn new(patches: u32) -> Tally {
        Tally {
            sums: vec![0.0; 2 * patches as usize],
            sides: Vec::new(),
        }
    }

    /// Adds a share, which must be positive.
    pub fn add(&mut self, side: u32, share: f64) {
        let sum = &mut self.sums[side as usize];
        if *sum == 0.0 {
            self.sides.push(side);
        }
        *sum += share;
    }

    /// Takes the sums by side, sorted.
    pub fn take(&mut self) -> impl Iterator<Item = (u32, f64)> + '_ {
        self.sides.sort_unstable();
        let sums = &mut self.sums;
        let take = move |side| (side, std::mem::take(&mut sums[side as usize]));
        self.sides.drain(..).map(take)
    }
}

/// Form factors of one view, from all windows.
#[derive(Default)]
pub struct Shares {
    found: Vec<(u32, u8, Rgb)>,
    /// Their number when they were last merged.
    together: usize,
}

impl Shares {
    pub fn add(&mut self, side: u32, order: u8, share: Rgb) {
        self.found.push((side, order, share));
        if self.found.len() > 2 * self.together + 4096 {
            self.put_together();
        }
    }

    fn put_together(&mut self) {
        // A stable sort keeps the order of insertion, on which alone the sums depend.
        self.found.sort_by_key(|&(side, order, _)| (side, order));
        self.found.dedup_by(|next, kept| {
            let is_same = (next.0, next.1) == (kept.0, kept.1);
            if is_same {
                kept.2 += next.2;
            }
            is_same
        });
        self.together = self.found.len();
    }

    /// Takes the sums: each side and order once, sorted.
    pub fn finished(mut self) -> Vec<Share> {
        self.put_together();
        let share = |(side, order, share): (u32, u8, Rgb)| Share {
            side,
            order,
            weight: share,
        };
        self.found.into_iter().map(share).collect()
    }
}

/// Delta form factors of a hemicube's pixels, which sum to 1.
pub fn exact_weights(cube: &Hemicube) -> Vec<f64> {
    let sum: f64 = cube.weights().iter().map(|&w| f64::from(w)).sum();
    cube.weights().iter().map(|&w| f64::from(w) / sum).collect()
}

/// The same as integers, and the integer for 1. Each is at most 2^27, so that 16 of them can be
/// added in 32 bits, and rounded to 2^-28 of the largest.
pub fn whole_weights(weights: &[f64]) -> (Vec<u32>, f64) {
    let largest = weights.iter().fold(0.0, |a: f64, &b| a.max(b));
    let scale = (27.0 - largest.log2()).floor().exp2();
    let whole = |w: &f64| (w * scale).round() as u32;
    let whole: Vec<u32> = weights.iter().map(whole).collect();
    let sum: u64 = whole.iter().map(|&w| u64::from(w)).sum();
    (whole, sum as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_sorted_and_start_anew() {
        let mut tally = Tally::new(3);
        for _round in 0..2 {
            tally.add(5, 0.25);
            tally.add(2, 1.0);
            tally.add(5, 0.5);
            assert_eq!(tally.take().collect::<Vec<_>>(), [(2, 1.0), (5, 0.75)]);
        }
        assert_eq!(tally.take().count(), 0);
    }

    #[test]
    fn shares_of_a_side_and_order_become_one() {
        let mut shares = Shares::default();
        for _ in 0..5000 {
            shares.add(7, 2, Rgb::grey(0.125));
            shares.add(3, 1, Rgb::new(0.25, 0.0, 0.0));
        }
        let shares = shares.finished();
        let shares: Vec<_> = shares.iter().map(|s| (s.side, s.order, s.weight)).collect();
        let expected = [(3, 1, Rgb::new(1250.0, 0.0, 0.0)), (7, 2, Rgb::grey(625.0))];
        assert_eq!(shares, expected);
    }

    #[test]
    fn whole_weights_are_close_and_do_not_overflow() {
        for n in [2, 64, 512] {
            let weights = exact_weights(&Hemicube::new(n));
            let (whole, sum) = whole_weights(&weights);
            for (&w, f) in whole.iter().zip(weights) {
                assert!(w > 0 && w <= 1 << 27);
                let off = (f64::from(w) / sum - f).abs();
                assert!(off < 1e-6 * f + 1e-12, "{n}: {w} {f}");
            }
        }
    }
}
