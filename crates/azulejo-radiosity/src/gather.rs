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
use crate::point_light::PointLight;
use crate::shared_gather::gather_shared;
use azulejo_trace::{DiffuseLight, Gatherer, Run};

pub use crate::gather_pass::GatherLight;
pub use crate::gathering::{GatherEffort, GatherError, GatherTargets, Gathering, MOST_RAYS, Paths};
pub use crate::strata::{ErrorParts, QuarterError};

/// The light at all points as `effort` asks for it; passes intermediate results to `watch` after each pass but the last.
/// Where there are thousands of points, they share indirect light, unless that is not wished, each is to reach the
/// error, or a deadline has all points planned together.
pub(crate) fn point_light(
    gatherer: &Gatherer,
    light: GatherLight<impl DiffuseLight>,
    targets: GatherTargets,
    effort: GatherEffort,
    seed: u32,
    run: Run,
    watch: &mut dyn FnMut(&PointLight),
) -> Result<PointLight, GatherError> {
    let pass = GatherPass {
        gatherer,
        light,
        points: targets.points,
        pace: &GatherPace::default(),
        seed,
        run,
    };
    run.progress.limit_phase(1.0);
    let is_free = light.limited.is_none() && !run.progress.has_deadline();
    if is_free && effort.shares(targets.points.len()) {
        return gather_shared(&pass, targets, effort);
    }
    let mut all = Gathering::new(targets);
    pass.reach(&mut all, effort, &mut |all| watch(&all.light()))?;
    Ok(all.light())
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
        values: GatheredValues::apart(targets.points.len()),
        ..Gathering::new(targets)
    };
    pass.reach(&mut all, effort, &mut |_| ())?;
    Ok(all)
}
