//! Reproducible random numbers for synthetic scenes, checks and tests.

/// The next number of a SplitMix64 sequence, uniform in 0..1; advances `state`, whose first value
/// is the seed.
///
/// Steele, Lea and Flood, *Fast splittable pseudorandom number generators*, 2014.
pub fn split_mix64(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    (mixed(*state) >> 11) as f64 / (1u64 << 53) as f64
}

/// The finalizer of SplitMix64: a number whose bits each depend on all bits of `z`.
pub(crate) fn mixed(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
