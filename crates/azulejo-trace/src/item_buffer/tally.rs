//! Adds up the form factors of pixels by the side that they show.

use super::Share;
use azulejo_scene::Rgb;

/// Number of orders that are distinguished: no mirror, one mirror, more.
const ORDERS: usize = 3;
const FREE: u32 = u32::MAX;

/// Sums by side and order, in `f64`, in the order in which they are added.
pub(super) struct Tally {
    /// For each side and order, the index of its sum.
    slots: Vec<u32>,
    keys: Vec<u32>,
    sums: Vec<Rgb>,
}

impl Tally {
    pub fn new(patches: u32) -> Tally {
        Tally {
            slots: vec![FREE; 2 * patches as usize * ORDERS],
            keys: Vec::new(),
            sums: Vec::new(),
        }
    }

    pub fn add(&mut self, side: u32, order: u8, share: Rgb) {
        let key = side * ORDERS as u32 + u32::from(order);
        let slot = &mut self.slots[key as usize];
        if *slot == FREE {
            *slot = self.sums.len() as u32;
            self.keys.push(key);
            self.sums.push(Rgb::BLACK);
        }
        self.sums[*slot as usize] += share;
    }

    /// Takes the sums, sorted by side and order.
    pub fn take(&mut self) -> Vec<Share> {
        self.keys.sort_unstable();
        let share = |&key: &u32| {
            let slot = std::mem::replace(&mut self.slots[key as usize], FREE);
            Share {
                side: key / ORDERS as u32,
                order: (key % ORDERS as u32) as u8,
                weight: self.sums[slot as usize],
            }
        };
        let shares = self.keys.iter().map(share).collect();
        self.keys.clear();
        self.sums.clear();
        shares
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_sorted_and_start_anew() {
        let mut tally = Tally::new(3);
        for _round in 0..2 {
            tally.add(5, 0, Rgb::grey(0.25));
            tally.add(2, 1, Rgb::new(1.0, 0.0, 0.0));
            tally.add(5, 0, Rgb::grey(0.5));
            tally.add(2, 0, Rgb::WHITE);
            let sums: Vec<_> = tally
                .take()
                .iter()
                .map(|s| (s.side, s.order, s.weight))
                .collect();
            let expected = [
                (2, 0, Rgb::WHITE),
                (2, 1, Rgb::new(1.0, 0.0, 0.0)),
                (5, 0, Rgb::grey(0.75)),
            ];
            assert_eq!(sums, expected);
        }
        assert!(tally.take().is_empty());
    }
}
