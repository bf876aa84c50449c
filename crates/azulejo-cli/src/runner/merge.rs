//! `merge`: the result of a command from the parts that its shards computed.

use super::Runner;
use super::command::{self, FoundFiles};
use super::header::PartHeader;
use super::merged::MergedParts;
use crate::args::Command;
use crate::failure::Failure;
use crate::session::Session;
use crate::shard::MergeArgs;
use std::fs::File;
use std::path::Path;

/// A command whose work was done in parts.
pub struct MergePlan {
    parts: MergedParts,
    /// The command, with its files where they are now and the output of the merge.
    pub command: Command,
}

impl MergePlan {
    /// The parts compute its work.
    pub fn runner(&self) -> Runner<'_> {
        Runner::merged(&self.parts)
    }

    /// The result is written.
    pub fn finish(&self, session: &mut Session) {
        if self.parts.added() > 0 {
            session.note(&format!(
                "{} blocks were in no part and were computed now",
                self.parts.added()
            ));
        }
    }
}

/// Reads the parts of `merge`, and finds the files of the command that they record.
///
/// # Errors
/// Parts or files are missing, or do not fit together.
pub fn plan(args: &MergeArgs, session: &mut Session) -> Result<MergePlan, Failure> {
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
    Ok(MergePlan { parts, command })
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
