//! Ending the program from outside: SIGTERM, SIGINT, SIGHUP, and what other systems have instead.
//!
//! Such a request is not a crash, and no user is there to be asked: the window writes unsaved changes
//! as a recovery copy, which the next start offers, and closes.

use crate::jobs::RepaintRequest;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
#[cfg(not(target_arch = "wasm32"))]
use std::time::Duration;

/// The time that a window has to close. One that is stuck, or whose display is gone, must not keep
/// the session from ending.
#[cfg(not(target_arch = "wasm32"))]
const PATIENCE: Duration = Duration::from_secs(10);

/// What became of unsaved changes: the path of their copy, `None` if there were none, or why no
/// copy could be written.
pub type KeptWork = Result<Option<PathBuf>, String>;

/// A request to end the program, shared by the window and the thread that receives signals.
#[derive(Clone, Default)]
pub struct EndRequest(Arc<EndState>);

#[derive(Default)]
struct EndState {
    is_asked: AtomicBool,
    wake: Mutex<Option<RepaintRequest>>,
    kept: Mutex<Option<KeptWork>>,
}

impl EndRequest {
    /// Listens to the signals from now on; a web page gets none.
    ///
    /// # Errors
    ///
    /// A message if they cannot be received.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn listen(&self) -> Result<(), String> {
        let request = self.clone();
        ctrlc::set_handler(move || request.on_signal())
            .map_err(|e| format!("cannot handle signals: {e}"))
    }

    /// A second signal does not wait for the window.
    #[cfg(not(target_arch = "wasm32"))]
    fn on_signal(&self) {
        if self.is_asked() {
            std::process::exit(1);
        }
        self.ask();
        let request = self.clone();
        std::thread::spawn(move || {
            std::thread::sleep(PATIENCE);
            let is_safe = matches!(request.kept(), Some(Ok(_)));
            std::process::exit(i32::from(!is_safe));
        });
    }

    /// Asks the window to keep what is unsaved and to close.
    pub fn ask(&self) {
        self.0.is_asked.store(true, Ordering::SeqCst);
        // Not while it is locked: the window may answer at once.
        let wake = self.0.wake.lock().ok().and_then(|wake| wake.clone());
        if let Some(wake) = wake {
            wake();
        }
    }

    /// Whether the program should end.
    pub fn is_asked(&self) -> bool {
        self.0.is_asked.load(Ordering::SeqCst)
    }

    /// Sets what wakes the window, which otherwise sleeps until it has something to do.
    pub fn wake_with(&self, wake: RepaintRequest) {
        if let Ok(mut slot) = self.0.wake.lock() {
            *slot = Some(wake);
        }
    }

    /// Notes what became of unsaved changes.
    pub fn note(&self, kept: KeptWork) {
        if let Ok(mut slot) = self.0.kept.lock() {
            *slot = Some(kept);
        }
    }

    /// What became of unsaved changes, once the window has answered.
    pub fn kept(&self) -> Option<KeptWork> {
        self.0.kept.lock().ok()?.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicU32;

    #[test]
    fn the_window_is_woken_and_its_answer_known() {
        let request = EndRequest::default();
        // A signal may come before there is a window.
        request.ask();
        assert!(request.is_asked() && request.kept().is_none());
        let woken = Arc::new(AtomicU32::new(0));
        let count = Arc::clone(&woken);
        request.wake_with(Arc::new(move || {
            count.fetch_add(1, Ordering::SeqCst);
        }));
        request.clone().ask();
        assert_eq!(woken.load(Ordering::SeqCst), 1);
        request.note(Ok(Some("a.grf".into())));
        assert_eq!(request.kept(), Some(Ok(Some("a.grf".into()))));
    }
}
