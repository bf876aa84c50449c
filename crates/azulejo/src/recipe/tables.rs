//! The file of a recipe: TOML, with the place of what is wrong.

use super::RecipeError;
use crate::files::Refused;
use crate::spelling;
use azulejo_scene::Rgb;
use serde::Deserialize;
use std::fmt;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// A recipe.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RecipeTables {
    /// Rules for materials.
    #[serde(default)]
    pub material: Vec<RuleTable>,
    /// Rules for objects.
    #[serde(default)]
    pub object: Vec<RuleTable>,
    /// Lights that are added.
    #[serde(default)]
    pub light: Vec<Spanned<LightTable>>,
    /// Cameras that are added.
    #[serde(default)]
    pub camera: Vec<Spanned<CameraTable>>,
    /// Radiance behind everything.
    pub background: Option<Spanned<RecipeColor>>,
    /// Fog.
    pub fog: Option<Spanned<FogTable>>,
}

/// One or several patterns.
#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "expected a pattern, or a list of patterns")]
pub(super) enum RecipePatterns {
    /// One.
    One(String),
    /// Several.
    Many(Vec<String>),
}

/// A colour: a number for all channels, or three.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(untagged, expecting = "expected a number, or [red, green, blue]")]
pub(super) enum RecipeColor {
    /// A whole number.
    Whole(i64),
    /// Grey.
    Grey(f64),
    /// Red, green and blue.
    Channels([f64; 3]),
}

/// What materials or objects of some names become.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RuleTable {
    /// The names.
    pub name: Spanned<RecipePatterns>,
    /// Diffuse reflectance.
    pub diffuse: Option<Spanned<RecipeColor>>,
    /// Reflectance of a perfect mirror.
    pub mirror: Option<Spanned<RecipeColor>>,
    /// Emitted radiance.
    pub emission: Option<Spanned<RecipeColor>>,
    /// A reflection model, as `azulejo brdf` takes it.
    pub brdf: Option<Spanned<String>>,
    /// Index of refraction of glass.
    pub glass: Option<Spanned<f64>>,
    /// Whether that is a whole pane.
    #[serde(default)]
    pub thin: bool,
    /// Luminous flux of each object.
    pub lumens: Option<Spanned<f64>>,
    /// Colour temperature of that light, kelvin.
    pub temperature: Option<f64>,
}

/// A light without area.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LightTable {
    /// Its name.
    #[serde(default)]
    pub name: String,
    /// point, spot, directional or luminaire.
    pub kind: String,
    /// The photometric file of a luminaire.
    pub file: Option<String>,
    /// Of point lights, spots and luminaires.
    pub position: Option<[f64; 3]>,
    /// Of spots and directional lights.
    pub direction: Option<[f64; 3]>,
    /// W/sr, or W/m² of directional lights.
    pub intensity: Option<Spanned<RecipeColor>>,
    /// Luminous flux of a point light, or of a luminaire in place of its file's.
    pub lumens: Option<f64>,
    /// Colour temperature of that light, kelvin.
    pub temperature: Option<f64>,
    /// Half angle of a spot's bright cone, degrees.
    #[serde(default)]
    pub inner: f64,
    /// Half angle beyond which a spot is dark, degrees.
    #[serde(default = "half_right")]
    pub outer: f64,
    /// By how many degrees a luminaire is tilted from straight down.
    #[serde(default)]
    pub tilt: f64,
    /// Where its plane of 0 degrees points, degrees from +x, counter-clockwise as seen from above.
    #[serde(default)]
    pub rotation: f64,
    /// By how many degrees it is turned about its own axis.
    #[serde(default)]
    pub spin: f64,
    /// Its set of lamps, from 1.
    pub lamp_set: Option<usize>,
}

fn half_right() -> f64 {
    45.0
}

/// A camera.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CameraTable {
    /// Its name.
    #[serde(default)]
    pub name: String,
    /// Position.
    pub eye: [f64; 3],
    /// The point in the middle of the picture.
    pub target: [f64; 3],
    /// The direction that is up in the picture.
    pub up: [f64; 3],
    /// Vertical field of view, degrees.
    pub fov: f64,
    /// Width and height in pixels.
    pub size: Option<[u32; 2]>,
}

/// Fog.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FogTable {
    /// Its radiance.
    pub color: Spanned<RecipeColor>,
    /// The distance at which nothing is seen.
    pub visibility: f64,
    /// Whether it thickens exponentially.
    #[serde(default)]
    pub exponential: bool,
}

/// The text of a recipe, for errors with positions.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct RecipeSource {
    /// Its file.
    pub path: PathBuf,
    text: String,
}

impl RecipeSource {
    /// Reads a recipe.
    pub fn read(path: &Path) -> Result<(RecipeTables, RecipeSource), RecipeError> {
        let text = azulejo_formats::disk::read_to_string(path).map_err(|error| {
            RecipeError::File(Refused {
                deed: "read",
                path: path.to_owned(),
                error,
            })
        })?;
        let source = RecipeSource {
            path: path.to_owned(),
            text,
        };
        let tables = toml::from_str(&source.text).map_err(|e| {
            let message = spelling::with_hint(e.message());
            source.wrong(e.span().map_or(0, |s| s.start), message)
        })?;
        Ok((tables, source))
    }

    /// A file by its path relative to the recipe.
    pub fn beside(&self, file: &str) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(file)
    }

    /// A message with the place of a byte before it.
    pub fn place(&self, byte: usize, message: impl fmt::Display) -> String {
        let before = self.text.get(..byte).unwrap_or(&self.text);
        let line = 1 + before.matches('\n').count();
        let column = 1 + before.rsplit('\n').next().unwrap_or("").chars().count();
        format!("{}:{line}:{column}: {message}", self.path.display())
    }

    /// An error at a byte of the text.
    pub fn wrong(&self, byte: usize, message: impl fmt::Display) -> RecipeError {
        RecipeError::Content(self.place(byte, message))
    }

    /// A colour of light: nothing negative.
    pub fn light(&self, color: &Spanned<RecipeColor>) -> Result<Rgb, RecipeError> {
        let rgb = match *color.get_ref() {
            RecipeColor::Whole(x) => Rgb::grey(x as f64),
            RecipeColor::Grey(x) => Rgb::grey(x),
            RecipeColor::Channels(list) => Rgb::from(list),
        };
        if is_light(rgb) {
            Ok(rgb)
        } else {
            Err(self.wrong(color.span().start, "colours are finite and not negative"))
        }
    }

    /// A reflectance: 0 to 1.
    pub fn share(&self, color: &Spanned<RecipeColor>) -> Result<Rgb, RecipeError> {
        let rgb = self.light(color)?;
        if rgb.max_channel() > 1.0 {
            return Err(self.wrong(color.span().start, "a reflectance is at most 1"));
        }
        Ok(rgb)
    }
}

/// Whether a colour can be light: finite, nothing negative.
fn is_light(color: Rgb) -> bool {
    color.to_array().iter().all(|x| *x >= 0.0 && x.is_finite())
}
