//! `form-factors`: the matrix between patches.

use super::args::FormFactorArgs;
use super::failure::Failure;
use super::output::Output;
use super::report::{Report, count, number, percent};
use super::session::Session;
use super::{input, pass, sparse};
use azulejo_radiosity::{FormFactorOptions, FormFactors};

/// Runs `form-factors`.
pub fn run(args: &FormFactorArgs, session: &mut Session) -> Result<Report, Failure> {
    let extension = args.output.extension().and_then(|e| e.to_str());
    let extension = extension.unwrap_or("").to_ascii_lowercase();
    let output = Output::check(&args.output)?;
    let is_npz = extension == "npz";
    if !is_npz && extension != "csv" && !output.is_stdout() {
        return Err(Failure::misuse(format_args!(
            "{}: unknown kind of matrix, expected .npz or .csv",
            args.output.display()
        )));
    }
    session.claim_stdout(output.is_stdout())?;
    let chosen = args.engine.choose()?;
    let scene = input::read_all(&args.input, session)?;
    let tracer = chosen.tracer(&scene)?;
    let options = FormFactorOptions {
        engine: chosen.engine.clone(),
        ..options(args)
    };
    let factors = session
        .watched(|p| azulejo_radiosity::form_factors(&scene, &tracer, &options, p))
        .map_err(pass::failure)?;
    output.write(session.progress(), |out| match is_npz {
        true => sparse::write_npz(&factors, out),
        false => sparse::write_csv(&factors, out),
    })?;
    let mut report = Report::default();
    chosen.describe(&factors.ran, &mut report);
    describe(&factors, &mut report);
    let path = args.output.display().to_string();
    report.fact("output", path.clone(), "wrote", path);
    Ok(report)
}

fn options(args: &FormFactorArgs) -> FormFactorOptions {
    let default = FormFactorOptions::default();
    FormFactorOptions {
        size: pass::patch_size(&args.division).unwrap_or(default.size),
        rays: args.rays.unwrap_or(default.rays),
        two_sided: args.two_sided,
        seed: args.seed,
        ..default
    }
}

fn describe(factors: &FormFactors, report: &mut Report) {
    let (n, entries) = (factors.len(), factors.exchange.entries());
    report.fact("patches", n, "patches", count(n));
    let share = entries as f64 / (n as f64 * n as f64);
    let words = format!("{}, {} of the matrix", count(entries), percent(share));
    report.fact("entries", entries, "entries", words);
    report.fact("rays", factors.rays, "rays", count(factors.rays));
    let words = match factors.is_closed {
        true => "closed".to_owned(),
        false => format!(
            "open, {} of the light leaves it",
            percent(mean(
                factors,
                &factors.rest.iter().map(|r| r.escaped()).collect::<Vec<_>>()
            ))
        ),
    };
    report.fact("closed", factors.is_closed, "scene", words);
    // An empty row sums to −0, which is true but looks wrong.
    let sums: Vec<f64> = factors.row_sums().iter().map(|s| s + 0.0).collect();
    let low = sums.iter().copied().fold(f64::INFINITY, f64::min);
    let high = sums.iter().copied().fold(0.0, f64::max);
    let middle = mean(factors, &sums);
    report.line(
        "row sums",
        format!("{low:.4} to {high:.4}, mean {middle:.6}"),
    );
    report.value("row_sum_min", number(low));
    report.value("row_sum_max", number(high));
    report.value("row_sum_mean", number(middle));
    let error = mean(factors, &factors.row_errors);
    report.fact("row_error", number(error), "error of a row", percent(error));
    let moved = factors.closed.map_or(0.0, |m| m.total);
    report.value("correction", number(moved));
}

/// The mean of one number per row, weighted by area.
fn mean(factors: &FormFactors, numbers: &[f64]) -> f64 {
    let total: f64 = factors.areas.iter().sum();
    let weighted = numbers.iter().zip(&factors.areas).map(|(x, a)| x * a);
    weighted.sum::<f64>() / total.max(f64::MIN_POSITIVE)
}
