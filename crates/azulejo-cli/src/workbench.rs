//! `view`: starts the workbench, which is a program of its own.
//!
//! Its window needs hundreds of crates that nobody else does, so it is not part of this program;
//! who has built it has it beside this one.

use super::args::WorkbenchArgs;
use super::failure::Failure;
use std::env::consts::EXE_SUFFIX;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Its name without what the system puts behind programs.
const PROGRAM: &str = "azulejo-workbench";

/// Runs the workbench until its window is closed; its failure is this command's.
pub fn run(args: &WorkbenchArgs) -> Result<(), Failure> {
    let program = find().ok_or_else(|| Failure::Failed(advice(args)))?;
    let status = Command::new(&program).args(arguments(args)).status();
    let status = status.map_err(|e| Failure::file("start", &program, &e))?;
    match status.code() {
        Some(0) => Ok(()),
        // It has said why.
        Some(code) => Err(Failure::Failed(format!(
            "the workbench ended with status {code}"
        ))),
        None => Err(Failure::failed("the workbench was killed")),
    }
}

/// The workbench beside this program, or where the system looks for programs.
fn find() -> Option<PathBuf> {
    let name = format!("{PROGRAM}{EXE_SUFFIX}");
    let own = std::env::current_exe().ok();
    let beside = own.as_deref().and_then(Path::parent).map(|f| f.join(&name));
    let path = std::env::var_os("PATH").unwrap_or_default();
    let others = std::env::split_paths(&path).map(|folder| folder.join(&name));
    beside.into_iter().chain(others).find(|p| p.is_file())
}

/// What the workbench is given: the same words.
fn arguments(args: &WorkbenchArgs) -> Vec<OsString> {
    let mut words = Vec::new();
    for (option, value) in [
        ("--script", &args.script),
        ("--screenshot", &args.screenshot),
    ] {
        if let Some(value) = value {
            words.extend([option.into(), value.clone().into_os_string()]);
        }
    }
    if args.no_preferences {
        words.push("--no-preferences".into());
    }
    // A file whose name begins with a dash is a file all the same.
    words.push("--".into());
    words.extend(args.files.iter().map(|f| f.clone().into_os_string()));
    words
}

fn advice(args: &WorkbenchArgs) -> String {
    let words: Vec<String> = (arguments(args).iter())
        .map(|w| w.to_string_lossy().into_owned())
        .filter(|w| w != "--")
        .collect();
    format!(
        "there is no {PROGRAM} beside this program or on the PATH; in azulejo's folder: \
         cargo run --release -p {PROGRAM} -- {}",
        words.join(" ")
    )
}
