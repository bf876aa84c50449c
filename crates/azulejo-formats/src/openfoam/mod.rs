//! Meshes of OpenFOAM, in the folder `polyMesh`.
//!
//! The patches of the boundary become objects that face the fluid; internal faces are not read.
//! `docs/formats/openfoam.md` has the details.

mod cursor;
mod lists;
mod patches;
#[cfg(test)]
mod tests;

use crate::reading::gzip;
use crate::reading::options::check_length;
use crate::reading::warnings::Warnings;
use crate::surface::named::NamedSurfaces;
use crate::surface::single;
use crate::{FileError, Files, Loaded, Position, ReadError, ReadOptions};

use azulejo_scene::math::area_vector;
use cursor::{FoamCursor, FoamHeader};
use glam::DVec3;
use patches::{FoamPatch, patches};
use std::borrow::Cow;

/// Reads a mesh, of which `bytes` are one file: `boundary`, `faces`, `points`, or another of the folder; or
/// the file without content that stands beside `constant` for the whole case. `files` provides the others.
///
/// # Errors
/// Files that are missing or are not what OpenFOAM writes, with line or byte.
pub fn read(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    let bytes = &*gzip::unpacked(bytes, name, options)?;
    let mesh = FoamMesh::around(bytes, name, files, options)?;
    let mut warnings = Warnings::default();
    let (points, is_single) = mesh.points()?;
    let surfaces = mesh.surfaces(&points, &mut warnings)?;
    let mut scene = surfaces.scene(&points, name, &mut warnings);
    scene.units.metres_per_unit = Some(1.0);
    if is_single {
        single::warn(&scene, &mesh.points.name, &mut warnings);
    }
    Ok(Loaded {
        scene,
        warnings: warnings.finish(name),
    })
}

/// A file of a mesh.
struct FoamFile<'a> {
    name: String,
    bytes: Cow<'a, [u8]>,
}

/// The three files that the surface of a mesh is in.
struct FoamMesh<'a> {
    boundary: FoamFile<'a>,
    faces: FoamFile<'a>,
    points: FoamFile<'a>,
}

/// Where the mesh of a case is.
const FOLDER: &str = "constant/polyMesh/";

impl<'a> FoamMesh<'a> {
    fn around(
        bytes: &'a [u8],
        name: &str,
        files: &dyn Files,
        options: &ReadOptions,
    ) -> Result<FoamMesh<'a>, ReadError> {
        let (folder, given) = if bytes.trim_ascii().is_empty() {
            (FOLDER, None)
        } else {
            ("", given(bytes, name)?)
        };
        let file = |part: &str| -> Result<FoamFile<'a>, ReadError> {
            let file = if given == Some(part) {
                FoamFile {
                    name: name.to_owned(),
                    bytes: Cow::Borrowed(bytes),
                }
            } else {
                sibling(&[folder, part].concat(), files, options)?
            };
            check_length(&file.bytes, &file.name)?;
            Ok(file)
        };
        Ok(FoamMesh {
            boundary: file("boundary")?,
            faces: file("faces")?,
            points: file("points")?,
        })
    }

    /// All points, and whether they are in single precision.
    fn points(&self) -> Result<(Vec<DVec3>, bool), ReadError> {
        let (mut cursor, header) = self.points.open()?;
        let is_single = header.is_binary && header.scalar == 4;
        Ok((lists::points(&mut cursor, &header)?, is_single))
    }

    /// The faces by patch.
    fn surfaces(
        &self,
        points: &[DVec3],
        warnings: &mut Warnings,
    ) -> Result<NamedSurfaces, ReadError> {
        let (boundary, _) = self.boundary.open()?;
        let patches = patches(&mut { boundary })?;
        let mut normals = vec![DVec3::ZERO; patches.len()];
        let mut surfaces = NamedSurfaces::default();
        let (mut cursor, header) = self.faces.open()?;
        let first = patches.first().map_or(u64::MAX, |p| p.first);
        let (mut current, mut number) = (0, None);
        let mut turned = Vec::new();
        let count = lists::faces(&mut cursor, &header, first, &mut |face, corners| {
            while patches.get(current).is_some_and(|p| face >= p.end()) {
                (current, number) = (current + 1, None);
            }
            let patch = patches.get(current);
            if patch.is_some_and(|p| p.first == face) {
                normals[current] = normal(points, corners);
            }
            if let Some(patch) = patch.filter(|p| face >= p.first && !p.is_skipped()) {
                let number = *number.get_or_insert_with(|| surfaces.number(&patch.name));
                // Faces look out of the fluid, and rows into it; the first corner stays.
                turned.clear();
                turned.extend_from_slice(corners);
                if let Some(others) = turned.get_mut(1..) {
                    others.reverse();
                }
                surfaces.push(number, &turned, points);
            }
        })?;
        self.warn(&boundary, &patches, &normals, warnings);
        match patches.iter().find(|p| p.count > 0 && p.end() > count) {
            None => Ok(surfaces),
            Some(patch) => {
                let found = format!("patch \"{}\" up to face {}", patch.name, patch.end());
                let expected = format!("at most the {count} faces of {}", self.faces.name);
                Err(boundary.error(patch.at, found, expected))
            }
        }
    }

    /// Counts the patches that are not walls, which have these normals.
    fn warn(
        &self,
        boundary: &FoamCursor,
        patches: &[FoamPatch],
        normals: &[DVec3],
        warnings: &mut Warnings,
    ) {
        for (patch, normal) in patches.iter().zip(normals) {
            let kind = &patch.kind;
            let axis = ["x", "y", "z"][normal.abs().max_position()];
            let what = match (&**kind, patch.is_skipped(), patch.is_repetition()) {
                ("empty", ..) => {
                    format!(
                        "skipped, so that light leaves; a flat case goes on with --periodic {axis}"
                    )
                }
                ("wedge", ..) => {
                    "skipped, so that light leaves; wedges are not revolved".to_owned()
                }
                (_, true, _) => "skipped".to_owned(),
                (_, _, true) => "read as a surface like any other".to_owned(),
                _ => continue,
            };
            let message = format!("patch of type {kind}: {what}");
            let place = || boundary.text.position(patch.at);
            warnings.add(&self.boundary.name, message, place);
        }
    }
}

impl FoamFile<'_> {
    /// A cursor behind the header.
    fn open(&self) -> Result<(FoamCursor<'_>, FoamHeader), ReadError> {
        let mut cursor = FoamCursor::new(&self.bytes, &self.name);
        let header = cursor.header()?;
        Ok((cursor, header))
    }
}

/// The normal of a face; zero if it has corners that do not exist.
fn normal(points: &[DVec3], corners: &[u32]) -> DVec3 {
    let corners = corners.iter().map(|&c| points.get(c as usize).copied());
    corners
        .collect::<Option<Vec<_>>>()
        .map_or(DVec3::ZERO, |c| area_vector(&c))
}

/// Which of the three files some bytes are; `None` for others of the same folder.
fn given(bytes: &[u8], name: &str) -> Result<Option<&'static str>, ReadError> {
    let mut cursor = FoamCursor::new(bytes, name);
    let class = cursor.header()?.class;
    match &*class {
        "polyBoundaryMesh" => Ok(Some("boundary")),
        "faceList" | "faceCompactList" => Ok(Some("faces")),
        "vectorField" => Ok(Some("points")),
        // Owners, neighbours and zones.
        "labelList" | "regIOobject" => Ok(None),
        other => {
            let found = format!("a file of OpenFOAM with the class \"{other}\"");
            let expected = "boundary, faces or points of a folder polyMesh";
            Err(ReadError::whole(name, found, expected))
        }
    }
}

/// Another file of the mesh, compressed or not.
fn sibling(
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<FoamFile<'static>, ReadError> {
    let packed = format!("{name}.gz");
    let (name, bytes) = match files.read(name) {
        Err(FileError::Missing) => (&*packed, files.read(&packed)),
        read => (name, read),
    };
    let bytes = bytes.map_err(|reason| ReadError {
        position: Position::Whole,
        ..ReadError::whole(
            name.trim_end_matches(".gz"),
            format!("no file ({reason})"),
            "boundary, faces and points of OpenFOAM in one folder",
        )
    })?;
    let unpacked = gzip::unpacked(&bytes, name, options)?.into_owned();
    Ok(FoamFile {
        name: name.to_owned(),
        bytes: Cow::Owned(unpacked),
    })
}
