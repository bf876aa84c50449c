//! Skips, seen from outside: this program starts itself again with one test that skips.

use azulejo_testing::Need;
use std::process::{Command, Output};

/// Set in the process that [`skipping`] starts.
const INNER: &str = "AZULEJO_TESTING_INNER";

/// Skips where it was started for that; passes otherwise.
#[test]
fn inner() {
    if std::env::var_os(INNER).is_some() {
        for _ in 0..2 {
            assert_eq!(azulejo_testing::data(), None);
        }
        assert_eq!(
            azulejo_testing::require(Need::Gpu, Ok::<_, &str>(1)),
            Some(1)
        );
    }
}

/// Runs [`inner`] in a process of its own, without data.
fn skipping(variables: &[(&str, &str)]) -> (Output, String) {
    let program = std::env::current_exe().unwrap();
    let output = Command::new(program)
        .args(["inner", "--exact"])
        .env_remove("AZULEJO_DATA")
        .env_remove("AZULEJO_REQUIRE")
        .env_remove("AZULEJO_SKIPPED")
        .env(INNER, "1")
        .envs(variables.iter().copied())
        .output()
        .unwrap();
    let printed = [&output.stdout[..], &output.stderr[..]].concat();
    let printed = String::from_utf8(printed).unwrap();
    (output, printed)
}

#[test]
fn a_skip_passes_and_is_counted_once() {
    let list = std::env::temp_dir().join(format!("azulejo-skipped-{}", std::process::id()));
    let path = list.to_str().unwrap();
    let message = "skipped: 1 test without data: AZULEJO_DATA is not set\n";
    for variables in [
        &[("AZULEJO_SKIPPED", path)][..],
        &[("AZULEJO_SKIPPED", path), ("AZULEJO_REQUIRE", "gpu,fonts")],
    ] {
        let (output, printed) = skipping(variables);
        assert!(output.status.success(), "{printed}");
        assert!(printed.ends_with(message), "{printed}");
    }
    let listed = std::fs::read_to_string(&list).unwrap();
    std::fs::remove_file(&list).unwrap();
    assert_eq!(
        listed,
        "data\tAZULEJO_DATA is not set\tit\tinner\n".repeat(2)
    );
}

#[test]
fn a_requirement_that_is_not_met_fails() {
    let check = |variables: &[(&str, &str)], expected: &[&str]| {
        let (output, printed) = skipping(variables);
        assert_eq!(output.status.code(), Some(101), "{printed}");
        for words in expected {
            assert!(printed.contains(words), "{words}: {printed}");
        }
    };
    check(
        &[("AZULEJO_REQUIRE", "fonts,data")],
        &["AZULEJO_DATA is not set", "Set AZULEJO_DATA to a folder"],
    );
    check(
        &[("AZULEJO_REQUIRE", "date")],
        &[
            "`date`",
            "none of data, gpu, display, embree, fonts, python",
        ],
    );
    let missing = [("AZULEJO_REQUIRE", "data"), ("AZULEJO_DATA", "/nowhere")];
    check(
        &missing,
        &["AZULEJO_DATA is /nowhere, which is not a folder"],
    );
}
