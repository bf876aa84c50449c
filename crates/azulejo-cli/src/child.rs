//! Child processes: what they print, within a time limit, and their end if the work is cancelled.

use crate::failure::Failure;
use crate::report::seconds;
use azulejo_trace::Progress;
use std::io::Read;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Interval at which a child is polled.
const POLL: Duration = Duration::from_millis(20);

/// Runs a command without input, and returns what it prints or the reason of its failure. It is killed if the work is
/// cancelled or the time limit is exceeded.
///
/// # Errors
/// It cannot be started, or the work was cancelled.
pub fn output(
    command: &mut Command,
    limit: Option<Duration>,
    progress: &Progress,
) -> Result<Result<String, String>, Failure> {
    let command = command.stdin(Stdio::null());
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = child.spawn();
    let child = child.map_err(|e| Failure::failed(format_args!("cannot start a process: {e}")))?;
    let mut child = KillOnDrop(child);
    // Pipes are drained meanwhile, otherwise a child that prints much would block forever.
    let stdout = child.0.stdout.take().map(drain);
    let stderr = child.0.stderr.take().map(drain);
    let text = |pipe: Option<std::thread::JoinHandle<String>>| {
        pipe.and_then(|p| p.join().ok()).unwrap_or_default()
    };
    let start = Instant::now();
    loop {
        progress.advance(0)?;
        let status = child.0.try_wait();
        let status =
            status.map_err(|e| Failure::failed(format_args!("cannot wait for a process: {e}")))?;
        match status {
            Some(status) if status.success() => return Ok(Ok(text(stdout))),
            Some(status) => {
                let messages = text(stderr);
                let last = messages.lines().rev().find(|l| !l.trim().is_empty());
                let reason = last.map(|l| l.trim_start_matches("error: ").to_owned());
                return Ok(Err(reason.unwrap_or_else(|| status.to_string())));
            }
            None if limit.is_some_and(|l| start.elapsed() > l) => {
                let limit = limit.unwrap_or_default().as_secs_f64();
                return Ok(Err(format!("took longer than {}", seconds(limit))));
            }
            None => std::thread::sleep(POLL),
        }
    }
}

/// A child process that is killed when dropped.
struct KillOnDrop(Child);

impl Drop for KillOnDrop {
    fn drop(&mut self) {
        // It may have exited already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Reads a pipe to its end in a thread.
fn drain(mut pipe: impl Read + Send + 'static) -> std::thread::JoinHandle<String> {
    std::thread::spawn(move || {
        let mut bytes = Vec::new();
        let _ = pipe.read_to_end(&mut bytes);
        String::from_utf8_lossy(&bytes).into_owned()
    })
}
