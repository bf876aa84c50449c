//! `merge`: the result of a command from the parts that its shards computed.

use super::MergedParts;
use super::command::{self, FoundFiles};
use super::header::PartHeader;
use crate::args::Command;
use crate::failure::Failure;
use crate::report::Report;
use crate::session::Session;
use crate::{bake, form_factors, probe, solve};
use clap::{Args, ValueHint};
use std::fs::File;
use std::path::{Path, PathBuf};

/// `merge`
#[derive(Debug, Args)]
pub struct MergeArgs {
    /// The parts: what each run of the command with --shard wrote
    #[arg(value_name = "PART", required = true, value_hint = ValueHint::FilePath)]
    pub parts: Vec<PathBuf>,
    /// Output file: whatever -o of the command may be without --shard
    #[arg(long, short, value_name = "FILE", value_hint = ValueHint::FilePath, required_unless_present = "lightmap")]
    pub output: Option<PathBuf>,
    /// With parts of `bake`, write the irradiance as OpenEXR, as its --lightmap does
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub lightmap: Option<PathBuf>,
    /// With parts of `bake`, write the standard error of the irradiance, likewise
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub error_map: Option<PathBuf>,
    /// Folder in which the model, and other files that the command names, are now, if not where
    /// they were when the parts were computed. Their content has to be the same
    #[arg(long, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    pub files: Option<PathBuf>,
}

/// Examples and notes below the help.
pub const EXAMPLES: &str = "\
Examples:
  azulejo form-factors room.obj --patches 20000 --shard 1/2 -o part-1
  azulejo form-factors room.obj --patches 20000 --shard 2/2 -o part-2
  azulejo merge part-1 part-2 -o f.npz
  azulejo merge parts/* -o f.npz --files models
  azulejo merge parts/* -o lit.glb --lightmap E.exr

Parts can be computed in any order, on any machines, by any number of threads: the result has the same
bytes as that of the command without --shard. merge runs the command that the parts record, with their
blocks instead of computing them, so it needs the model too. docs/shards.md has scripts for queues.";

impl MergeArgs {
    /// The pictures of a lightmap that are written.
    fn maps(&self) -> impl Iterator<Item = &PathBuf> {
        self.lightmap.iter().chain(&self.error_map)
    }

    /// All files that are written.
    fn outputs(&self) -> impl Iterator<Item = &PathBuf> {
        self.output.iter().chain(self.maps())
    }
}

/// Runs `merge`.
pub fn run(args: &MergeArgs, session: &mut Session) -> Result<Report, Failure> {
    for output in args.outputs() {
        refuse_part(output)?;
    }
    session.progress().begin("reading parts", 0);
    let mut notes = Vec::new();
    let parts = MergedParts::read(&args.parts, &mut notes)?;
    notes.iter().for_each(|note| session.note(note));
    let header = parts.header();
    let found = FoundFiles::find(&header.files, &header.folder, args.files.as_deref())?;
    if let Some(output) = args.outputs().find(|output| found.has(output)) {
        return Err(Failure::misuse(format_args!(
            "{} is a file that the parts were computed from: write to another",
            output.display()
        )));
    }
    let mut command = command::parsed(&header.command)?.command;
    let Some(sharded) = command::sharded(&mut command) else {
        return Err(no_command(header));
    };
    *sharded.shard = None;
    match (sharded.maps, args.maps().next()) {
        (Some([lightmap, error_map]), _) => {
            lightmap.clone_from(&args.lightmap);
            error_map.clone_from(&args.error_map);
        }
        (None, Some(_)) => {
            return Err(Failure::misuse(format_args!(
                "--lightmap and --error-map are for parts of bake, and these are of {}",
                sharded.name
            )));
        }
        (None, None) => {}
    }
    sharded.output.set(args.output.as_deref())?;
    found.set(sharded.files);
    session.say(&format!(
        "merging {} parts of {}",
        parts.count(),
        sharded.name
    ));
    let report = match &command {
        Command::FormFactors(args) => form_factors::run_merged(args, &parts, session)?,
        Command::Probe(args) => probe::run_merged(args, &parts, session)?,
        Command::Solve(args) => solve::run_merged(args, &parts, session)?,
        Command::Bake(args) => bake::run_merged(args, &parts, session)?,
        _ => return Err(no_command(header)),
    };
    if parts.added() > 0 {
        session.note(&format!(
            "{} blocks were in no part and were computed now",
            parts.added()
        ));
    }
    Ok(report)
}

fn no_command(header: &PartHeader) -> Failure {
    let line = header.line();
    Failure::failed(format_args!(
        "the parts record a command that has no --shard: {line}"
    ))
}

/// Refuses to write over a part.
fn refuse_part(output: &Path) -> Result<(), Failure> {
    let is_part = File::open(output).is_ok_and(|mut file| {
        file.metadata().is_ok_and(|m| m.is_file() && m.len() > 0)
            && PartHeader::read(&mut file, output).is_ok()
    });
    if is_part {
        return Err(Failure::misuse(format_args!(
            "{} is a part: give another file for the result",
            output.display()
        )));
    }
    Ok(())
}
