//! The file dialog: the desktop's, or a field for a path where there is none.

#[cfg_attr(target_arch = "wasm32", path = "files/in_page.rs")]
mod native;
mod path_dialog;
mod request;
mod typed_path;

use crate::command::{Command, FileRequest};
use crate::platform;
use crate::ui::panel_context::PanelContext;
use azulejo::formats::disk;
use egui::{Context, Id, Modal, Ui};
use native::NativeDialog;
pub use native::NativeSupport;
use path_dialog::PathDialog;
use request::{FileAnswer, NativeFileRequest};
use std::path::{Path, PathBuf};

/// The file dialog, and the question before a file is replaced.
#[derive(Default)]
pub(super) struct FileChooser {
    dialog: Option<(FileRequest, FileDialogKind)>,
    /// An existing file that would be replaced, with the request it was chosen for.
    replacing: Option<(FileRequest, PathBuf)>,
    /// The folder of the last dialog.
    folder: Option<PathBuf>,
    /// Whether the desktop has a dialog that may be used.
    native: NativeSupport,
}

/// An open dialog.
enum FileDialogKind {
    /// A field for a path.
    Typed(PathDialog),
    /// The desktop's, which the window opens after the frame.
    NativeWanted(Box<NativeFileRequest>),
    /// The desktop's.
    Native(NativeDialog),
}

/// The files chosen for a request.
pub(super) struct ChosenFiles {
    pub request: FileRequest,
    pub first: PathBuf,
    pub all: Vec<PathBuf>,
}

impl FileChooser {
    /// Whether the dialog or the question is open.
    pub fn is_open(&self) -> bool {
        self.dialog.is_some() || self.replacing.is_some()
    }

    /// Sets whether the desktop's dialog may be used.
    pub fn set_native(&mut self, native: NativeSupport) {
        self.native = native;
    }

    /// Opens the desktop's dialog, if it was requested in this frame.
    pub fn open_native(&mut self, frame: &eframe::Frame, context: &Context) {
        if let Some((_, kind)) = &mut self.dialog
            && let FileDialogKind::NativeWanted(request) = kind
        {
            let dialog = NativeDialog::open((**request).clone(), frame, context);
            *kind = FileDialogKind::Native(dialog);
        }
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
        let (what, kind) = self.dialog.as_mut()?;
        let what = *what;
        let answer = match kind {
            FileDialogKind::Typed(dialog) => dialog.show(ui, cx, request::title(what, cx)),
            FileDialogKind::NativeWanted(_) => wait_for_native(ui, cx, None),
            FileDialogKind::Native(native) => wait_for_native(ui, cx, native.answer()),
        };
        self.close(what, answer?, cx)
    }

    /// Closes the dialog; returns the chosen files, unless one of them would be replaced and nobody has
    /// asked about it. Where the desktop's dialog failed, a path is typed.
    fn close(
        &mut self,
        what: FileRequest,
        answer: FileAnswer,
        cx: &mut PanelContext,
    ) -> Option<ChosenFiles> {
        let dialog = self.dialog.take();
        let paths = match answer {
            FileAnswer::Chosen(paths) => paths,
            FileAnswer::Cancelled => Vec::new(),
            FileAnswer::Failed => {
                // What failed once is not tried again.
                self.native = NativeSupport::default();
                self.dialog = Some((what, self.open(what, cx)));
                return None;
            }
        };
        let Some(mut first) = paths.first().cloned() else {
            cx.send(Command::CancelPending);
            return None;
        };
        self.folder = first.parent().map(Path::to_owned);
        let is_typed = matches!(dialog, Some((_, FileDialogKind::Typed(_))));
        let mut may_replace = !is_typed;
        if let (None, Some(extension)) = (first.extension(), request::default_extension(what)) {
            first.set_extension(extension);
            may_replace = false;
        }
        // Overwriting the document's own file needs no question, unless it has changed on disk.
        let own = cx
            .app
            .file
            .as_ref()
            .filter(|f| what == FileRequest::SaveAs && f.path == first);
        may_replace |= own.is_some_and(|f| !f.has_changed());
        let is_there = disk::exists(&first).unwrap_or_default();
        if request::saves(what) && is_there && !may_replace {
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

    /// The desktop's dialog if it has one, or a field for a path.
    fn open(&self, what: FileRequest, cx: &PanelContext) -> FileDialogKind {
        if self.native.offers(request::saves(what)) {
            return FileDialogKind::NativeWanted(Box::new(self.native_request(what, cx)));
        }
        let folder = self.folder(cx).unwrap_or_default();
        let name = request::proposed_name(what, &stem(cx), cx.app);
        FileDialogKind::Typed(PathDialog::new(request::saves(what), folder, name))
    }

    fn native_request(&self, what: FileRequest, cx: &PanelContext) -> NativeFileRequest {
        NativeFileRequest {
            title: request::title(what, cx).into(),
            saves: request::saves(what),
            many: request::takes_many(what),
            folder: self.folder(cx),
            name: request::proposed_name(what, &stem(cx), cx.app),
            types: file_types(what, cx),
        }
    }

    /// The folder in which a dialog opens.
    fn folder(&self, cx: &PanelContext) -> Option<PathBuf> {
        let folder = self.folder.clone();
        let folder = folder.or_else(|| known_file(cx).and_then(Path::parent).map(Path::to_owned));
        let folder = folder.filter(|f| disk::metadata(f).is_ok_and(|meta| meta.is_dir()));
        folder.or_else(platform::current_folder)
    }
}

/// Tells that the desktop's dialog is open; returns its answer, or that of the user who no longer
/// waits for it.
fn wait_for_native(
    ui: &Ui,
    cx: &PanelContext,
    mut answer: Option<FileAnswer>,
) -> Option<FileAnswer> {
    let modal = Modal::new(Id::unique("native files")).show(ui.ctx(), |ui| {
        ui.set_width(320.0);
        ui.label(cx.tr("Choose the file in the desktop's dialog."));
        ui.horizontal(|ui| {
            if ui.button(cx.tr("Type a path…")).clicked() {
                answer = Some(FileAnswer::Failed);
            }
            if ui.button(cx.tr("Cancel")).clicked() {
                answer = Some(FileAnswer::Cancelled);
            }
        });
    });
    // A click beside it comes from the other window as it closes.
    let escapes = modal.is_top_modal && ui.input(|i| i.key_pressed(egui::Key::Escape));
    answer.or(escapes.then_some(FileAnswer::Cancelled))
}

/// The types of files that the desktop's dialog offers. Its patterns know upper and lower case.
fn file_types(what: FileRequest, cx: &PanelContext) -> Vec<(String, Vec<String>)> {
    let mut types = Vec::new();
    let extensions = match request::default_extension(what) {
        // Some desktops add the first extension to a name without one.
        Some(extension) if what == FileRequest::SaveAs => vec![extension],
        _ => request::extensions(what).to_vec(),
    };
    if !extensions.is_empty() {
        let name = if request::takes_many(what) {
            cx.tr("Models").to_owned()
        } else {
            request::title(what, cx).to_owned()
        };
        let upper = extensions.iter().map(|e| e.to_uppercase());
        let lower = extensions.iter().map(|e| (*e).to_owned());
        types.push((name, lower.chain(upper).collect()));
    }
    types.push((cx.tr("All files").to_owned(), vec!["*".into()]));
    types
}

/// The file of the document, or the first one that was added to it.
fn known_file<'a>(cx: &'a PanelContext) -> Option<&'a Path> {
    let file = cx.app.file.as_ref().map(|f| f.path.as_path());
    let sources = &cx.app.document.source_files;
    file.or_else(|| sources.first().map(|b| b.path.as_path()))
}

/// The name of the document's file without its extension.
fn stem(cx: &PanelContext) -> String {
    let stem = known_file(cx).and_then(Path::file_stem);
    let stem = stem.map(|s| s.to_string_lossy().into_owned());
    stem.filter(|s| !s.is_empty())
        .unwrap_or_else(|| "azulejo".into())
}

#[cfg(test)]
mod tests;
