//! Any bytes as NASTRAN's bulk data: what is read must be valid. They may include themselves and another file.
#![no_main]

use azulejo_formats::{Memory, ReadOptions, nastran};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let options = ReadOptions::in_proportion(bytes.len());
    let files = Memory::new()
        .with("a.bdf", bytes)
        .with("b.bdf", "GRID,9,,1.,2.,3.\n");
    if let Ok(loaded) = nastran::read(bytes, "fuzz.bdf", &files, &options) {
        loaded
            .scene
            .validate()
            .expect("a reader gives valid scenes");
    }
});
