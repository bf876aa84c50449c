//! Disjoint sets of numbers.

/// Disjoint sets over 0..n, named by their smallest members.
pub(crate) struct DisjointSets(Vec<u32>);

impl DisjointSets {
    /// A set for each number below `n`.
    pub fn new(n: usize) -> DisjointSets {
        DisjointSets((0..n as u32).collect())
    }

    /// The smallest member of the set of `x`.
    pub fn find(&mut self, mut x: u32) -> u32 {
        while self.0[x as usize] != x {
            self.0[x as usize] = self.0[self.0[x as usize] as usize];
            x = self.0[x as usize];
        }
        x
    }

    /// Makes one set of those of `a` and `b`.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b) as usize] = a.min(b);
    }

    /// For each number the smallest member of its set.
    pub fn into_smallest(mut self) -> Vec<u32> {
        (0..self.0.len() as u32).map(|x| self.find(x)).collect()
    }
}
