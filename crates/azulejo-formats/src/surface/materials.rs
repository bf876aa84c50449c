//! The materials of a scene under construction, each once.

use azulejo_scene::{Material, MaterialId, OpacityChannel, OpacityMode, Rgb, Sidedness};
use std::collections::HashMap;

/// Materials in the order in which they are first used; equal ones are merged.
#[derive(Debug, Default)]
pub(crate) struct Materials {
    list: Vec<Material>,
    known: HashMap<Key, MaterialId>,
}

/// Everything that distinguishes two materials, with numbers as bits.
#[derive(Debug, PartialEq, Eq, Hash)]
struct Key {
    name: String,
    colors: [[u64; 3]; 3],
    emission_picture: Option<u32>,
    emits_back: bool,
    sidedness: Sidedness,
    dielectric: Option<(u64, [u64; 3], bool)>,
    textures: Vec<u32>,
    brdf: String,
    opacity: Option<OpacityKey>,
    /// Finish, relief and lightmap, as they print: their numbers differ where the text does.
    maps: String,
}

/// The constant, the picture and the cutoff of an opacity.
type OpacityKey = (u64, Option<(u32, OpacityChannel)>, Option<u64>);

fn bits(color: Rgb) -> [u64; 3] {
    color.to_array().map(f64::to_bits)
}

impl Key {
    fn of(m: &Material) -> Key {
        Key {
            name: m.name.clone(),
            colors: [m.diffuse, m.mirror, m.emission].map(bits),
            emission_picture: m.emission_picture,
            emits_back: m.emits_back,
            sidedness: m.sidedness,
            dielectric: m
                .dielectric
                .map(|d| (d.ior.to_bits(), bits(d.transmittance), d.thin)),
            textures: m.textures.clone(),
            brdf: m
                .brdf
                .as_ref()
                .map(|b| b.description().to_string())
                .unwrap_or_default(),
            opacity: m.opacity.map(|o| {
                let picture = o.picture.map(|p| (p.texture, p.channel));
                let cutoff = match o.mode {
                    OpacityMode::Mask { cutoff } => Some(cutoff.to_bits()),
                    OpacityMode::Blend => None,
                };
                (o.constant.to_bits(), picture, cutoff)
            }),
            maps: match (&m.finish, &m.relief, &m.lightmap) {
                (None, None, None) => String::new(),
                maps => format!("{maps:?}"),
            },
        }
    }
}

impl Materials {
    /// The index of a material, which is added if it is new.
    pub fn index(&mut self, material: Material) -> MaterialId {
        *self.known.entry(Key::of(&material)).or_insert_with(|| {
            self.list.push(material);
            (self.list.len() - 1) as MaterialId
        })
    }

    /// The material with an index.
    ///
    /// # Panics
    /// If there is no material with that index.
    pub fn get(&self, id: MaterialId) -> &Material {
        &self.list[id as usize]
    }

    /// All materials, in the order of their indices.
    pub fn into_list(self) -> Vec<Material> {
        self.list
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::Opacity;

    #[test]
    fn equal_materials_are_one() {
        let mut materials = Materials::default();
        let grey = || Material::diffuse("grey", Rgb::grey(0.5));
        assert_eq!(materials.index(grey()), 0);
        assert_eq!(materials.index(Material::mirror("grey", Rgb::grey(0.5))), 1);
        assert_eq!(materials.index(grey()), 0);
        let lamp = Material {
            emits_back: true,
            ..grey()
        };
        assert_eq!(materials.index(lamp), 2);
        let sheet = Material {
            sidedness: Sidedness::Two,
            ..grey()
        };
        assert_eq!(materials.index(sheet), 3);
        let sheer = |opacity: f64| Material {
            opacity: Some(Opacity::constant(opacity)),
            ..grey()
        };
        assert_eq!(
            [0.5, 0.25, 0.5].map(|o| materials.index(sheer(o))),
            [4, 5, 4]
        );
        assert_eq!(materials.into_list().len(), 6);
    }
}
