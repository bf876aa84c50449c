//! Parts: nodes, elements, sets and surfaces, as the file lists them.

use super::elements::{ElementFace, ElementType};
use glam::{DAffine3, DVec3};
use std::collections::HashMap;

/// An element of a part.
#[derive(Clone, Copy, Debug)]
pub(super) struct PartElement {
    pub kind: ElementType,
    /// Numbers of its corner nodes.
    pub nodes: [u32; 8],
    /// The set that its keyword names, [`NO_SET`] for none.
    pub set: u32,
}

/// Marks an element without a set.
pub(super) const NO_SET: u32 = u32::MAX;

/// What sets and surfaces refer to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum ElementItem {
    /// Elements by index, those of one keyword.
    Indices(u32, u32),
    /// Elements by number: from, to, step.
    Numbers([u32; 3], Option<String>),
    /// Another set.
    Set(String, Option<String>),
}

/// A named set of elements.
#[derive(Clone, Debug, Default)]
pub(super) struct ElementSet {
    pub name: String,
    pub items: Vec<ElementItem>,
    /// Whether a program has made it for its own use, or it is the one of all elements, or of a surface of
    /// gmsh's geometry.
    pub is_internal: bool,
}

/// A named surface.
#[derive(Clone, Debug, Default)]
pub(super) struct ElementSurface {
    pub name: String,
    pub items: Vec<(ElementItem, ElementFace)>,
    /// File and line.
    pub place: (u32, u32),
}

/// A radiation load of CalculiX in a cavity (`RkCR`).
#[derive(Clone, Debug)]
pub(super) struct CavityLoad {
    pub cavity: String,
    pub item: ElementItem,
    pub face: ElementFace,
    /// File and line.
    pub place: (u32, u32),
}

/// What a file lists between `*PART` and `*END PART`, or outside of all of them.
#[derive(Debug, Default)]
pub(super) struct AbaqusPart {
    pub name: String,
    pub positions: Vec<DVec3>,
    pub node_numbers: HashMap<u32, u32>,
    pub elements: Vec<PartElement>,
    pub element_numbers: HashMap<u32, u32>,
    pub sets: Vec<ElementSet>,
    pub set_numbers: HashMap<String, u32>,
    pub surfaces: Vec<ElementSurface>,
    /// The sets that have sections, which divide the elements.
    pub sections: Vec<String>,
}

impl AbaqusPart {
    /// The index of a set, which is added if it is new.
    pub fn set(&mut self, name: &str) -> u32 {
        let new = self.sets.len() as u32;
        let key = name.to_ascii_uppercase();
        let is_internal = key == "EALL" || is_of_gmsh(name);
        let number = *self.set_numbers.entry(key).or_insert(new);
        if number == new {
            self.sets.push(ElementSet {
                name: name.to_owned(),
                items: Vec::new(),
                is_internal,
            });
        }
        number
    }

    /// The index of a set, whatever the capitals of its name.
    pub fn known_set(&self, name: &str) -> Option<u32> {
        self.set_numbers.get(&name.to_ascii_uppercase()).copied()
    }
}

/// Whether a name is one that gmsh or meshio gives: of a surface or volume of the geometry, beside which stand
/// the sets of physical groups, or of what meshio keeps for itself.
fn is_of_gmsh(name: &str) -> bool {
    let number = name
        .strip_prefix("Surface")
        .or_else(|| name.strip_prefix("Volume"));
    let is_number = |n: &str| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit());
    number.is_some_and(is_number) || name.starts_with("gmsh:")
}

/// A part in its place.
#[derive(Debug)]
pub(super) struct AbaqusInstance {
    pub name: String,
    /// The name of the part.
    pub part: String,
    /// Index of what the instance itself lists.
    pub own: usize,
    pub place: DAffine3,
    /// File and line.
    pub line: (u32, u32),
}

/// The whole model.
#[derive(Debug)]
pub(super) struct AbaqusModel {
    /// The names of its files, that of the model first.
    pub files: Vec<String>,
    /// What is outside of all parts, first; parts, and what instances list themselves.
    pub parts: Vec<AbaqusPart>,
    pub part_numbers: HashMap<String, usize>,
    pub instances: Vec<AbaqusInstance>,
    /// The surfaces that cavities consist of, in capitals; none if there are no cavities.
    pub cavities: Vec<String>,
    /// Loads on the faces of cavities of CalculiX, in the order of the file.
    pub loads: Vec<CavityLoad>,
}

impl Default for AbaqusModel {
    fn default() -> AbaqusModel {
        AbaqusModel {
            files: Vec::new(),
            parts: vec![AbaqusPart::default()],
            part_numbers: HashMap::new(),
            instances: Vec::new(),
            cavities: Vec::new(),
            loads: Vec::new(),
        }
    }
}
