//! Merging of equal positions, for formats that repeat every position.

use glam::DVec3;
use std::hash::{BuildHasher, RandomState};

/// Collects positions, each once, in the order in which they first appear.
///
/// The hash is keyed anew for every file, so that no file can be made to collide. It affects
/// only the running time.
#[derive(Debug)]
pub(crate) struct Welder {
    pub positions: Vec<DVec3>,
    /// Index into `positions` plus one, 0 for a free slot; the length is a power of two.
    table: Vec<u32>,
    /// Odd key of the hash, random for every file.
    key: u64,
}

impl Welder {
    /// A welder with room for about `expected` positions.
    pub fn new(expected: usize) -> Welder {
        Welder {
            positions: Vec::with_capacity(expected),
            table: vec![0; (2 * expected).max(16).next_power_of_two()],
            key: RandomState::new().hash_one(0) | 1,
        }
    }

    /// The index of a position, which is added if it is new. −0 and 0 are equal.
    #[inline]
    pub fn index(&mut self, position: DVec3) -> u32 {
        // Adding zero makes 0 of −0.
        let position = position + DVec3::ZERO;
        let mut slot = self.slot(position);
        loop {
            match self.table[slot] {
                0 => return self.add(position, slot),
                // Bits and not values are compared, so that the search ends for NaN, too.
                known if bits(self.positions[known as usize - 1]) == bits(position) => {
                    return known - 1;
                }
                _ => slot = (slot + 1) & (self.table.len() - 1),
            }
        }
    }

    #[inline]
    fn slot(&self, position: DVec3) -> usize {
        let mixed = bits(position).iter().fold(self.key, |hash, word| {
            (hash ^ word).wrapping_mul(self.key).rotate_left(29)
        });
        let mixed = mixed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (mixed >> (64 - self.table.len().trailing_zeros())) as usize
    }

    #[inline]
    fn add(&mut self, position: DVec3, slot: usize) -> u32 {
        self.positions.push(position);
        self.table[slot] = self.positions.len() as u32;
        if 2 * self.positions.len() > self.table.len() {
            self.grow();
        }
        (self.positions.len() - 1) as u32
    }

    #[cold]
    fn grow(&mut self) {
        self.table = vec![0; 2 * self.table.len()];
        for index in 0..self.positions.len() {
            let mut slot = self.slot(self.positions[index]);
            while self.table[slot] != 0 {
                slot = (slot + 1) & (self.table.len() - 1);
            }
            self.table[slot] = index as u32 + 1;
        }
    }
}

#[inline]
fn bits(position: DVec3) -> [u64; 3] {
    position.to_array().map(f64::to_bits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_positions_are_one() {
        let mut welder = Welder::new(0);
        assert_eq!(welder.index(DVec3::ZERO), 0);
        assert_eq!(welder.index(DVec3::X), 1);
        assert_eq!(welder.index(-DVec3::ZERO), 0);
        assert_eq!(welder.index(DVec3::NAN), 2);
        assert_eq!(welder.index(DVec3::NAN), 2);
        for i in 0..1000 {
            assert_eq!(welder.index(DVec3::splat(f64::from(i + 2))), 3 + i as u32);
        }
        assert_eq!(welder.index(DVec3::splat(501.0)), 502);
        assert_eq!(welder.positions.len(), 1003);
    }
}
