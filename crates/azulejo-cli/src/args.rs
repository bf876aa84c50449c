//! What can be typed. Values are typed here; what they mean is for the commands to say.

use super::brdf::{BRDF_EXAMPLES, BrdfCommand};
use super::engine::EngineArgs;
use super::form_factors;
use super::lettering::{
    EXTRUDE_EXAMPLES, ExtrudeArgs, FONT_EXAMPLES, FontCommand, TEXT_EXAMPLES, TextArgs,
};
use super::placement::{self, Placement};
use super::values::{self, UpArg};
use azulejo_formats::{Lod, ReadOptions};
use azulejo_render::rtrace::Side;
use clap::{Args, Parser, Subcommand, ValueEnum, ValueHint};
use glam::DVec3;
use std::path::PathBuf;
use std::time::Duration;

/// Global illumination for the models people already have.
///
/// A model goes in; irradiance on its vertices, pictures and measurements come out.
#[derive(Debug, Parser)]
#[command(name = "azulejo", version, max_term_width = 100, after_help = EXAMPLES)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// How to do it.
    #[command(flatten)]
    pub common: CommonArgs,
}

/// Switches of every command.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Everywhere")]
pub struct CommonArgs {
    /// Print one JSON object on standard output instead of words
    #[arg(long, global = true)]
    pub json: bool,
    /// Print nothing but errors: no progress, no warnings, no summary
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Threads to work with [default: one per processor core]
    #[arg(long, global = true, value_name = "N",
          value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Say what is in a model
    #[command(after_help = INFO_EXAMPLES)]
    Info(InfoArgs),
    /// Read models, merge them, write them in another format
    #[command(after_help = CONVERT_EXAMPLES)]
    Convert(ConvertArgs),
    /// First pass: find the irradiance and write it onto the vertices
    #[command(after_help = SOLVE_EXAMPLES)]
    Solve(SolveArgs),
    /// Second pass: make a picture; solves first when the scene carries no irradiance
    #[command(after_help = RENDER_EXAMPLES)]
    Render(RenderArgs),
    /// Measure: irradiance at points, radiance or hits along rays
    #[command(after_help = PROBE_EXAMPLES)]
    Probe(ProbeArgs),
    /// Write the matrix of form factors between patches
    #[command(after_help = form_factors::args::EXAMPLES)]
    FormFactors(form_factors::args::FormFactorArgs),
    /// Compare engines: run a suite of scenes and settings, and report times and errors
    #[command(after_help = EXPERIMENT_EXAMPLES)]
    Experiment(ExperimentArgs),
    /// Make solid letters of a text
    #[command(after_help = TEXT_EXAMPLES)]
    Text(TextArgs),
    /// Convert typefaces, and look at them
    #[command(after_help = FONT_EXAMPLES)]
    Font {
        /// What to do with them
        #[command(subcommand)]
        command: FontCommand,
    },
    /// Make a solid of a flat drawing, SVG or DXF
    #[command(after_help = EXTRUDE_EXAMPLES)]
    Extrude(ExtrudeArgs),
    /// Reflection models: evaluate, draw, check and fit them
    #[command(after_help = BRDF_EXAMPLES)]
    Brdf {
        /// What to do with them
        #[command(subcommand)]
        command: BrdfCommand,
    },
    /// Open the workbench: a window to look at models, light them and save them
    #[command(after_help = VIEW_EXAMPLES)]
    View(WorkbenchArgs),
    /// Print a completion script for a shell
    #[command(after_help = COMPLETIONS_EXAMPLES)]
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Write the manual pages into a folder
    #[command(after_help = MAN_EXAMPLES)]
    Man {
        /// An existing folder
        #[arg(value_name = "DIR", value_hint = ValueHint::DirPath)]
        folder: PathBuf,
    },
}

/// What the workbench is started with.
#[derive(Debug, Args)]
pub struct WorkbenchArgs {
    /// Models to open
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub files: Vec<PathBuf>,
    /// Play a list of steps, one a line
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub script: Option<PathBuf>,
    /// Write a picture of the window, PNG, when all is loaded and the script is done, and end
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub screenshot: Option<PathBuf>,
    /// Neither read nor write preferences and copies for recovery
    #[arg(long)]
    pub no_preferences: bool,
}

/// Which models to read.
#[derive(Debug, Args)]
pub struct InputArgs {
    /// Model files; several are merged into one scene. `-` is standard input
    #[arg(value_name = "SCENE", required = true, value_hint = ValueHint::FilePath)]
    pub scenes: Vec<PathBuf>,
    /// Add the point lights of a camera file (.json)
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub lights: Option<PathBuf>,
    #[command(flatten)]
    pub reading: ReadingArgs,
}

/// How models are read and put together.
#[derive(Debug, Args)]
#[command(next_help_heading = "Reading")]
pub struct ReadingArgs {
    /// Where one of the models goes: FILE:translate=1,0,2,rotate=0,90,0,scale=2, done in the
    /// order written (degrees about x, y, z; one scale or three), or fit=2 to give it that largest
    /// side and stand it on the origin; also up=z and unit=mm for a model that does not say its
    /// own, and name=lamp for its branch
    #[arg(long, value_name = "FILE:HOW", value_parser = placement::parse)]
    pub place: Vec<Placement>,
    /// Which axis points up in the scene; models with another are turned [default: that of the
    /// first model]. For `render` also a direction X,Y,Z that points up in the picture alone
    #[arg(long, value_name = "y|z", value_parser = values::up, allow_hyphen_values = true)]
    pub up: Option<UpArg>,
    /// Unit of the scene's lengths: mm, cm, m, km, in, ft, or a number of metres; models that say
    /// another are scaled [default: that of the first model]
    #[arg(long, value_name = "UNIT", value_parser = values::unit)]
    pub unit: Option<f64>,
    /// Level of detail, where a model has several: finest, coarsest, all, or what is seen from a
    /// distance
    #[arg(long, value_name = "LEVEL", default_value = "finest", value_parser = values::lod)]
    pub lod: Lod,
    /// Fail when anything in a model had to be skipped or mended
    #[arg(long)]
    pub strict: bool,
    /// Most vertices and corners that the instances and curves of a model may unfold to
    #[arg(long, value_name = "N", default_value_t = ReadOptions::default().most_elements)]
    pub most_elements: u64,
    /// Also read files from this folder when a model names them by `..` or an absolute path
    #[arg(long, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    pub allow: Vec<PathBuf>,
}

/// `info`
#[derive(Debug, Args)]
pub struct InfoArgs {
    #[command(flatten)]
    pub input: InputArgs,
}

/// `convert`
#[derive(Debug, Args)]
pub struct ConvertArgs {
    #[command(flatten)]
    pub input: InputArgs,
    /// Where to write, by extension: .grf, .obj (with its .mtl beside), .glb, .gltf or .ply; `-`
    /// writes GRF to standard output
    #[arg(long, short, value_name = "OUT", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,
}

/// How finely the surfaces are divided.
#[derive(Clone, Copy, Debug, Args)]
#[group(multiple = false)]
pub struct DivisionArgs {
    /// About how many patches to divide the surfaces into
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    pub patches: Option<u64>,
    /// Longest edge of a patch, in scene units; 0 leaves faces whole
    #[arg(long, value_name = "LENGTH", value_parser = values::not_negative)]
    pub patch_size: Option<f64>,
}

/// The first pass.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "First pass")]
pub struct FirstPassArgs {
    #[command(flatten)]
    pub division: DivisionArgs,
    /// Stop when the estimated relative error of the irradiance (RMS) is below this: 1% or 0.01
    /// [default without --rays: 3%, or what 2048 rays give]
    #[arg(long, value_name = "SHARE", value_parser = values::fraction)]
    pub error: Option<f64>,
    /// Rays from each patch, and most from each vertex or point
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub rays: Option<u32>,
    /// Stop refining after this time and keep what there is: 60s, 2m, 500ms
    #[arg(long, value_name = "TIME", value_parser = values::duration)]
    pub time: Option<Duration>,
    /// How often light is reflected diffusely [default: until it has converged]
    #[arg(long, value_name = "N")]
    pub bounces: Option<u32>,
    /// Memory for the matrix of form factors; above it, the pass does without a matrix
    /// [default: half of the machine's]
    #[arg(long, value_name = "SIZE", value_parser = values::bytes)]
    pub memory: Option<u64>,
    /// Seed of the random numbers; the same seed gives the same result
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Write irradiance on the vertices as they are, without dividing faces
    #[arg(long)]
    pub keep_mesh: bool,
    #[command(flatten)]
    pub engine: EngineArgs,
}

/// `solve`
#[derive(Debug, Args)]
pub struct SolveArgs {
    #[command(flatten)]
    pub input: InputArgs,
    /// Where to write the scene with its light, by extension: .grf, .glb, .gltf or .ply; `-` writes
    /// GRF to standard output
    #[arg(long, short, value_name = "OUT", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,
    #[command(flatten)]
    pub first_pass: FirstPassArgs,
}

/// How radiance becomes display light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ToneName {
    /// Cut off above 1
    Linear,
    /// Compress luminance, keep colours (Reinhard et al. 2002)
    Reinhard,
    /// A film's soft curve (Narkowicz 2015)
    Filmic,
}

/// The viewpoint.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Viewpoint")]
pub struct CameraArgs {
    /// A camera file (.json), or the name of one of the scene's cameras [default: the scene's
    /// first camera, or a view of all of it]
    #[arg(long, value_name = "FILE|NAME", value_hint = ValueHint::FilePath)]
    pub camera: Option<String>,
    /// Where the viewer stands
    #[arg(long, value_name = "X,Y,Z", value_parser = values::vector, allow_hyphen_values = true)]
    pub from: Option<DVec3>,
    /// What the viewer looks at
    #[arg(long, value_name = "X,Y,Z", value_parser = values::vector, allow_hyphen_values = true)]
    pub at: Option<DVec3>,
    /// Vertical field of view
    #[arg(long, value_name = "DEGREES", value_parser = values::degrees)]
    pub fov: Option<f64>,
}

/// `render`
#[derive(Debug, Args)]
pub struct RenderArgs {
    #[command(flatten)]
    pub input: InputArgs,
    /// Where to write, by extension: .png (for looking at), .exr or .hdr (linear radiance);
    /// `-` writes PNG to standard output
    #[arg(long, short, value_name = "IMAGE", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,
    #[command(flatten)]
    pub picture: ImageArgs,
    #[command(flatten)]
    pub view: CameraArgs,
    #[command(flatten)]
    pub look: RtraceArgs,
    #[command(flatten)]
    pub first_pass: FirstPassArgs,
}

/// Whose picture it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RenderStyle {
    /// Light as it is
    Physical,
    /// An SFF or SCN scene as RTRACE drew it
    Rtrace,
}

/// RTRACE's options; the letters in brackets are its own.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Look")]
pub struct RtraceArgs {
    /// Light as it is, or an SFF or SCN scene as RTRACE drew it, for which the rest of these are
    #[arg(long, value_name = "LOOK", value_enum, default_value_t = RenderStyle::Physical)]
    pub look: RenderStyle,
    /// How surfaces shine (m): 0 Phong, 1 Strauss [default: 1]
    #[arg(long, value_name = "0|1", value_parser = clap::value_parser!(u8).range(0..=1))]
    pub look_model: Option<u8>,
    /// Textures (t): 0 none, 1 those among the objects, 2 those in a section of their own
    /// [default: 0]
    #[arg(long, value_name = "0|1|2", value_parser = clap::value_parser!(u8).range(0..=2))]
    pub look_textures: Option<u8>,
    /// Shadows (l): 0 opaque, 1 filtered by glass, 2 and light through glass [default: 0]
    #[arg(long, value_name = "0|1|2", value_parser = clap::value_parser!(u8).range(0..=2))]
    pub look_shadows: Option<u8>,
    /// How often a pixel is halved, 0 to 3 (p) [default: 0]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=3))]
    pub look_levels: Option<u8>,
    /// How much the corners of a pixel that is halved differ (A); below 0, their contrast
    /// [default: 0.05]
    #[arg(long, value_name = "SHARE", value_parser = values::threshold,
          allow_hyphen_values = true)]
    pub look_threshold: Option<f64>,
    /// Which pixels are halved (a): 0 again and again where they differ, 1 all at once where they
    /// differ, 2 all at once everywhere [default: 0]
    #[arg(long, value_name = "0|1|2", value_parser = clap::value_parser!(u8).range(0..=2))]
    pub look_antialiasing: Option<u8>,
    /// Look for objects inside a pixel that its corners do not see (i1): fine lines stay whole
    #[arg(long)]
    pub look_all_objects: bool,
    /// Most surfaces along a path (s) [default: 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64))]
    pub look_depth: Option<u32>,
    /// Paths end that carry less (S) [default: 1%]
    #[arg(long, value_name = "SHARE", value_parser = values::fraction)]
    pub look_cut: Option<f64>,
    /// So many surfaces along a path gather their ambient light with rays (d) [default: 0]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=64))]
    pub look_ambient_depth: Option<u32>,
    /// Rays that gather ambient light (D) [default: 16]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=65_536))]
    pub look_ambient_samples: Option<u32>,
    /// Radius of the lens, in sizes of what the picture shows where it is sharp (P)
    /// [default: 0, a pinhole]
    #[arg(long, value_name = "SHARE", value_parser = values::fraction)]
    pub look_aperture: Option<f64>,
    /// Distance at which the picture is sharp (F) [default: that of the point looked at]
    #[arg(long, value_name = "LENGTH", value_parser = values::positive)]
    pub look_focus: Option<f64>,
    /// The picture of one of two eyes so far apart (v1 or v2, E): left=0.5, right=0.5
    #[arg(long, value_name = "SIDE=LENGTH", value_parser = values::eye)]
    pub look_eye: Option<(Side, f64)>,
}

/// The picture.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Image")]
pub struct ImageArgs {
    /// Width and height in pixels [default: the camera's, or 512x512; RTRACE's is 256x256]
    #[arg(long, value_name = "WxH", value_parser = values::size)]
    pub size: Option<(u32, u32)>,
    /// Samples per pixel [default: 16, or 256 with --reference]
    #[arg(long, value_name = "N",
          value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub spp: Option<u32>,
    /// Gather light at every hit with N rays instead of showing what the vertices carry
    #[arg(long, value_name = "N",
          value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub gather: Option<u32>,
    /// Trace paths by brute force instead of two passes: slow, without bias, with an error for
    /// every pixel; what both passes are judged by
    #[arg(long, conflicts_with = "gather")]
    pub reference: bool,
    /// Where to write the standard error of every pixel of a reference: .exr or .hdr
    #[arg(long, value_name = "IMAGE", requires = "reference", value_hint = ValueHint::FilePath)]
    pub error_image: Option<PathBuf>,
    /// Exposure of a PNG in stops: each doubles the brightness [default: chosen from the picture]
    #[arg(long, value_name = "STOPS", value_parser = values::finite, allow_hyphen_values = true)]
    pub exposure: Option<f64>,
    /// Tone curve of a PNG
    #[arg(long, value_name = "CURVE", value_enum, default_value_t = ToneName::Reinhard)]
    pub tone: ToneName,
}

/// What to measure.
#[derive(Debug, Args)]
#[group(required = true, multiple = false)]
pub struct ProbeSources {
    /// Irradiance at points: text (x y z nx ny nz per line), or .npy (n x 3, with --normals;
    /// or n x 6)
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub points: Option<PathBuf>,
    /// Radiance along rays: 8 little-endian f32 per ray (origin, tmin, direction, tmax)
    #[arg(long, value_name = "RAYS", value_hint = ValueHint::FilePath)]
    pub radiance: Option<PathBuf>,
    /// What rays hit: t, object, triangle, u, v; a miss is inf, -1, -1, 0, 0
    #[arg(long, value_name = "RAYS", value_hint = ValueHint::FilePath)]
    pub hits: Option<PathBuf>,
}

/// `probe`
#[derive(Debug, Args)]
pub struct ProbeArgs {
    #[command(flatten)]
    pub input: InputArgs,
    #[command(flatten)]
    pub probes: ProbeSources,
    /// Normals of the points, .npy (n x 3)
    #[arg(long, value_name = "FILE", requires = "points", value_hint = ValueHint::FilePath)]
    pub normals: Option<PathBuf>,
    /// Where to write: .npy (f64), or text under any other name; `-` writes text to standard
    /// output [default: - without --json, nowhere with it]
    #[arg(long, short, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub first_pass: FirstPassArgs,
}

/// `experiment`
#[derive(Debug, Args)]
pub struct ExperimentArgs {
    /// The suite: scenes, engines, how often, compared with what (.toml)
    #[arg(value_name = "SUITE", value_hint = ValueHint::FilePath)]
    pub suite: PathBuf,
    /// Folder for the report; what was already done there is not done again
    #[arg(long, short, value_name = "FOLDER", value_hint = ValueHint::DirPath,
          required_unless_present = "list")]
    pub output: Option<PathBuf>,
    /// Only say what there is to do
    #[arg(long)]
    pub list: bool,
    /// Only what has this in its name, as --list says it
    #[arg(long, value_name = "NAME")]
    pub only: Option<String>,
    /// Of each engine on each scene only the first setting, once
    #[arg(long)]
    pub quick: bool,
    /// Do one task and print what it found: what the command starts for each
    #[arg(long, value_name = "KEY", hide = true)]
    pub task: Option<String>,
}

const EXAMPLES: &str = "\
Examples:
  azulejo render examples/cornell.grf -o cornell.png
  azulejo solve room.obj -o room.grf --error 1%
  azulejo render room.grf -o room.exr --size 1280x720 --spp 64

Exit codes: 0 done, 1 failed (an old output file stays as it was), 2 misused.";

const INFO_EXAMPLES: &str = "\
Examples:
  azulejo info room.3ds
  azulejo info drawing.dxf --strict
  azulejo info room.grf --json | python3 -m json.tool";

const CONVERT_EXAMPLES: &str = "\
Examples:
  azulejo convert tank.flt -o tank.glb --lod coarsest
  azulejo convert room.dxf chair.3ds -o room.grf --up y --unit m \\
      --place chair.3ds:scale=0.01,rotate=0,30,0,translate=2,0,1";

const SOLVE_EXAMPLES: &str = "\
Examples:
  azulejo solve room.obj -o room.grf
  azulejo solve room.obj -o room.grf --patches 20000 --error 1%
  azulejo solve level.glb -o level-lit.glb --keep-mesh
  azulejo solve room.obj -o room.grf --patch-size 0.1 --time 60s --json
  azulejo solve room.obj -o room.grf --engine embree";

const RENDER_EXAMPLES: &str = "\
Examples:
  azulejo render room.grf -o room.png
  azulejo render room.grf -o room.png --from 2,1.6,5 --at 0,1,0 --fov 60 --exposure 1.5
  azulejo render room.obj --camera room.json -o room.exr --size 1280x720 --spp 64 --gather 128
  azulejo render demo.sff --look rtrace --look-textures 2 --look-levels 3 -o demo.png";

const PROBE_EXAMPLES: &str = "\
Examples:
  azulejo probe room.obj --points desk.txt -o lux.txt --error 2%
  azulejo probe room.obj --points p.npy --normals n.npy -o e.npy --time 10s
  azulejo probe room.obj --hits rays.f32 -o hits.npy --json

Points give irradiance in red, green, blue and then its standard error, six numbers each. With
emission in W/(sr·m²) irradiance is in W/m².";

const EXPERIMENT_EXAMPLES: &str = "\
Examples:
  azulejo experiment examples/experiments/truths.toml -o report
  azulejo experiment examples/experiments/diffuse.toml --list
  azulejo experiment examples/experiments/mirrors.toml -o report --only hybrid";

const VIEW_EXAMPLES: &str = "\
Examples:
  azulejo view room.3ds lamp.glb
  azulejo view --script steps.txt --screenshot out.png

The workbench is a program of its own beside this one. To build it, in azulejo's folder:
  cargo build --release -p azulejo-workbench";

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
