//! Materials and textures.

use super::node::V1Node;
use super::walk::V1Traversal;
use crate::reading::text::shortened;
use crate::surface::phong::Highlight;
use crate::vrml::appearance;
use azulejo_scene::{Material, MaterialId, Opacity, Rgb, Sidedness, TextureId, WrapMode};
use std::collections::HashMap;

/// VRML's specular exponent is its shininess times this, as in OpenGL.
const MOST_EXPONENT: f64 = 128.0;

/// Reflectance of surfaces without a Material.
const DEFAULT_DIFFUSE: Rgb = Rgb::grey(0.8);

/// Materials and textures already made for nodes of this file.
#[derive(Debug, Default)]
pub(super) struct V1MaterialCache {
    materials: HashMap<V1MaterialKey, MaterialId>,
    /// Keyed by the offset of the node.
    textures: HashMap<usize, Option<TextureId>>,
}

/// Everything that distinguishes two materials of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct V1MaterialKey {
    /// The offset of the Material node, and the index of the material in it.
    material: Option<(usize, u32)>,
    texture: Option<TextureId>,
    is_open: bool,
    has_inside: bool,
    is_colored: bool,
}

/// How many materials a node Material holds.
pub(super) fn count(material: &V1Node) -> usize {
    let diffuse = material.colors("diffuseColor").map_or(1, <[Rgb]>::len);
    beyond_diffuse(material).fold(diffuse, usize::max).max(1)
}

/// Whether the materials of a node differ in more than their diffuse colours.
pub(super) fn differ_beyond_diffuse(material: &V1Node) -> bool {
    beyond_diffuse(material).any(|count| count > 1)
}

/// The lengths of the other relevant fields.
fn beyond_diffuse<'n>(material: &'n V1Node) -> impl Iterator<Item = usize> + 'n {
    let colors = ["specularColor", "emissiveColor"];
    let numbers = ["shininess", "transparency", "mirror"];
    let colors = colors
        .into_iter()
        .filter_map(|f| Some(material.colors(f)?.len()));
    let numbers = numbers
        .into_iter()
        .filter_map(|f| Some(material.numbers(f)?.len()));
    colors.chain(numbers)
}

/// The value of the `i`-th material: the last one of a list that is too short.
fn nth<T: Copy>(list: Option<&[T]>, i: usize) -> Option<T> {
    let list = list?;
    list.get(i).or(list.last()).copied()
}

impl V1Traversal<'_, '_, '_> {
    /// The `i`-th of the current materials, for a surface that is closed, or open and seen from
    /// both sides; with `is_colored`, for one whose vertices have the diffuse colours.
    pub fn material(&mut self, i: usize, is_open: bool, is_colored: bool) -> MaterialId {
        let key = V1MaterialKey {
            material: self.state.material.map(|node| (node.at, i as u32)),
            texture: self.state.texture,
            is_open,
            has_inside: self.state.hints.has_inside,
            is_colored,
        };
        if let Some(&known) = self.cache.materials.get(&key) {
            return known;
        }
        let mut material = match self.state.material {
            Some(node) => self.described(node, i),
            None => Material::diffuse("", DEFAULT_DIFFUSE),
        };
        if is_colored {
            material.diffuse = Rgb::WHITE;
            // Vertex colours can reach white, so the specular share must leave room for them.
            material.limit_reflectance();
        }
        material.emits_back = is_open && material.is_emitter();
        if self.state.hints.has_inside {
            material.sidedness = Sidedness::One;
        }
        material.textures.extend(key.texture);
        if let Some(picture) = self.builder.textures.alpha_of(&material.textures) {
            let opacity = material.opacity.unwrap_or(Opacity::constant(1.0));
            material.opacity = Some(Opacity {
                picture: Some(picture),
                ..opacity
            });
        }
        let id = self.builder.materials.index(material);
        self.cache.materials.insert(key, id);
        id
    }

    /// The `i`-th material of a node.
    fn described(&mut self, node: &V1Node, i: usize) -> Material {
        let color = |field| nth(node.colors(field), i);
        let number = |field, default| nth(node.numbers(field), i).unwrap_or(default);
        let share = |x: f64| {
            if x.is_finite() {
                x.clamp(0.0, 1.0)
            } else {
                0.0
            }
        };
        let emission = color("emissiveColor").unwrap_or_default();
        // With an empty list of diffuse colours, the emissive colours hold precomputed lighting.
        let is_baked =
            node.colors("diffuseColor").is_some_and(<[Rgb]>::is_empty) && !emission.is_black();
        let default = if is_baked {
            Rgb::BLACK
        } else {
            DEFAULT_DIFFUSE
        };
        let mirror = share(number("mirror", 0.0));
        let diffuse = color("diffuseColor").unwrap_or(default).map(share);
        let mut material = Material {
            name: node.name.as_deref().unwrap_or_default().to_owned(),
            diffuse: (1.0 - mirror) * diffuse,
            mirror: Rgb::grey(mirror),
            emission: emission.map(|c| c.max(0.0)),
            ..Material::default()
        };
        material.limit_reflectance();
        let specular = color("specularColor").unwrap_or_default().map(share);
        let exponent = MOST_EXPONENT * share(number("shininess", 0.2));
        let highlight = Highlight::half(exponent, specular);
        if let Err(message) = self.builder.gloss.highlight(&mut material, highlight) {
            self.warn(node, message);
        }
        let opacity = Opacity::constant(1.0 - share(number("transparency", 0.0)));
        material.opacity = (!opacity.is_opaque()).then_some(opacity);
        material
    }

    /// Whether all current materials are fully transparent.
    pub fn is_invisible(&self) -> bool {
        let transparency = self.state.material.and_then(|m| m.numbers("transparency"));
        transparency.is_some_and(|list| !list.is_empty() && list.iter().all(|t| *t >= 1.0))
    }

    /// The texture of a Texture2 node; `None` if it has none.
    pub fn texture(&mut self, node: &V1Node) -> Option<TextureId> {
        if let Some(&known) = self.cache.textures.get(&node.at) {
            return known;
        }
        let wrap = ["wrapS", "wrapT"].map(|field| match node.word(field) {
            "CLAMP" => WrapMode::Clamp,
            _ => WrapMode::Repeat,
        });
        let id = match node.word("filename") {
            "" => self.pixel_texture_in_node(node),
            name => Some(self.picture(node, name)),
        };
        let id = id.map(|id| self.builder.textures.wrapped(id, wrap));
        self.cache.textures.insert(node.at, id);
        id
    }

    /// The texture in a file.
    fn picture(&mut self, node: &V1Node, name: &str) -> TextureId {
        let builder = &mut *self.builder;
        let (id, problem) = builder
            .textures
            .index(&self.source.path, name, builder.files);
        if let Some(problem) = problem {
            self.warn(node, problem);
        }
        id
    }

    /// The texture whose pixels are in the node; `None` if it has none.
    fn pixel_texture_in_node(&mut self, node: &V1Node) -> Option<TextureId> {
        let numbers = node.numbers("image")?;
        if numbers.iter().take(3).any(|n| *n == 0.0) {
            return None;
        }
        let name = shortened(node.name.as_deref().unwrap_or("Texture2"));
        let drawn = match appearance::pixels(numbers) {
            Some(image) => self.builder.textures.add_pixels(name, image),
            None => Err("it has fewer pixels than its size requires".to_owned()),
        };
        let warn = |why| self.warn(node, format!("pixels of a texture not used: {why}"));
        drawn.map_err(warn).ok()
    }
}
