//! What all commands share: general options, progress, warnings and output of the summary.

use super::clock::{self, Clock};
use super::failure::Failure;
use super::interrupt::{self, BlockEnd};
use super::progress_bar;
use super::report::{self, Report};
use azulejo::models::ModelOutput;
use azulejo_formats::{Format, Warning};
use azulejo_scene::Scene;
use azulejo_trace::{Measured, Progress};
use clap::Args;
use serde_json::{Value, json};
use std::fmt;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Options of every command.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "General")]
pub struct CommonArgs {
    /// Print one JSON object on standard output instead of text
    #[arg(long, global = true)]
    pub json: bool,
    /// Print errors only: no progress, warnings or summary
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Number of threads [default: one per processor core]
    #[arg(long, global = true, value_name = "N",
          value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

/// One run of one command.
#[derive(Debug)]
pub struct Session {
    json: bool,
    quiet: bool,
    progress: Arc<Progress>,
    block_end: Arc<BlockEnd>,
    memory: Option<u64>,
    clock: Clock,
    warnings: Vec<Value>,
    /// The warnings as text, for commands that list them in their result.
    listed: Option<Vec<String>>,
    formats: Vec<Format>,
    /// Models with the names of other files that were read for them.
    files: Vec<(PathBuf, Vec<String>)>,
    makes_image: bool,
}

/// How a process works: by itself, or as one of several.
#[derive(Debug)]
pub struct SessionSetup {
    /// Whether it says nothing, not even its result: another does.
    pub is_silent: bool,
    /// The progress of the work.
    pub progress: Arc<Progress>,
    /// How it ends after a block that is stored.
    pub block_end: Arc<BlockEnd>,
    /// Threads, if the command line does not say.
    pub threads: Option<usize>,
    /// Memory of the machine, bytes.
    pub memory: Option<u64>,
}

impl Default for SessionSetup {
    fn default() -> SessionSetup {
        SessionSetup {
            is_silent: false,
            progress: Arc::default(),
            block_end: Arc::default(),
            threads: None,
            memory: azulejo::machine::memory(),
        }
    }
}

impl Session {
    /// Starts the clock, sets up the threads and installs the handler of Ctrl-C.
    pub fn start(common: CommonArgs, setup: SessionSetup) -> Result<Session, Failure> {
        let SessionSetup {
            is_silent,
            progress,
            block_end,
            threads,
            memory,
        } = setup;
        let is_quiet = common.quiet || common.json || is_silent;
        interrupt::install(
            Arc::clone(&progress),
            Arc::clone(&block_end),
            is_quiet,
            is_silent,
        )?;
        let threads = common.threads.map(usize::from).or(threads);
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads.unwrap_or(0))
            .build_global()
            .map_err(|e| Failure::failed(format_args!("cannot start the threads: {e}")))?;
        Ok(Session {
            json: common.json && !is_silent,
            quiet: common.quiet || is_silent,
            progress,
            block_end,
            memory,
            clock: Clock::start(),
            warnings: Vec::new(),
            listed: None,
            formats: Vec::new(),
            files: Vec::new(),
            makes_image: false,
        })
    }

    /// Whether results are printed as JSON.
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
            let message = "--json and the output cannot both go to standard output";
            return Err(Failure::misuse(message));
        }
        Ok(())
    }

    /// The progress of the work, through which it is cancelled.
    pub fn progress(&self) -> &Progress {
        &self.progress
    }

    /// Ends refinement after `time` from now.
    pub fn limit_time(&self, time: Option<Duration>) {
        if let Some(end) = time.and_then(|t| Instant::now().checked_add(t)) {
            self.progress.set_deadline(end);
        }
    }

    /// Writes a scene atomically, and reports what the format cannot represent.
    pub fn write(&mut self, scene: &Scene, output: &ModelOutput) -> Result<(), Failure> {
        let losses = output.write(scene, &self.progress)?;
        if !losses.is_empty() {
            let (name, losses) = (output.format().name, losses.join(", "));
            self.note(&format!("{name} does not keep everything: {losses}"));
        }
        if let Some(open) = output.open_objects(scene) {
            self.note(&open);
        }
        Ok(())
    }

    /// Runs long work under a progress bar, if standard error is a terminal.
    pub fn with_progress<T>(&self, work: impl FnOnce(&Progress) -> T) -> T {
        if !self.quiet && io::stderr().is_terminal() {
            progress_bar::with_bar(&self.progress, work)
        } else {
            work(&self.progress)
        }
    }

    /// The same; prints what `words` says of the measures of the work as soon as they are taken.
    pub fn with_measures<T>(
        &self,
        words: &(dyn Fn(&Measured) -> Option<String> + Sync),
        work: impl FnOnce(&Progress) -> T,
    ) -> T {
        if self.quiet || self.json {
            return self.with_progress(work);
        }
        let has_bar = io::stderr().is_terminal();
        progress_bar::with_words(&self.progress, has_bar, words, work)
    }

    /// Reports what a reader skipped or repaired.
    pub fn warn(&mut self, warning: &Warning) {
        let value = json!({
            "file": warning.file,
            "position": warning.position.to_string().trim_start_matches(':').trim_start(),
            "message": warning.message,
            "count": warning.count,
        });
        self.record(value, warning);
    }

    /// Collects later warnings for [`listed`](Session::listed) instead of printing them.
    pub fn list_warnings(&mut self) {
        self.listed = Some(Vec::new());
    }

    /// The collected warnings.
    pub fn listed(&self) -> &[String] {
        self.listed.as_deref().unwrap_or_default()
    }

    /// Declares that the command makes an image, for which `--up` may be a direction.
    pub fn set_makes_image(&mut self) {
        self.makes_image = true;
    }

    /// Whether the command makes an image.
    pub fn makes_image(&self) -> bool {
        self.makes_image
    }

    /// Seconds of processors that this process took so far.
    pub fn cpu_seconds(&self) -> f64 {
        self.clock.cpu()
    }

    /// Memory of the machine, bytes; where several processes share the work, of that of the first.
    pub fn memory(&self) -> Option<u64> {
        self.memory
    }

    /// How the work ends after a block that is stored.
    pub fn block_end(&self) -> Arc<BlockEnd> {
        Arc::clone(&self.block_end)
    }

    /// Records the format of a model.
    pub fn has_read(&mut self, format: Format) {
        self.formats.push(format);
    }

    /// Records the files that were read for a model, by their names relative to its folder.
    pub fn has_read_files(&mut self, model: &Path, files: Vec<String>) {
        self.files.push((model.to_owned(), files));
    }

    /// The models that were read, each with the names of the files read for it.
    pub fn files(&self) -> &[(PathBuf, Vec<String>)] {
        &self.files
    }

    /// The formats of the models that were read, in their order.
    pub fn formats(&self) -> &[Format] {
        &self.formats
    }

    /// Prints a message on the state of the work.
    pub fn say(&self, message: &str) {
        if !self.json && !self.quiet {
            let _ = writeln!(io::stderr(), "{message}");
        }
    }

    /// Reports a warning that does not concern a file.
    pub fn note(&mut self, message: &str) {
        self.record(json!({ "message": message, "count": 1 }), message);
    }

    /// Prints a message on completed work, unless there is a progress bar.
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
            // Standard error may be closed; that is no reason to fail.
            let _ = writeln!(io::stderr(), "warning: {words}");
        }
    }

    /// Ends a command whose result is a file: the summary goes to standard error, because the
    /// result may go to standard output.
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

    /// Ends a command whose result is the report.
    pub fn print(self, mut report: Report) -> Result<(), Failure> {
        if self.json {
            self.costs(&mut report);
            return self.print_json(report);
        }
        let mut out = io::stdout().lock();
        report.write_lines(&mut out)?;
        Ok(out.flush()?)
    }

    /// Adds time and memory of the run.
    fn costs(&self, report: &mut Report) {
        let (wall, cpu) = (self.clock.wall(), self.clock.cpu());
        let threads = rayon::current_num_threads();
        let mut words = format!(
            "{}, {} of CPU time on {threads} thread{}",
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
