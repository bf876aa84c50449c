//! A web page that shows a model with its baked light.
//!
//! One HTML file holds everything: our own viewer in WebGL 2, the geometry, the pictures, and the
//! light as irradiance per texel. It asks the network for nothing, so it works from a disk, and a
//! content security policy in it makes sure of that.
//!
//! The viewer shows the radiance `base_color × picture × E/π + emission` of each surface: what is
//! glossy, a mirror or glass is shown matt. Besides the picture it shows E in false colours with
//! its values, and its standard error.
//!
//! # How the data are stored
//! The head of the data is JSON; everything large is DEFLATE in base64, each piece in a script
//! element that no browser executes. Light is stored as logarithms in steps of 1/128 of an octave,
//! which is never off by more than 0.28%, and predicted from the texels to the left and above as
//! in lossless pictures. That is smaller than RGBE, whose shared exponent is worth 0.39% at best.
//!
//! ```
//! use azulejo_bake::web_page::{PageMaterial, PageMesh, PageModel};
//! let mut model = PageModel::default();
//! model.title = "A triangle".into();
//! model.materials.push(PageMaterial::matt("grey", [0.5; 3]));
//! model.meshes.push(PageMesh {
//!     name: "triangle".into(),
//!     positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
//!     normals: vec![[0.0, 0.0, 1.0]; 3],
//!     indices: vec![0, 1, 2],
//!     ..PageMesh::default()
//! });
//! let mut page = Vec::new();
//! azulejo_bake::web_page::write(&model, &mut page)?;
//! assert!(page.starts_with(b"<!doctype html>"));
//! # Ok::<(), std::io::Error>(())
//! ```

mod base64;
mod geometry;
mod head;
mod html;
mod light;
mod planes;
mod validate;

#[cfg(test)]
mod tests;

use azulejo_scene::{Camera, Up, WrapMode};
use std::io::{self, Write};

/// What a page shows. All numbers are finite; see [`write()`].
#[derive(Clone, Debug, Default)]
pub struct PageModel {
    /// The title of the page; `azulejo` if empty.
    pub title: String,
    /// The surfaces.
    pub meshes: Vec<PageMesh>,
    /// What they are made of.
    pub materials: Vec<PageMaterial>,
    /// The light that falls on them.
    pub lightmaps: Vec<PageLightmap>,
    /// Views to choose from; the page opens with the first, or with one that frames everything.
    pub cameras: Vec<Camera>,
    /// The axis that points away from the ground.
    pub up: Up,
    /// Whether light is in lux and cd/m² instead of W/m² and W/(sr·m²).
    pub photometric: bool,
    /// What is stated about the error of the light, shown in the help of the page; may be empty.
    pub note: String,
}

/// Triangles of one material and one lightmap, in the world.
#[derive(Clone, Debug, Default)]
pub struct PageMesh {
    /// Its name in the file, shown with the values under the pointer.
    pub name: String,
    /// Vertices, scene units.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals, one per vertex; used without baked light only. May be empty: those of the triangles.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates, one per vertex, (0, 0) in the lower left corner of the picture as in
    /// [`azulejo_scene::Mesh`]; may be empty.
    pub uvs: Vec<[f32; 2]>,
    /// Places in the lightmap, one per vertex, 0..=1, (0, 0) in the *upper* left corner; may be
    /// empty, and no light falls on the mesh then.
    pub lightmap_uvs: Vec<[f32; 2]>,
    /// Factors of the base colour, linear, 0..=1, one per vertex; may be empty.
    pub colors: Vec<[f32; 3]>,
    /// Three per triangle, counterclockwise from the front.
    pub indices: Vec<u32>,
    /// Its material, an index into [`PageModel::materials`].
    pub material: u32,
    /// Its lightmap, an index into [`PageModel::lightmaps`]; unused if `lightmap_uvs` is empty.
    pub lightmap: u32,
}

/// How a surface answers light.
#[derive(Clone, Debug, Default)]
pub struct PageMaterial {
    /// Its name in the file.
    pub name: String,
    /// Reflectance of the matt part, linear, 0..=1.
    pub base_color: [f32; 3],
    /// A picture that multiplies the base colour, and whose alpha counts for `opacity`.
    pub picture: Option<PagePicture>,
    /// Radiance that it emits, W/(sr·m²) or cd/m², ≥ 0.
    pub emission: [f32; 3],
    /// What is behind it.
    pub opacity: PageOpacity,
    /// Whether its back is seen, with the light of the front. The back of what is not double-sided is
    /// not drawn at all.
    pub double_sided: bool,
    /// Whether base colour times picture is shown as it is, whatever the light and the exposure.
    pub unlit: bool,
}

impl PageMaterial {
    /// A matt, opaque, double-sided material of this reflectance, linear, 0..=1.
    pub fn matt(name: impl Into<String>, base_color: [f32; 3]) -> PageMaterial {
        PageMaterial {
            name: name.into(),
            base_color,
            double_sided: true,
            ..PageMaterial::default()
        }
    }
}

/// How much of what is behind a surface is seen through it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum PageOpacity {
    /// Nothing; the alpha of pictures is ignored.
    #[default]
    Opaque,
    /// Everything where the alpha of the picture is below `cutoff`, nothing elsewhere.
    Mask {
        /// The least alpha that is seen, 0..=1.
        cutoff: f32,
    },
    /// 1 − `opacity` × the alpha of the picture.
    Blend {
        /// Its opacity, 0..=1.
        opacity: f32,
    },
}

/// A picture as it is in a file; its colours are sRGB.
#[derive(Clone, Debug, Default)]
pub struct PagePicture {
    /// The file.
    pub bytes: Vec<u8>,
    /// What it is: `image/png`, `image/jpeg`, `image/webp`, `image/gif`, `image/bmp` or
    /// `image/avif`, which browsers decode.
    pub media_type: String,
    /// What is beyond its edges, by axis.
    pub wrap: [WrapMode; 2],
}

/// Irradiance per texel, and how sure it is.
#[derive(Clone, Debug, Default)]
pub struct PageLightmap {
    /// Texels per row, 1..=16384.
    pub width: u32,
    /// Rows, 1..=16384.
    pub height: u32,
    /// Irradiance, W/m² or lux, rows from the top. What is negative or not finite counts as 0:
    /// texels that no surface covers may have any value, but a smooth continuation of what is
    /// beside them compresses best.
    pub irradiance: Vec<[f32; 3]>,
    /// Standard error of each, in the same unit, or empty if unknown. The page keeps its luminance.
    pub standard_error: Vec<[f32; 3]>,
}

/// Writes a page.
///
/// The same model gives the same bytes. Texts are shown as texts, whatever is in them.
///
/// # Errors
/// Those of `out`, and [`io::ErrorKind::InvalidInput`] if the model cannot be shown: numbers that
/// are not finite, lists of different lengths, indices of what does not exist, pictures of other
/// media types. The message says where.
pub fn write(model: &PageModel, out: &mut dyn Write) -> io::Result<()> {
    validate::validate(model)?;
    html::write(model, out)
}
