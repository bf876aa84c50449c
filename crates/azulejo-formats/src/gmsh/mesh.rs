//! The content of a file: nodes, elements and the groups that they belong to.

use super::element_types::MshShape;
use super::source::MshSource;
use crate::ReadError;
use crate::surface::boundary::CellKind;
use azulejo_scene::Faces;
use glam::DVec3;
use std::collections::HashMap;

/// What an element belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum MshGroup {
    /// A physical group: its dimension, and its number.
    Physical(u8, i64),
    /// An entity of the geometry: its dimension, and its number.
    Entity(u8, i64),
}

/// The nodes and elements of a file, whatever its version.
#[derive(Debug, Default)]
pub(super) struct MshMesh {
    pub positions: Vec<DVec3>,
    /// Index into `positions` by the number of the node.
    nodes: HashMap<u64, u32>,
    /// Names of physical groups by dimension and number.
    pub names: HashMap<(u8, i64), String>,
    pub groups: Vec<MshGroup>,
    known: HashMap<MshGroup, u32>,
    pub faces: Faces,
    /// Index into `groups` for each face.
    pub face_groups: Vec<u32>,
    /// Volumes, each with its index into `groups`.
    pub cells: Vec<(CellKind, u32)>,
    /// The corners of all volumes one after the other.
    pub cell_corners: Vec<u32>,
    /// Points and lines.
    pub lines: usize,
    /// Elements of second or higher order.
    pub curved: usize,
}

impl MshMesh {
    /// Adds a node.
    pub fn node(&mut self, number: u64, position: DVec3) {
        self.nodes.insert(number, self.positions.len() as u32);
        self.positions.push(position);
    }

    /// The index of a group, which is added if it is new.
    fn group(&mut self, group: MshGroup) -> u32 {
        let groups = &mut self.groups;
        *self.known.entry(group).or_insert_with(|| {
            groups.push(group);
            groups.len() as u32 - 1
        })
    }

    /// The group of an element: a physical one, or its entity if there is none.
    pub fn group_of(&mut self, shape: MshShape, physical: Option<i64>, entity: i64) -> u32 {
        let dimension = if matches!(shape, MshShape::Cell(_)) {
            3
        } else {
            2
        };
        self.group(match physical.filter(|&p| p != 0) {
            // The sign says which side is the front.
            Some(physical) => MshGroup::Physical(dimension, physical.saturating_abs()),
            None => MshGroup::Entity(dimension, entity),
        })
    }

    /// Adds an element of a group by the numbers of all its nodes; `reversed` is for one that looks to
    /// the other side. `at` is where it begins.
    pub fn element(
        &mut self,
        shape: MshShape,
        nodes: &[u64],
        (group, reversed): (u32, bool),
        (source, at): (&MshSource, usize),
    ) -> Result<(), ReadError> {
        let count = shape.corner_count();
        self.curved += usize::from(count > 0 && nodes.len() > count);
        let corners = match shape {
            MshShape::Line => {
                self.lines += 1;
                return Ok(());
            }
            MshShape::Polygon(_) => &mut self.faces.corners,
            MshShape::Cell(_) => &mut self.cell_corners,
        };
        let start = corners.len();
        for number in &nodes[..count] {
            let known = self.nodes.get(number).copied();
            let unknown = || {
                let found = format!("an element with node {number}");
                source.error(at, found, "a node of the section $Nodes before it")
            };
            corners.push(known.ok_or_else(unknown)?);
        }
        match shape {
            MshShape::Cell(kind) => self.cells.push((kind, group)),
            _ => {
                if reversed {
                    corners[start..].reverse();
                }
                self.faces.starts.push(self.faces.corners.len() as u32);
                self.face_groups.push(group);
            }
        }
        Ok(())
    }

    /// The name of a group.
    pub fn name(&self, group: MshGroup) -> String {
        let kind = |dimension| if dimension == 3 { "volume" } else { "surface" };
        match group {
            MshGroup::Physical(dimension, number) => match self.names.get(&(dimension, number)) {
                Some(name) => name.clone(),
                None => format!("physical {} {number}", kind(dimension)),
            },
            MshGroup::Entity(dimension, number) => format!("{} {number}", kind(dimension)),
        }
    }
}
