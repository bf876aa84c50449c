//! Commands whose work is divided: what of their arguments is about shards, outputs and files, and how one that
//! a part records is run again.

use super::{Cli, Command};
use crate::content_key::shown;
use crate::failure::Failure;
use crate::parts::{MergeArgs, Shard};
use crate::runner::merge::MergePlan;
use crate::runner::{self, DescribedCommand, OutputArg, ShardedArgs};
use crate::session::Session;
use clap::Parser;
use std::path::{Path, PathBuf};

/// These arguments of a command that can be divided; `None` for the others.
fn sharded(command: &mut Command) -> Option<ShardedArgs<'_>> {
    match command {
        Command::FormFactors(args) => {
            let mut files = args.input.files_mut();
            files.extend(&mut args.materials);
            Some(ShardedArgs {
                name: "form-factors",
                shard: &mut args.part.shard,
                output: OutputArg::Needed(&mut args.output),
                maps: None,
                files,
            })
        }
        Command::Probe(args) => {
            let mut files = args.input.files_mut();
            files.extend(&mut args.probes.points);
            files.extend(&mut args.normals);
            Some(ShardedArgs {
                name: "probe",
                shard: &mut args.part.shard,
                output: OutputArg::Optional(&mut args.output),
                maps: None,
                files,
            })
        }
        Command::Solve(args) => Some(ShardedArgs {
            name: "solve",
            shard: &mut args.part.shard,
            output: OutputArg::Optional(&mut args.output),
            maps: None,
            files: args.input.files_mut(),
        }),
        Command::Bake(args) => Some(ShardedArgs {
            name: "bake",
            shard: &mut args.part.shard,
            output: OutputArg::Optional(&mut args.output),
            maps: Some([&mut args.files.lightmap, &mut args.files.error_map]),
            files: args.input.files_mut(),
        }),
        _ => None,
    }
}

/// The shard that a command computes, and its output.
pub fn shard_of(command: &Command) -> Option<(Shard, Option<&Path>)> {
    let (shard, output) = match command {
        Command::FormFactors(args) => (args.part.shard, Some(&args.output)),
        Command::Probe(args) => (args.part.shard, args.output.as_ref()),
        Command::Solve(args) => (args.part.shard, args.output.as_ref()),
        Command::Bake(args) => (args.part.shard, args.output.as_ref()),
        _ => return None,
    };
    Some((shard?, output.map(PathBuf::as_path)))
}

/// The files that a command reads, which ranks share; none for those that do not.
pub fn files_of(cli: &mut Cli) -> Vec<&mut PathBuf> {
    sharded(&mut cli.command).map_or_else(Vec::new, |args| args.files)
}

/// Parses recorded arguments.
///
/// # Errors
/// They are not those of this version.
fn parsed(arguments: &[String]) -> Result<Cli, Failure> {
    let program = [String::from("azulejo")];
    let cli = Cli::try_parse_from(program.iter().chain(arguments));
    cli.map_err(|e| Failure::failed(format_args!("the recorded command cannot be run: {e}")))
}

/// The command of this process, as a part records it: the files that it names, and a key of its other
/// arguments but those about its shard and output, and general ones such as the number of threads.
///
/// # Errors
/// The command cannot be recorded.
pub fn described() -> Result<DescribedCommand, Failure> {
    let mut command = parsed(&runner::typed()?)?.command;
    let mut files = Vec::new();
    if let Some(mut args) = sharded(&mut command) {
        *args.shard = None;
        for file in &mut args.files {
            let name = file.file_name().map(PathBuf::from).unwrap_or_default();
            files.push(std::mem::replace(*file, name));
        }
        args.output.set(Some(Path::new("")))?;
    }
    let key = blake3::hash(format!("{command:?}").as_bytes());
    Ok(DescribedCommand {
        files,
        options: shown(key.as_bytes()),
    })
}

/// The command that the parts of a merge record, with its files where they are now and the output of the merge.
///
/// # Errors
/// It is not a command of this version, or has not the outputs of the merge.
pub fn merged(
    plan: &MergePlan,
    args: &MergeArgs,
    session: &mut Session,
) -> Result<Command, Failure> {
    let mut command = parsed(plan.arguments())?.command;
    plan.adapt(sharded(&mut command), args, session)?;
    Ok(command)
}
