//! The file dialog of a browser, which opens files. Those that are saved are downloads, whose name is typed.

use super::request::{FileAnswer, NativeFileRequest};
use crate::platform;
use eframe::Frame;
use egui::Context;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// A browser has a dialog.
#[derive(Clone, Debug, Default)]
pub struct NativeSupport;

impl NativeSupport {
    /// There is nobody to ask.
    pub fn ask() -> NativeSupport {
        NativeSupport
    }

    /// Whether there is one for writing files, or for opening them.
    pub fn offers(&self, saves: bool) -> bool {
        !saves
    }
}

/// A dialog that is open.
pub struct NativeDialog(Receiver<Vec<PathBuf>>);

impl NativeDialog {
    /// Opens the dialog.
    pub fn open(request: NativeFileRequest, _: &Frame, context: &Context) -> NativeDialog {
        let (sender, receiver) = channel();
        let context = context.clone();
        // All types: a model is chosen together with the files that it names.
        let opened = platform::pick(request.many, "", request.many, move |arrived| {
            let _ = sender.send(arrived.paths);
            context.request_repaint();
        });
        // Without a dialog the sender is dropped, and it has failed.
        drop(opened);
        NativeDialog(receiver)
    }

    /// The answer, once there is one.
    pub fn answer(&self) -> Option<FileAnswer> {
        match self.0.try_recv() {
            Ok(paths) if paths.is_empty() => Some(FileAnswer::Cancelled),
            Ok(paths) => Some(FileAnswer::Chosen(paths)),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(FileAnswer::Cancelled),
        }
    }
}
