//! The first pass: its options, solution and summary.

use super::args::{DivisionArgs, FirstPassArgs, SidesArg};
use super::engine::PreparedEngine;
use super::failure::Failure;
use super::report::{Report, bytes, count, number, numbers, percent, short, triple};
use super::session::Session;
use azulejo::machine;
use azulejo_radiosity::{
    EnergyBalance, FirstPass, LightSolution, Method, PatchSize, SolveError, StoredSides,
};
use azulejo_scene::{Rgb, Scene, Units};
use azulejo_trace::Tracer;

/// The patch size for the library; `None` if the command line does not specify one.
pub fn patch_size(division: &DivisionArgs) -> Option<PatchSize> {
    let count = division.patches.map(|n| PatchSize::Count(n as usize));
    count.or(division.patch_size.map(PatchSize::Edge))
}

/// The library's options.
pub fn options(args: &FirstPassArgs, prepared: &PreparedEngine) -> FirstPass {
    FirstPass {
        size: patch_size(&args.division).unwrap_or(FirstPass::default().size),
        error: args.error,
        rays: args.rays,
        bounces: args.bounces,
        seed: args.seed,
        memory: args.memory.unwrap_or_else(machine::memory_budget),
        keep_mesh: args.keep_mesh,
        sides: sides(args.sides),
        engine: prepared.engine.clone(),
    }
}

fn sides(arg: Option<SidesArg>) -> StoredSides {
    match arg {
        None => StoredSides::BySurface,
        Some(SidesArg::Front) => StoredSides::Front,
        Some(SidesArg::Brighter) => StoredSides::Brighter,
        Some(SidesArg::Split) => StoredSides::Split,
    }
}

/// Solves under a progress bar.
pub fn solve(
    scene: &Scene,
    tracer: &Tracer,
    args: &FirstPassArgs,
    prepared: &PreparedEngine,
    session: &Session,
) -> Result<LightSolution, Failure> {
    session.limit_time(args.time);
    let options = options(args, prepared);
    session
        .with_progress(|progress| azulejo_radiosity::solve(scene, tracer, &options, progress))
        .map_err(failure)
}

/// An error of the solver as a failure of the command.
pub fn failure(error: impl Into<SolveError>) -> Failure {
    match error.into() {
        SolveError::Cancelled => Failure::Cancelled,
        other => Failure::failed(other),
    }
}

/// The unit of power in a scene.
pub fn power_unit(units: Units) -> &'static str {
    if units.photometric { "lm" } else { "W" }
}

/// Adds what the first pass did, and the error of its result.
pub fn describe(
    pass: &azulejo_radiosity::Report,
    prepared: &PreparedEngine,
    units: Units,
    report: &mut Report,
) {
    prepared.describe(&pass.engine_used, report);
    let method = match pass.method {
        Method::Matrix => "matrix",
        Method::Stochastic => "stochastic",
    };
    report.value("method", method);
    let words = match pass.method {
        Method::Matrix => format!(
            "{}, {} of rows",
            count(pass.patches),
            bytes(pass.bytes as u64)
        ),
        Method::Stochastic => format!("{}, without a matrix", count(pass.patches)),
    };
    report.fact("patches", pass.patches, "patches", words);
    report.value("matrix_bytes", pass.bytes);
    let gathered = pass.points as u64 * u64::from(pass.point_rays);
    report.line(
        "rays",
        format!(
            "{} from patches, {} from {} {}",
            count(pass.patch_rays),
            count(gathered),
            count(pass.points),
            if pass.points == 1 { "point" } else { "points" }
        ),
    );
    report.value("patch_rays", pass.patch_rays);
    if pass.method == Method::Matrix {
        let words = match pass.refined_rows {
            0 => percent(pass.patch_error),
            rows => format!(
                "{}, {} rows refined",
                percent(pass.patch_error),
                count(rows)
            ),
        };
        report.line("error of patches", words);
    }
    report.value("patch_error", number(pass.patch_error));
    report.value("refined_rows", pass.refined_rows);
    report.value("points", pass.points);
    report.value("rays_per_point", pass.point_rays);
    report.value("rays", pass.patch_rays + gathered);
    let words = format!("{}, residual {}", pass.iterations, short(pass.residual));
    report.fact("iterations", pass.iterations, "bounces", words);
    report.value("residual", number(pass.residual));
    energy(&pass.balance, units, report);
    report.fact(
        "error",
        number(pass.error),
        "estimated error",
        percent(pass.error),
    );
}

/// Adds the energy balance, in W or lm and as shares.
fn energy(balance: &EnergyBalance, units: Units, report: &mut Report) {
    let emitted = balance.emitted.mean();
    let share = |power: Rgb| percent(power.mean() / emitted.max(f64::MIN_POSITIVE));
    report.line(
        "energy",
        format!(
            "{} {} emitted, {} absorbed, {} escaped, {} unaccounted for",
            triple(balance.emitted.to_array()),
            power_unit(units),
            share(balance.absorbed),
            share(balance.escaped),
            percent(balance.error())
        ),
    );
    if balance.is_off() {
        report.line(
            "caution",
            "the energy balance is off: request a smaller error, more rays or more time",
        );
    }
    report.value("emitted", numbers(balance.emitted.to_array()));
    report.value("absorbed", numbers(balance.absorbed.to_array()));
    report.value("escaped", numbers(balance.escaped.to_array()));
    report.value("cut", numbers(balance.cut.to_array()));
    report.value("energy_error", number(balance.error()));
}
