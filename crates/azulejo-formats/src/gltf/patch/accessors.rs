//! New accessors: texture coordinates, indices, and copies of others with more elements.

use super::super::accessor::Data;
use super::additions::Additions;
use super::error::PatchError;
use super::primitives::{Attributes, PrimitiveJson, accessor_index};
use super::scan::{self, Span};
use super::source::Source;
use super::splits::VertexGroup;
use gltf_json::accessor::ComponentType;
use serde_json::{Value, json};
use std::collections::HashMap;

/// Members of an accessor that say where its bytes are.
const PLACE: [&str; 5] = ["bufferView", "byteOffset", "count", "sparse", "extensions"];

/// The largest index of vertices in 8 and 16 bits; the next one restarts primitives.
const LARGEST_INDEX: [u32; 2] = [254, 65_534];

/// Accessors that take the place of those of a list of vertices.
#[derive(Clone, Debug, Default)]
pub struct NewVertices {
    /// The texture coordinates; `None` where they stay.
    pub uvs: Option<usize>,
    /// Attributes.
    pub attributes: Attributes,
    /// Attributes of morph targets, each with the number of its target.
    pub targets: Vec<(usize, String, usize)>,
}

/// Adds accessors for the vertices of a file.
pub struct NewAccessors<'s> {
    source: &'s Source<'s>,
    /// The accessors in the text.
    entries: Vec<Span>,
}

impl<'s> NewAccessors<'s> {
    /// Of a file.
    pub fn new(source: &'s Source<'s>) -> NewAccessors<'s> {
        NewAccessors {
            source,
            entries: source.list("accessors"),
        }
    }

    fn data(&self) -> &Data<'s> {
        &self.source.data
    }

    /// Adds the texture coordinates of a list of vertices, and copies of its other attributes as
    /// [`NewAccessors::copies`].
    ///
    /// # Errors
    /// As there.
    pub fn vertices(
        &self,
        group: &VertexGroup,
        primitive: &PrimitiveJson,
        but: &str,
        additions: &mut Additions,
    ) -> Result<Result<NewVertices, String>, PatchError> {
        let mut new = match self.copies(group, primitive, but, additions)? {
            Ok(new) => new,
            Err(fault) => return Ok(Err(fault)),
        };
        new.uvs = Some(self.uvs(group, additions)?);
        Ok(Ok(new))
    }

    /// Adds the texture coordinates of a list of vertices that has the copies of another.
    ///
    /// # Errors
    /// Too many bytes.
    pub fn same_vertices(
        &self,
        group: &VertexGroup,
        other: &NewVertices,
        additions: &mut Additions,
    ) -> Result<NewVertices, PatchError> {
        Ok(NewVertices {
            uvs: Some(self.uvs(group, additions)?),
            ..other.clone()
        })
    }

    /// Adds copies of the attributes of a list of vertices where vertices were copied or were compressed.
    /// `but` is an attribute that is not needed.
    ///
    /// # Errors
    /// The reason why an attribute cannot be copied. Too many bytes are an error of the whole.
    pub fn copies(
        &self,
        group: &VertexGroup,
        primitive: &PrimitiveJson,
        but: &str,
        additions: &mut Additions,
    ) -> Result<Result<NewVertices, String>, PatchError> {
        let mut known = HashMap::new();
        let mut copy = |accessor: usize| -> Result<Result<Option<usize>, String>, PatchError> {
            if group.sources.is_empty() && !self.is_compressed(accessor) {
                return Ok(Ok(None));
            }
            if let Some(&new) = known.get(&accessor) {
                return Ok(Ok(Some(new)));
            }
            let new = match self.copied(accessor, group, additions)? {
                Ok(new) => new,
                Err(fault) => return Ok(Err(fault)),
            };
            known.insert(accessor, new);
            Ok(Ok(Some(new)))
        };
        let mut new = NewVertices::default();
        for (name, accessor) in primitive.attributes.iter().filter(|(name, _)| name != but) {
            match copy(*accessor)? {
                Ok(copied) => new.attributes.extend(copied.map(|c| (name.clone(), c))),
                Err(fault) => return Ok(Err(fault)),
            }
        }
        for (i, target) in primitive.targets.iter().enumerate() {
            for (name, accessor) in target {
                match copy(*accessor)? {
                    Ok(copied) => new.targets.extend(copied.map(|c| (i, name.clone(), c))),
                    Err(fault) => return Ok(Err(fault)),
                }
            }
        }
        Ok(Ok(new))
    }

    /// Whether the elements of an accessor are compressed with the rest of their primitive.
    fn is_compressed(&self, accessor: usize) -> bool {
        let known = self.data().root.accessors.get(accessor);
        let Ok(index) = accessor_index(accessor) else {
            return false;
        };
        known.is_some_and(|a| a.buffer_view.is_none())
            && matches!(self.data().draco.get(index), Ok(Some(_)))
    }

    fn uvs(&self, group: &VertexGroup, additions: &mut Additions) -> Result<usize, PatchError> {
        let uvs = group.uvs.iter().chain(&group.more_uvs);
        let count = group.uvs.len() + group.more_uvs.len();
        additions.spend(8 * count)?;
        let bytes: Vec<u8> = uvs.flatten().flat_map(|v| v.to_le_bytes()).collect();
        let view = additions.view(&bytes, &vertex_view(8));
        Ok(additions.accessor(format!(
            "{{\"bufferView\":{view},\"componentType\":5126,\"count\":{count},\"type\":\"VEC2\"}}"
        )))
    }

    /// Adds an attribute in single precision.
    ///
    /// # Errors
    /// Too many bytes.
    pub fn attribute(
        &self,
        values: &[[f32; 3]],
        additions: &mut Additions,
    ) -> Result<usize, PatchError> {
        let count = values.len();
        additions.spend(12 * count)?;
        let bytes: Vec<u8> = values
            .iter()
            .flatten()
            .flat_map(|v| v.to_le_bytes())
            .collect();
        let view = additions.view(&bytes, &vertex_view(12));
        Ok(additions.accessor(format!(
            "{{\"bufferView\":{view},\"componentType\":5126,\"count\":{count},\"type\":\"VEC3\"}}"
        )))
    }

    /// The accessor with the elements of another, and after them those of the copies.
    fn copied(
        &self,
        accessor: usize,
        group: &VertexGroup,
        additions: &mut Additions,
    ) -> Result<Result<usize, String>, PatchError> {
        let count = group.uvs.len();
        // No element is larger than a matrix of 4 × 4.
        let raw = accessor_index(accessor)
            .and_then(|index| Ok((self.data().width(index)?, index)))
            .and_then(|(_, index)| self.data().raw(index, count));
        let (old, kind) = match raw {
            Ok(raw) => raw,
            Err(fault) => return Ok(Err(fault)),
        };
        let size = old.len() / count.max(1);
        let stride = size.next_multiple_of(4);
        let total = count + group.sources.len();
        additions.spend(stride * total)?;
        let mut bytes = Vec::with_capacity(stride * total);
        let vertices = (0..count).chain(group.sources.iter().map(|v| *v as usize));
        for vertex in vertices {
            bytes.extend_from_slice(&old[vertex * size..][..size]);
            bytes.resize(bytes.len().next_multiple_of(4), 0);
        }
        let view = additions.view(&bytes, &vertex_view(stride));
        let members = self.members_of_copy(accessor, kind, &old, size);
        let entry = format!("{{\"bufferView\":{view},\"count\":{total}{members}}}");
        Ok(Ok(additions.accessor(entry)))
    }

    /// The members of an accessor, but for some.
    fn members(&self, accessor: usize, but: &[&str]) -> String {
        let text = self.source.text();
        let members = self
            .entries
            .get(accessor)
            .and_then(|e| scan::members(text, e));
        let members = members.into_iter().flatten();
        let kept = members.filter(|m| !but.contains(&m.key.as_str()));
        kept.map(|m| format!(",{}", &text[m.span])).collect()
    }

    /// The members of the copy of an accessor. Of a compressed one, type and bounds may differ from those
    /// declared; bounds that were wrong are not repeated.
    fn members_of_copy(
        &self,
        accessor: usize,
        kind: ComponentType,
        bytes: &[u8],
        size: usize,
    ) -> String {
        let json = self.data().root.accessors.get(accessor);
        let declared =
            json.and_then(|a| Some([numbers(a.min.as_ref()?), numbers(a.max.as_ref()?)]));
        let actual = declared.as_ref().map(|_| bounds(kind, bytes, size));
        let mut but = PLACE.to_vec();
        let mut entry = String::new();
        if self.is_compressed(accessor) {
            but.push("componentType");
            entry += &format!(",\"componentType\":{}", kind.as_gl_enum());
        }
        if let Some(actual) = actual.filter(|actual| declared.as_ref() != Some(actual))
            && actual.iter().flatten().all(|v| v.is_finite())
        {
            but.extend(["min", "max"]);
            let [least, most] = actual.map(|numbers| json!(numbers));
            entry += &format!(",\"min\":{least},\"max\":{most}");
        }
        self.members(accessor, &but) + &entry
    }

    /// The accessor of the corners of a primitive that had others in `old`.
    ///
    /// # Errors
    /// Too many bytes.
    pub fn corners(
        &self,
        corners: &[u32],
        old: Option<usize>,
        additions: &mut Additions,
    ) -> Result<usize, PatchError> {
        let old = old.and_then(|old| self.data().root.accessors.get(old));
        let old = old.map(|a| match a.component_type {
            gltf_json::validation::Checked::Valid(kind) => kind.0,
            gltf_json::validation::Checked::Invalid => ComponentType::U16,
        });
        let most = corners.iter().max().copied().unwrap_or(0);
        let size = match old {
            Some(ComponentType::U8) if most <= LARGEST_INDEX[0] => 1,
            Some(ComponentType::U32) => 4,
            _ if most <= LARGEST_INDEX[1] => 2,
            _ => 4,
        };
        additions.spend(size * corners.len())?;
        let bytes = corners
            .iter()
            .flat_map(|v| v.to_le_bytes().into_iter().take(size));
        let bytes: Vec<u8> = bytes.collect();
        let view = additions.view(&bytes, ",\"target\":34963");
        let component = match size {
            1 => 5121,
            2 => 5123,
            _ => 5125,
        };
        let count = corners.len();
        Ok(additions.accessor(format!(
            "{{\"bufferView\":{view},\"componentType\":{component},\"count\":{count},\"type\":\"SCALAR\"}}"
        )))
    }
}

/// What a view of vertices has beside its place. The stride is needed where accessors share the view.
fn vertex_view(stride: usize) -> String {
    format!(",\"byteStride\":{stride},\"target\":34962")
}

/// Bounds as they are declared, in the precision of the components.
fn numbers(bound: &Value) -> Vec<f64> {
    let list = bound.as_array().into_iter().flatten();
    list.map(|v| v.as_f64().map_or(f64::NAN, |v| f64::from(v as f32)))
        .collect()
}

/// Least and largest components.
fn bounds(kind: ComponentType, bytes: &[u8], size: usize) -> [Vec<f64>; 2] {
    let width = match kind {
        ComponentType::I8 | ComponentType::U8 => 1,
        ComponentType::I16 | ComponentType::U16 => 2,
        ComponentType::U32 | ComponentType::F32 => 4,
    };
    let value = |b: &[u8]| match (kind, b) {
        (ComponentType::I8, [a]) => f64::from(*a as i8),
        (ComponentType::U8, [a]) => f64::from(*a),
        (ComponentType::I16, [a, b]) => i16::from_le_bytes([*a, *b]).into(),
        (ComponentType::U16, [a, b]) => u16::from_le_bytes([*a, *b]).into(),
        (ComponentType::U32, [a, b, c, d]) => u32::from_le_bytes([*a, *b, *c, *d]).into(),
        (ComponentType::F32, [a, b, c, d]) => f32::from_le_bytes([*a, *b, *c, *d]).into(),
        _ => 0.0,
    };
    let components = size / width;
    let mut least = vec![f64::INFINITY; components];
    let mut most = vec![f64::NEG_INFINITY; components];
    for element in bytes.chunks_exact(size.max(1)) {
        for (k, b) in element.chunks_exact(width).enumerate() {
            least[k] = least[k].min(value(b));
            most[k] = most[k].max(value(b));
        }
    }
    [least, most]
}
