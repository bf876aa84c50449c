//! Any bytes as MGF: what is read must be valid. They may include themselves, a file of
//! materials, and a luminaire with a body.
#![no_main]

use azulejo_formats::{Memory, ReadOptions, mgf};
use libfuzzer_sys::fuzz_target;

const MATERIALS: &str = "c k =\ncct 3000\nm m =\nrd .5\nm e =\ned 9\nv v =\np 1 2 3\nn 0 0 1\n";
const LUMINAIRE: &str = "GEOM=b.mgf\nTILT=NONE\n1 1 1 2 1 1 2 1 1 0\n1 1 1\n0 90\n0\n9 9\n";

fuzz_target!(|bytes: &[u8]| {
    let options = ReadOptions::in_proportion(bytes.len());
    let files = Memory::new()
        .with("a.mgf", MATERIALS)
        .with("b.mgf", bytes)
        .with("l.ies", LUMINAIRE)
        .with("d/l.ies", LUMINAIRE);
    if let Ok(loaded) = mgf::read(bytes, "fuzz.mgf", &files, &options) {
        loaded
            .scene
            .validate()
            .expect("a reader gives valid scenes");
    }
});
