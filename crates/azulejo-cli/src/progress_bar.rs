//! The progress bar on terminals: stage, share done, rate, remaining time.

use azulejo_trace::{Measured, Progress};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

/// Interval at which the bar is redrawn.
const FRAME: Duration = Duration::from_millis(100);

const TEMPLATE: &str = "{msg:>16} [{bar:30}] {percent:>3}%  {per_sec}, {eta} left";

/// What to say of a measure, if anything.
type Words<'a> = &'a (dyn Fn(&Measured) -> Option<String> + Sync);

/// Runs `work` while another thread draws the progress bar.
pub fn with_bar<T>(progress: &Progress, work: impl FnOnce(&Progress) -> T) -> T {
    with_words(progress, true, &|_| None, work)
}

/// Runs `work` while another thread prints what there is to say of its measures, and draws the
/// progress bar if there shall be one.
pub fn with_words<T>(
    progress: &Progress,
    has_bar: bool,
    words: Words,
    work: impl FnOnce(&Progress) -> T,
) -> T {
    let finished = AtomicBool::new(false);
    thread::scope(|scope| {
        let painter = scope.spawn(|| paint(progress, &finished, has_bar, words));
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

fn paint(progress: &Progress, finished: &AtomicBool, has_bar: bool, words: Words) {
    let bar = if has_bar {
        ProgressBar::new(0)
    } else {
        ProgressBar::hidden()
    };
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
        say(progress, &bar, words);
        thread::park_timeout(FRAME);
    }
    bar.finish_and_clear();
    say(progress, &bar, words);
}

/// Prints what there is to say of the measures since the last call.
fn say(progress: &Progress, bar: &ProgressBar, words: Words) {
    for line in progress.take_measures().iter().filter_map(words) {
        bar.suspend(|| {
            // Standard error may be closed; that is no reason to fail.
            let _ = writeln!(io::stderr(), "{line}");
        });
    }
}
