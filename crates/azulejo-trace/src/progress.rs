//! Reports and cancels long work.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;
use std::{fmt, sync::Mutex};

/// Counts work and stops it; shared between the worker threads and whoever watches.
///
/// A worker calls [`advance`](Progress::advance) once per patch row or tile: that both counts
/// and asks whether to go on. A watcher reads [`done`](Progress::done), [`total`](Progress::total)
/// and [`stage`](Progress::stage), and calls [`cancel`](Progress::cancel).
#[derive(Debug, Default)]
pub struct Progress {
    cancelled: AtomicBool,
    done: AtomicU64,
    total: AtomicU64,
    stage: Mutex<String>,
    deadline: Mutex<Option<Instant>>,
}

/// The work was cancelled before it was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cancelled;

impl fmt::Display for Cancelled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("cancelled")
    }
}

impl std::error::Error for Cancelled {}

impl Progress {
    /// Nothing done yet, never cancelled, no deadline.
    pub fn new() -> Progress {
        Progress::default()
    }

    /// Begins a stage of `total` steps; `stage` is a short verb for people ("form factors").
    pub fn begin(&self, stage: &str, total: u64) {
        if let Ok(mut name) = self.stage.lock() {
            stage.clone_into(&mut name);
        }
        self.done.store(0, Ordering::Relaxed);
        self.total.store(total, Ordering::Relaxed);
    }

    /// Counts `steps` and says whether to go on.
    ///
    /// # Errors
    /// [`Cancelled`] once [`cancel`](Progress::cancel) was called.
    pub fn advance(&self, steps: u64) -> Result<(), Cancelled> {
        self.done.fetch_add(steps, Ordering::Relaxed);
        if self.cancelled.load(Ordering::Relaxed) {
            Err(Cancelled)
        } else {
            Ok(())
        }
    }

    /// Asks all work to stop at its next step.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Sets the moment at which refinement should end with what it has; unlike
    /// [`cancel`](Progress::cancel), the work then finishes in good order.
    pub fn set_deadline(&self, deadline: Instant) {
        if let Ok(mut d) = self.deadline.lock() {
            *d = Some(deadline);
        }
    }

    /// Whether the deadline has passed.
    pub fn out_of_time(&self) -> bool {
        self.deadline
            .lock()
            .is_ok_and(|d| d.is_some_and(|d| Instant::now() >= d))
    }

    /// Steps of the current stage that are done.
    pub fn done(&self) -> u64 {
        self.done.load(Ordering::Relaxed)
    }

    /// Steps of the current stage.
    pub fn total(&self) -> u64 {
        self.total.load(Ordering::Relaxed)
    }

    /// Name of the current stage; empty before the first.
    pub fn stage(&self) -> String {
        self.stage.lock().map(|s| s.clone()).unwrap_or_default()
    }
}
