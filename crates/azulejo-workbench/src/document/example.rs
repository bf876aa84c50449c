//! Scenes to begin with, which need no file.

use super::App;
use crate::document::{Edit, EditError, NewShape, NewShapeKind, SceneDocument, TextLayout};
use azulejo::scene::synthetic::{CornellVariant, cornell_box};
use azulejo::scene::{Material, Rgb};
use glam::DVec3;

/// A scene to begin with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Example {
    /// The box of Cornell University: walls that colour each other.
    CornellBox,
    /// The same box, with a block that is a mirror.
    MirrorBlock,
    /// Solid letters in a studio.
    SolidText,
}

impl Example {
    /// All examples, in the order of the start screen.
    pub const ALL: [Example; 3] = [
        Example::CornellBox,
        Example::MirrorBlock,
        Example::SolidText,
    ];

    /// Its name in scripts.
    pub fn script_name(self) -> &'static str {
        match self {
            Example::CornellBox => "cornell-box",
            Example::MirrorBlock => "mirror-block",
            Example::SolidText => "solid-text",
        }
    }

    fn document(self) -> Result<SceneDocument, EditError> {
        let of = |variant| Ok(SceneDocument::of_scene(cornell_box(variant), None));
        match self {
            Example::CornellBox => of(CornellVariant::Diffuse),
            Example::MirrorBlock => of(CornellVariant::MirrorBlock),
            Example::SolidText => solid_text(),
        }
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

impl App {
    /// Opens an example as a new document without a file.
    pub(super) fn open_example(&mut self, example: Example) {
        self.clear();
        match example.document() {
            Ok(document) => self.replace(document, None),
            Err(refused) => self.report(super::Severity::Error, refused.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::Command;

    #[test]
    fn every_example_is_a_valid_scene_with_light_and_a_view() {
        for example in Example::ALL {
            let mut app = App::quiet();
            app.execute(Command::OpenExample(example));
            assert_eq!(app.errors, 0, "{:?}", app.messages);
            app.document.scene().validate().unwrap();
            assert!(app.document.has_light() && !app.document.cameras.is_empty());
            assert!(!app.is_changed(), "an example is nothing to save");
        }
    }
}
