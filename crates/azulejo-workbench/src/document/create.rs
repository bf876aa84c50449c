//! New shapes and lights, with sizes and strengths that suit the model.

use super::{EditError, PrismOutline, SceneDocument};
use azulejo::formats::outline::{ppf, typeface};
use azulejo::scene::{
    Align, Exact, Light, LightKind, Line, Material, MaterialId, PlacedGlyph, Primitive,
    PrimitiveKind, Rgb, Shape, Solid, TextFrame, Up,
};
use glam::{DAffine3, DMat3, DVec3};
use std::fmt;
use std::sync::Arc;

/// A shape to add.
#[derive(Clone, Debug, PartialEq)]
pub struct NewShape {
    /// Which shape, with what it takes beside a size.
    pub kind: NewShapeKind,
    /// Centre of its base; for an area light, its own centre.
    pub at: DVec3,
    /// Largest side (of the base for a prism; an em for text), world units, > 0.
    pub size: f64,
    /// Its material; `None` creates a new white or emissive one.
    pub material: Option<MaterialId>,
}

/// The shapes that can be added.
#[derive(Clone, Debug, PartialEq)]
pub enum NewShapeKind {
    /// A cube.
    Cuboid,
    /// A sphere.
    Sphere,
    /// An upright closed cylinder.
    Cylinder,
    /// An upright closed cone.
    Cone,
    /// A horizontal square that faces up.
    Square,
    /// A square that emits downward.
    AreaLight,
    /// An outline extruded upward.
    Prism(PrismOutline),
    /// Upright solid text that faces the front.
    Text(TextLayout),
}

/// Text after layout: glyph outlines and their positions.
#[derive(Clone, Debug, PartialEq)]
pub struct TextLayout {
    text: String,
    glyphs: Vec<PlacedGlyph>,
    depth: f64,
}

/// A light to add.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewLight {
    /// Which light source.
    pub kind: NewLightKind,
    /// Its position in world space.
    pub at: DVec3,
    /// The point it is aimed at.
    pub toward: DVec3,
}

/// The light sources without area that can be added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NewLightKind {
    /// A point light.
    Point,
    /// A spot light.
    Spot,
    /// The sun: parallel light from a disc. Its position and target do not matter.
    Sun,
    /// A clear sky around the sun.
    Sky,
    /// Uniform light from all directions.
    Ambient,
}

/// The typeface for text without a font file.
const TYPEFACE: &[u8] = azulejo::typeface::DEJAVU_SERIF;
/// Limit on the length of a text, in characters.
const MAX_TEXT_CHARS: usize = 10_000;
/// Reflectance of new white materials.
const WHITE: f64 = 0.7;
/// Radiance of a new area light, W/(sr·m²), or cd/m² in photometric scenes: that of a bright panel.
const RADIANCE: f64 = 10.0;
const LUMINANCE: f64 = 5_000.0;
/// Irradiance that a new light produces at its target, W/m² or lux.
const IRRADIANCE: f64 = 3.0;
const ILLUMINANCE: f64 = 500.0;

impl NewShapeKind {
    /// Base of the name of a new object, before a number is appended.
    fn name(&self) -> &str {
        match self {
            NewShapeKind::Cuboid => "box",
            NewShapeKind::Sphere => "sphere",
            NewShapeKind::Cylinder => "cylinder",
            NewShapeKind::Cone => "cone",
            NewShapeKind::Square => "square",
            NewShapeKind::AreaLight => "area light",
            NewShapeKind::Prism(outline) => outline.name(),
            NewShapeKind::Text(lettering) => &lettering.text,
        }
    }
}

impl TextLayout {
    /// Lays out `text` in a font of any supported format, or in the default typeface, extruded by
    /// `depth` ems.
    ///
    /// # Errors
    ///
    /// The text is empty or too long, the depth is not positive, or the font cannot be read or
    /// lacks a character.
    pub fn set(
        text: &str,
        depth: f64,
        font: Option<(&[u8], &str)>,
    ) -> Result<TextLayout, EditError> {
        if text.trim().is_empty() || text.len() > MAX_TEXT_CHARS {
            let message = format!(
                "{} bytes of text, expected 1 to {MAX_TEXT_CHARS}",
                text.trim().len()
            );
            return Err(EditError(message));
        }
        if !(depth > 0.0 && depth.is_finite()) {
            return Err(EditError(format!(
                "letters {depth} deep, expected more than 0"
            )));
        }
        let (bytes, name) = font.unwrap_or((TYPEFACE, "dejavu-serif.ppf"));
        let lines = if ppf::is_ppf(bytes) {
            let (font, _) = ppf::read(bytes, name).map_err(refused)?;
            let encoding = typeface::encoding_of(&font);
            set_lines(text, |line| font.set_line(line, &encoding, 0.0))?
        } else {
            let face = typeface::Typeface::read(bytes, name, 0).map_err(refused)?;
            let mut setting = face.setting();
            set_lines(text, |line| setting.line(line, 0.0))?
        };
        Ok(TextLayout {
            text: text.lines().next().unwrap_or_default().trim().to_owned(),
            glyphs: Align::Center.stack(lines, 1.2),
            depth,
        })
    }
}

fn refused(error: impl fmt::Display) -> EditError {
    EditError(error.to_string())
}

fn set_lines<E: fmt::Display>(
    text: &str,
    set: impl FnMut(&str) -> Result<Line, E>,
) -> Result<Vec<Line>, EditError> {
    text.lines()
        .map(set)
        .collect::<Result<_, E>>()
        .map_err(refused)
}

/// Axes of an upright object: right, up and toward the viewer.
fn axes(up: Up) -> DMat3 {
    match up {
        Up::Y => DMat3::IDENTITY,
        Up::Z => DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y),
    }
}

impl NewShape {
    /// Creates the shape and a name for it; may add a material to the document.
    pub(super) fn make(&self, document: &mut SceneDocument) -> Result<(String, Shape), EditError> {
        let valid = self.at.is_finite() && self.size > 0.0 && self.size.is_finite();
        if !valid {
            let message = format!("a size of {} at {}, expected > 0", self.size, self.at);
            return Err(EditError(message));
        }
        if (self.material).is_some_and(|m| m as usize >= document.materials.len()) {
            return Err(EditError("the material no longer exists".into()));
        }
        let material = self.material.unwrap_or_else(|| self.new_material(document));
        let shape = self.shape(document.units.up, material);
        Ok((self.kind.name().to_owned(), shape))
    }

    fn new_material(&self, document: &mut SceneDocument) -> MaterialId {
        let material = match self.kind {
            NewShapeKind::AreaLight => {
                let strength = if document.units.photometric {
                    LUMINANCE
                } else {
                    RADIANCE
                };
                Material::emitter("lamp", Rgb::grey(strength))
            }
            _ => Material::diffuse("white", Rgb::grey(WHITE)),
        };
        let same = document.materials.iter().position(|m| **m == material);
        match (same, &self.kind) {
            // Each area light has its own material, so that it can be dimmed separately.
            (Some(at), kind) if *kind != NewShapeKind::AreaLight => at as MaterialId,
            _ => {
                document.materials.push(Arc::new(material));
                (document.materials.len() - 1) as MaterialId
            }
        }
    }

    fn shape(&self, up: Up, material: MaterialId) -> Shape {
        // The unit primitives have z as their axis.
        let standing = axes(up) * DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y);
        let primitive = |kind, size: DVec3, corner: DVec3| {
            let map = DAffine3 {
                matrix3: standing * DMat3::from_diagonal(size),
                translation: self.at + standing * corner,
            };
            Shape::Primitive(Primitive::new(kind, map, material))
        };
        let (s, r) = (self.size, 0.5 * self.size);
        let column = DVec3::new(r, r, s);
        match &self.kind {
            NewShapeKind::Cuboid => primitive(
                PrimitiveKind::Cuboid,
                DVec3::splat(s),
                DVec3::new(-r, -r, 0.0),
            ),
            NewShapeKind::Sphere => primitive(PrimitiveKind::Sphere, DVec3::splat(r), r * DVec3::Z),
            NewShapeKind::Cylinder => primitive(PrimitiveKind::Cylinder, column, DVec3::ZERO),
            NewShapeKind::Cone => primitive(PrimitiveKind::Cone { top: 0.0 }, column, DVec3::ZERO),
            NewShapeKind::Square => primitive(
                PrimitiveKind::Square,
                DVec3::splat(s),
                DVec3::new(-r, -r, 0.0),
            ),
            // Rotated about x so that the front faces down.
            NewShapeKind::AreaLight => primitive(
                PrimitiveKind::Square,
                DVec3::new(s, -s, -s),
                DVec3::new(-r, r, 0.0),
            ),
            NewShapeKind::Prism(outline) => outline.prisms(s, self.at, standing, material),
            NewShapeKind::Text(lettering) => self.letters(lettering, up, material),
        }
    }

    fn letters(&self, lettering: &TextLayout, up: Up, material: MaterialId) -> Shape {
        let axes = axes(up);
        let frame = TextFrame {
            origin: self.at,
            progression: axes.x_axis,
            up: axes.y_axis,
            extrusion: -axes.z_axis,
            scale: self.size * DVec3::new(1.0, 1.0, lettering.depth),
        };
        let prisms = frame.prisms(&lettering.glyphs, material);
        Shape::Exact(Exact::new(prisms.into_iter().map(Solid::Prism).collect()))
    }
}

impl NewLight {
    /// Creates the light, bright enough for the distance to its target.
    pub(super) fn make(&self, document: &SceneDocument) -> Light {
        let unit = if document.units.photometric {
            ILLUMINANCE
        } else {
            IRRADIANCE
        };
        let toward = self.toward - self.at;
        let down = -document.units.up.axis();
        let direction = toward.try_normalize().unwrap_or(down);
        let intensity = Rgb::grey(unit * toward.length_squared().max(f64::MIN_POSITIVE));
        let position = self.at;
        let (name, kind) = match self.kind {
            NewLightKind::Point => (
                "point light",
                LightKind::Point {
                    position,
                    intensity,
                },
            ),
            NewLightKind::Spot => (
                "spot light",
                LightKind::Spot {
                    position,
                    direction,
                    intensity,
                    inner: 20f64.to_radians(),
                    outer: 30f64.to_radians(),
                },
            ),
            NewLightKind::Sun => ("sun", document.new_sun()),
            NewLightKind::Sky => ("sky", document.new_sky()),
            // A hemisphere of radiance L produces the irradiance πL on a horizontal surface.
            NewLightKind::Ambient => (
                "ambient light",
                LightKind::Ambient {
                    radiance: Rgb::grey(unit / std::f64::consts::PI),
                },
            ),
        };
        Light {
            name: name.into(),
            kind,
        }
    }
}
