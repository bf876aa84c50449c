//! What tests need: of the machine they run on, with a count of the tests that did without, and closed forms
//! to compare with.
//!
//! A test that needs reference data, a graphics driver, a display, Embree, an installed font,
//! Python or MPI asks this crate for it. Where it is missing, the test returns early, and the crate records a skip:
//!
//! ```
//! # fn test() {
//! let Some(data) = azulejo_testing::data() else { return };
//! # let _ = data;
//! # }
//! # test();
//! ```
//!
//! A test binary that skipped anything ends with the number of tests by reason, printed past the
//! test harness, which holds back the output of tests that pass.
//!
//! | variable | meaning |
//! |---|---|
//! | `AZULEJO_REQUIRE` | needs separated by commas, of `data`, `gpu`, `display`, `embree`, `fonts`, `python`, `browser` and `mpi`; a test that lacks one of these fails instead of being skipped |
//! | `AZULEJO_SKIPPED` | a file to which each test binary appends what it skipped, one line per test: the need, the reason, the binary and the test, separated by tabs |
//! | `AZULEJO_THOROUGH` | set to anything, tests of estimates take all rays and all cases, in ten times the time |
//! | `AZULEJO_DATA` | a folder with `reference/`, `scenes/` and `corpus/` |
//! | `AZULEJO_CHROMIUM` | a Chromium or Chrome, instead of the first in the path |
//! | `AZULEJO_PYTHON` | a Python with NumPy and SciPy, instead of `python3` |
//! | `AZULEJO_VIEWERS` | a folder with the npm packages `three`, `babylonjs` and `babylonjs-loaders` |

pub mod closed_forms;
mod exit;
mod need;
mod record;

pub use need::Need;

use std::ffi::{OsStr, OsString};
use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// The folder with reference data, scenes and corpus, or `None` after recording a skip.
///
/// # Panics
/// If it is missing and `AZULEJO_REQUIRE` has `data`.
#[must_use]
pub fn data() -> Option<PathBuf> {
    let folder = match std::env::var_os("AZULEJO_DATA") {
        None => Err("AZULEJO_DATA is not set".to_owned()),
        Some(folder) if Path::new(&folder).is_dir() => Ok(PathBuf::from(folder)),
        Some(folder) => Err(format!(
            "AZULEJO_DATA is {}, which is not a folder",
            Path::new(&folder).display()
        )),
    };
    require(Need::Data, folder)
}

/// Whether tests of estimates are to take all rays and all cases: whether `AZULEJO_THOROUGH` is set. Otherwise they
/// take an eighth of the rays; their tolerances are standard errors in both.
#[must_use]
pub fn is_thorough() -> bool {
    std::env::var_os("AZULEJO_THOROUGH").is_some()
}

/// The bytes of an installed font, by its path below `/usr/share/fonts`, or `None` after recording
/// a skip.
///
/// # Panics
/// If it is missing and `AZULEJO_REQUIRE` has `fonts`.
#[must_use]
pub fn font(path: &str) -> Option<Vec<u8>> {
    let path = Path::new("/usr/share/fonts").join(path);
    let bytes = std::fs::read(&path).map_err(|e| format!("{}: {e}", path.display()));
    require(Need::Fonts, bytes)
}

/// A Python interpreter that has NumPy and SciPy, or `None` after recording a skip.
///
/// # Panics
/// If there is none and `AZULEJO_REQUIRE` has `python`.
#[must_use]
pub fn python() -> Option<OsString> {
    let named = std::env::var_os("AZULEJO_PYTHON");
    let program = named.unwrap_or_else(|| OsStr::new("python3").to_owned());
    let status = Command::new(&program)
        .args(["-c", "import numpy, scipy.sparse"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    let shown = Path::new(&program).display();
    let modules = match status {
        Ok(status) if status.success() => Ok(()),
        Ok(_) => Err(format!("{shown} has no NumPy or no SciPy")),
        Err(error) => Err(format!("{shown}: {error}")),
    };
    require(Need::Python, modules).map(|()| program)
}

/// The output of a script that Node.js runs with headless Chromium, or `None` after recording a skip. Scripts say
/// with exit status 77 that something is not installed.
///
/// # Panics
/// If Node.js or Chromium is missing and `AZULEJO_REQUIRE` has `browser`.
#[must_use]
pub fn browser_script(script: &Path, arguments: &[&OsStr]) -> Option<Output> {
    let output = Command::new("node").arg(script).args(arguments).output();
    let output = match output {
        Err(error) => Err(format!("node: {error}")),
        Ok(output) if output.status.code() == Some(77) => {
            Err(String::from_utf8_lossy(&output.stderr).trim().to_owned())
        }
        Ok(output) => Ok(output),
    };
    require(Need::Browser, output)
}

/// A command that starts this many processes of a program by MPI, on however few processors, or `None` after
/// recording a skip. The program and its arguments are to follow.
///
/// # Panics
/// If there is no `mpiexec` and `AZULEJO_REQUIRE` has `mpi`.
#[must_use]
pub fn mpiexec(processes: usize) -> Option<Command> {
    let version = Command::new("mpiexec").arg("--version").output();
    require(
        Need::Mpi,
        version.map_err(|error| format!("mpiexec: {error}")),
    )?;
    let mut command = Command::new("mpiexec");
    // Open MPI asks for these words before it starts more processes than processors, or as root. Other
    // launchers ignore them.
    command
        .env("OMPI_MCA_rmaps_base_oversubscribe", "1")
        .env("PRTE_MCA_rmaps_default_mapping_policy", ":oversubscribe")
        .env("OMPI_ALLOW_RUN_AS_ROOT", "1")
        .env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
        .args(["-n", &processes.to_string()]);
    Some(command)
}

/// The value of a result, or `None` after recording its error as the reason for a skip.
///
/// # Panics
/// If the result is an error and `AZULEJO_REQUIRE` has `need`; or if that variable has an unknown
/// word, whether or not anything is missing.
#[must_use]
pub fn require<T, E: Display>(need: Need, result: Result<T, E>) -> Option<T> {
    let required = need::required(std::env::var("AZULEJO_REQUIRE").ok().as_deref());
    let required = required.unwrap_or_else(|message| panic!("{message}"));
    match result {
        Ok(value) => Some(value),
        Err(why) if required.contains(&need) => panic!(
            "AZULEJO_REQUIRE has `{need}`, but this test found none: {why}. {}",
            need.how_to_get_it()
        ),
        Err(why) => {
            record::skip(need, why.to_string());
            None
        }
    }
}
