#![doc = include_str!("../README.md")]

use bevy::asset::{AssetEventSystems, LoadContext};
use bevy::gltf::extensions::{
    ErasedGltfExtensionHandler, GltfExtensionHandler, GltfExtensionHandlers,
};
use bevy::gltf::gltf::{self, Material, Primitive, Texture};
use bevy::pbr::Lightmap;
use bevy::prelude::*;
use bevy::tasks::block_on;
use serde::Deserialize;
use std::collections::HashSet;
use std::f32::consts::PI;

/// The extension of materials that is read.
const MOZ_LIGHTMAP: &str = "MOZ_lightmap";

/// Gives meshes of glTF models a [`Lightmap`] and a [`LightmapExposure`], if their material has `MOZ_lightmap`.
///
/// It may be added before or after the plug-ins of Bevy. A lightmap that Bevy cannot show, or that is damaged, is left
/// out, with a warning that names the file, the material and the reason.
pub struct AzulejoLightmapPlugin;

impl Plugin for AzulejoLightmapPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Lightmap>()
            .register_type::<LightmapExposure>()
            // Before changes of assets are collected: else a mesh has the wrong brightness in its first frame.
            .add_systems(PostUpdate, expose.before(AssetEventSystems));
        let handlers = app
            .world_mut()
            .get_resource_or_init::<GltfExtensionHandlers>();
        block_on(handlers.0.write()).push(Box::new(LightmapHandler::default()));
    }
}

/// What `lightmap_exposure` of the [`StandardMaterial`] of a mesh becomes, once the mesh is spawned: the intensity of
/// its lightmap, divided by π.
///
/// Bevy shows base colour × texel × `lightmap_exposure`, then the exposure of the camera. A matt surface of the
/// reflectance ρ shows ρE/π, where E = intensity × texel is the illuminance in lx (or W/m², if the model says so).
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component)]
pub struct LightmapExposure(pub f32);

fn expose(
    meshes: Query<(&LightmapExposure, &MeshMaterial3d<StandardMaterial>), Added<LightmapExposure>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    for (exposure, material) in &meshes {
        if let Some(mut material) = materials.get_mut(&material.0) {
            material.lightmap_exposure = exposure.0;
        }
    }
}

/// What a material has under [`MOZ_LIGHTMAP`].
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct LightmapInfo {
    index: usize,
    #[serde(default = "usual_set")]
    tex_coord: u32,
    #[serde(default = "usual_intensity")]
    intensity: f32,
    #[serde(default)]
    extensions: InfoExtensions,
}

fn usual_set() -> u32 {
    1
}

fn usual_intensity() -> f32 {
    1.0
}

#[derive(Default, Deserialize)]
struct InfoExtensions {
    #[serde(rename = "KHR_texture_transform")]
    transform: Option<serde::de::IgnoredAny>,
}

/// Reads lightmaps while a file is loaded. Bevy makes a copy for each file.
#[derive(Default)]
struct LightmapHandler {
    /// Those of the file, by their index.
    textures: Vec<Handle<Image>>,
    /// Warnings so far: several meshes may have the same material.
    said: HashSet<String>,
}

impl GltfExtensionHandler for LightmapHandler {
    fn dyn_clone(&self) -> Box<dyn ErasedGltfExtensionHandler> {
        Box::new(Self::default())
    }

    fn on_texture(&mut self, _: &Texture, image: Handle<Image>) {
        self.textures.push(image);
    }

    fn on_spawn_mesh_and_material(
        &mut self,
        context: &mut LoadContext<'_>,
        primitive: &Primitive,
        mesh: &gltf::Mesh,
        material: &Material,
        entity: &mut EntityWorldMut,
        _: &str,
    ) {
        let Some(entry) = material.extension_value(MOZ_LIGHTMAP) else {
            return;
        };
        let shown = LightmapInfo::deserialize(entry)
            .map_err(|error| error.to_string())
            .and_then(|info| self.components(&info))
            .and_then(|shown| check_surface(primitive, mesh, material).map(|()| shown));
        match shown {
            Ok(components) => drop(entity.insert(components)),
            Err(fault) => self.warn(context, material, &fault),
        }
    }
}

impl LightmapHandler {
    /// What a mesh with the lightmap gets.
    ///
    /// # Errors
    /// Why Bevy cannot show it.
    fn components(&self, info: &LightmapInfo) -> Result<(Lightmap, LightmapExposure), String> {
        if !(info.intensity >= 0.0 && info.intensity.is_finite()) {
            return Err(format!("its intensity is {}", info.intensity));
        }
        if info.tex_coord != 1 {
            let set = info.tex_coord;
            return Err(format!(
                "it is on TEXCOORD_{set}, and Bevy takes TEXCOORD_1 alone"
            ));
        }
        if info.extensions.transform.is_some() {
            return Err(
                "it has KHR_texture_transform, which Bevy does not apply to lightmaps: \
                        bake without --instances transform"
                    .to_owned(),
            );
        }
        let Some(image) = self.textures.get(info.index).cloned() else {
            return Err(format!(
                "it is texture {} of {}",
                info.index,
                self.textures.len()
            ));
        };
        let lightmap = Lightmap {
            image,
            ..Default::default()
        };
        Ok((lightmap, LightmapExposure(info.intensity / PI)))
    }

    fn warn(&mut self, context: &LoadContext<'_>, material: &Material, fault: &str) {
        // Only the default material has no index, and it has no extensions.
        let named = named(material.name(), material.index().unwrap_or_default());
        let file = context.path();
        let warning = format!("{file}: material {named} is shown without its lightmap: {fault}");
        if self.said.insert(warning.clone()) {
            tracing::warn!("{warning}");
        }
    }
}

/// Checks that Bevy shows lightmaps on a surface. Its shader does not compile if coordinates are missing, which makes the
/// mesh invisible, and does not fit to skins and morph targets, at which Bevy 0.19 and 0.20 quit.
///
/// # Errors
/// Why it does not.
fn check_surface(
    primitive: &Primitive,
    mesh: &gltf::Mesh,
    material: &Material,
) -> Result<(), String> {
    let has = |name| {
        primitive
            .attributes()
            .any(|(semantic, _)| semantic.to_string() == name)
    };
    let place = named(mesh.name(), mesh.index());
    if material.unlit() {
        return Err("it is unlit, and Bevy shows no lightmap there".to_owned());
    }
    if !has("TEXCOORD_1") {
        return Err(format!("mesh {place} has no TEXCOORD_1"));
    }
    if has("JOINTS_0") || primitive.morph_targets().len() > 0 {
        return Err(format!(
            "mesh {place} has a skin or morph targets, and Bevy shows no lightmap there"
        ));
    }
    Ok(())
}

fn named(name: Option<&str>, index: usize) -> String {
    name.map_or(index.to_string(), |name| format!("\"{name}\""))
}
