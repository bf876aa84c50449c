//! What a first pass did, and its error.

use crate::strata::{ErrorParts, QuarterError};
use crate::system::EnergyBalance;
use azulejo_factors::EngineUsed;
use azulejo_scene::Rgb;

/// How the light between patches was computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Rows of form factors, then Jacobi iteration.
    Matrix,
    /// Power shot by rays, nothing stored: Stochastic Jacobi (Neumann 1995), or particles.
    Stochastic,
    /// None: a deadline left no time for patches, and paths were traced from every point.
    Paths,
}

/// Statistics of a first pass, with its error.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// The method.
    pub method: Method,
    /// The engine that computed the form factors; empty if there are none.
    pub engine_used: EngineUsed,
    /// Number of patches.
    pub patches: usize,
    /// Vertices or points at which irradiance was gathered.
    pub points: usize,
    /// Rays traced from patches.
    pub patch_rays: u64,
    /// Rows with more rays than the others, to reach the error.
    pub refined_rows: usize,
    /// Estimated relative RMS error of the radiosity that patches reflect: see
    /// [`RadiositySolution::error`](crate::system::RadiositySolution::error).
    pub patch_error: f64,
    /// Rays traced from each point, on average.
    pub point_rays: u32,
    /// Bytes of the stored rows.
    pub bytes: usize,
    /// Bounces of light followed.
    pub iterations: u32,
    /// Change of the last bounce relative to the brightest patch.
    pub residual: f64,
    /// Energy balance, W.
    pub balance: EnergyBalance,
    /// Standard error of the share of the emitted power that is unaccounted for.
    pub balance_error: f64,
    /// Estimated RMS error of irradiance over its mean: see
    /// [`Gathering::relative_error`](crate::gather::Gathering::relative_error); at least the share of
    /// the emitted power that is unaccounted for beyond its standard error.
    pub error: f64,
    /// Root mean square over the points of the standard error of each relative to its irradiance; points without light
    /// are left out.
    pub error_each: f64,
    /// `error` by its causes.
    pub error_parts: ErrorParts,
    /// Mean irradiance and error of the quarters of the vertices or points, from dark to bright.
    pub quarters: [QuarterError; 4],
    /// Share of the vertices or points at which patches would have been too coarse, so that paths
    /// were traced.
    pub path_traced: f64,
    /// How many times as many rays from points the requested error would take; 1 if it is reached.
    pub rays_needed: f64,
    /// Share of the vertices or points at which indirect light is interpolated.
    pub interpolated: f64,
}

/// An estimate with its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: Rgb,
    /// Its standard error: the truth lies within two of them 95 times in 100.
    pub error: Rgb,
}
