//! Any bytes as SCN: what is read must be valid.
#![no_main]

use azulejo_formats::{Memory, ReadOptions, scn};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let files = Memory::new()
        .with("a.scn", "#define R 2\nsphere 0 0 0 R\n")
        .with("t.t3d", "SPACING 1\n");
    let options = ReadOptions::in_proportion(bytes.len());
    let Ok(loaded) = scn::read(bytes, "fuzz.scn", &files, &options) else {
        return;
    };
    loaded
        .scene
        .validate()
        .expect("a reader gives valid scenes");
});
