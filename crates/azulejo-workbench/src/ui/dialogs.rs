//! Dialogs: questions, files, text, preferences, shortcuts.

use super::actions::{ACTIONS, Menu};
use super::panel_context::PanelContext;
use super::prism::PrismDialog;
use super::show_all_files::ShowAllFiles;
use crate::app::{App, PendingQuestion};
use crate::command::{Command, FileRequest};
use crate::preferences::{MAX_GATHER, Preferences, Theme};
use crate::view::ColorMap;
use crate::words::Language;
use egui::{DragValue, Grid, Id, Modal, Slider, Ui};
use egui_file::{FileDialog, State};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The state of open dialogs.
#[derive(Default)]
pub struct Dialogs {
    files: Option<(FileRequest, FileDialog)>,
    all_files: ShowAllFiles,
    /// An existing file that would be replaced, with the request it was chosen for.
    replacing: Option<(FileRequest, PathBuf)>,
    /// The folder of the last chosen file.
    folder: Option<PathBuf>,
    /// The dialog for solid text.
    pub text: Option<TextDialog>,
    /// The dialog for a prism.
    pub(super) prism: Option<PrismDialog>,
    /// Whether the preferences are open.
    pub preferences: bool,
    /// Whether the shortcuts are open.
    pub keys: bool,
    /// Whether the information about azulejo is open.
    pub about: bool,
    /// Whether the user has answered the question about recovery.
    asked_recovery: bool,
}

/// The dialog for solid text.
#[derive(Clone, Debug)]
pub struct TextDialog {
    text: String,
    size: f64,
    depth: f64,
    font: Option<PathBuf>,
}

/// A file for a request that the app does not handle itself.
pub enum BrdfFileChoice {
    /// A reflection model to load.
    LoadBrdf(PathBuf),
    /// The file to save a reflection model to.
    SaveBrdf(PathBuf),
}

impl TextDialog {
    /// Starts with a font size that suits the model.
    pub fn new(size: f64) -> TextDialog {
        TextDialog {
            text: String::new(),
            size,
            depth: 0.25,
            font: None,
        }
    }
}

/// Extensions of readable models, for the file dialog; the format is detected from the content.
const MODELS: [&str; 18] = [
    "3ds", "dxf", "obj", "flt", "wrl", "vrml", "x3d", "x3dv", "mgf", "gltf", "glb", "ply", "stl",
    "sff", "scn", "grf", "vs3", "gz",
];

impl Dialogs {
    /// Draws the open dialogs; returns a file for a request that the app does not handle itself.
    pub fn show(&mut self, ui: &mut Ui, cx: &mut PanelContext) -> Option<BrdfFileChoice> {
        self.question(ui, cx);
        self.recovery(ui, cx);
        self.ask_text(ui, cx);
        self.ask_prism(ui, cx);
        self.show_preferences(ui, cx);
        self.show_keys(ui, cx);
        self.show_about(ui, cx);
        self.ask_file(ui, cx)
    }

    /// Whether a dialog or question is open that takes the keyboard.
    pub fn is_open(&self, app: &App) -> bool {
        let asks_recovery = !self.asked_recovery && !app.recoverable().is_empty();
        asks_recovery
            || app.question.is_some()
            || self.files.is_some()
            || self.replacing.is_some()
            || self.text.is_some()
            || self.prism.is_some()
            || self.preferences
            || self.keys
            || self.about
    }

    fn question(&mut self, ui: &mut Ui, cx: &mut PanelContext) {
        let Some(question) = cx.app.question.clone() else {
            return;
        };
        // Hide the question while a save is running or its file is being chosen.
        if cx.app.is_busy(crate::jobs::JobKind::Save) || cx.app.asking.is_some() {
            return;
        }
        let modal = Modal::new(Id::unique("question")).show(ui.ctx(), |ui| {
            ui.set_width(380.0);
            match &question {
                PendingQuestion::Unsaved(_) => {
                    ui.heading(cx.tr("Unsaved changes"));
                    ui.label(cx.tr("If you continue, they will be lost."));
                    ui.horizontal(|ui| {
                        if ui.button(cx.tr("Save")).clicked() {
                            cx.send(Command::Save);
                        }
                        if ui.button(cx.tr("Discard changes")).clicked() {
                            cx.send(Command::Discard);
                        }
                        if ui.button(cx.tr("Cancel")).clicked() {
                            cx.send(Command::CancelPending);
                        }
                    });
                }
                PendingQuestion::ChangedOnDisk(path) => {
                    ui.heading(cx.tr("The file has changed on disk"));
                    ui.label(path.display().to_string());
                    ui.label(cx.tr("Another program has written it since it was opened here."));
                    ui.horizontal(|ui| {
                        if ui.button(cx.tr("Overwrite with mine")).clicked() {
                            cx.send(Command::SaveAnyway);
                        }
                        if ui.button(cx.tr("Reload")).clicked() {
                            cx.send(Command::Discard);
                        }
                        if ui.button(cx.tr("Cancel")).clicked() {
                            cx.send(Command::CancelPending);
                        }
                    });
                }
            }
        });
        if modal.should_close() {
            cx.send(Command::CancelPending);
        }
    }

    fn recovery(&mut self, ui: &mut Ui, cx: &mut PanelContext) {
        let found = cx.app.recoverable();
        if self.asked_recovery || found.is_empty() {
            return;
        }
        let modal = Modal::new(Id::unique("recovery")).show(ui.ctx(), |ui| {
            ui.set_width(460.0);
            ui.heading(cx.tr("azulejo was not closed properly last time"));
            ui.label(cx.tr("Unsaved work was kept:"));
            for one in found {
                ui.horizontal(|ui| {
                    let name = one.original.as_deref().and_then(Path::file_name);
                    let name = name.map(|n| n.to_string_lossy().into_owned());
                    ui.label(name.unwrap_or_else(|| cx.tr("without name").into()));
                    ui.weak(age(one.written, cx));
                    if ui.button(cx.tr("Recover")).clicked() {
                        cx.send(Command::Recover(one.copy.clone()));
                        self.asked_recovery = true;
                    }
                    if ui.button(cx.tr("Delete it")).clicked() {
                        cx.send(Command::DeleteRecovery(one.copy.clone()));
                    }
                });
            }
            if ui.button(cx.tr("Ask me later")).clicked() {
                self.asked_recovery = true;
            }
        });
        self.asked_recovery |= modal.should_close();
    }

    fn ask_text(&mut self, ui: &mut Ui, cx: &mut PanelContext) {
        if self.asks_file() {
            return;
        }
        let Some(dialog) = &mut self.text else {
            return;
        };
        let mut done = false;
        let mut asks_font = false;
        let modal = Modal::new(Id::unique("letters")).show(ui.ctx(), |ui| {
            ui.set_width(380.0);
            ui.heading(cx.tr("Solid text"));
            let label = ui.label(cx.tr("Text"));
            ui.add(
                egui::TextEdit::multiline(&mut dialog.text)
                    .desired_rows(2)
                    .desired_width(f32::INFINITY),
            )
            .labelled_by(label.id);
            Grid::new("letters").num_columns(2).show(ui, |ui| {
                let label = ui.label(cx.tr("Font size (em)"));
                let speed = 0.01 * dialog.size;
                let drag = DragValue::new(&mut dialog.size).range(1e-9..=1e9);
                ui.add(drag.speed(speed)).labelled_by(label.id);
                ui.end_row();
                let label = ui.label(cx.tr("Depth, ems"));
                let drag = DragValue::new(&mut dialog.depth).range(1e-3..=1e3);
                ui.add(drag.speed(0.01)).labelled_by(label.id);
                ui.end_row();
                ui.label(cx.tr("Font"));
                let name = dialog.font.as_deref().and_then(Path::file_name);
                let name = name.map(|n| n.to_string_lossy().into_owned());
                asks_font = ui
                    .button(name.unwrap_or_else(|| "DejaVu Serif".into()))
                    .clicked();
                ui.end_row();
            });
            ui.horizontal(|ui| {
                let ready = !dialog.text.trim().is_empty();
                if ui
                    .add_enabled(ready, egui::Button::new(cx.tr("Add text")))
                    .clicked()
                {
                    cx.send(Command::AddText {
                        text: dialog.text.clone(),
                        size: dialog.size,
                        depth: dialog.depth,
                        font: dialog.font.clone(),
                    });
                    done = true;
                }
                done |= ui.button(cx.tr("Cancel")).clicked();
            });
        });
        if asks_font {
            cx.send(Command::RequestFile(FileRequest::Font));
        } else if done || modal.should_close() {
            self.text = None;
        }
    }

    /// Whether the file dialog is open: the dialog that opened it hides, so as not to cover it.
    fn asks_file(&self) -> bool {
        self.files.is_some() || self.replacing.is_some()
    }

    fn ask_prism(&mut self, ui: &Ui, cx: &mut PanelContext) {
        if self.asks_file() {
            return;
        }
        let is_done = self.prism.as_mut().map(|prism| prism.show(ui, cx));
        if is_done == Some(true) {
            self.prism = None;
        }
    }

    fn show_preferences(&mut self, ui: &mut Ui, cx: &mut PanelContext) {
        if !self.preferences {
            return;
        }
        let old = &cx.app.preferences;
        let mut new = old.clone();
        let mut is_done = false;
        let modal = Modal::new(Id::unique("preferences")).show(ui.ctx(), |ui| {
            ui.set_width(420.0);
            ui.heading(cx.tr("Preferences"));
            Grid::new("preferences")
                .num_columns(2)
                .spacing([16.0, 6.0])
                .show(ui, |ui| preference_rows(ui, cx, &mut new));
            is_done = ui.button(cx.tr("Close")).clicked();
        });
        if new != *old {
            cx.send(Command::SetPreferences(Box::new(new)));
        }
        self.preferences = !(is_done || modal.should_close());
    }

    fn show_keys(&mut self, ui: &mut Ui, cx: &mut PanelContext) {
        if !self.keys {
            return;
        }
        let mut is_done = false;
        let modal = Modal::new(Id::unique("keys")).show(ui.ctx(), |ui| {
            ui.set_width(640.0);
            ui.heading(cx.tr("Keyboard and mouse"));
            egui::ScrollArea::vertical()
                .max_height(460.0)
                .show(ui, |ui| {
                    mouse_help(ui, cx);
                    key_help(ui, cx);
                });
            is_done = ui.button(cx.tr("Close")).clicked();
        });
        self.keys = !(is_done || modal.should_close());
    }

    fn show_about(&mut self, ui: &mut Ui, cx: &mut PanelContext) {
        if !self.about {
            return;
        }
        let mut is_done = false;
        let modal = Modal::new(Id::unique("about")).show(ui.ctx(), |ui| {
            ui.set_width(380.0);
            ui.heading(format!("azulejo {}", env!("CARGO_PKG_VERSION")));
            ui.label(cx.tr("Global illumination for the models people already have."));
            is_done = ui.button(cx.tr("Close")).clicked();
        });
        self.about = !(is_done || modal.should_close());
    }

    fn ask_file(&mut self, ui: &mut Ui, cx: &mut PanelContext) -> Option<BrdfFileChoice> {
        if let Some(what) = cx.app.asking
            && self.replacing.is_none()
            && self.files.as_ref().is_none_or(|(open, _)| *open != what)
        {
            self.files = Some((what, self.open(what, cx)));
        }
        if let Some(chosen) = self.ask_replace(ui, cx) {
            return Some(chosen);
        }
        let (what, dialog) = self.files.as_mut()?;
        let what = *what;
        dialog.show(ui.ctx());
        self.all_files
            .show(ui.ctx(), cx, Id::unique("files"), dialog);
        let paths: Vec<PathBuf> = match dialog.state() {
            State::Open => return None,
            State::Selected => match dialog.selection() {
                // A typed name is not one of the list.
                none if none.is_empty() => dialog.path().into_iter().map(Path::to_owned).collect(),
                several => several.into_iter().map(Path::to_owned).collect(),
            },
            State::Closed | State::Cancelled => Vec::new(),
        };
        if let [folder] = &paths[..]
            && folder.is_dir()
        {
            dialog.set_path(folder);
            dialog.open();
            return None;
        }
        self.folder = Some(dialog.directory().to_owned());
        self.files = None;
        let Some(mut first) = paths.first().cloned() else {
            cx.send(Command::CancelPending);
            return None;
        };
        if let (None, Some(extension)) = (first.extension(), default_extension(what)) {
            first.set_extension(extension);
        }
        // Overwriting the document's own file needs no question, unless it has changed on disk.
        let own = cx
            .app
            .file
            .as_ref()
            .filter(|f| what == FileRequest::SaveAs && f.path == first);
        let is_meant = own.is_some_and(|f| !f.has_changed());
        if saves(what) && first.exists() && !is_meant {
            self.replacing = Some((what, first));
            return None;
        }
        self.chosen(what, first, paths, cx)
    }

    /// Asks before a file is replaced.
    fn ask_replace(&mut self, ui: &mut Ui, cx: &mut PanelContext) -> Option<BrdfFileChoice> {
        let (what, path) = self.replacing.clone()?;
        let mut answer = None;
        let modal = Modal::new(Id::unique("replace")).show(ui.ctx(), |ui| {
            ui.set_width(380.0);
            ui.heading(cx.tr("A file with this name already exists"));
            ui.label(path.display().to_string());
            ui.horizontal(|ui| {
                if ui.button(cx.tr("Replace")).clicked() {
                    answer = Some(true);
                }
                if ui.button(cx.tr("Cancel")).clicked() {
                    answer = Some(false);
                }
            });
        });
        if modal.should_close() {
            answer = Some(false);
        }
        let replaces = answer?;
        self.replacing = None;
        if replaces {
            self.chosen(what, path.clone(), vec![path], cx)
        } else {
            cx.send(Command::CancelPending);
            None
        }
    }

    fn chosen(
        &mut self,
        what: FileRequest,
        first: PathBuf,
        all: Vec<PathBuf>,
        cx: &mut PanelContext,
    ) -> Option<BrdfFileChoice> {
        cx.send(Command::DialogClosed);
        cx.send(match what {
            FileRequest::Open => Command::Open(all),
            FileRequest::Add => Command::Add(all),
            FileRequest::SaveAs => Command::SaveAs(first),
            FileRequest::Export => Command::Export(first),
            FileRequest::SaveRender => Command::SaveRender(first),
            FileRequest::Backdrop => Command::LoadBackdrop(first),
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

    /// Creates the file dialog.
    fn open(&self, what: FileRequest, cx: &PanelContext) -> FileDialog {
        let file = cx.app.file.as_ref().map(|f| f.path.as_path());
        let source_file = cx
            .app
            .document
            .source_files
            .first()
            .map(|b| b.path.as_path());
        let known = file.or(source_file);
        let folder = self.folder.clone();
        let folder = folder.or_else(|| known.and_then(Path::parent).map(Path::to_owned));
        let folder = folder.filter(|f| f.is_dir());
        let folder = folder.or_else(|| std::env::current_dir().ok());
        let stem = known.and_then(Path::file_stem).unwrap_or_default();
        let stem = if stem.is_empty() {
            "azulejo".to_owned()
        } else {
            stem.to_string_lossy().into_owned()
        };
        let dialog = match what {
            FileRequest::Open | FileRequest::Add => FileDialog::open_file().multi_select(true),
            FileRequest::Backdrop
            | FileRequest::Font
            | FileRequest::Outline
            | FileRequest::LoadBrdf => FileDialog::open_file(),
            FileRequest::SaveAs => FileDialog::save_file().default_filename(format!("{stem}.grf")),
            FileRequest::Export => FileDialog::save_file().default_filename(format!("{stem}.glb")),
            FileRequest::SaveRender => {
                FileDialog::save_file().default_filename(format!("{stem}.png"))
            }
            FileRequest::SaveBrdf => FileDialog::save_file().default_filename("material.brdf"),
        };
        let mut dialog = dialog
            .id(Id::unique("files"))
            .initial_path(folder.unwrap_or_default())
            .title(title(what, cx))
            .default_size([640.0, 420.0])
            .anchor(egui::Align2::CENTER_CENTER, egui::Vec2::ZERO)
            .show_rename(false)
            .keep_on_top(true)
            .show_files_filter(self.all_files.filter(move |path| is_offered(what, path)))
            .open_button_text(cx.tr("Open").into())
            .save_button_text(cx.tr("Save").into())
            .cancel_button_text(cx.tr("Cancel").into())
            .new_folder_button_text(cx.tr("New folder").into())
            .new_folder_name_text(cx.tr("New folder").into())
            .refresh_button_hover_text(cx.tr("Refresh").into())
            .parent_folder_button_hover_text(cx.tr("Parent folder").into())
            .file_label_text(cx.tr("File:").into())
            .show_hidden_checkbox_text(cx.tr("Show hidden files").into());
        dialog.open();
        dialog
    }
}

/// The extension added to a name without one.
fn default_extension(what: FileRequest) -> Option<&'static str> {
    match what {
        FileRequest::SaveAs => Some("grf"),
        FileRequest::SaveRender => Some("png"),
        FileRequest::SaveBrdf => Some("brdf"),
        _ => None,
    }
}

fn saves(what: FileRequest) -> bool {
    matches!(
        what,
        FileRequest::SaveAs | FileRequest::Export | FileRequest::SaveRender | FileRequest::SaveBrdf
    )
}

/// Whether the file dialog lists a file.
fn is_offered(what: FileRequest, path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    let extension = extension.to_ascii_lowercase();
    match what {
        FileRequest::Open | FileRequest::Add | FileRequest::SaveAs | FileRequest::Export => {
            MODELS.contains(&extension.as_str())
        }
        FileRequest::Backdrop => ["png", "jpg", "jpeg", "hdr"].contains(&extension.as_str()),
        FileRequest::SaveRender => ["png", "exr", "hdr"].contains(&extension.as_str()),
        FileRequest::Outline => ["svg", "dxf"].contains(&extension.as_str()),
        FileRequest::Font | FileRequest::LoadBrdf | FileRequest::SaveBrdf => true,
    }
}

fn title(what: FileRequest, cx: &PanelContext) -> &'static str {
    match what {
        FileRequest::Open => cx.tr("Open models"),
        FileRequest::Add => cx.tr("Add models"),
        FileRequest::SaveAs => cx.tr("Save as GRF"),
        FileRequest::Export => cx.tr("Export a copy"),
        FileRequest::SaveRender => cx.tr("Save the image"),
        FileRequest::Backdrop => cx.tr("Choose a background image"),
        FileRequest::Font => cx.tr("Choose a font"),
        FileRequest::Outline => cx.tr("Choose a drawing to extrude"),
        FileRequest::LoadBrdf => cx.tr("Load a reflection model"),
        FileRequest::SaveBrdf => cx.tr("Save the reflection model"),
    }
}

/// How long ago a recovery copy was written.
fn age(written: u64, cx: &PanelContext) -> String {
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    let seconds = now.map_or(0, |d| d.as_secs().saturating_sub(written));
    match seconds {
        0..3_600 => format!("{} min", seconds / 60),
        3_600..86_400 => format!("{} h", seconds / 3_600),
        _ => format!("{} {}", seconds / 86_400, cx.tr("days")),
    }
}

fn preference_rows(ui: &mut Ui, cx: &PanelContext, new: &mut Preferences) {
    let tr = |text| cx.tr(text);
    let label = ui.label(tr("Language"));
    egui::ComboBox::new("language", "")
        .selected_text(new.language.name())
        .show_ui(ui, |ui| {
            for language in Language::ALL {
                ui.selectable_value(&mut new.language, language, language.name());
            }
        })
        .response
        .labelled_by(label.id);
    ui.end_row();
    ui.label(tr("Theme"));
    ui.horizontal(|ui| {
        ui.selectable_value(&mut new.theme, Theme::System, tr("like the system"));
        ui.selectable_value(&mut new.theme, Theme::Light, tr("bright"));
        ui.selectable_value(&mut new.theme, Theme::Dark, tr("dark"));
    });
    ui.end_row();
    let label = ui.label(tr("Text size"));
    let slider = Slider::new(&mut new.scale, 0.5..=3.0).step_by(0.1);
    ui.add(slider.update_while_editing(false))
        .labelled_by(label.id);
    ui.end_row();
    let label = ui.label(tr("Colour map"));
    egui::ComboBox::new("map", "")
        .selected_text(map_name(new.color_map, cx))
        .show_ui(ui, |ui| {
            for map in ColorMap::ALL {
                ui.selectable_value(&mut new.color_map, map, map_name(map, cx));
            }
        })
        .response
        .labelled_by(label.id);
    ui.end_row();
    let label = ui.label(tr("Recovery copy after"));
    let drag = DragValue::new(&mut new.autosave)
        .range(0..=3_600)
        .suffix(" s");
    ui.add(drag)
        .on_hover_text(tr("0 s: never"))
        .labelled_by(label.id);
    ui.end_row();
    let label = ui.label(tr("Threads"));
    let drag = DragValue::new(&mut new.threads).range(0..=256);
    ui.add(drag)
        .on_hover_text(tr("0: all but one, which is left to the window"))
        .labelled_by(label.id);
    ui.end_row();
    let label = ui.label(tr("Paths per pixel of a render"));
    let drag = DragValue::new(&mut new.picture_samples).range(1..=65_536);
    ui.add(drag).labelled_by(label.id);
    ui.end_row();
    let label = ui.label(tr("Final gather rays"));
    let drag = DragValue::new(&mut new.picture_gather).range(0..=MAX_GATHER);
    let about = tr("Sharpens shadows and hides patches, slowly; 0 for none.");
    ui.add(drag).labelled_by(label.id).on_hover_text(about);
    ui.end_row();
}

/// The name of a colour map.
pub fn map_name(map: ColorMap, cx: &PanelContext) -> &'static str {
    match map {
        ColorMap::Viridis => "viridis",
        ColorMap::Cividis => "cividis",
        ColorMap::Magma => "magma",
        ColorMap::Grey => cx.tr("grey"),
    }
}

fn mouse_help(ui: &mut Ui, cx: &PanelContext) {
    let rows = [
        (cx.tr("Drag"), cx.tr("orbit around the middle of the view")),
        (
            cx.tr("Right or middle drag, or Shift and drag"),
            cx.tr("pan the view"),
        ),
        (cx.tr("Wheel, or Ctrl and drag"), cx.tr("zoom")),
        (
            cx.tr("Click"),
            cx.tr("select an object; with Ctrl, one more; with Alt, a face"),
        ),
        (cx.tr("Double click"), cx.tr("frame the object")),
        (
            cx.tr("W A S D, R F"),
            cx.tr("fly forward, left, back, right, up, down"),
        ),
        (cx.tr("Drag while flying"), cx.tr("look around")),
        (cx.tr("Arrows"), cx.tr("turn the camera")),
        (cx.tr("Shift + arrows"), cx.tr("orbit around the model")),
        (cx.tr("Ctrl + arrows"), cx.tr("pan the view")),
        ("+ −", cx.tr("zoom")),
        (
            cx.tr("Enter, with the viewport in focus"),
            cx.tr("a click in the middle of it; with Alt, on a face"),
        ),
        (
            cx.tr("Drag an arrow of the selection"),
            cx.tr("move it along the axis"),
        ),
    ];
    Grid::new("mouse")
        .num_columns(2)
        .striped(true)
        .show(ui, |ui| {
            for (what, does) in rows {
                ui.strong(what);
                ui.label(does);
                ui.end_row();
            }
        });
}

/// Two columns of menus with their shortcuts.
fn key_help(ui: &mut Ui, cx: &PanelContext) {
    let half = Menu::ALL.len() / 2;
    ui.columns(2, |columns| {
        for (column, menus) in columns
            .iter_mut()
            .zip([&Menu::ALL[..half], &Menu::ALL[half..]])
        {
            key_column(column, cx, menus);
        }
    });
}

fn key_column(ui: &mut Ui, cx: &PanelContext, menus: &[Menu]) {
    for &menu in menus {
        let keyed: Vec<_> = (ACTIONS.iter())
            .filter(|a| a.menu == menu && a.key.is_some())
            .collect();
        if keyed.is_empty() {
            continue;
        }
        ui.add_space(8.0);
        ui.strong(menu.label(cx.language));
        Grid::new(("keys", menu.label(cx.language)))
            .num_columns(2)
            .striped(true)
            .show(ui, |ui| {
                for action in keyed {
                    let key = action.key.map(|k| ui.ctx().format_shortcut(&k));
                    ui.monospace(key.unwrap_or_default());
                    ui.label(cx.tr(action.label));
                    ui.end_row();
                }
            });
    }
}

/// An image as displayed by egui.
pub fn pixels(image: &azulejo::scene::Image, exposure: Option<f64>) -> Arc<egui::ColorImage> {
    let bytes = crate::app::shown(image, exposure);
    let size = [image.width as usize, image.height as usize];
    Arc::new(egui::ColorImage::from_rgb(size, &bytes))
}
