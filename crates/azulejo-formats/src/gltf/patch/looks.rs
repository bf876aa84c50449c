//! How a material says that a surface has a lightmap, by the conventions there are.

use super::super::material::{DEFAULT_REFLECTANCE, LEAST_TRANSMISSION};
use super::assign::Placement;
use super::edits::Edit;
use super::scan::{Span, elements, find, members, string};
use super::types::{Convention, LightmapPage};
use serde_json::json;
use std::f64::consts::PI;

/// The lightmap of a material.
pub struct MaterialLightmap<'l> {
    /// The picture.
    pub page: &'l LightmapPage,
    /// Its texture.
    pub texture: usize,
    /// The set of texture coordinates.
    pub set: u32,
    /// How the coordinates are moved.
    pub placement: Option<Placement>,
}

/// A change of a material, and the extensions that it uses.
type Change = (Edit, Vec<&'static str>);

const UNLIT: &str = "KHR_materials_unlit";
/// The extension that moves texture coordinates.
pub const MOVED: &str = "KHR_texture_transform";

impl MaterialLightmap<'_> {
    /// The change of a material, or of the default one.
    ///
    /// # Errors
    /// Why a material gets no lightmap in this way.
    pub fn change(
        &self,
        convention: Convention,
        text: &str,
        material: Option<&Span>,
    ) -> Result<Change, String> {
        let json = Material { text, material };
        // The default material comes first, for what is set after it.
        let (mut change, mut used) = match material {
            Some(_) => (Edit::default(), Vec::new()),
            None => grey(convention),
        };
        used.extend(match convention {
            Convention::Moz => self.moz(&json, &mut change),
            Convention::Emissive => self.emissive(&json, &mut change)?,
            Convention::Unlit => self.unlit(&json, &mut change)?,
            Convention::Occlusion => self.occlusion(&json, &mut change)?,
            Convention::Mx | Convention::Plain => Vec::new(),
        });
        Ok((change, used))
    }

    /// The reference to the texture.
    fn texture(&self) -> Edit {
        let mut info = Edit::default();
        info.key("index").set(self.texture.to_string());
        info.key("texCoord").set(self.set.to_string());
        if let Some(placement) = self.placement {
            let moved = info.key("extensions").key(MOVED);
            let [u, v] = placement.offset;
            moved.key("offset").set(json!([u, v]).to_string());
            let [u, v] = placement.scale;
            moved.key("scale").set(json!([u, v]).to_string());
        }
        info
    }

    /// The extensions that are used, with that of moved coordinates.
    fn used<const N: usize>(&self, names: [&'static str; N]) -> Vec<&'static str> {
        let moved = self.placement.map(|_| MOVED);
        names.into_iter().chain(moved).collect()
    }

    fn moz(&self, material: &Material, change: &mut Edit) -> Vec<&'static str> {
        // Where there is no light, the picture is the colour; elsewhere it is divided by π.
        let intensity = if material.has_extension(UNLIT) {
            self.page.intensity / PI
        } else {
            self.page.intensity
        };
        let mut info = self.texture();
        info.key("intensity").set(json!(intensity).to_string());
        let extension = change.key("extensions").key("MOZ_lightmap");
        // Another lightmap in its place goes as a whole.
        extension.set(info.rendered());
        self.used(["MOZ_lightmap"])
    }

    fn occlusion(
        &self,
        material: &Material,
        change: &mut Edit,
    ) -> Result<Vec<&'static str>, String> {
        if material.find(&["occlusionTexture"]).is_some() {
            return Err("material with a picture of occlusion: keeps it".to_owned());
        }
        change
            .key("occlusionTexture")
            .set(self.texture().rendered());
        Ok(self.used([]))
    }

    fn emissive(
        &self,
        material: &Material,
        change: &mut Edit,
    ) -> Result<Vec<&'static str>, String> {
        material.check_shown()?;
        if material.has_extension(UNLIT) {
            return Err("unlit material: stays, without lightmap".to_owned());
        }
        let surface = change.key("pbrMetallicRoughness");
        if material.is_opaque() {
            // It is black, whatever it shows; where it has holes, they stay.
            surface.key("baseColorTexture").remove();
        }
        let alpha = material.alpha();
        surface
            .key("baseColorFactor")
            .set(format!("[0,0,0,{alpha}]"));
        surface.key("metallicFactor").set("0");
        surface.key("roughnessFactor").set("1");
        surface.key("metallicRoughnessTexture").remove();
        change.key("emissiveTexture").set(self.texture().rendered());
        let intensity = self.page.intensity;
        let factor = [intensity.min(1.0); 3];
        let factor = json!(factor).to_string();
        change.key("emissiveFactor").set(factor);
        let extensions = change.key("extensions");
        let mut used = self.used(["KHR_materials_specular"]);
        extensions.key("MOZ_lightmap").remove();
        let matt = "{\"specularFactor\":0}";
        extensions.key("KHR_materials_specular").set(matt);
        extensions.key("KHR_materials_emissive_strength").remove();
        if intensity > 1.0 {
            let strength = json!({ "emissiveStrength": intensity }).to_string();
            let name = "KHR_materials_emissive_strength";
            extensions.key(name).set(strength);
            used.push(name);
        }
        Ok(used)
    }

    fn unlit(&self, material: &Material, change: &mut Edit) -> Result<Vec<&'static str>, String> {
        material.check_shown()?;
        let steps = ["pbrMetallicRoughness", "baseColorTexture"];
        let has_picture = material.find(&steps).is_some();
        if has_picture && !material.is_opaque() {
            let fault = "material with holes in its picture: stays, without lightmap";
            return Err(fault.to_owned());
        }
        let surface = change.key("pbrMetallicRoughness");
        // No colour is above 1.
        let colour = json!(self.page.intensity.min(1.0)).to_string();
        let alpha = material.alpha();
        let factor = format!("[{colour},{colour},{colour},{alpha}]");
        surface.key("baseColorFactor").set(factor);
        surface
            .key("baseColorTexture")
            .set(self.texture().rendered());
        let extensions = change.key("extensions");
        extensions.key(UNLIT).set("{}");
        extensions.key("MOZ_lightmap").remove();
        Ok(self.used([UNLIT]))
    }
}

/// The material of surfaces without one, as the reader takes it: glTF's own default is a white metal, of
/// which a lightmap shows nothing.
fn grey(convention: Convention) -> Change {
    let [r, g, b] = DEFAULT_REFLECTANCE.to_array();
    let mut change = Edit::default();
    change.key("name").set("\"default\"");
    let surface = change.key("pbrMetallicRoughness");
    let factor = json!([r, g, b, 1]).to_string();
    surface.key("baseColorFactor").set(factor);
    surface.key("metallicFactor").set("0");
    if convention == Convention::Unlit {
        return (change, Vec::new());
    }
    let extensions = change.key("extensions");
    let specular = "KHR_materials_specular";
    extensions.key(specular).key("specularFactor").set("0");
    (change, vec![specular])
}

/// A material as the text has it; `None` is the default one.
struct Material<'t> {
    text: &'t str,
    material: Option<&'t Span>,
}

impl Material<'_> {
    fn find(&self, steps: &[&str]) -> Option<Span> {
        find(self.text, self.material?, steps)
    }

    fn string(&self, key: &str) -> Option<String> {
        string(self.text, &self.find(&[key])?)
    }

    fn has_extension(&self, name: &str) -> bool {
        let extensions = self.find(&["extensions"]);
        let extensions = extensions.and_then(|e| members(self.text, &e));
        extensions.is_some_and(|list| list.iter().any(|m| m.key == name))
    }

    fn numbers(&self, steps: &[&str]) -> Vec<&str> {
        let list = self.find(steps).and_then(|list| elements(self.text, &list));
        list.into_iter().flatten().map(|n| &self.text[n]).collect()
    }

    fn number(&self, steps: &[&str]) -> Option<f64> {
        self.text[self.find(steps)?].parse().ok()
    }

    fn is_opaque(&self) -> bool {
        let mode = self.string("alphaMode");
        mode.is_none_or(|mode| mode == "OPAQUE")
    }

    /// Refuses materials whose look is not that of diffusely reflected light.
    fn check_shown(&self) -> Result<(), String> {
        let kind = if self.emits() {
            "material that emits light"
        } else if self.is_metal() {
            "metal"
        } else if self.is_glass() {
            "glass"
        } else {
            return Ok(());
        };
        Err(format!("{kind}: stays, without lightmap"))
    }

    /// Whether nothing is reflected diffusely; metals are what glTF has where nothing is said.
    fn is_metal(&self) -> bool {
        let steps = ["pbrMetallicRoughness", "metallicRoughnessTexture"];
        let factor = self.number(&["pbrMetallicRoughness", "metallicFactor"]);
        let is_lit = self.material.is_some() && !self.has_extension(UNLIT);
        is_lit && self.find(&steps).is_none() && factor.unwrap_or(1.0) >= 1.0
    }

    /// Whether most light passes.
    fn is_glass(&self) -> bool {
        let steps = ["extensions", "KHR_materials_transmission"];
        let factor = self.number(&[steps[0], steps[1], "transmissionFactor"]);
        factor.is_some_and(|f| f >= LEAST_TRANSMISSION)
    }

    fn emits(&self) -> bool {
        let factor = self.numbers(&["emissiveFactor"]);
        let is_dark = |n: &&str| n.parse::<f64>().is_ok_and(|n| n == 0.0);
        !factor.iter().all(is_dark)
    }

    /// The opacity, as the text has it.
    fn alpha(&self) -> &str {
        let steps = ["pbrMetallicRoughness", "baseColorFactor"];
        self.numbers(&steps).get(3).copied().unwrap_or("1")
    }
}
