//! An SFF file, mirrored record by record; surfaces and objects are numbered from 1.

use crate::reading::words::Words;
use crate::{Position, ReadError};
use azulejo_scene::rtrace::{RtraceLight, RtraceSource};
use azulejo_scene::{Operation, Rgb};
use glam::{DMat4, DVec3};

/// A whole file.
#[derive(Clone, Debug, Default)]
pub(crate) struct SffDocument {
    /// Whether scn2sff wrote it, according to its title.
    pub is_translated: bool,
    pub view: SffView,
    pub background: Rgb,
    pub ambient: Rgb,
    pub lights: Vec<RtraceLight>,
    pub surfaces: Vec<SurfaceRecord>,
    pub objects: Vec<SffRecord>,
    /// The last section; its records are [`RecordKind::Texture`].
    pub textures: Vec<SffRecord>,
}

/// The first section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SffView {
    pub eye: DVec3,
    pub target: DVec3,
    pub up: DVec3,
    /// Half angles of view, degrees.
    pub angles: [f64; 2],
    pub place: SffPosition,
}

/// SCN's defaults.
impl Default for SffView {
    fn default() -> SffView {
        SffView {
            eye: DVec3::new(5.0, 0.0, 0.0),
            target: DVec3::ZERO,
            up: DVec3::Y,
            angles: [22.5; 2],
            place: SffPosition::default(),
        }
    }
}

/// A surface before the format's rules are applied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SurfaceRecord {
    pub color: Rgb,
    pub is_emitter: bool,
    pub is_unshadowed: bool,
    pub source: RtraceSource,
}

/// One entry of the objects' section.
#[derive(Clone, Debug)]
pub(crate) struct SffRecord {
    pub place: SffPosition,
    pub kind: RecordKind,
}

/// The types of records.
#[derive(Clone, Debug)]
pub(crate) enum RecordKind {
    Object {
        appearance: RecordAppearance,
        geometry: SffGeometry,
    },
    Texture(Box<TextureRecord>),
    Transform {
        object: u32,
        matrix: Box<DMat4>,
    },
    CsgBegin {
        appearance: RecordAppearance,
        operation: Operation,
    },
    CsgNext,
    CsgEnd,
    ListBegin {
        appearance: RecordAppearance,
    },
    ListEnd,
}

/// The surface and refraction index in a record; 0 if the members have their own.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct RecordAppearance {
    pub surface: u32,
    pub refraction: f64,
}

/// The shapes.
#[derive(Clone, Debug)]
pub(crate) enum SffGeometry {
    Sphere {
        centre: DVec3,
        radius: f64,
    },
    /// Half sizes.
    Cuboid {
        centre: DVec3,
        half: DVec3,
    },
    Cone(SffCone),
    Patches(Box<PlacedData<PatchData>>),
    Polygons(Box<PlacedData<PolygonData>>),
    Triangles(Box<PlacedData<TriangleData>>),
    Text(RecordData<Vec<TextCommand>>),
}

/// The lateral surface of a cone or cylinder; the ends in any order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SffCone {
    pub base: DVec3,
    pub base_radius: f64,
    pub apex: DVec3,
    pub apex_radius: f64,
}

/// Data with a scale and a subsequent translation.
#[derive(Clone, Debug)]
pub(crate) struct PlacedData<T> {
    pub origin: DVec3,
    pub scale: DVec3,
    pub data: RecordData<T>,
}

/// Data in the file itself, or in another one.
#[derive(Clone, Debug)]
pub(crate) enum RecordData<T> {
    Here(T),
    File(String),
}

/// Bicubic patches.
#[derive(Clone, Debug, Default)]
pub(crate) struct PatchData {
    /// Indices counted from 0.
    pub patches: Vec<[u32; 12]>,
    pub vertices: Vec<DVec3>,
}

/// Polygons.
#[derive(Clone, Debug, Default)]
pub(crate) struct PolygonData {
    /// Indices counted from 0.
    pub faces: azulejo_scene::Faces,
    pub vertices: Vec<DVec3>,
}

/// Triangles with normals.
#[derive(Clone, Debug, Default)]
pub(crate) struct TriangleData {
    /// Three positions, each with a normal.
    pub corners: Vec<[(DVec3, DVec3); 3]>,
    /// The surfaces at the corners, counted from 1; empty if the object has a single one.
    pub surfaces: Vec<[u32; 3]>,
}

/// A command of a text block.
#[derive(Clone, Debug)]
pub(crate) struct TextCommand {
    pub place: SffPosition,
    pub kind: TextCommandKind,
}

/// The commands of text blocks.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum TextCommandKind {
    Spacing(f64),
    Scale(DVec3),
    Orientation([DVec3; 3]),
    Font(String),
    Encoding(String),
    At(DVec3, String),
}

/// A texture record; it applies to the object with the number `object`, 0 for the latest.
#[derive(Clone, Debug)]
pub(crate) struct TextureRecord {
    pub place: SffPosition,
    pub object: u32,
    pub matrix: DMat4,
    pub kind: TextureKind,
    /// Name of a colour map or image; empty for none.
    pub file: String,
}

/// A texture's type, 0..=20, and the numbers after its matrix, in the file's order and without the
/// file name.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TextureKind {
    pub number: u32,
    pub values: Vec<f64>,
}

/// A position: an index into [`SffSources`], and a byte offset.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SffPosition {
    pub file: u32,
    pub offset: u32,
}

/// The texts of a document, for messages about positions in them.
#[derive(Debug, Default)]
pub(crate) struct SffSources<'a> {
    list: Vec<(String, std::borrow::Cow<'a, [u8]>)>,
}

impl<'a> SffSources<'a> {
    /// The index that the next text gets.
    pub fn next(&self) -> u32 {
        self.list.len() as u32
    }

    /// Adds a text and returns its index.
    pub fn add(&mut self, name: &str, bytes: impl Into<std::borrow::Cow<'a, [u8]>>) -> u32 {
        self.list.push((name.to_owned(), bytes.into()));
        (self.list.len() - 1) as u32
    }

    /// Name of a text.
    pub fn name(&self, file: u32) -> &str {
        self.list.get(file as usize).map_or("", |(name, _)| name)
    }

    /// The bytes of a text.
    pub fn bytes(&self, file: u32) -> &[u8] {
        &self.list[file as usize].1
    }

    fn words(&self, file: u32) -> Words<'_> {
        let (name, bytes) = &self.list[file as usize];
        Words::new(bytes, name)
    }

    /// Line and column of a position.
    pub fn position(&self, place: SffPosition) -> Position {
        self.words(place.file).position(place.offset as usize)
    }

    /// An error at a position.
    pub fn error(
        &self,
        place: SffPosition,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> ReadError {
        let words = self.words(place.file);
        words.error_with(place.offset as usize, found, expected)
    }
}
