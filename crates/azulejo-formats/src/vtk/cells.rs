//! The types of cells, and what surface each has.

use super::piece::VtkPiece;
use crate::surface::boundary::{CellKind, VolumeBoundary};

/// The type of cells that list their faces.
pub(super) const POLYHEDRON: i64 = 42;

/// What a cell is, whatever its order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CellClass {
    /// A point or a line, which has no area, or nothing at all.
    Line,
    /// A polygon of all its points.
    Polygon,
    /// A polygon of this number of its first points.
    Corners(usize),
    /// A polygon of the first half of its points.
    FirstHalf,
    Strip,
    /// A rectangle whose points are in the order of pixels.
    Pixel,
    /// A box whose points are in the order of pixels.
    Voxel,
    Cell(CellKind),
    Polyhedron,
    /// A prism with this number of corners at each end.
    Column(usize),
    Unknown,
}

impl CellClass {
    /// The class of a type; [`CellClass::Unknown`] for shapes that only parametric programs have.
    pub fn of(kind: u8) -> CellClass {
        match kind {
            0..=4 | 21 | 35 | 51 | 60 | 68 | 75 => CellClass::Line,
            5 | 7 | 9 => CellClass::Polygon,
            6 => CellClass::Strip,
            8 => CellClass::Pixel,
            11 => CellClass::Voxel,
            22 | 34 | 61 | 69 | 76 => CellClass::Corners(3),
            23 | 28 | 30 | 62 | 70 | 77 => CellClass::Corners(4),
            36 => CellClass::FirstHalf,
            10 | 24 | 64 | 71 | 78 => CellClass::Cell(CellKind::Tetrahedron),
            12 | 25 | 29 | 33 | 65 | 72 | 79 => CellClass::Cell(CellKind::Hexahedron),
            13 | 26 | 31 | 32 | 66 | 73 | 80 => CellClass::Cell(CellKind::Prism),
            14 | 27 | 37 | 67 | 74 | 81 => CellClass::Cell(CellKind::Pyramid),
            15 => CellClass::Column(5),
            16 => CellClass::Column(6),
            42 => CellClass::Polyhedron,
            _ => CellClass::Unknown,
        }
    }

    /// Whether cells of this class are volumes.
    pub fn is_volume(self) -> bool {
        matches!(
            self,
            CellClass::Voxel | CellClass::Cell(_) | CellClass::Polyhedron | CellClass::Column(_)
        )
    }

    /// Whether cells of this class are surfaces.
    pub fn is_surface(self) -> bool {
        !self.is_volume() && !matches!(self, CellClass::Line | CellClass::Unknown)
    }
}

/// The polygons of a cell that is a surface; those of another are none.
pub(super) fn polygons(class: CellClass, points: &[u32], mut push: impl FnMut(&[u32])) {
    match class {
        CellClass::Polygon => push(points),
        CellClass::Corners(count) => push(points.get(..count).unwrap_or_default()),
        CellClass::FirstHalf => push(&points[..points.len() / 2]),
        CellClass::Pixel => match *points {
            [a, b, c, d] => push(&[a, b, d, c]),
            _ => push(&[]),
        },
        CellClass::Strip => {
            for (k, corners) in points.windows(3).enumerate() {
                let &[a, b, c] = corners else { continue };
                // A point that is repeated only changes the orientation.
                if a == b || b == c || c == a {
                    continue;
                }
                push(&if k % 2 == 0 { [a, b, c] } else { [b, a, c] });
            }
        }
        _ => {}
    }
}

/// Adds a cell that is a volume; says whether it could be, by the number of its points.
pub(super) fn add_volume(
    boundary: &mut VolumeBoundary,
    class: CellClass,
    points: &[u32],
    tag: u32,
) -> bool {
    match (class, points) {
        (CellClass::Voxel, &[a, b, c, d, e, f, g, h]) => {
            boundary.add_cell(CellKind::Hexahedron, &[a, b, d, c, e, f, h, g], tag);
            true
        }
        (CellClass::Cell(kind), _) if points.len() >= kind.corner_count() => {
            boundary.add_cell(kind, points, tag);
            true
        }
        (CellClass::Column(corners), _) if points.len() == 2 * corners => {
            add_column(boundary, points, tag);
            true
        }
        (CellClass::Polyhedron, _) => add_polyhedron(boundary, points, tag).is_some(),
        _ => false,
    }
}

/// A prism between two polygons.
fn add_column(boundary: &mut VolumeBoundary, points: &[u32], tag: u32) {
    let (base, top) = points.split_at(points.len() / 2);
    let reversed: Vec<u32> = base.iter().rev().copied().collect();
    boundary.add_face(&reversed, Some(top[0]), tag);
    boundary.add_face(top, Some(base[0]), tag);
    for k in 0..base.len() {
        let next = (k + 1) % base.len();
        let opposite = base[(k + base.len() / 2 + 1) % base.len()];
        let side = [base[k], base[next], top[next], top[k]];
        boundary.add_face(&side, Some(opposite), tag);
    }
}

/// A cell by its faces: how many, and for each its number of points and these. `None` if there are fewer.
fn add_polyhedron(boundary: &mut VolumeBoundary, stream: &[u32], tag: u32) -> Option<()> {
    let (&count, mut rest) = stream.split_first()?;
    let mut faces = Vec::new();
    for _ in 0..count {
        let (&points, behind) = rest.split_first()?;
        let (face, behind) = behind.split_at_checked(points as usize)?;
        faces.push(face);
        rest = behind;
    }
    let mut points: Vec<u32> = faces.iter().flat_map(|f| f.iter().copied()).collect();
    points.sort_unstable();
    points.dedup();
    let mut own = Vec::new();
    for face in faces {
        own.clear();
        own.extend_from_slice(face);
        own.sort_unstable();
        // Any other point of the cell lies behind the face, if the cell is convex. One of the first is none
        // of the face's own, so that the search is short.
        let inner = points.iter().find(|p| own.binary_search(p).is_err());
        boundary.add_face(face, inner.copied(), tag);
    }
    Some(())
}

impl VtkPiece {
    /// Whether a cell belongs to another piece, or is hidden.
    pub fn is_ghost(&self, cell: usize) -> bool {
        const DUPLICATE: i64 = 1;
        const HIDDEN: i64 = 32;
        let flags = self.ghosts.get(cell).copied().unwrap_or(0);
        flags & (DUPLICATE | HIDDEN) != 0
    }
}
