//! Records as a tree: set operations and lists with their members, and the later records that apply
//! to each of them.

use super::document::*;
use crate::ReadError;
use crate::reading::warnings::Warnings;
use azulejo_scene::Operation;
use glam::{DAffine3, DMat4};

/// Maximum nesting of set operations and lists, as in the original and in a valid scene.
const DEEPEST: usize = 256;

/// All objects, members included, in the order of their numbers.
#[derive(Debug, Default)]
pub(super) struct SffTree<'d> {
    pub nodes: Vec<SffNode<'d>>,
    /// The objects that are not members.
    pub roots: Vec<usize>,
}

/// One object.
#[derive(Debug)]
pub(super) struct SffNode<'d> {
    pub place: SffPosition,
    pub appearance: RecordAppearance,
    pub kind: SffNodeKind<'d>,
    /// The index after the last of its descendants; the next one for an object without members.
    pub end: usize,
    /// Its side in the enclosing set operation.
    pub side: usize,
    /// The product of its transforms; the first one is applied first.
    pub map: DAffine3,
    /// Textures among the objects.
    pub inline_textures: Vec<&'d TextureRecord>,
    /// Textures of the separate section.
    pub section_textures: Vec<&'d TextureRecord>,
}

#[derive(Debug)]
pub(super) enum SffNodeKind<'d> {
    Leaf(&'d SffGeometry),
    Csg(Operation, [Vec<usize>; 2]),
    List(Vec<usize>),
}

/// A set operation or list that has not ended.
struct OpenNode {
    node: usize,
    /// The current side of a set operation.
    side: usize,
}

impl<'d> SffTree<'d> {
    /// Builds the tree of a document.
    ///
    /// # Errors
    /// Beginnings and ends that do not match, sides without members, singular transforms, numbers
    /// of objects that do not exist.
    pub fn new(
        document: &'d SffDocument,
        sources: &SffSources,
        warnings: &mut Warnings,
    ) -> Result<SffTree<'d>, ReadError> {
        // Objects are numbered in the order of their records; `open` holds the operations and lists around.
        let mut tree = SffTree::default();
        tree.nodes.reserve(document.objects.len());
        let mut open: Vec<OpenNode> = Vec::new();
        for record in &document.objects {
            let place = record.place;
            let fail = |found: String, expected: &str| Err(sources.error(place, found, expected));
            match &record.kind {
                RecordKind::Object {
                    appearance,
                    geometry,
                } => {
                    tree.add(place, *appearance, SffNodeKind::Leaf(geometry), &open);
                }
                // Textures and transforms name an object before them by its number.
                RecordKind::Texture(texture) => match tree.find(texture.object) {
                    Some(node) => node.inline_textures.push(texture),
                    None => return fail(no_object(texture.object), AN_OBJECT),
                },
                RecordKind::Transform { object, matrix } => {
                    let Some(node) = tree.find(*object) else {
                        return fail(no_object(*object), AN_OBJECT);
                    };
                    let Some(map) = affine(matrix, || {
                        let message = "transform with perspective: only its affine part is used";
                        let position = || sources.position(place);
                        warnings.add(sources.name(place.file), message.into(), position);
                    }) else {
                        return fail("a singular transform".into(), A_MAP);
                    };
                    node.map = map * node.map;
                    if !is_invertible(&node.map) {
                        return fail("singular transforms".into(), A_MAP);
                    }
                }
                RecordKind::CsgBegin { .. } | RecordKind::ListBegin { .. }
                    if open.len() == DEEPEST =>
                {
                    let found = format!("operations nested more than {DEEPEST} deep");
                    return fail(found, "fewer levels");
                }
                RecordKind::CsgBegin {
                    appearance,
                    operation,
                } => {
                    let kind = SffNodeKind::Csg(*operation, Default::default());
                    let node = tree.add(place, *appearance, kind, &open);
                    open.push(OpenNode { node, side: 0 });
                }
                RecordKind::ListBegin { appearance } => {
                    let node = tree.add(place, *appearance, SffNodeKind::List(Vec::new()), &open);
                    open.push(OpenNode { node, side: 0 });
                }
                // A separator or an end must follow members of the operation or list that is open.
                RecordKind::CsgNext => match open.last_mut() {
                    Some(open) if open.side == 0 && tree.has_members(open) && tree.is_csg(open) => {
                        open.side = 1;
                    }
                    _ => return fail(tree.misplaced("66 1", open.last()), NEXT),
                },
                RecordKind::CsgEnd => match open.pop() {
                    Some(open) if open.side == 1 && tree.has_members(&open) => tree.close(&open),
                    last => return fail(tree.misplaced("66 2", last.as_ref()), END),
                },
                RecordKind::ListEnd => match open.pop() {
                    Some(open) if !tree.is_csg(&open) && tree.has_members(&open) => {
                        tree.close(&open);
                    }
                    last => return fail(tree.misplaced("67 1", last.as_ref()), LIST_END),
                },
            }
        }
        // Every operation and list must have ended.
        if let Some(last) = open.last() {
            let node = &tree.nodes[last.node];
            let end = if tree.is_csg(last) { "66 2" } else { "67 1" };
            let found = format!("a beginning without its end, {end}");
            return Err(sources.error(node.place, found, "both"));
        }
        // The separate section of textures may refer to any object, members included.
        tree.add_section(document, sources)?;
        Ok(tree)
    }

    fn add(
        &mut self,
        place: SffPosition,
        appearance: RecordAppearance,
        kind: SffNodeKind<'d>,
        open: &[OpenNode],
    ) -> usize {
        let index = self.nodes.len();
        self.nodes.push(SffNode {
            place,
            appearance,
            kind,
            end: index + 1,
            side: open.last().map_or(0, |o| o.side),
            map: DAffine3::IDENTITY,
            inline_textures: Vec::new(),
            section_textures: Vec::new(),
        });
        match open.last() {
            None => self.roots.push(index),
            Some(open) => match &mut self.nodes[open.node].kind {
                SffNodeKind::Csg(_, sides) => sides[open.side].push(index),
                SffNodeKind::List(members) => members.push(index),
                SffNodeKind::Leaf(_) => {}
            },
        }
        index
    }

    /// Ends an operation or list after the latest object.
    fn close(&mut self, open: &OpenNode) {
        self.nodes[open.node].end = self.nodes.len();
    }

    /// The object with a number, the latest for 0.
    fn find(&mut self, number: u32) -> Option<&mut SffNode<'d>> {
        match number {
            0 => self.nodes.last_mut(),
            _ => self.nodes.get_mut(number as usize - 1),
        }
    }

    fn is_csg(&self, open: &OpenNode) -> bool {
        matches!(self.nodes[open.node].kind, SffNodeKind::Csg(..))
    }

    fn has_members(&self, open: &OpenNode) -> bool {
        match &self.nodes[open.node].kind {
            SffNodeKind::Csg(_, sides) => !sides[open.side].is_empty(),
            SffNodeKind::List(members) => !members.is_empty(),
            SffNodeKind::Leaf(_) => true,
        }
    }

    /// Describes a separator or end record in the wrong position.
    fn misplaced(&self, record: &str, open: Option<&OpenNode>) -> String {
        match open {
            None => format!("{record} outside"),
            Some(open) if !self.has_members(open) => format!("{record} with nothing before it"),
            Some(_) => format!("{record} out of order"),
        }
    }

    fn add_section(
        &mut self,
        document: &'d SffDocument,
        sources: &SffSources,
    ) -> Result<(), ReadError> {
        for record in &document.textures {
            let RecordKind::Texture(texture) = &record.kind else {
                continue;
            };
            match self.find(texture.object).filter(|_| texture.object > 0) {
                Some(node) => node.section_textures.push(texture),
                None => {
                    let found = no_object(texture.object);
                    return Err(sources.error(record.place, found, AN_OBJECT));
                }
            }
        }
        Ok(())
    }
}

const AN_OBJECT: &str = "the number of an object above, counted from 1, or 0 for the latest";
const A_MAP: &str = "a matrix whose determinant is not zero";
const NEXT: &str = "66 0, the left side, 66 1, the right side, 66 2";
const END: &str = NEXT;
const LIST_END: &str = "67 0, the members, 67 1";

fn no_object(number: u32) -> String {
    match number {
        0 => "a record about the latest object before the first one".to_owned(),
        _ => format!("object {number}, which does not exist"),
    }
}

/// The affine part of a matrix for column vectors, `None` if it is singular. All zeros mean the
/// identity.
fn affine(matrix: &DMat4, warn: impl FnOnce()) -> Option<DAffine3> {
    if *matrix == DMat4::ZERO {
        return Some(DAffine3::IDENTITY);
    }
    let last = matrix.row(3);
    let weight = if last.w == 0.0 { 1.0 } else { last.w };
    if last.truncate() != glam::DVec3::ZERO || last.w == 0.0 {
        warn();
    }
    // A weight of one is the usual case, and dividing by it would not change a bit.
    let map = DAffine3::from_mat4(*matrix * (1.0 / weight));
    is_invertible(&map).then_some(map)
}

/// Whether a map has a finite inverse.
pub(super) fn is_invertible(map: &DAffine3) -> bool {
    let size = map.matrix3.determinant();
    map.is_finite() && size != 0.0 && size.is_finite() && map.inverse().is_finite()
}
