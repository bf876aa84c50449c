//! Files that a file refers to.

use super::document::FltDocument;
use super::opcode;
use super::part::VertexSlot;
use super::transform::InheritedState;
use super::walk::{BYTES_PER_ELEMENT, FltSource, FltWalker};
use crate::reading::files::beside;
use crate::reading::text::shortened;
use crate::reading::warnings::Warnings;
use crate::surface::textures::one_spelling;
use crate::{FileError, Files, Position, ReadError};
use glam::{DAffine3, DVec3};
use std::borrow::Cow;
use std::collections::HashMap;
use std::rc::Rc;

/// Most files inside each other.
const MOST_OPEN: usize = 16;

/// The files that have been referred to, each read once.
pub(super) struct ExternalFiles<'f> {
    files: &'f dyn Files,
    known: HashMap<String, Result<Rc<ExternalFile>, ExternalProblem>>,
    /// Names of the files that are being drawn, the root model first, without capitals.
    open: Vec<String>,
    bytes_left: u64,
}

/// A file that has been read.
pub(super) struct ExternalFile {
    document: FltDocument<'static>,
    number: usize,
}

/// Why a file is left out.
#[derive(Clone, Debug)]
enum ExternalProblem {
    /// It is not where it was looked for.
    Elsewhere(String),
    /// Something else is wrong.
    Other(String),
}

impl<'f> ExternalFiles<'f> {
    pub fn new(files: &'f dyn Files, root: &str, most_bytes: u64) -> ExternalFiles<'f> {
        let root = root.rsplit(['/', '\\']).next().unwrap_or(root);
        ExternalFiles {
            files,
            known: HashMap::new(),
            open: vec![root.to_lowercase()],
            bytes_left: most_bytes,
        }
    }

    fn read(&mut self, path: &str) -> Result<Vec<u8>, ExternalProblem> {
        let bytes = self.files.read(path).map_err(|e| match e {
            FileError::Missing | FileError::Outside => ExternalProblem::Elsewhere(e.to_string()),
            _ => ExternalProblem::Other(e.to_string()),
        })?;
        let left = self.bytes_left.checked_sub(bytes.len() as u64);
        self.bytes_left = left.ok_or_else(|| {
            let message =
                "the files referred to have more bytes than allowed (ReadOptions::most_unpacked)";
            ExternalProblem::Other(message.into())
        })?;
        Ok(bytes)
    }

    fn load(
        &mut self,
        path: &str,
        slots: &mut Vec<Vec<VertexSlot>>,
        warnings: &mut Warnings,
    ) -> Result<Rc<ExternalFile>, ExternalProblem> {
        if let Some(known) = self.known.get(path) {
            return known.clone();
        }
        let read = self.read(path).and_then(|bytes| {
            let parsed = FltDocument::parse(Cow::Owned(bytes), path, path, warnings);
            let document = parsed.map_err(|e| ExternalProblem::Other(e.to_string()))?;
            let number = slots.len();
            slots.push(vec![VertexSlot::default(); document.vertices.len()]);
            Ok(Rc::new(ExternalFile { document, number }))
        });
        self.known.insert(path.to_owned(), read.clone());
        read
    }
}

/// A path, and the name of the node that stands in `<>` behind it.
fn split(reference: &str) -> (&str, Option<&str>) {
    match reference.split_once('<') {
        Some((path, node)) => (path.trim(), Some(node.trim_end_matches('>'))),
        None => (reference, None),
    }
}

impl FltWalker<'_> {
    /// Draws the file that an external reference names.
    pub fn external(
        &mut self,
        source: FltSource,
        node: u32,
        place: &InheritedState,
    ) -> Result<(), ReadError> {
        let record = source.document.node(node);
        let reference = record.text(4, 200);
        let (name, part) = split(&reference);
        let (path, external) = match self.find(source, name) {
            Ok(found) => found,
            Err(why) => {
                let message = format!("\"{}\" is left out: {why}", shortened(name));
                self.notes(source, node).add(message);
                return Ok(());
            }
        };
        // Before revision 14.2 each file had its own palettes.
        let flags = match source.document.revision {
            ..1420 => None,
            _ => record.u32(208),
        };
        let document = &external.document;
        let palettes = document
            .palettes
            .under(source.palettes, flags.unwrap_or(u32::MAX));
        self.sets += 1;
        let scale = scale(document, source.document);
        let inner = FltSource {
            document,
            number: external.number,
            path: &path,
            palettes: &palettes,
            set: self.sets,
            scale: source.scale * scale,
        };
        let place = match scale {
            1.0 => *place,
            _ => place.then(&DAffine3::from_scale(DVec3::splat(scale))),
        };
        self.externals.open.push(path.to_lowercase());
        let done = match part {
            None => self.top(inner, &place),
            Some(part) => self.named(inner, part, &place),
        };
        self.externals.open.pop();
        done
    }

    /// The file of that name: where the name says, or else without its folders, which may be
    /// those of its author's machine.
    fn find(
        &mut self,
        source: FltSource,
        name: &str,
    ) -> Result<(String, Rc<ExternalFile>), String> {
        if self.externals.open.len() == MOST_OPEN {
            return Err(format!("more than {MOST_OPEN} files inside each other"));
        }
        let name = &one_spelling(name);
        let base = name.rsplit('/').next().unwrap_or(name);
        let path = beside(source.path, name);
        match self.open(path) {
            Err(ExternalProblem::Elsewhere(why)) if base != name => {
                let other = self.open(beside(source.path, base));
                other.map_err(|e| match e {
                    ExternalProblem::Elsewhere(_) => why,
                    ExternalProblem::Other(why) => why,
                })
            }
            Err(ExternalProblem::Elsewhere(why) | ExternalProblem::Other(why)) => Err(why),
            Ok(found) => Ok(found),
        }
    }

    fn open(&mut self, path: String) -> Result<(String, Rc<ExternalFile>), ExternalProblem> {
        if self.externals.open.contains(&path.to_lowercase()) {
            return Err(ExternalProblem::Other("it refers to itself".into()));
        }
        let (slots, warnings) = (&mut self.slots, &mut self.warnings);
        let external = self.externals.load(&path, slots, warnings)?;
        Ok((path, external))
    }

    /// Draws the first node of that name.
    fn named(
        &mut self,
        source: FltSource,
        name: &str,
        place: &InheritedState,
    ) -> Result<(), ReadError> {
        let document = source.document;
        // Each of them is asked for its name.
        self.spend(document.nodes.len() as u64 + document.size() / BYTES_PER_ELEMENT)?;
        let is_it = |&index: &u32| {
            let opcode = document.nodes[index as usize].opcode;
            opcode::OpcodeRole::of(opcode) == opcode::OpcodeRole::Node
                && document.name(index) == name
        };
        if let Some(node) = (0..document.nodes.len() as u32).find(is_it) {
            return self.one(source, node, place);
        }
        let message = format!("no node of the name \"{}\": left out", shortened(name));
        self.warnings
            .add(&document.file, message, || Position::Byte(0));
        Ok(())
    }
}

/// Length of an inner file's unit in units of the outer; 1 if one of them does not say.
fn scale(inner: &FltDocument, outer: &FltDocument) -> f64 {
    match (inner.metres_per_unit, outer.metres_per_unit) {
        (Some(inner), Some(outer)) => inner / outer,
        _ => 1.0,
    }
}
