//! Rows of extended form factors: what one side of a patch sees.

use azulejo_scene::Rgb;
use azulejo_trace::REPLICATES;
use azulejo_trace::follow::{Path, Via};

/// One side of a patch p: 2p for the front, 2p + 1 for the back.
pub type Side = u32;

/// The front or the back of `patch`.
pub fn side(patch: u32, front: bool) -> Side {
    2 * patch + u32::from(!front)
}

/// Number of orders that entries distinguish.
pub const ORDERS: usize = 3;

/// Path class of light: 0 direct, 1 by one mirror, 2 by more mirrors or through glass.
pub type Order = u8;

/// The order of a path.
pub fn order(path: &Path) -> Order {
    match path.via {
        _ if path.passed_pane => 2,
        Via::Direct => 0,
        Via::Mirror(_) => 1,
        Via::Many => 2,
    }
}

/// An extended form factor to one side, for one order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// The side where the light arrives.
    pub side: Side,
    /// The path class.
    pub order: Order,
    /// Form factor, per channel.
    pub weight: Rgb,
}

/// Entries of one replicate of a row, sorted by side and order, each pair once.
pub type Entries = Vec<Entry>;

/// The row of one side of a patch, as an estimator computed it.
#[derive(Clone, Debug, Default)]
pub struct Row {
    /// Per replicate, the extended form factor to each side that was reached.
    pub entries: [Entries; REPLICATES],
    /// Per replicate, Σ k² − k/N over its N paths for each side and order, with what a path brings there, k: the
    /// variance beyond that of paths which arrive whole or not at all, with some for the path that brings most.
    /// Mirrors show a side to one path several times, and leaving glass gives a path more weight. Of order 0 it is
    /// what the direct light of paths has in common with the rest. Empty where light is direct, and in rows by item
    /// buffers.
    pub excess: [Entries; REPLICATES],
    /// Per replicate, irradiance from emission and surroundings found along the paths that direct
    /// lighting does not count, W/m².
    pub stray: [Rgb; REPLICATES],
    /// The part of `stray` that came from the surroundings.
    pub external: Rgb,
    /// Share absorbed by surfaces.
    pub absorbed: Rgb,
    /// Per replicate, the share that left the scene, upwards and downwards.
    pub escaped: [[Rgb; 2]; REPLICATES],
    /// Share of paths that were cut off as too weak or too long.
    pub cut: Rgb,
    /// Rays traced, or pixels rendered, from the patch, without those added by mirrors.
    pub rays: u32,
}

impl Row {
    /// The row of parts that have its replicates, each of them one or several.
    pub(crate) fn from_parts(mut parts: impl Iterator<Item = Row>) -> Row {
        let first = parts.next().unwrap_or_default();
        parts.fold(first, Row::with_replicates)
    }

    /// This row with the replicates of another part.
    fn with_replicates(mut self, part: Row) -> Row {
        for (replicate, entries) in part.entries.into_iter().enumerate() {
            if !entries.is_empty() {
                self.entries[replicate] = entries;
            }
            self.stray[replicate] += part.stray[replicate];
            let escaped = self.escaped[replicate].iter_mut();
            escaped
                .zip(part.escaped[replicate])
                .for_each(|(sum, more)| *sum += more);
        }
        for (own, excess) in self.excess.iter_mut().zip(part.excess) {
            if !excess.is_empty() {
                *own = excess;
            }
        }
        self.external += part.external;
        self.absorbed += part.absorbed;
        self.cut += part.cut;
        self
    }

    /// Share that left the scene in either direction, mean of the replicates.
    pub fn all_escaped(&self) -> Rgb {
        let ways = self.escaped.iter().flatten();
        ways.fold(Rgb::BLACK, |sum, &way| sum + way) * (1.0 / REPLICATES as f64)
    }
}

/// Which sides of patches a row keeps as columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Columns {
    /// All that are reached, mirrors included: complete rows, whose shares add up.
    All,
    /// Only sides that reflect diffusely: what a solver needs.
    Diffuse,
}

/// Accumulates what rays or pixels find on sides, in `f64`, in the order of arrival.
///
/// A table by side and order points to each sum, so that only the sums are sorted. Kept between
/// rows to save allocations: 24 bytes per patch.
pub struct RowAccumulator {
    /// For each side and order the index into `entries`, or [`NOWHERE`].
    places: Vec<u32>,
    entries: Vec<Entry>,
}

const NOWHERE: u32 = u32::MAX;

impl RowAccumulator {
    /// An empty accumulator over this many sides.
    pub fn new(sides: usize) -> RowAccumulator {
        RowAccumulator {
            places: vec![NOWHERE; sides * ORDERS],
            entries: Vec::new(),
        }
    }

    /// Adds `weight` to what arrived at `side` by `order`.
    pub fn add(&mut self, side: Side, order: Order, weight: Rgb) {
        let place = &mut self.places[key(side, order)];
        match self.entries.get_mut(*place as usize) {
            Some(sum) => sum.weight += weight,
            None => {
                *place = self.entries.len() as u32;
                self.entries.push(Entry {
                    side,
                    order,
                    weight,
                });
            }
        }
    }

    /// The sums, sorted by side and order; empties the accumulator.
    pub fn take(&mut self) -> Entries {
        for sum in &self.entries {
            self.places[key(sum.side, sum.order)] = NOWHERE;
        }
        self.entries.sort_unstable_by_key(|e| key(e.side, e.order));
        // A copy of the exact size: thousands of rows are kept.
        let sums = self.entries.clone();
        self.entries.clear();
        sums
    }
}

fn key(side: Side, order: Order) -> usize {
    side as usize * ORDERS + usize::from(order)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tally_sorts_sums_and_starts_anew() {
        let mut sums = RowAccumulator::new(4);
        for (side, order, weight) in [(3, 1, 0.25), (0, 2, 0.5), (3, 1, 0.125), (3, 0, 1.0)] {
            sums.add(side, order, Rgb::grey(weight));
        }
        let entries: Vec<(Side, Order, f64)> = sums
            .take()
            .iter()
            .map(|e| (e.side, e.order, e.weight.g))
            .collect();
        assert_eq!(entries, [(0, 2, 0.5), (3, 0, 1.0), (3, 1, 0.375)]);
        assert!(sums.take().is_empty());
        sums.add(3, 1, Rgb::WHITE);
        assert_eq!(sums.take()[0].weight, Rgb::WHITE);
    }
}
