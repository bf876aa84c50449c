//! The lightmap that a file has, or the texture coordinates that one could have.

use super::super::lightmap::{self, NamedLightmap, OF_MATERIALS, OF_NODES};
use super::super::origin::ObjectOrigin;
use super::super::topology;
use super::super::uri::{self, Uri};
use super::error::PatchError;
use super::json::Json;
use super::mark::MARK;
use super::primitives::{self, Primitive, accessor_index};
use super::source::{Source, with_source};
use super::splits::turned;
use super::strip;
use super::types::{FoundLightmap, FoundPage, GltfFile, NO_PAGE, ObjectLayout};
use glam::DAffine2;
use std::collections::HashMap;

/// The set of texture coordinates where nothing names one, by `MOZ_lightmap`.
const USUAL_SET: u32 = 1;

/// Extensions of textures whose picture takes the place of the usual one.
const PICTURES: [&str; 2] = ["MOZ_texture_rgbe", "KHR_texture_basisu"];

/// The lightmap that a file has, by `MOZ_lightmap` or `MX_lightmap`, whoever made it; if it has none, the texture
/// coordinates that could be used for one. `origins` are those of its objects; `set` is the set of
/// coordinates, by default the one that lightmaps name, else 1.
///
/// # Errors
/// Files that cannot be read or are not UTF-8.
pub fn found_lightmap(
    file: &GltfFile,
    origins: &[ObjectOrigin],
    set: Option<u32>,
) -> Result<FoundLightmap, PatchError> {
    read(file, origins, set, true)
}

/// One set of texture coordinates as it is in the file, whatever lightmaps it has, as
/// [`found_lightmap`] has it.
///
/// # Errors
/// Files that cannot be read or are not UTF-8.
pub fn coordinates(
    file: &GltfFile,
    origins: &[ObjectOrigin],
    set: u32,
) -> Result<FoundLightmap, PatchError> {
    read(file, origins, Some(set), false)
}

/// Reads the lightmap of a file, or one set of its coordinates alone.
fn read(
    file: &GltfFile,
    origins: &[ObjectOrigin],
    set: Option<u32>,
    follows_lightmaps: bool,
) -> Result<FoundLightmap, PatchError> {
    // Nodes that share a mesh have coordinates each, as they may read the picture in other places.
    let faces: u64 = origins.iter().map(|o| o.faces.len() as u64).sum();
    if faces > file.options.most_elements {
        let found = format!("{faces} faces with those of all nodes that share a mesh");
        return Err(PatchError::of(file.name, found));
    }
    with_source(file, |source| {
        let mut reader = LightmapReader {
            meshes: primitives::of_meshes(&source.json),
            set,
            follows_lightmaps,
            sets: Vec::new(),
            numbers: HashMap::new(),
            pages: Vec::new(),
            source,
        };
        let is_named = reader.has_lightmap();
        let mut object = |origin| reader.object(origin, is_named);
        let objects = origins.iter().map(&mut object).collect();
        let mark = source.json.find(&MARK);
        Ok(FoundLightmap {
            is_named,
            is_own: mark.is_some_and(|mark| !strip::is_of_vertices(mark)),
            set: reader.sets.iter().copied().max().unwrap_or(USUAL_SET),
            is_one_set: reader.sets.len() <= 1,
            objects,
            pages: reader.pages,
        })
    })
}

/// Reads the lightmaps of materials and nodes.
struct LightmapReader<'r, 's> {
    source: &'r Source<'s>,
    meshes: Vec<Vec<Primitive>>,
    /// The set that is asked for.
    set: Option<u32>,
    follows_lightmaps: bool,
    /// Sets that are used.
    sets: Vec<u32>,
    /// Pages by picture.
    numbers: HashMap<Option<usize>, u32>,
    pages: Vec<FoundPage>,
}

impl LightmapReader<'_, '_> {
    /// Whether a material or a node has a lightmap.
    fn has_lightmap(&self) -> bool {
        let has_one = |list: &str, name: &str| {
            let mut list = self.source.json.entries(list).iter();
            list.any(|entry| entry.find(&["extensions", name]).is_some())
        };
        self.follows_lightmaps && (has_one("materials", OF_MATERIALS) || has_one("nodes", OF_NODES))
    }

    /// The coordinates of an object; `None` if it has none. Where the file has lightmaps, only those of
    /// primitives with one.
    fn object(&mut self, origin: &ObjectOrigin, has_any: bool) -> Option<ObjectLayout> {
        let mesh = self.source.mesh_of(origin.node)?;
        let mut layout = ObjectLayout::default();
        for faces in origin.faces.chunk_by(|a, b| a.primitive == b.primitive) {
            let primitive = faces[0].primitive as usize;
            let named = self.named(mesh, primitive, origin.node);
            let set = self.set.or(named.map(|named| named.coordinates.set));
            let set = set.unwrap_or(USUAL_SET);
            let uvs = match (&named, has_any) {
                (None, true) => None,
                _ => self.corners(mesh, primitive, set),
            };
            let page = uvs.as_ref().map(|_| self.page(named));
            if page.is_some() && !self.sets.contains(&set) {
                self.sets.push(set);
            }
            let moved = named.map(|named| named.coordinates.picture_from_uv);
            let moved = moved.filter(|moved| *moved != DAffine2::IDENTITY);
            let placed = |[u, v]: [f32; 2]| match moved {
                Some(moved) => moved
                    .transform_point2([u, v].map(f64::from).into())
                    .as_vec2()
                    .into(),
                None => [u, v],
            };
            for face in faces {
                let corners = uvs.as_ref().and_then(|all| all.get(face.triangle as usize));
                let turned = turned(corners.copied().unwrap_or_default(), origin.mirrored);
                layout.uvs.push(turned.map(placed));
                layout
                    .pages
                    .push(page.filter(|_| corners.is_some()).unwrap_or(NO_PAGE));
            }
        }
        let has_page = layout.pages.iter().any(|p| *p != NO_PAGE);
        has_page.then_some(layout)
    }

    /// The lightmap of a primitive, as its node or its material names it.
    fn named(&self, mesh: usize, primitive: usize, node: usize) -> Option<NamedLightmap> {
        if !self.follows_lightmaps {
            return None;
        }
        let (json, root) = (&self.source.json, self.source.data.root);
        let extension = |list: &str, entry: usize, name: &str| {
            let extension = json.entries(list).get(entry)?.find(&["extensions", name])?;
            serde_json::from_str(&extension.to_string()).ok()
        };
        if let Some(of_node) = extension("nodes", node, OF_NODES) {
            return lightmap::of_node(&of_node, root).ok();
        }
        let material = self.meshes.get(mesh)?.get(primitive)?.material?;
        lightmap::of_material(
            &extension("materials", material, OF_MATERIALS)?,
            false,
            root,
        )
        .ok()
    }

    /// The coordinates of all triangles of a primitive.
    fn corners(&self, mesh: usize, primitive: usize, set: u32) -> Option<Vec<[[f32; 2]; 3]>> {
        let primitive = self.meshes.get(mesh)?.get(primitive)?;
        let count = primitive.count(self.source).ok()?;
        let accessor = primitive.attribute(&format!("TEXCOORD_{set}"))?;
        let accessor = accessor_index(accessor).ok()?;
        // `count` was justified when the positions were read.
        let single = |[u, v]: [f64; 2]| [u as f32, v as f32];
        let uvs = self.source.data.read(accessor, count, single).ok()?;
        let corners = primitive.corners(self.source, count).ok()?;
        let triangles = topology::triangles(primitive.mode?, &corners);
        let uv = |v: u32| uvs.get(v as usize).copied().unwrap_or([f32::NAN; 2]);
        let all = 0..triangles.count();
        Some(all.map(|t| triangles.get(t).map(uv)).collect())
    }

    /// The number of the page of a lightmap.
    fn page(&mut self, named: Option<NamedLightmap>) -> u32 {
        let image = named.and_then(|named| self.image(named.texture.value()));
        let intensity = named.map_or(1.0, |named| named.scale);
        if let Some(&known) = self.numbers.get(&image) {
            let page = &mut self.pages[known as usize];
            page.intensity = page.intensity.max(intensity);
            return known;
        }
        let picture = match (named, image) {
            (None, _) => Ok(None),
            (Some(_), None) => Err("a texture without a picture".to_owned()),
            (Some(_), Some(image)) => self.picture(image).map(Some),
        };
        self.pages.push(FoundPage { picture, intensity });
        let number = self.pages.len() as u32 - 1;
        self.numbers.insert(image, number);
        number
    }

    /// The picture of a texture.
    fn image(&self, texture: usize) -> Option<usize> {
        let texture = self.source.json.entries("textures").get(texture)?;
        let own = |name: &&str| texture.find(&["extensions", *name, "source"]);
        let image = PICTURES
            .iter()
            .find_map(own)
            .or_else(|| texture.get("source"));
        image.and_then(Json::index)
    }

    /// The bytes of a picture.
    fn picture(&self, image: usize) -> Result<Vec<u8>, String> {
        let image = self.source.data.root.images.get(image);
        let image = image.ok_or("a picture that is not in the file")?;
        match (image.buffer_view, &image.uri) {
            (Some(view), _) => Ok(self.source.data.buffers.view(view)?.to_vec()),
            (None, Some(uri)) => match uri::read(uri)? {
                Uri::Data(bytes) => Ok(bytes),
                Uri::File(name) => self
                    .source
                    .file
                    .files
                    .read(&name)
                    .map_err(|e| e.to_string()),
            },
            (None, None) => Err("an image without a uri".to_owned()),
        }
    }
}
