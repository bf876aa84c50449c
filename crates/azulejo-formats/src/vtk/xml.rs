//! Files in XML, `.vtu` and `.vtp`.

use super::arrays::{AppendedBytes, XmlArrays};
use super::piece::{ArrayUse, VtkPiece};
use super::values::{VtkType, VtkValues};
use crate::reading::text::{shortened, text};
use crate::reading::warnings::Warnings;
use crate::reading::xml::crowded_element;
use crate::{Position, ReadError, ReadOptions};
use roxmltree::{Document, Node};

/// Reads the pieces of a file.
pub(super) fn read(
    bytes: &[u8],
    file: &str,
    options: &ReadOptions,
    warnings: &mut Warnings,
) -> Result<Vec<VtkPiece>, ReadError> {
    let (head, appended) = split(bytes);
    let mut xml = text(head).into_owned();
    if appended.is_some() {
        xml.push_str("</AppendedData></VTKFile>");
    }
    if let Some((at, found)) = crowded_element(&xml) {
        let position = crate::reading::cursor::position(xml.as_bytes(), at);
        let error = ReadError::whole(file, found, "elements as VTK writes them");
        return Err(ReadError { position, ..error });
    }
    let document = Document::parse(&xml).map_err(|e| {
        let (message, place) = (e.to_string(), e.pos());
        // The crate's messages end with the position.
        let what = message
            .rsplit_once(" at ")
            .map_or(&*message, |(what, _)| what);
        let found = format!("malformed XML ({what})");
        ReadError::at_line(file, &xml, place.row, place.col, found, "well-formed XML")
    })?;
    let mut reader = XmlReader {
        document: &document,
        arrays: XmlArrays::new(&document, file, appended, options)?,
        skipped: 0,
        is_poly: false,
    };
    let pieces = reader.pieces()?;
    let message = "array of points or cells: skipped".to_owned();
    warnings.add_many(file, message, reader.skipped, || Position::Whole);
    Ok(pieces)
}

/// The file up to and with the tag of its appended data, and these, which need not be XML.
fn split(bytes: &[u8]) -> (&[u8], Option<AppendedBytes<'_>>) {
    const TAG: &[u8] = b"<AppendedData";
    let mut at = 0;
    while let Some(step) = bytes[at..].iter().position(|&b| b == b'<') {
        at += step;
        if bytes[at..].starts_with(TAG) {
            let end = bytes[at..].iter().position(|&b| b == b'>');
            let Some(end) = end.map(|end| at + end + 1) else {
                break;
            };
            let tag = &bytes[at..end];
            if tag.ends_with(b"/>") {
                break;
            }
            let rest = &bytes[end..];
            // The data begin behind an underscore.
            let start = rest.iter().position(|b| !b.is_ascii_whitespace());
            let start = start.filter(|&k| rest[k] == b'_').map_or(0, |k| k + 1);
            let is_raw = tag.windows(3).any(|w| w == b"raw");
            let appended = AppendedBytes {
                bytes: &rest[start..],
                is_raw,
            };
            return (&bytes[..end], Some(appended));
        }
        at += 1;
    }
    (bytes, None)
}

struct XmlReader<'a, 'x> {
    document: &'a Document<'x>,
    arrays: XmlArrays<'a>,
    skipped: usize,
    is_poly: bool,
}

impl<'a> XmlReader<'a, '_> {
    /// The pieces of the data set.
    fn pieces(&mut self) -> Result<Vec<VtkPiece>, ReadError> {
        const EXPECTED: &str = "UnstructuredGrid (.vtu) or PolyData (.vtp)";
        let root = self.document.root_element();
        if root.tag_name().name() != "VTKFile" {
            let found = format!("the element {}", shortened(root.tag_name().name()));
            return Err(self.arrays.error(root, found, "VTKFile"));
        }
        let kind = root.attribute("type").unwrap_or_default();
        self.is_poly = match kind {
            "UnstructuredGrid" => false,
            "PolyData" => true,
            _ => {
                let found = format!("a data set of the type \"{}\"", shortened(kind));
                let expected = match kind {
                    "PUnstructuredGrid"
                    | "PPolyData"
                    | "vtkMultiBlockDataSet"
                    | "Collection"
                    | "vtkPartitionedDataSetCollection"
                    | "vtkPartitionedDataSet" => {
                        format!("{EXPECTED}: this file only lists such files, give one of these")
                    }
                    _ => format!("{EXPECTED} (in ParaView: the filter Extract Surface)"),
                };
                return Err(self.arrays.error(root, found, expected));
            }
        };
        let Some(set) = children(root, kind).next() else {
            return Err(self
                .arrays
                .error(root, "no data set", format!("an element {kind}")));
        };
        let pieces: Vec<Node> = children(set, "Piece").collect();
        pieces.into_iter().map(|piece| self.piece(piece)).collect()
    }

    fn piece(&mut self, node: Node<'a, '_>) -> Result<VtkPiece, ReadError> {
        let mut piece = VtkPiece::default();
        self.points(node, &mut piece)?;
        if self.is_poly {
            // The order of the cells in their arrays.
            for (name, kind) in [("Verts", 2), ("Lines", 4), ("Polys", 7), ("Strips", 6)] {
                if let Some(list) = children(node, name).next() {
                    self.cells(list, Some(kind), &mut piece)?;
                }
            }
        } else if let Some(list) = children(node, "Cells").next() {
            self.cells(list, None, &mut piece)?;
        }
        for data in children(node, "CellData") {
            for array in arrays(data) {
                self.cell_array(array, &mut piece)?;
            }
        }
        self.skipped += children(node, "PointData").flat_map(arrays).count();
        Ok(piece)
    }

    fn points(&mut self, node: Node<'a, '_>, piece: &mut VtkPiece) -> Result<(), ReadError> {
        let stated = node
            .attribute("NumberOfPoints")
            .and_then(|n| n.parse().ok());
        let array = children(node, "Points").flat_map(arrays).next();
        let Some(array) = array else {
            return match stated {
                None | Some(0) => Ok(()),
                Some(_) => {
                    Err(self
                        .arrays
                        .error(node, "a piece without points", "an element Points"))
                }
            };
        };
        let coordinates = self.arrays.values(array)?.into_reals();
        let stated = stated.unwrap_or(coordinates.len() / 3);
        if stated.checked_mul(3) != Some(coordinates.len()) {
            let found = format!("{} coordinates", coordinates.len());
            let expected = format!("three for each of {stated} points");
            return Err(self.arrays.error(array, found, expected));
        }
        let kind = array.attribute("type").and_then(VtkType::of_xml);
        piece.is_single = kind == Some(VtkType::Real(4));
        piece.set_points(&coordinates);
        Ok(())
    }

    /// An array by its name; empty if there is none.
    fn integers(&mut self, list: Node<'a, '_>, name: &str) -> Result<Vec<i64>, ReadError> {
        let array = arrays(list).find(|a| a.attribute("Name") == Some(name));
        match array {
            Some(array) => Ok(self.arrays.values(array)?.into_integers()),
            None => Ok(Vec::new()),
        }
    }

    fn cells(
        &mut self,
        list: Node<'a, '_>,
        kind: Option<u8>,
        piece: &mut VtkPiece,
    ) -> Result<(), ReadError> {
        let points = self.integers(list, "connectivity")?;
        let offsets = self.integers(list, "offsets")?;
        let kinds = match kind {
            Some(_) => Vec::new(),
            None => self.integers(list, "types")?,
        };
        if kind.is_none() && kinds.len() != offsets.len() {
            let found = format!("{} types of cells", kinds.len());
            let expected = format!("{}, as there are offsets", offsets.len());
            return Err(self.arrays.error(list, found, expected));
        }
        let faces = if kinds.contains(&super::cells::POLYHEDRON) {
            self.polyhedra(list, &kinds)?
        } else {
            Vec::new()
        };
        let mut start = 0;
        for (k, &end) in offsets.iter().enumerate() {
            let range = usize::try_from(start).ok().zip(usize::try_from(end).ok());
            let cell = range.and_then(|(from, to)| points.get(from..to));
            let Some(cell) = cell else {
                let found = format!("a cell of the points {start} to {end}");
                let expected = format!("offsets up to {} in ascending order", points.len());
                return Err(self.arrays.error(list, found, expected));
            };
            start = end;
            let kind = kind.unwrap_or_else(|| u8::try_from(kinds[k]).unwrap_or(u8::MAX));
            let cell = faces.get(k).filter(|f| !f.is_empty()).map_or(cell, |f| f);
            piece.cell(kind, cell.iter().copied());
        }
        Ok(())
    }

    /// The faces of each cell that is a polyhedron, as a legacy file has them.
    fn polyhedra(&mut self, list: Node<'a, '_>, kinds: &[i64]) -> Result<Vec<Vec<i64>>, ReadError> {
        let (faces, ends) = (
            self.integers(list, "faces")?,
            self.integers(list, "faceoffsets")?,
        );
        if ends.is_empty() {
            return self.numbered_faces(list);
        }
        let mut start = 0;
        let mut cells = Vec::new();
        for &end in ends.iter().take(kinds.len()) {
            // Cells that are not polyhedra have −1.
            let Ok(end) = usize::try_from(end) else {
                cells.push(Vec::new());
                continue;
            };
            let Some(stream) = faces.get(start..end) else {
                let found = format!("faces {start} to {end} of a polyhedron");
                let expected = format!("offsets up to {} in ascending order", faces.len());
                return Err(self.arrays.error(list, found, expected));
            };
            cells.push(stream.to_vec());
            start = end;
        }
        Ok(cells)
    }

    /// The same of files since VTK 9.4, which number the faces of a piece.
    fn numbered_faces(&mut self, list: Node<'a, '_>) -> Result<Vec<Vec<i64>>, ReadError> {
        let points = self.integers(list, "face_connectivity")?;
        let ends = self.integers(list, "face_offsets")?;
        let numbers = self.integers(list, "polyhedron_to_faces")?;
        let cells = self.integers(list, "polyhedron_offsets")?;
        let part = |list: &[i64], ends: &[i64], k: usize| -> Option<Vec<i64>> {
            let from = if k == 0 { 0 } else { *ends.get(k - 1)? };
            let range = usize::try_from(from).ok()?..usize::try_from(*ends.get(k)?).ok()?;
            Some(list.get(range)?.to_vec())
        };
        // A face belongs to two cells at most; what is repeated more often must not fill memory.
        let mut left = 4 * (points.len() + numbers.len());
        let mut cell = |k: usize| -> Option<Vec<i64>> {
            let numbers = part(&numbers, &cells, k)?;
            let mut stream = Vec::new();
            if !numbers.is_empty() {
                stream.push(numbers.len() as i64);
            }
            for number in numbers {
                let face = part(&points, &ends, usize::try_from(number).ok()?)?;
                left = left.checked_sub(face.len() + 1)?;
                stream.push(face.len() as i64);
                stream.extend(face);
            }
            Some(stream)
        };
        let streams: Option<Vec<Vec<i64>>> = (0..cells.len()).map(&mut cell).collect();
        streams.ok_or_else(|| {
            let expected = "faces and points that exist";
            self.arrays
                .error(list, "a polyhedron whose faces do not exist", expected)
        })
    }

    fn cell_array(&mut self, array: Node<'a, '_>, piece: &mut VtkPiece) -> Result<(), ReadError> {
        let name = array.attribute("Name").unwrap_or_default();
        let components = array.attribute("NumberOfComponents").unwrap_or("1");
        let is_used = components == "1" && ArrayUse::of(name) != ArrayUse::Nothing;
        if !is_used {
            self.skipped += 1;
            return Ok(());
        }
        let values: VtkValues = self.arrays.values(array)?;
        piece.cell_array(name, values);
        Ok(())
    }
}

/// The children of an element with this name.
fn children<'a, 'x: 'a>(
    node: Node<'a, 'x>,
    name: &'a str,
) -> impl Iterator<Item = Node<'a, 'x>> + use<'a, 'x> {
    node.children().filter(move |c| c.has_tag_name(name))
}

/// The arrays of an element.
fn arrays<'a, 'x: 'a>(node: Node<'a, 'x>) -> impl Iterator<Item = Node<'a, 'x>> + use<'a, 'x> {
    node.children()
        .filter(|c| c.has_tag_name("DataArray") || c.has_tag_name("Array"))
}
