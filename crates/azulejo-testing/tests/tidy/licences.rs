//! Licences, which `cargo package` packs only where they lie.

use crate::root;
use std::fs;

#[test]
fn published_crates_have_their_licences() {
    let mut published = 0;
    for entry in fs::read_dir(root().join("crates")).expect("readable") {
        let folder = entry.expect("readable").path();
        let manifest = fs::read_to_string(folder.join("Cargo.toml")).expect("a manifest");
        // The Python package is released, too, though not on crates.io.
        if manifest.contains("publish = false") && !folder.ends_with("azulejo-python") {
            continue;
        }
        for licence in ["LICENSE-MIT", "LICENSE-APACHE"] {
            let file = folder.join(licence);
            assert!(file.is_file(), "no {}: link to the root's", file.display());
        }
        published += 1;
    }
    assert!(published > 10, "the crates are not found");
}
