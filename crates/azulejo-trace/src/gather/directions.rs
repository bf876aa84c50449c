//! Directions over the hemisphere, made once for all points of a gather.

use super::{GatherOptions, REPLICATES};
use crate::sampling::{cosine_hemisphere, seeds, sobol};
use std::ops::Range;
use std::sync::OnceLock;

/// Cosine-distributed directions about +z, in several scramblings of one stretch of the Sobol
/// sequence. A point takes one of them, rotated about its normal by its own angle: as well
/// stratified as its own scrambling, and several times cheaper. Tables are made when a point first takes
/// them: a process that gathers at few of the points needs few.
pub struct DirectionTables {
    /// Directions per replicate.
    pub(super) count: usize,
    /// Indices of the directions in the sequence.
    indices: Range<u32>,
    seed: u32,
    tables: [OnceLock<Vec<[f32; 3]>>; TABLES],
}

/// Scramblings to choose from.
const TABLES: usize = 32;

impl DirectionTables {
    /// The directions that a gather with these options takes.
    pub fn new(options: &GatherOptions) -> DirectionTables {
        let count = options.per_replicate();
        DirectionTables {
            count: count as usize,
            indices: options.spent..options.spent + count * REPLICATES as u32,
            seed: options.seed,
            tables: [const { OnceLock::new() }; TABLES],
        }
    }

    /// One table: a stretch of directions for each replicate, one after the other.
    pub(super) fn table(&self, choice: u32) -> &[[f32; 3]] {
        let table = choice % TABLES as u32;
        self.tables[table as usize].get_or_init(|| {
            let [s1, s2, ..] = seeds(&[self.seed, table, 0x9a7]);
            let direction = |k: u32| {
                let d = cosine_hemisphere(sobol(k, 0, s1).into(), sobol(k, 1, s2).into());
                d.as_vec3().to_array()
            };
            self.indices.clone().map(direction).collect()
        })
    }
}
