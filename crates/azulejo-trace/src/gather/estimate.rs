//! Estimates of irradiance with their replicates.

use super::REPLICATES;
use azulejo_scene::Rgb;

/// Irradiance of one point as independent estimates, W/m².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gathered {
    /// One estimate per replicate; their mean is the result.
    pub replicates: [Rgb; REPLICATES],
}

impl Gathered {
    /// The estimate.
    pub fn mean(&self) -> Rgb {
        self.replicates.iter().copied().sum::<Rgb>() / REPLICATES as f64
    }

    /// Standard error of [`mean`](Gathered::mean), if the replicates are independent, scaled so that
    /// two of it to either side cover the true value with the normal distribution's probability of
    /// 95.4%: by Student's t with three degrees of freedom, 2 σ become 3.307 s.
    pub fn standard_error(&self) -> Rgb {
        self.variance().map(f64::sqrt) * (3.307 / 2.0)
    }

    /// The weighted mean of two independent estimates; `share`, in 0..=1, is the weight of
    /// `other`.
    pub fn blend(&self, other: &Gathered, share: f64) -> Gathered {
        let of = |r: usize| self.replicates[r] * (1.0 - share) + other.replicates[r] * share;
        Gathered {
            replicates: std::array::from_fn(of),
        }
    }

    /// The sum of two estimates, replicate by replicate.
    pub fn plus(&self, other: &Gathered) -> Gathered {
        Gathered {
            replicates: std::array::from_fn(|r| self.replicates[r] + other.replicates[r]),
        }
    }

    /// The estimate times a number.
    pub fn scaled(&self, factor: f64) -> Gathered {
        Gathered {
            replicates: self.replicates.map(|r| r * factor),
        }
    }

    /// The difference of two estimates, replicate by replicate: noise that both share cancels.
    pub fn minus(&self, other: &Gathered) -> Gathered {
        Gathered {
            replicates: std::array::from_fn(|r| self.replicates[r] - other.replicates[r]),
        }
    }

    /// Variance of [`mean`](Gathered::mean), per channel, from the spread of the replicates as
    /// if they were independent; it is smaller for replicates that are stretches of one sequence.
    pub fn variance(&self) -> Rgb {
        let mean = self.mean();
        let square = |c: Rgb| c * c;
        let spread: Rgb = self.replicates.iter().map(|&r| square(r - mean)).sum();
        spread / (REPLICATES * (REPLICATES - 1)) as f64
    }
}

/// Variance of the means of estimates relative to that of independent replicates, a quarter to 1.
///
/// Replicates are parts of one sequence, so two together are better distributed than each alone. Comparing the
/// variance of halves with that of quarters, over all estimates, measures how much this helps; the whole is
/// assumed to gain over halves what these gain over quarters. `mean_of` is the mean over the channels that count.
pub fn sequence_gain<'a>(
    estimates: impl IntoIterator<Item = &'a Gathered>,
    mean_of: impl Fn(Rgb) -> f64,
) -> f64 {
    /// Weight of the conservative assumption, in estimates: a few carry little information.
    const DOUBT: f64 = 20.0;
    let (mut halves, mut quarters, mut count) = (0.0, 0.0, 0.0);
    for g in estimates {
        let [a, b, c, d] = g.replicates;
        let half = (a + b - c - d) * 0.5;
        // Both estimate the variance of one of their parts, times one minus the parts' correlation.
        halves += mean_of(half * half) / 2.0;
        quarters += REPLICATES as f64 * mean_of(g.variance());
        count += 1.0;
    }
    let step = if quarters > 0.0 {
        (2.0 * halves / quarters).clamp(0.5, 1.0)
    } else {
        1.0
    };
    (count * step * step + DOUBT) / (count + DOUBT)
}

/// Irradiance of one point by where it comes from, W/m².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SplitIrradiance {
    /// Straight from lamps and lights, or from them by one flat mirror: it changes abruptly at the
    /// edges of shadows.
    pub direct: Gathered,
    /// All else.
    pub indirect: Gathered,
}

impl SplitIrradiance {
    /// Both together.
    pub fn whole(&self) -> Gathered {
        self.direct.plus(&self.indirect)
    }

    /// As [`Gathered::blend`].
    pub fn blend(&self, other: &SplitIrradiance, share: f64) -> SplitIrradiance {
        SplitIrradiance {
            direct: self.direct.blend(&other.direct, share),
            indirect: self.indirect.blend(&other.indirect, share),
        }
    }
}

/// Direct irradiance of one point, W/m².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DirectLight {
    /// From lamps, one estimate per replicate.
    pub lamps: Gathered,
    /// From lights without area, exact.
    pub lights: Rgb,
    /// From environments and suns, one estimate per replicate.
    pub outside: Gathered,
}

impl DirectLight {
    /// All together, one estimate per replicate.
    pub fn whole(&self) -> Gathered {
        let all = self.lamps.plus(&self.outside);
        Gathered {
            replicates: all.replicates.map(|e| e + self.lights),
        }
    }

    /// What no surface emits.
    pub fn external(&self) -> Rgb {
        self.lights + self.outside.mean()
    }
}
