//! Any bytes as PNG: what is read must be whole, and nearly the same after writing and reading.
#![no_main]

use azulejo_formats::picture::png;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Ok(image) = png::read(bytes) else {
        return;
    };
    let count = image.width as usize * image.height as usize;
    assert_eq!(image.pixels.len(), count);
    let in_range = |v: &f32| (0.0..=1.0).contains(v);
    assert!(image.pixels.iter().flatten().all(in_range));
    if count == 0 {
        return;
    }
    let mut file = Vec::new();
    png::write_linear(&image, &mut file).expect("memory takes everything");
    let again = png::read(&file).expect("what is written is read");
    assert_eq!((again.width, again.height), (image.width, image.height));
    // Half a step of eight bits where sRGB is steepest in linear light, at white.
    let near = |(a, b): (&f32, &f32)| (a - b).abs() < 0.5 * 2.3 / 255.0;
    let values = again.pixels.iter().flatten();
    assert!(values.zip(image.pixels.iter().flatten()).all(near));
});
