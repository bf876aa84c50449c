//! Any bytes as a model part of 3MF, in a package: what is read must be valid.
#![no_main]

use azulejo_formats::{Memory, ReadOptions, three_mf};
use libfuzzer_sys::fuzz_target;
use std::io::{Cursor, Write};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

fuzz_target!(|bytes: &[u8]| {
    let options = ReadOptions::in_proportion(bytes.len());
    // Checksums would keep most changes away from the reader of the parts.
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let stored = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    zip.start_file("3D/a.model", stored).expect("a part");
    zip.write_all(bytes).expect("memory");
    let package = zip.finish().expect("a package").into_inner();
    let packages = [package.as_slice(), bytes];
    for bytes in packages {
        let Ok(loaded) = three_mf::read(bytes, "fuzz.3mf", &Memory::new(), &options) else {
            continue;
        };
        loaded
            .scene
            .validate()
            .expect("a reader gives valid scenes");
    }
});
