//! Sample points: scrambled Sobol sequences, and the maps from the square to disks and
//! hemispheres.
//!
//! Every random number in azulejo is a function of its purpose (patch or pixel, sample index,
//! dimension), never of the order in which threads run.

use azulejo_scene::math::Frame;
use glam::DVec3;

/// Number of Sobol dimensions of [`sobol`].
pub const DIMENSIONS: usize = 8;

/// Direction numbers of the first eight dimensions, bit-reversed so that scrambling by
/// [`owen_scramble_reversed`] needs no reversal of its input.
///
/// Joe and Kuo, *Constructing Sobol sequences with better two-dimensional projections*, SIAM J.
/// Sci. Comput. 30, 2008: the table new-joe-kuo-6, first eight rows.
static DIRECTIONS: [[u32; 32]; DIMENSIONS] = directions();

const fn directions() -> [[u32; 32]; DIMENSIONS] {
    // Degree s, coefficients a, initial numbers m of each primitive polynomial.
    const POLYNOMIALS: [(usize, u32, [u32; 5]); DIMENSIONS - 1] = [
        (1, 0, [1, 0, 0, 0, 0]),
        (2, 1, [1, 3, 0, 0, 0]),
        (3, 1, [1, 3, 1, 0, 0]),
        (3, 2, [1, 1, 1, 0, 0]),
        (4, 1, [1, 1, 3, 3, 0]),
        (4, 4, [1, 3, 5, 13, 0]),
        (5, 2, [1, 1, 5, 5, 17]),
    ];
    let mut table = [[0u32; 32]; DIMENSIONS];
    let mut k = 0;
    while k < 32 {
        table[0][k] = 1 << k; // van der Corput, reversed: bit k stays bit k
        k += 1;
    }
    let mut d = 1;
    while d < DIMENSIONS {
        let (s, a, m) = POLYNOMIALS[d - 1];
        let mut v = [0u32; 32];
        let mut i = 0;
        while i < 32 {
            if i < s {
                v[i] = m[i] << (31 - i);
            } else {
                v[i] = v[i - s] ^ (v[i - s] >> s);
                let mut j = 1;
                while j < s {
                    if (a >> (s - 1 - j)) & 1 == 1 {
                        v[i] ^= v[i - j];
                    }
                    j += 1;
                }
            }
            i += 1;
        }
        let mut i = 0;
        while i < 32 {
            table[d][i] = v[i].reverse_bits();
            i += 1;
        }
        d += 1;
    }
    table
}

/// The unscrambled Sobol integer with its bits reversed.
fn sobol_reversed(index: u32, dimension: usize) -> u32 {
    let (mut rest, mut x) = (index, 0);
    while rest != 0 {
        x ^= DIRECTIONS[dimension][rest.trailing_zeros() as usize];
        rest &= rest - 1;
    }
    x
}

/// Owen scrambling by hashing, of a bit-reversed integer, to a number in 0..1.
///
/// Laine and Karras 2011 as improved by Burley, *Practical Hash-based Owen Scrambling*, JCGT 9(4),
/// 2020: each bit is flipped by a hash of the more significant ones.
fn owen_scramble_reversed(reversed: u32, seed: u32) -> f32 {
    let mut x = reversed ^ reversed.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    unit_f32(x.reverse_bits())
}

/// The upper 24 bits as a number in 0..1.
fn unit_f32(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// Coordinate `dimension` (0..8) of point `index` of the Sobol sequence, Owen-scrambled by
/// `seed`; in 0..1, never 1.
///
/// Points of equal `seed` in all dimensions form one scrambled sequence; give each dimension
/// its own seed (for example by [`hash`]) for Owen's independence between dimensions.
///
/// # Panics
/// If `dimension` is 8 or more.
pub fn sobol(index: u32, dimension: usize, seed: u32) -> f32 {
    owen_scramble_reversed(sobol_reversed(index, dimension), seed)
}

/// The first points of the 4-D Sobol sequence, precomputed so that each use pays for scrambling
/// only.
#[derive(Clone, Debug)]
pub struct SobolTable {
    reversed: Vec<[u32; 4]>,
}

impl SobolTable {
    /// Points 0 to `count` − 1.
    pub fn new(count: usize) -> SobolTable {
        let point = |i: usize| [0, 1, 2, 3].map(|d| sobol_reversed(i as u32, d));
        SobolTable {
            reversed: (0..count).map(point).collect(),
        }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.reversed.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.reversed.is_empty()
    }

    /// Point `index` under the scrambling `seeds`.
    pub fn point(&self, index: usize, seeds: [u32; 4]) -> [f32; 4] {
        let p = self.reversed[index];
        [0, 1, 2, 3].map(|d| owen_scramble_reversed(p[d], seeds[d]))
    }
}

/// A well-mixed 32-bit hash of several words, for seeds.
///
/// The mixing is that of Jarzynski and Olano, *Hash Functions for GPU Rendering*, JCGT 9(3),
/// 2020 (PCG output permutation), chained.
pub fn hash(words: &[u32]) -> u32 {
    words.iter().fold(0x9e37_79b9, |h, &w| {
        let state = (h ^ w)
            .wrapping_mul(747_796_405)
            .wrapping_add(2_891_336_453);
        let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
        (word >> 22) ^ word
    })
}

/// Independent scrambling seeds for four dimensions, from words that identify their use.
pub fn seeds(words: &[u32]) -> [u32; 4] {
    let h = hash(words);
    [0, 1, 2, 3].map(|d| hash(&[h, d]))
}

/// A number in 0..1 from a hash of several words, for choices that need no stratification.
pub fn uniform(words: &[u32]) -> f32 {
    unit_f32(hash(words))
}

/// Maps the unit square to the unit disk, preserving areas and adjacency.
///
/// Shirley and Chiu, *A Low Distortion Map Between Disk and Square*, JGT 2(3), 1997.
pub fn concentric_disk(u1: f64, u2: f64) -> (f64, f64) {
    use std::f64::consts::FRAC_PI_4;
    let (a, b) = (2.0 * u1 - 1.0, 2.0 * u2 - 1.0);
    if a == 0.0 && b == 0.0 {
        return (0.0, 0.0);
    }
    if a.abs() > b.abs() {
        let (sin, cos) = sin_cos_quarter(FRAC_PI_4 * (b / a));
        (a * cos, a * sin)
    } else {
        let (sin, cos) = sin_cos_quarter(FRAC_PI_4 * (a / b));
        (b * sin, b * cos)
    }
}

/// Sine and cosine of an angle of at most π/4, to 1e-11: Taylor's series, several times faster
/// than the library's, which must reduce the angle first. Without divisions, which compilers keep.
fn sin_cos_quarter(x: f64) -> (f64, f64) {
    const SIN: [f64; 6] = [
        1.0,
        -1.0 / 6.0,
        1.0 / 120.0,
        -1.0 / 5_040.0,
        1.0 / 362_880.0,
        -1.0 / 39_916_800.0,
    ];
    const COS: [f64; 7] = [
        1.0,
        -1.0 / 2.0,
        1.0 / 24.0,
        -1.0 / 720.0,
        1.0 / 40_320.0,
        -1.0 / 3_628_800.0,
        1.0 / 479_001_600.0,
    ];
    let y = x * x;
    let series = |terms: &[f64]| terms.iter().rev().fold(0.0, |sum, term| sum * y + term);
    (x * series(&SIN), series(&COS))
}

/// Samples a direction about +z with density cos θ/π (Malley's method).
pub fn cosine_hemisphere(u1: f64, u2: f64) -> DVec3 {
    let (x, y) = concentric_disk(u1, u2);
    DVec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt())
}

/// Samples a direction with even density over the sphere.
pub fn uniform_sphere(u1: f64, u2: f64) -> DVec3 {
    let z = 1.0 - 2.0 * u1;
    let (sin, cos) = (std::f64::consts::TAU * u2).sin_cos();
    let r = (1.0 - z * z).max(0.0).sqrt();
    DVec3::new(r * cos, r * sin, z)
}

/// Samples a direction about the unit normal of `frame` with density cos θ/π.
pub fn cosine_about(frame: &Frame, u1: f64, u2: f64) -> DVec3 {
    frame.to_world(cosine_hemisphere(u1, u2))
}

/// The sums of values up to each.
pub(crate) fn cumulative_sums(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sum = 0.0;
    let up_to = |value| {
        sum += value;
        sum
    };
    values.map(up_to).collect()
}

/// The index that `u` in 0..1 chooses in proportion to values with these cumulative sums, and its probability; `None`
/// if all of them are 0.
pub(crate) fn sample_discrete(cumulative: &[f64], u: f64) -> Option<(usize, f64)> {
    let sum = *cumulative.last().filter(|&&sum| sum > 0.0)?;
    let chosen = cumulative.partition_point(|&end| end <= u * sum);
    let chosen = chosen.min(cumulative.len() - 1);
    let before = chosen.checked_sub(1).map_or(0.0, |k| cumulative[k]);
    Some((chosen, (cumulative[chosen] - before) / sum))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every elementary interval of area 1/n holds one of n points: the net property, which
    /// scrambling must keep.
    fn check_net(first: usize, second: usize, log_n: u32) {
        let n = 1u32 << log_n;
        for columns in 0..=log_n {
            let (nx, ny) = (1u32 << columns, 1u32 << (log_n - columns));
            let mut seen = vec![false; n as usize];
            for i in 0..n {
                let x = (sobol(i, first, 77) * nx as f32) as u32;
                let y = (sobol(i, second, 991) * ny as f32) as u32;
                seen[(y * nx + x) as usize] = true;
            }
            assert!(
                seen.iter().all(|&s| s),
                "dimensions {first} and {second}, {nx}×{ny}"
            );
        }
    }

    #[test]
    fn the_first_two_dimensions_are_a_net() {
        check_net(0, 1, 10);
    }

    #[test]
    fn every_dimension_is_stratified() {
        for d in 0..DIMENSIONS {
            for seed in [0, 1, 0xdead_beef] {
                let mut seen = [false; 1024];
                (0..1024).for_each(|i| seen[(sobol(i, d, seed) * 1024.0) as usize] = true);
                assert!(seen.iter().all(|&s| s), "dimension {d}, seed {seed}");
            }
        }
    }

    #[test]
    fn the_table_holds_the_sequence() {
        let table = SobolTable::new(300);
        let seeds = seeds(&[1, 2, 3]);
        for i in [0, 1, 7, 299] {
            assert_eq!(
                table.point(i, seeds),
                [0, 1, 2, 3].map(|d| sobol(i as u32, d, seeds[d]))
            );
        }
    }

    #[test]
    fn scrambled_sobol_integrates_better_than_random() {
        // The smooth integrand Π (12 (x − ½)²) has mean 1.
        let n = 4096;
        let f = |i: u32, seed: u32| {
            (0..4)
                .map(|d| 12.0 * (f64::from(sobol(i, d, hash(&[seed, d as u32]))) - 0.5).powi(2))
                .product::<f64>()
        };
        let rms = (0..32)
            .map(|s| ((0..n).map(|i| f(i, s)).sum::<f64>() / f64::from(n) - 1.0).powi(2))
            .sum::<f64>()
            / 32.0;
        let random_rms = (1.8f64.powi(4) - 1.0) / f64::from(n);
        assert!(rms < random_rms / 16.0, "{rms:e} against {random_rms:e}");
    }

    #[test]
    fn quarter_sines() {
        for k in -8..=8 {
            let x = f64::from(k) / 8.0 * std::f64::consts::FRAC_PI_4;
            let (sin, cos) = sin_cos_quarter(x);
            assert!(
                (sin - x.sin()).abs() < 1e-11 && (cos - x.cos()).abs() < 1e-11,
                "{x}"
            );
        }
    }

    #[test]
    fn cosine_hemisphere_has_its_moments() {
        let n = 1 << 14;
        let mean: DVec3 = (0..n)
            .map(|i| cosine_hemisphere(f64::from(sobol(i, 0, 3)), f64::from(sobol(i, 1, 4))))
            .sum::<DVec3>()
            / f64::from(n);
        assert!(
            (mean - DVec3::new(0.0, 0.0, 2.0 / 3.0)).length() < 1e-3,
            "{mean}"
        );
    }
}
