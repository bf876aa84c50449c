//! Any bytes as DXF: what is read must be valid, and not much more than the bytes.
#![no_main]

use azulejo_formats::{Memory, ReadOptions, dxf};
use libfuzzer_sys::fuzz_target;

/// What external references lead to: a face, a block, and a way back.
const PART: &str = "0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n2\na\n70\n4\n1\np.dxf\n0\nENDBLK\n0\nENDSEC\n\
    0\nSECTION\n2\nENTITIES\n0\nINSERT\n2\na\n0\n3DFACE\n11\n1\n22\n1\n0\nENDSEC\n0\nEOF\n";

fuzz_target!(|bytes: &[u8]| {
    let options = ReadOptions::in_proportion(bytes.len());
    let files = Memory::new().with("p.dxf", PART);
    let Ok(loaded) = dxf::read(bytes, "fuzz.dxf", &files, &options) else {
        return;
    };
    loaded
        .scene
        .validate()
        .expect("a reader gives valid scenes");
    assert!(!loaded.scene.objects.is_empty() || !loaded.warnings.is_empty());
});
