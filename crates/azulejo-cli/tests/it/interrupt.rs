//! Ctrl-C in the middle of long work.

use crate::support::{Folder, Run};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Starts work that would take hours, interrupts it, and expects a quick and clean end.
fn check(line: &str, output: &str, signal: Signal) {
    let folder = Folder::with_room();
    folder.write("p.txt", "2 0 2 0 1 0\n".repeat(2000));
    folder.write(output, "old");
    let before = folder.names();
    let child = folder
        .command(line)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    sleep(Duration::from_millis(700));
    let process = Pid::from_raw(child.id().try_into().unwrap());
    kill(process, signal).unwrap();
    let asked = Instant::now();
    let run = Run::of(child.wait_with_output().unwrap());
    assert_eq!(run.code, Some(1), "{line}\n{}", run.err);
    assert!(run.err.contains("cancelled"), "{line}\n{}", run.err);
    assert_eq!(folder.read(output), b"old", "{line}");
    assert_eq!(folder.names(), before, "{line}");
    // A second is what people get; a loaded machine gets the benefit of the doubt.
    assert!(asked.elapsed() < Duration::from_secs(200), "{line}");
}

#[test]
fn solve_stops() {
    let line = "solve room.obj -o out.grf --patches 500000 --rays 100000";
    check(line, "out.grf", Signal::SIGINT);
}

#[test]
fn render_stops() {
    let line = "render room.obj -o out.png --size 4000x4000 --spp 100000 --rays 16 --patches 50";
    check(line, "out.png", Signal::SIGINT);
}

#[test]
fn probe_stops() {
    let line = "probe room.obj --points p.txt -o out.txt --rays 10000000 --patches 50";
    check(line, "out.txt", Signal::SIGTERM);
}

#[test]
fn form_factors_stop() {
    let line = "form-factors room.obj -o out.npz --patches 20000 --rays 10000000 --no-journal";
    check(line, "out.npz", Signal::SIGINT);
}

#[test]
fn bake_stops() {
    let line = "bake room.obj -o out.glb --size 2048 --error 0.01%";
    check(line, "out.glb", Signal::SIGINT);
}

/// The child that does the work stops with the command that started it.
#[test]
fn experiments_stop() {
    let folder = Folder::new();
    let suite = "title = 't'\n[[scene]]\nname = 'a'\ngenerator = 'street'\n\
                 [[engine]]\nengine = 'rays'\nrays = 100000\n";
    folder.write("t.toml", suite);
    let mut command = folder.command("experiment t.toml -o a --quiet");
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = command.spawn().unwrap();
    sleep(Duration::from_millis(700));
    let process = Pid::from_raw(child.id().try_into().unwrap());
    kill(process, Signal::SIGTERM).unwrap();
    let asked = Instant::now();
    // Its pipes are closed only once the child is gone, too.
    let run = Run::of(child.wait_with_output().unwrap());
    assert_eq!(run.code, Some(1), "{}", run.err);
    assert!(run.err.contains("cancelled"), "{}", run.err);
    assert_eq!(folder.read("a/results.jsonl"), b"");
    assert!(asked.elapsed() < Duration::from_secs(200));
}

/// A process that is killed while it writes cannot clean up: the next one in that folder does.
#[test]
fn solve_is_killed_while_it_writes() {
    let folder = Folder::with_room();
    let drafts = |folder: &Folder| {
        let names = folder.names().into_iter();
        names
            .filter(|n| n.starts_with(".azulejo-") && n.ends_with(".tmp"))
            .count()
    };
    let line = "solve room.obj -o x.grf --patches 20 --rays 16";
    folder.write("x.grf", "old");
    // A draft exists for moments; killing at one of them may need several tries.
    let left = (0..200).any(|_| {
        let mut child = folder
            .command(line)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        while drafts(&folder) == 0 && child.try_wait().unwrap().is_none() {}
        let process = Pid::from_raw(child.id().try_into().unwrap());
        let _ = kill(process, Signal::SIGKILL);
        child.wait().unwrap();
        let found = folder.read("x.grf");
        if found != b"old" {
            // It was faster; what it wrote is whole.
            folder.ok("info x.grf");
            folder.write("x.grf", "old");
        }
        drafts(&folder) > 0
    });
    assert!(left, "no draft was left behind in 200 tries");
    assert_eq!(folder.read("x.grf"), b"old");
    folder.ok(line);
    assert_eq!(drafts(&folder), 0);
    folder.ok("info x.grf");
}
