//! Runs the program in a folder of its own.

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::atomic::{AtomicU32, Ordering};

/// A temporary folder, removed at the end.
pub struct Folder(PathBuf);

/// What a run of the program left: exit code and both streams.
pub struct Run {
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

impl Folder {
    pub fn new() -> Folder {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let name = format!("azulejo-it-{}-{number}", std::process::id());
        let path = std::env::temp_dir().join(name);
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Folder(path)
    }

    /// A folder with the lit room in it: `room.obj` and `room.mtl`.
    pub fn with_room() -> Folder {
        let folder = Folder::new();
        folder.write("room.obj", ROOM);
        folder.write("room.mtl", ROOM_MATERIALS);
        folder
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).unwrap();
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap()
    }

    /// Names of the files that are there, sorted.
    pub fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.0).unwrap();
        let mut names: Vec<String> = entries
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    /// The program, ready to run here.
    pub fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_azulejo"));
        command.args(line.split_whitespace()).current_dir(&self.0);
        command
    }

    /// Runs the program; arguments are separated by blanks.
    pub fn run(&self, line: &str) -> Run {
        Run::of(self.command(line).output().unwrap())
    }

    /// Runs the program, which must succeed.
    pub fn ok(&self, line: &str) -> Run {
        let run = self.run(line);
        assert_eq!(run.code, Some(0), "azulejo {line}\n{}", run.err);
        run
    }

    /// Runs the program with `--json`, which must succeed and print one object.
    pub fn json(&self, line: &str) -> Value {
        let run = self.ok(&format!("{line} --json"));
        serde_json::from_str(&run.out).unwrap_or_else(|e| panic!("{line}: {e}\n{}", run.out))
    }

    /// Runs the program, which must fail with `code`, say `expected`, and not panic.
    pub fn fails(&self, line: &str, code: i32, expected: &str) {
        let run = self.run(line);
        assert_eq!(run.code, Some(code), "azulejo {line}\n{}", run.err);
        assert!(run.err.contains(expected), "azulejo {line}\n{}", run.err);
        assert!(!run.err.contains("panicked"), "azulejo {line}\n{}", run.err);
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

impl Run {
    pub fn of(output: Output) -> Run {
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        Run {
            code: output.status.code(),
            out: text(&output.stdout),
            err: text(&output.stderr),
        }
    }
}

/// Where the project stands.
pub fn project() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// A closed room of 4 × 3 × 4 with a lamp hanging under its ceiling.
const ROOM: &str = "\
mtllib room.mtl
v 0 0 0
v 4 0 0
v 4 0 4
v 0 0 4
v 0 3 0
v 4 3 0
v 4 3 4
v 0 3 4
v 1.5 2.9 1.5
v 2.5 2.9 1.5
v 2.5 2.9 2.5
v 1.5 2.9 2.5
o walls
usemtl white
f 1 4 3 2
f 5 6 7 8
f 1 2 6 5
f 4 8 7 3
f 1 5 8 4
f 2 3 7 6
o lamp
usemtl lamp
f 9 10 11 12
";

const ROOM_MATERIALS: &str = "\
newmtl white
Kd 0.7 0.6 0.5
newmtl lamp
Kd 0 0 0
Ke 10 10 10
";
