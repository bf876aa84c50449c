//! What is to be drawn, as plain data.

use super::Overlay;
use crate::view::{ColorMap, Fit, Shading};
use azulejo::render::Tone;
use azulejo::scene::math::Aabb;
use azulejo::scene::{Camera, Fog, Image, Material, Mesh};
use glam::DAffine3;
use serde::{Deserialize, Serialize};

/// One picture of the viewport.
#[derive(Clone, Debug)]
pub struct ViewportFrame<'a> {
    /// Width and height, pixels; 0 counts as 1.
    pub size: [u32; 2],
    /// The view.
    pub camera: &'a Camera,
    /// How surfaces are shown.
    pub shading: Shading,
    /// What is there.
    pub objects: &'a [MeshInstance<'a>],
    /// What faces refer to; a face of a material that is not here is grey.
    pub materials: &'a [&'a Material],
    /// What materials refer to.
    pub textures: &'a [TextureSource<'a>],
    /// What is seen where there is no surface.
    pub background: Background<'a>,
    /// Hides what is far, in the modes that look like pictures.
    pub fog: Option<Fog>,
    /// Lines and triangles beside the model.
    pub overlay: &'a Overlay,
    /// Multiplies radiance before the tone curve.
    pub exposure: f64,
    /// The tone curve of [`Shading::Irradiance`] and [`Shading::Patches`].
    pub tone: Tone,
    /// Scale of [`Shading::FalseColor`] and [`Shading::FormFactors`].
    pub scale: ColorScale,
    /// sRGB colour of lines and points.
    pub line_color: [u8; 3],
    /// sRGB colour of what is selected.
    pub selection_color: [u8; 3],
    /// Whether edges are smoothed, where the driver can.
    pub antialiasing: bool,
    /// Whether faces are left out that show their back: a look into rooms from outside.
    pub hides_backs: bool,
}

impl<'a> ViewportFrame<'a> {
    /// Objects before a plain background, shaded by Gouraud.
    pub fn new(
        size: [u32; 2],
        camera: &'a Camera,
        objects: &'a [MeshInstance<'a>],
        materials: &'a [&'a Material],
    ) -> ViewportFrame<'a> {
        ViewportFrame {
            size,
            camera,
            shading: Shading::Gouraud,
            objects,
            materials,
            textures: &[],
            background: Background::Color([58, 62, 68]),
            fog: None,
            overlay: Overlay::none(),
            exposure: 1.0,
            tone: Tone::default(),
            scale: ColorScale::default(),
            line_color: [225, 228, 232],
            selection_color: [255, 150, 30],
            antialiasing: true,
            hides_backs: false,
        }
    }
}

/// A placed mesh.
#[derive(Clone, Copy, Debug)]
pub struct MeshInstance<'a> {
    /// Identity and revision of everything in the mesh but its light. Geometry is uploaded when
    /// its key is new, and freed when the key was not drawn for a while.
    pub key: u64,
    /// Revision of the irradiance.
    pub light_key: u64,
    /// Its polygons.
    pub mesh: &'a Mesh,
    /// Its place: free to change, nothing is uploaded again.
    pub world_from_object: DAffine3,
    /// A box around its polygons where they are not placed, if that is known: rays that pass by
    /// ask no polygon.
    pub bounds: Option<Aabb>,
    /// Whether it is selected as a whole.
    pub is_selected: bool,
    /// Selected faces.
    pub selected_faces: &'a [u32],
    /// One number per face for [`Shading::FormFactors`].
    pub face_values: Option<FaceValues<'a>>,
}

impl<'a> MeshInstance<'a> {
    /// A mesh where it is, not selected. `key` counts for its light too.
    pub fn new(key: u64, mesh: &'a Mesh) -> MeshInstance<'a> {
        MeshInstance {
            key,
            light_key: key,
            mesh,
            world_from_object: DAffine3::IDENTITY,
            bounds: None,
            is_selected: false,
            selected_faces: &[],
            face_values: None,
        }
    }
}

/// One number for each face.
#[derive(Clone, Copy, Debug)]
pub struct FaceValues<'a> {
    /// Their revision.
    pub key: u64,
    /// As many as faces, >= 0; what is missing or NaN is shown as not known.
    pub values: &'a [f32],
}

/// A picture to draw with.
#[derive(Clone, Copy, Debug)]
pub struct TextureSource<'a> {
    /// Its identity and revision.
    pub key: u64,
    /// Its pixels, if it could be loaded.
    pub image: Option<&'a Image>,
}

/// Which number of a colour counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ColorScalar {
    /// The mean of the channels.
    Mean,
    /// Relative luminance, ITU-R BT.709.
    #[default]
    Luminance,
}

/// How numbers become colours.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ColorScale {
    /// The colours.
    pub map: ColorMap,
    /// Which number of the irradiance.
    pub quantity: ColorScalar,
    /// The number of the first colour, in the unit of what is shown.
    pub low: f64,
    /// The number of the last colour.
    pub high: f64,
    /// Whether equal steps of colour are equal ratios. Needs 0 < low < high.
    pub is_logarithmic: bool,
    /// Into how many bands lines divide the scale; 0 for no lines.
    pub bands: u32,
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
        }
    }
}

impl ColorScale {
    /// Where `value` stands on the scale: 0 at `low`, 1 at `high`.
    pub fn fraction(&self, value: f64) -> f64 {
        let (a, b, x) = if self.is_logarithmic {
            (self.low.ln(), self.high.ln(), value.ln())
        } else {
            (self.low, self.high, value)
        };
        if b > a { (x - a) / (b - a) } else { 0.0 }
    }

    /// The number that stands at `place`: the inverse of [`place`](Scale::place).
    pub fn value(&self, place: f64) -> f64 {
        if self.is_logarithmic {
            (self.low.ln() + place * (self.high / self.low).ln()).exp()
        } else {
            self.low + place * (self.high - self.low)
        }
    }
}

/// What is seen where there is no surface. Colours are sRGB.
#[derive(Clone, Copy, Debug)]
pub enum Background<'a> {
    /// One colour.
    Color([u8; 3]),
    /// From the lower edge to the upper one.
    Gradient {
        /// At the lower edge.
        lower: [u8; 3],
        /// At the upper edge.
        upper: [u8; 3],
    },
    /// A picture.
    Image {
        /// Its pixels.
        picture: TextureSource<'a>,
        /// How it fills the view.
        fit: Fit,
        /// What is seen around it.
        around: [u8; 3],
    },
}
