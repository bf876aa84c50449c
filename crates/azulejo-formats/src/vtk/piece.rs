//! Points and cells, as all variants of the format have them.

use super::values::VtkValues;
use azulejo_scene::Faces;
use glam::DVec3;

/// A part of a data set: points, and cells between them.
#[derive(Clone, Debug, Default)]
pub(super) struct VtkPiece {
    pub points: Vec<DVec3>,
    /// Whether their coordinates are in single precision.
    pub is_single: bool,
    /// The type of each cell.
    pub kinds: Vec<u8>,
    /// The points of each cell; `u32::MAX` for those that cannot exist. Of a polyhedron its faces: how many
    /// there are, and for each its number of points and these.
    pub cells: Faces,
    /// What divides the cells into objects.
    pub rows: Option<CellRows>,
    /// For each cell whether it belongs to another piece or is hidden; empty if none is.
    pub ghosts: Vec<i64>,
}

/// A cell array whose values are the names of objects.
#[derive(Clone, Debug)]
pub(super) struct CellRows {
    pub array: String,
    pub values: VtkValues,
}

/// Names of cell arrays that divide a mesh into surfaces, the first of which counts: azulejo's own, those
/// of gmsh, meshio, OpenFOAM, ParaView and others.
const ROWS: &str = "object group surface name physicalids gmsh:physical cellentityids materialids materialid \
     material patchid regionid groupids boundary cell_tags medit:ref gmsh:geometrical \
     geometryids";

/// Which cells are not part of a piece: duplicates of another's, and hidden ones.
const GHOST_ARRAY: &str = "vtkghosttype";

/// What a cell array is used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ArrayUse {
    /// Divides the cells into objects, the better the smaller.
    Rows(usize),
    Ghosts,
    Nothing,
}

impl ArrayUse {
    /// The use of an array by its name.
    pub fn of(name: &str) -> ArrayUse {
        let name = name.to_ascii_lowercase();
        match ROWS.split(' ').position(|known| known == name) {
            Some(rank) => ArrayUse::Rows(rank),
            None if name == GHOST_ARRAY => ArrayUse::Ghosts,
            None => ArrayUse::Nothing,
        }
    }
}

impl VtkPiece {
    /// Takes an array of the cells, if it has a use and a value for each.
    pub fn cell_array(&mut self, name: &str, values: VtkValues) {
        match ArrayUse::of(name) {
            ArrayUse::Ghosts => self.ghosts = values.into_integers(),
            ArrayUse::Rows(rank) if !matches!(values, VtkValues::Reals(_)) => {
                let current = self.rows.as_ref().map(|rows| ArrayUse::of(&rows.array));
                let is_better = match current {
                    Some(ArrayUse::Rows(other)) => rank < other,
                    _ => true,
                };
                if is_better {
                    self.rows = Some(CellRows {
                        array: name.to_owned(),
                        values,
                    });
                }
            }
            _ => {}
        }
    }

    /// Drops arrays of another length than the cells have; returns how many.
    pub fn drop_odd_arrays(&mut self) -> usize {
        let count = self.kinds.len();
        let is_odd = |rows: &CellRows| rows.values.len() != count;
        let mut dropped = 0;
        if self.rows.as_ref().is_some_and(is_odd) {
            self.rows = None;
            dropped += 1;
        }
        if !self.ghosts.is_empty() && self.ghosts.len() != count {
            self.ghosts.clear();
            dropped += 1;
        }
        dropped
    }

    /// Appends coordinates, three for each point.
    pub fn set_points(&mut self, coordinates: &[f64]) {
        let points = coordinates.chunks_exact(3);
        self.points = points.map(|p| DVec3::new(p[0], p[1], p[2])).collect();
    }

    /// Appends a cell.
    pub fn cell(&mut self, kind: u8, points: impl IntoIterator<Item = i64>) {
        self.kinds.push(kind);
        let point = |p| u32::try_from(p).unwrap_or(u32::MAX);
        self.cells.corners.extend(points.into_iter().map(point));
        self.cells.starts.push(self.cells.corners.len() as u32);
    }
}
