//! How many samples the rows of patches take.

/// A number of samples for each patch: rays, hemicubes, or positions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SampleCounts {
    /// The same for all.
    Alike(u32),
    /// One number for each patch.
    ByPatch(Vec<u32>),
}

impl SampleCounts {
    /// The samples of a row of `patch`.
    pub fn of(&self, patch: usize) -> u32 {
        match self {
            SampleCounts::Alike(count) => *count,
            SampleCounts::ByPatch(counts) => counts[patch],
        }
    }

    /// The mean over the first `rows` patches; 0 without any.
    pub fn mean(&self, rows: usize) -> f64 {
        let samples: f64 = (0..rows).map(|row| f64::from(self.of(row))).sum();
        samples / rows.max(1) as f64
    }

    /// The largest of these numbers; 0 without patches.
    pub fn most(&self) -> u32 {
        match self {
            SampleCounts::Alike(count) => *count,
            SampleCounts::ByPatch(counts) => counts.iter().copied().max().unwrap_or(0),
        }
    }

    /// The same with each number changed by `change`.
    pub fn map(&self, change: impl Fn(u32) -> u32) -> SampleCounts {
        match self {
            SampleCounts::Alike(count) => SampleCounts::Alike(change(*count)),
            SampleCounts::ByPatch(counts) => {
                SampleCounts::ByPatch(counts.iter().map(|&count| change(count)).collect())
            }
        }
    }

    /// Steps of progress of a row of `patch`: one where all rows take the same, else one for each `unit`
    /// samples.
    pub fn steps(&self, patch: usize, unit: u32) -> u64 {
        match self {
            SampleCounts::Alike(_) => 1,
            SampleCounts::ByPatch(counts) => u64::from(counts[patch].div_ceil(unit).max(1)),
        }
    }
}

/// The samples of rows, by whatever engine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RowSamples {
    /// Rays, rounded up to multiples of four.
    pub rays: SampleCounts,
    /// Hemicubes, rounded up to multiples of four; `None` for as many as the engine's
    /// [`points`](crate::Hemicube::points).
    pub hemicubes: Option<SampleCounts>,
}

impl RowSamples {
    /// `rays` rays per row, and as many hemicubes as the engine says.
    pub fn of_rays(rays: u32) -> RowSamples {
        RowSamples {
            rays: SampleCounts::Alike(rays),
            hemicubes: None,
        }
    }
}

/// The steps of a row that are due after part `part` of `parts`: all of them after the last.
pub(crate) fn steps_of_part(steps: u64, part: usize, parts: usize) -> u64 {
    let until = |k: usize| steps * k as u64 / parts as u64;
    until(part + 1) - until(part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_of_parts_are_those_of_the_row() {
        for steps in [1, 3, 4, 9] {
            let sum: u64 = (0..4).map(|part| steps_of_part(steps, part, 4)).sum();
            assert_eq!(sum, steps);
        }
        let counts = SampleCounts::ByPatch(vec![1, 4096, 10_000]);
        assert_eq!([0, 1, 2].map(|p| counts.steps(p, 4096)), [1, 1, 3]);
        assert_eq!(SampleCounts::Alike(10_000).steps(2, 4096), 1);
    }
}
