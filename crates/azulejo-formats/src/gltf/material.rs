//! Materials: metallic-roughness as a reflection model.

use super::accessor::Data;
use super::lightmap::{self, NamedLightmap};
use super::messages::GltfMessages;
use super::pictures::Pictures;
use crate::Files;
use crate::surface::gloss::{Gloss, SMOOTHEST};
use crate::surface::materials::Materials;
use azulejo_scene::{
    Dielectric, FinishMaps, Image, IrradiancePicture, Material, MaterialId, NumberPicture, Opacity,
    OpacityMode, PictureChannel, Relief, ReliefKind, Rgb, Sidedness, Texture, TextureId,
};
use glam::{DAffine2, DMat2, DVec2};
use gltf_json::extensions::texture::TextureTransform;
use gltf_json::material::{AlphaMode, NormalTexture};
use gltf_json::texture::Info;
use gltf_json::validation::Checked;
use gltf_json::{Index, Root};
use std::collections::HashMap;

/// Reflectance of primitives without a material. glTF's own default is white, but no surface
/// reflects all light.
pub(super) const DEFAULT_REFLECTANCE: Rgb = Rgb::grey(0.5);

/// Index of refraction without an extension that defines it.
const DEFAULT_IOR: f64 = 1.5;

/// Glass below this roughness is taken as clear without a warning.
const CLEAR: f64 = 0.1;

/// From this share of transmitted light on, a surface is glass.
pub(super) const LEAST_TRANSMISSION: f64 = 0.5;

/// A material as primitives use it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct GltfSurface {
    /// Its index in the scene.
    pub id: MaterialId,
    /// Whether it has a texture.
    pub is_textured: bool,
    /// The set of texture coordinates that its texture uses.
    pub set: u32,
    /// The transform of those coordinates.
    pub picture_from_uv: DAffine2,
    /// The coordinates of its lightmap, if it has one.
    pub lightmap: Option<GltfCoordinates>,
}

/// Texture coordinates of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct GltfCoordinates {
    /// The set.
    pub set: u32,
    /// Their transform.
    pub picture_from_uv: DAffine2,
}

impl GltfCoordinates {
    /// Coordinates of the file in azulejo's convention, with v upwards.
    pub fn uv_of(&self, uv: [f64; 2]) -> DVec2 {
        let uv = self.picture_from_uv.transform_point2(uv.into());
        DVec2::new(uv.x, 1.0 - uv.y)
    }
}

/// A lightmap that is used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct GltfLightmap {
    /// Its picture.
    pub picture: IrradiancePicture,
    /// Where that lies.
    pub coordinates: GltfCoordinates,
}

/// A lightmap by its bits: texture, scale, set and transform.
type LightmapBits = (TextureId, u64, u32, [u64; 6]);

impl GltfLightmap {
    fn bits(&self) -> LightmapBits {
        let GltfCoordinates {
            set,
            picture_from_uv,
        } = self.coordinates;
        let map = picture_from_uv.to_cols_array().map(f64::to_bits);
        (self.picture.texture, self.picture.scale.to_bits(), set, map)
    }
}

/// The materials of a file, read when they are first used.
pub(super) struct Surfaces<'a> {
    root: &'a Root,
    pictures: Pictures<'a>,
    materials: Materials,
    gloss: Gloss,
    /// By the index of the material, and the lightmap of the node.
    known: HashMap<(Option<usize>, Option<LightmapBits>), GltfSurface>,
    /// Materials without the lightmap that they have.
    unlit: HashMap<MaterialId, MaterialId>,
}

impl<'a> Surfaces<'a> {
    /// No materials yet.
    pub fn new(data: &'a Data<'a>, files: &'a dyn Files) -> Surfaces<'a> {
        Surfaces {
            root: data.root,
            pictures: Pictures::new(data, files),
            materials: Materials::default(),
            gloss: Gloss::default(),
            known: HashMap::new(),
            unlit: HashMap::new(),
        }
    }

    /// All materials that were used, and their textures.
    pub fn finish(self) -> (Vec<Material>, Vec<Texture>) {
        (self.materials.into_list(), self.pictures.finish())
    }

    /// An image of the file.
    ///
    /// # Errors
    /// The reason, for one that cannot be loaded.
    pub fn picture(&mut self, image: usize) -> Result<Image, String> {
        self.pictures.load(image)
    }

    /// Adds a picture to the textures.
    ///
    /// # Errors
    /// The reason, if it is too large.
    pub fn add_picture(&mut self, name: &str, image: Image) -> Result<TextureId, String> {
        self.pictures.add(name, image)
    }

    /// A material of the file, or the default one of primitives without a material; a lightmap of the node
    /// comes before that of the material.
    pub fn of(
        &mut self,
        index: Option<Index<gltf_json::Material>>,
        of_node: Option<GltfLightmap>,
        messages: &mut GltfMessages,
    ) -> GltfSurface {
        let key = (index.map(|i| i.value()), of_node.map(|l| l.bits()));
        if let Some(&known) = self.known.get(&key) {
            return known;
        }
        let given = index.and_then(|i| self.root.get(i));
        let number = index.map_or(0, |i| i.value());
        let of_material = given.filter(|_| of_node.is_none());
        let lightmap = match of_material {
            Some(json) => self.lightmap_of(json, number, messages),
            None => of_node,
        };
        let (mut material, coordinates) = match given {
            None => (
                Material::diffuse("default", DEFAULT_REFLECTANCE),
                GltfSurface::plain(0),
            ),
            Some(json) => {
                let mut reader = MaterialReader {
                    json,
                    index: number,
                    pictures: &mut self.pictures,
                    gloss: &mut self.gloss,
                    messages,
                };
                (reader.material(), reader.coordinates())
            }
        };
        material.lightmap = lightmap.map(|l| l.picture);
        let surface = GltfSurface {
            id: self.materials.index(material),
            lightmap: lightmap.map(|l| l.coordinates),
            ..coordinates
        };
        self.known.insert(key, surface);
        surface
    }

    /// A material without its lightmap, for primitives that lack the coordinates.
    pub fn without_lightmap(&mut self, surface: GltfSurface) -> GltfSurface {
        let materials = &mut self.materials;
        let id = *self.unlit.entry(surface.id).or_insert_with(|| {
            let unlit = Material {
                lightmap: None,
                ..materials.get(surface.id).clone()
            };
            materials.index(unlit)
        });
        GltfSurface {
            id,
            lightmap: None,
            ..surface
        }
    }

    /// The lightmap of a material.
    fn lightmap_of(
        &mut self,
        json: &gltf_json::Material,
        index: usize,
        messages: &mut GltfMessages,
    ) -> Option<GltfLightmap> {
        let extensions = json.extensions.as_ref()?;
        let extension = extensions.others.get(lightmap::OF_MATERIALS)?;
        let named = lightmap::of_material(extension, extensions.unlit.is_some(), self.root);
        let (lightmap, problem) = self.lightmap(named);
        if let Some(problem) = problem {
            messages.of(&problem, || format!("materials[{index}]"));
        }
        lightmap
    }

    /// A lightmap with its picture, and a warning if there is one.
    pub fn lightmap(
        &mut self,
        named: Result<NamedLightmap, String>,
    ) -> (Option<GltfLightmap>, Option<String>) {
        let named = match named {
            Ok(named) => named,
            Err(fault) => return (None, Some(format!("lightmap not used: {fault}"))),
        };
        let (texture, problem) = self.pictures.of_light(named.texture);
        let texture = texture.filter(|id| self.pictures.is_loaded(*id));
        let Some(texture) = texture else {
            let problem = problem.unwrap_or_else(|| "its picture is missing".to_owned());
            return (None, Some(format!("lightmap not used: {problem}")));
        };
        let lightmap = GltfLightmap {
            picture: IrradiancePicture {
                texture,
                scale: named.scale,
            },
            coordinates: named.coordinates,
        };
        (Some(lightmap), problem)
    }
}

impl GltfSurface {
    /// A material without texture.
    fn plain(id: MaterialId) -> GltfSurface {
        GltfSurface {
            id,
            is_textured: false,
            set: 0,
            picture_from_uv: DAffine2::IDENTITY,
            lightmap: None,
        }
    }
}

/// State of reading one material.
struct MaterialReader<'r, 'a> {
    json: &'r gltf_json::Material,
    index: usize,
    pictures: &'r mut Pictures<'a>,
    gloss: &'r mut Gloss,
    messages: &'r mut GltfMessages,
}

/// A factor clamped to 0..=1.
fn share(value: f32) -> f64 {
    // JSON cannot represent NaN.
    f64::from(value).clamp(0.0, 1.0)
}

fn color([r, g, b]: [f32; 3]) -> Rgb {
    Rgb::new(share(r), share(g), share(b))
}

impl MaterialReader<'_, '_> {
    fn warn(&mut self, message: &str) {
        let index = self.index;
        self.messages.of(message, || format!("materials[{index}]"));
    }

    fn material(&mut self) -> Material {
        let mut material = Material {
            name: self.json.name.clone().unwrap_or_default(),
            ..Material::default()
        };
        (material.emission, material.emission_picture) = self.emission();
        material.emits_back = self.json.double_sided && material.is_emitter();
        material.sidedness = if self.json.double_sided {
            Sidedness::Two
        } else {
            Sidedness::One
        };
        if !self.glass(&mut material) {
            self.opaque(&mut material);
        }
        material.relief = self.relief();
        self.name_the_rest();
        material
    }

    /// Radiance in cd/m² by factor and strength, and the picture that multiplies it.
    fn emission(&mut self) -> (Rgb, Option<TextureId>) {
        let extensions = self.json.extensions.as_ref();
        let strength = extensions.and_then(|e| e.emissive_strength.as_ref());
        let strength = strength.map_or(1.0, |s| f64::from(s.emissive_strength.0));
        let factor = Rgb::from(self.json.emissive_factor.0.map(f64::from));
        let emission = (factor * strength).map(|c| if c.is_finite() { c.max(0.0) } else { 0.0 });
        let Some(info) = self.json.emissive_texture.as_ref() else {
            return (emission, None);
        };
        if emission.is_black() {
            return (emission, None);
        }
        let (texture, problem) = self.pictures.index(info.index);
        if let Some(problem) = problem {
            self.warn(&problem);
        }
        let mean = texture.map_or(Rgb::BLACK, |id| self.pictures.mean_of(id));
        if texture.is_none_or(|id| !self.pictures.is_loaded(id)) {
            self.warn("emissive texture without a picture: the surface does not emit light");
        }
        if mean.is_black() {
            return (Rgb::BLACK, None);
        }
        if coordinates_of(info) != self.coordinates() {
            self.warn("emissive texture placed otherwise than the base colour: its mean shines");
            return (emission * mean, None);
        }
        (emission, texture)
    }

    /// Makes the material transmitting and returns `true`, if the file declares it as such.
    ///
    /// A thin wall is a pane: what its two surfaces mirror is subtracted from what passes. A volume is
    /// the boundary of a solid body; absorption inside is moved to its boundary, which light that
    /// crosses the body passes twice.
    fn glass(&mut self, material: &mut Material) -> bool {
        let pbr = &self.json.pbr_metallic_roughness;
        let extensions = self.json.extensions.as_ref();
        let Some(transmission) = extensions.and_then(|e| e.transmission.as_ref()) else {
            return false;
        };
        // Metal transmits nothing; what transmits less than half of its light is read as opaque.
        let of_rest = 1.0 - share(pbr.metallic_factor.0);
        let transmitted = share(transmission.transmission_factor.0) * of_rest;
        if transmitted < LEAST_TRANSMISSION {
            if transmitted > 0.0 {
                self.warn("material that transmits less than half of its light: opaque");
            }
            return false;
        }
        // A dielectric here is clear and has one colour.
        if share(pbr.roughness_factor.0) >= CLEAR {
            self.warn("frosted glass: taken as clear");
        }
        if transmission.transmission_texture.is_some() || pbr.base_color_texture.is_some() {
            self.warn("texture of glass: not used");
        }
        // Each of the two crossings of a boundary absorbs as half of the thickness does.
        let [r, g, b, _] = pbr.base_color_factor.0;
        let tint = color([r, g, b]) * transmitted;
        let volume = extensions.and_then(|e| e.volume.as_ref());
        let volume = volume.filter(|v| v.thickness_factor.0 > 0.0);
        let transmittance = match volume {
            Some(volume) => {
                let crossings = 0.5 * f64::from(volume.thickness_factor.0)
                    / f64::from(volume.attenuation_distance.0);
                let left = color(volume.attenuation_color.0);
                let left = left.map(|c| {
                    if crossings > 0.0 {
                        c.powf(crossings)
                    } else {
                        1.0
                    }
                });
                tint * left
            }
            None => tint,
        };
        // Without a volume the surface is a thin wall.
        material.mirror = self.specular();
        material.dielectric = Some(Dielectric {
            ior: self.ior(),
            transmittance,
            thin: volume.is_none(),
        });
        true
    }

    fn ior(&self) -> f64 {
        let extensions = self.json.extensions.as_ref();
        let ior = extensions
            .and_then(|e| e.ior.as_ref())
            .map(|i| f64::from(i.ior.0));
        ior.filter(|n| *n >= 1.0 && n.is_finite())
            .unwrap_or(DEFAULT_IOR)
    }

    /// The factor of the specular reflection of a dielectric.
    fn specular(&self) -> Rgb {
        let extensions = self.json.extensions.as_ref();
        match extensions.and_then(|e| e.specular.as_ref()) {
            Some(s) => color(s.specular_color_factor.0) * share(s.specular_factor.0),
            None => Rgb::WHITE,
        }
    }

    /// A surface that transmits no light.
    fn opaque(&mut self, material: &mut Material) {
        let pbr = &self.json.pbr_metallic_roughness;
        let [r, g, b, _] = pbr.base_color_factor.0;
        let base = color([r, g, b]);
        let finish = self.finish(base);
        let [metallic, roughness] = finish.means;
        let metal = self.metal(base, metallic);
        let gloss = &mut *self.gloss;
        if let Err(message) = gloss.metallic_roughness(material, metal, metallic, roughness) {
            self.warn(message);
        }
        // The texture multiplies the diffuse reflectance.
        material.diffuse = Rgb::from([0, 1, 2].map(|k| match metal[k] {
            0.0 => 0.0,
            colored => material.diffuse[k] * (base[k] / colored),
        }));
        material.limit_reflectance();
        // Without a model the surface is matt, or a mirror.
        material.finish = finish.maps.filter(|_| material.brdf.is_some());
        if let Some(info) = &pbr.base_color_texture {
            let (texture, problem) = self.pictures.index(info.index);
            material.textures.extend(texture);
            if let Some(problem) = problem {
                self.warn(&problem);
            }
        }
        material.opacity = self.opacity(&material.textures);
    }

    /// Metalness and roughness: the blue and the green channel of a texture, times factors.
    fn finish(&mut self, base: Rgb) -> GltfFinish {
        let pbr = &self.json.pbr_metallic_roughness;
        let (metallic, roughness) = (share(pbr.metallic_factor.0), share(pbr.roughness_factor.0));
        if self.is_unlit() {
            return GltfFinish {
                means: [0.0, 1.0],
                maps: None,
            };
        }
        let maps = FinishMaps {
            base,
            metallic,
            roughness,
            metallic_picture: None,
            roughness_picture: None,
        };
        let Some(info) = &pbr.metallic_roughness_texture else {
            // A texture colours metals, too.
            let is_colored_metal = pbr.base_color_texture.is_some() && metallic > 0.0;
            return GltfFinish {
                means: [metallic, roughness],
                maps: is_colored_metal.then_some(maps),
            };
        };
        let (texture, problem) = self.pictures.index(info.index);
        if let Some(problem) = problem {
            self.warn(&problem);
        }
        let known = texture.and_then(|id| Some((id, self.pictures.mean_numbers(id)?)));
        let Some((texture, mean)) = known else {
            self.warn("metallic-roughness texture without a picture: the surface is diffuse");
            return GltfFinish {
                means: [0.0, 1.0],
                maps: None,
            };
        };
        let is_placed = coordinates_of(info) == self.coordinates();
        if !is_placed {
            self.warn(
                "metallic-roughness texture placed otherwise than the first: its mean counts",
            );
        }
        let picture = |channel| Some(NumberPicture { texture, channel });
        let maps = FinishMaps {
            metallic_picture: picture(PictureChannel::Blue),
            roughness_picture: picture(PictureChannel::Green),
            ..maps
        };
        GltfFinish {
            means: [metallic * mean.z, (roughness * mean.y).max(SMOOTHEST)],
            maps: is_placed.then_some(maps),
        }
    }

    /// The relief by a normal map.
    fn relief(&mut self) -> Option<Relief> {
        let json = self.json;
        let map = json.normal_texture.as_ref()?;
        let (texture, problem) = self.pictures.index(map.index);
        if let Some(problem) = problem {
            self.warn(&problem);
        }
        let texture = texture.filter(|id| self.pictures.is_loaded(*id));
        let Some(texture) = texture else {
            self.warn("normal map without a picture: not used");
            return None;
        };
        if self.coordinates() != normal_coordinates(map) {
            self.warn("normal map placed otherwise than the first texture: not used");
            return None;
        }
        let scale = f64::from(map.scale);
        let kind = ReliefKind::Normals { scale };
        Some(Relief { texture, kind }).filter(|_| scale.is_finite())
    }

    /// The opacity by `alphaMode`: the alpha of the base colour's factor, times that of its texture.
    fn opacity(&self, textures: &[TextureId]) -> Option<Opacity> {
        let mode = match self.json.alpha_mode.as_ref().value()? {
            AlphaMode::Opaque => return None,
            AlphaMode::Mask => OpacityMode::Mask {
                cutoff: self
                    .json
                    .alpha_cutoff
                    .map_or(0.5, |c| f64::from(c.0))
                    .max(0.0),
            },
            AlphaMode::Blend => OpacityMode::Blend,
        };
        let [.., alpha] = self.json.pbr_metallic_roughness.base_color_factor.0;
        let opacity = Opacity {
            constant: share(alpha),
            picture: self.pictures.alpha_of(textures),
            mode,
        };
        (!opacity.is_opaque()).then_some(opacity)
    }

    /// The base colour of metals: the mean of the texture multiplies their reflectance.
    fn metal(&mut self, base: Rgb, metallic: f64) -> Rgb {
        let pbr = &self.json.pbr_metallic_roughness;
        let picture = pbr.base_color_texture.as_ref().filter(|_| metallic > 0.0);
        let mean = picture.and_then(|info| self.pictures.mean(info.index).ok());
        // Mirrors have one colour.
        if picture.is_some() && pbr.roughness_factor.0 <= 0.0 {
            self.warn("texture of a metal: multiplies diffuse reflection, and its mean multiplies mirror reflection");
        }
        base * mean.unwrap_or(Rgb::WHITE)
    }

    /// Whether it shows its colour whatever the light (`KHR_materials_unlit`). Its other properties are for
    /// programs that do not know that.
    fn is_unlit(&self) -> bool {
        let extensions = self.json.extensions.as_ref();
        extensions.is_some_and(|e| e.unlit.is_some())
    }

    /// Warns about properties that have no effect here.
    fn name_the_rest(&mut self) {
        let json = self.json;
        let rest = [
            (json.occlusion_texture.is_some(), "occlusion map: not used"),
            (
                self.is_unlit(),
                "material without shading (KHR_materials_unlit): lit as diffuse",
            ),
        ];
        for (is_present, message) in rest {
            if is_present {
                self.warn(message);
            }
        }
    }

    /// The texture coordinates of its pictures: those of the first that it has.
    fn coordinates(&self) -> GltfSurface {
        let pbr = &self.json.pbr_metallic_roughness;
        let first = [
            &pbr.base_color_texture,
            &self.json.emissive_texture,
            &pbr.metallic_roughness_texture,
        ];
        let first = first.into_iter().flatten().next().map(coordinates_of);
        let last = || self.json.normal_texture.as_ref().map(normal_coordinates);
        first.or_else(last).unwrap_or(GltfSurface::plain(0))
    }
}

/// Metalness and roughness of a material: their means, and the pictures that vary them.
struct GltfFinish {
    means: [f64; 2],
    maps: Option<FinishMaps>,
}

/// The texture coordinates of a texture.
fn coordinates_of(info: &Info) -> GltfSurface {
    placed(info.tex_coord, transform_of(info))
}

/// The texture coordinates of a normal map.
fn normal_coordinates(map: &NormalTexture) -> GltfSurface {
    let others = map.extensions.as_ref().map(|e| &e.others);
    let transform = others.and_then(|o| o.get("KHR_texture_transform"));
    let transform = transform.and_then(|t| serde_json::from_value(t.clone()).ok());
    placed(map.tex_coord, transform.as_ref())
}

fn placed(set: u32, transform: Option<&TextureTransform>) -> GltfSurface {
    GltfSurface {
        id: 0,
        is_textured: true,
        set: transform.and_then(|t| t.tex_coord).unwrap_or(set),
        picture_from_uv: transform.map_or(DAffine2::IDENTITY, transform_matrix),
        lightmap: None,
    }
}

fn transform_of(info: &Info) -> Option<&TextureTransform> {
    info.extensions.as_ref()?.texture_transform.as_ref()
}

/// `KHR_texture_transform`: scale, then rotation counter-clockwise as the texture is seen, then
/// offset. The formula in its specification turns the other way than its text and its example;
/// programs follow the text.
pub(super) fn transform_matrix(transform: &TextureTransform) -> DAffine2 {
    let [x, y] = transform.scale.0.map(f64::from);
    let offset = DVec2::from(transform.offset.0.map(f64::from));
    let (sin, cos) = f64::from(transform.rotation.0).sin_cos();
    let turn = DMat2::from_cols(DVec2::new(cos, -sin), DVec2::new(sin, cos));
    DAffine2::from_mat2_translation(turn * DMat2::from_diagonal(DVec2::new(x, y)), offset)
}

/// `Checked` without panics.
trait Value<T> {
    fn value(self) -> Option<T>;
}

impl<T> Value<T> for Checked<T> {
    fn value(self) -> Option<T> {
        match self {
            Checked::Valid(value) => Some(value),
            Checked::Invalid => None,
        }
    }
}
