//! The file dialog of the desktop.

use super::request::{FileAnswer, NativeFileRequest};
use azulejo::trace::time::{Duration, Instant};
use eframe::Frame;
use egui::Context;
use rfd::{AsyncFileDialog, FileHandle};
use std::path::PathBuf;
use std::pin::Pin;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::sync::{Arc, OnceLock};

/// Whether the desktop has a file dialog. The default is a window that does not ask for one.
#[derive(Clone, Debug, Default)]
pub struct NativeSupport(Arc<OnceLock<bool>>);

impl NativeSupport {
    /// Asks the desktop, in a thread: until the answer comes there is none.
    pub fn ask() -> NativeSupport {
        let support = NativeSupport::default();
        let answer = Arc::clone(&support.0);
        let ask = move || {
            let _ = answer.set(is_offered());
        };
        // Without a thread there is no answer, and none is needed.
        let _ = std::thread::Builder::new()
            .name("ask for file dialogs".into())
            .spawn(ask);
        support
    }

    /// A desktop that has one.
    #[cfg(test)]
    pub fn known() -> NativeSupport {
        NativeSupport(Arc::new(OnceLock::from(true)))
    }

    /// Whether it is known to have one, for writing files or for opening them.
    pub fn offers(&self, _saves: bool) -> bool {
        self.is_known()
    }

    /// Whether it is known to have one.
    pub fn is_known(&self) -> bool {
        self.0.get().copied().unwrap_or_default()
    }
}

/// Windows and macOS have one.
#[cfg(not(all(unix, not(target_os = "macos"))))]
fn is_offered() -> bool {
    true
}

/// Elsewhere a portal on the session bus offers it, or nothing does. In a session over SSH, it would
/// open on the other machine's screen.
#[cfg(all(unix, not(target_os = "macos")))]
fn is_offered() -> bool {
    /// A portal that is slower to start is as good as none.
    const PATIENCE: Duration = Duration::from_secs(5);
    let ask = async {
        let bus = zbus::connection::Builder::session()?;
        let bus = bus.method_timeout(PATIENCE).build().await?;
        bus.call_method(
            Some("org.freedesktop.portal.Desktop"),
            "/org/freedesktop/portal/desktop",
            Some("org.freedesktop.DBus.Properties"),
            "Get",
            &("org.freedesktop.portal.FileChooser", "version"),
        )
        .await
    };
    std::env::var_os("SSH_CONNECTION").is_none() && pollster::block_on(ask).is_ok()
}

/// A dialog of the desktop that is open.
pub struct NativeDialog(Receiver<(Option<Vec<PathBuf>>, Duration)>);

type PickedFiles = Pin<Box<dyn Future<Output = Option<Vec<FileHandle>>> + Send>>;

impl NativeDialog {
    /// Opens a dialog in front of the window `parent`, which is drawn again when it is answered.
    pub fn open(request: NativeFileRequest, parent: &Frame, context: &Context) -> NativeDialog {
        let picked = pick(request, parent);
        let (sender, receiver) = channel();
        let context = context.clone();
        let wait = move || {
            let begin = Instant::now();
            let files = pollster::block_on(picked);
            let paths = files.map(|all| all.iter().map(|f| f.path().to_owned()).collect());
            let _ = sender.send((paths, begin.elapsed()));
            context.request_repaint();
        };
        // Without a thread the sender is dropped, and the dialog has failed.
        let _ = std::thread::Builder::new()
            .name("file dialog".into())
            .spawn(wait);
        NativeDialog(receiver)
    }

    /// The answer, once there is one.
    pub fn answer(&self) -> Option<FileAnswer> {
        match self.0.try_recv() {
            Ok((paths, after)) => Some(understand(paths, after)),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(FileAnswer::Failed),
        }
    }
}

/// A dialog that could not open says the same as one that was cancelled. But nobody cancels what has
/// hardly appeared.
fn understand(paths: Option<Vec<PathBuf>>, after: Duration) -> FileAnswer {
    const TOO_SOON: Duration = Duration::from_millis(250);
    match paths {
        Some(paths) if !paths.is_empty() => FileAnswer::Chosen(paths),
        _ if after < TOO_SOON => FileAnswer::Failed,
        _ => FileAnswer::Cancelled,
    }
}

/// Opens the dialog here, as macOS requires of the thread of the window; the result may be awaited
/// elsewhere.
fn pick(request: NativeFileRequest, parent: &Frame) -> PickedFiles {
    let mut dialog = AsyncFileDialog::new()
        .set_title(request.title)
        .set_parent(parent);
    if let Some(folder) = request.folder {
        dialog = dialog.set_directory(folder);
    }
    for (name, extensions) in &request.types {
        dialog = dialog.add_filter(name, extensions);
    }
    if request.saves {
        let picked = dialog.set_file_name(request.name).save_file();
        Box::pin(async { picked.await.map(|file| vec![file]) })
    } else if request.many {
        Box::pin(dialog.pick_files())
    } else {
        let picked = dialog.pick_file();
        Box::pin(async { picked.await.map(|file| vec![file]) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dialog_that_closes_at_once_has_not_opened() {
        let (soon, late) = (Duration::from_millis(20), Duration::from_secs(2));
        let paths = Some(vec![PathBuf::from("/a.obj")]);
        let chosen = FileAnswer::Chosen(vec!["/a.obj".into()]);
        assert_eq!(understand(paths, soon), chosen);
        assert_eq!(understand(None, soon), FileAnswer::Failed);
        assert_eq!(understand(Some(Vec::new()), soon), FileAnswer::Failed);
        assert_eq!(understand(None, late), FileAnswer::Cancelled);
    }

    #[test]
    fn a_window_that_does_not_ask_has_none() {
        assert!(!NativeSupport::default().is_known());
    }

    #[test]
    fn a_thread_that_ends_without_an_answer_has_failed() {
        let (sender, receiver) = channel();
        let dialog = NativeDialog(receiver);
        assert_eq!(dialog.answer(), None);
        drop(sender);
        assert_eq!(dialog.answer(), Some(FileAnswer::Failed));
    }
}
