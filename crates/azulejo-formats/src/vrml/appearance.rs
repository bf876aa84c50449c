//! Appearances: materials, textures and texture coordinate transformations.

use super::builder::VrmlSceneBuilder;
use super::tree::VrmlNode;
use crate::ReadError;
use crate::picture::srgb::linear_from_srgb;
use crate::reading::text::shortened;
use crate::surface::gloss::SMOOTHEST;
use crate::surface::phong::Highlight;
use azulejo_scene::{
    FinishMaps, Image, Material, NumberPicture, Opacity, OpacityMode, PictureChannel, Relief,
    ReliefKind, Rgb, TextureId, WrapMode,
};
use glam::{DAffine2, DMat2, DVec2};
use std::collections::HashMap;
use std::rc::Rc;

/// Diffuse reflectance of a shape without a material, or of a material that does not define one.
const DIFFUSE: Rgb = Rgb::grey(0.8);

/// Factor between `shininess` and the exponent of a highlight: ISO/IEC 14772-1, 4.14.4.
const SHININESS: f64 = 128.0;

/// The appearance of a shape.
#[derive(Debug)]
pub(super) struct ShapeAppearance {
    /// The material, without textures.
    pub material: Material,
    /// The textures.
    pub textures: Vec<TextureId>,
    /// Whether the textures replace the diffuse reflectance instead of being multiplied with it.
    replaces: bool,
    /// The transformation of the texture coordinates.
    pub texture_from_uv: Option<DAffine2>,
}

impl ShapeAppearance {
    /// Whether pictures vary the surface, which then needs texture coordinates.
    pub fn is_pictured(&self) -> bool {
        let material = &self.material;
        !self.textures.is_empty() || material.finish.is_some() || material.relief.is_some()
    }

    /// The material of a surface with texture coordinates; `color` replaces the material's own
    /// colour.
    pub fn textured(&self, color: Option<Rgb>) -> Material {
        let own = if self.replaces {
            Rgb::WHITE
        } else {
            self.material.diffuse
        };
        let mut material = Material {
            textures: self.textures.clone(),
            diffuse: color.unwrap_or(own),
            ..self.material.clone()
        };
        material.limit_reflectance();
        material
    }
}

/// Appearances that have been resolved. Many shapes share one, and loading textures takes time.
#[derive(Default)]
pub(super) struct AppearanceCache {
    /// Keyed by the address of the node, which is kept alive so that no other node can reuse it.
    known: HashMap<*const VrmlNode, (Rc<VrmlNode>, Option<Rc<ShapeAppearance>>)>,
}

impl AppearanceCache {
    /// The largest number of entries: instances of prototypes may each have their own appearance.
    const MOST: usize = 4096;

    fn get(&self, appearance: &Rc<VrmlNode>) -> Option<Option<Rc<ShapeAppearance>>> {
        let known = self.known.get(&Rc::as_ptr(appearance));
        known.map(|(_, shape_appearance)| shape_appearance.clone())
    }

    fn keep(&mut self, appearance: Rc<VrmlNode>, shape_appearance: Option<Rc<ShapeAppearance>>) {
        if self.known.len() == AppearanceCache::MOST {
            self.known.clear();
        }
        let address = Rc::as_ptr(&appearance);
        self.known.insert(address, (appearance, shape_appearance));
    }
}

impl VrmlSceneBuilder<'_> {
    /// The appearance of the node `shape`; `None`, with a warning, if it is invisible.
    ///
    /// # Errors
    /// The model unfolds to more than the options allow.
    pub(super) fn appearance(
        &mut self,
        shape: &VrmlNode,
    ) -> Result<Option<Rc<ShapeAppearance>>, ReadError> {
        let appearance = shape.nodes("appearance").first();
        let known = appearance.and_then(|a| self.appearances.get(a));
        let shape_appearance = match known {
            Some(shape_appearance) => shape_appearance,
            None => {
                let shape_appearance = self.new_appearance(shape)?.map(Rc::new);
                if let Some(appearance) = appearance {
                    self.appearances
                        .keep(appearance.clone(), shape_appearance.clone());
                }
                shape_appearance
            }
        };
        if shape_appearance.is_none() {
            let message = "shape with transparency 1: invisible, skipped";
            self.warn_node(shape, message);
        }
        Ok(shape_appearance)
    }

    /// The appearance of a shape that is not cached yet; `None` if it is invisible.
    fn new_appearance(&mut self, shape: &VrmlNode) -> Result<Option<ShapeAppearance>, ReadError> {
        let appearance = self.child(shape, "appearance")?;
        let material = match &appearance {
            Some(appearance) => self.child(appearance, "material")?,
            None => None,
        };
        let mut shape_appearance = ShapeAppearance {
            material: Material::diffuse("", DIFFUSE),
            textures: Vec::new(),
            replaces: false,
            texture_from_uv: None,
        };
        match &material {
            Some(m) if m.number("transparency", 0.0) >= 1.0 => return Ok(None),
            Some(material) => shape_appearance.material = self.surface_material(material)?,
            None => {
                let message = "shape without a material, which VRML displays unlit: diffuse with reflectance 0.8";
                self.warn_node(shape, message);
            }
        }
        let Some(appearance) = appearance else {
            return Ok(Some(shape_appearance));
        };
        if shape_appearance.material.name.is_empty() {
            let name = appearance.name.as_deref().unwrap_or_default();
            shape_appearance.material.name = name.to_owned();
        }
        self.resolve_textures(&appearance, material.as_deref(), &mut shape_appearance)?;
        resolve_opacity(self, &appearance, &mut shape_appearance);
        self.warn_other_fields(&appearance, KNOWN_OF_APPEARANCE);
        Ok(Some(shape_appearance))
    }

    /// A material without textures.
    fn surface_material(&mut self, node: &Rc<VrmlNode>) -> Result<Material, ReadError> {
        let mut material = match &*node.kind {
            "PhysicalMaterial" => self.physical_material(node)?,
            "UnlitMaterial" => Material::emitter("", node.color("emissiveColor", Rgb::WHITE)),
            "Material" | "TwoSidedMaterial" => self.phong_material(node),
            kind => {
                let message = format!("material {}: diffuse with reflectance 0.8", shortened(kind));
                self.warn_node(node, message);
                Material::diffuse("", DIFFUSE)
            }
        };
        let opacity = Opacity::constant(1.0 - node.number("transparency", 0.0).clamp(0.0, 1.0));
        material.opacity = (!opacity.is_opaque()).then_some(opacity);
        if node.flag("separateBackColor", false) {
            let message = "TwoSidedMaterial with separate back colours: the front colours are used on both sides";
            self.warn_node(node, message);
        }
        self.warn_other_fields(node, KNOWN);
        material.name = node.name.as_deref().unwrap_or_default().to_owned();
        // Since X3D 4.
        let relief = self.number_picture(node, "normalTexture")?;
        material.relief = relief.map(|texture| Relief {
            texture,
            kind: ReliefKind::Normals {
                scale: node.number("normalScale", 1.0),
            },
        });
        Ok(material)
    }

    /// Warns about every field that is not among `known`.
    fn warn_other_fields(&mut self, node: &VrmlNode, known: &[&str]) {
        let is_lost = |name: &str| !known.contains(&name) && !name.starts_with("metadata");
        for field in node.fields().iter().filter(|f| is_lost(&f.name)) {
            let message = format!("{} of {}: skipped", shortened(&field.name), node.kind);
            self.warn_node(node, message);
        }
    }

    fn phong_material(&mut self, node: &VrmlNode) -> Material {
        let diffuse = node.color("diffuseColor", DIFFUSE);
        let specular = node.color("specularColor", Rgb::BLACK);
        // An extension of Castle Game Engine: the reflectance of a perfect mirror.
        let mirror = node.number("mirror", 0.0).clamp(0.0, 1.0);
        let mut material = Material {
            mirror: Rgb::grey(mirror),
            emission: node.color("emissiveColor", Rgb::BLACK),
            ..Material::diffuse("", diffuse * (1.0 - mirror))
        };
        let exponent = SHININESS * node.number("shininess", 0.2).clamp(0.0, 1.0);
        let highlight = Highlight::half(exponent, specular);
        if let Err(message) = self.gloss.highlight(&mut material, highlight) {
            self.warn_node(node, message);
        }
        material
    }

    /// glTF's base colour, metalness and roughness; the last two are the blue and the green channel of a texture, times
    /// factors.
    fn physical_material(&mut self, node: &Rc<VrmlNode>) -> Result<Material, ReadError> {
        let share = |name: &str| node.number(name, 1.0).clamp(0.0, 1.0);
        let mut finish = FinishMaps {
            base: node.color("baseColor", Rgb::WHITE),
            metallic: share("metallic"),
            roughness: share("roughness"),
            metallic_picture: None,
            roughness_picture: None,
        };
        let (mut metallic, mut roughness) = (finish.metallic, finish.roughness);
        // A texture colours metals, too.
        let mut is_varied = metallic > 0.0 && !node.nodes("baseTexture").is_empty();
        if !node.nodes("metallicRoughnessTexture").is_empty() {
            let texture = self.number_picture(node, "metallicRoughnessTexture")?;
            let known = texture.and_then(|id| Some((id, self.textures.numbers(id)?.mean())));
            // Factors alone say nothing: those of what is no metal are 1, too.
            (metallic, roughness) = known.map_or((0.0, 1.0), |(_, mean)| {
                (metallic * mean.z, (roughness * mean.y).max(SMOOTHEST))
            });
            let picture = |channel| known.map(|(texture, _)| NumberPicture { texture, channel });
            finish.metallic_picture = picture(PictureChannel::Blue);
            finish.roughness_picture = picture(PictureChannel::Green);
            is_varied = known.is_some();
        }
        let mut material = Material {
            emission: node.color("emissiveColor", Rgb::BLACK),
            ..Material::default()
        };
        let gloss = &mut self.gloss;
        if let Err(message) =
            gloss.metallic_roughness(&mut material, finish.base, metallic, roughness)
        {
            self.warn_node(node, message);
        }
        // Without a model the surface is matt, or a mirror.
        material.finish = (is_varied && material.brdf.is_some()).then_some(finish);
        Ok(material)
    }

    /// The picture of numbers in a field of a material; with a warning, none if it cannot be read.
    fn number_picture(
        &mut self,
        material: &VrmlNode,
        field: &str,
    ) -> Result<Option<TextureId>, ReadError> {
        let Some(node) = self.child(material, field)? else {
            return Ok(None);
        };
        let picture = match &*node.kind {
            "ImageTexture" => self.image_texture(&node),
            "PixelTexture" => self.pixel_texture(&node),
            _ => None,
        };
        let picture = picture.filter(|id| self.textures.is_loaded(*id));
        if picture.is_none() {
            self.warn_node(&node, format!("{field} without a picture: not used"));
        }
        Ok(picture)
    }

    /// Finds the textures of an appearance: its own, or since X3D 4 those of its material.
    fn resolve_textures(
        &mut self,
        appearance: &VrmlNode,
        material: Option<&VrmlNode>,
        shape_appearance: &mut ShapeAppearance,
    ) -> Result<(), ReadError> {
        let mut texture = self.child(appearance, "texture")?;
        for field in ["diffuseTexture", "baseTexture"] {
            if let (None, Some(material)) = (&texture, material) {
                texture = self.child(material, field)?;
            }
        }
        let Some(texture) = texture else {
            return Ok(());
        };
        self.picture(&texture, shape_appearance)?;
        let is_colored = |id: &TextureId| self.textures.image(*id).is_some_and(is_colored);
        // Single-channel textures, and since X3D 4 all textures, are multiplied.
        shape_appearance.replaces =
            !appearance.source.is_x3d_4() && shape_appearance.textures.iter().any(is_colored);
        if let Some(transform) = self.child(appearance, "textureTransform")? {
            shape_appearance.texture_from_uv = self.texture_transform(&transform);
        }
        Ok(())
    }

    fn picture(
        &mut self,
        node: &Rc<VrmlNode>,
        shape_appearance: &mut ShapeAppearance,
    ) -> Result<(), ReadError> {
        match &*node.kind {
            "ImageTexture" => shape_appearance.textures.extend(self.image_texture(node)),
            "PixelTexture" => shape_appearance.textures.extend(self.pixel_texture(node)),
            "MultiTexture" => {
                let message = "MultiTexture: its textures are multiplied, using the first texture coordinates";
                self.warn_node(node, message);
                // The standard does not allow a MultiTexture inside another.
                for part in node.nodes("texture") {
                    if let Some(part) = self.unfold(part)?
                        && &*part.kind != "MultiTexture"
                    {
                        self.picture(&part, shape_appearance)?;
                    }
                }
            }
            _ => self.skip(node),
        }
        Ok(())
    }

    /// The texture in a file: the first of the URLs that exists.
    fn image_texture(&mut self, node: &VrmlNode) -> Option<TextureId> {
        let id = self.texture_of_urls(node, &node.strings("url"))?;
        Some(self.textures.wrapped(id, wrap_of(node)))
    }

    /// A texture of a side of the background; nodes other than pictures have none.
    pub(super) fn side_texture(&mut self, node: &VrmlNode) -> Option<TextureId> {
        let id = match &*node.kind {
            "ImageTexture" => self.texture_of_urls(node, &node.strings("url")),
            "PixelTexture" => self.pixel_texture(node),
            _ => {
                let message = format!("{} of a background: skipped", node.kind);
                self.warn_node(node, message);
                None
            }
        }?;
        self.textures.image(id).map(|_| id)
    }

    /// The first of the files of a node that is there.
    pub(super) fn texture_of_urls(
        &mut self,
        node: &VrmlNode,
        urls: &[String],
    ) -> Option<TextureId> {
        let beside = |url: &String| crate::reading::files::beside(&node.source.path, url);
        let exists = |url: &&String| self.files.read(&beside(url)).is_ok();
        let url = match urls {
            [] => return None,
            [only] => only,
            several => several.iter().find(exists).unwrap_or(&several[0]),
        };
        let (id, problem) = self.textures.index(&node.source.path, url, self.files);
        if let Some(problem) = problem {
            self.warn_node(node, problem);
        }
        Some(id)
    }

    /// The texture whose pixels are in the node itself.
    fn pixel_texture(&mut self, node: &VrmlNode) -> Option<TextureId> {
        let numbers = node.numbers("image");
        let pixel_texture = match pixels(&numbers) {
            Some(image) => {
                let name = node.name.as_deref().unwrap_or("PixelTexture");
                let added = self.textures.add_pixels(shortened(name), image);
                added.map(|id| self.textures.wrapped(id, wrap_of(node)))
            }
            None => Err("it has fewer pixels than its size requires".to_owned()),
        };
        pixel_texture
            .map_err(|why| {
                let message = format!("PixelTexture not used: {why}");
                self.warn_node(node, message);
            })
            .ok()
    }

    /// −C × S × R × C × T, ISO/IEC 14772-1, 6.49.
    fn texture_transform(&mut self, node: &Rc<VrmlNode>) -> Option<DAffine2> {
        if &*node.kind != "TextureTransform" {
            self.skip(node);
            return None;
        }
        let vector = |name: &str, default: f64| DVec2::from(node.array(name, [default; 2]));
        let center = vector("center", 0.0);
        Some(
            DAffine2::from_translation(-center)
                * DAffine2::from_scale(vector("scale", 1.0))
                * DAffine2::from_mat2(DMat2::from_angle(node.number("rotation", 0.0)))
                * DAffine2::from_translation(center + vector("translation", 0.0)),
        )
    }
}

/// Fields of appearances that are used.
const KNOWN_OF_APPEARANCE: &[&str] = &[
    "material",
    "texture",
    "textureTransform",
    "alphaMode",
    "alphaCutoff",
];

/// The opacity by the alpha channel of a texture, which replaces that of the material until X3D 4
/// (ISO/IEC 14772-1, 4.14) and multiplies it since, and by X3D 4's alpha mode.
fn resolve_opacity(
    builder: &VrmlSceneBuilder,
    appearance: &VrmlNode,
    shape_appearance: &mut ShapeAppearance,
) {
    let mode = appearance.strings("alphaMode");
    let mode = mode.first().map_or("AUTO", String::as_str);
    let material = &mut shape_appearance.material;
    let picture = builder.textures.alpha_of(&shape_appearance.textures);
    let constant = material.opacity.map_or(1.0, |o| o.constant);
    let opacity = Opacity {
        constant: match picture {
            Some(_) if !appearance.source.is_x3d_4() => 1.0,
            _ => constant,
        },
        picture,
        mode: match mode {
            "MASK" => OpacityMode::Mask {
                cutoff: appearance.number("alphaCutoff", 0.5).clamp(0.0, 1.0),
            },
            _ => OpacityMode::Blend,
        },
    };
    material.opacity = (mode != "OPAQUE" && !opacity.is_opaque()).then_some(opacity);
}

/// Fields of materials that are used, that are reported elsewhere, or that describe light that
/// azulejo computes.
const KNOWN: &[&str] = &[
    "ambientIntensity",
    "diffuseColor",
    "emissiveColor",
    "specularColor",
    "shininess",
    "transparency",
    "separateBackColor",
    "backAmbientIntensity",
    "backDiffuseColor",
    "backEmissiveColor",
    "backShininess",
    "backSpecularColor",
    "backTransparency",
    "baseColor",
    "metallic",
    "roughness",
    "diffuseTexture",
    "baseTexture",
    "metallicRoughnessTexture",
    "normalTexture",
    "normalScale",
    "mirror",
];

/// Whether an image has colours other than shades of grey.
fn is_colored(image: &Image) -> bool {
    image.pixels.iter().any(|[r, g, b]| r != g || g != b)
}

/// How a texture goes on beyond its edges.
fn wrap_of(node: &VrmlNode) -> [WrapMode; 2] {
    let repeats = ["repeatS", "repeatT"].map(|field| node.flag(field, true));
    repeats.map(|repeats| {
        if repeats {
            WrapMode::Repeat
        } else {
            WrapMode::Clamp
        }
    })
}

/// Width, height, channels and pixels, bottom row first: ISO/IEC 14772-1, 5.5.
pub(super) fn pixels(numbers: &[f64]) -> Option<Image> {
    let (&[width, height, channels], pixels) = numbers.split_first_chunk()?;
    let (width, height) = (width as u32, height as u32);
    let count = (width as usize).checked_mul(height as usize)?;
    if count == 0 || pixels.len() < count {
        return None;
    }
    let rows = pixels[..count].chunks_exact(width as usize).rev();
    let pixel = |&packed: &f64| unpacked(packed as u32, channels as u32);
    let alpha = |&packed: &f64| (packed as u32 & 0xff) as f32 / 255.0;
    let alphas =
        matches!(channels as u32, 2 | 4).then(|| rows.clone().flatten().map(alpha).collect());
    let image = Image::opaque(width, height, rows.flatten().map(pixel).collect());
    Some(match alphas {
        Some(alphas) => image.with_alpha(alphas),
        None => image,
    })
}

/// A pixel with 1 to 4 channels packed into one number, the first channel most significant, as
/// linear RGB.
fn unpacked(packed: u32, channels: u32) -> [f32; 3] {
    let byte = |shift: u32| linear((packed >> shift & 0xff) as u8);
    match channels {
        1 => [byte(0); 3],
        2 => [byte(8); 3],
        3 => [byte(16), byte(8), byte(0)],
        _ => [byte(24), byte(16), byte(8)],
    }
}

/// Linear value of an sRGB byte, IEC 61966-2-1; image files use the same encoding.
fn linear(byte: u8) -> f32 {
    linear_from_srgb(f32::from(byte) / 255.0)
}
