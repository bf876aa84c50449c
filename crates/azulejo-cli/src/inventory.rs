//! The parts of exact shapes, for `info`.

use super::report::count;
use azulejo_scene::{Exact, Figure, Leaf, Prism, Solid};
use std::collections::HashSet;
use std::sync::Arc;

/// Counts of the parts of exact shapes. Figures shared by prisms count once.
#[derive(Default)]
pub struct Inventory<'s> {
    /// Solids that are not composed of others.
    pub solids: usize,
    pub prisms: usize,
    primitives: usize,
    patches: usize,
    meshes: usize,
    pub operations: usize,
    figures: HashSet<*const Figure>,
    /// Lines and cubic curves of the figures.
    pub curves: usize,
    /// The prisms that lie side by side, for telling text from other prisms.
    first: Option<&'s Prism>,
    is_one_line: bool,
}

impl<'s> Inventory<'s> {
    /// The parts of one shape.
    pub fn of(exact: &'s Exact) -> Inventory<'s> {
        let mut inventory = Inventory {
            is_one_line: true,
            ..Inventory::default()
        };
        exact.leaves().iter().for_each(|l| inventory.leaf(l));
        inventory.operations = exact.solids.iter().map(operations).sum();
        inventory
    }

    /// Adds the content of another shape of the same scene.
    pub fn add(&mut self, other: &Inventory<'s>, exact: &Exact) {
        self.solids += other.solids;
        self.prisms += other.prisms;
        for leaf in exact.leaves() {
            if let Leaf::Prism(prism) = leaf {
                self.figure(prism);
            }
        }
    }

    /// Number of different figures.
    pub fn figures(&self) -> usize {
        self.figures.len()
    }

    fn leaf(&mut self, leaf: &Leaf<'s>) {
        self.solids += 1;
        match *leaf {
            Leaf::Prism(prism) => {
                self.prisms += 1;
                self.figure(prism);
                let first = *self.first.get_or_insert(prism);
                let axes = |p: &Prism| p.world_from_figure.matrix3;
                self.is_one_line &= axes(first) == axes(prism);
            }
            Leaf::Primitive(_) => self.primitives += 1,
            Leaf::Patch(_) => self.patches += 1,
            Leaf::Mesh(_) => self.meshes += 1,
        }
    }

    fn figure(&mut self, prism: &Prism) {
        if self.figures.insert(Arc::as_ptr(&prism.figure)) {
            self.curves += prism.figure.curve_count();
        }
    }

    /// The kind of a shape: `text` for prisms that differ in position only.
    pub fn kind(&self, exact: &Exact) -> &'static str {
        match &exact.solids[..] {
            [Solid::Csg(_)] => "csg",
            [Solid::Shell(_)] => "shell",
            [Solid::Patch(_)] => "patch",
            [Solid::Prism(_)] => "prism",
            many if many.len() == self.prisms && self.is_one_line && self.prisms > 1 => "text",
            _ => "solids",
        }
    }

    /// The parts in words: "18 prisms of 12 figures".
    pub fn words(&self) -> String {
        let plural = |n: usize, one: &str| match n {
            1 => format!("1 {one}"),
            n if one.ends_with('h') => format!("{} {one}es", count(n)),
            n => format!("{} {one}s", count(n)),
        };
        let prisms = format!(
            "{} of {}, {}",
            plural(self.prisms, "prism"),
            plural(self.figures(), "figure"),
            plural(self.curves, "curve")
        );
        let parts = [
            (self.operations, plural(self.operations, "set operation")),
            (self.prisms, prisms),
            (self.primitives, plural(self.primitives, "primitive")),
            (self.patches, plural(self.patches, "patch")),
            (self.meshes, plural(self.meshes, "mesh")),
        ];
        let there = parts.into_iter().filter(|(n, _)| *n > 0);
        let words: Vec<String> = there.map(|(_, words)| words).collect();
        if words.is_empty() {
            "nothing".to_owned()
        } else {
            words.join("; ")
        }
    }
}

/// Number of set operations in a solid.
fn operations(solid: &Solid) -> usize {
    let sum = |solids: &[Solid]| solids.iter().map(operations).sum::<usize>();
    match solid {
        Solid::Csg(csg) => 1 + sum(&csg.left) + sum(&csg.right),
        Solid::Shell(pieces) => sum(pieces),
        Solid::Primitive(_) | Solid::Prism(_) | Solid::Patch(_) | Solid::Mesh(_) => 0,
    }
}
