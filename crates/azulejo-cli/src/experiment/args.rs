//! The options of `experiment`.

use clap::{Args, ValueHint};
use std::path::PathBuf;

/// `experiment`
#[derive(Debug, Args)]
pub struct ExperimentArgs {
    /// The suite of scenes, engines and settings (.toml)
    #[arg(value_name = "SUITE", value_hint = ValueHint::FilePath)]
    pub suite: PathBuf,
    /// Folder of the report; tasks completed there before are not repeated
    #[arg(long, short, value_name = "FOLDER", value_hint = ValueHint::DirPath,
          required_unless_present = "list")]
    pub output: Option<PathBuf>,
    /// List the tasks and exit
    #[arg(long)]
    pub list: bool,
    /// Run only the tasks whose names, as in --list, contain this
    #[arg(long, value_name = "NAME")]
    pub only: Option<String>,
    /// Run only the first setting of each engine on each scene, once
    #[arg(long)]
    pub quick: bool,
    /// Run one task and print its records: how the command runs each task in a process of its own
    #[arg(long, value_name = "KEY", hide = true)]
    pub task: Option<String>,
}

/// Examples below the help.
pub const EXAMPLES: &str = "\
Examples:
  azulejo experiment examples/experiments/truths.toml -o report
  azulejo experiment examples/experiments/diffuse.toml --list
  azulejo experiment examples/experiments/mirrors.toml -o report --only hybrid";
