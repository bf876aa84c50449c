//! Primitives as the document of a file has them.

use super::super::draco::DRACO;
use super::json::{Json, unescaped};
use super::source::Source;
use gltf_json::Index;
use gltf_json::mesh::Mode;
use std::borrow::Cow;
use std::collections::HashMap;

/// Names and accessors of attributes.
pub type Attributes = Vec<(String, usize)>;

/// A primitive of a mesh.
#[derive(Debug)]
pub struct Primitive {
    /// Its attributes.
    pub attributes: Attributes,
    /// Those of its morph targets.
    pub targets: Vec<Attributes>,
    /// Primitives with the same number have the same attributes and targets, so the same vertices.
    pub vertices: usize,
    /// The accessor of its indices.
    pub indices: Option<usize>,
    /// How its indices form triangles; `None` for points and lines.
    pub mode: Option<Mode>,
    /// Its material.
    pub material: Option<usize>,
    /// The materials of its mappings (`KHR_materials_variants`).
    pub variants: Vec<Option<usize>>,
    /// Whether it is compressed with Draco.
    pub has_draco: bool,
}

/// The steps to the mappings of materials in a primitive.
pub const MAPPINGS: [&str; 3] = ["extensions", "KHR_materials_variants", "mappings"];

/// The primitives of all meshes.
pub fn of_meshes(json: &Json) -> Vec<Vec<Primitive>> {
    let mut known = HashMap::new();
    let mut primitives = |mesh: &Json| {
        let list = mesh.entries("primitives").iter();
        list.map(|p| Primitive::of(p, &mut known)).collect()
    };
    json.entries("meshes").iter().map(&mut primitives).collect()
}

impl Primitive {
    fn of(json: &Json, known: &mut HashMap<(Attributes, Vec<Attributes>), usize>) -> Primitive {
        let index = |key: &str| json.get(key).and_then(Json::index);
        let attributes = json.get("attributes").map_or(Vec::new(), accessors);
        let targets: Vec<Attributes> = json.entries("targets").iter().map(accessors).collect();
        let next = known.len();
        let mappings = json.find(&MAPPINGS).map_or(&[][..], Json::list).iter();
        Primitive {
            vertices: *(known.entry((attributes.clone(), targets.clone()))).or_insert(next),
            attributes,
            targets,
            indices: index("indices"),
            mode: match index("mode") {
                None | Some(4) => Some(Mode::Triangles),
                Some(5) => Some(Mode::TriangleStrip),
                Some(6) => Some(Mode::TriangleFan),
                _ => None,
            },
            material: index("material"),
            variants: mappings.map(|m| m.get("material")?.index()).collect(),
            has_draco: json.find(&["extensions", DRACO]).is_some(),
        }
    }

    /// The accessor of an attribute.
    pub fn attribute(&self, name: &str) -> Option<usize> {
        let mut attributes = self.attributes.iter().rev();
        Some(attributes.find(|(key, _)| key == name)?.1)
    }

    /// The number of vertices.
    pub fn count(&self, source: &Source) -> Result<usize, String> {
        let positions = self.attribute("POSITION").ok_or("no positions")?;
        source.data.count(accessor_index(positions)?)
    }

    /// The vertices of its corners, as its mode has them.
    pub fn corners(&self, source: &Source, count: usize) -> Result<Vec<u32>, String> {
        let Some(indices) = self.indices else {
            return Ok((0..count as u32).collect());
        };
        let indices = accessor_index(indices)?;
        source.data.indices(indices, source.data.count(indices)?)
    }
}

/// An index of an accessor as the reader has it.
pub fn accessor_index<T>(index: usize) -> Result<Index<T>, String> {
    let index = u32::try_from(index).map_err(|_| "an accessor out of range")?;
    Ok(Index::new(index))
}

fn accessors(json: &Json) -> Attributes {
    let members = json.members().iter();
    let named =
        |(key, value): &(Cow<str>, Json)| Some((unescaped(key)?.into_owned(), value.index()?));
    members.filter_map(named).collect()
}
