//! Any bytes as KTX2, also behind the bytes that all files begin with: what is read must be whole, and the same after
//! writing and reading, as far as half floats hold it.
#![no_main]

use azulejo_formats::picture::ktx2::{self, Ktx2Texels};
use azulejo_scene::Image;
use libfuzzer_sys::fuzz_target;

const START: &[u8; 12] = b"\xabKTX 20\xbb\r\n\x1a\n";

fuzz_target!(|bytes: &[u8]| {
    check(bytes);
    check(&[START, bytes].concat());
});

fn check(bytes: &[u8]) {
    let Ok(image) = ktx2::read(bytes) else {
        return;
    };
    let count = image.width as usize * image.height as usize;
    assert_eq!(image.pixels.len(), count);
    if count == 0 {
        return;
    }
    let mut file = Vec::new();
    let plain = Image::opaque(image.width, image.height, image.pixels.clone());
    ktx2::write(&plain, Ktx2Texels::Half, 1, &mut file).expect("a vector takes all");
    let again = ktx2::read(&file).expect("what is written is read");
    assert_eq!((again.width, again.height), (image.width, image.height));
    let mut volume = Vec::new();
    let layers = [plain.clone(), plain];
    ktx2::write_volume(&layers, Ktx2Texels::SharedExponent, &mut volume)
        .expect("a vector takes all");
    let first = ktx2::read(&volume).expect("the first layer of a volume is read");
    assert_eq!(first.pixels.len(), count);
}
