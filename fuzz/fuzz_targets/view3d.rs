//! Any bytes as a View3D file: what is read must be valid, and have a row for every face.
#![no_main]

use azulejo_formats::ReadOptions;
use azulejo_formats::view3d::{View3dDocument, View3dModel};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let options = ReadOptions::in_proportion(bytes.len());
    let read = View3dDocument::read(bytes, "fuzz.vs3", &options);
    let model = read.and_then(|(document, _)| View3dModel::new(&document, "fuzz.vs3"));
    if let Ok(model) = model {
        model.scene.validate().expect("a reader gives valid scenes");
        let rows = model.rows.iter().flatten().flatten();
        assert!(rows.clone().all(|&r| (r as usize) < model.names.len()));
    }
});
