//! Stanford polygon files, `.ply`, as text or binary of either byte order; read and written.
//!
//! What is read: vertices with colours, normals, texture coordinates and azulejo's irradiance,
//! polygons with colours and texture coordinates, triangle strips. `docs/formats/ply.md` says
//! which properties.

mod assemble;
mod faces;
mod header;
mod source;
#[cfg(test)]
mod tests;
mod vertices;
mod write;

pub use write::{losses, write};

use crate::reading::options::check_length;
use crate::reading::text::decoded;
use crate::reading::warnings::Warnings;
use crate::{Files, Loaded, Position, ReadError, ReadOptions};
use faces::FaceList;
use header::{Element, Encoding, Header};
use source::{Binary, Source, Stop, Text};
use vertices::Vertices;

/// "No such vertex": a negative index, or one that is no integer. No real index reaches it,
/// because [`check_length`] bounds the file.
const NONE: u32 = u32::MAX;

/// Reads a model. `name` stands in messages; `files` gives the pictures that it names, relative
/// to its own folder.
///
/// # Errors
/// A malformed header, and text with a word that is no number. A file that ends before what its
/// header promises gives what is there, with warnings that count the rest.
pub fn read(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    _options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    check_length(bytes, name)?;
    let bytes = &*decoded(bytes);
    let mut warnings = Warnings::default();
    let header = Header::read(bytes, name, &mut warnings)?;
    let mut reader = Reader {
        file: name,
        vertices: None,
        faces: FaceList::default(),
        warnings,
    };
    match header.encoding {
        Encoding::Text => reader.elements(&header, Text::new(bytes, header.end, name))?,
        Encoding::LittleEndian => {
            reader.elements(&header, Binary::<false>::new(bytes, header.end))?;
        }
        Encoding::BigEndian => reader.elements(&header, Binary::<true>::new(bytes, header.end))?,
    }
    let (scene, warnings) = assemble::scene(reader, &header, files);
    Ok(Loaded {
        scene,
        warnings: warnings.finish(name),
    })
}

/// Reads the elements of a file, one after the other.
struct Reader<'a> {
    file: &'a str,
    vertices: Option<Vertices>,
    faces: FaceList,
    warnings: Warnings,
}

impl Reader<'_> {
    fn elements<S: Source>(&mut self, header: &Header, mut source: S) -> Result<(), ReadError> {
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
            let position = source.position();
            self.warnings
                .add_many(self.file, message, missing, || position);
        }
        source.finish(self.file, &mut self.warnings);
        Ok(())
    }

    fn skip<S: Source>(&mut self, element: &Element, source: &mut S) -> Result<u64, ReadError> {
        let message = format!("elements \"{}\": skipped", element.name);
        let count = usize::try_from(element.count).unwrap_or(usize::MAX);
        let declared = Position::Line(element.line, 1);
        self.warnings
            .add_many(self.file, message, count, || declared);
        rows(element, source, |source| {
            element.properties.iter().try_for_each(|p| p.skip(source))
        })
    }

    /// Says that a property is not used.
    fn unused(&mut self, element: &Element, property: &str) {
        let message = format!("property \"{property}\" of \"{}\": skipped", element.name);
        self.warnings
            .add(self.file, message, || Position::Line(element.line, 1));
    }
}

/// Reads the rows of an element and returns how many are missing from the file.
///
/// # Errors
/// A word that is no number.
fn rows<S: Source>(
    element: &Element,
    source: &mut S,
    mut row: impl FnMut(&mut S) -> Result<(), Stop>,
) -> Result<u64, ReadError> {
    if element.properties.is_empty() {
        // Rows of nothing take no bytes, however many there are.
        return Ok(0);
    }
    for done in 0..element.count {
        match source.begin_row().and_then(|()| row(source)) {
            Ok(()) => source.end_row(),
            Err(Stop::End) => {
                source.give_up();
                return Ok(element.count - done);
            }
            Err(Stop::Error(error)) => return Err(*error),
        }
    }
    Ok(0)
}
