//! Background computations of which only the latest result matters.

use crate::platform::IS_PAGE;
use azulejo::trace::time::{Duration, Instant};
use azulejo::trace::{Cancelled, Progress};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// An outdated task may still finish within this time, so that something is displayed while
/// dragging; a slower one is cancelled.
const PATIENCE: Duration = Duration::from_millis(250);
/// The same in a page, where nothing else happens meanwhile: what is shown by then stays.
const PAGE_LIMIT: Duration = Duration::from_millis(150);

/// One thread separate from the solver's, so that the editor does not wait behind long jobs.
pub(super) struct BackgroundWorker {
    /// `None` if the system has no more threads; the global pool is used then.
    pool: Option<ThreadPool>,
}

impl BackgroundWorker {
    pub fn new(name: &'static str) -> BackgroundWorker {
        let builder = ThreadPoolBuilder::new().num_threads(1);
        let pool = builder.thread_name(move |_| name.to_owned()).build();
        BackgroundWorker { pool: pool.ok() }
    }

    /// Runs a job soon; in a page at once, as there is no other thread.
    pub fn spawn(&self, job: impl FnOnce() + Send + 'static) {
        match &self.pool {
            _ if IS_PAGE => job(),
            Some(pool) => pool.spawn(job),
            None => rayon::spawn(job),
        }
    }
}

/// The latest result of a task identified by a key.
pub(super) struct LatestResult<K, T> {
    running: Option<RunningTask<K, T>>,
    found: Option<(K, T)>,
    /// How long the next task may take in a page, which stands still meanwhile.
    page_limit: Duration,
}

struct RunningTask<K, T> {
    key: K,
    progress: Arc<Progress>,
    results: Receiver<T>,
    since: Instant,
    has_shown: bool,
}

impl<K, T> Default for LatestResult<K, T> {
    fn default() -> LatestResult<K, T> {
        LatestResult {
            running: None,
            found: None,
            page_limit: PAGE_LIMIT,
        }
    }
}

/// A background task: passes results of increasing quality to the callback until it is done or
/// cancelled.
pub(super) type BackgroundTask<K, T> =
    fn(&K, &Progress, &mut dyn FnMut(T)) -> Result<(), Cancelled>;

impl<K: Clone + PartialEq + Send + 'static, T: Send + 'static> LatestResult<K, T> {
    /// Starts computing the result for `key` unless it is available or on its way, and takes
    /// available results.
    pub fn ask(
        &mut self,
        key: &K,
        job: BackgroundTask<K, T>,
        worker: &BackgroundWorker,
        ctx: &egui::Context,
    ) {
        self.collect();
        if let Some(running) = &self.running {
            if running.key == *key {
                return;
            }
            if running.has_shown || running.since.elapsed() > PATIENCE {
                running.progress.cancel();
                self.running = None;
            } else {
                // Nothing else repaints while a task is being waited for.
                ctx.request_repaint_after(PATIENCE);
                return;
            }
        }
        if !self.found.as_ref().is_some_and(|(known, _)| known == key) {
            let limit = IS_PAGE.then_some(self.page_limit);
            self.running = Some(start(key.clone(), job, worker, ctx.clone(), limit));
        }
    }

    /// Takes available results.
    fn collect(&mut self) {
        let Some(running) = &mut self.running else {
            return;
        };
        loop {
            match running.results.try_recv() {
                Ok(result) => {
                    running.has_shown = true;
                    self.found = Some((running.key.clone(), result));
                }
                Err(TryRecvError::Empty) => return,
                Err(TryRecvError::Disconnected) => break,
            }
        }
        let is_found = running.has_shown;
        self.running = None;
        // What was cut off without a result gets more time.
        self.page_limit = if is_found {
            PAGE_LIMIT
        } else {
            2 * self.page_limit
        };
    }

    /// Waits for a first result, for a time too short to notice.
    pub fn wait(&mut self, longest: Duration) {
        if IS_PAGE {
            // What could be had in time is there.
            return self.collect();
        }
        let Some(running) = self.running.as_mut().filter(|r| !r.has_shown) else {
            return;
        };
        if let Ok(result) = running.results.recv_timeout(longest) {
            running.has_shown = true;
            self.found = Some((running.key.clone(), result));
        }
        self.collect();
    }

    /// The latest result, with its key.
    pub fn found(&self) -> Option<&(K, T)> {
        self.found.as_ref()
    }

    /// The result for `key`, if it is available.
    pub fn of(&self, key: &K) -> Option<&T> {
        let result = self.found.as_ref();
        result.and_then(|(k, result)| (k == key).then_some(result))
    }

    /// Whether a task is running.
    pub fn is_running(&self) -> bool {
        self.running.is_some()
    }
}

impl<K, T> Drop for LatestResult<K, T> {
    fn drop(&mut self) {
        if let Some(running) = &self.running {
            running.progress.cancel();
        }
    }
}

fn start<K, T>(
    key: K,
    job: BackgroundTask<K, T>,
    worker: &BackgroundWorker,
    ctx: egui::Context,
    limit: Option<Duration>,
) -> RunningTask<K, T>
where
    K: Clone + Send + 'static,
    T: Send + 'static,
{
    let (sender, results) = channel();
    let progress = Arc::new(Progress::new());
    let (own_key, own_progress) = (key.clone(), progress.clone());
    if let Some(limit) = limit {
        progress.set_deadline(Instant::now() + limit);
        progress.observe(|progress| {
            if progress.out_of_time() {
                progress.cancel();
            }
        });
    }
    worker.spawn(move || {
        let mut show = |result| {
            // The receiver may be gone.
            let _ = sender.send(result);
            ctx.request_repaint();
        };
        if own_progress.advance(0).is_ok() {
            // A cancelled task has no result.
            let _ = job(&own_key, &own_progress, &mut show);
        }
        drop(sender);
        ctx.request_repaint();
    });
    RunningTask {
        key,
        progress,
        results,
        since: Instant::now(),
        has_shown: false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wait(
        latest: &mut LatestResult<u32, u32>,
        key: u32,
        job: BackgroundTask<u32, u32>,
        worker: &BackgroundWorker,
    ) {
        let ctx = egui::Context::default();
        for _ in 0..2000 {
            latest.ask(&key, job, worker, &ctx);
            if !latest.is_running() && latest.of(&key).is_some() {
                return;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        panic!("no result for {key}");
    }

    fn doubled(key: &u32, _: &Progress, show: &mut dyn FnMut(u32)) -> Result<(), Cancelled> {
        show(2 * key);
        Ok(())
    }

    /// Returns one result and runs until it is cancelled, except for key 0.
    fn endless(key: &u32, progress: &Progress, show: &mut dyn FnMut(u32)) -> Result<(), Cancelled> {
        show(*key);
        if *key == 0 {
            return Ok(());
        }
        loop {
            progress.advance(1)?;
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    #[test]
    fn the_result_is_that_of_the_last_key() {
        let (mut latest, worker) = (LatestResult::default(), BackgroundWorker::new("test"));
        wait(&mut latest, 3, doubled, &worker);
        assert_eq!(latest.found(), Some(&(3, 6)));
        wait(&mut latest, 4, doubled, &worker);
        assert_eq!((latest.of(&3), latest.of(&4)), (None, Some(&8)));
    }

    #[test]
    fn work_that_nobody_wants_is_stopped() {
        let (mut latest, worker) = (LatestResult::default(), BackgroundWorker::new("test"));
        let ctx = egui::Context::default();
        while latest.found().is_none() {
            latest.ask(&7, endless, &worker, &ctx);
        }
        assert!(latest.is_running());
        // The only thread is free for this task only if the first one has stopped.
        wait(&mut latest, 0, endless, &worker);
    }
}
