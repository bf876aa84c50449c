//! Any bytes as OFF: what is read must be valid.
#![no_main]

use azulejo_formats::{Memory, ReadOptions, off};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let options = ReadOptions::in_proportion(bytes.len());
    if let Ok(loaded) = off::read(bytes, "fuzz.off", &Memory::new(), &options) {
        loaded
            .scene
            .validate()
            .expect("a reader gives valid scenes");
    }
});
