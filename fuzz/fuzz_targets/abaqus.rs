//! Any bytes as input of Abaqus: what is read must be valid. They may include themselves and another file.
#![no_main]

use azulejo_formats::{Memory, ReadOptions, abaqus};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let options = ReadOptions::in_proportion(bytes.len());
    let files = Memory::new()
        .with("a.inp", bytes)
        .with("b.inp", "9, 1, 2, 3\n");
    if let Ok(loaded) = abaqus::read(bytes, "fuzz.inp", &files, &options) {
        loaded
            .scene
            .validate()
            .expect("a reader gives valid scenes");
    }
});
