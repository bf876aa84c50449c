//! Parameters of RTRACE's shading, stored beside the physical materials.
//!
//! SFF and SCN scenes were designed for the shading of one program: lights that do not fall off
//! with the square of the distance, surfaces with one number for mirror and highlight, solid
//! textures. The physical scene approximates them; the file's parameters are stored here to
//! reproduce the original images.

use crate::Rgb;
use glam::{DMat4, DVec3};
use std::collections::BTreeMap;
use std::sync::Arc;

/// RTRACE's parameters of a scene. The geometry is the [`Scene`](crate::Scene)'s own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rtrace {
    /// Position of the viewer.
    pub eye: DVec3,
    /// The target; its distance from the viewer scales the fading of lights.
    pub look: DVec3,
    /// Up direction of the image; not parallel to the view direction.
    pub up: DVec3,
    /// Half the horizontal and half the vertical aperture, radians.
    pub half_angles: [f64; 2],
    /// Colour of rays that hit nothing.
    pub background: Rgb,
    /// Ambient light.
    pub ambient: Rgb,
    /// Lights in the order of the file.
    pub lights: Vec<RtraceLight>,
    /// Surfaces in the order of the file.
    pub surfaces: Vec<RtraceSurface>,
    /// RTRACE's properties of each material of the scene, in their order. Further materials of the
    /// scene belong to lamps, which RTRACE does not render: bodies that replace its extended and
    /// planar lights.
    pub materials: Vec<RtraceMaterial>,
    /// Meshes whose surface changes between corners: by object, three surfaces (indices into
    /// `surfaces`) for each face, which is a triangle.
    pub corner_surfaces: BTreeMap<u32, Vec<[u32; 3]>>,
}

/// A light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RtraceLight {
    /// Position; the centre of an extended or planar light.
    pub position: DVec3,
    /// Brightness, not negative.
    pub brightness: Rgb,
    /// Whether each channel fades with distance.
    pub fades: [bool; 3],
    /// Its shape.
    pub kind: RtraceLightKind,
}

/// Shapes of lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RtraceLightKind {
    /// A point that emits in all directions.
    Point,
    /// A point that emits into a cone.
    Spot {
        /// Unit direction of its axis.
        direction: DVec3,
        /// Half the cone's aperture, radians.
        half_angle: f64,
        /// 1: linear in the cosine; more: flatter, with a sharper edge.
        factor: f64,
    },
    /// A ball, sampled as a square that faces the lit point.
    Extended {
        /// Half the square's side.
        radius: f64,
        /// Samples per side, as the file has it: 1..=256, the corners among them left out.
        samples: u32,
    },
    /// A parallelogram, or a line if the second edge is zero.
    Planar {
        /// Its edges, centre to centre of opposite sides.
        edges: [DVec3; 2],
        /// Samples along each, as the file has it: 1..=256; 0 along the second edge of a line.
        samples: [u32; 2],
    },
}

/// A surface; by default a black one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RtraceSurface {
    /// Its colour C.
    pub color: Rgb,
    /// Whether it shows its colour unlit.
    pub is_emitter: bool,
    /// Whether no shadow falls on it.
    pub is_unshadowed: bool,
    /// Kd, derived from the file's numbers by RTRACE's rules.
    pub diffuse: Rgb,
    /// Ks: mirror and highlight.
    pub specular: Rgb,
    /// Exponent of the highlight.
    pub phong: f64,
    /// 0 for plastic, 1 for metal.
    pub metal: Rgb,
    /// Kt.
    pub transparency: Rgb,
    /// df: 1 − smooth × metal.
    pub diffuse_factor: Rgb,
    /// The numbers after the record's type, as in the file, for writing it again.
    pub source: RtraceSource,
}

/// The two kinds of surface records.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RtraceSource {
    /// Type 1: Kd, Ks, phong, metal, Kt.
    Phong {
        /// Kd.
        diffuse: Rgb,
        /// Ks.
        specular: Rgb,
        /// Exponent.
        phong: f64,
        /// 0..=1.
        metal: f64,
        /// Kt.
        transparency: Rgb,
    },
    /// Type 2: smoothness, metal, Kt.
    Strauss {
        /// Smoothness.
        smooth: Rgb,
        /// 0..=1 per channel.
        metal: Rgb,
        /// Kt.
        transparency: Rgb,
    },
}

impl Default for RtraceSource {
    fn default() -> RtraceSource {
        RtraceSource::Phong {
            diffuse: Rgb::BLACK,
            specular: Rgb::BLACK,
            phong: 0.0,
            metal: 0.0,
            transparency: Rgb::BLACK,
        }
    }
}

/// RTRACE's properties of a material of the scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RtraceMaterial {
    /// Index into the surfaces.
    pub surface: u32,
    /// Index of refraction, >= 1.
    pub ior: f64,
    /// Textures of texture mode 1 (records among the objects), in the order they apply.
    pub inline_textures: Vec<RtraceTexture>,
    /// Textures of texture mode 2 (a section of their own).
    pub section_textures: Vec<RtraceTexture>,
}

/// A texture with its transform.
#[derive(Clone, Debug, PartialEq)]
pub struct RtraceTexture {
    /// Maps a point to texture space: the inverse of the file's matrix, with its perspective row.
    /// The next texture starts from the resulting point.
    pub texture_from_point: DMat4,
    /// The file's matrix, all zero for none, for writing it again.
    pub matrix: DMat4,
    /// Name of the colour map or image as the file has it; empty for none.
    pub file: String,
    /// Its kind with the parameters.
    pub kind: RtraceTextureKind,
}

/// 256 colours, 0..=1.
pub type ColorMap = Arc<[Rgb; 256]>;

/// The textures, in the order of the format's numbers, 0 to 20.
#[derive(Clone, Debug, PartialEq)]
#[allow(
    missing_docs,
    reason = "the fields are the format's own numbers, documented with it"
)]
pub enum RtraceTextureKind {
    Null,
    Checker {
        surface: u32,
    },
    Blotch {
        k: f64,
        surface: u32,
    },
    Bump {
        k: f64,
    },
    Marble {
        map: Option<ColorMap>,
    },
    Fbm {
        offset: f64,
        k: f64,
        omega: f64,
        lambda: f64,
        threshold: f64,
        octaves: f64,
        map: Option<ColorMap>,
    },
    FbmBump {
        offset: f64,
        k: f64,
        omega: f64,
        lambda: f64,
        octaves: f64,
    },
    Wood {
        color: Rgb,
    },
    Round {
        k: f64,
    },
    Bozo {
        turbulence: f64,
        map: Option<ColorMap>,
    },
    Ripples {
        frequency: f64,
        phase: f64,
        k: f64,
    },
    Waves {
        frequency: f64,
        phase: f64,
        k: f64,
    },
    Spotted {
        map: Option<ColorMap>,
    },
    Dents {
        k: f64,
    },
    Agate {
        map: Option<ColorMap>,
    },
    Wrinkles {
        k: f64,
    },
    Granite {
        map: Option<ColorMap>,
    },
    Gradient {
        turbulence: f64,
        direction: DVec3,
        map: Option<ColorMap>,
    },
    ImageMap {
        turbulence: f64,
        tiles: bool,
        /// The coordinates along the image's columns and rows: 0, 1 or 2 for x, y, z.
        axes: [u8; 2],
        /// The file's bytes divided by 255, no gamma taken out; 2 × 2 pixels or more.
        image: Arc<crate::Image>,
    },
    Gloss {
        k: f64,
    },
    Bump3 {
        k: f64,
        size: f64,
    },
}
