//! Recognizes the format of a file by its content rather than by its name.

mod json;
mod marks;
mod solvers;
#[cfg(test)]
mod tests;
mod words;

use super::gzip;
use super::text::decoded;
use flate2::read::MultiGzDecoder;
use marks::known_mark;
use std::borrow::Cow;
use std::fmt;
use std::io::Read;
use words::by_words;

/// The model formats that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// GRanada File, azulejo's own format.
    Grf,
    /// Wavefront OBJ.
    Obj,
    /// 3D Studio (3DS).
    Studio3ds,
    /// AutoCAD drawing exchange, ASCII or binary.
    Dxf,
    /// OpenFlight.
    OpenFlight,
    /// VRML 1.0, VRML97 and X3D, in XML or in the classic encoding.
    Vrml,
    /// Materials and Geometry Format.
    Mgf,
    /// glTF 2.0, JSON or binary (GLB).
    Gltf,
    /// Stanford polygon file.
    Ply,
    /// Stereolithography, ASCII or binary.
    Stl,
    /// Scenes of RTRACE.
    Sff,
    /// The scene language from which SFF was generated.
    Scn,
    /// Input of View3D.
    View3d,
    /// Meshes of gmsh, as text or binary.
    Gmsh,
    /// Object File Format of Geomview.
    Off,
    /// Meshes of VTK: legacy files, text or binary, and files in XML.
    Vtk,
    /// Bulk data of NASTRAN.
    Nastran,
    /// Input of Abaqus and CalculiX.
    Abaqus,
    /// A mesh of OpenFOAM.
    OpenFoam,
    /// CityJSON, and sequences of its features (CityJSONSeq).
    CityJson,
    /// Input of EnergyPlus: IDF, or the same as JSON (epJSON).
    EnergyPlus,
    /// Photometric files of luminaires: IES LM-63 and EULUMDAT.
    Photometry,
    /// 3D Manufacturing Format.
    ThreeMf,
}

/// The error for bytes in none of the supported formats.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unrecognized {
    /// A description of what they seem to be: "a PNG picture", "text in no known format".
    pub looks_like: &'static str,
}

impl fmt::Display for Unrecognized {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "found {}, expected {EXPECTED}", self.looks_like)
    }
}

impl std::error::Error for Unrecognized {}

/// What errors list as expected.
pub(crate) const EXPECTED: &str = "a model in 3DS, 3MF, Abaqus, CityJSON, DXF, EnergyPlus, EULUMDAT, glTF, gmsh, GRF, IES, MGF, NASTRAN, OBJ, OFF, OpenFlight, OpenFOAM, PLY, SCN, SFF, STL, View3D, VRML, VTK or X3D";

/// Recognizes the format of a model by its content or, if that is ambiguous, by its file name.
///
/// # Errors
/// As [`detect`].
pub fn recognize(bytes: &[u8], name: &str) -> Result<Format, Unrecognized> {
    by_extension(name, detect(bytes))
}

/// A format without magic bytes or keywords is recognized by the file name, unless the content
/// contradicts it.
fn by_extension(
    name: &str,
    detected: Result<Format, Unrecognized>,
) -> Result<Format, Unrecognized> {
    let lower = name.to_ascii_lowercase();
    let name = lower.strip_suffix(".gz").unwrap_or(&lower);
    match &detected {
        // Lines of prose pass for one or the other language of statements.
        Ok(Format::Grf | Format::Mgf | Format::Obj | Format::Scn) if is_document(name) => {
            Err(Unrecognized {
                looks_like: "a text document",
            })
        }
        // A list of no blocks; a file without a byte is rather one that could not be written.
        Err(e) if e.looks_like == WHITE_SPACE && name.ends_with(".grf") => Ok(Format::Grf),
        Err(e) if e.looks_like == PLAIN_TEXT && name.ends_with(".sff") => Ok(Format::Sff),
        Err(e) if e.looks_like == PLAIN_TEXT && name.ends_with(".scn") => Ok(Format::Scn),
        // Editions of 1986 begin with any text, and EULUMDAT with a name.
        Ok(Format::Grf | Format::Mgf | Format::Obj | Format::Scn) | Err(_)
            if is_photometric(name) && !matches!(&detected, Err(e) if e.looks_like == EMPTY) =>
        {
            Ok(Format::Photometry)
        }
        // A single letter begins a line in several formats.
        Err(e) if e.looks_like == PLAIN_TEXT && name.ends_with(".vs3") => Ok(Format::View3d),
        Err(e) if e.looks_like == PLAIN_TEXT && name.ends_with(".idf") => Ok(Format::EnergyPlus),
        Ok(Format::Grf | Format::Mgf | Format::Obj | Format::Scn) if name.ends_with(".vs3") => {
            Ok(Format::View3d)
        }
        // The word at the start is optional.
        Err(e) if e.looks_like == PLAIN_TEXT && name.ends_with(".off") => Ok(Format::Off),
        // Bulk data that only include others, and words of the executive control before bulk data. An
        // empty file beside a case is what programs open for it.
        Err(e) if e.looks_like == PLAIN_TEXT && is_bulk_data(name) => Ok(Format::Nastran),
        Ok(Format::Grf | Format::Mgf | Format::Obj | Format::Scn) if is_bulk_data(name) => {
            Ok(Format::Nastran)
        }
        Err(e) if matches!(e.looks_like, EMPTY | WHITE_SPACE) && is_case(name) => {
            Ok(Format::OpenFoam)
        }
        // Words that several languages share, and comments after a semicolon.
        Ok(Format::Grf | Format::Mgf | Format::Obj) if name.ends_with(".scn") => Ok(Format::Scn),
        _ => detected,
    }
}

/// Whether a name ends as those of photometric files do.
fn is_photometric(name: &str) -> bool {
    [".ies", ".ldt"].iter().any(|ending| name.ends_with(ending))
}

/// Whether a name ends as those of texts for people do, and of no model.
fn is_document(name: &str) -> bool {
    [".md", ".markdown", ".rst", ".adoc", ".tex"]
        .iter()
        .any(|ending| name.ends_with(ending))
}

/// Whether a name ends as those of bulk data do, and of nothing else.
fn is_bulk_data(name: &str) -> bool {
    [".bdf", ".nas", ".fem", ".blk"]
        .iter()
        .any(|end| name.ends_with(end))
}

/// Whether a name is that of the file which stands for a case of OpenFOAM.
fn is_case(name: &str) -> bool {
    name.ends_with(".foam") || name.ends_with(".openfoam")
}

/// Description of no bytes.
const EMPTY: &str = "an empty file";

/// Description of text without a keyword of any format.
const PLAIN_TEXT: &str = "text in no known format";

/// Description of text without a word.
const WHITE_SPACE: &str = "only white space";

/// Most bytes that are decompressed to get past a long comment.
const MOST_UNPACKED: u64 = 1 << 24;

/// Recognizes the format of a model, compressed with gzip or not.
///
/// # Errors
/// [`Unrecognized`], which names the actual format if it is well known.
pub fn detect(bytes: &[u8]) -> Result<Format, Unrecognized> {
    let start = unpacked_start(bytes);
    let format = match known_mark(&start) {
        Some(format) => format,
        // The whole file: a comment at its start may be of any length.
        None => by_words(&decoded(&start)),
    };
    format.map_err(|looks_like| Unrecognized { looks_like })
}

/// The bytes, or the first of their decompressed bytes.
fn unpacked_start(bytes: &[u8]) -> Cow<'_, [u8]> {
    if !gzip::is_gzip(bytes) {
        return Cow::Borrowed(bytes);
    }
    let mut start = Vec::new();
    // What could be decompressed before the damage is enough to recognize the format.
    let _ = MultiGzDecoder::new(bytes)
        .take(MOST_UNPACKED)
        .read_to_end(&mut start);
    Cow::Owned(start)
}

type Detection = Result<Format, &'static str>;
