//! Windows over the window: questions, files, letters, preferences, keys.

use super::actions::{ACTIONS, Menu};
use super::all_files::ShowAllFiles;
use super::desk::PanelContext;
use super::prism::PrismDialog;
use crate::app::{App, PendingQuestion};
use crate::command::{Command, FileRequest};
use crate::preferences::{MOST_GATHER, Preferences, Theme};
use crate::view::ColorMap;
use crate::words::Language;
use egui::{DragValue, Grid, Id, Modal, Slider, Ui};
use egui_file::{FileDialog, State};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What dialogs remember while they are open.
#[derive(Default)]
pub struct Dialogs {
    files: Option<(FileRequest, FileDialog)>,
    all_files: ShowAllFiles,
    /// A place to save at where there is a file already.
    replacing: Option<(FileRequest, PathBuf)>,
    /// The last folder that something was chosen in.
    folder: Option<PathBuf>,
    /// The letters that are being asked for.
    pub text: Option<TextDialog>,
    /// The prism that is being asked for.
    pub(super) prism: Option<PrismDialog>,
    /// Whether the preferences are open.
    pub preferences: bool,
    /// Whether the keys are shown.
    pub keys: bool,
    /// Whether azulejo says what it is.
    pub about: bool,
    /// Whether what a crash left was answered.
    asked_recovery: bool,
}

/// The letters that are being asked for.
#[derive(Clone, Debug)]
pub struct TextDialog {
    text: String,
    size: f64,
    depth: f64,
    font: Option<PathBuf>,
}

/// What was chosen for whom the app does not serve itself.
pub enum BrdfFileChoice {
    /// A reflection model to read.
    LoadBrdf(PathBuf),
    /// Where a reflection model goes.
    SaveBrdf(PathBuf),
}

impl TextDialog {
    /// Letters that suit the model.
    pub fn new(size: f64) -> TextDialog {
        TextDialog {
            text: String::new(),
            size,
            depth: 0.25,
            font: None,
        }
    }
}

/// Extensions of models that are read, for the dialog; content decides in the end.
const MODELS: [&str; 18] = [
    "3ds", "dxf", "obj", "flt", "wrl", "vrml", "x3d", "x3dv", "mgf", "gltf", "glb", "ply", "stl",
    "sff", "scn", "grf", "vs3", "gz",
];

impl Dialogs {
    /// Draws what is open; returns a file that was chosen for somebody else.
    pub fn show(&mut self, ui: &mut Ui, desk: &mut PanelContext) -> Option<BrdfFileChoice> {
        self.question(ui, desk);
        self.recovery(ui, desk);
        self.ask_text(ui, desk);
        self.ask_prism(ui, desk);
        self.show_preferences(ui, desk);
        self.show_keys(ui, desk);
        self.show_about(ui, desk);
        self.ask_file(ui, desk)
    }

    /// Whether something is open that keys belong to, a question included.
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

    fn question(&mut self, ui: &mut Ui, desk: &mut PanelContext) {
        let Some(question) = desk.app.question.clone() else {
            return;
        };
        // While a save goes on or its place is chosen the question waits.
        if desk.app.is_busy(crate::jobs::JobKind::Save) || desk.app.asking.is_some() {
            return;
        }
        let modal = Modal::new(Id::unique("question")).show(ui.ctx(), |ui| {
            ui.set_width(380.0);
            match &question {
                PendingQuestion::Unsaved(_) => {
                    ui.heading(desk.say("Changes are not saved"));
                    ui.label(desk.say("What you do next would lose them."));
                    ui.horizontal(|ui| {
                        if ui.button(desk.say("Save")).clicked() {
                            desk.wish(Command::Save);
                        }
                        if ui.button(desk.say("Lose the changes")).clicked() {
                            desk.wish(Command::Discard);
                        }
                        if ui.button(desk.say("Cancel")).clicked() {
                            desk.wish(Command::CancelPending);
                        }
                    });
                }
                PendingQuestion::ChangedOnDisk(path) => {
                    ui.heading(desk.say("The file has changed on the disk"));
                    ui.label(path.display().to_string());
                    ui.label(desk.say("Somebody wrote it since it was opened here."));
                    ui.horizontal(|ui| {
                        if ui.button(desk.say("Keep mine and write over it")).clicked() {
                            desk.wish(Command::SaveAnyway);
                        }
                        if ui.button(desk.say("Read it again")).clicked() {
                            desk.wish(Command::Discard);
                        }
                        if ui.button(desk.say("Cancel")).clicked() {
                            desk.wish(Command::CancelPending);
                        }
                    });
                }
            }
        });
        if modal.should_close() {
            desk.wish(Command::CancelPending);
        }
    }

    fn recovery(&mut self, ui: &mut Ui, desk: &mut PanelContext) {
        let found = desk.app.recoverable();
        if self.asked_recovery || found.is_empty() {
            return;
        }
        let modal = Modal::new(Id::unique("recovery")).show(ui.ctx(), |ui| {
            ui.set_width(460.0);
            ui.heading(desk.say("azulejo did not end well last time"));
            ui.label(desk.say("What was being worked on was kept:"));
            for one in found {
                ui.horizontal(|ui| {
                    let name = one.original.as_deref().and_then(Path::file_name);
                    let name = name.map(|n| n.to_string_lossy().into_owned());
                    ui.label(name.unwrap_or_else(|| desk.say("without name").into()));
                    ui.weak(age(one.written, desk));
                    if ui.button(desk.say("Recover")).clicked() {
                        desk.wish(Command::Recover(one.copy.clone()));
                        self.asked_recovery = true;
                    }
                    if ui.button(desk.say("Delete it")).clicked() {
                        desk.wish(Command::DeleteRecovery(one.copy.clone()));
                    }
                });
            }
            if ui.button(desk.say("Ask me later")).clicked() {
                self.asked_recovery = true;
            }
        });
        self.asked_recovery |= modal.should_close();
    }

    fn ask_text(&mut self, ui: &mut Ui, desk: &mut PanelContext) {
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
            ui.heading(desk.say("Solid letters"));
            let label = ui.label(desk.say("Text"));
            ui.add(
                egui::TextEdit::multiline(&mut dialog.text)
                    .desired_rows(2)
                    .desired_width(f32::INFINITY),
            )
            .labelled_by(label.id);
            Grid::new("letters").num_columns(2).show(ui, |ui| {
                let label = ui.label(desk.say("Size of an em"));
                let speed = 0.01 * dialog.size;
                let drag = DragValue::new(&mut dialog.size).range(1e-9..=1e9);
                ui.add(drag.speed(speed)).labelled_by(label.id);
                ui.end_row();
                let label = ui.label(desk.say("Depth, ems"));
                let drag = DragValue::new(&mut dialog.depth).range(1e-3..=1e3);
                ui.add(drag.speed(0.01)).labelled_by(label.id);
                ui.end_row();
                ui.label(desk.say("Typeface"));
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
                    .add_enabled(ready, egui::Button::new(desk.say("Add the letters")))
                    .clicked()
                {
                    desk.wish(Command::AddText {
                        text: dialog.text.clone(),
                        size: dialog.size,
                        depth: dialog.depth,
                        font: dialog.font.clone(),
                    });
                    done = true;
                }
                done |= ui.button(desk.say("Cancel")).clicked();
            });
        });
        if asks_font {
            desk.wish(Command::RequestFile(FileRequest::Font));
        } else if done || modal.should_close() {
            self.text = None;
        }
    }

    /// Whether a file is being asked for: what asks for it waits, and would lie over it else.
    fn asks_file(&self) -> bool {
        self.files.is_some() || self.replacing.is_some()
    }

    fn ask_prism(&mut self, ui: &Ui, desk: &mut PanelContext) {
        if self.asks_file() {
            return;
        }
        let is_done = self.prism.as_mut().map(|prism| prism.show(ui, desk));
        if is_done == Some(true) {
            self.prism = None;
        }
    }

    fn show_preferences(&mut self, ui: &mut Ui, desk: &mut PanelContext) {
        if !self.preferences {
            return;
        }
        let old = &desk.app.preferences;
        let mut new = old.clone();
        let mut is_done = false;
        let modal = Modal::new(Id::unique("preferences")).show(ui.ctx(), |ui| {
            ui.set_width(420.0);
            ui.heading(desk.say("Preferences"));
            Grid::new("preferences")
                .num_columns(2)
                .spacing([16.0, 6.0])
                .show(ui, |ui| preference_rows(ui, desk, &mut new));
            is_done = ui.button(desk.say("Close")).clicked();
        });
        if new != *old {
            desk.wish(Command::SetPreferences(Box::new(new)));
        }
        self.preferences = !(is_done || modal.should_close());
    }

    fn show_keys(&mut self, ui: &mut Ui, desk: &mut PanelContext) {
        if !self.keys {
            return;
        }
        let mut is_done = false;
        let modal = Modal::new(Id::unique("keys")).show(ui.ctx(), |ui| {
            ui.set_width(640.0);
            ui.heading(desk.say("Keys and mouse"));
            egui::ScrollArea::vertical()
                .max_height(460.0)
                .show(ui, |ui| {
                    mouse_help(ui, desk);
                    key_help(ui, desk);
                });
            is_done = ui.button(desk.say("Close")).clicked();
        });
        self.keys = !(is_done || modal.should_close());
    }

    fn show_about(&mut self, ui: &mut Ui, desk: &mut PanelContext) {
        if !self.about {
            return;
        }
        let mut is_done = false;
        let modal = Modal::new(Id::unique("about")).show(ui.ctx(), |ui| {
            ui.set_width(380.0);
            ui.heading(format!("azulejo {}", env!("CARGO_PKG_VERSION")));
            ui.label(desk.say("Global illumination for the models people already have."));
            is_done = ui.button(desk.say("Close")).clicked();
        });
        self.about = !(is_done || modal.should_close());
    }

    fn ask_file(&mut self, ui: &mut Ui, desk: &mut PanelContext) -> Option<BrdfFileChoice> {
        if let Some(what) = desk.app.asking
            && self.replacing.is_none()
            && self.files.as_ref().is_none_or(|(open, _)| *open != what)
        {
            self.files = Some((what, self.open(what, desk)));
        }
        if let Some(chosen) = self.ask_replace(ui, desk) {
            return Some(chosen);
        }
        let (what, dialog) = self.files.as_mut()?;
        let what = *what;
        dialog.show(ui.ctx());
        self.all_files
            .show(ui.ctx(), desk, Id::unique("files"), dialog);
        let paths: Vec<PathBuf> = match dialog.state() {
            State::Open => return None,
            State::Selected => match dialog.selection() {
                // A name that was typed is not one of the list.
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
            desk.wish(Command::CancelPending);
            return None;
        };
        if let (None, Some(extension)) = (first.extension(), usual_extension(what)) {
            first.set_extension(extension);
        }
        // The document's own file is what one means to write over, if it is still as it was.
        let own = desk
            .app
            .file
            .as_ref()
            .filter(|f| what == FileRequest::SaveAs && f.path == first);
        let is_meant = own.is_some_and(|f| !f.has_changed());
        if saves(what) && first.exists() && !is_meant {
            self.replacing = Some((what, first));
            return None;
        }
        self.chosen(what, first, paths, desk)
    }

    /// Asks before a file is written over.
    fn ask_replace(&mut self, ui: &mut Ui, desk: &mut PanelContext) -> Option<BrdfFileChoice> {
        let (what, path) = self.replacing.clone()?;
        let mut answer = None;
        let modal = Modal::new(Id::unique("replace")).show(ui.ctx(), |ui| {
            ui.set_width(380.0);
            ui.heading(desk.say("There is a file of this name"));
            ui.label(path.display().to_string());
            ui.horizontal(|ui| {
                if ui.button(desk.say("Replace it")).clicked() {
                    answer = Some(true);
                }
                if ui.button(desk.say("Cancel")).clicked() {
                    answer = Some(false);
                }
            });
        });
        if modal.should_close() {
            answer = Some(false);
        }
        let replaces = answer?;
        self.replacing = None;
        match replaces {
            true => self.chosen(what, path.clone(), vec![path], desk),
            false => {
                desk.wish(Command::CancelPending);
                None
            }
        }
    }

    fn chosen(
        &mut self,
        what: FileRequest,
        first: PathBuf,
        all: Vec<PathBuf>,
        desk: &mut PanelContext,
    ) -> Option<BrdfFileChoice> {
        desk.wish(Command::DialogClosed);
        desk.wish(match what {
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

    /// The dialog for a file.
    fn open(&self, what: FileRequest, desk: &PanelContext) -> FileDialog {
        let file = desk.app.file.as_ref().map(|f| f.path.as_path());
        let branch = desk.app.document.branches.first().map(|b| b.path.as_path());
        let known = file.or(branch);
        let folder = self.folder.clone();
        let folder = folder.or_else(|| known.and_then(Path::parent).map(Path::to_owned));
        let folder = folder.filter(|f| f.is_dir());
        let folder = folder.or_else(|| std::env::current_dir().ok());
        let stem = known.and_then(Path::file_stem).unwrap_or_default();
        let stem = match stem.is_empty() {
            true => "azulejo".to_owned(),
            false => stem.to_string_lossy().into_owned(),
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
            .title(title(what, desk))
            .default_size([640.0, 420.0])
            .anchor(egui::Align2::CENTER_CENTER, egui::Vec2::ZERO)
            .show_rename(false)
            .keep_on_top(true)
            .show_files_filter(self.all_files.filter(move |path| is_offered(what, path)))
            .open_button_text(desk.say("Open").into())
            .save_button_text(desk.say("Save").into())
            .cancel_button_text(desk.say("Cancel").into())
            .new_folder_button_text(desk.say("New folder").into())
            .new_folder_name_text(desk.say("New folder").into())
            .refresh_button_hover_text(desk.say("Look again").into())
            .parent_folder_button_hover_text(desk.say("Folder above").into())
            .file_label_text(desk.say("File:").into())
            .show_hidden_checkbox_text(desk.say("Hidden ones too").into());
        dialog.open();
        dialog
    }
}

/// What is put behind a name that says no kind of file.
fn usual_extension(what: FileRequest) -> Option<&'static str> {
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

/// Whether a file is worth a line in the dialog.
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

fn title(what: FileRequest, desk: &PanelContext) -> &'static str {
    match what {
        FileRequest::Open => desk.say("Open models"),
        FileRequest::Add => desk.say("Add models"),
        FileRequest::SaveAs => desk.say("Save as GRF"),
        FileRequest::Export => desk.say("Export a copy"),
        FileRequest::SaveRender => desk.say("Save the picture"),
        FileRequest::Backdrop => desk.say("A picture for the background"),
        FileRequest::Font => desk.say("A typeface"),
        FileRequest::Outline => desk.say("A drawing to extrude"),
        FileRequest::LoadBrdf => desk.say("Load a reflection model"),
        FileRequest::SaveBrdf => desk.say("Save the reflection model"),
    }
}

/// How long ago something was written.
fn age(written: u64, desk: &PanelContext) -> String {
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    let seconds = now.map_or(0, |d| d.as_secs().saturating_sub(written));
    match seconds {
        0..3_600 => format!("{} min", seconds / 60),
        3_600..86_400 => format!("{} h", seconds / 3_600),
        _ => format!("{} {}", seconds / 86_400, desk.say("days")),
    }
}

fn preference_rows(ui: &mut Ui, desk: &PanelContext, new: &mut Preferences) {
    let say = |text| desk.say(text);
    let label = ui.label(say("Language"));
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
    ui.label(say("Theme"));
    ui.horizontal(|ui| {
        ui.selectable_value(&mut new.theme, Theme::System, say("as the desktop"));
        ui.selectable_value(&mut new.theme, Theme::Light, say("bright"));
        ui.selectable_value(&mut new.theme, Theme::Dark, say("dark"));
    });
    ui.end_row();
    let label = ui.label(say("Size of texts"));
    let slider = Slider::new(&mut new.scale, 0.5..=3.0).step_by(0.1);
    ui.add(slider.update_while_editing(false))
        .labelled_by(label.id);
    ui.end_row();
    let label = ui.label(say("Colour map"));
    egui::ComboBox::new("map", "")
        .selected_text(map_name(new.color_map, desk))
        .show_ui(ui, |ui| {
            for map in ColorMap::ALL {
                ui.selectable_value(&mut new.color_map, map, map_name(map, desk));
            }
        })
        .response
        .labelled_by(label.id);
    ui.end_row();
    let label = ui.label(say("Copy for recovery after"));
    let drag = DragValue::new(&mut new.autosave)
        .range(0..=3_600)
        .suffix(" s");
    ui.add(drag)
        .on_hover_text(say("0 s: never"))
        .labelled_by(label.id);
    ui.end_row();
    let label = ui.label(say("Threads"));
    let drag = DragValue::new(&mut new.threads).range(0..=256);
    ui.add(drag)
        .on_hover_text(say("0: all but one, which the window keeps"))
        .labelled_by(label.id);
    ui.end_row();
    let label = ui.label(say("Paths per pixel of a picture"));
    let drag = DragValue::new(&mut new.picture_samples).range(1..=65_536);
    ui.add(drag).labelled_by(label.id);
    ui.end_row();
    let label = ui.label(say("Rays of its final gather"));
    let drag = DragValue::new(&mut new.picture_gather).range(0..=MOST_GATHER);
    let about = say("Sharpens shadows and hides patches, slowly; 0 for none.");
    ui.add(drag).labelled_by(label.id).on_hover_text(about);
    ui.end_row();
}

/// Its name.
pub fn map_name(map: ColorMap, desk: &PanelContext) -> &'static str {
    match map {
        ColorMap::Viridis => "viridis",
        ColorMap::Cividis => "cividis",
        ColorMap::Magma => "magma",
        ColorMap::Grey => desk.say("grey"),
    }
}

fn mouse_help(ui: &mut Ui, desk: &PanelContext) {
    let rows = [
        (
            desk.say("Drag"),
            desk.say("turn around the middle of the view"),
        ),
        (
            desk.say("Right or middle drag, or Shift and drag"),
            desk.say("shift the view"),
        ),
        (
            desk.say("Wheel, or Ctrl and drag"),
            desk.say("nearer and further"),
        ),
        (
            desk.say("Click"),
            desk.say("select an object; with Ctrl, one more; with Alt, a face"),
        ),
        (desk.say("Double click"), desk.say("look at the object")),
        (
            desk.say("W A S D, R F"),
            desk.say("fly forward, left, back, right, up, down"),
        ),
        (desk.say("Drag while flying"), desk.say("look around")),
        (desk.say("Arrows"), desk.say("turn the head")),
        (
            desk.say("Shift + arrows"),
            desk.say("turn around the model"),
        ),
        (desk.say("Ctrl + arrows"), desk.say("shift the view")),
        ("+ −", desk.say("nearer and further")),
        (
            desk.say("Enter, with the viewport in focus"),
            desk.say("a click in the middle of it; with Alt, on a face"),
        ),
        (
            desk.say("Drag an arrow of the selection"),
            desk.say("move it along the axis"),
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

/// Two columns of menus with their keys.
fn key_help(ui: &mut Ui, desk: &PanelContext) {
    let half = Menu::ALL.len() / 2;
    ui.columns(2, |columns| {
        for (column, menus) in columns
            .iter_mut()
            .zip([&Menu::ALL[..half], &Menu::ALL[half..]])
        {
            key_column(column, desk, menus);
        }
    });
}

fn key_column(ui: &mut Ui, desk: &PanelContext, menus: &[Menu]) {
    for &menu in menus {
        let keyed: Vec<_> = (ACTIONS.iter())
            .filter(|a| a.menu == menu && a.key.is_some())
            .collect();
        if keyed.is_empty() {
            continue;
        }
        ui.add_space(8.0);
        ui.strong(menu.label(desk.language));
        Grid::new(("keys", menu.label(desk.language)))
            .num_columns(2)
            .striped(true)
            .show(ui, |ui| {
                for action in keyed {
                    let key = action.key.map(|k| ui.ctx().format_shortcut(&k));
                    ui.monospace(key.unwrap_or_default());
                    ui.label(desk.say(action.label));
                    ui.end_row();
                }
            });
    }
}

/// A picture on the screen.
pub fn pixels(image: &azulejo::scene::Image, exposure: Option<f64>) -> Arc<egui::ColorImage> {
    let bytes = crate::app::shown(image, exposure);
    let size = [image.width as usize, image.height as usize];
    Arc::new(egui::ColorImage::from_rgb(size, &bytes))
}
