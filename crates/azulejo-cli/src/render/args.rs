//! The options of `render`.

use crate::camera::CameraArgs;
use crate::first_pass::FirstPassArgs;
use crate::input::InputArgs;
use crate::values;
use azulejo_render::FinalGather;
use azulejo_render::rtrace::Side;
use clap::{Args, ValueEnum, ValueHint};
use std::path::PathBuf;

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

/// The image.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Image")]
pub struct ImageArgs {
    /// Width and height in pixels [default: the camera's, or 512x512; RTRACE's is 256x256]
    #[arg(long, value_name = "WxH", value_parser = values::size)]
    pub size: Option<(u32, u32)>,
    /// Samples per pixel [default: at most 16, or 256 with --reference]
    ///
    /// By default, even pixels get four, and pictures that would cost much fewer.
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
    #[arg(long, value_name = "IMAGE", requires = "reference", conflicts_with_all = ["cameras", "turntable"],
          value_hint = ValueHint::FilePath)]
    pub error_image: Option<PathBuf>,
    /// Clamp fireflies: maximum radiance that the indirect paths of one sample may add, in the unit
    /// of the scene [default: off]
    ///
    /// This removes light, too; the summary says how much.
    #[arg(long, value_name = "RADIANCE", value_parser = values::positive)]
    pub clamp: Option<f64>,
    /// Additional layers (AOVs) of an .exr, for compositing: all, or a list of albedo, normal,
    /// depth, object, material, glyph, direct, indirect, error; and cryptomatte
    ///
    /// Channels are albedo.R/G/B, N.X/Y/Z, Z, objectId, materialId, glyphId, direct.R/G/B,
    /// indirect.R/G/B and error.R/G/B, the standard error. Ids count from 1, 0 is none; a glyph is a
    /// letter of a text. Cryptomatte has CryptoObject00.r/g/b/a to 02 of objects and letters, and as many of
    /// CryptoAsset, whole objects, and CryptoMaterial, with their names in the file's attributes.
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
    /// Cryptomatte: coverage by name of objects, letters and materials; not among `all`
    Cryptomatte,
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

/// What the image shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RenderStyle {
    /// Physically based light
    Physical,
    /// An SFF or SCN scene as RTRACE rendered it
    Rtrace,
    /// Light that arrives at surfaces, lx or W/m²: a .png in false colours, an .exr or .hdr of its values
    Illuminance,
}

/// Options of RTRACE's look; the letters in parentheses are its own switches.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "RTRACE")]
pub struct RtraceArgs {
    /// Physically based light, the illuminance of surfaces in false colours, or an SFF or SCN scene as RTRACE rendered
    /// it; the other options below require `rtrace`
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

/// Examples below the help.
pub const EXAMPLES: &str = "\
Examples:
  azulejo render room.grf -o room.png
  azulejo render room.grf -o room.png --from 2,1.6,5 --at 0,1,0 --fov 60 --exposure 1.5
  azulejo render room.obj --camera room.json -o room.exr --size 1280x720 --spp 64 --gather 128
  azulejo render demo.sff --look rtrace --look-textures 2 --look-levels 3 -o demo.png";
