//! A room with `MOZ_lightmap` in three.js and Babylon.js, compared with its formula.

use std::path::Path;

/// Both show 8-bit texels within 1% and those of an EXR within 0.3%, on matt and unlit surfaces, with a texture
/// transform and without.
#[test]
fn foreign_viewers_show_the_light_that_is_meant() {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/viewers/check.mjs");
    let Some(output) = azulejo_testing::browser_script(&script, &[]) else {
        return;
    };
    let text = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}{errors}");
}
