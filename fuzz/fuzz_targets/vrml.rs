//! Any bytes as VRML97 or classic X3D: what is read must be valid. A header is put before what has
//! none, and a file of prototypes stands beside it.
#![no_main]

use azulejo_formats::{Lod, Memory, ReadOptions, vrml};
use libfuzzer_sys::fuzz_target;

const PARTS: &str = "#VRML V2.0 utf8\nPROTO A [ field SFNode n NULL field SFFloat r 1 ] {
  Shape { appearance IS n geometry Sphere { radius IS r } } }\nEXTERNPROTO B [ ] \"b.wrl\" B { }";

fuzz_target!(|bytes: &[u8]| {
    let text = match bytes.starts_with(b"#VRML V2") || bytes.starts_with(b"#X3D") {
        true => bytes.to_vec(),
        false => [b"#VRML V2.0 utf8\n", bytes].concat(),
    };
    let files = Memory::new()
        .with("a.wrl", PARTS)
        .with("b.wrl", PARTS.replace("b.wrl", "a.wrl#B"));
    for lod in [Lod::Finest, Lod::Coarsest, Lod::All] {
        let options = ReadOptions {
            lod,
            ..ReadOptions::in_proportion(text.len())
        };
        if let Ok(loaded) = vrml::read(&text, "fuzz.wrl", &files, &options) {
            loaded
                .scene
                .validate()
                .expect("a reader gives valid scenes");
        }
    }
});
