//! Scenes to begin with, which need no file.

use super::{Edit, EditError, NewShape, NewShapeKind, SceneDocument, TextLayout};
use azulejo::scene::synthetic::{CornellVariant, cornell_box};
use azulejo::scene::{Material, Rgb};
use clap::ValueEnum;
use glam::DVec3;

/// A scene to begin with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Example {
    /// The box of Cornell University: walls that colour each other.
    CornellBox,
    /// The same box, with a block that is a mirror.
    MirrorBlock,
    /// Solid letters in a studio.
    SolidText,
}

impl Example {
    /// A new document with the example.
    ///
    /// # Errors
    ///
    /// [`EditError`], which a test excludes.
    pub fn document(self) -> Result<SceneDocument, EditError> {
        let variant = match self {
            Example::CornellBox => CornellVariant::Diffuse,
            Example::MirrorBlock => CornellVariant::MirrorBlock,
            Example::SolidText => return solid_text(),
        };
        Ok(SceneDocument::of_scene(cornell_box(variant), None))
    }
}

/// The word "azulejo" in a blue glaze, on the floor of a studio.
fn solid_text() -> Result<SceneDocument, EditError> {
    let mut document = SceneDocument::default();
    let mut glaze = Material::diffuse("glaze", Rgb::new(0.05, 0.16, 0.5));
    glaze.mirror = Rgb::grey(0.06);
    Edit::AddMaterial(glaze).apply(&mut document)?;
    let text = NewShape {
        kind: NewShapeKind::Text(TextLayout::set("azulejo", 0.3, None)?),
        at: DVec3::ZERO,
        size: 1.0,
        material: Some(0),
    };
    Edit::AddShape(text).apply(&mut document)?;
    Edit::AddStudio.apply(&mut document)?;
    Ok(document)
}
