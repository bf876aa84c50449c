//! A baked model and its copies, and apps that load them.

use azulejo_lightmap::AzulejoLightmapPlugin;
use bevy::asset::io::AssetSourceBuilder;
use bevy::asset::io::memory::{Dir, MemoryAssetReader};
use bevy::asset::{AssetServer, RecursiveDependencyLoadState};
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::world_serialization::WorldInstanceReady;
use serde_json::Value;
use std::path::Path;

/// Squares of 1 m in the plane y = 0, at x = -1.5, 0 and 1.5: `grey`, `red` and the first once more, mirrored. The sun
/// is to the right, 30° high. A black blind, which is seen beside the red square, throws its shadow on the quarter of
/// positive x and z. From `azulejo bake squares.glb -o squares.glb --size 32 --pages 2`.
pub const SQUARES: &[u8] = include_bytes!("../squares.glb");

/// The illuminance of the squares outside of the shadow (lx).
pub const ILLUMINANCE: f32 = 1000.0;

/// The squares with a changed description.
pub fn squares(edit: impl FnOnce(&mut Value)) -> Vec<u8> {
    let (mut json, rest) = parts();
    edit(&mut json);
    let mut json = json.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let lengths = [20 + json.len() + rest.len(), json.len()];
    let [all, chunk] = lengths.map(|length| u32::try_from(length).unwrap().to_le_bytes());
    [
        b"glTF",
        &2_u32.to_le_bytes()[..],
        &all,
        &chunk,
        b"JSON",
        &json,
        rest,
    ]
    .concat()
}

/// The description of the squares.
pub fn described() -> Value {
    parts().0
}

/// The description and the chunks after it.
fn parts() -> (Value, &'static [u8]) {
    let length = u32::from_le_bytes(SQUARES[12..16].try_into().unwrap());
    let (json, rest) = SQUARES[20..].split_at(length as usize);
    (serde_json::from_slice(json).unwrap(), rest)
}

/// An app whose assets are one file.
pub fn app(name: &str, file: Vec<u8>, render: RenderPlugin) -> App {
    let folder = Dir::default();
    folder.insert_asset(Path::new(name), file);
    let reader = move || {
        Box::new(MemoryAssetReader {
            root: folder.clone(),
        }) as Box<_>
    };
    let mut app = App::new();
    app.register_asset_source(None, AssetSourceBuilder::new(reader))
        .add_plugins((DefaultPlugins.set(render), AzulejoLightmapPlugin))
        .insert_resource(GlobalAmbientLight::NONE);
    app
}

/// Loads the first scene of the file and runs the app until the scene is there.
pub fn spawn(app: &mut App, name: &str) {
    #[derive(Default, Resource)]
    struct IsThere(bool);
    app.init_resource::<IsThere>()
        .add_observer(|_: On<WorldInstanceReady>, mut is_there: ResMut<IsThere>| is_there.0 = true);
    app.finish();
    app.cleanup();
    let path = GltfAssetLabel::Scene(0).from_asset(name.to_owned());
    let scene = app.world().resource::<AssetServer>().load(path);
    app.world_mut().spawn(WorldAssetRoot(scene.clone()));
    while !app.world().resource::<IsThere>().0 {
        let state = app
            .world()
            .resource::<AssetServer>()
            .recursive_dependency_load_state(&scene);
        assert!(
            !matches!(state, RecursiveDependencyLoadState::Failed(_)),
            "{name}: {state:?}"
        );
        app.update();
    }
}
