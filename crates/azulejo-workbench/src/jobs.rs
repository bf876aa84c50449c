//! Background jobs, each in a thread of its own.
//!
//! A job owns its input, reports through its [`Progress`], and sends its results through a channel
//! that the window empties in every frame. A panic in a job is an error of that job: the window
//! stays open.

use crate::platform;
use azulejo::trace::Progress;
use azulejo::trace::time::Instant;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

/// A function that requests a repaint of the window.
pub type RepaintRequest = Arc<dyn Fn() + Send + Sync>;

/// Kinds of jobs; of some there is only one at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JobKind {
    /// Reading models.
    Load,
    /// Reading an image for the background.
    Backplate,
    /// Reading a picture of the surroundings.
    Environment,
    /// Writing a file that the user requested.
    Save,
    /// Writing a recovery copy.
    Autosave,
    /// The first pass: solving the light.
    Solve,
    /// The second pass: rendering.
    Render,
    /// The third pass: baking a lightmap.
    Bake,
    /// Computing the form factors of one patch.
    FormFactors,
    /// Measuring irradiance at probes.
    Probe,
    /// Measuring irradiance on the task plane.
    TaskPlane,
}

/// A running job.
#[derive(Clone, Debug)]
pub struct Job {
    /// Its number, by which it is cancelled.
    pub id: u64,
    /// What it does.
    pub kind: JobKind,
    /// What it works on, as displayed to the user.
    pub title: String,
    /// Its progress, which also cancels and pauses it.
    pub progress: Arc<Progress>,
    /// When it started.
    pub started: Instant,
}

/// What a job may send.
#[cfg(not(target_arch = "wasm32"))]
pub trait JobOutput: Send + 'static {}

#[cfg(not(target_arch = "wasm32"))]
impl<T: Send + 'static> JobOutput for T {}

/// What a job may send. In a page long jobs have a memory of their own, from which results come as bytes.
#[cfg(target_arch = "wasm32")]
pub trait JobOutput: Send + 'static {
    /// A result as bytes.
    fn packed(&self) -> Vec<u8>;

    /// The result for these bytes, which need not be understood yet.
    fn arrived(bytes: Vec<u8>) -> Self;
}

impl JobKind {
    /// Whether it takes long in a page, where other jobs run at once while nothing else happens.
    #[cfg(target_arch = "wasm32")]
    fn is_long(self) -> bool {
        use JobKind::*;
        matches!(
            self,
            Autosave | FormFactors | Probe | Render | Solve | TaskPlane
        )
    }
}

/// A message from a job.
pub enum JobMessage<T> {
    /// A result; more may follow.
    Output(T),
    /// The job has ended, with an error message if it failed.
    Ended(Option<String>),
}

/// The sending end of a job's channel.
pub struct JobSender<T> {
    id: u64,
    sender: Sender<(u64, JobMessage<T>)>,
    repaint: RepaintRequest,
}

impl<T: JobOutput> JobSender<T> {
    /// Sends a result.
    pub fn send(&self, result: T) {
        self.post(JobMessage::Output(result));
    }

    fn post(&self, news: JobMessage<T>) {
        #[cfg(target_arch = "wasm32")]
        if platform::is_worker() {
            return platform::post(match news {
                JobMessage::Output(result) => platform::WorkerMessage::Output(result.packed()),
                JobMessage::Ended(why) => platform::WorkerMessage::Ended(why),
            });
        }
        // Nobody receives the message if the window has been closed.
        let _ = self.sender.send((self.id, news));
        (self.repaint)();
    }
}

/// While the camera moves, every frame requests another render: only one that is still wanted after this time
/// gets a worker and a copy of the memory.
#[cfg(target_arch = "wasm32")]
const START_DELAY: std::time::Duration = std::time::Duration::from_millis(60);

/// All running jobs.
pub struct Jobs<T> {
    running: Vec<Job>,
    sender: Sender<(u64, JobMessage<T>)>,
    receiver: Receiver<(u64, JobMessage<T>)>,
    repaint: RepaintRequest,
    next: u64,
}

impl<T: JobOutput> Default for Jobs<T> {
    fn default() -> Jobs<T> {
        Jobs::new(Arc::new(|| ()))
    }
}

impl<T: JobOutput> Jobs<T> {
    /// Creates an empty list.
    pub fn new(repaint: RepaintRequest) -> Jobs<T> {
        let (sender, receiver) = channel();
        Jobs {
            running: Vec::new(),
            sender,
            receiver,
            repaint,
            next: 0,
        }
    }

    /// Replaces the function that requests a repaint, for jobs started from now on.
    pub fn set_repaint(&mut self, repaint: RepaintRequest) {
        self.repaint = repaint;
    }

    /// Starts `work` in a thread of its own; returns its number. An error it returns is sent as a
    /// message.
    pub fn start(
        &mut self,
        kind: JobKind,
        title: impl Into<String>,
        work: impl FnOnce(&Progress, &JobSender<T>) -> Result<(), String> + Send + 'static,
    ) -> u64 {
        self.next += 1;
        let (id, progress) = (self.next, Arc::new(Progress::new()));
        let outbox = JobSender {
            id,
            sender: self.sender.clone(),
            repaint: Arc::clone(&self.repaint),
        };
        self.running.push(Job {
            id,
            kind,
            title: title.into(),
            progress: Arc::clone(&progress),
            started: Instant::now(),
        });
        #[cfg(target_arch = "wasm32")]
        let (shown, sender) = (Arc::clone(&progress), self.sender.clone());
        let run = move || {
            #[cfg(target_arch = "wasm32")]
            progress.observe(platform::report);
            let result = catch_unwind(AssertUnwindSafe(|| work(&progress, &outbox)));
            let end = match result {
                Ok(done) => done.err(),
                Err(panic) => Some(panic_message(&*panic)),
            };
            outbox.post(JobMessage::Ended(end));
        };
        #[cfg(not(target_arch = "wasm32"))]
        if let Err(error) = platform::start_thread(format!("{kind:?}"), run) {
            let message = format!("cannot start a thread: {error}");
            let _ = self.sender.send((id, JobMessage::Ended(Some(message))));
        }
        #[cfg(target_arch = "wasm32")]
        if kind.is_long() {
            let repaint = Arc::clone(&self.repaint);
            let listen = move |message| {
                let news = match message {
                    platform::WorkerMessage::Progress(report) => return report.show(&shown),
                    platform::WorkerMessage::Output(bytes) => JobMessage::Output(T::arrived(bytes)),
                    platform::WorkerMessage::Ended(why) => JobMessage::Ended(why),
                };
                let _ = sender.send((id, news));
                repaint();
            };
            platform::start_worker(id, START_DELAY, Box::new(run), listen);
        } else {
            run();
        }
        id
    }

    /// The next message, if there is one, with the job that sent it. Messages of cancelled jobs are
    /// dropped.
    pub fn next_message(&mut self) -> Option<(Job, JobMessage<T>)> {
        loop {
            let (id, news) = self.receiver.try_recv().ok()?;
            let Some(at) = self.running.iter().position(|j| j.id == id) else {
                continue;
            };
            let job = match news {
                JobMessage::Output(_) => self.running[at].clone(),
                JobMessage::Ended(_) => self.running.remove(at),
            };
            return Some((job, news));
        }
    }

    /// The jobs that have not ended, oldest first.
    pub fn running(&self) -> &[Job] {
        &self.running
    }

    /// The first job of a kind.
    pub fn of(&self, kind: JobKind) -> Option<&Job> {
        self.running.iter().find(|j| j.kind == kind)
    }

    /// Cancels a job; its further messages are dropped.
    pub fn cancel(&mut self, id: u64) {
        self.forget(|job| job.id == id);
    }

    /// Cancels all jobs of a kind.
    pub fn cancel_kind(&mut self, kind: JobKind) {
        self.forget(|job| job.kind == kind);
    }

    fn forget(&mut self, which: impl Fn(&Job) -> bool) {
        self.running.retain(|job| {
            let goes = which(job);
            if goes {
                job.progress.cancel();
                #[cfg(target_arch = "wasm32")]
                platform::end_worker(job.id);
            }
            !goes
        });
    }
}

impl<T> Drop for Jobs<T> {
    fn drop(&mut self) {
        self.running.iter().for_each(|job| job.progress.cancel());
    }
}

/// The message of a panic.
fn panic_message(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().copied();
    let text = text.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
    format!(
        "internal error: {}; please report it",
        text.unwrap_or("unknown")
    )
}

/// Runs `work` in a thread pool of its own, smaller than the number of processors: the window needs
/// one too, and paused workers must not block the global pool. The threads have a lower priority
/// than drawing, which may need all processors for a moment without a GPU.
pub fn in_thread_pool<R: Send>(most: usize, work: impl FnOnce() -> R + Send) -> R {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = match most {
        0 => processors.saturating_sub(1).max(1),
        most => most.min(processors),
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    match pool.start_handler(|_| platform::lower_priority()).build() {
        Ok(pool) => pool.install(work),
        Err(_) => work(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    fn wait<T: Send + 'static>(jobs: &mut Jobs<T>) -> (Job, JobMessage<T>) {
        let begin = Instant::now();
        loop {
            if let Some(message) = jobs.next_message() {
                return message;
            }
            assert!(begin.elapsed() < Duration::from_secs(60), "no news");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    #[test]
    fn what_is_found_arrives_in_order_and_then_the_end() {
        let mut jobs = Jobs::new(Arc::new(|| ()));
        jobs.start(JobKind::Load, "two", |_, out| {
            out.send(1);
            out.send(2);
            Ok(())
        });
        for expected in [1, 2] {
            assert!(matches!(wait(&mut jobs).1, JobMessage::Output(n) if n == expected));
        }
        assert!(matches!(wait(&mut jobs).1, JobMessage::Ended(None)));
        assert!(jobs.running().is_empty());
    }

    #[test]
    fn a_panic_is_a_failure_and_not_the_end_of_the_window() {
        let mut jobs = Jobs::<()>::new(Arc::new(|| ()));
        jobs.start(JobKind::Solve, "fault", |_, _| panic!("on purpose"));
        let (job, JobMessage::Ended(Some(why))) = wait(&mut jobs) else {
            unreachable!("it cannot end well")
        };
        assert_eq!(job.kind, JobKind::Solve);
        assert!(why.contains("on purpose"), "{why}");
    }

    #[test]
    fn a_cancelled_job_is_stopped_and_not_heard() {
        let mut jobs = Jobs::new(Arc::new(|| ()));
        let (tell, told) = channel();
        let id = jobs.start(JobKind::Solve, "endless", move |progress, out| {
            while progress.advance(1).is_ok() {
                std::thread::yield_now();
            }
            out.send(7);
            tell.send(()).map_err(|e| e.to_string())
        });
        jobs.cancel(id);
        told.recv_timeout(Duration::from_secs(60)).unwrap();
        std::thread::sleep(Duration::from_millis(20));
        assert!(jobs.next_message().is_none());
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn work_gives_way_to_what_draws() {
        let niceness = || {
            let status = std::fs::read_to_string("/proc/thread-self/stat").unwrap();
            // After the name in parentheses: state is the third field, niceness the nineteenth.
            let rest = status.rsplit(')').next().unwrap();
            rest.split_whitespace()
                .nth(16)
                .unwrap()
                .parse::<i32>()
                .unwrap()
        };
        let own = niceness();
        let theirs = in_thread_pool(1, niceness);
        assert!(theirs > own || own >= 5, "{theirs} {own}");
        assert_eq!(niceness(), own);
    }
}
