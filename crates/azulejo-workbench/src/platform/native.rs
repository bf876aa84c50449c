//! A desktop.

use std::path::PathBuf;
use std::time::Duration;
use thread_priority::{ThreadPriority, ThreadPriorityValue, set_current_thread_priority};

/// Whether the workbench is a page in a browser.
pub const IS_PAGE: bool = false;

/// The folder of the user.
pub fn home() -> Option<PathBuf> {
    Some(directories::UserDirs::new()?.home_dir().to_owned())
}

/// The folder in which relative paths begin.
pub fn current_folder() -> Option<PathBuf> {
    std::env::current_dir().ok()
}

/// Does nothing for a while, in a thread that may.
pub fn sleep(time: Duration) {
    std::thread::sleep(time);
}

/// Lowers the priority of this thread, where the system supports it.
pub fn lower_priority() {
    // On a scale from 0 to 99 on which threads start at 49. Equivalent to niceness 5 where that
    // exists: the window gets three quarters of a contended processor, and other programs do not
    // starve the job.
    const BELOW_OTHERS: u8 = 35;
    if let Ok(value) = ThreadPriorityValue::try_from(BELOW_OTHERS) {
        let _ = set_current_thread_priority(ThreadPriority::Crossplatform(value));
    }
}

/// Runs `run` in a thread.
///
/// # Errors
/// The system has no more threads.
pub fn start_thread(name: String, run: impl FnOnce() + Send + 'static) -> std::io::Result<()> {
    let builder = std::thread::Builder::new().name(name);
    builder.spawn(run).map(drop)
}
