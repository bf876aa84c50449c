//! Work that MPI's processes share: the bytes of one process, and what may happen to it.

use crate::support::{Folder, Run};
use std::process::Command;

/// A program without MPI that MPI starts several times.
#[cfg(not(feature = "mpi"))]
#[test]
fn a_program_without_mpi_says_so() {
    let folder = Folder::with_room();
    let started = |line: &str, rank: &str| {
        let mut command: Command = folder.command(line);
        command.env("OMPI_COMM_WORLD_SIZE", "4");
        Run::of(command.env("OMPI_COMM_WORLD_RANK", rank).output().unwrap())
    };
    let line = "form-factors room.obj --patches 100 --rays 16 -o f.npz";
    let run = started(line, "0");
    assert_eq!(run.code, Some(2));
    assert!(run.err.contains("--features mpi"), "{}", run.err);
    // Rank 0 says it for all.
    let run = started(line, "1");
    assert_eq!((run.code, run.err.as_str()), (Some(2), ""));
    // Shards need no MPI, and may be started by it.
    let run = started(&format!("{line} --shard 2/4"), "1");
    assert_eq!(run.code, Some(0), "{}", run.err);
    let run = started("form-factors none.obj -o f-2 --shard 2/4", "1");
    assert!(run.code == Some(1) && run.err.contains("none.obj"));
    let run = started("render room.obj -o r.png", "0");
    assert!(run.code == Some(2) && run.err.contains("without mpiexec"));
}

#[cfg(feature = "mpi")]
mod started {
    use super::*;
    use std::fs;
    use std::process::{Child, Stdio};
    use std::thread::sleep;
    use std::time::Duration;

    const QUICK: &str = "form-factors room.obj --patches 200 --rays 4096";

    /// The program, started by this many ranks, with one thread each.
    fn ranks(folder: &Folder, processes: usize, line: &str) -> Option<Command> {
        let mut command = azulejo_testing::mpiexec(processes)?;
        command
            .arg(env!("CARGO_BIN_EXE_azulejo"))
            .args(line.split_whitespace())
            .args(["--threads", "1"])
            .current_dir(folder.path(""));
        Some(command)
    }

    /// Checks that 1, 2, 3 and 5 ranks give the bytes of one process.
    fn check(folder: &Folder, line: &str, output: &str) {
        folder.ok(&format!("{line} -o whole.{output}"));
        let whole = folder.read(&format!("whole.{output}"));
        for processes in [1, 2, 3, 5] {
            let line = format!("{line} -o ranks.{output}");
            let Some(mut command) = ranks(folder, processes, &line) else {
                return;
            };
            let run = Run::of(command.output().unwrap());
            assert_eq!(run.code, Some(0), "{processes} ranks: {}", run.err);
            let found = folder.read(&format!("ranks.{output}"));
            assert!(found == whole, "{line}, {processes} ranks");
            assert!(!folder.path(&format!("ranks.{output}.journal")).exists());
            fs::remove_file(folder.path(&format!("ranks.{output}"))).unwrap();
        }
    }

    #[test]
    fn form_factors() {
        let folder = Folder::with_room();
        check(&folder, QUICK, "npz");
        check(
            &folder,
            "form-factors room.obj --patches 300 --engine analytic",
            "csv",
        );
    }

    #[test]
    fn light_on_vertices() {
        let folder = Folder::with_room();
        check(&folder, "solve room.obj --patches 200 --rays 64", "grf");
        check(&folder, "solve room.obj --patches 400 --error 0.05", "ply");
        check(&folder, "solve room.obj --patches 100 --bounces 2", "glb");
    }

    #[test]
    fn light_at_points() {
        let folder = Folder::with_room();
        folder.write("points.txt", POINTS);
        let probe = "probe room.obj --points points.txt --patches 200";
        check(&folder, &format!("{probe} --error 0.05"), "csv");
        check(&folder, &format!("{probe} --rays 64"), "npy");
    }

    #[test]
    fn lightmaps() {
        let folder = Folder::with_room();
        check(
            &folder,
            "bake room.obj --size 64 --patches 200 --error 0.1",
            "glb",
        );
        let rays = "bake room.obj --size 32 --patches 100 --rays 64";
        check(&folder, rays, "glb");
        check(&folder, &format!("{rays} --light ao"), "glb");
    }

    const POINTS: &str = "0.5 0.5 0.5 0 0 1\n0.2 0.3 0.5 0 1 0\n0.7 0.7 0.2 1 0 0\n";

    /// Blocks that take a while each.
    const LONG: &str = "form-factors room.obj --patches 1500 --rays 16384 --two-sided -o f.npz";

    /// Starts ranks, and waits until the journal has some blocks.
    fn started(folder: &Folder, processes: usize, line: &str) -> Option<Child> {
        let mut command = ranks(folder, processes, line)?;
        let streams = command.stdout(Stdio::null()).stderr(Stdio::piped());
        let mut child = streams.spawn().unwrap();
        let length = || fs::metadata(folder.path("f.npz.journal")).map_or(0, |m| m.len());
        while length() < 100_000 {
            let end = child.try_wait().unwrap();
            assert!(end.is_none(), "it ended before it was interrupted");
            sleep(Duration::from_millis(2));
        }
        Some(child)
    }

    /// The processes that a launcher has started.
    fn processes(launcher: &Child) -> Vec<nix::unistd::Pid> {
        let wanted = format!("({})", "azulejo");
        let entries = fs::read_dir("/proc").unwrap().flatten();
        let mut found = Vec::new();
        for entry in entries {
            let Ok(number) = entry.file_name().to_string_lossy().parse::<i32>() else {
                continue;
            };
            let stat = fs::read_to_string(entry.path().join("stat")).unwrap_or_default();
            let Some((name, rest)) = stat.split_once(") ") else {
                continue;
            };
            let parent = rest.split(' ').nth(1).and_then(|p| p.parse::<u32>().ok());
            if parent == Some(launcher.id()) && format!("{name})").ends_with(&wanted) {
                found.push(nix::unistd::Pid::from_raw(number));
            }
        }
        found
    }

    #[test]
    fn a_rank_that_dies_ends_the_run_and_the_next_goes_on() {
        let folder = Folder::with_room();
        let Some(child) = started(&folder, 3, LONG) else {
            return;
        };
        let last = *processes(&child).last().unwrap();
        nix::sys::signal::kill(last, nix::sys::signal::Signal::SIGKILL).unwrap();
        let end = child.wait_with_output().unwrap();
        assert!(!end.status.success());
        assert!(folder.path("f.npz.journal").exists() && !folder.path("f.npz").exists());
        let run = Run::of(ranks(&folder, 2, LONG).unwrap().output().unwrap());
        assert_eq!(run.code, Some(0), "{}", run.err);
        assert!(run.err.contains("resuming"), "{}", run.err);
        let whole = LONG.replace("f.npz", "whole.npz");
        folder.ok(&whole);
        assert!(folder.read("f.npz") == folder.read("whole.npz"));
    }

    #[test]
    fn a_signal_ends_all_behind_their_blocks() {
        let folder = Folder::with_room();
        let Some(child) = started(&folder, 3, LONG) else {
            return;
        };
        for rank in processes(&child) {
            nix::sys::signal::kill(rank, nix::sys::signal::Signal::SIGTERM).unwrap();
        }
        let end = child.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&end.stderr);
        assert_eq!(end.status.code(), Some(1), "{said}");
        assert!(said.contains("completed work is kept"), "{said}");
        // One process goes on as well.
        let run = folder.ok(LONG);
        assert!(run.err.contains("resuming"), "{}", run.err);
    }

    #[test]
    fn errors_are_said_once() {
        let folder = Folder::with_room();
        let lines = [
            ("form-factors none.obj -o f.npz", 1, "none.obj"),
            ("solve room.obj -o l.grf --time 1", 2, "--time"),
            ("render room.obj -o r.png", 2, "without mpiexec"),
            ("form-factors room.obj --patches x -o f.npz", 2, "--patches"),
        ];
        for (line, code, words) in lines {
            let Some(mut command) = ranks(&folder, 3, line) else {
                return;
            };
            let run = Run::of(command.output().unwrap());
            assert_eq!(run.code, Some(code), "{line}: {}", run.err);
            assert_eq!(run.err.matches("error: ").count(), 1, "{line}: {}", run.err);
            assert!(run.err.contains(words), "{line}: {}", run.err);
        }
    }

    /// Ranks that find another file, or none, under the path get that of rank 0.
    #[test]
    fn files_are_those_of_rank_0() {
        let folder = Folder::with_room();
        let line = format!("{QUICK} -o f.npz --threads 1");
        folder.ok(&line.replace("f.npz", "whole.npz"));
        fs::create_dir(folder.path("elsewhere")).unwrap();
        folder.write(
            "elsewhere/room.obj",
            "o other\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        );
        let Some(mut command) = azulejo_testing::mpiexec(1) else {
            return;
        };
        let program = env!("CARGO_BIN_EXE_azulejo");
        command.arg(program).args(line.split_whitespace());
        command.args([":", "-n", "2", "--wdir"]);
        command.arg(folder.path("elsewhere")).arg(program);
        command.args(line.split_whitespace());
        let run = Run::of(command.current_dir(folder.path("")).output().unwrap());
        assert_eq!(run.code, Some(0), "{}", run.err);
        assert!(folder.read("f.npz") == folder.read("whole.npz"));
        let left: Vec<String> = folder.names();
        assert!(!left.iter().any(|name| name.contains("rank")), "{left:?}");
    }
}
