//! Traverses the tree of records and builds the scene.

use super::document::{FltDocument, FltNode, Siblings};
use super::external::ExternalFiles;
use super::fields::RecordFields;
use super::materials::FltMaterials;
use super::opcode::{self, OpcodeRole};
use super::palettes::Palettes;
use super::part::{FltPart, VertexSlot};
use super::select::{ChildSelection, has_current_mask};
use super::transform::{self, InheritedState};
use super::warn::RecordWarnings;
use crate::reading::options::Budget;
use crate::reading::warnings::Warnings;
use crate::{Files, Lod, ReadError, ReadOptions};
use azulejo_scene::{Object, Scene, Shape};
use glam::DAffine3;

/// Maximum depth of nested nodes, instances and files.
const MOST_LEVELS: u32 = 128;

/// This many bytes of names count as one element of the budget.
pub(super) const BYTES_PER_ELEMENT: u64 = 64;

/// A file in the context of the reference to it.
#[derive(Clone, Copy)]
pub(super) struct FltSource<'d> {
    pub document: &'d FltDocument<'d>,
    /// Unique among documents.
    pub number: usize,
    /// Its name relative to the root model; empty for the root model.
    pub path: &'d str,
    pub palettes: &'d Palettes,
    /// Unique among sets of palettes.
    pub set: u32,
    /// Length of a unit in units of the root model.
    pub scale: f64,
}

/// A node, with the file that it is in and what it inherits from the nodes above.
#[derive(Clone, Copy)]
pub(super) struct NodeVisit<'d> {
    pub source: FltSource<'d>,
    pub node: u32,
    pub place: InheritedState,
}

impl<'d> NodeVisit<'d> {
    /// Another node that inherits the same.
    pub fn with(self, node: u32) -> NodeVisit<'d> {
        NodeVisit { node, ..self }
    }

    /// The same node with a transform of its own.
    fn moved(self, map: &DAffine3) -> NodeVisit<'d> {
        let place = self.place.then(map);
        NodeVisit { place, ..self }
    }

    pub fn opcode(&self) -> u16 {
        self.source.document.nodes[self.node as usize].opcode
    }

    pub fn record(&self) -> RecordFields<'d> {
        self.source.document.node(self.node)
    }
}

/// The scene under construction, and the state of the traversal.
pub(super) struct FltWalker<'f> {
    pub name: &'f str,
    pub options: &'f ReadOptions,
    pub budget: Budget,
    pub warnings: Warnings,
    pub materials: FltMaterials<'f>,
    pub scene: Scene,
    pub externals: ExternalFiles<'f>,
    /// Names of the nodes above, joined by `/`.
    pub path: String,
    /// For each document, the vertices made from those of its palette.
    pub slots: Vec<Vec<VertexSlot>>,
    pub stamps: u32,
    pub sets: u32,
    levels: u32,
    /// Instances being traversed: numbers of document and definition.
    instances: Vec<(usize, u16)>,
}

impl<'f> FltWalker<'f> {
    pub fn new(
        name: &'f str,
        files: &'f dyn Files,
        options: &'f ReadOptions,
        warnings: Warnings,
    ) -> FltWalker<'f> {
        FltWalker {
            name,
            options,
            budget: Budget::new(options),
            warnings,
            materials: FltMaterials::new(files),
            scene: Scene::default(),
            externals: ExternalFiles::new(files, name, options.most_unpacked),
            path: String::new(),
            slots: Vec::new(),
            stamps: 0,
            sets: 0,
            levels: 0,
            instances: Vec::new(),
        }
    }

    /// Takes elements from the budget.
    pub fn spend(&mut self, elements: u64) -> Result<(), ReadError> {
        self.budget.spend(elements).map_err(|e| e.error(self.name))
    }

    /// A collector of warnings about a node.
    pub fn notes<'n>(&'n mut self, visit: NodeVisit<'n>) -> RecordWarnings<'n> {
        RecordWarnings::new(&mut self.warnings, visit.source.document, visit.node)
    }

    /// Counts a warning about a node, of which nothing else is read.
    fn skip(&mut self, visit: NodeVisit, message: impl Into<String>) -> Result<(), ReadError> {
        self.notes(visit).add(message);
        Ok(())
    }

    /// Runs a step one level deeper.
    pub fn deeper(
        &mut self,
        visit: NodeVisit,
        inside: impl FnOnce(&mut Self) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        if self.levels == MOST_LEVELS {
            let document = visit.source.document;
            let at = document.nodes[visit.node as usize].at.into();
            let found = format!("nodes nested more than {MOST_LEVELS} deep");
            return Err(ReadError::at_byte(&*document.file, at, found, "fewer"));
        }
        self.levels += 1;
        let done = inside(self);
        self.levels -= 1;
        done
    }

    /// Adds the top-level nodes of a file.
    pub fn top(&mut self, source: FltSource, place: InheritedState) -> Result<(), ReadError> {
        self.siblings(source, None, source.document.top(), place)
    }

    /// Adds a single node.
    pub fn one(&mut self, visit: NodeVisit) -> Result<(), ReadError> {
        match visit.opcode() {
            opcode::FACE | opcode::MESH => {
                let mut part = FltPart::default();
                self.surface(visit, &mut part)?;
                self.finish(part)
            }
            _ => self.node(visit),
        }
    }

    /// Adds the children of a node.
    fn children(&mut self, visit: NodeVisit) -> Result<(), ReadError> {
        let document = visit.source.document;
        let parent = document.nodes[visit.node as usize];
        if self.options.lod == Lod::Coarsest {
            // Whether a level of detail is empty is found by scanning it.
            self.spend(u64::from(parent.end - visit.node))?;
        }
        let children = document.below(visit.node);
        self.siblings(visit.source, Some(parent), children, visit.place)
    }

    fn siblings(
        &mut self,
        source: FltSource,
        parent: Option<FltNode>,
        siblings: Siblings,
        place: InheritedState,
    ) -> Result<(), ReadError> {
        let (lod, document) = (self.options.lod, source.document);
        let selection = ChildSelection::new(document, parent, siblings.clone(), lod, source.scale);
        let (mut part, mut position) = (FltPart::default(), 0);
        for (child, node) in siblings {
            self.spend(1)?;
            if OpcodeRole::of(node.opcode) != OpcodeRole::Node {
                continue;
            }
            let left_out = selection.leaves_out(document, position, node);
            position += 1;
            let visit = NodeVisit {
                source,
                node: child,
                place,
            };
            match (left_out, node.opcode) {
                (Some(why), _) => self.notes(visit).add(why),
                (None, opcode::FACE | opcode::MESH) => self.surface(visit, &mut part)?,
                (None, _) => self.node(visit)?,
            }
        }
        self.finish(part)
    }

    /// Makes an object of the faces found below one node.
    fn finish(&mut self, part: FltPart) -> Result<(), ReadError> {
        if let Some(mesh) = part.finish() {
            let object = Object::new(self.full_name()?, Shape::Mesh(mesh));
            if self.budget.keeps() {
                self.scene.objects.push(object);
            }
        }
        Ok(())
    }

    /// The names of all nodes above. A long name above many objects is copied to each.
    pub fn full_name(&mut self) -> Result<String, ReadError> {
        self.spend(self.path.len() as u64 / BYTES_PER_ELEMENT)?;
        Ok(self.path.clone())
    }

    /// Adds a node that is not a face, and its descendants.
    pub fn node(&mut self, visit: NodeVisit) -> Result<(), ReadError> {
        let outer = self.path.len();
        if visit.opcode() != opcode::HEADER {
            let name = visit.source.document.name(visit.node);
            self.spend(name.len() as u64 / BYTES_PER_ELEMENT)?;
            self.enter(&name);
        }
        let done = self.deeper(visit, |walker| {
            walker.each_copy(visit, |walker, copy| walker.inside(copy))
        });
        self.path.truncate(outer);
        done
    }

    /// Adds a name to the path of those above.
    fn enter(&mut self, name: &str) {
        if !name.is_empty() && !self.path.is_empty() {
            self.path.push('/');
        }
        self.path.push_str(name);
    }

    /// Runs a step for each copy of a node: once with its matrix, or, if the node is replicated,
    /// without the matrix and then with its powers.
    pub fn each_copy(
        &mut self,
        visit: NodeVisit,
        mut draw: impl FnMut(&mut Self, NodeVisit) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        let (document, node) = (visit.source.document, visit.node);
        let copies = document.ancillary(node, opcode::REPLICATE);
        let copies = copies.and_then(|r| r.i16(4)).unwrap_or_default();
        let record = document.ancillary(node, opcode::MATRIX);
        let matrix = record.and_then(transform::matrix);
        if record.is_some() && matrix.is_none() {
            let message = "matrix that is too short or not finite: ignored";
            self.notes(visit).add(message);
        }
        let translations = document.ancillaries(node, opcode::TRANSLATE);
        let matrix = matrix.map(|m| transform::with_exact_translation(m, translations));
        let Some(matrix) = matrix else {
            if copies > 0 {
                let message = "replication without a matrix: ignored, all copies would coincide";
                self.notes(visit).add(message);
            }
            return draw(self, visit);
        };
        if copies <= 0 {
            return draw(self, visit.moved(&matrix));
        }
        let mut step = DAffine3::IDENTITY;
        for _ in 0..=copies {
            self.spend(1)?;
            draw(self, visit.moved(&step))?;
            step = matrix * step;
        }
        Ok(())
    }

    /// Adds the content of a node, after its transform.
    fn inside(&mut self, visit: NodeVisit) -> Result<(), ReadError> {
        use opcode::*;
        let opcode = visit.opcode();
        match opcode {
            HEADER | GROUP | OLD_LOD | LOD | BSP | EXTENSION => {}
            SWITCH if has_current_mask(visit.record()) => {}
            SWITCH => {
                let message = "switch without its current mask: all children are used";
                self.notes(visit).add(message);
            }
            // The faces of roads are their descendants; the construction parameters are not needed.
            CLIP_REGION | 87 | 127 => {
                let name = name(opcode);
                let message = format!("{name} (opcode {opcode}): skipped, except for its children");
                self.notes(visit).add(message);
            }
            OBJECT => {
                let transparency = visit.record().u16(18).unwrap_or_default();
                let share = 1.0 - f64::from(transparency) / f64::from(u16::MAX);
                let mut inner = visit;
                inner.place.opacity *= share;
                return self.children(inner);
            }
            DOF => match transform::degree_of_freedom(visit.record()) {
                Some(map) => return self.children(visit.moved(&map)),
                None => {
                    let message = "degree of freedom that is too short or not finite: ignored";
                    self.notes(visit).add(message);
                }
            },
            LIGHT_SOURCE => self.light(visit)?,
            // Definitions are only added where they are referred to.
            INSTANCE_DEFINITION => return Ok(()),
            INSTANCE_REFERENCE => return self.instance(visit),
            EXTERNAL_REFERENCE => return self.external(visit),
            _ => {
                let message = format!("{} (opcode {opcode}): skipped", name(opcode));
                return self.skip(visit, message);
            }
        }
        self.children(visit)
    }

    fn instance(&mut self, visit: NodeVisit) -> Result<(), ReadError> {
        let number = visit.record().u16(6).unwrap_or_default();
        let Some(&definition) = visit.source.document.definitions.get(&number) else {
            let message = format!("reference to instance {number}, which is not defined: skipped");
            return self.skip(visit, message);
        };
        let key = (visit.source.number, number);
        if self.instances.contains(&key) {
            return self.skip(visit, format!("instance {number} inside itself: skipped"));
        }
        self.instances.push(key);
        let done = self.each_copy(visit.with(definition), |walker, copy| walker.children(copy));
        self.instances.pop();
        done
    }
}
