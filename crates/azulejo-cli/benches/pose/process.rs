//! Runs of the program, as users start it, with a time limit.

use std::fs::File;
use std::io;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// How a run ended.
#[derive(Clone, Debug)]
pub enum RunEnd {
    /// With success: what it printed on standard output.
    Done(String),
    /// With an error: its last lines.
    Refused(String),
    /// Not within the time, so that it was stopped.
    Unfinished,
}

/// How often a run is looked at.
const POLL: Duration = Duration::from_millis(5);

/// Longest part of an error that is kept, characters.
const WORDS: usize = 300;

/// Runs the program with these arguments in a folder, which keeps both streams.
pub fn run(folder: &Path, arguments: &[String], limit: Duration) -> io::Result<RunEnd> {
    let (out, err) = (folder.join("stdout"), folder.join("stderr"));
    let mut child = Command::new(env!("CARGO_BIN_EXE_azulejo"))
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(File::create(&out)?)
        .stderr(File::create(&err)?)
        .spawn()?;
    let Some(is_success) = wait(&mut child, limit)? else {
        return Ok(RunEnd::Unfinished);
    };
    let text = |path: &Path| {
        Ok::<_, io::Error>(String::from_utf8_lossy(&std::fs::read(path)?).into_owned())
    };
    if is_success {
        return Ok(RunEnd::Done(text(&out)?));
    }
    let words = text(&err)?;
    let start = words.chars().count().saturating_sub(WORDS);
    let words: String = words.chars().skip(start).collect();
    Ok(RunEnd::Refused(words.trim().replace('\n', "; ")))
}

/// Whether it succeeded; `None` if it had to be stopped.
fn wait(child: &mut Child, limit: Duration) -> io::Result<Option<bool>> {
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status.success()));
        }
        if start.elapsed() > limit {
            // It may have ended meanwhile, which is no reason to fail.
            let _ = child.kill();
            child.wait()?;
            return Ok(None);
        }
        std::thread::sleep(POLL);
    }
}
