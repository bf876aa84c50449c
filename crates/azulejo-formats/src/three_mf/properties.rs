//! Materials and colours: groups of properties, to which triangles refer.

use super::part::PartReader;
use crate::ReadError;
use crate::picture::srgb::linear_color;
use crate::stl::painted;
use crate::surface::textures::Textures;
use azulejo_scene::{Material, MaterialId, Rgb, Scene, WrapMode};
use glam::DVec2;
use roxmltree::Node;
use std::collections::HashMap;

/// The materials of a scene under construction.
#[derive(Default)]
pub(super) struct Palette {
    pub scene: Scene,
    pub textures: Textures,
    default: Option<MaterialId>,
    painted: HashMap<[u64; 3], MaterialId>,
    white: Option<MaterialId>,
}

impl Palette {
    /// The material of what has none.
    pub fn plain(&mut self) -> MaterialId {
        let scene = &mut self.scene;
        *self
            .default
            .get_or_insert_with(|| scene.add_material(Material::diffuse("default", Rgb::grey(0.5))))
    }

    /// A material of one colour.
    pub fn painted(&mut self, color: Rgb) -> MaterialId {
        let scene = &mut self.scene;
        let key = color.to_array().map(f64::to_bits);
        let known = self.painted.entry(key);
        *known.or_insert_with(|| scene.add_material(painted(color)))
    }

    /// The material of surfaces whose vertices have colours.
    pub fn white(&mut self) -> MaterialId {
        let scene = &mut self.scene;
        *self
            .white
            .get_or_insert_with(|| scene.add_material(Material::diffuse("colors", Rgb::WHITE)))
    }
}

/// Properties that triangles choose by their number.
pub(super) enum PropertyGroup {
    Materials(Vec<MaterialId>),
    Colors(Vec<Rgb>),
    Texture(MaterialId, Vec<DVec2>),
    /// What is not read.
    Unknown,
}

/// The groups of a part by their ids.
pub(super) type PropertyGroups = HashMap<u32, PropertyGroup>;

/// Reads all groups of a part; elements are known by their local names, whatever their namespace.
pub(super) fn groups(
    resources: Node,
    reader: &mut PartReader,
    palette: &mut Palette,
) -> Result<PropertyGroups, ReadError> {
    let mut groups = PropertyGroups::new();
    let mut pictures = HashMap::new();
    for node in resources.children().filter(Node::is_element) {
        let name = node.tag_name().name();
        let group = match name {
            "basematerials" => base_materials(node, reader, palette)?,
            "colorgroup" => colors(node, reader)?,
            "texture2d" => {
                let texture = picture(node, reader, palette)?;
                pictures.insert(reader.id(node, "id")?, texture);
                continue;
            }
            "texture2dgroup" => texture_group(node, &pictures, reader, palette)?,
            "compositematerials" => composites(node, &groups, reader, palette)?,
            "multiproperties" => first_layer(node, reader)?,
            "object" => continue,
            other => {
                reader.warn(node, format!("resource \"{other}\" is not read: skipped"));
                continue;
            }
        };
        groups.insert(reader.id(node, "id")?, group);
    }
    Ok(groups)
}

fn base_materials(
    node: Node,
    reader: &mut PartReader,
    palette: &mut Palette,
) -> Result<PropertyGroup, ReadError> {
    if node.attribute("displaypropertiesid").is_some() {
        let what = "materials with metallic, specular or translucent display properties: their colour alone is read";
        reader.warn(node, what.to_owned());
    }
    let mut list = Vec::new();
    for base in node.children().filter(|n| n.tag_name().name() == "base") {
        let color = reader.color(base, "displaycolor")?;
        let name = base.attribute("name").unwrap_or_default();
        list.push(palette.scene.add_material(Material::diffuse(name, color)));
    }
    Ok(PropertyGroup::Materials(list))
}

fn colors(node: Node, reader: &mut PartReader) -> Result<PropertyGroup, ReadError> {
    let colors = node.children().filter(|n| n.tag_name().name() == "color");
    let list: Result<Vec<Rgb>, ReadError> = colors.map(|n| reader.color(n, "color")).collect();
    Ok(PropertyGroup::Colors(list?))
}

/// A white material with a picture.
fn picture(
    node: Node,
    reader: &mut PartReader,
    palette: &mut Palette,
) -> Result<MaterialId, ReadError> {
    let path = node.attribute("path").unwrap_or_default();
    let bytes = reader.package.part(path)?;
    let read = bytes.ok_or_else(|| "there is no such part".to_owned());
    let (texture, problem) = palette.textures.embedded(path.to_owned(), read);
    if let Some(problem) = problem {
        reader.warn(node, problem);
    }
    let wrap = ["tilestyleu", "tilestylev"].map(|name| match node.attribute(name) {
        Some("mirror") => WrapMode::Mirror,
        Some("clamp" | "none") => WrapMode::Clamp,
        _ => WrapMode::Repeat,
    });
    let texture = palette.textures.wrapped(texture, wrap);
    let mut material = Material::diffuse(path, Rgb::WHITE);
    if palette.textures.is_loaded(texture) {
        material.textures.push(texture);
    } else {
        material.diffuse = Rgb::grey(0.5);
    }
    Ok(palette.scene.add_material(material))
}

fn texture_group(
    node: Node,
    pictures: &HashMap<u32, MaterialId>,
    reader: &mut PartReader,
    palette: &mut Palette,
) -> Result<PropertyGroup, ReadError> {
    let id = reader.id(node, "texid")?;
    let material = match pictures.get(&id) {
        Some(material) => *material,
        None => {
            reader.warn(node, format!("texture {id} is not declared before: grey"));
            palette.plain()
        }
    };
    let mut uvs = Vec::new();
    for at in node
        .children()
        .filter(|n| n.tag_name().name() == "tex2coord")
    {
        uvs.push(DVec2::new(reader.number(at, "u")?, reader.number(at, "v")?));
    }
    Ok(PropertyGroup::Texture(material, uvs))
}

/// Mixtures of base materials, by their shares.
fn composites(
    node: Node,
    groups: &PropertyGroups,
    reader: &mut PartReader,
    palette: &mut Palette,
) -> Result<PropertyGroup, ReadError> {
    let id = reader.id(node, "matid")?;
    let Some(PropertyGroup::Materials(bases)) = groups.get(&id) else {
        reader.warn(
            node,
            format!("composites of {id}, which are no base materials: grey"),
        );
        return Ok(PropertyGroup::Unknown);
    };
    let chosen = numbers(node.attribute("matindices"));
    let mut list = Vec::new();
    for composite in node.children().filter(Node::is_element) {
        let shares = numbers(composite.attribute("values"));
        let (mut sum, mut color) = (0.0, Rgb::BLACK);
        for (index, share) in chosen.iter().zip(shares) {
            let base = bases.get(*index as usize).filter(|_| share > 0.0);
            if let Some(base) = base {
                sum += share;
                color += palette.scene.materials[*base as usize].diffuse * share;
            }
        }
        let color = if sum > 0.0 {
            color / sum
        } else {
            Rgb::grey(0.5)
        };
        list.push(palette.painted(color));
    }
    Ok(PropertyGroup::Materials(list))
}

/// The numbers of a list; what is none ends it.
fn numbers(text: Option<&str>) -> Vec<f64> {
    let words = text.unwrap_or_default().split_whitespace();
    let numbers = words.map_while(|word| word.parse().ok());
    numbers.filter(|x: &f64| x.is_finite()).collect()
}

/// Several properties in one: not read.
fn first_layer(node: Node, reader: &mut PartReader) -> Result<PropertyGroup, ReadError> {
    let what = "several properties in layers (multiproperties) are not read: grey";
    reader.warn(node, what.to_owned());
    Ok(PropertyGroup::Unknown)
}

/// A colour as linear light: `#rrggbb`, or with an alpha, of which is told whether it is less than 1.
pub(super) fn color(text: &str) -> Option<(Rgb, bool)> {
    let digits = text.trim().strip_prefix('#')?;
    let is_whole = matches!(digits.len(), 6 | 8) && digits.bytes().all(|b| b.is_ascii_hexdigit());
    let code = u32::from_str_radix(digits, 16).ok().filter(|_| is_whole)?;
    let (code, alpha) = match digits.len() {
        6 => (code, 255),
        _ => (code >> 8, code & 255),
    };
    let part = |shift: u32| f64::from(code >> shift & 255) / 255.0;
    let color = linear_color(Rgb::new(part(16), part(8), part(0)));
    Some((color, alpha < 255))
}
