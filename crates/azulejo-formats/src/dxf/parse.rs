//! Converts the records of a file to a [`DxfDrawing`]: sections, tables, blocks.

use super::color::{Color, Paint};
use super::drawing::{Appearance, DxfBlock, DxfDrawing, Finish, Layer};
use super::ids::{AppearanceId, BlockId, LayerId, MODEL_SPACE};
use super::pairs::{Damage, Encoding};
use super::polyline::Polyline;
use super::record::{Record, Records};
use super::{camera, units};
use crate::reading::options::Budget;
use crate::reading::text::{shortened, text};
use crate::reading::warnings::Warnings;
use crate::{Position, ReadError, ReadOptions};
use std::collections::HashMap;

/// Parses the content of a file.
///
/// # Errors
/// A file without any section, and one whose curves have more segments than `options` allow.
pub(super) fn parse(
    bytes: &[u8],
    file: &str,
    options: &ReadOptions,
    warnings: &mut Warnings,
) -> Result<DxfDrawing, ReadError> {
    let mut parser = DxfParser::new(bytes, file, options, warnings);
    parser.records()?;
    parser.note_damage();
    if !parser.has_sections {
        return Err(parser.no_sections());
    }
    Ok(parser.drawing)
}

/// The current section, which determines the meaning of records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Section {
    /// None, only in damaged files: entities are read as in the ENTITIES section.
    None,
    Tables,
    Blocks,
    Entities,
    Objects,
    /// One without visible content.
    Other,
}

/// A drawing under construction.
pub(super) struct DxfParser<'a, 'w> {
    bytes: &'a [u8],
    source: Records<'a>,
    warnings: &'w mut Warnings,
    /// The drawing so far.
    pub drawing: DxfDrawing,
    section: Section,
    has_sections: bool,
    /// The block that is being read; none between blocks.
    block: Option<BlockId>,
    /// The POLYLINE that is being read.
    pub polyline: Option<Polyline>,
    /// The remaining budget for curves.
    pub budget: Budget,
    layers: IdsByName<'a, LayerId>,
    blocks: IdsByName<'a, BlockId>,
    appearances: HashMap<Appearance, AppearanceId>,
    last_look: Option<(Appearance, AppearanceId)>,
}

/// Ids by case-insensitive name.
#[derive(Debug)]
struct IdsByName<'a, Id> {
    /// The last name looked up: consecutive entities mostly share a layer.
    last: Option<(&'a [u8], Id)>,
    by_bytes: HashMap<&'a [u8], Id>,
    by_name: HashMap<String, Id>,
}

impl<'a, Id: Copy> IdsByName<'a, Id> {
    fn new() -> IdsByName<'a, Id> {
        IdsByName {
            last: None,
            by_bytes: HashMap::new(),
            by_name: HashMap::new(),
        }
    }

    /// The id of this name, created by `make` if it is new.
    fn find(&mut self, bytes: &'a [u8], make: impl FnOnce(&str) -> Id) -> Id {
        if let Some((last, id)) = self.last
            && last == bytes
        {
            return id;
        }
        let id = match self.by_bytes.get(bytes) {
            Some(&id) => id,
            None => {
                let name = super::record::decoded(bytes);
                let id = *self
                    .by_name
                    .entry(name.to_lowercase())
                    .or_insert_with(|| make(&name));
                self.by_bytes.insert(bytes, id);
                id
            }
        };
        self.last = Some((bytes, id));
        id
    }
}

impl<'a, 'w> DxfParser<'a, 'w> {
    fn new(
        bytes: &'a [u8],
        file: &str,
        options: &ReadOptions,
        warnings: &'w mut Warnings,
    ) -> DxfParser<'a, 'w> {
        DxfParser {
            bytes,
            source: Records::new(bytes),
            warnings,
            drawing: DxfDrawing {
                file: file.to_owned(),
                metres_per_unit: None,
                layers: Vec::new(),
                appearances: Vec::new(),
                blocks: vec![DxfBlock {
                    is_defined: true,
                    ..DxfBlock::default()
                }],
                finishes: HashMap::new(),
                cameras: Vec::new(),
            },
            section: Section::None,
            has_sections: false,
            block: Some(MODEL_SPACE),
            polyline: None,
            budget: Budget::new(options),
            layers: IdsByName::new(),
            blocks: IdsByName::new(),
            appearances: HashMap::new(),
            last_look: None,
        }
    }

    fn records(&mut self) -> Result<(), ReadError> {
        let mut record = Record::default();
        let mut has_end = false;
        while self.source.read(&mut record) {
            if record.kind == b"EOF" {
                has_end = true;
                break;
            }
            self.record(&record)?;
            let malformed = record.take_malformed();
            if malformed > 0 {
                let message = format!(
                    "{} with a number that is malformed or out of range: taken as missing",
                    shortened(&text(record.kind))
                );
                self.warn_many(message, malformed, record.offset);
            }
        }
        self.finish_polyline(false)?;
        if self.has_sections && !has_end {
            let end = self.bytes.len();
            self.warn(
                "the file ends without an EOF: what precedes the end is used",
                end,
            );
        }
        Ok(())
    }

    fn record(&mut self, record: &Record<'a>) -> Result<(), ReadError> {
        if self.polyline.is_some() && !matches!(record.kind, b"VERTEX" | b"SEQEND") {
            self.finish_polyline(false)?;
        }
        match (record.kind, self.section) {
            (b"SECTION", _) => self.begin_section(record),
            (b"ENDSEC", _) => (self.section, self.block) = (Section::None, Some(MODEL_SPACE)),
            (b"LAYER", Section::Tables) => self.layer_entry(record),
            (b"VIEW" | b"VPORT", Section::Tables) => self.view(record),
            (b"MATERIAL", Section::Objects) => self.material(record),
            (b"SUN", Section::Objects) => {
                self.warn("SUN: light that is not supported", record.offset)
            }
            (_, Section::Tables | Section::Objects | Section::Other) => {}
            (b"BLOCK", Section::Blocks) => self.begin_block(record),
            (b"ENDBLK", Section::Blocks) => self.block = None,
            (_, Section::Blocks | Section::Entities | Section::None) => return self.entity(record),
        }
        Ok(())
    }

    fn begin_section(&mut self, record: &Record) {
        self.has_sections = true;
        self.section = match record.bytes(2) {
            b"TABLES" => Section::Tables,
            b"BLOCKS" => Section::Blocks,
            b"ENTITIES" => Section::Entities,
            b"OBJECTS" => Section::Objects,
            b"HEADER" => {
                self.drawing.metres_per_unit = units::metres_per_unit(record);
                Section::Other
            }
            _ => Section::Other,
        };
        self.block = (self.section != Section::Blocks).then_some(MODEL_SPACE);
    }

    fn begin_block(&mut self, record: &Record<'a>) {
        const EXTERNAL: i64 = 4;
        const OVERLAID: i64 = 8;
        let id = self.block_id(record.bytes(2));
        self.block = Some(id);
        let name = record.text(2);
        let block = &mut self.drawing.blocks[id as usize];
        let was_defined = block.is_defined;
        let is_external = record.integer(70, 0) & (EXTERNAL | OVERLAID) != 0;
        *block = DxfBlock {
            // Anonymous blocks are named by programs, not by users.
            name: if name.starts_with('*') {
                String::new()
            } else {
                name.into_owned()
            },
            base: record.point(10),
            is_defined: true,
            external: is_external.then(|| record.text(1).into_owned()),
            ..DxfBlock::default()
        };
        if was_defined {
            self.warn(
                "BLOCK whose name is already defined: the later definition is used",
                record.offset,
            );
        }
    }

    /// The block that entities are added to.
    pub fn current(&mut self) -> Option<&mut DxfBlock> {
        self.block.map(|id| &mut self.drawing.blocks[id as usize])
    }

    /// The id of a block, defined or not yet.
    pub fn block_id(&mut self, name: &'a [u8]) -> BlockId {
        let list = &mut self.drawing.blocks;
        self.blocks.find(name, |name| {
            list.push(DxfBlock {
                name: name.to_owned(),
                ..DxfBlock::default()
            });
            (list.len() - 1) as BlockId
        })
    }

    /// The id of a layer.
    pub fn layer_id(&mut self, name: &'a [u8]) -> LayerId {
        // Entities without a layer are on the first one.
        let name = if name.is_empty() { b"0" } else { name };
        let list = &mut self.drawing.layers;
        self.layers.find(name, |name| {
            list.push(Layer::new(name.to_owned()));
            (list.len() - 1) as LayerId
        })
    }

    /// The appearance of an entity.
    pub fn appearance(&mut self, record: &Record<'a>) -> Appearance {
        Appearance {
            layer: self.layer_id(record.bytes(8)),
            color: Color::of(record),
            finish: record.handle(347),
        }
    }

    /// The id of an appearance.
    pub fn appearance_id(&mut self, appearance: Appearance) -> AppearanceId {
        if let Some((last, id)) = self.last_look
            && last == appearance
        {
            return id;
        }
        let list = &mut self.drawing.appearances;
        let id = *self.appearances.entry(appearance).or_insert_with(|| {
            list.push(appearance);
            (list.len() - 1) as AppearanceId
        });
        self.last_look = Some((appearance, id));
        id
    }

    fn layer_entry(&mut self, record: &Record<'a>) {
        const FROZEN: i64 = 1;
        let id = self.layer_id(record.bytes(2));
        let index = record.integer(62, 7);
        let indexed = || Paint::Index(index.unsigned_abs().clamp(1, 255) as u8);
        let paint = Paint::true_color(record, 420).unwrap_or_else(indexed);
        let layer = &mut self.drawing.layers[id as usize];
        layer.paint = paint;
        layer.finish = record.handle(347);
        layer.is_off = index < 0;
        layer.is_frozen = record.integer(70, 0) & FROZEN != 0;
    }

    fn view(&mut self, record: &Record) {
        self.drawing.cameras.extend(camera::camera(record));
    }

    fn material(&mut self, record: &Record) {
        let (finish, losses) = Finish::read(record);
        self.drawing.finishes.insert(record.handle(5), finish);
        for lost in losses {
            self.warn(format!("MATERIAL with {lost}: not used"), record.offset);
        }
    }

    /// Counts a warning.
    pub fn warn(&mut self, message: impl Into<String>, offset: usize) {
        self.warn_many(message.into(), 1, offset);
    }

    /// Counts a warning several times.
    pub fn warn_many(&mut self, message: String, count: usize, offset: usize) {
        let (bytes, encoding) = (self.bytes, self.source.pairs.encoding);
        self.warnings
            .add_many(&self.drawing.file, message, count, || {
                position(bytes, encoding, offset)
            });
    }

    fn note_damage(&mut self) {
        let pairs = &self.source.pairs;
        let (mark_is_damaged, damage) = (pairs.mark_is_damaged, pairs.damage);
        let is_text = pairs.encoding == Encoding::Text;
        let rest = pairs.rest().iter().take_while(|b| !matches!(b, 0x1a));
        let has_rest = rest.clone().any(|b| !b.is_ascii_whitespace() && *b != 0);
        let end = pairs.offset();
        if mark_is_damaged {
            self.warn("the header of the binary file lost a byte, as in transfers as text: numbers may be wrong", 0);
        }
        match damage {
            Some(Damage { offset, count }) if is_text => {
                let message = "line that should be a group code but is not: skipped";
                self.warn_many(message.to_owned(), count, offset);
            }
            Some(Damage { offset, .. }) => {
                self.warn("unknown group code: the rest is not read", offset)
            }
            None => {}
        }
        if self.has_sections && has_rest {
            self.warn("data after the EOF is not read", end);
        }
    }

    fn no_sections(&self) -> ReadError {
        let expected = "a section: a line 0 and a line SECTION";
        let (file, found) = (&self.drawing.file, "a file without any section");
        match self.source.pairs.encoding {
            Encoding::Text => ReadError::at_line(file, &text(self.bytes), 1, 1, found, expected),
            _ => ReadError::at_byte(file, 0, found, expected),
        }
    }
}

/// The position of an offset, for messages.
pub(super) fn position(bytes: &[u8], encoding: Encoding, offset: usize) -> Position {
    if encoding != Encoding::Text {
        return Position::Byte(offset as u64);
    }
    let before = &bytes[..offset.min(bytes.len())];
    let feeds = before.iter().filter(|b| **b == b'\n').count();
    // Files of old Macintosh computers have only carriage returns.
    let ends = match feeds {
        0 => before.iter().filter(|b| **b == b'\r').count(),
        _ => feeds,
    };
    Position::Line(ends as u32 + 1, 1)
}
