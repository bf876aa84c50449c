//! Stanford polygon files, `.ply`, as text or binary with either byte order; read and written.
//!
//! Supported are vertices with colours, normals, texture coordinates and azulejo's irradiance,
//! polygons with colours and texture coordinates, and triangle strips. `docs/formats/ply.md` lists
//! the properties.

mod assemble;
mod faces;
mod header;
mod rows;
#[cfg(test)]
mod tests;
mod vertices;
mod write;

pub use write::{losses, write};

use crate::reading::options::check_length;
use crate::reading::text::decoded;
use crate::reading::warnings::Warnings;
use crate::surface::single;
use crate::{Files, Loaded, Position, ReadError, ReadOptions};
use faces::PlyFaceList;
use header::{PlyElement, PlyEncoding, PlyHeader};
use rows::{AsciiRows, BinaryRows, RowError, RowSource};
use vertices::PlyVertices;

/// An invalid vertex index: negative or not an integer. No valid index reaches it, because
/// [`check_length`] limits the file size.
const NONE: u32 = u32::MAX;

/// Reads a model. `name` is used in messages; `files` provides the textures that it refers to,
/// relative to its own folder.
///
/// # Errors
/// A malformed header, and text with a word that is not a number. A truncated file yields what it
/// contains, with warnings that count the rest.
pub fn read(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    check_length(bytes, name)?;
    let bytes = &*decoded(bytes);
    let mut warnings = Warnings::default();
    let header = PlyHeader::read(bytes, name, &mut warnings)?;
    let mut reader = PlyReader {
        file: name,
        vertices: None,
        faces: PlyFaceList::default(),
        warnings,
    };
    match header.encoding {
        PlyEncoding::Text => reader.elements(&header, AsciiRows::new(bytes, header.end, name))?,
        PlyEncoding::LittleEndian => {
            reader.elements(&header, BinaryRows::<false>::new(bytes, header.end))?;
        }
        PlyEncoding::BigEndian => {
            reader.elements(&header, BinaryRows::<true>::new(bytes, header.end))?
        }
    }
    let (scene, mut warnings) = assemble::scene(reader, &header, files, options);
    if header.has_single_positions() {
        single::warn(&scene, name, &mut warnings);
    }
    Ok(Loaded {
        scene,
        warnings: warnings.finish(name),
    })
}

/// Reads the elements of a file, one after the other.
struct PlyReader<'a> {
    file: &'a str,
    vertices: Option<PlyVertices>,
    faces: PlyFaceList,
    warnings: Warnings,
}

impl PlyReader<'_> {
    fn elements<S: RowSource>(
        &mut self,
        header: &PlyHeader,
        mut source: S,
    ) -> Result<(), ReadError> {
        for element in &header.elements {
            let missing = match element.name.as_str() {
                "vertex" if self.vertices.is_none() => {
                    let named = !header.objects.is_empty();
                    let (vertices, missing) = self.read_vertices(element, named, &mut source)?;
                    self.vertices = Some(vertices);
                    missing
                }
                "face" => self.read_faces(element, &mut source)?,
                "tristrips" => self.read_strips(element, &mut source)?,
                _ => self.skip(element, &mut source)?,
            };
            let name = &element.name;
            let message = format!("elements \"{name}\" missing from the end of the file");
            let missing = usize::try_from(missing).unwrap_or(usize::MAX);
            // The line is counted from the start: once for the warning, not for each element.
            self.warnings
                .add_many(self.file, message, missing, || source.position());
        }
        source.finish(self.file, &mut self.warnings);
        Ok(())
    }

    fn skip<S: RowSource>(
        &mut self,
        element: &PlyElement,
        source: &mut S,
    ) -> Result<u64, ReadError> {
        let message = format!("elements \"{}\": skipped", element.name);
        let count = usize::try_from(element.count).unwrap_or(usize::MAX);
        let declared = Position::Line(element.line, 1);
        self.warnings
            .add_many(self.file, message, count, || declared);
        rows(element, source, |source| {
            element.properties.iter().try_for_each(|p| p.skip(source))
        })
    }

    /// Warns about a property that is not used.
    fn unused(&mut self, element: &PlyElement, property: &str) {
        let message = format!("property \"{property}\" of \"{}\": skipped", element.name);
        self.warnings
            .add(self.file, message, || Position::Line(element.line, 1));
    }
}

/// Reads the rows of an element and returns how many are missing from the file.
///
/// # Errors
/// A word that is not a number.
fn rows<S: RowSource>(
    element: &PlyElement,
    source: &mut S,
    mut row: impl FnMut(&mut S) -> Result<(), RowError>,
) -> Result<u64, ReadError> {
    if element.properties.is_empty() {
        // Empty rows take no bytes, however many there are.
        return Ok(0);
    }
    for done in 0..element.count {
        match source.begin_row().and_then(|()| row(source)) {
            Ok(()) => source.end_row(),
            Err(RowError::End) => {
                source.skip_incomplete_row();
                return Ok(element.count - done);
            }
            Err(RowError::Error(error)) => return Err(*error),
        }
    }
    Ok(0)
}
