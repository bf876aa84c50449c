//! Any bytes as a picture of the format that they show: what is read must be whole.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Ok(image) = azulejo_formats::read_picture(bytes) else {
        return;
    };
    let count = image.width as usize * image.height as usize;
    assert_eq!(image.pixels.len(), count);
    assert!(image.pixels.iter().flatten().all(|v| !v.is_nan()));
    if let Some(alpha) = &image.alpha {
        assert_eq!(alpha.len(), count);
        assert!(alpha.iter().all(|a| (0.0..=1.0).contains(a)));
    }
});
