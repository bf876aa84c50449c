//! `convert`: reads models and writes them as one.

use super::failure::Failure;
use super::input::{self, ClockArgs, InputArgs};
use super::report::{Report, count};
use super::session::Session;
use super::values;
use azulejo::models::ModelOutput;
use azulejo_scene::Scene;
use clap::{Args, ValueHint};
use std::path::PathBuf;

/// `convert`
#[derive(Debug, Args)]
pub struct ConvertArgs {
    /// Output file, its format chosen by extension: .grf, .obj (with an .mtl), .glb, .gltf (with a
    /// .bin), .ply, .wrl, .x3d, .dxf, .stl, .3mf, .sff or .vs3; a single file is compressed if .gz
    /// follows; `-` writes GRF to standard output
    #[arg(long, short, value_name = "OUT", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,
    /// Write GRF as of 2001, without extensions: parallelogram lamps as `light`, exact shapes as
    /// meshes, matt surfaces as `rgb`; what it cannot express is listed
    #[arg(long)]
    pub plain: bool,
    /// Triangulate all polygons, for programs that read triangles only, or keep them [default: yes for
    /// .ply, otherwise no]
    #[arg(long, value_name = "yes|no", num_args = 0..=1, require_equals = true,
          default_missing_value = "yes", value_parser = values::yes_or_no)]
    pub triangles: Option<bool>,
    /// Significant digits of the numbers of meshes in text formats [default: as many as the exact
    /// values need]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(4..=17))]
    pub digits: Option<u8>,
    #[command(flatten)]
    pub polygons: PolygonArgs,
    #[command(flatten)]
    pub clock: ClockArgs,
    #[command(flatten)]
    pub input: InputArgs,
}

/// The polygons of exact shapes.
#[derive(Clone, Copy, Debug, Args)]
pub struct PolygonArgs {
    /// Largest distance of polygons from the exact shapes that they replace, in scene units [default: a thousandth of
    /// the size of a shape]
    #[arg(long, value_name = "LENGTH", value_parser = values::positive, allow_hyphen_values = true,
          help_heading = "Polygons")]
    pub tolerance: Option<f64>,
}

/// Examples below the help.
pub const EXAMPLES: &str = "\
Examples:
  azulejo convert tank.flt -o tank.glb --lod coarsest
  azulejo convert room.dxf chair.3ds -o room.grf --up y --unit m \\
      --place chair.3ds:scale=0.01,rotate=0,30,0,translate=2,0,1";

/// Runs `convert`.
pub fn run(args: &ConvertArgs, session: &mut Session) -> Result<Report, Failure> {
    let output = if args.plain {
        ModelOutput::check_plain(&args.output)?
    } else {
        ModelOutput::check(&args.output)?
    }
    .with_tolerance(args.polygons.tolerance)?
    .with_triangles(args.triangles);
    let digits = checked_digits(args.digits, &output)?;
    session.claim_stdout(output.is_stdout())?;
    let mut scene = input::read_all(&args.input, args.clock, session)?;
    round(&mut scene, digits);
    session.write(&scene, &output)?;
    let mut report = Report::default();
    report.value("objects", scene.objects.len());
    report.value("materials", scene.materials.len());
    let path = args.output.display().to_string();
    let words = format!(
        "{path}: {} objects, {} materials",
        count(scene.objects.len()),
        count(scene.materials.len())
    );
    report.fact("output", path, "wrote", words);
    Ok(report)
}

/// The number of digits, if the format has digits.
pub fn checked_digits(digits: Option<u8>, output: &ModelOutput) -> Result<Option<u8>, Failure> {
    let format = output.format();
    if digits.is_some() && !format.is_text() {
        return Err(Failure::misuse(format_args!(
            "--digits applies to text formats; {} has numbers of fixed size",
            format.name
        )));
    }
    Ok(digits)
}

/// Gives the numbers of all meshes this many digits.
pub fn round(scene: &mut Scene, digits: Option<u8>) {
    if let Some(digits) = digits {
        scene.round_meshes(usize::from(digits));
    }
}
