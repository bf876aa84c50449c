//! Any bytes as points with normals, and as rays: what is read must be finite, with directions.
#![no_main]

use azulejo_cli::parsers::{parse_points, parse_rays};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    for point in parse_points(bytes).into_iter().flatten() {
        assert!(point.position.is_finite() && point.normal.is_normalized());
    }
    for ray in parse_rays(bytes).into_iter().flatten() {
        assert!(ray.origin.is_finite() && ray.direction.length_squared() > 0.0);
        assert!(ray.t_min >= 0.0 && !ray.t_max.is_nan());
    }
});
