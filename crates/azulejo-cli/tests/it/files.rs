//! Results appear whole or not at all.

use crate::support::{Folder, Run};
use std::process::Stdio;

#[test]
fn outputs_that_cannot_be_written_are_found_before_the_work() {
    let folder = Folder::with_room();
    std::fs::create_dir(folder.path("d.grf")).unwrap();
    // A million patches of as many rays would take hours: these must fail at once.
    let work = "--patches 1000000 --rays 1000000";
    folder.fails(
        &format!("solve room.obj -o nowhere/out.grf {work}"),
        1,
        "nowhere/out.grf",
    );
    folder.fails(&format!("solve room.obj -o d.grf {work}"), 1, "directory");
    folder.fails(
        &format!("render room.obj -o nowhere/a.png {work}"),
        1,
        "nowhere/a.png",
    );
}

#[test]
fn a_failure_leaves_the_old_files() {
    let folder = Folder::with_room();
    folder.write("bad.obj", "v 0 0 0\nf 1 2 9\n");
    for (line, output) in [
        ("convert bad.obj -o out.grf", "out.grf"),
        ("convert bad.obj -o out.obj", "out.obj"),
        ("solve bad.obj -o out.grf", "out.grf"),
        ("render bad.obj -o out.png", "out.png"),
        ("form-factors bad.obj -o out.npz", "out.npz"),
    ] {
        folder.write(output, "old");
        folder.fails(line, 1, "bad.obj");
        assert_eq!(folder.read(output), b"old", "{line}");
    }
    let left = folder.names();
    assert!(left.iter().all(|n| !n.ends_with(".tmp")), "{left:?}");
}

#[cfg(unix)]
#[test]
fn a_full_disk_is_said_plainly() {
    let folder = Folder::with_room();
    if !std::path::Path::new("/dev/full").exists() {
        return;
    }
    for name in ["out.grf", "out.obj"] {
        std::os::unix::fs::symlink("/dev/full", folder.path(name)).unwrap();
        let expected = format!("cannot write {name}: No space left on device");
        folder.fails(&format!("convert room.obj -o {name}"), 1, &expected);
    }
}

#[cfg(unix)]
#[test]
fn a_read_only_file_is_respected() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::with_room();
    folder.write("out.grf", "old");
    let mode = |m| std::fs::Permissions::from_mode(m);
    std::fs::set_permissions(folder.path("out.grf"), mode(0o444)).unwrap();
    folder.fails("convert room.obj -o out.grf", 1, "read-only");
    std::fs::set_permissions(folder.path("out.grf"), mode(0o600)).unwrap();
    folder.ok("convert room.obj -o out.grf");
    let kept = std::fs::metadata(folder.path("out.grf")).unwrap();
    assert_eq!(kept.permissions().mode() & 0o777, 0o600);
}

#[test]
fn a_closed_pipe_is_no_error() {
    let folder = Folder::with_room();
    for line in [
        "info room.obj",
        "info room.obj --json",
        "convert room.obj -o -",
        "completions bash",
        "--help",
    ] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let child = folder
            .command(line)
            .stdout(writer)
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let run = Run::of(child.wait_with_output().unwrap());
        assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{line}");
    }
}

#[test]
fn nothing_is_drawn_into_a_pipe() {
    let folder = Folder::with_room();
    let run = folder.ok("solve room.obj -o out.grf --patches 100 --rays 32");
    assert!(!run.err.contains(['\r', '\u{1b}']), "{}", run.err);
    assert!(run.err.contains("patches") && run.out.is_empty());
    let quiet = folder.ok("solve room.obj -o out.grf --patches 100 --rays 32 --quiet");
    assert_eq!((quiet.out.as_str(), quiet.err.as_str()), ("", ""));
}
