//! The program: its commands as clap parses them, each defined by its own module, and which code runs each.

mod generate;
mod recorded;
mod short_help;

use crate::brdf::{self, BRDF_EXAMPLES, BrdfCommand};
use crate::failure::Failure;
use crate::grf::{self, GRF_EXAMPLES, GrfCommand};
use crate::lettering::{
    self, EXTRUDE_EXAMPLES, ExtrudeArgs, FONT_EXAMPLES, FontCommand, TEXT_EXAMPLES, TextArgs,
};
use crate::parts::{self, MergeArgs};
use crate::report::Report;
use crate::runner::merge::MergePlan;
use crate::runner::{self, Runner, Started};
use crate::session::{CommonArgs, Session};
use crate::{
    bake, convert, exchange, experiment, form_factors, info, matrix_info, model_table, probe,
    render, solve, validate, workbench,
};
use clap::{Parser, Subcommand, ValueHint};
use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

/// Global illumination for the models people already have.
///
/// Reads a model, computes the irradiance on its surfaces, and renders and measures it.
#[derive(Debug, Parser)]
#[command(name = "azulejo", version, max_term_width = 100, after_help = EXAMPLES)]
pub struct Cli {
    /// The command.
    #[command(subcommand)]
    pub command: Command,
    /// The options of every command.
    #[command(flatten)]
    pub common: CommonArgs,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Show what a model, or a matrix of form factors (.npz), contains
    #[command(after_help = info::EXAMPLES)]
    Info(info::InfoArgs),
    /// Read models, merge them and write them in another format
    #[command(after_help = convert::EXAMPLES)]
    Convert(convert::ConvertArgs),
    /// Solve the light: compute the irradiance at the vertices (first pass)
    #[command(mut_args = short_help::showing(short_help::SOLVE), after_help = short_help::ending(solve::args::EXAMPLES),
              after_long_help = solve::args::EXAMPLES)]
    Solve(solve::args::SolveArgs),
    /// Bake a lightmap: irradiance in the texels of a second set of texture coordinates
    #[command(mut_args = short_help::showing(short_help::BAKE), after_help = short_help::ending(bake::args::EXAMPLES),
              after_long_help = bake::args::EXAMPLES)]
    Bake(bake::args::BakeArgs),
    /// Render an image (second pass); solves the light first if the scene has no irradiance yet
    #[command(mut_args = short_help::showing(short_help::RENDER), after_help = short_help::ending(render::args::EXAMPLES),
              after_long_help = render::args::EXAMPLES)]
    Render(render::args::RenderArgs),
    /// Measure irradiance at points, or radiance or hits along rays
    #[command(mut_args = short_help::showing(short_help::PROBE), after_help = short_help::ending(probe::EXAMPLES),
              after_long_help = probe::EXAMPLES)]
    Probe(probe::ProbeArgs),
    /// Compute the matrix of form factors between patches
    #[command(mut_args = short_help::showing(short_help::FORM_FACTORS), after_help = short_help::ending(form_factors::args::EXAMPLES),
              after_long_help = form_factors::args::EXAMPLES)]
    FormFactors(form_factors::args::FormFactorArgs),
    /// Combine the parts that several runs of a command computed
    #[command(after_help = parts::EXAMPLES)]
    Merge(MergeArgs),
    /// Radiative exchange from form factors: conductances, temperatures and heat fluxes
    #[command(mut_args = short_help::showing(short_help::EXCHANGE), after_help = short_help::ending(exchange::args::EXAMPLES),
              after_long_help = exchange::args::EXAMPLES)]
    Exchange(exchange::args::ExchangeArgs),
    /// Compare form factor engines: run a suite of scenes and settings and report times and errors
    #[command(after_help = experiment::args::EXAMPLES)]
    Experiment(experiment::args::ExperimentArgs),
    /// Validate azulejo against closed-form solutions, energy balances and its own error estimates,
    /// and write a report
    #[command(after_help = validate::args::EXAMPLES)]
    Validate(validate::args::ValidateArgs),
    /// Make 3D text from a font
    #[command(after_help = TEXT_EXAMPLES)]
    Text(TextArgs),
    /// Convert fonts and draw specimen sheets
    #[command(after_help = FONT_EXAMPLES)]
    Font {
        /// The subcommand
        #[command(subcommand)]
        command: FontCommand,
    },
    /// Extrude a drawing (SVG, DXF or PDF) to a solid
    #[command(after_help = EXTRUDE_EXAMPLES)]
    Extrude(ExtrudeArgs),
    /// Evaluate, plot, check and fit reflection models
    #[command(after_help = BRDF_EXAMPLES)]
    Brdf {
        /// The subcommand
        #[command(subcommand)]
        command: BrdfCommand,
    },
    /// Format, check and compare GRF files
    #[command(after_help = GRF_EXAMPLES)]
    Grf {
        /// The subcommand
        #[command(subcommand)]
        command: GrfCommand,
    },
    /// Open the workbench, the graphical application to view, light and save models
    #[command(after_help = workbench::EXAMPLES)]
    View(workbench::WorkbenchArgs),
    /// Print a completion script for a shell
    #[command(after_help = COMPLETIONS_EXAMPLES)]
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Write the manual pages to a folder
    #[command(after_help = MAN_EXAMPLES)]
    Man {
        /// An existing folder
        #[arg(value_name = "DIR", value_hint = ValueHint::DirPath)]
        folder: PathBuf,
    },
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
    let is_one_of_many = runner::is_silent() && recorded::shard_of(&cli.command).is_none();
    match launch(cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if !is_one_of_many {
                print_failure(&failure, common.json);
            }
            failure.exit_code()
        }
    }
}

/// Runs the command, by all processes that a launcher started to share it, if there are several.
fn launch(cli: Cli) -> Result<(), Failure> {
    if !runner::is_started_together() || recorded::shard_of(&cli.command).is_some() {
        return run(cli, Started::alone());
    }
    refuse_unshared(&cli.command)?;
    runner::launch(cli, recorded::files_of, run)
}

/// Refuses commands whose work several processes cannot share.
fn refuse_unshared(command: &Command) -> Result<(), Failure> {
    match command {
        Command::FormFactors(args) if args.matrix.compress.is_some() => Err(Failure::misuse(
            "--compress: factors in blocks are not shared among MPI processes: run it without mpiexec",
        )),
        Command::FormFactors(_) | Command::Solve(_) | Command::Probe(_) => Ok(()),
        Command::Bake(args) if !args.check && !args.strip => Ok(()),
        _ => Err(Failure::misuse(
            "this command does not share its work among MPI processes: run it without mpiexec; form-factors, solve, bake \
             and probe do",
        )),
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
        Command::Bake(args) if args.verify => {
            let (report, end) = bake::verify(args, &mut session)?;
            session.print(report)?;
            return end;
        }
        Command::Render(args) => render::run(args, &mut session)?,
        Command::Merge(args) => {
            let plan = MergePlan::open(args, &mut session)?;
            let command = recorded::merged(&plan, args, &mut session)?;
            let report = divided(&command, plan.runner(), &mut session)?;
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
            let runner = Runner::new(
                recorded::shard_of(&cli.command),
                recorded::described,
                started,
            )?;
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

const EXAMPLES: &str = "\
Examples:
  azulejo render examples/cornell.grf -o cornell.png
  azulejo solve room.obj -o room.grf --error 1%
  azulejo render room.grf -o room.exr --size 1280x720 --spp 64

Exit codes: 0 success, 1 failure (an existing output file is left unchanged), 2 usage error.";

const COMPLETIONS_EXAMPLES: &str = "\
Examples:
  azulejo completions bash > ~/.local/share/bash-completion/completions/azulejo
  azulejo completions zsh > ~/.zfunc/_azulejo";

const MAN_EXAMPLES: &str = "\
Examples:
  azulejo man ~/.local/share/man/man1";

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_is_sound() {
        Cli::command().debug_assert();
    }

    #[test]
    fn every_command_has_examples() {
        for command in Cli::command().get_subcommands() {
            let help = command.get_after_help().map(ToString::to_string);
            let call = format!("azulejo {}", command.get_name());
            assert!(help.is_some_and(|h| h.contains(&call)), "{call}");
        }
    }

    #[test]
    fn misuse_is_refused() {
        let parse = |line: &str| Cli::try_parse_from(line.split(' '));
        assert!(parse("azulejo solve a.grf -o b.grf --patches 10 --patch-size 1").is_err());
        assert!(parse("azulejo probe a.grf --points p --hits r").is_err());
        assert!(parse("azulejo probe a.grf").is_err());
        assert!(parse("azulejo render -o x.png").is_err());
        assert!(parse("azulejo solve a.grf -o b.grf --resolution 7").is_err());
        assert!(parse("azulejo solve a.grf -o b.grf --engine radiance").is_err());
        assert!(parse("azulejo render a.grf -o x.png --from -1,2,-3 --exposure -1.5").is_ok());
    }
}
