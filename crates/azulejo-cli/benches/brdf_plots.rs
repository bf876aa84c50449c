//! What `azulejo brdf plot` costs for each reflection model.
//!
//! `cargo bench -p azulejo-cli --bench brdf_plots -- [part of a name]`: CPU seconds of the whole process, user and
//! system, for the first example of each model.
#![allow(clippy::print_stdout, reason = "printing is what a benchmark is for")]

use azulejo_scene::brdf::MODELS;
use nix::sys::resource::{UsageWho, getrusage};
use nix::sys::time::TimeValLike;
use std::process::{Command, Stdio};

fn main() {
    let filter = std::env::args().skip(1).find(|word| !word.starts_with('-'));
    for text in MODELS.iter().map(|model| model.examples[0]) {
        if filter.as_ref().is_none_or(|w| text.contains(w.as_str())) {
            println!("{:6.2}  {text}", plotted_in(text));
        }
    }
}

/// CPU seconds of a plot.
fn plotted_in(text: &str) -> f64 {
    let picture = std::env::temp_dir().join(format!("azulejo-plot-{}.png", std::process::id()));
    let before = children_seconds();
    let status = Command::new(env!("CARGO_BIN_EXE_azulejo"))
        .args(["brdf", "plot", text, "--quiet", "-o"])
        .arg(&picture)
        .stdin(Stdio::null())
        .status();
    let took = children_seconds() - before;
    assert!(status.is_ok_and(|s| s.success()), "{text}");
    let _ = std::fs::remove_file(picture);
    took
}

/// CPU seconds of processes that have ended.
fn children_seconds() -> f64 {
    let usage = getrusage(UsageWho::RUSAGE_CHILDREN).expect("the system counts");
    let [user, system] = [usage.user_time(), usage.system_time()];
    1e-6 * (user + system).num_microseconds() as f64
}
