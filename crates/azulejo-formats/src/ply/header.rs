//! The header: which elements there are, and what their rows hold.

use super::source::{Source, Stop};
use crate::reading::text::text;
use crate::reading::warnings::Warnings;
use crate::reading::words::Words;
use crate::{Position, ReadError};
use azulejo_scene::{Units, Up};

/// How the rows are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// The kinds of number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

/// What a property is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Type {
    Scalar(Kind),
    List { count: Kind, item: Kind },
}

/// A column of an element.
#[derive(Clone, Debug)]
pub(super) struct Property {
    pub name: String,
    pub kind: Type,
}

/// A table.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
    /// Where the header declares it.
    pub line: u32,
}

/// All that stands before the rows.
#[derive(Debug)]
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// Pictures that `comment TextureFile` names.
    pub textures: Vec<String>,
    /// Names of objects that `obj_info azulejo object` gives, in order.
    pub objects: Vec<String>,
    pub units: Units,
    /// Offset of the first row.
    pub end: usize,
}

impl Kind {
    fn parse(word: &[u8]) -> Option<Kind> {
        Some(match word {
            b"char" | b"int8" => Kind::I8,
            b"uchar" | b"uint8" => Kind::U8,
            b"short" | b"int16" => Kind::I16,
            b"ushort" | b"uint16" => Kind::U16,
            b"int" | b"int32" => Kind::I32,
            b"uint" | b"uint32" => Kind::U32,
            b"float" | b"float32" => Kind::F32,
            b"double" | b"float64" => Kind::F64,
            _ => return None,
        })
    }

    /// Bytes in a binary file.
    pub fn size(self) -> usize {
        match self {
            Kind::I8 | Kind::U8 => 1,
            Kind::I16 | Kind::U16 => 2,
            Kind::I32 | Kind::U32 | Kind::F32 => 4,
            Kind::F64 => 8,
        }
    }

    /// What stands for 1 in colours of this kind.
    pub fn one(self) -> f64 {
        match self {
            Kind::F32 | Kind::F64 => 1.0,
            Kind::I16 | Kind::U16 => 65535.0,
            _ => 255.0,
        }
    }
}

impl Property {
    /// Passes over this property in a row.
    pub fn skip(&self, source: &mut impl Source) -> Result<(), Stop> {
        match self.kind {
            Type::Scalar(kind) => source.number(kind).map(|_| ()),
            Type::List { count, item } => {
                let count = source.count(count, item)?;
                (0..count).try_for_each(|_| source.number(item).map(|_| ()))
            }
        }
    }
}

impl Element {
    /// Room for the rows, but never more than so many bytes can hold.
    pub fn room(&self, bytes: usize) -> usize {
        let size = |p: &Property| match p.kind {
            Type::Scalar(kind) => kind.size(),
            Type::List { count, .. } => count.size(),
        };
        // The shortest number as text takes two bytes with its blank.
        let row: usize = self.properties.iter().map(|p| size(p).min(2)).sum();
        self.count.min((bytes / row.max(1)) as u64) as usize
    }
}

impl Header {
    /// Reads the header of a file.
    ///
    /// # Errors
    /// A statement that is not as it should be, or no end.
    pub fn read(bytes: &[u8], file: &str, warnings: &mut Warnings) -> Result<Header, ReadError> {
        let mut parser = Parser {
            words: Words::new(bytes, file),
            file,
            warnings,
            line: 1,
            encoding: None,
            header: Header {
                encoding: Encoding::Text,
                elements: Vec::new(),
                textures: Vec::new(),
                objects: Vec::new(),
                units: Units::default(),
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

struct Parser<'a> {
    words: Words<'a>,
    file: &'a str,
    warnings: &'a mut Warnings,
    line: u32,
    encoding: Option<Encoding>,
    header: Header,
}

impl Parser<'_> {
    fn statements(mut self) -> Result<Header, ReadError> {
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

    /// Comments without the word are not rare.
    fn unknown(&mut self) {
        let message = "line of the header that is no statement of PLY: skipped";
        let line = Position::Line(self.line, 1);
        self.warnings.add(self.file, message.into(), || line);
        self.words.rest_of_line();
    }

    /// The rows begin behind exactly one line end: their first byte may look like another.
    fn end(mut self, start: usize) -> Result<Header, ReadError> {
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
            b"ascii" => Encoding::Text,
            b"binary_little_endian" => Encoding::LittleEndian,
            b"binary_big_endian" => Encoding::BigEndian,
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
        }
    }

    /// What azulejo writes beside the format: names of objects, and units.
    fn info(&mut self) {
        let info = text(self.words.rest_of_line());
        let Some(info) = info.strip_prefix("azulejo ") else {
            return;
        };
        let units = &mut self.header.units;
        match info.split_once(' ').unwrap_or((info, "")) {
            ("object", name) => self.header.objects.push(name.trim().to_owned()),
            ("up", "z") => units.up = Up::Z,
            ("photometric", _) => units.photometric = true,
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
        match self.words.at_line_end() {
            true => &[],
            false => self.words.word().unwrap_or_default(),
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
        self.header.elements.push(Element {
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
            b"list" => Type::List {
                count: self.kind()?,
                item: self.kind()?,
            },
            word => match Kind::parse(word) {
                Some(kind) => Type::Scalar(kind),
                None => return Err(self.words.error(start, KINDS)),
            },
        };
        let name = text(self.words.rest_of_line()).into_owned();
        match self.header.elements.last_mut() {
            Some(element) => element.properties.push(Property { name, kind }),
            None => return Err(self.words.error(start, "an element before its properties")),
        }
        Ok(())
    }

    fn kind(&mut self) -> Result<Kind, ReadError> {
        self.words.skip_spaces();
        let start = self.words.offset();
        Kind::parse(self.word()).ok_or_else(|| self.words.error(start, KINDS))
    }
}

const KINDS: &str = "a kind of number (char, uchar, short, ushort, int, uint, float, double)";
