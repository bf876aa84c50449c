//! A picture of a baked model without a window: `cargo run --example picture -- baked.glb camera.json picture.png`.
//!
//! The camera is `{ "eye": [x, y, z], "target": [x, y, z], "up": [0, 1, 0], "vertical_fov": 45, "width": 640,
//! "height": 480 }` with degrees. Radiance × exposure (the fourth argument, or 1) is clipped at 1, which is white.

use azulejo_lightmap::AzulejoLightmapPlugin;
use bevy::camera::{Exposure, RenderTarget};
use bevy::core_pipeline::tonemapping::{DebandDither, Tonemapping};
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::render_resource::TextureFormat;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured, save_to_disk};
use bevy::world_serialization::WorldInstanceReady;
use serde::Deserialize;
use std::error::Error;
use std::fs;
use std::path::PathBuf;

/// Frames after the scene is there, in which its pictures and pipelines get ready.
const FRAMES: u32 = 20;

#[derive(Deserialize)]
struct View {
    eye: [f32; 3],
    target: [f32; 3],
    up: [f32; 3],
    vertical_fov: f32,
    width: u32,
    height: u32,
}

#[derive(Default, Resource)]
struct Progress {
    is_loaded: bool,
    is_saved: bool,
}

fn main() -> Result<(), Box<dyn Error>> {
    let usage = "usage: picture MODEL.glb CAMERA.json PICTURE.png [EXPOSURE]";
    let mut arguments = std::env::args().skip(1);
    let mut argument = || arguments.next().ok_or(usage);
    let model = PathBuf::from(argument()?).canonicalize()?;
    let view: View = serde_json::from_slice(&fs::read(argument()?)?)?;
    let picture = argument()?;
    let exposure: f32 = argument().map_or(Ok(1.0), |text| text.parse())?;
    let folder = model.parent().and_then(|f| f.to_str()).ok_or(usage)?;
    let name = model.file_name().and_then(|n| n.to_str()).ok_or(usage)?;

    let assets = AssetPlugin {
        file_path: folder.to_owned(),
        ..default()
    };
    let render = RenderPlugin {
        synchronous_pipeline_compilation: true,
        ..default()
    };
    let mut app = App::new();
    app.add_plugins((
        DefaultPlugins.set(assets).set(render),
        AzulejoLightmapPlugin,
    ))
    .insert_resource(GlobalAmbientLight::NONE)
    .insert_resource(ClearColor(Color::BLACK))
    .init_resource::<Progress>()
    .add_observer(
        |_: On<WorldInstanceReady>, mut progress: ResMut<Progress>| {
            progress.is_loaded = true;
        },
    )
    .add_observer(
        |_: On<ScreenshotCaptured>, mut progress: ResMut<Progress>| {
            progress.is_saved = true;
        },
    );
    app.finish();
    app.cleanup();
    let world = app.world_mut();
    let target =
        Image::new_target_texture(view.width, view.height, TextureFormat::Rgba8UnormSrgb, None);
    let target = world.resource_mut::<Assets<Image>>().add(target);
    world.spawn((
        Camera3d::default(),
        RenderTarget::Image(target.clone().into()),
        Projection::from(PerspectiveProjection {
            fov: view.vertical_fov.to_radians(),
            ..default()
        }),
        Transform::from_translation(view.eye.into())
            .looking_at(view.target.into(), Vec3::from(view.up)),
        // Bevy's exposure is 1 / (1.2 × 2^EV).
        Exposure {
            ev100: -(1.2 * exposure).log2(),
        },
        Tonemapping::None,
        DebandDither::Disabled,
    ));
    let scene = GltfAssetLabel::Scene(0).from_asset(name.to_owned());
    let scene = world.resource::<AssetServer>().load(scene);
    world.spawn(WorldAssetRoot(scene));

    while !app.world().resource::<Progress>().is_loaded {
        app.update();
    }
    (0..FRAMES).for_each(|_| app.update());
    app.world_mut()
        .spawn(Screenshot::image(target))
        .observe(save_to_disk(picture));
    while !app.world().resource::<Progress>().is_saved {
        app.update();
    }
    Ok(())
}
