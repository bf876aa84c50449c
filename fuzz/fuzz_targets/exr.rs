//! Any bytes as OpenEXR: what is read must be whole, and the same after writing and reading.
#![no_main]

use azulejo_formats::picture::exr;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Ok(image) = exr::read(bytes) else {
        return;
    };
    let count = image.width as usize * image.height as usize;
    assert_eq!(image.pixels.len(), count);
    let mut file = Vec::new();
    if count == 0 || exr::write(&image, &mut file).is_err() {
        return;
    }
    let again = exr::read(&file).expect("what is written is read");
    assert_eq!((again.width, again.height), (image.width, image.height));
    let bits = |v: &f32| if v.is_nan() { None } else { Some(v.to_bits()) };
    let values = again.pixels.iter().flatten().map(bits);
    assert!(values.eq(image.pixels.iter().flatten().map(bits)));
});
