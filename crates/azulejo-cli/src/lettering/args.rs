//! What can be typed for `text`, `font` and `extrude`.

use super::values::{self, Characters};
use crate::values::{finite, vector};
use azulejo_scene::{Align, Rgb};
use clap::{Args, Subcommand, ValueEnum, ValueHint};
use glam::DVec3;
use std::path::PathBuf;

/// `text`
#[derive(Debug, Args)]
pub struct TextArgs {
    /// What to write; \n begins a new line, `-` is standard input
    #[arg(
        value_name = "TEXT",
        required_unless_present = "file",
        allow_hyphen_values = true
    )]
    pub text: Option<String>,
    /// Write what stands in this file (UTF-8)
    #[arg(long, value_name = "FILE", conflicts_with = "text", value_hint = ValueHint::FilePath)]
    pub file: Option<PathBuf>,
    #[command(flatten)]
    pub typeface: TypefaceArgs,
    /// Where to write, by extension: .grf and .sff keep exact letters, .obj, .glb, .gltf and .ply
    /// get polygons; `-` writes GRF to standard output
    #[arg(long, short, value_name = "OUT", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,
    #[command(flatten)]
    pub lines: LinesArgs,
    #[command(flatten)]
    pub solid: SolidArgs,
    #[command(flatten)]
    pub frame: FrameArgs,
    #[command(flatten)]
    pub surface: SurfaceArgs,
}

/// Which letters.
#[derive(Debug, Args)]
#[command(next_help_heading = "Typeface")]
pub struct TypefaceArgs {
    /// TrueType (.ttf, .ttc), OpenType (.otf), Type 1 (.pfb, .pfa, .t1), or RTRACE's .ppf
    #[arg(long, visible_alias = "ppf", value_name = "FILE", required = true,
          value_hint = ValueHint::FilePath)]
    pub font: PathBuf,
    /// Names of a .ppf's glyphs by character (.ppe) [default: by Adobe's glyph names]
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub encoding: Option<PathBuf>,
    /// Which face of a collection (.ttc)
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub face: u32,
}

/// How letters stand next to each other.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Lines")]
pub struct LinesArgs {
    /// More space between letters, in ems
    #[arg(long, value_name = "EMS", default_value_t = 0.0, value_parser = finite,
          allow_hyphen_values = true)]
    pub spacing: f64,
    /// From one base line to the next, in ems
    #[arg(long, value_name = "EMS", default_value_t = 1.2, value_parser = finite,
          allow_hyphen_values = true)]
    pub line_spacing: f64,
    /// Which part of each line is at the place where the text goes
    #[arg(long, value_name = "SIDE", value_enum, default_value_t = AlignName::Left)]
    pub align: AlignName,
}

/// On which side lines are flush.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum AlignName {
    /// Lines begin there
    Left,
    /// Their middles are there
    #[value(alias = "centre")]
    Center,
    /// Lines end there
    Right,
}

impl AlignName {
    /// What it means.
    pub fn align(self) -> Align {
        match self {
            AlignName::Left => Align::Left,
            AlignName::Center => Align::Center,
            AlignName::Right => Align::Right,
        }
    }
}

/// How large letters are.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Size")]
pub struct SolidArgs {
    /// Length of an em: the letters' size
    #[arg(long, value_name = "LENGTH", default_value_t = 1.0, value_parser = values::positive,
          allow_hyphen_values = true)]
    pub size: f64,
    /// How deep the letters are [default: a quarter of the size]
    #[arg(long, value_name = "LENGTH", value_parser = values::positive,
          allow_hyphen_values = true)]
    pub depth: Option<f64>,
}

/// Where a front plane lies, and where extrusion goes.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Place")]
pub struct FrameArgs {
    /// Where the first line begins, on the front
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,0", value_parser = vector,
          allow_hyphen_values = true)]
    pub at: DVec3,
    /// Nine numbers as in SFF: the directions of the line, of up, and from the front to the back.
    /// Their lengths do not count; they need not be perpendicular
    #[arg(long, value_name = "P,U,E", default_value = "1,0,0,0,1,0,0,0,-1",
          value_parser = values::orientation, allow_hyphen_values = true)]
    pub orientation: Directions,
    /// Lean upright strokes toward the end of the line, as italics do
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, value_parser = values::slope,
          allow_hyphen_values = true)]
    pub slant: f64,
    /// Turn the extrusion toward the end of the line, and second upward; fronts and depth stay
    #[arg(long, value_name = "DEGREES[,DEGREES]", default_value = "0",
          value_parser = values::slopes, allow_hyphen_values = true)]
    pub oblique: Slopes,
}

/// Of the line, of up, of extrusion; unit vectors.
pub type Directions = [DVec3; 3];

/// Degrees toward the end of the line, and upward.
pub type Slopes = [f64; 2];

/// What a solid is made of.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Surface")]
pub struct SurfaceArgs {
    /// Share of light that is reflected diffusely: linear, 0.8,0.4,0.1 or 0.5, or #e8a030 as on
    /// screens [default: 0.7, or the colours of a drawing]
    #[arg(long, value_name = "COLOR", value_parser = values::reflectance)]
    pub color: Option<Rgb>,
    /// Share of light that is mirrored
    #[arg(long, value_name = "COLOR", value_parser = values::reflectance)]
    pub mirror: Option<Rgb>,
    /// Light that the surface emits, W/(sr·m²)
    #[arg(long, value_name = "COLOR", value_parser = values::radiance)]
    pub emission: Option<Rgb>,
    /// Name of the object and its material [default: the text, or the file]
    #[arg(long, value_name = "NAME")]
    pub name: Option<String>,
}

/// `font`
#[derive(Debug, Subcommand)]
pub enum FontCommand {
    /// Write a typeface's outlines as RTRACE's PPF, and the names of its characters as PPE
    #[command(after_help = CONVERT_EXAMPLES)]
    Convert(FontConvertArgs),
    /// Draw all glyphs with their names
    #[command(after_help = SHEET_EXAMPLES)]
    Sheet(FontSheetArgs),
}

/// `font convert`
#[derive(Debug, Args)]
pub struct FontConvertArgs {
    /// TrueType (.ttf, .ttc), OpenType (.otf), Type 1 (.pfb, .pfa, .t1), or RTRACE's .ppf
    #[arg(value_name = "FONT", value_hint = ValueHint::FilePath)]
    pub font: PathBuf,
    /// Where to write the outlines (.ppf); `-` is standard output
    #[arg(long, short, value_name = "OUT", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,
    /// Where to write the names by character (.ppe)
    #[arg(long, value_name = "OUT", value_hint = ValueHint::FilePath)]
    pub encoding: Option<PathBuf>,
    #[command(flatten)]
    pub part: FontPart,
}

/// `font sheet`
#[derive(Debug, Args)]
pub struct FontSheetArgs {
    /// TrueType (.ttf, .ttc), OpenType (.otf), Type 1 (.pfb, .pfa, .t1), or RTRACE's .ppf
    #[arg(value_name = "FONT", value_hint = ValueHint::FilePath)]
    pub font: PathBuf,
    /// Where to write the picture (.png); `-` is standard output
    #[arg(long, short, value_name = "OUT", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,
    /// Pixels of an em
    #[arg(long, value_name = "PIXELS", default_value_t = 64,
          value_parser = clap::value_parser!(u32).range(8..=1024))]
    pub size: u32,
    #[command(flatten)]
    pub part: FontPart,
}

/// Which part of a font file.
#[derive(Debug, Args)]
pub struct FontPart {
    /// Which characters: ascii, latin1, all, or hexadecimal codes as in 20-7e,20ac; a .ppf is
    /// taken whole
    #[arg(long, value_name = "RANGES", default_value = "latin1", value_parser = values::characters)]
    pub characters: Characters,
    /// Which face of a collection (.ttc)
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub face: u32,
}

/// `extrude`
#[derive(Debug, Args)]
pub struct ExtrudeArgs {
    /// Filled shapes of an SVG, or closed outlines of a DXF drawing
    #[arg(value_name = "DRAWING", value_hint = ValueHint::FilePath)]
    pub drawing: PathBuf,
    /// Where to write, by extension: .grf and .sff keep exact outlines, .obj, .glb, .gltf and .ply
    /// get polygons; `-` writes GRF to standard output
    #[arg(long, short, value_name = "OUT", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,
    /// How deep the solid is, in units of the scene
    #[arg(long, value_name = "LENGTH", value_parser = values::positive,
          allow_hyphen_values = true)]
    pub depth: f64,
    /// Length of a unit of the drawing
    #[arg(long, value_name = "LENGTH", default_value_t = 1.0, value_parser = values::positive,
          allow_hyphen_values = true)]
    pub scale: f64,
    #[command(flatten)]
    pub frame: FrameArgs,
    #[command(flatten)]
    pub surface: SurfaceArgs,
}

pub const TEXT_EXAMPLES: &str = "\
Examples:
  azulejo text \"Iluminación global\" --font Serif.ttf -o title.grf
  azulejo text Azulejo --ppf examples/fonts/dejavu-serif.ppf --depth 0.1 --color '#2a5caa' -o a.glb
  fortune | azulejo text - --font Sans.otf --size 0.2 --align center --oblique 20 -o wise.grf";

pub const FONT_EXAMPLES: &str = "\
Examples:
  azulejo font convert Serif.ttf -o serif.ppf --encoding serif.ppe
  azulejo font sheet serif.ppf -o serif.png";

const CONVERT_EXAMPLES: &str = "\
Examples:
  azulejo font convert Serif.ttf -o serif.ppf --encoding serif.ppe
  azulejo font convert Sans.otf -o greek.ppf --encoding greek.ppe --characters ascii,370-3ff";

const SHEET_EXAMPLES: &str = "\
Examples:
  azulejo font sheet serif.ppf -o serif.png
  azulejo font sheet Sans.ttf -o sans.png --size 32 --characters all";

pub const EXTRUDE_EXAMPLES: &str = "\
Examples:
  azulejo extrude logo.svg --depth 2 -o logo.grf
  azulejo extrude bracket.dxf --depth 6 --scale 0.001 --color 0.4 -o bracket.glb";
