//! What a camera path costs.

/// What a camera path costs, on average.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PathCost {
    /// Rays of the path itself: its segments, and shadow rays of glossy surfaces.
    pub rays: f64,
    /// Gathers of irradiance.
    pub gathers: f64,
    /// Rays for each direction of a gather: directions that hit a patch from nearer than its size go on.
    pub per_direction: f64,
    /// Rays for the direct light of a gather.
    pub direct: f64,
}

impl PathCost {
    /// Rays of a path whose gathers take as many directions.
    pub fn with_gathers(self, directions: u32) -> f64 {
        self.rays + self.gathers * (self.per_direction * f64::from(directions) + self.direct)
    }
}
