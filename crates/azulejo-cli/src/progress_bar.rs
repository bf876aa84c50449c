//! The progress bar on terminals: stage, share done, rate, remaining time.

use azulejo_trace::Progress;
use indicatif::{ProgressBar, ProgressStyle};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

/// Interval at which the bar is redrawn.
const FRAME: Duration = Duration::from_millis(100);

const TEMPLATE: &str = "{msg:>16} [{bar:30}] {percent:>3}%  {per_sec}, {eta} left";

/// Runs `work` while another thread draws the progress bar.
pub fn with_bar<T>(progress: &Progress, work: impl FnOnce(&Progress) -> T) -> T {
    let finished = AtomicBool::new(false);
    thread::scope(|scope| {
        let painter = scope.spawn(|| paint(progress, &finished));
        // Also dropped if the work panics: otherwise the scope would wait for the painter forever.
        let _finish = StopOnDrop {
            finished: &finished,
            painter: painter.thread().clone(),
        };
        work(progress)
    })
}

struct StopOnDrop<'a> {
    finished: &'a AtomicBool,
    painter: thread::Thread,
}

impl Drop for StopOnDrop<'_> {
    fn drop(&mut self) {
        self.finished.store(true, Ordering::Relaxed);
        self.painter.unpark();
    }
}

fn paint(progress: &Progress, finished: &AtomicBool) {
    let bar = ProgressBar::new(0);
    if let Ok(style) = ProgressStyle::with_template(TEMPLATE) {
        bar.set_style(style.progress_chars("=> "));
    }
    let mut stage = String::new();
    while !finished.load(Ordering::Relaxed) {
        let now = progress.stage();
        if now != stage {
            // A new stage has its own rate; the old one would distort the estimate.
            bar.reset();
            bar.set_message(now.clone());
            stage = now;
        }
        if !stage.is_empty() {
            bar.set_length(progress.total());
            bar.set_position(progress.done());
        }
        thread::park_timeout(FRAME);
    }
    bar.finish_and_clear();
}
