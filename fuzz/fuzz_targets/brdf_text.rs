//! Any bytes as a file of a reflection model: what is read must be the same after writing and
//! reading, and be made into the same model.
#![no_main]

use azulejo_formats::{Memory, brdf};
use azulejo_scene::Brdf;
use azulejo_scene::brdf::Content;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    // The file may name itself as measured data.
    let files = Memory::new().with("fuzz.brdf", bytes);
    let Ok(read) = brdf::text::read(bytes, "fuzz.brdf", &files) else {
        return;
    };
    let Content::Text(description) = read.content else {
        return;
    };
    Brdf::new(description.clone()).expect("a reader gives possible models");
    let mut text = Vec::new();
    brdf::text::write(&description, &mut text).expect("memory takes everything");
    let again = brdf::text::read(&text, "again.brdf", &files).expect("what is written is read");
    assert_eq!(
        again.content,
        Content::Text(description),
        "{}",
        String::from_utf8_lossy(&text)
    );
});
