//! Ctrl-C: stops within a second and leaves no half file.

use super::failure::Failure;
use azulejo::output;
use azulejo_trace::Progress;
use std::io::Write;
use std::sync::Arc;
use std::time::Duration;

/// How long the work may take to stop by itself before the process is ended under it.
const PATIENCE: Duration = Duration::from_millis(700);

/// Makes Ctrl-C (and a polite request to terminate) cancel `progress`.
///
/// Most work polls its progress and ends in good order within milliseconds. Reading one huge
/// file or building one huge tree may not: then the drafts are removed and the process ends.
pub fn install(progress: Arc<Progress>) -> Result<(), Failure> {
    let on_interrupt = move || {
        progress.cancel();
        std::thread::sleep(PATIENCE);
        output::abandon_all();
        let _ = writeln!(std::io::stderr(), "\nerror: {}", Failure::Cancelled);
        std::process::exit(1);
    };
    ctrlc::set_handler(on_interrupt)
        .map_err(|e| Failure::failed(format_args!("cannot listen for Ctrl-C: {e}")))
}
