//! Meshes of VTK: legacy files, `.vtk`, and files in XML, `.vtu` and `.vtp`.
//!
//! Cells that are surfaces are read, with an object for each value of an array that divides them; of volumes
//! alone the boundary. `docs/formats/vtk.md` has the details.

mod arrays;
mod cells;
mod legacy;
mod legacy_source;
mod piece;
#[cfg(test)]
mod tests;
mod values;
mod xml;

use crate::reading::options::check_length;
use crate::reading::text::decoded;
use crate::reading::warnings::Warnings;
use crate::surface::boundary::VolumeBoundary;
use crate::surface::named::NamedSurfaces;
use crate::surface::single;
use crate::surface::weld::Welder;
use crate::{Files, Loaded, Position, ReadError, ReadOptions};
use azulejo_scene::Scene;
use cells::{CellClass, add_volume, polygons};
use glam::DVec3;
use piece::VtkPiece;
use std::collections::HashMap;
use values::VtkValues;

/// The object of cells that nothing divides.
const UNNAMED: &str = "surfaces";

/// Reads a model. `name` is used in messages; the files refer to no others.
///
/// # Errors
/// Other kinds of data sets, malformed XML, words that are not numbers, fewer values than the file states,
/// compression other than zlib's, and cells without surfaces that are of an unknown type.
pub fn read(
    bytes: &[u8],
    name: &str,
    _files: &dyn Files,
    options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    check_length(bytes, name)?;
    let bytes = &*decoded(bytes);
    let mut warnings = Warnings::default();
    let pieces = if bytes.starts_with(b"# vtk") {
        vec![legacy::read(bytes, name, &mut warnings)?]
    } else {
        xml::read(bytes, name, options, &mut warnings)?
    };
    let mut builder = VtkBuilder {
        file: name,
        warnings,
        surfaces: NamedSurfaces::default(),
        positions: Vec::new(),
        names: Vec::new(),
        counts: Skipped::default(),
    };
    let is_single = pieces.iter().any(|piece| piece.is_single);
    builder.pieces(pieces)?;
    let (scene, mut warnings) = builder.finish();
    if is_single {
        single::warn(&scene, name, &mut warnings);
    }
    Ok(Loaded {
        scene,
        warnings: warnings.finish(name),
    })
}

/// Cells that are not read.
#[derive(Default)]
struct Skipped {
    lines: usize,
    volumes: usize,
    curved: usize,
    ghosts: usize,
    unknown: usize,
    odd: usize,
    odd_arrays: usize,
}

struct VtkBuilder<'a> {
    file: &'a str,
    warnings: Warnings,
    surfaces: NamedSurfaces,
    /// The points of all pieces.
    positions: Vec<DVec3>,
    /// Names of objects of volumes, by tag.
    names: Vec<String>,
    counts: Skipped,
}

impl VtkBuilder<'_> {
    fn pieces(&mut self, mut pieces: Vec<VtkPiece>) -> Result<(), ReadError> {
        for piece in &mut pieces {
            self.counts.odd_arrays += piece.drop_odd_arrays();
        }
        let has = |is: fn(CellClass) -> bool| {
            let mut kinds = pieces.iter().flat_map(|p| &p.kinds);
            kinds.any(|&kind| is(CellClass::of(kind)))
        };
        let are_volumes = has(CellClass::is_volume) && !has(CellClass::is_surface);
        let several = pieces.len() > 1;
        let mut volumes = VtkVolumes::default();
        for (number, piece) in pieces.into_iter().enumerate() {
            let default = if several {
                format!("piece {}", number + 1)
            } else {
                UNNAMED.to_owned()
            };
            if are_volumes {
                self.volumes(piece, &default, several, &mut volumes)?;
            } else {
                self.polygons(piece, &default);
            }
        }
        if are_volumes {
            self.positions.append(&mut volumes.welder.positions);
            let names = std::mem::take(&mut self.names);
            self.surfaces.push_boundary(
                &volumes.boundary,
                &self.positions,
                |tag| names[tag as usize].clone(),
                self.file,
                &mut self.warnings,
            );
        }
        Ok(())
    }

    /// The cells of a piece that are surfaces.
    fn polygons(&mut self, piece: VtkPiece, default: &str) {
        let base = self.positions.len() as u32;
        self.positions.extend_from_slice(&piece.points);
        let mut rows = RowNames::new(&piece, default);
        let mut corners = Vec::new();
        for (cell, (&kind, points)) in std::iter::zip(&piece.kinds, piece.cells.iter()).enumerate()
        {
            let class = CellClass::of(kind);
            if !self.is_kept(&piece, cell, class) {
                continue;
            }
            self.counts.curved += usize::from(matches!(class, CellClass::Corners(_)));
            let surface = rows.number(cell, |name| self.surfaces.number(name));
            polygons(class, points, |polygon| {
                corners.clear();
                // Points that do not exist must not become those of other pieces.
                let is_there = |p: u32| (p as usize) < piece.points.len();
                let known = |&p: &u32| if is_there(p) { p + base } else { u32::MAX };
                corners.extend(polygon.iter().map(known));
                self.surfaces.push(surface, &corners, &self.positions);
            });
        }
    }

    /// Counts a cell that is not a surface.
    fn is_kept(&mut self, piece: &VtkPiece, cell: usize, class: CellClass) -> bool {
        let counts = &mut self.counts;
        let count = match class {
            _ if piece.is_ghost(cell) => &mut counts.ghosts,
            CellClass::Line => &mut counts.lines,
            CellClass::Unknown => &mut counts.unknown,
            _ if class.is_volume() => &mut counts.volumes,
            _ => return true,
        };
        *count += 1;
        false
    }

    /// The cells of a piece that are volumes, with equal points merged if another piece may have them.
    fn volumes(
        &mut self,
        piece: VtkPiece,
        default: &str,
        several: bool,
        volumes: &mut VtkVolumes,
    ) -> Result<(), ReadError> {
        let places: Vec<u32> = if several {
            piece
                .points
                .iter()
                .map(|&p| volumes.welder.index(p))
                .collect()
        } else {
            self.positions.extend_from_slice(&piece.points);
            Vec::new()
        };
        let place = |p: u32| {
            if several {
                places.get(p as usize).copied().unwrap_or(u32::MAX)
            } else {
                p
            }
        };
        let mut rows = RowNames::new(&piece, default);
        let mut corners = Vec::new();
        for (cell, (&kind, points)) in std::iter::zip(&piece.kinds, piece.cells.iter()).enumerate()
        {
            let class = CellClass::of(kind);
            if piece.is_ghost(cell) {
                self.counts.ghosts += 1;
                continue;
            }
            match class {
                CellClass::Line => self.counts.lines += 1,
                CellClass::Unknown => {
                    let expected = "tetrahedra, pyramids, prisms, hexahedra or polyhedra, as the boundary of \
                                    volumes needs all of them";
                    let found = format!("a cell of the type {kind}");
                    return Err(ReadError::whole(self.file, found, expected));
                }
                _ => {
                    let names = &mut self.names;
                    let tag = rows.number(cell, |name| {
                        names.push(name.to_owned());
                        names.len() - 1
                    });
                    corners.clear();
                    // The numbers of points in a polyhedron are not points.
                    let is_stream = class == CellClass::Polyhedron;
                    corners.extend(points.iter().map(|&p| if is_stream { p } else { place(p) }));
                    if is_stream && several {
                        place_faces(&mut corners, place);
                    }
                    if !add_volume(&mut volumes.boundary, class, &corners, tag as u32) {
                        self.counts.odd += 1;
                    }
                }
            }
        }
        Ok(())
    }

    fn finish(mut self) -> (Scene, Warnings) {
        let counts = [
            (
                "point or line cell: skipped, as it has no area",
                self.counts.lines,
            ),
            (
                "volume cell: skipped, as the file has cells that are surfaces",
                self.counts.volumes,
            ),
            (
                "cell of second or higher order: read as flat, between its corners",
                self.counts.curved,
            ),
            (
                "cell that another piece has, or that is hidden: skipped",
                self.counts.ghosts,
            ),
            ("cell of an unknown type: skipped", self.counts.unknown),
            ("volume cell with too few points: skipped", self.counts.odd),
            (
                "cell array that has not one value for each cell: not used",
                self.counts.odd_arrays,
            ),
        ];
        for (message, count) in counts {
            self.warnings
                .add_many(self.file, message.to_owned(), count, || Position::Whole);
        }
        let scene = (self.surfaces).scene(&self.positions, self.file, &mut self.warnings);
        (scene, self.warnings)
    }
}

/// The volumes of all pieces.
struct VtkVolumes {
    boundary: VolumeBoundary,
    welder: Welder,
}

impl Default for VtkVolumes {
    fn default() -> VtkVolumes {
        VtkVolumes {
            boundary: VolumeBoundary::new(),
            welder: Welder::new(0),
        }
    }
}

/// Replaces the points in the faces of a polyhedron.
fn place_faces(stream: &mut [u32], place: impl Fn(u32) -> u32) {
    let mut at = 1;
    while let Some(&count) = stream.get(at) {
        let end = (at + 1).saturating_add(count as usize).min(stream.len());
        stream[at + 1..end].iter_mut().for_each(|p| *p = place(*p));
        at = end;
    }
}

/// Numbers for the objects of a piece's cells, each requested once by its name.
struct RowNames<'a> {
    piece: &'a VtkPiece,
    default: &'a str,
    integers: HashMap<i64, usize>,
    texts: HashMap<&'a str, usize>,
    whole: Option<usize>,
}

impl<'a> RowNames<'a> {
    fn new(piece: &'a VtkPiece, default: &'a str) -> RowNames<'a> {
        RowNames {
            piece,
            default,
            integers: HashMap::new(),
            texts: HashMap::new(),
            whole: None,
        }
    }

    /// The number of a cell's object; `number` gives that of a name.
    fn number(&mut self, cell: usize, mut number: impl FnMut(&str) -> usize) -> usize {
        let rows = self.piece.rows.as_ref();
        match rows.map(|rows| (&rows.values, &rows.array)) {
            Some((VtkValues::Integers(values), array)) => {
                let value = values[cell];
                let new = || number(&format!("{array} {value}"));
                *self.integers.entry(value).or_insert_with(new)
            }
            Some((VtkValues::Texts(values), _)) => {
                let value = values[cell].as_str();
                *self.texts.entry(value).or_insert_with(|| number(value))
            }
            _ => *self.whole.get_or_insert_with(|| number(self.default)),
        }
    }
}
