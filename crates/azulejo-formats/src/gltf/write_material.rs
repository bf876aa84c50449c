//! Writes materials and textures as glTF.

use super::json_parts::{factor_and_strength, named};
use super::lightmap;
use super::pack::Pack;
use super::uri;
use crate::picture::png;
use crate::picture::srgb::srgb_bytes;
use crate::surface::model::{gltf_mr, model_of, slope};
use azulejo_scene::{
    Dielectric, FinishMaps, Image, Material, MaterialId, Opacity, OpacityChannel, OpacityMap,
    OpacityMode, PictureChannel, Relief, ReliefKind, Rgb, Scene, Sidedness, Texture, TextureId,
    WrapMode,
};
use glam::DVec2;
use serde_json::{Map, Value, json};
use std::collections::{BTreeSet, HashMap, HashSet};
use std::io;

/// The set of texture coordinates of lightmaps.
const LIGHTMAP_SET: u32 = 1;

/// Thickness that distinguishes a solid body from a thin wall, in metres. Its value matters only to
/// programs that do not trace rays.
const SOLID: f64 = 0.01;

/// How a file describes matt surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MattSurfaces {
    /// That their roughness is 1. Programs that know nothing else let them mirror 4% of the light, and more
    /// at grazing angles.
    #[default]
    Rough,
    /// Also that nothing is mirrored: `KHR_materials_specular` with a factor of 0.
    Said,
}

/// The materials of a file being written, in the order of the scene's.
#[derive(Debug, Default)]
pub(super) struct Materials {
    /// The materials.
    pub list: Vec<Value>,
    /// Their textures, in the order of the scene's.
    pub textures: Vec<Value>,
    /// The pictures of the textures.
    pub images: Vec<Value>,
    /// How textures go on beyond their edges, where they do not repeat.
    pub samplers: Vec<Value>,
    /// The extensions that they use.
    pub extensions: BTreeSet<&'static str>,
    /// The mean of the picture that each emits, if it emits one.
    emitted_means: Vec<Option<Rgb>>,
    /// Copies without texture, by the index of the material that has one.
    plain: HashMap<MaterialId, usize>,
    /// Whether matt surfaces say that they are.
    says_matt: bool,
}

impl Materials {
    /// Writes the materials of a scene; the pixels of their textures go into `pack`.
    ///
    /// # Errors
    /// A picture without pixels.
    pub fn of(scene: &Scene, matt: MattSurfaces, pack: &mut Pack) -> io::Result<Materials> {
        let mut materials = Materials {
            says_matt: matt == MattSurfaces::Said,
            ..Materials::default()
        };
        let environments = only_around(scene);
        let peaks = bright_lightmaps(scene);
        for (i, texture) in scene.textures.iter().enumerate() {
            if environments.contains(&(i as TextureId)) {
                // Textures keep their numbers; one without an image is nothing.
                materials.textures.push(json!({}));
                continue;
            }
            let sampler = materials.sampler(texture.wrap);
            let source = json!({ "source": materials.images.len() });
            materials.textures.push(with_sampler(source, sampler));
            let entry = match peaks.get(&(i as TextureId)) {
                Some(&peak) => image(&darkened(texture, peak), pack)?,
                None => image(texture, pack)?,
            };
            materials.images.push(entry);
        }
        let has_lightmap = scene.has_lightmap();
        for material in &scene.materials {
            let mut json = materials.material(material);
            if let Some(lightmap) = material.lightmap.filter(|_| has_lightmap) {
                let peak = peaks.get(&lightmap.texture).copied().unwrap_or(1.0);
                materials.extensions.insert(lightmap::OF_MATERIALS);
                json["extensions"][lightmap::OF_MATERIALS] = json!({
                    "index": lightmap.texture,
                    "texCoord": LIGHTMAP_SET,
                    "intensity": lightmap.scale * peak,
                });
            }
            if let Some(opacity) = &material.opacity {
                materials.opacity(scene, material, opacity, &mut json, pack)?;
            }
            materials.list.push(json);
            let picture = material.emission_picture;
            let mean = picture.map(|id| scene.textures[id as usize].mean());
            materials.emitted_means.push(mean);
        }
        Ok(materials)
    }

    /// The index of a material for a mesh without texture coordinates, on which glTF allows no texture:
    /// it emits the mean of its picture.
    pub fn plain(&mut self, material: MaterialId) -> usize {
        let json = &self.list[material as usize];
        let surface = &json["pbrMetallicRoughness"];
        let pictures = [
            &surface["baseColorTexture"],
            &surface["metallicRoughnessTexture"],
            &json["emissiveTexture"],
            &json["normalTexture"],
        ];
        if pictures.iter().all(|picture| picture.is_null()) {
            return material as usize;
        }
        *self.plain.entry(material).or_insert_with(|| {
            let mut twin = self.list[material as usize].clone();
            if let Some(surface) = twin["pbrMetallicRoughness"].as_object_mut() {
                surface.remove("baseColorTexture");
                surface.remove("metallicRoughnessTexture");
            }
            if let Some(twin) = twin.as_object_mut() {
                twin.remove("normalTexture");
            }
            if let Some(mean) = self.emitted_means[material as usize]
                && let Some(twin) = twin.as_object_mut()
                && twin.remove("emissiveTexture").is_some()
            {
                let factors = twin["emissiveFactor"].as_array().into_iter().flatten();
                let factors = factors.zip(mean.to_array());
                let means: Vec<f64> = factors
                    .map(|(f, mean)| f.as_f64().unwrap_or(0.0) * mean)
                    .collect();
                twin["emissiveFactor"] = json!(means);
            }
            self.list.push(twin);
            self.list.len() - 1
        })
    }

    fn material(&mut self, m: &Material) -> Value {
        let mut extensions = Map::new();
        // Start from the surface that core glTF can express; glass adds extensions.
        let mut surface = match m.dielectric {
            Some(glass) => self.glass(m, glass, &mut extensions),
            None => opaque(m),
        };
        // A finish has its own factors, and the picture of metalness and roughness if a single one has both.
        if let Some(finish) = m.finish.filter(|_| m.dielectric.is_none()) {
            surface = metallic_roughness(finish.base, finish.metallic, finish.roughness);
            if let Some(texture) = finish_texture(&finish) {
                surface["metallicRoughnessTexture"] = json!({ "index": texture });
            }
        }
        if let Some(&texture) = m.textures.first() {
            surface["baseColorTexture"] = json!({ "index": texture });
        }
        let mut json = named(&m.name);
        json.insert("pbrMetallicRoughness".into(), surface);
        json.insert("doubleSided".into(), json!(has_two_sides(m)));
        // glTF has normal maps, but no pictures of heights.
        if let Some(Relief {
            texture,
            kind: ReliefKind::Normals { scale },
        }) = m.relief
        {
            let map = json!({ "index": texture, "scale": scale });
            json.insert("normalTexture".into(), map);
        }
        if m.is_emitter() {
            let factor = self.emission(m.emission, &mut extensions);
            json.insert("emissiveFactor".into(), json!(factor.to_array()));
            if let Some(texture) = m.emission_picture {
                json.insert("emissiveTexture".into(), json!({ "index": texture }));
            }
        }
        // Without this, other programs let rough surfaces mirror a little.
        if self.says_matt && is_matt(m) {
            let none = json!({ "specularFactor": 0 });
            self.extend(&mut extensions, "KHR_materials_specular", none);
        }
        if !extensions.is_empty() {
            json.insert("extensions".into(), extensions.into());
        }
        json.into()
    }

    /// The alpha mode, with the alpha factor of the base colour. The picture of an opacity is the alpha
    /// channel of the base colour's; where these are different pictures, a new one joins them.
    fn opacity(
        &mut self,
        scene: &Scene,
        m: &Material,
        opacity: &Opacity,
        json: &mut Value,
        pack: &mut Pack,
    ) -> io::Result<()> {
        match opacity.mode {
            OpacityMode::Blend => json["alphaMode"] = json!("BLEND"),
            OpacityMode::Mask { cutoff } => {
                json["alphaMode"] = json!("MASK");
                json["alphaCutoff"] = json!(cutoff);
            }
        }
        let surface = &mut json["pbrMetallicRoughness"];
        surface["baseColorFactor"][3] = json!(opacity.constant);
        let Some(picture) = opacity.picture else {
            return Ok(());
        };
        let base = m.textures.first().copied();
        if base == Some(picture.texture) && picture.channel == OpacityChannel::Alpha {
            return Ok(());
        }
        let image_of = |id: TextureId| scene.textures[id as usize].image.as_ref();
        let map = image_of(picture.texture)
            .and_then(|i| OpacityMap::new(i, picture.channel, [WrapMode::Clamp; 2]));
        if let Some(map) = map {
            let joined = joined(base.and_then(image_of), &map);
            let opacity = &scene.textures[picture.texture as usize];
            let texture = Texture {
                path: format!("{} opacity", opacity.path),
                image: Some(joined),
                wrap: opacity.wrap,
            };
            let sampler = self.sampler(texture.wrap);
            surface["baseColorTexture"] = json!({ "index": self.textures.len() });
            let source = json!({ "source": self.images.len() });
            self.textures.push(with_sampler(source, sampler));
            self.images.push(image(&texture, pack)?);
        }
        Ok(())
    }

    /// The index of a sampler; none for textures that repeat.
    fn sampler(&mut self, wrap: [WrapMode; 2]) -> Option<usize> {
        if wrap == [WrapMode::Repeat; 2] {
            return None;
        }
        // The numbers of OpenGL.
        let [s, t] = wrap.map(|mode| match mode {
            WrapMode::Repeat => 10497,
            WrapMode::Clamp => 33071,
            WrapMode::Mirror => 33648,
        });
        let sampler = json!({ "wrapS": s, "wrapT": t });
        let known = self.samplers.iter().position(|other| *other == sampler);
        Some(known.unwrap_or_else(|| {
            self.samplers.push(sampler);
            self.samplers.len() - 1
        }))
    }

    fn extend(&mut self, list: &mut Map<String, Value>, name: &'static str, value: Value) {
        self.extensions.insert(name);
        list.insert(name.into(), value);
    }

    /// The emission factor, which is at most 1; stronger emission needs an extension.
    fn emission(&mut self, emission: Rgb, extensions: &mut Map<String, Value>) -> Rgb {
        if emission.max_channel() <= 1.0 {
            return emission;
        }
        let (factor, strength) = factor_and_strength(emission);
        let name = "KHR_materials_emissive_strength";
        self.extend(extensions, name, json!({ "emissiveStrength": strength }));
        factor
    }

    fn glass(
        &mut self,
        m: &Material,
        glass: Dielectric,
        extensions: &mut Map<String, Value>,
    ) -> Value {
        let transmission = json!({ "transmissionFactor": 1 });
        self.extend(extensions, "KHR_materials_transmission", transmission);
        let ior = glass.ior.max(1.0);
        self.extend(extensions, "KHR_materials_ior", json!({ "ior": ior }));
        if is_solid(&glass) {
            let solid = json!({ "thicknessFactor": SOLID });
            self.extend(extensions, "KHR_materials_volume", solid);
        }
        if m.mirror != Rgb::WHITE {
            let mirror = json!({ "specularColorFactor": m.mirror.to_array() });
            self.extend(extensions, "KHR_materials_specular", mirror);
        }
        metallic_roughness(glass.transmittance, 0.0, 0.0)
    }
}

/// Surfaces act on both sides in azulejo; but lamps may emit from one side only, the boundary of a
/// body in glTF has both sides anyway, and a file may have said that backs are culled.
fn has_two_sides(m: &Material) -> bool {
    let is_solid = m.dielectric.is_some_and(|g| is_solid(&g));
    !is_solid && (!m.is_emitter() || m.emits_back) && m.sidedness != Sidedness::One
}

/// Whether all that a surface reflects is reflected diffusely.
fn is_matt(m: &Material) -> bool {
    m.mirror.is_black() && m.brdf.is_none() && m.dielectric.is_none() && m.finish.is_none()
}

/// Glass without a volume is a thin pane in glTF; one of index 1 equals the boundary of a body.
fn is_solid(glass: &Dielectric) -> bool {
    glass.ior > 1.0 && !glass.thin
}

fn metallic_roughness(base: Rgb, metallic: f64, roughness: f64) -> Value {
    let [r, g, b] = base.to_array();
    json!({
        "baseColorFactor": [r, g, b, 1],
        "metallicFactor": metallic,
        "roughnessFactor": roughness,
    })
}

/// Metals colour their mirror reflection; for other models glTF has only the nearest metal.
fn opaque(m: &Material) -> Value {
    if let Some((base, metallic, roughness)) = gltf_mr(m) {
        return metallic_roughness(base, metallic, roughness);
    }
    let mirrored = m.mirror + m.mean_glossy();
    if mirrored.is_black() {
        return metallic_roughness(m.diffuse, 0.0, 1.0);
    }
    let base = (m.diffuse + mirrored).map(|c| c.min(1.0));
    let share = mirrored.mean() / (m.diffuse + mirrored).mean();
    let slope = model_of(m)
        .filter(|_| m.glossy().is_some())
        .map_or(0.0, slope);
    metallic_roughness(base, share, slope.sqrt())
}

/// The one picture whose blue channel is the metalness and whose green one is the roughness.
pub(super) fn finish_texture(finish: &FinishMaps) -> Option<TextureId> {
    let (metallic, roughness) = (finish.metallic_picture?, finish.roughness_picture?);
    let is_one = metallic.texture == roughness.texture
        && metallic.channel == PictureChannel::Blue
        && roughness.channel == PictureChannel::Green;
    is_one.then_some(metallic.texture)
}

/// The mirrored share of a surface's reflectance.
fn mirrored_share(m: &Material) -> f64 {
    m.mirror.mean() / (m.diffuse + m.mirror).mean()
}

/// Whether one colour and one share describe a surface with mirror and diffuse reflection.
pub(super) fn is_one_colour(m: &Material) -> bool {
    let share = mirrored_share(m);
    let off = m.mirror - (m.diffuse + m.mirror) * share;
    m.mirror.is_black() || off.map(f64::abs).max_channel() < 1e-6
}

fn with_sampler(mut texture: Value, sampler: Option<usize>) -> Value {
    if let Some(sampler) = sampler {
        texture["sampler"] = json!(sampler);
    }
    texture
}

/// The pictures of lightmaps with texels above 1, and the largest: they are divided by it, and their intensity
/// grows, since a PNG ends at 1.
pub(super) fn bright_lightmaps(scene: &Scene) -> HashMap<TextureId, f64> {
    let ids: HashSet<TextureId> = (scene.materials.iter())
        .filter_map(|m| Some(m.lightmap?.texture))
        .collect();
    let peak = |id: TextureId| {
        let image = scene.textures.get(id as usize)?.image.as_ref()?;
        let peak = image.pixels.iter().flatten().copied().fold(1.0, f32::max);
        (peak > 1.0 && peak.is_finite()).then_some((id, f64::from(peak)))
    };
    ids.into_iter().filter_map(peak).collect()
}

/// A picture whose texels are divided by the largest.
fn darkened(texture: &Texture, peak: f64) -> Texture {
    let mut darker = texture.clone();
    let pixels = darker.image.iter_mut().flat_map(|image| &mut image.pixels);
    pixels
        .flatten()
        .for_each(|value| *value = (f64::from(*value) / peak) as f32);
    darker
}

/// The pictures that only environments and the background show, which glTF does not keep: megabytes that no material uses.
pub(super) fn only_around(scene: &Scene) -> HashSet<TextureId> {
    let mut around: HashSet<TextureId> = scene.surrounding_pictures().collect();
    for material in &scene.materials {
        for id in material.pictures() {
            around.remove(&id);
        }
    }
    around
}

/// The colours of a picture, or white, with the opacities of a map, as large as the larger of the two.
fn joined(base: Option<&Image>, map: &OpacityMap) -> Image {
    let [width, height] = map.size();
    let (width, height) = base.map_or((width, height), |b| {
        (b.width.max(width), b.height.max(height))
    });
    let place = |k: u32| {
        let (x, y) = (f64::from(k % width) + 0.5, f64::from(k / width) + 0.5);
        DVec2::new(x / f64::from(width), 1.0 - y / f64::from(height))
    };
    let pixels = (0..width * height).map(place);
    let color = |at: DVec2| base.map_or([1.0; 3], |b| b.sample(at.x, at.y));
    let alpha = |at: DVec2| map.sample(at) as f32;
    Image::opaque(width, height, pixels.clone().map(color).collect())
        .with_alpha(pixels.map(alpha).collect())
}

fn image(texture: &Texture, pack: &mut Pack) -> io::Result<Value> {
    let Some(image) = &texture.image else {
        return Ok(json!({ "uri": uri::escaped(&texture.path) }));
    };
    let mut file = Vec::new();
    if image.alpha.is_some() {
        png::write_linear(image, &mut file)?;
    } else {
        png::write(image.width, image.height, &srgb_bytes(image), &mut file)?;
    }
    let mut json = named(&texture.path);
    json.insert("mimeType".into(), json!("image/png"));
    json.insert("bufferView".into(), json!(pack.bytes(&file)));
    Ok(json.into())
}
