//! The options of `solve`.

use crate::first_pass::FirstPassArgs;
use crate::input::InputArgs;
use crate::parts::PartArgs;
use crate::values;
use clap::{Args, ValueHint};
use std::path::PathBuf;

/// `solve`
#[derive(Debug, Args)]
pub struct SolveArgs {
    /// Output file for the scene with its irradiance, its format chosen by extension: .grf, .glb,
    /// .gltf or .ply; `-` writes GRF to standard output
    #[arg(long, short, value_name = "OUT", value_hint = ValueHint::FilePath,
          required_unless_present = "in_place")]
    pub output: Option<PathBuf>,
    /// Write the irradiance into the text of the GRF file itself, or of a copy of it at OUT, and leave
    /// every other byte as it is: comments, layout, names, transforms, parameters
    ///
    /// `irad` is added before each vertex, or replaced. No face is divided or turned: light on backs,
    /// and that of exact shapes and reflecting primitives, goes into extensions after the object.
    /// Includes with surfaces are replaced by the included text, because each use of a part has
    /// light of its own; their files are not changed.
    #[arg(long)]
    pub in_place: bool,
    /// Significant digits of the numbers of meshes in text formats; with --in-place, of the
    /// irradiance alone [default: as many as the exact values need; with --in-place: 6]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(4..=17))]
    pub digits: Option<u8>,
    /// Triangulate all polygons of OUT, or keep them [default: yes for .ply, otherwise no]
    #[arg(long, value_name = "yes|no", num_args = 0..=1, require_equals = true,
          default_missing_value = "yes", value_parser = values::yes_or_no)]
    pub triangles: Option<bool>,
    #[command(flatten)]
    pub part: PartArgs,
    #[command(flatten)]
    pub first_pass: FirstPassArgs,
    #[command(flatten)]
    pub input: InputArgs,
}

/// Examples below the help.
pub const EXAMPLES: &str = "\
Examples:
  azulejo solve room.obj -o room.grf
  azulejo solve room.obj -o room.grf --patches 20000 --error 1%
  azulejo solve level.glb -o level-lit.glb --keep-mesh
  azulejo solve hut.obj -o hut.glb --sides split
  azulejo solve scene.grf --in-place
  azulejo solve room.obj -o room.grf --patch-size 0.1 --time 60s --json
  azulejo solve room.obj -o room.grf --engine embree";
