//! The options of `grf`.

use super::super::input::ReadingArgs;
use clap::{Args, Subcommand, ValueHint};
use std::path::PathBuf;

/// `grf`
#[derive(Debug, Subcommand)]
pub enum GrfCommand {
    /// Format files canonically; comments, words and numbers are kept
    #[command(after_help = FMT_EXAMPLES)]
    Fmt(FmtArgs),
    /// Report problems in files, with line, column and the name of the rule
    #[command(after_help = LINT_EXAMPLES)]
    Lint(LintArgs),
    /// Compare the contents of two scenes, whatever their layout or format
    #[command(after_help = DIFF_EXAMPLES)]
    Diff(DiffArgs),
}

/// `grf fmt`
#[derive(Debug, Args)]
pub struct FmtArgs {
    /// GRF files, changed in place; `-` reads standard input and writes to standard output
    #[arg(value_name = "FILE", required = true, value_hint = ValueHint::FilePath)]
    pub files: Vec<PathBuf>,
    /// Change nothing, list the files that would change, and exit with 1 if there are any
    #[arg(long)]
    pub check: bool,
}

/// `grf lint`
#[derive(Debug, Args)]
pub struct LintArgs {
    /// GRF files; `-` is standard input
    #[arg(value_name = "FILE", required = true, value_hint = ValueHint::FilePath)]
    pub files: Vec<PathBuf>,
    /// Rules to skip
    #[arg(long, value_name = "RULE")]
    pub skip: Vec<String>,
    /// Also read files in this folder that a scene refers to by `..` or an absolute path
    #[arg(long, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    pub allow: Vec<PathBuf>,
}

/// `grf diff`
#[derive(Debug, Args)]
pub struct DiffArgs {
    /// The first model, of any format
    #[arg(value_name = "A", value_hint = ValueHint::FilePath)]
    pub one: PathBuf,
    /// The second model
    #[arg(value_name = "B", value_hint = ValueHint::FilePath)]
    pub other: PathBuf,
    /// Largest difference of positions that is ignored, relative to the size of the scene
    #[arg(long, value_name = "SHARE", default_value_t = 0.0)]
    pub tolerance: f64,
    #[command(flatten)]
    pub reading: ReadingArgs,
}

/// Examples of `grf`.
pub const GRF_EXAMPLES: &str = "\
Examples:
  azulejo grf fmt scene.grf
  azulejo grf lint *.grf
  azulejo grf diff before.grf after.grf";

const FMT_EXAMPLES: &str = "\
Examples:
  azulejo grf fmt scene.grf parts/*.grf
  azulejo grf fmt --check *.grf
  azulejo grf fmt - < scene.grf

Exit codes: 0 success, with --check all files are formatted so; 1 failure, with --check some are not;
2 usage error.";

const LINT_EXAMPLES: &str = "\
Examples:
  azulejo grf lint scene.grf
  azulejo grf lint *.grf --skip unused-vertex

Rules: syntax, missing-include, missing-file, energy, reciprocity, negative-light, unused-definition,
defined-twice, unknown-extension, unknown-key, degenerate-face, repeated-corner, unused-vertex,
normal-length, missing-attribute, attribute-twice, missing-comma, stray-dot, no-effect,
shared-vertices, warning.
Exit codes: 0 no problems, 1 problems found, 2 usage error.";

const DIFF_EXAMPLES: &str = "\
Examples:
  azulejo grf diff before.grf after.grf
  azulejo grf diff room.obj room.grf --tolerance 1e-6
  azulejo grf diff quick.grf slow.grf --json

Objects are compared by name, those of one name in their order; materials and lights in theirs.
Exit codes: 0 equal, 1 different, 2 error.";
