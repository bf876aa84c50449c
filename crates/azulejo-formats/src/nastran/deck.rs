//! The content of a file and of those that it includes, and the surfaces that it makes.

use super::coordinates::{DefinedSystem, GridPoint, SystemFault, SystemResolver};
use super::elements::BulkElement;
use super::names::PropertyNames;
use super::thermal::RadiationDeck;
use crate::reading::warnings::Warnings;
use crate::surface::finite::FiniteMesh;
use crate::surface::named::NamedSurfaces;
use crate::{Position, ReadError};
use azulejo_scene::Scene;
use glam::DVec3;
use std::collections::HashMap;

/// What a model in bulk data consists of.
#[derive(Default)]
pub(super) struct BulkDeck {
    /// The names of its files, that of the model first.
    pub files: Vec<String>,
    /// Grid points in the order of their cards.
    pub grids: Vec<GridPoint>,
    /// The index of each grid point.
    pub grid_numbers: HashMap<u32, u32>,
    /// The coordinate system of grid points that do not state one.
    pub default_system: u32,
    pub systems: HashMap<u32, DefinedSystem>,
    pub elements: Vec<BulkElement>,
    pub names: PropertyNames,
    pub radiation: RadiationDeck,
}

/// Grid points in the basic coordinate system.
pub(super) struct PlacedGrids<'a> {
    numbers: &'a HashMap<u32, u32>,
    pub positions: Vec<DVec3>,
}

impl PlacedGrids<'_> {
    /// The indices of grid points, if they all exist.
    pub fn of(&self, numbers: &[u32]) -> Option<Vec<u32>> {
        let index = |number: &u32| self.numbers.get(number).copied();
        numbers.iter().map(index).collect()
    }
}

impl BulkDeck {
    /// The file of a place.
    pub fn file(&self, place: (u32, u32)) -> &str {
        &self.files[place.0 as usize]
    }

    /// The surfaces as objects: elements for radiation if there are any, else shells and the boundary of
    /// solids by their property.
    pub fn scene(&self, warnings: &mut Warnings) -> Result<Scene, ReadError> {
        let grids = self.placed()?;
        let mut surfaces = NamedSurfaces::default();
        if self.radiation.elements.is_empty() {
            self.collect(&grids, &mut surfaces, warnings);
        } else {
            let message =
                "element without radiation, beside elements that have it (CHBDY): skipped";
            let file = self.file((0, 0));
            warnings.add_many(file, message.to_owned(), self.elements.len(), || {
                Position::Whole
            });
            self.radiation
                .collect(self, &grids, &mut surfaces, warnings);
        }
        Ok(surfaces.scene(&grids.positions, self.file((0, 0)), warnings))
    }

    /// All grid points in the basic system.
    fn placed(&self) -> Result<PlacedGrids<'_>, ReadError> {
        let grid = |number: u32| {
            let grid = self.grids[*self.grid_numbers.get(&number)? as usize];
            Some(GridPoint {
                system: grid.system.or(Some(self.default_system)),
                ..grid
            })
        };
        let mut systems = SystemResolver::new(&self.systems, &grid);
        let mut positions = Vec::with_capacity(self.grids.len());
        for grid in &self.grids {
            let number = grid.system.unwrap_or(self.default_system);
            let system = systems.place(number).map_err(|fault| self.fault(fault))?;
            positions.push(system.basic(grid.coordinates));
        }
        Ok(PlacedGrids {
            numbers: &self.grid_numbers,
            positions,
        })
    }

    /// The error for a coordinate system that has no place.
    fn fault(&self, fault: SystemFault) -> ReadError {
        let (at, found, expected) = match fault {
            SystemFault::Circle(system) => (
                system,
                format!("coordinate system {system}, which is defined by itself"),
                "one that the basic system leads to".to_owned(),
            ),
            SystemFault::Missing(system, needed) => (
                system,
                format!("coordinate system {needed}, which does not exist"),
                "one of CORD1R, CORD1C, CORD1S, CORD2R, CORD2C, CORD2S".to_owned(),
            ),
            SystemFault::NoGrid(system, grid) => (
                system,
                format!("coordinate system {system} at grid point {grid}, which does not exist"),
                "three grid points".to_owned(),
            ),
            SystemFault::Flat(system) => (
                system,
                format!("coordinate system {system}, whose three points are on one line"),
                "an origin, a point on its z axis, and one beside that".to_owned(),
            ),
        };
        let place = self.systems.get(&at).map(|s| s.place);
        let file = self.file(place.unwrap_or((0, 0)));
        let error = ReadError::whole(file, found, expected);
        match place {
            Some((_, line)) => ReadError {
                position: Position::Line(line, 1),
                ..error
            },
            None => error,
        }
    }

    /// Adds shells and the boundary of solids.
    fn collect(&self, grids: &PlacedGrids, surfaces: &mut NamedSurfaces, warnings: &mut Warnings) {
        let mut mesh = FiniteMesh::default();
        for element in &self.elements {
            let Some(corners) = grids.of(element.corners()) else {
                let message = "element with a grid point that does not exist: skipped";
                let place = || Position::Line(element.place.1, 1);
                warnings.add(self.file(element.place), message.to_owned(), place);
                continue;
            };
            let surface = mesh.surface(&self.names.name(element.property));
            mesh.add(element.shape, &corners, surface);
        }
        mesh.finish(&grids.positions, surfaces, self.file((0, 0)), warnings);
    }
}
