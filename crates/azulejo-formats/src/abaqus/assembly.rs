//! Parts in their places, and the elements that sets consist of.

use super::part::{AbaqusModel, AbaqusPart, ElementItem};
use crate::reading::fortran::identifier;
use crate::reading::options::Budget;
use crate::reading::text::shortened;
use crate::reading::warnings::Warnings;
use crate::{Position, ReadError};
use glam::DVec3;
use std::collections::{HashMap, HashSet};
use std::f64::consts::TAU;

/// A part in its place; what is outside of all parts is the first.
pub(super) struct PlacedPart<'a> {
    /// The name of the instance; empty for the first.
    pub name: &'a str,
    /// What its elements are listed in.
    pub part: &'a AbaqusPart,
    /// What the instance lists itself, beside its part.
    pub own: Option<&'a AbaqusPart>,
    /// The index of its first node among all.
    pub first_node: u32,
}

/// An element in its place: index of the instance, and index in its part.
pub(super) type PlacedElement = (u32, u32);

/// All instances of a model.
pub(super) struct AbaqusAssembly<'a> {
    pub model: &'a AbaqusModel,
    pub instances: Vec<PlacedPart<'a>>,
    instance_numbers: HashMap<String, u32>,
    /// All nodes; if bodies are revolved, once more for each further end of a sector.
    pub positions: Vec<DVec3>,
    /// Sectors of bodies of revolution, 0 if nothing is revolved.
    pub sectors: u32,
    /// Whether several instances have elements, so that names need those of instances.
    pub is_divided: bool,
    pub budget: Budget,
    pub warnings: &'a mut Warnings,
}

impl<'a> AbaqusAssembly<'a> {
    /// Places all instances.
    ///
    /// # Errors
    /// More than the budget allows, and sections of bodies of revolution that are not beside the axis.
    pub fn new(
        model: &'a AbaqusModel,
        sectors: Option<u32>,
        budget: Budget,
        warnings: &'a mut Warnings,
    ) -> Result<AbaqusAssembly<'a>, ReadError> {
        let mut assembly = AbaqusAssembly {
            model,
            instances: Vec::new(),
            instance_numbers: HashMap::new(),
            positions: model.parts[0].positions.clone(),
            sectors: 0,
            is_divided: false,
            budget,
            warnings,
        };
        assembly.instances.push(PlacedPart {
            name: "",
            part: &model.parts[0],
            own: None,
            first_node: 0,
        });
        for number in 0..model.instances.len() {
            assembly.place(number)?;
        }
        let is_used = |part: &AbaqusPart| !part.elements.is_empty();
        if model.instances.is_empty() && model.parts[1..].iter().any(is_used) {
            assembly.place_parts()?;
        }
        let with_elements = assembly.instances.iter().filter(|i| is_used(i.part));
        assembly.is_divided = with_elements.count() > 1;
        if let Some(sectors) = sectors {
            assembly.revolve(sectors)?;
        }
        Ok(assembly)
    }

    /// Adds the nodes of sections of bodies of revolution in all their places around the axis y, x being the distance from
    /// it. A regular polygon stands for a circle, of the same circumference, so that what is parallel to the axis has the
    /// right area.
    fn revolve(&mut self, sectors: u32) -> Result<(), ReadError> {
        let mut is_section = vec![false; self.positions.len()];
        let mut sections = 0;
        for placed in &self.instances {
            let elements = placed.part.elements.iter();
            for element in elements.filter(|e| e.kind.swept().is_some()) {
                self.sectors = sectors;
                sections += 1;
                for number in &element.nodes[..element.kind.shape.corner_count()] {
                    if let Some(index) = placed.part.node_numbers.get(number) {
                        let node = is_section.get_mut((placed.first_node + index) as usize);
                        if let Some(is_section) = node {
                            *is_section = true;
                        }
                    }
                }
            }
        }
        let (nodes, turns) = (
            self.positions.len(),
            self.sectors.saturating_sub(1) as usize,
        );
        // Elements may be many where nodes are few.
        self.spend((nodes as u64 + 8 * sections) * turns as u64)?;
        if (nodes as u64) * u64::from(self.sectors) >= u64::from(u32::MAX) {
            let file = &self.model.files[0];
            return Err(ReadError::whole(
                file,
                "too many nodes around the axis",
                "fewer than 2^32",
            ));
        }
        let angle = TAU / f64::from(sectors);
        let widening = angle / 2.0 / (angle / 2.0).sin();
        for (p, _) in self
            .positions
            .iter_mut()
            .zip(is_section)
            .filter(|(_, is)| *is)
        {
            // Instances are placed by rounded numbers.
            if p.x < 0.0 || p.z.abs() > 1e-6 * p.x.max(p.y.abs()) {
                let found = format!(
                    "a node at {}, {}, {} of an axisymmetric element",
                    p.x, p.y, p.z
                );
                let file = &self.model.files[0];
                return Err(ReadError::whole(
                    file,
                    found,
                    "x >= 0, its distance from the axis y, and z = 0",
                ));
            }
            p.x *= widening;
        }
        for k in 1..=turns {
            let (sin, cos) = (k as f64 * angle).sin_cos();
            let turned = |node: usize| {
                let p = self.positions[node];
                DVec3::new(cos * p.x, p.y, sin * p.x)
            };
            let places: Vec<DVec3> = (0..nodes).map(turned).collect();
            self.positions.extend(places);
        }
        Ok(())
    }

    /// A node of a section at the beginning of a sector; on the axis all are the same.
    pub fn turned(&self, node: u32, sector: u32) -> u32 {
        let nodes = self.positions.len() as u32 / self.sectors;
        match self.positions[node as usize].x {
            0.0 => node,
            _ => node + sector % self.sectors * nodes,
        }
    }

    /// Places an instance of a part, or of what it lists itself.
    fn place(&mut self, number: usize) -> Result<(), ReadError> {
        let model = self.model;
        let instance = &model.instances[number];
        let own = &model.parts[instance.own];
        let of_name = model.part_numbers.get(&instance.part.to_ascii_uppercase());
        let (part, own) = match of_name.map(|&part| &model.parts[part]) {
            Some(part) if own.elements.is_empty() => (part, Some(own)),
            part => (own, part),
        };
        if part.elements.is_empty() {
            let message =
                "instance of a part that does not exist, or has no elements with surfaces";
            let place = Position::Line(instance.line.1, 1);
            let file = &model.files[instance.line.0 as usize];
            self.warnings.add(file, message.to_owned(), || place);
        }
        let numbers = &mut self.instance_numbers;
        let next = self.instances.len() as u32;
        numbers
            .entry(instance.name.to_ascii_uppercase())
            .or_insert(next);
        let position = |&p: &DVec3| instance.place.transform_point3(p);
        self.add(&instance.name, part, own, position)
    }

    /// Parts without an assembly stand where they are.
    fn place_parts(&mut self) -> Result<(), ReadError> {
        let model = self.model;
        for part in &model.parts[1..] {
            self.add(&part.name, part, None, |&p| p)?;
        }
        Ok(())
    }

    fn add(
        &mut self,
        name: &'a str,
        part: &'a AbaqusPart,
        own: Option<&'a AbaqusPart>,
        position: impl Fn(&DVec3) -> DVec3,
    ) -> Result<(), ReadError> {
        let nodes = part.positions.len() as u64;
        let elements = 8 * part.elements.len() as u64;
        self.spend(nodes + elements + 1)?;
        let first_node = self.positions.len();
        let is_countable = first_node as u64 + nodes < u64::from(u32::MAX);
        if !is_countable {
            let file = &self.model.files[0];
            return Err(ReadError::whole(
                file,
                "instances of too many nodes",
                "fewer than 2^32",
            ));
        }
        self.instances.push(PlacedPart {
            name,
            part,
            own,
            first_node: first_node as u32,
        });
        if self.budget.keeps() {
            self.positions.extend(part.positions.iter().map(position));
        }
        Ok(())
    }

    /// Counts work that the length of the file does not limit.
    pub fn spend(&mut self, elements: u64) -> Result<(), ReadError> {
        let spent = self.budget.spend(elements);
        spent.map_err(|e| e.error(&self.model.files[0]))
    }

    /// The elements of an item that an instance lists, in order and each as often as it is listed.
    pub fn members(
        &mut self,
        instance: u32,
        item: &'a ElementItem,
    ) -> Result<Vec<PlacedElement>, ReadError> {
        let mut members = Vec::new();
        let mut known: HashSet<(u32, *const ElementItem)> = HashSet::new();
        // Sets of sets may be nested as deeply as the file is long.
        let mut work = vec![(instance, item)];
        while let Some((instance, item)) = work.pop() {
            self.spend(1)?;
            match item {
                &ElementItem::Indices(first, end) => {
                    self.spend(u64::from(end - first))?;
                    members.extend((first..end).map(|e| (instance, e)));
                }
                ElementItem::Numbers(numbers, of) => match self.instance(instance, of) {
                    Some(instance) => self.numbered(instance, *numbers, &mut members)?,
                    None => self.missing(of),
                },
                ElementItem::Set(name, of) => {
                    let number = identifier(name.as_bytes());
                    match (
                        self.set_of(instance, name, of),
                        self.instance(instance, of),
                        number,
                    ) {
                        (Some((instance, items)), ..) => {
                            if known.insert((instance, items.as_ptr())) {
                                work.extend(items.iter().rev().map(|item| (instance, item)));
                            }
                        }
                        // `left.12`: an element of another instance.
                        (None, Some(instance), Some(number)) => {
                            self.numbered(instance, [number, number, 1], &mut members)?;
                        }
                        (None, ..) => self.missing(&Some(name.clone())),
                    }
                }
            }
        }
        Ok(members)
    }

    fn instance(&self, current: u32, name: &Option<String>) -> Option<u32> {
        match name {
            None => Some(current),
            Some(name) => self
                .instance_numbers
                .get(&name.to_ascii_uppercase())
                .copied(),
        }
    }

    /// The set of a name that another instance has, or this one if there is no such instance: then the dot
    /// belongs to the name.
    fn set_of(
        &self,
        current: u32,
        name: &str,
        of: &Option<String>,
    ) -> Option<(u32, &'a [ElementItem])> {
        match (self.instance(current, of), of) {
            (Some(instance), _) => self.set(instance, name),
            (None, Some(of)) => self.set(current, &format!("{of}.{name}")),
            (None, None) => None,
        }
    }

    /// The set of a name that an instance has, from its part or by itself.
    fn set(&self, instance: u32, name: &str) -> Option<(u32, &'a [ElementItem])> {
        let placed = &self.instances[instance as usize];
        let parts = [Some(placed.part), placed.own];
        parts.into_iter().flatten().find_map(|part| {
            let set = part.known_set(name)?;
            Some((instance, &*part.sets[set as usize].items))
        })
    }

    /// Elements of a range of numbers, in the order of the numbers or, if there are fewer elements than
    /// numbers, in their own.
    fn numbered(
        &mut self,
        instance: u32,
        [first, last, step]: [u32; 3],
        elements: &mut Vec<PlacedElement>,
    ) -> Result<(), ReadError> {
        let part = self.instances[instance as usize].part;
        let Some(span) = last.checked_sub(first) else {
            return Ok(());
        };
        let count = span / step + 1;
        if count as usize <= part.elements.len() {
            self.spend(count.into())?;
            let numbers = (0..count).map(|k| first + k * step);
            let indices = numbers.filter_map(|n| part.element_numbers.get(&n));
            elements.extend(indices.map(|&e| (instance, e)));
            return Ok(());
        }
        self.spend(part.elements.len() as u64)?;
        let is_in = |n: u32| (first..=last).contains(&n) && (n - first).is_multiple_of(step);
        let known = part.element_numbers.iter().filter(|&(&n, _)| is_in(n));
        let mut indices: Vec<u32> = known.map(|(_, &e)| e).collect();
        indices.sort_unstable();
        elements.extend(indices.into_iter().map(|e| (instance, e)));
        Ok(())
    }

    fn missing(&mut self, name: &Option<String>) {
        let name = shortened(name.as_deref().unwrap_or_default());
        let message = format!("set or instance \"{name}\" does not exist: skipped");
        self.warnings.add_whole(&self.model.files[0], message);
    }
}
