//! The command line of azulejo, as a library: [`main`] is the program, [`parsers`] are the parsers
//! of its input files.
//!
//! `args` defines the options with their types, one module per command interprets them, and the
//! libraries below do the work.

mod args;
mod bake;
mod brdf;
mod camera;
mod charts;
mod clock;
mod content_key;
mod convert;
mod draft_list;
mod drawing;
mod engine;
mod exchange;
mod experiment;
mod failure;
mod form_factors;
mod generate;
mod grf;
mod in_place;
mod info;
mod input;
mod interrupt;
mod inventory;
mod kept_gltf;
mod known;
mod layers;
mod lettering;
mod machine_info;
mod matrix_info;
mod matrix_metrics;
mod model_table;
mod parts;
mod pass;
mod placement;
mod points;
mod probe;
mod progress_bar;
mod render;
mod report;
mod rtrace;
mod runner;
mod session;
mod short_help;
mod solve;
mod surroundings;
mod validate;
mod values;
mod views;
mod workbench;

use args::{Cli, Command};
use clap::Parser;
use failure::Failure;
use report::Report;
use runner::{Runner, Started, merge};
use session::Session;
use std::io::{self, Write};
use std::process::ExitCode;

/// Parsers of input other than models, public for tests and fuzzing.
pub mod parsers {
    pub use crate::experiment::parse_suite;
    pub use crate::points::{parse_points, parse_rays};
    pub use azulejo_formats::numpy::npy::{Array, read as parse_npy};

    /// The definition of the command line.
    #[must_use]
    pub fn command_line() -> clap::Command {
        <crate::args::Cli as clap::CommandFactory>::command()
    }
}

/// Parses the command line, runs the command, and prints why it failed, if it did.
///
/// Exit codes: 0 success, 1 failure, 2 usage error.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        // All processes would say the same.
        Err(e) if runner::is_silent() => {
            return ExitCode::from(u8::try_from(e.exit_code()).unwrap_or(2));
        }
        Err(e) => {
            // Help and version are also printed here; a closed pipe is not an error, a full disk is.
            let printed = e.print().and_then(|()| io::stdout().flush());
            if let Err(failure) = printed.map_err(Failure::from) {
                print_failure(&failure, false);
                return failure.exit_code();
            }
            return ExitCode::from(u8::try_from(e.exit_code()).unwrap_or(2));
        }
    };
    let common = cli.common;
    let is_one_of_many = runner::is_silent() && !runner::has_own_work(&cli.command);
    match runner::launch(cli, run) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if !is_one_of_many {
                print_failure(&failure, common.json);
            }
            failure.exit_code()
        }
    }
}

fn run(cli: Cli, started: Started) -> Result<(), Failure> {
    let mut session = Session::start(cli.common, started.setup())?;
    let report = match &cli.command {
        Command::Brdf { command } => return brdf::run(command, session),
        Command::Grf { command } => return grf::run(command, session),
        Command::Completions { shell } => return generate::completions(*shell),
        Command::Man { folder } => return generate::manual(folder),
        Command::View(args) => return workbench::run(args),
        Command::Info(args) if args.table => {
            let (report, end) = model_table::run(args, &mut session)?;
            session.print(report)?;
            return end;
        }
        Command::Info(args) => {
            let report = match matrix_info::run(args, &mut session)? {
                Some(report) => report,
                None => info::run(args, &mut session)?,
            };
            return session.print(report);
        }
        Command::Convert(args) => convert::run(args, &mut session)?,
        Command::Bake(args) if args.check => {
            let (report, end) = bake::check(args, &mut session)?;
            session.print(report)?;
            return end;
        }
        Command::Render(args) => render::run(args, &mut session)?,
        Command::Merge(args) => {
            let plan = merge::plan(args, &mut session)?;
            let report = divided(&plan.command, plan.runner(), &mut session)?;
            plan.finish(&mut session);
            report
        }
        Command::Exchange(args) => exchange::run(args, &mut session)?,
        Command::Experiment(args) => match experiment::run(args, &mut session)? {
            Some(report) if args.list => return session.print(report),
            Some(report) => report,
            None => return Ok(()),
        },
        Command::Validate(args) => {
            let (report, end) = validate::run(args, &mut session)?;
            session.finish(report)?;
            return end;
        }
        Command::Text(args) => lettering::run_text(args, &mut session)?,
        Command::Font { command } => lettering::run_font(command, &mut session)?,
        Command::Extrude(args) => lettering::run_extrude(args, &mut session)?,
        Command::Solve(_) | Command::Bake(_) | Command::Probe(_) | Command::FormFactors(_) => {
            let runner = Runner::new(&cli.command, started)?;
            divided(&cli.command, runner, &mut session)?
        }
    };
    session.finish(report)
}

/// Runs a command whose work can be divided.
fn divided(command: &Command, runner: Runner, session: &mut Session) -> Result<Report, Failure> {
    match command {
        Command::Solve(args) => solve::run(args, runner, session),
        Command::Bake(args) => bake::run(args, runner, session),
        Command::Probe(args) => probe::run(args, runner, session),
        Command::FormFactors(args) => form_factors::run(args, runner, session),
        _ => Err(Failure::misuse("the work of this command is not divided")),
    }
}

/// Prints the error on standard error, and with `--json` also as JSON on standard output.
fn print_failure(failure: &Failure, json: bool) {
    if matches!(failure, Failure::BrokenPipe | Failure::Found) {
        return;
    }
    let _ = writeln!(io::stderr(), "error: {failure}");
    if json {
        let value = serde_json::json!({ "error": failure.to_string() });
        let _ = writeln!(io::stdout(), "{value}");
    }
}
