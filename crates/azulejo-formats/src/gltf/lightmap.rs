//! Lightmaps as the file has them: `MOZ_lightmap` of materials, `MX_lightmap` of nodes.
//!
//! Both name a texture whose decoded texels, times an intensity, are irradiance.

use super::material::{GltfCoordinates, transform_matrix};
use glam::{DAffine2, DMat2, DVec2};
use gltf_json::extensions::texture::TextureTransform;
use gltf_json::{Index, Root};
use serde_json::Value;
use std::f64::consts::PI;

/// The lightmap of a material.
pub(super) const OF_MATERIALS: &str = "MOZ_lightmap";

/// The lightmap of a node.
pub(super) const OF_NODES: &str = "MX_lightmap";

/// The set of texture coordinates where none is named, by `MOZ_lightmap`.
const USUAL_SET: u32 = 1;

/// A lightmap that a material or a node names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct NamedLightmap {
    /// The texture, which is in the file.
    pub texture: Index<gltf_json::Texture>,
    /// Irradiance of a decoded texel of 1, >= 0.
    pub scale: f64,
    /// Where its picture lies.
    pub coordinates: GltfCoordinates,
}

/// Reads the extension of a material. That of an unlit one is its colour, undivided by π: irradiance that a
/// matt surface of its colour shows so is π times as much.
///
/// # Errors
/// What is wrong with it.
pub(super) fn of_material(
    extension: &Value,
    is_unlit: bool,
    root: &Root,
) -> Result<NamedLightmap, String> {
    let transform = extension
        .get("extensions")
        .and_then(|e| e.get("KHR_texture_transform"));
    let transform: Option<TextureTransform> = match transform {
        Some(transform) => Some(
            serde_json::from_value(transform.clone())
                .map_err(|_| "an invalid KHR_texture_transform")?,
        ),
        None => None,
    };
    let set = set_of(extension)?;
    let factor = if is_unlit { PI } else { 1.0 };
    Ok(NamedLightmap {
        texture: texture_of(extension, root)?,
        scale: intensity_of(extension)? * factor,
        coordinates: GltfCoordinates {
            set: transform.as_ref().and_then(|t| t.tex_coord).unwrap_or(set),
            picture_from_uv: transform
                .as_ref()
                .map_or(DAffine2::IDENTITY, transform_matrix),
        },
    })
}

/// Reads the extension of a node, whose picture is named in it or in its `lightMapTexture`.
///
/// # Errors
/// What is wrong with it.
pub(super) fn of_node(extension: &Value, root: &Root) -> Result<NamedLightmap, String> {
    let picture = extension.get("lightMapTexture").unwrap_or(extension);
    let [offset, scale] = [("offset", DVec2::ZERO), ("scale", DVec2::ONE)].map(|(key, usual)| {
        let Some(given) = extension.get(key) else {
            return Ok(usual);
        };
        let pair: Option<[f64; 2]> = serde_json::from_value(given.clone()).ok();
        pair.map(DVec2::from)
            .filter(|pair| pair.is_finite())
            .ok_or_else(|| format!("{key} is not a pair of numbers"))
    });
    Ok(NamedLightmap {
        texture: texture_of(picture, root)?,
        scale: intensity_of(extension)?,
        coordinates: GltfCoordinates {
            set: set_of(picture)?,
            picture_from_uv: DAffine2::from_mat2_translation(DMat2::from_diagonal(scale?), offset?),
        },
    })
}

fn texture_of(picture: &Value, root: &Root) -> Result<Index<gltf_json::Texture>, String> {
    let given = picture.get("index").ok_or("it names no texture")?;
    let index = given.as_u64().and_then(|i| u32::try_from(i).ok());
    let index = index.ok_or_else(|| "its texture has no index".to_owned())?;
    let count = root.textures.len();
    if index as usize >= count {
        return Err(format!("texture {index} of {count}"));
    }
    Ok(Index::new(index))
}

fn set_of(picture: &Value) -> Result<u32, String> {
    let Some(given) = picture.get("texCoord") else {
        return Ok(USUAL_SET);
    };
    let set = given.as_u64().and_then(|set| u32::try_from(set).ok());
    set.ok_or_else(|| "texCoord is not the number of a set".to_owned())
}

fn intensity_of(extension: &Value) -> Result<f64, String> {
    let Some(given) = extension.get("intensity") else {
        return Ok(1.0);
    };
    let intensity = given.as_f64().filter(|i| *i >= 0.0 && i.is_finite());
    intensity.ok_or_else(|| "intensity is not a number >= 0".to_owned())
}
