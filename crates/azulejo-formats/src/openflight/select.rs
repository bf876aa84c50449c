//! Selection among the children of a node: levels of detail, switches, animation frames.

use super::document::{FltDocument, FltNode, Siblings};
use super::fields::RecordFields;
use super::opcode;
use crate::Lod;

/// The selection among the children of one node.
#[derive(Debug)]
pub(super) struct ChildSelection<'d> {
    by_position: ByPosition<'d>,
    lod: LodRule,
}

/// A selection by the position of a child among its siblings.
#[derive(Debug)]
enum ByPosition<'d> {
    All,
    First,
    /// The bits of a switch's current mask, and their offset.
    Mask(RecordFields<'d>, usize),
}

#[derive(Debug)]
enum LodRule {
    All,
    /// Levels with this switch-out distance.
    SwitchOut(f64),
    /// Levels that are visible from this distance, in the file's units.
    Distance(f64),
}

impl<'d> ChildSelection<'d> {
    /// The selection among `children` of `parent`, for the requested `lod`. A unit of the document
    /// is `scale` units of the root model.
    pub fn new(
        document: &'d FltDocument,
        parent: Option<FltNode>,
        children: Siblings,
        lod: Lod,
        scale: f64,
    ) -> ChildSelection<'d> {
        ChildSelection {
            by_position: parent.map_or(ByPosition::All, |node| by_position(document, node)),
            lod: lod_rule(document, children, lod, scale),
        }
    }

    /// Why a child is not selected, if it is not; `position` is the number of children before it.
    pub fn leaves_out(
        &self,
        document: &FltDocument,
        position: usize,
        child: FltNode,
    ) -> Option<&'static str> {
        let is_on = match self.by_position {
            ByPosition::All => true,
            ByPosition::First if position > 0 => {
                return Some("frame of an animation after the first: skipped");
            }
            ByPosition::First => true,
            ByPosition::Mask(record, start) => {
                let word = record.u32(start + 4 * (position / 32)).unwrap_or_default();
                word & 1 << (position % 32) != 0
            }
        };
        if !is_on {
            return Some("node that its switch disables: skipped");
        }
        let (switch_in, switch_out) = range(document, child)?;
        let is_seen = match self.lod {
            LodRule::All => true,
            LodRule::SwitchOut(chosen) => switch_out == chosen,
            LodRule::Distance(d) => {
                let always = switch_in == 0.0 && switch_out == 0.0;
                let nearest = switch_out == 0.0 && d == 0.0;
                always || nearest || (switch_out < d && d <= switch_in)
            }
        };
        (!is_seen).then_some("level of detail that is not the requested one: skipped")
    }
}

fn by_position<'d>(document: &'d FltDocument, node: FltNode) -> ByPosition<'d> {
    let record = document.fields(node.at);
    match node.opcode {
        opcode::GROUP if is_animated(record, document.revision) => ByPosition::First,
        opcode::SWITCH => mask(record).map_or(ByPosition::All, |at| ByPosition::Mask(record, at)),
        _ => ByPosition::All,
    }
}

/// Whether the children of a group are frames of an animation.
fn is_animated(group: RecordFields, revision: u32) -> bool {
    const FORWARD: u32 = 1 << 30;
    const SWING: u32 = 1 << 29;
    const BACKWARD: u32 = 1 << 25;
    // Revision 15.8 added the third bit, and changed the meaning of the second one.
    let bits = match revision {
        ..1580 => FORWARD | SWING,
        _ => FORWARD | BACKWARD,
    };
    group.u32(16).is_some_and(|flags| flags & bits != 0)
}

/// Whether a switch has a mask that selects its children.
pub(super) fn has_current_mask(switch: RecordFields) -> bool {
    mask(switch).is_some()
}

/// The offset of the current mask of a switch; `None` if the record has no such mask.
fn mask(switch: RecordFields) -> Option<usize> {
    let [current, count, words] = [16, 20, 24].map(|at| switch.u32(at));
    let (current, words) = (current?, words? as usize);
    let start = words.checked_mul(4 * current as usize)?.checked_add(28)?;
    let is_there = current < count? && words > 0 && start < switch.0.len();
    is_there.then_some(start)
}

/// Switch-in and switch-out distances of a level of detail; `None` for other nodes.
fn range(document: &FltDocument, node: FltNode) -> Option<(f64, f64)> {
    let record = document.fields(node.at);
    let (switch_in, switch_out) = match node.opcode {
        opcode::LOD => (record.double(16), record.double(24)),
        opcode::OLD_LOD => {
            let distance = |at| record.u32(at).map(f64::from);
            (distance(12), distance(16))
        }
        _ => return None,
    };
    let finite = |x: Option<f64>| x.filter(|x| x.is_finite());
    let switch_in = finite(switch_in).unwrap_or(f64::INFINITY);
    Some((switch_in, finite(switch_out).unwrap_or(0.0)))
}

fn lod_rule(document: &FltDocument, children: Siblings, lod: Lod, scale: f64) -> LodRule {
    let switch_out = |(_, node): (u32, FltNode)| range(document, node).map(|r| r.1);
    match lod {
        Lod::All => LodRule::All,
        Lod::Distance(d) => LodRule::Distance(d / scale),
        Lod::Finest | Lod::Numbered(_) => {
            let distances = children.filter_map(switch_out);
            LodRule::SwitchOut(distances.fold(f64::INFINITY, f64::min))
        }
        Lod::Coarsest => {
            let full = children.filter(|(index, _)| has_surface(document, *index));
            let distances = full.filter_map(switch_out);
            LodRule::SwitchOut(distances.fold(f64::NEG_INFINITY, f64::max))
        }
    }
}

/// Whether a node has any descendant that may be visible.
fn has_surface(document: &FltDocument, node: u32) -> bool {
    use opcode::*;
    let end = document.nodes[node as usize].end;
    let below = &document.nodes[node as usize..end as usize];
    below.iter().any(|n| {
        let is_surface = matches!(
            n.opcode,
            FACE | MESH | INSTANCE_REFERENCE | EXTERNAL_REFERENCE
        );
        is_surface
    })
}
