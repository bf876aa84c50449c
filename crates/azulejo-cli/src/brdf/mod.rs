//! Reflection models: `brdf`.

mod args;
mod check;
mod eval;
mod fit;
mod list;
mod model;
mod plot;

pub use args::{BRDF_EXAMPLES, BrdfCommand};

use super::failure::Failure;
use super::session::Session;

/// Runs `brdf`.
pub fn run(command: &BrdfCommand, mut session: Session) -> Result<(), Failure> {
    match command {
        BrdfCommand::List(args) => {
            let report = list::run(args)?;
            session.print(report)
        }
        BrdfCommand::Eval(args) => {
            let report = eval::run(args, &mut session)?;
            session.print(report)
        }
        BrdfCommand::Check(args) => {
            let (report, end) = check::run(args, &mut session)?;
            session.print(report)?;
            end
        }
        BrdfCommand::Fit(args) => {
            let report = fit::run(args, &mut session)?;
            session.finish(report)
        }
        BrdfCommand::Plot(args) => {
            let report = plot::run(args, &mut session)?;
            session.finish(report)
        }
    }
}
