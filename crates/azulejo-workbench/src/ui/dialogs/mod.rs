//! Dialogs, one per file: questions, files, text, prisms, lightmaps, preferences, shortcuts.

mod about;
mod bake;
mod files;
mod preferences;
mod prism;
mod question;
mod recovery;
mod shortcuts;
mod text;

use super::panel_context::PanelContext;
use crate::app::App;
use crate::command::{Command, FileRequest};
use egui::Ui;
use files::{ChosenFiles, FileChooser};
use std::path::PathBuf;

pub(super) use bake::BakeDialog;
pub use files::NativeSupport;
pub use preferences::map_name;
pub(super) use prism::PrismDialog;
pub use text::TextDialog;

/// The state of open dialogs.
#[derive(Default)]
pub struct Dialogs {
    files: FileChooser,
    /// The dialog for solid text.
    pub text: Option<TextDialog>,
    /// The dialog for a prism.
    pub(super) prism: Option<PrismDialog>,
    /// The dialog for a lightmap.
    pub(super) bake: Option<BakeDialog>,
    /// Whether the preferences are open.
    pub preferences: bool,
    /// Whether the shortcuts are open.
    pub keys: bool,
    /// Whether the information about azulejo is open.
    pub about: bool,
    /// Whether the user has answered the question about recovery.
    asked_recovery: bool,
}

/// A file for a request that the app does not handle itself.
pub enum BrdfFileChoice {
    /// A reflection model to load.
    LoadBrdf(PathBuf),
    /// The file to save a reflection model to.
    SaveBrdf(PathBuf),
}

impl Dialogs {
    /// Draws the open dialogs; returns a file for a request that the app does not handle itself.
    pub fn show(&mut self, ui: &mut Ui, cx: &mut PanelContext) -> Option<BrdfFileChoice> {
        question::show(ui, cx);
        recovery::show(ui, cx, &mut self.asked_recovery);
        self.show_shapes(ui, cx);
        preferences::show(ui, cx, &mut self.preferences);
        shortcuts::show(ui, cx, &mut self.keys);
        about::show(ui, cx, &mut self.about);
        let chosen = self.files.show(ui, cx)?;
        self.use_files(chosen, cx)
    }

    /// Sets whether the desktop's file dialog may be used.
    pub fn set_native_files(&mut self, native: NativeSupport) {
        self.files.set_native(native);
    }

    /// Opens the desktop's file dialog in front of a window, if it was requested in this frame.
    pub fn open_native_files(&mut self, frame: &eframe::Frame, context: &egui::Context) {
        self.files.open_native(frame, context);
    }

    /// Whether a dialog or question is open that takes the keyboard.
    pub fn is_open(&self, app: &App) -> bool {
        let asks_recovery = !self.asked_recovery && !app.recoverable().is_empty();
        asks_recovery
            || app.question.is_some()
            || self.files.is_open()
            || self.text.is_some()
            || self.prism.is_some()
            || self.bake.is_some()
            || self.preferences
            || self.keys
            || self.about
    }

    /// Draws the dialogs for text, prisms and lightmaps. They hide while they wait for a file, so as not to
    /// cover the file dialog.
    fn show_shapes(&mut self, ui: &Ui, cx: &mut PanelContext) {
        if self.files.is_open() {
            return;
        }
        if self.text.as_mut().is_some_and(|text| text.show(ui, cx)) {
            self.text = None;
        }
        if self.prism.as_mut().is_some_and(|prism| prism.show(ui, cx)) {
            self.prism = None;
        }
        if self.bake.as_mut().is_some_and(|bake| bake.show(ui, cx)) {
            self.bake = None;
        }
    }

    /// Executes the request that files were chosen for.
    fn use_files(&mut self, chosen: ChosenFiles, cx: &mut PanelContext) -> Option<BrdfFileChoice> {
        let ChosenFiles {
            request,
            first,
            all,
        } = chosen;
        cx.send(Command::DialogClosed);
        cx.send(match request {
            FileRequest::Open => Command::Open(all),
            FileRequest::Add => Command::Add(all),
            FileRequest::SaveAs => Command::SaveAs(first),
            FileRequest::Export => Command::Export(first),
            FileRequest::SaveRender => Command::SaveRender(first),
            FileRequest::SaveLightmap(what) => Command::SaveLightmap(what, first),
            FileRequest::SaveProbes => Command::SaveProbes(first),
            FileRequest::SaveTaskPlane => Command::SaveTaskPlane(first),
            FileRequest::Backplate => Command::LoadBackplate(first),
            FileRequest::Recipe => Command::ApplyRecipe(first),
            FileRequest::Environment(into) => Command::LoadEnvironment(first, into),
            FileRequest::Font => {
                if let Some(text) = &mut self.text {
                    text.font = Some(first);
                }
                return None;
            }
            FileRequest::Outline => {
                if let Some(prism) = &mut self.prism {
                    prism.drawing = Some(first);
                }
                return None;
            }
            FileRequest::LoadBrdf => return Some(BrdfFileChoice::LoadBrdf(first)),
            FileRequest::SaveBrdf => return Some(BrdfFileChoice::SaveBrdf(first)),
        });
        None
    }
}
