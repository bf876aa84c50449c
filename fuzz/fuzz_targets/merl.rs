//! Any bytes as a MERL table: what is read can be evaluated and sampled. The first three bytes
//! choose sizes, because a table of the database's own takes 33 MB.
#![no_main]

use azulejo_formats::brdf::merl;
use azulejo_scene::brdf::{Brdf, Content, Description, Measured};
use glam::DVec3;
use libfuzzer_sys::fuzz_target;
use std::sync::Arc;

fuzz_target!(|bytes: &[u8]| {
    // As the file begins, by the reader of files.
    let _ = merl::read(bytes, "fuzz.binary");
    let Some((sizes, bytes)) = bytes.split_first_chunk::<3>() else {
        return;
    };
    let sizes = sizes.map(|size| usize::from(size % 6));
    let Ok((merl, warnings)) = merl::read_sized(bytes, "fuzz.binary", sizes) else {
        return;
    };
    let count: usize = warnings.iter().map(|w| w.count).sum();
    assert!(count <= 3 * sizes.iter().product::<usize>() + 1);
    evaluate(Measured::Merl(merl));
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
