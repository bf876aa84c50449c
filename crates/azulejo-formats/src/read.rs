//! Models and drawings in whatever format they are: recognised once, then read by the format's
//! own reader.

use crate::outline::{Drawing, svg};
use crate::reading::detect::{EXPECTED, Format, detect, recognise};
use crate::reading::gzip;
use crate::reading::text::without_utf16;
use crate::{Files, ReadError, ReadOptions, Warning};
use crate::{dxf, gltf, grf, mgf, obj, openflight, ply, scn, sff, stl, studio3ds, view3d, vrml};
use azulejo_scene::Scene;

/// A model and the format that it was recognised as.
#[derive(Clone, Debug)]
pub struct RecognisedModel {
    /// Valid in the sense of [`Scene::validate`], in the axes and the unit of its file.
    pub scene: Scene,
    /// What was skipped, mended or guessed.
    pub warnings: Vec<Warning>,
    /// The format that the content is in.
    pub format: Format,
}

/// Reads a model in any of the formats, packed with gzip or not. `name` stands in messages;
/// `files` gives the files that the model names, relative to the model's folder.
///
/// # Errors
/// Bytes in none of the formats, and the errors of the format's own reader.
pub fn read(bytes: &[u8], name: &str, files: &dyn Files) -> Result<RecognisedModel, ReadError> {
    read_with(bytes, name, files, &ReadOptions::default())
}

/// [`read`] with other options than the default.
///
/// # Errors
/// As [`read`].
pub fn read_with(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<RecognisedModel, ReadError> {
    let bytes = &*gzip::unpacked(bytes, name, options)?;
    let format = recognise(bytes, name)
        .map_err(|unrecognised| ReadError::whole(name, unrecognised.looks_like, EXPECTED))?;
    let read = match format {
        Format::Grf => grf::read_with,
        Format::Obj => obj::read_with,
        Format::Studio3ds => studio3ds::read,
        Format::Dxf => dxf::read,
        Format::OpenFlight => openflight::read,
        Format::Vrml => vrml::read,
        Format::Mgf => mgf::read,
        Format::Gltf => gltf::read,
        Format::Ply => ply::read,
        Format::Stl => stl::read,
        Format::Sff => sff::read,
        Format::Scn => scn::read,
        Format::View3d => view3d::read,
    };
    let loaded = read(bytes, name, files, options)?;
    Ok(RecognisedModel {
        scene: loaded.scene,
        warnings: loaded.warnings,
        format,
    })
}

/// Reads an SVG or DXF drawing, recognised by its content. `name` stands in messages.
///
/// # Errors
/// Another format, and the errors of [`svg::read`] and [`dxf::read_figures`].
pub fn read_drawing(bytes: &[u8], name: &str, options: &ReadOptions) -> Result<Drawing, ReadError> {
    const EXPECTED: &str = "a drawing in SVG or DXF";
    let bytes = &*without_utf16(bytes);
    if svg::is_svg(bytes) {
        return svg::read(bytes, name, options);
    }
    match detect(bytes) {
        Ok(Format::Dxf) => dxf::read_figures(bytes, name, options),
        Ok(other) => {
            let found = format!("a model in {}", other.name());
            Err(ReadError::whole(name, found, EXPECTED))
        }
        Err(unrecognised) => Err(ReadError::whole(name, unrecognised.looks_like, EXPECTED)),
    }
}
