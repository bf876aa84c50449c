//! Lightmaps of materials. A material stays shared where all its users agree on their page, else some get a
//! copy of the same name.

use super::additions::Additions;
use super::assign::Placement;
use super::json::Json;
use super::looks::{MOVED, MaterialLightmap};
use super::notes::Notes;
use super::primitives::Primitive;
use super::types::{Convention, LightmapEdit, LightmapPage, MediaType};
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// The light of a primitive: its page, and how its coordinates are moved, as bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Lit {
    page: u32,
    placement: Option<[u32; 4]>,
}

impl Lit {
    /// The light of a page.
    pub fn new(page: u32, placement: Option<Placement>) -> Lit {
        let bits = |p: Placement| [p.offset[0], p.offset[1], p.scale[0], p.scale[1]];
        Lit {
            page,
            placement: placement.map(|p| bits(p).map(f32::to_bits)),
        }
    }

    /// How its coordinates are moved.
    pub fn placement(&self) -> Option<Placement> {
        let [a, b, c, d] = self.placement?.map(f32::from_bits);
        Some(Placement {
            offset: [a, b],
            scale: [c, d],
        })
    }
}

/// The textures of the pages, each added when it is first used.
pub struct Textures<'l> {
    pages: &'l [LightmapPage],
    mipmaps: bool,
    known: HashMap<u32, PageTextures>,
    sampler: Option<usize>,
}

/// The textures of a page: that of its light, and those of where it comes from.
#[derive(Clone, Debug)]
pub struct PageTextures {
    pub light: usize,
    pub directions: Vec<usize>,
}

impl<'l> Textures<'l> {
    /// None yet.
    pub fn new(edit: &LightmapEdit<'l>) -> Textures<'l> {
        Textures {
            pages: edit.pages,
            mipmaps: edit.mipmaps,
            known: HashMap::new(),
            sampler: None,
        }
    }

    /// A page and the index of its texture.
    pub fn of(
        &mut self,
        page: u32,
        additions: &mut Additions,
    ) -> Option<(&'l LightmapPage, PageTextures)> {
        let content = self.pages.get(page as usize)?;
        if let Some(known) = self.known.get(&page) {
            return Some((content, known.clone()));
        }
        // Clamped, since a page does not go on beyond its edges; mipmaps only if the padding is made for them.
        let least = if self.mipmaps { 9987 } else { 9729 };
        let clamped =
            json!({ "magFilter": 9729, "minFilter": least, "wrapS": 33071, "wrapT": 33071 });
        let sampler = self.sampler;
        let sampler = sampler.unwrap_or_else(|| additions.append("samplers", clamped));
        self.sampler = Some(sampler);
        let light = texture(content, sampler, additions);
        let light = additions.append("textures", light);
        let directions = content.directions.iter().enumerate().map(|(axis, png)| {
            let name = format!("{}, direction {axis}", content.name);
            let image = additions.image(&name, png, "image/png", "png");
            additions.append(
                "textures",
                json!({ "sampler": sampler, "source": image, "name": name }),
            )
        });
        let directions = directions.collect();
        let textures = PageTextures { light, directions };
        self.known.insert(page, textures.clone());
        Some((content, textures))
    }
}

/// The entry of the texture of a page.
fn texture(page: &LightmapPage, sampler: usize, additions: &mut Additions) -> Value {
    let (kind, ending, extension) = match page.media_type {
        MediaType::Png => ("image/png", "png", None),
        MediaType::Hdr => ("image/vnd.radiance", "hdr", Some("MOZ_texture_rgbe")),
        MediaType::Ktx2 => ("image/ktx2", "ktx2", Some("KHR_texture_basisu")),
    };
    let mut texture = json!({ "sampler": sampler });
    let image = additions.image(&page.name, &page.picture, kind, ending);
    match extension {
        None => texture["source"] = image.into(),
        Some(extension) => {
            if let Some(png) = &page.fallback {
                let png = additions.image(&page.name, png, "image/png", "png");
                texture["source"] = png.into();
            }
            texture["extensions"] = json!({ extension: { "source": image } });
            additions.use_extension("extensionsUsed", extension);
        }
    }
    if !page.name.is_empty() {
        texture["name"] = page.name.as_str().into();
    }
    texture
}

/// Which materials take the place of others.
#[derive(Debug, Default)]
pub struct Replaced {
    of: HashMap<(Option<usize>, Lit), usize>,
    /// Materials that stay as they are.
    others: usize,
}

impl Replaced {
    /// Whether no material shows light.
    pub fn is_empty(&self) -> bool {
        self.of.is_empty()
    }

    /// Whether some materials stay as they are.
    pub fn has_others(&self) -> bool {
        self.others > 0
    }

    /// Whether a material shows this light: some stay as they are.
    pub fn shows(&self, material: Option<usize>, lit: Lit) -> bool {
        self.of.contains_key(&(material, lit))
    }

    /// The material that a primitive with this light gets in the place of its own.
    pub fn of(&self, material: Option<usize>, lit: Lit) -> Option<usize> {
        let new = self.of.get(&(material, lit)).copied();
        new.filter(|new| Some(*new) != material)
    }
}

/// Who uses each material, and with what light.
#[derive(Debug, Default)]
pub struct MaterialUses(BTreeMap<Option<usize>, BTreeSet<Option<Lit>>>);

impl MaterialUses {
    /// Counts the materials of a primitive, of its variants, too.
    pub fn add(&mut self, primitive: &Primitive, lit: Option<Lit>) {
        let all = primitive.variants.iter().chain([&primitive.material]);
        for material in all {
            self.0.entry(*material).or_default().insert(lit);
        }
    }

    /// The materials of surfaces that get light, and whether others have them, too.
    pub fn receiving(&self) -> impl Iterator<Item = (usize, bool)> + '_ {
        let entries = self.0.iter();
        entries.filter_map(|(material, uses)| {
            let is_lit = uses.iter().any(Option::is_some);
            material
                .filter(|_| is_lit)
                .map(|m| (m, uses.contains(&None)))
        })
    }

    /// Gives all materials their light.
    pub fn light(
        &self,
        edit: &LightmapEdit,
        set: u32,
        textures: &mut Textures,
        additions: &mut Additions,
        notes: &mut Notes,
    ) -> Replaced {
        let mut replaced = Replaced::default();
        let pages = self.0.values().flatten().flatten().map(|lit| lit.page);
        for page in pages.collect::<BTreeSet<u32>>() {
            textures.of(page, additions);
        }
        for (&material, uses) in &self.0 {
            let old = material.and_then(|m| additions.source.json.entries("materials").get(m));
            let mut place = material.filter(|_| old.is_some() && !uses.contains(&None));
            for lit in uses.iter().flatten() {
                let Some((page, textures)) = textures.of(lit.page, additions) else {
                    continue;
                };
                let placement = lit.placement();
                let look = MaterialLightmap {
                    page,
                    textures: &textures,
                    set,
                    placement,
                };
                let (new, extensions) = match look.lit(edit.convention, old) {
                    Ok(lit) => lit,
                    Err(fault) => {
                        notes.add(&fault);
                        replaced.others += 1;
                        continue;
                    }
                };
                if edit.convention == Convention::Moz && has_occlusion(old) {
                    notes.add(
                        "material with a picture of occlusion: viewers darken the lightmap by it, which has that \
                         shade already",
                    );
                }
                for extension in extensions {
                    additions.use_extension("extensionsUsed", extension);
                }
                if placement.is_some() {
                    // Without the transform the coordinates are those of another place.
                    additions.use_extension("extensionsRequired", MOVED);
                }
                let index = if let Some(place) = place.take() {
                    additions.json.key("materials").at(place).set(new);
                    place
                } else {
                    notes.add(match old {
                        Some(_) => "material whose users have different light: copied",
                        None => "primitive without material: gets a grey one, as it was lit",
                    });
                    additions.append("materials", new)
                };
                replaced.of.insert((material, *lit), index);
            }
        }
        replaced
    }
}

fn has_occlusion(material: Option<&Json>) -> bool {
    material.is_some_and(|m| m.get("occlusionTexture").is_some())
}
