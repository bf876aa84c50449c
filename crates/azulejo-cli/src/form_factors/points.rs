//! `form-factors --from`: what points see, instead of the matrix between patches.

use super::args::{FormFactorArgs, FromArgs};
use super::{FactorRequest, FactorSetup, painted, read_models};
use crate::failure::Failure;
use crate::report::{Report, count, number, short, with_error};
use crate::session::Session;
use crate::{pass, points};
use azulejo::models;
use azulejo::output::Output;
use azulejo_exchange::GroupBy;
use azulejo_exchange::files::FactorFormat;
use azulejo_exchange::points::{SeenFromPoints, in_six_directions, numbered};
use azulejo_exchange::thermal::tables::BoundaryTable;
use azulejo_factors::form_factors::FactorPoint;
use std::path::Path;

/// Points whose temperatures the summary has.
const LISTED: usize = 10;

/// Computes what the points see, and writes it.
pub fn run(args: &FormFactorArgs, from: &Path, session: &mut Session) -> Result<Report, Failure> {
    let (output, format) = output(args)?;
    session.claim_stdout(output.is_stdout())?;
    let points = read(from, &args.from)?;
    let table = match &args.from.temperatures {
        Some(path) => Some(read_table(path)?),
        None => None,
    };
    let scene = painted(args, read_models(&args.input, args.clock, session)?)?;
    // Whole objects, unless others are asked for: few points need no patches.
    let by = args.matrix.by.map_or(GroupBy::Object, Into::into);
    let request = FactorRequest {
        computation: &args.computation,
        sky: None,
        separate: false,
        groups: Some(by),
        room: None,
    };
    let setup = FactorSetup::new(&scene, request, session)?;
    let plan = setup.plan(&scene, request, session)?;
    let prepared = plan.prepare();
    let seen = session
        .with_progress(|p| SeenFromPoints::compute(&prepared, (&scene, Some(by)), points, p));
    let mut seen = seen.map_err(|_| Failure::Cancelled)?;
    if let Some(division) = args.matrix.sky_patches {
        let north = args.input.outside.north.to_radians();
        let added = session.with_progress(|p| seen.add_sky(&prepared, (division, north), p));
        added.map_err(pass::failure)?;
    }
    if let (Some(table), Some(path)) = (&table, &args.from.temperatures) {
        let unused = seen.unused(table).join("\", \"");
        if !unused.is_empty() {
            session.note(&format!(
                "{}: no row has the name \"{unused}\"",
                path.display()
            ));
        }
        let added = seen.add_temperatures(table);
        added.map_err(|e| Failure::failed(format_args!("{}: {e}", path.display())))?;
    }
    output.write(session.progress(), |out| match format {
        FactorFormat::Npz => seen.write_npz(out),
        _ => seen.write_csv(out),
    })?;
    let mut report = Report::default();
    describe(&seen, setup.options.rays, &mut report);
    let path = args.output.display().to_string();
    report.fact("output", path.clone(), "wrote", path);
    Ok(report)
}

/// Where to write, as CSV or `.npz`.
fn output(args: &FormFactorArgs) -> Result<(Output, FactorFormat), Failure> {
    let is_stdout = args.output == Path::new("-");
    match args.file_format() {
        Some(format @ (FactorFormat::Csv | FactorFormat::Npz)) => {
            Ok((Output::check(&args.output)?, format))
        }
        None if is_stdout => Ok((Output::check(&args.output)?, FactorFormat::Csv)),
        _ => Err(Failure::misuse(format_args!(
            "{}: what points see is written as .csv or .npz, as other programs have no place for it",
            args.output.display()
        ))),
    }
}

/// The points of a file, and their names.
fn read(path: &Path, from: &FromArgs) -> Result<(Vec<FactorPoint>, Vec<String>), Failure> {
    let points = points::read_places(path)?;
    let points = points
        .into_iter()
        .map(|(position, normal)| FactorPoint { position, normal });
    let points: Vec<FactorPoint> = points.collect();
    if !from.six_directions {
        return Ok(numbered(points));
    }
    if points.iter().any(|point| point.normal.is_some()) {
        return Err(Failure::misuse(format_args!(
            "--six-directions: the points of {} have normals, and need none",
            path.display()
        )));
    }
    Ok(in_six_directions(&points))
}

fn read_table(path: &Path) -> Result<BoundaryTable, Failure> {
    let failed =
        |e: &dyn std::fmt::Display| Failure::failed(format_args!("{}: {e}", path.display()));
    let text = String::from_utf8(models::read_bytes(path)?);
    let text = text.map_err(|_| failed(&"not a text in UTF-8"))?;
    BoundaryTable::read(&text).map_err(|e| failed(&e))
}

/// Adds the size, the error of shares, and temperatures.
fn describe(seen: &SeenFromPoints, rays: u32, report: &mut Report) {
    report.fact("points", seen.seen.len(), "points", count(seen.seen.len()));
    report.fact(
        "rays_per_point",
        rays,
        "rays",
        format!("{} of each", count(rays as usize)),
    );
    let groups = seen.groups.names.len();
    report.fact("columns", groups, "columns", count(groups));
    let errors = seen
        .seen
        .iter()
        .flat_map(|p| &p.factors)
        .map(|(_, f)| f.error);
    let most = errors.fold(0.0, f64::max);
    let words = format!("{}, the largest of a share", short(most));
    report.fact("std_error_max", number(most), "standard error", words);
    let Some(temperatures) = &seen.temperatures else {
        return;
    };
    for (name, [t, error]) in seen.names.iter().zip(temperatures).take(LISTED) {
        report.line(
            &format!("point {name}"),
            format!("{} K", with_error(*t, *error)),
        );
    }
    if temperatures.len() > LISTED {
        report.line("", format!("and {} more", temperatures.len() - LISTED));
    }
    let listed: Vec<_> = temperatures.iter().map(|t| number(t[0])).collect();
    report.value("radiant_temperatures", listed);
}
