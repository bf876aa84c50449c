//! Primitives as the text of a file has them.

use super::super::draco::DRACO;
use super::scan::{Span, elements, find, member, members, number};
use super::source::Source;
use gltf_json::Index;
use gltf_json::mesh::Mode;

/// Names and accessors of attributes.
pub type Attributes = Vec<(String, usize)>;

/// A primitive of a mesh.
#[derive(Debug)]
pub struct PrimitiveJson<'t> {
    /// Its attributes.
    pub attributes: Attributes,
    /// Those of its morph targets.
    pub targets: Vec<Attributes>,
    /// The texts of both: primitives with the same have the same vertices.
    pub key: (&'t str, &'t str),
    /// The accessor of its indices.
    pub indices: Option<usize>,
    /// How its indices form triangles; `None` for points and lines.
    pub mode: Option<Mode>,
    /// Its material.
    pub material: Option<usize>,
    /// The materials of its mappings (`KHR_materials_variants`).
    pub variants: Vec<Option<usize>>,
    /// Names of its extensions.
    pub extensions: Vec<String>,
}

/// The name of the extension with other materials.
pub const VARIANTS: &str = "KHR_materials_variants";

impl<'t> PrimitiveJson<'t> {
    /// The primitives of a mesh.
    pub fn of_mesh(text: &'t str, mesh: &Span) -> Vec<PrimitiveJson<'t>> {
        let list = member(text, mesh, "primitives").and_then(|list| elements(text, &list));
        let list = list.unwrap_or_default();
        list.iter()
            .map(|span| PrimitiveJson::of(text, span))
            .collect()
    }

    fn of(text: &'t str, span: &Span) -> PrimitiveJson<'t> {
        let value = |key: &str| member(text, span, key);
        let index = |key: &str| value(key).and_then(|v| number(text, &v));
        let own = value("attributes");
        let targets = value("targets");
        let target_list = targets.as_ref().and_then(|list| elements(text, list));
        let slice = |span: &Option<Span>| span.clone().map_or("", |s| &text[s]);
        let extensions = value("extensions").and_then(|e| members(text, &e));
        PrimitiveJson {
            key: (slice(&own), slice(&targets)),
            attributes: own.map_or(Vec::new(), |own| accessors(text, &own)),
            targets: target_list
                .iter()
                .flatten()
                .map(|target| accessors(text, target))
                .collect(),
            indices: index("indices"),
            mode: match index("mode") {
                None | Some(4) => Some(Mode::Triangles),
                Some(5) => Some(Mode::TriangleStrip),
                Some(6) => Some(Mode::TriangleFan),
                _ => None,
            },
            material: index("material"),
            variants: variants(text, span),
            extensions: extensions.into_iter().flatten().map(|m| m.key).collect(),
        }
    }

    /// The accessor of an attribute.
    pub fn attribute(&self, name: &str) -> Option<usize> {
        let found = self.attributes.iter().rev().find(|(key, _)| key == name);
        found.map(|(_, accessor)| *accessor)
    }

    /// Whether it is compressed.
    pub fn has_draco(&self) -> bool {
        self.extensions.iter().any(|name| name == DRACO)
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
        let length = source.data.count(indices)?;
        source.data.indices(indices, length)
    }
}

/// An index of an accessor as the reader has it.
pub fn accessor_index<T>(index: usize) -> Result<Index<T>, String> {
    let index = u32::try_from(index).map_err(|_| "an accessor out of range")?;
    Ok(Index::new(index))
}

fn accessors(text: &str, span: &Span) -> Attributes {
    let list = members(text, span).into_iter().flatten();
    list.filter_map(|m| Some((m.key, number(text, &m.value)?)))
        .collect()
}

fn variants(text: &str, primitive: &Span) -> Vec<Option<usize>> {
    let steps = ["extensions", VARIANTS, "mappings"];
    let list = find(text, primitive, &steps).and_then(|list| elements(text, &list));
    let list = list.into_iter().flatten();
    list.map(|m| member(text, &m, "material").and_then(|v| number(text, &v)))
        .collect()
}
