//! Arguments of `text`, `font` and `extrude`.

use super::values::{self, Characters, Edge, Flux};
use crate::convert::PolygonArgs;
use crate::values::{number, vector};
use azulejo_formats::outline::typeface::{AxisValue, FontFeature};
use azulejo_scene::{Align, Rgb};
use clap::{Args, Subcommand, ValueEnum, ValueHint};
use glam::DVec3;
use std::path::PathBuf;

/// `text`
#[derive(Debug, Args)]
pub struct TextArgs {
    /// The text; \n starts a new line, {size=1.5 color=#c00|words} differ from the rest, `-` reads standard input
    #[arg(
        value_name = "TEXT",
        required_unless_present = "file",
        allow_hyphen_values = true
    )]
    pub text: Option<String>,
    /// Read the text from this file (UTF-8)
    #[arg(long, value_name = "FILE", conflicts_with = "text", value_hint = ValueHint::FilePath)]
    pub file: Option<PathBuf>,
    #[command(flatten)]
    pub typeface: TypefaceArgs,
    /// Output file: .grf and .sff keep exact outlines, .obj, .glb, .gltf and .ply get polygons, .stl and .3mf
    /// closed ones; `-` writes GRF to standard output
    #[arg(long, short, value_name = "OUT", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,
    #[command(flatten)]
    pub polygons: PolygonArgs,
    #[command(flatten)]
    pub lines: LinesArgs,
    #[command(flatten)]
    pub solid: SolidArgs,
    #[command(flatten)]
    pub edge: EdgeArgs,
    #[command(flatten)]
    pub frame: FrameArgs,
    #[command(flatten)]
    pub surface: SurfaceArgs,
}

/// The fonts.
#[derive(Debug, Args)]
#[command(next_help_heading = "Font")]
pub struct TypefaceArgs {
    /// Font files: TrueType, OpenType (.ttf, .otf, .ttc#2 for the third face), WOFF (.woff, .woff2), Type 1 (.pfb,
    /// .pfa, .t1, with the .afm beside it), or RTRACE's .ppf. What the first lacks is taken from the next
    #[arg(long, visible_alias = "ppf", value_name = "FILE,...", required = true,
          value_hint = ValueHint::FilePath)]
    pub font: Vec<PathBuf>,
    /// Encoding of .ppf fonts (.ppe) [default: Adobe's glyph names]
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub encoding: Option<PathBuf>,
    /// Values on the axes of variable fonts, as in wght=650,wdth=80 [default: those of the font]
    #[arg(long, value_name = "AXIS=VALUE,...", value_delimiter = ',')]
    pub variation: Vec<AxisValue>,
    /// OpenType features to switch, as in smcp,ss01,liga=0
    #[arg(long, value_name = "FEATURE,...", value_delimiter = ',')]
    pub features: Vec<FontFeature>,
}

/// The layout of lines.
#[derive(Debug, Args)]
#[command(next_help_heading = "Lines")]
pub struct LinesArgs {
    /// Additional space between letters, in ems
    #[arg(long, value_name = "EMS", default_value_t = 0.0, value_parser = number,
          allow_hyphen_values = true)]
    pub spacing: f64,
    /// Distance between baselines, in ems
    #[arg(long, value_name = "EMS", default_value_t = 1.2, value_parser = number,
          allow_hyphen_values = true)]
    pub line_spacing: f64,
    /// Alignment of lines
    #[arg(long, value_name = "SIDE", value_enum, default_value_t = AlignName::Left)]
    pub align: AlignName,
    /// Break lines that would be longer than this, in scene units
    #[arg(long, value_name = "LENGTH", value_parser = values::positive, allow_hyphen_values = true)]
    pub width: Option<f64>,
    /// Set the text along the first path of an SVG drawing, whose units are those of the scene
    #[arg(long, value_name = "SVG", conflicts_with = "width", value_hint = ValueHint::FilePath)]
    pub path: Option<PathBuf>,
}

/// Alignment of lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum AlignName {
    /// Lines start at the position of the text
    Left,
    /// Lines are centred on it
    #[value(alias = "centre")]
    Center,
    /// Lines end at it
    Right,
    /// Lines fill the width or the path, those at the ends of paragraphs excepted
    Justify,
}

impl AlignName {
    /// The alignment as the library takes it.
    pub fn align(self) -> Align {
        match self {
            AlignName::Left | AlignName::Justify => Align::Left,
            AlignName::Center => Align::Center,
            AlignName::Right => Align::Right,
        }
    }
}

/// The size of letters.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Size")]
pub struct SolidArgs {
    /// Font size: the length of an em
    #[arg(long, value_name = "LENGTH", default_value_t = 1.0, value_parser = values::positive,
          allow_hyphen_values = true)]
    pub size: f64,
    /// Depth of the letters [default: a quarter of the size]
    #[arg(long, value_name = "LENGTH", value_parser = values::positive,
          allow_hyphen_values = true)]
    pub depth: Option<f64>,
}

/// The edges of solids.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Size")]
pub struct EdgeArgs {
    /// Round the edges about the front, or cut them off: `0.02` or `round:0.02`, `chamfer:0.02`, with `:both` also
    /// those about the back
    #[arg(long, value_name = "[PROFILE:]RADIUS[:both]", value_parser = values::edge)]
    pub bevel: Option<Edge>,
}

/// The position of the front plane, and the direction of extrusion.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Position")]
pub struct FrameArgs {
    /// Start of the first line, on the front plane
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,0", value_parser = vector,
          allow_hyphen_values = true)]
    pub at: DVec3,
    /// Nine numbers as in SFF: the directions along the line, up, and from front to back. They are
    /// normalized, and need not be perpendicular
    #[arg(long, value_name = "P,U,E", default_value = "1,0,0,0,1,0,0,0,-1",
          value_parser = values::orientation, allow_hyphen_values = true)]
    pub orientation: Directions,
    /// Slant letters towards the end of the line, as italics
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, value_parser = values::slope,
          allow_hyphen_values = true)]
    pub slant: f64,
    /// Shear the extrusion towards the end of the line, and upwards; front plane and depth remain
    #[arg(long, value_name = "DEGREES[,DEGREES]", default_value = "0",
          value_parser = values::slopes, allow_hyphen_values = true)]
    pub oblique: Slopes,
}

/// Unit vectors along the line, up, and along the extrusion.
pub type Directions = [DVec3; 3];

/// Angles in degrees towards the end of the line, and upwards.
pub type Slopes = [f64; 2];

/// The material of a solid.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Surface")]
pub struct SurfaceArgs {
    /// Diffuse reflectance: linear, as 0.8,0.4,0.1 or 0.5, or sRGB, as #e8a030 [default: 0.7, or the
    /// colours of the drawing]
    #[arg(long, value_name = "COLOR", value_parser = values::reflectance)]
    pub color: Option<Rgb>,
    /// Specular reflectance
    #[arg(long, value_name = "COLOR", value_parser = values::reflectance)]
    pub mirror: Option<Rgb>,
    /// Emitted radiance, W/(sr·m²); with --flux, its colour
    #[arg(long, value_name = "COLOR", value_parser = values::radiance)]
    pub emission: Option<Rgb>,
    /// Luminous flux: of the whole, 1200lm, or per metre of its strokes, 800lm/m, whose length is half of that of the
    /// outlines. All sides shine evenly, and the scene is photometric
    #[arg(long, value_name = "FLUX", value_parser = values::flux)]
    pub flux: Option<Flux>,
    /// Name of the object and its material [default: the text, or the file]
    #[arg(long, value_name = "NAME")]
    pub name: Option<String>,
}

/// `font`
#[derive(Debug, Subcommand)]
pub enum FontCommand {
    /// Convert a font to RTRACE's PPF, and its encoding to PPE
    #[command(after_help = CONVERT_EXAMPLES)]
    Convert(FontConvertArgs),
    /// Draw a specimen sheet of all glyphs with their names
    #[command(after_help = SHEET_EXAMPLES)]
    Sheet(FontSheetArgs),
}

/// `font convert`
#[derive(Debug, Args)]
pub struct FontConvertArgs {
    /// Font file: TrueType, OpenType (.ttf, .otf, .ttc#2 for the third face), WOFF (.woff, .woff2), Type 1 (.pfb, .pfa,
    /// .t1), or RTRACE's .ppf
    #[arg(value_name = "FONT", value_hint = ValueHint::FilePath)]
    pub font: PathBuf,
    /// Output file for the outlines (.ppf); `-` is standard output
    #[arg(long, short, value_name = "OUT", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,
    /// Output file for the encoding (.ppe)
    #[arg(long, value_name = "OUT", value_hint = ValueHint::FilePath)]
    pub encoding: Option<PathBuf>,
    #[command(flatten)]
    pub part: FontPart,
}

/// `font sheet`
#[derive(Debug, Args)]
pub struct FontSheetArgs {
    /// Font file: TrueType, OpenType (.ttf, .otf, .ttc#2 for the third face), WOFF (.woff, .woff2), Type 1 (.pfb, .pfa,
    /// .t1), or RTRACE's .ppf
    #[arg(value_name = "FONT", value_hint = ValueHint::FilePath)]
    pub font: PathBuf,
    /// Output image (.png); `-` is standard output
    #[arg(long, short, value_name = "OUT", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,
    /// Font size in pixels per em
    #[arg(long, value_name = "PIXELS", default_value_t = 64,
          value_parser = clap::value_parser!(u32).range(8..=1024))]
    pub size: u32,
    #[command(flatten)]
    pub part: FontPart,
}

/// The part of a font file to use.
#[derive(Debug, Args)]
#[command(next_help_heading = "Glyphs")]
pub struct FontPart {
    /// Characters: ascii, latin1, all, or hexadecimal codes as in 20-7e,20ac; ignored for .ppf,
    /// which is always used completely
    #[arg(long, value_name = "RANGES", default_value = "latin1", value_parser = values::characters)]
    pub characters: Characters,
}

/// What becomes of shapes that are painted over others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PaintOrder {
    /// The front of each is higher than that of the one before it by this, > 0, in scene units.
    Raised(f64),
    /// Each is cut out of those before it.
    Inlay,
}

fn paint_order(text: &str) -> Result<PaintOrder, String> {
    match text {
        "inlay" => Ok(PaintOrder::Inlay),
        _ => values::positive(text)
            .map(PaintOrder::Raised)
            .map_err(|why| format!("{why}; expected a length or inlay")),
    }
}

/// `extrude`
#[derive(Debug, Args)]
pub struct ExtrudeArgs {
    /// Filled and stroked shapes and texts of an SVG or of a page of a PDF (a.pdf#2 for the second), or outlines and
    /// texts of a DXF drawing
    #[arg(value_name = "DRAWING", value_hint = ValueHint::FilePath)]
    pub drawing: PathBuf,
    /// Where to write, by extension: .grf and .sff keep exact outlines, .obj, .glb, .gltf and .ply
    /// get polygons, .stl and .3mf closed ones; `-` writes GRF to standard output
    #[arg(long, short, value_name = "OUT", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,
    #[command(flatten)]
    pub polygons: PolygonArgs,
    /// Depth of the solid, in scene units
    #[arg(long, value_name = "LENGTH", value_parser = values::positive,
          allow_hyphen_values = true)]
    pub depth: f64,
    /// Shapes painted over others: raise the front of each by this over that of the one before it, in scene units, or
    /// inlay: cut each out of those before it, so that all fronts are flush
    #[arg(long, value_name = "STEP|inlay", value_parser = paint_order, allow_hyphen_values = true)]
    pub layers: Option<PaintOrder>,
    /// Font of all texts in the drawing: TrueType, OpenType or Type 1 [default: those that it names, of the
    /// system's]
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub font: Option<PathBuf>,
    /// Length of one unit of the drawing, in scene units
    #[arg(long, value_name = "LENGTH", default_value_t = 1.0, value_parser = values::positive,
          allow_hyphen_values = true)]
    pub scale: f64,
    #[command(flatten)]
    pub edge: EdgeArgs,
    #[command(flatten)]
    pub frame: FrameArgs,
    #[command(flatten)]
    pub surface: SurfaceArgs,
}

pub const TEXT_EXAMPLES: &str = "\
Examples:
  azulejo text \"Iluminación global\" --font Serif.ttf -o title.grf
  azulejo text Azulejo --ppf examples/fonts/dejavu-serif.ppf --depth 0.1 --color '#2a5caa' -o a.glb
  azulejo text Azulejo --ppf examples/fonts/dejavu-serif.ppf --bevel 0.02 -o soft.grf
  fortune | azulejo text - --font Sans.otf --size 0.2 --align center --oblique 20 -o wise.grf
  azulejo text \"שלום 123 abc\" --font Latin.ttf,Hebrew.ttf --features smcp -o mixed.glb
  azulejo text --file poem.txt --font Serif.woff2 --width 12 --align justify -o poem.grf
  azulejo text \"Sale {size=2 color=#c00|50%}\" --font Sans.ttf --variation wght=700 -o sale.glb
  azulejo text OPEN --font Sans.ttf --depth 0.02 --flux 800lm/m --emission '#ff4020' -o neon.grf
  azulejo text Azulejo --font Sans.ttf --depth 8 --size 60 --tolerance 0.02 -o azulejo.3mf
  azulejo text \"around the world\" --font Sans.ttf --path circle.svg --align center -o ring.grf";

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
  azulejo extrude badge.svg --depth 2 --layers 0.3 -o badge.glb
  azulejo extrude plate.svg --depth 5 --bevel chamfer:0.5:both -o plate.stl
  azulejo extrude bracket.dxf --depth 6 --scale 0.001 --color 0.4 -o bracket.glb
  azulejo extrude brochure.pdf#2 --depth 2 -o title.grf";
