//! Charts that fold over an edge at which they should end, because they reach both of its sides by another way.
//!
//! A crease that fades out within a surface cuts no chart in two: the unwrapper leaves both sides where they meet, and
//! the bilinear filter of a viewer mixes their light. Such charts are divided so that no part has both sides.

use crate::layout::NO_CHART;
use crate::seams::EdgePair;
use std::collections::VecDeque;

/// The triangles around each, in one list.
struct Around {
    starts: Vec<u32>,
    list: Vec<u32>,
}

impl Around {
    fn new(count: usize, pairs: &[[u32; 2]]) -> Around {
        let mut starts = vec![0; count + 1];
        for triangle in pairs.iter().flatten() {
            starts[*triangle as usize + 1] += 1;
        }
        for t in 0..count {
            starts[t + 1] += starts[t];
        }
        let mut next = starts.clone();
        let mut list = vec![0; 2 * pairs.len()];
        for &[a, b] in pairs {
            for (of, other) in [(a, b), (b, a)] {
                list[next[of as usize] as usize] = other;
                next[of as usize] += 1;
            }
        }
        Around { starts, list }
    }

    fn of(&self, triangle: u32) -> &[u32] {
        let [from, to] = [0, 1].map(|k| self.starts[triangle as usize + k] as usize);
        &self.list[from..to]
    }
}

/// Whether a pair of triangles of one chart meets at an edge that charts must not cross.
pub(crate) fn has_folds(pairs: &[EdgePair], seams: &[[bool; 3]], charts: &[u32]) -> bool {
    pairs.iter().any(|pair| is_fold(pair, seams, charts))
}

fn is_fold(pair: &EdgePair, seams: &[[bool; 3]], charts: &[u32]) -> bool {
    is_in_chart(pair, charts) && is_seam(pair, seams)
}

fn is_seam(pair: &EdgePair, seams: &[[bool; 3]]) -> bool {
    let mut sides = pair.sides.into_iter();
    sides.any(|(t, corner)| seams[t as usize][usize::from(corner)])
}

fn is_in_chart(pair: &EdgePair, charts: &[u32]) -> bool {
    let [a, b] = pair.sides.map(|(t, _)| charts[t as usize]);
    a == b && a != NO_CHART
}

/// Divides charts into regions without folds, numbered from 0; charts without any are one region each. Triangles
/// without chart have number 0.
pub(crate) fn regions(pairs: &[EdgePair], seams: &[[bool; 3]], charts: &[u32]) -> Vec<u32> {
    let (mut joined, mut apart) = (Vec::new(), Vec::new());
    for pair in pairs.iter().filter(|pair| is_in_chart(pair, charts)) {
        let triangles = pair.sides.map(|(t, _)| t);
        if is_seam(pair, seams) {
            apart.push(triangles);
        } else {
            joined.push(triangles);
        }
    }
    let joined = Around::new(charts.len(), &joined);
    let apart = Around::new(charts.len(), &apart);
    let mut regions = vec![NO_CHART; charts.len()];
    let mut count = 0;
    let mut queue = VecDeque::new();
    for seed in 0..charts.len() as u32 {
        if regions[seed as usize] != NO_CHART || charts[seed as usize] == NO_CHART {
            continue;
        }
        queue.push_back(seed);
        while let Some(triangle) = queue.pop_front() {
            let folds = apart.of(triangle).iter();
            let is_free = regions[triangle as usize] == NO_CHART;
            if !is_free || folds.clone().any(|&f| regions[f as usize] == count) {
                continue;
            }
            regions[triangle as usize] = count;
            queue.extend(joined.of(triangle));
        }
        count += 1;
    }
    for region in regions.iter_mut().filter(|r| **r == NO_CHART) {
        *region = 0;
    }
    regions
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ring of triangles with a seam between the first and the last: the ring is opened there, in two regions.
    #[test]
    fn a_ring_with_a_seam_is_divided() {
        let count = 8;
        let pair = |a: u32| EdgePair {
            sides: [(a, 1), ((a + 1) % count, 0)],
            is_twisted: false,
            is_shared_by_more: false,
        };
        let pairs: Vec<EdgePair> = (0..count).map(pair).collect();
        let mut seams = vec![[false; 3]; count as usize];
        let charts = vec![5; count as usize];
        assert!(!has_folds(&pairs, &seams, &charts));
        assert_eq!(regions(&pairs, &seams, &charts), vec![0; 8]);
        seams[0][0] = true;
        assert!(has_folds(&pairs, &seams, &charts));
        let numbers = regions(&pairs, &seams, &charts);
        assert_ne!(numbers[0], numbers[7]);
        assert!(numbers.iter().all(|r| *r < 2), "{numbers:?}");
        let none = vec![NO_CHART; count as usize];
        assert!(!has_folds(&pairs, &seams, &none));
        assert_eq!(regions(&pairs, &seams, &none), vec![0; 8]);
    }
}
