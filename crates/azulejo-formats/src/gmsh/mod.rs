//! Meshes of gmsh, `.msh`, versions 2 and 4.1, as text or binary.
//!
//! Each physical surface becomes one object, or each surface of the geometry where there are none. Of a mesh
//! of volumes alone the boundary is read. `docs/formats/gmsh.md` has the details.

mod element_types;
mod mesh;
mod source;
#[cfg(test)]
mod tests;
mod version2;
mod version4;

use crate::reading::options::check_length;
use crate::reading::text::{decoded, quoted, shortened, text};
use crate::reading::warnings::Warnings;
use crate::surface::boundary::{CellKind, VolumeBoundary};
use crate::surface::named::NamedSurfaces;
use crate::{Files, Loaded, Position, ReadError, ReadOptions};
use azulejo_scene::Scene;
use mesh::MshMesh;
use source::{MshEncoding, MshSource};
use version4::MshEntities;

/// What is written for versions that are not read.
const VERSIONS: &str = "version 2.2 or 4.1, as which gmsh exports it (Mesh.MshFileVersion)";

/// Reads a model. `name` is used in messages; gmsh's files refer to no others and have no options.
///
/// # Errors
/// Another version, sections whose content does not match their counts, unknown types of elements, and
/// elements with nodes that do not exist.
pub fn read(
    bytes: &[u8],
    name: &str,
    _files: &dyn Files,
    _options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    check_length(bytes, name)?;
    let bytes = &*decoded(bytes);
    let mut reader = MshReader {
        file: name,
        source: MshSource::new(bytes, name),
        version: None,
        mesh: MshMesh::default(),
        entities: MshEntities::default(),
        repeated: 0,
        warnings: Warnings::default(),
    };
    reader.sections()?;
    let (scene, warnings) = reader.finish();
    Ok(Loaded {
        scene,
        warnings: warnings.finish(name),
    })
}

/// The layouts that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum MshVersion {
    Two,
    FourOne,
}

struct MshReader<'a> {
    file: &'a str,
    source: MshSource<'a>,
    version: Option<MshVersion>,
    mesh: MshMesh,
    entities: MshEntities,
    /// Elements that are written again for another physical group.
    repeated: usize,
    warnings: Warnings,
}

impl MshReader<'_> {
    fn sections(&mut self) -> Result<(), ReadError> {
        while let Some((at, word)) = self.source.word() {
            let Some(section) = word.strip_prefix(b"$") else {
                let expected = "a section, as $Nodes";
                return Err(self.source.error(at, quoted(word), expected));
            };
            let section = text(section).into_owned();
            self.source.rest_of_line();
            self.section(at, &section)?;
        }
        match self.version {
            Some(_) => Ok(()),
            None => Err(ReadError::whole(
                self.file,
                "no section $MeshFormat",
                VERSIONS,
            )),
        }
    }

    fn section(&mut self, at: usize, section: &str) -> Result<(), ReadError> {
        use MshVersion::{FourOne, Two};
        let (source, mesh) = (&mut self.source, &mut self.mesh);
        match (section, self.version) {
            ("MeshFormat", _) => self.format()?,
            ("NOD" | "ELM", _) => {
                return Err(source.error(at, "version 1 of the format", VERSIONS));
            }
            ("Nodes" | "Elements" | "Entities" | "PartitionedEntities", None) => {
                return Err(source.error(at, format!("${section}"), "$MeshFormat before it"));
            }
            ("PhysicalNames", _) => self.names()?,
            ("Entities", Some(FourOne)) => self.entities.read(source)?,
            ("PartitionedEntities", Some(FourOne)) => self.entities.read_partitioned(source)?,
            ("Nodes", Some(Two)) => version2::nodes(source, mesh, false)?,
            ("ParametricNodes", Some(Two)) => version2::nodes(source, mesh, true)?,
            ("Nodes", Some(FourOne)) => version4::nodes(source, mesh)?,
            ("Elements", Some(Two)) => self.repeated += version2::elements(source, mesh)?,
            ("Elements", Some(FourOne)) => {
                version4::elements(source, mesh, &mut self.entities)?;
            }
            _ => return self.skip(at, section),
        }
        self.source.end(section)
    }

    /// Passes a section that is not part of the surface, with a warning unless nothing is lost by it.
    fn skip(&mut self, at: usize, section: &str) -> Result<(), ReadError> {
        const HARMLESS: [&str; 5] = [
            "Comments",
            "Periodic",
            "GhostElements",
            "Parametrizations",
            "InterpolationScheme",
        ];
        if !HARMLESS.contains(&section) {
            let message = format!("section ${}: skipped", shortened(section));
            let source = self.source;
            self.warnings
                .add(self.file, message, || source.error(at, "", "").position);
        }
        self.source.skip(section)
    }

    /// The version, the encoding, and in binary files an integer that tells their byte order.
    fn format(&mut self) -> Result<(), ReadError> {
        let source = &mut self.source;
        // The version itself is text in any file.
        source.encoding = MshEncoding::Text;
        let Some((at, version)) = source.word() else {
            return Err(source.error(source.offset(), "the end of the file", VERSIONS));
        };
        let version = text(version);
        self.version = Some(match &*version {
            "2" | "2.0" | "2.1" | "2.2" => MshVersion::Two,
            "4.1" => MshVersion::FourOne,
            _ => {
                let found = format!("version {} of the format", shortened(&version));
                return Err(source.error(at, found, VERSIONS));
            }
        });
        let is_binary = source.int("0 for text or 1 for binary")? != 0;
        let at = source.next_offset();
        source.size_bytes = match source.int("4 or 8 bytes for each size")? {
            4 => 4,
            8 => 8,
            other => return Err(source.error(at, other.to_string(), "4 or 8 bytes for each size")),
        };
        if !is_binary {
            return Ok(());
        }
        source.rest_of_line();
        source.encoding = MshEncoding::Binary { is_big: false };
        let at = source.next_offset();
        match source.int("the integer 1")? {
            1 => {}
            0x0100_0000 => source.encoding = MshEncoding::Binary { is_big: true },
            other => return Err(source.error(at, other.to_string(), "the integer 1")),
        }
        Ok(())
    }

    /// The names of physical groups, which are lines of text in binary files, too.
    fn names(&mut self) -> Result<(), ReadError> {
        let source = &mut self.source;
        let encoding = std::mem::replace(&mut source.encoding, MshEncoding::Text);
        for _ in 0..source.count_line("a number of names")? {
            let first = source.int("the dimension of a physical group")?;
            let line = text(source.rest_of_line());
            let number = line.trim_start().split_once([' ', '\t']);
            let number =
                number.and_then(|(number, name)| Some((number.parse::<i64>().ok()?, name)));
            // Version 2.0 has no dimensions.
            let (dimensions, number, name) = match number {
                Some((number, name)) => (first..=first, number, name),
                None => (0..=3, first, &*line),
            };
            let name = name.trim().trim_matches('"').trim();
            for dimension in dimensions.filter_map(|d| u8::try_from(d).ok()) {
                if !name.is_empty() {
                    self.mesh.names.insert((dimension, number), name.to_owned());
                }
            }
        }
        source.encoding = encoding;
        Ok(())
    }

    /// The scene of what was read, and the warnings.
    fn finish(mut self) -> (Scene, Warnings) {
        let counts = [
            (
                "point or line element: skipped, as it has no area",
                self.mesh.lines,
            ),
            (
                "element of second or higher order: read as flat, between its corners",
                self.mesh.curved,
            ),
            (
                "surface in several physical groups: only the first one has it",
                self.entities.shared,
            ),
            (
                "element in several physical groups: only the first one has it",
                self.repeated,
            ),
            (
                "element between partitions of a volume: skipped",
                self.entities.between,
            ),
        ];
        for (message, count) in counts {
            self.warnings
                .add_many(self.file, message.to_owned(), count, || Position::Whole);
        }
        let mut surfaces = NamedSurfaces::default();
        if self.mesh.faces.is_empty() && !self.mesh.cells.is_empty() {
            self.boundary(&mut surfaces);
        } else {
            self.faces(&mut surfaces);
        }
        let scene = surfaces.scene(&self.mesh.positions, self.file, &mut self.warnings);
        (scene, self.warnings)
    }

    /// The elements that are surfaces.
    fn faces(&mut self, surfaces: &mut NamedSurfaces) {
        let mesh = &self.mesh;
        let message = "volume element: skipped, as the file has elements of surfaces".to_owned();
        self.warnings
            .add_many(self.file, message, mesh.cells.len(), || Position::Whole);
        let mut numbers: Vec<Option<usize>> = vec![None; mesh.groups.len()];
        for (corners, &group) in std::iter::zip(mesh.faces.iter(), &mesh.face_groups) {
            let name = || mesh.name(mesh.groups[group as usize]);
            let number = *numbers[group as usize].get_or_insert_with(|| surfaces.number(&name()));
            surfaces.push(number, corners, &mesh.positions);
        }
    }

    /// The boundary of the elements that are volumes.
    fn boundary(&mut self, surfaces: &mut NamedSurfaces) {
        let mesh = &self.mesh;
        let mut boundary = VolumeBoundary::new();
        let mut corners = mesh.cell_corners.as_slice();
        for &(kind, group) in &mesh.cells {
            let (cell, rest) = corners.split_at(CellKind::corner_count(kind));
            boundary.add_cell(kind, cell, group);
            corners = rest;
        }
        let name = |tag: u32| mesh.name(mesh.groups[tag as usize]);
        let (positions, warnings) = (&mesh.positions, &mut self.warnings);
        surfaces.push_boundary(&boundary, positions, name, self.file, warnings);
    }
}
