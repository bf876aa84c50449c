//! Whether results stay the same when a scene is written in another way: random scenes, commands and changes.
//!
//! `cargo bench -p azulejo-cli --bench poses -- 300 --seed 7` runs 300 poses; docs/validation.md tells what they are and
//! what they found. One that failed is run alone, and its files kept, by
//! `-- --seed 7 --pose 41`, or by names: `-- --pose cube:probe:motion+format`.
#![allow(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "printing is what a benchmark is for"
)]

// Its own tests are among those of the command.
#[allow(dead_code, unused_imports)]
#[path = "pose/mod.rs"]
mod pose;

use clap::Parser;
use pose::{PoseChoice, PoseCounts, PoseOutcome, PoseRecord, csv_heading, tables};
use std::error::Error;
use std::fs::{self, File};
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Probability that a normal variable is beyond five standard deviations.
const CHANCE: f64 = 5.73e-7;

/// Compares the results of random scenes and commands with those of the same scenes in another place, unit, order,
/// division or file format.
#[derive(Debug, Parser)]
struct Arguments {
    /// How many poses
    #[arg(default_value_t = 100)]
    count: u64,
    /// Seed of all that is random
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Of those drawn, only the ones that have this in SCENE:COMMAND:CHANGES
    #[arg(long)]
    only: Option<String>,
    /// Only this pose: its number, or SCENE:COMMAND:CHANGE+CHANGE. May be given several times
    #[arg(long)]
    pose: Vec<String>,
    /// Folder of poses.csv, and of the files of each --pose
    #[arg(long, short, default_value = concat!(env!("CARGO_TARGET_TMPDIR"), "/poses"))]
    output: PathBuf,
    /// What cargo adds
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let arguments = Arguments::parse();
    let folder = arguments.output.join("runs");
    fs::create_dir_all(&folder)?;
    let choice = PoseChoice {
        seed: arguments.seed,
        count: arguments.count,
        only: arguments.only,
        named: arguments.pose,
        folder,
        has_corpus: true,
    };
    // Lines are written as they come, so that those of a run that is stopped stay.
    let mut csv = File::create(arguments.output.join("poses.csv"))?;
    csv.write_all(csv_heading().as_bytes())?;
    let (mut records, mut written) = (Vec::new(), Ok(()));
    pose::run(&choice, &mut |record| {
        if record.outcome != PoseOutcome::Right {
            eprintln!("{}", sentence(&record));
        }
        let line = csv.write_all(record.csv_line().as_bytes());
        written = std::mem::replace(&mut written, Ok(())).and(line);
        records.push(record);
    })?;
    written?;
    // Those of thousands of poses take gigabytes.
    if choice.named.is_empty() {
        fs::remove_dir_all(&choice.folder)?;
    }
    tables(&records).iter().for_each(|line| println!("{line}"));
    let counts = PoseCounts::of(&records);
    println!(
        "\n{} poses: {} right, {} off, {} unfinished, in {}",
        counts.run,
        counts.right,
        counts.off,
        counts.unfinished,
        arguments.output.join("poses.csv").display()
    );
    let expected = records.iter().map(|r| r.quantities as f64).sum::<f64>() * CHANCE;
    let is_chance = counts.failures() as f64 <= expected + 3.0 * expected.sqrt();
    Ok(ExitCode::from(u8::from(!is_chance)))
}

fn sentence(record: &PoseRecord) -> String {
    format!(
        "pose {}: {}: {}: {}: {}",
        record.key, record.scene, record.command, record.words, record.problem
    )
}
