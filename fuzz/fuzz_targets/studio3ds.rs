//! Any bytes as 3DS: what is read must be valid.
#![no_main]

use azulejo_formats::{Memory, ReadOptions, studio3ds};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let options = ReadOptions::in_proportion(bytes.len());
    if let Ok(loaded) = studio3ds::read(bytes, "fuzz.3ds", &Memory::new(), &options) {
        loaded
            .scene
            .validate()
            .expect("a reader gives valid scenes");
    }
});
