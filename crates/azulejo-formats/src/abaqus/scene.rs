//! The surfaces of a model as objects.

use super::assembly::{AbaqusAssembly, PlacedElement};
use super::elements::ElementFace;
use super::part::{AbaqusPart, ElementItem, ElementSurface, NO_SET, PartElement};
use crate::surface::boundary::VolumeBoundary;
use crate::surface::finite::{FiniteMesh, FiniteShape, face_key};
use crate::surface::named::NamedSurfaces;
use crate::{Position, ReadError};
use azulejo_scene::Scene;
use std::collections::{HashMap, HashSet};

/// What is known of the faces that named surfaces have.
#[derive(Default)]
struct SurfaceFaces {
    surfaces: NamedSurfaces,
    /// The faces that a surface has, by element, corners and side.
    known: HashSet<(PlacedElement, [u32; 4], bool)>,
    /// The free faces of each solid; computed where a surface does not say which it means.
    free: Option<HashMap<PlacedElement, Vec<Vec<u32>>>>,
}

impl<'a> AbaqusAssembly<'a> {
    /// The scene: named surfaces if there are any, else shells and the boundary of solids by their sets.
    pub fn scene(mut self) -> Result<Scene, ReadError> {
        if !self.budget.keeps() {
            return Ok(Scene::default());
        }
        let mut faces = SurfaceFaces::default();
        if !self.model.loads.is_empty() {
            self.collect_loads(&mut faces)?;
            let file = &self.model.files[0];
            return Ok((faces.surfaces).scene(&self.positions, file, self.warnings));
        }
        for (instance, surface) in self.chosen_surfaces() {
            self.collect(instance, surface, &mut faces)?;
        }
        if faces.surfaces.is_empty() {
            self.collect_sets(&mut faces.surfaces)?;
        } else {
            self.count_others(&faces);
        }
        let file = &self.model.files[0];
        Ok((faces.surfaces).scene(&self.positions, file, self.warnings))
    }

    /// The surfaces of all instances; if there are cavities, those that they consist of.
    fn chosen_surfaces(&self) -> Vec<(u32, &'a ElementSurface)> {
        let cavities: HashSet<&str> = self.model.cavities.iter().map(String::as_str).collect();
        let mut chosen = Vec::new();
        for (number, instance) in self.instances.iter().enumerate() {
            let parts = [Some(instance.part), instance.own];
            for surface in parts.into_iter().flatten().flat_map(|p| &p.surfaces) {
                let name = surface.name.to_ascii_uppercase();
                let full = format!("{}.{name}", instance.name.to_ascii_uppercase());
                if cavities.is_empty() || cavities.contains(&*name) || cavities.contains(&*full) {
                    chosen.push((number as u32, surface));
                }
            }
        }
        chosen
    }

    /// The name of something in an instance, with that of the instance if there are several.
    fn full_name(&self, instance: u32, name: &str) -> String {
        match (self.instances[instance as usize].name, name) {
            ("", name) => name.to_owned(),
            (of, "") => of.to_owned(),
            (of, name) if self.is_divided => format!("{of}.{name}"),
            (_, name) => name.to_owned(),
        }
    }

    fn element(&self, (instance, element): PlacedElement) -> &'a PartElement {
        &self.instances[instance as usize].part.elements[element as usize]
    }

    /// The nodes of an element at some of its corners, among all nodes; `None` if one does not exist.
    fn corners(&self, placed: PlacedElement, corners: &[usize]) -> Option<Vec<u32>> {
        let instance = &self.instances[placed.0 as usize];
        let element = self.element(placed);
        let node = |&k: &usize| {
            let index = instance.part.node_numbers.get(&element.nodes[k])?;
            Some(instance.first_node + index)
        };
        corners.iter().map(node).collect()
    }

    /// An element by its corners; a section of a body of revolution by the solids that it sweeps, one in each sector.
    /// `None` if a node does not exist.
    fn shapes(&self, placed: PlacedElement) -> Option<Vec<(FiniteShape, Vec<u32>)>> {
        let kind = self.element(placed).kind;
        let corners = self.corners(placed, &CORNERS[..kind.shape.corner_count()])?;
        let Some(solid) = kind.swept() else {
            return Some(vec![(kind.shape, corners)]);
        };
        let section = |k| corners.iter().map(move |&node| self.turned(node, k));
        let sector = |k| section(k).chain(section(k + 1)).collect();
        let sectors = 0..self.sectors;
        Some(sectors.map(|k| (solid, sector(k))).collect())
    }

    /// Adds the faces of a surface.
    fn collect(
        &mut self,
        instance: u32,
        surface: &'a ElementSurface,
        faces: &mut SurfaceFaces,
    ) -> Result<(), ReadError> {
        let number = faces
            .surfaces
            .number(&self.full_name(instance, &surface.name));
        for (item, face) in &surface.items {
            for placed in self.members(instance, item)? {
                self.spend(1)?;
                self.add_known(placed, *face, number, surface.place, faces);
            }
        }
        Ok(())
    }

    /// Adds the faces with radiation loads, an object for each cavity, in the order in which CalculiX numbers them:
    /// by element, and of an element that whose load comes last first.
    fn collect_loads(&mut self, faces: &mut SurfaceFaces) -> Result<(), ReadError> {
        let model = self.model;
        let numbers = &model.parts[0].element_numbers;
        let numbers: HashMap<u32, u32> = numbers.iter().map(|(&n, &index)| (index, n)).collect();
        let (mut loaded, mut seen) = (Vec::new(), HashSet::new());
        for (load, known) in model.loads.iter().zip(0u32..) {
            for placed in self.members(0, &load.item)? {
                self.spend(1)?;
                // A load that a later step repeats is the same one.
                if !seen.insert((placed, load.face)) {
                    continue;
                }
                let number = numbers.get(&placed.1).copied().unwrap_or(placed.1);
                loaded.push(((number, u32::MAX - known), placed, load));
            }
        }
        loaded.sort_by_key(|(order, ..)| *order);
        for (_, placed, load) in loaded {
            let number = faces.surfaces.number(&load.cavity);
            self.add_known(placed, load.face, number, load.place, faces);
        }
        if self.sectors > 0 {
            let message = "--revolve: a row for each facet around the axis, where *VIEWFACTOR, READ has one for each face";
            self.warnings.add_whole(&model.files[0], message);
        }
        if model
            .loads
            .iter()
            .any(|load| load.cavity != model.loads[0].cavity)
        {
            let message = "several cavities, each an object: *VIEWFACTOR, READ numbers the faces of all of them together";
            self.warnings.add_whole(&model.files[0], message);
        }
        Ok(())
    }

    /// Adds a face to a surface, if its element has it and no surface before; warns if not.
    fn add_known(
        &mut self,
        placed: PlacedElement,
        face: ElementFace,
        number: usize,
        (file, line): (u32, u32),
        faces: &mut SurfaceFaces,
    ) {
        let problem = match face.of(self.element(placed).kind) {
            Some(face) => self.add_face(placed, face, number, faces),
            None => Err("face that its element does not have: skipped"),
        };
        if let Err(message) = problem {
            let file = &self.model.files[file as usize];
            let place = || Position::Line(line, 1);
            self.warnings.add(file, message.to_owned(), place);
        }
    }

    /// Adds a face of an element to a surface, or says why not.
    fn add_face(
        &self,
        placed: PlacedElement,
        face: ElementFace,
        surface: usize,
        faces: &mut SurfaceFaces,
    ) -> Result<(), &'static str> {
        let kind = self.element(placed).kind;
        let shapes = self.shapes(placed).ok_or(NO_NODE)?.into_iter();
        let outlines = match face {
            ElementFace::Free => {
                let free = faces.free.get_or_insert_with(|| self.free_faces());
                free.get(&placed).cloned().unwrap_or_default()
            }
            ElementFace::Number(number) => {
                let corners = kind.solid_face(number);
                let corners = corners.ok_or("face that its element does not have: skipped")?;
                let outline = |solid: Vec<u32>| corners.iter().map(|&k| solid[k]).collect();
                shapes.map(|(_, solid)| outline(solid)).collect()
            }
            ElementFace::Front => shapes.map(|(_, shell)| shell).collect(),
            ElementFace::Back => {
                let turned = |shell: Vec<u32>| shell.into_iter().rev().collect();
                shapes.map(|(_, shell)| turned(shell)).collect()
            }
        };
        let mut result = Ok(());
        for outline in outlines {
            let corners = face_key(&outline);
            let key = (placed, corners, face == ElementFace::Back);
            if corners[2] == u32::MAX {
                result = Err("face with fewer than three different corners: skipped");
            } else if faces.known.insert(key) {
                faces.surfaces.push(surface, &outline, &self.positions);
            } else {
                result = Err("face that an earlier surface has: it stays there");
            }
        }
        result
    }

    /// The faces of each solid that no other one shares.
    fn free_faces(&self) -> HashMap<PlacedElement, Vec<Vec<u32>>> {
        let (mut volumes, mut cells) = (VolumeBoundary::new(), Vec::new());
        for placed in self.all() {
            for (shape, corners) in self.shapes(placed).into_iter().flatten() {
                if let FiniteShape::Cell(kind) = shape {
                    volumes.add_cell(kind, &corners, cells.len() as u32);
                    cells.push(placed);
                }
            }
        }
        let mut free: HashMap<PlacedElement, Vec<Vec<u32>>> = HashMap::new();
        for mut face in volumes.faces() {
            face.turn_outwards(|c| self.positions[c as usize]);
            let cell = cells[face.tag as usize];
            free.entry(cell).or_default().push(face.corners);
        }
        free
    }

    /// All elements of all instances.
    fn all(&self) -> impl Iterator<Item = PlacedElement> + use<'a> {
        let counts = self.instances.iter().map(|i| i.part.elements.len() as u32);
        let counts: Vec<u32> = counts.collect();
        let instance_elements = |(i, count): (usize, u32)| (0..count).map(move |e| (i as u32, e));
        counts.into_iter().enumerate().flat_map(instance_elements)
    }

    /// Counts the shells that no surface has.
    fn count_others(&mut self, faces: &SurfaceFaces) {
        let named: HashSet<PlacedElement> = faces.known.iter().map(|(e, ..)| *e).collect();
        let is_shell = |e: &PlacedElement| !self.element(*e).kind.is_solid();
        let others = self
            .all()
            .filter(|e| is_shell(e) && !named.contains(e))
            .count();
        let message = "shell without a surface, beside others that have one (*SURFACE): skipped";
        let file = &self.model.files[0];
        self.warnings
            .add_many(file, message.to_owned(), others, || Position::Whole);
    }

    /// Adds all shells and the boundary of all solids to surfaces by their sets.
    fn collect_sets(&mut self, surfaces: &mut NamedSurfaces) -> Result<(), ReadError> {
        let mut mesh = FiniteMesh::default();
        for instance in 0..self.instances.len() as u32 {
            let part = self.instances[instance as usize].part;
            let owners = self.owners(instance, part)?;
            let mut numbers: HashMap<u32, usize> = HashMap::new();
            for (index, set) in owners.into_iter().enumerate() {
                let placed = (instance, index as u32);
                let number = *numbers.entry(set).or_insert_with(|| {
                    let name = part
                        .sets
                        .get(set as usize)
                        .map_or(&*part.name, |s| &*s.name);
                    let name = self.full_name(instance, name);
                    mesh.surface(if name.is_empty() { "elements" } else { &name })
                });
                let Some(shapes) = self.shapes(placed) else {
                    self.warnings.add_whole(&self.model.files[0], NO_NODE);
                    continue;
                };
                for (shape, corners) in shapes {
                    mesh.add(shape, &corners, number);
                }
            }
        }
        let file = &self.model.files[0];
        mesh.finish(&self.positions, surfaces, file, self.warnings);
        Ok(())
    }

    /// The set that names each element: that of its keyword; else the first one with a section, as sections
    /// divide the elements; else the first one that no program has made for itself.
    fn owners(&mut self, instance: u32, part: &'a AbaqusPart) -> Result<Vec<u32>, ReadError> {
        let is_named = |set: u32| part.sets.get(set as usize).is_some_and(|s| !s.is_internal);
        let own = |e: &PartElement| if is_named(e.set) { e.set } else { NO_SET };
        let mut owners: Vec<u32> = part.elements.iter().map(own).collect();
        let sections: Vec<u32> = part
            .sections
            .iter()
            .filter_map(|s| part.known_set(s))
            .collect();
        let sets = 0..part.sets.len() as u32;
        let order = (sections.iter().copied().filter(|&s| is_named(s)))
            .chain(sets.filter(|&s| is_named(s)))
            .chain(sections.iter().copied().filter(|&s| !is_named(s)));
        let mut left = owners.iter().filter(|&&o| o == NO_SET).count();
        for set in order {
            if left == 0 {
                break;
            }
            let items: &'a [ElementItem] = &part.sets[set as usize].items;
            for item in items {
                for (_, element) in self
                    .members(instance, item)?
                    .into_iter()
                    .filter(|m| m.0 == instance)
                {
                    let owner = &mut owners[element as usize];
                    left -= usize::from(*owner == NO_SET);
                    if *owner == NO_SET {
                        *owner = set;
                    }
                }
            }
        }
        for (owner, element) in owners.iter_mut().zip(&part.elements) {
            if *owner == NO_SET {
                *owner = element.set;
            }
        }
        Ok(owners)
    }
}

/// The most corners of an element.
const CORNERS: [usize; 8] = [0, 1, 2, 3, 4, 5, 6, 7];

/// The warning for elements that miss a node.
const NO_NODE: &str = "element with a node that does not exist: skipped";
