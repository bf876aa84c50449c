//! An SFF file record by record, as it stands; numbers of surfaces and objects count from 1.

use crate::reading::words::Words;
use crate::{Position, ReadError};
use azulejo_scene::rtrace::{RtraceLight, RtraceSource};
use azulejo_scene::{Operation, Rgb};
use glam::{DMat4, DVec3};

/// A whole file.
#[derive(Clone, Debug, Default)]
pub(crate) struct SffDocument {
    /// Whether scn2sff wrote it, by its title.
    pub is_translated: bool,
    pub view: SffView,
    pub background: Rgb,
    pub ambient: Rgb,
    pub lights: Vec<RtraceLight>,
    pub surfaces: Vec<SurfaceRecord>,
    pub objects: Vec<SffRecord>,
    /// The last section, whose records are [`RecordKind::Texture`].
    pub textures: Vec<SffRecord>,
}

/// The first section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SffView {
    pub eye: DVec3,
    pub target: DVec3,
    pub up: DVec3,
    /// Half apertures, degrees.
    pub angles: [f64; 2],
    pub place: SffPosition,
}

/// As SCN has it.
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

/// A surface before the format's rules are applied to it.
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

/// The kinds of entries.
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

/// What a record says of its surface; 0 where it is the members' own.
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

/// The side of a cone or cylinder; the ends in any order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SffCone {
    pub base: DVec3,
    pub base_radius: f64,
    pub apex: DVec3,
    pub apex_radius: f64,
}

/// Data under a scale and, behind it, a shift.
#[derive(Clone, Debug)]
pub(crate) struct PlacedData<T> {
    pub origin: DVec3,
    pub scale: DVec3,
    pub data: RecordData<T>,
}

/// Data in the file itself, or in another.
#[derive(Clone, Debug)]
pub(crate) enum RecordData<T> {
    Here(T),
    File(String),
}

/// Bicubic patches.
#[derive(Clone, Debug, Default)]
pub(crate) struct PatchData {
    /// From 0.
    pub patches: Vec<[u32; 12]>,
    pub vertices: Vec<DVec3>,
}

/// Polygons.
#[derive(Clone, Debug, Default)]
pub(crate) struct PolygonData {
    /// From 0.
    pub faces: azulejo_scene::Faces,
    pub vertices: Vec<DVec3>,
}

/// Triangles with normals.
#[derive(Clone, Debug, Default)]
pub(crate) struct TriangleData {
    /// Three positions with three normals.
    pub corners: Vec<[(DVec3, DVec3); 3]>,
    /// The surfaces at the corners, from 1; empty where the object has one for all.
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

/// A texture record; what it is about stands in `object`, 0 for the latest.
#[derive(Clone, Debug)]
pub(crate) struct TextureRecord {
    pub place: SffPosition,
    pub object: u32,
    pub matrix: DMat4,
    pub kind: TextureKind,
    /// Name of a colour map or picture; empty for none.
    pub file: String,
}

/// A texture's number, 0..=20, and the numbers behind its matrix, in the file's order and without
/// the name of a file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TextureKind {
    pub number: u32,
    pub values: Vec<f64>,
}

/// Where something stands: which of the [`SffSources`], and the byte in it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SffPosition {
    pub file: u32,
    pub offset: u32,
}

/// The texts that a document is made of, for messages about places in them.
#[derive(Debug, Default)]
pub(crate) struct SffSources<'a> {
    list: Vec<(String, std::borrow::Cow<'a, [u8]>)>,
}

impl<'a> SffSources<'a> {
    /// The number that the next text gets.
    pub fn next(&self) -> u32 {
        self.list.len() as u32
    }

    /// Adds a text and returns its number.
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

    /// Line and column of a place.
    pub fn position(&self, place: SffPosition) -> Position {
        self.words(place.file).position(place.offset as usize)
    }

    /// An error at a place.
    pub fn error(
        &self,
        place: SffPosition,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> ReadError {
        let words = self.words(place.file);
        words.error_saying(place.offset as usize, found, expected)
    }
}
