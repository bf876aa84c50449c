//! What RTRACE's shading reads in a scene, kept beside the physical materials.
//!
//! SFF and SCN scenes were made for one program's look: lights that do not fall with the square
//! of the distance, surfaces whose mirror and highlight are one number, textures in space. The
//! physical scene translates what it can; this keeps the numbers as they are in the file, for
//! pictures as they were.

use crate::Rgb;
use glam::{DMat4, DVec3};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A scene as RTRACE sees it. Geometry is the [`Scene`](crate::Scene)'s own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rtrace {
    /// Where from, where to, and up.
    pub eye: DVec3,
    /// The point looked at: its distance sets how fast everything fades.
    pub look: DVec3,
    /// Up in the picture; not parallel to the gaze.
    pub up: DVec3,
    /// Half the horizontal and half the vertical aperture, radians.
    pub half_angles: [f64; 2],
    /// What rays see that meet nothing.
    pub background: Rgb,
    /// Ambient light.
    pub ambient: Rgb,
    /// Lights in the order of the file.
    pub lights: Vec<RtraceLight>,
    /// Surfaces in the order of the file.
    pub surfaces: Vec<RtraceSurface>,
    /// For each material of the scene, in their order: what RTRACE knows of the objects made of
    /// it. Materials of the scene beyond these are those of lamps, which RTRACE does not show:
    /// bodies in the place of its extended and planar lights.
    pub materials: Vec<RtraceMaterial>,
    /// Meshes whose surface changes between corners: by object, three surfaces (indices into
    /// `surfaces`) for each face, which is a triangle.
    pub corner_surfaces: BTreeMap<u32, Vec<[u32; 3]>>,
}

/// A light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RtraceLight {
    /// Where it is; the centre of an extended or planar one.
    pub position: DVec3,
    /// Brightness, not negative.
    pub brightness: Rgb,
    /// For each channel: whether it fades with distance.
    pub fades: [bool; 3],
    /// Its shape.
    pub kind: RtraceLightKind,
}

/// Shapes of lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RtraceLightKind {
    /// A point that shines everywhere.
    Point,
    /// A point that shines into a cone.
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
    /// What became of the file's numbers by its own rules (clamped, derived).
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
    /// The record's numbers behind its type, as the file has them, for writing it again.
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

/// What RTRACE knows of a material of the scene.
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

/// A texture and where it is.
#[derive(Clone, Debug, PartialEq)]
pub struct RtraceTexture {
    /// Takes a point to the texture's own space: the inverse of the file's matrix, with its
    /// perspective row. The point that results goes on to the next texture.
    pub texture_from_point: DMat4,
    /// The file's matrix, all zero for none, for writing it again.
    pub matrix: DMat4,
    /// Name of the colour map or picture as the file has it; empty for none.
    pub file: String,
    /// What it does there.
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
        /// Which coordinates run along the picture and up it: 0, 1 or 2 for x, y, z.
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
