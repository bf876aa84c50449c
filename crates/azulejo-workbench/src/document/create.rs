//! New shapes and lights, with sizes and strengths that suit the model they join.

use super::{EditError, PrismOutline, SceneDocument};
use azulejo::formats::{ppf, typeface};
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
    /// What it is.
    pub kind: NewShapeKind,
    /// The middle of its ground; for an area light, its own middle.
    pub at: DVec3,
    /// Its largest side, of a prism that of its base, of letters an em; world units, > 0.
    pub size: f64,
    /// What it is made of; `None` for a new white, or a new lamp.
    pub material: Option<MaterialId>,
}

/// The kinds of shapes that can be added.
#[derive(Clone, Debug, PartialEq)]
pub enum NewShapeKind {
    /// A cube.
    Cuboid,
    /// A ball.
    Sphere,
    /// A closed cylinder that stands.
    Cylinder,
    /// A closed cone that stands.
    Cone,
    /// A square that lies and looks up.
    Square,
    /// A square that shines downward.
    AreaLight,
    /// Outlines that are extruded upward.
    Prism(PrismOutline),
    /// Solid letters that stand and look at the viewer.
    Text(TextLayout),
}

/// Text that has been set: outlines and where they go.
#[derive(Clone, Debug, PartialEq)]
pub struct TextLayout {
    text: String,
    glyphs: Vec<PlacedGlyph>,
    depth: f64,
}

/// A light to add.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewLight {
    /// What it is.
    pub kind: NewLightKind,
    /// Where it is.
    pub at: DVec3,
    /// What it looks at.
    pub toward: DVec3,
}

/// The kinds of lights without area that can be added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NewLightKind {
    /// In all directions.
    Point,
    /// In a cone.
    Spot,
    /// From far away.
    Directional,
    /// From everywhere.
    Ambient,
}

/// The typeface for those who choose none: its licence stands beside the examples.
const TYPEFACE: &[u8] = include_bytes!("../../../../examples/fonts/dejavu-serif.ppf");
/// Letters that one line of a dialog holds with ease; a page belongs into a file.
const MAX_TEXT_CHARS: usize = 10_000;
/// Reflectance of what is made by hand.
const WHITE: f64 = 0.7;
/// Radiance of a new lamp, W/(sr·m²), or in scenes of lux, cd/m²: a bright panel's.
const RADIANCE: f64 = 10.0;
const LUMINANCE: f64 = 5_000.0;
/// Irradiance that a new light gives to what it looks at, W/m², or lux.
const IRRADIANCE: f64 = 3.0;
const ILLUMINANCE: f64 = 500.0;

impl NewShapeKind {
    /// Its name for people, before a number is put behind it.
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
    /// Sets `text` in a font file of any kind, or in the typeface that comes with azulejo; letters
    /// are `depth` ems deep.
    ///
    /// # Errors
    /// No text or too much, no positive depth, a font that cannot be read or lacks a character.
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

/// Right, up and toward the viewer of someone who stands in the scene.
fn axes(up: Up) -> DMat3 {
    match up {
        Up::Y => DMat3::IDENTITY,
        Up::Z => DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y),
    }
}

impl NewShape {
    /// A name and the shape; may add a material to the document.
    pub(super) fn make(&self, document: &mut SceneDocument) -> Result<(String, Shape), EditError> {
        let valid = self.at.is_finite() && self.size > 0.0 && self.size.is_finite();
        if !valid {
            let message = format!("a size of {} at {}, expected > 0", self.size, self.at);
            return Err(EditError(message));
        }
        if (self.material).is_some_and(|m| m as usize >= document.materials.len()) {
            return Err(EditError("there is no such material any more".into()));
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
            // Lamps are dimmed one by one.
            (Some(at), kind) if *kind != NewShapeKind::AreaLight => at as MaterialId,
            _ => {
                document.materials.push(Arc::new(material));
                (document.materials.len() - 1) as MaterialId
            }
        }
    }

    fn shape(&self, up: Up, material: MaterialId) -> Shape {
        // The unit primitives stand along z.
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
            // Turned about x, so that the front looks down.
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
    /// The light, bright enough for what it looks at.
    pub(super) fn make(&self, document: &SceneDocument) -> Light {
        let wanted = if document.units.photometric {
            ILLUMINANCE
        } else {
            IRRADIANCE
        };
        let toward = self.toward - self.at;
        let down = -document.units.up.axis();
        let direction = toward.try_normalize().unwrap_or(down);
        let intensity = Rgb::grey(wanted * toward.length_squared().max(f64::MIN_POSITIVE));
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
            NewLightKind::Directional => (
                "sun",
                LightKind::Directional {
                    direction,
                    irradiance: Rgb::grey(wanted),
                },
            ),
            // A hemisphere of radiance L gives a horizontal surface πL.
            NewLightKind::Ambient => (
                "sky",
                LightKind::Ambient {
                    radiance: Rgb::grey(wanted / std::f64::consts::PI),
                },
            ),
        };
        Light {
            name: name.into(),
            kind,
        }
    }
}
