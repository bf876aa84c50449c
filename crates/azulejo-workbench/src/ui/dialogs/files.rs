//! The file dialog.

use super::show_all_files::ShowAllFiles;
use crate::app::App;
use crate::bake::LightmapFile;
use crate::command::{Command, FileRequest};
use crate::library::slug;
use crate::ui::panel_context::PanelContext;
use egui::{Id, Modal, Ui};
use egui_file::{FileDialog, State};
use std::path::{Path, PathBuf};

/// The file dialog, and the question before a file is replaced.
#[derive(Default)]
pub(super) struct FileChooser {
    dialog: Option<(FileRequest, FileDialog)>,
    all_files: ShowAllFiles,
    /// An existing file that would be replaced, with the request it was chosen for.
    replacing: Option<(FileRequest, PathBuf)>,
    /// The folder of the last chosen file.
    folder: Option<PathBuf>,
}

/// The files chosen for a request.
pub(super) struct ChosenFiles {
    pub request: FileRequest,
    pub first: PathBuf,
    pub all: Vec<PathBuf>,
}

/// Extensions of readable models, for the file dialog; the format is detected from the content.
const MODELS: [&str; 34] = [
    "3ds", "dxf", "obj", "flt", "wrl", "vrml", "x3d", "x3dv", "mgf", "gltf", "glb", "ply", "stl",
    "sff", "scn", "grf", "vs3", "msh", "off", "vtk", "vtu", "vtp", "bdf", "nas", "dat", "fem",
    "blk", "inp", "foam", "json", "jsonl", "idf", "epjson", "gz",
];

impl FileChooser {
    /// Whether the dialog or the question is open.
    pub fn is_open(&self) -> bool {
        self.dialog.is_some() || self.replacing.is_some()
    }

    /// Opens the file dialog when the app requests a file, and draws it; returns what was chosen.
    pub fn show(&mut self, ui: &Ui, cx: &mut PanelContext) -> Option<ChosenFiles> {
        if let Some(what) = cx.app.asking
            && self.replacing.is_none()
            && self.dialog.as_ref().is_none_or(|(open, _)| *open != what)
        {
            self.dialog = Some((what, self.open(what, cx)));
        }
        if let Some(chosen) = self.ask_replace(ui, cx) {
            return Some(chosen);
        }
        let (what, dialog) = self.dialog.as_mut()?;
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
        self.dialog = None;
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
        Some(ChosenFiles {
            request: what,
            first,
            all: paths,
        })
    }

    /// Asks before a file is replaced.
    fn ask_replace(&mut self, ui: &Ui, cx: &mut PanelContext) -> Option<ChosenFiles> {
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
            Some(ChosenFiles {
                request: what,
                first: path.clone(),
                all: vec![path],
            })
        } else {
            cx.send(Command::CancelPending);
            None
        }
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
            | FileRequest::Environment(_)
            | FileRequest::Recipe
            | FileRequest::Font
            | FileRequest::Outline
            | FileRequest::LoadBrdf => FileDialog::open_file(),
            FileRequest::SaveAs => FileDialog::save_file().default_filename(format!("{stem}.grf")),
            FileRequest::Export => FileDialog::save_file().default_filename(format!("{stem}.glb")),
            FileRequest::SaveRender => {
                FileDialog::save_file().default_filename(format!("{stem}.png"))
            }
            FileRequest::SaveLightmap(what) => {
                FileDialog::save_file().default_filename(lightmap_name(&stem, what))
            }
            FileRequest::SaveProbes => {
                FileDialog::save_file().default_filename(format!("{stem}-probes.csv"))
            }
            FileRequest::SaveTaskPlane => {
                FileDialog::save_file().default_filename(format!("{stem}-task-plane.csv"))
            }
            FileRequest::SaveBrdf => FileDialog::save_file().default_filename(brdf_name(cx.app)),
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
        FileRequest::SaveLightmap(what) => Some(what.extension()),
        FileRequest::SaveProbes | FileRequest::SaveTaskPlane => Some("csv"),
        FileRequest::SaveBrdf => Some("brdf"),
        _ => None,
    }
}

/// The name that is proposed for a reflection model: that of its material.
fn brdf_name(app: &App) -> String {
    let id = app.selection.material;
    let material = id.and_then(|id| app.document.materials.get(id as usize));
    let name = material.map_or(String::new(), |m| slug(&m.name));
    let name = if name.is_empty() { "material" } else { &name };
    format!("{name}.brdf")
}

/// The name that is proposed: another one than that of the model, which would be replaced.
fn lightmap_name(stem: &str, what: LightmapFile) -> String {
    let part = match what {
        LightmapFile::Model => "baked",
        LightmapFile::Irradiance => "irradiance",
        LightmapFile::StandardError => "error",
    };
    format!("{stem}-{part}.{}", what.extension())
}

fn saves(what: FileRequest) -> bool {
    matches!(
        what,
        FileRequest::SaveAs
            | FileRequest::Export
            | FileRequest::SaveRender
            | FileRequest::SaveLightmap(_)
            | FileRequest::SaveProbes
            | FileRequest::SaveTaskPlane
            | FileRequest::SaveBrdf
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
        FileRequest::Recipe => extension == "toml",
        FileRequest::Environment(_) => ["hdr", "exr"].contains(&extension.as_str()),
        FileRequest::Backdrop => ["png", "jpg", "jpeg", "hdr"].contains(&extension.as_str()),
        FileRequest::SaveRender => ["png", "exr", "hdr"].contains(&extension.as_str()),
        FileRequest::SaveLightmap(LightmapFile::Model) => {
            ["glb", "gltf"].contains(&extension.as_str())
        }
        FileRequest::SaveLightmap(_) => extension == "exr",
        FileRequest::SaveProbes | FileRequest::SaveTaskPlane => extension == "csv",
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
        FileRequest::SaveLightmap(LightmapFile::Model) => cx.tr("Save the model with its lightmap"),
        FileRequest::SaveLightmap(LightmapFile::Irradiance) => cx.tr("Save the irradiance"),
        FileRequest::SaveLightmap(LightmapFile::StandardError) => cx.tr("Save the standard error"),
        FileRequest::SaveProbes => cx.tr("Save the probes"),
        FileRequest::SaveTaskPlane => cx.tr("Save the task plane"),
        FileRequest::Backdrop => cx.tr("Choose a background image"),
        FileRequest::Recipe => cx.tr("Choose a recipe"),
        FileRequest::Environment(_) => cx.tr("Choose an environment map"),
        FileRequest::Font => cx.tr("Choose a font"),
        FileRequest::Outline => cx.tr("Choose a drawing to extrude"),
        FileRequest::LoadBrdf => cx.tr("Load a reflection model"),
        FileRequest::SaveBrdf => cx.tr("Save the reflection model"),
    }
}
