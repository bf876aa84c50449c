//! Options of `bake`.

use crate::first_pass::FirstPassArgs;
use crate::input::InputArgs;
use crate::parts::PartArgs;
use crate::values;
use azulejo::bake::unwrap::MOST_SIZE;
use azulejo::lightmap::{BakedLight, BakedSides, DirectionForm};
use azulejo_formats::gltf::patch::{Convention, InstanceMode, LightsMode};
use clap::{Args, ValueEnum, ValueHint};
use globset::{Glob, GlobMatcher};
use std::path::PathBuf;

/// Examples.
pub const EXAMPLES: &str = "\
Examples:
  azulejo bake level.glb -o baked.glb --size 1024 --error 1%
  azulejo bake old.3ds sun.grf -o lit.glb --texels-per-metre 20 --lightmap E.exr --error-map SE.exr
  azulejo bake word.sff room.wrl -o page.html
  azulejo bake level.glb -o shop.glb --as emissive
  azulejo bake baked.glb --strip -o level-again.glb
  azulejo bake baked.glb --check --lightmap E.exr
  azulejo bake --verify baked.glb level.glb --size 1024 --error 1%

A glTF file keeps everything that does not have to change; `--strip` restores it. Other models are \
written as glTF.";

/// `bake`
#[derive(Clone, Debug, Args)]
pub struct BakeArgs {
    /// Output file: .glb, .gltf (with its pictures beside it), or .html, a page that shows the model with
    /// its light in any browser
    #[arg(long, short, value_name = "OUT", value_hint = ValueHint::FilePath,
          required_unless_present_any = ["lightmap", "check", "verify"])]
    pub output: Option<PathBuf>,
    /// Write a page that shows the model, whatever the extension of the output
    #[arg(long, requires = "output", conflicts_with_all = ["strip", "check"])]
    pub html: bool,
    /// Remove the lightmap that azulejo added to a glTF file, or the light that `solve --keep-mesh`
    /// added to its vertices: restores the original file
    #[arg(long, requires = "output", conflicts_with = "part")]
    pub strip: bool,
    /// Only check the lightmap of a glTF file, whatever program made it, or a second set of texture
    /// coordinates for one; with --lightmap, also compare the image in the file with that one
    #[arg(long, conflicts_with_all = ["strip", "output", "part"])]
    pub check: bool,
    /// Only say whether the lightmap of the first file is up to date: exit status 1 if its geometry, materials or
    /// lights have changed since it was baked
    ///
    /// With further models, whether it is what these and the options of the command would give, such as in checks of
    /// a repository.
    #[arg(long, conflicts_with_all = ["strip", "output", "part", "check", "lightmap", "error_map"])]
    pub verify: bool,
    #[command(flatten)]
    pub part: PartArgs,
    #[command(flatten)]
    pub texels: TexelArgs,
    #[command(flatten)]
    pub files: LightmapFileArgs,
    #[command(flatten)]
    pub input: InputArgs,
    #[command(flatten)]
    pub first_pass: FirstPassArgs,
}

impl TexelArgs {
    /// How dense the texels of some objects are.
    pub fn object_densities(&self) -> impl DoubleEndedIterator<Item = &ObjectDensity> {
        self.density.iter().filter_map(|given| match given {
            DensityArg::Auto => None,
            DensityArg::Objects(density) => Some(density),
        })
    }

    /// Whether the light says which charts are denser.
    pub fn follows_light(&self) -> bool {
        (self.density.iter()).any(|given| matches!(given, DensityArg::Auto))
    }
}

impl BakeArgs {
    /// What tells viewers of the lightmap.
    pub fn convention(&self) -> ConventionArg {
        let usual = match self.texels.light {
            LightArg::Ao => ConventionArg::Occlusion,
            _ => ConventionArg::Moz,
        };
        self.files.conventions.first().copied().unwrap_or(usual)
    }

    /// Whether the output is a page.
    pub fn is_page(&self) -> bool {
        let extension = self.output.as_deref().and_then(|path| path.extension());
        let extension = extension.map(|e| e.to_string_lossy().to_lowercase());
        self.html || matches!(extension.as_deref(), Some("html" | "htm"))
    }

    /// Whether what is written has a place for directions of light.
    pub fn has_place_for_directions(&self) -> bool {
        if self.texels.light == LightArg::Ao || self.is_page() {
            return false;
        }
        self.convention() == ConventionArg::Moz
            || (self.convention() == ConventionArg::Plain && self.files.lightmap.is_some())
    }

    /// Whether bright surfaces may have pictures of their own: those of 8 bits, of materials.
    pub fn separates_bright(&self) -> bool {
        self.files.image == ImageArg::Png && self.convention() == ConventionArg::Moz
    }
}

/// The texels of a lightmap.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Texels")]
pub struct TexelArgs {
    /// Width and height of a page in texels; with --texels-per-metre or --texels the maximum
    /// [default: 1024, or 8192 with those]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_SIZE)))]
    pub size: Option<u32>,
    /// Texels per metre of surface, on as many pages as needed
    #[arg(long, value_name = "N", value_parser = values::positive, conflicts_with = "count")]
    pub texels_per_metre: Option<f64>,
    /// Approximate number of texels that cover surfaces, as in 1e6, on as many pages as needed
    #[arg(long = "texels", id = "count", value_name = "N", value_parser = values::positive)]
    pub count: Option<f64>,
    /// Number of pages, among which whole objects are distributed
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u32).range(1..=256))]
    pub pages: u32,
    /// Empty texels around each chart: 1 for bilinear filters, 2 for bicubic ones
    #[arg(long, value_name = "N", default_value_t = 2,
          value_parser = clap::value_parser!(u32).range(1..=64))]
    pub padding: u32,
    /// Number of mipmap levels that viewers may use: padding grows to 2^N texels
    #[arg(long, value_name = "N", default_value_t = 0,
          value_parser = clap::value_parser!(u32).range(0..=6))]
    pub mips: u32,
    /// Align charts to blocks of 4 × 4 texels, for block-compressed textures
    #[arg(long)]
    pub blocks: bool,
    /// What to do with the texture coordinates that a glTF file already has in the set [default:
    /// keep them if they are suitable for a lightmap]
    #[arg(long, value_name = "WHAT")]
    pub uv: Option<UvArg>,
    /// Texel density, per length, of the objects of these names relative to others, as in
    /// 'table*=2'; if several match, the last counts. With 'auto', surfaces with shadow edges get more
    /// texels, and evenly lit ones fewer
    #[arg(long, value_name = "GLOB=N|auto", value_parser = density, conflicts_with = "uv")]
    pub density: Vec<DensityArg>,
    /// Cut charts at edges where the angle between the faces is larger than this, in degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 30.0, value_parser = values::degrees)]
    pub crease: f64,
    /// Do not cut faces along contacts, where one object stands on another
    ///
    /// By default, the faces of models other than glTF are cut there, so that light does not bleed from
    /// one side to the other.
    #[arg(long)]
    pub no_split_contacts: bool,
    /// Also cut the faces of a glTF file along contacts: the file is rewritten, and loses what
    /// azulejo does not support
    #[arg(long, conflicts_with = "no_split_contacts")]
    pub split_contacts: bool,
    /// Which side of surfaces is baked [default: the front in glTF files, the brighter one in
    /// others]
    #[arg(long, value_name = "SIDE")]
    pub double_sided: Option<DoubleSidedArg>,
    /// Which light to bake
    #[arg(long, value_name = "LIGHT", default_value = "total")]
    pub light: LightArg,
    /// Remove noise from texels that are gathered each by itself (with --rays), within the parts of charts that no
    /// contact divides
    #[arg(long)]
    pub denoise: bool,
    /// With --light ao, maximum distance of occluders in metres [default: a tenth of the size of
    /// the model]
    #[arg(long, value_name = "METRES", value_parser = values::positive)]
    pub ao_distance: Option<f64>,
}

/// Files of a lightmap, and how they say what they are.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Files")]
pub struct LightmapFileArgs {
    /// Write the irradiance as OpenEXR, in the unit of the scene (W/m² or lx), top row at v = 0
    ///
    /// With several pages, each file gets the number of its page before the extension. Floats have
    /// 16 bits, which are exact to 0.05%, or 32 where values are out of their range.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub lightmap: Option<PathBuf>,
    /// Write the standard error of the irradiance as OpenEXR
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub error_map: Option<PathBuf>,
    /// Use 32-bit floats in --lightmap and --error-map
    #[arg(long)]
    pub float: bool,
    /// Also store where the light of each texel comes from, so that normal maps show relief: spherical
    /// harmonics of bands 0 and 1 ('sh', three more images), or the dominant direction alone
    /// ('dominant', one); --lightmap and --error-map get the coefficients as layers
    #[arg(long, value_name = "FORM", num_args = 0..=1, require_equals = true,
          default_missing_value = "sh")]
    pub directional: Option<DirectionalArg>,
    /// How the glTF file refers to the lightmap [default: moz; occlusion with --light ao]
    #[arg(
        long = "as",
        id = "conventions",
        value_name = "CONVENTION",
        value_delimiter = ','
    )]
    pub conventions: Vec<ConventionArg>,
    /// With --as unlit or emissive: factor by which radiance is multiplied before it is stored,
    /// clipped at 1 (white); 'auto' fits all but the brightest thousandth of the area [default:
    /// auto with --as unlit; none with --as emissive, which stores any light]
    #[arg(long, value_name = "F", value_parser = exposure)]
    pub exposure: Option<ExposureArg>,
    /// Format of the images in the file
    #[arg(long, value_name = "TYPE", default_value = "png")]
    pub image: ImageArg,
    /// The set of texture coordinates, TEXCOORD_N, that is added, kept or checked; if a texture
    /// already uses it, the next free one is added [default: 1, or that of the file's lightmap]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=7))]
    pub uv_set: Option<u32>,
    /// How nodes that share a mesh get places of their own in the lightmap
    #[arg(long, value_name = "HOW", default_value = "copy")]
    pub instances: InstancesArg,
    /// What to do with baked point, spot and directional lights [default: dim; keep with --light
    /// indirect]
    #[arg(long, value_name = "WHAT")]
    pub baked_lights: Option<LightsArg>,
}

/// `--exposure`
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ExposureArg {
    /// By the radiance of the surfaces.
    Auto,
    /// A factor.
    Factor(f64),
}

/// `auto`, or a number above 0.
fn exposure(text: &str) -> Result<ExposureArg, String> {
    match text {
        "auto" => Ok(ExposureArg::Auto),
        _ => values::positive(text).map(ExposureArg::Factor),
    }
}

/// `--uv`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum UvArg {
    /// Keep them; fail if they are not suitable for a lightmap
    Keep,
    /// Create new ones
    New,
}

/// `--density`
#[derive(Clone, Debug)]
pub enum DensityArg {
    /// By the light that charts get.
    Auto,
    /// Of some objects.
    Objects(ObjectDensity),
}

/// How dense the texels of some objects are.
#[derive(Clone, Debug)]
pub struct ObjectDensity {
    /// As it was given.
    pub text: String,
    /// Names of objects.
    pub names: GlobMatcher,
    /// Texels per length relative to others.
    pub factor: f64,
}

/// `GLOB=N`, or `auto`
fn density(text: &str) -> Result<DensityArg, String> {
    if text == "auto" {
        return Ok(DensityArg::Auto);
    }
    let (names, factor) = text
        .rsplit_once('=')
        .ok_or("expected a name with * and ?, = and a number")?;
    let factor = values::positive(factor)?;
    if !(LEAST_DENSITY..=1.0 / LEAST_DENSITY).contains(&factor) {
        return Err(format!("{factor}: expected 0.001 to 1000"));
    }
    let names = Glob::new(names).map_err(|e| e.to_string())?;
    Ok(DensityArg::Objects(ObjectDensity {
        text: text.to_owned(),
        names: names.compile_matcher(),
        factor,
    }))
}

/// Least density of an object relative to others.
const LEAST_DENSITY: f64 = 1e-3;

/// `--light`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LightArg {
    /// Direct and indirect light
    Total,
    /// Indirect light only, for viewers that add the direct light of lamps and the sun
    Indirect,
    /// Direct light only
    Direct,
    /// Ambient occlusion: fraction of the hemisphere that is free of nearby surfaces
    Ao,
}

impl LightArg {
    /// For the library; `None` without light.
    pub fn baked(self) -> Option<BakedLight> {
        match self {
            LightArg::Total => Some(BakedLight::Total),
            LightArg::Indirect => Some(BakedLight::Indirect),
            LightArg::Direct => Some(BakedLight::Direct),
            LightArg::Ao => None,
        }
    }
}

/// `--double-sided`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DoubleSidedArg {
    /// The front of every surface
    Front,
    /// For each chart the back if it gets more than twice the light of the front, otherwise the
    /// front
    Brighter,
    /// Both, each with its own texels; the file is rewritten
    Split,
}

impl DoubleSidedArg {
    /// For the library.
    pub fn baked(self) -> BakedSides {
        match self {
            DoubleSidedArg::Front => BakedSides::Front,
            DoubleSidedArg::Brighter => BakedSides::Brighter,
            DoubleSidedArg::Split => BakedSides::Both,
        }
    }
}

/// `--directional`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DirectionalArg {
    /// Of each colour channel
    Sh,
    /// The dominant direction of the luminance
    Dominant,
}

impl DirectionalArg {
    /// For the writer.
    pub fn form(self) -> DirectionForm {
        match self {
            DirectionalArg::Sh => DirectionForm::Harmonics,
            DirectionalArg::Dominant => DirectionForm::Dominant,
        }
    }
}

/// `--as`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ConventionArg {
    /// The extension MOZ_lightmap of materials
    Moz,
    /// The extension MX_lightmap of nodes
    Mx,
    /// As emission, for viewers without lightmaps
    Emissive,
    /// As unlit colours, for viewers without lightmaps
    Unlit,
    /// The occlusionTexture of materials, with --light ao
    Occlusion,
    /// Not at all: texture coordinates only, for a separate --lightmap
    Plain,
}

impl ConventionArg {
    /// For the writer.
    pub fn written(self) -> Convention {
        match self {
            ConventionArg::Moz => Convention::Moz,
            ConventionArg::Mx => Convention::Mx,
            ConventionArg::Emissive => Convention::Emissive,
            ConventionArg::Unlit => Convention::Unlit,
            ConventionArg::Occlusion => Convention::Occlusion,
            ConventionArg::Plain => Convention::Plain,
        }
    }
}

/// `--image`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ImageArg {
    /// PNG: 8 bits, which every viewer reads
    Png,
    /// Radiance HDR, as Mozilla Hubs reads it, with a PNG for others
    Hdr,
    /// KTX2 with 9 bits and an exponent, as three.js reads it, with a PNG for others
    Ktx2,
    /// KTX2 with floats of 16 bits, likewise
    Ktx2Half,
}

/// `--instances`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum InstancesArg {
    /// A mesh for each further node, which shares all but the texture coordinates
    Copy,
    /// A material for each node, with KHR_texture_transform
    Transform,
    /// Offset and scale at the node, with --as mx
    Node,
}

impl InstancesArg {
    /// For the writer.
    pub fn written(self) -> InstanceMode {
        match self {
            InstancesArg::Copy => InstanceMode::Copy,
            InstancesArg::Transform => InstanceMode::Transform,
            InstancesArg::Node => InstanceMode::Node,
        }
    }
}

/// `--baked-lights`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LightsArg {
    /// Set their intensity to 0, and note the original
    Dim,
    /// Keep them
    Keep,
    /// Remove them from their nodes
    Remove,
}

impl LightsArg {
    /// For the writer.
    pub fn written(self) -> LightsMode {
        match self {
            LightsArg::Dim => LightsMode::Dim,
            LightsArg::Keep => LightsMode::Keep,
            LightsArg::Remove => LightsMode::Remove,
        }
    }
}
