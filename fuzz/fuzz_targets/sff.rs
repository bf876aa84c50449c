//! Any bytes as SFF: what is read must be valid, and what is written of it must be read again.
#![no_main]

use azulejo_formats::{Memory, ReadOptions, sff};
use libfuzzer_sys::fuzz_target;

const FONT: &str = "/A 1 3 l 0 0 l 1 0 c 1 1 .5 2 0 1\n/B 1 4 l 0 0 l 1 0 l 1 1 l 0 1\n";

fuzz_target!(|bytes: &[u8]| {
    let files = Memory::new()
        .with("f.ppf", FONT)
        .with("f.ppe", "65/A\n66/B\n")
        .with("t.t3d", "AT 0 0 0 \"AB\"\n")
        .with("p.pic", [&[2, 0, 2, 0][..], &[9; 12]].concat());
    let options = ReadOptions::in_proportion(bytes.len());
    let Ok(loaded) = sff::read(bytes, "fuzz.sff", &files, &options) else {
        return;
    };
    loaded
        .scene
        .validate()
        .expect("a reader gives valid scenes");
    let mut text = Vec::new();
    let beside = sff::write(&loaded.scene, "again", &mut text).expect("memory takes everything");
    let files = beside
        .into_iter()
        .fold(files, |files, (name, bytes)| files.with(name, bytes));
    // Rounding may make what was barely a shape none at all, so an error is not a fault here.
    if let Ok(again) = sff::read(&text, "again.sff", &files, &ReadOptions::default()) {
        again.scene.validate().expect("a reader gives valid scenes");
    }
});
