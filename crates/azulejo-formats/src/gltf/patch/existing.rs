//! The lightmap that a file has, or the texture coordinates that one could have.

use super::super::origin::ObjectOrigin;
use super::super::topology;
use super::super::uri::{self, Uri};
use super::assign::mesh_of;
use super::error::PatchError;
use super::glb::Parts;
use super::looks::MOVED;
use super::primitives::{PrimitiveJson, accessor_index};
use super::source::{Source, parsed};
use super::types::{FoundLightmap, FoundPage, GltfFile, NO_PAGE, ObjectLayout};
use super::undo;
use crate::Files;
use serde_json::Value;
use std::collections::HashMap;

/// The set of texture coordinates where nothing names one, by `MOZ_lightmap`.
const USUAL_SET: u32 = 1;

/// Extensions of textures whose picture takes the place of the usual one.
const PICTURES: [&str; 2] = ["MOZ_texture_rgbe", "KHR_texture_basisu"];

/// Reads the lightmap of a file; see [`found_lightmap`](super::found_lightmap).
pub fn found(
    file: &GltfFile,
    origins: &[ObjectOrigin],
    set: Option<u32>,
) -> Result<FoundLightmap, PatchError> {
    read(file, origins, set, true)
}

/// Reads one set of coordinates; see [`coordinates`](super::coordinates).
pub fn coordinates(
    file: &GltfFile,
    origins: &[ObjectOrigin],
    set: u32,
) -> Result<FoundLightmap, PatchError> {
    read(file, origins, Some(set), false)
}

fn read(
    file: &GltfFile,
    origins: &[ObjectOrigin],
    set: Option<u32>,
    follows: bool,
) -> Result<FoundLightmap, PatchError> {
    // Nodes that share a mesh have coordinates each, as they may read the picture in other places.
    let faces: u64 = origins.iter().map(|o| o.faces.len() as u64).sum();
    if faces > file.options.most_elements {
        let found = format!("{faces} faces with those of all nodes that share a mesh");
        return Err(PatchError::of(file.name, found));
    }
    let parts = Parts::of(file.bytes, file.name)?;
    let root = parsed(&parts, file)?;
    let source = Source::new(parts, &root, file);
    let mut reader = LightmapReader {
        materials: values(&source, "materials"),
        nodes: values(&source, "nodes"),
        textures: values(&source, "textures"),
        meshes: source
            .list("meshes")
            .iter()
            .map(|span| PrimitiveJson::of_mesh(source.text(), span))
            .collect(),
        set,
        sets: Vec::new(),
        numbers: HashMap::new(),
        found: FoundLightmap::default(),
        files: file.files,
        source: &source,
    };
    let has_any = follows && reader.has_lightmap();
    if !follows {
        reader.materials.clear();
        reader.nodes.clear();
    }
    for origin in origins {
        let object = reader.object(origin, has_any);
        reader.found.objects.push(object);
    }
    reader.found.is_named = has_any;
    let note = undo::found(&reader.source.parts);
    reader.found.is_own = note.is_some_and(|note| !note.is_of_vertices());
    reader.found.set = reader.sets.iter().copied().max().unwrap_or(USUAL_SET);
    reader.found.is_one_set = reader.sets.len() <= 1;
    Ok(reader.found)
}

fn values(source: &Source, list: &str) -> Vec<Value> {
    let value = |span: &super::scan::Span| serde_json::from_str(&source.text()[span.clone()]);
    let list = source.list(list);
    list.iter()
        .map(|span| value(span).unwrap_or_default())
        .collect()
}

/// Reads what materials and nodes say of lightmaps.
struct LightmapReader<'r, 's> {
    source: &'r Source<'s>,
    files: &'r dyn Files,
    materials: Vec<Value>,
    nodes: Vec<Value>,
    textures: Vec<Value>,
    meshes: Vec<Vec<PrimitiveJson<'s>>>,
    /// The set that is asked for.
    set: Option<u32>,
    /// Sets that are used.
    sets: Vec<u32>,
    /// Pages by picture.
    numbers: HashMap<Option<usize>, u32>,
    found: FoundLightmap,
}

impl LightmapReader<'_, '_> {
    /// Whether a material or a node has a lightmap.
    fn has_lightmap(&self) -> bool {
        let of = |list: &[Value], name| list.iter().any(|m| extension(m, name).is_some());
        of(&self.materials, "MOZ_lightmap") || of(&self.nodes, "MX_lightmap")
    }

    /// The coordinates of an object; `None` if it has none. Where the file has lightmaps, only those of
    /// primitives with one.
    fn object(&mut self, origin: &ObjectOrigin, has_any: bool) -> Option<ObjectLayout> {
        let mesh = mesh_of(self.source, origin.node)?;
        let node = self.nodes.get(origin.node).cloned().unwrap_or_default();
        let mut layout = ObjectLayout::default();
        for faces in origin.faces.chunk_by(|a, b| a.primitive == b.primitive) {
            let primitive = faces[0].primitive as usize;
            let info = self.info(mesh, primitive, &node);
            let set = self.set.or_else(|| info.as_ref()?.texture_set());
            let set = set.unwrap_or(USUAL_SET);
            let uvs = match (&info, has_any) {
                (None, true) => None,
                _ => self.corners(mesh, primitive, set),
            };
            let page = match &uvs {
                Some(_) => self.page(info.as_ref()),
                None => NO_PAGE,
            };
            if uvs.is_some() && !self.sets.contains(&set) {
                self.sets.push(set);
            }
            for face in faces {
                let of_face = uvs.as_ref().and_then(|all| all.get(face.triangle as usize));
                let [a, b, c] = of_face.copied().unwrap_or_default();
                let turned = if origin.mirrored {
                    [a, c, b]
                } else {
                    [a, b, c]
                };
                let placed = |uv| info.as_ref().map_or(uv, |info| info.placed(uv));
                layout.uvs.push(turned.map(placed));
                layout.pages.push(match of_face {
                    Some(_) => page,
                    None => NO_PAGE,
                });
            }
        }
        let has_page = layout.pages.iter().any(|p| *p != NO_PAGE);
        has_page.then_some(layout)
    }

    /// What is said of the lightmap of a primitive.
    fn info(&self, mesh: usize, primitive: usize, node: &Value) -> Option<LightmapInfo> {
        if let Some(mx) = extension(node, "MX_lightmap") {
            return LightmapInfo::of_mx(mx);
        }
        let primitive = self.meshes.get(mesh)?.get(primitive)?;
        let material = self.materials.get(primitive.material?)?;
        LightmapInfo::of_moz(extension(material, "MOZ_lightmap")?)
    }

    /// The coordinates of all triangles of a primitive.
    fn corners(&self, mesh: usize, primitive: usize, set: u32) -> Option<Vec<[[f32; 2]; 3]>> {
        let primitive = self.meshes.get(mesh)?.get(primitive)?;
        let count = primitive.count(self.source).ok()?;
        let accessor = primitive.attribute(&format!("TEXCOORD_{set}"))?;
        let accessor = accessor_index(accessor).ok()?;
        // `count` was justified when the positions were read.
        let uvs = self
            .source
            .data
            .read(accessor, count, |[u, v]: [f64; 2]| [u as f32, v as f32]);
        let uvs = uvs.ok()?;
        let corners = primitive.corners(self.source, count).ok()?;
        let triangles = topology::triangles(primitive.mode?, &corners);
        let uv = |v: u32| uvs.get(v as usize).copied().unwrap_or([f32::NAN; 2]);
        let all = 0..triangles.count();
        Some(all.map(|t| triangles.get(t).map(uv)).collect())
    }

    /// The number of the page of a lightmap.
    fn page(&mut self, info: Option<&LightmapInfo>) -> u32 {
        let image = info.and_then(|info| self.image(info.texture));
        let intensity = info.map_or(1.0, |i| i.intensity);
        if let Some(&known) = self.numbers.get(&image) {
            let page = &mut self.found.pages[known as usize];
            page.intensity = page.intensity.max(intensity);
            return known;
        }
        let number = self.found.pages.len() as u32;
        let picture = match (info, image) {
            (None, _) => Ok(None),
            (Some(_), None) => Err("a texture without a picture".to_owned()),
            (Some(_), Some(image)) => self.picture(image).map(Some),
        };
        self.found.pages.push(FoundPage { picture, intensity });
        self.numbers.insert(image, number);
        number
    }

    /// The picture of a texture.
    fn image(&self, texture: u64) -> Option<usize> {
        let texture = self.textures.get(usize::try_from(texture).ok()?)?;
        let own = PICTURES
            .iter()
            .find_map(|name| extension(texture, name)?.get("source"));
        let image = own.or_else(|| texture.get("source"))?.as_u64()?;
        usize::try_from(image).ok()
    }

    /// The bytes of a picture.
    fn picture(&self, image: usize) -> Result<Vec<u8>, String> {
        let image = self.source.data.root.images.get(image);
        let image = image.ok_or("a picture that is not in the file")?;
        match (image.buffer_view, &image.uri) {
            (Some(view), _) => Ok(self.source.data.buffers.view(view)?.to_vec()),
            (None, Some(uri)) => match uri::read(uri)? {
                Uri::Data(bytes) => Ok(bytes),
                Uri::File(name) => self.files.read(&name).map_err(|e| e.to_string()),
            },
            (None, None) => Err("an image without a uri".to_owned()),
        }
    }
}

fn extension<'v>(value: &'v Value, name: &str) -> Option<&'v Value> {
    value.get("extensions")?.get(name)
}

/// What is said of a lightmap.
#[derive(Debug)]
struct LightmapInfo {
    texture: u64,
    set: u64,
    intensity: f64,
    offset: [f64; 2],
    scale: [f64; 2],
    /// Counter-clockwise, radians.
    rotation: f64,
}

impl LightmapInfo {
    fn of_moz(moz: &Value) -> Option<LightmapInfo> {
        let moved = extension(moz, MOVED);
        let set = moved
            .and_then(|m| m.get("texCoord"))
            .or(moz.get("texCoord"));
        Some(LightmapInfo {
            texture: moz.get("index")?.as_u64()?,
            set: set.and_then(Value::as_u64).unwrap_or(USUAL_SET.into()),
            intensity: moz.get("intensity").and_then(Value::as_f64).unwrap_or(1.0),
            offset: pair(moved, "offset").unwrap_or([0.0; 2]),
            scale: pair(moved, "scale").unwrap_or([1.0; 2]),
            rotation: moved
                .and_then(|m| m.get("rotation")?.as_f64())
                .unwrap_or(0.0),
        })
    }

    fn of_mx(mx: &Value) -> Option<LightmapInfo> {
        // Some files have the texture's members at the extension itself.
        let texture = mx.get("lightMapTexture").unwrap_or(mx);
        let set = texture.get("texCoord").and_then(Value::as_u64);
        Some(LightmapInfo {
            texture: texture.get("index")?.as_u64()?,
            set: set.unwrap_or(USUAL_SET.into()),
            intensity: mx.get("intensity").and_then(Value::as_f64).unwrap_or(1.0),
            offset: pair(Some(mx), "offset").unwrap_or([0.0; 2]),
            scale: pair(Some(mx), "scale").unwrap_or([1.0; 2]),
            rotation: 0.0,
        })
    }

    fn texture_set(&self) -> Option<u32> {
        u32::try_from(self.set).ok()
    }

    /// Coordinates as they read the picture (`KHR_texture_transform`).
    fn placed(&self, uv: [f32; 2]) -> [f32; 2] {
        if (self.offset, self.scale, self.rotation) == ([0.0; 2], [1.0; 2], 0.0) {
            return uv;
        }
        let [u, v] = [0, 1].map(|k| self.scale[k] * f64::from(uv[k]));
        let (sin, cos) = self.rotation.sin_cos();
        let turned = [cos * u + sin * v, cos * v - sin * u];
        [0, 1].map(|k| (self.offset[k] + turned[k]) as f32)
    }
}

fn pair(value: Option<&Value>, key: &str) -> Option<[f64; 2]> {
    let list = value?.get(key)?;
    Some([list.get(0)?.as_f64()?, list.get(1)?.as_f64()?])
}
