//! Ctrl-C: stops within a second and leaves no partial file.

use super::failure::Failure;
use azulejo::output;
use azulejo_trace::Progress;
use std::io::Write;
use std::sync::Arc;
use std::time::Duration;

/// Time for the work to stop in an orderly way before the process exits.
const PATIENCE: Duration = Duration::from_millis(700);

/// Makes SIGINT (Ctrl-C) and SIGTERM cancel `progress`.
///
/// Most work polls its progress and ends within milliseconds. Reading one very large file or
/// building its bounding volume hierarchy does not: then the drafts are removed and the process exits.
pub fn install(progress: Arc<Progress>) -> Result<(), Failure> {
    let on_interrupt = move || {
        progress.cancel();
        std::thread::sleep(PATIENCE);
        output::abandon_all();
        let _ = writeln!(std::io::stderr(), "\nerror: {}", Failure::Cancelled);
        std::process::exit(1);
    };
    ctrlc::set_handler(on_interrupt)
        .map_err(|e| Failure::failed(format_args!("cannot handle Ctrl-C: {e}")))
}
