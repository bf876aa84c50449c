//! Shell completions and manual pages, generated from the definition of the command line.

use super::Cli;
use crate::failure::Failure;
use azulejo::output::Output;
use azulejo_trace::Progress;
use clap::CommandFactory;
use std::io::{self, Write};
use std::path::Path;

/// Prints a completion script.
pub fn completions(shell: clap_complete::Shell) -> Result<(), Failure> {
    // Generated in memory, because clap panics if the pipe is closed.
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "azulejo", &mut script);
    let mut out = io::stdout().lock();
    out.write_all(&script)?;
    Ok(out.flush()?)
}

/// Writes `azulejo.1` and one page per command.
pub fn manual(folder: &Path) -> Result<(), Failure> {
    let mut cli = Cli::command().disable_help_subcommand(true);
    cli.build();
    pages(cli, folder)
}

/// Writes the page of a command, and those of its subcommands.
fn pages(command: clap::Command, folder: &Path) -> Result<(), Failure> {
    let inner = command.get_subcommands().filter(|c| c.get_name() != "help");
    inner.cloned().try_for_each(|c| pages(c, folder))?;
    page(command, folder)
}

fn page(command: clap::Command, folder: &Path) -> Result<(), Failure> {
    let page = clap_mangen::Man::new(command);
    let mut text = Vec::new();
    page.render(&mut text)?;
    let output = Output::check(&folder.join(page.get_filename()))?;
    Ok(output.write(&Progress::new(), |out| out.write_all(&text))?)
}
