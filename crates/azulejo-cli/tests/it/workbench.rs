//! `view` finds the workbench, or says how to get it.

use crate::support::Folder;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The program alone in a folder: what else was built stands beside the original.
fn program(folder: &Folder) -> PathBuf {
    let own = folder.path("azulejo");
    let original = Path::new(env!("CARGO_BIN_EXE_azulejo"));
    if std::fs::hard_link(original, &own).is_err() {
        std::fs::copy(original, &own).unwrap();
    }
    own
}

#[test]
fn without_a_workbench_the_way_to_it_is_said() {
    let folder = Folder::new();
    let output = Command::new(program(&folder))
        .args(["view", "a room.3ds", "--screenshot", "out.png"])
        .env("PATH", folder.path("nowhere"))
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    let expected = "cargo run --release -p azulejo-workbench -- --screenshot out.png a room.3ds";
    assert!(said.contains(expected), "{said}");
}

#[cfg(unix)]
#[test]
fn a_workbench_beside_it_gets_the_same_words() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    let program = program(&folder);
    let fake = folder.path("azulejo-workbench");
    let run = |script: &str| {
        folder.write("azulejo-workbench", script);
        std::fs::set_permissions(&fake, std::fs::Permissions::from_mode(0o755)).unwrap();
        let words = ["view", "--script", "s.txt", "a.3ds", "b.obj"];
        Command::new(&program).args(words).output().unwrap()
    };
    let output = run("#!/bin/sh\necho \"$@\"\n");
    assert_eq!(output.stdout, b"--script s.txt -- a.3ds b.obj\n");
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(run("#!/bin/sh\nexit 3\n").status.code(), Some(3));
}

/// A window that outlived the command that opened it could not be ended with it.
#[cfg(unix)]
#[test]
fn a_signal_to_the_command_reaches_the_workbench() {
    use nix::sys::signal::{Signal, kill};
    use nix::unistd::Pid;
    use std::os::unix::fs::PermissionsExt;
    use std::time::{Duration, Instant};
    let folder = Folder::new();
    let program = program(&folder);
    std::fs::create_dir(folder.path("bin")).unwrap();
    let fake = folder.path("bin/azulejo-workbench");
    // What the window does: it notes the signal and ends well.
    let script = "#!/bin/sh\ntrap 'echo saved > ended; exit 0' TERM INT\necho $$ > ready.part\n\
                  mv ready.part ready\nfor k in $(seq 600); do sleep 0.1; done\nexit 9\n";
    folder.write("bin/azulejo-workbench", script);
    std::fs::set_permissions(&fake, std::fs::Permissions::from_mode(0o755)).unwrap();
    let system = std::env::var("PATH").unwrap();
    let path = format!("{}:{system}", folder.path("bin").display());
    for signal in [Signal::SIGTERM, Signal::SIGINT] {
        let mut child = Command::new(&program)
            .args(["view", "a.3ds"])
            .env("PATH", &path)
            .current_dir(folder.path("bin").parent().unwrap())
            .spawn()
            .unwrap();
        let begin = Instant::now();
        while !folder.path("ready").exists() {
            assert!(begin.elapsed() < Duration::from_secs(200));
            std::thread::sleep(Duration::from_millis(5));
        }
        let own = child.id().to_string();
        assert_eq!(folder.read("ready"), format!("{own}\n").as_bytes());
        kill(Pid::from_raw(child.id().try_into().unwrap()), signal).unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(0));
        assert_eq!(folder.read("ended"), b"saved\n");
        for name in ["ready", "ended"] {
            std::fs::remove_file(folder.path(name)).unwrap();
        }
    }
}
