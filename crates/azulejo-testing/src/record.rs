//! What was skipped so far in this process, and the report of it at its end.

use crate::{Need, exit};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs::OpenOptions;
use std::io::Write as _;
use std::path::Path;
use std::sync::{Mutex, Once, PoisonError};

/// A test that did without something, wholly or in part.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Skip {
    need: Need,
    why: String,
    test: String,
}

/// Each skip once, however often its test recorded it.
static SKIPS: Mutex<BTreeSet<Skip>> = Mutex::new(BTreeSet::new());

/// Records that the current test does without `need`.
pub(crate) fn skip(need: Need, why: String) {
    static REPORT: Once = Once::new();
    REPORT.call_once(|| exit::at_exit(report));
    // libtest names a test's thread after the test.
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("?").to_owned();
    let mut skips = SKIPS.lock().unwrap_or_else(PoisonError::into_inner);
    skips.insert(Skip { need, why, test });
}

/// Prints the counts and appends the list to the file `AZULEJO_SKIPPED`.
///
/// Nothing can be done about errors at this point of a process, and a full disk is no reason to
/// fail the tests.
fn report() {
    let skips = SKIPS.lock().unwrap_or_else(PoisonError::into_inner);
    let _ = std::io::stderr().write_all(counted(&skips).as_bytes());
    if let Some(path) = std::env::var_os("AZULEJO_SKIPPED") {
        let file = OpenOptions::new().append(true).create(true).open(path);
        // One call, so that lines of processes that end together do not mix.
        let _ = file.and_then(|mut file| file.write_all(listed(&skips, &binary()).as_bytes()));
    }
}

/// One line per reason, with the number of tests.
fn counted(skips: &BTreeSet<Skip>) -> String {
    let mut counts = BTreeMap::new();
    for skip in skips {
        *counts.entry((skip.need, &skip.why)).or_insert(0) += 1;
    }
    let mut text = String::new();
    for ((need, why), count) in counts {
        let tests = if count == 1 { "test" } else { "tests" };
        let _ = writeln!(text, "skipped: {count} {tests} without {need}: {why}");
    }
    text
}

/// One line per test: need, reason, binary and test, separated by tabs.
fn listed(skips: &BTreeSet<Skip>, binary: &str) -> String {
    let mut text = String::new();
    for Skip { need, why, test } in skips {
        let why = why.replace(['\t', '\n', '\r'], " ");
        let _ = writeln!(text, "{need}\t{why}\t{binary}\t{test}");
    }
    text
}

/// The name of this process's program without the hash that cargo appends.
fn binary() -> String {
    let program = std::env::args_os().next().unwrap_or_default();
    let name = Path::new(&program).file_stem().unwrap_or_default();
    let name = name.to_string_lossy();
    let is_hash = |tail: &str| tail.len() == 16 && tail.bytes().all(|b| b.is_ascii_hexdigit());
    match name.rsplit_once('-') {
        Some((name, tail)) if is_hash(tail) => name.to_owned(),
        _ => name.into_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn skips() -> BTreeSet<Skip> {
        let skip = |need, why: &str, test: &str| Skip {
            need,
            why: why.to_owned(),
            test: test.to_owned(),
        };
        BTreeSet::from([
            skip(Need::Fonts, "no\tfont", "c"),
            skip(Need::Data, "not set", "b"),
            skip(Need::Data, "not set", "a"),
        ])
    }

    #[test]
    fn reasons_are_counted() {
        assert_eq!(
            counted(&skips()),
            "skipped: 2 tests without data: not set\nskipped: 1 test without fonts: no\tfont\n"
        );
        assert_eq!(counted(&BTreeSet::new()), "");
    }

    #[test]
    fn a_line_has_four_cells() {
        assert_eq!(
            listed(&skips(), "it"),
            "data\tnot set\tit\ta\ndata\tnot set\tit\tb\nfonts\tno font\tit\tc\n"
        );
    }
}
