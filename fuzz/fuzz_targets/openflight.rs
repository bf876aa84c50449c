//! Any bytes as OpenFlight, which may refer to two other files and to itself: what is read must
//! be valid, at every level of detail.
#![no_main]

use azulejo_formats::{Lod, Memory, ReadOptions, openflight};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    // A file begins with opcode 1; other numbers there stand for other levels of detail.
    let lod = match bytes.get(1) {
        Some(2) => Lod::Coarsest,
        Some(3) => Lod::All,
        Some(4) => Lod::Distance(100.0),
        _ => Lod::Finest,
    };
    let mut bytes = bytes.to_vec();
    if let Some(opcode) = bytes.get_mut(1) {
        *opcode = 1;
    }
    let files = Memory::new()
        .with("b.flt", bytes.clone())
        .with("c.flt", bytes.clone());
    let options = ReadOptions {
        lod,
        ..ReadOptions::in_proportion(bytes.len())
    };
    if let Ok(loaded) = openflight::read(&bytes, "fuzz.flt", &files, &options) {
        let valid = loaded.scene.validate();
        valid.expect("a reader gives valid scenes");
    }
});
