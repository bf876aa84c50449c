//! Any bytes as a photometric file, IES and EULUMDAT, and as one that an MGF scene names: what is read must be valid.
#![no_main]

use azulejo_formats::{Memory, ReadOptions, mgf, photometry};
use libfuzzer_sys::fuzz_target;

const SCENE: &[u8] = b"xf -my -t 1 2 3 -s 2\nies l.ies -m 3 -rx 30 -a 2 -t 1 0 0\nxf\n";

fuzz_target!(|bytes: &[u8]| {
    let files = Memory::new()
        .with("l.ies", bytes)
        .with("b.mgf", "v v =\nm e =\ned 9\nsph v 1\n");
    let options = ReadOptions::default();
    let read = mgf::read(SCENE, "fuzz.mgf", &files, &options);
    let loaded = read.expect("the scene is small");
    let mut scenes = vec![loaded.scene];
    for name in ["l.ies", "l.ldt", "l"] {
        let read = photometry::read(bytes, name, &files, &options);
        scenes.extend(read.map(|loaded| loaded.scene));
    }
    for scene in scenes {
        scene.validate().expect("a reader gives valid scenes");
    }
});
