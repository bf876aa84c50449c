//! New accessors of vertices and their corners.

use super::additions::Additions;
use super::json::Json;
use super::primitives::{Attributes, Primitive, accessor_index};
use super::splits::VertexGroup;
use gltf_json::accessor::ComponentType;
use serde_json::json;

/// Accessors that take the place of those of a list of vertices.
#[derive(Clone, Debug, Default)]
pub struct NewVertices {
    /// Attributes.
    pub attributes: Attributes,
    /// Attributes of morph targets, each with the number of its target.
    pub targets: Vec<(usize, String, usize)>,
}

impl NewVertices {
    /// Gives them to a primitive.
    pub fn give(&self, primitive: &mut Json) {
        for (name, accessor) in &self.attributes {
            primitive.key("attributes").key(name).set(*accessor);
        }
        for (target, name, accessor) in &self.targets {
            primitive
                .key("targets")
                .at(*target)
                .key(name)
                .set(*accessor);
        }
    }
}

/// The largest index of vertices in 8 and 16 bits; the next one restarts primitives.
const LARGEST_INDEX: [u32; 2] = [254, 65_534];

impl Additions<'_> {
    /// Adds the texture coordinates of a list of vertices, as this set, and copies of its other attributes as
    /// [`Additions::copies`].
    ///
    /// # Errors
    /// As there.
    pub fn vertices(
        &mut self,
        group: &VertexGroup,
        primitive: &Primitive,
        set: u32,
    ) -> Result<NewVertices, String> {
        let name = |set: u32| format!("TEXCOORD_{set}");
        let mut new = self.copies(group, primitive, &name(set))?;
        let uvs = self.vectors(group.uvs.iter().map(|uv| uv.unwrap_or_default()));
        // Names are numbered without gaps (glTF 2.0, 3.7.2.1).
        let lower = (0..set)
            .map(name)
            .filter(|name| primitive.attribute(name).is_none());
        new.attributes
            .extend(lower.chain([name(set)]).map(|name| (name, uvs)));
        Ok(new)
    }

    /// Adds copies of the attributes of a list of vertices where vertices were copied or were compressed.
    /// `but` is an attribute that is not needed.
    ///
    /// # Errors
    /// The reason why an attribute cannot be copied.
    pub fn copies(
        &mut self,
        group: &VertexGroup,
        primitive: &Primitive,
        but: &str,
    ) -> Result<NewVertices, String> {
        let mut new = NewVertices::default();
        for (name, accessor) in primitive.attributes.iter().filter(|(name, _)| name != but) {
            let copy = self.copy(*accessor, group)?;
            new.attributes.extend(copy.map(|copy| (name.clone(), copy)));
        }
        for (i, target) in primitive.targets.iter().enumerate() {
            for (name, accessor) in target {
                let copy = self.copy(*accessor, group)?;
                new.targets.extend(copy.map(|copy| (i, name.clone(), copy)));
            }
        }
        Ok(new)
    }

    /// Whether the elements of an accessor are compressed with the rest of their primitive.
    fn is_compressed(&self, accessor: usize) -> bool {
        let data = &self.source.data;
        let known = data.root.accessors.get(accessor);
        let decoded = accessor_index(accessor).and_then(|index| data.draco.get(index));
        known.is_some_and(|a| a.buffer_view.is_none()) && matches!(decoded, Ok(Some(_)))
    }

    /// The accessor with the elements of another, and after them those of the copies; `None` if the other is
    /// as good.
    fn copy(&mut self, accessor: usize, group: &VertexGroup) -> Result<Option<usize>, String> {
        let is_compressed = self.is_compressed(accessor);
        if group.sources.is_empty() && !is_compressed || self.left.is_none() {
            return Ok(None);
        }
        let count = group.count;
        let (old, kind) = self.source.data.raw(accessor_index(accessor)?, count)?;
        let size = old.len() / count.max(1);
        let stride = size.next_multiple_of(4);
        let total = count + group.sources.len();
        let mut bytes = Vec::with_capacity(stride * total);
        for vertex in (0..count).chain(group.sources.iter().map(|v| *v as usize)) {
            bytes.extend_from_slice(&old[vertex * size..][..size]);
            bytes.resize(bytes.len().next_multiple_of(4), 0);
        }
        let view = self.view(&bytes, json!({ "byteStride": stride, "target": 34962 }));
        let entry = self.source.json.entries("accessors").get(accessor);
        let mut entry = entry.cloned().ok_or("an accessor out of range")?;
        for key in ["byteOffset", "sparse", "extensions"] {
            entry.remove(key);
        }
        entry.key("bufferView").set(view);
        entry.key("count").set(total);
        if is_compressed {
            entry.key("componentType").set(kind.as_gl_enum() as usize);
        }
        if kind == ComponentType::F32 {
            correct_bounds(&mut entry, &old, size);
        }
        Ok(Some(self.accessor(entry)))
    }

    /// The accessor of the corners of a primitive that had others in `old`.
    pub fn corners(&mut self, corners: &[u32], old: Option<usize>) -> usize {
        let accessor = old.and_then(|old| self.source.json.entries("accessors").get(old));
        let old = accessor.and_then(|a| a.get("componentType")?.index());
        let most = corners.iter().max().copied().unwrap_or(0);
        let (size, component) = match old {
            Some(5121) if most <= LARGEST_INDEX[0] => (1, 5121),
            Some(5125) => (4, 5125),
            _ if most <= LARGEST_INDEX[1] => (2, 5123),
            _ => (4, 5125),
        };
        let bytes = corners
            .iter()
            .flat_map(|v| v.to_le_bytes().into_iter().take(size));
        let view = self.view(&bytes.collect::<Vec<u8>>(), json!({ "target": 34963 }));
        let (count, kind) = (corners.len(), "SCALAR");
        let entry =
            json!({ "bufferView": view, "componentType": component, "count": count, "type": kind });
        self.accessor(entry.into())
    }
}

/// Corrects the bounds of an accessor that declares some: decompressed positions differ from those that
/// were compressed.
fn correct_bounds(accessor: &mut Json, elements: &[u8], size: usize) {
    let ends = [("min", f32::INFINITY), ("max", f32::NEG_INFINITY)];
    for (key, start) in ends {
        if accessor.get(key).is_none() {
            continue;
        }
        let mut bound = vec![start; size / 4];
        for element in elements.chunks_exact(size.max(1)) {
            for (bound, bytes) in bound.iter_mut().zip(element.as_chunks::<4>().0) {
                let value = f32::from_le_bytes(*bytes);
                *bound = if key == "min" {
                    bound.min(value)
                } else {
                    bound.max(value)
                };
            }
        }
        if bound.iter().all(|v| v.is_finite()) {
            accessor.key(key).set(json!(bound));
        }
    }
}
