//! The matrix in blocks between clusters: `--compress`.

use super::args::{FormFactorArgs, PrecisionName};
use super::outside::AskedSky;
use super::view3d::View3dInput;
use super::{FactorRequest, FactorSetup, facing, outside, stored, summary};
use crate::failure::Failure;
use crate::pass;
use crate::report::{Report, count, number, percent};
use crate::session::Session;
use azulejo::output::{Output, commit};
use azulejo_exchange::archive::{self, BlockArchive};
use azulejo_exchange::files::FactorFormat;
use azulejo_factors::CompressionOptions;
use azulejo_factors::hierarchy::{CompressionError, Estimated, FactorOperator, StatedFactors};
use serde_json::json;

/// Computes the matrix in blocks, and writes it.
pub fn run(
    args: &FormFactorArgs,
    tolerance: f64,
    session: &mut Session,
) -> Result<Report, Failure> {
    refuse_contradiction(args)?;
    let output = Output::check(&args.output)?;
    // Blocks are for the many patches of a model; the few rows of a View3D file gain nothing from them.
    let (room, scene) = super::read_scene(args, session)?;
    if let Some(room) = room {
        return Err(Failure::misuse(format_args!(
            "--compress: the rows of a View3D file are its own surfaces ({}), few enough for a whole matrix",
            count(View3dInput::scene(&room).objects.len())
        )));
    }
    let how = FactorRequest {
        computation: &args.computation,
        sky: AskedSky::of(args)?,
        separate: false,
        groups: None,
        room: None,
    };
    // Compute the blocks: by rays without ever having the whole matrix, otherwise from it.
    let setup = FactorSetup::new(&scene, how, session)?;
    let plan = setup.plan(&scene, how, session)?;
    let prepared = plan.prepare();
    let options = CompressionOptions {
        tolerance,
        keep_sums: true,
    };
    let stated_factors = session.with_progress(|p| StatedFactors::of(&prepared, &options, p));
    let stated_factors = stated_factors.map_err(|e| match e {
        CompressionError::Factors(e) => pass::failure(e),
        other => Failure::failed(other),
    })?;
    // Rows are traced again only where the blocks are by rays, for which closure plays no part.
    if stated_factors.stated.rows > 0 && args.computation.closure.is_some() {
        session.note(
            "--closure has no effect: by rays, rows and columns are scaled until rows have the sums that their \
             own rays found",
        );
    }
    // Add the light from outside, and warn of objects that are probably turned inside out.
    let mut blocks = BlockArchive::of(&prepared, &scene, stated_factors, tolerance);
    let factors = &blocks.enclosure.factors;
    let sky = outside::sky(&prepared, factors, how.sky, session)?;
    blocks.enclosure.outside = outside::irradiance(&prepared, &scene, factors, session)?;
    blocks.enclosure.sky = sky;
    if !setup.options.two_sided {
        facing::advise(&scene, &setup.tracer, &blocks.enclosure, session)?;
    }
    let mut draft = output.draft()?;
    archive::write_blocks(&blocks, &mut draft).map_err(|e| output.error(e))?;
    commit(vec![draft], session.progress())?;
    let mut report = Report::default();
    let used = &blocks.enclosure.factors.engine_used;
    setup.engine.describe(used, &mut report);
    describe(&blocks, &mut report);
    outside::describe(&blocks.enclosure, &mut report);
    let path = args.output.display().to_string();
    report.fact("output", path.clone(), "wrote", path);
    Ok(report)
}

/// Options that ask for single entries, or for another file.
fn refuse_contradiction(args: &FormFactorArgs) -> Result<(), Failure> {
    let matrix = &args.matrix;
    let format = args.format.map(|name| name.0);
    let is_npz = match format {
        Some(format) => format == FactorFormat::Npz,
        None => FactorFormat::from_path(&args.output) == Some(FactorFormat::Npz),
    };
    if !is_npz {
        return Err(Failure::misuse(format_args!(
            "--compress: blocks are written as .npz, and {} is not one",
            args.output.display()
        )));
    }
    let groups = "groups are whole matrices; make them of the file: form-factors F.npz --by object";
    let entries = "blocks have no single entries";
    let idle = [
        (
            "--separate",
            matrix.separate,
            "blocks hold the sum of all orders of reflection",
        ),
        ("--truncate", matrix.truncate.is_some(), entries),
        ("--by", matrix.by.is_some(), groups),
        ("--cluster", matrix.cluster.is_some(), groups),
        (
            "--precision",
            matrix.precision != PrecisionName::Auto,
            "blocks have 32 bits, of which their tolerance needs few",
        ),
        ("--vtu-rows", !args.programs.vtu_rows.is_empty(), entries),
    ];
    if let Some((option, _, why)) = idle.into_iter().find(|(_, is_given, _)| *is_given) {
        return Err(Failure::misuse(format_args!(
            "--compress and {option}: {why}"
        )));
    }
    if args
        .input
        .scenes
        .iter()
        .any(|path| stored::is_archive(path))
    {
        return Err(Failure::misuse(
            "--compress: an .npz has no clusters of its rows; give the model",
        ));
    }
    Ok(())
}

/// Adds size and errors.
pub fn describe(archive: &BlockArchive, report: &mut Report) {
    let (factors, n) = (&*archive.factors, archive.factors.len());
    report.fact("patches", n, "patches", count(n));
    let (bytes, whole) = (factors.bytes() as u64, archive.whole_bytes);
    let mut words = format!("{} in blocks", crate::report::bytes(bytes));
    if whole > 0 {
        let share = percent(bytes as f64 / whole as f64);
        let about = if archive.stated.rows > 0 {
            "about "
        } else {
            ""
        };
        words += &format!(
            ", {share} of {about}{} of the whole matrix",
            crate::report::bytes(whole)
        );
    }
    report.fact("matrix_bytes", bytes, "matrix", words);
    report.value("whole_bytes", whole);
    let [sparse, dense, low] = factors.kinds();
    let words = format!(
        "{} sparse, {} dense, {} of low rank, for a tolerance of {:e}",
        count(sparse),
        count(dense),
        count(low),
        archive.tolerance
    );
    let blocks = json!({ "sparse": sparse, "dense": dense, "low_rank": low });
    report.fact("blocks", blocks, "blocks", words);
    report.value("tolerance", number(archive.tolerance));
    report.fact("rays", factors.rays, "rays", count(factors.rays));
    summary::describe_sums(&archive.enclosure, report);
    stated(archive, report);
}

/// The errors, and what they are against.
fn stated(archive: &BlockArchive, report: &mut Report) {
    let stated = archive.stated;
    let against = match stated.rows {
        0 => "against the whole matrix".to_owned(),
        rows => format!("by {} rows traced again", count(rows)),
    };
    let errors = [
        (
            "product_error",
            "error of products",
            stated.product,
            "of their RMS",
        ),
        ("row_sum_error", "of row sums", stated.sums, "RMS"),
    ];
    for (key, label, Estimated { value, error }, what) in errors {
        let spread = match error {
            0.0 => String::new(),
            error => format!(" ± {}", percent(error)),
        };
        let words = format!("{}{spread} {what}, {against}", percent(value));
        report.fact(key, number(value), label, words);
        report.value(&format!("{key}_error"), number(error));
    }
    report.value("traced_again", stated.rows);
}
