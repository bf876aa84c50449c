//! Primitives compressed with Draco (`KHR_draco_mesh_compression`), decoded by `draco-core`.

use super::buffers::Buffers;
use draco_core::{DataType, DecodeLimits, DecoderBuffer, Mesh, MeshDecoder, PointAttribute};
use draco_core::{ErrorKind, PointIndex};
use gltf_json::accessor::{Accessor, ComponentType};
use gltf_json::mesh::{Mode, Primitive};
use gltf_json::validation::Checked;
use gltf_json::{Index, Root, Value};
use std::collections::HashMap;

/// Name of the extension.
pub(super) const DRACO: &str = "KHR_draco_mesh_compression";

/// The elements of an accessor that were compressed: one after another, without gaps.
#[derive(Debug)]
pub(super) struct DracoElements {
    /// Their bytes, as in an uncompressed buffer view.
    pub bytes: Vec<u8>,
    /// Type of each component.
    pub kind: ComponentType,
    /// Components of each element.
    pub width: usize,
    /// Number of elements. What the accessor says about it is not used.
    pub count: usize,
}

/// What the compressed primitives of a file contain, by index of accessor.
#[derive(Debug, Default)]
pub(super) struct DracoAccessors(HashMap<usize, Result<DracoElements, String>>);

impl DracoAccessors {
    /// Decodes all compressed primitives. Accessors with a buffer view are not replaced: a file that
    /// does not require the extension has the uncompressed data there.
    ///
    /// Together they may decode to `left` bytes.
    pub fn load(root: &Root, buffers: &Buffers, mut left: u64) -> DracoAccessors {
        let mut decoded = DracoAccessors::default();
        for primitive in root.meshes.iter().flat_map(|m| &m.primitives) {
            let extensions = primitive.extensions.as_ref();
            if let Some(json) = extensions.and_then(|e| e.others.get(DRACO)) {
                decoded.add(root, primitive, json, buffers, &mut left);
            }
        }
        decoded
    }

    /// The elements of an accessor, if they were compressed.
    ///
    /// # Errors
    /// The reason why they could not be decoded.
    pub fn get(&self, index: Index<Accessor>) -> Result<Option<&DracoElements>, String> {
        let elements = self.0.get(&index.value()).map(Result::as_ref);
        elements.transpose().map_err(String::clone)
    }

    fn add(
        &mut self,
        root: &Root,
        primitive: &Primitive,
        json: &Value,
        buffers: &Buffers,
        left: &mut u64,
    ) {
        let accessors = DracoParts::of(root, primitive, json);
        if accessors.0.is_empty() {
            return;
        }
        let mesh = decode(primitive, json, buffers, left);
        for (accessor, part) in accessors.0 {
            let elements = mesh.as_ref().map_err(String::clone);
            let elements = elements.and_then(|mesh| {
                let elements = match part {
                    DracoPart::Corners => corners(mesh),
                    DracoPart::Attribute(id) => attribute(mesh, id)?,
                };
                spend(left, elements.bytes.len())?;
                Ok(elements)
            });
            // Of two primitives with one accessor the first counts; both say the same.
            self.0.entry(accessor).or_insert(elements);
        }
    }
}

#[derive(Clone, Copy)]
enum DracoPart {
    Corners,
    /// The attribute with this identity in the Draco data.
    Attribute(u32),
}

/// The accessors that a primitive needs from its compressed data.
struct DracoParts(Vec<(usize, DracoPart)>);

impl DracoParts {
    fn of(root: &Root, primitive: &Primitive, json: &Value) -> DracoParts {
        let compressed = |index: &Index<Accessor>| {
            let accessor = root.get(*index);
            accessor.is_some_and(|a| a.buffer_view.is_none())
        };
        let mut list = Vec::new();
        let corners = primitive.indices.filter(compressed);
        list.extend(corners.map(|i| (i.value(), DracoPart::Corners)));
        let identities = json.get("attributes").and_then(Value::as_object);
        if let Some(identities) = identities {
            for (semantic, index) in primitive.attributes.iter().filter(|(_, i)| compressed(i)) {
                let identity = identities.get(&semantic.to_string());
                let identity = identity.and_then(Value::as_u64);
                if let Some(id) = identity.and_then(|id| u32::try_from(id).ok()) {
                    list.push((index.value(), DracoPart::Attribute(id)));
                }
            }
        }
        DracoParts(list)
    }
}

/// Takes `bytes` from what may still be decoded.
fn spend(left: &mut u64, bytes: usize) -> Result<(), String> {
    let enough = left.checked_sub(bytes as u64);
    *left = enough.ok_or("Draco data that decode to more than is allowed")?;
    Ok(())
}

/// The mesh of a compressed primitive.
fn decode(
    primitive: &Primitive,
    json: &Value,
    buffers: &Buffers,
    left: &mut u64,
) -> Result<Mesh, String> {
    if primitive.mode != Checked::Valid(Mode::Triangles) {
        return Err("Draco data that are not a list of triangles".to_owned());
    }
    let view = json.get("bufferView").and_then(Value::as_u64);
    let view = view.and_then(|v| u32::try_from(v).ok());
    let bytes = buffers.view(Index::new(view.ok_or("Draco data without a buffer view")?))?;
    // Time is spent on data that turn out to be damaged, too.
    spend(left, bytes.len())?;
    // A few bytes can describe millions of equal points, so what limits a file is its size decoded.
    let limits = DecodeLimits::permissive()
        .with_max_decoded_bytes(*left)
        .with_max_faces(*left / 12)
        .with_max_points(*left / 12);
    let mut buffer = DecoderBuffer::new(bytes).with_limits(limits);
    let mut mesh = Mesh::new();
    let decoded = MeshDecoder::new().decode(&mut buffer, &mut mesh);
    decoded.map_err(|e| match e.kind() {
        ErrorKind::LimitExceeded => "Draco data that decode to more than is allowed".to_owned(),
        _ => format!("damaged Draco data ({e})"),
    })?;
    Ok(mesh)
}

/// The corners of the triangles.
fn corners(mesh: &Mesh) -> DracoElements {
    let corners = mesh.faces().iter().flatten();
    let bytes: Vec<u8> = corners.flat_map(|p| p.0.to_le_bytes()).collect();
    DracoElements {
        count: bytes.len() / 4,
        bytes,
        kind: ComponentType::U32,
        width: 1,
    }
}

/// The values of an attribute, one for each point.
fn attribute(mesh: &Mesh, identity: u32) -> Result<DracoElements, String> {
    let attribute = mesh.attribute_by_unique_id(identity);
    let attribute = attribute.ok_or("an attribute that its Draco data do not contain")?;
    let kind = match attribute.data_type() {
        DataType::Int8 => ComponentType::I8,
        DataType::Uint8 => ComponentType::U8,
        DataType::Int16 => ComponentType::I16,
        DataType::Uint16 => ComponentType::U16,
        DataType::Uint32 => ComponentType::U32,
        DataType::Float32 => ComponentType::F32,
        _ => return Err("Draco data of a type that glTF does not have".to_owned()),
    };
    let count = mesh.num_points();
    let bytes = by_point(attribute, count).ok_or("damaged Draco data (missing values)")?;
    Ok(DracoElements {
        bytes,
        kind,
        width: attribute.num_components().into(),
        count,
    })
}

/// The bytes of an attribute's values in the order of the points, which share equal values.
fn by_point(attribute: &PointAttribute, points: usize) -> Option<Vec<u8>> {
    let size = attribute.data_type().byte_length() * usize::from(attribute.num_components());
    let stride = usize::try_from(attribute.byte_stride()).ok()?;
    let data = attribute.buffer().data();
    let mut bytes = Vec::with_capacity(size.checked_mul(points)?);
    for point in 0..points {
        let value = attribute.mapped_index(PointIndex(point as u32)).0 as usize;
        let start = value.checked_mul(stride)?;
        bytes.extend_from_slice(data.get(start..start.checked_add(size)?)?);
    }
    Some(bytes)
}
