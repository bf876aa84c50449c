//! Any text as VRML 1.0, which may have another file and itself inside: what is read must be
//! valid, at every level of detail.
#![no_main]

use azulejo_formats::{Lod, Memory, ReadOptions, vrml};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let (kind, body) = bytes.split_first().unwrap_or((&0, &[]));
    let header: &[u8] = match kind % 2 {
        0 => b"#VRML V1.0 ascii\n",
        _ => b"#Inventor V2.1 ascii\n",
    };
    let lod = match kind / 64 {
        0 => Lod::Finest,
        1 => Lod::Coarsest,
        2 => Lod::All,
        _ => Lod::Distance(10.0),
    };
    let text = [header, body].concat();
    let files = Memory::new()
        .with("b.wrl", text.clone())
        .with("c.wrl", "#VRML V2.0 utf8\nShape { geometry Box {} }");
    let options = ReadOptions {
        lod,
        ..ReadOptions::in_proportion(text.len())
    };
    if let Ok(loaded) = vrml::read(&text, "fuzz.wrl", &files, &options) {
        let valid = loaded.scene.validate();
        valid.expect("a reader gives valid scenes");
    }
});
