//! What can be typed behind `form-factors`.

use crate::args::{DivisionArgs, InputArgs};
use crate::engine::EngineArgs;
use crate::values;
use azulejo_factors::Closure;
use clap::{Args, ValueEnum, ValueHint};
use std::path::PathBuf;

/// `form-factors`
#[derive(Debug, Args)]
pub struct FormFactorArgs {
    #[command(flatten)]
    pub input: InputArgs,
    /// Where to write: .npz (for scipy.sparse.load_npz), .csv, or View3D's .txt and .vf (text or
    /// binary, as its input says); `-` writes CSV to standard output
    #[arg(long, short, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,
    /// How to write it, whatever the file is called
    #[arg(long, value_name = "KIND", value_enum)]
    pub format: Option<FormatName>,
    #[command(flatten)]
    pub division: DivisionArgs,
    /// Rays from each patch; who says how many is given rays by --engine auto [default: 4096]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub rays: Option<u32>,
    /// Add the back side of every face as patches of their own
    #[arg(long)]
    pub two_sided: bool,
    /// Seed of the random numbers; the same seed gives the same result
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Memory that may be used; what needs more, by a forecast, is refused before it begins
    /// [default: what the machine has]
    #[arg(long, value_name = "SIZE", value_parser = values::bytes)]
    pub memory: Option<u64>,
    /// Keep no journal beside the output: interrupted work then starts from the beginning
    #[arg(long)]
    pub no_journal: bool,
    #[command(flatten)]
    pub matrix: MatrixArgs,
    #[command(flatten)]
    pub engine: EngineArgs,
}

/// Kinds of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FormatName {
    /// Sparse, for NumPy and SciPy
    Npz,
    /// A line for each entry
    Csv,
    /// View3D's output as text
    View3d,
    /// View3D's output in binary
    View3dBinary,
}

/// What is made of the form factors between patches.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Matrix")]
pub struct MatrixArgs {
    /// One row for each face, object or material instead of each patch
    #[arg(long, value_name = "WHAT", value_enum)]
    pub by: Option<GroupBy>,
    /// Whose rows are changed, within their standard errors, so that no light is missing: `closed`
    /// scenes without mirrors, `always` (open ones then sum to 1 with sky and ground), `never`
    #[arg(long, value_name = "WHEN", value_enum, num_args = 0..=1, require_equals = true,
          default_value = "closed", default_missing_value = "always")]
    pub closure: ClosureName,
    /// Leave out pairs of which neither gives the other this share of its light, and move their
    /// weight onto the rest: sums of rows and reciprocity stay
    #[arg(long, value_name = "SHARE", value_parser = values::fraction)]
    pub truncate: Option<f64>,
    /// Also write what comes straight, by one mirror, and by more mirrors or glass, each for itself
    #[arg(long)]
    pub separate: bool,
}

/// What becomes one row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum GroupBy {
    /// Each face of each object
    Face,
    /// Each object
    Object,
    /// All that has the same material
    Material,
}

/// Whose rows are made to add up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ClosureName {
    /// Nobody's
    Never,
    /// Those of closed scenes without mirrors and glass
    Closed,
    /// All
    Always,
}

impl From<ClosureName> for Closure {
    fn from(name: ClosureName) -> Closure {
        match name {
            ClosureName::Never => Closure::Never,
            ClosureName::Closed => Closure::Closed,
            ClosureName::Always => Closure::Always,
        }
    }
}

/// How people use it.
pub const EXAMPLES: &str = "\
Examples:
  azulejo form-factors room.obj -o f.npz --patches 2000 --rays 4096
  azulejo form-factors room.obj -o f.csv --patch-size 0 --by object --closure
  azulejo form-factors room.vs3 -o f.txt
  azulejo form-factors street.obj -o f.npz --by face --truncate 0.01% --memory 8G
  python3 -c 'import scipy.sparse as s; print(s.load_npz(\"f.npz\").sum(axis=1))'

Row i, column j: the share of the light leaving i diffusely that arrives at j, with its standard
error. A patch counts by its front and blocks light from both sides. What leaves the scene upwards
and downwards is in lines to \"sky\" and \"ground\" of a CSV and in arrays of that name of an .npz.

The same command goes on where it was interrupted: what is done is kept in FILE.journal until FILE
is complete. docs/form-factors.md describes files, errors, closure and truncation.";
