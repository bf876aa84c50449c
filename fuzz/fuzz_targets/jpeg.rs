//! Any bytes as JPEG: what is read must be whole and in range.
#![no_main]

use azulejo_formats::picture::jpeg;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Ok(image) = jpeg::read(bytes) else {
        return;
    };
    let count = image.width as usize * image.height as usize;
    assert_eq!(image.pixels.len(), count);
    let in_range = |v: &f32| (0.0..=1.0).contains(v);
    assert!(image.pixels.iter().flatten().all(in_range));
});
