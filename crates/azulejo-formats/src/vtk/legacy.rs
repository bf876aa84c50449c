//! Legacy files: keywords with numbers behind them, as text or as big-endian binary.

use super::legacy_source::{LegacySource, unescaped};
use super::piece::{ArrayUse, VtkPiece};
use super::values::{VtkType, VtkValues};
use crate::reading::text::{quoted, shortened};
use crate::reading::warnings::Warnings;
use crate::{Position, ReadError};

/// Reads a file that begins with `# vtk DataFile Version`.
pub(super) fn read(
    bytes: &[u8],
    file: &str,
    warnings: &mut Warnings,
) -> Result<VtkPiece, ReadError> {
    let mut reader = LegacyReader {
        source: LegacySource::new(bytes, file)?,
        piece: VtkPiece::default(),
        values: 0,
        of_cells: false,
        has_types: true,
        skipped: 0,
        warnings,
    };
    reader.data_set()?;
    while let Some(keyword) = reader.source.keyword() {
        reader.section(&keyword)?;
    }
    if !reader.has_types {
        let expected = "CELL_TYPES, without which cells of an unstructured grid are unknown";
        return Err(reader.source.error_before(expected));
    }
    let message = "array of points or cells: skipped".to_owned();
    let skipped = reader.skipped;
    reader
        .warnings
        .add_many(file, message, skipped, || Position::Whole);
    Ok(reader.piece)
}

struct LegacyReader<'a, 'w> {
    source: LegacySource<'a>,
    piece: VtkPiece,
    /// Number of values in each array of the current section.
    values: usize,
    /// Whether the arrays of the current section belong to cells.
    of_cells: bool,
    /// Whether the types of all cells are known.
    has_types: bool,
    skipped: usize,
    warnings: &'w mut Warnings,
}

impl LegacyReader<'_, '_> {
    /// The kind of data set.
    fn data_set(&mut self) -> Result<(), ReadError> {
        let expected = "DATASET POLYDATA or DATASET UNSTRUCTURED_GRID";
        loop {
            let keyword = self.source.keyword().unwrap_or_default();
            if keyword == "FIELD" {
                self.field()?;
                continue;
            }
            let source = &mut self.source;
            if keyword != "DATASET" {
                return Err(source.error_before(expected));
            }
            let (at, kind) = source.word();
            return match kind.to_ascii_uppercase().as_slice() {
                b"POLYDATA" | b"UNSTRUCTURED_GRID" => Ok(()),
                b"STRUCTURED_GRID" | b"RECTILINEAR_GRID" | b"STRUCTURED_POINTS" | b"FIELD" => {
                    let found = format!(
                        "a data set of the kind {}",
                        shortened(&String::from_utf8_lossy(kind))
                    );
                    let expected = format!("{expected} (in ParaView: the filter Extract Surface)");
                    Err(source.error(at, found, expected))
                }
                _ => Err(source.error(at, quoted(kind), expected)),
            };
        }
    }

    fn section(&mut self, keyword: &str) -> Result<(), ReadError> {
        match keyword {
            "POINTS" => self.points(),
            "CELLS" => self.cells(None),
            "VERTICES" => self.cells(Some(2)),
            "LINES" => self.cells(Some(4)),
            "POLYGONS" => self.cells(Some(7)),
            "TRIANGLE_STRIPS" => self.cells(Some(6)),
            "CELL_TYPES" => self.cell_types(),
            "POINT_DATA" | "CELL_DATA" => {
                self.of_cells = keyword == "CELL_DATA";
                self.values = self.source.count("a number of values")?;
                self.source.end_line();
                Ok(())
            }
            "METADATA" => {
                self.source.skip_paragraph();
                Ok(())
            }
            "FIELD" => self.field(),
            _ => self.attribute(keyword),
        }
    }

    fn points(&mut self) -> Result<(), ReadError> {
        let count = self.source.count("a number of points")?;
        let kind = self.source.kind()?;
        self.source.end_line();
        let values = self.source.values(kind, count, 3)?;
        self.piece.is_single = kind == VtkType::Real(4);
        self.piece.set_points(&values.into_reals());
        Ok(())
    }

    /// Lists of points: of one kind of cell, or of kinds that follow.
    fn cells(&mut self, kind: Option<u8>) -> Result<(), ReadError> {
        self.has_types &= kind.is_some();
        let count = self.source.count("a number of cells")?;
        let size = self.source.count("a number of integers")?;
        self.source.end_line();
        if self.source.version < 5.0 {
            let start = self.source.offset();
            let list = self.source.values(VtkType::Signed(4), size, 1)?;
            return self.cells_of_list(&list.into_integers(), count, kind, start);
        }
        let start = self.source.offset();
        let offsets = self.offsets("OFFSETS", count)?;
        let points = self.offsets("CONNECTIVITY", size)?;
        for pair in offsets.windows(2) {
            let range = usize::try_from(pair[0])
                .ok()
                .zip(usize::try_from(pair[1]).ok());
            let cell = range.and_then(|(from, to)| points.get(from..to));
            let Some(cell) = cell else {
                let found = format!("a cell of the points {} to {}", pair[0], pair[1]);
                let expected = format!("offsets up to {} in ascending order", points.len());
                return Err(self.source.error(start, found, expected));
            };
            self.piece.cell(kind.unwrap_or(0), cell.iter().copied());
        }
        Ok(())
    }

    /// One of the two arrays of cells since version 5.
    fn offsets(&mut self, keyword: &str, count: usize) -> Result<Vec<i64>, ReadError> {
        if self.source.keyword().as_deref() != Some(keyword) {
            return Err(self.source.error_before(keyword));
        }
        let kind = self.source.kind()?;
        self.source.end_line();
        Ok(self.source.values(kind, count, 1)?.into_integers())
    }

    /// Cells up to version 4: the number of points before the points of each.
    fn cells_of_list(
        &mut self,
        list: &[i64],
        count: usize,
        kind: Option<u8>,
        start: usize,
    ) -> Result<(), ReadError> {
        let mut rest = list;
        let mut cells = 0;
        while let Some((&points, behind)) = rest.split_first() {
            let cell = usize::try_from(points)
                .ok()
                .and_then(|n| behind.split_at_checked(n));
            let Some((cell, behind)) = cell else {
                let found = format!(
                    "a cell of {points} points, with {} integers left",
                    behind.len()
                );
                return Err(self.source.error(start, found, "no more than there are"));
            };
            self.piece.cell(kind.unwrap_or(0), cell.iter().copied());
            rest = behind;
            cells += 1;
        }
        if cells == count {
            return Ok(());
        }
        Err(self.source.error(
            start,
            format!("{cells} cells"),
            format!("{count}, as stated"),
        ))
    }

    fn cell_types(&mut self) -> Result<(), ReadError> {
        let count = self.source.count("a number of cells")?;
        self.source.end_line();
        let start = self.source.offset();
        let kinds = self
            .source
            .values(VtkType::Signed(4), count, 1)?
            .into_integers();
        if kinds.len() != self.piece.kinds.len() {
            let expected = format!("{}, as there are cells", self.piece.kinds.len());
            return Err(self
                .source
                .error(start, format!("{count} types of cells"), expected));
        }
        self.has_types = true;
        let kind = |k| u8::try_from(k).unwrap_or(u8::MAX);
        self.piece.kinds = kinds.into_iter().map(kind).collect();
        Ok(())
    }

    /// An array by its old form, with a keyword for its meaning.
    fn attribute(&mut self, keyword: &str) -> Result<(), ReadError> {
        let components = match keyword {
            "SCALARS" => 1,
            "VECTORS" | "NORMALS" => 3,
            "TENSORS" => 9,
            "TENSORS6" => 6,
            "GLOBAL_IDS" | "PEDIGREE_IDS" => 1,
            "TEXTURE_COORDINATES" | "COLOR_SCALARS" => 0,
            "LOOKUP_TABLE" => return self.lookup_table(),
            _ => return Err(self.source.error_before("a keyword of legacy VTK files")),
        };
        let (_, name) = self.source.word();
        let name = String::from_utf8_lossy(name).into_owned();
        if keyword == "COLOR_SCALARS" {
            let components = self.source.count("a number of channels")?;
            self.source.end_line();
            let is_used = self.of_cells && ArrayUse::of(&unescaped(&name)) != ArrayUse::Nothing;
            if is_used && components == 1 && !self.source.is_binary {
                return self.grey_levels(&unescaped(&name));
            }
            return self.array(&name, self.color_kind(), self.values, components);
        }
        let components = match keyword {
            "TEXTURE_COORDINATES" => self.source.count("a number of coordinates")?,
            _ => components,
        };
        let kind = self.source.kind()?;
        let stated = match keyword {
            "SCALARS" => self.source.count_on_line(),
            _ => None,
        };
        self.source.end_line();
        if keyword == "SCALARS" {
            self.source.pass_line("LOOKUP_TABLE");
        }
        self.array(&name, kind, self.values, stated.unwrap_or(components))
    }

    /// Unsigned bytes or bools as text, which has their shares of 255.
    fn grey_levels(&mut self, name: &str) -> Result<(), ReadError> {
        let values = self.source.values(self.color_kind(), self.values, 1)?;
        if let VtkValues::Reals(shares) = values {
            let levels = shares.iter().map(|share| (255.0 * share).round() as i64);
            let levels = VtkValues::Integers(levels.collect());
            self.piece.cell_array(name, levels);
        }
        Ok(())
    }

    /// A table of colours, of four channels each.
    fn lookup_table(&mut self) -> Result<(), ReadError> {
        self.source.word();
        let count = self.source.count("a number of colours")?;
        self.source.end_line();
        self.source.skip(self.color_kind(), count, 4)
    }

    /// The type of the channels of colours, which are shares of one in text.
    fn color_kind(&self) -> VtkType {
        if self.source.is_binary {
            VtkType::Unsigned(1)
        } else {
            VtkType::Real(4)
        }
    }

    /// Arrays by the new form, each with its own length.
    fn field(&mut self) -> Result<(), ReadError> {
        self.source.word();
        let count = self.source.count("a number of arrays")?;
        for _ in 0..count {
            self.source.pass_metadata();
            let (_, name) = self.source.word();
            let name = String::from_utf8_lossy(name).into_owned();
            let components = self.source.count("a number of components")?;
            let tuples = self.source.count("a number of tuples")?;
            let kind = self.source.kind()?;
            self.source.end_line();
            self.array(&name, kind, tuples, components)?;
        }
        Ok(())
    }

    /// The values of an array, which are kept if they divide the cells.
    fn array(
        &mut self,
        name: &str,
        kind: VtkType,
        tuples: usize,
        components: usize,
    ) -> Result<(), ReadError> {
        // Blanks are written as %20.
        let name = unescaped(name);
        if self.of_cells && components == 1 && ArrayUse::of(&name) != ArrayUse::Nothing {
            let values = self.source.values(kind, tuples, components)?;
            self.piece.cell_array(&name, values);
            return Ok(());
        }
        self.skipped += 1;
        self.source.skip(kind, tuples, components)
    }
}
