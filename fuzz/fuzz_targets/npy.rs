//! Any bytes as NumPy's `.npy`: an array that is read has as many values as its shape says.
#![no_main]

use azulejo_cli::parsers::parse_npy;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(array) = parse_npy(bytes) {
        assert_eq!(array.values.len(), array.shape.iter().product::<usize>());
    }
});
