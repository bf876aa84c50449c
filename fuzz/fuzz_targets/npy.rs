//! Any bytes as NumPy's `.npy`: what is read must be whole, and the same after writing and reading.
#![no_main]

use azulejo_cli::npy;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Ok(array) = npy::read(bytes) else {
        return;
    };
    assert_eq!(array.values.len(), array.shape.iter().product::<usize>());
    let mut file = Vec::new();
    npy::write(&array.shape, &array.values, &mut file).expect("memory takes everything");
    let again = npy::read(&file).expect("what is written is read");
    assert_eq!(again.shape, array.shape);
    let bits = |v: &f64| if v.is_nan() { None } else { Some(v.to_bits()) };
    assert!(again.values.iter().map(bits).eq(array.values.iter().map(bits)));
});
