//! Any bytes as points with normals, as points beside normals, and as rays: what is read must be
//! finite, with directions.
#![no_main]

use azulejo_cli::points::{read_points, read_rays};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let path = std::env::temp_dir().join(format!("azulejo-fuzz-{}.points", std::process::id()));
    std::fs::write(&path, bytes).expect("a temporary folder");
    for normals in [None, Some(&*path)] {
        for point in read_points(&path, normals).into_iter().flatten() {
            assert!(point.position.is_finite() && point.normal.is_normalized());
        }
    }
    for ray in read_rays(&path).into_iter().flatten() {
        assert!(ray.origin.is_finite() && ray.direction.length_squared() > 0.0);
        assert!(ray.t_min >= 0.0 && !ray.t_max.is_nan());
    }
});
