//! Solids from text and drawings: `text`, `font` and `extrude`.

mod args;
mod extrude;
mod font;
mod ink;
mod sheet;
mod solid;
mod text;
mod typeface;
mod values;

pub use args::{
    EXTRUDE_EXAMPLES, ExtrudeArgs, FONT_EXAMPLES, FontCommand, TEXT_EXAMPLES, TextArgs,
};

use super::failure::Failure;
use super::report::Report;
use super::session::Session;

/// Runs `text`.
pub fn run_text(args: &TextArgs, session: &mut Session) -> Result<Report, Failure> {
    text::run(args, session)
}

/// Runs `font`.
pub fn run_font(command: &FontCommand, session: &mut Session) -> Result<Report, Failure> {
    match command {
        FontCommand::Convert(args) => font::run(args, session),
        FontCommand::Sheet(args) => sheet::run(args, session),
    }
}

/// Runs `extrude`.
pub fn run_extrude(args: &ExtrudeArgs, session: &mut Session) -> Result<Report, Failure> {
    extrude::run(args, session)
}
