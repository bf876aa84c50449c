//! How a material says that a surface has a lightmap, by the conventions there are.

use super::super::material::{DEFAULT_REFLECTANCE, LEAST_TRANSMISSION};
use super::assign::Placement;
use super::json::Json;
use super::materials::PageTextures;
use super::types::{Convention, LightmapPage};
use serde_json::{Value, json};
use std::f64::consts::PI;

/// The lightmap of a material.
pub struct MaterialLightmap<'l> {
    /// The picture.
    pub page: &'l LightmapPage,
    /// Its textures.
    pub textures: &'l PageTextures,
    /// The set of texture coordinates.
    pub set: u32,
    /// How the coordinates are moved.
    pub placement: Option<Placement>,
}

/// The extension that moves texture coordinates.
pub const MOVED: &str = "KHR_texture_transform";
const UNLIT: &str = "KHR_materials_unlit";
const SPECULAR: &str = "KHR_materials_specular";
const STRENGTH: &str = "KHR_materials_emissive_strength";
const MOZ: &str = "MOZ_lightmap";
const SURFACE: &str = "pbrMetallicRoughness";

impl MaterialLightmap<'_> {
    /// A material, or the default one, with its lightmap, and the extensions that it uses for that.
    ///
    /// # Errors
    /// Why a material gets no lightmap in this way.
    pub fn lit<'s>(
        &self,
        convention: Convention,
        material: Option<&Json<'s>>,
    ) -> Result<(Json<'s>, Vec<&'static str>), String> {
        let (mut new, mut used) = match material {
            Some(material) => (material.clone(), Vec::new()),
            None => grey(convention),
        };
        match convention {
            Convention::Moz => self.moz(&mut new),
            Convention::Emissive => self.emissive(&mut new)?,
            Convention::Unlit => self.unlit(&mut new)?,
            Convention::Occlusion => self.occlusion(&mut new)?,
            Convention::Mx | Convention::Plain => {}
        }
        used.extend(match convention {
            Convention::Moz => Some(MOZ),
            Convention::Emissive => Some(SPECULAR),
            Convention::Unlit => Some(UNLIT),
            _ => None,
        });
        used.extend(self.placement.map(|_| MOVED));
        if convention == Convention::Emissive && self.page.intensity > 1.0 {
            used.push(STRENGTH);
        }
        Ok((new, used))
    }

    /// The reference to the texture.
    fn texture(&self) -> Value {
        let mut info = json!({ "index": self.textures.light, "texCoord": self.set });
        if let Some(Placement { offset, scale }) = self.placement {
            info["extensions"] = json!({ MOVED: { "offset": offset, "scale": scale } });
        }
        info
    }

    fn moz(&self, material: &mut Json) {
        let mut info = self.texture();
        // Where there is no light, the picture is the colour; elsewhere it is divided by π.
        let divisor = if has_extension(material, UNLIT) {
            PI
        } else {
            1.0
        };
        info["intensity"] = json!(self.page.intensity / divisor);
        if !self.textures.directions.is_empty() {
            let directions = self.textures.directions.iter();
            let directions: Vec<Value> = directions.map(|t| json!({ "index": t })).collect();
            info["extras"] = json!({ "azulejo": { "directions": directions } });
        }
        material.key("extensions").key(MOZ).set(info);
    }

    fn occlusion(&self, material: &mut Json) -> Result<(), String> {
        if material.get("occlusionTexture").is_some() {
            return Err("material with a picture of occlusion: keeps it".to_owned());
        }
        material.key("occlusionTexture").set(self.texture());
        Ok(())
    }

    fn emissive(&self, material: &mut Json) -> Result<(), String> {
        check_shown(material)?;
        if has_extension(material, UNLIT) {
            return Err("unlit material: stays, without lightmap".to_owned());
        }
        let (is_opaque, alpha) = (is_opaque(material), alpha(material));
        let surface = material.key(SURFACE);
        if is_opaque {
            // It is black, whatever it shows; where it has holes, they stay.
            surface.remove("baseColorTexture");
        }
        surface
            .key("baseColorFactor")
            .set(grey_with(json!(0), alpha));
        surface.key("metallicFactor").set(json!(0));
        surface.key("roughnessFactor").set(json!(1));
        surface.remove("metallicRoughnessTexture");
        material.key("emissiveTexture").set(self.texture());
        let intensity = self.page.intensity;
        let factor = intensity.min(1.0);
        material
            .key("emissiveFactor")
            .set(json!([factor, factor, factor]));
        let extensions = material.key("extensions");
        extensions.remove(MOZ);
        extensions.key(SPECULAR).set(json!({ "specularFactor": 0 }));
        extensions.remove(STRENGTH);
        if intensity > 1.0 {
            extensions
                .key(STRENGTH)
                .set(json!({ "emissiveStrength": intensity }));
        }
        Ok(())
    }

    fn unlit(&self, material: &mut Json) -> Result<(), String> {
        check_shown(material)?;
        let has_picture = material.find(&[SURFACE, "baseColorTexture"]).is_some();
        if has_picture && !is_opaque(material) {
            let fault = "material with holes in its picture: stays, without lightmap";
            return Err(fault.to_owned());
        }
        let alpha = alpha(material);
        let surface = material.key(SURFACE);
        // No colour is above 1.
        let colour = json!(self.page.intensity.min(1.0));
        surface.key("baseColorFactor").set(grey_with(colour, alpha));
        surface.key("baseColorTexture").set(self.texture());
        let extensions = material.key("extensions");
        extensions.key(UNLIT).set(json!({}));
        extensions.remove(MOZ);
        Ok(())
    }
}

/// The material of surfaces without one, as the reader takes it: glTF's own default is a white metal, of
/// which a lightmap shows nothing.
fn grey(convention: Convention) -> (Json<'static>, Vec<&'static str>) {
    let [r, g, b] = DEFAULT_REFLECTANCE.to_array();
    let surface = json!({ "baseColorFactor": [r, g, b, 1], "metallicFactor": 0 });
    let mut grey = json!({ "name": "default", SURFACE: surface });
    if convention == Convention::Unlit {
        return (grey.into(), Vec::new());
    }
    grey["extensions"] = json!({ SPECULAR: { "specularFactor": 0 } });
    (grey.into(), vec![SPECULAR])
}

fn grey_with(level: Value, alpha: Json) -> Json {
    let level = Json::from(level);
    Json::List(vec![level.clone(), level.clone(), level, alpha])
}

fn has_extension(material: &Json, name: &str) -> bool {
    material.find(&["extensions", name]).is_some()
}

fn is_opaque(material: &Json) -> bool {
    let mode = material.get("alphaMode").and_then(Json::text);
    mode.is_none_or(|mode| mode == "OPAQUE")
}

/// The opacity, as it is spelled.
fn alpha<'a>(material: &Json<'a>) -> Json<'a> {
    let colour = material.find(&[SURFACE, "baseColorFactor"]);
    colour
        .and_then(|c| c.list().get(3))
        .cloned()
        .unwrap_or_else(|| json!(1).into())
}

/// Refuses materials whose look is not that of diffusely reflected light.
fn check_shown(material: &Json) -> Result<(), String> {
    let number = |steps: &[&str]| material.find(steps).and_then(Json::number);
    // Nothing is reflected diffusely by metals, which are the default in glTF.
    let picture = material.find(&[SURFACE, "metallicRoughnessTexture"]);
    let metallic = number(&[SURFACE, "metallicFactor"]).unwrap_or(1.0);
    let is_metal = picture.is_none() && metallic >= 1.0 && !has_extension(material, UNLIT);
    let glass = [
        "extensions",
        "KHR_materials_transmission",
        "transmissionFactor",
    ];
    let mut emission = material.entries("emissiveFactor").iter();
    let kind = if emission.any(|n| n.number() != Some(0.0)) {
        "material that emits light"
    } else if is_metal {
        "metal"
    } else if number(&glass).is_some_and(|f| f >= LEAST_TRANSMISSION) {
        "glass"
    } else {
        return Ok(());
    };
    Err(format!("{kind}: stays, without lightmap"))
}
