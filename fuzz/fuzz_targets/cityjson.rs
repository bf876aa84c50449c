//! Any bytes as CityJSON: what is read must be valid.
#![no_main]

use azulejo_formats::{Memory, ReadOptions, cityjson};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let options = ReadOptions::in_proportion(bytes.len());
    if let Ok(loaded) = cityjson::read(bytes, "fuzz.json", &Memory::new(), &options) {
        loaded
            .scene
            .validate()
            .expect("a reader gives valid scenes");
    }
});
