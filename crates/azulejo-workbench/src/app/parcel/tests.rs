use super::*;
use crate::document::Example;
use crate::first_pass::{LightSettings, solve_document};
use azulejo::trace::Progress;
use std::cell::RefCell;

#[test]
fn a_solution_arrives_to_the_last_bit() {
    let document = Example::CornellBox.document().unwrap();
    let settings = LightSettings {
        patches: 100,
        error: 0.2,
        ..LightSettings::default()
    };
    let found = RefCell::new(Vec::new());
    let show = |solution| found.borrow_mut().push(solution);
    solve_document(&document, &settings, true, &Progress::new(), &show).unwrap();
    let found = found.into_inner();
    assert!(found.len() >= 2 && found.iter().any(|s| s.report.is_some()));
    for solution in found {
        let result = JobResult::Light(Box::new(solution.clone()));
        let Some(JobResult::Light(arrived)) = unpack(&pack(&result), &document) else {
            panic!("light arrives as light")
        };
        assert_eq!(arrived.report, solution.report);
        assert!(arrived.shapes().eq(solution.shapes()));
        assert!(arrived.is_of(&document));
    }
}

#[test]
fn pictures_and_damaged_parcels() {
    let image = Image {
        width: 2,
        height: 1,
        pixels: vec![[f32::MIN_POSITIVE, -0.0, 3.5], [0.1, 0.2, f32::MAX]],
        alpha: Some(vec![0.5, 1.0]),
    };
    let bytes = pack(&JobResult::Render(Box::new(image.clone()), 7));
    let document = SceneDocument::default();
    let Some(JobResult::Render(arrived, 7)) = unpack(&bytes, &document) else {
        panic!("a picture arrives as one")
    };
    assert_eq!(*arrived, image);
    for length in 0..bytes.len() {
        assert!(unpack(&bytes[..length], &document).is_none(), "{length}");
    }
}
