//! Progress reports, pausing and cancelling of long computations.

use crate::time::{Duration, Instant};
use std::collections::VecDeque;
use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, OnceLock, PoisonError};

/// Largest number of measures that are stored until they are taken; older ones are dropped.
const MOST_MEASURES: usize = 4096;

/// Counts work, pauses it and stops it; shared between worker threads and observers.
///
/// A worker calls [`advance`](Progress::advance) once per patch row or tile: this counts, waits
/// while the work is paused, and returns an error once it is cancelled. An observer reads
/// [`done`](Progress::done), [`total`](Progress::total), [`stage`](Progress::stage) and the
/// [measures](Progress::take_measures), and calls [`pause`](Progress::pause),
/// [`resume`](Progress::resume) and [`cancel`](Progress::cancel).
#[derive(Debug, Default)]
pub struct Progress {
    cancelled: AtomicBool,
    paused: AtomicBool,
    done: AtomicU64,
    total: AtomicU64,
    stage: Mutex<String>,
    clock: Mutex<Clock>,
    /// The work was resumed or cancelled.
    released: Condvar,
    measures: Mutex<VecDeque<Measured>>,
    observer: OnceLock<fn(&Progress)>,
}

/// The state that depends on the time.
#[derive(Debug, Default)]
struct Clock {
    deadline: Option<Instant>,
    /// Time from setting the deadline to the deadline.
    allowed: Duration,
    /// End of the current phase, not after the deadline.
    phase: Option<Instant>,
    /// Start of the current pause, or the time at which the deadline was set if that is later.
    paused: Option<Instant>,
}

impl Clock {
    /// Now, or when the current pause began.
    fn now(&self) -> Instant {
        self.paused.unwrap_or_else(Instant::now)
    }
}

/// The accuracy of a result so far.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Measure {
    /// The convergence of the solver. The systems of all replicates take their bounces together, or one after the
    /// other without a matrix, and again if their rows are refined.
    Residual {
        /// Index of the independent replicate, from 0.
        replicate: u32,
        /// Number of bounces computed, from 1.
        iteration: u32,
        /// With a matrix the largest change of a patch in this bounce, relative to the brightest
        /// patch; without, the unshot power, relative to the power reflected by the first bounce.
        /// Falls to the solver's tolerance.
        value: f64,
    },
    /// Estimated relative RMS error of the reflected radiosity of patches.
    PatchError(f64),
    /// Estimated relative RMS error of the gathered irradiance; the last value is that of the
    /// result.
    Error(f64),
    /// The requested error will not be reached with the time or the rays that are allowed.
    OutOfReach {
        /// The requested error.
        error: f64,
        /// How much longer from now it would take, seconds.
        seconds: f64,
        /// Mean number of rays per point that it would take in all.
        rays: f64,
    },
}

/// A measure and when it was taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// When it was taken.
    pub at: Instant,
    /// The measure.
    pub measure: Measure,
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

/// Locks a mutex even if it is poisoned: every change is one assignment, so the value is
/// consistent.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Progress {
    /// Progress with nothing done, not paused or cancelled, without deadline.
    pub fn new() -> Progress {
        Progress::default()
    }

    /// Calls `observer` at every step from now on, by the thread that makes it: for observers without a thread of
    /// their own. Only the first one counts.
    pub fn observe(&self, observer: fn(&Progress)) {
        let _ = self.observer.set(observer);
    }

    /// Begins a stage of `total` steps; `stage` is its short name for the user ("form factors").
    pub fn begin(&self, stage: &str, total: u64) {
        stage.clone_into(&mut lock(&self.stage));
        self.done.store(0, Ordering::Relaxed);
        self.total.store(total, Ordering::Relaxed);
    }

    /// Counts `steps`; waits while the work is [paused](Progress::pause).
    ///
    /// # Errors
    /// [`Cancelled`] once [`cancel`](Progress::cancel) was called.
    pub fn advance(&self, steps: u64) -> Result<(), Cancelled> {
        self.done.fetch_add(steps, Ordering::Relaxed);
        if let Some(observer) = self.observer.get() {
            observer(self);
        }
        if self.is_paused() {
            self.wait();
        }
        if self.is_cancelled() {
            Err(Cancelled)
        } else {
            Ok(())
        }
    }

    /// Sleeps until the work is resumed or cancelled.
    fn wait(&self) {
        let is_held = |clock: &mut Clock| clock.paused.is_some() && !self.is_cancelled();
        let clock = self.released.wait_while(lock(&self.clock), is_held);
        drop(clock);
    }

    /// Stops all work at its next step, at once if it is paused.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
        // While the lock is held, no thread is between checking the state and falling asleep.
        let _clock = lock(&self.clock);
        self.released.notify_all();
    }

    /// Whether the work was cancelled.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// Suspends all work at its next step until it is [resumed](Progress::resume) or cancelled. The
    /// time until then does not count against a deadline.
    ///
    /// The worker threads sleep, including those of a thread pool: work that may be paused while
    /// other work continues needs a thread pool of its own.
    pub fn pause(&self) {
        let mut clock = lock(&self.clock);
        clock.paused.get_or_insert_with(Instant::now);
        self.paused.store(true, Ordering::Relaxed);
    }

    /// Lets paused work continue.
    pub fn resume(&self) {
        let mut clock = lock(&self.clock);
        if let Some(since) = clock.paused.take() {
            let later = |end: Option<Instant>| end.and_then(|d| d.checked_add(since.elapsed()));
            (clock.deadline, clock.phase) = (later(clock.deadline), later(clock.phase));
        }
        self.paused.store(false, Ordering::Relaxed);
        self.released.notify_all();
    }

    /// Whether the work is paused, or about to be: a thread sleeps from its next step on.
    pub fn is_paused(&self) -> bool {
        self.paused.load(Ordering::Relaxed)
    }

    /// Sets the time at which refinement should end with its current result; unlike after
    /// [`cancel`](Progress::cancel), the work then finishes with a result.
    pub fn set_deadline(&self, deadline: Instant) {
        let mut clock = lock(&self.clock);
        clock.deadline = Some(deadline);
        clock.allowed = deadline.saturating_duration_since(Instant::now());
        clock.phase = None;
        clock.paused = clock.paused.map(|_| Instant::now());
    }

    /// Moves the deadline, if there is one, so much earlier: for work that has to be done after it.
    pub fn reserve(&self, time: Duration) {
        let mut clock = lock(&self.clock);
        let now = clock.now();
        let earlier = |d: Instant| d.checked_sub(time).map_or(now, |d| d.max(now));
        clock.deadline = clock.deadline.map(earlier);
    }

    /// Whether there is a deadline.
    pub fn has_deadline(&self) -> bool {
        lock(&self.clock).deadline.is_some()
    }

    /// Begins a phase that may take `share`, in 0..=1, of the time that is left until the deadline;
    /// without a deadline it has no end.
    pub fn limit_phase(&self, share: f64) {
        let mut clock = lock(&self.clock);
        let now = clock.now();
        let end = |d: Instant| {
            now + d
                .saturating_duration_since(now)
                .mul_f64(share.clamp(0.0, 1.0))
        };
        clock.phase = clock.deadline.map(end);
    }

    /// Time until the deadline, zero once it has passed; `None` without one.
    pub fn time_left(&self) -> Option<Duration> {
        let clock = lock(&self.clock);
        clock
            .deadline
            .map(|d| d.saturating_duration_since(clock.now()))
    }

    /// Time until the current phase should end; `None` without a deadline.
    pub fn phase_left(&self) -> Option<Duration> {
        let clock = lock(&self.clock);
        let end = clock.phase.or(clock.deadline);
        end.map(|d| d.saturating_duration_since(clock.now()))
    }

    /// Whether the deadline has passed.
    pub fn out_of_time(&self) -> bool {
        let clock = lock(&self.clock);
        clock.deadline.is_some_and(|d| clock.now() >= d)
    }

    /// Whether the current phase should end, or the deadline has passed.
    pub fn phase_is_over(&self) -> bool {
        let clock = lock(&self.clock);
        let end = clock.phase.or(clock.deadline);
        end.is_some_and(|d| clock.now() >= d)
    }

    /// Whether the deadline passed so long ago that work must end even without a result: a tenth of
    /// the time that was given, and half a second.
    pub fn is_overdue(&self) -> bool {
        let clock = lock(&self.clock);
        let grace = clock.allowed.mul_f64(0.1) + Duration::from_millis(500);
        clock.deadline.is_some_and(|d| clock.now() >= d + grace)
    }

    /// Number of completed steps of the current stage.
    pub fn done(&self) -> u64 {
        self.done.load(Ordering::Relaxed)
    }

    /// Number of steps of the current stage.
    pub fn total(&self) -> u64 {
        self.total.load(Ordering::Relaxed)
    }

    /// Name of the current stage; empty before the first.
    pub fn stage(&self) -> String {
        lock(&self.stage).clone()
    }

    /// Stores the accuracy of the result so far, for observers. Observers do not influence the
    /// computation.
    pub fn measured(&self, measure: Measure) {
        let mut measures = lock(&self.measures);
        if measures.len() == MOST_MEASURES {
            measures.pop_front();
        }
        measures.push_back(Measured {
            at: Instant::now(),
            measure,
        });
    }

    /// Takes the measures since the last call, the oldest first; at most the last 4096.
    pub fn take_measures(&self) -> Vec<Measured> {
        lock(&self.measures).drain(..).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::thread;

    /// Longer than any thread needs for a step, even on a busy machine.
    const PATIENCE: Duration = Duration::from_secs(60);

    fn wait_until(what: &str, is_so: impl Fn() -> bool) {
        let start = Instant::now();
        while !is_so() {
            assert!(start.elapsed() < PATIENCE, "{what}");
            thread::sleep(Duration::from_millis(1));
        }
    }

    /// Runs several threads that work until cancelled, which `watch` must do.
    fn working(progress: &Progress, watch: impl FnOnce()) {
        thread::scope(|scope| {
            for _ in 0..3 {
                scope.spawn(|| while progress.advance(1).is_ok() {});
            }
            wait_until("nothing is done", || progress.done() > 100);
            watch();
            progress.cancel();
        });
        assert!(progress.is_cancelled());
    }

    /// The number of steps once every thread has reached its next step.
    fn standing(progress: &Progress) -> u64 {
        let start = Instant::now();
        let mut before = progress.done();
        loop {
            assert!(start.elapsed() < PATIENCE, "it does not stand still");
            thread::sleep(Duration::from_millis(20));
            match progress.done() {
                now if now == before => return now,
                now => before = now,
            }
        }
    }

    #[test]
    fn an_observer_sees_every_step_and_may_end_the_work() {
        let progress = Progress::new();
        progress.observe(|progress| {
            if progress.done() == 3 {
                progress.cancel();
            }
        });
        assert_eq!(
            (0..9).take_while(|_| progress.advance(1).is_ok()).count(),
            2
        );
    }

    #[test]
    fn paused_work_stands_still_and_goes_on() {
        let progress = Progress::new();
        working(&progress, || {
            progress.pause();
            assert!(progress.is_paused());
            let held = standing(&progress);
            progress.resume();
            assert!(!progress.is_paused());
            wait_until("it does not go on", || progress.done() > held + 100);
        });
    }

    #[test]
    fn paused_work_ends_when_it_is_cancelled() {
        let progress = Progress::new();
        // The test is that the threads can be joined.
        working(&progress, || {
            progress.pause();
            standing(&progress);
        });
        assert_eq!(progress.advance(1), Err(Cancelled));
    }

    #[test]
    fn pauses_do_not_count_against_a_deadline() {
        let progress = Progress::new();
        let moment = Duration::from_millis(50);
        progress.set_deadline(Instant::now() + Duration::from_secs(3600));
        progress.pause();
        progress.set_deadline(Instant::now() + moment);
        thread::sleep(2 * moment);
        assert!(!progress.out_of_time(), "the pause counts");
        progress.resume();
        wait_until("the deadline never comes", || progress.out_of_time());
        progress.resume();
        assert!(progress.out_of_time(), "there was nothing to resume");
    }

    #[test]
    fn phases_end_before_the_deadline_and_grace_after_it() {
        let progress = Progress::new();
        progress.limit_phase(0.0);
        assert!(
            !progress.phase_is_over() && !progress.is_overdue(),
            "no deadline"
        );
        assert_eq!((progress.time_left(), progress.phase_left()), (None, None));
        progress.set_deadline(Instant::now() + Duration::from_secs(3600));
        assert!(!progress.phase_is_over());
        progress.limit_phase(0.0);
        assert!(progress.phase_is_over() && !progress.out_of_time());
        progress.limit_phase(0.5);
        assert!(!progress.phase_is_over());
        let minutes = |left: Option<Duration>| left.map(|l| (l.as_secs_f64() / 60.0).round());
        assert_eq!(minutes(progress.phase_left()), Some(30.0));
        assert_eq!(minutes(progress.time_left()), Some(60.0));
        // Time for what comes after is not there before, and no more than there is can be kept.
        progress.reserve(Duration::from_secs(1800));
        assert_eq!(minutes(progress.time_left()), Some(30.0));
        progress.reserve(Duration::from_secs(1 << 40));
        assert!(progress.out_of_time());
        progress.set_deadline(Instant::now());
        assert_eq!(progress.time_left(), Some(Duration::ZERO));
        assert!(progress.phase_is_over() && progress.out_of_time() && !progress.is_overdue());
        wait_until("the grace never ends", || progress.is_overdue());
    }

    #[test]
    fn measures_are_taken_once_and_bounded() {
        let progress = Progress::new();
        assert!(progress.take_measures().is_empty());
        let last = MOST_MEASURES + 3;
        (0..=last).for_each(|k| progress.measured(Measure::Error(k as f64)));
        let taken = progress.take_measures();
        assert_eq!(taken.len(), MOST_MEASURES);
        assert_eq!(taken[0].measure, Measure::Error(4.0));
        assert!(taken.is_sorted_by_key(|m| m.at));
        assert!(progress.take_measures().is_empty());
    }
}
