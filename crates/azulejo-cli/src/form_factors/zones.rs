//! Zones of buildings: each is an enclosure of its own, in which others are neither seen nor in the way.

use super::args::FormFactorArgs;
use super::{Completed, Enclosure, FactorRequest, enclosure};
use crate::failure::Failure;
use crate::report::Report;
use crate::runner::Runner;
use crate::session::Session;
use azulejo_exchange::files::FactorFormat;
use azulejo_scene::Scene;

/// The scene of each zone to compute; none if the format has no zones, or the model.
pub fn scenes(scene: &Scene, args: &FormFactorArgs) -> Result<Vec<Scene>, Failure> {
    use FactorFormat::{EnergyPlus, EnergyPlusJson};
    if !matches!(args.file_format(), Some(EnergyPlus | EnergyPlusJson)) {
        return Ok(Vec::new());
    }
    let names = scene.zones();
    let Some(zone) = &args.programs.zone else {
        return Ok(names.into_iter().map(|name| scene.of_zone(name)).collect());
    };
    match names.iter().find(|name| name.eq_ignore_ascii_case(zone)) {
        Some(name) => Ok(vec![scene.of_zone(name)]),
        None if names.is_empty() => Ok(Vec::new()),
        None => Err(Failure::failed(format_args!(
            "--zone {zone}: found no such zone, expected one of {}",
            names.join(", ")
        ))),
    }
}

/// The factors of all zones, one after another.
pub fn enclosures(
    zones: &[Scene],
    how: FactorRequest,
    runner: Runner,
    session: &mut Session,
    report: &mut Report,
) -> Result<Option<Completed<Enclosure>>, Failure> {
    if runner.shared_by().is_some() || runner.is_merged() {
        return Err(Failure::misuse(
            "the zones of a building are computed one after another, with nothing to divide: give --zone for one of \
             them, or leave out what divides the work",
        ));
    }
    let mut joined: Option<Completed<Enclosure>> = None;
    for zone in zones {
        let mut scratch = Report::default();
        let to = if joined.is_none() {
            &mut *report
        } else {
            &mut scratch
        };
        let computed = enclosure(zone, how, (Runner::alone(), None), session, to)?;
        joined = match (joined, computed) {
            (Some(a), Some(b)) => Some(Completed {
                value: a.value.beside(b.value),
                ..a
            }),
            (_, b) => b,
        };
    }
    Ok(joined)
}
