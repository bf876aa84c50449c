//! Reads statements into flat lists, in one pass over the bytes.

use super::assemble::assemble;
use super::cursor::StatementCursor;
use super::free_form::FreeForm;
use super::lists::{NONE, ObjLists, ObjPart};
use super::mtl::Library;
use crate::picture::srgb::{linear_color, linear_from_srgb};
use crate::reading::options::{BLENDER_COLORS, Budget};
use crate::reading::text::{decoded, shortened, text};
use crate::reading::warnings::Warnings;
use crate::surface::textures::normalized_path;
use crate::{Files, Loaded, Position, ReadError, ReadOptions, VertexColors};
use azulejo_scene::Rgb;
use glam::{DVec2, DVec3};
use std::collections::{HashMap, HashSet};

/// Largest file in bytes. Every vertex, corner and face takes at least two bytes, so that
/// indices fit in 32 bits.
const LARGEST: u64 = 4 << 30;

/// Reads a Wavefront OBJ file. `name` is used in messages; `files` provides the material libraries
/// and textures, by their names relative to the model.
///
/// Each run of faces under one `o` and `g` becomes an object, named `o/g`; the free-form surfaces
/// among them become another. An object holds the positions that its faces use, in file
/// order. Missing material libraries and textures and all skipped statements cause warnings.
///
/// # Errors
/// A malformed number, an index that is malformed or out of range, bytes that are not text, a file
/// of 4 GiB or more, surfaces with more polygons than [`ReadOptions`] allow.
pub fn read(bytes: &[u8], name: &str, files: &dyn Files) -> Result<Loaded, ReadError> {
    read_with(bytes, name, files, &ReadOptions::default())
}

/// Like [`read`], with options.
///
/// # Errors
/// As [`read`].
pub fn read_with(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    let size = bytes.len() as u64;
    if size >= LARGEST {
        let (found, expected) = (format!("{size} bytes"), format!("fewer than {LARGEST}"));
        return Err(ReadError::whole(name, found, expected));
    }
    let bytes = decoded(bytes);
    let mut reader = ObjReader::new(&bytes, name, files, options)?;
    while let Some(keyword) = reader.cursor.keyword() {
        reader.statement(keyword)?;
        reader.cursor.finish_statement();
    }
    reader.end_of_file()?;
    reader.check_references()?;
    reader.unused_weights();
    if !reader.polypaint.is_empty() {
        reader.end_polypaint();
    }
    let ObjReader {
        raw,
        library,
        mut warnings,
        ..
    } = reader;
    let scene = assemble(raw, library, name, &mut warnings);
    Ok(Loaded {
        scene,
        warnings: warnings.finish(name),
    })
}

/// State of reading a file.
pub(super) struct ObjReader<'a> {
    pub(super) cursor: StatementCursor<'a>,
    pub(super) file: &'a str,
    files: &'a dyn Files,
    pub(super) raw: ObjLists,
    pub(super) budget: Budget,
    pub(super) free_form: FreeForm,
    /// The largest vertex index that preceded its vertex, and its offset in the file.
    ahead: (i64, usize),
    pub(super) material: u32,
    /// [`NONE`] before the first `s`.
    smoothing: u32,
    /// Name of the latest `o`.
    object: String,
    /// The first vertex that has a weight.
    weight_at: Option<Position>,
    /// Colours from ZBrush whose block has not ended.
    polypaint: Vec<Rgb>,
    /// What colours of vertices are, if that is given.
    vertex_colors: Option<VertexColors>,
    is_by_blender: bool,
    material_index: HashMap<String, u32>,
    library: Library,
    libraries_read: HashSet<String>,
    pub(super) warnings: Warnings,
}

impl<'a> ObjReader<'a> {
    fn new(
        bytes: &'a [u8],
        file: &'a str,
        files: &'a dyn Files,
        options: &ReadOptions,
    ) -> Result<Self, ReadError> {
        Ok(ObjReader {
            cursor: StatementCursor::new(bytes, file)?,
            file,
            files,
            raw: ObjLists::default(),
            budget: Budget::new(options),
            free_form: FreeForm::default(),
            ahead: (0, 0),
            material: NONE,
            smoothing: NONE,
            object: String::new(),
            weight_at: None,
            polypaint: Vec::new(),
            vertex_colors: options.vertex_colors,
            is_by_blender: bytes.trim_ascii_start().starts_with(b"# Blender"),
            material_index: HashMap::new(),
            library: Library::default(),
            libraries_read: HashSet::new(),
            warnings: Warnings::default(),
        })
    }

    fn statement(&mut self, keyword: &[u8]) -> Result<(), ReadError> {
        match keyword {
            b"v" => self.vertex()?,
            b"vt" => self.uv()?,
            b"vn" => self.normal()?,
            b"f" | b"fo" => self.face()?,
            b"o" => self.begin_object(),
            b"g" => self.begin_group(),
            b"s" => self.smoothing_group(),
            b"usemtl" => self.use_material(),
            b"mtllib" => self.material_library()?,
            b"p" => self.points(),
            b"l" => self.warn("lines (l) have no surface: skipped"),
            POLYPAINT => self.polypaint(),
            _ if self.free_form(keyword)? => {}
            _ => self.skipped(keyword),
        }
        Ok(())
    }

    #[cold]
    pub(super) fn warn(&mut self, message: impl Into<String>) {
        let cursor = &self.cursor;
        self.warnings
            .add(self.file, message.into(), || cursor.position());
    }

    #[cold]
    fn skipped(&mut self, keyword: &[u8]) {
        const DISPLAY: [&[u8]; 7] = [
            b"bevel",
            b"c_interp",
            b"d_interp",
            b"lod",
            b"shadow_obj",
            b"trace_obj",
            b"mg",
        ];
        let word = shortened(&text(keyword));
        if DISPLAY.contains(&keyword) {
            self.warn(format!("\"{word}\" does not change the geometry: skipped"));
        } else if matches!(keyword, b"usemap" | b"maplib") {
            self.warn(format!(
                "\"{word}\" (textures outside materials) is not used: skipped"
            ));
        } else {
            self.warn(format!("unknown statement \"{word}\": skipped"));
        }
    }

    /// The next number, if there is one; NaN and infinities included.
    #[inline]
    fn number(&mut self) -> Result<Option<f64>, ReadError> {
        let Some(number) = self.cursor.number()? else {
            return Ok(None);
        };
        if number.misplaced_sign {
            self.warn("numbers like 3.1+e2, the exponent's sign before its letter: read as 3.1e+2");
        }
        Ok(Some(number.value))
    }

    /// `N` required numbers.
    #[inline]
    fn numbers<const N: usize>(&mut self, expected: &str) -> Result<[f64; N], ReadError> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = match self.number()? {
                Some(v) => v,
                None => return Err(self.cursor.error_at(self.cursor.offset(), expected)),
            };
        }
        Ok(values)
    }

    /// `v x y z`, then nothing, a weight, a colour, or both.
    fn vertex(&mut self) -> Result<(), ReadError> {
        if !self.polypaint.is_empty() {
            self.end_polypaint();
        }
        self.cursor.skip_blanks();
        let start = self.cursor.offset();
        let position = match self.cursor.plain_numbers() {
            Some(position) => DVec3::from_array(position),
            None => DVec3::from(self.numbers::<3>("x, y and z of a vertex")?),
        };
        if !position.is_finite() {
            let found = format!("a vertex at {position}");
            return Err(self.cursor.error_with(start, found, "finite coordinates"));
        }
        self.raw.positions.push(position);
        if self.cursor.at_end() {
            return Ok(());
        }
        self.vertex_extras()
    }

    fn vertex_extras(&mut self) -> Result<(), ReadError> {
        // Read all numbers on the line, as their count tells a weight from a colour.
        let start = self.cursor.offset();
        let (mut extras, mut count) = ([0.0; 4], 0);
        while let Some(value) = self.number()? {
            if let Some(slot) = extras.get_mut(count) {
                *slot = value;
            }
            count += 1;
        }
        if extras.iter().any(|e| !e.is_finite()) {
            let found = "a number that is not finite";
            return Err(self.cursor.error_with(start, found, "a weight or colour"));
        }
        let (weight, color) = match (count, extras) {
            (1, [w, ..]) => (w, None),
            (3, [r, g, b, _]) => (1.0, Some([r, g, b])),
            (4, [w, r, g, b]) => (w, Some([r, g, b])),
            _ => {
                self.warn("numbers after x, y and z that are neither weight nor colour: skipped");
                return Ok(());
            }
        };
        // Lists of weights and colours end at the last vertex that has one: fill the gap before this one.
        let before = self.raw.positions.len() - 1;
        if weight != 1.0 {
            self.weight_at.get_or_insert_with(|| self.cursor.position());
            self.raw.weights.resize(before, 1.0);
            self.raw.weights.push(weight);
        }
        if let Some(color) = color {
            let clamped = color.map(|c| c.clamp(0.0, 1.0));
            if clamped != color {
                self.warn("vertex colour outside 0..1: clamped");
            }
            // Colours are sRGB if the options say so, or if nothing is specified and Blender wrote the file.
            let mut color = Rgb::from(clamped);
            if self.vertex_colors.is_none() && self.is_by_blender {
                self.warn(BLENDER_COLORS);
                color = linear_color(color);
            } else if self.vertex_colors == Some(VertexColors::Srgb) {
                color = linear_color(color);
            }
            self.raw.colors.resize(before, None);
            self.raw.colors.push(Some(color));
        }
        Ok(())
    }

    /// Warns if no surface has used the weights.
    fn unused_weights(&mut self) {
        let Some(position) = self.weight_at.filter(|_| !self.free_form.weights_used) else {
            return;
        };
        let message = "vertex with a weight w: not used, weights apply only to rational surfaces";
        let count = self.raw.weights.iter().filter(|w| **w != 1.0).count();
        self.warnings
            .add_many(self.file, message.to_owned(), count, || position);
    }

    /// ZBrush writes colours into comments, `#MRGB` and eight hexadecimal digits for each vertex:
    /// a mask, red, green and blue. A block applies to the latest vertices.
    fn polypaint(&mut self) {
        let digits = self.cursor.word().unwrap_or_default();
        for vertex in digits.chunks(8) {
            let text = std::str::from_utf8(vertex).unwrap_or_default();
            let Some(mrgb) = u32::from_str_radix(text, 16)
                .ok()
                .filter(|_| text.len() == 8)
            else {
                return self.warn("#MRGB colours that are not hexadecimal: skipped");
            };
            let linear = |v: u8| f64::from(linear_from_srgb(f32::from(v) / 255.0));
            let [_, r, g, b] = mrgb.to_be_bytes();
            self.polypaint.push(Rgb::from([r, g, b].map(linear)));
        }
    }

    /// Assigns the colours of a block to the vertices before it.
    #[cold]
    fn end_polypaint(&mut self) {
        let colors = std::mem::take(&mut self.polypaint);
        let Some(first) = self.raw.positions.len().checked_sub(colors.len()) else {
            return self.warn("more #MRGB colours than vertices: skipped");
        };
        self.raw.colors.resize(first, None);
        self.raw.colors.extend(colors.into_iter().map(Some));
    }

    fn points(&mut self) {
        let mut count = 0;
        while self.cursor.word().is_some() {
            count += 1;
        }
        let message = "points (p) have no surface: skipped".to_owned();
        let cursor = &self.cursor;
        self.warnings
            .add_many(self.file, message, count, || cursor.position());
    }

    /// `vt u [v [w]]`.
    fn uv(&mut self) -> Result<(), ReadError> {
        let mut uv = match self.cursor.plain_numbers() {
            Some(uv) => DVec2::from_array(uv),
            None => {
                let [u] = self.numbers::<1>("u of a texture coordinate")?;
                DVec2::new(u, self.number()?.unwrap_or(0.0))
            }
        };
        if !uv.is_finite() {
            self.warn("texture coordinate that is not finite: taken as (0, 0)");
            uv = DVec2::ZERO;
        }
        self.raw.uvs.push(uv);
        Ok(())
    }

    fn normal(&mut self) -> Result<(), ReadError> {
        let given = match self.cursor.plain_numbers() {
            Some(normal) => DVec3::from_array(normal),
            None => DVec3::from(self.numbers::<3>("x, y and z of a normal")?),
        };
        let unit = unit_or_zero(given);
        if unit == DVec3::ZERO {
            self.warn("normal that is zero or not finite: dropped");
        }
        self.raw.normals.push(unit);
        Ok(())
    }

    fn face(&mut self) -> Result<(), ReadError> {
        let first = self.raw.faces.corners.len();
        while !self.cursor.at_end() {
            let at = self.raw.faces.corners.len();
            let [position, uv, normal] = self.corner()?;
            self.raw.faces.corners.push(position);
            put(&mut self.raw.corner_uvs, at, uv);
            put(&mut self.raw.corner_normals, at, normal);
        }
        if self.raw.faces.corners.len() - first < 3 {
            self.raw.faces.corners.truncate(first);
            self.raw.corner_uvs.truncate(first);
            self.raw.corner_normals.truncate(first);
            self.warn("face of fewer than three corners: skipped");
            return Ok(());
        }
        let end = self.raw.faces.corners.len() as u32;
        self.raw.faces.starts.push(end);
        self.raw.face_materials.push(self.material);
        if self.smoothing != NONE {
            let before = self.raw.face_materials.len() - 1;
            self.raw.smoothing.resize(before, NONE);
            self.raw.smoothing.push(self.smoothing);
        }
        Ok(())
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn` as indices from zero; missing ones after a slash are
    /// [`NONE`].
    #[inline(always)]
    pub(super) fn corner(&mut self) -> Result<[u32; 3], ReadError> {
        let start = self.cursor.offset();
        let position = self.position(start)?;
        let (mut uv, mut normal) = (NONE, NONE);
        if self.cursor.slash() {
            uv = self.attribute(self.raw.uvs.len(), start)?;
            if self.cursor.slash() {
                normal = self.attribute(self.raw.normals.len(), start)?;
            }
        }
        if !self.cursor.word_ends() {
            return Err(self.cursor.error_at(start, CORNER));
        }
        Ok([position, uv, normal])
    }

    /// An index from zero into the positions.
    #[inline]
    fn position(&mut self, start: usize) -> Result<u32, ReadError> {
        let Some(given) = self.cursor.integer() else {
            return Err(self.cursor.error_at(start, CORNER));
        };
        let count = self.raw.positions.len();
        if given > count as i64 && given > self.ahead.0 {
            self.ahead = (given, start);
        }
        match from_zero(given, count) {
            NONE => Err(self.out_of_range(given, start)),
            index => Ok(index),
        }
    }

    /// An index from zero into a list of `count` texture coordinates or normals; [`NONE`] if it
    /// is missing or out of range: the shape does not depend on it.
    #[inline]
    fn attribute(&mut self, count: usize, start: usize) -> Result<u32, ReadError> {
        let Some(given) = self.cursor.integer() else {
            return self.absent(start);
        };
        let index = from_zero(given, count);
        if index == NONE {
            self.warn(NO_SUCH_ATTRIBUTE);
        }
        Ok(index)
    }

    #[cold]
    fn absent(&self, start: usize) -> Result<u32, ReadError> {
        if self.cursor.word_ends() || self.cursor.at_slash() {
            Ok(NONE)
        } else {
            Err(self.cursor.error_at(start, CORNER))
        }
    }

    #[cold]
    pub(super) fn out_of_range(&self, given: i64, start: usize) -> ReadError {
        let expected = match (given, self.raw.positions.len()) {
            (0, _) => "1 for the first vertex or -1 for the latest".to_owned(),
            (_, 0) => "vertices to be defined".to_owned(),
            (1.., count) => format!("1 to {count}, the number of vertices in the file"),
            (_, count) => format!("-{count} to -1, the number of vertices so far"),
        };
        self.cursor
            .error_with(start, format!("vertex {given}"), expected)
    }

    /// Faces may precede their vertices; whether those exist is known only at the end of the file.
    fn check_references(&mut self) -> Result<(), ReadError> {
        let (given, start) = self.ahead;
        if given > self.raw.positions.len() as i64 {
            return Err(self.out_of_range(given, start));
        }
        let (uvs, normals) = (self.raw.uvs.len(), self.raw.normals.len());
        let dropped = drop_beyond(&mut self.raw.corner_uvs, uvs)
            + drop_beyond(&mut self.raw.corner_normals, normals);
        let message = NO_SUCH_ATTRIBUTE.to_owned();
        self.warnings
            .add_many(self.file, message, dropped, || Position::Whole);
        Ok(())
    }

    fn begin_object(&mut self) {
        self.object = self.cursor.name();
        let name = self.object.clone();
        self.begin_part(name);
    }

    /// Begins a group, unless the current one has the same name: exporters repeat it after
    /// every change of material.
    fn begin_group(&mut self) {
        let group = self.cursor.name();
        let name = match (self.object.as_str(), group.as_str()) {
            ("", _) => group,
            (object, "") => object.to_owned(),
            (object, group) if object == group => group.to_owned(),
            (object, group) => format!("{object}/{group}"),
        };
        if self.raw.parts.last().is_none_or(|last| last.name != name) {
            self.begin_part(name);
        }
    }

    fn begin_part(&mut self, name: String) {
        let first_face = self.raw.face_materials.len();
        self.raw.parts.push(ObjPart { name, first_face });
    }

    fn smoothing_group(&mut self) {
        let word = self.cursor.word().unwrap_or(b"off");
        let number = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
        self.smoothing = match number {
            Some(NONE) => NONE - 1,
            Some(group) => group,
            None => {
                if word != b"off" && word != b"on" {
                    self.warn("smoothing group that is not a number: taken as off");
                }
                u32::from(word == b"on")
            }
        };
    }

    fn use_material(&mut self) {
        let name = self.cursor.name();
        if name.is_empty() {
            self.material = NONE;
            return;
        }
        self.material = match self.material_index.get(&name) {
            Some(&known) => known,
            None => {
                let new = self.raw.material_names.len() as u32;
                self.raw.material_names.push(name.clone());
                self.material_index.insert(name, new);
                new
            }
        };
    }

    /// `mtllib` with one name that may contain blanks, or with several.
    fn material_library(&mut self) -> Result<(), ReadError> {
        let position = self.cursor.position();
        let names = self.cursor.name();
        for name in library_names(&names, self.files) {
            let name = normalized_path(&name);
            if !self.libraries_read.insert(name.clone()) {
                continue;
            }
            match self.files.read(&name) {
                Ok(bytes) => self
                    .library
                    .add(&bytes, &name, self.files, &mut self.warnings)
                    .map_err(|e| included_from(e, self.file, position))?,
                Err(e) => {
                    let message = format!("material library \"{name}\": {e}");
                    self.warnings.add(self.file, message, || position);
                }
            }
        }
        Ok(())
    }
}

/// What [`StatementCursor::keyword`] returns for ZBrush's comments.
const POLYPAINT: &[u8] = b"#MRGB";

const CORNER: &str = "a corner like 1, 1/2, 1//3 or 1/2/3";

const NO_SUCH_ATTRIBUTE: &str =
    "corner whose texture coordinate or normal does not exist: taken without it";

/// Converts an index of OBJ, which counts from 1 or backwards from −1, to one from 0. One beyond the
/// `count` so far is kept: it may be defined later. [`NONE`] for 0 and what precedes the first.
#[inline]
fn from_zero(given: i64, count: usize) -> u32 {
    if given > 0 {
        (given - 1).min(i64::from(NONE - 1)) as u32
    } else if given < 0 && given >= -(count as i64) {
        (count as i64 + given) as u32
    } else {
        NONE
    }
}

/// Removes the indices that are not below `count` and returns how many there were.
fn drop_beyond(indices: &mut [u32], count: usize) -> usize {
    let beyond = |i: &&mut u32| **i != NONE && **i as usize >= count;
    indices.iter_mut().filter(beyond).map(|i| *i = NONE).count()
}

/// Adds the including file to an error in a material library.
fn included_from(mut error: ReadError, file: &str, position: Position) -> ReadError {
    if let Position::Line(line, _) = position {
        error.included_from.insert(0, (file.to_owned(), line));
    }
    error
}

/// Sets the attribute of a corner, in a list that stays empty until one corner has it.
#[inline]
fn put(list: &mut Vec<u32>, corner: usize, value: u32) {
    if value != NONE {
        list.resize(corner, NONE);
        list.push(value);
    } else if !list.is_empty() {
        list.push(NONE);
    }
}

/// A vector scaled to length 1, or zero if that is impossible.
fn unit_or_zero(n: DVec3) -> DVec3 {
    let largest = n.abs().max_element();
    if (n.length_squared() - 1.0).abs() < 1e-15 {
        // Normals that azulejo wrote stay the same to the last bit.
        n
    } else if n.is_finite() && largest > 0.0 {
        // Dividing first avoids overflow and underflow of the squared length.
        (n / largest).normalize_or_zero()
    } else {
        DVec3::ZERO
    }
}

/// The files that an `mtllib` names: its whole text if there is such a file, otherwise the
/// pieces that end in `.mtl`, otherwise its words.
fn library_names(text: &str, files: &dyn Files) -> Vec<String> {
    let words: Vec<&str> = text.split_whitespace().collect();
    if words.len() <= 1 || files.read(text).is_ok() {
        return vec![text.to_owned()];
    }
    let ends = |w: &&str| w.to_ascii_lowercase().ends_with(".mtl");
    if !words.iter().any(ends) {
        return words.into_iter().map(str::to_owned).collect();
    }
    words
        .split_inclusive(ends)
        .map(|piece| piece.join(" "))
        .collect()
}
