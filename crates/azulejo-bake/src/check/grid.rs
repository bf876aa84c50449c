//! Which boxes are near one another: squares of all sizes, each box in one that is no smaller.
//!
//! A box looks only into squares of its own size and larger ones, so that a floor is not compared with all
//! pebbles in its bounds from both sides.

use glam::DVec2;

/// Powers of two that squares are between, texels.
const LEVELS: [i32; 2] = [-24, 26];

/// Boxes that are looked at for all together, at most, and for each of them, at least and at most.
const MOST_LOOKS: usize = 1 << 29;
const LOOKS_EACH: [usize; 2] = [1024, 1 << 20];

/// A box on a page, texels.
#[derive(Clone, Copy, Debug)]
pub(super) struct PageBox {
    pub page: u32,
    pub low: DVec2,
    pub high: DVec2,
}

impl PageBox {
    /// The box around points.
    pub fn around(page: u32, points: &[DVec2]) -> PageBox {
        let around = PageBox {
            page,
            low: DVec2::INFINITY,
            high: DVec2::NEG_INFINITY,
        };
        points.iter().fold(around, |b, &p| PageBox {
            low: b.low.min(p),
            high: b.high.max(p),
            ..b
        })
    }

    fn is_near(&self, other: &PageBox, reach: f64) -> bool {
        (self.low - reach).cmple(other.high).all() && (other.low - reach).cmple(self.high).all()
    }
}

/// A square that boxes begin in: page, level, row and column.
type Square = (u32, i32, i64, i64);

/// Boxes by the squares that they begin in.
pub(super) struct BoxGrid {
    boxes: Vec<PageBox>,
    entries: Vec<(Square, u32)>,
    /// Pages and levels that have entries.
    levels: Vec<(u32, i32)>,
    reach: f64,
    most_looks: usize,
}

impl BoxGrid {
    /// A grid to find boxes that are no more than `reach` apart.
    pub fn new(boxes: Vec<PageBox>, reach: f64) -> BoxGrid {
        let mut grid = BoxGrid {
            entries: Vec::new(),
            levels: Vec::new(),
            reach,
            most_looks: (MOST_LOOKS / boxes.len().max(1)).clamp(LOOKS_EACH[0], LOOKS_EACH[1]),
            boxes,
        };
        let mut entries: Vec<(Square, u32)> = (0..grid.boxes.len() as u32)
            .map(|b| {
                let (of, level) = (&grid.boxes[b as usize], grid.level(b));
                let [row, column] = [of.low.y, of.low.x].map(|x| square(x, level));
                ((of.page, level, row, column), b)
            })
            .collect();
        entries.sort_unstable();
        grid.levels = entries.iter().map(|((p, l, ..), _)| (*p, *l)).collect();
        grid.levels.dedup();
        grid.entries = entries;
        grid
    }

    /// The size of squares that a box is put into.
    fn level(&self, of: u32) -> i32 {
        let of = &self.boxes[of as usize];
        let extent = (of.high - of.low).max_element().max(self.reach);
        (extent.log2().ceil() as i32).clamp(LEVELS[0], LEVELS[1])
    }

    /// Calls `each` with the boxes near one of them that are larger or come before it, until it returns false.
    /// Returns whether all were looked at.
    pub fn near(&self, of: u32, mut each: impl FnMut(u32) -> bool) -> bool {
        let (own, own_level) = (&self.boxes[of as usize], self.level(of));
        let mut looks = 0;
        let first = self.levels.partition_point(|l| *l < (own.page, own_level));
        for &(_, level) in self.levels[first..].iter().take_while(|l| l.0 == own.page) {
            let size = f64::from(level).exp2();
            let low = own.low - self.reach - size;
            let high = own.high + self.reach;
            for row in square(low.y, level)..=square(high.y, level) {
                let [left, right] = [low.x, high.x].map(|x| square(x, level));
                let start = (own.page, level, row, left);
                let start = self.entries.partition_point(|(s, _)| *s < start);
                let end = (own.page, level, row, right);
                let in_row = self.entries[start..].iter();
                for &(_, other) in in_row.take_while(|(s, _)| *s <= end) {
                    looks += 1;
                    if looks > self.most_looks {
                        return false;
                    }
                    let is_first = level > own_level || other < of;
                    let is_near = own.is_near(&self.boxes[other as usize], self.reach);
                    if is_first && is_near && !each(other) {
                        return true;
                    }
                }
            }
        }
        true
    }
}

/// The square of this level that a coordinate lies in.
fn square(x: f64, level: i32) -> i64 {
    (x * f64::from(-level).exp2()).floor() as i64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boxes that all lie on one another.
    fn crowd(count: u32) -> BoxGrid {
        let boxed = |k: u32| {
            let low = DVec2::splat(f64::from(k) * 1e-6);
            PageBox::around(0, &[low, low + 1.0])
        };
        BoxGrid::new((0..count).map(boxed).collect(), 0.0)
    }

    /// Boxes looked at near all boxes of a grid, and whether those were all there are.
    fn looks(grid: &BoxGrid) -> (usize, bool) {
        let mut looks = 0;
        let mut is_complete = true;
        for of in 0..grid.boxes.len() as u32 {
            is_complete &= grid.near(of, |_| {
                looks += 1;
                true
            });
        }
        (looks, is_complete)
    }

    #[test]
    fn pairs_in_a_crowd_are_looked_at_up_to_a_limit() {
        let mut grid = crowd(1000);
        assert_eq!(looks(&grid), (1000 * 999 / 2, true));
        grid.most_looks = 100;
        let (few, is_complete) = looks(&grid);
        assert!(few <= 1000 * 100 && !is_complete, "{few}");
        // The more boxes, the fewer looks for each.
        for count in [100_000, 300_000] {
            let each = crowd(count).most_looks;
            assert!(
                each * count as usize <= MOST_LOOKS && each >= LOOKS_EACH[0],
                "{each}"
            );
        }
    }
}
