//! External references: files that a file refers to.

use super::document::FltDocument;
use super::opcode;
use super::part::VertexSlot;
use super::transform::InheritedState;
use super::walk::{BYTES_PER_ELEMENT, FltSource, FltWalker, NodeVisit};
use crate::reading::files::beside;
use crate::reading::text::shortened;
use crate::reading::warnings::Warnings;
use crate::surface::textures::normalized_path;
use crate::{FileError, Files, Position, ReadError};
use glam::{DAffine3, DVec3};
use std::borrow::Cow;
use std::collections::HashMap;
use std::rc::Rc;

/// Maximum depth of nested files.
const MOST_OPEN: usize = 16;

/// The external files, each read once.
pub(super) struct ExternalFiles<'f> {
    files: &'f dyn Files,
    known: HashMap<String, Result<Rc<ExternalFile>, ExternalProblem>>,
    /// Names of the files being traversed, the root model first, in lower case.
    open: Vec<String>,
    bytes_left: u64,
}

/// A file that has been read.
pub(super) struct ExternalFile {
    document: FltDocument<'static>,
    number: usize,
}

/// Why a file is skipped.
#[derive(Clone, Debug)]
enum ExternalProblem {
    /// It was not found at this path.
    Elsewhere(String),
    /// Any other error.
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
            let message = "the external files exceed the size limit (ReadOptions::most_unpacked)";
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

/// Splits a reference into the path, and the node name in `<>` after it.
fn split(reference: &str) -> (&str, Option<&str>) {
    match reference.split_once('<') {
        Some((path, node)) => (path.trim(), Some(node.trim_end_matches('>'))),
        None => (reference, None),
    }
}

impl FltWalker<'_> {
    /// Adds the content of an external reference.
    pub fn external(&mut self, visit: NodeVisit) -> Result<(), ReadError> {
        let (source, record) = (visit.source, visit.record());
        let reference = record.text(4, 200);
        let (name, part) = split(&reference);
        let (path, external) = match self.find(source, name) {
            Ok(external) => external,
            Err(why) => {
                let message = format!("file \"{}\" skipped: {why}", shortened(name));
                self.notes(visit).add(message);
                return Ok(());
            }
        };
        // Before revision 14.2, each file had its own palettes.
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
            1.0 => visit.place,
            _ => visit.place.then(&DAffine3::from_scale(DVec3::splat(scale))),
        };
        self.externals.open.push(path.to_lowercase());
        let done = match part {
            None => self.top(inner, place),
            Some(part) => self.named(inner, part, place),
        };
        self.externals.open.pop();
        done
    }

    /// The file with this name: looked up by its full path, otherwise without its folders, which
    /// may be those of the author's machine.
    fn find(
        &mut self,
        source: FltSource,
        name: &str,
    ) -> Result<(String, Rc<ExternalFile>), String> {
        if self.externals.open.len() == MOST_OPEN {
            return Err(format!("files nested more than {MOST_OPEN} deep"));
        }
        let name = &normalized_path(name);
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
            Ok(file) => Ok(file),
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

    /// Adds the first node with this name.
    fn named(
        &mut self,
        source: FltSource,
        name: &str,
        place: InheritedState,
    ) -> Result<(), ReadError> {
        let document = source.document;
        // The name of each node is compared.
        self.spend(document.nodes.len() as u64 + document.size() / BYTES_PER_ELEMENT)?;
        let is_it = |&index: &u32| {
            let opcode = document.nodes[index as usize].opcode;
            opcode::OpcodeRole::of(opcode) == opcode::OpcodeRole::Node
                && document.name(index) == name
        };
        if let Some(node) = (0..document.nodes.len() as u32).find(is_it) {
            return self.one(NodeVisit {
                source,
                node,
                place,
            });
        }
        let message = format!("no node named \"{}\": skipped", shortened(name));
        self.warnings
            .add(&document.file, message, || Position::Byte(0));
        Ok(())
    }
}

/// The ratio of the inner file's unit of length to that of the outer one; 1 if one of them is
/// unknown.
fn scale(inner: &FltDocument, outer: &FltDocument) -> f64 {
    match (inner.metres_per_unit, outer.metres_per_unit) {
        (Some(inner), Some(outer)) => inner / outer,
        _ => 1.0,
    }
}
