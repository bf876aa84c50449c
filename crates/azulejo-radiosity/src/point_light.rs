//! Irradiance at points, whichever way it was found, with what is said of it.

use crate::gathering::{GatherTargets, Gathering};
use crate::report::Estimate;
use crate::strata::{ErrorParts, QuarterError};

/// Irradiance at points.
#[derive(Clone, Debug)]
pub(crate) struct PointLight {
    /// One estimate per point, W/m².
    pub estimates: Vec<Estimate>,
    pub summary: GatherSummary,
}

/// What is said of irradiance at points.
#[derive(Clone, Debug)]
pub(crate) struct GatherSummary {
    /// Number of points.
    pub points: usize,
    /// Rays from each of them, on average.
    pub rays: u32,
    /// See [`Gathering::relative_error`].
    pub error: f64,
    /// See [`Gathering::error_of_each`].
    pub error_each: f64,
    pub parts: ErrorParts,
    pub quarters: [QuarterError; 4],
    /// Share of the points that are path traced.
    pub path_traced: f64,
    /// How many times as many rays the requested error would take; 1 if it is reached.
    pub rays_needed: f64,
    /// Share of the points whose indirect light is interpolated.
    pub interpolated: f64,
    /// Points at which light was gathered, if a deadline left no time for all.
    pub records: Option<usize>,
}

impl GatherSummary {
    /// Of no points.
    pub fn of_none() -> GatherSummary {
        Gathering::new(GatherTargets {
            points: &[],
            areas: &[],
        })
        .summary()
    }
}

impl Gathering {
    pub(crate) fn summary(&self) -> GatherSummary {
        GatherSummary {
            points: self.gathered.len(),
            rays: self.rays_per_point(),
            error: self.relative_error(),
            error_each: self.error_of_each(),
            parts: self.parts(),
            quarters: self.quarters(),
            path_traced: self.path_traced(),
            rays_needed: self.rays_needed,
            interpolated: self.interpolated(),
            records: self.records,
        }
    }

    /// The light of all points.
    pub(crate) fn light(&self) -> PointLight {
        let errors = self.standard_errors();
        let all = self.gathered.iter().zip(errors);
        // The estimate of a visible fraction may fall slightly below zero.
        let estimate = |(g, error): (&azulejo_trace::Gathered, _)| Estimate {
            value: g.mean().map(|e| e.max(0.0)),
            error,
        };
        PointLight {
            estimates: all.map(estimate).collect(),
            summary: self.summary(),
        }
    }
}
