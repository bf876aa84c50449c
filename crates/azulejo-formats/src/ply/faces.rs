//! The elements `face` and `tristrips`.

use super::header::{PlyElement, PlyProperty, PropertyType, ScalarType};
use super::rows::{RowError, RowSource};
use super::{NONE, PlyReader, rows};
use crate::{Position, ReadError};
use azulejo_scene::{Faces, Rgb};
use glam::DVec2;
use std::collections::HashMap;

/// Maximum number of distinct appearances of faces; each becomes a material.
const MOST_FACE_MATERIALS: usize = 1 << 16;

/// The polygons of a file, before their indices are checked.
#[derive(Debug, Default)]
pub(super) struct PlyFaceList {
    pub faces: Faces,
    /// Texture coordinate of each corner, or empty.
    pub corner_uvs: Vec<DVec2>,
    /// Index into `materials` for each face, or empty.
    pub face_material_indices: Vec<u32>,
    pub materials: Vec<FaceMaterial>,
    known: HashMap<(Option<[u64; 3]>, u32), u32>,
}

/// The appearance of a face.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct FaceMaterial {
    pub color: Option<Rgb>,
    /// Index of the texture.
    pub texture: u32,
}

/// The meaning of a face property.
#[derive(Clone, Copy, PartialEq)]
enum FaceProperty {
    Corners(ScalarType, ScalarType),
    CornerUvs(ScalarType, ScalarType),
    Color(usize, ScalarType),
    Texture(ScalarType),
    Nothing,
}

/// Colours that other programs show, too.
const PLAIN: [&str; 3] = ["red", "green", "blue"];

/// The values in one row of faces.
#[derive(Clone, Copy, Default)]
struct FaceRow {
    color: [f64; 3],
    texture: u32,
}

impl FaceProperty {
    /// `diffuse_red` always belongs to the material; `red` is used only if `is_red_used`.
    fn of(property: &PlyProperty, is_red_used: bool) -> FaceProperty {
        let channel = |names: [&str; 3]| names.iter().position(|n| *n == property.name);
        match (property.kind, property.name.as_str()) {
            (PropertyType::List { count, item }, "vertex_indices" | "vertex_index") => {
                FaceProperty::Corners(count, item)
            }
            (PropertyType::List { count, item }, "texcoord") => {
                FaceProperty::CornerUvs(count, item)
            }
            (PropertyType::List { .. }, _) => FaceProperty::Nothing,
            (PropertyType::Scalar(kind), "texnumber") => FaceProperty::Texture(kind),
            (PropertyType::Scalar(kind), _) => {
                let plain = channel(PLAIN).filter(|_| is_red_used);
                let own = channel(["diffuse_red", "diffuse_green", "diffuse_blue"]);
                let channel = own.or(plain);
                channel.map_or(FaceProperty::Nothing, |i| FaceProperty::Color(i, kind))
            }
        }
    }
}

impl PlyReader<'_> {
    /// Reads faces and returns how many are missing.
    pub fn read_faces<S: RowSource>(
        &mut self,
        element: &PlyElement,
        source: &mut S,
    ) -> Result<u64, ReadError> {
        let meanings = self.meanings(element);
        let has = |m: fn(&FaceProperty) -> bool| meanings.iter().any(m);
        let has_uvs = has(|m| matches!(m, FaceProperty::CornerUvs(..)));
        let has_color = has(|m| matches!(m, FaceProperty::Color(..)));
        let has_material = has_color || has(|m| matches!(m, FaceProperty::Texture(_)));
        let room = element.room(source.left());
        let mut reading = FaceReading {
            list: &mut self.faces,
            too_few: 0,
            odd_uvs: 0,
        };
        reading.list.faces.starts.reserve(room);
        reading.list.faces.corners.reserve(3 * room);
        let missing = rows(element, source, |source| {
            let start = reading.start();
            let row = reading.row(source, element, &meanings);
            if row.is_err() {
                reading.undo(start);
            }
            let row = row?;
            if reading.finish(start, has_uvs) && has_material {
                reading.list.face_material(row, has_color);
            }
            Ok(())
        })?;
        let (too_few, odd_uvs) = (reading.too_few, reading.odd_uvs);
        self.count("face with fewer than three corners: skipped", too_few);
        let message = "face without a texture coordinate for each corner: (0, 0) is used";
        self.count(message, odd_uvs);
        Ok(missing)
    }

    fn count(&mut self, message: &str, count: usize) {
        self.warnings
            .add_many(self.file, message.into(), count, || Position::Whole);
    }

    fn meanings(&mut self, element: &PlyElement) -> Vec<FaceProperty> {
        // Programs that write colours of vertices and faces write the same; the numbers that azulejo
        // writes are more exact.
        let has_colors = self.vertices.as_ref().is_some_and(|v| !v.colors.is_empty());
        let has_numbers = element.properties.iter().any(|p| p.name == "diffuse_red");
        let meanings: Vec<FaceProperty> = element
            .properties
            .iter()
            .map(|p| FaceProperty::of(p, !has_colors && !has_numbers))
            .collect();
        for (property, meaning) in std::iter::zip(&element.properties, &meanings) {
            let is_known = has_numbers && PLAIN.contains(&property.name.as_str());
            if *meaning == FaceProperty::Nothing && !is_known {
                self.unused(element, &property.name);
            }
        }
        meanings
    }

    /// Reads triangle strips: rows of indices, in which −1 begins the next strip.
    pub fn read_strips<S: RowSource>(
        &mut self,
        element: &PlyElement,
        source: &mut S,
    ) -> Result<u64, ReadError> {
        let meanings = self.meanings(element);
        let mut strip = Vec::new();
        let faces = &mut self.faces.faces;
        rows(element, source, |source| {
            strip.clear();
            for (property, meaning) in std::iter::zip(&element.properties, &meanings) {
                let FaceProperty::Corners(count, item) = *meaning else {
                    property.skip(source)?;
                    continue;
                };
                for _ in 0..source.count(count, item)? {
                    strip.push(source.index(item)?);
                }
            }
            for strip in strip.split(|index| *index == NONE) {
                push_strip(faces, strip);
            }
            Ok(())
        })
    }
}

/// Appends the triangles of a strip, every second one reversed. Degenerate triangles only change
/// the orientation.
fn push_strip(faces: &mut Faces, strip: &[u32]) {
    for (i, corners) in strip.windows(3).enumerate() {
        let &[a, b, c] = corners else { continue };
        if a == b || b == c || c == a {
            continue;
        }
        faces.push(&if i % 2 == 0 { [a, b, c] } else { [b, a, c] });
    }
}

/// Faces being read.
struct FaceReading<'a> {
    list: &'a mut PlyFaceList,
    too_few: usize,
    odd_uvs: usize,
}

impl FaceReading<'_> {
    fn start(&self) -> (usize, usize) {
        (self.list.faces.corners.len(), self.list.corner_uvs.len())
    }

    fn undo(&mut self, (corners, uvs): (usize, usize)) {
        self.list.faces.corners.truncate(corners);
        self.list.corner_uvs.truncate(uvs);
    }

    #[inline]
    fn row<S: RowSource>(
        &mut self,
        source: &mut S,
        element: &PlyElement,
        meanings: &[FaceProperty],
    ) -> Result<FaceRow, RowError> {
        let mut row = FaceRow::default();
        for (number, meaning) in meanings.iter().enumerate() {
            match *meaning {
                FaceProperty::Corners(count, item) => {
                    for _ in 0..source.count(count, item)? {
                        self.list.faces.corners.push(source.index(item)?);
                    }
                }
                FaceProperty::CornerUvs(count, item) => self.corner_uvs(source, count, item)?,
                FaceProperty::Color(channel, kind) => {
                    row.color[channel] = source.number(kind)? / kind.one();
                }
                FaceProperty::Texture(kind) => row.texture = source.index(kind)?,
                FaceProperty::Nothing => element.properties[number].skip(source)?,
            }
        }
        Ok(row)
    }

    fn corner_uvs<S: RowSource>(
        &mut self,
        source: &mut S,
        count: ScalarType,
        item: ScalarType,
    ) -> Result<(), RowError> {
        let count = source.count(count, item)?;
        for _ in 0..count / 2 {
            let (u, v) = (source.number(item)?, source.number(item)?);
            self.list.corner_uvs.push(DVec2::new(u, v));
        }
        for _ in 0..count % 2 {
            source.number(item)?;
        }
        Ok(())
    }

    /// Completes a face; `false` if it is invalid.
    #[inline]
    fn finish(&mut self, start: (usize, usize), has_uvs: bool) -> bool {
        let end = self.list.faces.corners.len();
        if end < start.0 + 3 {
            self.too_few += 1;
            self.undo(start);
            return false;
        }
        self.list.faces.starts.push(end as u32);
        if has_uvs {
            let uv_count = start.1 + end - start.0;
            self.odd_uvs += usize::from(self.list.corner_uvs.len() != uv_count);
            self.list.corner_uvs.resize(uv_count, DVec2::ZERO);
        }
        true
    }
}

impl PlyFaceList {
    /// Gives every face the colour of its first vertex.
    pub fn take_colors(&mut self, vertex_colors: &[Rgb]) {
        for face in 0..self.faces.len() {
            let color = vertex_colors[self.faces.get(face)[0] as usize];
            let color = color.to_array();
            self.face_material(FaceRow { color, texture: 0 }, true);
        }
    }

    /// Assigns the last face its appearance.
    fn face_material(&mut self, row: FaceRow, has_color: bool) {
        let color = has_color.then(|| Rgb::from(row.color));
        let key = (color.map(|c| c.to_array().map(f64::to_bits)), row.texture);
        let face_material = match self.known.get(&key) {
            Some(&known) => known,
            None if self.materials.len() == MOST_FACE_MATERIALS => 0,
            None => {
                self.materials.push(FaceMaterial {
                    color,
                    texture: row.texture,
                });
                let new = (self.materials.len() - 1) as u32;
                self.known.insert(key, new);
                new
            }
        };
        self.face_material_indices.push(face_material);
    }
}
