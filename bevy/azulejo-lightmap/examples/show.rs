//! Shows a baked model: `cargo run --example show --features window -- baked.glb`. Keys W, A, S, D, Q and E move the
//! camera, and the mouse turns it while its right button is held.

use azulejo_lightmap::AzulejoLightmapPlugin;
use bevy::camera::Exposure;
use bevy::camera_controller::free_camera::{FreeCamera, FreeCameraPlugin};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::prelude::*;
use std::error::Error;
use std::path::PathBuf;

/// The exposure of the camera, for about 500 lx.
const EV100: f32 = 8.0;

#[derive(Resource)]
struct Model(String);

fn main() -> Result<(), Box<dyn Error>> {
    let usage = "usage: show MODEL.glb";
    let path = PathBuf::from(std::env::args_os().nth(1).ok_or(usage)?).canonicalize()?;
    let folder = path
        .parent()
        .and_then(|folder| folder.to_str())
        .ok_or(usage)?;
    let name = path
        .file_name()
        .and_then(|name| name.to_str())
        .ok_or(usage)?;
    let assets = AssetPlugin {
        file_path: folder.to_owned(),
        ..default()
    };
    App::new()
        .add_plugins((
            DefaultPlugins.set(assets),
            FreeCameraPlugin,
            AzulejoLightmapPlugin,
        ))
        // Bevy adds 80 cd/m² everywhere by default.
        .insert_resource(GlobalAmbientLight::NONE)
        .insert_resource(Model(name.to_owned()))
        .add_systems(Startup, set_up)
        .run();
    Ok(())
}

fn set_up(mut commands: Commands, assets: Res<AssetServer>, model: Res<Model>) {
    let scene = GltfAssetLabel::Scene(0).from_asset(model.0.clone());
    commands.spawn(WorldAssetRoot(assets.load(scene)));
    commands.spawn((
        Camera3d::default(),
        Transform::from_xyz(0.0, 1.6, 4.0),
        FreeCamera::default(),
        Exposure { ev100: EV100 },
        Tonemapping::AcesFitted,
    ));
}
