//! Flat drawings: filled figures, to be extruded.

use crate::Warning;
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
