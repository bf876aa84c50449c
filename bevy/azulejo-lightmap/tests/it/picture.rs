use crate::model::{self, ILLUMINANCE};
use bevy::camera::{Exposure, Hdr, RenderTarget, ScalingMode};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::gpu_readback::{Readback, ReadbackComplete};
use bevy::render::render_resource::{TextureFormat, TextureUsages};
use std::f32::consts::PI;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

/// The picture: 64 × 16 pixels of 16 bytes for 4 m × 1 m, from above. Rows of a multiple of 256 bytes are read back
/// without gaps.
const SIZE: [u32; 2] = [64, 16];

/// Of the camera, so that the squares are about as bright as 1.
const EV100: f32 = 7.0;

#[derive(Default, Resource)]
struct Picture(Vec<[f32; 4]>);

impl Picture {
    /// The linear colour of a place (m).
    fn at(&self, x: f32, z: f32) -> [f32; 3] {
        let [width, height] = SIZE.map(|size| size as f32);
        let (column, row) = ((x + 2.0) / 4.0 * width, (z + 0.5) * height);
        let [r, g, b, _] = self.0[row as usize * SIZE[0] as usize + column as usize];
        [r, g, b]
    }
}

/// An app that renders, unless there is no driver for a graphics card, and `AZULEJO_REQUIRE` does not demand one.
fn renderer() -> Option<App> {
    let render = RenderPlugin {
        synchronous_pipeline_compilation: true,
        ..default()
    };
    let app = || model::app("squares.glb", model::SQUARES.to_vec(), render);
    catch_unwind(AssertUnwindSafe(app))
        .map(Some)
        .unwrap_or_else(|cause| {
            let text = cause.downcast_ref::<String>().map_or("", String::as_str);
            let is_required =
                std::env::var("AZULEJO_REQUIRE").is_ok_and(|needs| needs.contains("gpu"));
            if is_required || !text.contains("Unable to find a GPU") {
                resume_unwind(cause);
            }
            None
        })
}

fn add_camera(app: &mut App) {
    let [width, height] = SIZE;
    let mut target = Image::new_target_texture(width, height, TextureFormat::Rgba32Float, None);
    target.texture_descriptor.usage |= TextureUsages::COPY_SRC;
    let target = app.world_mut().resource_mut::<Assets<Image>>().add(target);
    app.world_mut().spawn((
        Camera3d::default(),
        RenderTarget::Image(target.clone().into()),
        Projection::from(OrthographicProjection {
            scaling_mode: ScalingMode::Fixed {
                width: 4.0,
                height: 1.0,
            },
            ..OrthographicProjection::default_3d()
        }),
        Transform::from_xyz(0.0, 5.0, 0.0).looking_at(Vec3::ZERO, Vec3::NEG_Z),
        (Hdr, Msaa::Off, Tonemapping::None, Exposure { ev100: EV100 }),
    ));
    app.init_resource::<Picture>();
    app.world_mut().spawn(Readback::texture(target)).observe(
        |read: On<ReadbackComplete>, mut picture: ResMut<Picture>| {
            let numbers = read.data.chunks_exact(4);
            let numbers: Vec<f32> = numbers
                .map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap()))
                .collect();
            picture.0 = numbers
                .chunks_exact(4)
                .map(|pixel| pixel.try_into().unwrap())
                .collect();
        },
    );
}

/// The squares' light is the same everywhere, but in the shadow on one quarter of the red one: coordinates that are
/// turned or flipped would show it elsewhere.
#[test]
fn matt_surfaces_show_reflectance_times_irradiance_over_pi() {
    let Some(mut app) = renderer() else {
        eprintln!("skipped: no driver for a graphics card");
        return;
    };
    add_camera(&mut app);
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
        let shown = app.world().resource::<Picture>().at(x, z);
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
