//! The command line of azulejo, as a library: [`main`] is the program, [`parsers`] are the parsers
//! of its input files.
//!
//! `cli` is the parser of the whole program and knows all commands. One module per command defines its
//! options and interprets them; the libraries below do the work.

mod bake;
mod brdf;
mod camera;
mod charts;
mod child;
mod cli;
mod clock;
mod content_key;
mod convert;
mod draft_list;
mod drawing;
mod engine;
mod exchange;
mod experiment;
mod failure;
mod first_pass;
mod form_factors;
mod grf;
mod info;
mod input;
mod interrupt;
mod inventory;
mod known;
mod lettering;
mod luminaires;
mod machine_info;
mod matrix_info;
mod matrix_metrics;
mod model_table;
mod parts;
mod pass;
mod placement;
mod points;
mod probe;
mod progress_bar;
mod render;
mod report;
mod runner;
mod session;
mod solve;
mod surroundings;
mod validate;
mod values;
mod workbench;

pub use cli::main;

/// Parsers of input other than models, public for tests and fuzzing.
pub mod parsers {
    pub use crate::experiment::parse_suite;
    pub use crate::points::{parse_points, parse_rays};
    pub use azulejo_formats::numpy::npy::{Array, read as parse_npy};

    /// The definition of the command line.
    #[must_use]
    pub fn command_line() -> clap::Command {
        <crate::cli::Cli as clap::CommandFactory>::command()
    }
}
