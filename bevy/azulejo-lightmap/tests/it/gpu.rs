//! Pictures as numbers.

use crate::model;
use bevy::camera::{Exposure, Hdr, RenderTarget, ScalingMode};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::gpu_readback::{Readback, ReadbackComplete};
use bevy::render::render_resource::{TextureFormat, TextureUsages};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

/// What the camera shows: floats of pixels from the upper left.
#[derive(Default, Resource)]
struct Picture(Vec<u8>);

/// A camera without perspective. Rows of a multiple of 256 bytes (16 pixels) are read back without gaps.
pub struct Plan {
    /// Pixels.
    pub size: [u32; 2],
    /// Metres.
    pub extent: [f32; 2],
    pub transform: Transform,
    pub ev100: f32,
}

impl Plan {
    /// The linear colour at a place that the camera sees.
    pub fn shown(&self, app: &App, place: Vec3) -> [f32; 3] {
        let seen = self.transform.rotation.inverse() * (place - self.transform.translation);
        let share = Vec2::from([seen.x, -seen.y]) / Vec2::from(self.extent) + 0.5;
        let pixel = (share * UVec2::from(self.size).as_vec2()).as_uvec2();
        let at = 16 * (pixel.y * self.size[0] + pixel.x) as usize;
        let bytes = &app.world().resource::<Picture>().0[at..at + 12];
        [0, 4, 8].map(|k| f32::from_le_bytes(bytes[k..k + 4].try_into().unwrap()))
    }

    /// Adds the camera to an app.
    pub fn spawn(&self, app: &mut App) {
        let [width, height] = self.size;
        let mut target = Image::new_target_texture(width, height, TextureFormat::Rgba32Float, None);
        target.texture_descriptor.usage |= TextureUsages::COPY_SRC;
        let target = app.world_mut().resource_mut::<Assets<Image>>().add(target);
        app.world_mut().spawn((
            Camera3d::default(),
            RenderTarget::Image(target.clone().into()),
            Projection::from(OrthographicProjection {
                scaling_mode: ScalingMode::Fixed {
                    width: self.extent[0],
                    height: self.extent[1],
                },
                ..OrthographicProjection::default_3d()
            }),
            self.transform,
            (
                Hdr,
                Msaa::Off,
                Tonemapping::None,
                Exposure { ev100: self.ev100 },
            ),
        ));
        app.init_resource::<Picture>();
        app.world_mut().spawn(Readback::texture(target)).observe(
            |read: On<ReadbackComplete>, mut picture: ResMut<Picture>| {
                picture.0.clone_from(&read.data);
            },
        );
    }
}

/// An app that renders, unless there is no driver for a graphics card, and `AZULEJO_REQUIRE` does not demand one. Its
/// assets are one file.
pub fn renderer(name: &str, file: &[u8]) -> Option<App> {
    let render = RenderPlugin {
        synchronous_pipeline_compilation: true,
        ..default()
    };
    let app = || model::app(name, file.to_vec(), render);
    catch_unwind(AssertUnwindSafe(app))
        .map(Some)
        .unwrap_or_else(|cause| {
            let text = cause.downcast_ref::<String>().map_or("", String::as_str);
            let is_required =
                std::env::var("AZULEJO_REQUIRE").is_ok_and(|needs| needs.contains("gpu"));
            if is_required || !text.contains("Unable to find a GPU") {
                resume_unwind(cause);
            }
            eprintln!("skipped: no driver for a graphics card");
            None
        })
}
