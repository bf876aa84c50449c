//! From the tree of records to the scene.

use super::document::{FltDocument, FltNode, Siblings};
use super::external::ExternalFiles;
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

/// Most levels of nodes, instances and files inside each other.
const MOST_LEVELS: u32 = 128;

/// So many bytes of names count as one element of the budget.
pub(super) const BYTES_PER_ELEMENT: u64 = 64;

/// A file in the part that it plays where it is referred to.
#[derive(Clone, Copy)]
pub(super) struct FltSource<'d> {
    pub document: &'d FltDocument<'d>,
    /// Tells documents apart.
    pub number: usize,
    /// Its name as the root model knows it; empty for the root model.
    pub path: &'d str,
    pub palettes: &'d Palettes,
    /// Tells sets of palettes apart.
    pub set: u32,
    /// Length of a unit in units of the root model.
    pub scale: f64,
}

/// The scene under construction, and where in the tree we are.
pub(super) struct FltWalker<'f> {
    pub name: &'f str,
    pub options: &'f ReadOptions,
    pub budget: Budget,
    pub warnings: Warnings,
    pub materials: FltMaterials<'f>,
    pub scene: Scene,
    pub externals: ExternalFiles<'f>,
    /// Names of the nodes above, and `/` between them.
    pub path: String,
    /// For each document, what became of the vertices of its palette.
    pub slots: Vec<Vec<VertexSlot>>,
    pub stamps: u32,
    pub sets: u32,
    levels: u32,
    /// Instances that are being drawn: numbers of document and definition.
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

    /// For warnings about a node.
    pub fn notes<'n>(&'n mut self, source: FltSource<'n>, node: u32) -> RecordWarnings<'n> {
        RecordWarnings::new(&mut self.warnings, source.document, node)
    }

    /// Goes a level down, and comes back.
    pub fn deeper(
        &mut self,
        source: FltSource,
        node: u32,
        inside: impl FnOnce(&mut Self) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        if self.levels == MOST_LEVELS {
            return Err(ReadError::at_byte(
                &*source.document.file,
                source.document.nodes[node as usize].at.into(),
                format!("more than {MOST_LEVELS} levels of nodes inside each other"),
                "fewer",
            ));
        }
        self.levels += 1;
        let done = inside(self);
        self.levels -= 1;
        done
    }

    /// Draws what stands at the top of a file.
    pub fn top(&mut self, source: FltSource, place: &InheritedState) -> Result<(), ReadError> {
        self.siblings(source, None, source.document.top(), place)
    }

    /// Draws a node by itself.
    pub fn one(
        &mut self,
        source: FltSource,
        node: u32,
        place: &InheritedState,
    ) -> Result<(), ReadError> {
        match source.document.nodes[node as usize].opcode {
            opcode::FACE | opcode::MESH => {
                let mut part = FltPart::default();
                self.surface(source, node, place, &mut part)?;
                self.finish(part)
            }
            _ => self.node(source, node, place),
        }
    }

    /// Draws what is below a node.
    fn children(
        &mut self,
        source: FltSource,
        node: u32,
        place: &InheritedState,
    ) -> Result<(), ReadError> {
        let parent = source.document.nodes[node as usize];
        if self.options.lod == Lod::Coarsest {
            // Whether a level is empty is found by looking through it.
            self.spend(u64::from(parent.end - node))?;
        }
        self.siblings(source, Some(parent), source.document.below(node), place)
    }

    fn siblings(
        &mut self,
        source: FltSource,
        parent: Option<FltNode>,
        siblings: Siblings,
        place: &InheritedState,
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
            match (left_out, node.opcode) {
                (Some(why), _) => self.notes(source, child).add(why),
                (None, opcode::FACE | opcode::MESH) => {
                    self.surface(source, child, place, &mut part)?;
                }
                (None, _) => self.node(source, child, place)?,
            }
        }
        self.finish(part)
    }

    /// Makes an object of the faces that have been found below one node.
    fn finish(&mut self, part: FltPart) -> Result<(), ReadError> {
        if let Some(mesh) = part.finish() {
            let object = Object::new(self.full_name()?, Shape::Mesh(mesh));
            self.scene.objects.push(object);
        }
        Ok(())
    }

    /// Names of all nodes above. A long name above many objects is copied to each.
    pub fn full_name(&mut self) -> Result<String, ReadError> {
        self.spend(self.path.len() as u64 / BYTES_PER_ELEMENT)?;
        Ok(self.path.clone())
    }

    /// Draws a node that is no face, and all below it.
    pub fn node(
        &mut self,
        source: FltSource,
        node: u32,
        place: &InheritedState,
    ) -> Result<(), ReadError> {
        let outer = self.path.len();
        if source.document.nodes[node as usize].opcode != opcode::HEADER {
            let name = source.document.name(node);
            self.spend(name.len() as u64 / BYTES_PER_ELEMENT)?;
            self.enter(&name);
        }
        let done = self.deeper(source, node, |walker| {
            walker.each_copy(source, node, place, |walker, place| {
                walker.inside(source, node, place)
            })
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

    /// Does something at each place where a node stands: where its matrix puts it, or once
    /// without the matrix and then as often as it is replicated, with the matrix once, twice...
    pub fn each_copy(
        &mut self,
        source: FltSource,
        node: u32,
        place: &InheritedState,
        mut draw: impl FnMut(&mut Self, &InheritedState) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        let document = source.document;
        let copies = document.ancillary(node, opcode::REPLICATE);
        let copies = copies.and_then(|r| r.i16(4)).unwrap_or_default();
        let record = document.ancillary(node, opcode::MATRIX);
        let matrix = record.and_then(transform::matrix);
        if record.is_some() && matrix.is_none() {
            let message = "matrix that is too short, or of what is no number: left out";
            self.notes(source, node).add(message);
        }
        let Some(matrix) = matrix else {
            if copies > 0 {
                let message = "replication without a matrix: left out, all copies would coincide";
                self.notes(source, node).add(message);
            }
            return draw(self, place);
        };
        if copies <= 0 {
            return draw(self, &place.then(&matrix));
        }
        let mut step = DAffine3::IDENTITY;
        for _ in 0..=copies {
            self.spend(1)?;
            draw(self, &place.then(&step))?;
            step = matrix * step;
        }
        Ok(())
    }

    /// Draws what a node consists of, at its own place.
    fn inside(
        &mut self,
        source: FltSource,
        node: u32,
        place: &InheritedState,
    ) -> Result<(), ReadError> {
        use opcode::*;
        let opcode = source.document.nodes[node as usize].opcode;
        let record = source.document.node(node);
        match opcode {
            HEADER | GROUP | OLD_LOD | LOD | BSP | EXTENSION => {}
            SWITCH => {
                if !has_current_mask(record) {
                    let message = "switch without its current mask: all below it is drawn";
                    self.notes(source, node).add(message);
                }
            }
            // Roads are made of faces, which are below; how they were made is of no use.
            CLIP_REGION | 87 | 127 => {
                let message = format!(
                    "{} (opcode {opcode}): skipped, but for what is below it",
                    name(opcode)
                );
                self.notes(source, node).add(message);
            }
            OBJECT => {
                let transparency = record.u16(18).unwrap_or_default();
                let share = 1.0 - f64::from(transparency) / f64::from(u16::MAX);
                let place = InheritedState {
                    opacity: place.opacity * share,
                    ..*place
                };
                return self.children(source, node, &place);
            }
            DOF => return self.degree_of_freedom(source, node, place),
            LIGHT_SOURCE => self.light(source, node, place)?,
            // It is drawn only where it is referred to.
            INSTANCE_DEFINITION => return Ok(()),
            INSTANCE_REFERENCE => return self.instance(source, node, place),
            EXTERNAL_REFERENCE => return self.external(source, node, place),
            _ => {
                let message = format!("{} (opcode {opcode}): skipped", name(opcode));
                self.notes(source, node).add(message);
                return Ok(());
            }
        }
        self.children(source, node, place)
    }

    fn degree_of_freedom(
        &mut self,
        source: FltSource,
        node: u32,
        place: &InheritedState,
    ) -> Result<(), ReadError> {
        let Some(map) = transform::degree_of_freedom(source.document.node(node)) else {
            let message =
                "degree of freedom that is too short, or of what is no number: stands still";
            self.notes(source, node).add(message);
            return self.children(source, node, place);
        };
        self.children(source, node, &place.then(&map))
    }

    fn instance(
        &mut self,
        source: FltSource,
        node: u32,
        place: &InheritedState,
    ) -> Result<(), ReadError> {
        let number = source.document.node(node).u16(6).unwrap_or_default();
        let Some(&definition) = source.document.definitions.get(&number) else {
            let message = format!("reference to instance {number}, which is not defined: left out");
            self.notes(source, node).add(message);
            return Ok(());
        };
        let key = (source.number, number);
        if self.instances.contains(&key) {
            let message = format!("instance {number} inside itself: left out");
            self.notes(source, node).add(message);
            return Ok(());
        }
        self.instances.push(key);
        let done = self.each_copy(source, definition, place, |walker, place| {
            walker.children(source, definition, place)
        });
        self.instances.pop();
        done
    }
}
