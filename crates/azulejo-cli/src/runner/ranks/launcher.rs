//! What the launcher of MPI programs says in the environment, before MPI is called.

use crate::args::{Cli, Command};
use crate::failure::Failure;
use crate::runner::command::{ShardedArgs, sharded};
use std::env;

/// Variables with the number of this rank: Open MPI's, MPICH's and Intel's, MVAPICH's, that of PMIx.
const RANK: [&str; 4] = [
    "OMPI_COMM_WORLD_RANK",
    "PMI_RANK",
    "MV2_COMM_WORLD_RANK",
    "PMIX_RANK",
];

/// Variables with the number of ranks; that of SLURM counts beside one of those above.
const SIZE: [&str; 4] = [
    "OMPI_COMM_WORLD_SIZE",
    "PMI_SIZE",
    "MV2_COMM_WORLD_SIZE",
    "SLURM_STEP_NUM_TASKS",
];

/// Whether the launcher says that this is not rank 0, which alone says anything.
pub fn is_helper() -> bool {
    number(&RANK).is_some_and(|rank| rank > 0)
}

/// Whether a launcher started several processes for this command, to share it.
///
/// # Errors
/// They cannot.
pub fn is_shared(cli: &Cli) -> Result<bool, Failure> {
    if number(&RANK).is_none() || number(&SIZE).unwrap_or(1) < 2 {
        return Ok(false);
    }
    if crate::runner::has_own_work(&cli.command) {
        return Ok(false);
    }
    match &cli.command {
        Command::FormFactors(args) if args.matrix.compress.is_some() => Err(Failure::misuse(
            "--compress: factors in blocks are not shared among MPI processes: run it without mpiexec",
        )),
        Command::FormFactors(_) | Command::Solve(_) | Command::Probe(_) => Ok(true),
        Command::Bake(args) if !args.check && !args.strip => Ok(true),
        _ => Err(Failure::misuse(
            "this command does not share its work among MPI processes: run it without mpiexec; form-factors, solve, bake \
             and probe do",
        )),
    }
}

/// Several processes, of a program that cannot share.
#[cfg(not(feature = "mpi"))]
pub fn without_mpi() -> Failure {
    Failure::misuse(
        "MPI started several processes, but this azulejo was built without it, and each would do all of the work: build \
         with --features mpi (docs/mpi.md), divide the work by --shard, or run one process",
    )
}

/// The files that a command reads, which ranks share; none for those that do not.
pub fn files_of(command: &mut Command) -> Vec<&mut std::path::PathBuf> {
    let sharded: Option<ShardedArgs<'_>> = sharded(command);
    sharded.map_or_else(Vec::new, |args| args.files)
}

/// Threads of a rank beside which there are so many on its machine, itself counted: its part of the processors, or those
/// that it is bound to.
#[cfg(feature = "mpi")]
pub fn threads(ranks: usize) -> usize {
    let bound = std::thread::available_parallelism().map_or(1, usize::from);
    // A rank that is bound to some processors does not see the others there.
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let all = text
        .lines()
        .filter(|line| line.starts_with("processor"))
        .count();
    (all.max(bound) / ranks.max(1)).clamp(1, bound)
}

fn number(names: &[&str]) -> Option<usize> {
    let of = |name: &&str| env::var(name).ok()?.trim().parse().ok();
    names.iter().find_map(of)
}
