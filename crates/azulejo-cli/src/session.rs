//! What every command works with: switches, progress, warnings, and how it speaks.

use super::args::CommonArgs;
use super::clock::{self, Clock};
use super::failure::Failure;
use super::report::{self, Report};
use super::{interrupt, progress_bar};
use azulejo::models::ModelOutput;
use azulejo_formats::{Format, Warning};
use azulejo_scene::Scene;
use azulejo_trace::Progress;
use serde_json::{Value, json};
use std::fmt;
use std::io::{self, IsTerminal, Write};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// One run of one command.
#[derive(Debug)]
pub struct Session {
    json: bool,
    quiet: bool,
    progress: Arc<Progress>,
    clock: Clock,
    warnings: Vec<Value>,
    /// Warnings in words, where a command lists them in its result.
    listed: Option<Vec<String>>,
    formats: Vec<Format>,
    makes_picture: bool,
}

impl Session {
    /// Starts the clocks, sets up the threads and listens for Ctrl-C.
    pub fn start(common: CommonArgs) -> Result<Session, Failure> {
        let progress = Arc::new(Progress::new());
        interrupt::install(Arc::clone(&progress))?;
        rayon::ThreadPoolBuilder::new()
            .num_threads(common.threads.map_or(0, usize::from))
            .build_global()
            .map_err(|e| Failure::failed(format_args!("cannot start the threads: {e}")))?;
        Ok(Session {
            json: common.json,
            quiet: common.quiet,
            progress,
            clock: Clock::start(),
            warnings: Vec::new(),
            listed: None,
            formats: Vec::new(),
            makes_picture: false,
        })
    }

    /// Whether results are for machines.
    pub fn json(&self) -> bool {
        self.json
    }

    /// Whether only errors and results are printed.
    pub fn quiet(&self) -> bool {
        self.quiet
    }

    /// Refuses to mix a result with JSON when both would go to standard output.
    pub fn claim_stdout(&self, result_goes_there: bool) -> Result<(), Failure> {
        if self.json && result_goes_there {
            let message = "both --json and the output would go to standard output";
            return Err(Failure::misuse(message));
        }
        Ok(())
    }

    /// Counts and stops the work.
    pub fn progress(&self) -> &Progress {
        &self.progress
    }

    /// Lets refinement end after `time`, counted from now.
    pub fn limit_time(&self, time: Option<Duration>) {
        if let Some(end) = time.and_then(|t| Instant::now().checked_add(t)) {
            self.progress.set_deadline(end);
        }
    }

    /// Writes a scene whole or not at all; says what of it the format does not keep.
    pub fn write(&mut self, scene: &Scene, output: &ModelOutput) -> Result<(), Failure> {
        let losses = output.write(scene, &self.progress)?;
        if !losses.is_empty() {
            let (name, losses) = (output.format().name, losses.join(", "));
            self.note(&format!("{name} does not keep all: {losses}"));
        }
        Ok(())
    }

    /// Does long work under a progress bar, if a person is watching.
    pub fn with_progress<T>(&self, work: impl FnOnce(&Progress) -> T) -> T {
        if !self.quiet && io::stderr().is_terminal() {
            progress_bar::with_bar(&self.progress, work)
        } else {
            work(&self.progress)
        }
    }

    /// Says once what a reader skipped or mended.
    pub fn warn(&mut self, warning: &Warning) {
        let value = json!({
            "file": warning.file,
            "position": warning.position.to_string().trim_start_matches(':').trim_start(),
            "message": warning.message,
            "count": warning.count,
        });
        self.record(value, warning);
    }

    /// From now on keeps warnings for [`listed`](Session::listed) instead of printing them.
    pub fn list_warnings(&mut self) {
        self.listed = Some(Vec::new());
    }

    /// The warnings that were kept.
    pub fn listed(&self) -> &[String] {
        self.listed.as_deref().unwrap_or_default()
    }

    /// Says that the command makes a picture, in which a direction may be up.
    pub fn set_makes_picture(&mut self) {
        self.makes_picture = true;
    }

    /// Whether the command makes a picture.
    pub fn makes_picture(&self) -> bool {
        self.makes_picture
    }

    /// Remembers the format of a model.
    pub fn has_read(&mut self, format: Format) {
        self.formats.push(format);
    }

    /// The formats of the models that were read, in their order.
    pub fn formats(&self) -> &[Format] {
        &self.formats
    }

    /// Says to people how the work stands, while it goes on.
    pub fn say(&self, message: &str) {
        if !self.json && !self.quiet {
            let _ = writeln!(io::stderr(), "{message}");
        }
    }

    /// Says something about the run that no file is to blame for.
    pub fn note(&mut self, message: &str) {
        self.record(json!({ "message": message, "count": 1 }), message);
    }

    /// Says what was done, where no progress bar says it.
    pub fn tell(&self, words: &str) {
        if !self.json && !self.quiet && !io::stderr().is_terminal() {
            let _ = writeln!(io::stderr(), "{words}");
        }
    }

    fn record(&mut self, value: Value, words: impl fmt::Display) {
        self.warnings.push(value);
        if let Some(listed) = &mut self.listed {
            listed.push(words.to_string());
            return;
        }
        if !self.json && !self.quiet {
            // Standard error may be closed; a warning is not worth failing for.
            let _ = writeln!(io::stderr(), "warning: {words}");
        }
    }

    /// Ends a command whose result is a file: the summary goes to standard error, where it
    /// cannot mix with the result.
    pub fn finish(self, mut report: Report) -> Result<(), Failure> {
        self.costs(&mut report);
        if self.json {
            return self.print_json(report);
        }
        if !self.quiet {
            let _ = report.write_lines(&mut io::stderr());
        }
        Ok(())
    }

    /// Ends a command whose result is what it prints.
    pub fn print(self, mut report: Report) -> Result<(), Failure> {
        if self.json {
            self.costs(&mut report);
            return self.print_json(report);
        }
        let mut out = io::stdout().lock();
        report.write_lines(&mut out)?;
        Ok(out.flush()?)
    }

    /// What the whole run has cost so far.
    fn costs(&self, report: &mut Report) {
        let (wall, cpu) = (self.clock.wall(), self.clock.cpu());
        let threads = rayon::current_num_threads();
        let mut words = format!(
            "{}, {} of processor time on {threads} thread{}",
            report::seconds(wall),
            report::seconds(cpu),
            if threads == 1 { "" } else { "s" }
        );
        if let Some(peak) = clock::peak_memory() {
            words += &format!(", {} of memory", report::bytes(peak));
            report.value("peak_memory_bytes", peak);
        }
        report.line("time", words);
        report.value("wall_seconds", report::number(wall));
        report.value("cpu_seconds", report::number(cpu));
        report.value("threads", threads);
    }

    fn print_json(mut self, mut report: Report) -> Result<(), Failure> {
        report.value("warnings", std::mem::take(&mut self.warnings));
        let mut out = io::stdout().lock();
        report.write_json(&mut out)?;
        Ok(out.flush()?)
    }
}
