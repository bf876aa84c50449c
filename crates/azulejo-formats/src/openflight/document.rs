//! One file: its records as a tree, and its palettes.

use super::fields::RecordFields;
use super::opcode::{self, OpcodeRole};
use super::palettes::{self, Palettes};
use super::vertices::VertexPalette;
use crate::reading::warnings::Warnings;
use crate::{Position, ReadError};
use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;
use std::rc::Rc;

/// A file of 4 GiB or more has offsets that its own fields cannot represent.
const LARGEST: u64 = u32::MAX as u64;

/// Maximum number of ancillary records examined per node: only five types are used, one of them several times.
const MOST_ANCILLARY: usize = 32;

/// A record that is kept. Everything between it and `end` belongs to it: first its ancillary
/// records, then its children, each followed by its own.
#[derive(Clone, Copy, Debug)]
pub(super) struct FltNode {
    pub opcode: u16,
    /// Offset of the record in the file.
    pub at: u32,
    /// The first node that does not belong to it.
    pub end: u32,
}

/// A file whose records have been located, but not interpreted.
#[derive(Debug)]
pub(super) struct FltDocument<'a> {
    /// Its name in messages.
    pub file: Rc<str>,
    bytes: Cow<'a, [u8]>,
    /// Records joined with their continuations, by offset.
    continued: HashMap<u32, Vec<u8>>,
    pub nodes: Vec<FltNode>,
    /// The nodes of instance definitions, by number.
    pub definitions: HashMap<u16, u32>,
    /// The revision in hundredths: 1420 for 14.2.
    pub revision: u32,
    /// Whether all colours are packed colours.
    pub packed_colors: bool,
    pub metres_per_unit: Option<f64>,
    pub palettes: Palettes,
    pub vertices: VertexPalette,
}

impl<'a> FltDocument<'a> {
    /// Locates the records of a file. `path` is its name relative to the root model, empty for the
    /// root model itself.
    ///
    /// # Errors
    /// Bytes that do not begin with a header; 4 GiB or more.
    pub fn parse(
        bytes: Cow<'a, [u8]>,
        file: &str,
        path: &str,
        warnings: &mut Warnings,
    ) -> Result<FltDocument<'a>, ReadError> {
        let header = check_header(&bytes, file)?;
        let revision = revision(header);
        let metres_per_unit = metres_per_unit(header);
        let packed_colors = header.u32(64).is_some_and(|flags| flags & 1 << 30 != 0);
        let document = FltDocument {
            file: file.into(),
            bytes,
            continued: HashMap::new(),
            nodes: Vec::new(),
            definitions: HashMap::new(),
            revision,
            packed_colors,
            metres_per_unit,
            palettes: Palettes::default(),
            vertices: VertexPalette::default(),
        };
        let mut scan = RecordScan {
            document,
            path: path.into(),
            warnings,
            open: Vec::new(),
            current: None,
            at: 0,
        };
        scan.header();
        while scan.record() {}
        Ok(scan.finish())
    }

    /// The fields of the record at offset `at`, with its continuations.
    pub fn fields(&self, at: u32) -> RecordFields<'_> {
        if let Some(joined) = self.continued.get(&at) {
            return RecordFields(joined);
        }
        let rest = self.bytes.get(at as usize..).unwrap_or_default();
        let length = RecordFields(rest).u16(2).unwrap_or_default();
        RecordFields(&rest[..rest.len().min(length.into())])
    }

    /// The fields of a node.
    pub fn node(&self, node: u32) -> RecordFields<'_> {
        self.fields(self.nodes[node as usize].at)
    }

    /// Length of the file in bytes.
    pub fn size(&self) -> u64 {
        self.bytes.len() as u64
    }

    /// What belongs to a node: ancillary records and children.
    pub fn below(&self, node: u32) -> Siblings<'_> {
        self.siblings(node + 1..self.nodes[node as usize].end)
    }

    /// The top-level nodes.
    pub fn top(&self) -> Siblings<'_> {
        self.siblings(0..self.nodes.len() as u32)
    }

    fn siblings(&self, range: Range<u32>) -> Siblings<'_> {
        Siblings {
            nodes: &self.nodes,
            range,
        }
    }

    /// An ancillary record of a node.
    pub fn ancillary(&self, node: u32, opcode: u16) -> Option<RecordFields<'_>> {
        self.ancillaries(node, opcode).next()
    }

    /// All ancillary records of a node with an opcode.
    pub fn ancillaries(&self, node: u32, opcode: u16) -> impl Iterator<Item = RecordFields<'_>> {
        self.below(node)
            .take(MOST_ANCILLARY)
            .take_while(|(_, n)| OpcodeRole::of(n.opcode) == OpcodeRole::Ancillary)
            .filter(move |(_, n)| n.opcode == opcode)
            .map(|(_, n)| self.fields(n.at))
    }

    /// A node's name: its long ID if it has one, otherwise its ID.
    pub fn name(&self, node: u32) -> String {
        use opcode::*;
        if let Some(long) = self.ancillary(node, LONG_ID) {
            return long.text(4, long.0.len());
        }
        match self.nodes[node as usize].opcode {
            INSTANCE_REFERENCE..=EXTERNAL_REFERENCE | VERTEX_LIST | MESH_PRIMITIVE => String::new(),
            _ => self.node(node).text(4, 8),
        }
    }
}

/// Consecutive siblings in the tree, with their indices.
#[derive(Clone, Debug)]
pub(super) struct Siblings<'a> {
    nodes: &'a [FltNode],
    range: Range<u32>,
}

impl Iterator for Siblings<'_> {
    type Item = (u32, FltNode);

    fn next(&mut self) -> Option<(u32, FltNode)> {
        let index = self.range.start;
        if index >= self.range.end {
            return None;
        }
        let node = self.nodes[index as usize];
        self.range.start = node.end;
        Some((index, node))
    }
}

fn check_header<'b>(bytes: &'b [u8], file: &str) -> Result<RecordFields<'b>, ReadError> {
    let fields = RecordFields(bytes);
    let expected = "a header record: opcode 1 and a length of at least 16";
    let (found, length) = match (fields.u16(0), fields.u16(2)) {
        _ if bytes.len() as u64 >= LARGEST => {
            let expected = format!("fewer than {LARGEST}");
            let found = format!("{} bytes", bytes.len());
            return Err(ReadError::whole(file, found, expected));
        }
        (Some(opcode::HEADER), Some(length)) if length >= 16 => {
            if let Some(header) = bytes.get(..length.into()) {
                return Ok(RecordFields(header));
            }
            ("a header of", format!("{length} bytes, truncated"))
        }
        (Some(opcode), Some(length)) => ("opcode", format!("{opcode} and length {length}")),
        _ => ("the end", "of the file".to_owned()),
    };
    Err(ReadError::at_byte(
        file,
        0,
        format!("{found} {length}"),
        expected,
    ))
}

/// Old files store 14, later ones 1420.
fn revision(header: RecordFields) -> u32 {
    match header.u32(12).unwrap_or_default() {
        small @ 0..100 => small * 100,
        revision => revision,
    }
}

fn metres_per_unit(header: RecordFields) -> Option<f64> {
    match header.u8(62)? {
        0 => Some(1.0),
        1 => Some(1000.0),
        4 => Some(0.3048),
        5 => Some(0.0254),
        8 => Some(1852.0),
        _ => None,
    }
}

/// A pass over the records of a file.
struct RecordScan<'a, 'w> {
    document: FltDocument<'a>,
    path: Rc<str>,
    warnings: &'w mut Warnings,
    /// The nodes whose children are being read.
    open: Vec<u32>,
    /// The latest node on this level.
    current: Option<u32>,
    at: usize,
}

impl<'a> RecordScan<'a, '_> {
    #[cold]
    fn warn(&mut self, message: String) {
        let at = self.at as u64;
        let file = &self.document.file;
        self.warnings.add(file, message, || Position::Byte(at));
    }

    fn header(&mut self) {
        if self.document.revision < 1400 {
            let revision = f64::from(self.document.revision) / 100.0;
            self.warn(format!(
                "revision {revision}: colours and vertices before revision 14 have other formats, which are not supported"
            ));
        }
        if self.document.metres_per_unit.is_none() {
            self.warn("unknown unit of length: not used".into());
        }
    }

    /// Reads a record; `false` at the end.
    fn record(&mut self) -> bool {
        let rest = &self.document.bytes[self.at..];
        let (Some(opcode), Some(length)) = (RecordFields(rest).u16(0), RecordFields(rest).u16(2))
        else {
            if !rest.is_empty() {
                self.warn(format!(
                    "{} bytes after the last record: skipped",
                    rest.len()
                ));
            }
            return false;
        };
        let left = rest.len();
        if length < 4 || usize::from(length) > left {
            // Some writers pad a file with zeros.
            if rest.iter().all(|b| *b == 0) {
                return false;
            }
            let name = opcode::name(opcode);
            self.warn(format!(
                "damaged: {name} (opcode {opcode}) with a length of {length} bytes, but only {left} left; \
                 the rest of the file is skipped"
            ));
            return false;
        }
        let next = self.continuations(self.at + usize::from(length));
        self.take(opcode);
        self.at = next;
        true
    }

    /// Joins the continuation records that follow to the record before them; returns their end.
    fn continuations(&mut self, end: usize) -> usize {
        let mut next = end;
        while let Some(piece) = self.continuation(next) {
            next += piece.len() + 4;
        }
        if next > end {
            let mut joined = self.document.bytes[self.at..end].to_vec();
            let mut at = end;
            while at < next {
                let piece = self.continuation(at).unwrap_or_default();
                joined.extend_from_slice(piece);
                at += piece.len() + 4;
            }
            self.document.continued.insert(self.at as u32, joined);
        }
        next
    }

    /// The content of a continuation record at `at`.
    fn continuation(&self, at: usize) -> Option<&[u8]> {
        let fields = RecordFields(self.document.bytes.get(at..)?);
        let length = usize::from(fields.u16(2)?);
        let is_one = fields.u16(0) == Some(opcode::CONTINUATION);
        is_one.then(|| fields.0.get(4..length)).flatten()
    }

    fn take(&mut self, opcode: u16) {
        match OpcodeRole::of(opcode) {
            OpcodeRole::Push => self.push(),
            OpcodeRole::Pop => self.pop(),
            OpcodeRole::Node => self.node(opcode),
            OpcodeRole::Ancillary => {
                self.add(opcode);
            }
            OpcodeRole::Palette => self.palette(opcode),
            OpcodeRole::Silent => {}
            OpcodeRole::Skipped => {
                let name = opcode::name(opcode);
                self.warn(format!("{name} (opcode {opcode}): skipped"));
            }
        }
    }

    /// Adds a node, which has no descendants yet.
    fn add(&mut self, opcode: u16) -> u32 {
        let index = self.document.nodes.len() as u32;
        self.document.nodes.push(FltNode {
            opcode,
            at: self.at as u32,
            end: index + 1,
        });
        index
    }

    fn node(&mut self, opcode: u16) {
        self.close();
        let index = self.add(opcode);
        self.current = Some(index);
        if opcode == opcode::INSTANCE_DEFINITION {
            let number = self.document.node(index).u16(6).unwrap_or_default();
            self.document.definitions.insert(number, index);
        }
    }

    /// Assigns everything since the latest node on this level to it.
    fn close(&mut self) {
        if let Some(node) = self.current {
            self.document.nodes[node as usize].end = self.document.nodes.len() as u32;
        }
    }

    fn push(&mut self) {
        if let Some(node) = self.current.take() {
            self.open.push(node);
        } else {
            // The matching pop needs a node to end.
            let node = self.add(opcode::GROUP);
            self.warn("push without a node before it: taken as an unnamed group".into());
            self.open.push(node);
        }
    }

    fn pop(&mut self) {
        if self.open.is_empty() {
            return self.warn("pop without a push: skipped".into());
        }
        self.close();
        self.current = self.open.pop();
    }

    fn palette(&mut self, opcode: u16) {
        use opcode::*;
        let (at, revision) = (self.at as u32, self.document.revision);
        let record = self.document.fields(at);
        match opcode {
            COLOR_PALETTE => {
                let colors = palettes::colors(record, revision);
                self.document.palettes.colors = Rc::new(colors);
            }
            OLD_MATERIAL_PALETTE => {
                let materials = palettes::old_materials(record).collect();
                self.document.palettes.materials = Rc::new(materials);
            }
            MATERIAL_PALETTE => {
                let entry = palettes::material(record);
                self.insert(entry, |palettes| &mut palettes.materials);
            }
            TEXTURE_PALETTE => {
                let entry = palettes::texture(record, revision, &self.path);
                self.insert(entry, |palettes| &mut palettes.textures);
            }
            LIGHT_SOURCE_PALETTE => {
                let entry = palettes::light(record);
                self.insert(entry, |palettes| &mut palettes.lights);
            }
            VERTEX_PALETTE => {
                if !self.document.vertices.begin(at) {
                    self.warn("second vertex palette: skipped".into());
                }
            }
            _ => {
                if !self.document.vertices.add(at) {
                    self.warn("vertex outside the vertex palette: skipped".into());
                }
            }
        }
    }

    /// Inserts an entry into a palette.
    fn insert<T: Clone>(
        &mut self,
        entry: Option<(i32, T)>,
        palette: impl Fn(&mut Palettes) -> &mut Rc<HashMap<i32, T>>,
    ) {
        if let Some((index, entry)) = entry {
            let palette = Rc::make_mut(palette(&mut self.document.palettes));
            palette.insert(index, entry);
        } else {
            self.warn("palette entry that is too short: skipped".into());
        }
    }

    fn finish(mut self) -> FltDocument<'a> {
        if !self.open.is_empty() {
            let levels = self.open.len();
            self.warn(format!(
                "the file ends inside {levels} nested levels: closed"
            ));
        }
        while !self.open.is_empty() {
            self.pop();
        }
        self.close();
        self.document
    }
}
