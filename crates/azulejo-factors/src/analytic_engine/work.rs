//! How much work pairs are, counted and not timed, so that what depends on it does not depend on the
//! machine.

/// Kinds of work that take about the same time each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WorkKind {
    /// Visits of a pair of clusters or facets.
    Visit,
    /// Tests of an obstruction against the shaft between two clusters.
    Shaft,
    /// Values of the kernel between Gauss points.
    Kernel,
    /// Tests of an obstruction against the lines between two facets.
    Effect,
    /// Contour integrals.
    Contour,
    /// What a point of one facet sees of another.
    View,
    /// Pieces of such a view, cut at an obstruction.
    Cut,
    /// What a point sees past obstructions, for exact pairs, times the obstructions.
    ExactView,
    /// Shadow rays.
    Ray,
}

/// Number of kinds.
pub(crate) const KINDS: usize = 9;

/// Nanoseconds of each kind on one core: fitted to what thirteen rooms, streets and towns took.
const NANOSECONDS: [f64; KINDS] = [60.0, 200.0, 3.9, 60.0, 1_700.0, 120.0, 82.0, 500.0, 150.0];

/// Rows of a group of sixteen that share a visit of clusters, on average.
const TOGETHER: u64 = 4;

/// Counts by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct PairWork {
    /// By [`WorkKind`].
    pub counts: [u64; KINDS],
}

impl PairWork {
    pub fn count(&mut self, kind: WorkKind, number: usize) {
        self.counts[kind as usize] += number as u64;
    }

    pub fn add(&mut self, other: &PairWork) {
        let pairs = self.counts.iter_mut().zip(other.counts);
        pairs.for_each(|(sum, count)| *sum += count);
    }

    /// The same for a row of a group whose rows go through the clusters together.
    pub fn in_group(&self) -> PairWork {
        let mut work = *self;
        for kind in [WorkKind::Visit, WorkKind::Shaft] {
            work.counts[kind as usize] /= TOGETHER;
        }
        work
    }

    /// Seconds that this takes on one core, about.
    pub fn seconds(&self) -> f64 {
        let kinds = self.counts.iter().zip(NANOSECONDS);
        1e-9 * kinds.map(|(&count, ns)| count as f64 * ns).sum::<f64>()
    }
}
