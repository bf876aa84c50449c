//! The command line as clap parses it. Values get their types here; the commands interpret them.

use super::bake;
use super::brdf::{BRDF_EXAMPLES, BrdfCommand};
use super::engine::EngineArgs;
use super::grf::{GRF_EXAMPLES, GrfCommand};
use super::lettering::{
    EXTRUDE_EXAMPLES, ExtrudeArgs, FONT_EXAMPLES, FontCommand, TEXT_EXAMPLES, TextArgs,
};
use super::parts::{self, MergeArgs, PartArgs};
use super::placement::{self, PlaceArg, Placement};
use super::short_help;
use super::surroundings::args::{Site, SurroundingsArgs};
use super::values::{self, TimeArg, UpArg};
use super::{exchange, form_factors, validate};
use azulejo_formats::{Lod, ReadOptions};
use azulejo_render::FinalGather;
use azulejo_render::rtrace::Side;
use clap::builder::Resettable;
use clap::{Args, Parser, Subcommand, ValueEnum, ValueHint};
use glam::DVec3;
use globset::GlobMatcher;
use jiff::Timestamp;
use std::path::PathBuf;
use std::time::Duration;

/// Global illumination for the models people already have.
///
/// Reads a model, computes the irradiance on its surfaces, and renders and measures it.
#[derive(Debug, Parser)]
#[command(name = "azulejo", version, max_term_width = 100, after_help = EXAMPLES)]
pub struct Cli {
    /// The command.
    #[command(subcommand)]
    pub command: Command,
    /// The options of every command.
    #[command(flatten)]
    pub common: CommonArgs,
}

/// Options of every command.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "General")]
pub struct CommonArgs {
    /// Print one JSON object on standard output instead of text
    #[arg(long, global = true)]
    pub json: bool,
    /// Print errors only: no progress, warnings or summary
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Number of threads [default: one per processor core]
    #[arg(long, global = true, value_name = "N",
          value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Show what a model, or a matrix of form factors (.npz), contains
    #[command(after_help = INFO_EXAMPLES)]
    Info(InfoArgs),
    /// Read models, merge them and write them in another format
    #[command(after_help = CONVERT_EXAMPLES)]
    Convert(ConvertArgs),
    /// Solve the light: compute the irradiance at the vertices (first pass)
    #[command(mut_args = short_help::of(short_help::SOLVE), after_help = short_help::ending(SOLVE_EXAMPLES),
              after_long_help = SOLVE_EXAMPLES)]
    Solve(SolveArgs),
    /// Bake a lightmap: irradiance in the texels of a second set of texture coordinates
    #[command(mut_args = short_help::of(short_help::BAKE), after_help = short_help::ending(bake::args::EXAMPLES),
              after_long_help = bake::args::EXAMPLES)]
    Bake(bake::args::BakeArgs),
    /// Render an image (second pass); solves the light first if the scene has no irradiance yet
    #[command(mut_args = short_help::of(short_help::RENDER), after_help = short_help::ending(RENDER_EXAMPLES),
              after_long_help = RENDER_EXAMPLES)]
    Render(RenderArgs),
    /// Measure irradiance at points, or radiance or hits along rays
    #[command(mut_args = short_help::of(short_help::PROBE), after_help = short_help::ending(PROBE_EXAMPLES),
              after_long_help = PROBE_EXAMPLES)]
    Probe(ProbeArgs),
    /// Compute the matrix of form factors between patches
    #[command(mut_args = short_help::of(short_help::FORM_FACTORS), after_help = short_help::ending(form_factors::args::EXAMPLES),
              after_long_help = form_factors::args::EXAMPLES)]
    FormFactors(form_factors::args::FormFactorArgs),
    /// Put together the parts of a work that several runs of a command divided
    #[command(after_help = parts::EXAMPLES)]
    Merge(MergeArgs),
    /// Radiative exchange from form factors: conductances, temperatures and heat fluxes
    #[command(mut_args = short_help::of(short_help::EXCHANGE), after_help = short_help::ending(exchange::args::EXAMPLES),
              after_long_help = exchange::args::EXAMPLES)]
    Exchange(exchange::args::ExchangeArgs),
    /// Compare form factor engines: run a suite of scenes and settings and report times and errors
    #[command(after_help = EXPERIMENT_EXAMPLES)]
    Experiment(ExperimentArgs),
    /// Validate azulejo against closed-form solutions, energy balances and its own error estimates,
    /// and write a report
    #[command(after_help = validate::args::EXAMPLES)]
    Validate(validate::args::ValidateArgs),
    /// Make 3D text from a font
    #[command(after_help = TEXT_EXAMPLES)]
    Text(TextArgs),
    /// Convert fonts and draw specimen sheets
    #[command(after_help = FONT_EXAMPLES)]
    Font {
        /// The subcommand
        #[command(subcommand)]
        command: FontCommand,
    },
    /// Extrude a drawing (SVG or DXF) to a solid
    #[command(after_help = EXTRUDE_EXAMPLES)]
    Extrude(ExtrudeArgs),
    /// Evaluate, plot, check and fit reflection models
    #[command(after_help = BRDF_EXAMPLES)]
    Brdf {
        /// The subcommand
        #[command(subcommand)]
        command: BrdfCommand,
    },
    /// Format, check and compare GRF files
    #[command(after_help = GRF_EXAMPLES)]
    Grf {
        /// The subcommand
        #[command(subcommand)]
        command: GrfCommand,
    },
    /// Open the workbench, the graphical application to view, light and save models
    #[command(after_help = VIEW_EXAMPLES)]
    View(WorkbenchArgs),
    /// Print a completion script for a shell
    #[command(after_help = COMPLETIONS_EXAMPLES)]
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Write the manual pages to a folder
    #[command(after_help = MAN_EXAMPLES)]
    Man {
        /// An existing folder
        #[arg(value_name = "DIR", value_hint = ValueHint::DirPath)]
        folder: PathBuf,
    },
}

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
    /// Neither read nor write preferences and recovery files
    #[arg(long)]
    pub no_preferences: bool,
}

/// The models to read.
#[derive(Debug, Args)]
pub struct InputArgs {
    /// Model files, merged into one scene if several; `-` is standard input
    #[arg(value_name = "SCENE", required = true, value_hint = ValueHint::FilePath,
          help_heading = Resettable::Reset)]
    pub scenes: Vec<PathBuf>,
    /// Add the point lights of a camera file (.json)
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath,
          help_heading = "Light from outside")]
    pub lights: Option<PathBuf>,
    #[command(flatten)]
    pub reading: ReadingArgs,
    #[command(flatten)]
    pub outside: SurroundingsArgs,
}

impl InputArgs {
    /// The files that are read.
    pub fn files_mut(&mut self) -> Vec<&mut PathBuf> {
        let named = self.scenes.iter_mut().chain(&mut self.lights);
        let more = (self.reading.recipe.iter_mut()).chain(&mut self.outside.environment);
        named.chain(more).collect()
    }
}

/// How models are read and put together.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Reading")]
pub struct ReadingArgs {
    /// Place a model: FILE:translate=1,0,2,rotate=0,90,0,scale=2; or LAT,LON, the place on Earth for
    /// which the sun is computed
    ///
    /// Steps are applied in the given order: degrees about x, y, z; one scale factor or three. fit=2
    /// scales the model so that its largest side is 2, and stands it on the origin; up=z and unit=mm
    /// override the file's axis and unit; name=lamp names its branch in the scene. LAT,LON are in
    /// degrees, north and east positive; with --time or --sun.
    #[arg(long, value_name = "FILE:HOW|LAT,LON", value_parser = placement::place,
          allow_hyphen_values = true)]
    pub place: Vec<PlaceArg>,
    /// Up axis of the scene, to which models are rotated [default: that of the first model]. For
    /// `render`, also a direction X,Y,Z that points up in the image only
    #[arg(long, value_name = "y|z", value_parser = values::up, allow_hyphen_values = true)]
    pub up: Option<UpArg>,
    /// Unit of length of the scene, to which models are scaled: mm, cm, m, km, in, ft, or a number
    /// of metres [default: that of the first model]
    #[arg(long, value_name = "UNIT", value_parser = values::unit)]
    pub unit: Option<f64>,
    /// Level of detail of models that have several: finest, coarsest, all, a viewing distance in the
    /// model's units, or a level as in lod1.3 (CityJSON)
    #[arg(long, value_name = "LEVEL", default_value = "finest", value_parser = values::lod)]
    pub lod: Lod,
    /// Apply a recipe (TOML) to the scene: rules by names of materials and objects, lights, cameras,
    /// background, fog. May be given several times
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub recipe: Vec<PathBuf>,
    /// Reverse the faces of the objects of these names, with the wildcards * and ?: their backs
    /// become their fronts
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', value_parser = values::names)]
    pub flip: Vec<GlobMatcher>,
    /// Fail if anything in a model had to be skipped or repaired
    #[arg(long)]
    pub strict: bool,
    /// Maximum number of vertices and face corners to which the instances and curves of a model may
    /// expand
    #[arg(long, value_name = "N", default_value_t = ReadOptions::default().most_elements)]
    pub most_elements: u64,
    /// Also read files in this folder that a model refers to by `..` or an absolute path
    #[arg(long, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    pub allow: Vec<PathBuf>,
}

/// `info`
#[derive(Debug, Args)]
pub struct InfoArgs {
    /// Print one row for each model instead: size, objects, materials, vertices, faces, size as GRF and
    /// their ratio, as Table 1 of the paper on GRF
    #[arg(long, conflicts_with = "lights")]
    pub table: bool,
    /// Format of the table
    #[arg(
        long,
        value_name = "FORMAT",
        default_value = "text",
        requires = "table"
    )]
    pub format: TableFormat,
    #[command(flatten)]
    pub input: InputArgs,
}

/// `info --format`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TableFormat {
    /// Aligned columns
    Text,
    /// Values separated by commas, sizes in bytes
    Csv,
    /// A table in Markdown
    Markdown,
}

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
    /// Triangulate all polygons, for programs that read triangles only
    #[arg(long)]
    pub triangles: bool,
    /// Significant digits of the numbers of meshes in text formats [default: as many as the exact
    /// values need]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(4..=17))]
    pub digits: Option<u8>,
    #[command(flatten)]
    pub input: InputArgs,
}

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

impl ReadingArgs {
    /// How models are placed.
    pub fn placements(&self) -> impl Iterator<Item = &Placement> {
        self.place.iter().filter_map(|place| match place {
            PlaceArg::Model(placement) => Some(placement),
            PlaceArg::Site(_) => None,
        })
    }

    /// The place on Earth.
    pub fn site(&self) -> Option<Site> {
        self.place.iter().rev().find_map(|place| match place {
            PlaceArg::Site(site) => Some(*site),
            PlaceArg::Model(_) => None,
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
    /// and that of exact shapes and reflecting primitives, goes into extensions behind the object.
    /// Includes with surfaces are replaced by the included text, because each use of a part has
    /// light of its own; their files are not changed.
    #[arg(long)]
    pub in_place: bool,
    /// Significant digits of the numbers of meshes in text formats; with --in-place, of the
    /// irradiance alone [default: as many as the exact values need; with --in-place: 6]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(4..=17))]
    pub digits: Option<u8>,
    #[command(flatten)]
    pub part: PartArgs,
    #[command(flatten)]
    pub first_pass: FirstPassArgs,
    #[command(flatten)]
    pub input: InputArgs,
}

/// Tone mapping curves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ToneName {
    /// Clip above 1
    Linear,
    /// Compress luminance, preserving colours (Reinhard et al. 2002)
    Reinhard,
    /// Film-like curve (Narkowicz 2015)
    Filmic,
}

/// The camera.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Camera")]
pub struct CameraArgs {
    /// A camera file (.json), or the name of one of the scene's cameras [default: the scene's
    /// first camera, or a view of the whole scene]
    #[arg(long, value_name = "FILE|NAME", value_hint = ValueHint::FilePath)]
    pub camera: Option<String>,
    /// Position of the camera
    #[arg(long, value_name = "X,Y,Z", value_parser = values::vector, allow_hyphen_values = true)]
    pub from: Option<DVec3>,
    /// Point that the camera looks at
    #[arg(long, value_name = "X,Y,Z", value_parser = values::vector, allow_hyphen_values = true)]
    pub at: Option<DVec3>,
    /// Vertical field of view in degrees
    #[arg(long, value_name = "DEGREES", value_parser = values::degrees)]
    pub fov: Option<f64>,
}

/// `render`
#[derive(Debug, Args)]
pub struct RenderArgs {
    /// Output image, its format chosen by extension: .png (tone mapped), .exr or .hdr (linear
    /// radiance); `-` writes PNG to standard output
    #[arg(long, short, value_name = "IMAGE", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,
    #[command(flatten)]
    pub picture: ImageArgs,
    #[command(flatten)]
    pub view: CameraArgs,
    /// Render a turntable: N views around the up axis, written to IMAGE-001 and so on
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000),
          conflicts_with = "cameras", help_heading = "Camera")]
    pub turntable: Option<u32>,
    /// Render several cameras, each written to IMAGE-NAME: all of the scene's, or those of these
    /// names
    #[arg(long, value_name = "all|NAME,...", conflicts_with_all = ["camera", "from", "at"],
          help_heading = "Camera")]
    pub cameras: Option<String>,
    #[command(flatten)]
    pub input: InputArgs,
    #[command(flatten)]
    pub first_pass: FirstPassArgs,
    #[command(flatten)]
    pub look: RtraceArgs,
}

/// What the image shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RenderStyle {
    /// Physically based light
    Physical,
    /// An SFF or SCN scene as RTRACE rendered it
    Rtrace,
}

/// Options of RTRACE's look; the letters in parentheses are its own switches.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "RTRACE")]
pub struct RtraceArgs {
    /// Physically based light, or an SFF or SCN scene as RTRACE rendered it; the other options
    /// below require `rtrace`
    #[arg(long, value_name = "LOOK", value_enum, default_value_t = RenderStyle::Physical)]
    pub look: RenderStyle,
    /// Reflection model (m): 0 Phong, 1 Strauss [default: 1]
    #[arg(long, value_name = "0|1", value_parser = clap::value_parser!(u8).range(0..=1))]
    pub look_model: Option<u8>,
    /// Textures (t): 0 none, 1 inline with the objects, 2 from the texture section [default: 0]
    #[arg(long, value_name = "0|1|2", value_parser = clap::value_parser!(u8).range(0..=2))]
    pub look_textures: Option<u8>,
    /// Shadows (l): 0 opaque, 1 filtered by glass, 2 also light through glass [default: 0]
    #[arg(long, value_name = "0|1|2", value_parser = clap::value_parser!(u8).range(0..=2))]
    pub look_shadows: Option<u8>,
    /// Levels of pixel subdivision, 0 to 3 (p) [default: 0]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=3))]
    pub look_levels: Option<u8>,
    /// Difference between the corners of a pixel above which it is subdivided (A); a negative value
    /// is a contrast [default: 0.05]
    #[arg(long, value_name = "SHARE", value_parser = values::threshold,
          allow_hyphen_values = true)]
    pub look_threshold: Option<f64>,
    /// Which pixels are subdivided (a): 0 adaptively, level by level; 1 to the last level where the
    /// corners differ; 2 all to the last level [default: 0]
    #[arg(long, value_name = "0|1|2", value_parser = clap::value_parser!(u8).range(0..=2))]
    pub look_antialiasing: Option<u8>,
    /// Find objects inside a pixel that its corners miss (i1), which keeps fine lines whole
    #[arg(long)]
    pub look_all_objects: bool,
    /// Maximum number of surfaces along a path (s) [default: 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64))]
    pub look_depth: Option<u32>,
    /// Weight below which paths are terminated (S) [default: 1%]
    #[arg(long, value_name = "SHARE", value_parser = values::fraction)]
    pub look_cut: Option<f64>,
    /// How many surfaces along a path gather ambient light by rays (d) [default: 0]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=64))]
    pub look_ambient_depth: Option<u32>,
    /// Rays for ambient light (D) [default: 16]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=65_536))]
    pub look_ambient_samples: Option<u32>,
    /// Radius of the lens, relative to the size of the image in the plane of focus (P)
    /// [default: 0, a pinhole]
    #[arg(long, value_name = "SHARE", value_parser = values::fraction)]
    pub look_aperture: Option<f64>,
    /// Distance of the plane of focus (F) [default: that of the point looked at]
    #[arg(long, value_name = "LENGTH", value_parser = values::positive)]
    pub look_focus: Option<f64>,
    /// Stereo: the image of one eye, with the distance between both (v1 or v2, E), as in left=0.5
    #[arg(long, value_name = "SIDE=LENGTH", value_parser = values::eye)]
    pub look_eye: Option<(Side, f64)>,
}

/// Layers of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LayerName {
    /// All layers
    All,
    /// Reflectance: diffuse, glossy and specular together
    Albedo,
    /// Shading normal in world coordinates
    Normal,
    /// Depth: distance along the viewing direction, in scene units
    Depth,
    /// Number of the object
    Object,
    /// Number of the material
    Material,
    /// Number of the letter or solid within an exact shape
    Glyph,
    /// Light reflected by at most one surface
    Direct,
    /// All other light
    Indirect,
    /// Standard error
    Error,
}

impl LayerName {
    /// Each layer.
    pub const EACH: [LayerName; 9] = [
        LayerName::Albedo,
        LayerName::Normal,
        LayerName::Depth,
        LayerName::Object,
        LayerName::Material,
        LayerName::Glyph,
        LayerName::Direct,
        LayerName::Indirect,
        LayerName::Error,
    ];
}

/// The image.
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
    /// Final gather: where irradiance is computed anew instead of interpolated between vertices
    /// [default: auto]
    ///
    /// auto: where the corners of a face differ by more than half, as at shadow edges; off: nowhere;
    /// N: at every hit, by N rays.
    #[arg(long, value_name = "auto|off|N", value_parser = values::final_gather)]
    pub gather: Option<FinalGather>,
    /// Path tracing instead of the two passes: slow and unbiased, with a standard error for every
    /// pixel
    #[arg(long, conflicts_with = "gather")]
    pub reference: bool,
    /// Image of the standard error of every pixel of a --reference: .exr or .hdr
    #[arg(long, value_name = "IMAGE", requires = "reference", value_hint = ValueHint::FilePath)]
    pub error_image: Option<PathBuf>,
    /// Clamp fireflies: maximum radiance that the indirect paths of one sample may add, in the unit
    /// of the scene [default: off]
    ///
    /// This removes light, too; the summary says how much.
    #[arg(long, value_name = "RADIANCE", value_parser = values::positive)]
    pub clamp: Option<f64>,
    /// Additional layers (AOVs) of an .exr, for compositing: all, or a list of albedo, normal,
    /// depth, object, material, glyph, direct, indirect, error
    ///
    /// Channels are albedo.R/G/B, N.X/Y/Z, Z, objectId, materialId, glyphId, direct.R/G/B,
    /// indirect.R/G/B and error.R/G/B, the standard error. Ids count from 1, 0 is none; a glyph is a
    /// letter of a text.
    #[arg(long, value_name = "all|LIST", value_enum, value_delimiter = ',')]
    pub layers: Option<Vec<LayerName>>,
    /// Denoise after rendering, guided by the standard errors; reports how much changed, and the
    /// estimated error before and after
    ///
    /// Joint non-local means over colours, albedo, normals and depth (Rousselle et al. 2013).
    #[arg(long)]
    pub denoise: bool,
    /// Exposure of a PNG in stops, each of which doubles the brightness [default: automatic]
    #[arg(long, value_name = "STOPS", value_parser = values::number, allow_hyphen_values = true)]
    pub exposure: Option<f64>,
    /// Tone curve of a PNG
    #[arg(long, value_name = "CURVE", value_enum, default_value_t = ToneName::Reinhard)]
    pub tone: ToneName,
}

/// The quantity to measure.
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
    pub probes: ProbeSources,
    /// Normals of the points: .npy (n x 3)
    #[arg(long, value_name = "FILE", requires = "points", value_hint = ValueHint::FilePath)]
    pub normals: Option<PathBuf>,
    /// Output file: .npy (f64), or text with any other extension; `-` writes text to standard
    /// output [default: `-`, or none with --json]
    #[arg(long, short, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub part: PartArgs,
    #[command(flatten)]
    pub first_pass: FirstPassArgs,
    #[command(flatten)]
    pub input: InputArgs,
}

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

const EXAMPLES: &str = "\
Examples:
  azulejo render examples/cornell.grf -o cornell.png
  azulejo solve room.obj -o room.grf --error 1%
  azulejo render room.grf -o room.exr --size 1280x720 --spp 64

Exit codes: 0 success, 1 failure (an existing output file is left unchanged), 2 usage error.";

const INFO_EXAMPLES: &str = "\
Examples:
  azulejo info room.3ds
  azulejo info drawing.dxf --strict
  azulejo info --table *.3ds *.obj --format markdown
  azulejo info f.npz
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
  azulejo solve hut.obj -o hut.glb --sides split
  azulejo solve scene.grf --in-place
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

Each point gives six numbers: the irradiance in red, green and blue, and its standard error.
Irradiance is in W/m² if emission is in W/(sr·m²).";

const EXPERIMENT_EXAMPLES: &str = "\
Examples:
  azulejo experiment examples/experiments/truths.toml -o report
  azulejo experiment examples/experiments/diffuse.toml --list
  azulejo experiment examples/experiments/mirrors.toml -o report --only hybrid";

const VIEW_EXAMPLES: &str = "\
Examples:
  azulejo view room.3ds lamp.glb
  azulejo view --script steps.txt --screenshot out.png

The workbench is a separate program, azulejo-workbench, next to this one or on the PATH. To build it
from azulejo's source:
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
