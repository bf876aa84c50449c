//! Converts text blocks to prisms.

use super::document::{SffPosition, SffSources, TextCommand, TextCommandKind};
use crate::outline::{ppe, ppf};
use crate::reading::files::open_beside;
use crate::reading::options::Budget;
use crate::reading::warnings::Warnings;
use crate::{Files, ReadError, Warning};
use azulejo_scene::{Encoding, Font, MaterialId, Prism, TextFrame};
use glam::{DMat3, DVec3};
use std::collections::HashMap;
use std::sync::Arc;

/// The current settings, which persist from one block to the next.
#[derive(Default)]
pub(super) struct Typesetter {
    spacing: Option<f64>,
    scale: Option<DVec3>,
    orientation: Option<[DVec3; 3]>,
    font: Option<Arc<Font>>,
    encoding: Option<Arc<Encoding>>,
    fonts: HashMap<String, Arc<Font>>,
    encodings: HashMap<String, Arc<Encoding>>,
}

/// The files, and the collectors of positions and warnings.
pub(super) struct TypesetContext<'r, 's> {
    pub files: &'r dyn Files,
    pub sources: &'r SffSources<'s>,
    pub warnings: &'r mut Warnings,
    pub budget: &'r mut Budget,
}

impl Typesetter {
    /// Executes the commands of a block.
    ///
    /// # Errors
    /// Settings that are missing before the first string or invalid, files that cannot be read, and
    /// characters without a glyph.
    pub fn run(
        &mut self,
        commands: &[TextCommand],
        material: MaterialId,
        context: &mut TypesetContext,
    ) -> Result<Vec<Prism>, ReadError> {
        let mut prisms = Vec::new();
        for command in commands {
            let place = command.place;
            match &command.kind {
                TextCommandKind::Spacing(spacing) => self.spacing = Some(*spacing),
                TextCommandKind::Scale(scale) if scale.min_element() > 0.0 => {
                    self.scale = Some(*scale);
                }
                TextCommandKind::Scale(scale) => {
                    let found = format!("SCALE {} {} {}", scale.x, scale.y, scale.z);
                    return Err(context
                        .sources
                        .error(place, found, "three positive numbers"));
                }
                TextCommandKind::Orientation(axes) => {
                    self.orientation = Some(orientation(axes, place, context)?);
                }
                TextCommandKind::Font(name) => {
                    let font = load(&mut self.fonts, name, place, context, ppf::read)?;
                    self.font = Some(font);
                }
                TextCommandKind::Encoding(name) => {
                    let encoding = load(&mut self.encodings, name, place, context, ppe::read)?;
                    self.encoding = Some(encoding);
                }
                TextCommandKind::At(origin, text) => {
                    // A glyph's prism is as large as a few vertices.
                    let count = 4 * text.len() as u64;
                    (context.budget.spend(count))
                        .map_err(|e| e.error(context.sources.name(place.file)))?;
                    prisms.extend(self.set(*origin, text, material, place, context.sources)?);
                }
            }
        }
        Ok(prisms)
    }

    fn set(
        &self,
        origin: DVec3,
        text: &str,
        material: MaterialId,
        place: SffPosition,
        sources: &SffSources,
    ) -> Result<Vec<Prism>, ReadError> {
        let missing = |name: &str| {
            let found = format!("AT before any {name}");
            let expected = "SPACING, SCALE, ORIENTATION, FONT and ENCODING before the first AT";
            sources.error(place, found, expected)
        };
        let spacing = self.spacing.ok_or_else(|| missing("SPACING"))?;
        let scale = self.scale.ok_or_else(|| missing("SCALE"))?;
        let axes = self.orientation.ok_or_else(|| missing("ORIENTATION"))?;
        let font = self.font.as_ref().ok_or_else(|| missing("FONT"))?;
        let encoding = self.encoding.as_ref().ok_or_else(|| missing("ENCODING"))?;
        let frame = TextFrame {
            origin,
            progression: axes[0],
            up: axes[1],
            extrusion: axes[2],
            scale,
        };
        let placed = font.lay_out(text, encoding, spacing).map_err(|e| {
            let expected = "characters and /names/ that ENCODING and FONT define";
            sources.error(place, e.to_string(), expected)
        })?;
        Ok(frame.prisms(&placed, material))
    }
}

/// Unit directions that span space.
fn orientation(
    axes: &[DVec3; 3],
    place: SffPosition,
    context: &TypesetContext,
) -> Result<[DVec3; 3], ReadError> {
    let unit = axes.map(DVec3::normalize_or_zero);
    let volume = DMat3::from_cols(unit[0], unit[1], unit[2]).determinant();
    if volume.abs() > 1e-12 {
        return Ok(unit);
    }
    let found = "ORIENTATION with directions that are zero, parallel or in one plane";
    let expected = "progression, up and extrusion that span space";
    Err(context.sources.error(place, found, expected))
}

/// Decodes a font or an encoding.
type DecodeFn<T> = fn(&[u8], &str) -> Result<(T, Vec<Warning>), ReadError>;

/// The font or encoding in a file, read once.
fn load<T>(
    known: &mut HashMap<String, Arc<T>>,
    name: &str,
    place: SffPosition,
    context: &mut TypesetContext,
    read: DecodeFn<T>,
) -> Result<Arc<T>, ReadError> {
    let of = context.sources.name(place.file);
    let key = crate::reading::files::beside(of, name);
    if let Some(known) = known.get(&key) {
        return Ok(Arc::clone(known));
    }
    let (path, bytes) = open_beside(context.files, of, name).map_err(|e| {
        let found = format!("\"{name}\", which cannot be read: {e}");
        context
            .sources
            .error(place, found, "a file beside the scene")
    })?;
    let (value, warnings) = read(&bytes, &path)?;
    context.warnings.extend(warnings);
    let value = Arc::new(value);
    known.insert(key, Arc::clone(&value));
    Ok(value)
}
