//! Pictures of the surroundings.

use crate::models::{ReadFailure, read_bytes};
use azulejo_formats::read_picture;
use azulejo_scene::{Image, Projection, Texture};
use std::fmt;
use std::path::Path;

/// A picture of the surroundings: radiance by direction.
#[derive(Clone, Debug, PartialEq)]
pub struct SurroundingPicture {
    /// The picture, loaded, with its path.
    pub texture: Texture,
    /// How directions map to its pixels.
    pub projection: Projection,
}

/// Why a file is not a picture of the surroundings.
#[derive(Debug)]
#[non_exhaustive]
pub enum PictureFailure {
    /// The file could not be read.
    File(ReadFailure),
    /// Its content is none: what was found and what was expected, after the path.
    Content(String),
}

impl fmt::Display for PictureFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PictureFailure::File(failure) => failure.fmt(f),
            PictureFailure::Content(message) => f.write_str(message),
        }
    }
}

impl std::error::Error for PictureFailure {}

impl From<ReadFailure> for PictureFailure {
    fn from(failure: ReadFailure) -> PictureFailure {
        PictureFailure::File(failure)
    }
}

impl SurroundingPicture {
    /// Reads an `.hdr` or `.exr` picture, twice as wide as high (equirectangular) or square
    /// (angular map); also returns warnings. Pixels that are not light become black.
    ///
    /// # Errors
    /// [`PictureFailure`].
    pub fn read(path: &Path) -> Result<(SurroundingPicture, Vec<String>), PictureFailure> {
        let bytes = read_bytes(path)?;
        let wrong = |fault: String| PictureFailure::Content(format!("{}: {fault}", path.display()));
        let is_hdr = bytes.starts_with(b"#?") || bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]);
        if !is_hdr {
            return Err(wrong(
                "holds no radiance, expected an .hdr or .exr picture".into(),
            ));
        }
        let mut image = read_picture(&bytes).map_err(|e| wrong(e.to_string()))?;
        let projection = projection_of(&image).map_err(wrong)?;
        let warnings = clean(&mut image).into_iter();
        let warnings = warnings.map(|what| format!("{}: {what}", path.display()));
        let picture = SurroundingPicture {
            texture: Texture {
                path: path.to_string_lossy().into_owned(),
                image: Some(image),
                ..Texture::default()
            },
            projection,
        };
        Ok((picture, warnings.collect()))
    }
}

fn projection_of(image: &Image) -> Result<Projection, String> {
    match (image.width, image.height) {
        (width, height) if width == height => Ok(Projection::AngularMap),
        (width, height) if width == 2 * height => Ok(Projection::Equirectangular),
        (width, height) => Err(format!(
            "{width} × {height} pixels, expected a picture twice as wide as high \
             (equirectangular) or a square (angular map)"
        )),
    }
}

/// Makes pixels that are not light black, and says how many.
fn clean(image: &mut Image) -> Vec<String> {
    let mut warnings = Vec::new();
    let mut wrong = 0;
    for pixel in &mut image.pixels {
        if !pixel.iter().all(|v| *v >= 0.0 && v.is_finite()) {
            wrong += 1;
            *pixel = pixel.map(|v| if v.is_finite() { v.max(0.0) } else { 0.0 });
        }
    }
    if wrong > 0 {
        warnings.push(format!(
            "{wrong} pixels are negative or not finite: taken as 0"
        ));
    }
    if image.pixels.iter().flatten().all(|&v| v == 0.0) {
        warnings.push("all pixels are black".into());
    }
    warnings
}
