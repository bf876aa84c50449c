//! Ctrl-C: stops within a second and leaves no partial file; work that is kept block by block finishes
//! its block first.

use super::failure::Failure;
use azulejo::output;
use azulejo_trace::Progress;
use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Time for the work to stop in an orderly way before the process exits.
const PATIENCE: Duration = Duration::from_millis(700);

/// Whether a block is in work that is worth finishing, and whether the work is to end behind it.
#[derive(Debug, Default)]
pub struct BlockEnd {
    is_in_block: AtomicBool,
    is_asked: AtomicBool,
}

impl BlockEnd {
    /// Says whether a block is in work.
    pub fn set_in_block(&self, is_in_block: bool) {
        self.is_in_block.store(is_in_block, Ordering::Relaxed);
    }

    /// Whether the work is to end behind its block.
    pub fn is_asked(&self) -> bool {
        self.is_asked.load(Ordering::Relaxed)
    }

    /// Asks for it, once; whether there is a block to wait for.
    fn ask(&self) -> bool {
        self.is_in_block.load(Ordering::Relaxed) && !self.is_asked.swap(true, Ordering::Relaxed)
    }
}

/// Makes SIGINT (Ctrl-C) and SIGTERM cancel `progress`, or end the work behind its block.
///
/// Most work polls its progress and ends within milliseconds. Reading one very large file or
/// building its bounding volume hierarchy does not: then the drafts are removed and the process exits.
/// A second signal does not wait for the block any more.
pub fn install(
    progress: Arc<Progress>,
    block_end: Arc<BlockEnd>,
    is_quiet: bool,
    is_silent: bool,
) -> Result<(), Failure> {
    let on_interrupt = move || {
        if block_end.ask() {
            if !is_quiet {
                let words = "finishing the block in work; a second signal does not wait for it";
                let _ = writeln!(std::io::stderr(), "\n{words}");
            }
            return;
        }
        progress.cancel();
        std::thread::sleep(PATIENCE);
        output::abandon_all();
        // Of several processes, one says it.
        if !is_silent {
            let _ = writeln!(std::io::stderr(), "\nerror: {}", Failure::Cancelled);
        }
        std::process::exit(1);
    };
    ctrlc::set_handler(on_interrupt)
        .map_err(|e| Failure::failed(format_args!("cannot handle Ctrl-C: {e}")))
}
