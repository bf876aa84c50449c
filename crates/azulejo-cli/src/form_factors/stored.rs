//! Matrices that were computed before: read from an `.npz` or a `.zarr` and reworked.

use super::args::{ClosureName, ComputationArgs, FormFactorArgs};
use super::grouping;
use crate::args::InputArgs;
use crate::engine::EngineName;
use crate::failure::Failure;
use crate::pass;
use crate::report::percent;
use crate::session::Session;
use azulejo_exchange::Enclosure;
use azulejo_exchange::archive::{self, StoredFactors};
use azulejo_exchange::store::{MatrixStore, StoreError, StoreFolder};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// Difference of both directions of a pair from which it is no rounding, as a share of the smaller area.
const NOT_RECIPROCAL: f64 = 1e-5;

/// Reads the input if it is a single `.npz` or `.zarr`; otherwise `None`.
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
    refuse_computation(&args.input, &args.computation)?;
    let others = [
        ("--separate", args.matrix.separate),
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
    let budget = memory_limit(memory);
    let read = if is_store(path) {
        let store = open_store(path, memory, session)?;
        let read = session.with_progress(|p| {
            p.begin("reading", 0);
            store.read(p)
        });
        StoredFactors::Whole(Box::new(read.map_err(|e| of_store(path, e))?))
    } else {
        session.progress().begin("reading", 0);
        let file = File::open(path).map_err(|e| failed(&e))?;
        let read = archive::open(BufReader::new(file), budget);
        read.map_err(|e| failed(&e))?
    };
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

/// The limit of memory: as given, or that of the machine.
pub fn memory_limit(memory: Option<u64>) -> u64 {
    let limit = memory.or_else(azulejo::machine::memory);
    limit.unwrap_or(u64::MAX)
}

/// Opens a store, whose pairs are not read yet.
pub fn open_store(
    path: &Path,
    memory: Option<u64>,
    session: &mut Session,
) -> Result<MatrixStore, Failure> {
    session.progress().begin("reading", 0);
    let store = MatrixStore::open(StoreFolder(path.to_owned()), memory_limit(memory));
    store.map_err(|e| of_store(path, StoreError::Store(e)))
}

/// An error of reading a store.
pub fn of_store(path: &Path, error: StoreError) -> Failure {
    match error {
        StoreError::Cancelled => Failure::Cancelled,
        StoreError::Store(error) => Failure::failed(format_args!("{}: {error}", path.display())),
    }
}

/// Whether a file is an archive or a store of arrays, by its name.
pub fn is_archive(path: &Path) -> bool {
    let is_npz = |e: &std::ffi::OsStr| e.eq_ignore_ascii_case("npz");
    path.extension().is_some_and(is_npz) || is_store(path)
}

/// Whether a folder is a store of arrays, by its name.
pub fn is_store(path: &Path) -> bool {
    path.extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("zarr"))
}

/// Options that say how factors are computed have nothing to do where they are there already.
pub fn refuse_computation(input: &InputArgs, args: &ComputationArgs) -> Result<(), Failure> {
    let (reading, outside) = (&input.reading, &input.outside);
    let gives_light = [
        ("--lights", input.lights.is_some()),
        ("--sun", outside.sun.is_some()),
        ("--sky", outside.sky.is_some()),
        ("--ground", outside.ground.is_some()),
        ("--environment", outside.environment.is_some()),
        ("--studio", outside.studio),
    ];
    if let Some((option, _)) = gives_light.into_iter().find(|(_, is_given)| *is_given) {
        return Err(Failure::misuse(format_args!(
            "{option}: an .npz or .zarr has the light of its model, and no other; give {option} where form-factors or \
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
        "{option}: the factors of an .npz or .zarr are computed; --by, --cluster, --closure, --truncate, \
         --precision, --compression and --format of form-factors apply to it"
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
    let is_to_close = match args.computation.closure {
        None | Some(ClosureName::Never) => false,
        Some(ClosureName::Closed) => enclosure.factors.is_closed && !has_mirrors,
        Some(ClosureName::Always) => true,
    };
    if is_to_close {
        session.with_progress(|p| enclosure.factors.close(p))?;
    }
    Ok(())
}
