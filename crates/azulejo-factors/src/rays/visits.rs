//! What single paths bring to sides by mirrors and glass, for the variance of their sums.

use crate::row::{Entries, Order, RowAccumulator, Side};
use azulejo_scene::Rgb;
use std::collections::BTreeMap;

/// How many paths like the one that brought most to a side count besides those that there were. Between facing
/// mirrors a few of many paths return hundreds of times, and most samples have none of these.
const UNSEEN: f64 = 1.0;

/// Visits of the paths of a batch, and what their squares add up to.
pub(crate) struct Visits {
    /// In the order of each path.
    list: Vec<Visit>,
    excess: RowAccumulator,
    /// Of each side, the order and the excess of the path that brought most.
    largest: BTreeMap<Side, (Order, f64)>,
}

/// A path reaches a side.
#[derive(Clone, Copy)]
struct Visit {
    path: u32,
    side: Side,
    /// Its place in the list.
    number: u32,
    order: Order,
    weight: f64,
}

impl Visits {
    /// None, to this many sides.
    pub fn new(sides: usize) -> Visits {
        Visits {
            list: Vec::new(),
            excess: RowAccumulator::new(sides),
            largest: BTreeMap::new(),
        }
    }

    /// Path `path` brings `weight` to a side.
    pub fn add(&mut self, path: u32, side: Side, order: Order, weight: f64) {
        self.list.push(Visit {
            path,
            side,
            number: self.list.len() as u32,
            order,
            weight,
        });
    }

    /// Ends a batch of paths that began with weight `share` each.
    ///
    /// A visit adds (k + w)² − k² − w `share` to the order that it has, where k is what the path brought to that
    /// side by mirrors and glass before, and 2dw to order 0 where d came directly.
    pub fn end(&mut self, share: f64) {
        self.list
            .sort_unstable_by_key(|visit| (visit.side, visit.path, visit.number));
        let is_same = |a: &Visit, b: &Visit| (a.side, a.path) == (b.side, b.path);
        for visits in self.list.chunk_by(is_same) {
            let (mut direct, mut before) = (0.0, 0.0);
            let (side, last) = (visits[0].side, visits[visits.len() - 1].order);
            for &Visit { order, weight, .. } in visits {
                if order == 0 {
                    direct += weight;
                    continue;
                }
                let own = weight * (2.0 * before + weight - share);
                self.excess.add(side, order, Rgb::grey(own));
                if direct > 0.0 {
                    let common = 2.0 * direct * weight;
                    self.excess.add(side, 0, Rgb::grey(common));
                }
                before += weight;
            }
            let own = before * (before - share);
            let largest = self.largest.entry(side).or_insert((last, 0.0));
            if own > largest.1 {
                *largest = (last, own);
            }
        }
        self.list.clear();
    }

    /// The sums, sorted by side and order; empties them.
    pub fn take(&mut self) -> Entries {
        for (side, (order, own)) in std::mem::take(&mut self.largest) {
            if own > 0.0 {
                self.excess.add(side, order, Rgb::grey(UNSEEN * own));
            }
        }
        self.excess.take()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two of four paths reach a side, one of them three times.
    #[test]
    fn squares_of_paths_are_more_than_those_of_visits() {
        let mut visits = Visits::new(4);
        for (path, order) in [(0, 0), (1, 1), (0, 1), (0, 2)] {
            visits.add(path, 3, order, 0.25);
        }
        visits.end(0.25);
        let entries = visits.take();
        let of = |order: Order| {
            let entry = entries.iter().find(|e| (e.side, e.order) == (3, order));
            entry.map_or(0.0, |e| e.weight.g)
        };
        // In units of 1/16: a path that comes directly and returns twice has 9 instead of 3, of which 2 are of
        // its later visits and 4 of what these have in common with the first. It also stands for others.
        let expected = [4.0, 0.0, 2.0 + 2.0 * UNSEEN];
        assert_eq!([of(0), of(1), of(2)].map(|x| 16.0 * x), expected);
        assert!(visits.take().is_empty());
    }

    /// A path of more weight counts with its square, one of less with less than itself.
    #[test]
    fn weights_are_squared() {
        let check = |weight: f64, expected: f64| {
            let mut visits = Visits::new(2);
            visits.add(7, 1, 2, weight);
            visits.end(0.5);
            assert_eq!(visits.take()[0].weight.g, expected);
        };
        check(1.0, 0.5 * (1.0 + UNSEEN));
        check(0.25, -0.0625);
    }
}
