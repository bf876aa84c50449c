//! Long work: in a thread of its own, without the interpreter, while the calling thread listens for
//! Ctrl-C and reports progress.

use crate::error::refused;
use azulejo_trace::Progress;
use pyo3::prelude::*;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::{self, Builder};
use std::time::{Duration, Instant};

/// How long the calling thread waits before it looks for signals.
const SLICE: Duration = Duration::from_millis(50);

/// Time between two calls of a progress callback.
const BETWEEN_CALLS: Duration = Duration::from_millis(100);

/// Time for cancelled work to end before it is left to itself. Most ends within milliseconds; reading
/// one very large file, or building its bounding volume hierarchy, does not.
const PATIENCE: Duration = Duration::from_millis(600);

/// Bytes of stack, as the command's main thread has.
const STACK: usize = 8 << 20;

/// How work is run and watched.
pub struct WorkOptions {
    /// Number of threads; `None` for as many as there are processors.
    pub threads: Option<usize>,
    /// Called with the completed share and the name of the stage.
    pub callback: Option<Py<PyAny>>,
    /// Ends refinement after this time.
    pub time: Option<Duration>,
}

impl WorkOptions {
    /// Without a limit of time.
    pub fn new(threads: Option<usize>, callback: Option<Py<PyAny>>) -> WorkOptions {
        WorkOptions {
            threads,
            callback,
            time: None,
        }
    }
}

/// Where the result of a thread appears.
struct ResultSlot<T> {
    result: Mutex<Option<thread::Result<PyResult<T>>>>,
    ready: Condvar,
}

impl<T> ResultSlot<T> {
    fn put(&self, result: thread::Result<PyResult<T>>) {
        *self.result.lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
        self.ready.notify_all();
    }

    /// The result, if it appears in time.
    fn wait(&self, time: Duration) -> Option<thread::Result<PyResult<T>>> {
        let guard = self.result.lock().unwrap_or_else(PoisonError::into_inner);
        let waited = self.ready.wait_timeout_while(guard, time, |r| r.is_none());
        waited.unwrap_or_else(PoisonError::into_inner).0.take()
    }
}

/// Runs `work` and waits for it.
///
/// # Errors
/// Those of the work; `KeyboardInterrupt` and what else a signal handler or the callback raises, for
/// which the work is cancelled; a panic as an [`AzulejoError`](crate::error::AzulejoError).
pub fn run<T: Send + 'static>(
    py: Python<'_>,
    options: &WorkOptions,
    work: impl FnOnce(&Progress) -> PyResult<T> + Send + 'static,
) -> PyResult<T> {
    let progress = Arc::new(Progress::new());
    if let Some(end) = options.time.and_then(|t| Instant::now().checked_add(t)) {
        progress.set_deadline(end);
    }
    let slot = Arc::new(ResultSlot {
        result: Mutex::new(None),
        ready: Condvar::new(),
    });
    let (for_work, for_result, threads) = (progress.clone(), slot.clone(), options.threads);
    let in_thread = move || {
        let done = catch_unwind(AssertUnwindSafe(|| in_pool(threads, || work(&for_work))));
        for_result.put(done);
    };
    let started = Builder::new().stack_size(STACK).spawn(in_thread);
    started.map_err(|e| refused(format_args!("cannot start a thread: {e}")))?;
    let mut called = Instant::now();
    loop {
        if let Some(result) = py.detach(|| slot.wait(SLICE)) {
            return result.unwrap_or_else(|panic| Err(internal(&*panic)));
        }
        if let Err(error) = look(py, &progress, options.callback.as_ref(), &mut called) {
            progress.cancel();
            py.detach(|| drop(slot.wait(PATIENCE)));
            return Err(error);
        }
    }
}

/// Runs in a pool of this many threads, or in everybody's.
fn in_pool<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> PyResult<T> + Send,
) -> PyResult<T> {
    let Some(threads) = threads else {
        return work();
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let failed = |e| refused(format_args!("cannot start {threads} threads: {e}"));
    pool.map_err(failed)?.install(work)
}

/// Handles signals and calls the callback.
fn look(
    py: Python<'_>,
    progress: &Progress,
    callback: Option<&Py<PyAny>>,
    called: &mut Instant,
) -> PyResult<()> {
    py.check_signals()?;
    if let Some(callback) = callback
        && called.elapsed() >= BETWEEN_CALLS
    {
        *called = Instant::now();
        let total = progress.total().max(1) as f64;
        let share = (progress.done() as f64 / total).min(1.0);
        callback.call1(py, (share, progress.stage()))?;
    }
    Ok(())
}

/// A panic is a mistake of ours.
fn internal(panic: &(dyn Any + Send)) -> PyErr {
    let words = panic.downcast_ref::<&str>().copied();
    let words = words.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
    refused(format_args!(
        "internal error, please report it: {}",
        words.unwrap_or("a panic")
    ))
}
