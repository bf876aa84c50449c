//! Any bytes as each of the three files of an OpenFOAM mesh, and as all of them in one: what is read must be
//! valid.
#![no_main]

use azulejo_formats::{Memory, ReadOptions, openfoam};
use libfuzzer_sys::fuzz_target;

const BOUNDARY: &str =
    "FoamFile { class polyBoundaryMesh; } 1 ( a { type wall; nFaces 1; startFace 0; } )";
const FACES: &str = "FoamFile { class faceList; } 1 ( 3(0 1 2) )";
const POINTS: &str = "FoamFile { class vectorField; } 3 ( (0 0 0) (1 0 0) (0 1 0) )";

fuzz_target!(|bytes: &[u8]| {
    let options = ReadOptions::in_proportion(bytes.len());
    let all = [BOUNDARY, FACES, POINTS].map(str::as_bytes);
    for k in 0..3 {
        let mut texts = all;
        texts[k] = bytes;
        let [boundary, faces, points] = texts;
        let files = Memory::new()
            .with("boundary", boundary)
            .with("faces", faces)
            .with("points", points);
        if let Ok(loaded) = openfoam::read(boundary, "boundary", &files, &options) {
            loaded
                .scene
                .validate()
                .expect("a reader gives valid scenes");
        }
    }
});
