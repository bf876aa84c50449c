use crate::gpu::{self, Plan};
use crate::model::{self, ILLUMINANCE};
use bevy::camera::Exposure;
use bevy::prelude::*;
use std::f32::consts::PI;

/// Of the camera, so that the squares are about as bright as 1.
const EV100: f32 = 7.0;

/// The squares' light is the same everywhere, but in the shadow on one quarter of the red one: coordinates that are
/// turned or flipped would show it elsewhere.
#[test]
fn matt_surfaces_show_reflectance_times_irradiance_over_pi() {
    let Some(mut app) = gpu::renderer("squares.glb", model::SQUARES) else {
        return;
    };
    let plan = Plan {
        size: [64, 16],
        extent: [4.0, 1.0],
        transform: Transform::from_xyz(0.0, 5.0, 0.0).looking_at(Vec3::ZERO, Vec3::NEG_Z),
        ev100: EV100,
    };
    plan.spawn(&mut app);
    model::spawn(&mut app, "squares.glb");
    // Pictures go to the card, and pipelines are made, in the frames after the scene is there.
    (0..20).for_each(|_| app.update());
    let [grey, red, shadow] = [[0.5; 3], [0.8, 0.4, 0.2], [0.0; 3]];
    let places = [
        (-1.5, 0.0, grey),
        (-0.23, -0.25, red),
        (-0.23, 0.25, red),
        (0.23, -0.25, red),
        (0.23, 0.25, shadow),
        (1.5, 0.0, grey),
    ];
    let exposure = Exposure { ev100: EV100 }.exposure();
    for (x, z, reflectance) in places {
        let shown = plan.shown(&app, Vec3::new(x, 0.0, z));
        let expected = reflectance.map(|r| r * ILLUMINANCE / PI * exposure);
        for (shown, expected) in shown.into_iter().zip(expected) {
            let error = (shown - expected).abs();
            assert!(
                error <= 0.003 * expected,
                "{x}, {z}: {shown}, expected {expected}"
            );
        }
    }
}
