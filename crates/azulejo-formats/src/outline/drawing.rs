//! Two-dimensional drawings: filled figures, to be extruded.

use crate::Warning;
use azulejo_scene::{Figure, Rgb};

/// The filled figures of a drawing, in the order in which they are painted.
#[derive(Clone, Debug, Default)]
pub struct Drawing {
    /// The figures, in units of the drawing, y up.
    pub shapes: Vec<Filled>,
    /// Length of a unit in metres, if the drawing defines it.
    pub metres_per_unit: Option<f64>,
    /// What was left out, repaired or guessed.
    pub warnings: Vec<Warning>,
}

/// A figure and its paint.
#[derive(Clone, Debug, PartialEq)]
pub struct Filled {
    /// The figure whose inside is filled.
    pub figure: Figure,
    /// Its colour, linear; `None` if the drawing does not define a uniform one.
    pub color: Option<Rgb>,
    /// Its name in the drawing; may be empty.
    pub name: String,
}
