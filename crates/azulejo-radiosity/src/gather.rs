//! Irradiance at points, to a requested error that includes the discretization.
//!
//! Reading the radiosity of patches is quick and leaves little noise, but patches that are too coarse
//! for what a point sees leave an error that no number of rays removes: light leaks into dark rooms.
//! So the points are divided into [strata](crate::strata) of brightness, and at a keyed sample of each
//! stratum irradiance is also path traced, so that its mean does not depend on the patches
//! ([`Roulette`](azulejo_trace::Termination::Roulette)). Where the two differ by more than a part of the requested
//! error, all points of the stratum are path traced; elsewhere the difference is part of the stated error.

use crate::deadline::GatherPace;
use crate::gather_pass::GatherPass;
use crate::gathered_values::GatheredValues;
use crate::sparse;
use crate::strata::Strata;
use azulejo_trace::{DiffuseLight, Gatherer, Run};

pub use crate::gather_pass::GatherLight;
pub use crate::gathering::{GatherEffort, GatherError, GatherTargets, Gathering, MOST_RAYS, Paths};
pub use crate::strata::{ErrorParts, QuarterError};

/// Gathers at all points until `effort` is reached or the progress is out of time.
///
/// To reach an error, a first pass measures the noise of each point; later ones spend rays where
/// they reduce the error most.
///
/// # Errors
/// [`GatherError`].
pub fn gather<'r>(
    gatherer: &Gatherer,
    light: GatherLight<impl DiffuseLight>,
    targets: GatherTargets,
    effort: GatherEffort,
    seed: u32,
    run: impl Into<Run<'r>>,
) -> Result<Gathering, GatherError> {
    let run = run.into();
    gather_watched(gatherer, light, targets, effort, seed, run, &mut |_| ())
}

/// As [`gather`]; passes intermediate results to `watch` after each pass but the last.
pub(crate) fn gather_watched(
    gatherer: &Gatherer,
    light: GatherLight<impl DiffuseLight>,
    targets: GatherTargets,
    effort: GatherEffort,
    seed: u32,
    run: Run,
    watch: &mut dyn FnMut(&Gathering),
) -> Result<Gathering, GatherError> {
    let pass = GatherPass {
        gatherer,
        light,
        points: targets.points,
        pace: &GatherPace::default(),
        seed,
        run,
    };
    run.progress.limit_phase(1.0);
    // Before a deadline, all points are planned together.
    let is_sparse = effort.interpolate && !effort.is_each && !run.progress.has_deadline();
    if effort.error.is_some() && is_sparse && targets.points.len() >= sparse::LEAST_POINTS {
        return sparse::gather_sparse(&pass, targets, effort, watch);
    }
    let mut all = Gathering::new(targets);
    pass.reach(&mut all, effort, watch)?;
    Ok(all)
}

/// As [`gather`] without interpolation, with indirect light apart ([`Gathering::indirect`]).
pub(crate) fn gather_split(
    gatherer: &Gatherer,
    light: GatherLight<impl DiffuseLight>,
    targets: GatherTargets,
    effort: GatherEffort,
    seed: u32,
    run: Run,
) -> Result<Gathering, GatherError> {
    let pass = GatherPass {
        gatherer,
        light,
        points: targets.points,
        pace: &GatherPace::default(),
        seed,
        run,
    };
    run.progress.limit_phase(1.0);
    let mut all = Gathering {
        values: GatheredValues::apart(&Strata::new(targets.points.len(), targets.areas)),
        ..Gathering::new(targets)
    };
    pass.reach(&mut all, effort, &mut |_| ())?;
    Ok(all)
}
