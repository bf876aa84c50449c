//! Arguments of `validate`.

use crate::engine::EngineName;
use clap::{Args, ValueHint};
use std::path::PathBuf;

/// `validate`
#[derive(Debug, Args)]
pub struct ValidateArgs {
    /// Folder of the report: index.html, its plots, results.csv and results.json
    #[arg(long, short, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    pub output: PathBuf,
    /// Engines to check [default: all that are available on this machine]
    #[arg(long, value_name = "ENGINE,...", value_enum, value_delimiter = ',')]
    pub engine: Vec<EngineName>,
    /// Run only the checks whose part of the report, case or scene has this in its name
    #[arg(long, value_name = "NAME")]
    pub only: Option<String>,
    /// Use all rays, pixels and repetitions: eight times as many rays, in ten times the time
    #[arg(long)]
    pub full: bool,
    /// Also let the other programs for form factors that are installed answer the closed forms: View3D
    /// (`view3d` on the path, or named by VIEW3D), and pyviewfactor and raystrack of `python3`
    #[arg(long)]
    pub peers: bool,
    /// Seed of the random numbers; the same seed gives the same report, except for times
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
}

/// Examples and notes below the help.
pub const EXAMPLES: &str = "\
Examples:
  azulejo validate -o report
  azulejo validate -o report --full
  azulejo validate -o report --engine rays,analytic
  azulejo validate -o report --only \"error bars\"
  azulejo validate -o report --only closed --engine analytic --peers

The report tells what was compared with what, and when a check passes. docs/validation.md has the figures
of a release.

Exit codes: 0 every check passed, 1 one or more failed (the report is written), 2 usage error.";
