//! Tools for GRF files that people write: `grf`.

mod args;
mod diff;
mod fmt;
mod lint;

pub use args::{GRF_EXAMPLES, GrfCommand};

use super::failure::Failure;
use super::session::Session;

/// Runs `grf`.
pub fn run(command: &GrfCommand, mut session: Session) -> Result<(), Failure> {
    let (report, end) = match command {
        GrfCommand::Fmt(args) => fmt::run(args, &session)?,
        GrfCommand::Lint(args) => lint::run(args)?,
        GrfCommand::Diff(args) => {
            // As `diff` does: 1 is a difference, so 2 is trouble.
            let compared = diff::run(args, &mut session);
            compared.map_err(|failure| match failure {
                Failure::Failed(words) => Failure::Misuse(words),
                other => other,
            })?
        }
    };
    session.print(report)?;
    end
}
