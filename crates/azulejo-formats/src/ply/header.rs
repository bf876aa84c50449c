//! The header: the elements, and their properties.

use super::rows::{RowError, RowSource};
use crate::reading::text::text;
use crate::reading::warnings::Warnings;
use crate::reading::words::Words;
use crate::{Position, ReadError};
use azulejo_scene::{Units, Up};

/// The encoding of the rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PlyEncoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// The scalar types.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ScalarType {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

/// The type of a property.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PropertyType {
    Scalar(ScalarType),
    List { count: ScalarType, item: ScalarType },
}

/// A property, which is a column of an element.
#[derive(Clone, Debug)]
pub(super) struct PlyProperty {
    pub name: String,
    pub kind: PropertyType,
}

/// An element, which is a table.
#[derive(Clone, Debug)]
pub(super) struct PlyElement {
    pub name: String,
    pub count: u64,
    pub properties: Vec<PlyProperty>,
    /// The line of its declaration.
    pub line: u32,
}

/// The content of the header.
#[derive(Debug)]
pub(super) struct PlyHeader {
    pub encoding: PlyEncoding,
    pub elements: Vec<PlyElement>,
    /// Texture files named by `comment TextureFile`.
    pub textures: Vec<String>,
    /// Names of objects from `obj_info azulejo object`, in order.
    pub objects: Vec<String>,
    pub units: Units,
    pub is_by_blender: bool,
    /// Whether the colours of vertices are those of the faces around them.
    pub carries_face_colors: bool,
    /// Offset of the first row.
    pub end: usize,
}

impl ScalarType {
    fn parse(word: &[u8]) -> Option<ScalarType> {
        Some(match word {
            b"char" | b"int8" => ScalarType::I8,
            b"uchar" | b"uint8" => ScalarType::U8,
            b"short" | b"int16" => ScalarType::I16,
            b"ushort" | b"uint16" => ScalarType::U16,
            b"int" | b"int32" => ScalarType::I32,
            b"uint" | b"uint32" => ScalarType::U32,
            b"float" | b"float32" => ScalarType::F32,
            b"double" | b"float64" => ScalarType::F64,
            _ => return None,
        })
    }

    /// Its size in bytes in a binary file.
    pub fn size(self) -> usize {
        match self {
            ScalarType::I8 | ScalarType::U8 => 1,
            ScalarType::I16 | ScalarType::U16 => 2,
            ScalarType::I32 | ScalarType::U32 | ScalarType::F32 => 4,
            ScalarType::F64 => 8,
        }
    }

    /// The value that represents 1 in colours of this type.
    pub fn one(self) -> f64 {
        match self {
            ScalarType::F32 | ScalarType::F64 => 1.0,
            ScalarType::I16 | ScalarType::U16 => 65535.0,
            _ => 255.0,
        }
    }
}

impl PlyProperty {
    /// Skips this property in a row.
    pub fn skip(&self, source: &mut impl RowSource) -> Result<(), RowError> {
        match self.kind {
            PropertyType::Scalar(kind) => source.number(kind).map(|_| ()),
            PropertyType::List { count, item } => {
                let count = source.count(count, item)?;
                (0..count).try_for_each(|_| source.number(item).map(|_| ()))
            }
        }
    }
}

impl PlyElement {
    /// The capacity for the rows, limited to what this many bytes can hold.
    pub fn room(&self, bytes: usize) -> usize {
        let size = |p: &PlyProperty| match p.kind {
            PropertyType::Scalar(kind) => kind.size(),
            PropertyType::List { count, .. } => count.size(),
        };
        // The shortest number in a text takes two bytes, with its blank.
        let row: usize = self.properties.iter().map(|p| size(p).min(2)).sum();
        self.count.min((bytes / row.max(1)) as u64) as usize
    }
}

impl PlyHeader {
    /// Whether the positions of vertices are declared as numbers of single precision.
    pub fn has_single_positions(&self) -> bool {
        let is_single = |p: &PlyProperty| {
            let is_position = matches!(p.name.as_str(), "x" | "y" | "z");
            is_position && matches!(p.kind, PropertyType::Scalar(ScalarType::F32))
        };
        let mut vertices = self.elements.iter().filter(|e| e.name == "vertex");
        vertices.any(|e| e.properties.iter().any(is_single))
    }

    /// Reads the header of a file.
    ///
    /// # Errors
    /// A malformed statement, or a missing end.
    pub fn read(bytes: &[u8], file: &str, warnings: &mut Warnings) -> Result<PlyHeader, ReadError> {
        let mut parser = PlyHeaderParser {
            words: Words::new(bytes, file),
            file,
            warnings,
            line: 1,
            encoding: None,
            header: PlyHeader {
                encoding: PlyEncoding::Text,
                elements: Vec::new(),
                textures: Vec::new(),
                objects: Vec::new(),
                units: Units::default(),
                is_by_blender: false,
                carries_face_colors: false,
                end: 0,
            },
        };
        if parser.words.word() != Some(b"ply") {
            return Err(parser
                .words
                .error(0, "a PLY file, which begins with \"ply\""));
        }
        parser.words.rest_of_line();
        parser.statements()
    }
}

struct PlyHeaderParser<'a> {
    words: Words<'a>,
    file: &'a str,
    warnings: &'a mut Warnings,
    line: u32,
    encoding: Option<PlyEncoding>,
    header: PlyHeader,
}

impl PlyHeaderParser<'_> {
    fn statements(mut self) -> Result<PlyHeader, ReadError> {
        loop {
            self.line += 1;
            self.words.skip_spaces();
            let start = self.words.offset();
            if self.words.at_line_end() && !self.words.at_end() {
                self.words.rest_of_line();
                continue;
            }
            match self.words.word().unwrap_or_default() {
                b"" => return Err(self.words.error(start, "the end of the header, end_header")),
                b"format" => self.format()?,
                b"comment" => self.comment(),
                b"obj_info" => self.info(),
                b"element" => self.element()?,
                b"property" => self.property()?,
                b"end_header" => return self.end(start),
                _ => self.unknown(),
            }
        }
    }

    /// Comments without the keyword are not rare.
    fn unknown(&mut self) {
        let message = "header line that is not a PLY statement: skipped";
        let line = Position::Line(self.line, 1);
        self.warnings.add(self.file, message.into(), || line);
        self.words.rest_of_line();
    }

    /// The rows begin after exactly one line end: their first byte may have the value of another.
    fn end(mut self, start: usize) -> Result<PlyHeader, ReadError> {
        self.words.rest_of_line();
        self.header.end = self.words.offset();
        match self.encoding {
            Some(encoding) => self.header.encoding = encoding,
            None => {
                return Err(self
                    .words
                    .error(start, "the format before the end of the header"));
            }
        }
        Ok(self.header)
    }

    fn format(&mut self) -> Result<(), ReadError> {
        self.words.skip_spaces();
        let start = self.words.offset();
        self.encoding = Some(match self.words.word().unwrap_or_default() {
            b"ascii" => PlyEncoding::Text,
            b"binary_little_endian" => PlyEncoding::LittleEndian,
            b"binary_big_endian" => PlyEncoding::BigEndian,
            _ => {
                let expected = "ascii, binary_little_endian or binary_big_endian";
                return Err(self.words.error(start, expected));
            }
        });
        self.words.rest_of_line();
        Ok(())
    }

    fn comment(&mut self) {
        let comment = self.words.rest_of_line();
        if let Some(file) = comment.strip_prefix(b"TextureFile") {
            self.header.textures.push(text(file).trim().to_owned());
        } else {
            let comment = text(comment);
            self.header.is_by_blender |=
                comment.starts_with("Created ") && comment.contains("Blender");
            self.extension(&comment);
        }
    }

    /// azulejo's own extensions: names of objects, and units.
    fn info(&mut self) {
        let info = text(self.words.rest_of_line()).into_owned();
        self.extension(&info);
    }

    /// What follows `obj_info`, or `comment`, which more programs accept.
    fn extension(&mut self, info: &str) {
        let Some(info) = info.strip_prefix("azulejo ") else {
            return;
        };
        let units = &mut self.header.units;
        match info.split_once(' ').unwrap_or((info, "")) {
            ("object", name) => self.header.objects.push(name.trim().to_owned()),
            ("up", "z") => units.up = Up::Z,
            ("photometric", _) => units.photometric = true,
            ("colours_of_faces", _) => self.header.carries_face_colors = true,
            ("metres_per_unit", length) => {
                let length = length.trim().parse().ok();
                units.metres_per_unit = length.filter(|l: &f64| l.is_finite() && *l > 0.0);
            }
            _ => {}
        }
    }

    /// The next word of the line.
    fn word(&mut self) -> &[u8] {
        self.words.skip_spaces();
        if self.words.at_line_end() {
            &[]
        } else {
            self.words.word().unwrap_or_default()
        }
    }

    fn element(&mut self) -> Result<(), ReadError> {
        let name = text(self.word()).into_owned();
        self.words.skip_spaces();
        let start = self.words.offset();
        let count = std::str::from_utf8(self.word()).ok();
        let Some(count) = count.and_then(|c| c.parse().ok()) else {
            return Err(self.words.error(start, "a number of elements"));
        };
        self.header.elements.push(PlyElement {
            name,
            count,
            properties: Vec::new(),
            line: self.line,
        });
        self.words.rest_of_line();
        Ok(())
    }

    fn property(&mut self) -> Result<(), ReadError> {
        self.words.skip_spaces();
        let start = self.words.offset();
        let kind = match self.word() {
            b"list" => PropertyType::List {
                count: self.kind()?,
                item: self.kind()?,
            },
            word => match ScalarType::parse(word) {
                Some(kind) => PropertyType::Scalar(kind),
                None => return Err(self.words.error(start, KINDS)),
            },
        };
        let name = text(self.words.rest_of_line()).into_owned();
        match self.header.elements.last_mut() {
            Some(element) => element.properties.push(PlyProperty { name, kind }),
            None => return Err(self.words.error(start, "an element before its properties")),
        }
        Ok(())
    }

    fn kind(&mut self) -> Result<ScalarType, ReadError> {
        self.words.skip_spaces();
        let start = self.words.offset();
        ScalarType::parse(self.word()).ok_or_else(|| self.words.error(start, KINDS))
    }
}

const KINDS: &str = "a scalar type (char, uchar, short, ushort, int, uint, float, double)";
