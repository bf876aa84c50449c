//! Matrices that were computed before: read from an `.npz` and reworked.

use super::args::{ClosureName, ComputationArgs, FormFactorArgs};
use super::grouping;
use crate::engine::EngineName;
use crate::failure::Failure;
use crate::input::{ClockArgs, InputArgs};
use crate::pass;
use crate::report::percent;
use crate::session::Session;
use azulejo_exchange::Enclosure;
use azulejo_exchange::archive::{self, StoredFactors};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// Difference of both directions of a pair from which it is not rounding, as a share of the smaller area.
const NOT_RECIPROCAL: f64 = 1e-5;

/// Reads the input if it is a single `.npz`; otherwise `None`.
pub fn read(args: &FormFactorArgs, session: &mut Session) -> Result<Option<Enclosure>, Failure> {
    let [path] = &args.input.scenes[..] else {
        let archive = args.input.scenes.iter().find(|path| is_archive(path));
        return match archive {
            Some(path) => Err(Failure::misuse(format_args!(
                "{}: a matrix stands alone, other files beside it have no place in it",
                path.display()
            ))),
            None => Ok(None),
        };
    };
    if !is_archive(path) {
        return Ok(None);
    }
    refuse_computation((&args.input, args.clock), &args.computation)?;
    let others = [
        ("--separate", args.matrix.separate),
        ("--sky-patches", args.matrix.sky_patches.is_some()),
        ("--materials", args.materials.is_some()),
    ];
    if let Some((option, _)) = others.into_iter().find(|(_, is_given)| *is_given) {
        return Err(computed_already(option));
    }
    let enclosure = read_archive(path, args.computation.memory, session)?;
    if enclosure.elsewhere.is_some() && args.matrix.by.is_none() && args.matrix.cluster.is_none() {
        return Err(Failure::failed(format_args!(
            "{}: the matrix is compressed into blocks, which have no single entries: expected --by or --cluster, \
             whose groups have a whole matrix; exchange and info read it as it is",
            path.display()
        )));
    }
    Ok(Some(enclosure))
}

/// Reads the factors of an archive, whole or in blocks, and says what is odd about them.
pub fn read_archive(
    path: &Path,
    memory: Option<u64>,
    session: &mut Session,
) -> Result<Enclosure, Failure> {
    Ok(read_whole(path, memory, session)?.into_enclosure())
}

/// Reads an archive with what is known of its arrays, and says what is odd about it.
pub fn read_whole(
    path: &Path,
    memory: Option<u64>,
    session: &mut Session,
) -> Result<StoredFactors, Failure> {
    let failed =
        |e: &dyn std::fmt::Display| Failure::failed(format_args!("{}: {e}", path.display()));
    session.progress().begin("reading", 0);
    let file = File::open(path).map_err(|e| failed(&e))?;
    let budget = memory.or_else(azulejo::machine::memory);
    let read = archive::open(BufReader::new(file), budget.unwrap_or(u64::MAX));
    let read = read.map_err(|e| failed(&e))?;
    if let StoredFactors::Whole(read) = &read
        && read.asymmetry > NOT_RECIPROCAL
    {
        session.note(&format!(
            "{}: A_i X_ij and A_j X_ji differ by up to {} of the smaller area; their mean is taken",
            path.display(),
            percent(read.asymmetry)
        ));
    }
    Ok(read)
}

/// Whether a file is an archive of arrays, by its name.
pub fn is_archive(path: &Path) -> bool {
    path.extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("npz"))
}

/// Options that say how factors are computed have nothing to do where they are there already.
pub fn refuse_computation(
    (input, clock): (&InputArgs, ClockArgs),
    args: &ComputationArgs,
) -> Result<(), Failure> {
    let (reading, outside) = (&input.reading, &input.outside);
    let gives_light = [
        ("--lights", input.lights.is_some()),
        ("--sun", outside.sun.is_some()),
        ("--time", clock.time.is_some()),
        ("--sky", outside.sky.is_some()),
        ("--ground", outside.ground.is_some()),
        ("--environment", outside.environment.is_some()),
        ("--studio", outside.studio),
    ];
    if let Some((option, _)) = gives_light.into_iter().find(|(_, is_given)| *is_given) {
        return Err(Failure::misuse(format_args!(
            "{option}: an .npz has the light of its model, and no other; give {option} where form-factors or \
             exchange read the model, or sunlight by a column \"solar\" of --boundary"
        )));
    }
    let given = [
        ("--recipe", !reading.recipe.is_empty()),
        ("--flip", !reading.flip.is_empty()),
        ("--rays", args.rays.is_some()),
        (
            "--patches or --patch-size",
            pass::patch_size(&args.division).is_some(),
        ),
        ("--tolerance", args.tolerance.is_some()),
        ("--two-sided", args.two_sided),
        ("--periodic", args.periodic.is_some()),
        ("--engine", args.engine.engine != EngineName::Auto),
        ("--unit, --up or --place", {
            reading.unit.is_some() || reading.up.is_some() || reading.placements().next().is_some()
        }),
    ];
    match given.into_iter().find(|(_, is_given)| *is_given) {
        Some((option, _)) => Err(computed_already(option)),
        None => Ok(()),
    }
}

fn computed_already(option: &str) -> Failure {
    Failure::misuse(format_args!(
        "{option}: the factors of an .npz are computed; --by, --cluster, --closure, --truncate, \
         --precision and --format of form-factors apply to it"
    ))
}

/// Enforces closure, and groups rows, as requested.
pub fn rework(
    mut enclosure: Enclosure,
    args: &FormFactorArgs,
    session: &mut Session,
) -> Result<Enclosure, Failure> {
    if enclosure.elsewhere.is_some() {
        // Groups have single entries, which closure changes.
        enclosure = grouping::grouped(enclosure, args, session)?;
        close(&mut enclosure, args, session)?;
        return Ok(enclosure);
    }
    close(&mut enclosure, args, session)?;
    let options = [
        ("--by", args.matrix.by.is_some()),
        ("--cluster", args.matrix.cluster.is_some()),
    ];
    if let Some((option, _)) = options.into_iter().find(|(_, is_given)| *is_given)
        && enclosure.rows.are_groups
    {
        return Err(Failure::misuse(format_args!(
            "{option}: the rows of this matrix are groups already; start from that of the patches"
        )));
    }
    grouping::grouped(enclosure, args, session)
}

fn close(
    enclosure: &mut Enclosure,
    args: &FormFactorArgs,
    session: &mut Session,
) -> Result<(), Failure> {
    let has_mirrors = enclosure.factors.ends.iter().any(|&ends| ends < 1.0);
    let is_to_close = match args.closure() {
        None | Some(ClosureName::Never) => false,
        Some(ClosureName::Closed) => enclosure.factors.is_closed && !has_mirrors,
        Some(ClosureName::Always) => true,
    };
    if is_to_close {
        session.with_progress(|p| enclosure.factors.close(p))?;
    }
    Ok(())
}
