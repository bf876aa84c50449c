//! Vertices: the palette shared by faces, and the local pools of meshes.

use super::document::FltDocument;
use super::fields::RecordFields;
use super::opcode::*;
use super::palettes::Palettes;
use azulejo_scene::Rgb;
use glam::{DVec2, DVec3};

/// A vertex in the coordinates of its node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FltVertex {
    pub position: DVec3,
    /// Not normalized, but non-zero.
    pub normal: Option<DVec3>,
    pub uv: Option<DVec2>,
}

/// The locations of the palette's vertices.
#[derive(Debug, Default)]
pub(super) struct VertexPalette {
    /// Offset of record 67, once it has been found.
    start: Option<u32>,
    /// Offsets of the vertex records in the file, ascending.
    records: Vec<u32>,
    ended: bool,
}

impl VertexPalette {
    /// Begins the palette at its record; `false`, and the palette ends, if there is one already.
    pub fn begin(&mut self, at: u32) -> bool {
        self.ended = self.start.is_some();
        self.start.get_or_insert(at);
        !self.ended
    }

    /// Adds a vertex record; `false` if no palette has begun.
    pub fn add(&mut self, at: u32) -> bool {
        let inside = self.start.is_some() && !self.ended;
        if inside {
            self.records.push(at);
        }
        inside
    }

    pub fn len(&self) -> usize {
        self.records.len()
    }

    /// The index of the vertex that begins `offset` bytes after the start of the palette.
    pub fn find(&self, offset: u32) -> Option<u32> {
        let at = self.start?.checked_add(offset)?;
        let index = self.records.binary_search(&at).ok()?;
        Some(index as u32)
    }

    /// The offset of a vertex record in the file.
    fn record(&self, index: u32) -> u32 {
        self.records[index as usize]
    }
}

/// A vertex of the palette; `None` if its record is too short or its position is not finite.
pub(super) fn palette_vertex(document: &FltDocument, index: u32) -> Option<FltVertex> {
    let record = document.fields(document.vertices.record(index));
    let (normal, uv) = match record.u16(0)? {
        VERTEX_CN => (record.singles(32), None),
        VERTEX_CNT => (record.singles(32), pair(record, 44)),
        VERTEX_CT => (None, pair(record, 32)),
        _ => (None, None),
    };
    vertex(record.doubles(8)?, normal, uv)
}

/// The colour of a vertex of the palette, if it has one.
pub(super) fn palette_vertex_color(
    document: &FltDocument,
    palettes: &Palettes,
    index: u32,
) -> Option<Rgb> {
    const NO_COLOR: u16 = 0x2000;
    const PACKED: u16 = 0x1000;
    let record = document.fields(document.vertices.record(index));
    let flags = record.u16(6)?;
    let packed = match record.u16(0)? {
        VERTEX_CN => 44,
        VERTEX_CNT => 52,
        VERTEX_CT => 40,
        _ => 32,
    };
    if flags & PACKED != 0 || document.packed_colors {
        return record.packed_color(packed);
    }
    if flags & NO_COLOR != 0 {
        return None;
    }
    // Before revision 15.1, index and intensity were stored in place of the colour name index.
    let index = match document.revision {
        ..1510 => record.u16(4).map(u32::from),
        _ => record.u32(packed + 4),
    };
    palettes.color(index?)
}

fn pair(record: RecordFields, at: usize) -> Option<DVec2> {
    Some(DVec2::new(record.single(at)?, record.single(at + 4)?))
}

fn vertex(position: DVec3, normal: Option<DVec3>, uv: Option<DVec2>) -> Option<FltVertex> {
    let has_direction = |n: &DVec3| n.is_finite() && *n != DVec3::ZERO;
    position.is_finite().then_some(FltVertex {
        position,
        normal: normal.filter(has_direction),
        uv: uv.filter(|uv| uv.is_finite()),
    })
}

/// The vertices of one mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalPool<'a> {
    record: RecordFields<'a>,
    /// From the highest bit: position, colour index, packed colour, normal, texture coordinates,
    /// and coordinates of seven more textures.
    attributes: u32,
    stride: usize,
    pub count: usize,
    /// The number of vertices declared in the record.
    pub promised: u32,
}

/// The attribute bits with the size of each attribute, in storage order.
const ATTRIBUTES: [(u32, usize); 12] = [
    (POSITION, 24),
    (COLOR_INDEX, 4),
    (PACKED_COLOR, 4),
    (NORMAL, 12),
    (UV, 8),
    (1 << 26, 8),
    (1 << 25, 8),
    (1 << 24, 8),
    (1 << 23, 8),
    (1 << 22, 8),
    (1 << 21, 8),
    (1 << 20, 8),
];
const POSITION: u32 = 1 << 31;
const COLOR_INDEX: u32 = 1 << 30;
const PACKED_COLOR: u32 = 1 << 29;
const NORMAL: u32 = 1 << 28;
const UV: u32 = 1 << 27;

impl<'a> LocalPool<'a> {
    const FIRST: usize = 12;

    /// The pool of a record; `None` if it has no positions.
    pub fn new(record: RecordFields<'a>) -> Option<LocalPool<'a>> {
        let (promised, attributes) = (record.u32(4)?, record.u32(8)?);
        let sizes = ATTRIBUTES.iter().filter(|(bit, _)| attributes & bit != 0);
        let stride: usize = sizes.map(|(_, size)| size).sum();
        if attributes & POSITION == 0 {
            return None;
        }
        let present = (record.0.len() - Self::FIRST) / stride;
        Some(LocalPool {
            record,
            attributes,
            stride,
            count: present.min(promised as usize),
            promised,
        })
    }

    /// The offset of an attribute of a vertex, if vertices have it.
    fn at(&self, index: u32, attribute: u32) -> Option<usize> {
        let before = ATTRIBUTES.iter().take_while(|(bit, _)| *bit != attribute);
        let present = before.filter(|(bit, _)| self.attributes & bit != 0);
        let offset: usize = present.map(|(_, size)| size).sum();
        let start = Self::FIRST + self.stride * index as usize;
        (self.attributes & attribute != 0).then_some(start + offset)
    }

    /// The vertex `index`, which is below `count`; `None` if its position is not finite.
    pub fn vertex(&self, index: u32) -> Option<FltVertex> {
        let position = self.record.doubles(self.at(index, POSITION)?)?;
        let normal = self
            .at(index, NORMAL)
            .and_then(|at| self.record.singles(at));
        let uv = self.at(index, UV).and_then(|at| pair(self.record, at));
        vertex(position, normal, uv)
    }

    /// The colour of a vertex, if vertices have one.
    pub fn color(&self, index: u32, palettes: &Palettes) -> Option<Rgb> {
        if let Some(at) = self.at(index, PACKED_COLOR) {
            return self.record.packed_color(at);
        }
        palettes.color(self.record.u32(self.at(index, COLOR_INDEX)?)?)
    }
}
