//! Any bytes as GRF: what is read must be valid, and must be the same after writing and reading.
#![no_main]

use azulejo_formats::{Memory, grf};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    // The file includes itself, and files that are there.
    let files = Memory::new()
        .with(
            "lamp.grf",
            "light begin (0, 0, 1) (1, 0, 0) (0, 1, 0) end light",
        )
        .with("a.brdf", "begin brdf model lewis param n 3 end brdf")
        .with("fuzz.grf", bytes);
    let Ok(loaded) = grf::read(bytes, "fuzz.grf", &files) else {
        return;
    };
    loaded
        .scene
        .validate()
        .expect("a reader gives valid scenes");
    let mut text = Vec::new();
    grf::write(&loaded.scene, &mut text).expect("memory takes everything");
    let again = grf::read(&text, "again.grf", &files).expect("what is written is read");
    assert_eq!(
        again.scene,
        loaded.scene,
        "{}",
        String::from_utf8_lossy(&text)
    );

    let (document, _) = grf::GrfDocument::parse(bytes, "fuzz.grf", &files).expect("it was read");
    let mut text = Vec::new();
    document.write(&mut text).expect("memory takes everything");
    let (again, _) = grf::GrfDocument::parse(&text, "fuzz.grf", &files).expect("it was written");
    let mut twice = Vec::new();
    again.write(&mut twice).expect("memory takes everything");
    assert_eq!(text, twice, "{}", String::from_utf8_lossy(&text));

    let text = grf::GrfText::parse(bytes.to_vec(), "fuzz.grf", &files).expect("it was read");
    let _ = text.lit(&loaded.scene, &files);
});
