//! Flat drawings: filled figures, to be extruded.

use crate::text::without_utf16;
use crate::{Format, ReadError, ReadOptions, Warning, detect, dxf, svg};
use azulejo_scene::{Figure, Rgb};

/// The filled figures of a drawing, in the order in which they are painted.
#[derive(Clone, Debug, Default)]
pub struct Drawing {
    /// The figures, in units of the drawing, y up.
    pub shapes: Vec<Filled>,
    /// Length of a unit in metres, if the drawing says it.
    pub metres_per_unit: Option<f64>,
    /// What was left out, mended or guessed.
    pub warnings: Vec<Warning>,
}

/// A figure and its paint.
#[derive(Clone, Debug, PartialEq)]
pub struct Filled {
    /// What is inside of it is filled.
    pub figure: Figure,
    /// Its colour, linear; `None` where the drawing does not say one that is the same everywhere.
    pub color: Option<Rgb>,
    /// What the drawing calls it; may be empty.
    pub name: String,
}

/// Reads an SVG or DXF drawing, whichever it is. `name` stands in messages.
///
/// # Errors
/// Another format, and what [`svg::read`] and [`dxf::read_figures`] say.
pub fn read(bytes: &[u8], name: &str, options: &ReadOptions) -> Result<Drawing, ReadError> {
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
        Err(e) => Err(ReadError::whole(name, e.looks_like, EXPECTED)),
    }
}
