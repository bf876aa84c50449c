//! Directions over the hemisphere, made once for all points of a gather.

use super::{GatherOptions, REPLICATES};
use crate::sampling::{cosine_hemisphere, seeds, sobol};

/// Cosine-distributed directions about +z, in several scramblings of one stretch of the Sobol
/// sequence. A point takes one of them, rotated about its normal by its own angle: as well
/// stratified as its own scrambling, and several times cheaper.
pub struct DirectionTables {
    /// Directions per replicate.
    pub(super) count: usize,
    directions: Vec<[f32; 3]>,
}

/// Scramblings to choose from.
const TABLES: u32 = 32;

impl DirectionTables {
    /// The directions that a gather with these options takes.
    pub fn new(options: &GatherOptions) -> DirectionTables {
        let count = options.per_replicate();
        let indices = options.spent..options.spent + count * REPLICATES as u32;
        let mut directions = Vec::with_capacity(TABLES as usize * indices.len());
        for table in 0..TABLES {
            let [s1, s2, ..] = seeds(&[options.seed, table, 0x9a7]);
            for k in indices.clone() {
                let d = cosine_hemisphere(sobol(k, 0, s1).into(), sobol(k, 1, s2).into());
                directions.push(d.as_vec3().to_array());
            }
        }
        DirectionTables {
            count: count as usize,
            directions,
        }
    }

    /// One table: a stretch of directions for each replicate, one after the other.
    pub(super) fn table(&self, choice: u32) -> &[[f32; 3]] {
        let all = self.count * REPLICATES;
        let start = (choice % TABLES) as usize * all;
        &self.directions[start..start + all]
    }
}
