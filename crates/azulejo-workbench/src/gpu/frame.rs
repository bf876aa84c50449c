//! The input of the renderer, as plain data.

use super::{LightmapPages, Overlay};
use crate::view::{ColorMap, Shading};
use azulejo::render::Tone;
use azulejo::scene::math::Aabb;
use azulejo::scene::{BackplateFit, Camera, Fog, Image, Material, Mesh};
use glam::{DAffine3, DVec3};
use serde::{Deserialize, Serialize};

/// One frame of the viewport.
#[derive(Clone, Debug)]
pub struct ViewportFrame<'a> {
    /// Width and height in pixels; 0 counts as 1.
    pub size: [u32; 2],
    /// Where the picture is taken, in world space.
    pub camera: &'a Camera,
    /// What the colours of surfaces mean.
    pub shading: Shading,
    /// The objects to draw.
    pub objects: &'a [DrawnMesh<'a>],
    /// Faces refer to these; a face with a missing material is grey.
    pub materials: &'a [&'a Material],
    /// Materials refer to these.
    pub textures: &'a [TextureSource<'a>],
    /// The pages that places of meshes in a lightmap refer to, shown in the modes that show irradiance.
    pub lightmap: Option<LightmapPages<'a>>,
    /// What is seen where no object is.
    pub background: Background<'a>,
    /// Fog, applied in modes with realistic shading.
    pub fog: Option<Fog>,
    /// Lines and triangles drawn in addition to the model.
    pub overlay: &'a Overlay,
    /// Multiplies radiance before the tone curve.
    pub exposure: f64,
    /// The tone curve of [`Shading::Irradiance`] and [`Shading::Patches`].
    pub tone: Tone,
    /// The scale of [`Shading::FalseColor`] and [`Shading::FormFactors`].
    pub scale: ColorScale,
    /// sRGB colour of edges and points.
    pub line_color: [u8; 3],
    /// sRGB colour of the selection.
    pub selection_color: [u8; 3],
    /// Whether positions on the colour scale are drawn in place of its colours, packed into bytes:
    /// see [`Renderer::values`](super::Renderer::values).
    pub is_values: bool,
    /// Whether edges are antialiased, if the driver supports it.
    pub antialiasing: bool,
    /// Whether back faces are culled, which shows the inside of rooms from outside.
    pub hides_backs: bool,
    /// A plane, n · x = d in world space, beyond which everything is cut away.
    pub section: Option<(DVec3, f64)>,
}

impl<'a> ViewportFrame<'a> {
    /// Objects with Gouraud shading in front of a plain background.
    pub fn new(
        size: [u32; 2],
        camera: &'a Camera,
        objects: &'a [DrawnMesh<'a>],
        materials: &'a [&'a Material],
    ) -> ViewportFrame<'a> {
        ViewportFrame {
            size,
            camera,
            shading: Shading::Gouraud,
            objects,
            materials,
            textures: &[],
            lightmap: None,
            background: Background::Color([58, 62, 68]),
            fog: None,
            overlay: Overlay::none(),
            exposure: 1.0,
            tone: Tone::default(),
            scale: ColorScale::default(),
            line_color: [225, 228, 232],
            selection_color: [255, 150, 30],
            is_values: false,
            antialiasing: true,
            hides_backs: false,
            section: None,
        }
    }
}

/// A mesh at its place in a frame.
#[derive(Clone, Copy, Debug)]
pub struct DrawnMesh<'a> {
    /// Identity and revision of the mesh except for its irradiance. A new key uploads the geometry;
    /// it is freed when the key has not been drawn for a while.
    pub key: u64,
    /// Revision of the irradiance: a new one uploads that alone.
    pub light_key: u64,
    /// Its polygons in object space.
    pub mesh: &'a Mesh,
    /// For each vertex its place on a page of the lightmap, u and v from the upper left corner, and
    /// the number of the page, or a negative one. Part of what the key identifies.
    pub lightmap: Option<&'a [[f32; 3]]>,
    /// Its placement; changing it uploads nothing.
    pub world_from_object: DAffine3,
    /// Bounding box in object space, if known: picking skips the polygons of objects that the ray
    /// misses.
    pub bounds: Option<Aabb>,
    /// Whether the whole object is selected.
    pub is_selected: bool,
    /// Indices of the selected faces of the mesh.
    pub selected_faces: &'a [u32],
    /// One value per face for [`Shading::FormFactors`].
    pub face_values: Option<FaceValues<'a>>,
}

impl<'a> DrawnMesh<'a> {
    /// An unselected mesh with the identity as its placement. `key` is also the revision of its
    /// irradiance.
    pub fn new(key: u64, mesh: &'a Mesh) -> DrawnMesh<'a> {
        DrawnMesh {
            key,
            light_key: key,
            mesh,
            lightmap: None,
            world_from_object: DAffine3::IDENTITY,
            bounds: None,
            is_selected: false,
            selected_faces: &[],
            face_values: None,
        }
    }
}

/// One value per face.
#[derive(Clone, Copy, Debug)]
pub struct FaceValues<'a> {
    /// Their revision: a new one uploads them.
    pub key: u64,
    /// One value for each face, >= 0; missing values and NaN are displayed as unknown.
    pub values: &'a [f32],
}

/// An image to upload as a texture.
#[derive(Clone, Copy, Debug)]
pub struct TextureSource<'a> {
    /// Its identity and revision.
    pub key: u64,
    /// Its pixels, if it could be loaded.
    pub image: Option<&'a Image>,
}

/// The scalar computed from a colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ColorScalar {
    /// The mean of the channels.
    Mean,
    /// Relative luminance, ITU-R BT.709.
    #[default]
    Luminance,
}

/// A scale that maps values to colours.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ColorScale {
    /// The colours from the lower end to the upper one.
    pub map: ColorMap,
    /// The scalar computed from the irradiance.
    pub quantity: ColorScalar,
    /// The value at the lower end, in the unit of the displayed quantity.
    pub low: f64,
    /// The value at the upper end.
    pub high: f64,
    /// Whether the scale is logarithmic, which requires 0 < low < high.
    pub is_logarithmic: bool,
    /// About how many bands isolines separate, which lie at round values; 0 for no isolines.
    pub bands: u32,
    /// Factor from the stored unit to the one in which values are shown, > 0.
    pub display: f64,
}

impl Default for ColorScale {
    fn default() -> ColorScale {
        ColorScale {
            map: ColorMap::default(),
            quantity: ColorScalar::default(),
            low: 0.0,
            high: 1.0,
            is_logarithmic: false,
            bands: 0,
            display: 1.0,
        }
    }
}

impl ColorScale {
    /// Position of `value` on the scale: 0 at `low`, 1 at `high`.
    pub fn fraction(&self, value: f64) -> f64 {
        let (a, b, x) = if self.is_logarithmic {
            (self.low.ln(), self.high.ln(), value.ln())
        } else {
            (self.low, self.high, value)
        };
        if b > a { (x - a) / (b - a) } else { 0.0 }
    }

    /// The value at a position on the scale: the inverse of [`fraction`](ColorScale::fraction).
    pub fn value(&self, place: f64) -> f64 {
        if self.is_logarithmic {
            (self.low.ln() + place * (self.high / self.low).ln()).exp()
        } else {
            self.low + place * (self.high - self.low)
        }
    }
}

/// The background of the viewport. Colours are sRGB.
#[derive(Clone, Copy, Debug)]
pub enum Background<'a> {
    /// A single colour.
    Color([u8; 3]),
    /// A vertical gradient.
    Gradient {
        /// Colour at the lower edge.
        lower: [u8; 3],
        /// Colour at the upper edge.
        upper: [u8; 3],
    },
    /// An image, and one colour where it does not reach.
    Image {
        /// The image; the colour alone if it could not be loaded.
        picture: TextureSource<'a>,
        /// How it fills the viewport.
        fit: BackplateFit,
        /// Factor of its linear colours.
        gain: f64,
        /// Colour around it.
        around: [u8; 3],
    },
}
