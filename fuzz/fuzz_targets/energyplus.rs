//! Any bytes as IDF or epJSON: what is read must be valid.
#![no_main]

use azulejo_formats::{Memory, ReadOptions, energyplus};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let options = ReadOptions::in_proportion(bytes.len());
    if let Ok(loaded) = energyplus::read(bytes, "fuzz.idf", &Memory::new(), &options) {
        loaded
            .scene
            .validate()
            .expect("a reader gives valid scenes");
    }
});
