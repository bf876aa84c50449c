//! `view`: starts the workbench.
//!
//! It depends on hundreds of crates for its window, so it is a program of its own.

use super::failure::Failure;
use clap::{Args, ValueHint};
use std::env::consts::EXE_SUFFIX;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

/// `view`
#[derive(Debug, Args)]
pub struct WorkbenchArgs {
    /// Models to open
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub files: Vec<PathBuf>,
    /// Run a script of steps, one per line
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub script: Option<PathBuf>,
    /// Write a screenshot (PNG) once all is loaded and the script has run, and exit
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub screenshot: Option<PathBuf>,
    /// Open a lesson of the lab, 1 to 8, with its scene
    #[arg(long, value_name = "NUMBER")]
    pub lab: Option<String>,
    /// Language of the window: en, es, pt
    #[arg(long, value_name = "CODE")]
    pub language: Option<String>,
    /// Neither read nor write preferences and recovery files
    #[arg(long)]
    pub no_preferences: bool,
}

/// Examples below the help.
pub const EXAMPLES: &str = "\
Examples:
  azulejo view room.3ds lamp.glb
  azulejo view --script steps.txt --screenshot out.png
  azulejo view --lab 3 --language es

The workbench is a separate program, azulejo-workbench, next to this one or on the PATH. To build it
from azulejo's source:
  cargo build --release -p azulejo-workbench";

/// Its name, without the extension of programs.
const PROGRAM: &str = "azulejo-workbench";

/// Runs the workbench until its window is closed; fails if it fails.
pub fn run(args: &WorkbenchArgs) -> Result<(), Failure> {
    let program = find().ok_or_else(|| Failure::Failed(advice(args)))?;
    let mut command = Command::new(&program);
    command.args(arguments(args));
    become_it(command, &program)
}

/// Becomes the workbench: there is one process, so that a signal to this command ends the window,
/// and its status is that of the command.
#[cfg(unix)]
fn become_it(mut command: Command, program: &Path) -> Result<(), Failure> {
    use std::os::unix::process::CommandExt;
    // It only returns if it failed.
    Err(Failure::file("start", program, &command.exec()))
}

/// Starts the workbench and waits for it: elsewhere a process cannot become another program. Ctrl-C
/// and closing the console reach both, as they are attached to the same one.
#[cfg(not(unix))]
fn become_it(mut command: Command, program: &Path) -> Result<(), Failure> {
    let status = command.status();
    let status = status.map_err(|e| Failure::file("start", program, &e))?;
    match status.code() {
        Some(0) => Ok(()),
        // It has printed the reason.
        Some(code) => Err(Failure::Failed(format!(
            "the workbench exited with status {code}"
        ))),
        None => Err(Failure::failed("the workbench was killed")),
    }
}

/// The workbench next to this program, or on the PATH.
fn find() -> Option<PathBuf> {
    let name = format!("{PROGRAM}{EXE_SUFFIX}");
    let own = std::env::current_exe().ok();
    let beside = own.as_deref().and_then(Path::parent).map(|f| f.join(&name));
    let path = std::env::var_os("PATH").unwrap_or_default();
    let others = std::env::split_paths(&path).map(|folder| folder.join(&name));
    beside.into_iter().chain(others).find(|p| p.is_file())
}

/// The arguments of the workbench.
fn arguments(args: &WorkbenchArgs) -> Vec<OsString> {
    let mut words = Vec::new();
    for (option, value) in [
        ("--script", &args.script),
        ("--screenshot", &args.screenshot),
    ] {
        if let Some(value) = value {
            words.extend([option.into(), value.clone().into_os_string()]);
        }
    }
    // The workbench knows its lessons and languages.
    for (option, value) in [("--lab", &args.lab), ("--language", &args.language)] {
        words.extend(value.iter().flat_map(|value| [option.into(), value.into()]));
    }
    if args.no_preferences {
        words.push("--no-preferences".into());
    }
    // File names may start with a dash.
    words.push("--".into());
    words.extend(args.files.iter().map(|f| f.clone().into_os_string()));
    words
}

fn advice(args: &WorkbenchArgs) -> String {
    let words: Vec<String> = (arguments(args).iter())
        .map(|w| w.to_string_lossy().into_owned())
        .filter(|w| w != "--")
        .collect();
    format!(
        "there is no {PROGRAM} next to this program or on the PATH; to build and run it from \
         azulejo's source: cargo run --release -p {PROGRAM} -- {}",
        words.join(" ")
    )
}
