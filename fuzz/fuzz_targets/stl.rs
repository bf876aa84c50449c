//! Any bytes as STL: what is read must be valid.
#![no_main]

use azulejo_formats::{Memory, ReadOptions, stl};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let length = bytes.len() as u64;
    let options = ReadOptions {
        most_elements: 64 * length / 100 + 10_000,
        most_unpacked: 64 * length,
        ..ReadOptions::default()
    };
    if let Ok(loaded) = stl::read(bytes, "fuzz.stl", &Memory::new(), &options) {
        loaded
            .scene
            .validate()
            .expect("a reader gives valid scenes");
    }
});
