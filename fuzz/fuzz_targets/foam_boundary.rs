//! Any bytes as `polyMesh/boundary` of OpenFOAM: patches take no more than their text.
#![no_main]

use azulejo_exchange::files::openfoam::read_boundary;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(patches) = read_boundary(bytes, "boundary") {
        let words = |p: &azulejo_exchange::files::openfoam::BoundaryPatch| 1 + p.groups.len();
        assert!(patches.iter().map(words).sum::<usize>() <= bytes.len());
    }
});
