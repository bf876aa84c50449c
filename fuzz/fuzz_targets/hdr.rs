//! Any bytes as Radiance HDR: what is read must be whole, and nearly the same after writing and
//! reading.
#![no_main]

use azulejo_formats::picture::hdr;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Ok(image) = hdr::read(bytes) else {
        return;
    };
    let count = image.width as usize * image.height as usize;
    assert_eq!(image.pixels.len(), count);
    let mut file = Vec::new();
    if hdr::write(&image, &mut file).is_err() || count == 0 {
        return;
    }
    let again = hdr::read(&file).expect("what is written is read");
    assert_eq!((again.width, again.height), (image.width, image.height));
    for (found, known) in again.pixels.iter().zip(&image.pixels) {
        // The largest channel is exact to a step of eight bits of mantissa; values that the format
        // cannot hold are brought to its limits.
        let largest = known.iter().copied().fold(0.0, f32::max);
        if largest > 1e-30 && largest < 1e38 {
            for (a, b) in found.iter().zip(known) {
                assert!(
                    (a - b.max(0.0)).abs() <= largest / 127.0,
                    "{found:?} {known:?}"
                );
            }
        }
    }
});
