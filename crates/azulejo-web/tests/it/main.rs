//! The page in a browser: used as users do, and compared with the same functions here.
//!
//! Needs Node.js, Chromium and a page in `dist/web`, or in the folder `AZULEJO_PAGE`; skipped where one is missing.
//! Making the page takes minutes, so that no test does it. How long things took is printed, for BENCHMARKS.md.
#![allow(clippy::print_stderr, reason = "what was measured is for --nocapture")]

// The crate itself is for browsers alone.
#[path = "../../src/bits.rs"]
mod bits;

use std::fs;
use std::path::Path;

#[test]
fn the_page_is_used_and_has_the_results_of_a_desktop() {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let page = std::env::var_os("AZULEJO_PAGE").map_or(workspace.join("dist/web"), Into::into);
    let folder = std::env::temp_dir().join(format!("azulejo-page-{}", std::process::id()));
    let expected = folder.join("expected");
    fs::create_dir_all(&expected).unwrap();
    if page.exists() {
        for scene in ["cornell", "cornell-mirror"] {
            let text = fs::read(workspace.join(format!("examples/{scene}.grf"))).unwrap();
            let keep = |name: &str, bytes: Result<Vec<u8>, String>| {
                let path = expected.join(format!("{scene}@{name}"));
                fs::write(
                    path,
                    bytes.unwrap_or_else(|why| panic!("{scene} {name}: {why}")),
                )
                .unwrap();
            };
            keep("form_factors", bits::form_factors(&text));
            keep("picture", bits::picture(&text));
            keep("solution", bits::solution(&text));
        }
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/page.mjs");
    let arguments = [
        page.as_os_str(),
        expected.as_os_str(),
        workspace.as_os_str(),
    ];
    let output = azulejo_testing::browser_script(&script, &arguments);
    fs::remove_dir_all(&folder).unwrap();
    let Some(output) = output else {
        return;
    };
    let text = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}{errors}");
    eprint!("{text}");
}
