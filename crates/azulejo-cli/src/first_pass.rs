//! Options of the first pass, which all commands that need light have.

use super::engine::EngineArgs;
use super::values::{self, TimeArg};
use clap::{Args, ValueEnum};
use jiff::Timestamp;
use std::time::Duration;

/// The subdivision into patches.
#[derive(Clone, Copy, Debug, Args)]
#[group(multiple = false)]
pub struct DivisionArgs {
    /// Approximate number of patches
    ///
    /// If the undivided faces alone are more than half of it, as in 3D text, half of it is added to
    /// them for subdividing the largest faces.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    pub patches: Option<u64>,
    /// Longest edge of a patch, in scene units; 0 leaves faces undivided
    #[arg(long, value_name = "LENGTH", value_parser = values::not_negative)]
    pub patch_size: Option<f64>,
}

/// The first pass.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "First pass")]
pub struct FirstPassArgs {
    #[command(flatten)]
    pub division: DivisionArgs,
    /// Target error, as in 1% or 0.01: stop when the estimated RMS error of the irradiance is below
    /// this fraction of its mean [default without --rays: 3%, with at most 2048 rays]
    ///
    /// The error is that of noise and discretization. docs/errors.md says what it means.
    #[arg(long, value_name = "SHARE", value_parser = values::fraction)]
    pub error: Option<f64>,
    /// Target error of each vertex or point relative to its own irradiance, instead of --error: for gauges in the dark
    ///
    /// Takes many more rays where the scene has dark places. Points darker than a thousandth of the mean are taken to
    /// have that. Not for lightmaps.
    #[arg(long, value_name = "SHARE", value_parser = values::fraction, conflicts_with = "error")]
    pub error_each: Option<f64>,
    /// Rays per patch, and maximum number of rays per vertex or point
    ///
    /// `bake` gathers with this number at every texel if neither --error nor --time is given, and does
    /// not interpolate.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub rays: Option<u32>,
    /// Time limit, as in 60s, 2m or 500ms: stop refining then, and keep the result with the error
    /// reached; or a date and time for which the sun is computed
    ///
    /// The command fails if part of the scene has no light by the limit. A date and time are as in
    /// 2025-06-21T14:00+02:00, at the LAT,LON of --place; both a limit and an instant may be given.
    #[arg(long, value_name = "TIME", value_parser = values::time)]
    pub time: Vec<TimeArg>,
    /// Maximum number of diffuse bounces [default: until converged]
    #[arg(long, value_name = "N")]
    pub bounces: Option<u32>,
    /// Memory limit, as in 8G, for the form factor matrix (a larger problem is solved without a
    /// matrix) and for the texels of a lightmap [default: half of the machine's memory]
    #[arg(long, value_name = "SIZE", value_parser = values::bytes)]
    pub memory: Option<u64>,
    /// Seed of the random numbers; the same seed gives the same result
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Gather light at every vertex or point. By default, indirect light is interpolated if there
    /// are thousands of them, as far as the target error permits
    #[arg(long)]
    pub no_interpolation: bool,
    /// Accept a solution in which more than 10% of the emitted power is unaccounted for
    #[arg(long)]
    pub allow_imbalance: bool,
    /// Write irradiance on the original vertices, without subdividing faces
    ///
    /// A glTF file that `solve` writes as glTF keeps all bytes that do not have to change; `bake --strip`
    /// restores it.
    #[arg(long)]
    pub keep_mesh: bool,
    /// Which side's irradiance surfaces store [default: by what the file says of each surface]
    ///
    /// By default: the front where the file says that backs are culled; both sides where it says
    /// that both are visible, or says nothing and the faces of the object contradict each other at
    /// more than 2% of their edges; otherwise the front, or the back if only that is lit. Sides are
    /// chosen for whole surfaces, faces that meet at edges. Closed surfaces lit from one side only
    /// store that one; with --keep-mesh all surfaces store one. GRF stores both sides of a face;
    /// GLB, glTF and PLY get a reversed copy of it. Where a picture shows a side that is not stored,
    /// its light is gathered.
    #[arg(long, value_name = "SIDES")]
    pub sides: Option<SidesArg>,
    #[command(flatten)]
    pub engine: EngineArgs,
}

impl FirstPassArgs {
    /// The error to reach, of all or of each.
    pub fn requested_error(&self) -> Option<f64> {
        self.error_each.or(self.error)
    }

    /// How long to work: the last that is given.
    pub fn limit(&self) -> Option<Duration> {
        self.time.iter().rev().find_map(|time| match time {
            TimeArg::Limit(limit) => Some(*limit),
            TimeArg::Instant(_) => None,
        })
    }

    /// The instant for which the sun is computed.
    pub fn instant(&self) -> Option<Timestamp> {
        self.time.iter().rev().find_map(|time| match time {
            TimeArg::Instant(instant) => Some(*instant),
            TimeArg::Limit(_) => None,
        })
    }
}

/// `--sides`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SidesArg {
    /// The front of every face
    Front,
    /// The side of each surface that is brighter by a quarter and three standard errors, otherwise
    /// the front
    Brighter,
    /// Both: sheets are written twice, with a reversed copy for the back
    Split,
    /// As by default, but without turning faces: what `--in-place` needs
    #[value(skip)]
    Unturned,
}
