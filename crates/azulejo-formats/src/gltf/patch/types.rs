//! What edits are made of.

use crate::{Files, ReadOptions};

/// A glTF file to edit.
#[derive(Clone, Copy)]
pub struct GltfFile<'a> {
    /// Its bytes, JSON or GLB, as they were read with
    /// [`read_with_origins`](crate::gltf::read_with_origins).
    pub bytes: &'a [u8],
    /// Its name, for messages.
    pub name: &'a str,
    /// The files that it names.
    pub files: &'a dyn Files,
    /// `most_unpacked` limits the bytes that an edit adds, too.
    pub options: &'a ReadOptions,
}

/// The container of the edited file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Container {
    /// As the file is.
    #[default]
    Same,
    /// One binary file. What a JSON file names is put into it.
    Glb,
    /// JSON, with numbers and pictures in files of their own.
    Json,
}

/// What is written.
#[derive(Clone, Copy, Debug)]
pub struct Output<'a> {
    /// The container of the edited file.
    pub container: Container,
    /// What the names of files beside it begin with: `room` for `room.gltf`.
    pub stem: &'a str,
}

/// A lightmap to put into a file.
#[derive(Clone, Copy, Debug)]
pub struct LightmapEdit<'a> {
    /// What each object of the scene receives, parallel to the origins; `None` for nothing.
    pub objects: &'a [Option<ObjectLayout>],
    /// The pictures.
    pub pages: &'a [LightmapPage],
    /// Where the texture coordinates of the objects are put.
    pub uvs: LightmapUvs,
    /// How several nodes of one mesh get a place in the pictures each.
    pub instances: InstanceMode,
    /// How the file says what the pictures are.
    pub convention: Convention,
    /// What becomes of the lights. They stay with [`Convention::Plain`] and [`Convention::Occlusion`],
    /// whose files show no light.
    pub lights: LightsMode,
    /// Whether viewers may use smaller versions of the pictures (mipmaps), which needs wide padding.
    pub mipmaps: bool,
    /// The key of what the lightmap was computed from, which the file keeps.
    pub content: Option<&'a str>,
    /// What is written.
    pub output: Output<'a>,
}

/// Where the texture coordinates of a lightmap are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightmapUvs {
    /// In a new set, `TEXCOORD_n`, which takes the place of one of this number. If a picture of a material that
    /// gets a lightmap uses it, the next free one is taken.
    Added(u32),
    /// In this set of the file, which stays as it is, with all vertices: the layouts have its coordinates.
    Existing(u32),
}

impl Default for LightmapUvs {
    fn default() -> LightmapUvs {
        LightmapUvs::Added(1)
    }
}

/// Where the faces of an object are in the pictures.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjectLayout {
    /// For every face of the object's mesh, the texture coordinates of its corners, in 0..1, v downwards
    /// as in glTF.
    pub uvs: Vec<[[f32; 2]; 3]>,
    /// For every face, the index of its picture. All faces of one primitive have the same.
    pub pages: Vec<u32>,
}

/// The page of faces that have no lightmap.
pub const NO_PAGE: u32 = u32::MAX;

/// The lightmap that a file has.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FoundLightmap {
    /// Whether materials or nodes name a lightmap.
    pub is_named: bool,
    /// Whether it is one of azulejo's, which [`strip`](super::strip) removes.
    pub is_own: bool,
    /// The set of texture coordinates; the last, if there are several.
    pub set: u32,
    /// Whether all that has coordinates has them in one set.
    pub is_one_set: bool,
    /// For each object, parallel to the origins, the coordinates of its faces as they read the picture, and
    /// their pages: [`NO_PAGE`] where a face has none. `None` for objects without any. Coordinates are what
    /// the file says: any number, or none.
    pub objects: Vec<Option<ObjectLayout>>,
    /// The pages.
    pub pages: Vec<FoundPage>,
}

/// A picture that a file has as a lightmap.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundPage {
    /// The file of the picture, if one is named; why it cannot be had.
    pub picture: Result<Option<Vec<u8>>, String>,
    /// What a decoded texel is multiplied with; the largest that a material says.
    pub intensity: f64,
}

/// A picture of a lightmap.
///
/// For [`Convention::Moz`] and [`Convention::Mx`], a texel times `intensity` is the irradiance, E, in
/// the unit of the scene (lx). For [`Convention::Emissive`] and [`Convention::Unlit`] it is the
/// radiance, ρE/π: the reflectance is in the picture already.
#[derive(Clone, Debug, PartialEq)]
pub struct LightmapPage {
    /// The name of its texture and its image.
    pub name: String,
    /// The file of the picture.
    pub picture: Vec<u8>,
    /// Its type.
    pub media_type: MediaType,
    /// What a decoded texel is multiplied with, >= 0.
    pub intensity: f64,
    /// A PNG for viewers that cannot read a picture of another type.
    pub fallback: Option<Vec<u8>>,
    /// PNG files of where the light comes from, linear, for [`Convention::Moz`]: G/φ from −1 to 1, of the vector
    /// irradiance G and the scalar irradiance φ, in one picture of G's axes, or in three, one for each axis, of the
    /// channels.
    pub directions: Vec<Vec<u8>>,
}

/// The type of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MediaType {
    /// PNG, with sRGB-encoded texels, which every viewer reads.
    Png,
    /// Radiance HDR, in a texture with `MOZ_texture_rgbe` as Hubs reads it.
    Hdr,
    /// KTX2, in a texture with `KHR_texture_basisu`.
    Ktx2,
}

/// How several nodes of one mesh get a place in the pictures each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InstanceMode {
    /// A mesh entry for each further node, which shares everything but the texture coordinates.
    #[default]
    Copy,
    /// The same texture coordinates, and a material for each node that moves and scales them with
    /// `KHR_texture_transform`. Nodes whose coordinates are not those of the first, moved and scaled,
    /// get a copy.
    Transform,
    /// The same mesh, and the offset and scale at the node. Only with [`Convention::Mx`]; nodes as
    /// in [`InstanceMode::Transform`].
    Node,
}

/// How a file says what the pictures of a lightmap are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Convention {
    /// `MOZ_lightmap` of materials.
    #[default]
    Moz,
    /// `MX_lightmap` of nodes.
    Mx,
    /// As light that the surfaces emit, for viewers that know no lightmaps; their colours are black.
    Emissive,
    /// As colours that need no light, for viewers that know no lightmaps (`KHR_materials_unlit`).
    Unlit,
    /// The share of the hemisphere that is free, 0 to 1, as the `occlusionTexture` of materials that have none.
    Occlusion,
    /// Texture coordinates only.
    Plain,
}

/// What becomes of the lights that were baked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightsMode {
    /// Their intensity becomes 0.
    #[default]
    Dim,
    /// They stay.
    Keep,
    /// Nodes lose them.
    Remove,
}

/// An edited file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PatchedFile {
    /// The file.
    pub bytes: Vec<u8>,
    /// Files that it names and that are written beside it: names and contents.
    pub files: Vec<(String, Vec<u8>)>,
    /// What was skipped or changed beside what was asked for.
    pub notes: Vec<String>,
    /// Whether lights went dark, and something has no lightmap to replace them.
    pub leaves_dark: bool,
}

/// A file without its lightmap.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StrippedFile {
    /// The file.
    pub bytes: Vec<u8>,
    /// Whether it had light on its vertices by
    /// [`with_vertex_light`](super::with_vertex_light), not a lightmap.
    pub is_of_vertices: bool,
    /// Whether this is the file as it was before: the same bytes of buffers, and the same JSON with its order and
    /// its numbers as they were spelled, but for blanks. If another program has written the file since, or it is of
    /// an earlier version of azulejo, the lightmap is removed from it as it is now.
    pub is_exact: bool,
    /// Files that were written beside the file and that it no longer names.
    pub unused_files: Vec<String>,
    /// What could not be restored.
    pub notes: Vec<String>,
}
