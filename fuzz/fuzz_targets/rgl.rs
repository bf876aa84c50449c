//! Any bytes as RGL's tensor file: what is read can be evaluated and sampled.
#![no_main]

use azulejo_formats::brdf::rgl;
use azulejo_scene::brdf::{Brdf, Content, Description, Measured};
use glam::DVec3;
use libfuzzer_sys::fuzz_target;
use std::sync::Arc;

fuzz_target!(|bytes: &[u8]| {
    if let Ok((rgl, _)) = rgl::read(bytes, "fuzz.bsdf") {
        evaluate(Measured::Rgl(Box::new(rgl)));
    }
});

fn evaluate(measured: Measured) {
    let content = Arc::new(Content::Measured(Arc::new(measured)));
    let file = Description::File {
        path: "fuzz".to_owned(),
        content: Some(content),
    };
    let brdf = Brdf::new(file).expect("what is read is a model");
    for wo in [
        DVec3::Z,
        DVec3::new(0.6, 0.0, 0.8),
        DVec3::new(1.0, 0.0, 1e-9),
    ] {
        for wi in [
            DVec3::Z,
            DVec3::new(-0.6, 0.0, 0.8),
            DVec3::new(0.0, 1.0, 1e-9),
        ] {
            assert!(brdf.eval(wo, wi).is_finite() && brdf.pdf(wo, wi).is_finite());
        }
        for u in [[0.1, 0.2, 0.3], [0.9, 0.0, 0.9], [0.5, 0.999, 0.5]] {
            let sample = brdf.sample(wo, u);
            assert!(sample.is_none_or(|s| s.weight.is_finite() && s.wi.is_finite()));
        }
    }
}
